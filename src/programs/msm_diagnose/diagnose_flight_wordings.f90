! SPDX-License-Identifier: GPL-3.0-or-later
!> Provides the words for the parameters that records of forces over the beat show: kinematics, flow and force balance.
module diagnose_flight_wordings
  use base_kinds, only: rp
  use solid_wording, only: factor => word_factor, plain => word_plain, wording_t, SCALE_FACTOR, SCALE_LINEAR
  implicit none
  private
  public :: word_flight

  character(*), parameter :: STATED = 'than the kinematics say', AS_STATED = 'what the kinematics say', FEWER = 'less'

contains

  !> Fills w with the words of parameter `name` [unit]. Leaves w as it is for other parameters.
  subroutine word_flight(w, name, unit)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name, unit
    call word_kinematics(w, name)
    if (.not. allocated(w%up)) call word_flow(w, name)
    if (.not. allocated(w%up)) call word_balance(w, name, unit)
  end subroutine word_flight

  !> Gives the words for a change of the kinematics.
  subroutine word_kinematics(w, name)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name
    select case (name)
    case ('stroke_amplitude')
      call amplitude(w, 'The stroke was')
    case ('pitch_amplitude')
      call amplitude(w, 'The pitch was')
    case ('deviation_amplitude')
      call amplitude(w, 'The deviation was')
    case ('stroke_mean')
      call angle(w, 'The middle of the stroke was displaced in phi by')
    case ('pitch_mean')
      call angle(w, 'The mean pitch was displaced by')
    case ('stroke_plane')
      call angle(w, 'The stroke plane was tilted in eta by')
    case ('pitch_lead')
      call plain(w, 'beats', 'The pitch was early by', 'The pitch was late by', '', '', '', 0.0_rp)
    case ('beat_frequency')
      call factor(w, SCALE_FACTOR, 'The wing beat faster:', 'The wing beat slower:', 'more beats in a second', &
                  'fewer beats in a second', 'than stated', 'as many beats as stated', 1.0_rp)
    end select
  end subroutine word_kinematics

  !> Gives the words for a factor on an amplitude.
  subroutine amplitude(w, lead)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: lead
    call factor(w, SCALE_LINEAR, lead, lead, 'larger', 'smaller', STATED, AS_STATED, 0.0_rp)
  end subroutine amplitude

  !> Gives the words for an angle that is added.
  subroutine angle(w, lead)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: lead
    call plain(w, 'degrees', lead//' plus', lead//' minus', '', '', '', 0.0_rp)
  end subroutine angle

  !> Gives the words for wind and viscosity.
  subroutine word_flow(w, name)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name
    if (index(name, 'wind:') == 1) then
      call plain(w, 'm/s', 'There was wind:', 'There was wind:', 'along +'//name(6:), 'along -'//name(6:), '', 0.0_rp)
    else if (name == 'viscosity') then
      call factor(w, SCALE_FACTOR, 'The fluid was', 'The fluid was', 'more viscous', 'less viscous', 'than stated', &
                  'as viscous as stated', 1.0_rp)
    end if
  end subroutine word_flow

  !> Gives the words for an error of the force balance.
  subroutine word_balance(w, name, unit)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name, unit
    character(:), allocatable :: what, lead
    what = name(index(name, ':') + 1:)
    select case (name(:index(name//':', ':') - 1))
    case ('balance_gain')
      call factor(w, SCALE_FACTOR, 'The balance shows all forces', 'The balance shows all forces', 'larger', 'smaller', &
                  'than they are', 'as large as they are', 1.0_rp)
    case ('balance_offset')
      lead = 'The balance shows '//what//' where there is none:'
      call plain(w, unit, lead, lead, 'too much', 'too little', '', 0.0_rp)
    case ('balance_turn')
      lead = 'The balance is turned about '//what//':'
      call plain(w, 'degrees', lead, lead, 'right-handed', 'left-handed', '', 0.0_rp)
    case ('cross_talk')
      lead = 'The balance shows a share of '//what(:index(what, '-') - 1)//' in '//what(index(what, '-') + 1:)//':'
      call plain(w, '', lead, lead, 'of it', 'of it, reversed', '', 0.0_rp)
    case ('balance_lowpass')
      call plain(w, 'ms', 'The balance is slow: it has a time constant of', 'The balance is fast:', '', FEWER, '', 0.0_rp)
      w%factor = 1.0e3_rp
    case ('balance_delay')
      call plain(w, 'ms', 'Forces come late against the motion by', 'Forces come early against the motion by', '', '', '', 0.0_rp)
      w%factor = 1.0e3_rp
    case ('inertia_mass')
      lead = 'The inertia of the wing is in the forces: that of'
      call plain(w, unit, lead, 'Too much inertia of the wing was subtracted: that of', '', '', '', 0.0_rp)
    end select
  end subroutine word_balance
end module diagnose_flight_wordings
