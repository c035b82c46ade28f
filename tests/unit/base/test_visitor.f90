! SPDX-License-Identifier: GPL-3.0-or-later
!> A value with all kinds of components comes back from a message bit by bit; one that is cut anywhere, or has numbers that are
!> none of it, is refused; and a new component changes a fingerprint, with no place of its own in it.
program test_visitor
  use base_errors, only: failure_t
  use base_fingerprint, only: fingerprint_t
  use base_kinds, only: i8, rp
  use base_packing, only: count_packed, pack_value, unpack_value
  use testkit, only: testkit_t
  use visited_values, only: differences, fill, mixed_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_round_trip(.true.)
  call test_round_trip(.false.)
  call test_cuts()
  call test_nonsense()
  call test_fingerprint()
  call t%finish()

contains

  !> With optional components allocated, or not.
  subroutine test_round_trip(is_full)
    logical, intent(in) :: is_full
    type(mixed_t) :: value, copy
    real(rp), allocatable :: words(:), again(:)
    type(failure_t) :: failure
    call fill(value, is_full)
    call pack_value(value, words)
    call t%check('the number of words is known before', count_packed(value) == size(words))
    call unpack_value(words, copy, failure)
    call t%check('a whole message is accepted', (.not. failure%failed))
    call t%check('all components come back:'//differences(value, copy), differences(value, copy) == '')
    call pack_value(copy, again)
    call t%check('and make the same message', all(transfer(again, [0_i8]) == transfer(words, [0_i8])))
  end subroutine test_round_trip

  !> Every message that is too short, or too long, is refused.
  subroutine test_cuts()
    type(mixed_t) :: value
    real(rp), allocatable :: words(:)
    integer :: i, n_accepted, n_unnamed
    call fill(value, .true.)
    call pack_value(value, words)
    n_accepted = 0
    n_unnamed = 0
    do i = 0, size(words) + 1
      if (i /= size(words)) call try([words, 1.0_rp], i, n_accepted, n_unnamed)
    end do
    call t%check('no message of another length is accepted', n_accepted == 0)
    call t%check('and all refusals have a reason', n_unnamed == 0)
  end subroutine test_cuts

  subroutine try(words, n, n_accepted, n_unnamed)
    real(rp), intent(in) :: words(:)
    integer, intent(in) :: n
    integer, intent(inout) :: n_accepted, n_unnamed
    type(mixed_t) :: copy
    type(failure_t) :: failure
    call unpack_value(words(:n), copy, failure)
    if (.not. failure%failed) n_accepted = n_accepted + 1
    if (failure%failed) then
      if (index(failure%reason, 'damaged') + index(failure%reason, 'range') == 0) &
        n_unnamed = n_unnamed + 1
    end if
  end subroutine try

  !> One number after the other is replaced by one that is no size, character or half of an integer: nothing crashes.
  subroutine test_nonsense()
    type(mixed_t) :: value, copy
    real(rp), allocatable :: words(:), wrong(:)
    type(failure_t) :: failure
    integer :: i, k, n_refused
    real(rp), parameter :: NONSENSE(3) = [-1.0_rp, 4294967295.0_rp, 1.0e300_rp]
    call fill(value, .true.)
    call pack_value(value, words)
    n_refused = 0
    do i = 1, size(words)
      do k = 1, size(NONSENSE)
        call fresh(copy)
        failure = failure_t()
        wrong = words
        wrong(i) = NONSENSE(k)
        call unpack_value(wrong, copy, failure)
        if (failure%failed) n_refused = n_refused + 1
      end do
    end do
    call t%check('numbers that cannot be are found', n_refused > size(words))
    call check_named(words, 2, 'no integer where whole should be')
    call check_named(words, 9, 'no text where word should be')
  end subroutine test_nonsense

  !> Number i is replaced.
  subroutine check_named(words, i, sentence)
    real(rp), intent(in) :: words(:)
    integer, intent(in) :: i
    character(*), intent(in) :: sentence
    type(mixed_t) :: copy
    type(failure_t) :: failure
    real(rp), allocatable :: wrong(:)
    wrong = words
    wrong(i) = -1
    call unpack_value(wrong, copy, failure)
    call t%check('a number that cannot be is found', failure%failed)
    if (failure%failed) call t%check(sentence//': '//failure%reason, index(failure%reason, sentence) > 0)
  end subroutine check_named

  subroutine fresh(value)
    type(mixed_t), intent(out) :: value
    value%single = 0
  end subroutine fresh

  subroutine test_fingerprint()
    type(mixed_t) :: value
    call fill(value, .true.)
    call t%check('equal values have equal fingerprints', mark(value, .false.) == mark(value, .false.))
    call t%check('what its owner sums is no longer in the rest', mark(value, .false.) /= mark(value, .true.))
    call test_omission(value)
    call changes('an integer', 1)
    call changes('a member of a list', 2)
    call changes('a text', 3)
    call changes('a logical of a matrix', 4)
  end subroutine test_fingerprint

  !> What the owner omits does not change the fingerprint, and nothing is left if it omits all.
  subroutine test_omission(value)
    type(mixed_t), intent(inout) :: value
    type(fingerprint_t) :: without, changed
    real(rp) :: single
    call value%visit(without)
    call without%omit('single')
    call without%omit_part('list')
    single = value%single
    value%single = 7*single + 1
    value%list(2)%number = value%list(2)%number + 1
    call value%visit(changed)
    call t%check('changes of what is omitted count until it is omitted', changed%rest() /= without%rest())
    call changed%omit('single')
    call changed%omit_part('list')
    call t%check('and not afterwards', changed%rest() == without%rest() .and. without%rest() /= 0)
    value%single = single
    value%list(2)%number = value%list(2)%number - 1
  end subroutine test_omission

  !> The sum of all components, or of all but `single`.
  integer(i8) function mark(value, is_asked)
    type(mixed_t), intent(inout) :: value
    logical, intent(in) :: is_asked
    type(fingerprint_t) :: marks
    call value%visit(marks)
    if (is_asked) call t%check('the owner gets the numbers', all(abs(marks%numbers('single') - value%single) <= 0))
    mark = marks%rest()
  end function mark

  subroutine changes(what, which)
    character(*), intent(in) :: what
    integer, intent(in) :: which
    type(mixed_t) :: value
    integer(i8) :: before
    call fill(value, .true.)
    before = mark(value, .false.)
    select case (which)
    case (1)
      value%whole = value%whole + 1
    case (2)
      value%list(2)%number = value%list(2)%number + 1
    case (3)
      value%any_text(2:2) = 'x'
    case (4)
      value%any_flags(2, 1) = .not. value%any_flags(2, 1)
    end select
    call t%check('a fingerprint tells '//what, mark(value, .false.) /= before)
  end subroutine changes
end program test_visitor
