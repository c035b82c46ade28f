! SPDX-License-Identifier: GPL-3.0-or-later
!> Misfits that no test of the catalogue sees must not vanish into the size of the noise: errors of scans that are larger than
!> declared, and more variance than the scatter of pixels has, on a wing in closed form (diagnosis_beam).
!>
!> Random numbers are fixed; bounds are those that a correct program violates with a probability below 2e-3 for a random seed.
program test_fit_checks
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_beam, only: beam_t, make_beam, N_BASE
  use inference_declared_errors, only: SIZE_WORDS
  use inference_residual_checks, only: combined_log_p, most_significant, residual_check_t
  use inference_fit_checks, only: check_fit
  use inference_decision, only: LEVEL, TESTS_FRACTION, VERDICT_ADEQUATE, VERDICT_UNKNOWN
  use inference_design, only: build_design, design_t
  use inference_engine, only: diagnosis_options_t, diagnosis_t, run_diagnosis
  use inference_refit, only: fit_nested, nested_fit_t
  use least_squares_fit, only: fit_options_t
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: SCATTER = 3000 !< degrees of freedom
  real(rp), parameter :: TILT_SD = 0.002_rp, RATIO = 3.3_rp
  type(testkit_t) :: test
  type(beam_t), target :: beam
  type(design_t) :: design
  class(solver_state_t), allocatable :: state
  type(failure_t) :: failure
  real(rp), allocatable :: q0(:)

  call test%start(parallel=.false.)
  call make_beam(beam)
  q0 = beam%null_point()
  beam%tilt_sd = TILT_SD
  beam%gain_sd = 0.05_rp
  beam%n_nuisances = beam%n_nuisances + 1
  call beam%observe(q0, beam%sigma, 1)
  allocate (state)
  call build_design(beam, q0, state, 1.0_rp, design, failure)
  call test_nulls()
  call test_tilts()
  call test_variance()
  call test_verdict()
  call test%finish()

contains

  !> Questions to data with tilts of `tilts` and noise of `noise` times the declared size.
  subroutine ask(tilts, noise, seed, freedom, checks)
    real(rp), intent(in) :: tilts, noise
    integer, intent(in) :: seed, freedom
    type(residual_check_t), allocatable, intent(out) :: checks(:)
    type(nested_fit_t) :: found
    type(fit_options_t) :: options
    integer :: i
    beam%tilt_sd = tilts*TILT_SD
    call beam%observe(q0, noise*beam%sigma, seed)
    beam%tilt_sd = TILT_SD
    call fit_nested(beam, design%whitener, [(i, i=1, N_BASE)], q0, solver_state_t(), options, found)
    call check_fit(beam, design, found, 1.0_rp, freedom, checks)
  end subroutine ask

  !> The question about tilts.
  integer function size_at(checks) result(at)
    type(residual_check_t), intent(in) :: checks(:)
    do at = 1, size(checks)
      if (index(checks(at)%name, SIZE_WORDS) == 1) return
    end do
  end function size_at

  !> All questions together alarm in at most 1 % of nulls: more than 5 of 120 have a probability of 1.5e-3. Statistics of slopes are
  !> standard normal numbers: the mean of n squares is within 4 sqrt(2/n) of 1 but for a probability of 1e-4. Questions of one null
  !> share the response, so that n is the number of nulls.
  subroutine test_nulls()
    type(residual_check_t), allocatable :: checks(:)
    real(rp) :: squares
    integer :: s, alarms, i, n
    integer, parameter :: NULLS = 120
    alarms = 0
    squares = 0
    n = 0
    do s = 1, NULLS
      call ask(1.0_rp, 1.0_rp, 1000 + s, SCATTER, checks)
      if (combined_log_p(checks) < log(0.01_rp)) alarms = alarms + 1
      do i = 1, size(checks)
        if (all(checks(i)%name /= ['level', 'sign ', 'order'])) cycle
        squares = squares + checks(i)%statistic**2
        n = n + 1
      end do
    end do
    call test%check('slopes are asked', n >= NULLS)
    call test%check_close('slopes of residuals are standard normal', squares/n, 1.0_rp, atol=4*sqrt(2.0_rp/NULLS))
    call test%check('questions to residuals alarm in 1 % of the nulls', alarms <= 5)
  end subroutine test_nulls

  !> Tilts of 3.3 times their declared sd are seen and measured; sd that are stated a quarter too small are no alarm.
  subroutine test_tilts()
    type(residual_check_t), allocatable :: checks(:)
    integer :: s, seen, inside, alarms
    seen = 0
    inside = 0
    alarms = 0
    do s = 1, 25
      call ask(RATIO, 1.0_rp, 2000 + s, SCATTER, checks)
      associate (one => checks(size_at(checks)))
        if (one%log_p < log(1.0e-6_rp) .and. size_at(checks) == most_significant(checks)) seen = seen + 1
        if (one%interval(1) < RATIO .and. RATIO < one%interval(2)) inside = inside + 1
      end associate
      call ask(1.25_rp, 1.0_rp, 3000 + s, SCATTER, checks)
      if (checks(size_at(checks))%log_p < log(0.01_rp)) alarms = alarms + 1
    end do
    call test%check('tilts that are larger than declared are the most_significant question', seen >= 24)
    call test%check('and 90 % intervals hold their size', inside >= 18)
    call test%check('sd that are a little wrong are no alarm', alarms <= 2)
  end subroutine test_tilts

  !> 1.2 times the scatter of pixels is more than white noise; where nothing tells the scatter, the declared errors hold.
  subroutine test_variance()
    type(residual_check_t), allocatable :: checks(:)
    call ask(1.0_rp, 1.2_rp, 1, SCATTER, checks)
    call test%check('variance beyond that of neighbouring pixels is an alarm', &
                    checks(1)%name == 'chi2' .and. checks(1)%log_p < log(1.0e-6_rp) .and. checks(1)%takes_part)
    call ask(1.0_rp, 1.2_rp, 1, huge(1), checks)
    call test%check('without pixels variance beyond that of the declared errors is an alarm', &
                    checks(1)%log_p < log(1.0e-6_rp) .and. checks(1)%takes_part)
    call test%check('which says how much larger the errors are', index(checks(1)%sentence, '1.2 times as large as') > 0)
    call ask(1.0_rp, 0.8_rp, 1, SCATTER, checks)
    call test%check('less variance than declared is no misfit',.not. checks(1)%takes_part)
  end subroutine test_variance

  !> The verdict honours what the checks say.
  subroutine test_verdict()
    type(diagnosis_t), target :: d
    type(diagnosis_options_t) :: options
    integer :: s, adequate, by_checks
    options%n_draws = 200
    options%validates = .false.
    options%finds_intervals = .false.
    options%most_refits = 1
    options%noise_dof = SCATTER
    adequate = 0
    by_checks = 0
    do s = 1, 4
      beam%tilt_sd = RATIO*TILT_SD
      call beam%observe(q0, beam%sigma, 4000 + s)
      beam%tilt_sd = TILT_SD
      call run_diagnosis(beam, reshape(q0, [size(q0), 1]), options, d, failure)
      if (d%decision%verdict == VERDICT_ADEQUATE) adequate = adequate + 1
      if (d%decision%is_rejected_by_checks .and. d%decision%verdict == VERDICT_UNKNOWN .and. &
          d%decision%probability > 0.99_rp) by_checks = by_checks + 1
      call test%check('the global p is no larger than that of the checks', &
                      d%decision%log_p_global <= combined_log_p(d%tests%checks) - log(1 - TESTS_FRACTION) + 1.0e-9_rp)
    end do
    call test%check('tilts that are larger than declared are not adequate', adequate == 0)
    call test%check('where no test sees them the cause is unknown, and certainly there', by_checks > 0)
    beam%tilt_sd = TILT_SD
    call beam%observe(q0, beam%sigma, 1)
    call run_diagnosis(beam, reshape(q0, [size(q0), 1]), options, d, failure)
    call test%check('chance is adequate', d%decision%verdict == VERDICT_ADEQUATE .and. d%decision%log_p_global > log(LEVEL))
  end subroutine test_verdict
end program test_fit_checks
