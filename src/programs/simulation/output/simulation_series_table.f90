! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the time series of a run as rows of a table. A row says all about its series: name of the file, columns, when a record is
!> due, and the procedure that gives its values. Root writes, and every record is flushed to the disk at once.
module simulation_series_table
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_thin_wings, only: thin_wings_t
  use fsi_wing_loads, only: wing_loads_t
  use fsi_wing_shape, only: wing_shape_t
  use io_series, only: series_t
  use simulation_opening, only: opening_t
  implicit none
  private
  public :: series_table_t, moment_t

  character(*), parameter, public :: TIME_COLUMN = 'time [T]'

  integer, parameter :: MOST = 64 !< series of a run

  !> When a record is due: after every pass of the fluid, before the solids move; at the end of every step, with its cost; after
  !> the passes that compute the integrals (tintegral); after the pass that has read the slip of wings without thickness.
  integer, parameter, public :: EVERY_PASS = 1, EVERY_STEP = 2, EVERY_INTEGRAL = 3, EVERY_SLIP = 4

  !> All that the values of a record may depend on. A part that the run does not have is not associated or not allocated. The
  !> pointers hold while records are written.
  type :: moment_t
    type(fluid_t), pointer :: fluid => null()
    type(flapping_wings_t), pointer :: wings => null() !< where they were in the last pass; at the end of a step not associated
    type(coupler_t), pointer :: coupler => null()
    type(thin_wings_t), pointer :: thin => null()
    type(wing_loads_t), allocatable :: loads(:)        !< (wings) in the last pass; of integrals
    real(rp) :: seconds = 0                            !< wall time of the step
    integer :: ranks = 1
    integer :: item = 0                                !< of the row: number of the wing, or the colour
    real(rp), allocatable :: spectra(:, :)             !< (0:shells-1, 3) at the beginning of the step, L^2/T^2
    real(rp), allocatable :: sampled(:, :)             !< (:, wings) loads at the beginning of the step
    type(wing_shape_t), allocatable :: shapes(:)       !< (wings) of flexible ones
  end type moment_t

  abstract interface
    !> Returns the record of a series, the time first; nothing if no record is due now. It is no function, since gfortran 12 frees
    !> a pointer to a function with an allocatable result.
    subroutine series_values(now, values)
      import :: moment_t, rp
      type(moment_t), intent(in) :: now
      real(rp), allocatable, intent(out) :: values(:)
    end subroutine series_values
  end interface

  !> One series.
  type :: row_t
    character(:), allocatable :: name
    character(40), allocatable :: columns(:) !< names with units, the time first; not allocated: something else writes the file
    integer :: due = EVERY_STEP
    integer :: item = 0
    procedure(series_values), pointer, nopass :: values => null()
    type(series_t) :: file
  end type row_t

  !> All series of a run.
  type :: series_table_t
    private
    type(row_t), allocatable :: rows(:) !< (MOST), the first n in use
    integer :: n = 0
  contains
    procedure :: add => table_add
    procedure :: add_name => table_add_name
    procedure :: open => table_open
    procedure :: write => table_write
    procedure :: check => table_check
    procedure :: close => table_close
  end type series_table_t

contains

  !> Adds a row, unless `exists` is false: the run then has no such series. --overwrite moves files that end with .t, so that `name`
  !> must.
  subroutine table_add(self, name, columns, due, values, item, exists)
    class(series_table_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(*), intent(in) :: columns(:) !< names with units, the time first
    integer, intent(in) :: due
    procedure(series_values) :: values
    integer, intent(in), optional :: item
    logical, intent(in), optional :: exists
    if (present(exists)) then
      if (.not. exists) return
    end if
    call self%add_name(name)
    associate (row => self%rows(self%n))
      row%columns = columns
      row%due = due
      row%values => values
      if (present(item)) row%item = item
    end associate
  end subroutine table_add

  !> Adds only the name of a file that something else writes, or a pattern if only a run knows the name.
  subroutine table_add_name(self, name)
    class(series_table_t), intent(inout) :: self
    character(*), intent(in) :: name
    call require(index(name, '.t', back=.true.) == len(name) - 1, 'simulation_series_table: a name that ends with .t: '//name)
    if (.not. allocated(self%rows)) allocate (self%rows(MOST))
    call require(self%n < MOST, 'simulation_series_table: fewer series')
    self%n = self%n + 1
    self%rows(self%n)%name = name
  end subroutine table_add_name

  !> Opens all files through `opening`, which keeps the first failure, or only lists their names. No row may be added afterwards.
  !> Collective.
  subroutine table_open(self, opening)
    class(series_table_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    integer :: i
    do i = 1, self%n
      associate (row => self%rows(i))
        if (associated(row%values)) then
          call opening%open(row%file, row%name, row%columns)
        else
          call opening%list(row%name)
        end if
      end associate
    end do
  end subroutine table_open

  !> Writes the records that are `due`. `check` or `close` reports a failure.
  subroutine table_write(self, due, now)
    class(series_table_t), intent(inout) :: self
    integer, intent(in) :: due
    type(moment_t), intent(inout) :: now
    real(rp), allocatable :: values(:)
    integer :: i
    do i = 1, self%n
      associate (row => self%rows(i))
        if (.not. associated(row%values) .or. row%due /= due) cycle
        now%item = row%item
        call row%values(now, values)
        if (size(values) > 0) call row%file%write(values)
      end associate
    end do
  end subroutine table_write

  !> Fails if the series called `name`, which must be in the table, could not be written. Collective.
  subroutine table_check(self, name, failure)
    class(series_table_t), intent(in) :: self
    character(*), intent(in) :: name
    type(failure_t), intent(inout) :: failure
    integer :: i
    do i = 1, self%n
      if (self%rows(i)%name == name) exit
    end do
    call require(i <= self%n, 'simulation_series_table: a series called '//name)
    call self%rows(i)%file%check(failure)
  end subroutine table_check

  !> Closes all files that were opened. Fails if any of them could not be written completely. Collective.
  subroutine table_close(self, failure)
    class(series_table_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    integer :: i
    do i = 1, self%n
      if (associated(self%rows(i)%values)) call self%rows(i)%file%close(failure)
    end do
  end subroutine table_close
end module simulation_series_table
