! SPDX-License-Identifier: GPL-3.0-or-later
!> The two wings of a fly that flaps symmetrically in a vacuum are mirror images of each other, with every effect that a
!> wing may have, and to whichever side the z of the wing file points.
program test_wing_mirror
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use fluid_solver, only: fluid_t
  use fsi_coupler, only: coupler_t
  use fsi_coupler_params, only: coupler_params_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_flight_params, only: flight_params_t, COLOR_LEFT, COLOR_RIGHT
  use fsi_kinematics, only: body_rotation, pose_wing, wing_pose_t
  use fsi_rotation, only: angle_t
  use fsi_wing_energy, only: wing_energy_t
  use io_units, only: unit_scales_t
  use named_params, only: set_each, value_of
  use sample_wings, only: make_fly_wing
  use solid_inertia, only: momenta_t
  use solid_params, only: default_params, solid_params_t
  use solid_wing, only: wing_t, Z_SIDES
  use support_fluid, only: box_3d, make_fluid, NL
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: METRE = 6.0e-3_rp  !< one L: the wing has the length 1.5
  real(rp), parameter :: PERIOD = 1/158.0_rp !< [s] one T
  real(rp), parameter :: MASS = 250.0e-9_rp !< [kg] of a wing
  real(rp), parameter :: DT = 0.01_rp       !< T
  integer, parameter :: STEPS = 4
  real(rp), parameter :: FLIP(3) = [1.0_rp, -1.0_rp, 1.0_rp] !< from left to right in space
  !> The frames of both wings differ by round-off, which the stiffest spring (k_e) may amplify over the softest motion of
  !> the wing, EI/L^3 of its veins: 1e5 L^3/EI = 1e6 for veins of 40 um. Both wings make the same iterations, so that
  !> what these leave is the same, too.
  real(rp), parameter :: ROUND_OFF = 1.0e6_rp*epsilon(1.0_rp)

  !> What is compared of a flight: (3, points, steps, wings) displacements [L], and at its end energies and momenta.
  type :: flown_t
    real(rp), allocatable :: u(:, :, :, :)
    type(wing_energy_t) :: energies(2)
    real(rp) :: linear(3, 2), angular(3, 2), centre(3, 2) !< in space
  end type flown_t

  type(testkit_t) :: t
  type(fluid_t) :: fluid
  type(wing_t) :: wing
  type(solid_params_t) :: plain, all_effects
  type(parameter_t) :: effect
  type(flown_t) :: flown, other
  integer :: i, k

  call t%start(parallel=.true.)
  call make_fluid(t%world, box_3d(16, 4.0_rp)//'[ReynoldsNumber]'//NL//'nu=0.1'//NL//'[InitialCondition]'//NL// &
                  'inicond=quiescent'//NL//'[Time]'//NL//'Tmax=1'//NL, fluid)
  wing = make_fly_wing(24, 12)
  plain = default_params(wing)
  plain%joint = 2.0e-6_rp
  plain%effects%disc = [4.0e-3_rp, 0.0_rp, 1.5e-3_rp]
  plain%effects%soft_vein = 'R4+5'
  plain%effects%soft_fraction = 0.45_rp
  plain%effects%has_sides = .true.
  plain%effects%has_sided_veins = .true.
  all_effects = plain
  call every_effect()
  call fly(wing, all_effects, flown)
  call t%check_below('mirror images with all effects together', mirror_error(flown), ROUND_OFF)
  call check_sums(flown)
  call fly(wing, all_effects, other, same_frames=.true.)
  call t%check('which they are not if each is the wing of the file in its own frame', mirror_error(other) > 0.05_rp)
  call test_sides()
  call fly(tilted(), all_effects, flown)
  call t%check_below('mirror images with places off the plane z = 0', mirror_error(flown), ROUND_OFF)
  call fluid%free()
  call t%finish()

contains

  !> Each effect alone, at a strength that is usual for it.
  subroutine every_effect()
    type(solid_params_t) :: params
    do i = plain%count_basic() + 1, plain%count()
      effect = plain%describe(i)
      params = plain
      call params%set(i, strength())
      call all_effects%set(i, strength())
      call fly(wing, params, flown)
      call t%check_below('mirror images with '//effect%name, mirror_error(flown), ROUND_OFF)
    end do
  end subroutine every_effect

  !> The upper end of what is usual for `effect`.
  real(rp) function strength()
    if (effect%is_log) then
      strength = effect%null*exp(effect%prior_sd)
    else
      strength = effect%null + effect%prior_sd
    end if
    strength = min(strength, effect%upper)
  end function strength

  !> The same wing in a file whose z points to the other side: curvatures have the other sign there. (So would one-way
  !> joints have the inverse factor, but only as far as a joint folds two flat halves.) The statement in the file makes it
  !> the same wing; without it, it is another one.
  subroutine test_sides()
    type(wing_t) :: turned
    type(solid_params_t) :: params
    params = all_effects
    call set_each(params, 'one_way:', spread(1.0_rp, 1, size(params%joint)))
    call fly(wing, params, flown)
    call set_each(params, 'camber_', -[value_of(params, 'camber_span'), value_of(params, 'camber_chord'), &
                                      value_of(params, 'camber_twist')])
    do k = 1, size(Z_SIDES)
      turned = wing
      turned%z_side = Z_SIDES(k)%kind
      call fly(turned, params, other)
      call t%check_below('mirror images with z on the side: '//trim(Z_SIDES(k)%word), mirror_error(other), ROUND_OFF)
      if (turned%z_is_dorsal()) then
        call t%check_below('the same wing seen from '//trim(Z_SIDES(k)%word), difference(other%u, flown%u), ROUND_OFF)
      else
        call t%check('another wing seen from '//trim(Z_SIDES(k)%word), difference(other%u, flown%u) > 0.05_rp)
      end if
    end do
  end subroutine test_sides

  !> The wing turned about x in its frame.
  function tilted() result(turned)
    type(wing_t) :: turned
    real(rp), parameter :: ANGLE = 0.1_rp
    turned = wing
    turned%points(3, :) = sin(ANGLE)*turned%points(2, :)
    turned%points(2, :) = cos(ANGLE)*turned%points(2, :)
  end function tilted

  !> Energies, momenta and the centre of mass are mirror images as well.
  subroutine check_sums(f)
    type(flown_t), intent(in) :: f
    associate (a => f%energies(1), b => f%energies(2), bound => ROUND_OFF*(f%energies(1)%kinetic + f%energies(1)%elastic))
      call t%check_below('the same energy', abs(a%kinetic - b%kinetic) + abs(a%elastic - b%elastic), bound)
      call t%check_below('the same work of hinge and weight', abs(a%hinge_work - b%hinge_work) + &
                         abs(a%weight_work - b%weight_work), bound)
      call t%check_below('the same loss to damping', abs(a%damped - b%damped), bound)
      call t%check('some is lost', a%damped > 0)
    end associate
    call t%check_below('momentum', norm2(f%linear(:, 2) - FLIP*f%linear(:, 1)), ROUND_OFF*norm2(f%linear(:, 1)))
    call t%check_below('angular momentum', norm2(f%angular(:, 2) + FLIP*f%angular(:, 1)), &
                       ROUND_OFF*norm2(f%angular(:, 1)))
    call t%check_below('centre of mass', norm2(f%centre(:, 2) - FLIP*f%centre(:, 1)), ROUND_OFF*norm2(f%centre(:, 1)))
  end subroutine check_sums

  !> Largest deviation of the right wing from the mirror image of the left one, of any point at any time, over the largest
  !> displacement.
  pure real(rp) function mirror_error(f) result(error)
    type(flown_t), intent(in) :: f
    real(rp) :: image(size(f%u, 1), size(f%u, 2), size(f%u, 3))
    image = f%u(:, :, :, 1)
    image(3, :, :) = -image(3, :, :)
    error = maxval(abs(f%u(:, :, :, 2) - image))/maxval(abs(image))
  end function mirror_error

  pure real(rp) function difference(a, b)
    real(rp), intent(in) :: a(:, :, :, :), b(:, :, :, :)
    difference = maxval(abs(a - b))/maxval(abs(b))
  end function difference

  !> Both wings of a fly from rest, with weight and damping, without a flow. `same_frames`: as if the right wing's frame
  !> were that of the file.
  subroutine fly(given, params, f, same_frames)
    type(wing_t), intent(in) :: given
    type(solid_params_t), intent(in) :: params
    type(flown_t), intent(out) :: f
    logical, intent(in), optional :: same_frames
    type(coupler_t) :: coupler
    type(coupler_params_t) :: c
    type(flapping_wings_t) :: wings
    type(failure_t) :: failure
    integer :: n, j
    c%units = unit_scales_t(length=METRE, time=PERIOD, mass=1.2_rp*METRE**3)
    c%distance = 0.45_rp
    c%gravity = [300.0_rp, 0.0_rp, -900.0_rp]
    c%largest_deflection = 9
    call c%model%init(given, params, failure)
    call c%inertia%init(c%model, [(MASS/size(given%points, 2), j=1, size(given%points, 2))])
    c%inertia%rayleigh_mass = 20
    c%inertia%rayleigh_stiffness = 3.0e-5_rp
    call wings%init(flight_of(given, same_frames), fluid%rhs%params%grid, fluid%transform%block)
    call coupler%init(t%world, c, fluid, 0.0_rp, wings)
    allocate (f%u(3, size(given%points, 2), STEPS, 2))
    do n = 1, STEPS
      call coupler%advance(DT, wings, failure)
      do j = 1, 2
        f%u(:, :, n, j) = wings%deformation(j)%u
      end do
    end do
    if (failure%failed) call t%check('flown: '//failure%reason, .false.)
    f%energies = coupler%energies
    do j = 1, 2
      call look(coupler, wings%params, j, f)
    end do
    call coupler%free()
  end subroutine fly

  !> Momenta of wing j and its centre of mass, in space.
  subroutine look(coupler, params, j, f)
    type(coupler_t), intent(in) :: coupler
    type(flight_params_t), intent(in) :: params
    integer, intent(in) :: j
    type(flown_t), intent(inout) :: f
    type(wing_pose_t) :: pose
    type(momenta_t) :: m
    m = coupler%measure(j)
    call pose_wing(params%body, params%wings(j)%mount, params%wings(j)%motion, coupler%states(j)%time/PERIOD, pose)
    f%linear(:, j) = pose%vector_to_space(m%linear)
    f%angular(:, j) = pose%vector_to_space(m%angular)
    f%centre(:, j) = pose%vector_to_space(m%centre)
  end subroutine look

  function flight_of(given, same_frames) result(flight)
    type(wing_t), intent(in) :: given
    logical, intent(in), optional :: same_frames
    type(flight_params_t) :: flight
    integer :: j
    flight%half_thickness = 0.2_rp
    flight%smoothing = 0.125_rp
    flight%body%centre = 2
    flight%body%rotation = body_rotation(roll=angle_t(), pitch=angle_t(value=-0.5_rp), yaw=angle_t())
    allocate (flight%wings(2))
    do j = 1, 2
      associate (w => flight%wings(j))
        w%side = merge('left ', 'right', j == 1)
        w%color = merge(COLOR_LEFT, COLOR_RIGHT, j == 1)
        w%mount%is_right = j == 2
        w%mount%hinge = [0.1_rp, merge(0.3_rp, -0.3_rp, j == 1), 0.05_rp]
        w%mount%eta = -1.1_rp
        w%is_mirrored = w%mount%mirrors(given%z_is_dorsal())
        if (present(same_frames)) w%is_mirrored = w%is_mirrored .and. .not. same_frames
        w%points = given%points/METRE
        if (w%is_mirrored) w%points(3, :) = -w%points(3, :)
        w%triangles = given%triangles
        call w%motion%phi%set_fourier(0.0_rp, [0.9_rp], [0.1_rp])
        call w%motion%alpha%set_fourier(0.4_rp, [0.1_rp], [0.7_rp])
        call w%motion%theta%set_fourier(0.1_rp, [0.1_rp, 0.05_rp], [0.0_rp, 0.1_rp])
      end associate
    end do
  end function flight_of
end program test_wing_mirror
