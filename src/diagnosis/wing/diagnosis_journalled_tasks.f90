! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs tasks on the pool and records their results in a journal. A diagnosis that was killed and starts again asks for the same
!> tasks in the same order, gets their results from the journal, and so reaches the point where it was. It needs nothing else,
!> as ranks keep no state between tasks.
module diagnosis_journalled_tasks
  use base_checksum, only: checksum_add, checksum_reals
  use base_kinds, only: i8
  use io_journal, only: journal_t
  use measurement_bending_pool, only: bending_batch_t, bending_pool_t
  use measurement_bending_task, only: FACT_VIOLATION
  implicit none
  private
  public :: run_journalled_tasks

contains

  !> Does one batch of tasks. Its outputs are 0 unless all tasks have found a shape outside the excluded zones (`is_valid`). Without
  !> a journal the pool does them all. Rank 0 calls it; the others serve.
  subroutine run_journalled_tasks(pool, journal, batch, is_valid)
    type(bending_pool_t), intent(inout) :: pool
    type(journal_t), pointer, intent(in) :: journal
    type(bending_batch_t), intent(inout) :: batch
    logical, intent(out) :: is_valid
    integer(i8) :: key
    integer :: l
    logical :: is_known
    is_valid = .false.
    key = 0
    if (associated(journal)) then
      key = checksum_reals(batch%starts, 0_i8)
      do l = 1, size(batch%inputs, 2)
        key = checksum_add(key, checksum_reals(batch%inputs(:, l), size(batch%starts) + (l - 1)*size(batch%inputs, 1, kind=i8)))
      end do
      call journal%recall(key, batch%outputs, is_valid, is_known)
      if (is_known) return
    end if
    call pool%run(batch)
    is_valid = all(batch%statuses == 0) .and. .not. any(batch%outputs(FACT_VIOLATION:FACT_VIOLATION + 1, :) > 0)
    if (.not. is_valid) batch%outputs = 0
    if (associated(journal)) call journal%record(key, batch%outputs, is_valid)
  end subroutine run_journalled_tasks
end module diagnosis_journalled_tasks
