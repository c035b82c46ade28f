! SPDX-License-Identifier: GPL-3.0-or-later
!> Natural modes of a wing at rest against exact chains and beams, their derivatives with respect to everything that acts on
!> them against differences, and their frequency against that of the wing when it rings. The first argument names a wing file.
program test_solid_modal
  use base_constants, only: PI, TWO_PI
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use cantilever, only: make_cantilever
  use loaded_wing, only: wing_of_argument
  use solid_added_mass, only: strip_added_mass
  use solid_dynamics, only: dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_mass, only: lump_mass, mass_params_t, mass_t
  use solid_mass_effects, only: mass_effects_t, mass_parts_t, MASS_POINT, N_MASS_EFFECTS
  use solid_modal, only: modal_t, mode_slopes_t
  use solid_model, only: solid_model_t
  use solid_motion, only: steady_motion_t
  use solid_params, only: default_params, solid_params_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: damage_direction, hinge_direction, parameter_direction
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: K = 4                  !< modes that are compared
  real(rp), parameter :: AIR = 1.2_rp          !< [kg/m^3]
  real(rp), parameter :: LIMIT = 1.0e-7_rp     !< of derivatives, see test_slopes
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(mass_parts_t) :: parts
  type(mass_effects_t) :: effects

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  call test_chain()
  call test_beam()
  call prepare_wing()
  call test_strip()
  call test_slopes('at null', .true.)
  call test_slopes('away from null', .false.)
  call test_ringing()
  call t%finish()

contains

  !> n masses on n springs, fixed at one end: omega_j = 2 sqrt(k/m) sin((2 j - 1) pi/(4 n + 2)). Along the beam the hinges of
  !> a straight chain do nothing, and they are so stiff that its lowest modes are those of the springs.
  subroutine test_chain()
    integer, parameter :: SIZES(2) = [2, 12]
    real(rp), parameter :: SPRING = 100.0_rp
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(modal_t) :: modal
    type(failure_t) :: failure
    real(rp) :: exact
    integer :: i, j, n
    do i = 1, size(SIZES)
      n = SIZES(i)
      call make_cantilever(n, 1.0e7_rp, SPRING, model, inertia)
      call modal%init(model)
      call modal%solve(spread(merge(1.0_rp, 0.0_rp, inertia%mass > 0), 1, 3), n, failure)
      call t%check('the modes of a chain are found',.not. failure%failed)
      do j = 1, n
        exact = 2*sqrt(SPRING)*sin((2*j - 1)*PI/(4*n + 2))
        call t%check_close('a chain of masses and springs has its discrete frequencies', sqrt(modal%lambda(j)), exact, &
                           rtol=1.0e-8_rp)
      end do
      call modal%free()
    end do
  end subroutine test_chain

  !> Euler and Bernoulli's cantilever, every frequency in both planes: values, and derivatives where modes repeat.
  subroutine test_beam()
    real(rp), parameter :: EXACT(4) = [1.87510407_rp, 4.69409113_rp, 7.85475744_rp, 10.9955407_rp]**2
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(modal_t) :: modal
    type(failure_t) :: failure
    type(stiffness_t) :: direction
    type(mode_slopes_t) :: slopes
    real(rp), allocatable :: product(:, :)
    logical :: same(8, 8)
    integer :: i, j
    call make_cantilever(160, 1.0_rp, 1.0e6_rp, model, inertia)
    call modal%init(model)
    call modal%solve(spread(inertia%mass, 1, 3), 8, failure)
    call t%check('the modes of a cantilever are found',.not. failure%failed)
    allocate (product(8, 8))
    do i = 1, 8
      call t%check_close('a natural frequency of the cantilever is beta^2', sqrt(modal%lambda(i)), &
                         EXACT(ceiling(0.5_rp*i)), rtol=1.0e-3_rp)
      do j = 1, 8
        product(i, j) = sum(spread(inertia%mass, 1, 3)*modal%shapes(:, :, i)*modal%shapes(:, :, j)) - merge(1, 0, i == j)
        same(i, j) = (i - 1)/2 == (j - 1)/2
      end do
    end do
    call t%check_below('shapes are orthonormal in the metric of the masses', maxval(abs(product)), 1.0e-9_rp)
    call parameter_direction(model, 1, direction) ! log E: all of the bending stiffness
    call modal%slopes_of_stiffness(direction, same, slopes)
    do i = 1, 8
      j = merge(i + 1, i - 1, mod(i, 2) == 1)
      call t%check_close('omega^2 goes with E', slopes%force(i, i)/modal%lambda(i), 1.0_rp, atol=1.0e-8_rp)
      call t%check_below('both planes at once, without turning into one another', &
                         abs(slopes%force(j, i))/modal%lambda(i), 1.0e-8_rp)
      call t%check_below('no shape changes with E', norm2(slopes%shapes(:, :, i))/norm2(modal%shapes(:, :, i)), 1.0e-7_rp)
    end do
    call modal%free()
  end subroutine test_beam

  subroutine prepare_wing()
    type(mass_params_t) :: material
    type(mass_t) :: mass
    type(message_list_t) :: messages
    call lump_mass(wing, material, mass, messages)
    call t%check('the wing has a mass', messages%count() == 0)
    call parts%init(wing, mass)
    call t%check_close('its parts are the whole', sum(parts%veins) + sum(parts%membrane), mass%total, rtol=1.0e-12_rp)
  end subroutine prepare_wing

  !> A rectangle carries rho pi c^2/4 L; the root of the profile at its edges costs the midpoints a few percent.
  subroutine test_strip()
    integer, parameter :: NX = 6, NY = 40
    real(rp), parameter :: L = 3.0_rp, C = 1.5_rp
    type(wing_t) :: plate
    integer :: i, j, m
    allocate (plate%points(3, (NX + 1)*(NY + 1)), plate%triangles(3, 2*NX*NY))
    m = 0
    do j = 0, NY
      do i = 0, NX
        plate%points(:, 1 + i + j*(NX + 1)) = [L*i/NX, C*j/NY, 0.0_rp]
        if (i == NX .or. j == NY) cycle
        plate%triangles(:, m + 1) = 1 + i + j*(NX + 1) + [0, 1, NX + 2]
        plate%triangles(:, m + 2) = 1 + i + j*(NX + 1) + [0, NX + 2, NX + 1]
        m = m + 2
      end do
    end do
    call t%check_close('the added mass of a strip is that of a flat plate', sum(strip_added_mass(plate)), &
                       PI*C**2/4*L, rtol=1.0e-2_rp)
  end subroutine test_strip

  !> The wing with these parameters and masses.
  subroutine solve(modal, params, mass_effects)
    type(modal_t), intent(inout) :: modal
    type(solid_params_t), intent(in) :: params
    type(mass_effects_t), intent(in) :: mass_effects
    type(failure_t) :: failure
    real(rp) :: mass(3, modal%model%n_all)
    call modal%model%set_params(params)
    call parts%masses(mass_effects, AIR, mass)
    call modal%solve(mass, K + 3, failure)
    if (failure%failed) call t%check('modes are found', .false.)
  end subroutine solve

  !> Derivatives against differences of fourth order with h = 1e-3: its error is (h/1)^4/30 of the fifth derivative, some
  !> 1e-12, and that of the residuals of the modes, 1e-12, over h.
  subroutine test_slopes(where, is_null)
    character(*), intent(in) :: where
    logical, intent(in) :: is_null
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(modal_t) :: modal, other
    type(failure_t) :: failure
    type(stiffness_t) :: direction
    type(mode_slopes_t) :: slopes
    type(parameter_t) :: p
    real(rp), allocatable :: dm(:, :)
    logical :: same(K, K)
    integer :: i
    params = chosen_params(is_null)
    call model%init(wing, params, failure)
    call t%check('the wing is valid',.not. failure%failed)
    call modal%init(model)
    call other%init(model)
    call solve(modal, params, effects)
    call t%check_below('residuals of the modes', modal%residual, 1.0e-11_rp)
    same = .false.
    do i = 1, params%count()
      p = params%describe(i)
      if (.not. is_compared(p)) cycle
      select case (p%name)
      case ('root_twist', 'root_flap')
        call modal%slopes_of_clamp(merge(1, 2, p%name == 'root_twist'), same, slopes)
      case default
        call parameter_direction(modal%model, i, direction)
        call modal%slopes_of_stiffness(direction, same, slopes)
      end select
      call compare(modal, other, slopes, p, where, i, 0)
    end do
    allocate (dm(3, model%n_all))
    do i = 1, N_MASS_EFFECTS
      p%name = 'mass effect '//achar(48 + i)
      p%is_log = i /= 3 .and. i /= MASS_POINT
      p%prior_sd = merge(2.5e-8_rp, 1.0_rp, i == MASS_POINT)
      call parts%derivative(effects, AIR, i, dm)
      call modal%slopes_of_mass(dm, same, slopes)
      call compare(modal, other, slopes, p, where, 0, i)
    end do
    if (is_null) then ! what is not in the model can be scanned
      call damage_direction(modal%model, params%effects%disc, direction)
      call modal%slopes_of_stiffness(direction, same, slopes)
      p = params%describe(params%find('damage'))
      call compare(modal, other, slopes, p, 'that the model lacks', params%find('damage'), 0)
      call hinge_direction(modal%model, modal%model%layout%soft_hinge, direction)
      call modal%slopes_of_stiffness(direction, same, slopes)
      p = params%describe(params%find('soft'))
      call compare(modal, other, slopes, p, 'that the model lacks', params%find('soft'), 0)
    end if
    call modal%free()
    call other%free()
  end subroutine test_slopes

  !> Parameters, and `effects`, at null or all away from it.
  function chosen_params(is_null) result(params)
    logical, intent(in) :: is_null
    type(solid_params_t) :: params
    params = default_params(wing)
    params%joint = 1.0e-6_rp
    params%effects%disc = [4.5e-3_rp, -0.5e-3_rp, 1.2e-3_rp]
    params%effects%soft_vein = 'R4+5'
    params%effects%soft_fraction = 0.4_rp
    params%effects%has_sided_veins = .true.
    effects = mass_effects_t()
    effects%corner = wing%triangles(:, size(wing%triangles, 2)/2)
    effects%weight = [0.5_rp, 0.3_rp, 0.2_rp]
    if (.not. is_null) then
      call params%set_named('E_gradient', -0.7_rp)
      call params%set_named('damage', 0.4_rp)
      call params%set_named('soft', 0.1_rp)
      call params%set_named('orthotropy', 0.3_rp)
      call params%set_named('torsion', 0.8_rp)
      call params%set_named('root_flap', 3.0e3_rp)
      call params%set_named('root_twist', 1.0e3_rp)
      effects%veins = 1.3_rp
      effects%membrane = 0.8_rp
      effects%gradient = -0.4_rp
      effects%added = 0.7_rp
      effects%point = 5.0e-9_rp
    end if
  end function chosen_params

  !> Differences with respect to parameter i of the wing, or effect j of the masses.
  subroutine compare(modal, other, slopes, p, where, i, j)
    type(modal_t), intent(in) :: modal
    type(modal_t), intent(inout) :: other
    type(mode_slopes_t), intent(in) :: slopes
    type(parameter_t), intent(in) :: p
    character(*), intent(in) :: where
    integer, intent(in) :: i, j
    real(rp), parameter :: WEIGHTS(4) = [1.0_rp, -8.0_rp, 8.0_rp, -1.0_rp]/12, AT(4) = [-2, -1, 1, 2]
    type(solid_params_t) :: changed
    type(mass_effects_t) :: masses
    real(rp) :: h, value, lambda(K), shapes(3, modal%model%n_all, K), scale, error
    integer :: n, m
    h = 1.0e-3_rp
    if (.not. p%is_log .and. p%prior_sd > 0) h = 1.0e-3_rp*p%prior_sd
    if (p%name == 'torsion') h = 1.0e-4_rp ! veins that twist freely feel the least of it
    lambda = 0
    shapes = 0
    do n = 1, 4
      changed = modal%model%params
      masses = effects
      if (i > 0) then
        value = modal%model%params%get(i)
        call changed%set(i, merge(value*exp(AT(n)*h), value + AT(n)*h, p%is_log))
      else
        value = effects%get(j)
        call masses%set(j, merge(value*exp(AT(n)*h), value + AT(n)*h, p%is_log))
      end if
      call solve(other, changed, masses)
      lambda = lambda + WEIGHTS(n)*other%lambda(:K)/h
      do m = 1, K
        shapes(:, :, m) = shapes(:, :, m) + WEIGHTS(n)/h*other%shapes(:, :, m)* &
                          sign(1.0_rp, sum(other%shapes(:, :, m)*modal%shapes(:, :, m)))
      end do
    end do
    scale = 1
    if (.not. p%is_log .and. p%prior_sd > 0) scale = p%prior_sd ! per sd
    error = 0
    do m = 1, K
      error = max(error, scale*abs(lambda(m) - slopes%force(m, m))/modal%lambda(m))
    end do
    call t%check_below('derivative of frequencies to '//p%name//' '//where, error, LIMIT)
    error = 0
    do m = 1, K
      error = max(error, scale*norm2(shapes(:, :, m) - slopes%shapes(:, :, m))/norm2(modal%shapes(:, :, m)))
    end do
    call t%check_below('derivative of shapes to '//p%name//' '//where, error, LIMIT)
  end subroutine compare

  !> What acts on small motions about the flat wing at rest; a few of the many.
  logical function is_compared(p)
    type(parameter_t), intent(in) :: p
    character(20), parameter :: NAMES(12) = [character(20) :: 'E', 'D', 'root', 'diameter_exponent', 'k_membrane', &
                                             'E_gradient', 'damage', 'soft', 'orthotropy', 'torsion', 'root_flap', 'root_twist']
    is_compared = any(NAMES == p%name) .or. p%name == 'joint:C_h' .or. p%name == 'E:R4+5'
  end function is_compared

  !> The wing, released in the shape of its first mode, rings with its frequency, but for what BDF2 takes off: (omega dt)^2/3,
  !> and terms of the fourth order, 1.6e-5 with a hundred steps a period.
  subroutine test_ringing()
    integer, parameter :: A_PERIOD = 100, N_CROSSINGS = 8
    type(solid_model_t) :: model
    type(modal_t) :: modal
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state
    type(dynamic_options_t) :: options
    type(step_report_t) :: report
    type(steady_motion_t) :: rest
    type(failure_t) :: failure
    real(rp), allocatable :: u(:, :), force(:, :), mass(:, :)
    real(rp) :: dt, before, now, crossings(N_CROSSINGS), f
    integer :: tip, n
    call model%init(wing, default_params(wing), failure)
    allocate (mass(3, model%n_all), force(3, model%n_all), source=0.0_rp)
    call parts%masses(mass_effects_t(), 0.0_rp, mass)
    call modal%init(model)
    call modal%solve(mass, 2, failure)
    call inertia%init(model, mass(1, :model%n_points))
    call stepper%init(model)
    tip = maxloc(model%points(1, :model%n_points), 1)
    u = modal%shapes(:, :, 1)*1.0e-4_rp*model%size/abs(modal%shapes(3, tip, 1))
    call state%init(model, 0.0_rp, u=u)
    dt = TWO_PI/sqrt(modal%lambda(1))/A_PERIOD
    n = 0
    do while (n < N_CROSSINGS .and. state%time < N_CROSSINGS*A_PERIOD*dt)
      before = state%u(3, tip)
      call stepper%step(model, inertia, rest, force, dt, options, state, report)
      now = state%u(3, tip)
      if (now*before > 0) cycle
      n = n + 1
      crossings(n) = state%time - dt*now/(now - before)
    end do
    f = 0.5_rp*(N_CROSSINGS - 2)/(crossings(N_CROSSINGS) - crossings(2))
    call t%check_close('the wing rings with its natural frequency, as BDF2 shows it', f*TWO_PI/sqrt(modal%lambda(1)), &
                       1 - (TWO_PI/A_PERIOD)**2/3, atol=3.0e-5_rp)
    call stepper%free()
    call modal%free()
  end subroutine test_ringing
end program test_solid_modal
