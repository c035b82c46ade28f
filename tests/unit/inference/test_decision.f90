! SPDX-License-Identifier: GPL-3.0-or-later
!> Which word is said where odds are close, on a wing in closed form (diagnosis_beam): odds are set by hand, or by the
!> strength of a second effect, and the verdict is that of docs/theory/diagnosis.md on both sides of its bounds.
program test_decision
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use diagnosis_beam, only: beam_t, make_beam, E_DRIFT, E_OFFSET
  use inference_calibration, only: calibration_t, find_statistics, statistics_t
  use inference_causes, only: withdraw_unsupported
  use inference_decision, only: decide, decision_t, NO_GAIN, VERDICT_NAMED, VERDICT_SET, VERDICT_UNKNOWN
  use inference_design, only: build_design, design_t
  use inference_hypotheses, only: hypotheses_t, log_odds_unknown, log_prior
  use inference_record, only: diagnosis_options_t, prediction_t, support_t
  use inference_refit, only: nested_fit_t
  use inference_rejection, only: imitation
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N_EFFECTS = 12
  integer(i8), parameter :: SEED = 7
  type(testkit_t) :: test
  type(beam_t), target :: beam
  type(design_t) :: design
  class(solver_state_t), allocatable :: state
  type(calibration_t) :: calibration
  type(failure_t) :: failure
  real(rp), allocatable :: q0(:)

  call test%start(parallel=.false.)
  call make_beam(beam)
  q0 = beam%null_point()
  call beam%observe(q0, beam%sigma, 1)
  allocate (state)
  call build_design(beam, q0, state, 1.0_rp, design, failure)
  call test%check('the design exists',.not. failure%failed)
  call calibration%init(design, N_EFFECTS, .true., 500, SEED)
  call test_unknown()
  call test_further()
  call test_joint_causes()
  call test_imitation()
  call test_wider()
  call test_prediction()
  call test%finish()

contains

  !> Drift of 12 sd. An unknown cause that is as probable as drift alone, and a little more, but less probable than all of
  !> the catalogue together, is not the answer; one that is more probable than not is.
  subroutine test_unknown()
    type(hypotheses_t) :: hypotheses
    type(decision_t) :: one
    real(rp) :: z(design%k), fraction
    z = 12*drift()
    call hypotheses%init(design, N_EFFECTS, z)
    hypotheses%unknown = -1.0e3_rp
    call verdict_on(z, hypotheses, one)
    call test%check('drift is named where nothing else is probable', one%verdict == VERDICT_NAMED .and. &
                    one%posterior_unknown < 1.0e-6_rp .and. size(one%set) == 1)
    ! With o the odds of unknown against drift alone, and s those of everything else, P(unknown) = o/(1 + o + s).
    fraction = (1 - one%posterior(E_DRIFT))/one%posterior(E_DRIFT)
    call test%check('  but not certain', fraction > 1.0e-6_rp)
    call set_unknown(hypotheses, 1 + fraction/2)
    call verdict_on(z, hypotheses, one)
    call test%check('a set where unknown causes lead with less than one half', one%verdict == VERDICT_SET .and. &
                    one%posterior_unknown > one%posterior(E_DRIFT) .and. one%posterior_unknown < 0.5_rp)
    call set_unknown(hypotheses, 1 + 2*fraction)
    call verdict_on(z, hypotheses, one)
    call test%check('unknown where they have more than one half', one%verdict == VERDICT_UNKNOWN .and. &
                    one%posterior_unknown > 0.5_rp .and. size(one%set) == 0)
  end subroutine test_unknown

  !> Odds of unknown causes against drift alone.
  subroutine set_unknown(hypotheses, odds)
    type(hypotheses_t), intent(inout) :: hypotheses
    real(rp), intent(in) :: odds
    integer :: testable
    testable = count(hypotheses%best > 0)
    hypotheses%unknown = 0
    hypotheses%unknown = log(odds) + hypotheses%effect(E_DRIFT) + log_prior(1, testable) - &
                         log_odds_unknown(hypotheses%unknown)
  end subroutine set_unknown

  !> Drift of 15 sd and so much of an offset that two causes are twice as probable as drift alone, which leaves nothing but
  !> noise: drift is a cause either way, and its name stands.
  subroutine test_further()
    type(hypotheses_t) :: hypotheses
    type(decision_t) :: one
    real(rp) :: z(design%k)
    call make_pair('two causes are twice as probable as one', 2.0_rp, z, hypotheses, one)
    call test%check('  which has a further one beside it', one%has_further .and. size(one%set) == 1)
    call test%check('  and keeps its name', one%verdict == VERDICT_NAMED .and. one%set(1) == E_DRIFT .and. &
                    .not. one%is_joint .and. one%probability > 0.9_rp)
  end subroutine test_further

  !> Two causes that are six times as probable as drift alone are the answer, together. Unknown causes that are more probable
  !> than these, but not than everything in the catalogue, do not take their place.
  subroutine test_joint_causes()
    type(hypotheses_t) :: hypotheses
    type(decision_t) :: one
    real(rp) :: z(design%k), left, drift_alone
    call make_pair('two causes are six times as probable as one', 6.0_rp, z, hypotheses, one)
    call test%check('  and the answer, together', one%is_joint .and. size(one%set) == 2)
    left = 1 - one%posterior_joint
    call test%check('  but not certain', left > 0.05_rp)
    drift_alone = one%posterior(E_DRIFT)
    call set_unknown(hypotheses, (1 - left/2)/drift_alone) ! against everything else: 1 - left/2
    call verdict_on(z, hypotheses, one)
    call test%check('both where unknown causes lead with less than one half', one%is_joint .and. &
                    one%posterior_unknown > one%posterior_joint .and. one%posterior_unknown < 0.5_rp)
    call set_unknown(hypotheses, (1 + left)/drift_alone)
    call verdict_on(z, hypotheses, one)
    call test%check('unknown where they have more than one half', one%verdict == VERDICT_UNKNOWN .and. &
                    one%posterior_unknown > 0.5_rp .and. size(one%set) == 0)
  end subroutine test_joint_causes

  !> Two causes that are six times as probable as drift alone, where every unknown cause looks like the two of them: it would be
  !> taken for them each time, and its prior is twice theirs. Where none looks like them, they stay.
  subroutine test_imitation()
    type(hypotheses_t) :: hypotheses
    type(decision_t) :: one
    type(design_t) :: other
    integer :: effects(N_EFFECTS), i, f
    real(rp) :: z(design%k), share(0:3)
    call make_pair('two causes again', 6.0_rp, z, hypotheses, one)
    call test%check('  which few unknown causes imitate', one%is_joint .and. one%imitation < 0.5_rp)
    other = design
    do f = 1, size(other%families)
      other%families(f)%basis = reshape([drift(), second()], [design%k, 2])
      other%families(f)%scale = [1.0_rp, 1.0_rp]
    end do
    call judge(other, z, hypotheses, one)
    call test%check('are an unknown cause where all of them imitate the two', one%verdict == VERDICT_UNKNOWN .and. &
                    .not. one%is_joint .and. size(one%set) == 0 .and. one%imitation > 0.9_rp)
    call test%check_close('  with the odds of the priors', one%probability, &
                          one%imitation*0.2_rp/(one%imitation*0.2_rp + 0.1_rp), 1.0e-12_rp)
    effects = [(i, i=1, N_EFFECTS)]
    do i = 0, 3
      share(i) = imitation(design, calibration, effects, i, 12.0_rp, log(0.01_rp), 60, SEED)
    end do
    call test%check('no cause imitates a strong unknown one', share(0) < 0.02_rp)
    call test%check('more causes imitate more of them', all(share(1:) >= share(:2)) .and. share(3) > share(1))
    share(0) = imitation(design, calibration, effects, 0, 0.0_rp, log(0.01_rp), 100, SEED)
    call test%check('noise is noise', share(0) > 0.95_rp)
  end subroutine test_imitation

  !> A wider effect frees the parameter of drift and one more, which the data do not show. It is no rival of drift: the name
  !> of drift stands if this effect is as probable, and if it leads by less than can be distinguished. If it leads by more it has
  !> the name.
  subroutine test_wider()
    type(hypotheses_t) :: hypotheses
    type(decision_t) :: one, alone
    type(design_t) :: other
    real(rp) :: z(design%k)
    integer :: c, from
    z = 12*drift()
    call hypotheses%init(design, N_EFFECTS, z)
    hypotheses%unknown = -1.0e3_rp
    from = hypotheses%best(E_DRIFT)
    call verdict_on(z, hypotheses, alone)
    other = design
    do c = 1, size(other%candidates)
      if (other%candidates(c)%effect /= E_OFFSET) cycle
      associate (columns => [design%candidates(from)%columns, other%candidates(c)%columns])
        other%candidates(c) = design%candidates(from)
        other%candidates(c)%effect = E_OFFSET
        other%candidates(c)%columns = columns
      end associate
    end do
    call hypotheses%init(other, N_EFFECTS, z)
    hypotheses%unknown = -1.0e3_rp
    call judge(other, z, hypotheses, one)
    call test%check('a wider effect of equal evidence is no rival of its part', one%verdict == VERDICT_NAMED .and. &
                    size(one%set) == 1 .and. one%set(1) == E_DRIFT .and. size(one%wider) == 1 .and. any(one%wider == E_OFFSET))
    call test%check('  and the name holds in either case', one%probability >= alone%probability .and. &
                    one%posterior(E_DRIFT) < 0.6_rp)
    hypotheses%effect(E_OFFSET) = hypotheses%effect(E_OFFSET) + 2.5_rp
    call judge(other, z, hypotheses, one)
    call test%check('  also if the wider one leads by little', one%verdict == VERDICT_NAMED .and. one%set(1) == E_DRIFT .and. &
                    other%candidates(one%causes(1))%effect == E_DRIFT .and. size(one%wider) == 1)
    hypotheses%effect(E_OFFSET) = hypotheses%effect(E_OFFSET) + 7.5_rp
    call judge(other, z, hypotheses, one)
    call test%check('a wider effect that leads by much is the cause', one%set(1) == E_OFFSET .and. size(one%wider) == 0)
    call test_wider_signal()
  end subroutine test_wider

  !> Drift of 12 sd and 4 sd in the direction that a wider effect has beside it: drift alone leaves a loss of 8. The wider is the
  !> cause, even if priors make drift nearly as probable.
  subroutine test_wider_signal()
    type(hypotheses_t) :: hypotheses
    type(decision_t) :: one
    type(design_t) :: other
    real(rp) :: z(design%k), r(2, 2)
    integer :: from, to, c
    z = 12*drift() + 4*second()
    call hypotheses%init(design, N_EFFECTS, z)
    from = hypotheses%best(E_DRIFT)
    to = hypotheses%best(E_OFFSET)
    other = design
    associate (one => design%candidates(from), added => design%candidates(to), wide => other%candidates(to))
      wide%columns = [one%columns, added%columns]
      wide%df = 2
      wide%basis = reshape([drift(), second()], [design%k, 2])
      wide%tangents = reshape([one%tangents, added%tangents], [design%k, 2])
      wide%projected = reshape([one%projected, added%projected], [size(one%projected, 1), 2])
      r = matmul(transpose(wide%basis), wide%tangents)
      wide%solve = reshape([r(2, 2), -r(2, 1), -r(1, 2), r(1, 1)], [2, 2])/(r(1, 1)*r(2, 2) - r(1, 2)*r(2, 1))
      call wide%size_prior%init([1.0_rp, 1.0_rp])
    end associate
    do c = 1, size(other%candidates)
      if (other%candidates(c)%effect == E_OFFSET .and. c /= to) other%candidates(c)%df = 0
    end do
    call hypotheses%init(other, N_EFFECTS, z)
    hypotheses%unknown = -1.0e3_rp
    hypotheses%effect(E_DRIFT) = hypotheses%effect(E_OFFSET) - 0.1_rp
    call judge(other, z, hypotheses, one)
    call test%check('a wider effect that explains more is the cause, with little more evidence', &
                    other%candidates(one%causes(1))%effect == E_OFFSET .and. .not. one%is_joint .and. size(one%wider) == 0)
  end subroutine test_wider_signal

  !> A name needs a better prediction if its fit gains more of the data, and one that is not worse if it gains more of the priors.
  subroutine test_prediction()
    real(rp), parameter :: BETTER = 0.6_rp, EVEN = -0.2_rp, WORSE = -0.6_rp, OF_DATA = 30, OF_PRIORS = 90
    call test%check('a better prediction is enough for what the data show', keeps_name(BETTER, OF_DATA, 0.0_rp) .and. &
                    keeps_name(BETTER, OF_PRIORS, OF_DATA))
    call test%check('  and needed',.not. (keeps_name(EVEN, OF_DATA, 0.0_rp) .or. keeps_name(EVEN, OF_PRIORS, OF_DATA)))
    call test%check('an even one for what was known otherwise', keeps_name(EVEN, OF_DATA, OF_PRIORS) .and. &
                    keeps_name(EVEN, -OF_DATA, OF_PRIORS))
    call test%check('  but none that is worse',.not. keeps_name(WORSE, OF_DATA, OF_PRIORS))
    call test%check('priors that lose do not count',.not. keeps_name(EVEN, -OF_PRIORS, -OF_DATA))
  end subroutine test_prediction

  !> Whether a name stands whose prediction gains this, with an error of 0.5, and whose fit gains this of the data and the priors.
  logical function keeps_name(gain, of_data, of_priors)
    real(rp), intent(in) :: gain, of_data, of_priors
    type(diagnosis_options_t) :: options
    type(support_t) :: support
    type(prediction_t) :: prediction
    type(nested_fit_t) :: baseline, extended
    type(decision_t) :: one
    options%validates = .true.
    support%is_null_excluded = .true.
    prediction = prediction_t(gain=gain, gain_error=0.5_rp, has_gain=.true.)
    baseline%chi2 = 300 + of_data
    baseline%prior_chi2 = 100 + of_priors
    extended%chi2 = 300
    extended%prior_chi2 = 100
    allocate (one%causes(0), one%set(0), one%wider(0), one%posterior(0))
    one%verdict = VERDICT_NAMED
    call withdraw_unsupported(options, support, prediction, baseline, extended, one)
    keeps_name = one%verdict == VERDICT_NAMED
    call test%check('  without it, the decision gives the missing gain as its reason', keeps_name .neqv. one%reason == NO_GAIN)
  end function keeps_name

  !> The direction of the offset without that of drift.
  function second() result(direction)
    real(rp) :: direction(design%k)
    direction = first_basis(E_OFFSET)
    direction = direction - dot_product(direction, drift())*drift()
    direction = direction/norm2(direction)
  end function second

  !> Drift of 15 sd and so much of an offset that two causes have these odds against drift alone; unknown causes have none.
  subroutine make_pair(title, wanted, z, hypotheses, one)
    character(*), intent(in) :: title
    real(rp), intent(in) :: wanted
    real(rp), intent(out) :: z(:)
    type(hypotheses_t), intent(out) :: hypotheses
    type(decision_t), intent(out) :: one
    real(rp) :: other(design%k), low, high, odds
    integer :: i
    other = second()
    low = 0
    high = 8
    do i = 1, 40
      z = 15*drift() + 0.5_rp*(low + high)*other
      call hypotheses%init(design, N_EFFECTS, z)
      hypotheses%unknown = -1.0e3_rp
      call verdict_on(z, hypotheses, one)
      odds = one%posterior_joint/one%posterior(E_DRIFT)
      if (odds > wanted) high = 0.5_rp*(low + high)
      if (odds <= wanted) low = 0.5_rp*(low + high)
    end do
    call test%check(title, abs(odds/wanted - 1) < 1.0e-3_rp)
  end subroutine make_pair

  subroutine verdict_on(z, hypotheses, decision)
    real(rp), intent(in) :: z(:)
    type(hypotheses_t), intent(in) :: hypotheses
    type(decision_t), intent(out) :: decision
    call judge(design, z, hypotheses, decision)
  end subroutine verdict_on

  subroutine judge(of_design, z, hypotheses, decision)
    type(design_t), intent(in) :: of_design
    real(rp), intent(in) :: z(:)
    type(hypotheses_t), intent(in) :: hypotheses
    type(decision_t), intent(out) :: decision
    type(statistics_t) :: statistics
    call find_statistics(of_design, N_EFFECTS, .true., z, 0.0_rp, statistics)
    call decide(of_design, calibration, statistics, hypotheses, z, SEED, decision)
  end subroutine judge

  function drift() result(direction)
    real(rp) :: direction(design%k)
    direction = first_basis(E_DRIFT)
  end function drift

  function first_basis(effect) result(direction)
    integer, intent(in) :: effect
    real(rp) :: direction(design%k)
    integer :: c
    do c = size(design%candidates), 1, -1
      if (design%candidates(c)%effect == effect .and. design%candidates(c)%df > 0) &
        direction = design%candidates(c)%basis(:, 1)
    end do
  end function first_basis
end program test_decision
