! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs the commands that only read files.
module flusi_postprocess
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_outcome, only: outcome_t, OUTCOME_DIFFERENT, OUTCOME_MISTAKE
  use flusi_command, only: command_t
  use io_keyvalues, only: N_KEYS, field_keys, key_line, keyvalues, compare_keys, write_verdict
  implicit none
  private
  public :: run_keyvalues, run_compare_keys

contains

  !> Prints the key of a field, a few numbers that characterise it. If the program is called as FLUSI is called, it also writes them
  !> to FILE.key.
  subroutine run_keyvalues(command, outcome)
    type(command_t), intent(in) :: command
    type(outcome_t), intent(inout) :: outcome
    real(rp) :: keys(N_KEYS)
    if (command%postprocess) then
      call keyvalues(command%file, output_unit, outcome%failure)
    else
      call field_keys(command%file, keys, outcome%failure)
      if (.not. outcome%failure%failed) write (output_unit, '(a)') key_line(keys)
    end if
    if (.not. outcome%failure%failed) return
    write (error_unit, '(a)') 'flusi: '//outcome%failure%reason
    call outcome%classify(OUTCOME_MISTAKE)
  end subroutine run_keyvalues

  !> Compares two keys of fields. Sets `outcome` to OUTCOME_DIFFERENT if they differ.
  subroutine run_compare_keys(command, outcome)
    type(command_t), intent(in) :: command
    type(outcome_t), intent(inout) :: outcome
    type(failure_t) :: failure
    logical :: equal
    call compare_keys(command%file, command%other_file, output_unit, equal, failure)
    if (.not. equal) call outcome%end_as(OUTCOME_DIFFERENT)
    if (failure%failed) then
      write (error_unit, '(a)') 'flusi: '//failure%reason
      call outcome%fail(OUTCOME_MISTAKE, failure%reason)
    end if
    if (command%postprocess) call write_verdict(equal, failure)
  end subroutine run_compare_keys
end module flusi_postprocess
