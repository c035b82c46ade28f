! SPDX-License-Identifier: GPL-3.0-or-later
!> Records of a wing that rings are read as they were written, on all ranks, and what is wrong with them is reported with the
!> record, all at once. What is written again, bending tests, modes and records, is read to the bit.
program test_measurement_series
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use measurement_broadcast, only: load_measurement
  use measurement_data, only: measurement_t
  use measurement_file, only: read_measurement
  use measurement_modes, only: MEDIUM_AIR, MEDIUM_VACUUM
  use measurement_refusals, only: check_refused
  use measurement_writer, only: measurement_writer_t, MM
  use solid_ringing, only: EXCITED_BASE, EXCITED_RELEASE
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use testkit, only: testkit_t
  use written_again, only: check_written_again
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
  implicit none
  character(*), parameter :: PATH = 'series.h5', AGAIN = 'series_again.h5'
  integer, parameter :: N = 4, P = 2 !< samples, points
  real(rp), parameter :: PLACES(2*P) = MM*[0.5_rp, 0.5_rp, 1.9_rp, 1.5_rp], VALUES(P*N) = 1.0e-6_rp* &
                         [1.0_rp, 2.0_rp, 0.5_rp, -1.0_rp, 0.2_rp, 0.1_rp, 0.0_rp, 0.3_rp]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(measurement_writer_t) :: w
  type(message_list_t) :: messages

  call t%start(parallel=.true.)
  if (t%world%is_root) then
    call w%sample('series_wing.h5')
    call w%close()
    call sample()
    call w%reals('/series/one/values', [P, N], [VALUES(:P*N - 1), ieee_value(0.0_rp, ieee_quiet_nan)])
    call w%close()
  end if
  call t%world%barrier()
  call read_wing('series_wing.h5', wing, messages)
  call t%check('the wing is valid', messages%count() == 0)
  call read_it()
  call t%world%barrier()
  if (t%world%size == 1) call write_again()
  if (t%world%size == 1) call refuse_all()
  call t%finish()

contains

  !> A valid measurement with a release and a moving base.
  subroutine sample()
    call w%measurement(PATH)
    call w%delete('/reference')
    call w%delete('/loads')
    call w%delete('/points')
    call w%delete('/accuracy')
    call add_records()
  end subroutine sample

  subroutine add_records()
    call w%group('/series')
    call one_record('/series/one', 'release', 'm')
    call w%real_attribute('/series/one', 'point', [1.0_rp, 1.0_rp]*MM)
    call w%real_attribute('/series/one', 'size', [2.0e-5_rp])
    call w%real_attribute('/series/one', 'size_sigma', [1.0e-6_rp])
    call w%real_attribute('/series/one', 'start', [1.0e-3_rp])
    call w%real_attribute('/series/one', 'trigger_sigma', [1.0e-5_rp])
    call w%real_attribute('/series/one', 'lowpass', [900.0_rp])
    call w%integer_attribute('/series/one', 'order', 2)
    call one_record('/series/two', 'base', 'm/s')
    call w%reals('/series/two/base', [N], 9.0_rp*[1.0_rp, -1.0_rp, 0.5_rp, 0.0_rp])
  end subroutine add_records

  !> Every kind of data: what is read of what was written is the same, all components to the bit.
  subroutine write_again()
    type(measurement_t) :: m
    call w%measurement(PATH)
    call add_records()
    call w%real_attribute('/series', 'air_density', [1.1_rp])
    call w%reals('/series/one/values', [P, N], [ieee_value(0.0_rp, ieee_quiet_nan), VALUES(2:)/3])
    call one_record('/series/three', 'tap', 'm/s')
    call w%real_attribute('/series/three', 'point', [1.0_rp, 1.0_rp]*MM/3)
    call w%real_attribute('/series/three', 'size', [1.0e-7_rp/3])
    call w%real_attribute('/series/three', 'size_sigma', [1.0e-8_rp/3])
    call w%group('/modes')
    call w%real_attribute('/modes', 'air_density', [1.3_rp])
    call w%group('/modes/one')
    call w%real_attribute('/modes/one', 'frequency', [150.0_rp/7])
    call w%real_attribute('/modes/one', 'frequency_sigma', [1.5_rp/7])
    call w%real_attribute('/modes/one', 'damping', [0.1_rp/3])
    call w%real_attribute('/modes/one', 'damping_sigma', [0.01_rp/3])
    call w%text_attribute('/modes/one', 'medium', 'air')
    call w%reals('/modes/one/points', [2, P], PLACES/3)
    call w%reals('/modes/one/shape', [P], VALUES(:P)/3)
    call w%reals('/modes/one/sigma', [P], VALUES(:P)/30)
    call w%close()
    call read_measurement(PATH, wing, m, messages)
    call t%check('all kinds of data are read together', messages%count() == 0 .and. size(m%loads) == 2 .and. &
                 size(m%observations) == 2 .and. m%count_modes() == 1 .and. m%count_series() == 3)
    call check_written_again(t, AGAIN, wing, m)
  end subroutine write_again

  subroutine one_record(group, excitation, units)
    character(*), intent(in) :: group, excitation, units
    call w%group(group)
    call w%text_attribute(group, 'excitation', excitation)
    call w%text_attribute(group, 'medium', merge('air   ', 'vacuum', units == 'm'))
    call w%text_attribute(group, 'units', units)
    call w%real_attribute(group, 'direction', [0.0_rp, 0.0_rp, -2.0_rp])
    call w%real_attribute(group, 'axis', [0.0_rp, 0.0_rp, 1.0_rp])
    call w%real_attribute(group, 'rate', [4000.0_rp])
    call w%reals(group//'/points', [2, P], PLACES)
    call w%reals(group//'/values', [P, N], VALUES)
    call w%reals(group//'/sigma', [P], [1.0e-8_rp, 2.0e-8_rp])
  end subroutine one_record

  subroutine read_it()
    type(measurement_t) :: m
    call load_measurement(t%world, PATH, wing, m, messages)
    call t%check('records are read alone', messages%count() == 0)
    if (messages%count() > 0) call messages%print(6, '  ')
    if (messages%count() > 0) return
    call t%check('they are no plan', .not. m%is_plan .and. m%moves() .and. m%is_in_air())
    call t%check('there are two with two traces each', m%count_series() == 2 .and. &
                 size(m%series(1)%sigma) == 2 .and. size(m%series(2)%sigma) == 2)
    call t%check('a missing value is none', m%count_series_observations() == 2*N*P - 1)
    associate (one => m%series(1), two => m%series(2))
      call t%check('the first is as written', one%name == 'one' .and. one%medium == MEDIUM_AIR .and. &
                   one%excitation == EXCITED_RELEASE .and. .not. one%is_velocity .and. one%order == 2)
      call t%check('so are its numbers', maxval(abs([one%size - 2.0e-5_rp, one%size_sigma - 1.0e-6_rp, one%start - 1.0e-3_rp, &
                                                     one%trigger_sigma - 1.0e-5_rp, one%lowpass - 900, one%rate - 4000, &
                                                     one%point - MM, one%direction - [0, 0, -1]])) <= 0)
      call t%check('so are its values, in time along the first axis', &
                   maxval(abs(reshape(transpose(one%values), [P*N - 1]) - VALUES(:P*N - 1))) <= 0 .and. &
                   .not. one%is_known(N, P) .and. maxval(abs(reshape(one%place, [2*P]) - PLACES)) <= 0)
      call t%check('the second is a velocity on a moving base', two%is_velocity .and. two%excitation == EXCITED_BASE .and. &
                   two%medium == MEDIUM_VACUUM .and. size(two%base) == N .and. abs(two%base(2) + 9) <= 0)
    end associate
    call t%check('a trace has the name of its record', m%surface_name(3) == 'two:1')
  end subroutine read_it

  subroutine refuse_all()
    call sample()
    call w%delete_attribute('/series/one', 'rate')
    call refused('/series/one', 'attribute rate is missing; it must hold a real number [Hz]')
    call sample()
    call w%text_attribute('/series/one', 'excitation', 'push')
    call refused('/series/one', "attribute excitation is 'push'; valid: release, tap, base")
    call sample()
    call w%text_attribute('/series/one', 'units', 'mm')
    call refused('/series/one', "attribute units is 'mm'; valid: m (displacement), m/s (velocity)")
    call sample()
    call w%text_attribute('/series/one', 'medium', 'water')
    call refused('/series/one', "attribute medium is 'water'; valid: air, vacuum")
    call sample()
    call w%real_attribute('/series/one', 'lowpas', [1.0_rp])
    call refused('/series/one', "unknown attribute 'lowpas'; did you mean 'lowpass'?")
    call sample()
    call w%integer_attribute('/series/one', 'order', 3)
    call refused('/series/one', 'attribute order is 3; valid: 1 to 2')
    call sample()
    call w%reals('/series/one/sigma', [1], [1.0e-8_rp])
    call refused('/series/one', 'points has 2 rows and sigma 1 numbers; they must be as many')
    call sample()
    call w%reals('/series/one/sigma', [P], [1.0e-8_rp, 0.0_rp])
    call refused('/series/one/sigma', 'holds 0.0; standard deviations must be positive')
    call sample()
    call w%reals('/series/one/values', [P, N], [ieee_value(0.0_rp, ieee_positive_inf), VALUES(2:)])
    call refused('/series/one/values', 'holds an infinite number; only NaN means missing')
    call sample()
    call w%reals('/series/one/points', [2, P], 1000*PLACES)
    call refused('/series/one/points', 'is not on the wing')
    call sample()
    call w%real_attribute('/series/one', 'point', [1.0_rp, 1.0_rp])
    call refused('/series/one', 'attribute point: (1.0, 1.0) m is not on the wing')
    call sample()
    call w%reals('/series/one/base', [N], VALUES(:N))
    call refused('/series/one/base', 'is only valid where excitation is base')
    call sample()
    call w%reals('/series/two/base', [N - 1], VALUES(:N - 1))
    call refused('/series/two', 'values has 4 rows and base 3 numbers; they must be as many')
    call sample()
    call w%real_attribute('/series/two', 'start', [1.0_rp])
    call refused('/series/two', 'attribute start must be 0 with excitation base')
    call sample()
    call w%delete('/series')
    call refused('/loads', 'there is no load, no mode in /modes and no record in /series')
    call sample()
    call w%delete_attribute('/series/two', 'rate')
    call w%real_attribute('/series/one', 'size', [0.0_rp])
    call refused('/series/one', 'attribute size is 0.0; valid: above 0.0')
    call refused('/series/two', 'attribute rate is missing')
  end subroutine refuse_all

  subroutine refused(object, what)
    character(*), intent(in) :: object, what
    call w%close()
    call check_refused(t, PATH, wing, object, what)
  end subroutine refused
end program test_measurement_series
