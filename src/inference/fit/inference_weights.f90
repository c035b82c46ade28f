! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the prior probability of each variant of an effect, if the effect is there.
!>
!> All positions of a scan are equally probable. Finer positions are tried where the data have found an effect, so that their set
!> depends on the data. They therefore divide the weight that the scan gives to their neighbourhood.
module inference_weights
  use base_kinds, only: rp
  implicit none
  private
  public :: cell_weights

contains

  !> Returns weight(n) of variants at place(2, n). The weights add up to 1 over those that are shown and are 0 for others. A finer
  !> variant belongs to the cell of the nearest one of the scan. A cell has the weight that its variants of the scan would have
  !> without finer ones. All variants in it, finer or not, have the same weight.
  pure function cell_weights(site, is_finer, is_shown) result(weight)
    real(rp), intent(in) :: site(:, :)
    logical, intent(in) :: is_finer(:), is_shown(:)
    real(rp) :: weight(size(is_finer))
    logical :: is_scanned(size(is_finer))
    integer :: i, cell(size(is_finer))
    weight = 0
    is_scanned = is_shown .and. .not. is_finer
    if (.not. any(is_scanned)) is_scanned = is_shown
    cell = 0
    do i = 1, size(cell)
      if (is_shown(i)) cell(i) = minloc(norm2(site - spread(site(:, i), 2, size(cell)), 1), 1, mask=is_scanned)
    end do
    do i = 1, size(cell)
      if (.not. is_shown(i)) cycle
      weight(i) = real(count(is_scanned .and. cell == cell(i)), rp)/(count(is_scanned)*count(cell == cell(i)))
    end do
  end function cell_weights
end module inference_weights
