! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the variant of an effect that should replace the fitted one, by a Gauss-Newton step over sites.
!>
!> A scan by tangents at the baseline finds the position only roughly, because strong effects are not linear. At the fit with
!> strength a0 at one position, a strength a at another position has the residuals r - S0 a0 + S a, where S and S0 are the tangents
!> there. The error is of second order in the difference of both, which is small for positions that overlap.
module inference_refine_location
  use base_kinds, only: rp
  use base_lapack, only: orthogonalise
  use inference_design, only: design_t
  use inference_refit, only: nested_fit_t
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  implicit none
  private
  public :: add_finer, refine_location

contains

  !> Finds the candidate `next` of the same effect that promises the smallest sum of squares in place of candidate `c`, whose fit
  !> is `found`; 0 if there is none. Returns the expected decrease of the sum. For effects of one parameter only.
  subroutine refine_location(simulator, design, whitener, c, found, next, gain)
    class(simulator_t), intent(inout) :: simulator
    type(design_t), intent(in) :: design
    type(whitener_t), intent(in) :: whitener
    integer, intent(in) :: c
    type(nested_fit_t), intent(in) :: found
    integer, intent(out) :: next
    real(rp), intent(out) :: gain
    real(rp), allocatable :: raw(:), tangents(:, :), rows(:, :), basis(:, :), r(:, :), left(:)
    integer, allocatable :: rivals(:), columns(:), own(:)
    real(rp) :: least, square
    integer :: i, n, b
    logical :: is_valid
    next = 0
    gain = 0
    rivals = pack([(i, i=1, size(design%candidates))], design%candidates%effect == design%candidates(c)%effect)
    if (size(rivals) < 2 .or. size(design%candidates(c)%columns) /= 1) return
    b = simulator%n_baseline
    n = simulator%n_observations
    columns = [(i, i=1, b), (design%candidates(rivals(i))%columns(1), i=1, size(rivals))]
    allocate (raw(n), tangents(n, size(columns)), left(n + b))
    call simulator%evaluate(found%q, columns, found%state, raw, tangents, is_valid)
    if (.not. is_valid) return
    call whitener%apply_one(raw)
    call whitener%apply(tangents)
    allocate (rows(n + b, size(columns)), source=0.0_rp)
    rows(:n, :) = tangents
    do i = 1, b
      rows(n + i, i) = design%weight(i)
    end do
    left(:n) = raw
    left(n + 1:) = (found%q(:b) - design%prior)*design%weight
    call orthogonalise(rows(:, :b), basis, r)
    associate (variant_tangents => rows(:, b + 1:))
      variant_tangents = variant_tangents - matmul(basis, matmul(transpose(basis), variant_tangents))
      left = left - matmul(basis, matmul(left, basis))
      least = sum(left**2)
      own = pack([(i, i=1, size(rivals))], rivals == c)
      associate (column => design%candidates(c)%columns(1))
        left = left - variant_tangents(:, own(1))*(found%q(column) - simulator%parameters(column)%null)
      end associate
      do i = 1, size(rivals)
        square = sum(variant_tangents(:, i)**2)
        if (rivals(i) == c .or. .not. square > 0) cycle
        square = sum(left**2) - dot_product(variant_tangents(:, i), left)**2/square
        if (.not. least - square > gain) cycle
        gain = least - square
        next = rivals(i)
      end do
    end associate
  end subroutine refine_location

  !> Releases the finer variants about the best candidate best_of(effects) of each scan, 0: none, for the next design. The
  !> calibration stays that of the scan: finer variants only improve the position of an effect that the scan has found.
  subroutine add_finer(simulator, design, best_of, has_finer)
    class(simulator_t), intent(inout) :: simulator
    type(design_t), intent(in) :: design
    integer, intent(in) :: best_of(:)
    logical, intent(out) :: has_finer
    integer, parameter :: MOST = 60
    real(rp), allocatable :: distance(:)
    logical, allocatable :: is_left(:) ! not tried so far, and on the lattice
    integer :: e, i, k, best
    has_finer = .false.
    do e = 1, size(simulator%effects)
      if (best_of(e) == 0) cycle
      best = design%candidates(best_of(e))%variant
      associate (variants => simulator%effects(e)%variants)
        distance = [(norm2(variants(k)%site - variants(best)%site), k=1, size(variants))]
        do k = 1, MOST
          is_left = .not. variants%is_tried() .and. [(i /= simulator%effects(e)%anywhere, i=1, size(variants))]
          if (.not. any(is_left)) exit
          variants(minloc(distance, 1, mask=is_left))%is_released = .true.
          has_finer = .true.
        end do
      end associate
    end do
  end subroutine add_finer
end module inference_refine_location
