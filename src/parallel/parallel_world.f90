! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the communicator of a run, with the reductions that all layers need.
module parallel_world
  use base_blas, only: prepare_blas
  use base_kinds, only: rp, i8
  use mpi_f08, only: MPI_Comm, MPI_COMM_WORLD, MPI_COMM_SELF, MPI_Init, MPI_Finalize, MPI_Initialized, &
                     MPI_Comm_rank, MPI_Comm_size, MPI_Allreduce, MPI_Bcast, MPI_Barrier, MPI_IN_PLACE, &
                     MPI_DOUBLE_PRECISION, MPI_INTEGER8, MPI_INTEGER, MPI_SUM, MPI_MAX, MPI_MIN, &
                     MPI_CHARACTER, MPI_COMM_TYPE_SHARED, MPI_Comm_free, MPI_Comm_split, MPI_Comm_split_type, MPI_INFO_NULL
  implicit none
  private
  public :: world_t

  !> Communicator, rank and size; a collective procedure needs it.
  type :: world_t
    type(MPI_Comm) :: comm
    integer :: rank = 0
    integer :: size = 1
    logical :: is_root = .true. !< rank 0 prints and writes text files
  contains
    procedure :: start => world_start
    procedure :: stop => world_stop
    procedure :: adopt => world_adopt
    procedure :: isolate => world_isolate
    procedure :: split => world_split
    procedure :: release => world_release
    procedure :: sum_reals => world_sum_reals
    procedure :: max_reals => world_max_reals
    procedure :: min_reals => world_min_reals
    procedure :: sum_int8 => world_sum_int8
    procedure :: max_integer => world_max_integer
    procedure :: broadcast_integer => world_broadcast_integer
    procedure :: broadcast_integers => world_broadcast_integers
    procedure :: broadcast_reals => world_broadcast_reals
    procedure :: broadcast_text => world_broadcast_text
    procedure :: count_here => world_count_here
    procedure :: barrier => world_barrier
  end type world_t

contains

  !> Starts MPI (once per process) on all ranks, and sets up the BLAS (base_blas). Collective.
  subroutine world_start(self)
    class(world_t), intent(out) :: self
    logical :: started
    call MPI_Initialized(started)
    if (.not. started) call MPI_Init()
    call prepare_blas()
    call self%adopt(MPI_COMM_WORLD)
  end subroutine world_start

  !> Ends MPI. Collective; the last call of a program.
  subroutine world_stop(self)
    class(world_t), intent(inout) :: self
    call self%barrier()
    call MPI_Finalize()
  end subroutine world_stop

  !> Uses an existing communicator, for instance half of the ranks. Collective over `comm`.
  subroutine world_adopt(self, comm)
    class(world_t), intent(inout) :: self
    type(MPI_Comm), intent(in) :: comm
    self%comm = comm
    call MPI_Comm_rank(comm, self%rank)
    call MPI_Comm_size(comm, self%size)
    self%is_root = self%rank == 0
  end subroutine world_adopt

  !> Returns a world of the calling process alone, for files that it writes while the other ranks do something else.
  subroutine world_isolate(self)
    class(world_t), intent(inout) :: self
    call self%adopt(MPI_COMM_SELF)
  end subroutine world_isolate

  !> Makes the world `part` of all ranks of this world that give the same number `group`, >= 0, in the same order. Collective.
  subroutine world_split(self, group, part)
    class(world_t), intent(in) :: self
    integer, intent(in) :: group
    type(world_t), intent(out) :: part
    type(MPI_Comm) :: comm
    call MPI_Comm_split(self%comm, group, self%rank, comm)
    call part%adopt(comm)
  end subroutine world_split

  !> Releases a world that `split` has made. Collective over this world.
  subroutine world_release(self)
    class(world_t), intent(inout) :: self
    call MPI_Comm_free(self%comm)
  end subroutine world_release

  !> Replaces `values` by their sums over the ranks. Collective.
  subroutine world_sum_reals(self, values)
    class(world_t), intent(in) :: self
    real(rp), contiguous, intent(inout) :: values(:)
    call MPI_Allreduce(MPI_IN_PLACE, values, size(values), MPI_DOUBLE_PRECISION, MPI_SUM, self%comm)
  end subroutine world_sum_reals

  !> Replaces `values` by their maxima over the ranks. Collective. NaN is not propagated reliably.
  subroutine world_max_reals(self, values)
    class(world_t), intent(in) :: self
    real(rp), contiguous, intent(inout) :: values(:)
    call MPI_Allreduce(MPI_IN_PLACE, values, size(values), MPI_DOUBLE_PRECISION, MPI_MAX, self%comm)
  end subroutine world_max_reals

  !> Replaces `values` by their minima over the ranks. Collective.
  subroutine world_min_reals(self, values)
    class(world_t), intent(in) :: self
    real(rp), contiguous, intent(inout) :: values(:)
    call MPI_Allreduce(MPI_IN_PLACE, values, size(values), MPI_DOUBLE_PRECISION, MPI_MIN, self%comm)
  end subroutine world_min_reals

  !> Returns the sum of a 64-bit integer over the ranks, modulo 2**64 (checksums). Collective.
  integer(i8) function world_sum_int8(self, value) result(total)
    class(world_t), intent(in) :: self
    integer(i8), intent(in) :: value
    integer(i8) :: buffer(1)
    buffer(1) = value
    call MPI_Allreduce(MPI_IN_PLACE, buffer, 1, MPI_INTEGER8, MPI_SUM, self%comm)
    total = buffer(1)
  end function world_sum_int8

  !> Returns the largest integer over the ranks. Collective.
  integer function world_max_integer(self, value) result(largest)
    class(world_t), intent(in) :: self
    integer, intent(in) :: value
    integer :: buffer(1)
    buffer(1) = value
    call MPI_Allreduce(MPI_IN_PLACE, buffer, 1, MPI_INTEGER, MPI_MAX, self%comm)
    largest = buffer(1)
  end function world_max_integer

  !> Gives rank 0's integer to all. Collective.
  subroutine world_broadcast_integer(self, value)
    class(world_t), intent(in) :: self
    integer, intent(inout) :: value
    integer :: buffer(1)
    buffer(1) = value
    call MPI_Bcast(buffer, 1, MPI_INTEGER, 0, self%comm)
    value = buffer(1)
  end subroutine world_broadcast_integer

  !> Gives rank 0's integers to all; `values` has the same size everywhere. Collective.
  subroutine world_broadcast_integers(self, values)
    class(world_t), intent(in) :: self
    integer, contiguous, intent(inout) :: values(:)
    call MPI_Bcast(values, size(values), MPI_INTEGER, 0, self%comm)
  end subroutine world_broadcast_integers

  !> Gives the reals of rank 0, or of rank `from`, to all; `values` has the same size everywhere. Collective.
  subroutine world_broadcast_reals(self, values, from)
    class(world_t), intent(in) :: self
    real(rp), contiguous, intent(inout) :: values(:)
    integer, intent(in), optional :: from
    integer :: source
    source = 0
    if (present(from)) source = from
    call MPI_Bcast(values, size(values), MPI_DOUBLE_PRECISION, source, self%comm)
  end subroutine world_broadcast_reals

  !> Gives the text of rank 0, or of rank `from`, to all; on the others it may be unallocated on entry.
  !> Collective.
  subroutine world_broadcast_text(self, text, from)
    class(world_t), intent(in) :: self
    character(:), allocatable, intent(inout) :: text
    integer, intent(in), optional :: from
    character(:), allocatable :: buffer
    integer :: length(1), source
    source = 0
    if (present(from)) source = from
    length = 0
    if (self%rank == source) length = len(text)
    call MPI_Bcast(length, 1, MPI_INTEGER, source, self%comm)
    allocate (character(length(1)) :: buffer)
    if (self%rank == source) buffer = text
    call MPI_Bcast(buffer, length(1), MPI_CHARACTER, source, self%comm)
    call move_alloc(buffer, text)
  end subroutine world_broadcast_text

  !> Returns how many ranks share the memory of this machine. Collective.
  integer function world_count_here(self) result(n)
    class(world_t), intent(in) :: self
    type(MPI_Comm) :: here
    call MPI_Comm_split_type(self%comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, here)
    call MPI_Comm_size(here, n)
    call MPI_Comm_free(here)
  end function world_count_here

  !> Waits for all ranks. Collective.
  subroutine world_barrier(self)
    class(world_t), intent(in) :: self
    call MPI_Barrier(self%comm)
  end subroutine world_barrier
end module parallel_world
