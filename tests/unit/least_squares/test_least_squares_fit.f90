! SPDX-License-Identifier: GPL-3.0-or-later
!> Levenberg-Marquardt, covariances and profile intervals on problems whose answers are known: linear ones in
!> closed form, and Misra1a and MGH09 of NIST's Statistical Reference Datasets with certified values.
program test_least_squares_fit
  use base_kinds, only: rp
  use curve_problems, only: compliance_t, linear_t, mgh09_t, misra1a_t
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use least_squares_posterior, only: find_posterior, posterior_t
  use least_squares_problem, only: least_squares_t, unknowns_t
  use least_squares_profile, only: interval_t, linear_guess_t, profile_interval, profile_sentence, THRESHOLD_90
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: M = 30, N = 4
  real(rp), parameter :: ROUND_OFF = 1.0e-11_rp, LARGEST_COSINE = 1.0e-6_rp
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call solve_linear()
  call solve_bounded()
  call weigh_prior()
  call reproduce_certified()
  call find_exact_intervals()
  call find_one_sided()
  call avoid_invalid()
  call t%finish()

contains

  function some_linear() result(problem)
    type(linear_t) :: problem
    integer :: i, k
    allocate (problem%a(M, N), problem%b(M))
    do i = 1, M
      problem%b(i) = cos(0.7_rp*i) + 0.1_rp*i
      do k = 1, N
        problem%a(i, k) = sin(real(i*k, rp)) + 0.3_rp*i/k
      end do
    end do
    problem%n_residuals = M
  end function some_linear

  !> An undamped step is exact, and the residuals are then orthogonal to the columns.
  subroutine solve_linear()
    type(linear_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    problem = some_linear()
    call unknowns%init(N)
    options%damping = 0
    options%largest_step = 1.0e6_rp
    call fit(problem, unknowns, [1.0_rp, -2.0_rp, 3.0_rp, 5.0_rp], solver_state_t(), options, report)
    call t%check('a linear problem is solved in one step', report%is_converged .and. report%n_evaluations == 2 &
                 .and. report%n_accepted == 1)
    call t%check_below('its residuals are orthogonal to the columns', &
                       maxval(abs(matmul(report%residuals, problem%a))), ROUND_OFF)
    options%damping = 1.0e-3_rp
    call fit(problem, unknowns, [1.0_rp, -2.0_rp, 3.0_rp, 5.0_rp], solver_state_t(), options, report)
    call t%check('and in a few damped steps', report%is_converged .and. report%n_evaluations <= 12)
    call t%check_below('with the same result', maxval(cosines(problem, report)), LARGEST_COSINE)
  end subroutine solve_linear

  !> Cosines of the angles between the residuals and the columns; their squares are the relative reductions of
  !> the sum of squares that are left, of which steps leave 1e-12.
  function cosines(problem, report) result(values)
    type(linear_t), intent(in) :: problem
    type(fit_report_t), intent(in) :: report
    real(rp) :: values(N)
    values = abs(matmul(report%residuals, problem%a))/norm2(report%residuals)/norm2(problem%a, 1)
  end function cosines

  !> At the constrained optimum the free slopes vanish and the others point out of the box.
  subroutine solve_bounded()
    type(linear_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: free, report
    real(rp) :: slope(N)
    problem = some_linear()
    call unknowns%init(N)
    options%largest_step = 1.0e6_rp
    call fit(problem, unknowns, spread(0.0_rp, 1, N), solver_state_t(), options, free)
    unknowns%upper(2) = free%p(2) - 0.5_rp
    unknowns%lower(3) = free%p(3) + 0.1_rp
    call fit(problem, unknowns, spread(10.0_rp, 1, N), solver_state_t(), options, report)
    slope = matmul(report%residuals, problem%a)
    call t%check('a bounded problem ends inside the box', report%is_converged .and. &
                 all(report%p <= unknowns%upper) .and. all(report%p >= unknowns%lower))
    call t%check('the active bounds are named', report%is_at_bound(2) .and. .not. report%is_at_bound(1))
    call t%check_below('the slope of the free unknowns vanishes', &
                       maxval(cosines(problem, report), mask=.not. report%is_at_bound), LARGEST_COSINE)
    unknowns%lower(1) = report%p(1) - 1
    unknowns%upper(4) = report%p(4) + 1
    call fit(problem, unknowns, [unknowns%lower(1), 0.0_rp, 0.0_rp, unknowns%upper(4)], solver_state_t(), options, free)
    call t%check_below('a start on other bounds leaves them', norm2(free%p - report%p), 1.0e-5_rp)
    call t%check('the others are pushed outward', slope(2) < 0 .and. (slope(3) > 0 .or. .not. report%is_at_bound(3)))
  end subroutine solve_bounded

  !> (a x - b)^2 + ((x - c)/s)^2 is least at (a b + c/s^2)/(a^2 + 1/s^2).
  subroutine weigh_prior()
    real(rp), parameter :: A = 2.0_rp, B = 3.0_rp, C = -1.0_rp, S = 0.7_rp
    type(linear_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    type(posterior_t) :: posterior
    allocate (problem%a(1, 1), problem%b(1))
    problem%n_residuals = 1
    problem%a = A
    problem%b = B
    call unknowns%init(1)
    unknowns%prior = C
    unknowns%prior_sd = S
    options%damping = 0
    call fit(problem, unknowns, [0.0_rp], solver_state_t(), options, report)
    call t%check_close('a prior counts as a residual', report%p(1), (A*B + C/S**2)/(A**2 + 1/S**2), ROUND_OFF)
    call t%check_close('and is reported apart', report%prior_chi2, ((report%p(1) - C)/S)**2, ROUND_OFF)
    posterior = find_posterior(unknowns, report)
    call t%check_close('the sd counts it', posterior%sd(1), 1/sqrt(A**2 + 1/S**2), ROUND_OFF)
    call t%check_close('singular values do not', posterior%singular_values(1), A, ROUND_OFF)
  end subroutine weigh_prior

  !> Certified values have 11 digits. Parameters are found to about the root of the relative error of the sum of squares
  !> in one step of Gauss and Newton, here below 1e-9; their sd to the same relative error.
  subroutine reproduce_certified()
    type(misra1a_t) :: misra1a
    type(mgh09_t) :: mgh09
    call misra1a%init()
    call mgh09%init()
    call certify('Misra1a', misra1a, [500.0_rp, 0.0001_rp], [2.3894212918e2_rp, 5.5015643181e-4_rp], &
                 [2.7070075241e0_rp, 7.2668688436e-6_rp], 1.2455138894e-1_rp)
    call certify('Misra1a from nearby', misra1a, [250.0_rp, 0.0005_rp], [2.3894212918e2_rp, 5.5015643181e-4_rp], &
                 [2.7070075241e0_rp, 7.2668688436e-6_rp], 1.2455138894e-1_rp)
    call certify('MGH09', mgh09, [25.0_rp, 39.0_rp, 41.5_rp, 39.0_rp], &
                 [1.9280693458e-1_rp, 1.9128232873e-1_rp, 1.2305650693e-1_rp, 1.3606233068e-1_rp], &
                 [1.1435312227e-2_rp, 1.9633220911e-1_rp, 8.0842031232e-2_rp, 9.0025542308e-2_rp], 3.0750560385e-4_rp)
    call certify('MGH09 from nearby', mgh09, [0.25_rp, 0.39_rp, 0.415_rp, 0.39_rp], &
                 [1.9280693458e-1_rp, 1.9128232873e-1_rp, 1.2305650693e-1_rp, 1.3606233068e-1_rp], &
                 [1.1435312227e-2_rp, 1.9633220911e-1_rp, 8.0842031232e-2_rp, 9.0025542308e-2_rp], 3.0750560385e-4_rp)
  end subroutine reproduce_certified

  subroutine certify(name, problem, start, p, sd, squares)
    character(*), intent(in) :: name
    class(least_squares_t), intent(inout) :: problem
    real(rp), intent(in) :: start(:), p(:), sd(:), squares
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    type(posterior_t) :: posterior
    real(rp) :: variance
    call unknowns%init(size(p))
    options%largest_step = 1.0e6_rp
    options%reduction_tolerance = 1.0e-20_rp
    options%step_tolerance = 1.0e-13_rp
    options%most_iterations = 2000
    call fit(problem, unknowns, start, solver_state_t(), options, report)
    variance = report%chi2/(size(report%residuals) - size(p))
    posterior = find_posterior(unknowns, report)
    call t%check(name//' converges: '//report%reason, report%is_converged)
    call t%check_close(name//': sum of squares', report%chi2, squares, rtol=1.0e-10_rp)
    call t%check_below(name//': parameters', maxval(abs(report%p/p - 1)), 1.0e-8_rp)
    call t%check_below(name//': standard deviations', maxval(abs(posterior%sd*sqrt(variance)/sd - 1)), 1.0e-6_rp)
  end subroutine certify

  !> For linear problems the profile is a parabola, and the interval p +- sqrt(threshold) sd, whatever the guess of sd.
  subroutine find_exact_intervals()
    type(linear_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    type(posterior_t) :: posterior
    type(interval_t) :: interval
    real(rp), parameter :: GUESSES(3) = [1.0_rp, 0.2_rp, 7.0_rp]
    real(rp) :: worst
    integer :: i, g, most
    problem = some_linear()
    call unknowns%init(N)
    options%largest_step = 1.0e6_rp
    options%damping = 0
    call fit(problem, unknowns, spread(0.0_rp, 1, N), solver_state_t(), options, report)
    posterior = find_posterior(unknowns, report)
    worst = 0
    most = 0
    do g = 1, 3
      do i = 1, N
        call profile_interval(problem, unknowns, report, i, linear_guess_t(GUESSES(g)*posterior%sd(i)), THRESHOLD_90, options, &
                              interval)
        if (.not. (interval%has_lower .and. interval%has_upper .and. interval%is_complete)) worst = huge(worst)
        worst = max(worst, abs(interval%upper - report%p(i) - sqrt(THRESHOLD_90)*posterior%sd(i))/posterior%sd(i), &
                    abs(interval%lower - report%p(i) + sqrt(THRESHOLD_90)*posterior%sd(i))/posterior%sd(i))
        most = max(most, interval%n_refits)
      end do
    end do
    call t%check_below('intervals of linear problems are exact', worst, 1.0e-7_rp)
    call t%check('in at most three refits for each side and one for the minimum', most <= 7)
  end subroutine find_exact_intervals

  !> y = exp(-q): a spring in series, of which only the compliance shows. It was measured as COMPLIANCE +- NOISE.
  subroutine find_one_sided()
    real(rp), parameter :: NOISE = 1.0e-3_rp, LOWER = -5, UPPER = 12
    type(compliance_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    type(posterior_t) :: posterior
    type(interval_t) :: interval
    character(:), allocatable :: sentence
    real(rp) :: end
    integer :: i
    real(rp), parameter :: MEASURED(3) = [0.0_rp, 0.1_rp, 0.0_rp], SCATTER(3) = [NOISE, NOISE, 1.0e4_rp]
    call unknowns%init(1)
    unknowns%lower = LOWER
    unknowns%upper = UPPER
    unknowns%prior_sd = 2.3_rp
    problem%n_residuals = 1
    do i = 1, 3
      problem%measured = MEASURED(i)
      problem%noise = SCATTER(i)
      call fit(problem, unknowns, [1.0_rp], solver_state_t(), options, report)
      posterior = find_posterior(unknowns, report)
      call profile_interval(problem, unknowns, report, 1, linear_guess_t(posterior%sd(1)), THRESHOLD_90, options, interval)
      sentence = profile_sentence('joint:7', 'N m/rad', .true., interval)
      call t%check('the search is complete', interval%is_complete)
      select case (i)
      case (1)
        end = -log(sqrt(NOISE**2*THRESHOLD_90 + exp(-2*UPPER)))
        call t%check('a stiff spring has a lower end only', interval%has_lower .and. .not. interval%has_upper)
        call t%check_close('  which is where it should be', interval%lower, end, atol=0.02_rp)
        call t%check('  and the sentence says so: '//sentence, &
                     index(sentence, 'joint:7: these data give a lower limit only: > 6.08') == 1 &
                     .and. index(sentence, 'E+02 N m/rad') > 0)
      case (2)
        call t%check('a soft spring has two ends', interval%has_lower .and. interval%has_upper)
        call t%check_close('  the lower', interval%lower, -log(0.1_rp + NOISE*sqrt(THRESHOLD_90)), atol=1.0e-3_rp)
        call t%check_close('  the upper', interval%upper, -log(0.1_rp - NOISE*sqrt(THRESHOLD_90)), atol=1.0e-3_rp)
        call t%check('  '//sentence, index(sentence, 'joint:7: 1.0000E+01 N m/rad, with 90 % confidence between') == 1)
      case default
        call t%check('noise leaves no end',.not. interval%has_lower .and. .not. interval%has_upper)
        call t%check('  '//sentence, index(sentence, 'not determined by these data; every value from') > 0)
        interval%is_complete = .false.
        call t%check('a search that broke off without an end says no number', &
                     scan(profile_sentence('joint', 'N m/rad', .true., interval), '0123456789') == 0)
      end select
    end do
  end subroutine find_one_sided

  !> Steps into a region without residuals are rejected; an interval ends there.
  subroutine avoid_invalid()
    type(compliance_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    type(interval_t) :: interval
    problem%n_residuals = 1
    problem%measured = exp(-1.0_rp)
    problem%noise = 1
    problem%valid_below = 1.2_rp
    call unknowns%init(1)
    unknowns%lower = -8
    unknowns%upper = 8
    call fit(problem, unknowns, [-3.0_rp], solver_state_t(), options, report)
    call t%check_close('the fit goes around it', report%p(1), 1.0_rp, atol=1.0e-6_rp)
    call profile_interval(problem, unknowns, report, 1, linear_guess_t(3.0_rp), THRESHOLD_90, options, interval)
    call t%check('the interval ends there', interval%has_upper .and. interval%is_complete)
    call t%check_close('  at its edge', interval%upper, 1.2_rp, atol=1.0e-3_rp)
    problem%valid_below = 0.9_rp
    call fit(problem, unknowns, [-3.0_rp], solver_state_t(), options, report)
    call t%check('the fit stays in front of it: '//report%reason, report%p(1) > 0.89_rp .and. report%p(1) < 0.9_rp)
    call fit(problem, unknowns, [2.0_rp], solver_state_t(), options, report)
    call t%check('an invalid start is a failure, not a result',.not. report%is_converged)
  end subroutine avoid_invalid
end program test_least_squares_fit
