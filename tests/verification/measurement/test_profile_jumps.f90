! SPDX-License-Identifier: GPL-3.0-or-later
!> Intervals beside a jump: the wing in the file that the first argument names has a load under which the end of its
!> loading path jumps to another shape as E passes some value. The truth lies so close to that value that the interval
!> of E from all loads would reach beyond it. What has to come out is what the other loads say. All shapes are solved cold:
!> warm ones may stay on the branch on which they began, which then has no jump.
program test_profile_jumps
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use least_squares_posterior, only: find_posterior, posterior_t
  use least_squares_problem, only: unknowns_t
  use least_squares_profile, only: interval_t, linear_guess_t, profile_interval, THRESHOLD_90
  use loaded_wing, only: wing_of_argument
  use measurement_data, only: measurement_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use measurement_problem, only: wing_point_t, wing_problem_t, wing_unknowns
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N_LOADS = 3, NX = 30, NY = 15, N = 3, JUMPING = 1
  real(rp), parameter :: SIGMA = 1.0e-5_rp !< [m]
  !> x [m], y [m], force [N]; the first is the one that jumps.
  real(rp), parameter :: LOADS(3, N_LOADS) = reshape([0.00721_rp, -0.00032_rp, 5.5e-4_rp, &
                                                      0.00496_rp, -0.00228_rp, 1.6e-4_rp, &
                                                      0.00541_rp, 0.00005_rp, 3.8e-3_rp], [3, N_LOADS])
  real(rp), parameter :: YOUNG(2) = [8.4e9_rp, 8.45e9_rp] !< [Pa] the jump lies between
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_params_t) :: params
  type(measurement_t) :: m
  type(experiment_t), target :: experiment
  real(rp) :: truth(N), sides(2), jump

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  call lay_out()
  call find_jump()
  call check_intervals()
  call t%finish()

contains

  !> A flat measurement of a flat wing; unknowns are E and two joints.
  subroutine lay_out()
    type(static_options_t) :: options
    type(failure_t) :: failure
    integer :: i, j, l, numbers(N)
    params = default_params(wing)
    do i = 1, size(params%joint_names)
      call params%set(params%find('joint:'//trim(params%joint_names(i))), 1.0e-4_rp)
    end do
    numbers = [params%find('E'), params%find('joint:R4+5_base'), params%find('joint:R1_Rs')]
    call params%set(numbers(1), YOUNG(1))
    call params%set(numbers(2), 3.0e-5_rp)
    call params%set(numbers(3), 2.0e-4_rp)
    m%x = [(minval(wing%points(1, :)) + (i - 0.37_rp)*1.02_rp*span(1)/NX, i=1, NX)]
    m%y = [(minval(wing%points(2, :)) + (j - 0.41_rp)*1.02_rp*span(2)/NY, j=1, NY)]
    allocate (m%unloaded(NX, NY), m%unloaded_sigma(NX, NY), source=0.0_rp)
    allocate (m%has_unloaded(NX, NY), source=.true.)
    allocate (m%loads(N_LOADS), m%observations(0), m%zeros(0))
    m%accuracy%height = SIGMA
    do l = 1, N_LOADS
      associate (load => m%loads(l))
        load%name = 'load_'//achar(iachar('0') + l)
        load%force = LOADS(3, l)
        load%direction = [0.0_rp, 0.0_rp, 1.0_rp]
        load%point = LOADS(:2, l)
        load%has_surface = .true.
        load%node = reshape([((i, j, i=1, NX), j=1, NY)], [2, NX*NY])
        allocate (load%height(NX*NY), source=0.0_rp)
        allocate (load%sigma(NX*NY), source=SIGMA)
      end associate
    end do
    options%tolerance = 1.0e-8_rp
    call experiment%init(m, wing, params, numbers, options, failure)
    call t%check('the experiment is made',.not. failure%failed)
    truth = experiment%start()
  end subroutine lay_out

  pure real(rp) function span(direction)
    integer, intent(in) :: direction
    span = maxval(wing%points(direction, :)) - minval(wing%points(direction, :))
  end function span

  !> Deformations [m] under load l, solved cold.
  function deformations(l, coordinates) result(heights)
    integer, intent(in) :: l
    real(rp), intent(in) :: coordinates(N)
    real(rp), allocatable :: heights(:)
    type(evaluation_t) :: evaluation
    type(evaluation_work_t) :: work
    real(rp), allocatable :: u(:, :)
    call work%init(experiment)
    call evaluation%init(experiment, l, .false.)
    allocate (u(3, experiment%model%n_all), source=0.0_rp)
    call evaluate(experiment, work, coordinates, l, .false., u, evaluation)
    call t%check('a shape is found', evaluation%is_feasible())
    heights = evaluation%residuals + experiment%comparisons(l)%measured
    call work%free()
  end function deformations

  !> `sides`: values of ln E beside the jump that differ by 1e-5; `jump`: the jump of the deformations there in units of
  !> SIGMA. What lies between them is halved so that the larger change stays inside.
  subroutine find_jump()
    real(rp), allocatable :: low(:), high(:), middle(:)
    real(rp) :: between
    sides = log(YOUNG)
    low = deformations(JUMPING, [sides(1), truth(2:)])
    high = deformations(JUMPING, [sides(2), truth(2:)])
    do while (sides(2) - sides(1) > 1.0e-5_rp)
      between = sum(sides)/2
      middle = deformations(JUMPING, [between, truth(2:)])
      if (norm2(middle - low) > norm2(high - middle)) then
        sides(2) = between
        high = middle
      else
        sides(1) = between
        low = middle
      end if
    end do
    jump = norm2(high - low)/SIGMA
    call t%check('the shape jumps, by more than the threshold of an interval', jump > sqrt(THRESHOLD_90))
  end subroutine find_jump

  !> The profile of E about the truth passes the jump, which is at a third of the sd from all loads. Nothing has noise.
  !> An interval has to be that of the loads it is from, in a fit that has only these; for E the profile is a parabola,
  !> and its width known from the covariance. The search of an end stops within 1 % of the threshold's root.
  subroutine check_intervals()
    real(rp), parameter :: ACCURACY = 0.03_rp
    type(wing_problem_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: at_truth
    type(posterior_t) :: all_loads, others
    type(interval_t) :: interval, reference
    type(parameter_t) :: parameter
    character(:), allocatable :: name
    real(rp) :: along(N), edge(N)
    logical :: is_without
    integer :: i, l
    truth(1) = sum(sides)/2
    call problem%init(experiment)
    problem%is_cold = .true.
    unknowns = wing_unknowns(experiment, truth, 1.0_rp)
    call evaluate_at_truth(problem, unknowns, .false., at_truth, all_loads)
    along = all_loads%covariance(:, 1)/all_loads%covariance(1, 1)
    edge = truth
    truth = edge + along*all_loads%sd(1)/3
    do l = 1, N_LOADS
      experiment%comparisons(l)%measured = deformations(l, truth)
    end do
    jump = norm2(deformations(JUMPING, edge + 0.03_rp*(truth - edge)) - &
                 deformations(JUMPING, edge - 0.03_rp*(truth - edge)))/SIGMA
    call t%check('the profile crosses the jump', jump > 2*sqrt(THRESHOLD_90))
    call evaluate_at_truth(problem, unknowns, .true., at_truth, others)
    do i = 1, 2
      parameter = experiment%describe(i)
      name = trim(parameter%name)
      call evaluate_at_truth(problem, unknowns, .false., at_truth, all_loads)
      call profile_interval(problem, unknowns, at_truth, i, linear_guess_t(all_loads%sd(i)), THRESHOLD_90, options, interval)
      call t%check(name//': the interval has two ends, none of them a jump', interval%is_complete .and. &
                   interval%has_lower .and. interval%has_upper .and. .not. any(interval%is_jump))
      call t%check('  it holds the truth', interval%lower < truth(i) .and. interval%upper > truth(i))
      call t%check('  no other load is left out',.not. any(interval%is_left_out(JUMPING + 1:)))
      is_without = interval%is_left_out(JUMPING)
      if (i == 1) then
        call t%check('  the load that jumps is left out', is_without)
        call t%check('  it reaches beyond the jump', interval%lower < edge(1))
        call t%check_close('  it is as wide as the covariance of the other loads', interval%upper - interval%lower, &
                           2*sqrt(THRESHOLD_90)*others%sd(1), rtol=ACCURACY)
        call t%check('  it is wider for that', others%sd(1) > (1 + 2*ACCURACY)*all_loads%sd(1))
      end if
      call evaluate_at_truth(problem, unknowns, is_without, at_truth, others)
      problem%is_cold = .false.
      call profile_interval(problem, unknowns, at_truth, i, linear_guess_t(others%sd(i)), THRESHOLD_90, options, reference)
      problem%is_cold = .true.
      call t%check_close('  the loads that count say the same alone: the lower end', interval%lower - truth(i), &
                         reference%lower - truth(i), rtol=ACCURACY)
      call t%check_close('  and the upper', interval%upper - truth(i), reference%upper - truth(i), rtol=ACCURACY)
    end do
    call problem%free()
  end subroutine check_intervals

  !> A fit at the truth, where nothing can be fitted better, and its covariances, with or without the load that jumps.
  subroutine evaluate_at_truth(problem, unknowns, is_without, report, posterior)
    type(wing_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    logical, intent(in) :: is_without
    type(fit_report_t), intent(out) :: report
    type(posterior_t), intent(out) :: posterior
    type(fit_options_t) :: options
    type(wing_point_t) :: rest
    options%reduction_tolerance = 1.0e-4_rp
    rest = problem%initial_state()
    rest%is_left_out(JUMPING) = is_without
    call fit(problem, unknowns, truth, rest, options, report)
    posterior = find_posterior(unknowns, report)
  end subroutine evaluate_at_truth
end program test_profile_jumps
