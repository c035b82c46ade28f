! SPDX-License-Identifier: GPL-3.0-or-later
!> msm_probe wing|measurement FILE reads a file without a seal before another program does. If damage crashes the HDF5 library, it
!> ends this process and not the other program. Exit code 0 means that the file can be read; it may still have mistakes.
program msm_probe
  use base_errors, only: failure_t, message_list_t
  use base_outcome, only: exit_code_of, OUTCOME_DONE, OUTCOME_MISTAKE
  use base_process, only: exit_with
  use measurement_data, only: measurement_t
  use measurement_file, only: read_measurement_unguarded
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing_unguarded
  use solid_wing_report, only: wing_report_t
  implicit none
  character(16) :: kind
  character(:), allocatable :: path
  type(failure_t) :: failure
  type(measurement_t) :: measurement
  type(message_list_t) :: messages
  type(wing_report_t) :: report
  type(wing_t) :: wing
  logical :: is_read
  integer :: length

  if (command_argument_count() /= 2) call exit_with(exit_code_of(OUTCOME_MISTAKE))
  call get_command_argument(1, kind)
  call get_command_argument(2, length=length)
  allocate (character(length) :: path)
  call get_command_argument(2, path)
  select case (kind)
  case ('wing')
    call read_wing_unguarded(path, wing, messages)
  case ('measurement')
    call read_measurement_unguarded(path, .true., measurement, is_read, report, failure)
  case default
    call exit_with(exit_code_of(OUTCOME_MISTAKE))
  end select
  call exit_with(exit_code_of(OUTCOME_DONE))
end program msm_probe
