! SPDX-License-Identifier: GPL-3.0-or-later
!> Declares the keys of a free flight, with FLUSI's names: mass, gravity, J_body_yawpitchroll, DoF, startup_conditioner; and the
!> mass of a wing.
module fsi_flyer_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_body_motion, only: MOTION_FREE
  use fsi_body_motion_keys, only: body_motion_choices, body_motion_choices_t
  use fsi_flyer, only: flyer_params_t
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  implicit none
  private
  public :: flyer_choices_t, flyer_choices, flyer_keys, read_flyer

  character(*), parameter :: SECTION = 'Insects'

  type :: flyer_choices_t
    type(flyer_params_t) :: params
    logical :: has_gravity = .false.
    real(rp) :: inertia(3) = 0          !< about z, y and x
    character(:), allocatable :: dof    !< x, y, z, yaw, pitch, roll: 1 is free
    real(rp) :: wing_mass = 0
    logical :: has_wing_mass = .false.
  contains
    procedure :: mass_of_wing => choices_mass_of_wing
  end type flyer_choices_t

contains

  !> Declares and reads the keys of a free flight.
  subroutine flyer_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(flyer_choices_t), intent(inout) :: c
    real(rp), parameter :: ZERO(3) = 0.0_rp
    call keys%section(SECTION)
    call keys%real('mass', c%params%mass, 0.0_rp, 'free flight: mass of the insect with its wings', unit='M', min=0.0_rp)
    call keys%real('gravity', c%params%gravity, 0.0_rp, 'free flight: acceleration of gravity along z, negative: down; '// &
                   'buoyancy is not part of it', unit='L/T^2', given=c%has_gravity)
    call keys%reals('J_body_yawpitchroll', c%inertia, ZERO, 'free flight: inertia of the body without wings about its axes z, '// &
                    'y and x', unit='M L^2', min=0.0_rp)
    call keys%word('DoF', c%dof, '111111', '*', 'free flight: which of x, y, z, yaw, pitch, roll are free (1) or keep their '// &
                   'velocity (0)')
    call keys%switch('startup_conditioner', c%params%conditioner, .false., 'free flight: the forces of the flow on the insect '// &
                     'grow from 0 at t = 0.1 to their full values at t = 0.6; its weight acts from the beginning')
    call keys%real('release_time', c%params%release, 0.0_rp, 'free flight: the insect keeps its initial velocity until this time', &
                   unit='T', min=0.0_rp)
    call keys%real('wing_mass', c%wing_mass, 0.0_rp, 'free flight: mass of one rigid wing, spread evenly over its surface; if '// &
                   'it is not given, it follows from Jxx, or is the mass of [Wing]', unit='M', min=0.0_rp, given=c%has_wing_mass)
  end subroutine flyer_keys

  !> Returns what the user chose.
  function flyer_choices(config) result(c)
    type(config_t), intent(in), target :: config
    type(flyer_choices_t) :: c
    type(keys_t) :: keys
    keys = reading(config)
    call flyer_keys(keys, c)
  end function flyer_choices

  !> Reads what a free flight needs. Mistakes go to `errors`. Reads nothing for a body that does not fly freely.
  subroutine read_flyer(config, params, errors, notices)
    type(config_t), intent(in) :: config
    type(flyer_params_t), intent(out) :: params
    type(message_list_t), intent(inout) :: errors, notices
    character(*), parameter :: AXES(6) = [character(5) :: 'x', 'y', 'z', 'yaw', 'pitch', 'roll']
    type(flyer_choices_t) :: c
    type(body_motion_choices_t) :: motion
    integer, parameter :: PLACE(6) = [1, 2, 3, 6, 5, 4]
    integer :: i
    motion = body_motion_choices(config)
    if (motion%kind /= MOTION_FREE) return
    c = flyer_choices(config)
    params = c%params
    params%is_free = .true.
    params%inertia = c%inertia([3, 2, 1])
    associate (dof => c%dof)
      if (len(dof) /= 6 .or. verify(dof, '01') > 0) then
        call config%complain(errors, SECTION, 'DoF', '"'//dof//'" are not six digits 0 or 1; valid: 111111, all are free')
        return
      end if
    end associate
    do i = 1, 6
      params%held(PLACE(i)) = c%dof(i:i) == '0'
    end do
    if (.not. c%has_gravity) call config%complain(errors, SECTION, 'gravity', &
      'is missing: BodyMotion = free_flight needs it; 0: no gravity, negative values: downward')
    if (params%gravity > 0) call config%complain(notices, SECTION, 'gravity', &
      'is positive: gravity points upward, as in FLUSI; a negative value points downward')
    if (params%mass <= 0) call config%complain(errors, SECTION, 'mass', &
      'is missing: BodyMotion = free_flight needs the mass of the insect')
    do i = 4, 6
      if (params%held(PLACE(i)) .or. c%inertia(i - 3) > 0) cycle
      call config%complain(errors, SECTION, 'J_body_yawpitchroll', 'is 0 about the axis of '//trim(AXES(i))// &
                           ', about which the body may turn; hold this rotation by DoF, or give the inertia of the body')
    end do
    ! Three positive values are moments of inertia only if none is larger than the sum of the other two.
    if (all(c%inertia > 0) .and. 2*maxval(c%inertia) > sum(c%inertia)*(1 + 1.0e-9_rp)) &
      call config%complain(errors, SECTION, 'J_body_yawpitchroll', 'fits no rigid body: '// &
                           number_text(maxval(c%inertia))//' is more than the sum of the other two')
  end subroutine read_flyer

  !> Returns the mass of a wing with this area and this moment of the area about the x axis, int y^2 dA: the mass of its key, or
  !> the mass that follows from Jxx.
  pure real(rp) function choices_mass_of_wing(self, jxx, area, area_moment) result(mass)
    class(flyer_choices_t), intent(in) :: self
    real(rp), intent(in) :: jxx, area, area_moment
    mass = 0
    if (self%has_wing_mass) then
      mass = self%wing_mass
    else if (area_moment > 0) then
      mass = jxx*area/area_moment
    end if
  end function choices_mass_of_wing
end module fsi_flyer_keys
