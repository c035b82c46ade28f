! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs tasks on the farm and records their results in a journal. A diagnosis that was killed and starts again asks for the same
!> tasks in the same order, gets their results from the journal, and so reaches the point where it was. It needs nothing else,
!> as ranks keep no state between tasks.
module diagnosis_journalled_tasks
  use base_checksum, only: checksum_add, checksum_reals
  use base_kinds, only: i8, rp
  use diagnosis_wing_task, only: wing_runner_t
  use io_journal, only: journal_t
  use parallel_farm, only: farm_t
  implicit none
  private
  public :: run_journalled_tasks

contains

  !> Does one batch of tasks inputs(:, n) about wings in these `shapes`. results(:, n) are 0 unless all tasks have one
  !> (`is_valid`). Without a journal the farm does them all. Rank 0 calls it; the others serve.
  subroutine run_journalled_tasks(farm, runner, journal, shapes, inputs, results, is_valid)
    type(farm_t), intent(inout) :: farm
    type(wing_runner_t), intent(inout) :: runner
    type(journal_t), pointer, intent(in) :: journal
    real(rp), intent(in) :: shapes(:), inputs(:, :)
    real(rp), contiguous, intent(inout) :: results(:, :)
    logical, intent(out) :: is_valid
    real(rp) :: seconds(size(inputs, 2))
    integer :: statuses(size(inputs, 2)), l
    integer(i8) :: key
    logical :: is_known
    is_valid = .false.
    key = 0
    if (associated(journal)) then
      key = checksum_reals(shapes, 0_i8)
      do l = 1, size(inputs, 2)
        key = checksum_add(key, checksum_reals(inputs(:, l), size(shapes) + (l - 1)*size(inputs, 1, kind=i8)))
      end do
      call journal%recall(key, results, is_valid, is_known)
      if (is_known) return
    end if
    call farm%broadcast(runner, shapes)
    call farm%run(runner, [(l, l=1, size(inputs, 2))], inputs, results, statuses, seconds)
    is_valid = all(statuses == 0)
    if (.not. is_valid) results = 0
    if (associated(journal)) call journal%record(key, results, is_valid)
  end subroutine run_journalled_tasks
end module diagnosis_journalled_tasks
