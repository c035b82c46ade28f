! SPDX-License-Identifier: GPL-3.0-or-later
!> Records of forces over the beat are read as they were written, on all ranks, and what is wrong with them is reported with
!> the record, all at once.
program test_measurement_flight
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use measurement_broadcast, only: load_measurement
  use measurement_data, only: measurement_t
  use measurement_file, only: read_measurement
  use measurement_flight, only: SAME_AXES
  use measurement_refusals, only: check_refused
  use measurement_writer, only: measurement_writer_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use testkit, only: testkit_t
  use written_again, only: check_written_again
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
  implicit none
  character(*), parameter :: PATH = 'flight.h5', AGAIN = 'flight_again.h5', ONE = '/flight/one'
  integer, parameter :: N = 4, K = 2 !< times, components
  real(rp), parameter :: TIMES(N) = [0.0_rp, 0.2_rp, 0.5_rp, 0.9_rp], &
                         MEANS(K*N) = 1.0e-3_rp*[1.0_rp, 2.0_rp, 0.5_rp, -1.0_rp, 0.2_rp, 0.1_rp, 0.0_rp, 0.3_rp], &
                         ERRORS(K*N) = 1.0e-4_rp*[1.0_rp, 2.0_rp, 1.5_rp, 3.0_rp, 1.2_rp, 2.1_rp, 1.1_rp, 2.3_rp]
  !> Axes that are turned about x by the angle with the cosine 0.8, in numbers that are exact to five digits, and any others.
  real(rp), parameter :: SECTION(9) = [1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 0.8_rp, 0.60001_rp, 0.0_rp, -0.6_rp, 0.8_rp], &
                         ANY_AXES(9) = [0.0_rp, 0.0_rp, 1.0_rp, 0.6_rp, 0.8_rp, 0.0_rp, -0.8_rp, 0.6_rp, 0.0_rp]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(measurement_writer_t) :: w
  type(message_list_t) :: messages

  call t%start(parallel=.true.)
  if (t%world%is_root) then
    call w%sample('flight_wing.h5')
    call w%close()
    call sample()
    call w%reals(ONE//'/mean', [K, N], [MEANS(:K*N - 1), ieee_value(0.0_rp, ieee_quiet_nan)])
    call w%close()
  end if
  call t%world%barrier()
  call read_wing('flight_wing.h5', wing, messages)
  call t%check('the wing is valid', messages%count() == 0)
  call read_it()
  if (t%world%size == 1) call write_again()
  call t%world%barrier()
  if (t%world%size == 1) call refuse_all()
  if (t%world%size == 1) call refuse_axes()
  call t%finish()

contains

  !> A valid measurement with a record of a wing, which has sd, and of a section, which has the spread of beats.
  subroutine sample()
    call w%measurement(PATH)
    call w%delete('/reference')
    call w%delete('/loads')
    call w%delete('/points')
    call w%delete('/accuracy')
    call w%group('/flight')
    call one_record(ONE, 'Fz, power', 'N, W', 'sd')
    call w%real_attribute(ONE, 'correlation_time', [2.0e-3_rp])
    call w%real_attribute(ONE, 'stroke_plane_sd', [1.5_rp])
    call w%real_attribute(ONE, 'pitch_lead_sd', [4.0e-3_rp])
    call one_record('/flight/two', 'Fy,Mx', 'N/m, N', 'spread')
    call w%integer_attribute('/flight/two', 'per_length', 1)
    call w%real_attribute('/flight/two', 'axes', SECTION)
  end subroutine sample

  subroutine one_record(group, components, units, errors_name)
    character(*), intent(in) :: group, components, units, errors_name
    call w%group(group)
    call w%text_attribute(group, 'components', components)
    call w%text_attribute(group, 'units', units)
    call w%text_attribute(group, 'frame', 'lab')
    call w%integer_attribute(group, 'beats', 16)
    call w%real_attribute(group, 'frequency', [25.0_rp])
    call w%real_attribute(group, 'reference', [0.0_rp, 1.0e-3_rp, 0.0_rp])
    call w%reals(group//'/time', [N], TIMES)
    call w%reals(group//'/mean', [K, N], MEANS)
    call w%reals(group//'/'//errors_name, [K, N], ERRORS)
  end subroutine one_record

  subroutine read_it()
    type(measurement_t) :: m
    call load_measurement(t%world, PATH, wing, m, messages)
    call t%check('records of flights are read alone', messages%count() == 0)
    if (messages%count() > 0) call messages%print(6, '  ')
    if (messages%count() > 0) return
    call t%check('they are no plan, and the wing by itself does not move', .not. m%is_plan .and. .not. m%moves())
    call t%check('there are two', m%count_flights() == 2)
    call t%check('a missing value is none', m%count_flight_observations() == 2*N*K - 1)
    associate (first => m%flights(1), second => m%flights(2))
      call t%check('the first is as written', first%name == 'one' .and. first%beats == 16 .and. &
                   .not. first%is_per_length .and. all(first%component == [3, 7]))
      call t%check('so are its numbers', maxval(abs([first%frequency - 25, first%correlation_time - 2.0e-3_rp, &
                                                     first%reference - [0.0_rp, 1.0e-3_rp, 0.0_rp], first%time - TIMES])) <= 0)
      call t%check('so are the errors of its kinematics, and others are not stated', &
                   maxval(abs(first%kinematic_sd([5, 7]) - [4.0e-3_rp, 1.5_rp])) <= 0 .and. &
                   count(abs(first%kinematic_sd) > 0) == 2 .and. all(abs(second%kinematic_sd) <= 0))
      call t%check('so are its values, in time along the first axis', &
                   maxval(abs(reshape(transpose(first%mean), [K*N - 1]) - MEANS(:K*N - 1))) <= 0 .and. &
                   .not. first%is_known(N, K))
      call t%check('sd are as given', maxval(abs(reshape(transpose(first%sd), [K*N - 1]) - ERRORS(:K*N - 1))) <= 0)
      call t%check('or those of the mean of 16 beats', maxval(abs(reshape(transpose(second%sd), [K*N]) - ERRORS/4)) <= 0)
      call t%check('the second is of a section', second%is_per_length .and. all(second%component == [2, 4]))
      call t%check('axes are those of the case where the record has none', maxval(abs(first%axes - SAME_AXES)) <= 0)
      call t%check_below('or as written', maxval(abs(second%axes - transpose(reshape(SECTION, [3, 3])))), 2.0e-5_rp)
      call t%check_below('and exactly orthonormal', maxval(abs(matmul(second%axes, transpose(second%axes)) - SAME_AXES)), &
                         1.0e-15_rp)
    end associate
    call t%check('a component has the name of its record', m%surface_name(3) == 'two:Fy')
  end subroutine read_it

  !> What is read of what was written is the same, all components to the bit.
  subroutine write_again()
    type(measurement_t) :: m
    call read_measurement(PATH, wing, m, messages)
    m%flights(1)%mean = m%flights(1)%mean/3
    call check_written_again(t, AGAIN, wing, m)
  end subroutine write_again

  subroutine refuse_all()
    call sample()
    call w%delete_attribute(ONE, 'frequency')
    call refused(ONE, 'attribute frequency is missing; it must hold a real number [Hz]')
    call sample()
    call w%delete_attribute(ONE, 'beats')
    call refused(ONE, 'attribute beats is missing')
    call sample()
    call w%text_attribute(ONE, 'frame', 'body')
    call refused(ONE, "attribute frame is 'body'; valid: lab")
    call sample()
    call w%text_attribute(ONE, 'components', 'Fz, powr')
    call refused(ONE, "attribute components: unknown component 'powr'; did you mean 'power'?")
    call sample()
    call w%text_attribute(ONE, 'components', 'Fz, Fz')
    call refused(ONE, "attribute components names 'Fz' twice")
    call sample()
    call w%text_attribute(ONE, 'units', 'mN, W')
    call refused(ONE, "attribute units is 'mN, W'; it must be 'N, W'")
    call sample()
    call w%text_attribute('/flight/two', 'units', 'N, N m')
    call refused('/flight/two', "attribute units is 'N, N m'; it must be 'N/m, N'")
    call sample()
    call w%real_attribute(ONE, 'corelation_time', [1.0_rp])
    call refused(ONE, "unknown attribute 'corelation_time'; did you mean 'correlation_time'?")
    call sample()
    call w%real_attribute(ONE, 'pitch_led_sd', [1.0_rp])
    call refused(ONE, "unknown attribute 'pitch_led_sd'; did you mean 'pitch_lead_sd'?")
    call sample()
    call w%real_attribute(ONE, 'pitch_mean_sd', [0.0_rp])
    call refused(ONE, 'attribute pitch_mean_sd is 0.0; valid: above 0.0, at most 20.0 degree')
    call sample()
    call w%reals(ONE//'/time', [N], 1000*TIMES)
    call refused(ONE//'/time', 'fractions of a beat, at least 0 and below 1, are valid')
    call sample()
    call w%reals(ONE//'/time', [N], TIMES(N:1:-1))
    call refused(ONE//'/time', 'is not strictly increasing')
    call sample()
    call w%reals(ONE//'/time', [N - 1], TIMES(:N - 1))
    call refused(ONE//'/time', 'holds 3 times; at least 4 make a record')
    call sample()
    call w%reals(ONE//'/sd', [K, N - 1], ERRORS(:K*(N - 1)))
    call refused(ONE, 'time has 4 numbers, mean 4 rows and sd 3; they must be as many')
    call sample()
    call w%reals(ONE//'/sd', [K, N], [0.0_rp, ERRORS(2:)])
    call refused(ONE//'/sd', 'holds 0.0; standard deviations must be positive')
    call sample()
    call w%reals(ONE//'/mean', [K, N], [ieee_value(0.0_rp, ieee_positive_inf), MEANS(2:)])
    call refused(ONE//'/mean', 'holds an infinite number; only NaN means missing')
    call sample()
    call w%reals(ONE//'/spread', [K, N], ERRORS)
    call refused(ONE, 'must have either sd, of the mean, or spread, of single beats')
    call sample()
    call w%integer_attribute('/flight/two', 'beats', 1)
    call refused('/flight/two/spread', 'needs the attribute beats, at least 2')
    call sample()
    call w%delete('/flight')
    call refused('/loads', 'there is no load, no mode in /modes and no record in /series and /flight')
  end subroutine refuse_all

  subroutine refuse_axes()
    call sample()
    call w%real_attribute(ONE, 'axes', 1.001_rp*ANY_AXES)
    call refused(ONE, 'attribute axes: its rows are no unit vectors at right angles, by 0.002')
    call sample()
    call w%real_attribute(ONE, 'axes', -ANY_AXES)
    call refused(ONE, 'attribute axes is left-handed; valid: a third row that is the cross product of the first two')
    call sample()
    call w%real_attribute(ONE, 'axes', ANY_AXES(:6))
    call refused(ONE, 'attribute axes')
    call sample()
    call w%real_attribute('/flight/two', 'axes', ANY_AXES)
    call refused('/flight/two', 'attribute axes turns about another axis than x, but per_length is 1')
  end subroutine refuse_axes

  subroutine refused(object, what)
    character(*), intent(in) :: object, what
    call w%close()
    call check_refused(t, PATH, wing, object, what)
  end subroutine refused
end program test_measurement_flight
