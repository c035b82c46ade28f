! SPDX-License-Identifier: GPL-3.0-or-later
!> Prints the timing table of a run over all ranks.
module parallel_report
  use base_errors, only: require
  use base_kinds, only: rp
  use base_timers, only: timers_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: report_timers

contains

  !> Prints for every region the calls of rank 0, the least, mean and largest time over the ranks, and the
  !> share of the mean in the region `total`. All ranks must have defined the same regions. Rank 0
  !> writes to `unit`. Collective.
  subroutine report_timers(world, timers, total, unit)
    type(world_t), intent(in) :: world
    type(timers_t), intent(in) :: timers
    integer, intent(in) :: total   !< number of the region that is the whole
    integer, intent(in) :: unit
    real(rp), allocatable :: least(:), mean(:), largest(:)
    real(rp) :: whole
    integer :: i, n, most, fewest

    n = timers%count()
    most = world%max_integer(n)
    fewest = -world%max_integer(-n)
    call require(most == fewest, 'report_timers: the ranks have different regions')
    call require(total >= 1 .and. total <= n, 'report_timers: no such region')
    allocate (mean(n))
    do i = 1, n
      mean(i) = timers%seconds(i)
    end do
    least = mean
    largest = mean
    call world%min_reals(least)
    call world%max_reals(largest)
    call world%sum_reals(mean)
    mean = mean/world%size
    if (.not. world%is_root) return
    whole = max(mean(total), tiny(whole))
    write (unit, '(a24,a12,3a12,a9)') 'region                  ', 'calls', 'min [s]', 'mean [s]', 'max [s]', &
      'share'
    do i = 1, n
      write (unit, '(a24,i12,3f12.3,f8.1,a1)') timers%name(i)//repeat(' ', 24), timers%calls(i), least(i), &
        mean(i), &
        largest(i), 100*mean(i)/whole, '%'
    end do
    flush (unit)
  end subroutine report_timers
end module parallel_report
