! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines a visitor of numbers and texts, on which base_visitor builds visitors of whole types. A concrete visitor carries arrays
!> of reals, arrays of integers, and texts, each under a name. All else consists of these: logicals are 0 and 1; an allocatable
!> array has its shape before it, the integers `<name>_shape`, -1 if not allocated.
module base_value_visitor
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  implicit none
  private
  public :: value_visitor_t

  !> Visits components. After a failure a visit does nothing, and a component that it should read is undefined.
  type, abstract :: value_visitor_t
    logical :: is_reading = .false.    !< the visitor sets the components; otherwise it copies them
    type(failure_t) :: failure         !< something was missing or of another size while reading
    character(:), allocatable :: path  !< first part of all names, or none
  contains
    procedure(carry_reals), deferred :: carry_reals
    procedure(carry_integers), deferred :: carry_integers
    procedure(carry_text), deferred :: carry_text
    procedure :: carry_real => visitor_carry_real
    procedure :: carry_integer => visitor_carry_integer
    procedure :: most => visitor_most
    procedure :: extents => visitor_extents
    procedure :: full_name => visitor_full_name
    !> A component whose size writer and reader know.
    generic :: visit => visit_real, visit_reals_1, visit_reals_2, visit_reals_3, visit_integer, &
      visit_integers_1, visit_integers_2, visit_long, visit_longs_1, visit_logical, visit_logicals_1, visit_logicals_2
    !> An allocatable component. Its size goes with it, and whether it is allocated.
    generic :: visit_allocatable => any_reals_1, any_reals_2, any_reals_3, any_integers_1, any_integers_2, &
      any_longs_1, any_logicals_1, any_logicals_2
    procedure, private :: visit_real, visit_reals_1, visit_reals_2, visit_reals_3
    procedure, private :: visit_integer, visit_integers_1, visit_integers_2, visit_long, visit_longs_1
    procedure, private :: visit_logical, visit_logicals_1, visit_logicals_2, any_reals_1, any_reals_2
    procedure, private :: any_reals_3, any_integers_1, any_integers_2, any_longs_1, any_logicals_1, any_logicals_2
  end type value_visitor_t

  abstract interface
    !> Takes or gives an array of numbers.
    subroutine carry_reals(self, name, values)
      import :: value_visitor_t, rp
      class(value_visitor_t), intent(inout) :: self
      character(*), intent(in) :: name
      real(rp), intent(inout) :: values(:)
      end subroutine carry_reals

    !> Carries integers in the same way.
    subroutine carry_integers(self, name, values)
      import :: value_visitor_t, i8
      class(value_visitor_t), intent(inout) :: self
      character(*), intent(in) :: name
      integer(i8), intent(inout) :: values(:)
      end subroutine carry_integers

    !> Carries a text in the same way. It is allocated unless it is read.
    subroutine carry_text(self, name, text)
      import :: value_visitor_t
      class(value_visitor_t), intent(inout) :: self
      character(*), intent(in) :: name
      character(:), allocatable, intent(inout) :: text
    end subroutine carry_text
  end interface

contains

  !> Returns how many numbers can still be read: a larger size is an error of the source.
  pure integer(i8) function visitor_most(self) result(most)
    class(value_visitor_t), intent(in) :: self
    most = huge(1)
    if (self%failure%failed) most = 0
  end function visitor_most

  !> Returns the name with the names of its parts in front.
  pure function visitor_full_name(self, name) result(full)
    class(value_visitor_t), intent(in) :: self
    character(*), intent(in) :: name
    character(:), allocatable :: full
    full = name
    if (allocated(self%path)) full = self%path//name
  end function visitor_full_name

  !> Visits the size of an array, -1 if it is not allocated. An impossible size is a failure; `n` is -1 then.
  subroutine visitor_extents(self, name, n)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(inout) :: n(:)
    integer(i8) :: total
    integer :: i
    call self%visit(name, n)
    if (.not. self%is_reading) return
    total = 1
    do i = 1, size(n)
      if (self%failure%failed .or. n(i) < 0) exit
      total = total*n(i)
      if (total > self%most()) call self%failure%raise(self%full_name(name)//' has more elements than there are data: '// &
                                                       'the data are damaged')
    end do
    if (self%failure%failed) n = -1
  end subroutine visitor_extents

  !> Carries one real as a list of one, unless a visitor treats single reals in another way.
  subroutine visitor_carry_real(self, name, value)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: value
    real(rp) :: values(1)
    values = value
    call self%carry_reals(name, values)
    value = values(1)
  end subroutine visitor_carry_real

  !> Carries one integer as a list of one.
  subroutine visitor_carry_integer(self, name, value)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: value
    integer(i8) :: values(1)
    values = value
    call self%carry_integers(name, values)
    value = values(1)
  end subroutine visitor_carry_integer

  !> Carries n reals, of an array of any rank.
  subroutine carry_many(self, name, values, n)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: n
    real(rp), intent(inout) :: values(n)
    if (.not. self%failure%failed) call self%carry_reals(self%full_name(name), values)
  end subroutine carry_many

  !> Carries n long integers, of an array of any rank.
  subroutine carry_longs(self, name, values, n)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: n
    integer(i8), intent(inout) :: values(n)
    if (.not. self%failure%failed) call self%carry_integers(self%full_name(name), values)
  end subroutine carry_longs

  !> Carries n default integers, of an array of any rank. Numbers that do not fit into them are a failure.
  subroutine carry_defaults(self, name, values, n)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: n
    integer, intent(inout) :: values(n)
    integer(i8) :: wide(n)
    wide = 0
    if (.not. self%is_reading) wide = values
    call carry_longs(self, name, wide, n)
    if (self%is_reading) call check_range(self, name, wide)
    if (self%is_reading .and. .not. self%failure%failed) values = int(wide)
  end subroutine carry_defaults

  !> Fails if a number that was read does not fit into a default integer.
  subroutine check_range(self, name, wide)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(in) :: wide(:)
    if (any(wide > huge(1) .or. wide < -huge(1))) call self%failure%raise(self%full_name(name)//' is out of range')
  end subroutine check_range

  !> Carries n logicals as 0 and 1, of an array of any rank.
  subroutine carry_flags(self, name, flags, n)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: n
    logical, intent(inout) :: flags(n)
    integer(i8) :: wide(n)
    wide = 0
    if (.not. self%is_reading) wide = merge(1_i8, 0_i8, flags)
    call carry_longs(self, name, wide, n)
    if (self%is_reading .and. .not. self%failure%failed) flags = wide /= 0
  end subroutine carry_flags

  !> Visits one real.
  subroutine visit_real(self, name, value)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: value
    if (.not. self%failure%failed) call self%carry_real(self%full_name(name), value)
  end subroutine visit_real

  !> Visits the reals of an array of one dimension.
  subroutine visit_reals_1(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: values(:)
    call carry_many(self, name, values, size(values))
  end subroutine visit_reals_1

  !> Visits the reals of an array of two dimensions.
  subroutine visit_reals_2(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: values(:, :)
    call carry_many(self, name, values, size(values))
  end subroutine visit_reals_2

  !> Visits the reals of an array of three dimensions.
  subroutine visit_reals_3(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: values(:, :, :)
    call carry_many(self, name, values, size(values))
  end subroutine visit_reals_3

  !> Visits one default integer. A number that does not fit into it is a failure.
  subroutine visit_integer(self, name, value)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(inout) :: value
    integer(i8) :: wide
    wide = 0
    if (.not. self%is_reading) wide = value
    call self%visit(name, wide)
    if (self%is_reading) call check_range(self, name, [wide])
    if (self%is_reading .and. .not. self%failure%failed) value = int(wide)
  end subroutine visit_integer

  !> Visits the default integers of an array of one dimension.
  subroutine visit_integers_1(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(inout) :: values(:)
    call carry_defaults(self, name, values, size(values))
  end subroutine visit_integers_1

  !> Visits the default integers of an array of two dimensions.
  subroutine visit_integers_2(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(inout) :: values(:, :)
    call carry_defaults(self, name, values, size(values))
  end subroutine visit_integers_2

  !> Visits one long integer.
  subroutine visit_long(self, name, value)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: value
    if (.not. self%failure%failed) call self%carry_integer(self%full_name(name), value)
  end subroutine visit_long

  !> Visits the long integers of an array of one dimension.
  subroutine visit_longs_1(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: values(:)
    call carry_longs(self, name, values, size(values))
  end subroutine visit_longs_1

  !> Visits one logical, as 0 or 1.
  subroutine visit_logical(self, name, value)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    logical, intent(inout) :: value
    integer(i8) :: wide
    wide = 0
    if (.not. self%is_reading) wide = merge(1_i8, 0_i8, value)
    call self%visit(name, wide)
    if (self%is_reading .and. .not. self%failure%failed) value = wide /= 0
  end subroutine visit_logical

  !> Visits the logicals of an array of one dimension.
  subroutine visit_logicals_1(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    logical, intent(inout) :: values(:)
    call carry_flags(self, name, values, size(values))
  end subroutine visit_logicals_1

  !> Visits the logicals of an array of two dimensions.
  subroutine visit_logicals_2(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    logical, intent(inout) :: values(:, :)
    call carry_flags(self, name, values, size(values))
  end subroutine visit_logicals_2

  !> Visits an array of reals with its shape, and allocates it when it is read. It may be unallocated.
  subroutine any_reals_1(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), allocatable, intent(inout) :: values(:)
    integer :: n(1)
    n = -1
    if (allocated(values)) n = shape(values)
    call self%extents(name//'_shape', n)
    if (self%is_reading .and. allocated(values)) deallocate (values)
    if (n(1) < 0) return
    if (self%is_reading) allocate (values(n(1)))
    call self%visit(name, values)
  end subroutine any_reals_1

  !> The same in two dimensions.
  subroutine any_reals_2(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), allocatable, intent(inout) :: values(:, :)
    integer :: n(2)
    n = -1
    if (allocated(values)) n = shape(values)
    call self%extents(name//'_shape', n)
    if (self%is_reading .and. allocated(values)) deallocate (values)
    if (n(1) < 0) return
    if (self%is_reading) allocate (values(n(1), n(2)))
    call self%visit(name, values)
  end subroutine any_reals_2

  !> The same in three dimensions.
  subroutine any_reals_3(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), allocatable, intent(inout) :: values(:, :, :)
    integer :: n(3)
    n = -1
    if (allocated(values)) n = shape(values)
    call self%extents(name//'_shape', n)
    if (self%is_reading .and. allocated(values)) deallocate (values)
    if (n(1) < 0) return
    if (self%is_reading) allocate (values(n(1), n(2), n(3)))
    call self%visit(name, values)
  end subroutine any_reals_3

  !> The same for default integers in one dimension.
  subroutine any_integers_1(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, allocatable, intent(inout) :: values(:)
    integer :: n(1)
    n = -1
    if (allocated(values)) n = shape(values)
    call self%extents(name//'_shape', n)
    if (self%is_reading .and. allocated(values)) deallocate (values)
    if (n(1) < 0) return
    if (self%is_reading) allocate (values(n(1)))
    call self%visit(name, values)
  end subroutine any_integers_1

  !> The same for default integers in two dimensions.
  subroutine any_integers_2(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, allocatable, intent(inout) :: values(:, :)
    integer :: n(2)
    n = -1
    if (allocated(values)) n = shape(values)
    call self%extents(name//'_shape', n)
    if (self%is_reading .and. allocated(values)) deallocate (values)
    if (n(1) < 0) return
    if (self%is_reading) allocate (values(n(1), n(2)))
    call self%visit(name, values)
  end subroutine any_integers_2

  !> The same for long integers in one dimension.
  subroutine any_longs_1(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), allocatable, intent(inout) :: values(:)
    integer :: n(1)
    n = -1
    if (allocated(values)) n = shape(values)
    call self%extents(name//'_shape', n)
    if (self%is_reading .and. allocated(values)) deallocate (values)
    if (n(1) < 0) return
    if (self%is_reading) allocate (values(n(1)))
    call self%visit(name, values)
  end subroutine any_longs_1

  !> The same for logicals in one dimension.
  subroutine any_logicals_1(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    logical, allocatable, intent(inout) :: values(:)
    integer :: n(1)
    n = -1
    if (allocated(values)) n = shape(values)
    call self%extents(name//'_shape', n)
    if (self%is_reading .and. allocated(values)) deallocate (values)
    if (n(1) < 0) return
    if (self%is_reading) allocate (values(n(1)))
    call self%visit(name, values)
  end subroutine any_logicals_1

  !> The same for logicals in two dimensions.
  subroutine any_logicals_2(self, name, values)
    class(value_visitor_t), intent(inout) :: self
    character(*), intent(in) :: name
    logical, allocatable, intent(inout) :: values(:, :)
    integer :: n(2)
    n = -1
    if (allocated(values)) n = shape(values)
    call self%extents(name//'_shape', n)
    if (self%is_reading .and. allocated(values)) deallocate (values)
    if (n(1) < 0) return
    if (self%is_reading) allocate (values(n(1), n(2)))
    call self%visit(name, values)
  end subroutine any_logicals_2
end module base_value_visitor
