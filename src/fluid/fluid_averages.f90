! SPDX-License-Identifier: GPL-3.0-or-later
!> Gathers means over time of velocity, kinetic energy and enstrophy density during the run: [Averaging], as in FLUSI.
!>
!>     mean f(t) = 1/(t - t_0) int_{t_0}^t f dt',  t_0 the first time not before tstart_avg,
!>
!> It integrates by the trapezoidal rule over the time steps. Over whole beats of a periodic flow this rule has no error except the
!> one from unequal steps. f is u, |u|^2/2 or |omega|^2/2, on the grid.
module fluid_averages
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_average_keys, only: average_params_t
  use fluid_solver, only: fluid_t
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use parallel_block, only: allocate_fields, block_t, rows_t
  implicit none
  private
  public :: averages_t

  integer, parameter, public :: MOST_AVERAGES = 5
  integer, parameter :: AVERAGE_UX = 1, AVERAGE_UZ = 3, AVERAGE_ENERGY = 4, AVERAGE_ENSTROPHY = 5
  character(7), parameter :: NAMES(MOST_AVERAGES) = [character(7) :: 'uavgx', 'uavgy', 'uavgz', 'ekinavg', 'zavg']

  !> Holds the state of the means: the sums, the time at which they begin, and the length of the previous step.
  type :: averages_t
    type(average_params_t) :: params
    integer :: n = 0                              !< number of fields
    integer, private :: kind(MOST_AVERAGES) = 0   !< kinds of the fields, AVERAGE_*
    character(7) :: name(MOST_AVERAGES) = ''      !< their prefixes
    real(rp), allocatable, private :: sum(:, :, :, :) !< (nx, ny_local, nz_local, n) int f dt
    real(rp), private :: since = 0                !< T; counts if `has_begun`
    real(rp), private :: dt_old = 0               !< length of the last step, 0 at the beginning, T
    logical, private :: has_begun = .false.
    type(rows_t), private :: rows                 !< lines along x
  contains
    procedure :: init => averages_init
    procedure :: wants => averages_wants
    procedure :: add => averages_add
    procedure :: mean => averages_mean
    procedure :: has => averages_has
    procedure :: save => averages_save
    procedure :: load => averages_load
  end type averages_t

contains

  !> Allocates the sums on this rank's `block` and sets them to 0. Every rank must call it, without waiting for others.
  subroutine averages_init(self, params, block)
    class(averages_t), intent(inout) :: self
    type(average_params_t), intent(in) :: params
    type(block_t), intent(in) :: block
    logical :: chosen(MOST_AVERAGES)
    integer :: i, z
    self%params = params
    chosen = [spread(params%velocity, 1, 3), params%kinetic_energy, params%enstrophy]
    self%n = count(chosen)
    self%kind(:self%n) = pack([(i, i=1, MOST_AVERAGES)], chosen)
    self%name(:self%n) = pack(NAMES, chosen)
    call allocate_fields(self%sum, block, self%n, 'averages over time')
    self%sum = 0
    self%rows%n = block%n(2)*block%n(3)
    self%rows%n_local = block%count(2)*block%count(3)
    self%rows%start = [(block%start(2) + block%n(2)*(block%start(3) + z), z=0, block%count(3) - 1)]
    self%rows%count = [(block%count(2), i=1, block%count(3))]
    self%rows%stride = [(1, i=1, block%count(3))]
  end subroutine averages_init

  !> Tells whether the step that begins at `time` [T] must keep the fields of its beginning for the means.
  pure logical function averages_wants(self, time) result(wants)
    class(averages_t), intent(in) :: self
    real(rp), intent(in) :: time
    wants = self%has_begun .or. time >= self%params%begin*(1 - 1.0e-12_rp)
  end function averages_wants

  !> Adds to the sums the step that `fluid` has made. The fluid must have kept the fields of the beginning of this step if
  !> `wants` asked for them.
  subroutine averages_add(self, fluid)
    class(averages_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    real(rp) :: weight
    integer :: i
    if (.not. self%wants(fluid%sums_time)) return
    if (.not. self%has_begun) self%since = fluid%sums_time
    self%has_begun = .true.
    weight = (self%dt_old + fluid%dt)/2
    do i = 1, self%n
      call add_field(self%kind(i), fluid%rhs%fields, weight, self%sum(:, :, :, i))
    end do
    self%dt_old = fluid%dt
  end subroutine averages_add

  !> Tells whether a mean exists at `time` [T], which needs some time since the beginning of the means.
  pure logical function averages_has(self, time) result(has)
    class(averages_t), intent(in) :: self
    real(rp), intent(in) :: time
    has = self%has_begun
    if (has) has = time > self%since
  end function averages_has

  !> Puts mean `i`, up to the time of the fields that `fluid` keeps, into `field` (nx, ny_local, nz_local).
  subroutine averages_mean(self, fluid, i, field)
    class(averages_t), intent(in) :: self
    type(fluid_t), intent(in) :: fluid
    integer, intent(in) :: i
    real(rp), intent(inout) :: field(:, :, :)
    field = self%sum(:, :, :, i)
    call add_field(self%kind(i), fluid%rhs%fields, self%dt_old/2, field)
    field = field/(fluid%sums_time - self%since)
  end subroutine averages_mean

  !> Adds `weight` times the density AVERAGE_* of the fields u and omega to `sum`.
  subroutine add_field(kind, fields, weight, sum)
    integer, intent(in) :: kind
    real(rp), intent(in) :: fields(:, :, :, :), weight
    real(rp), intent(inout) :: sum(:, :, :)
    select case (kind)
    case (AVERAGE_UX:AVERAGE_UZ)
      sum = sum + weight*fields(:, :, :, kind)
    case (AVERAGE_ENERGY)
      sum = sum + (weight/2)*(fields(:, :, :, 1)**2 + fields(:, :, :, 2)**2 + fields(:, :, :, 3)**2)
    case (AVERAGE_ENSTROPHY)
      sum = sum + (weight/2)*(fields(:, :, :, 4)**2 + fields(:, :, :, 5)**2 + fields(:, :, :, 6)**2)
    end select
  end subroutine add_field

  !> Writes the sums into an open checkpoint. Collective.
  subroutine averages_save(self, writer)
    class(averages_t), intent(in) :: self
    type(checkpoint_writer_t), intent(inout) :: writer
    integer :: i
    if (.not. self%has_begun) return
    call writer%put_reals('averages', [self%since, self%dt_old])
    do i = 1, self%n
      call writer%put_rows(trim(self%name(i)), reshape(self%sum(:, :, :, i), [size(self%sum, 1), self%rows%n_local]), &
                           self%rows)
    end do
  end subroutine averages_save

  !> Reads the sums from an open checkpoint. If the checkpoint lacks one of them, all means start at its time. Collective.
  subroutine averages_load(self, reader, failure)
    class(averages_t), intent(inout) :: self
    type(checkpoint_reader_t), intent(inout) :: reader
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: numbers(:), rows(:, :)
    integer :: i
    if (.not. reader%has('averages')) return
    do i = 1, self%n
      if (.not. reader%has(trim(self%name(i)))) return
    end do
    call reader%get_reals('averages', numbers, failure)
    if (failure%failed) return
    self%has_begun = .true.
    self%since = numbers(1)
    self%dt_old = numbers(2)
    allocate (rows(size(self%sum, 1), self%rows%n_local))
    do i = 1, self%n
      call reader%get_rows(trim(self%name(i)), rows, self%rows, failure)
      if (failure%failed) return
      self%sum(:, :, :, i) = reshape(rows, shape(self%sum(:, :, :, i)))
    end do
  end subroutine averages_load
end module fluid_averages
