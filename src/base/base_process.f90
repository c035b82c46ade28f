! SPDX-License-Identifier: GPL-3.0-or-later
!> The few things a program asks of its process: exit code, terminal, environment, wall clock.
module base_process
  use, intrinsic :: iso_c_binding, only: c_int
  use base_kinds, only: rp, i8
  implicit none
  private
  public :: exit_with, is_terminal, environment_value, wall_seconds, epoch_seconds, launched_rank, process_id

  interface
    subroutine c_exit(code) bind(c, name='exit')
      import :: c_int
      integer(c_int), value :: code
    end subroutine c_exit

    function c_isatty(descriptor) result(yes) bind(c, name='isatty')
      import :: c_int
      integer(c_int), value :: descriptor
      integer(c_int) :: yes
    end function c_isatty

    function c_getpid() result(id) bind(c, name='getpid')
      import :: c_int
      integer(c_int) :: id
    end function c_getpid

    function c_time(ignored) result(seconds) bind(c, name='time')
      use, intrinsic :: iso_c_binding, only: c_long, c_ptr
      type(c_ptr), value :: ignored
      integer(c_long) :: seconds
    end function c_time
  end interface

contains

  !> Ends the process with `code`; Fortran 2008's stop takes constants only.
  subroutine exit_with(code)
    integer, intent(in) :: code
    call c_exit(int(code, c_int))
  end subroutine exit_with

  !> The number of this process on its machine.
  integer function process_id()
    process_id = int(c_getpid())
  end function process_id

  !> Whether somebody watches: standard output is a terminal, and standard error too, because launchers
  !> put a pseudo-terminal behind the output of batch jobs.
  logical function is_terminal()
    is_terminal = c_isatty(1_c_int) == 1 .and. c_isatty(2_c_int) == 1
  end function is_terminal

  !> Value of an environment variable, empty if unset.
  function environment_value(name) result(value)
    character(*), intent(in) :: name
    character(:), allocatable :: value
    integer :: length, status
    call get_environment_variable(name, length=length, status=status)
    if (status /= 0) length = 0
    allocate (character(length) :: value)
    if (length > 0) call get_environment_variable(name, value)
  end function environment_value

  !> The rank that a launcher gave this process, also before MPI is started; 0 without a launcher.
  integer function launched_rank() result(rank)
    character(20), parameter :: NAMES(4) = [character(20) :: 'OMPI_COMM_WORLD_RANK', 'PMIX_RANK', 'PMI_RANK', &
                                                                                                     'SLURM_PROCID']
    character(:), allocatable :: value
    integer :: i, status
    do i = 1, size(NAMES)
      value = environment_value(trim(NAMES(i)))
      if (value == '') cycle
      read (value, *, iostat=status) rank
      if (status == 0) return
    end do
    rank = 0
  end function launched_rank

  !> Seconds on a clock that only differences of are meaningful.
  real(rp) function wall_seconds()
    integer(i8) :: count, rate
    call system_clock(count, rate)
    wall_seconds = real(count, rp)/real(rate, rp)
  end function wall_seconds

  !> Seconds since 1970, as job schedulers tell their deadlines.
  integer(i8) function epoch_seconds()
    use, intrinsic :: iso_c_binding, only: c_null_ptr
    epoch_seconds = int(c_time(c_null_ptr), i8)
  end function epoch_seconds
end module base_process
