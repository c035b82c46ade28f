! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists the files in a folder.
module base_listing
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_ptr
  use base_errors, only: message_list_t
  implicit none
  private
  public :: list_folder, matches_name

  interface
    type(c_ptr) function c_opendir(path) bind(C, name='opendir')
      import :: c_ptr, c_char
      character(kind=c_char), intent(in) :: path(*)
    end function c_opendir

    integer(c_int) function c_closedir(folder) bind(C, name='closedir')
      import :: c_ptr, c_int
      type(c_ptr), value :: folder
    end function c_closedir

    integer(c_int) function c_next_entry(folder, name, size) bind(C, name='flusi_next_entry')
      import :: c_ptr, c_int, c_char
      type(c_ptr), value :: folder
      character(kind=c_char), intent(out) :: name(*)
      integer(c_int), value :: size
    end function c_next_entry
  end interface

contains

  !> Returns the names of all entries of the folder at `path`, in no order, without those that begin with a dot; none if it cannot
  !> be read.
  subroutine list_folder(path, names)
    character(*), intent(in) :: path
    type(message_list_t), intent(out) :: names
    integer, parameter :: MOST = 1024 ! longer than any file system allows
    character(MOST) :: name
    type(c_ptr) :: folder
    integer(c_int) :: ignored
    folder = c_opendir(path//c_null_char)
    if (.not. c_associated(folder)) return
    do while (c_next_entry(folder, name, int(MOST, c_int)) /= 0)
      if (name(1:1) /= '.') call names%add(name(:index(name, c_null_char) - 1))
    end do
    ignored = c_closedir(folder)
  end subroutine list_folder

  !> Tells whether `name` matches `pattern`, in which a * stands for any text and a # for an unsigned number.
  pure recursive logical function matches_name(name, pattern) result(matches)
    character(*), intent(in) :: name, pattern
    integer :: k
    matches = len(name) == 0
    if (len(pattern) == 0) return
    matches = .false.
    select case (pattern(1:1))
    case ('*')
      do k = 0, len(name)
        if (matches_name(name(k + 1:), pattern(2:))) matches = .true.
      end do
    case ('#')
      do k = 1, len(name)
        if (verify(name(k:k), '0123456789') > 0) return
        if (matches_name(name(k + 1:), pattern(2:))) matches = .true.
      end do
    case default
      if (len(name) == 0) return
      if (name(1:1) == pattern(1:1)) matches = matches_name(name(2:), pattern(2:))
    end select
  end function matches_name
end module base_listing
