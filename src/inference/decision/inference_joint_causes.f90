! SPDX-License-Identifier: GPL-3.0-or-later
!> Searches for two or three effects that jointly explain the data.
!>
!> The best single effect may stand for several causes at once. The search therefore tries all pairs with one of the top
!> candidates, not only those with the first one, and then every third effect with the best pair. Finally it tries every effect in
!> place of each of the three, until no exchange improves the result.
module inference_joint_causes
  use base_kinds, only: rp
  use inference_design, only: design_t
  use inference_hypotheses, only: add_effect, explain, explained_t, hypotheses_t, log_prior, IMPOSSIBLE
  implicit none
  private
  public :: find_joint_causes

  integer, parameter :: MOST_JOINT = 3, MOST_CANDIDATES = 8, MOST_REFINEMENTS = 10

contains

  !> Finds the best two or three of the effects `order`, the most probable one first. log_joint is the logarithm of their odds.
  !> The others have to explain what the nonlinear fit of the first one leaves. If there are no two, it returns no members and
  !> IMPOSSIBLE.
  subroutine find_joint_causes(design, hypotheses, order, joint, log_joint)
    type(design_t), intent(in) :: design
    type(hypotheses_t), intent(in) :: hypotheses
    integer, intent(in) :: order(:)
    type(explained_t), intent(out) :: joint
    real(rp), intent(out) :: log_joint
    type(explained_t) :: next
    integer :: i
    allocate (joint%members(0))
    log_joint = IMPOSSIBLE
    if (size(order) < 2) return
    joint%log_evidence = IMPOSSIBLE
    do i = 1, min(size(order), MOST_CANDIDATES)
      call add_best(design, forward_selection(design, hypotheses, order(i:i)), order(i + 1:), joint)
    end do
    if (.not. joint%log_evidence > IMPOSSIBLE) return
    do while (size(joint%members) < min(MOST_JOINT, size(order)))
      next%log_evidence = IMPOSSIBLE
      call add_best(design, joint, order, next)
      if (.not. next%log_evidence > IMPOSSIBLE) exit
      call swap_members(design, hypotheses, order, next)
      if (next%log_evidence <= joint%log_evidence .or. log_odds(next) < log_odds(joint)) exit
      joint = next
    end do
    log_joint = log_odds(joint)

  contains

    real(rp) function log_odds(causes)
      type(explained_t), intent(in) :: causes
      log_odds = causes%log_evidence + log_prior(size(causes%members), size(order))
    end function log_odds

  end subroutine find_joint_causes

  !> Replaces members by other effects, one at a time, as long as that improves the result.
  subroutine swap_members(design, hypotheses, order, joint)
    type(design_t), intent(in) :: design
    type(hypotheses_t), intent(in) :: hypotheses
    integer, intent(in) :: order(:)
    type(explained_t), intent(inout) :: joint
    type(explained_t) :: one, best
    logical :: is_in(size(order)), is_other(size(order))
    integer :: m, j, n
    do n = 1, MOST_REFINEMENTS
      is_in = [(any(design%candidates(joint%members)%effect == order(j)), j=1, size(order))]
      best = joint
      do m = 1, size(order)
        if (.not. is_in(m)) cycle
        do j = 1, size(order)
          if (is_in(j)) cycle
          is_other = is_in
          is_other(m) = .false.
          is_other(j) = .true.
          one = forward_selection(design, hypotheses, pack(order, is_other))
          if (one%log_evidence > best%log_evidence) best = one
        end do
      end do
      if (.not. best%log_evidence > joint%log_evidence) exit
      joint = best
    end do
  end subroutine swap_members

  !> Returns these effects one after the other, the most probable one first, each with the variant that explains most in addition.
  function forward_selection(design, hypotheses, effects) result(known)
    type(design_t), intent(in) :: design
    type(hypotheses_t), intent(in) :: hypotheses
    integer, intent(in) :: effects(:)
    type(explained_t) :: known, next
    integer :: i
    call explain(design, hypotheses%best(effects(:1)), hypotheses%z(:, effects(1)), known)
    known%log_evidence = hypotheses%effect(effects(1))
    do i = 2, size(effects)
      call add_effect(design, known, effects(i), next)
      known = next
    end do
  end function forward_selection

  !> Sets `best` to `known` with one of the effects `others` that are not in it, if that has more evidence.
  subroutine add_best(design, known, others, best)
    type(design_t), intent(in) :: design
    type(explained_t), intent(in) :: known
    integer, intent(in) :: others(:)
    type(explained_t), intent(inout) :: best
    type(explained_t) :: one
    integer :: j
    do j = 1, size(others)
      if (any(design%candidates(known%members)%effect == others(j))) cycle
      call add_effect(design, known, others(j), one)
      if (one%log_evidence > best%log_evidence) best = one
    end do
  end subroutine add_best
end module inference_joint_causes
