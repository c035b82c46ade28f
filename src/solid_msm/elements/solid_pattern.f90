! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the pattern of the tangent: symmetric, in blocks of 3 x 3 for the pairs of free points.
!>
!> Values are assembled as blocks(3, 3, n_blocks) of the upper triangle and packed into the columns
!> that the sparse factorisation reads.
module solid_pattern
  use base_kinds, only: rp
  implicit none
  private
  public :: pattern_t, make_pattern

  !> The block columns 1..n. Column j holds the rows rows(start(j):start(j+1)-1), ascending, the last is j.
  type :: pattern_t
    integer :: n = 0                 !< free points
    integer, allocatable :: start(:), rows(:)
    integer, allocatable :: colptr(:), rowind(:) !< of the scalar upper triangle, 0-based
  contains
    procedure :: block_index => pattern_block_index
    procedure :: pack => pattern_pack
    procedure :: multiply => pattern_multiply
    procedure :: add_diagonal => pattern_add_diagonal
  end type pattern_t

contains

  !> Returns the pattern of the pairs(2, :) of free points 1..n. Pairs may repeat and be in any order; pairs with a 0 are dropped.
  !> The diagonal is always there.
  function make_pattern(n, pairs) result(self)
    integer, intent(in) :: n, pairs(:, :)
    type(pattern_t) :: self
    integer, allocatable :: first(:), filled(:), bucket(:)
    integer :: p, kept, j
    self%n = n
    allocate (first(n + 1), source=0)
    do p = 1, size(pairs, 2)
      if (minval(pairs(:, p)) > 0) first(maxval(pairs(:, p)) + 1) = first(maxval(pairs(:, p)) + 1) + 1
    end do
    first(1) = 1
    do j = 1, n
      first(j + 1) = first(j) + first(j + 1) + 1 ! one more for the diagonal
    end do
    allocate (bucket(first(n + 1) - 1), filled(n))
    filled = 0
    do j = 1, n
      call insert(j, j)
    end do
    do p = 1, size(pairs, 2)
      if (minval(pairs(:, p)) > 0) call insert(maxval(pairs(:, p)), minval(pairs(:, p)))
    end do
    allocate (self%start(n + 1))
    allocate (self%rows(sum(filled)))
    kept = 0
    do j = 1, n
      self%start(j) = kept + 1
      self%rows(kept + 1:kept + filled(j)) = bucket(first(j):first(j) + filled(j) - 1)
      kept = kept + filled(j)
    end do
    self%start(n + 1) = kept + 1
    call find_scalars(self)

  contains

    !> Adds a row to a column unless it is there, and keeps the rows in order.
    subroutine insert(column, row)
      integer, intent(in) :: column, row
      integer :: at
      at = first(column) + filled(column)
      do while (at > first(column))
        if (bucket(at - 1) == row) return
        if (bucket(at - 1) < row) exit
        at = at - 1
      end do
      bucket(at + 1:first(column) + filled(column)) = bucket(at:first(column) + filled(column) - 1)
      bucket(at) = row
      filled(column) = filled(column) + 1
    end subroutine insert
  end function make_pattern

  !> Makes the pattern of the matrix of scalars, upper part.
  subroutine find_scalars(self)
    type(pattern_t), intent(inout) :: self
    integer :: n, column, row, place, j, i
    n = self%n
    allocate (self%colptr(3*n + 1), self%rowind(9*(size(self%rows) - n) + 6*n))
    place = 0
    do column = 1, 3*n
      j = (column + 2)/3
      self%colptr(column) = place
      do i = self%start(j), self%start(j + 1) - 1
        do row = 3*self%rows(i) - 2, min(3*self%rows(i), column)
          place = place + 1
          self%rowind(place) = row - 1
        end do
      end do
    end do
    self%colptr(3*n + 1) = place
  end subroutine find_scalars

  !> Returns the number of the block of row i and column j, or minus that of (j, i) where i > j. It is 0 where i or j is 0
  !> (clamped), or where the pair is not in the pattern.
  pure integer function pattern_block_index(self, i, j) result(block)
    class(pattern_t), intent(in) :: self
    integer, intent(in) :: i, j
    integer :: k
    block = 0
    if (min(i, j) < 1) return
    do k = self%start(max(i, j)), self%start(max(i, j) + 1) - 1
      if (self%rows(k) == min(i, j)) block = k
    end do
    if (i > j) block = -block
  end function pattern_block_index

  !> Sets values(nnz) to the scalar columns of blocks(3, 3, n_blocks), in the order that `solid_cholesky` needs.
  pure subroutine pattern_pack(self, blocks, values)
    class(pattern_t), intent(in) :: self
    real(rp), intent(in) :: blocks(:, :, :)
    real(rp), intent(inout) :: values(:)
    integer :: j, c, k, at
    at = 0
    do j = 1, self%n
      do c = 1, 3
        do k = self%start(j), self%start(j + 1) - 2
          values(at + 1:at + 3) = blocks(:, c, k)
          at = at + 3
        end do
        values(at + 1:at + c) = blocks(1:c, c, self%start(j + 1) - 1)
        at = at + c
      end do
    end do
  end subroutine pattern_pack

  !> Adds factor*A x to y(3, n), where A is the symmetric matrix of the blocks. It needs full diagonal blocks.
  pure subroutine pattern_multiply(self, blocks, factor, x, y)
    class(pattern_t), intent(in) :: self
    real(rp), intent(in) :: blocks(:, :, :), factor, x(:, :)
    real(rp), intent(inout) :: y(:, :)
    real(rp) :: xj(3), yj(3)
    integer :: j, k, i
    do j = 1, self%n
      xj = factor*x(:, j)
      yj = 0
      do k = self%start(j), self%start(j + 1) - 2
        i = self%rows(k)
        y(:, i) = y(:, i) + blocks(:, 1, k)*xj(1) + blocks(:, 2, k)*xj(2) + blocks(:, 3, k)*xj(3)
        yj(1) = yj(1) + blocks(1, 1, k)*x(1, i) + blocks(2, 1, k)*x(2, i) + blocks(3, 1, k)*x(3, i)
        yj(2) = yj(2) + blocks(1, 2, k)*x(1, i) + blocks(2, 2, k)*x(2, i) + blocks(3, 2, k)*x(3, i)
        yj(3) = yj(3) + blocks(1, 3, k)*x(1, i) + blocks(2, 3, k)*x(2, i) + blocks(3, 3, k)*x(3, i)
      end do
      k = self%start(j + 1) - 1
      y(:, j) = y(:, j) + factor*yj + blocks(:, 1, k)*xj(1) + blocks(:, 2, k)*xj(2) + blocks(:, 3, k)*xj(3)
    end do
  end subroutine pattern_multiply

  !> Adds factor*diagonal(n) times the unit matrix to the diagonal blocks.
  pure subroutine pattern_add_diagonal(self, diagonal, factor, blocks)
    class(pattern_t), intent(in) :: self
    real(rp), intent(in) :: diagonal(:), factor
    real(rp), intent(inout) :: blocks(:, :, :)
    integer :: j, c, k
    do j = 1, self%n
      k = self%start(j + 1) - 1
      do c = 1, 3
        blocks(c, c, k) = blocks(c, c, k) + factor*diagonal(j)
      end do
    end do
  end subroutine pattern_add_diagonal
end module solid_pattern
