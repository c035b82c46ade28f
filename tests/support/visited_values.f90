! SPDX-License-Identifier: GPL-3.0-or-later
!> A type with every kind of component that a visitor knows.
module visited_values
  use base_kinds, only: i8, rp
  use base_visitor, only: visited_t, visitor_t
  implicit none
  private
  public :: member_t, mixed_t, row_t, fill, differences

  !> A part, and a member of a list.
  type, extends(visited_t) :: member_t
    integer :: number = 0
    character(:), allocatable :: name
  contains
    procedure :: visit => member_visit
  end type member_t

  !> An array whose size both sides know.
  type, extends(visited_t) :: row_t
    real(rp), allocatable :: numbers(:)
  contains
    procedure :: visit => row_visit
  end type row_t

  type, extends(visited_t) :: mixed_t
    real(rp) :: single = 0
    integer :: whole = 0
    integer(i8) :: long = 0
    logical :: flag = .false.
    character(6) :: word = ''
    real(rp) :: reals(3) = 0, matrix(2, 2) = 0, cube(2, 1, 2) = 0
    integer :: wholes(2) = 0, table(2, 2) = 0
    integer(i8) :: longs(2) = 0
    logical :: flags(3) = .false., flag_table(2, 2) = .false.
    character(4) :: words(2) = ''
    type(member_t) :: part
    type(member_t), allocatable :: list(:)
    character(:), allocatable :: any_text
    character(4), allocatable :: any_words(:)
    real(rp), allocatable :: any_reals(:), any_matrix(:, :), any_cube(:, :, :)
    integer, allocatable :: any_wholes(:), any_table(:, :)
    integer(i8), allocatable :: any_longs(:)
    logical, allocatable :: any_marks(:), any_flags(:, :)
  contains
    procedure :: visit => mixed_visit
  end type mixed_t

contains

  subroutine member_visit(self, visitor)
    class(member_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('number', self%number)
    call visitor%visit_allocatable('name', self%name)
  end subroutine member_visit

  subroutine row_visit(self, visitor)
    class(row_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('numbers', self%numbers)
  end subroutine row_visit

  subroutine mixed_visit(self, visitor)
    class(mixed_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('single', self%single)
    call visitor%visit('whole', self%whole)
    call visitor%visit('long', self%long)
    call visitor%visit('flag', self%flag)
    call visitor%visit('word', self%word)
    call visitor%visit('reals', self%reals)
    call visitor%visit('matrix', self%matrix)
    call visitor%visit('cube', self%cube)
    call visitor%visit('wholes', self%wholes)
    call visitor%visit('table', self%table)
    call visitor%visit('longs', self%longs)
    call visitor%visit('flags', self%flags)
    call visitor%visit('flag_table', self%flag_table)
    call visitor%visit('words', self%words)
    call visitor%visit('part', self%part)
    if (visitor%is_reading) allocate (self%list(visitor%count_of('list')))
    call visitor%visit_list('list', self%list)
    call visitor%visit_allocatable('any_text', self%any_text)
    call visitor%visit_allocatable('any_words', self%any_words)
    call visitor%visit_allocatable('any_reals', self%any_reals)
    call visitor%visit_allocatable('any_matrix', self%any_matrix)
    call visitor%visit_allocatable('any_cube', self%any_cube)
    call visitor%visit_allocatable('any_wholes', self%any_wholes)
    call visitor%visit_allocatable('any_table', self%any_table)
    call visitor%visit_allocatable('any_longs', self%any_longs)
    call visitor%visit_allocatable('any_marks', self%any_marks)
    call visitor%visit_allocatable('any_flags', self%any_flags)
  end subroutine mixed_visit

  !> Numbers that are easily lost: the smallest and the largest, a negative zero. Without `is_full` nothing optional is there, and
  !> the list is empty.
  subroutine fill(value, is_full)
    type(mixed_t), intent(out) :: value
    logical, intent(in) :: is_full
    value%single = tiny(1.0_rp)
    value%whole = -huge(1)
    value%long = -huge(1_i8) - 1
    value%flag = .true.
    value%word = ' ab'
    value%reals = [-0.0_rp, huge(1.0_rp), 0.1_rp]
    value%matrix = reshape([1.0_rp, 2.0_rp, 3.0_rp, 4.0_rp], [2, 2])
    value%cube = reshape([1.0_rp, 2.0_rp, 3.0_rp, 4.0_rp]/3, [2, 1, 2])
    value%wholes = [-1, huge(1)]
    value%table = reshape([1, -2, 3, -4], [2, 2])
    value%longs = [2_i8**53, -7_i8]
    value%flags = [.true., .false., .true.]
    value%flag_table = reshape([.true., .false., .false., .true.], [2, 2])
    value%words = ['one ', ' two']
    value%part%number = 17
    value%part%name = 'hinge'
    allocate (value%list(merge(3, 0, is_full)))
    if (.not. is_full) return
    value%list%number = [4, 5, 6]
    value%list(1)%name = 'first'
    value%list(3)%name = ''
    value%any_text = 'the text'//char(200)//char(0)
    value%any_words = ['a   ', 'bcde', '    ']
    value%any_reals = [real(rp) ::]
    value%any_matrix = reshape([1.5_rp, 2.5_rp, 3.5_rp, 4.5_rp, 5.5_rp, 6.5_rp], [2, 3])
    value%any_cube = reshape([1.5_rp, 2.5_rp, 3.5_rp, 4.5_rp], [1, 2, 2])
    value%any_wholes = [3, 2, 1]
    value%any_table = reshape([1, 2, 3, 4, 5, 6], [3, 2])
    value%any_longs = [-2_i8**53, 0_i8]
    value%any_marks = [.false., .true.]
    value%any_flags = reshape([.true., .false., .true., .true.], [2, 2])
  end subroutine fill

  !> Names of the components that differ, each with a blank before it.
  function differences(a, b) result(names)
    type(mixed_t), intent(in) :: a, b
    character(:), allocatable :: names
    integer :: i
    names = ''
    call compare('single', same([a%single], [b%single]))
    call compare('whole', a%whole == b%whole)
    call compare('long', a%long == b%long)
    call compare('flag', a%flag .eqv. b%flag)
    call compare('word', a%word == b%word)
    call compare('reals', same(a%reals, b%reals))
    call compare('matrix', same([a%matrix], [b%matrix]))
    call compare('cube', same([a%cube], [b%cube]))
    call compare('wholes', all(a%wholes == b%wholes))
    call compare('table', all(a%table == b%table))
    call compare('longs', all(a%longs == b%longs))
    call compare('flags', all(a%flags .eqv. b%flags))
    call compare('flag_table', all(a%flag_table .eqv. b%flag_table))
    call compare('words', all(a%words == b%words))
    call compare('part', same_member(a%part, b%part))
    call compare('list', size(a%list) == size(b%list))
    do i = 1, min(size(a%list), size(b%list))
      call compare('list', same_member(a%list(i), b%list(i)))
    end do
    call compare('any_text', allocated(a%any_text) .eqv. allocated(b%any_text))
    call compare('any_words', allocated(a%any_words) .eqv. allocated(b%any_words))
    call compare('any_reals', allocated(a%any_reals) .eqv. allocated(b%any_reals))
    call compare('any_matrix', allocated(a%any_matrix) .eqv. allocated(b%any_matrix))
    if (.not. (allocated(a%any_matrix) .and. allocated(b%any_text))) return
    call compare('any_text', a%any_text == b%any_text .and. len(a%any_text) == len(b%any_text))
    call compare('any_words', all(a%any_words == b%any_words))
    call compare('any_reals', same(a%any_reals, b%any_reals))
    call compare('any_matrix', same([a%any_matrix], [b%any_matrix]) .and. all(shape(a%any_matrix) == shape(b%any_matrix)))
    call compare('any_cube', same([a%any_cube], [b%any_cube]) .and. all(shape(a%any_cube) == shape(b%any_cube)))
    call compare('any_wholes', all(a%any_wholes == b%any_wholes))
    call compare('any_table', all(a%any_table == b%any_table))
    call compare('any_longs', all(a%any_longs == b%any_longs))
    call compare('any_marks', all(a%any_marks .eqv. b%any_marks))
    call compare('any_flags', all(a%any_flags .eqv. b%any_flags))

  contains

    subroutine compare(name, is_same)
      character(*), intent(in) :: name
      logical, intent(in) :: is_same
      if (.not. is_same) names = names//' '//name
    end subroutine compare
  end function differences

  pure logical function same_member(a, b) result(same)
    type(member_t), intent(in) :: a, b
    same = a%number == b%number .and. (allocated(a%name) .eqv. allocated(b%name))
    if (same .and. allocated(a%name)) same = a%name == b%name .and. len(a%name) == len(b%name)
  end function same_member

  !> To the bit.
  pure logical function same(a, b)
    real(rp), intent(in) :: a(:), b(:)
    same = size(a) == size(b)
    if (same) same = all(transfer(a, [0_i8]) == transfer(b, [0_i8]))
  end function same
end module visited_values
