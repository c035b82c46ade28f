! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures elapsed time: named regions, with the number of calls and the elapsed time of each on this process.
!>
!> Regions get a number when a program is set up, and the step uses the number. Regions may nest; the time
!> of an inner one is part of the outer one.
module base_timers
  use base_errors, only: require
  use base_kinds, only: rp, i8
  implicit none
  private
  public :: timers_t

  integer, parameter :: MAX_REGIONS = 64, NAME_LENGTH = 32

  type :: timers_t
    private
    integer :: n = 0
    character(NAME_LENGTH) :: names(MAX_REGIONS) = ''
    integer(i8) :: ticks(MAX_REGIONS) = 0
    integer(i8) :: began(MAX_REGIONS) = 0
    integer(i8) :: calls_of(MAX_REGIONS) = 0
    logical :: running(MAX_REGIONS) = .false.
  contains
    procedure :: region => timers_region
    procedure :: start => timers_start
    procedure :: stop => timers_stop
    procedure :: count => timers_count
    procedure :: name => timers_name
    procedure :: calls => timers_calls
    procedure :: seconds => timers_seconds
  end type timers_t

contains

  !> Returns the number of the region `name` (up to 32 characters), which is new if there was none. At most 64.
  integer function timers_region(self, name) result(id)
    class(timers_t), intent(inout) :: self
    character(*), intent(in) :: name
    do id = 1, self%n
      if (self%names(id) == name) return
    end do
    call require(self%n < MAX_REGIONS .and. len(name) <= NAME_LENGTH, &
                 'timers_t%region: too many or too long: '//name)
    self%n = self%n + 1
    id = self%n
    self%names(id) = name
  end function timers_region

  !> Enters region `id`, which must not be running.
  subroutine timers_start(self, id)
    class(timers_t), intent(inout) :: self
    integer, intent(in) :: id
    call require(id >= 1 .and. id <= self%n, 'timers_t%start: no such region')
    call require(.not. self%running(id), 'timers_t%start: running already: '//trim(self%names(id)))
    self%running(id) = .true.
    call system_clock(self%began(id))
  end subroutine timers_start

  !> Leaves region `id`.
  subroutine timers_stop(self, id)
    class(timers_t), intent(inout) :: self
    integer, intent(in) :: id
    integer(i8) :: now
    call system_clock(now)
    call require(id >= 1 .and. id <= self%n, 'timers_t%stop: no such region')
    call require(self%running(id), 'timers_t%stop: not running: '//trim(self%names(id)))
    self%ticks(id) = self%ticks(id) + now - self%began(id)
    self%calls_of(id) = self%calls_of(id) + 1
    self%running(id) = .false.
  end subroutine timers_stop

  !> Returns the number of regions.
  pure integer function timers_count(self) result(n)
    class(timers_t), intent(in) :: self
    n = self%n
  end function timers_count

  !> Returns the name of region `id`.
  pure function timers_name(self, id) result(name)
    class(timers_t), intent(in) :: self
    integer, intent(in) :: id
    character(:), allocatable :: name
    name = trim(self%names(id))
  end function timers_name

  !> Returns how often region `id` was left.
  pure integer(i8) function timers_calls(self, id) result(calls)
    class(timers_t), intent(in) :: self
    integer, intent(in) :: id
    calls = self%calls_of(id)
  end function timers_calls

  !> Returns the elapsed time in region `id` [s], up to now if it is running.
  real(rp) function timers_seconds(self, id) result(seconds)
    class(timers_t), intent(in) :: self
    integer, intent(in) :: id
    integer(i8) :: now, rate, ticks
    call system_clock(now, rate)
    ticks = self%ticks(id)
    if (self%running(id)) ticks = ticks + now - self%began(id)
    seconds = real(ticks, rp)/real(rate, rp)
  end function timers_seconds
end module base_timers
