! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves planes of the velocity, stacked over time as FLUSI does. A file such as sliceu1-ix0012_000000.h5 holds up to
!> `ncache_slices` planes at one position and of one component; its x axis is the time. slice_times.t lists the time of every plane
!> and the number of its file.
module simulation_slices
  use base_errors, only: failure_t
  use base_files, only: file_exists
  use base_kinds, only: rp
  use base_memory, only: check_allocation, REAL_BYTES
  use fluid_solver, only: fluid_t
  use io_fields, only: field_form_t, field_meta_t, write_field
  use io_series, only: series_t
  use io_series_read, only: read_series
  use parallel_block, only: block_t
  use simulation_opening, only: opening_t
  implicit none
  private
  public :: slices_t

  character(*), parameter :: TIMES = 'slice_times.t'

  !> Holds scratch memory and a few numbers. A checkpoint needs none of them, because all planes are written before it.
  type :: slices_t
    private
    integer, allocatable :: place(:)          !< x indices of the planes, from 0
    integer :: n_held = 0                     !< planes in the cache at each position
    integer :: number = 0                     !< number of the next file
    real(rp), allocatable :: time(:)          !< (size of the cache)
    real(rp), allocatable :: cache(:, :, :, :, :) !< (size of the cache, ny_local, nz_local, 3, places)
    type(series_t) :: times
  contains
    procedure :: init => slices_init
    procedure :: add => slices_add
    procedure :: flush => slices_flush
  end type slices_t

contains

  !> Makes room for `most` planes at each index in `place` that is not negative, and opens the list of times. Collective.
  subroutine slices_init(self, opening, block, place, most)
    class(slices_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    type(block_t), intent(in) :: block
    integer, intent(in) :: place(:), most
    real(rp), allocatable :: known(:, :)
    type(failure_t) :: unread
    integer :: status
    self%place = pack(place, place >= 0)
    allocate (self%time(most), self%cache(most, block%count(2), block%count(3), 3, size(self%place)), stat=status)
    call check_allocation(status, [most, block%count(2:3), 3, size(self%place)], REAL_BYTES, 'slices that wait to be written')
    if (opening%world%is_root .and. allocated(opening%restart_time) .and. file_exists(TIMES)) then
      call read_series(TIMES, 2, known, unread)
      if (.not. unread%failed) self%number = 1 + nint(maxval([-1.0_rp, pack(known(2, :), known(1, :) < opening%restart_time)]))
    end if
    call opening%world%broadcast_integer(self%number)
    call self%times%open(opening%world, TIMES, ['time [T]', 'file [-]'], opening%failure, opening%restart_time)
  end subroutine slices_init

  !> Adds the planes of the velocity that `fluid` keeps to the cache, and writes the cache if it is full. Collective.
  subroutine slices_add(self, fluid, meta, precision, failure)
    class(slices_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    type(field_meta_t), intent(in) :: meta
    integer, intent(in) :: precision
    type(failure_t), intent(inout) :: failure
    integer :: i
    self%n_held = self%n_held + 1
    self%time(self%n_held) = fluid%sums_time
    do i = 1, size(self%place)
      self%cache(self%n_held, :, :, :, i) = fluid%rhs%fields(self%place(i) + 1, :, :, 1:3) ! x is on one rank
    end do
    if (self%n_held == size(self%time)) call self%flush(fluid, meta, precision, failure)
  end subroutine slices_add

  !> Writes the planes in the cache. Collective.
  subroutine slices_flush(self, fluid, meta, precision, failure)
    class(slices_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    type(field_meta_t), intent(in) :: meta
    integer, intent(in) :: precision
    type(failure_t), intent(inout) :: failure
    type(block_t) :: block
    type(field_meta_t) :: of_stack
    character(14) :: name
    character(6) :: label
    integer :: i, c
    if (self%n_held == 0 .or. failure%failed) return
    block = fluid%transform%block
    block%n(1) = self%n_held
    block%start(1) = 0
    block%count(1) = self%n_held
    of_stack = meta
    of_stack%nxyz(1) = self%n_held
    of_stack%time = self%time(self%n_held)
    write (label, '(i6.6)') self%number
    do i = 1, size(self%place)
      do c = 1, 3
        write (name, '(a,i1,a,i4.4)') 'sliceu', c, '-ix', self%place(i)
        call write_field(fluid%rhs%world, name, block, self%cache(:self%n_held, :, :, c, i), of_stack, &
                         field_form_t('.', label, precision, 1), failure)
      end do
    end do
    do i = 1, self%n_held
      call self%times%write([self%time(i), real(self%number, rp)])
    end do
    call self%times%check(failure)
    self%number = self%number + 1
    self%n_held = 0
  end subroutine slices_flush
end module simulation_slices
