! SPDX-License-Identifier: GPL-3.0-or-later
!> The commands that look at files and run nothing.
module flusi_postprocess
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  use base_constants, only: EXIT_OK, EXIT_FAILURE, EXIT_USER
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use flusi_command, only: command_t
  use io_keyvalues, only: N_KEYS, field_keys, key_line, keyvalues, compare_keys, write_verdict
  implicit none
  private
  public :: run_keyvalues, run_compare_keys

contains

  !> Prints the key of a field; called in FLUSI's way, writes it to FILE.key as well.
  subroutine run_keyvalues(command, code)
    type(command_t), intent(in) :: command
    integer, intent(out) :: code
    type(failure_t) :: failure
    real(rp) :: keys(N_KEYS)
    code = EXIT_OK
    if (command%postprocess) then
      call keyvalues(command%file, output_unit, failure)
    else
      call field_keys(command%file, keys, failure)
      if (.not. failure%failed) write (output_unit, '(a)') key_line(keys)
    end if
    if (.not. failure%failed) return
    write (error_unit, '(a)') 'flusi: '//failure%reason
    code = EXIT_USER
  end subroutine run_keyvalues

  !> Compares two keys; exit code 1 if they differ.
  subroutine run_compare_keys(command, code)
    type(command_t), intent(in) :: command
    integer, intent(out) :: code
    type(failure_t) :: failure
    logical :: equal
    call compare_keys(command%file, command%other_file, output_unit, equal, failure)
    code = merge(EXIT_OK, EXIT_FAILURE, equal)
    if (failure%failed) then
      write (error_unit, '(a)') 'flusi: '//failure%reason
      code = EXIT_USER
    end if
    if (command%postprocess) call write_verdict(equal, failure)
  end subroutine run_compare_keys
end module flusi_postprocess
