! SPDX-License-Identifier: GPL-3.0-or-later
!> Stores named plain arrays. A checkpoint of an optimiser consists of them.
!>
!> One procedure visits all components of a state, and the archive's direction decides whether they are
!> copied out or in; writing and reading cannot get out of step. The owner of the file stores each field
!> under its name and gives them back in any order.
module cmaes_archive
  use base_errors, only: failure_t, require
  use base_kinds, only: rp, i8
  implicit none
  private
  public :: archive_t, field_t, NAME_LENGTH

  integer, parameter :: NAME_LENGTH = 32

  !> One named array, real or integer.
  type :: field_t
    character(NAME_LENGTH) :: name = ''
    real(rp), allocatable :: reals(:)      !< if real
    integer(i8), allocatable :: integers(:) !< if integer
  end type field_t

  !> A list of fields.
  type :: archive_t
    type(field_t), allocatable :: fields(:)
    logical :: is_reading = .false. !< fields are copied into the visited variables
    type(failure_t) :: failure      !< a field was missing or of another size while reading
  contains
    procedure :: visit_reals => archive_visit_reals
    procedure :: visit_matrix => archive_visit_matrix
    procedure :: visit_real => archive_visit_real
    procedure :: visit_integers => archive_visit_integers
    procedure :: visit_integer => archive_visit_integer
    procedure :: visit_default_integer => archive_visit_default_integer
    procedure :: put_reals => archive_put_reals
    procedure :: put_integers => archive_put_integers
    procedure :: find => archive_find
  end type archive_t

contains

  !> Stores or restores an array.
  subroutine archive_visit_reals(self, name, values)
    class(archive_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: values(:)
    integer :: i
    if (.not. self%is_reading) then
      call self%put_reals(name, values)
      return
    end if
    i = self%find(name)
    if (i == 0) then
      call self%failure%raise('the checkpoint lacks the numbers '//name)
    else if (.not. allocated(self%fields(i)%reals)) then
      call self%failure%raise('in the checkpoint '//name//' is not real')
    else if (size(self%fields(i)%reals) /= size(values)) then
      call self%failure%raise('in the checkpoint '//name//' has another size')
    else
      values = self%fields(i)%reals
    end if
  end subroutine archive_visit_reals

  !> Stores or restores a matrix, column after column.
  subroutine archive_visit_matrix(self, name, values)
    class(archive_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout), contiguous :: values(:, :)
    real(rp) :: flat(size(values))
    flat = reshape(values, [size(values)])
    call self%visit_reals(name, flat)
    values = reshape(flat, shape(values))
  end subroutine archive_visit_matrix

  !> Stores or restores a number.
  subroutine archive_visit_real(self, name, value)
    class(archive_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: value
    real(rp) :: values(1)
    values(1) = value
    call self%visit_reals(name, values)
    value = values(1)
  end subroutine archive_visit_real

  !> Stores or restores integers.
  subroutine archive_visit_integers(self, name, values)
    class(archive_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: values(:)
    integer :: i
    if (.not. self%is_reading) then
      call self%put_integers(name, values)
      return
    end if
    i = self%find(name)
    if (i == 0) then
      call self%failure%raise('the checkpoint lacks the integers '//name)
    else if (.not. allocated(self%fields(i)%integers)) then
      call self%failure%raise('in the checkpoint '//name//' is not an integer')
    else if (size(self%fields(i)%integers) /= size(values)) then
      call self%failure%raise('in the checkpoint '//name//' has another size')
    else
      values = self%fields(i)%integers
    end if
  end subroutine archive_visit_integers

  !> Stores or restores one integer.
  subroutine archive_visit_integer(self, name, value)
    class(archive_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: value
    integer(i8) :: values(1)
    values(1) = value
    call self%visit_integers(name, values)
    value = values(1)
  end subroutine archive_visit_integer

  !> Stores or restores one integer of the default kind.
  subroutine archive_visit_default_integer(self, name, value)
    class(archive_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(inout) :: value
    integer(i8) :: wide
    wide = value
    call self%visit_integer(name, wide)
    if (abs(wide) > huge(value)) then
      call self%failure%raise('in the checkpoint '//name//' is out of range')
    else
      value = int(wide)
    end if
  end subroutine archive_visit_default_integer

  !> Adds a real field; the reader of a file calls it for everything that it finds.
  subroutine archive_put_reals(self, name, values)
    class(archive_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(in) :: values(:)
    type(field_t) :: field
    allocate (field%reals(size(values)))
    field%reals(:) = values
    call append(self, name, field)
  end subroutine archive_put_reals

  !> Adds an integer field.
  subroutine archive_put_integers(self, name, values)
    class(archive_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(in) :: values(:)
    type(field_t) :: field
    allocate (field%integers(size(values)))
    field%integers(:) = values
    call append(self, name, field)
  end subroutine archive_put_integers

  subroutine append(self, name, field)
    type(archive_t), intent(inout) :: self
    character(*), intent(in) :: name
    type(field_t), intent(inout) :: field
    type(field_t), allocatable :: more(:)
    integer :: i, n
    call require(len(name) <= NAME_LENGTH, 'cmaes_archive: a shorter name than '//name)
    if (.not. allocated(self%fields)) allocate (self%fields(0))
    n = size(self%fields)
    call require(self%find(name) == 0, 'cmaes_archive: '//name//' stored once')
    allocate (more(n + 1))
    do i = 1, n
      call move_field(self%fields(i), more(i))
    end do
    field%name = name
    call move_field(field, more(n + 1))
    call move_alloc(more, self%fields)
  end subroutine append

  subroutine move_field(from, to)
    type(field_t), intent(inout) :: from, to
    to%name = from%name
    if (allocated(from%reals)) call move_alloc(from%reals, to%reals)
    if (allocated(from%integers)) call move_alloc(from%integers, to%integers)
  end subroutine move_field

  !> Number of the field of that name, or 0.
  integer function archive_find(self, name) result(i)
    class(archive_t), intent(in) :: self
    character(*), intent(in) :: name
    if (allocated(self%fields)) then
      do i = 1, size(self%fields)
        if (self%fields(i)%name == name) return
      end do
    end if
    i = 0
  end function archive_find
end module cmaes_archive
