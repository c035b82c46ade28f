! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks that what is read of a measurement file that the program writes is what it has written.
module written_again
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: i8, rp
  use base_packing, only: pack_value
  use measurement_data, only: measurement_t
  use measurement_file, only: read_measurement
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use whole_measurement, only: write_measurement
  implicit none
  private
  public :: check_written_again

contains

  !> Writes `m` to the file, reads it, and checks that all components are the same to the bit.
  subroutine check_written_again(t, path, wing, m)
    type(testkit_t), intent(inout) :: t
    character(*), intent(in) :: path
    type(wing_t), intent(in) :: wing
    type(measurement_t), intent(inout) :: m
    type(measurement_t) :: other
    type(failure_t) :: failure
    type(message_list_t) :: messages
    real(rp), allocatable :: words(:), others(:)
    call write_measurement(path, m, failure)
    call t%check('the measurement is written',.not. failure%failed)
    call read_measurement(path, wing, other, messages)
    call messages%print(6, '  ')
    call t%check('what was written is read', messages%count() == 0)
    call pack_value(m, words)
    call pack_value(other, others)
    call t%check('there is as much of it', size(words) == size(others))
    if (size(words) /= size(others)) return
    call t%check('and it is the same to the bit', all(transfer(words, [0_i8]) == transfer(others, [0_i8])))
  end subroutine check_written_again
end module written_again
