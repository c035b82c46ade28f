! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes a lock file that keeps two runs from writing the same files.
!>
!> The complete file appears under its name at once, and only one process succeeds: the file is written under another name and then
!> linked, which is exclusive on network file systems, too. It names machine and process, so that another run on that machine can
!> tell whether this one still runs. The lock file of a killed run is replaced.
module io_lock
  use base_errors, only: failure_t
  use base_files, only: file_exists, link_file, remove_file, rename_file
  use base_kinds, only: i8
  use base_process, only: date_and_clock, environment_value, host_name, process_birth, process_id
  use base_text_file, only: text_file_t
  use io_broadcast_text, only: read_text_file
  implicit none
  private
  public :: lock_t, LOCK_HELD, LOCK_TAKEN, LOCK_UNWRITABLE

  integer, parameter :: LOCK_HELD = 0       !< by this process
  integer, parameter :: LOCK_TAKEN = 1      !< by another one
  integer, parameter :: LOCK_UNWRITABLE = 2 !< a file cannot be written here
  character(*), parameter :: NL = new_line('a')

  type :: lock_t
    private
    character(:), allocatable :: path
    logical :: is_held = .false.
  contains
    procedure :: acquire => lock_acquire
    procedure :: release => lock_release
  end type lock_t

contains

  !> Takes the lock at `path`; `state` is one of the LOCK_ constants. Fails if it is not held then; the reason says what to do.
  !> `notice` is empty unless the lock file of a run that has ended was replaced. Not collective: for one rank.
  subroutine lock_acquire(self, path, state, notice, failure)
    class(lock_t), intent(inout) :: self
    character(*), intent(in) :: path
    integer, intent(out) :: state
    character(:), allocatable, intent(out) :: notice
    type(failure_t), intent(inout) :: failure
    type(failure_t) :: unmoved
    character(:), allocatable :: text, problem, message
    integer :: attempt
    notice = ''
    self%path = path
    do attempt = 1, 3
      call place(path, state)
      self%is_held = state == LOCK_HELD
      if (state /= LOCK_TAKEN) exit
      call read_text_file(path, text, problem)
      if (allocated(problem)) cycle ! the file has just disappeared
      if (.not. has_ended(text)) exit
      ! Only one of several processes that find it can remove it, and all of them try again.
      unmoved = failure_t()
      call rename_file(path, own_name(path)//'.stale', unmoved)
      if (.not. unmoved%failed) call remove_file(own_name(path)//'.stale')
      notice = path//' was left by process '//entry(text, 'process')//', which has ended'
    end do
    select case (state)
    case (LOCK_UNWRITABLE)
      call failure%raise(path//': cannot be written; is the folder missing or read-only, or the disk full?')
    case (LOCK_TAKEN)
      if (allocated(problem)) text = ''
      message = path//': another run writes here: process '//entry(text, 'process')//' on '//entry(text, 'host')
      if (entry(text, 'job') /= '?') message = message//', job '//entry(text, 'job')
      call failure%raise(message//', since '//entry(text, 'since')//'; if it has ended, remove '//path)
    end select
  end subroutine lock_acquire

  !> Puts a complete file at this place, unless there is one.
  subroutine place(path, state)
    character(*), intent(in) :: path
    integer, intent(out) :: state
    type(text_file_t) :: file
    character(:), allocatable :: own
    type(failure_t) :: unwritten
    logical :: is_linked
    state = LOCK_UNWRITABLE
    own = own_name(path)
    call file%create(own, unwritten)
    if (unwritten%failed) return
    call file%write(own_text(), unwritten)
    call file%close(unwritten)
    if (.not. unwritten%failed) then
      call link_file(own, path, is_linked)
      state = merge(LOCK_HELD, LOCK_TAKEN, is_linked)
      ! Some file systems have no links.
      if (.not. is_linked .and. .not. file_exists(path)) then
        call file%create_new(path, unwritten)
        if (unwritten%failed) then
          state = merge(LOCK_TAKEN, LOCK_UNWRITABLE, file_exists(path))
        else
          call file%write(own_text(), unwritten)
          call file%close(unwritten)
          state = merge(LOCK_UNWRITABLE, LOCK_HELD, unwritten%failed)
          if (unwritten%failed) call remove_file(path)
        end if
      end if
    end if
    call remove_file(own)
  end subroutine place

  !> Returns a name that no other process uses.
  function own_name(path) result(name)
    character(*), intent(in) :: path
    character(:), allocatable :: name
    character(12) :: number
    write (number, '(i0)') process_id()
    name = path//'.'//host_name()//'.'//trim(number)
  end function own_name

  !> Returns the text of a lock file of this process.
  function own_text() result(text)
    character(:), allocatable :: text
    character(24) :: process, birth
    write (process, '(i0)') process_id()
    write (birth, '(i0)') process_birth(process_id())
    text = '% A run writes here. It removes this file when it ends.'//NL//'host = '//host_name()//NL// &
           'process = '//trim(process)//NL//'birth = '//trim(birth)//NL
    if (environment_value('SLURM_JOB_ID') /= '') text = text//'job = '//environment_value('SLURM_JOB_ID')//NL
    text = text//'since = '//date_and_clock()
  end function own_text

  !> Tells whether the process that wrote this is known to have ended. The state of a process on another machine is unknown.
  logical function has_ended(text)
    character(*), intent(in) :: text
    integer(i8) :: birth, now
    integer :: process, status
    has_ended = .false.
    if (entry(text, 'host') /= host_name()) return
    read (text(index(text, NL//'process = ') + 11:), *, iostat=status) process
    if (status == 0) read (text(index(text, NL//'birth = ') + 9:), *, iostat=status) birth
    if (status /= 0) return
    now = process_birth(process)
    has_ended = now >= 0 .and. now /= birth
  end function has_ended

  !> Returns the value in the line `key = value`; ? if there is none.
  function entry(text, key) result(value)
    character(*), intent(in) :: text, key
    character(:), allocatable :: value
    integer :: first, last
    value = '?'
    first = index(text, NL//key//' = ')
    if (first == 0) return
    first = first + len(key) + 4
    last = first + index(text(first:)//NL, NL) - 2
    value = text(first:last)
  end function entry

  !> Removes the file, if this process holds it.
  subroutine lock_release(self)
    class(lock_t), intent(inout) :: self
    if (self%is_held) call remove_file(self%path)
    self%is_held = .false.
  end subroutine lock_release
end module io_lock
