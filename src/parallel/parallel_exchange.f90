! SPDX-License-Identifier: GPL-3.0-or-later
!> The exchange behind every transpose: blocks of complex numbers between all pairs of a communicator.
module parallel_exchange
  use base_kinds, only: rp
  use mpi_f08, only: MPI_Comm, MPI_Alltoallv, MPI_DOUBLE_COMPLEX, MPI_Wtime
  implicit none
  private
  public :: exchange

contains

  !> Sends near(q) numbers to each rank q and receives far(q) from it if `outward`; otherwise the two
  !> lists change roles, which is the way back. Blocks lie one behind the other in rank order. Adds the
  !> seconds it took to `seconds`. Collective over `comm`.
  subroutine exchange(comm, send, near, receive, far, outward, seconds)
    type(MPI_Comm), intent(in) :: comm
    complex(rp), contiguous, intent(in) :: send(:)
    complex(rp), contiguous, intent(inout) :: receive(:)
    integer, intent(in) :: near(0:), far(0:)
    logical, intent(in) :: outward
    real(rp), intent(inout) :: seconds
    real(rp) :: begun
    begun = MPI_Wtime()
    if (outward) then
      call MPI_Alltoallv(send, near, displacements(near), MPI_DOUBLE_COMPLEX, receive, far, displacements(far), &
                         MPI_DOUBLE_COMPLEX, comm)
    else
      call MPI_Alltoallv(send, far, displacements(far), MPI_DOUBLE_COMPLEX, receive, near, displacements(near), &
                         MPI_DOUBLE_COMPLEX, comm)
    end if
    seconds = seconds + MPI_Wtime() - begun
  end subroutine exchange

  !> Exclusive running sums.
  pure function displacements(counts) result(offsets)
    integer, intent(in) :: counts(:)
    integer :: offsets(size(counts)), i
    offsets(1) = 0
    do i = 2, size(counts)
      offsets(i) = offsets(i - 1) + counts(i - 1)
    end do
  end function displacements
end module parallel_exchange
