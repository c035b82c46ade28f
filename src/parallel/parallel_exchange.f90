! SPDX-License-Identifier: GPL-3.0-or-later
!> Exchanges blocks of complex numbers between all pairs of a communicator, for every transpose, and counts the traffic.
module parallel_exchange
  use base_kinds, only: i8, rp
  use mpi_f08, only: MPI_Comm, MPI_Comm_rank, MPI_Alltoallv, MPI_DOUBLE_COMPLEX, MPI_Wtime
  implicit none
  private
  public :: exchange, traffic_t

  !> Traffic of this rank in exchanges so far. Data that stay on the rank do not count, nor do empty blocks.
  type :: traffic_t
    real(rp) :: seconds = 0
    integer(i8) :: bytes = 0    !< sent to other ranks
    integer(i8) :: messages = 0 !< sent to other ranks
  end type traffic_t

  integer(i8), parameter :: WORD = 16 !< bytes of a complex number

contains

  !> Sends given(q) numbers of each of `n_fields` fields to each rank q and receives taken(q) of each from it. Blocks lie in the
  !> order of ranks. Each has room for `room` fields, and the first `n_fields` are used. Adds the traffic to `traffic`. Collective
  !> over `comm`.
  subroutine exchange(comm, send, given, receive, taken, n_fields, room, traffic)
    type(MPI_Comm), intent(in) :: comm
    complex(rp), contiguous, intent(in) :: send(:)
    complex(rp), contiguous, intent(inout) :: receive(:)
    integer, intent(in) :: given(0:), taken(0:), n_fields, room
    type(traffic_t), intent(inout) :: traffic
    real(rp) :: begun
    begun = MPI_Wtime()
    call MPI_Alltoallv(send, n_fields*given, room*displacements(given), MPI_DOUBLE_COMPLEX, receive, n_fields*taken, &
                       room*displacements(taken), MPI_DOUBLE_COMPLEX, comm)
    traffic%seconds = traffic%seconds + MPI_Wtime() - begun
    call count_sent(comm, n_fields*given, traffic)
  end subroutine exchange

  !> Adds the blocks of `counts` numbers that went to other ranks.
  subroutine count_sent(comm, counts, traffic)
    type(MPI_Comm), intent(in) :: comm
    integer, intent(in) :: counts(0:)
    type(traffic_t), intent(inout) :: traffic
    integer :: q, own
    call MPI_Comm_rank(comm, own)
    do q = 0, size(counts) - 1
      if (q == own .or. counts(q) == 0) cycle
      traffic%bytes = traffic%bytes + WORD*counts(q)
      traffic%messages = traffic%messages + 1
    end do
  end subroutine count_sent

  !> Returns exclusive running sums.
  pure function displacements(counts) result(offsets)
    integer, intent(in) :: counts(:)
    integer :: offsets(size(counts)), i
    offsets(1) = 0
    do i = 2, size(counts)
      offsets(i) = offsets(i - 1) + counts(i - 1)
    end do
  end function displacements
end module parallel_exchange
