! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the memory of this machine, as Linux reports it: from /proc/meminfo and from the control group of this process (cgroup
!> v2 and v1), which batch systems and containers use.
module base_machine
  use base_kinds, only: i8, rp
  implicit none
  private
  public :: machine_memory_t, read_machine_memory

  type :: machine_memory_t
    logical :: is_known = .false.
    real(rp) :: total = huge(1.0_rp) !< [byte] that this process may ever use, swap space included
    real(rp) :: free = huge(1.0_rp)  !< [byte] that other processes leave free
  end type machine_memory_t

contains

  !> Returns the memory according to the files below `root`; `root` is empty except in tests.
  function read_machine_memory(root) result(memory)
    character(*), intent(in) :: root
    type(machine_memory_t) :: memory
    real(rp) :: total, swap, free
    total = value_of(root//'/proc/meminfo', 'MemTotal:')
    free = value_of(root//'/proc/meminfo', 'MemAvailable:')
    if (total < 0 .or. free < 0) return
    swap = max(0.0_rp, value_of(root//'/proc/meminfo', 'SwapTotal:'))
    memory%is_known = .true.
    memory%total = 1024*(total + swap)
    memory%free = 1024*free
    call apply_groups(root, memory)
  end function read_machine_memory

  !> Applies the limits of the group of this process: its own one and those of the groups around it.
  subroutine apply_groups(root, memory)
    character(*), intent(in) :: root
    type(machine_memory_t), intent(inout) :: memory
    character(1000) :: line
    integer :: unit, status
    open (newunit=unit, file=root//'/proc/self/cgroup', action='read', status='old', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      if (line(1:3) == '0::') then
        call climb(root//'/sys/fs/cgroup', trim(line(4:)), 'memory.max', 'memory.current', 'inactive_file', memory)
      else if (index(line, ':memory:') > 0) then
        call climb(root//'/sys/fs/cgroup/memory', trim(line(index(line, ':memory:') + 8:)), 'memory.limit_in_bytes', &
                   'memory.usage_in_bytes', 'total_inactive_file', memory)
      end if
    end do
    close (unit)
  end subroutine apply_groups

  !> Finds the limits of the group `path` and of the groups around it. Memory that caches files counts as free, because the system
  !> gives it back.
  subroutine climb(base, path, limit_name, use_name, cache_name, memory)
    character(*), intent(in) :: base, path, limit_name, use_name, cache_name
    type(machine_memory_t), intent(inout) :: memory
    character(:), allocatable :: group
    real(rp) :: limit, used, cached
    group = path
    do
      if (len(group) > 0) then
        if (group(len(group):) == '/') group = group(:len(group) - 1)
      end if
      limit = value_of(base//group//'/'//limit_name, '')
      if (limit >= 0 .and. limit < memory%total) memory%total = limit
      used = value_of(base//group//'/'//use_name, '')
      cached = max(0.0_rp, value_of(base//group//'/memory.stat', cache_name))
      if (limit >= 0 .and. used >= 0) memory%free = min(memory%free, max(0.0_rp, limit - used + cached))
      if (index(group, '/') == 0) exit
      group = group(:index(group, '/', back=.true.) - 1)
    end do
  end subroutine climb

  !> Returns the number behind `word` at the beginning of a line, or in the first line if the word is empty; -1 if there is none.
  real(rp) function value_of(path, word) result(value)
    character(*), intent(in) :: path, word
    character(200) :: line
    integer(i8) :: number
    integer :: unit, status
    value = -1
    open (newunit=unit, file=path, action='read', status='old', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      if (line(:len(word)) /= word) cycle
      read (line(len(word) + 1:), *, iostat=status) number
      if (status == 0) value = real(number, rp)
      exit
    end do
    close (unit)
  end function value_of
end module base_machine
