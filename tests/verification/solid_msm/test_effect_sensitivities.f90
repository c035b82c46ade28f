! SPDX-License-Identifier: GPL-3.0-or-later
!> The derivatives of the shape of a wing, in the file that the first argument names, with respect to everything that
!> goes beyond the usual model equal central differences of equilibria: where the effects vanish and where they do not.
!> So do derivatives with respect to effects that the model does not have.
program test_effect_sensitivities
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use loaded_wing, only: load_at, wing_of_argument
  use model_variation, only: set_parameter, shape_sensitivities
  use named_params, only: set_each, value_of
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, solid_params_t
  use solid_sensitivity, only: direction_sensitivity, force_sensitivity
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: damage_direction
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N_LOADS = 2, PLACES(N_LOADS) = [4, 6]
  real(rp), parameter :: FORCES(N_LOADS) = [2.5e-4_rp, 6.0e-4_rp] !< [N] move the places by some 0.05 R
  real(rp), parameter :: LIMIT = 1.0e-6_rp !< of the largest value; the wing solver's 1e-10 over the step
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(equilibrium_t) :: work
  type(load_t) :: load
  type(static_options_t) :: options

  call t%start(parallel=.false.)
  options%tolerance = 1.0e-10_rp
  wing = wing_of_argument()
  call check_all('at null', is_null=.true.)
  call check_all('away from null', is_null=.false.)
  call check_mirror()
  call t%finish()

contains

  subroutine check_all(where, is_null)
    character(*), intent(in) :: where
    logical, intent(in) :: is_null
    type(solid_params_t) :: params
    type(failure_t) :: failure
    type(static_report_t) :: report
    type(parameter_t) :: p
    real(rp), allocatable :: u(:, :), d(:, :, :), difference(:, :)
    integer :: l, i, first, n_up
    params = default_params(wing)
    params%joint = 1.0e-6_rp
    params%effects%disc = [4.5e-3_rp, -0.5e-3_rp, 1.2e-3_rp]
    params%effects%soft_vein = 'R4+5'
    params%effects%soft_fraction = 0.4_rp
    params%effects%has_sides = .true.
    params%effects%has_sided_veins = .true.
    if (.not. is_null) then
      call params%set_named('E_gradient', -0.7_rp)
      call params%set_named('damage', 0.4_rp)
      call params%set_named('soft', 0.1_rp)
      call params%set_named('orthotropy', 0.3_rp)
      call params%set_named('thickness_gradient', 0.4_rp)
      call params%set_named('joint_hardening', 8.0_rp)
      call params%set_named('hardening:'//trim(params%joint_names(2)), -3.0_rp)
      call params%set_named('cuticle', 1.0e-6_rp)
      call set_each(params, 'one_way:', spread(1.4_rp, 1, size(params%joint)))
      call params%set_named('pretension', 0.05_rp)
      call set_each(params, 'camber_', [0.5_rp, 20.0_rp, -4.0_rp])
      call params%set_named('torsion', 0.8_rp)
    end if
    call model%init(wing, params, failure)
    call t%check('the wing is valid',.not. failure%failed)
    call work%init(model)
    first = params%count_basic() + 1
    allocate (u(3, model%n_all), difference(3, model%n_all), d(3, model%n_all, first:params%count()), source=0.0_rp)
    do l = 1, N_LOADS
      call load_at(model, PLACES(l), FORCES(l), load)
      call solve_static(work, model, load, .false., options, u, report)
      call t%check('the shape is found '//where, report%converged .and. report%snaps == 0)
      call shape_sensitivities(work, model, u, [(i, i=first, params%count())], d)
      call check_scan(where, u)
      n_up = 0
      do i = first, params%count()
        p = params%describe(i)
        if (index(p%name, 'hardening:') == 1 .and. i /= params%find('hardening:'//trim(params%joint_names(2)))) cycle
        if (index(p%name, 'root_') == 1) cycle ! a clamp has its own tests in test_instrument
        if (index(p%name, 'one_way:') == 1) then ! some joints bend down
          if (.not. maxval(abs(d(:, :, i))) > 0 .or. n_up >= 3) cycle
          n_up = n_up + 1
        end if
        call differ(i, p, u, difference)
        call t%check('it depends on '//p%name, maxval(abs(d(:, :, i))) > 0)
        call t%check_below('derivative to '//p%name//' '//where, maxval(abs(difference - d(:, :, i)))/ &
                           max(maxval(abs(d(:, :, i))), 1.0e-8_rp/p%prior_sd), LIMIT)
      end do
      call t%check('some joints bend up', n_up > 0)
    end do
    call work%free()
  end subroutine check_all

  !> A wing with joints that are 1.4 times as stiff upward is, turned upside down, one with joints that are 1.4 times as
  !> stiff and 1/1.4 times that upward: but for the little that joints bend within the wing, which has no sides.
  subroutine check_mirror()
    real(rp), parameter :: RATIO = 1.4_rp
    type(solid_params_t) :: params
    type(failure_t) :: failure
    type(static_report_t) :: report
    real(rp), allocatable :: u(:, :, :)
    integer :: side
    params = default_params(wing)
    params%effects%has_sides = .true.
    do side = 1, 3
      params%joint = merge(RATIO, 1.0_rp, side == 2)*1.0e-6_rp
      call set_each(params, 'one_way:', spread(merge(1/RATIO, RATIO, side == 2), 1, size(params%joint)))
      call model%init(wing, params, failure)
      if (side == 1) allocate (u(3, model%n_all, 3), source=0.0_rp)
      call work%init(model)
      call load_at(model, PLACES(1), merge(1, -1, side == 1)*FORCES(1), load)
      call solve_static(work, model, load, .false., options, u(:, :, side), report)
      call t%check('the shape is found', report%converged .and. report%snaps == 0)
      call work%free()
      if (side > 1) u(3, :, side) = -u(3, :, side)
    end do
    call t%check_below('upside down it is the same, against the other side of the joints', &
                       maxval(abs(u(:, :, 1) - u(:, :, 2)))/maxval(abs(u(:, :, 1) - u(:, :, 3))), 1.0e-3_rp)
  end subroutine check_mirror

  !> A central difference of the fourth order.
  subroutine differ(i, p, u, difference)
    integer, intent(in) :: i
    type(parameter_t), intent(in) :: p
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(out) :: difference(:, :)
    real(rp), dimension(3, size(u, 2)) :: ahead, behind
    real(rp) :: value, step
    integer :: s
    value = model%params%get(i)
    step = 2.0e-3_rp*p%prior_sd
    if (p%name == 'torsion') step = step/8 ! beside the membrane alone a hundredth of a vein's stiffness counts
    difference = 0
    do s = 1, 2
      call shape_with(i, moved(value, s*step, p%is_log), u, ahead)
      call shape_with(i, moved(value, -s*step, p%is_log), u, behind)
      difference = difference + merge(4, -1, s == 1)*(ahead - behind)/(2*s*step*3)
    end do
    call set_parameter(model, i, value)
  end subroutine differ

  pure real(rp) function moved(value, by, is_log)
    real(rp), intent(in) :: value, by
    logical, intent(in) :: is_log
    moved = value + by
    if (is_log) moved = value*exp(by)
  end function moved

  subroutine shape_with(i, value, u, shape)
    integer, intent(in) :: i
    real(rp), intent(in) :: value, u(:, :)
    real(rp), intent(out) :: shape(:, :)
    type(static_report_t) :: report
    call set_parameter(model, i, value)
    shape = u
    call solve_static(work, model, load, .true., options, shape, report)
    if (.not. report%converged .or. report%was_redone_cold) call t%check('a neighbour is on the same path', .false.)
  end subroutine shape_with

  !> Damage where the model has none, and another force, against differences.
  subroutine check_scan(where, u)
    character(*), intent(in) :: where
    real(rp), intent(in) :: u(:, :)
    real(rp), parameter :: elsewhere(3) = [6.5e-3_rp, 0.0_rp, 0.9e-3_rp]
    type(stiffness_t) :: direction
    type(solid_params_t) :: params
    type(static_report_t) :: report
    real(rp), dimension(3, size(u, 2)) :: derivative, pushed, shape, difference
    real(rp) :: kept(3)
    integer :: i, s
    params = model%params
    call force_sensitivity(work, model, load%force, pushed)
    call damage_direction(model, elsewhere, direction)
    call direction_sensitivity(work, model, u, direction, derivative)
    if (.not. abs(value_of(params, 'damage') - 1) > 0) then
      kept = params%effects%disc
      i = params%find('damage')
      model%params%effects%disc = elsewhere
      call differ(i, params%describe(i), u, difference)
      model%params%effects%disc = kept
      call set_parameter(model, i, 1.0_rp)
      call t%check_below('derivative to damage elsewhere '//where, maxval(abs(difference - derivative))/ &
                         maxval(abs(derivative)), LIMIT)
    end if
    difference = 0
    do s = -1, 1, 2
      load%force = load%force*(1 + s*1.0e-3_rp)
      shape = u
      call solve_static(work, model, load, .true., options, shape, report)
      load%force = load%force/(1 + s*1.0e-3_rp)
      difference = difference + s*shape/2.0e-3_rp
    end do
    call t%check_below('derivative to the force '//where, maxval(abs(difference - pushed))/maxval(abs(pushed)), &
                       1.0e-5_rp)
    ! the factorisation of this shape again
    shape = u
    call solve_static(work, model, load, .true., options, shape, report)
  end subroutine check_scan
end program test_effect_sensitivities
