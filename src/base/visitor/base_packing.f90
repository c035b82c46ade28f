! SPDX-License-Identifier: GPL-3.0-or-later
!> Turns a value into an array of reals, for a message to another process or for a row of a table.
!>
!> A real is one number, an integer or logical two of 32 bits each (so that all 64 are exact), a text its length and its characters.
module base_packing
  use base_errors, only: failure_t, require
  use base_kinds, only: i8, rp
  use base_text, only: number_text
  use base_visitor, only: visited_t, visitor_t
  implicit none
  private
  public :: count_packed, pack_value, unpack_value

  integer(i8), parameter :: HALF = 2_i8**32

  !> Takes the numbers of a value.
  type, extends(visitor_t) :: packer_t
    real(rp), allocatable :: words(:)
    integer :: n = 0 !< words in use
  contains
    procedure :: carry_reals => packer_reals
    procedure :: carry_integers => packer_integers
    procedure :: carry_text => packer_text
  end type packer_t

  !> Gives the numbers back in the same order.
  type, extends(visitor_t) :: unpacker_t
    real(rp), allocatable :: words(:)
    integer :: at = 0 !< words that were given
  contains
    procedure :: most => unpacker_most
    procedure :: carry_reals => unpacker_reals
    procedure :: carry_integers => unpacker_integers
    procedure :: carry_text => unpacker_text
  end type unpacker_t

contains

  !> Packs all of `value`, which is left as it is.
  subroutine pack_value(value, words)
    class(visited_t), intent(inout) :: value
    real(rp), allocatable, intent(out) :: words(:)
    type(packer_t) :: packer
    allocate (packer%words(64))
    call value%visit(packer)
    words = packer%words(:packer%n)
  end subroutine pack_value

  !> Returns how many words `pack_value` makes of it.
  integer function count_packed(value) result(n)
    class(visited_t), intent(inout) :: value
    type(packer_t) :: packer
    allocate (packer%words(64))
    call value%visit(packer)
    n = packer%n
  end function count_packed

  !> Does the inverse of `pack_value`. Fails if the words are too few or too many, or if they do not form a value of this kind.
  subroutine unpack_value(words, value, failure)
    real(rp), intent(in) :: words(:)
    class(visited_t), intent(inout) :: value
    type(failure_t), intent(inout) :: failure
    type(unpacker_t) :: unpacker
    if (failure%failed) return
    unpacker%is_reading = .true.
    allocate (unpacker%words, source=words)
    call value%visit(unpacker)
    if (unpacker%failure%failed) then
      call failure%raise(unpacker%failure%reason)
    else if (unpacker%at < size(words)) then
      call failure%raise('damaged data, from another process or a backup: '//number_text(size(words) - unpacker%at)// &
                         ' numbers too many; please report this')
    end if
  end subroutine unpack_value

  !> Appends these reals to the packed values.
  subroutine packer_reals(self, name, values)
    class(packer_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: values(:)
    real(rp), allocatable :: more(:)
    call require(name /= '', 'base_packing: a component with a name')
    if (self%n + size(values) > size(self%words)) then
      allocate (more(2*(self%n + size(values))))
      more(:self%n) = self%words(:self%n)
      call move_alloc(more, self%words)
    end if
    self%words(self%n + 1:self%n + size(values)) = values
    self%n = self%n + size(values)
  end subroutine packer_reals

  !> Appends these integers to the packed values.
  subroutine packer_integers(self, name, values)
    class(packer_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: values(:)
    real(rp) :: halves(2*size(values))
    halves(1::2) = real(shiftr(values, 32), rp)
    halves(2::2) = real(iand(values, HALF - 1), rp)
    call self%carry_reals(name, halves)
  end subroutine packer_integers

  !> Appends this text to the packed values, with its length.
  subroutine packer_text(self, name, text)
    class(packer_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(inout) :: text
    real(rp) :: codes(len(text) + 1)
    integer :: i
    codes = [real(len(text), rp), (real(ichar(text(i:i)), rp), i=1, len(text))]
    call self%carry_reals(name, codes)
  end subroutine packer_text

  !> Returns how many words are left.
  pure integer(i8) function unpacker_most(self) result(most)
    class(unpacker_t), intent(in) :: self
    most = size(self%words) - self%at
  end function unpacker_most

  !> Takes the next reals of the packed values.
  subroutine unpacker_reals(self, name, values)
    class(unpacker_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: values(:)
    if (size(values) > self%most()) then
      call self%failure%raise('damaged data, from another process or a backup: they end before '//name//'; please report this')
      return
    end if
    values = self%words(self%at + 1:self%at + size(values))
    self%at = self%at + size(values)
  end subroutine unpacker_reals

  !> Takes the next integers of the packed values.
  subroutine unpacker_integers(self, name, values)
    class(unpacker_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: values(:)
    real(rp) :: halves(2*size(values))
    call self%carry_reals(name, halves)
    if (self%failure%failed) return
    if (.not. all(halves >= 0 .and. halves < HALF)) then
      call self%failure%raise('damaged data, from another process or a backup: no integer where '//name// &
                              ' should be; please report this')
    else
      values = ior(shiftl(int(halves(1::2), i8), 32), int(halves(2::2), i8))
    end if
  end subroutine unpacker_integers

  !> Takes the next text of the packed values, and allocates it to its length.
  subroutine unpacker_text(self, name, text)
    class(unpacker_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(inout) :: text
    real(rp) :: length(1)
    real(rp), allocatable :: codes(:)
    integer :: i
    call self%carry_reals(name, length)
    if (self%failure%failed) return
    if (.not. (length(1) >= 0 .and. length(1) <= self%most())) then
      call self%failure%raise('damaged data, from another process or a backup: they end in '//name//'; please report this')
      return
    end if
    allocate (codes(int(length(1))))
    call self%carry_reals(name, codes)
    if (.not. all(codes >= 0 .and. codes < 256)) then
      call self%failure%raise('damaged data, from another process or a backup: no text where '//name// &
                              ' should be; please report this')
      return
    end if
    allocate (character(size(codes)) :: text)
    do i = 1, size(codes)
      text(i:i) = char(int(codes(i)))
    end do
  end subroutine unpacker_text
end module base_packing
