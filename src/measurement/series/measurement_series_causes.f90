! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes what a record of a vibrating wing can get wrong: a motion of its base that no file states. After the excitation the
!> clamp has the acceleration s sin(w t) + c cos(w t) along z, w 2 pi times a frequency that is tried. Values stay those against the
!> clamp.
module measurement_series_causes
  use base_cause, only: cause_t, enlist, make_cause
  use base_kinds, only: rp
  use base_parameter, only: define_effect, define_parameter, parameter_t
  use base_wording, only: word_by_name
  use solid_ringing, only: SHAKE_COSINE, SHAKE_RATE, SHAKE_SINE
  implicit none
  private
  public :: list_series_causes

  character(*), parameter :: OF_MOTION = 'the acceleration of a sine of the largest value'

contains

  !> Returns the causes. A motion of the base as large as the largest value of the record has this `acceleration` [m/s^2]; `spread`
  !> is the logarithm of the ratio of two neighbouring frequencies that are tried.
  pure function list_series_causes(acceleration, spread) result(list)
    real(rp), intent(in) :: acceleration, spread
    type(cause_t), allocatable :: list(:)
    call enlist(list, shake_of_base(acceleration, spread))
  end function list_series_causes

  pure function shake_of_base(acceleration, spread) result(cause)
    real(rp), intent(in) :: acceleration, spread
    type(cause_t) :: cause
    type(parameter_t) :: p
    integer :: k
    cause = make_cause('base_shake', 'a motion of the base that was not recorded', &
                       'The clamp moves after the excitation, and the wing with it.', 'records of a release or a tap')
    cause%is_measurement = .true.
    call define_effect(p, 'base_sine', 'm/s^2', .false., -10*acceleration, 10*acceleration, 0.1_rp*acceleration)
    call cause%add(SHAKE_SINE, p, OF_MOTION)
    call define_effect(p, 'base_cosine', 'm/s^2', .false., -10*acceleration, 10*acceleration, 0.1_rp*acceleration)
    call cause%add(SHAKE_COSINE, p, OF_MOTION)
    call define_parameter(p, 'base_frequency_factor', '1', .true., 0.5_rp, 2.0_rp)
    p%prior_sd = spread
    p%null = 1
    call cause%add(SHAKE_RATE, p, '', 'the logarithm of the ratio of two neighbouring frequencies')
    do k = 1, 3
      call word_by_name(cause%parameters(k)%words, cause%parameters(k)%value%name)
    end do
  end function shake_of_base
end module measurement_series_causes
