! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the measurement of a file to all ranks.
module measurement_broadcast
  use base_errors, only: message_list_t
  use measurement_data, only: measurement_t
  use measurement_file, only: read_measurement
  use parallel_broadcast, only: broadcast_value
  use parallel_world, only: world_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: load_measurement

contains

  !> Reads the file on rank 0, and gives the measurement and the messages to all ranks. `may_be_plan` allows a file that is only the
  !> plan of an experiment (by default it is false). `wing` is the same on all ranks. Collective.
  subroutine load_measurement(world, path, wing, measurement, messages, may_be_plan)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    type(wing_t), intent(in) :: wing
    type(measurement_t), intent(out) :: measurement
    type(message_list_t), intent(inout) :: messages
    logical, intent(in), optional :: may_be_plan
    type(message_list_t) :: found
    character(:), allocatable :: text
    integer :: n, i
    if (world%is_root) call read_measurement(path, wing, measurement, found, may_be_plan)
    n = found%count()
    call world%broadcast_integer(n)
    do i = 1, n
      if (world%is_root) text = found%text(i)
      call world%broadcast_text(text)
      call messages%add(text)
    end do
    if (n == 0) call broadcast_value(world, measurement)
  end subroutine load_measurement
end module measurement_broadcast
