! SPDX-License-Identifier: GPL-3.0-or-later
!> Natural modes of a measurement file are read as they were written, on all ranks, with or without bending tests, and
!> what is wrong with them is reported with the mode.
program test_measurement_modes
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use measurement_data, only: measurement_t
  use measurement_file, only: read_measurement
  use measurement_modes, only: AIR_DENSITY, MEDIUM_AIR, MEDIUM_VACUUM
  use measurement_broadcast, only: load_measurement
  use measurement_refusals, only: check_refused
  use measurement_writer, only: measurement_writer_t, MM
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use testkit, only: testkit_t
  use whole_measurement, only: write_measurement
  implicit none
  character(*), parameter :: PATH = 'modes.h5', OTHER = 'modes_again.h5'
  real(rp), parameter :: PLACES(6) = MM*[0.5_rp, 0.5_rp, 1.0_rp, 0.2_rp, 1.9_rp, 1.5_rp], SHAPE_OF(3) = [1.0_rp, -2.0_rp, 0.3_rp], &
                         GRAVITY(3) = [0.0_rp, 0.0_rp, -9.81_rp]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(measurement_writer_t) :: w
  type(message_list_t) :: messages

  call t%start(parallel=.true.)
  if (t%world%is_root) then
    call w%sample('modes_wing.h5')
    call w%close()
  end if
  call t%world%barrier()
  call read_wing('modes_wing.h5', wing, messages)
  call t%check('the wing is valid', messages%count() == 0)
  call read_it('with bending tests', 2)
  if (t%world%is_root) then
    call sample()
    call remove_bending()
    call w%close()
  end if
  call t%world%barrier()
  call read_it('alone', 0)
  call t%world%barrier()
  if (t%world%size == 1) call refuse_all()
  call t%finish()

contains

  !> A valid measurement with two modes, one of them under two loads and its weight.
  subroutine sample()
    character(:), allocatable :: load
    integer :: i
    call w%measurement(PATH)
    call w%group('/modes')
    call w%group('/modes/one')
    call w%real_attribute('/modes/one', 'frequency', [150.0_rp])
    call w%real_attribute('/modes/one', 'frequency_sigma', [1.5_rp])
    call w%real_attribute('/modes/one', 'damping', [0.04_rp])
    call w%real_attribute('/modes/one', 'damping_sigma', [0.01_rp])
    call w%text_attribute('/modes/one', 'medium', 'air')
    call w%reals('/modes/one/points', [2, 3], PLACES)
    call w%reals('/modes/one/shape', [3], SHAPE_OF)
    call w%reals('/modes/one/sigma', [3], 0.1_rp + 0*SHAPE_OF)
    call w%group('/modes/two')
    call w%real_attribute('/modes/two', 'frequency', [420.0_rp])
    call w%real_attribute('/modes/two', 'frequency_sigma', [2.0_rp])
    call w%text_attribute('/modes/two', 'medium', 'vacuum')
    call w%integer_attribute('/modes/two', 'number', 3)
    call w%real_attribute('/modes/two', 'gravity', GRAVITY)
    call w%group('/modes/two/loads')
    do i = 1, 2
      load = '/modes/two/loads/'//achar(96 + i)
      call w%group(load)
      call w%real_attribute(load, 'force', [i*1.0e-5_rp])
      call w%real_attribute(load, 'direction', [0.0_rp, 0.0_rp, -2.0_rp])
      call w%real_attribute(load, 'point', PLACES(2*i - 1:2*i))
    end do
  end subroutine sample

  subroutine remove_bending()
    call w%delete('/reference')
    call w%delete('/loads')
    call w%delete('/points')
    call w%delete('/accuracy')
  end subroutine remove_bending

  subroutine read_it(what, n_loads)
    character(*), intent(in) :: what
    integer, intent(in) :: n_loads
    type(measurement_t) :: m
    type(failure_t) :: failure
    integer :: i
    if (n_loads > 0 .and. t%world%is_root) then
      call sample()
      call w%close()
    end if
    call t%world%barrier()
    call load_measurement(t%world, PATH, wing, m, messages)
    do i = 1, 2
      call t%check('modes are read '//what, messages%count() == 0)
      if (messages%count() > 0) call messages%print(6, '  ')
      call t%check('loads are what there is', size(m%loads) == n_loads .and. .not. m%is_plan)
      call t%check('there are two modes', m%count_modes() == 2)
      associate (one => m%modes(1), two => m%modes(2))
        call t%check('the first is as written', one%name == 'one' .and. one%medium == MEDIUM_AIR .and. one%number == 0)
        call t%check('so are its numbers', maxval(abs([one%frequency - 150, one%frequency_sigma - 1.5_rp, &
                                                       one%damping - 0.04_rp, one%damping_sigma - 0.01_rp])) <= 0)
        call t%check('so is its shape', maxval(abs(one%shape - SHAPE_OF)) + maxval(abs(one%sigma - 0.1_rp)) + &
                     maxval(abs([one%place] - PLACES)) <= 0)
        call t%check('the second has a number and no shape', two%number == 3 .and. size(two%shape) == 0 .and. &
                     two%medium == MEDIUM_VACUUM .and. two%damping < 0)
        call t%check('only the second is about a loaded shape', two%is_loaded() .and. .not. one%is_loaded())
        call t%check('its loads are as written', &
                     maxval(abs(two%load_size - [1.0e-5_rp, 2.0e-5_rp])) + maxval(abs(two%gravity - GRAVITY)) + &
                     maxval(abs(two%load_direction - spread([0.0_rp, 0.0_rp, -1.0_rp], 2, 2))) + &
                     maxval(abs([two%load_place] - PLACES(:4))) <= 0)
      end associate
      call t%check('the density of the air is the usual one', abs(m%air_density - AIR_DENSITY) <= 0)
      call t%world%barrier()
      if (t%world%is_root .and. i == 1) call write_measurement(OTHER, m, failure)
      call t%world%barrier()
      if (i == 1) call load_measurement(t%world, OTHER, wing, m, messages)
    end do
  end subroutine read_it

  subroutine refuse_all()
    call sample()
    call w%delete_attribute('/modes/one', 'frequency')
    call refused('/modes/one', 'attribute frequency is missing; it must hold a real number [Hz]')
    call sample()
    call w%real_attribute('/modes/one', 'frequency', [-3.0_rp])
    call refused('/modes/one', 'attribute frequency is -3.0; valid: above 0.0')
    call sample()
    call w%real_attribute('/modes/one', 'frequency_sigma', [151.0_rp])
    call refused('/modes/one', 'Hz, more than the frequency')
    call sample()
    call w%real_attribute('/modes/one', 'damping', [4.0_rp])
    call refused('/modes/one', 'attribute damping is 4.0; valid: at least 0.0, at most 1.0')
    call sample()
    call w%delete_attribute('/modes/one', 'damping_sigma')
    call refused('/modes/one', 'attribute damping_sigma is missing')
    call sample()
    call w%text_attribute('/modes/one', 'medium', 'water')
    call refused('/modes/one', "attribute medium is 'water'; valid: air, vacuum")
    call sample()
    call w%real_attribute('/modes/one', 'frequncy', [1.0_rp])
    call refused('/modes/one', "unknown attribute 'frequncy'; did you mean 'frequency'?")
    call sample()
    call w%delete_attribute('/modes/two', 'number')
    call refused('/modes/two', 'cannot be identified: give it a shape (points, shape, sigma) or the attribute number')
    call sample()
    call w%delete('/modes/one/sigma')
    call refused('/modes/one/sigma', 'missing; it must hold a list of real numbers')
    call sample()
    call w%reals('/modes/one/sigma', [2], [1.0_rp, 1.0_rp])
    call refused('/modes/one', 'points has 3 rows, shape 3 and sigma 2 numbers; they must be as many')
    call sample()
    call w%reals('/modes/one/sigma', [3], [0.1_rp, 0.0_rp, 0.1_rp])
    call refused('/modes/one/sigma', 'holds 0.0; standard deviations must be positive')
    call sample()
    call w%reals('/modes/one/shape', [3], 0*SHAPE_OF)
    call refused('/modes/one/shape', 'is 0 everywhere')
    call sample()
    call w%reals('/modes/one/points', [2, 3], 1000*PLACES)
    call refused('/modes/one/points', 'is not on the wing')
    call sample()
    call w%delete_attribute('/modes/two/loads/a', 'force')
    call refused('/modes/two/loads/a', 'attribute force is missing; it must hold a real number [N]')
    call sample()
    call w%real_attribute('/modes/two/loads/b', 'force', [0.0_rp])
    call w%real_attribute('/modes/two/loads/a', 'direction', [0.0_rp, 0.0_rp, 0.0_rp])
    call w%real_attribute('/modes/two/loads/a', 'point', 1000*PLACES(:2))
    call refused('/modes/two/loads/b', 'attribute force is 0.0; valid: above 0.0') ! all mistakes at once
    call check_refused(t, PATH, wing, '/modes/two/loads/a', 'attribute direction must be a vector of a length')
    call check_refused(t, PATH, wing, '/modes/two/loads', 'attribute point of load 1')
    call sample()
    call w%real_attribute('/modes/two/loads/a', 'forse', [1.0_rp])
    call refused('/modes/two/loads/a', "unknown attribute 'forse'; did you mean 'force'?")
    call sample()
    call w%delete('/modes/two/loads/a')
    call w%delete('/modes/two/loads/b')
    call refused('/modes/two/loads', 'holds no load; remove it for a mode of the unloaded wing')
    call sample()
    call w%real_attribute('/modes/two', 'gravity', [0.0_rp, 0.0_rp, 2.0e3_rp])
    call refused('/modes/two', 'attribute gravity holds 2000')
    call sample()
    call w%delete('/modes/two/loads')
    call w%delete_attribute('/modes/two', 'gravity')
    call w%text_attribute('/modes/one', 'medium', 'vacuum')
    call w%integer_attribute('/modes/one', 'number', 3)
    call refused('/modes/two', 'attribute number is 3, as in one; modes in the same medium need different numbers')
    call sample()
    call w%real_attribute('/modes', 'air_density', [0.0_rp])
    call refused('/modes', 'attribute air_density is 0.0; valid: above 0.0')
    call sample()
    call remove_bending()
    call w%delete('/modes')
    call refused('/loads', 'there is no load, no mode in /modes and no record in /series')
  end subroutine refuse_all

  subroutine refused(object, what)
    character(*), intent(in) :: object, what
    call w%close()
    call check_refused(t, PATH, wing, object, what)
  end subroutine refused
end program test_measurement_modes
