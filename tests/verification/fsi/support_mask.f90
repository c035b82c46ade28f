! SPDX-License-Identifier: GPL-3.0-or-later
!> Masks as dense fields, for tests that look at them.
module support_mask
  use base_kinds, only: rp
  use fluid_penalty, only: penalty_t
  use parallel_block, only: block_t, split_evenly
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: field_t, fields_of, whole_block, pencil_block, turn, same_fields, empty_penalty

  !> What the fluid sees on a block; colour -1 and zeros where there is no solid.
  type :: field_t
    real(rp), allocatable :: chi(:, :, :), us(:, :, :, :)
    integer, allocatable :: color(:, :, :)
  end type field_t

contains

  !> Spreads the points that the fluid sees.
  subroutine fields_of(penalty, block, field)
    type(penalty_t), intent(in) :: penalty
    type(block_t), intent(in) :: block
    type(field_t), intent(out) :: field
    integer :: y, z, line, i
    associate (n => block%count)
      allocate (field%chi(n(1), n(2), n(3)), field%us(3, n(1), n(2), n(3)), source=0.0_rp)
      allocate (field%color(n(1), n(2), n(3)), source=-1)
      do z = 1, n(3)
        do y = 1, n(2)
          line = y + n(2)*(z - 1)
          do i = penalty%line_first(line), penalty%line_last(line)
            field%chi(penalty%x(i), y, z) = penalty%chi(i)
            field%us(:, penalty%x(i), y, z) = penalty%us(:, i)
            field%color(penalty%x(i), y, z) = penalty%color(i)
          end do
        end do
      end do
    end associate
  end subroutine fields_of

  !> Whether all numbers are the same to the bit.
  logical function same_fields(a, b) result(same)
    type(field_t), intent(in) :: a, b
    same = all(abs(a%chi - b%chi) <= 0) .and. all(abs(a%us - b%us) <= 0) .and. all(a%color == b%color)
  end function same_fields

  !> The whole box on one rank.
  function whole_block(grid) result(block)
    type(grid_t), intent(in) :: grid
    type(block_t) :: block
    block = pencil_block(grid, 1, 1, 0, 0)
  end function whole_block

  !> The block of the fluid's transform on a process grid.
  function pencil_block(grid, rows, columns, row, column) result(block)
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: rows, columns, row, column
    type(block_t) :: block
    block%n = grid%n
    block%count(1) = grid%n(1)
    call split_evenly(grid%n(2), rows, row, block%start(2), block%count(2))
    call split_evenly(grid%n(3), columns, column, block%start(3), block%count(3))
  end function pencil_block

  !> Rotation by three angles about z, y, x.
  function turn(angles) result(r)
    real(rp), intent(in) :: angles(3)
    real(rp) :: r(3, 3), c(3), s(3)
    c = cos(angles)
    s = sin(angles)
    r = matmul(reshape([c(1), s(1), 0.0_rp, -s(1), c(1), 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp], [3, 3]), &
               matmul(reshape([c(2), 0.0_rp, -s(2), 0.0_rp, 1.0_rp, 0.0_rp, s(2), 0.0_rp, c(2)], [3, 3]), &
                      reshape([1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, c(3), s(3), 0.0_rp, -s(3), c(3)], [3, 3])))
  end function turn

  !> No solid that never moves.
  subroutine empty_penalty(block, penalty)
    type(block_t), intent(in) :: block
    type(penalty_t), intent(inout) :: penalty
    real(rp) :: chi(block%count(1)), us(3, block%count(1))
    integer :: color(block%count(1)), line
    chi = 0
    us = 0
    color = 0
    call penalty%begin(block)
    do line = 1, block%count(2)*block%count(3)
      call penalty%add_line(chi, us, color)
    end do
    call penalty%finish()
  end subroutine empty_penalty
end module support_mask
