! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes JSON (RFC 8259), objects and lists that may be nested, as a text.
!>
!>     call json%open_object('')            the outermost object has no key
!>     call json%put('answer', 42)
!>     call json%open_list('values'); call json%put('', 1.0_rp); call json%close()
!>     call json%close()
!>
!> Inside lists keys are empty. Numbers that are not finite, and huge numbers, which mean that there is no value, become null.
module io_json
  use base_errors, only: require
  use base_kinds, only: rp
  use base_text, only: number_text
  implicit none
  private
  public :: json_t

  integer, parameter :: DEEPEST = 16
  character(*), parameter :: NL = new_line('a')

  type :: json_t
    character(:), allocatable :: text
    integer, private :: depth = 0
    logical, private :: is_list(DEEPEST) = .false., has_member(0:DEEPEST) = .false.
  contains
    procedure :: open_object => json_open_object
    procedure :: open_list => json_open_list
    procedure :: close => json_close
    procedure, private :: json_put_text, json_put_real, json_put_integer, json_put_logical, json_put_reals
    generic :: put => json_put_text, json_put_real, json_put_integer, json_put_logical, json_put_reals
    procedure, private :: begin_member => json_begin_member
  end type json_t

contains

  !> Begins an object as the member `key`.
  subroutine json_open_object(self, key)
    class(json_t), intent(inout) :: self
    character(*), intent(in) :: key
    call open_one(self, key, '{', .false.)
  end subroutine json_open_object

  !> Begins a list.
  subroutine json_open_list(self, key)
    class(json_t), intent(inout) :: self
    character(*), intent(in) :: key
    call open_one(self, key, '[', .true.)
  end subroutine json_open_list

  !> Opens an object or a list.
  subroutine open_one(self, key, bracket, is_list)
    class(json_t), intent(inout) :: self
    character(*), intent(in) :: key, bracket
    logical, intent(in) :: is_list
    call require(self%depth < DEEPEST, 'io_json: too deep')
    call self%begin_member(key)
    self%text = self%text//bracket
    self%depth = self%depth + 1
    self%is_list(self%depth) = is_list
    self%has_member(self%depth) = .false.
  end subroutine open_one

  !> Ends the object or the list that was begun last.
  subroutine json_close(self)
    class(json_t), intent(inout) :: self
    call require(self%depth > 0, 'io_json: nothing is open')
    self%depth = self%depth - 1
    if (self%has_member(self%depth + 1)) self%text = self%text//NL//repeat('  ', self%depth)
    self%text = self%text//merge(']', '}', self%is_list(self%depth + 1))
    if (self%depth == 0) self%text = self%text//NL
  end subroutine json_close

  !> Adds a text.
  subroutine json_put_text(self, key, value)
    class(json_t), intent(inout) :: self
    character(*), intent(in) :: key, value
    call self%begin_member(key)
    self%text = self%text//quote(value)
  end subroutine json_put_text

  !> Adds a real, or null if it is not finite.
  subroutine json_put_real(self, key, value)
    class(json_t), intent(inout) :: self
    character(*), intent(in) :: key
    real(rp), intent(in) :: value
    call self%begin_member(key)
    self%text = self%text//real_or_null(value)
  end subroutine json_put_real

  !> Adds an integer.
  subroutine json_put_integer(self, key, value)
    class(json_t), intent(inout) :: self
    character(*), intent(in) :: key
    integer, intent(in) :: value
    call self%begin_member(key)
    self%text = self%text//number_text(value)
  end subroutine json_put_integer

  !> Adds true or false.
  subroutine json_put_logical(self, key, value)
    class(json_t), intent(inout) :: self
    character(*), intent(in) :: key
    logical, intent(in) :: value
    call self%begin_member(key)
    self%text = self%text//trim(merge('true ', 'false', value))
  end subroutine json_put_logical

  !> Adds a list of numbers on one line.
  subroutine json_put_reals(self, key, values)
    class(json_t), intent(inout) :: self
    character(*), intent(in) :: key
    real(rp), intent(in) :: values(:)
    integer :: i
    call self%begin_member(key)
    self%text = self%text//'['
    do i = 1, size(values)
      if (i > 1) self%text = self%text//', '
      self%text = self%text//real_or_null(values(i))
    end do
    self%text = self%text//']'
  end subroutine json_put_reals

  !> Writes comma, line, indent and key.
  subroutine json_begin_member(self, key)
    class(json_t), intent(inout) :: self
    character(*), intent(in) :: key
    if (.not. allocated(self%text)) self%text = ''
    if (self%depth == 0) return
    if (self%has_member(self%depth)) self%text = self%text//','
    self%has_member(self%depth) = .true.
    self%text = self%text//NL//repeat('  ', self%depth)
    call require(self%is_list(self%depth) .eqv. key == '', 'io_json: members of objects have keys, those of lists none')
    if (key /= '') self%text = self%text//quote(key)//': '
  end subroutine json_begin_member

  !> Returns a number as JSON requires it: a digit before and after the point.
  function real_or_null(value) result(text)
    real(rp), intent(in) :: value
    character(:), allocatable :: text
    character(32) :: buffer
    text = 'null'
    if (.not. abs(value) < 1.0e290_rp) return
    write (buffer, '(es24.16e3)') value
    text = trim(adjustl(buffer))
  end function real_or_null

  !> Returns a text in quotation marks, with escapes where JSON needs them.
  pure function quote(value) result(text)
    character(*), intent(in) :: value
    character(:), allocatable :: text
    character(6) :: code
    integer :: i
    text = '"'
    do i = 1, len(value)
      select case (value(i:i))
      case ('"', '\')
        text = text//'\'//value(i:i)
      case default
        if (iachar(value(i:i)) >= 32) then
          text = text//value(i:i)
        else
          write (code, '(a,z4.4)') '\u', iachar(value(i:i))
          text = text//code
        end if
      end select
    end do
    text = text//'"'
  end function quote
end module io_json
