! SPDX-License-Identifier: GPL-3.0-or-later
!> A value of rank 0 arrives on all ranks with all its components, present or not.
program test_broadcast
  use parallel_broadcast, only: broadcast_value
  use testkit, only: testkit_t
  use visited_values, only: differences, fill, mixed_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.true.)
  call test_value(.true.)
  call test_value(.false.)
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
end program test_broadcast
