! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the measurement files that follow the wing file on the command line and prints what is in them; exit code 1 if
!> one is refused, with the report.
program test_measurements
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use measurement_data, only: measurement_t
  use measurement_file, only: read_measurement
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(measurement_t) :: m
  type(message_list_t) :: messages
  character(1000) :: path
  integer :: i, k, l

  call t%start(parallel=.false.)
  call get_command_argument(1, path)
  call read_wing(trim(path), wing, messages)
  do i = 2, command_argument_count()
    call get_command_argument(i, path)
    call read_measurement(trim(path), wing, m, messages)
    call t%check(trim(path)//' is accepted', messages%count() == 0)
    do k = 1, messages%count()
      write (*, '(a)') '      '//messages%text(k)
    end do
    if (messages%count() > 0) exit
    write (*, '(6x,3(i0,a))') size(m%x), ' x ', size(m%y), ' grid points, ', size(m%observations), ' observations'
    do l = 1, size(m%loads)
      write (*, '(6x,a,es12.4,a,2es12.4,a,i0,a,2es12.4)') m%loads(l)%name//':', m%loads(l)%force, ' N at', &
        m%loads(l)%point, ' m, ', m%loads(l)%count(), ' heights, deformations [m] from', &
        minval([(m%deformation(l, k), k=1, m%loads(l)%count()), 0.0_rp]), &
        maxval([(m%deformation(l, k), k=1, m%loads(l)%count()), 0.0_rp])
    end do
  end do
  call t%check('there was a file', command_argument_count() > 1)
  call t%finish()
end program test_measurements
