! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives access to the process of a program: exit code, terminal, environment, wall clock.
module base_process
  use, intrinsic :: iso_c_binding, only: c_int
  use base_kinds, only: rp, i8
  implicit none
  private
  public :: exit_with, is_terminal, environment_value, wall_seconds, epoch_seconds, launched_rank, process_id
  public :: host_name, process_birth, random_word, date_and_clock, peak_memory

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

    function c_gethostname(name, size) result(error) bind(c, name='gethostname')
      use, intrinsic :: iso_c_binding, only: c_char, c_size_t
      import :: c_int
      character(kind=c_char), intent(out) :: name(*)
      integer(c_size_t), value :: size
      integer(c_int) :: error
    end function c_gethostname

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

  !> Returns the number of this process on its machine.
  integer function process_id()
    process_id = int(c_getpid())
  end function process_id

  !> Returns the name of the machine; empty if it has none.
  function host_name() result(name)
    use, intrinsic :: iso_c_binding, only: c_size_t, c_null_char
    character(:), allocatable :: name
    integer, parameter :: MOST = 256
    character(MOST) :: buffer
    buffer = ''
    name = ''
    if (c_gethostname(buffer, int(MOST, c_size_t)) /= 0) return
    name = trim(buffer(:index(buffer//c_null_char, c_null_char) - 1))
  end function host_name

  !> Returns when the process `id` of this machine began, in clock ticks since the machine started. Number and start time identify
  !> a process for good. 0 means that there is no such process or that it has ended; -1 that this system does not tell (no /proc).
  integer(i8) function process_birth(id) result(birth)
    integer, intent(in) :: id
    integer, parameter :: BEFORE = 19 ! words between the state of a process and its birth, see proc(5)
    character(2000) :: line
    character(1) :: state
    character(24) :: words(BEFORE - 1)
    integer :: status
    birth = -1
    call read_line(process_id(), status)
    if (status /= 0) return
    birth = 0
    call read_line(id, status)
    if (status /= 0) return
    ! The name, in parentheses, may hold anything.
    read (line(index(line, ')', back=.true.) + 1:), *, iostat=status) state, words, birth
    if (status /= 0 .or. state == 'Z' .or. state == 'X') birth = 0

  contains

    !> Reads the line of a process in /proc.
    subroutine read_line(process, status)
      integer, intent(in) :: process
      integer, intent(out) :: status
      character(12) :: number
      integer :: unit
      write (number, '(i0)') process
      line = ''
      open (newunit=unit, file='/proc/'//trim(number)//'/stat', action='read', status='old', iostat=status)
      if (status /= 0) return
      read (unit, '(a)', iostat=status) line
      close (unit)
    end subroutine read_line
  end function process_birth

  !> Returns the most memory that this process has had so far [byte]; 0 if this system does not tell (it has no /proc).
  integer(i8) function peak_memory() result(bytes)
    character(200) :: line
    integer :: unit, status
    bytes = 0
    open (newunit=unit, file='/proc/self/status', action='read', status='old', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      if (line(1:6) /= 'VmHWM:') cycle
      read (line(7:), *, iostat=status) bytes ! in units of 1024 bytes
      bytes = 1024*bytes
      exit
    end do
    close (unit)
  end function peak_memory

  !> Returns a number that no other call on any machine returns, as far as chance allows.
  integer(i8) function random_word() result(word)
    integer :: unit, status
    integer(i8) :: count
    open (newunit=unit, file='/dev/urandom', access='stream', form='unformatted', action='read', status='old', iostat=status)
    if (status == 0) then
      read (unit, iostat=status) word
      close (unit)
    end if
    if (status == 0) return
    call system_clock(count)
    word = ieor(ieor(count, shiftl(epoch_seconds(), 24)), shiftl(int(process_id(), i8), 8))
  end function random_word

  !> Returns the present date and time, as 2020-02-29 23:59:59.
  function date_and_clock() result(text)
    character(19) :: text
    character(8) :: date
    character(10) :: time
    call date_and_time(date, time)
    text = date(1:4)//'-'//date(5:6)//'-'//date(7:8)//' '//time(1:2)//':'//time(3:4)//':'//time(5:6)
  end function date_and_clock

  !> Tells whether somebody watches: standard output is a terminal, and standard error too, because launchers put a
  !> pseudo-terminal behind the output of batch jobs.
  logical function is_terminal()
    is_terminal = c_isatty(1_c_int) == 1 .and. c_isatty(2_c_int) == 1
  end function is_terminal

  !> Returns the value of an environment variable, empty if unset.
  function environment_value(name) result(value)
    character(*), intent(in) :: name
    character(:), allocatable :: value
    integer :: length, status
    call get_environment_variable(name, length=length, status=status)
    if (status /= 0) length = 0
    allocate (character(length) :: value)
    if (length > 0) call get_environment_variable(name, value)
  end function environment_value

  !> Returns the rank that a launcher gave this process, also before MPI is started; 0 without a launcher.
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

  !> Returns the seconds on a clock of which only differences are meaningful.
  real(rp) function wall_seconds()
    integer(i8) :: count, rate
    call system_clock(count, rate)
    wall_seconds = real(count, rp)/real(rate, rp)
  end function wall_seconds

  !> Returns the seconds since 1970, the unit in which job schedulers give their deadlines.
  integer(i8) function epoch_seconds()
    use, intrinsic :: iso_c_binding, only: c_null_ptr
    epoch_seconds = int(c_time(c_null_ptr), i8)
  end function epoch_seconds
end module base_process
