! SPDX-License-Identifier: GPL-3.0-or-later
!> The mask of wings does not depend on how the box is cut: to the bit on any process grid, across the boundaries
!> of ranks and of the periodic box.
!>
!> usage: test_wing_ranks [builtin|p3dfft]
program test_wing_ranks
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_penalty, only: penalty_t
  use fluid_solver, only: fluid_t
  use fsi_mask, only: mask_t
  use fsi_planform, only: elliptic_planform
  use fsi_planform_mesh, only: triangulate_planform
  use fsi_surface, only: surface_t
  use parallel_block, only: block_t
  use spectral_grid, only: grid_t, make_grid
  use support_fluid, only: make_fluid, NL
  use support_mask, only: field_t, fields_of, whole_block, pencil_block, turn, same_fields, empty_penalty
  use test_pick, only: asked_transform
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: POINTS(3) = [40, 48, 36]
  real(rp), parameter :: DX = 1.0_rp/POINTS(1), BOX(3) = POINTS*DX
  type(testkit_t) :: kit
  type(grid_t) :: grid
  type(surface_t) :: wings(2)
  type(field_t) :: whole, part
  type(mask_t) :: mask
  integer :: rows, columns, row, column
  logical :: same

  call kit%start(parallel=.true.)
  grid = make_grid(POINTS, BOX)
  call place(0.0_rp*BOX)
  call draw(whole_block(grid), whole)
  call kit%check('a wing crosses the boundary of the box in every direction', any(whole%chi(1, :, :) > 0) .and. &
                 any(whole%chi(POINTS(1), :, :) > 0) .and. any(whole%chi(:, 1, :) > 0) .and. &
                 any(whole%chi(:, POINTS(2), :) > 0) .and. any(whole%chi(:, :, 1) > 0) .and. &
                 any(whole%chi(:, :, POINTS(3)) > 0))
  call kit%check('both wings are there', any(whole%color == 2) .and. any(whole%color == 3))

  same = .true.
  do columns = 1, 5
    do rows = 1, 7
      do column = 0, columns - 1
        do row = 0, rows - 1
          call draw(pencil_block(grid, rows, columns, row, column), part)
          same = same .and. same_as_whole(pencil_block(grid, rows, columns, row, column), part)
        end do
      end do
    end do
  end do
  call kit%check('the mask is the same to the bit on 35 process grids', same)
  call test_transform_blocks()
  call test_images()
  call kit%finish()

contains

  !> Two wings at a hinge near a corner of the box, moved by `shift`.
  subroutine place(shift)
    real(rp), intent(in) :: shift(3)
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    integer :: i
    call triangulate_planform(elliptic_planform(0.05_rp, 0.6_rp, 0.25_rp, 0.4_rp), 0.04_rp, points, triangles)
    do i = 1, 2
      call wings(i)%init(points, triangles, i + 1)
      call wings(i)%place_rigid(points, turn([0.7_rp + 2*i, 0.5_rp - 0.8_rp*i, 0.3_rp*i]), &
                                [0.02_rp, BOX(2) - 0.01_rp, 0.03_rp] + shift, [0.1_rp, 0.2_rp, 0.3_rp], &
                                [3.0_rp, -1.0_rp, 2.0_rp])
    end do
  end subroutine place

  subroutine draw(block, field)
    type(block_t), intent(in) :: block
    type(field_t), intent(out) :: field
    type(penalty_t) :: list
    type(failure_t) :: failure
    call empty_penalty(block, list)
    call mask%init(grid, block, 2*DX, DX)
    call mask%draw(wings, list, failure)
    call fields_of(list, block, field)
  end subroutine draw

  logical function same_as_whole(block, part) result(same)
    type(block_t), intent(in) :: block
    type(field_t), intent(in) :: part
    type(field_t) :: cut
    associate (first => block%start + 1, last => block%start + block%count)
      cut%chi = whole%chi(:, first(2):last(2), first(3):last(3))
      cut%us = whole%us(:, :, first(2):last(2), first(3):last(3))
      cut%color = whole%color(:, first(2):last(2), first(3):last(3))
    end associate
    same = same_fields(part, cut)
  end function same_as_whole

  !> The blocks that the fluid really has on these ranks, with all process grids of this number of ranks.
  subroutine test_transform_blocks()
    type(fluid_t) :: fluid
    type(failure_t) :: failure
    character(600) :: text
    do rows = 1, kit%world%size
      if (mod(kit%world%size, rows) /= 0) cycle
      write (text, '(4(a,i0),3(a,f20.15),a)') '[Resolution]'//NL//'nx=', POINTS(1), NL//'ny=', POINTS(2), NL//'nz=', &
      POINTS(3), NL//'process_rows=', rows, NL//'[Geometry]'//NL//'xl=', BOX(1), NL//'yl=', BOX(2), NL//'zl=', BOX(3), &
        NL//'[Penalization]'//NL//'iPenalization=1'//NL//'iMask=none'//NL//'eps=1.0e-2'//NL//'[ReynoldsNumber]'//NL// &
        'nu=1.0e-2'//NL//'[Time]'//NL//'Tmax=1'//NL//'[InitialCondition]'//NL//'inicond=quiescent'//NL//'[Parallel]'// &
        NL//'transform='//asked_transform()
      call make_fluid(kit%world, trim(text), fluid)
      call mask%init(grid, fluid%rhs%block, 2*DX, DX)
      call mask%draw(wings, fluid%rhs%penalty, failure)
      call fields_of(fluid%rhs%penalty, fluid%rhs%block, part)
      call kit%check('the mask on the blocks of the transform is that of one rank', &
                     same_as_whole(fluid%rhs%block, part))
      call fluid%free()
    end do
  end subroutine test_transform_blocks

  !> Moving the wings by whole cells moves the mask, by whole boxes changes nothing; both to round-off of the
  !> coordinates, because the wings are placed elsewhere.
  subroutine test_images()
    integer, parameter :: CELLS(3) = [17, 20, 9]
    integer :: i, k
    call place(CELLS*DX)
    call draw(whole_block(grid), part)
    do k = 1, 3
      part%chi = cshift(part%chi, CELLS(k), k)
      part%color = cshift(part%color, CELLS(k), k)
    end do
    call kit%check_below('a wing inside of the box is that across its boundaries', maxval(abs(part%chi - whole%chi)), &
                         1.0e-12_rp)
    call kit%check('with its colours', all(part%color == whole%color .or. whole%chi < 1.0e-12_rp))
    do i = -2, 2
      call place([i, 1, -i]*BOX)
      call draw(whole_block(grid), part)
      call kit%check_below('wings in other periodic boxes are the same', maxval(abs(part%chi - whole%chi)), 1.0e-12_rp)
     call kit%check_below('with their velocity', maxval(abs(part%us - whole%us), mask=part%us > 0 .and. whole%us > 0), &
                           1.0e-12_rp)
    end do
  end subroutine test_images
end program test_wing_ranks
