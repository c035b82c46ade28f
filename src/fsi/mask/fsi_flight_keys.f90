! SPDX-License-Identifier: GPL-3.0-or-later
!> Declares the keys of insects: [Insects], and those of [Flexible_wing] that concern the mask, one group after the other. The keys
!> in this module define the wings that exist, and their inertia.
module fsi_flight_keys
  use base_kinds, only: rp
  use fsi_body_keys, only: body_choices_t, body_keys
  use fsi_body_motion_keys, only: body_motion_choices_t
  use fsi_flyer_keys, only: flyer_choices_t, flyer_keys
  use fsi_kinematics_keys, only: kinematics_choices_t, kinematics_keys
  use fsi_mask_keys, only: mask_choices_t, mask_keys
  use fsi_thin_keys, only: thin_keys, thin_params_t
  use fsi_wing_source, only: source_choices_t, source_keys
  use fsi_wings_key, only: wings_key
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  implicit none
  private
  public :: flight_choices_t, flight_choices, register_flight_keys

  character(*), parameter :: SECTION = 'Insects'

  type :: flight_choices_t
    logical :: has_wing(2) = .true.        !< left, right
    real(rp) :: inertia(4) = 0             !< Jxx, Jyy, Jzz, Jxy
    logical :: has_inertia(4) = .false.
    real(rp) :: pitch = 0, stroke = 0      !< of some words of BodyMotion, degrees
  end type flight_choices_t

contains

  !> Adds every key of [Insects] and of the wings' mask to `registry`.
  subroutine register_flight_keys(registry)
    type(registry_t), intent(inout), target :: registry
    type(keys_t) :: keys
    type(flight_choices_t) :: flight
    type(source_choices_t) :: source
    type(body_motion_choices_t) :: motion
    type(kinematics_choices_t) :: kinematics
    type(flyer_choices_t) :: flyer
    type(body_choices_t) :: body
    type(mask_choices_t) :: mask
    type(thin_params_t) :: thin
    integer :: wings
    wings = 0
    keys = declaring(registry)
    call side_keys(keys, flight)
    call source_keys(keys, source)
    call inertia_keys(keys, flight)
    call kinematics_keys(keys, motion, kinematics)
    call flyer_keys(keys, flyer)
    call body_keys(keys, body)
    call other_flusi_keys(keys, flight)
    call mask_keys(keys, mask)
    call thin_keys(keys, thin)
    call wings_key(keys, wings)
  end subroutine register_flight_keys

  !> Visits the keys that say which wings there are.
  subroutine side_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(flight_choices_t), intent(inout) :: c
    call keys%section(SECTION, 'flapping wings (iMask = Insect); docs/guide/kinematics.md draws the frames')
    call keys%switch('LeftWing', c%has_wing(1), .true., 'there is a left wing')
    call keys%in_checkpoint()
    call keys%switch('RightWing', c%has_wing(2), .true., 'there is a right wing')
    call keys%in_checkpoint()
  end subroutine side_keys

  !> Visits the keys of the moments of inertia of a wing.
  subroutine inertia_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(flight_choices_t), intent(inout) :: c
    character(3), parameter :: INERTIA(4) = ['Jxx', 'Jyy', 'Jzz', 'Jxy']
    integer :: i
    call keys%section(SECTION)
    do i = 1, 4
      call keys%real(INERTIA(i), c%inertia(i), 0.0_rp, 'inertia of a wing about its hinge, in FLUSI''s wing frame (y to the '// &
                     'tip, x to the leading edge)', unit='M L^2', given=c%has_inertia(i))
    end do
  end subroutine inertia_keys

  !> Returns what the user chose in these keys.
  function flight_choices(config) result(c)
    type(config_t), intent(in), target :: config
    type(flight_choices_t) :: c
    type(keys_t) :: keys
    keys = reading(config)
    call side_keys(keys, c)
    call inertia_keys(keys, c)
    call other_flusi_keys(keys, c)
  end function flight_choices

  !> Declares keys of FLUSI that are refused, that have no effect, or that only some words of BodyMotion need.
  subroutine other_flusi_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(flight_choices_t), intent(inout) :: c
    character(*), parameter :: SECOND_PAIR = 'a second pair of wings', ONE_PAIR = 'LeftWing and RightWing alone, or, where '// &
                               'fore and hind wing beat as one, the outline of both in WingShape = from_file::NAME.ini'
    logical :: unbuilt
    call keys%section(SECTION)
    call keys%switch('LeftWing2', unbuilt, .false., 'hind wing', unbuilt=SECOND_PAIR, instead=ONE_PAIR)
    call keys%switch('RightWing2', unbuilt, .false., 'hind wing', unbuilt=SECOND_PAIR, instead=ONE_PAIR)
    call keys%switch('wing_fsi', unbuilt, .false., 'passive wing', unbuilt='a wing that the flow turns about its root', &
                     instead='wings = flexible, whose root is as soft as the joints of the wing file make it')
    call keys%real('body_pitch_const', c%pitch, 0.0_rp, 'BodyMotion = forward or hovering: pitch angle, positive nose up', &
                   unit='degree')
    call keys%real('eta_stroke', c%stroke, 0.0_rp, 'BodyMotion = forward: angle of the stroke plane', unit='degree')
    call keys%inert('mass_solid', 'free flight')
    call keys%inert('gravity_*', 'other names of gravity')
    call keys%inert('pointcloudfile', 'wing given by a cloud of points')
    call keys%inert('infile2', 'second pair of wings')
    call keys%inert('distance_from_sponge', 'sponge that moves with the body')
    call keys%inert('WingShape2', 'second pair of wings')
    call keys%inert('x_pivot_l2', 'second pair of wings')
    call keys%inert('x_pivot_r2', 'second pair of wings')
    call keys%inert('FlappingMotion_left2', 'second pair of wings')
    call keys%inert('FlappingMotion_right2', 'second pair of wings')
  end subroutine other_flusi_keys
end module fsi_flight_keys
