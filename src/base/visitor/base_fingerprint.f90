! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes a number that identifies values: a sum over all components that the visits of the values name.
!>
!> The module that makes a fingerprint names the components that must not count (`omit`). It may add some components itself, in an
!> order that it chooses. The names of all other components set their positions in the sum. A new component changes the fingerprint
!> as soon as a visit names it. Sizes do not count.
module base_fingerprint
  use base_checksum, only: checksum_add, checksum_reals, checksum_text
  use base_errors, only: require
  use base_kinds, only: i8, rp
  use base_visitor, only: visitor_t
  implicit none
  private
  public :: fingerprint_t

  !> One component.
  type :: component_t
    character(:), allocatable :: name
    real(rp), allocatable :: numbers(:)
    character(:), allocatable :: text
    logical :: is_done = .false. !< the owner has summed or omitted it
  end type component_t

  !> Takes the components of everything that it visits.
  type, extends(visitor_t) :: fingerprint_t
    private
    type(component_t), allocatable :: components(:)
    integer :: n = 0 !< components that are known
  contains
    procedure :: extents => fingerprint_extents
    procedure :: carry_reals => fingerprint_reals
    procedure :: carry_integers => fingerprint_integers
    procedure :: carry_text => fingerprint_text
    procedure :: numbers => fingerprint_numbers
    procedure :: text => fingerprint_one_text
    procedure :: omit => fingerprint_omit
    procedure :: omit_part => fingerprint_omit_part
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
    type(component_t) :: component
    component%name = name
    component%numbers = values
    call add(self, component)
  end subroutine fingerprint_reals

  !> Adds these integers and their name to the fingerprint.
  subroutine fingerprint_integers(self, name, values)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: values(:)
    type(component_t) :: component
    component%name = name
    component%numbers = real(values, rp)
    call add(self, component)
  end subroutine fingerprint_integers

  !> Adds this text and its name to the fingerprint.
  subroutine fingerprint_text(self, name, text)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(inout) :: text
    type(component_t) :: component
    component%name = name
    component%text = text
    call add(self, component)
  end subroutine fingerprint_text

  !> Adds a component, whose name must be new.
  subroutine add(self, component)
    class(fingerprint_t), intent(inout) :: self
    type(component_t), intent(inout) :: component !< its values move
    type(component_t), allocatable :: more(:)
    integer :: i
    if (.not. allocated(self%components)) allocate (self%components(8))
    call require(position_of(self, component%name) == 0, 'base_fingerprint: one component called '//component%name)
    if (self%n == size(self%components)) then
      allocate (more(2*self%n))
      do i = 1, self%n
        call move_component(self%components(i), more(i))
      end do
      call move_alloc(more, self%components)
    end if
    self%n = self%n + 1
    call move_component(component, self%components(self%n))
  end subroutine add

  !> Moves a component without a copy of its values.
  subroutine move_component(from, to)
    type(component_t), intent(inout) :: from
    type(component_t), intent(out) :: to
    call move_alloc(from%name, to%name)
    if (allocated(from%numbers)) call move_alloc(from%numbers, to%numbers)
    if (allocated(from%text)) call move_alloc(from%text, to%text)
    to%is_done = from%is_done
  end subroutine move_component

  !> Returns the number of the component of that name, or 0.
  integer function position_of(self, name) result(i)
    class(fingerprint_t), intent(in) :: self
    character(*), intent(in) :: name
    do i = 1, self%n
      if (self%components(i)%name == name) return
    end do
    i = 0
  end function position_of

  !> Returns the numbers of a component, logicals as 0 and 1. Its owner sums them.
  function fingerprint_numbers(self, name) result(numbers)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), allocatable :: numbers(:)
    integer :: i
    i = position_of(self, name)
    call require(i > 0, 'base_fingerprint: a component called '//name)
    self%components(i)%is_done = .true.
    numbers = self%components(i)%numbers
  end function fingerprint_numbers

  !> Returns a text, as long as its component. Its owner sums it.
  function fingerprint_one_text(self, name) result(text)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(:), allocatable :: text
    integer :: i
    i = position_of(self, name)
    call require(i > 0, 'base_fingerprint: a text called '//name)
    call self%omit(name)
    text = self%components(i)%text
  end function fingerprint_one_text

  !> Leaves the component `name` out of the rest, if it was visited, and whether it is there.
  subroutine fingerprint_omit(self, name)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer :: i
    do i = 1, self%n
      associate (component => self%components(i))
        if (component%name == name .or. component%name == name//'_is_there') component%is_done = .true.
      end associate
    end do
  end subroutine fingerprint_omit

  !> Leaves all components of a part or of a list out of the rest.
  subroutine fingerprint_omit_part(self, name)
    class(fingerprint_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer :: i
    do i = 1, self%n
      associate (component => self%components(i))
        if (index(component%name, name//'_') == 1) component%is_done = .true.
      end associate
    end do
  end subroutine fingerprint_omit_part

  !> Returns the sum of all components that the owner neither summed nor omitted; 0 if there are none.
  integer(i8) function fingerprint_rest(self) result(total)
    class(fingerprint_t), intent(in) :: self
    integer :: i
    total = 0
    do i = 1, self%n
      associate (one => self%components(i))
        if (one%is_done) cycle
        if (allocated(one%numbers)) total = checksum_add(total, checksum_reals(one%numbers, shiftr(checksum_text(one%name), 16)))
        if (allocated(one%text)) total = checksum_add(total, checksum_text(one%name//' '//one%text))
      end associate
    end do
  end function fingerprint_rest
end module base_fingerprint
