! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes a number that identifies values: a sum over all components that the visits of the values name.
!>
!> The owner of a fingerprint says which components it sums in which order, so that the number of an old file stays the same. For
!> all other components the position in the sum follows from their name. A new component changes the fingerprint as soon as a
!> visit names it, without any other change. Sizes are no components.
module base_fingerprint
  use base_checksum, only: checksum_add, checksum_reals, checksum_text
  use base_errors, only: require
  use base_kinds, only: i8, rp
  use base_visitor, only: visitor_t
  implicit none
  private
  public :: fingerprint_t

  !> One component.
  type :: mark_t
    character(:), allocatable :: name
    real(rp), allocatable :: numbers(:)
    character(:), allocatable :: text
    logical :: is_summed = .false. !< the owner has asked for it
  end type mark_t

  !> Takes the components of everything that it visits.
  type, extends(visitor_t) :: fingerprint_t
    private
    type(mark_t), allocatable :: marks(:)
  contains
    procedure :: extents => fingerprint_extents
    procedure :: carry_reals => fingerprint_reals
    procedure :: carry_integers => fingerprint_integers
    procedure :: carry_text => fingerprint_text
    procedure :: numbers => fingerprint_numbers
    procedure :: text => fingerprint_one_text
    procedure :: rest => fingerprint_rest
  end type fingerprint_t

contains

  !> Leaves sizes out.
  subroutine fingerprint_extents(self, name, n)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(inout) :: n(:)
    call require(name /= '' .and. size(n) > 0, 'base_fingerprint: a size with a name')
    call require(.not. self%is_reading, 'base_fingerprint: nothing can be read of it')
  end subroutine fingerprint_extents

  !> Adds these reals and their name to the fingerprint.
  subroutine fingerprint_reals(self, name, values)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: values(:)
    type(mark_t) :: mark
    mark%name = name
    mark%numbers = values
    call add(self, mark)
  end subroutine fingerprint_reals

  !> Adds these integers and their name to the fingerprint.
  subroutine fingerprint_integers(self, name, values)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: values(:)
    type(mark_t) :: mark
    mark%name = name
    mark%numbers = real(values, rp)
    call add(self, mark)
  end subroutine fingerprint_integers

  !> Adds this text and its name to the fingerprint.
  subroutine fingerprint_text(self, name, text)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(inout) :: text
    type(mark_t) :: mark
    mark%name = name
    mark%text = text
    call add(self, mark)
  end subroutine fingerprint_text

  !> Adds a mark, whose name must be new.
  subroutine add(self, mark)
    class(fingerprint_t), intent(inout) :: self
    type(mark_t), intent(in) :: mark
    type(mark_t), allocatable :: more(:)
    integer :: n
    if (.not. allocated(self%marks)) allocate (self%marks(0))
    call require(place(self, mark%name) == 0, 'base_fingerprint: one component called '//mark%name)
    n = size(self%marks)
    allocate (more(n + 1))
    more(:n) = self%marks
    more(n + 1) = mark
    call move_alloc(more, self%marks)
  end subroutine add

  !> Returns the number of the component of that name, or 0.
  integer function place(self, name) result(i)
    class(fingerprint_t), intent(in) :: self
    character(*), intent(in) :: name
    do i = 1, size(self%marks)
      if (self%marks(i)%name == name) return
    end do
    i = 0
  end function place

  !> Returns the numbers of a component, logicals as 0 and 1. Its owner sums them.
  function fingerprint_numbers(self, name) result(numbers)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), allocatable :: numbers(:)
    integer :: i
    i = place(self, name)
    call require(i > 0, 'base_fingerprint: a component called '//name)
    self%marks(i)%is_summed = .true.
    numbers = self%marks(i)%numbers
  end function fingerprint_numbers

  !> Returns a text, as long as its component. Its owner sums it.
  function fingerprint_one_text(self, name) result(text)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(:), allocatable :: text
    integer :: i
    i = place(self, name)
    call require(i > 0, 'base_fingerprint: a text called '//name)
    self%marks(i)%is_summed = .true.
    text = self%marks(i)%text
  end function fingerprint_one_text

  !> Returns the sum of all components that were not requested; 0 if there are none.
  integer(i8) function fingerprint_rest(self) result(total)
    class(fingerprint_t), intent(in) :: self
    integer :: i
    total = 0
    do i = 1, size(self%marks)
      associate (mark => self%marks(i))
        if (mark%is_summed) cycle
        if (allocated(mark%numbers)) total = checksum_add(total, checksum_reals(mark%numbers, shiftr(checksum_text(mark%name), 16)))
        if (allocated(mark%text)) total = checksum_add(total, checksum_text(mark%name//' '//mark%text))
      end associate
    end do
  end function fingerprint_rest
end module base_fingerprint
