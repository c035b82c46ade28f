! SPDX-License-Identifier: GPL-3.0-or-later
!> Derives a verdict from the odds of all hypotheses.
!>
!> | verdict | when |
!> |---|---|
!> | adequate | chance alone gives tests and checks as significant as these in more than LEVEL of all experiments |
!> | named | one effect, or few together, leave nothing but noise; no other does; its posterior probability is high, and
!> names of this probability were right in most blind cases;
!> and were the truth an unknown cause of this strength, of any kind, the name would be rejected with a probability of at least
!> POWER |
!> | set | the same, but several effects do, or the data are too weak to exclude an unknown cause |
!> | unknown | the checks alone speak against the baseline; or no effects of the catalogue, up to three together, leave
!> nothing but noise; or an unknown cause is more probable than they are, and than one half |
!> | insufficient | there is nothing that the data could show |
module inference_decision
  use base_kinds, only: i8, rp
  use inference_calibration, only: calibration_t, statistics_t
  use inference_design, only: design_t
  use inference_distributions, only: log_add
  use inference_hypotheses, only: explain, explained_t, hypotheses_t, log_odds_unknown, log_prior, remainder_log_p, IMPOSSIBLE, &
                                  PRIOR_NONE, PRIOR_ONE, PRIOR_TWO, PRIOR_UNKNOWN
  use inference_joint_causes, only: find_joint_causes
  use inference_probability, only: calibrated_probability, MAP_OF_BENDING
  use inference_rejection, only: imitation, name_power
  use inference_rivals, only: find_rivals, lead_with_part
  implicit none
  private
  public :: decision_t, decide, rank_effects, reject_catalogue, withdraw_name, verdict_word, grade_of, is_sure_name, &
            probability_of_set, stated_probability, stated_rest

  integer, parameter, public :: VERDICT_ADEQUATE = 0, VERDICT_NAMED = 10, VERDICT_SET = 11, VERDICT_UNKNOWN = 12, &
                                VERDICT_INSUFFICIENT = 20 !< exit codes
  !> Words for the reason why the answer is a set and not a name.
  character(*), parameter, public :: ALIAS = 'alias', NO_POWER = 'not_rejectable', NOT_SURE = 'probability', &
                                     NO_FIT = 'no_fit', NO_INTERVAL = 'null_not_excluded', AT_BOUND = 'at_bound', &
                                     NO_GAIN = 'no_gain'
  real(rp), parameter, public :: LEVEL = 0.05_rp
  real(rp), parameter :: REMAINDER_LEVEL = 0.01_rp, POWER = 0.8_rp
  real(rp), parameter, public :: TESTS_FRACTION = 0.8_rp !< of the level, the rest is for the checks
  real(rp), parameter :: SECOND_ODDS = 3.0_rp !< for a further cause if one cause already leaves nothing but noise
  real(rp), parameter :: NAME_PROBABILITY = 0.9_rp          !< least probability of a name by the odds,
  real(rp), parameter, public :: LEAST_STATED = 0.8_rp      !< and least fraction of such names that were right
  real(rp), parameter :: LEAST_UNKNOWN = 0.5_rp !< probability below which the verdict is a set, which excludes no other cause
  integer, parameter :: POWER_DRAWS = 100, IMITATION_DRAWS = 40

  type :: decision_t
    integer :: verdict = VERDICT_INSUFFICIENT
    integer :: probability_map = MAP_OF_BENDING !< by which the probability is stated
    real(rp) :: log_p_global = 0            !< of tests and checks
    real(rp) :: log_p_tests = 0             !< of the catalogue and of unknown causes
    real(rp) :: log_p_checks = 0            !< of the checks of residuals
    logical :: is_rejected_by_checks = .false.       !< the checks alone speak against the baseline
    !> Posterior probability of the verdict: adequate, no cause at all; named, this cause, alone or with another one, or exactly
    !> these causes jointly; set, at least one of these is a cause; unknown, a cause that is not in the catalogue.
    real(rp) :: probability = 0
    integer, allocatable :: causes(:)       !< candidates of the best explanation
    !> Effects of which at least one is a cause: those that alone explain the data equally well, the cause first, or all causes.
    integer, allocatable :: set(:)
    integer, allocatable :: wider(:)        !< effects that contain the first of the set and explain the data as well
    logical :: is_joint = .false.           !< the set is no choice: its members explain the data jointly
    character(20) :: reason = ''            !< why it is a set: one of the words above, or blank
    logical :: has_further = .false.        !< the best explanation by several causes contains an effect of the set
    real(rp) :: remainder_log_p = 0         !< of what the causes leave
    real(rp) :: name_power = 0              !< see above; 0 where it was not computed
    real(rp) :: imitation = 0               !< of several causes: see imitation(); 0 where it was not computed
    !> |signal| of the causes in units of the noise: by the tangents, or by the fit of one if that is more
    real(rp) :: snr = 0
    real(rp), allocatable :: posterior(:)   !< (effects) each alone; the sum with the next three is 1
    real(rp) :: posterior_none = 0, posterior_joint = 0, posterior_unknown = 0
  end type decision_t

contains

  !> Returns the word for a verdict.
  pure function verdict_word(verdict) result(word)
    integer, intent(in) :: verdict
    character(:), allocatable :: word
    select case (verdict)
    case (VERDICT_ADEQUATE)
      word = 'adequate'
    case (VERDICT_NAMED)
      word = 'named'
    case (VERDICT_SET)
      word = 'consistent_with_set'
    case (VERDICT_UNKNOWN)
      word = 'unknown_cause'
    case default
      word = 'data_insufficient'
    end select
  end function verdict_word

  !> Returns the grade of a verdict. A: one answer, which an unknown cause of the same strength would not have received. B: the
  !> answer is consistent with the data, but other causes are not excluded. Verdicts that give no cause have no grade.
  pure character(1) function grade_of(verdict) result(grade)
    integer, intent(in) :: verdict
    grade = ' '
    if (verdict == VERDICT_NAMED) grade = 'A'
    if (verdict == VERDICT_SET) grade = 'B'
  end function grade_of

  !> Tells whether a name is sure enough if its probability is p by the odds, and is stated by this map.
  pure logical function is_sure_name(map, p)
    integer, intent(in) :: map
    real(rp), intent(in) :: p
    is_sure_name = p >= NAME_PROBABILITY .and. calibrated_probability(map, VERDICT_NAMED, p) >= LEAST_STATED
  end function is_sure_name

  !> Returns the probability to print for a verdict: the fraction of such verdicts that were right in blind cases. A set that would
  !> be a name but for its probability has no larger one than such names.
  pure real(rp) function stated_probability(decision) result(stated)
    type(decision_t), intent(in) :: decision
    stated = calibrated_probability(decision%probability_map, decision%verdict, decision%probability)
    if (decision%verdict == VERDICT_SET .and. decision%reason == NOT_SURE) &
      stated = min(stated, calibrated_probability(decision%probability_map, VERDICT_NAMED, decision%probability))
  end function stated_probability

  !> Returns what a set leaves of 1: the probabilities to print of an unknown cause, of several causes together, of another cause in
  !> the catalogue, and of no cause. They have the proportions of the odds and add up to 1 less that of the set. What blind cases
  !> take from the odds of a set are other causes: no cause is not more probable than by its odds.
  pure function stated_rest(decision) result(rest)
    type(decision_t), intent(in) :: decision
    real(rp) :: rest(4), none
    rest = [decision%posterior_unknown, decision%posterior_joint, &
            max(0.0_rp, sum(decision%posterior) - probability_of_set(decision)), decision%posterior_none]
    if (decision%is_joint .or. decision%has_further) rest(2) = 0
    rest = (1 - stated_probability(decision))*rest/max(sum(rest), tiny(1.0_rp))
    none = min(rest(4), decision%posterior_none)
    if (sum(rest(:3)) > 0) then
      rest(:3) = rest(:3)*(1 + (rest(4) - none)/sum(rest(:3)))
    else
      rest(1) = rest(4) - none
    end if
    rest(4) = none
  end function stated_rest

  !> Returns the probability by the odds that one effect of the set is the cause, alone or as a part of a wider one.
  pure real(rp) function probability_of_set(decision) result(probability)
    type(decision_t), intent(in) :: decision
    probability = sum(decision%posterior(decision%set)) + sum(decision%posterior(decision%wider))
  end function probability_of_set

  !> Returns the effects that can be tested, the largest evidence first.
  pure function rank_effects(hypotheses) result(order)
    type(hypotheses_t), intent(in) :: hypotheses
    integer, allocatable :: order(:)
    real(rp) :: left(size(hypotheses%effect))
    integer :: e
    left = hypotheses%effect
    allocate (order(0))
    do
      e = maxloc(left, 1)
      if (e == 0) exit
      if (.not. left(e) > IMPOSSIBLE) exit
      order = [order, e]
      left(e) = IMPOSSIBLE
    end do
  end function rank_effects

  !> Finds the verdict for z(k), in units of the noise, with its statistics and hypotheses; nonlinear fits may have corrected the
  !> evidences. The checks of residuals, whose combined log p is `checks_log_p`, have a fraction of the level of their own. If they
  !> alone speak against the baseline, the cause is unknown.
  subroutine decide(design, calibration, statistics, hypotheses, z, seed, decision, checks_log_p)
    type(design_t), intent(in) :: design
    type(calibration_t), intent(in) :: calibration
    type(statistics_t), intent(in) :: statistics
    type(hypotheses_t), intent(in) :: hypotheses
    real(rp), intent(in) :: z(:)
    integer(i8), intent(in) :: seed
    type(decision_t), intent(out) :: decision
    real(rp), intent(in), optional :: checks_log_p
    type(explained_t) :: joint
    integer, allocatable :: order(:)
    real(rp) :: log_joint
    call begin(design%probability_map, decision)
    call find_global_p(calibration%log_p_global(statistics), checks_log_p, decision)
    order = rank_effects(hypotheses)
    call find_joint_causes(design, hypotheses, order, joint, log_joint)
    call find_posterior(hypotheses, size(order), log_joint, decision)
    order = lead_with_part(design, hypotheses, order, z)
    if (size(order) == 0 .and. size(design%families) == 0 .and. .not. decision%is_rejected_by_checks) return
    if (decision%log_p_global > log(LEVEL)) then
      decision%verdict = VERDICT_ADEQUATE
      decision%probability = decision%posterior_none
      return
    end if
    decision%verdict = VERDICT_UNKNOWN
    decision%probability = decision%posterior_unknown
    if (decision%is_rejected_by_checks) call reject_catalogue(decision, rejected_probability(decision))
    if (decision%is_rejected_by_checks .or. size(order) == 0) return
    call explain_by_one(design, calibration, hypotheses, order(1), z, decision)
    if (decision%remainder_log_p > log(REMAINDER_LEVEL) .and. &
        decision%posterior_joint <= SECOND_ODDS*maxval(decision%posterior)) then
      call find_rivals(design, hypotheses, order, z, decision%set, decision%wider)
      if (decision%posterior_unknown > max(LEAST_UNKNOWN, probability_of_set(decision))) then
        call leave_no_set(decision)
      else
        call name_or_set(design, calibration, seed, design%candidates(joint%members)%effect, decision)
      end if
    else if (size(joint%members) > 1) then
      decision%remainder_log_p = remainder_log_p(design, calibration, joint%left)
      if (decision%remainder_log_p <= log(REMAINDER_LEVEL)) then
        call reject_catalogue(decision, rejected_probability(decision))
        return
      end if
      if (decision%posterior_unknown > max(LEAST_UNKNOWN, decision%posterior_joint)) return
      decision%causes = joint%members
      decision%snr = sqrt(joint%square)
      decision%set = design%candidates(joint%members)%effect
      decision%is_joint = .true.
      call weigh_imitation(design, calibration, seed, order, decision)
      if (size(decision%set) > 0) call name_or_set(design, calibration, seed, decision%set, decision)
    else
      call reject_catalogue(decision, rejected_probability(decision))
    end if
  end subroutine decide

  !> Explains z(k) by one effect: its best candidate is the cause.
  subroutine explain_by_one(design, calibration, hypotheses, effect, z, decision)
    type(design_t), intent(in) :: design
    type(calibration_t), intent(in) :: calibration
    type(hypotheses_t), intent(in) :: hypotheses
    integer, intent(in) :: effect
    real(rp), intent(in) :: z(:)
    type(decision_t), intent(inout) :: decision
    type(explained_t) :: one
    call explain(design, [hypotheses%best(effect)], z, one)
    decision%causes = one%members
    decision%snr = sqrt(one%square)
    decision%remainder_log_p = remainder_log_p(design, calibration, one%left)
    if (hypotheses%is_fitted(effect)) then
      decision%snr = sqrt(max(one%square, hypotheses%gain(effect)))
      decision%remainder_log_p = hypotheses%remainder(effect)
    end if
  end subroutine explain_by_one

  !> Finds the p of tests and of checks, each with its fraction of the level, and whether the checks alone speak against the
  !> baseline.
  pure subroutine find_global_p(tests, checks, decision)
    real(rp), intent(in) :: tests
    real(rp), intent(in), optional :: checks
    type(decision_t), intent(inout) :: decision
    decision%log_p_tests = tests
    decision%log_p_global = tests
    if (.not. present(checks)) return
    decision%log_p_checks = checks
    decision%log_p_global = min(0.0_rp, tests - log(TESTS_FRACTION), checks - log(1 - TESTS_FRACTION))
    decision%is_rejected_by_checks = decision%log_p_global <= log(LEVEL) .and. tests > log(LEVEL*TESTS_FRACTION)
  end subroutine find_global_p

  !> Where several causes explain the data: finds how often the best ones of `order` would explain an unknown cause as well. If this
  !> makes it more probable than one half, the verdict is an unknown cause. (Odds judge unknown causes by tangents, and these causes
  !> by fits, which are more flexible.)
  subroutine weigh_imitation(design, calibration, seed, order, decision)
    type(design_t), intent(in) :: design
    type(calibration_t), intent(in) :: calibration
    integer(i8), intent(in) :: seed
    integer, intent(in) :: order(:)
    type(decision_t), intent(inout) :: decision
    real(rp) :: unknown
    associate (n => size(decision%set))
      decision%imitation = imitation(design, calibration, order, n, decision%snr, log(REMAINDER_LEVEL), IMITATION_DRAWS, seed)
      unknown = PRIOR_UNKNOWN*decision%imitation
      unknown = unknown/(unknown + PRIOR_TWO*(PRIOR_TWO/PRIOR_ONE)**(n - 2))
    end associate
    if (unknown > max(LEAST_UNKNOWN, decision%posterior_unknown)) call reject_catalogue(decision, unknown)
  end subroutine weigh_imitation

  !> Makes the verdict an unknown cause, with this probability. The other hypotheses keep their proportions in the rest of 1.
  pure subroutine reject_catalogue(decision, probability)
    type(decision_t), intent(inout) :: decision
    real(rp), intent(in) :: probability
    real(rp) :: factor
    factor = 0
    if (decision%posterior_unknown < 1) factor = (1 - probability)/(1 - decision%posterior_unknown)
    decision%posterior = factor*decision%posterior
    decision%posterior_none = factor*decision%posterior_none
    decision%posterior_joint = factor*decision%posterior_joint
    decision%posterior_unknown = probability
    decision%probability = probability
    decision%verdict = VERDICT_UNKNOWN
    decision%is_joint = .false.
    decision%reason = ''
    call leave_no_set(decision)
  end subroutine reject_catalogue

  !> Begins a decision that will state its probability by this map, without causes.
  pure subroutine begin(map, decision)
    integer, intent(in) :: map
    type(decision_t), intent(inout) :: decision
    decision%probability_map = map
    decision%causes = [integer ::]
    call leave_no_set(decision)
  end subroutine begin

  !> Empties the set and what is wider than its first effect.
  pure subroutine leave_no_set(decision)
    type(decision_t), intent(inout) :: decision
    decision%set = [integer ::]
    decision%wider = [integer ::]
  end subroutine leave_no_set

  !> Returns the posterior probability of an unknown cause if the best explanation of the catalogue leaves a remainder of this p,
  !> or if checks have this p, both for no cause and for every cause in the catalogue.
  pure real(rp) function rejected_probability(decision) result(probability)
    type(decision_t), intent(in) :: decision
    real(rp) :: other
    other = (PRIOR_ONE + PRIOR_TWO)*largest_odds(decision%remainder_log_p)
    if (decision%is_rejected_by_checks) other = (1 - PRIOR_UNKNOWN)*largest_odds(decision%log_p_checks)
    probability = max(decision%posterior_unknown, PRIOR_UNKNOWN/(PRIOR_UNKNOWN + other))
  end function rejected_probability

  !> Returns the factor -e p ln p. A small p is evidence of at most its inverse against an explanation (Sellke, Bayarri and Berger
  !> 2001, DOI 10.1198/000313001300339950), so that the odds of the explanation keep at least this factor.
  pure real(rp) function largest_odds(log_p) result(factor)
    real(rp), intent(in) :: log_p
    factor = 1
    if (log_p < -1) factor = -exp(1 + max(-700.0_rp, log_p))*log_p
  end function largest_odds

  !> Computes the posterior probabilities of all hypotheses.
  subroutine find_posterior(hypotheses, n, log_joint, decision)
    type(hypotheses_t), intent(in) :: hypotheses
    integer, intent(in) :: n
    real(rp), intent(in) :: log_joint
    type(decision_t), intent(inout) :: decision
    real(rp) :: total, unknown
    integer :: e
    decision%posterior = hypotheses%effect + log_prior(1, n)
    unknown = log_odds_unknown(hypotheses%unknown)
    total = log_add(log_add(log(PRIOR_NONE), unknown), log_joint)
    do e = 1, size(decision%posterior)
      total = log_add(total, decision%posterior(e))
    end do
    decision%posterior = exp(max(-700.0_rp, decision%posterior - total))
    decision%posterior_none = exp(max(-700.0_rp, log(PRIOR_NONE) - total))
    decision%posterior_joint = exp(max(-700.0_rp, log_joint - total))
    decision%posterior_unknown = exp(max(-700.0_rp, unknown - total))
  end subroutine find_posterior

  !> Decides on a name or a set, and its probability. `joint` are the effects of the best explanation by several.
  subroutine name_or_set(design, calibration, seed, joint, decision)
    type(design_t), intent(in) :: design
    type(calibration_t), intent(in) :: calibration
    integer(i8), intent(in) :: seed
    integer, intent(in) :: joint(:)
    type(decision_t), intent(inout) :: decision
    logical :: is_name
    integer :: i
    decision%name_power = name_power(design, calibration, design%candidates(decision%causes)%effect, &
                                     decision%snr, log(REMAINDER_LEVEL), POWER_DRAWS, seed)
    decision%has_further = any([(any(joint == decision%set(i)), i=1, size(decision%set))]) .or. &
                           any([(any(joint == decision%wider(i)), i=1, size(decision%wider))])
    if (decision%is_joint) then
      is_name = .true.
      decision%probability = decision%posterior_joint
    else
      is_name = size(decision%set) == 1
      decision%probability = probability_of_set(decision)
      ! A second cause in addition, however probable, would not make the first one wrong.
      if (is_name .and. decision%has_further) &
        decision%probability = min(1.0_rp, decision%probability + decision%posterior_joint)
    end if
    decision%verdict = VERDICT_NAMED
    if (.not. is_name) then
      call withdraw_name(decision, ALIAS)
    else if (decision%name_power < POWER) then
      call withdraw_name(decision, NO_POWER)
    else if (.not. is_sure_name(decision%probability_map, decision%probability)) then
      call withdraw_name(decision, NOT_SURE)
    end if
  end subroutine name_or_set

  !> Makes the verdict a set in place of a name, and keeps the reason.
  pure subroutine withdraw_name(decision, reason)
    type(decision_t), intent(inout) :: decision
    character(*), intent(in) :: reason
    decision%reason = reason
    decision%verdict = VERDICT_SET
    decision%probability = probability_of_set(decision)
    if (decision%has_further) decision%probability = min(1.0_rp, decision%probability + decision%posterior_joint)
  end subroutine withdraw_name
end module inference_decision
