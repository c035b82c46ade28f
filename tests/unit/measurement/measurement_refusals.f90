! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks that a measurement file is refused, with the object that is at fault and what is wrong with it.
module measurement_refusals
  use base_errors, only: message_list_t
  use measurement_data, only: measurement_t
  use measurement_file, only: read_measurement
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  private
  public :: check_refused

contains

  !> Reads the file and checks that one message names `object` and says `what`; else prints what was found.
  subroutine check_refused(t, path, wing, object, what)
    type(testkit_t), intent(inout) :: t
    character(*), intent(in) :: path, object, what
    type(wing_t), intent(in) :: wing
    type(measurement_t) :: m
    type(message_list_t) :: found
    integer :: i
    logical :: is_there
    call read_measurement(path, wing, m, found)
    is_there = .false.
    do i = 1, found%count()
      is_there = is_there .or. (index(found%text(i), object//':') > 0 .and. index(found%text(i), what) > 0)
    end do
    call t%check('refused: '//what, is_there)
    if (.not. is_there) call found%print(6, '  found ')
  end subroutine check_refused
end module measurement_refusals
