! SPDX-License-Identifier: GPL-3.0-or-later
!> The keys of a free flight, FLUSI's: mass, gravity, J_body_yawpitchroll, DoF, startup_conditioner; and the mass of a wing.
module fsi_flyer_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_flyer, only: flyer_params_t
  use io_config, only: config_t
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_flyer_keys, read_flyer, read_wing_mass

  character(*), parameter :: SECTION = 'Insects'

contains

  !> Adds them to `registry`.
  subroutine register_flyer_keys(registry)
    type(registry_t), intent(inout) :: registry
    real(rp), parameter :: ZERO(3) = 0.0_rp
    call registry%add_real(SECTION, 'mass', 0.0_rp, 'free flight: mass of the insect with its wings', unit='M', &
                           min=0.0_rp)
    call registry%add_real(SECTION, 'gravity', 0.0_rp, 'free flight: acceleration of gravity along z, negative: down; '// &
                           'buoyancy is not part of it', unit='L/T^2')
    call registry%add_reals(SECTION, 'J_body_yawpitchroll', ZERO, 'free flight: inertia of the body without wings '// &
                            'about its axes z, y and x', unit='M L^2', length=3, min=0.0_rp)
    call registry%add_word(SECTION, 'DoF', '111111', '*', 'free flight: which of x, y, z, yaw, pitch, roll are free '// &
                           '(1) or keep their velocity (0)')
    call registry%add_switch(SECTION, 'startup_conditioner', .false., 'free flight: the forces of the flow on the '// &
                             'insect begin at t = 0.1 and are whole at t = 0.6, its weight at once')
    call registry%add_real(SECTION, 'release_time', 0.0_rp, 'free flight: the insect keeps its first velocity until '// &
                           'then', unit='T', min=0.0_rp)
    call registry%add_real(SECTION, 'wing_mass', 0.0_rp, 'free flight: mass of one rigid wing, spread evenly over its '// &
                           'surface; not given: that of a wing with this Jxx, or that of [Wing]', unit='M', min=0.0_rp)
  end subroutine register_flyer_keys

  !> Reads what a free flight needs; mistakes go to `errors`. Nothing of it is read of a body that is not free.
  subroutine read_flyer(config, params, errors, notices)
    type(config_t), intent(in) :: config
    type(flyer_params_t), intent(out) :: params
    type(message_list_t), intent(inout) :: errors, notices
    character(*), parameter :: AXES(6) = [character(5) :: 'x', 'y', 'z', 'yaw', 'pitch', 'roll']
    character(:), allocatable :: dof
    real(rp) :: inertia(3)
    integer, parameter :: PLACE(6) = [1, 2, 3, 6, 5, 4]
    integer :: i
    params%is_free = config%get_word(SECTION, 'BodyMotion') == 'free_flight'
    if (.not. params%is_free) return
    params%mass = config%get_real(SECTION, 'mass')
    params%gravity = config%get_real(SECTION, 'gravity')
    inertia = config%get_reals(SECTION, 'J_body_yawpitchroll')
    params%inertia = inertia([3, 2, 1])
    params%conditioner = config%get_switch(SECTION, 'startup_conditioner')
    params%release = config%get_real(SECTION, 'release_time')
    dof = config%get_word(SECTION, 'DoF')
    if (len(dof) /= 6 .or. verify(dof, '01') > 0) then
      call config%complain(errors, SECTION, 'DoF', '"'//dof//'" are not six digits 0 or 1; valid: 111111, all are free')
      return
    end if
    do i = 1, 6
      params%held(PLACE(i)) = dof(i:i) == '0'
    end do
    if (.not. config%is_given(SECTION, 'gravity')) call config%complain(errors, SECTION, 'gravity', &
      'is missing: BodyMotion = free_flight needs it; 0 is none, a negative one points down')
    if (params%gravity > 0) call config%complain(notices, SECTION, 'gravity', &
      'is positive: the insect falls upwards, as in FLUSI')
    if (params%mass <= 0) call config%complain(errors, SECTION, 'mass', &
      'is missing: BodyMotion = free_flight needs the mass of the insect')
    do i = 4, 6
      if (params%held(PLACE(i)) .or. inertia(i - 3) > 0) cycle
      call config%complain(errors, SECTION, 'J_body_yawpitchroll', 'is 0 about the axis of '//trim(AXES(i))// &
                           ', which is free; hold it by DoF, or give the inertia of the body')
    end do
    ! Three positive numbers are an inertia only if none is larger than the others together.
    if (all(inertia > 0) .and. 2*maxval(inertia) > sum(inertia)*(1 + 1.0e-9_rp)) &
      call config%complain(errors, SECTION, 'J_body_yawpitchroll', 'is that of no body: '// &
                           number_text(maxval(inertia))//' is more than the sum of the other two')
  end subroutine read_flyer

  !> Mass of a wing of this area moment of the span int y^2 dA, and area: that of the key, or that of Jxx.
  real(rp) function read_wing_mass(config, area, area_moment) result(mass)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: area, area_moment
    if (config%is_given(SECTION, 'wing_mass')) then
      mass = config%get_real(SECTION, 'wing_mass')
    else
      mass = 0
      if (area_moment > 0) mass = config%get_real(SECTION, 'Jxx')*area/area_moment
    end if
  end function read_wing_mass
end module fsi_flyer_keys
