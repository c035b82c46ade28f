! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks the input of a free flight, computes the masses of the insect, and writes its lines of the summary.
module simulation_free_flight
  use base_constants, only: PI
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fluid_params, only: fluid_params_t, SCHEME_AB2
  use fluid_shapes, only: NO_SHAPE
  use fsi_coupler_params, only: coupler_params_t, COUPLING_STRONG
  use fsi_flight_params, only: flight_params_t
  use fsi_moments, only: moments_of_points, moments_t
  use io_config, only: config_t
  use io_series_read, only: read_series
  use io_units, only: unit_scales_t
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: check_free_flight, take_masses, free_flight_text

  character(*), parameter :: SECTION = 'Insects'
  real(rp), parameter :: WEIGHTS(2) = [0.05_rp, 20.0_rp] !< range of the weight over the lift that such wings usually have

contains

  !> Checks the input of a free flight: adds mistakes to `errors` and doubts to `notices`. Sets the gravity on flexible wings to
  !> that on the body. It does nothing if the flight is not free.
  subroutine check_free_flight(config, units, flexible, fluid, flight, coupler, errors, notices)
    type(config_t), intent(in) :: config
    type(unit_scales_t), intent(in) :: units
    logical, intent(in) :: flexible
    type(fluid_params_t), intent(in) :: fluid
    type(flight_params_t), intent(inout) :: flight
    type(coupler_params_t), intent(inout) :: coupler
    type(message_list_t), intent(inout) :: errors, notices
    real(rp) :: wings
    if (.not. flight%flyer%is_free) return
    if (fluid%solids%has_corrections) then
      flight%flyer%carries_fluid = .not. fluid%solids%unsteady_corrections
      if (flight%flyer%carries_fluid) call config%complain(notices, 'Penalization', 'unst_corrections', &
        'is no: as in FLUSI, the mass of the fluid inside the mask adds to that of the insect')
    end if
    if (fluid%time%scheme /= SCHEME_AB2) call config%complain(errors, 'Time', 'iTimeMethodFluid', &
      'cannot integrate the motion of a free body; valid with BodyMotion = free_flight: AB2')
    if (fluid%solids%obstacle /= NO_SHAPE) call config%complain(errors, 'Penalization', 'obstacle', &
      'needs an insect that is tethered or moves as prescribed; valid with BodyMotion = free_flight: none')
    if (fluid%grid%is_2d) call config%complain(errors, SECTION, 'BodyMotion', &
      'is free_flight in a two-dimensional flow; valid there: a body that is tethered or moves as prescribed')
    if (flexible .and. .not. flight%thin%is_thin .and. coupler%coupling == COUPLING_STRONG) &
      call config%complain(errors, 'Flexible_wing', 'coupling', 'is strong, which repeats a step of the flow and needs a body '// &
                           'that does not move freely; valid with BodyMotion = free_flight: weak, extrapolated, or surface = thin')
    wings = 0
    if (flexible) then
      if (.not. allocated(coupler%inertia%mass)) return ! there is no mass, which has been reported
      call set_gravity(config, units, flight, coupler, errors)
      wings = size(flight%wings)*sum(coupler%inertia%mass)/units%mass
    else
      wings = mass_of_wings(flight)
      if (.not. flight%has_wing_mass .and. flight%has_jxx .and. flight%flyer%mass > 0 .and. wings >= flight%flyer%mass) then
        call config%complain(notices, SECTION, 'Jxx', 'makes the mass of the wings '//number_text(wings)//', not below that '// &
                             'of the whole insect: the program uses Jxx for the power of the wings only, and flies '// &
                             'them without mass, as FLUSI does; set wing_mass to give them a mass')
        call drop_masses(flight)
        wings = 0
      else if (size(flight%wings) > 0 .and. .not. wings > 0) then
        call notices%add('[Insects] wing_mass is 0: the wings of this free flight have no mass, as in FLUSI')
      end if
    end if
    if (flight%flyer%mass > 0 .and. wings >= flight%flyer%mass) &
      call config%complain(errors, SECTION, 'mass', 'must include the wings, whose mass alone is '// &
                           number_text(wings))
    call notice_weight(config, flight, notices)
    call notice_way(config, fluid, flight, notices)
  end subroutine check_free_flight

  !> Returns the mass of all wings.
  pure real(rp) function mass_of_wings(flight) result(mass)
    type(flight_params_t), intent(in) :: flight
    integer :: i
    mass = 0
    do i = 1, size(flight%wings)
      mass = mass + flight%wings(i)%moments%mass
    end do
  end function mass_of_wings

  !> Makes all wings massless.
  subroutine drop_masses(flight)
    type(flight_params_t), intent(inout) :: flight
    type(moments_t) :: nothing
    integer :: i
    do i = 1, size(flight%wings)
      flight%wings(i)%moments = nothing
    end do
  end subroutine drop_masses

  !> Gives each rigid wing of a free flight the mass of every point that [Wing] gives, unless the user gives another mass.
  subroutine take_masses(wing_case, units, flight)
    type(wing_case_t), intent(in) :: wing_case
    type(unit_scales_t), intent(in) :: units
    type(flight_params_t), intent(inout) :: flight
    integer :: i
    if (.not. flight%flyer%is_free .or. flight%has_wing_mass .or. flight%has_jxx) return
    do i = 1, size(flight%wings)
      associate (wing => flight%wings(i))
        if (size(wing%points, 2) /= size(wing_case%mass%nodal)) cycle
        wing%moments = moments_of_points(wing_case%mass%nodal/units%mass, wing%points)
      end associate
    end do
  end subroutine take_masses

  !> Makes the same gravity act on wings and body: [Flexible_wing] gravity becomes that of [Insects]. A different value is a
  !> mistake.
  subroutine set_gravity(config, units, flight, coupler, errors)
    type(config_t), intent(in) :: config
    type(unit_scales_t), intent(in) :: units
    type(flight_params_t), intent(in) :: flight
    type(coupler_params_t), intent(inout) :: coupler
    type(message_list_t), intent(inout) :: errors
    real(rp) :: gravity(3)
    gravity = [0.0_rp, 0.0_rp, flight%flyer%gravity*units%length/units%time**2]
    if (coupler%states_gravity .and. norm2(gravity - coupler%gravity) > 1.0e-3_rp*norm2(gravity)) &
      call config%complain(errors, 'Flexible_wing', 'gravity', 'differs from [Insects] gravity, '// &
                           number_text(gravity(3))//' m/s^2 along z; leave it out')
    coupler%gravity = gravity
  end subroutine set_gravity

  !> Adds a remark if the weight is far from the lift that such wings can make.
  subroutine notice_weight(config, flight, notices)
    type(config_t), intent(in) :: config
    type(flight_params_t), intent(in) :: flight
    type(message_list_t), intent(inout) :: notices
    real(rp) :: lift, weight
    if (size(flight%wings) == 0) return
    if (size(flight%wings(1)%points) == 0) return
    lift = size(flight%wings)*flight%tip_speed()**2*flight%wings(1)%length()*flight%wings(1)%mean_chord()/2
    weight = abs(flight%flyer%mass*flight%flyer%gravity)
    if (.not. lift > 0 .or. .not. weight > 0) return
    if (weight > WEIGHTS(1)*lift .and. weight < WEIGHTS(2)*lift) return
    call config%complain(notices, SECTION, 'mass', 'makes a weight of '//number_text(weight)//' rho L^4/T^2, and wings '// &
                         'like these lift about '//number_text(lift)//': check the units of mass and gravity')
  end subroutine notice_weight

  !> Adds a remark if the insect will cross its own wake.
  subroutine notice_way(config, fluid, flight, notices)
    type(config_t), intent(in) :: config
    type(fluid_params_t), intent(in) :: fluid
    type(flight_params_t), intent(in) :: flight
    type(message_list_t), intent(inout) :: notices
    real(rp) :: way(3)
    if (fluid%time%t_max > 1.0e6_rp) return ! the number of steps limits this run
    way = (flight%motion%velocity - fluid%mean%velocity)*fluid%time%t_max
    if (all(abs(way) <= fluid%grid%length)) return
    call config%complain(notices, SECTION, 'v0', 'moves the insect through the periodic box before Tmax, over '// &
                         number_text(maxval(abs(way)/fluid%grid%length))//' lengths of the box: it meets its own wake')
  end subroutine notice_way

  !> Returns the lines of the summary on the flight: means over the time from `first` to `last`, the weight, and the mean
  !> lift. It reads them from the series on the disk and fails if it cannot. It is empty if the records do not span that time.
  function free_flight_text(flight, fluid, lift, first, last, failure) result(text)
    type(flight_params_t), intent(in) :: flight
    type(fluid_params_t), intent(in) :: fluid
    real(rp), intent(in) :: lift        !< mean over these times, rho L^4/T^2
    real(rp), intent(in) :: first, last !< T
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: text
    character(*), parameter :: NL = new_line('a')
    real(rp), allocatable :: state(:, :), loads(:, :)
    real(rp) :: way(3), tilt(3)
    character(160) :: line
    integer :: a, b, n
    text = ''
    call read_series('rigidsolidsolver.t', 14, state, failure)
    call read_series('free_flight.t', 22, loads, failure)
    if (failure%failed) return
    n = size(state, 2)
    a = minloc(abs(state(1, :) - first), 1)
    b = minloc(abs(state(1, :) - last), 1)
    if (b <= a) return
    way = state(2:4, b) - state(2:4, a)
    tilt = sum(loads(2:4, a:b), 2)/(b - a + 1)*180/PI
    write (line, '(a,3es11.3,a)') 'velocity    mean of the last beat', way/(state(1, b) - state(1, a)), ' L/T'
    text = NL//trim(line)//NL
    write (line, '(a,3f9.2,a)') 'attitude    mean roll, pitch, yaw of the last beat', tilt, ' degrees'
    text = text//trim(line)//NL
    write (line, '(2(a,es10.3),a)') 'weight      ', -flight%flyer%mass*flight%flyer%gravity, ', mean lift ', lift, &
      ' rho L^4/T^2 (last beat)'
    text = text//trim(line)//NL
    write (line, '(a,3es11.3,a,i0,a)') 'path        from the start', state(2:4, n) - state(2:4, 1), ' L in ', n, ' records'
    text = text//trim(line)//NL
    if (any(abs(state(2:4, n) - state(2:4, 1)) > fluid%grid%length)) &
      text = text//'            the insect has crossed the periodic box and met its own wake'//NL
  end function free_flight_text
end module simulation_free_flight
