! SPDX-License-Identifier: GPL-3.0-or-later
!> Identifies the run to which a file belongs: by a random name that a run gets at its first start and keeps over restarts, and by
!> its inputs.
module io_identity
  use base_build, only: BUILD_COMMIT, BUILD_VERSION
  use base_checksum, only: checksum_text
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: i8
  use base_process, only: random_word
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  implicit none
  private
  public :: identity_t, change_t, list_changes

  !> The identity of a run. All ranks have the same.
  type :: identity_t
    character(:), allocatable :: id      !< 16 hexadecimal digits; not allocated: not known
    character(:), allocatable :: inputs  !< lines `[section] key = value` (config_t)
    character(:), allocatable :: version !< of the program that wrote last
  contains
    procedure :: start => identity_start
    procedure :: is_known => identity_is_known
    procedure :: fingerprint => identity_fingerprint
    procedure :: save => identity_save
    procedure :: load => identity_load
  end type identity_t

  !> An input that differs between two runs.
  type :: change_t
    character(:), allocatable :: name !< [section] key
    character(:), allocatable :: now, was
  contains
    procedure :: text => change_text
  end type change_t

  character(*), parameter :: NL = new_line('a'), EQUALS = ' = ', FILE_MARK = ' {content '

contains

  !> Makes the identity of a new run with these inputs. One rank calls it and sends the result to the others.
  subroutine identity_start(self, inputs)
    class(identity_t), intent(out) :: self
    character(*), intent(in) :: inputs
    self%id = hexadecimal(random_word())
    self%inputs = inputs
    self%version = BUILD_VERSION//' ('//BUILD_COMMIT//')'
  end subroutine identity_start

  !> Tells whether the identity is known.
  pure logical function identity_is_known(self) result(is_known)
    class(identity_t), intent(in) :: self
    is_known = allocated(self%id)
  end function identity_is_known

  !> Returns a checksum of the inputs.
  function identity_fingerprint(self) result(text)
    class(identity_t), intent(in) :: self
    character(16) :: text
    text = hexadecimal(checksum_text(self%inputs))
  end function identity_fingerprint

  !> Puts the identity into an open checkpoint. Collective.
  subroutine identity_save(self, writer)
    class(identity_t), intent(in) :: self
    type(checkpoint_writer_t), intent(inout) :: writer
    if (.not. self%is_known()) return
    call writer%put_text('run_id', self%id)
    call writer%put_text('run_inputs', self%inputs)
    call writer%put_text('run_fingerprint', self%fingerprint())
    call writer%put_text('run_version', self%version)
  end subroutine identity_save

  !> Takes the identity of the run which wrote an open checkpoint. The identity is unknown if the checkpoint has none. Collective.
  subroutine identity_load(self, reader, failure)
    class(identity_t), intent(out) :: self
    type(checkpoint_reader_t), intent(inout) :: reader
    type(failure_t), intent(inout) :: failure
    if (.not. reader%has('run_id') .or. failure%failed) return
    call reader%get_text('run_id', self%id, failure)
    call reader%get_text('run_inputs', self%inputs, failure)
    call reader%get_text('run_version', self%version, failure)
  end subroutine identity_load

  !> Returns the inputs that both runs know and that differ, in the order of the new one. A file that has another name and the
  !> same content does not differ.
  subroutine list_changes(was, now, changes)
    character(*), intent(in) :: was, now !< inputs of two identities
    type(change_t), allocatable, intent(out) :: changes(:)
    type(message_list_t) :: old
    integer :: first, last, i
    character(:), allocatable :: line
    allocate (changes(0))
    first = 1
    do while (first <= len(was))
      last = first + index(was(first:)//NL, NL) - 2
      call old%add(was(first:last))
      first = last + 2
    end do
    first = 1
    do while (first <= len(now))
      last = first + index(now(first:)//NL, NL) - 2
      line = now(first:last)
      first = last + 2
      do i = 1, old%count()
        if (name_in(old%text(i)) /= name_in(line)) cycle
        if (content_in(old%text(i)) /= content_in(line)) call add_change(changes, line, old%text(i))
        exit
      end do
    end do
  end subroutine list_changes

  !> Adds a line that changed, with its old value.
  subroutine add_change(changes, line, old_line)
    type(change_t), allocatable, intent(inout) :: changes(:)
    character(*), intent(in) :: line, old_line
    type(change_t), allocatable :: larger(:)
    integer :: n
    n = size(changes)
    allocate (larger(n + 1))
    larger(:n) = changes
    larger(n + 1)%name = name_in(line)
    larger(n + 1)%now = value_in(line)
    larger(n + 1)%was = value_in(old_line)
    call move_alloc(larger, changes)
  end subroutine add_change

  !> Returns the words `[section] key = now, was then`.
  function change_text(self) result(text)
    class(change_t), intent(in) :: self
    character(:), allocatable :: text
    if (self%now == self%was) then
      text = self%name//EQUALS//shown(self%now)//': the content of this file has changed'
    else
      text = self%name//EQUALS//shown(self%now)//', was '//shown(self%was)
    end if
  end function change_text

  !> Returns a value as users see it.
  pure function shown(value) result(text)
    character(*), intent(in) :: value
    character(:), allocatable :: text
    text = value
    if (text == '') text = '(empty)'
  end function shown

  !> Returns the name in a line NAME = VALUE.
  pure function name_in(line) result(name)
    character(*), intent(in) :: line
    character(:), allocatable :: name
    name = line(:index(line, EQUALS) - 1)
  end function name_in

  !> Returns the value in a line NAME = VALUE, without the file that follows it.
  pure function value_in(line) result(value)
    character(*), intent(in) :: line
    character(:), allocatable :: value
    integer :: last
    last = index(line, FILE_MARK) - 1
    if (last < 0) last = len(line)
    value = line(index(line, EQUALS) + len(EQUALS):last)
  end function value_in

  !> Returns the value for comparisons: the checksum of the file that it names, or else the value itself.
  pure function content_in(line) result(content)
    character(*), intent(in) :: line
    character(:), allocatable :: content
    integer :: first
    first = index(line, FILE_MARK)
    if (first == 0) first = index(line, EQUALS) + len(EQUALS)
    content = line(first:)
  end function content_in

  !> Returns a word as 16 hexadecimal digits.
  function hexadecimal(word) result(text)
    integer(i8), intent(in) :: word
    character(16) :: text
    write (text, '(z16.16)') word
  end function hexadecimal
end module io_identity
