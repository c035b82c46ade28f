! SPDX-License-Identifier: GPL-3.0-or-later
!> A file without heights is the plan of an experiment, on all ranks, for those who ask for one; for others it is a file
!> without its heights.
program test_measurement_plan
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use measurement_data, only: measurement_t
  use measurement_broadcast, only: load_measurement
  use measurement_writer, only: measurement_writer_t, MM, NX, NY
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use testkit, only: testkit_t
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use whole_measurement, only: write_measurement
  implicit none
  character(*), parameter :: MEASURED = 'measured.h5', PLANNED = 'planned.h5', AGAIN = 'again.h5', HALF = 'half.h5', &
                             READINGS = 'readings.h5'
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(message_list_t) :: messages

  call t%start(parallel=.true.)
  if (t%world%is_root) call write_files()
  call t%world%barrier()
  call read_wing('wing.h5', wing, messages)
  call t%check('the wing is valid', messages%count() == 0)
  call read_plan()
  call read_others()
  call refuse_plans()
  call t%finish()

contains

  subroutine write_files()
    type(measurement_writer_t) :: w
    real(rp) :: nan
    integer :: i
    nan = ieee_value(nan, ieee_quiet_nan)
    call w%sample('wing.h5')
    call w%close()
    call w%measurement(MEASURED)
    call w%close()
    call w%measurement(PLANNED)
    call w%delete('/reference/z')
    call w%delete('/loads/tip/z')
    call w%delete_attribute('/points/move', 'value')
    call w%reals('/reference/sigma', [NX, NY], merge(1.0e-6_rp, nan, [(i /= 4, i=1, NX*NY)]))
    call w%reals('/loads/tip/sigma', [NX, NY], merge(3.0e-6_rp, nan, [(i /= 5, i=1, NX*NY)]))
    call w%load('zero', [1.5_rp*MM, 1.0_rp*MM])
    call w%real_attribute('/loads/zero', 'force', [0.0_rp])
    call w%text_attribute('/points/turn', 'load', 'zero')
    call w%close()
    call w%measurement(HALF)
    call w%delete('/reference/z')
    call w%close()
    call w%measurement(READINGS)
    call w%delete('/reference')
    call w%delete('/loads/tip')
    call w%delete_attribute('/points/move', 'value')
    call w%close()
  end subroutine write_files

  !> Heights will be seen under every force, where their sd are known, with the declared errors; written again, it stays a plan.
  subroutine read_plan()
    type(measurement_t) :: m
    type(failure_t) :: failure
    integer :: i
    call load_measurement(t%world, PLANNED, wing, m, messages, .true.)
    do i = 1, 2
      call t%check('the plan is valid', messages%count() == 0)
      if (messages%count() > 0) call messages%print(6, '  ')
      if (messages%count() > 0) return
      call t%check('it is one', m%is_plan)
      call t%check('without force there is no scan', all(m%loads%has_surface .eqv. [.true., .true., .false.]))
      call t%check('heights will be seen', m%loads(1)%count() == NX*NY - 1 .and. m%loads(2)%count() == NX*NY - 2)
      call t%check('at their places', all(m%loads(1)%node(:, NX + 1) == [2, 2]))
      call t%check('none has been', norm2([m%loads(1)%height, m%loads(2)%height]) <= 0 .and. &
                   .not. any(abs(m%unloaded) > 0) .and. abs(m%observations(1)%value) <= 0)
      call t%check_close('errors are as declared', m%deformation_sigma(1, 1), sqrt(10.0_rp)*1.0e-6_rp, rtol=1.0e-14_rp)
      if (i == 2) exit
      if (t%world%is_root) call write_measurement(AGAIN, m, failure)
      call t%check('it can be written',.not. failure%failed)
      call t%world%barrier()
      call load_measurement(t%world, AGAIN, wing, m, messages, .true.)
    end do
  end subroutine read_plan

  subroutine read_others()
    type(measurement_t) :: m
    call load_measurement(t%world, MEASURED, wing, m, messages, .true.)
    call t%check('what has heights is none',.not. m%is_plan .and. messages%count() == 0)
    call t%check('  and keeps them', m%loads(2)%count() == NX*NY - 2)
    call load_measurement(t%world, READINGS, wing, m, messages, .true.)
    call t%check('a plan of readings alone', m%is_plan .and. messages%count() == 0 .and. size(m%observations) == 2)
  end subroutine read_others

  !> A plan is no measurement, which is said once; heights are known with their unloaded ones only.
  subroutine refuse_plans()
    call refused(PLANNED, .false., '/reference/z: missing; without heights a file is the plan of an experiment')
    call refused(HALF, .true., '/reference/z: missing')
    call refused(READINGS, .false., '/points/move: attribute value is missing')
  end subroutine refuse_plans

  !> The first message says `what`.
  subroutine refused(path, may_be_plan, what)
    character(*), intent(in) :: path, what
    logical, intent(in) :: may_be_plan
    type(measurement_t) :: m
    type(message_list_t) :: found
    call load_measurement(t%world, path, wing, m, found, may_be_plan)
    call t%check(path//': '//what, found%count() > 0)
    if (found%count() == 0) return
    call t%check('  is said', index(found%text(1), path//': '//what) == 1)
    if (index(found%text(1), what) == 0) call found%print(6, '  found ')
    if (path == PLANNED) call t%check('  of heights once', count_of('/reference/z', found) == 1 .and. &
                                      count_of('observed neither', found) == 0)
  end subroutine refused

  integer function count_of(what, found) result(n)
    character(*), intent(in) :: what
    type(message_list_t), intent(in) :: found
    integer :: i
    n = count([(index(found%text(i), what) > 0, i=1, found%count())])
  end function count_of
end program test_measurement_plan
