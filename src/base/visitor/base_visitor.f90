! SPDX-License-Identifier: GPL-3.0-or-later
!> Lets a type list its components in one procedure, `visit`, which names every component.
!>
!> The same list serves for writing and for reading, so that they always agree: a visitor packs the components into a message,
!> writes them into a file, or sums them, and takes them back in the same order. A component that a visit forgets would be lost in
!> silence, so tools/check_structure compares the components of every type that has a procedure `visit` with those that it names.
!>
!> Parts and members of lists have their names before those of their components, with `_` between them: `search_restart` is
!> `restart` of the part `search`. A text that may be missing has `<name>_is_there` before it.
module base_visitor
  use base_text, only: number_text
  use base_value_visitor, only: value_visitor_t
  implicit none
  private
  public :: visited_t, visitor_t

  !> A value that lists its components.
  type, abstract :: visited_t
  contains
    procedure(visit_components), deferred :: visit
  end type visited_t

  !> A visitor of numbers, texts, and parts and lists of them.
  type, abstract, extends(value_visitor_t) :: visitor_t
  contains
    generic :: visit => visit_part, visit_text, visit_texts
    generic :: visit_allocatable => any_text, any_texts
    procedure :: count_of => visitor_count_of
    procedure :: visit_list => visitor_visit_list
    procedure :: leave_out => visitor_leave_out
    procedure, private :: visit_part, visit_text, visit_texts, any_text, any_texts
  end type visitor_t

  abstract interface
    !> Shows every component to the visitor. A value that is read is as it was declared: its lists are not allocated.
    subroutine visit_components(self, visitor)
      import :: visited_t, visitor_t
      class(visited_t), intent(inout) :: self
      class(visitor_t), intent(inout) :: visitor
    end subroutine visit_components
  end interface

contains

  !> Visits a part.
  recursive subroutine visit_part(self, name, part)
    class(visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    class(visited_t), intent(inout) :: part
    character(:), allocatable :: path
    path = self%full_name('')
    self%path = path//name//'_'
    call part%visit(self)
    self%path = path
  end subroutine visit_part

  !> Visits a text of fixed length.
  subroutine visit_text(self, name, value)
    class(visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(*), intent(inout) :: value
    character(:), allocatable :: text
    if (self%failure%failed) return
    if (.not. self%is_reading) text = value
    call self%carry_text(self%full_name(name), text)
    if (self%is_reading .and. .not. self%failure%failed) value = text
  end subroutine visit_text

  !> Visits texts of the same length, numbered from 1.
  subroutine visit_texts(self, name, values)
    class(visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(*), intent(inout) :: values(:)
    integer :: i
    do i = 1, size(values)
      call self%visit(name//'_'//number_text(i), values(i))
    end do
  end subroutine visit_texts

  !> Visits a text of any length, which may be unallocated.
  subroutine any_text(self, name, value)
    class(visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(inout) :: value
    logical :: is_there
    is_there = allocated(value)
    call self%visit(name//'_is_there', is_there)
    if (self%is_reading .and. allocated(value)) deallocate (value)
    if (is_there .and. .not. self%failure%failed) call self%carry_text(self%full_name(name), value)
  end subroutine any_text

  !> Visits an array of texts with its size, and allocates it when it is read. It may be unallocated.
  subroutine any_texts(self, name, values)
    class(visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(*), allocatable, intent(inout) :: values(:)
    integer :: n(1)
    n = -1
    if (allocated(values)) n = shape(values)
    call self%extents(name//'_shape', n)
    if (self%is_reading .and. allocated(values)) deallocate (values)
    if (n(1) < 0) return
    if (self%is_reading) allocate (values(n(1)))
    if (self%is_reading) values = ''
    call self%visit(name, values)
  end subroutine any_texts

  !> Returns the length of a list that is read: the caller allocates it before `visit_list`. 0 after a failure.
  integer function visitor_count_of(self, name) result(n)
    class(visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer :: length(1)
    length = 0
    call self%extents(name//'_count', length)
    n = max(0, length(1))
  end function visitor_count_of

  !> Visits a list of parts. Before a list is read, `count_of` must have been called.
  recursive subroutine visitor_visit_list(self, name, list)
    class(visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    class(visited_t), intent(inout) :: list(:)
    integer :: i, length(1)
    length = size(list)
    if (.not. self%is_reading) call self%extents(name//'_count', length)
    do i = 1, size(list)
      call self%visit(name//'_'//number_text(i), list(i))
    end do
  end subroutine visitor_visit_list

  !> Names components that the visit does not carry, with blanks between them: they follow from others, or are no part of what the
  !> visit is for. It does nothing; tools/check_structure reads it.
  subroutine visitor_leave_out(self, names)
    class(visitor_t), intent(in) :: self
    character(*), intent(in) :: names
    if (self%failure%failed .or. names == '') return
  end subroutine visitor_leave_out
end module base_visitor
