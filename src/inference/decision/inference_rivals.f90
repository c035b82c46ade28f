! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the effects that the data cannot distinguish from the most probable one.
!>
!> A wider effect releases the parameters of another one and more of them, as `elasticity` those of `membrane_bending`. It explains
!> everything that its part explains. Where it explains no more, its part is a cause in either case: the part leads, and the wider
!> effect is no rival.
module inference_rivals
  use base_kinds, only: rp
  use inference_design, only: design_t, is_part_of
  use inference_hypotheses, only: expect_loss, hypotheses_t
  implicit none
  private
  public :: find_rivals, lead_with_part

  real(rp), parameter, public :: ALIAS_LOSS = 3.0_rp !< log likelihood by which causes must differ to be distinguished
  real(rp), parameter :: ALIAS_FRACTION = 0.01_rp !< of a cause's effect beyond the baseline: below it priors do not decide

contains

  !> Returns the effects of `ranked`, the most probable first. In front is the most probable part of the first effect, if there is
  !> one that explains as much: it is behind by no more than ALIAS_LOSS in evidence, and in likelihood, by fits where both were
  !> fitted, else by what tangents expect. z(k) is in units of the noise.
  function lead_with_part(design, hypotheses, ranked, z) result(order)
    type(design_t), intent(in) :: design
    type(hypotheses_t), intent(in) :: hypotheses
    integer, intent(in) :: ranked(:)
    real(rp), intent(in) :: z(:)
    integer, allocatable :: order(:)
    real(rp) :: loss, fraction
    integer :: i
    order = ranked
    do i = 2, size(order)
      if (hypotheses%effect(order(1)) - hypotheses%effect(order(i)) > ALIAS_LOSS) return
      associate (part => hypotheses%best(order(i)), whole => hypotheses%best(order(1)))
        if (.not. is_part_of(design%candidates(part), design%candidates(whole))) cycle
        call expect_loss(design, whole, part, z, loss, fraction)
      end associate
      if (hypotheses%is_fitted(order(1)) .and. hypotheses%is_fitted(order(i))) &
        loss = 0.5_rp*(hypotheses%left(order(i)) - hypotheses%left(order(1)))
      if (loss > ALIAS_LOSS) cycle
      order(:i) = [ranked(i), ranked(:i - 1)]
      return
    end do
  end function lead_with_part

  !> Finds the first effect of `order` and all that the data cannot distinguish from it: they fit nearly as well, or are expected
  !> to, unless fits have shown the tangents to be misleading and the effects to differ. An effect that differs by a fraction of
  !> ALIAS_FRACTION or less belongs to them even if priors have made its evidence small. z(k) is in units of the noise. Effects
  !> that fit nearly as well, and all of whose variants contain the first, are `wider` and not in the set.
  subroutine find_rivals(design, hypotheses, order, z, set, wider)
    type(design_t), intent(in) :: design
    type(hypotheses_t), intent(in) :: hypotheses
    integer, intent(in) :: order(:)
    real(rp), intent(in) :: z(:)
    integer, allocatable, intent(out) :: set(:), wider(:)
    real(rp) :: behind, loss, fraction, least
    logical :: is_wider
    integer :: i, c
    set = order(:1)
    allocate (wider(0))
    do i = 2, size(order)
      if (hypotheses%tell_apart(order(1), order(i), ALIAS_LOSS)) cycle
      behind = hypotheses%effect(order(1)) - hypotheses%effect(order(i))
      least = huge(least)
      is_wider = .true.
      do c = 1, size(design%candidates)
        if (design%candidates(c)%effect /= order(i)) cycle
        if (is_part_of(design%candidates(hypotheses%best(order(1))), design%candidates(c))) cycle
        is_wider = .false.
        call expect_loss(design, hypotheses%best(order(1)), c, z, loss, fraction)
        if (behind > 2*ALIAS_LOSS .and. fraction > ALIAS_FRACTION) cycle
        least = min(least, loss)
      end do
      if (behind > ALIAS_LOSS .and. least > ALIAS_LOSS) cycle
      if (is_wider) then
        wider = [wider, order(i)]
      else
        set = [set, order(i)]
      end if
    end do
  end subroutine find_rivals
end module inference_rivals
