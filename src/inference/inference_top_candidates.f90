! SPDX-License-Identifier: GPL-3.0-or-later
!> Fits the most probable effects without linearisation, and corrects their evidence by the result.
module inference_top_candidates
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_residual_checks, only: combined_log_p
  use inference_decision, only: decide, decision_t, probability_of_set, rank_effects, VERDICT_UNKNOWN
  use inference_design, only: is_part_of
  use inference_hypotheses, only: average_variants, explain, explained_t, hypotheses_t, remainder_log_p
  use inference_record, only: compress_at, diagnosis_options_t, model_t, refit_t, tests_t, LARGEST_SCALE
  use inference_places, only: place_found
  use inference_refine_location, only: refine_location
  use inference_refit, only: fit_nested, nested_fit_t, loose_options
  use inference_simulator, only: simulator_t
  use least_squares_fit, only: fit_options_t
  use least_squares_state, only: solver_state_t
  implicit none
  private

  public :: replace_refit, fit_extended, refit_top_candidates

  real(rp), parameter :: SHORTFALL = 20.0_rp !< of a sum of squares, in units of the noise; beyond it fits are tried from elsewhere
  real(rp), parameter :: FAR = 10.0_rp !< of the log evidence; effects that are less probable by more are not worth a fit

  !> The effects during the rounds of fits.
  type :: queue_t
    integer, allocatable :: order(:)      !< the most probable by the tangents first
    real(rp), allocatable :: linear(:)    !< (effects) log evidence by the tangents
    logical, allocatable :: is_tried(:)   !< (effects)
    real(rp) :: least = huge(1.0_rp)      !< smallest sum of squares per degree of freedom of the refits
    type(refit_t), allocatable :: before(:) !< with other nuisances, from which the fits of the same effects begin
    logical :: is_last = .false.          !< the last round
  end type queue_t

contains

  !> Fits the top candidates without linearisation, corrects their evidence by the error of the linear approximation, and decides
  !> again. It does not fit candidates that are far less probable in the linear approximation, unless other fits have shown this
  !> approximation to be wrong by as much. It fits every candidate that is a part of a fitted one. If most of the misfit remains, it
  !> fits all candidates until one leaves less. It fits all candidates that the tangents prefer to no cause, since the shape of some
  !> effects depends on their strength, before an unknown cause or several causes become the answer, or if the best effect owes most
  !> of its evidence to its fit. `refits` are the new fits, and before that those with other nuisances, from which these begin.
  subroutine refit_top_candidates(simulator, options, model, tests, hypotheses, refits, decision)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in), target :: model
    type(tests_t), intent(in) :: tests
    type(hypotheses_t), intent(out) :: hypotheses
    type(refit_t), allocatable, intent(inout) :: refits(:)
    type(decision_t), intent(out) :: decision
    type(queue_t) :: queue
    integer :: round, n_fitted
    hypotheses = tests%hypotheses
    queue%order = rank_effects(hypotheses)
    queue%linear = hypotheses%effect
    allocate (queue%is_tried(size(queue%linear)), source=.false.)
    call move_alloc(refits, queue%before)
    allocate (refits(0))
    do round = 1, 2
      n_fitted = size(refits)
      queue%is_last = round == 2
      call refit_round(simulator, options, model, tests, queue, hypotheses, refits)
      if (round == 2 .and. size(refits) == n_fitted) exit
      call improve_refits(simulator, options, model, tests, n_fitted, hypotheses, refits)
      call decide_anew(options, model, tests, hypotheses, decision)
      if (decision%verdict /= VERDICT_UNKNOWN .and. size(decision%causes) < 2 .and. &
          decision%posterior_unknown <= probability_of_set(decision) .and. .not. hypotheses%is_misled()) exit
    end do
  end subroutine refit_top_candidates

  !> Fits the effects of the queue that are worth a fit in this round. The last round goes through the queue twice, for parts of the
  !> effects that were fitted meanwhile.
  subroutine refit_round(simulator, options, model, tests, queue, hypotheses, refits)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in), target :: model
    type(tests_t), intent(in) :: tests
    type(queue_t), intent(inout) :: queue
    type(hypotheses_t), intent(inout) :: hypotheses
    type(refit_t), allocatable, intent(inout) :: refits(:)
    type(refit_t) :: one
    integer :: turn, place, effect
    do turn = 1, merge(2, 1, queue%is_last)*size(queue%order)
      place = modulo(turn - 1, size(queue%order)) + 1
      effect = queue%order(place)
      if (queue%is_tried(effect)) cycle
      if (.not. is_worth_it(simulator, options, model, tests, queue, place, hypotheses, refits)) cycle
      queue%is_tried(effect) = .true.
      call refit_effect(simulator, options, model, tests, queue, effect, hypotheses, one)
      if (.not. one%found%is_found) cycle
      call append(refits, one)
      queue%least = min(queue%least, one%found%chi2/max(1, simulator%n_observations - size(one%found%active)))
    end do
  end subroutine refit_round

  !> Tells whether the effect at index `place` of the queue is to be fitted in this round.
  logical function is_worth_it(simulator, options, model, tests, queue, place, hypotheses, refits)
    class(simulator_t), intent(in) :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in) :: model
    type(tests_t), intent(in) :: tests
    type(queue_t), intent(in) :: queue
    integer, intent(in) :: place
    type(hypotheses_t), intent(in) :: hypotheses
    type(refit_t), intent(in) :: refits(:)
    integer :: k
    associate (effect => queue%order(place), candidates => model%design%candidates)
      associate (candidate => candidates(hypotheses%best(effect)))
        is_worth_it = any([(is_part_of(candidate, candidates(refits(k)%candidate)), k=1, size(refits))])
        if (is_worth_it) return
        if (queue%is_last) then
          is_worth_it = queue%linear(effect) > 0 .or. any(simulator%parameters(candidate%columns)%strong > 0)
          return
        end if
      end associate
      is_worth_it = place <= options%most_refits .or. queue%least >= LARGEST_SCALE
      if (.not. is_worth_it .or. any(tests%decision%set == effect)) return
      is_worth_it = queue%linear(effect) >= queue%linear(queue%order(1)) - FAR - maxval(abs(hypotheses%correction))
    end associate
  end function is_worth_it

  !> Fits the leading variant of an effect, starting from its refit of before if there is one, and corrects its evidence. In the
  !> last round it fits loosely, and continues to convergence only if the loose fit brings the effect close to the others.
  subroutine refit_effect(simulator, options, model, tests, queue, effect, hypotheses, one)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in), target :: model
    type(tests_t), intent(in) :: tests
    type(queue_t), intent(in) :: queue
    integer, intent(in) :: effect
    type(hypotheses_t), intent(inout) :: hypotheses
    type(refit_t), intent(out) :: one
    type(refit_t) :: full
    logical :: is_better
    integer :: known ! index in queue%before
    known = findloc(model%design%candidates(queue%before%candidate)%effect, effect, 1)
    if (known > 0) then
      one%candidate = queue%before(known)%candidate
      call fit_extended(simulator, options, model, tests, [one%candidate], one%found, queue%before(known))
    else
      one%candidate = place_found(simulator, model%design, effect)
      if (one%candidate == 0) one%candidate = hypotheses%best(effect)
      call fit_extended(simulator, options, model, tests, [one%candidate], one%found, is_loose=queue%is_last)
    end if
    if (.not. one%found%is_found) return
    call apply_refit(simulator, model, tests, hypotheses, one)
    if (.not. queue%is_last .or. known > 0 .or. is_behind(hypotheses, effect)) return
    full = one
    call fit_extended(simulator, options, model, tests, [one%candidate], full%found, one)
    call replace_if_better(simulator, model, tests, 0.0_rp, hypotheses, full, one, is_better)
  end subroutine refit_effect

  !> Repeats each fit, starting from the fits of which it is a part. For the fits after the first n_tried it also tries better
  !> positions.
  subroutine improve_refits(simulator, options, model, tests, n_tried, hypotheses, refits)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in), target :: model
    type(tests_t), intent(in) :: tests
    integer, intent(in) :: n_tried
    type(hypotheses_t), intent(inout) :: hypotheses
    type(refit_t), intent(inout) :: refits(:)
    type(refit_t) :: one
    integer :: i
    do i = 1, size(refits)
      one = refits(i)
      call fit_from_superset(simulator, options, model, tests, refits(merge(0, n_tried, i > n_tried) + 1:), hypotheses, one)
      refits(i) = one
    end do
    do i = n_tried + 1, size(refits)
      if (is_behind(hypotheses, model%design%candidates(refits(i)%candidate)%effect)) cycle
      one = refits(i)
      call refine_variant(simulator, options, model, tests, hypotheses, one)
      refits(i) = one
    end do
  end subroutine improve_refits

  !> Tells whether an effect has become so improbable that further fits of it are not worth their time.
  pure logical function is_behind(hypotheses, effect)
    type(hypotheses_t), intent(in) :: hypotheses
    integer, intent(in) :: effect
    is_behind = hypotheses%effect(effect) < maxval(hypotheses%effect) - FAR
  end function is_behind

  !> Appends `one` to the others.
  subroutine append(refits, one)
    type(refit_t), allocatable, intent(inout) :: refits(:)
    type(refit_t), intent(in) :: one
    type(refit_t), allocatable :: more(:)
    integer :: i
    allocate (more(size(refits) + 1))
    do i = 1, size(refits)
      more(i) = refits(i)
    end do
    more(size(more)) = one
    call move_alloc(more, refits)
  end subroutine append

  !> Replaces `one` by `other`, a fit of the same effect, if its sum of squares is smaller by more than `worth`.
  subroutine replace_if_better(simulator, model, tests, worth, hypotheses, other, one, is_better)
    class(simulator_t), intent(inout) :: simulator
    type(model_t), intent(in) :: model
    type(tests_t), intent(in) :: tests
    real(rp), intent(in) :: worth
    type(hypotheses_t), intent(inout) :: hypotheses
    type(refit_t), intent(inout) :: other, one
    logical, intent(out) :: is_better
    is_better = other%found%is_found
    if (is_better) is_better = other%found%cost() < one%found%cost() - worth
    if (.not. is_better) return
    call apply_refit(simulator, model, tests, hypotheses, other)
    one = other
  end subroutine replace_if_better

  !> Replaces the fit of a refit by `found`, another one of the same candidate, and decides again.
  subroutine replace_refit(simulator, options, model, tests, found, refit, hypotheses, decision)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in) :: model
    type(tests_t), intent(in) :: tests
    type(nested_fit_t), intent(in) :: found
    type(refit_t), intent(inout) :: refit
    type(hypotheses_t), intent(inout) :: hypotheses
    type(decision_t), intent(out) :: decision
    refit%found = found
    call apply_refit(simulator, model, tests, hypotheses, refit)
    call decide_anew(options, model, tests, hypotheses, decision)
  end subroutine replace_refit

  !> Decides again with the results of all refits, by which the hypotheses were corrected.
  subroutine decide_anew(options, model, tests, hypotheses, decision)
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in) :: model
    type(tests_t), intent(in) :: tests
    type(hypotheses_t), intent(inout) :: hypotheses
    type(decision_t), intent(out) :: decision
    call hypotheses%correct_unknown(model%design)
    call decide(model%design, model%calibration, tests%statistics, hypotheses, tests%z, options%seed, decision, &
                combined_log_p(tests%checks))
  end subroutine decide_anew

  !> Corrects the evidence of an effect by its refit. Residuals are evaluated in the state in which the fit ended, because the model
  !> may have other solutions with the same parameters.
  subroutine apply_refit(simulator, model, tests, hypotheses, one)
    class(simulator_t), intent(inout) :: simulator
    type(model_t), intent(in) :: model
    type(tests_t), intent(in) :: tests
    type(hypotheses_t), intent(inout) :: hypotheses
    type(refit_t), intent(inout) :: one
    type(explained_t) :: alone
    type(failure_t) :: failure
    real(rp) :: z(model%design%k), residual_square, most, average
    integer :: best
    one%gain = (model%baseline%cost() - one%found%cost())/tests%scale
    call explain(model%design, [one%candidate], tests%z, alone)
    one%linear_gain = alone%square
    call compress_at(simulator, one%found%q, one%found%state, model%design, z, residual_square, failure)
    if (failure%failed) return
    z = z/sqrt(tests%scale)
    z = z - matmul(alone%basis, matmul(z, alone%basis))
    one%remainder_log_p = min(0.0_rp, remainder_log_p(model%design, model%calibration, z))
    associate (e => model%design%candidates(one%candidate)%effect)
      call average_variants(model%design, e, tests%z, best, most, average)
      hypotheses%best(e) = one%candidate
      call hypotheses%correct(e, 0.5_rp*(one%gain - one%linear_gain), one%gain, one%remainder_log_p, &
                              z + tests%z - alone%left, most - alone%log_evidence, one%found%chi2/tests%scale)
    end associate
  end subroutine apply_refit

  !> Fits an effect again, starting from those of the `others` of which it is a part and that are better. Such an effect may suffice
  !> alone, although the fit from the baseline, where its tangents do not show it, has not found it.
  subroutine fit_from_superset(simulator, options, model, tests, others, hypotheses, one)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in), target :: model
    type(tests_t), intent(in) :: tests
    type(refit_t), intent(in) :: others(:)
    type(hypotheses_t), intent(inout) :: hypotheses
    type(refit_t), intent(inout) :: one
    type(refit_t) :: other
    logical :: is_better
    integer :: k
    do k = 1, size(others)
      if (.not. is_part_of(model%design%candidates(one%candidate), model%design%candidates(others(k)%candidate))) cycle
      if (others(k)%found%cost() > one%found%cost() - SHORTFALL*tests%scale) cycle
      other = one
      call fit_extended(simulator, options, model, tests, [one%candidate], other%found, others(k))
      call replace_if_better(simulator, model, tests, 0.0_rp, hypotheses, other, one, is_better)
    end do
  end subroutine fit_from_superset

  !> Replaces the variant of a refit by other variants of its effect, as long as these promise to be better and prove to be so.
  subroutine refine_variant(simulator, options, model, tests, hypotheses, one)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in), target :: model
    type(tests_t), intent(in) :: tests
    type(hypotheses_t), intent(inout) :: hypotheses
    type(refit_t), intent(inout) :: one
    integer, parameter :: MOST = 4
    real(rp), parameter :: WORTH = 2.0_rp ! of the sum of squares, in units of the noise
    type(refit_t) :: other
    real(rp) :: gain
    logical :: is_better
    integer :: n
    other = one
    do n = 1, MOST
      call refine_location(simulator, model%design, model%whitener, one%candidate, one%found, other%candidate, gain)
      if (other%candidate == 0 .or. gain < WORTH*tests%scale) return
      call fit_extended(simulator, options, model, tests, [other%candidate], other%found, one)
      call replace_if_better(simulator, model, tests, WORTH*tests%scale, hypotheses, other, one, is_better)
      if (.not. is_better) return
    end do
  end subroutine refine_variant

  !> Fits the baseline with candidates, without linearisation, from the fit of the baseline. If this gains much less than the
  !> tangents promise, or if the tangents show little of the candidates, it also fits from the values before any fit: a parameter
  !> that a wrong model has driven to an extreme value does not recover. `near`, where given, is a refit of this or another variant,
  !> or of an effect of which the candidate is a part. A single candidate is then fitted from the end of `near`, and as without
  !> `near` only if that fails. The fit stops early if `is_loose`.
  subroutine fit_extended(simulator, options, model, tests, candidates, found, near, is_loose)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(model_t), intent(in), target :: model
    type(tests_t), intent(in) :: tests
    integer, intent(in) :: candidates(:)
    type(nested_fit_t), intent(out) :: found
    type(refit_t), intent(in), optional :: near
    logical, intent(in), optional :: is_loose
    type(nested_fit_t) :: other
    type(fit_options_t) :: how
    type(explained_t) :: joint
    class(solver_state_t), allocatable :: state
    integer, allocatable :: active(:)
    real(rp) :: q(size(simulator%parameters)), typical(size(simulator%parameters))
    logical :: is_strong
    integer :: i
    how = options%fit
    if (present(is_loose)) then
      if (is_loose) how = loose_options(how)
    end if
    active = model%baseline%active
    q = simulator%null_point()
    do i = 1, size(candidates)
      associate (one => model%design%candidates(candidates(i)))
        active = [active, one%columns]
        if (one%df > 0) q(one%columns) = q(one%columns) - matmul(one%solve, matmul(tests%z*sqrt(tests%scale), one%basis))
        if (candidates(i) == place_found(simulator, model%design, one%effect)) &
          q(one%columns) = simulator%effects(one%effect)%strength
        where (simulator%parameters(one%columns)%strong > 0) q(one%columns) = simulator%parameters(one%columns)%strong
      end associate
    end do
    typical = q
    if (present(near)) then
      associate (old => model%design%candidates(near%candidate)%columns, new => model%design%candidates(candidates(1))%columns)
        q = near%found%q
        q(old) = simulator%parameters(old)%null
        if (size(new) == size(old)) q(new) = near%found%q(old)
        if (size(new) < size(old)) q(new) = near%found%q(new)
        call simulator%take_places(q)
      end associate
      allocate (state, source=model%baseline%state)
      call state%take_shapes(near%found%state)
      call fit_nested(simulator, model%whitener, active, q, state, options%fit, found, typical)
      if (found%is_found) return
    end if
    q = model%baseline%q
    associate (added => active(size(model%baseline%active) + 1:))
      if (is_at_found_place(simulator, model, candidates)) q(added) = typical(added)
    end associate
    call fit_nested(simulator, model%whitener, active, q, model%baseline%state, how, found, typical)
    call explain(model%design, candidates, tests%z, joint)
    is_strong = any(simulator%parameters(active)%strong > 0)
    if (found%is_found .and. .not. is_strong .and. &
        model%baseline%cost() - found%cost() > tests%scale*(joint%square - SHORTFALL)) return
    q = max(simulator%parameters%lower, min(simulator%parameters%upper, typical))
    call fit_nested(simulator, model%whitener, active, q, model%baseline%state, how, other, typical)
    if (.not. other%is_found) return
    if (.not. found%is_found .or. other%cost() < found%cost()) found = other
  end subroutine fit_extended

  !> Tells whether one of the candidates is at a place that a search has found, with a strength at which fits begin.
  pure logical function is_at_found_place(simulator, model, candidates) result(is_it)
    class(simulator_t), intent(in) :: simulator
    type(model_t), intent(in) :: model
    integer, intent(in) :: candidates(:)
    integer :: i
    is_it = any([(candidates(i) == place_found(simulator, model%design, model%design%candidates(candidates(i))%effect), &
                  i=1, size(candidates))])
  end function is_at_found_place
end module inference_top_candidates
