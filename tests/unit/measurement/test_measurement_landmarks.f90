! SPDX-License-Identifier: GPL-3.0-or-later
!> Landmarks on flapping wings are read as they were written, on all ranks, from the origin of the case; and what is wrong with them
!> is reported with the group.
program test_measurement_landmarks
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use measurement_broadcast, only: load_measurement
  use measurement_data, only: measurement_t
  use measurement_file, only: read_measurement
  use measurement_flight, only: N_COMPONENTS, SAME_AXES
  use measurement_refusals, only: check_refused
  use measurement_writer, only: measurement_writer_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use testkit, only: testkit_t
  use written_again, only: check_written_again
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  implicit none
  character(*), parameter :: PATH = 'landmarks.h5', AGAIN = 'landmarks_again.h5', ONE = '/flight/one', BOTH = '/flight/both', &
                             MARKS = '/landmarks', LEFT = '/landmarks/left', RIGHT = '/landmarks/right'
  integer, parameter :: N = 4, M = 2 !< times, points
  real(rp), parameter :: TIMES(N) = [0.0_rp, 0.2_rp, 0.5_rp, 0.9_rp], POINTS(2*M) = 1.0e-3_rp*[8.0_rp, -0.5_rp, 4.0_rp, 0.2_rp], &
                         ORIGIN(3) = [1.0e-2_rp, 2.0e-2_rp, 3.0e-2_rp]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(measurement_writer_t) :: w
  type(message_list_t) :: messages

  call t%start(parallel=.true.)
  if (t%world%is_root) then
    call w%sample('landmarks_wing.h5')
    call w%close()
    call sample()
    call w%close()
  end if
  call t%world%barrier()
  call read_wing('landmarks_wing.h5', wing, messages)
  call t%check('the wing is valid', messages%count() == 0)
  call read_it()
  if (t%world%size == 1) call write_again()
  call t%world%barrier()
  if (t%world%size == 1) call refuse_all()
  call t%finish()

contains

  !> Two flights: one with a force and with landmarks on both wings, and one with landmarks on the right wing alone.
  subroutine sample()
    call w%measurement(PATH)
    call w%delete('/reference')
    call w%delete('/loads')
    call w%delete('/points')
    call w%delete('/accuracy')
    call w%group('/flight')
    call facts(BOTH)
    call w%text_attribute(BOTH, 'components', 'Fz')
    call w%text_attribute(BOTH, 'units', 'N')
    call w%real_attribute(BOTH, 'reference', [0.0_rp, 1.0e-3_rp, 0.0_rp])
    call w%reals(BOTH//'/time', [N], TIMES)
    call w%reals(BOTH//'/mean', [1, N], TIMES)
    call w%reals(BOTH//'/sd', [1, N], TIMES + 1)
    call cameras(BOTH)
    call w%real_attribute(BOTH//MARKS, 'correlation_time', [2.0e-3_rp])
    call w%real_attribute(BOTH//MARKS, 'offset_sd', [1.0e-4_rp])
    call w%real_attribute(BOTH//MARKS, 'axes', [0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 1.0_rp, 0.0_rp, 0.0_rp])
    call one_wing(BOTH//LEFT)
    call one_wing(BOTH//RIGHT)
    call facts(ONE)
    call cameras(ONE)
    call w%integer_attribute(ONE//MARKS, 'beats', 9)
    call one_wing(ONE//RIGHT)
  end subroutine sample

  subroutine facts(group)
    character(*), intent(in) :: group
    call w%group(group)
    call w%text_attribute(group, 'frame', 'lab')
    call w%integer_attribute(group, 'beats', 16)
    call w%real_attribute(group, 'frequency', [25.0_rp])
  end subroutine facts

  subroutine cameras(group)
    character(*), intent(in) :: group
    call w%group(group//MARKS)
    call w%real_attribute(group//MARKS, 'origin', ORIGIN)
  end subroutine cameras

  !> The second point is never seen along x, and once not at all.
  subroutine one_wing(group)
    character(*), intent(in) :: group
    real(rp) :: mean(3*M, N)
    call w%group(group)
    call w%reals(group//'/time', [N], TIMES)
    call w%reals(group//'/points', [2, M], POINTS)
    call w%text_attribute(group//'/points', 'units', 'm')
    mean = values()
    mean(4, :) = ieee_value(0.0_rp, ieee_quiet_nan)
    mean(4:, 3) = ieee_value(0.0_rp, ieee_quiet_nan)
    call w%reals(group//'/mean', [3*M, N], [mean])
    call w%reals(group//'/spread', [3*M, N], spread(1.0e-4_rp, 1, 3*M*N))
  end subroutine one_wing

  pure function values()
    real(rp) :: values(3*M, N)
    integer :: i, j
    values = reshape([((1.0e-3_rp*(i + 10*j), i=1, 3*M), j=1, N)], [3*M, N])
  end function values

  subroutine read_it()
    type(measurement_t) :: d
    real(rp) :: seen(3*M, N)
    call load_measurement(t%world, PATH, wing, d, messages)
    call t%check('landmarks are read', messages%count() == 0)
    if (messages%count() > 0) call messages%print(6, '  ')
    if (messages%count() > 0) return
    seen = values()
    call t%check('one record of forces, and behind it three of landmarks', d%count_flights() == 4 .and. &
                 d%count_flights(has_landmarks=.true.) == 3 .and. d%flights(1)%side == 0 .and. all(d%flights(2:)%side == [1, 2, 2]))
    call t%check('what was not seen is no number', d%count_flight_observations(has_landmarks=.true.) == 3*(5*N - 2) .and. &
                 d%count_flight_observations(has_landmarks=.false.) == N)
    associate (left_wing => d%flights(2), right_wing => d%flights(3), alone => d%flights(4))
      call t%check('a record has the name of its flight', left_wing%name == 'both' .and. alone%name == 'one')
      call t%check('landmarks are numbered through', all([left_wing%first, right_wing%first, alone%first] == [0, M, 2*M]))
      call t%check('a coordinate that was never seen is left out', all(left_wing%component == N_COMPONENTS + [1, 2, 3, 5, 6]))
      call t%check('so it is on the other wing', all(right_wing%component == N_COMPONENTS + 3*M + [1, 2, 3, 5, 6]))
      call t%check('points are as written', maxval(abs(reshape(alone%points, [2*M]) - POINTS)) <= 0)
      call t%check('places are from the origin of the case, along the axes of the cameras: their y is its z', &
                   maxval(abs(left_wing%mean(:, 4) - ORIGIN(3) - seen(5, :)), left_wing%is_known(:, 4)) < 1.0e-15_rp)
      call t%check('cameras that state no axes have those of the case', &
                   maxval(abs(alone%mean(:, 4) - ORIGIN(2) - seen(5, :)), alone%is_known(:, 4)) < 1.0e-15_rp .and. &
                   maxval(abs(alone%axes - SAME_AXES)) <= 0)
      call t%check('a balance that states none, too', maxval(abs(d%flights(1)%axes - SAME_AXES)) <= 0)
      call t%check('the spread becomes the sd of the mean of all beats', abs(left_wing%sd(1, 1) - 1.0e-4_rp/4) < 1.0e-12_rp)
      call t%check('or of those of the cameras', abs(alone%sd(1, 1) - 1.0e-4_rp/3) < 1.0e-12_rp)
      call t%check('errors of the axes are as stated', abs(right_wing%offset_sd - 1.0e-4_rp) <= 0 .and. &
                   abs(right_wing%turn_sd) <= 0 .and. abs(right_wing%correlation_time - 2.0e-3_rp) <= 0)
      call t%check('a column knows its landmark', all(left_wing%landmark_of(4) == [2, 2]))
    end associate
    call t%check('a column has the name of its flight, wing, landmark and axis', d%surface_name(1) == 'both:Fz' .and. &
                 d%surface_name(5) == 'both:left:2:y' .and. d%surface_name(12) == 'one:right:1:x')
  end subroutine read_it

  !> What is read of what was written is the same, all components to the bit.
  subroutine write_again()
    type(measurement_t) :: d
    call read_measurement(PATH, wing, d, messages)
    call check_written_again(t, AGAIN, wing, d)
  end subroutine write_again

  subroutine refuse_all()
    call sample()
    call w%delete_attribute(ONE//MARKS, 'origin')
    call refused(ONE//MARKS, 'attribute origin is missing; it must hold 3 real numbers [m]')
    call sample()
    call w%real_attribute(ONE//MARKS, 'turn_sd', [40.0_rp])
    call refused(ONE//MARKS, 'attribute turn_sd is 40.0; valid: above 0.0, at most 20.0 degree')
    call sample()
    call w%real_attribute(ONE//MARKS, 'ofset_sd', [40.0_rp])
    call refused(ONE//MARKS, "unknown attribute 'ofset_sd'; did you mean 'offset_sd'?")
    call sample()
    call w%group(ONE//MARKS//'/lefft')
    call refused(ONE//MARKS, "unknown object 'lefft'; did you mean 'left'?")
    call sample()
    call w%real_attribute(ONE, 'axes', [0.0_rp, 0.0_rp, 1.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp])
    call refused(ONE, 'attribute axes is of forces, and the record has none; valid: axes of the group landmarks')
    call sample()
    call w%delete(ONE//RIGHT)
    call refused(ONE//MARKS, 'holds no landmarks; it must hold the group left or right, or both')
    call sample()
    call w%delete(ONE//RIGHT//'/points')
    call refused(ONE//RIGHT//'/points', 'missing; it must hold rows of 2 real numbers')
    call sample()
    call w%reals(ONE//RIGHT//'/points', [2, M], 1.0e6_rp*POINTS)
    call w%text_attribute(ONE//RIGHT//'/points', 'units', 'm')
    call refused(ONE//RIGHT//'/points', 'holds 8000.0 m; at most 10.0 m are valid')
    call sample()
    call w%reals(ONE//RIGHT//'/mean', [3, N], [values()])
    call refused(ONE//RIGHT//'/mean', 'must hold rows of 6 real numbers, but its shape is (4, 3)')
    call sample()
    call w%reals(ONE//RIGHT//'/mean', [3*M, N], spread(ieee_value(0.0_rp, ieee_quiet_nan), 1, 3*M*N))
    call refused(ONE//RIGHT//'/mean', 'holds no number; leave the record out')
    call sample()
    call w%reals(ONE//RIGHT//'/time', [N], 10*TIMES)
    call refused(ONE//RIGHT//'/time', 'fractions of a beat, at least 0 and below 1, are valid')
    call sample()
    call w%delete(ONE//RIGHT//'/spread')
    call refused(ONE//RIGHT, 'must have either sd, of the mean, or spread, of single beats')
    call sample()
    call w%delete(ONE//MARKS)
    call refused(ONE, 'attribute components is missing')
    call sample()
    call w%delete(BOTH//'/sd')
    call refused(BOTH, 'must have either sd, of the mean, or spread, of single beats')
  end subroutine refuse_all

  subroutine refused(object, what)
    character(*), intent(in) :: object, what
    call w%close()
    call check_refused(t, PATH, wing, object, what)
  end subroutine refused
end program test_measurement_landmarks
