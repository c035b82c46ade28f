! SPDX-License-Identifier: GPL-3.0-or-later
!> The statistics of the diagnosis on a wing in closed form (diagnosis_beam): size, power, names, aliases, unknown
!> causes.
!>
!> Random numbers are fixed, so the counts are always the same; bounds are those that a correct program violates with a
!> probability below 1e-3 for a random seed (binomial distribution), or the targets of docs/results/diagnosis-results.md.
program test_engine
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use diagnosis_beam, only: beam_t, make_beam, E_DRIFT, E_GAIN, E_HARD, E_MEMBRANE, E_OFFSET, E_ONE_WAY, E_ROOT, E_SCALE, &
                            E_SOFT, E_SPAN, E_TORSION, N_BASE, P_DRIFT, P_GAIN, P_HARD, P_OFFSET, P_ONE_WAY, P_ROOT, P_SOFT, &
                            P_SPAN, P_TORSION
  use inference_fit_checks, only: check_fit
  use inference_residual_checks, only: residual_check_t
  use inference_calibration, only: calibration_t, find_statistics, statistics_t
  use inference_decision, only: decide, decision_t, probability_of_set, AT_BOUND, VERDICT_ADEQUATE, VERDICT_NAMED, VERDICT_SET, &
                                VERDICT_UNKNOWN
  use inference_design, only: build_design, design_t
  use inference_engine, only: diagnosis_options_t, diagnosis_t, run_diagnosis
  use inference_hypotheses, only: hypotheses_t
  use inference_record, only: LARGEST_SCALE
  use inference_residual_checks, only: check_residuals, residual_check_t
  use inference_simulator, only: variant_t
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N_EFFECTS = 12, BATCH = 20
  integer, parameter :: SHOWN(7) = [E_DRIFT, E_ONE_WAY, E_HARD, E_OFFSET, E_SPAN, E_TORSION, E_ROOT]
  integer, parameter :: COLUMNS(7) = [P_DRIFT, P_ONE_WAY, P_HARD, P_OFFSET, P_SPAN, P_TORSION, P_ROOT]
  type(testkit_t) :: test
  type(beam_t), target :: beam
  type(design_t) :: design
  class(solver_state_t), allocatable :: state
  type(calibration_t) :: believing, estimating
  type(failure_t) :: failure
  real(rp), allocatable :: q0(:)
  integer :: incoherent = 0

  call test%start(parallel=.false.)
  call make_beam(beam)
  q0 = beam%null_point()
  call beam%observe(q0, beam%sigma, 1)
  allocate (state)
  call build_design(beam, q0, state, 1.0_rp, design, failure)
  call check(.not. failure%failed, 'the design exists')
  call believing%init(design, N_EFFECTS, .true., 2000, 5_i8)
  call estimating%init(design, N_EFFECTS, .false., 2000, 5_i8)
  call test_absorbed()
  call test_size()
  call test_names()
  call test_aliases()
  call test_unknown()
  call test_estimates()
  call test_whole_run()
  call test_bound()
  call test_places()
  call test_two()
  call test_turning()
  call check(incoherent == 0, 'probabilities of all verdicts add up and are those of the verdicts')
  call test%finish()

contains

  !> A sentence that should be true.
  subroutine check(holds, sentence)
    logical, intent(in) :: holds
    character(*), intent(in) :: sentence
    call test%check(sentence, holds)
  end subroutine check

  !> The gradient along the span is what four joints and E make of it: most of it is absorbed.
  subroutine test_absorbed()
    integer :: c
    do c = 1, size(design%candidates)
      associate (one => design%candidates(c))
        if (one%effect == 2) call check(one%df == 0 .and. one%retained < 0.05_rp, &
                                        'what the baseline imitates is said to be absorbed')
        if (one%effect == E_DRIFT) call check(one%retained > 0.9_rp, 'drift in random order is not imitated')
      end associate
    end do
  end subroutine test_absorbed

  !> Linear verdict on data from q with noise of sd sigma and this seed.
  subroutine judge(q, sigma, seed, calibration, decision)
    real(rp), intent(in) :: q(:), sigma
    integer, intent(in) :: seed
    type(calibration_t), intent(in) :: calibration
    type(decision_t), intent(out) :: decision
    type(statistics_t) :: statistics
    type(hypotheses_t) :: hypotheses
    real(rp) :: residuals(beam%n_observations), jacobian(beam%n_observations, 0), z(design%k), rest
    logical :: is_valid
    call beam%observe(q, sigma, seed)
    call beam%evaluate(q0, [integer ::], solver_state_t(), residuals, jacobian, is_valid)
    call design%compress(residuals, q0(:N_BASE), z, rest)
    call find_statistics(design, N_EFFECTS, calibration%is_scale_known, z, rest, statistics)
    if (.not. calibration%is_scale_known) z = z/sqrt(rest/design%residual_dof)
    call hypotheses%init(design, N_EFFECTS, z)
    call decide(design, calibration, statistics, hypotheses, z, 7_i8, decision)
    if (.not. is_coherent(decision)) incoherent = incoherent + 1
  end subroutine judge

  !> Whether the odds add up to 1, and the verdict has the probability that they give to what it says.
  logical function is_coherent(decision)
    type(decision_t), intent(in) :: decision
    real(rp), parameter :: ROUNDING = 1.0e-12_rp
    real(rp) :: least, most
    associate (v => decision)
      least = probability_of_set(v)
      most = least + v%posterior_joint    ! those of the set, with others or without
      select case (v%verdict)
      case (VERDICT_ADEQUATE)
        least = v%posterior_none
        most = least
      case (VERDICT_UNKNOWN)
        least = v%posterior_unknown
        most = least
      case (VERDICT_NAMED)
        least = max(0.9_rp, merge(v%posterior_joint, least, v%is_joint))
      end select
    is_coherent = abs(sum(v%posterior) + v%posterior_none + v%posterior_joint + v%posterior_unknown - 1) < ROUNDING &
                    .and. v%probability > least - ROUNDING .and. v%probability < most + ROUNDING .and. &
                    (size(v%set) > 0 .eqv. any(v%verdict == [VERDICT_NAMED, VERDICT_SET]))
    end associate
  end function is_coherent

  !> False alarms among 400 nulls: expected 20, more than 35 with a probability of 6e-4.
  subroutine test_size()
    type(decision_t) :: decision
    integer :: s, alarms, wrong_scale, names
    alarms = 0
    wrong_scale = 0
    names = 0
    do s = 1, 400
      call judge(q0, beam%sigma, 10000 + s, believing, decision)
      if (decision%verdict /= VERDICT_ADEQUATE) alarms = alarms + 1
      if (decision%verdict == VERDICT_NAMED) names = names + 1
    end do
    call check(alarms <= 35 .and. alarms >= 7, 'chance alone is called adequate in 95 % of the cases')
    call check(names <= 4, 'chance alone hardly ever gets a name')
    ! Twice the declared noise, and no nuisances, whose size is believed.
    beam%tilt_sd = 0
    do s = 1, 400
      call judge(q0, 2*beam%sigma, 20000 + s, estimating, decision)
      if (decision%verdict /= VERDICT_ADEQUATE) wrong_scale = wrong_scale + 1
    end do
    call check(wrong_scale <= 35, 'nor does noise of twice the declared size alarm, if its size is estimated')
    wrong_scale = 0
    do s = 1, 100
      call judge(q0, 2*beam%sigma, 20000 + s, believing, decision)
      if (decision%verdict /= VERDICT_ADEQUATE) wrong_scale = wrong_scale + 1
    end do
    call check(wrong_scale >= 30, 'but it does if the declared size is believed')
    beam%tilt_sd = 0.002_rp
  end subroutine test_size

  !> Point at which effect number e of SHOWN has this signal-to-noise ratio.
  function point_of(column, snr, s) result(q)
    integer, intent(in) :: column, s
    real(rp), intent(in) :: snr
    real(rp) :: q(size(q0))
    integer :: c, i
    q = q0
    do c = 1, size(design%candidates)
      do i = 1, size(design%candidates(c)%columns)
        if (design%candidates(c)%columns(i) /= column) cycle
        q(column) = merge(1, -1, modulo(s, 2) == 0)*snr/norm2(design%candidates(c)%tangents(:, i))
      end do
    end do
  end function point_of

  !> Detection >= 95 % at 5, the truth named or in the set >= 95 % and named alone >= 85 % at 8, all found at 12, wrong
  !> names <= 2 %.
  subroutine test_names()
    real(rp), parameter :: SNR(3) = [5.0_rp, 8.0_rp, 12.0_rp]
    type(decision_t) :: decision
    integer :: e, k, s, found(3), right(3), single(3), wrong, n
    found = 0
    right = 0
    single = 0
    wrong = 0
    n = BATCH*size(SHOWN)
    do k = 1, 3
      do e = 1, size(SHOWN)
        do s = 1, BATCH
          call judge(point_of(COLUMNS(e), SNR(k), s), beam%sigma, 100000*k + 1000*e + s, estimating, decision)
          if (decision%verdict /= VERDICT_ADEQUATE) found(k) = found(k) + 1
          if (any(decision%set == SHOWN(e)) .and. any(decision%verdict == [VERDICT_NAMED, VERDICT_SET])) &
            right(k) = right(k) + 1
          if (decision%verdict /= VERDICT_NAMED) cycle
          if (size(decision%set) == 1 .and. decision%set(1) == SHOWN(e)) then
            if (all(SHOWN(e) /= [E_ROOT, E_TORSION])) single(k) = single(k) + 1
          else if (.not. any(decision%set == SHOWN(e))) then
            wrong = wrong + 1
          end if
        end do
      end do
    end do
    call check(found(1) >= 0.95_rp*n, 'effects of a signal-to-noise ratio of 5 are detected')
    call check(right(2) >= 0.95_rp*n, 'at 8 the truth is named or in the set')
    call check(single(2) >= 0.85_rp*(n - 2*BATCH), 'at 8 what has no alias is named alone')
    call check(found(3) == n .and. right(3) >= 0.95_rp*n, 'at 12 everything is found')
    call check(wrong <= 0.02_rp*3*n, 'wrong names are rare')
  end subroutine test_names

  !> Gain of the force, scale of heights and membrane stiffness do the same to this wing: no name, but all three.
  subroutine test_aliases()
    type(decision_t) :: decision
    integer :: s, names, sets
    names = 0
    sets = 0
    do s = 1, BATCH
      call judge(point_of(P_GAIN, 12.0_rp, s), beam%sigma, 400000 + s, estimating, decision)
      if (decision%verdict == VERDICT_NAMED) names = names + 1
      if (decision%verdict == VERDICT_SET .and. any(decision%set == E_GAIN) .and. any(decision%set == E_SCALE) .and. &
          any(decision%set == E_MEMBRANE)) sets = sets + 1
    end do
    call check(names == 0, 'causes that do the same are not named')
    call check(sets >= BATCH - 2, 'but listed together')
  end subroutine test_aliases

  !> Waves of compliance along the span that no entry has. That of bending looks much like a soft place, which the data
  !> cannot exclude; that of torsion looks like nothing in the catalogue.
  subroutine test_unknown()
    type(decision_t) :: decision
    integer :: i, s, k, wrong, n, unknown
    wrong = 0
    n = 0
    unknown = 0
    do k = 1, 3
      do s = 1, BATCH
        beam%hidden = [(merge(1, -1, modulo(s, 2) == 0)*0.25_rp*k*sin(20*(i - 0.5_rp)/60), i=1, 60)]
        call judge(q0, beam%sigma, 500000 + 1000*k + s, estimating, decision)
        if (decision%verdict == VERDICT_NAMED) wrong = wrong + 1
        beam%hidden_twist = [(merge(1, -1, modulo(s, 2) == 0)*0.05_rp*k*sin(12*(i - 0.5_rp)/60), i=1, 60)]
        call judge(q0, beam%sigma, 510000 + 1000*k + s, estimating, decision)
        if (decision%verdict == VERDICT_NAMED) wrong = wrong + 1
        n = n + 2
        if (k == 3 .and. decision%verdict == VERDICT_UNKNOWN) unknown = unknown + 1
      end do
    end do
    call check(wrong <= 0.05_rp*n, 'a cause outside the catalogue gets no wrong name')
    call check(unknown >= 0.8_rp*BATCH, 'and if it is strong it is called unknown')
  end subroutine test_unknown

  !> Estimates of one parameter within 1.645 standard errors in 90 % of 200 cases: fewer than 166 or more than 192
  !> with a probability below 1e-3.
  subroutine test_estimates()
    real(rp) :: residuals(beam%n_observations), jacobian(beam%n_observations, 0), z(design%k), rest
    real(rp) :: q(size(q0)), value(1)
    integer :: c, s, inside
    logical :: is_valid
    inside = 0
    do c = 1, size(design%candidates)
      if (design%candidates(c)%effect == E_OFFSET) exit
    end do
    q = point_of(P_OFFSET, 8.0_rp, 0)
    do s = 1, 200
      call beam%observe(q, beam%sigma, 600000 + s)
      call beam%evaluate(q0, [integer ::], solver_state_t(), residuals, jacobian, is_valid)
      call design%compress(residuals, q0(:N_BASE), z, rest)
      associate (one => design%candidates(c))
        value = -matmul(one%solve, matmul(z, one%basis)) ! residuals are computed minus observed
        if (abs(value(1) - q(P_OFFSET)) < 1.6449_rp*norm2(one%solve(1, :))) inside = inside + 1
      end associate
    end do
    call check(inside >= 166 .and. inside <= 192, 'intervals of 90 % hold the truth in 90 % of the cases')
  end subroutine test_estimates

  !> From data to a confirmed verdict with full fits; and data whose loads were exchanged.
  subroutine test_whole_run()
    type(diagnosis_t), target :: d
    type(diagnosis_options_t) :: options
    type(residual_check_t), allocatable :: checks(:)
    real(rp) :: q(size(q0))
    integer :: i
    options%n_draws = 1000
    q = point_of(P_ONE_WAY, 12.0_rp, 0)
    q(2) = q(2) + 0.3_rp
    call beam%observe(q, beam%sigma, 700001)
    call run_diagnosis(beam, reshape(q0, [size(q0), 1]), options, d, failure)
    call check(.not. failure%failed .and. d%decision%verdict == VERDICT_NAMED, 'a one-way joint gets a name')
    call check(d%decision%set(1) == E_ONE_WAY, 'which is its own')
    call check(is_coherent(d%decision), 'with the probability that the odds after all fits give it')
    call check(d%intervals(1)%lower < q(P_ONE_WAY) .and. q(P_ONE_WAY) < d%intervals(1)%upper, &
               'its interval holds the truth')
    call check(d%prediction%has_gain .and. d%prediction%gain > d%prediction%gain_error, &
               'it predicts locations that the fit did not see')
    ! Deflections to one side are too large: that is the plain question about the sign.
    call check_fit(beam, d%model%design, d%model%baseline, 1.0_rp, huge(1), checks)
    do i = 1, size(checks)
      if (checks(i)%name == 'sign') exit
    end do
    call check(checks(i)%p() < 0.01_rp, 'the residuals depend on the sign of the force')
    call beam%observe(q0, beam%sigma, 700002)
    beam%data = cshift(beam%data, 28)
    call run_diagnosis(beam, reshape(q0, [size(q0), 1]), options, d, failure)
    call check(failure%failed .or. d%decision%verdict /= VERDICT_NAMED, 'exchanged loads get no name')
    if (.not. failure%failed) call check(is_coherent(d%decision), 'nor a probability that the odds do not have')
    call check(d%extended_scale > LARGEST_SCALE .and. .not. allocated(d%intervals), &
               'nor intervals of what leaves more than noise')
  end subroutine test_whole_run

  !> An effect that is stronger than the parameter may be is no name.
  subroutine test_bound()
    type(diagnosis_t), target :: d
    type(diagnosis_options_t) :: options
    real(rp) :: q(size(q0)), upper
    options%n_draws = 1000
    options%validates = .false.
    q = point_of(P_ONE_WAY, 12.0_rp, 0)
    upper = beam%parameters(P_ONE_WAY)%upper
    call beam%observe(q, beam%sigma, 700001)
    beam%parameters(P_ONE_WAY)%upper = 0.8_rp*q(P_ONE_WAY)
    call run_diagnosis(beam, reshape(q0, [size(q0), 1]), options, d, failure)
    call check(.not. failure%failed .and. d%decision%verdict == VERDICT_SET .and. d%decision%reason == AT_BOUND .and. &
               d%support%is_null_excluded, 'what stands at a bound is no name')
    beam%parameters(P_ONE_WAY)%upper = upper
  end subroutine test_bound

  !> A soft place between those that are scanned is found where it is, with the p of the scan alone.
  subroutine test_places()
    integer, parameter :: HIDDEN = 6
    type(diagnosis_t), target :: d, scan
    type(diagnosis_options_t) :: options
    type(variant_t), allocatable :: all(:)
    integer :: n
    options%n_draws = 1000
    options%validates = .false.
    n = size(beam%effects(E_SOFT)%variants)
    call beam%observe(point_of(P_SOFT + HIDDEN - 1, 12.0_rp, 0), beam%sigma, 700003)
    all = beam%effects(E_SOFT)%variants
    beam%effects(E_SOFT)%variants = all(1:n:2)
    call run_diagnosis(beam, reshape(q0, [size(q0), 1]), options, scan, failure)
    beam%effects(E_SOFT)%variants = all
    beam%effects(E_SOFT)%variants(2:n:2)%is_finer = .true.
    call run_diagnosis(beam, reshape(q0, [size(q0), 1]), options, d, failure)
    call check(.not. failure%failed .and. any(d%decision%set == E_SOFT), &
               'a soft place beside the scanned ones is found')
    if (size(d%decision%causes) > 0) call check(d%model%design%candidates(d%decision%causes(1))%variant == HIDDEN, &
                                                'and moved to where it is')
    ! Places that are tried later make nothing more probable by chance, nor less.
    call check(abs(d%decision%log_p_global - scan%decision%log_p_global) < 1.0e-9_rp, 'with the p of the scan')
    call check(abs(d%tests%scale - scan%tests%scale) < 1.0e-9_rp, 'and its size of the noise')
    beam%effects(E_SOFT)%variants = all
  end subroutine test_places

  !> Two strong effects are named together.
  subroutine test_two()
    type(diagnosis_t), target :: d
    type(diagnosis_options_t) :: options
    real(rp) :: one(size(q0)), other(size(q0))
    options%n_draws = 1000
    options%validates = .false.
    one = point_of(P_ONE_WAY, 15.0_rp, 0)
    other = point_of(P_DRIFT, 15.0_rp, 1)
    call beam%observe(one + other - q0, beam%sigma, 700005)
    call run_diagnosis(beam, reshape(q0, [size(q0), 1]), options, d, failure)
    call check(.not. failure%failed .and. d%decision%verdict == VERDICT_NAMED .and. d%decision%is_joint .and. &
               size(d%decision%set) == 2 .and. any(d%decision%set == E_ONE_WAY) .and. any(d%decision%set == E_DRIFT), &
               'two effects are named together')
    call check(all(d%intervals%lower < d%intervals%upper) .and. size(d%intervals) == 2, 'each with an interval')
  end subroutine test_two

  !> An effect whose tangent shows a small part of what it does at the strength it has is found nevertheless, before
  !> several others together are.
  subroutine test_turning()
    type(diagnosis_t), target :: d
    type(diagnosis_options_t) :: options
    real(rp) :: q(size(q0)), other(size(q0))
    options%n_draws = 1000
    options%validates = .false.
    q = point_of(P_SPAN, 4.0_rp, 0)
    other = point_of(P_TORSION, 20.0_rp, 0)
    beam%turns = other(P_TORSION)/q(P_SPAN)**3
    call beam%observe(q, beam%sigma, 700004)
    call run_diagnosis(beam, reshape(q0, [size(q0), 1]), options, d, failure)
    beam%turns = 0
    call check(.not. failure%failed .and. any(d%decision%set == E_SPAN) .and. size(d%decision%causes) == 1, &
               'what changes its shape with its strength is found alone')
  end subroutine test_turning
end program test_engine
