! SPDX-License-Identifier: GPL-3.0-or-later
!> Sheets on which markers are placed.
module marker_sheets
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  implicit none
  private
  public :: sheet_t, grid_sheet, bend, read_sheet, shake, least_distance

  type :: sheet_t
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
  end type sheet_t

contains

  !> A rectangle in the plane z = 0 of nx x ny cells of two triangles, without the cells whose numbers lie in `hole`
  !> (first and last along x, first and last along y).
  pure type(sheet_t) function grid_sheet(length, width, nx, ny, hole) result(sheet)
    real(rp), intent(in) :: length, width
    integer, intent(in) :: nx, ny
    integer, intent(in), optional :: hole(4)
    integer :: number(0:nx, 0:ny), i, j, k, without(4)
    without = [1, 0, 1, 0]
    if (present(hole)) without = hole
    allocate (sheet%points(3, (nx + 1)*(ny + 1)), sheet%triangles(3, 2*nx*ny))
    do j = 0, ny
      do i = 0, nx
        number(i, j) = 1 + i + (nx + 1)*j
        sheet%points(:, number(i, j)) = [length*i/nx, width*j/ny, 0.0_rp]
      end do
    end do
    k = 0
    do j = 1, ny
      do i = 1, nx
        if (i >= without(1) .and. i <= without(2) .and. j >= without(3) .and. j <= without(4)) cycle
        sheet%triangles(:, k + 1) = [number(i - 1, j - 1), number(i, j - 1), number(i, j)]
        sheet%triangles(:, k + 2) = [number(i - 1, j - 1), number(i, j), number(i - 1, j)]
        k = k + 2
      end do
    end do
    sheet%triangles = sheet%triangles(:, :k)
  end function grid_sheet

  !> Bends x into a circle of this radius about an axis along y.
  pure subroutine bend(sheet, radius)
    type(sheet_t), intent(inout) :: sheet
    real(rp), intent(in) :: radius
    integer :: i
    do i = 1, size(sheet%points, 2)
      associate (p => sheet%points(:, i))
        p = [radius*sin(p(1)/radius), p(2), radius*(1 - cos(p(1)/radius))]
      end associate
    end do
  end subroutine bend

  !> The wing of a wing file, of length 1; without points if it cannot be read.
  type(sheet_t) function read_sheet(path) result(sheet)
    character(*), intent(in) :: path
    type(wing_t) :: wing
    type(message_list_t) :: messages
    allocate (sheet%points(3, 0), sheet%triangles(3, 0))
    call read_wing(path, wing, messages)
    if (messages%count() > 0) return
    sheet%points = wing%points/maxval(wing%points(1, :))
    sheet%triangles = wing%triangles
  end function read_sheet

  !> Moves every point by about `amount`, as round-off would.
  pure subroutine shake(sheet, amount)
    type(sheet_t), intent(inout) :: sheet
    real(rp), intent(in) :: amount
    integer :: i
    do i = 1, size(sheet%points, 2)
      sheet%points(:, i) = sheet%points(:, i) + amount*sin(real([3, 5, 7]*i, rp))
    end do
  end subroutine shake

  !> Smallest distance between two of x (3, n).
  pure real(rp) function least_distance(x) result(least)
    real(rp), intent(in) :: x(:, :)
    integer :: i, j
    least = huge(1.0_rp)
    do i = 2, size(x, 2)
      do j = 1, i - 1
        least = min(least, norm2(x(:, i) - x(:, j)))
      end do
    end do
  end function least_distance

end module marker_sheets
