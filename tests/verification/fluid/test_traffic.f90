! SPDX-License-Identifier: GPL-3.0-or-later
!> What a step sends: the counted bytes and messages of every rank are those of the model in docs/theory/transforms.md, to the
!> last byte, on 1 to 8 ranks and all their process grids. The model is written here from the rules of sharing alone.
program test_traffic
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use mpi_f08, only: MPI_Comm_free, MPI_Comm_split
  use parallel_world, only: world_t
  use support_fluid, only: make_fluid, NL
  use testkit, only: testkit_t
  implicit none
  !> Lengths with remainders: no number of ranks but 1 divides them all.
  integer, parameter :: N(3) = [22, 18, 20]
  type(testkit_t) :: test
  type(world_t) :: world
  integer :: ranks, rows

  call test%start(parallel=.true.)
  do ranks = 1, test%world%size
    call MPI_Comm_split(test%world%comm, merge(0, 1, test%world%rank < ranks), test%world%rank, world%comm)
    call world%adopt(world%comm)
    do rows = 1, ranks
      if (mod(ranks, rows) == 0) call check_grid(ranks, rows)
    end do
    call MPI_Comm_free(world%comm)
  end do
  call test%finish()

contains

  !> Steps of several kinds on the first `ranks` ranks; the others look on.
  subroutine check_grid(ranks, rows)
    integer, intent(in) :: ranks, rows
    character(200) :: text
    type(fluid_t) :: fluid
    type(request_t) :: request
    logical :: same(4)
    integer :: kind
    same = .true.
    if (test%world%rank < ranks) then
      write (text, '(4(a,i0))') '[Resolution]'//NL//'nx=', N(1), NL//'ny=', N(2), NL//'nz=', N(3), NL//'process_rows=', rows
      call make_fluid(world, trim(text)//NL//'[Geometry]'//NL//'xl=2.2'//NL//'yl=1.8'//NL//'zl=2.0'//NL// &
                      'Size=0.3'//NL//'[InitialCondition]'//NL//'inicond=VortexRing'//NL//'omega1=1.0'//NL// &
                      '[ReynoldsNumber]'//NL//'nu=0.02'//NL//'[Time]'//NL//'Tmax=1'//NL//'CFL=0.3'//NL, fluid)
      call one_step(fluid, request, 6, 3, rows, same(1)) ! the first one begins from physical fields
      call one_step(fluid, request, 6, 3, rows, same(2))
      do kind = 3, 4
        request%pressure = kind == 3
        request%integrals = kind == 4
        call one_step(fluid, request, merge(7, 6, request%integrals), merge(4, 3, request%pressure), rows, same(kind))
      end do
      call fluid%free()
    end if
    write (text, '(a,i0,a,i0)') ' is that of the model, ranks ', ranks, ', rows ', rows
    call test%check('what a step sends'//trim(text), same(2))
    call test%check('what a step that wants the pressure sends'//trim(text), same(3))
    call test%check('what a step that wants integrals sends'//trim(text), same(4))
  end subroutine check_grid

  !> Whether each rank sends what the model says for `inverse` and `forward` fields.
  subroutine one_step(fluid, request, inverse, forward, rows, same)
    type(fluid_t), intent(inout) :: fluid
    type(request_t), intent(in) :: request
    integer, intent(in) :: inverse, forward, rows
    logical, intent(out) :: same
    type(failure_t) :: failure
    integer(i8) :: sent(2), bytes, messages
    sent = [fluid%transform%traffic%bytes, fluid%transform%traffic%messages]
    call fluid%step(request, failure)
    sent = [fluid%transform%traffic%bytes, fluid%transform%traffic%messages] - sent
    call model(world%size, rows, world%rank, inverse, forward, bytes, messages)
    same = all(sent == [bytes, messages])
  end subroutine one_step

  !> The bytes and messages that rank `rank` sends. Rank = column*rows + row. Each inverse field but the vorticity along z goes
  !> from sticks to planes within the column's communicator, each goes from planes to lines within the row's, each forward
  !> field back. In physical z the vorticity is made of the velocity.
  !> A row may have no kx, and then it has nothing to send.
  subroutine model(ranks, rows, rank, inverse, forward, bytes, messages)
    integer, intent(in) :: ranks, rows, rank, inverse, forward
    integer(i8), intent(out) :: bytes, messages
    integer :: columns, row, column, q
    columns = ranks/rows
    row = mod(rank, rows)
    column = rank/rows
    bytes = 0
    messages = 0
    do q = 0, columns - 1
      if (q == column) cycle
      call send((inverse - 1)*sticks_of(rows, columns, row, column)*part(N(3), columns, q), bytes, messages)
      call send(forward*sticks_of(rows, columns, row, q)*part(N(3), columns, column), bytes, messages)
    end do
    do q = 0, rows - 1
      if (q == row) cycle
      call send(inverse*kx_of(rows, row)*part(N(2), rows, q)*part(N(3), columns, column), bytes, messages)
      call send(forward*kx_of(rows, q)*part(N(2), rows, row)*part(N(3), columns, column), bytes, messages)
    end do
  end subroutine model

  !> One message of complex numbers, if there are any.
  pure subroutine send(words, bytes, messages)
    integer, intent(in) :: words
    integer(i8), intent(inout) :: bytes, messages
    bytes = bytes + 16*words
    if (words > 0) messages = messages + 1
  end subroutine send

  !> Sticks of a rank: those of the columns kx that its row is dealt, shared evenly.
  pure integer function sticks_of(rows, columns, row, column) result(sticks)
    integer, intent(in) :: rows, columns, row, column
    integer :: jx, jy
    sticks = 0
    do jx = row, N(1)/2, rows
      do jy = -N(2)/2, N(2)/2 - 1
        if ((jx/limit(1))**2 + (jy/limit(2))**2 < 1) sticks = sticks + 1
      end do
    end do
    sticks = part(sticks, columns, column)
  end function sticks_of

  !> Columns kx that a row is dealt.
  pure integer function kx_of(rows, row)
    integer, intent(in) :: rows, row
    integer :: jx
    kx_of = 0
    do jx = row, N(1)/2, rows
      if (jx < limit(1)) kx_of = kx_of + 1
    end do
  end function kx_of

  !> The semi-axis of the ellipsoid of modes that are kept.
  pure real(rp) function limit(i)
    integer, intent(in) :: i
    limit = 2*(N(i)/2 - 1)/3.0_rp
  end function limit

  !> What part `i` of `parts` has of `n` things: the first ones have one more.
  pure integer function part(n, parts, i)
    integer, intent(in) :: n, parts, i
    part = n/parts
    if (i < mod(n, parts)) part = part + 1
  end function part
end program test_traffic
