! SPDX-License-Identifier: GPL-3.0-or-later
!> Odds of several causes, unknown causes made of known parameters, whether names could have been rejected, finer places,
!> and what a name needs of intervals, on a wing in closed form (diagnosis_beam).
program test_hypotheses
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use diagnosis_beam, only: beam_t, make_beam, E_DRIFT, E_OFFSET, E_SOFT, N_BASE, P_BOTH, P_DRIFT, P_SOFT, P_TORSION
  use inference_calibration, only: calibration_t, find_statistics, statistics_t
  use inference_design, only: build_design, candidate_t, design_t, is_part_of
  use inference_hypotheses, only: add_effect, explain, explained_t, hypotheses_t, log_prior, PRIOR_ONE, PRIOR_TWO
  use inference_intervals, only: find_support
  use inference_refit, only: nested_fit_t
  use inference_rejection, only: name_power
  use inference_weights, only: cell_weights
  use least_squares_profile, only: interval_t
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  type(beam_t), target :: beam
  type(design_t) :: design
  class(solver_state_t), allocatable :: state
  type(failure_t) :: failure
  real(rp), allocatable :: q0(:)

  call test%start(parallel=.false.)
  call make_beam(beam)
  q0 = beam%null_point()
  call beam%observe(q0, beam%sigma, 1)
  allocate (state)
  call build_design(beam, q0, state, 1.0_rp, design, failure)
  call check(.not. failure%failed, 'the design exists')
  call test_choice()
  call test_field()
  call test_nonlinear()
  call test_parts()
  call test_power()
  call test_cells()
  call test_scan()
  call test_support()
  call test%finish()

contains

  !> A sentence that should be true.
  subroutine check(holds, sentence)
    logical, intent(in) :: holds
    character(*), intent(in) :: sentence
    call test%check(sentence, holds)
  end subroutine check

  !> The evidence of a second effect that may be at many places is the mean over them, here one by one, and not that of
  !> the best place.
  subroutine test_choice()
    type(explained_t) :: first, pair, one
    real(rp) :: z(design%k), mean, most
    integer :: c, n, drift
    drift = first_of(E_DRIFT)
    z = [(sin(1.7_rp*c**2), c=1, size(z))] + 8*design%candidates(drift)%basis(:, 1)
    call explain(design, [drift], z, first)
    call add_effect(design, first, E_SOFT, pair)
    n = 0
    mean = 0
    most = -huge(most)
    do c = 1, size(design%candidates)
      if (design%candidates(c)%effect /= E_SOFT .or. design%candidates(c)%df == 0) cycle
      call explain(design, [drift, c], z, one)
      n = n + 1
      mean = mean + exp(one%log_evidence - first%log_evidence)
      most = max(most, one%log_evidence)
      if (c == pair%members(2)) call check(maxval(abs(one%left - pair%left)) < 1.0e-12_rp, 'what a pair leaves')
    end do
    call check(n > 5 .and. abs(pair%log_evidence - first%log_evidence - log(mean/n)) < 1.0e-10_rp, &
               'an effect that may be at many places pays for the choice')
    call check(pair%log_evidence < most - 0.1_rp, 'which is less than the best place promises')
  end subroutine test_choice

  !> Unknown strengths of all soft places at once: the family spans what single ones do.
  subroutine test_field()
    type(beam_t) :: other
    type(design_t) :: wide
    real(rp) :: worst
    integer :: c, n
    call make_beam(other)
    call other%observe(q0, other%sigma, 1)
    n = size(other%parameters) - P_SOFT + 1
    other%field = [(c, c=P_SOFT, size(other%parameters))]
    other%family = [other%family, (maxval(other%family) + 1, c=1, n)]
    call build_design(other, q0, state, 1.0_rp, wide, failure)
    worst = 0
    associate (field => wide%families(size(wide%families)))
      do c = 1, size(wide%candidates)
        if (wide%candidates(c)%effect /= E_SOFT) cycle
        associate (t => wide%candidates(c)%tangents(:, 1))
          worst = max(worst, norm2(t - matmul(field%basis, matmul(t, field%basis)))/norm2(t))
        end associate
      end do
      call check(size(wide%families) == size(design%families) + 1 .and. worst < 1.0e-5_rp .and. &
                 size(field%patterns) == n .and. size(field%alone, 2) == 0, 'a field of quantities is an unknown cause')
    end associate
    call check(wide%k == design%k, 'and costs no directions')
  end subroutine test_field

  !> What a fit has found beyond its tangents is shared by unknown causes up to what the tangents show; beyond that they have
  !> what they explain by themselves, and where tangents promised too much they lose as much as the fit.
  subroutine test_nonlinear()
    type(hypotheses_t) :: all, seen
    real(rp), parameter :: GROWN = 800
    real(rp) :: z(design%k), before(size(design%families)), linear
    integer :: c
    do c = 1, size(design%candidates)
      if (design%candidates(c)%effect == E_DRIFT) z = 60*design%candidates(c)%basis(:, 1)
    end do
    call seen%init(design, size(beam%effects), z)
    call all%init(design, size(beam%effects), z + 40*design%families(1)%basis(:, 1))
    call check(maxval(all%unknown - seen%unknown) > 100, 'what tangents miss looks like an unknown cause')
    call all%correct_unknown(design)
    call check(maxval(all%unknown - seen%unknown) > 100, 'as long as nothing is fitted')
    before = all%unknown
    linear = all%effect(E_DRIFT)
    call all%correct(E_DRIFT, GROWN, 0.0_rp, 0.0_rp, z)
    call all%correct_unknown(design)
    call check(linear > GROWN .and. maxval(abs(all%unknown - max(GROWN + seen%unknown, before))) < 1.0e-9_rp, &
               'a fit that explains it shares that')
    call all%correct(E_DRIFT, 3*linear, 0.0_rp, 0.0_rp, z)
    call all%correct_unknown(design)
    call check(maxval(abs(all%unknown - max(linear + seen%unknown, before))) < 1.0e-9_rp, &
               'but no more than its tangents show')
    call check(all%is_misled(), 'a fit that finds three times as much more shows that tangents mislead')
    call all%correct(E_DRIFT, 3*linear, 0.0_rp, 0.0_rp, z, left=300.0_rp)
    call all%correct(E_OFFSET, 0.0_rp, 0.0_rp, 0.0_rp, z, left=311.0_rp)
    call check(.not. all%tell_apart(E_DRIFT, E_OFFSET, 3.0_rp), 'fits with nearly the same remainder do not tell effects apart')
    call all%correct(E_OFFSET, 0.0_rp, 0.0_rp, 0.0_rp, z, left=313.0_rp)
    call check(all%tell_apart(E_DRIFT, E_OFFSET, 3.0_rp), 'others do')
    call all%correct(E_DRIFT, 0.9_rp*linear, 0.0_rp, 0.0_rp, z, left=300.0_rp)
    call check(.not. (all%is_misled() .or. all%tell_apart(E_DRIFT, E_OFFSET, 3.0_rp)), 'but only if tangents mislead')
    call all%correct(E_DRIFT, -GROWN, 0.0_rp, 0.0_rp, z)
    call all%correct_unknown(design)
    call check(maxval(abs(all%unknown + GROWN - seen%unknown)) < 1.0e-9_rp, 'what tangents promised too much is lost by both')
  end subroutine test_nonlinear

  !> Parts are strict.
  subroutine test_parts()
    type(candidate_t) :: one, both, other
    one%columns = [4]
    both%columns = [7, 4]
    other%columns = [3, 5]
    call check(is_part_of(one, both), 'one of two parameters is a part')
    call check(.not. any([is_part_of(both, one), is_part_of(one, one), is_part_of(one, other)]), 'and nothing else')
  end subroutine test_parts

  !> What could be anywhere imitates more of what nobody knows, so that such a name says less; and names are rejected at the
  !> level of the rule. Bounds are 3 sd of a share of DRAWS.
  subroutine test_power()
    integer, parameter :: DRAWS = 200
    real(rp), parameter :: CLEAR = 3*sqrt(0.5_rp/DRAWS), RATIO = 6, LEVEL = log(0.01_rp)
    type(calibration_t) :: calibration
    type(design_t) :: one, many
    real(rp) :: alone, anywhere
    integer :: i, site
    call calibration%init(design, size(beam%effects), .true., 1000, 5_i8)
    ! A soft place in the middle, and others wherever the first kind of unknown causes has a pattern.
    site = first_of(E_SOFT) + 5
    one = design
    where (one%candidates%effect == E_SOFT) one%candidates%effect = 0
    one%candidates(site)%effect = E_SOFT
    one%candidates(site)%weight = 1
    many = one
    do i = 1, size(design%families(1)%alone, 2)
      many%candidates = [many%candidates, one%candidates(site)]
      many%candidates(size(many%candidates))%basis(:, 1) = design%families(1)%alone(:, i)
    end do
    call check(abs(5*exp(log_prior(1, 5)) - PRIOR_ONE) + abs(10*exp(log_prior(2, 5)) - PRIOR_TWO) < 1.0e-12_rp, &
               'five effects, or ten pairs of them, share a prior')
    where (many%candidates%effect == E_SOFT) many%candidates%weight = 1.0_rp/count(many%candidates%effect == E_SOFT)
    alone = name_power(one, calibration, [E_SOFT], RATIO, LEVEL, DRAWS, 3_i8)
    anywhere = name_power(many, calibration, [E_SOFT], RATIO, LEVEL, DRAWS, 3_i8)
    call check(anywhere < alone - CLEAR, 'a name that may be at many places is harder to reject')
    call check(name_power(many, calibration, [E_SOFT], RATIO, log(0.5_rp), DRAWS, 3_i8) > anywhere + CLEAR, &
               'and easier at a larger level')
    call check(name_power(many, calibration, [E_DRIFT, E_SOFT], RATIO, LEVEL, DRAWS, 3_i8) <= anywhere + CLEAR, &
               'with another cause it is no easier')
  end subroutine test_power

  !> A scan whose best place is tried once more, and again, is the same scan.
  subroutine test_cells()
    integer, parameter :: BEST = 6, COPIES = 4
    type(beam_t) :: other
    type(design_t) :: finer
    type(hypotheses_t) :: before, after
    type(explained_t) :: first, pair, pair_after
    real(rp) :: z(design%k)
    call check(maxval(abs(cell_weights(reshape([0, 0, 1, 0, 2, 0, 3, 0, 9, 0, 11, 0]/1.0_rp, [2, 6]), &
                                       [.false., .false., .true., .false., .false., .true.], &
                                       [.true., .true., .true., .false., .true., .true.])*6 - [2, 1, 1, 0, 1, 1])) < &
               1.0e-12_rp, 'finer places share the weight of their cell')
    call make_beam(other)
    call other%observe(q0, other%sigma, 1)
    associate (soft => other%effects(E_SOFT))
      soft%variants = [soft%variants, spread(soft%variants(BEST), 1, COPIES)]
      soft%variants(size(soft%variants) - COPIES + 1:)%is_finer = .true.
      soft%variants%is_released = .true.
    end associate
    call build_design(other, q0, state, 1.0_rp, finer, failure)
    z = 7*design%candidates(first_of(E_SOFT) + BEST - 1)%basis(:, 1) &
        + 9*design%candidates(first_of(E_DRIFT))%basis(:, 1)
    call before%init(design, size(beam%effects), z)
    call after%init(finer, size(beam%effects), z)
    call check(size(finer%candidates) == size(design%candidates) + COPIES .and. finer%k == design%k .and. &
               abs(before%effect(E_SOFT) - after%effect(E_SOFT)) < 1.0e-9_rp, &
               'the evidence of an effect is that of its scan, however often a place of it is tried')
    call explain(design, [first_of(E_DRIFT)], z, first)
    call add_effect(design, first, E_SOFT, pair)
    call add_effect(finer, first, E_SOFT, pair_after)
    call check(abs(pair%log_evidence - pair_after%log_evidence) < 1.0e-9_rp, 'also beside another cause')
  end subroutine test_cells

  !> Finer places between those of the scan, where the signal is, find nothing.
  subroutine test_scan()
    integer, parameter :: HIDDEN = 6
    type(beam_t) :: other
    type(design_t) :: coarse, finer
    type(statistics_t) :: before, after
    real(rp) :: q(size(q0))
    integer :: c
    call make_beam(other)
    q = q0
    q(P_SOFT + HIDDEN - 1) = 1.5_rp
    call other%observe(q, other%sigma, 1)
    other%effects(E_SOFT)%variants(HIDDEN)%is_finer = .true.
    call take(other, coarse, before)
    other%effects(E_SOFT)%variants(HIDDEN)%is_released = .true.
    call take(other, finer, after)
    call check(size(finer%candidates) == size(coarse%candidates) + 1 .and. before%effect(E_SOFT) > 10 .and. &
               maxval(abs(before%effect - after%effect)) < 1.0e-6_rp, 'the p of a scan is that of its own places')
    c = after%best(E_SOFT)
    call check(finer%candidates(c)%variant /= HIDDEN .and. &
               any(finer%candidates%is_finer .and. after%squares > 1.1_rp*after%squares(c)), &
               'although a finer one is better')
  end subroutine test_scan

  !> Every cause needs an interval of its own, and none that counts may belong to an estimate at a bound.
  subroutine test_support()
    type(nested_fit_t) :: found
    type(interval_t) :: intervals(3) ! of drift, and of both parameters of torsion
    logical :: is_excluded, is_bound
    type(candidate_t) :: causes(2)
    integer :: c
    causes(1)%columns = [P_DRIFT]
    causes(2)%columns = [P_TORSION, P_BOTH]
    found%active = [(c, c=1, N_BASE), P_DRIFT, P_TORSION, P_BOTH]
    found%q = q0 + 1
    found%is_at_bound = [(.false., c=1, N_BASE + 3)]
    call find_support(beam%parameters, causes, N_BASE, found, intervals, is_excluded, is_bound)
    call check(.not. (is_excluded .or. is_bound), 'no cause without intervals')
    intervals(1) = interval_t(lower=0.5_rp, has_lower=.true.)
    call find_support(beam%parameters, causes, N_BASE, found, intervals, is_excluded, is_bound)
    call check(.not. is_excluded, 'nor for that of another cause')
    intervals(3) = interval_t(upper=-0.5_rp, has_upper=.true.)
    call find_support(beam%parameters, causes, N_BASE, found, intervals, is_excluded, is_bound)
    call check(is_excluded .and. .not. is_bound, 'but one parameter of each is enough')
    found%is_at_bound(N_BASE + 2) = .true.
    call find_support(beam%parameters, causes, N_BASE, found, intervals, is_excluded, is_bound)
    call check(.not. is_bound, 'whatever another one of the same cause is at')
    found%is_at_bound(N_BASE + 3) = .true.
    call find_support(beam%parameters, causes, N_BASE, found, intervals, is_excluded, is_bound)
    call check(is_bound, 'unless it stands at a bound')
    found%q = q0
    call find_support(beam%parameters, causes, N_BASE, found, intervals, is_excluded, is_bound)
    call check(.not. is_bound, 'which is not where it has no effect')
  end subroutine test_support

  !> The design of a wing, and statistics of its data.
  subroutine take(wing, one, statistics)
    type(beam_t), intent(inout) :: wing
    type(design_t), intent(out) :: one
    type(statistics_t), intent(out) :: statistics
    real(rp) :: residuals(wing%n_observations), jacobian(wing%n_observations, 0), rest
    real(rp), allocatable :: z(:)
    logical :: is_valid
    call build_design(wing, q0, state, 1.0_rp, one, failure)
    allocate (z(one%k))
    call wing%evaluate(q0, [integer ::], solver_state_t(), residuals, jacobian, is_valid)
    call one%compress(residuals, q0(:N_BASE), z, rest)
    call find_statistics(one, size(wing%effects), .true., z, rest, statistics)
  end subroutine take

  !> The first candidate of an effect.
  integer function first_of(e) result(c)
    integer, intent(in) :: e
    do c = 1, size(design%candidates)
      if (design%candidates(c)%effect == e) return
    end do
    c = 0
  end function first_of
end program test_hypotheses
