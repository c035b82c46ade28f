! SPDX-License-Identifier: GPL-3.0-or-later
!> Fits the most probable effects without linearisation, and corrects their evidence by the result.
module inference_top_candidates
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_residual_checks, only: combined_log_p
  use inference_decision, only: decide, rank_effects, VERDICT_UNKNOWN
  use inference_design, only: is_part_of
  use inference_hypotheses, only: explain, explained_t, remainder_log_p
  use inference_record, only: compress_at, diagnosis_options_t, diagnosis_t, refit_t, LARGEST_SCALE
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
  end type queue_t

contains

  !> Fits the top candidates without linearisation, corrects their evidence by the error of the linear approximation, and decides
  !> again. It does not fit candidates that are far less probable in the linear approximation, unless other fits have shown this
  !> approximation to be wrong by as much. It fits every candidate that is a part of a fitted one. If most of the misfit remains, it
  !> fits all candidates until one leaves less. Before an unknown cause or several causes become the answer, it fits all candidates
  !> that the tangents prefer to no cause, because the shape of some effects depends on their strength. `before`, where given, are
  !> refits with other nuisances, from which the fits of the same effects begin.
  subroutine refit_top_candidates(simulator, options, d, before)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout) :: d
    type(refit_t), intent(in), optional :: before(:)
    type(queue_t) :: queue
    integer :: round, n_fitted
    queue%order = rank_effects(d%hypotheses)
    queue%linear = d%hypotheses%effect
    allocate (queue%is_tried(size(queue%linear)), source=.false.)
    if (allocated(d%refits)) deallocate (d%refits)
    allocate (d%refits(0))
    do round = 1, 2
      n_fitted = size(d%refits)
      call refit_round(simulator, options, round == 2, d, queue, before)
      if (round == 2 .and. size(d%refits) == n_fitted) exit
      call improve_refits(simulator, options, n_fitted, d)
      call decide_anew(options, d)
      if (d%decision%verdict /= VERDICT_UNKNOWN .and. size(d%decision%causes) < 2 .and. &
          d%decision%posterior_unknown <= sum(d%decision%posterior(d%decision%set))) exit
    end do
  end subroutine refit_top_candidates

  !> Fits the effects of the queue that are worth a fit in this round. The last round goes through the queue twice, for parts of the
  !> effects that were fitted meanwhile.
  subroutine refit_round(simulator, options, is_last, d, queue, before)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    logical, intent(in) :: is_last
    type(diagnosis_t), intent(inout) :: d
    type(queue_t), intent(inout) :: queue
    type(refit_t), intent(in), optional :: before(:)
    type(refit_t) :: one
    integer :: turn, place, effect
    do turn = 1, merge(2, 1, is_last)*size(queue%order)
      place = modulo(turn - 1, size(queue%order)) + 1
      effect = queue%order(place)
      if (queue%is_tried(effect)) cycle
      if (.not. is_worth_it(simulator, options, is_last, d, queue, place)) cycle
      queue%is_tried(effect) = .true.
      call refit_effect(simulator, options, is_last, effect, d, one, before)
      if (.not. one%found%is_found) cycle
      call append(d%refits, one)
      queue%least = min(queue%least, one%found%chi2/max(1, simulator%n_observations - size(one%found%active)))
    end do
  end subroutine refit_round

  !> Tells whether the effect at index `place` of the queue is to be fitted in this round.
  logical function is_worth_it(simulator, options, is_last, d, queue, place)
    class(simulator_t), intent(in) :: simulator
    type(diagnosis_options_t), intent(in) :: options
    logical, intent(in) :: is_last
    type(diagnosis_t), intent(in) :: d
    type(queue_t), intent(in) :: queue
    integer, intent(in) :: place
    integer :: k
    associate (effect => queue%order(place), candidates => d%design%candidates)
      associate (candidate => candidates(d%hypotheses%best(effect)))
        is_worth_it = any([(is_part_of(candidate, candidates(d%refits(k)%candidate)), k=1, size(d%refits))])
        if (is_worth_it) return
        if (is_last) then
          is_worth_it = queue%linear(effect) > 0 .or. any(simulator%parameters(candidate%columns)%strong > 0)
          return
        end if
      end associate
      is_worth_it = place <= options%most_refits .or. queue%least >= LARGEST_SCALE
      if (.not. is_worth_it .or. any(d%linear%set == effect)) return
      is_worth_it = queue%linear(effect) >= queue%linear(queue%order(1)) - FAR - maxval(abs(d%hypotheses%correction))
    end associate
  end function is_worth_it

  !> Fits the leading variant of an effect, starting from its refit in `before` if there is one, and corrects its evidence. In the
  !> last round it fits loosely, and continues to convergence only if the loose fit brings the effect close to the others.
  subroutine refit_effect(simulator, options, is_last, effect, d, one, before)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    logical, intent(in) :: is_last
    integer, intent(in) :: effect
    type(diagnosis_t), intent(inout) :: d
    type(refit_t), intent(out) :: one
    type(refit_t), intent(in), optional :: before(:)
    type(refit_t) :: full
    type(explained_t) :: alone
    logical :: is_better
    integer :: known ! index in `before`
    known = 0
    if (present(before)) known = findloc(d%design%candidates(before%candidate)%effect, effect, 1)
    if (known > 0) then
      one%candidate = before(known)%candidate
      call fit_extended(simulator, options, d, [one%candidate], one%found, before(known))
    else
      one%candidate = d%hypotheses%best(effect)
      call fit_extended(simulator, options, d, [one%candidate], one%found, is_loose=is_last)
    end if
    if (.not. one%found%is_found) return
    call explain(d%design, [one%candidate], d%z, alone)
    one%linear_gain = alone%square
    call apply_refit(simulator, d, one)
    if (.not. is_last .or. known > 0 .or. is_behind(d, effect)) return
    full = one
    call fit_extended(simulator, options, d, [one%candidate], full%found, one)
    call replace_if_better(simulator, d, full, one, 0.0_rp, is_better)
  end subroutine refit_effect

  !> Repeats each fit, starting from the fits of which it is a part. For the fits after the first n_tried it also tries better
  !> positions.
  subroutine improve_refits(simulator, options, n_tried, d)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    integer, intent(in) :: n_tried
    type(diagnosis_t), intent(inout) :: d
    type(refit_t) :: one
    integer :: i
    do i = 1, size(d%refits)
      one = d%refits(i)
      call fit_from_superset(simulator, options, d, one, merge(0, n_tried, i > n_tried))
      d%refits(i) = one
    end do
    do i = n_tried + 1, size(d%refits)
      if (is_behind(d, d%design%candidates(d%refits(i)%candidate)%effect)) cycle
      one = d%refits(i)
      call refine_variant(simulator, options, d, one)
      d%refits(i) = one
    end do
  end subroutine improve_refits

  !> Tells whether an effect has become so improbable that further fits of it are not worth their time.
  pure logical function is_behind(d, effect)
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: effect
    is_behind = d%hypotheses%effect(effect) < maxval(d%hypotheses%effect) - FAR
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
  subroutine replace_if_better(simulator, d, other, one, worth, is_better)
    class(simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(inout) :: d
    type(refit_t), intent(inout) :: other, one
    real(rp), intent(in) :: worth
    logical, intent(out) :: is_better
    is_better = other%found%is_found
    if (is_better) is_better = other%found%cost() < one%found%cost() - worth
    if (.not. is_better) return
    call apply_refit(simulator, d, other)
    one = other
  end subroutine replace_if_better

  !> Replaces refit i by `found`, a fit of the same candidate, and decides again.
  subroutine replace_refit(simulator, options, d, i, found)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout) :: d
    integer, intent(in) :: i
    type(nested_fit_t), intent(in) :: found
    type(refit_t) :: one
    one = d%refits(i)
    one%found = found
    call apply_refit(simulator, d, one)
    d%refits(i) = one
    call decide_anew(options, d)
  end subroutine replace_refit

  !> Decides again with the results of all refits.
  subroutine decide_anew(options, d)
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout) :: d
    call d%hypotheses%correct_unknown(d%design)
    call decide(d%design, d%calibration, d%statistics, d%hypotheses, d%z, options%seed, d%decision, combined_log_p(d%checks))
  end subroutine decide_anew

  !> Corrects the evidence of an effect by its refit. Residuals are evaluated in the state in which the fit ended, because the model
  !> may have other solutions with the same parameters.
  subroutine apply_refit(simulator, d, one)
    class(simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(inout) :: d
    type(refit_t), intent(inout) :: one
    type(explained_t) :: alone
    type(failure_t) :: failure
    real(rp) :: z(d%design%k), residual_square
    one%gain = (d%baseline%cost() - one%found%cost())/d%scale
    call explain(d%design, [one%candidate], d%z, alone)
    call compress_at(simulator, one%found%q, one%found%state, d%design, z, residual_square, failure)
    if (failure%failed) return
    z = z/sqrt(d%scale)
    z = z - matmul(alone%basis, matmul(z, alone%basis))
    one%remainder_log_p = min(0.0_rp, remainder_log_p(d%design, d%calibration, z))
    associate (e => d%design%candidates(one%candidate)%effect)
      d%hypotheses%best(e) = one%candidate
      call d%hypotheses%correct(e, 0.5_rp*(one%gain - one%linear_gain), one%gain, one%remainder_log_p, &
                                z + d%z - alone%left)
    end associate
  end subroutine apply_refit

  !> Fits an effect again, starting from better fits of which it is a part, except from the first n_tried refits. Such an effect may
  !> suffice alone, although the fit from the baseline, where its tangents do not show it, has not found it.
  subroutine fit_from_superset(simulator, options, d, one, n_tried)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout) :: d
    type(refit_t), intent(inout) :: one
    integer, intent(in) :: n_tried
    type(refit_t) :: other
    logical :: is_better
    integer :: k
    do k = n_tried + 1, size(d%refits)
      if (.not. is_part_of(d%design%candidates(one%candidate), d%design%candidates(d%refits(k)%candidate))) cycle
      if (d%refits(k)%found%cost() > one%found%cost() - SHORTFALL*d%scale) cycle
      other = one
      call fit_extended(simulator, options, d, [one%candidate], other%found, d%refits(k))
      call replace_if_better(simulator, d, other, one, 0.0_rp, is_better)
    end do
  end subroutine fit_from_superset

  !> Replaces the variant of a refit by other variants of its effect, as long as these promise to be better and prove to be so.
  subroutine refine_variant(simulator, options, d, one)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout) :: d
    type(refit_t), intent(inout) :: one
    integer, parameter :: MOST = 4
    real(rp), parameter :: WORTH = 2.0_rp ! of the sum of squares, in units of the noise
    type(refit_t) :: other
    real(rp) :: gain
    logical :: is_better
    integer :: n
    other = one
    do n = 1, MOST
      call refine_location(simulator, d%design, d%whitener, one%candidate, one%found, other%candidate, gain)
      if (other%candidate == 0 .or. gain < WORTH*d%scale) return
      call fit_extended(simulator, options, d, [other%candidate], other%found, one)
      call replace_if_better(simulator, d, other, one, WORTH*d%scale, is_better)
      if (.not. is_better) return
    end do
  end subroutine refine_variant

  !> Fits the baseline with candidates, without linearisation, from the fit of the baseline. If this gains much less than the
  !> tangents promise, or if the tangents show little of the candidates, it also fits from the values before any fit: a parameter
  !> that a wrong model has driven to an extreme value does not recover. `near`, where given, is a refit of this or another variant,
  !> or of an effect of which the candidate is a part. A single candidate is then fitted from the end of `near`, and as without
  !> `near` only if that fails. The fit stops early if `is_loose`.
  subroutine fit_extended(simulator, options, d, candidates, found, near, is_loose)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(in), target :: d
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
    active = d%baseline%active
    q = simulator%null_point()
    do i = 1, size(candidates)
      associate (one => d%design%candidates(candidates(i)))
        active = [active, one%columns]
        if (one%df > 0) q(one%columns) = q(one%columns) - matmul(one%solve, matmul(d%z*sqrt(d%scale), one%basis))
        where (simulator%parameters(one%columns)%strong > 0) q(one%columns) = simulator%parameters(one%columns)%strong
      end associate
    end do
    typical = q
    if (present(near)) then
      associate (old => d%design%candidates(near%candidate)%columns, new => d%design%candidates(candidates(1))%columns)
        q = near%found%q
        q(old) = simulator%parameters(old)%null
        if (size(new) == size(old)) q(new) = near%found%q(old)
        if (size(new) < size(old)) q(new) = near%found%q(new)
      end associate
      allocate (state, source=d%baseline%state)
      call state%take_shapes(near%found%state)
      call fit_nested(simulator, d%whitener, active, q, state, options%fit, found, typical)
      if (found%is_found) return
    end if
    call fit_nested(simulator, d%whitener, active, d%baseline%q, d%baseline%state, how, found, typical)
    call explain(d%design, candidates, d%z, joint)
    is_strong = any(simulator%parameters(active)%strong > 0)
    if (found%is_found .and. .not. is_strong .and. &
        d%baseline%cost() - found%cost() > d%scale*(joint%square - SHORTFALL)) return
    q = max(simulator%parameters%lower, min(simulator%parameters%upper, typical))
    call fit_nested(simulator, d%whitener, active, q, d%baseline%state, how, other, typical)
    if (.not. other%is_found) return
    if (found%is_found .and. .not. other%cost() < found%cost()) return
    found = other
  end subroutine fit_extended
end module inference_top_candidates
