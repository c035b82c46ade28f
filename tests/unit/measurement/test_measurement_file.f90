! SPDX-License-Identifier: GPL-3.0-or-later
!> A measurement file is read as it was written, on all ranks, and everything that is wrong with one is reported with
!> the load, the observation or the dataset.
program test_measurement_file
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use measurement_data, only: measurement_t
  use measurement_file, only: read_measurement
  use measurement_broadcast, only: load_measurement
  use measurement_writer, only: measurement_writer_t, loaded_heights, unloaded_heights, MM, NX, NY, X, Y
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use testkit, only: testkit_t
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf
  use whole_measurement, only: write_measurement
  implicit none
  character(*), parameter :: PATH = 'measurement.h5', OTHER = 'again.h5'
  type(testkit_t) :: t
  type(wing_t) :: wing, beam
  type(measurement_writer_t) :: w
  type(message_list_t) :: messages
  real(rp) :: z(NX*NY), loaded(NX*NY), nan

  call t%start(parallel=.true.)
  nan = ieee_value(nan, ieee_quiet_nan)
  z = unloaded_heights()
  loaded = loaded_heights()
  if (t%world%is_root) then
    call w%sample('wing.h5')
    call w%close()
    call w%beam('beam.h5')
    call w%close()
    call sample()
    call w%close()
  end if
  call t%world%barrier()
  call read_wing('wing.h5', wing, messages)
  call read_wing('beam.h5', beam, messages)
  call t%check('the wings are valid', messages%count() == 0)
  call read_it()
  call t%world%barrier()
  if (t%world%size == 1) then
    call refuse_headers()
    call refuse_datasets()
    call refuse_attributes()
    call refuse_what_does_not_fit()
    call refuse_observations()
    call report_all()
  end if
  call t%finish()

contains

  !> A valid measurement of the sample wing, which is a plate of 2 mm by 2 mm.
  subroutine sample()
    call w%measurement(PATH)
  end subroutine sample

  !> What was written is what is read, also after it has been written again.
  subroutine read_it()
    type(measurement_t) :: m
    type(failure_t) :: failure
    integer :: i
    call load_measurement(t%world, PATH, wing, m, messages)
    do i = 1, 2
      call t%check('the measurement is valid', messages%count() == 0)
      if (messages%count() > 0) call messages%print(6, '  ')
      call t%check('loads are in alphabetical order', m%loads(1)%name == 'base' .and. m%loads(2)%name == 'tip')
      call t%check('heights are where loaded and unloaded ones are known', m%loads(2)%count() == NX*NY - 2 &
                   .and. all(m%loads(2)%node(:, 2) == [4, 1]) .and. m%loads(1)%count() == 0)
      call t%check('heights are exact',.not. any(abs(m%loads(2)%height - pack(loaded, known())) > 0))
      call t%check_close('deformation is the difference', m%deformation(2, 3), 1.0e-4_rp, rtol=1.0e-14_rp)
      call t%check_close('its sd is that of both', m%deformation_sigma(2, 3), sqrt(2.0_rp)*3.0e-6_rp, rtol=1.0e-14_rp)
      call t%check('places are those of the grid',.not. any(abs(m%site(2, 3) - [X(1), Y(2)]) > 0))
      call t%check('the force is read', norm2(m%loads(2)%direction - [0, 0, 1]) <= 0 .and. &
                   abs(m%loads(2)%force - 1.0e-3_rp) <= 0)
      call t%check('facts are read', m%loads(2)%order == 2 .and. m%loads(2)%replicate == 3 .and. &
                   m%loads(1)%replicate == 1 .and. abs(m%loads(2)%hold - 5) <= 0 .and. &
                   abs(m%accuracy%force_gain - 0.02_rp) <= 0 .and. &
                   m%calibration%order_is_random == 1 .and. m%calibration%force_by_weight == -1)
      call t%check('observations are read', m%observations(1)%name == 'move' .and. m%observations(2)%load == 1 .and. &
                   m%observations(2)%zero == 1 .and. abs(m%observations(1)%axis(2) - 1) <= 0 .and. size(m%zeros) == 1)
      if (i == 2) exit
      if (t%world%is_root) call write_measurement(OTHER, m, failure)
      call t%check('it can be written',.not. failure%failed)
      call t%world%barrier()
      call load_measurement(t%world, OTHER, wing, m, messages)
    end do
  end subroutine read_it

  pure function known() result(has)
    logical :: has(NX*NY)
    has = .true.
    has(2:3) = .false.
  end function known

  !> Closes the file and reads it: exactly one message, which names the object and says `what`.
  subroutine refused(object, what, structure)
    character(*), intent(in) :: object, what
    type(wing_t), intent(in), optional :: structure
    type(measurement_t) :: m
    type(message_list_t) :: found
    logical :: is_named
    call w%close()
    if (present(structure)) then
      call read_measurement(PATH, structure, m, found)
    else
      call read_measurement(PATH, wing, m, found)
    end if
    call t%check(object//': '//what, found%count() == 1)
    if (found%count() /= 1) call found%print(6, '  found ')
    if (found%count() == 0) return
    is_named = index(found%text(1), PATH//': '//object) == 1 .and. index(found%text(1), what) > 0
    call t%check('  is named', is_named)
    if (.not. is_named) call found%print(6, '  found ')
  end subroutine refused

  subroutine refuse_headers()
    type(message_list_t) :: found
    type(measurement_t) :: m
    call read_measurement('nowhere.h5', wing, m, found)
    call t%check('a missing file is reported', index(found%text(1), 'nowhere.h5: does not exist') == 1)
    call sample()
    call w%text_attribute('/', 'schema', 'flusi-msm wing')
    call refused('attribute schema', "is 'flusi-msm wing', expected 'flusi-msm measurement'")
    call sample()
    call w%integer_attribute('/', 'version', 2)
    call refused('attribute version', 'is 2; this program reads version 1')
    call sample()
    call w%group('/load')
    call refused('/', "unknown object 'load'; did you mean 'loads'?")
    call sample()
    call w%delete('/accuracy')
    call refused('/accuracy', 'missing')
    call sample()
    call w%real_attribute('/accuracy', 'heigth', [1.0_rp])
    call refused('/accuracy', "unknown attribute 'heigth'; did you mean 'height'?")
    call sample()
    call w%real_attribute('/accuracy', 'height', [0.0_rp])
    call refused('/accuracy', 'attribute height is 0.0; valid: above 0.0')
    call sample()
    call w%integer_attribute('/calibration', 'force_by_weight', 2)
    call refused('/calibration', 'valid: 0 to 1')
  end subroutine refuse_headers

  subroutine refuse_datasets()
    integer :: i
    call sample()
    call w%reals('/reference/x', [NX], X([2, 1, 3, 4]))
    call refused('/reference/x', 'is not sorted')
    call sample()
    call w%reals('/reference/y', [NY], [Y(1), nan, Y(3)])
    call w%delete('/loads/tip')
    call w%delete('/reference/z')
    call w%close()
    call mentions('grid line 2 is infinite or undefined')
    call sample()
    call w%reals('/reference/x', [NX], X, units='mm')
    call refused('/reference/x', "attribute units is 'mm'; it must be 'm'")
    call sample()
    call w%reals('/reference/x', [4000], [(1.0e-6_rp*i, i=1, 4000)])
    call w%reals('/reference/y', [4000], [(1.0e-6_rp*i, i=1, 4000)])
    call refused('/reference', 'the grid has more than 10000000 points')
    call sample()
    call w%reals('/loads/tip/z', [NX - 1, NY], loaded(:(NX - 1)*NY))
    call refused('/loads/tip/z', 'must hold rows of 4 real numbers, but its shape is (3, 3)')
    call sample()
    call w%reals('/loads/tip/z', [NX, NY - 1], loaded(:NX*(NY - 1)))
    call refused('/loads/tip/z', 'has 2 rows; /reference/y has 3 values')
    call sample()
    call w%integers('/loads/tip/z', [NX, NY], [(i, i=1, NX*NY)])
    call refused('/loads/tip/z', 'must hold rows of 4 real numbers')
    call sample()
    loaded(5) = ieee_value(nan, ieee_positive_inf)
    call w%reals('/loads/tip/z', [NX, NY], loaded)
    call refused('/loads/tip/z', 'the height at [1, 0] is infinite')
    loaded(5) = 1.1e-4_rp
    call sample()
    call w%reals('/loads/tip/z', [NX, NY], spread(nan, 1, NX*NY))
    call refused('/loads/tip/z', 'all heights are missing')
    call sample()
    call w%reals('/loads/tip/z', [NX, NY], merge(1.0e-4_rp, spread(nan, 1, NX*NY),.not. known()))
    call w%reals('/reference/z', [NX, NY], merge(0.0_rp, spread(nan, 1, NX*NY), known()))
    call refused('/loads/tip/z', 'has no height where the unloaded height is known')
    call sample()
    call w%reals('/loads/tip/sigma', [NX, NY], spread(0.0_rp, 1, NX*NY))
    call refused('/loads/tip/sigma', '10 standard deviations of known heights are missing or not positive')
    call sample()
    call w%delete('/reference')
    call refused('/loads/tip/z', 'needs the unloaded heights in /reference')
  end subroutine refuse_datasets

  subroutine refuse_attributes()
    call sample()
    call w%delete_attribute('/loads/tip', 'force')
    call refused('/loads/tip', 'attribute force is missing; it must hold a real number [N]')
    call sample()
    call w%real_attribute('/loads/tip', 'force', [-1.0_rp])
    call refused('/loads/tip', 'attribute force is -1.0; valid: above 0.0')
    call sample()
    call w%real_attribute('/loads/tip', 'direction', [0.0_rp, 0.0_rp, 0.0_rp])
    call refused('/loads/tip', 'attribute direction must be a vector')
    call sample()
    call w%real_attribute('/loads/tip', 'point', [nan, 1.0e-3_rp])
    call w%close()
    call mentions('/loads/tip: attribute point is infinite or undefined')
    call sample()
    call w%integer_attribute('/loads/base', 'order', 2)
    call refused('/loads/tip', 'attribute order is 2, as in base; every load needs its own order')
    call sample()
    call w%real_attribute('/loads/tip', 'holdtime', [1.0_rp])
    call refused('/loads/tip', "unknown attribute 'holdtime'")
  end subroutine refuse_attributes

  subroutine refuse_what_does_not_fit()
    call sample()
    call w%real_attribute('/loads/tip', 'point', [2.5_rp*MM, 1.0_rp*MM])
    call refused('/loads/tip', 'm is not on the wing; its nearest point is')
    call sample()
    call w%reals('/reference/x', [NX], X + 3*MM)
    call refused('/loads/tip/z', 'none of the 10 known heights is on the wing')
    call sample()
    call w%reals('/reference/x', [NX], X*1000)
    call refused('/reference/x, /reference/y', 'are the grid lines in metres?')
    call sample()
    call w%reals('/reference/z', [NX, NY], z*1000)
    call w%reals('/loads/tip/z', [NX, NY], loaded*1000)
    call refused('/loads/tip/z', 'are the heights in metres?')
    call sample()
    call w%real_attribute('/loads/tip', 'force', [1.0_rp])
    call refused('/loads/tip', 'are the force in newtons and the heights in metres?')
    call sample()
    call w%real_attribute('/loads/tip', 'force', [1.0e-6_rp])
    call refused('/loads/tip', 'are the force in newtons and the heights in metres?')
    call sample()
    call w%delete('/points')
    call refused('/loads/base', 'has no observation: add heights z, or an object in /points')
  end subroutine refuse_what_does_not_fit

  subroutine refuse_observations()
    call sample()
    call w%text_attribute('/points/turn', 'load', 'bas')
    call refused('/points/turn', "there is no load 'bas'; did you mean 'base'?")
    call sample()
    call w%text_attribute('/points/turn', 'quantity', 'angle')
    call w%text_attribute('/points/turn', 'units', 'm')
    call refused('/points/turn', "attribute quantity is 'angle'; valid: displacement, rotation")
    call sample()
    call w%text_attribute('/points/turn', 'units', 'm')
    call refused('/points/turn', "attribute units is 'm'; valid: m for displacements, rad for rotations")
    call sample()
    call w%real_attribute('/points/move', 'point', [0.0_rp, 3.0_rp*MM])
    call refused('/points/move', 'is not on the wing')
    call sample()
    call w%delete('/loads')
    call w%group('/loads')
    call w%delete('/points')
    call refused('/loads', 'there is no load')
    ! A beam whose points are at 0, 1, 2, 3 m.
    call sample()
    call w%delete('/reference')
    call w%delete('/loads/tip')
    call w%real_attribute('/loads/base', 'point', [1.0_rp, 0.0_rp])
    call w%real_attribute('/points/move', 'point', [3.02_rp, 0.0_rp])
    call w%real_attribute('/points/turn', 'point', [2.5_rp, 0.0_rp])
    call refused('/points/turn', 'm away, more than 0.01 of the length', beam)
    call sample()
    call w%delete('/points')
    call w%delete('/loads/base')
    call w%real_attribute('/loads/tip', 'point', [1.0_rp, 0.0_rp])
    call refused('/reference', 'heights can only be compared with a wing that has triangles', beam)
  end subroutine refuse_observations

  !> Mistakes of different kinds and loads come in one report.
  subroutine report_all()
    call sample()
    call w%real_attribute('/loads/tip', 'force', [-1.0_rp])
    call w%real_attribute('/loads/base', 'point', [0.0_rp, 3.0_rp*MM])
    call w%delete_attribute('/points/move', 'sigma')
    call w%group('/load')
    call w%close()
    call mentions('/loads/tip: attribute force')
    call mentions('/loads/base: attribute point')
    call mentions('/points/move: attribute sigma')
    call mentions("unknown object 'load'")
  end subroutine report_all

  subroutine mentions(what)
    character(*), intent(in) :: what
    type(measurement_t) :: m
    type(message_list_t) :: found
    integer :: i
    logical :: is_there
    call read_measurement(PATH, wing, m, found)
    is_there = .false.
    do i = 1, found%count()
      is_there = is_there .or. index(found%text(i), what) > 0
    end do
    call t%check('reported: '//what, is_there)
    if (.not. is_there) call found%print(6, '  found ')
  end subroutine mentions
end program test_measurement_file
