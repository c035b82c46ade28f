! SPDX-License-Identifier: GPL-3.0-or-later
!> A value of rank 0 arrives on all ranks with all its components, present or not, and so does its failure.
program test_broadcast
  use base_errors, only: failure_t
  use parallel_broadcast, only: broadcast_value
  use parallel_failure, only: broadcast_failure
  use testkit, only: testkit_t
  use visited_values, only: differences, fill, mixed_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.true.)
  call test_value(.true.)
  call test_value(.false.)
  call test_failure()
  call t%finish()

contains

  subroutine test_value(is_full)
    logical, intent(in) :: is_full
    type(mixed_t) :: value, wanted
    call fill(wanted, is_full)
    if (t%world%is_root) call fill(value, is_full)
    call broadcast_value(t%world, value)
    call t%check('all components arrive:'//differences(wanted, value), differences(wanted, value) == '')
  end subroutine test_value

  subroutine test_failure()
    type(failure_t) :: own, failure, other, none
    call broadcast_failure(t%world, own, none)
    call t%check('without a failure there is none', .not. none%failed)
    if (.not. t%world%is_root) call own%raise('that of another rank')
    call broadcast_failure(t%world, own, none)
    call t%check('that of another rank does not count', .not. none%failed)
    own = failure_t()
    if (t%world%is_root) call own%raise('that of rank 0')
    call broadcast_failure(t%world, own, failure)
    call t%check('that of rank 0 is one of all', failure%failed)
    if (failure%failed) call t%check('with its reason', failure%reason == 'that of rank 0')
    call other%raise('an earlier one')
    call broadcast_failure(t%world, own, other)
    call t%check('an earlier one stays', other%reason == 'an earlier one')
  end subroutine test_failure
end program test_broadcast
