! SPDX-License-Identifier: GPL-3.0-or-later
!> Units of keys, and the same run described in SI units and without units.
program test_units
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use io_broadcast_text, only: read_text_file
  use io_units, only: unit_scales_t, unit_value
  use simulation_settings, only: load_settings, settings_t
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10)
  !> L = 9 mm, f = 158/s, air.
  real(rp), parameter :: L = 9.0e-3_rp, T = 1/158.0_rp, RHO = 1.225_rp
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call test_values()
  call test_same_run()
  call test_missing()
  call test_printed()
  call kit%finish()

contains

  subroutine test_values()
    call expect('L', 2.0_rp)
    call expect('T', 3.0_rp)
    call expect('M', 5.0_rp)
    call expect('L/T', 2.0_rp/3)
    call expect('L^2/T', 4.0_rp/3)
    call expect('1/T', 1.0_rp/3)
    call expect('L/T^2', 2.0_rp/9)
    call expect('M L^2', 20.0_rp)
    call expect('M/T^2', 5.0_rp/9)
    call expect('M L/T^2', 10.0_rp/9)
    call expect('M L^2/T^3', 20.0_rp/27)
    call expect('', 1.0_rp)
    call expect('degree', 1.0_rp)
    call expect('points', 1.0_rp)
    call expect('m/s', 1.0_rp)
    call expect('h', 1.0_rp)
    call expect('length', 1.0_rp)
    call kit%check('in its own system every unit is 1', all([unit_value('L', unit_scales_t()), &
                                                             unit_value('M L^2/T^3', unit_scales_t())] >= 1) .and. &
                   unit_value('L^3/T', unit_scales_t()) <= 1)
  end subroutine test_values

  subroutine expect(unit, value)
    character(*), intent(in) :: unit
    real(rp), intent(in) :: value
    type(unit_scales_t), parameter :: S = unit_scales_t(2.0_rp, 3.0_rp, 5.0_rp)
    call kit%check_close('['//unit//']', unit_value(unit, S), value, rtol=4*epsilon(1.0_rp))
  end subroutine expect

  !> Every key that has a unit, in a file of numbers in L, T and M and in one in m, s and kg.
  subroutine test_same_run()
    type(settings_t) :: one, two
    type(message_list_t) :: errors, notices
    real(rp), parameter :: M = RHO*L**3
    logical :: wings(2)
    call load_settings(text('dimensionless', 1.0_rp, 1.0_rp, 1.0_rp), 'one.ini', .false., one, errors, notices)
    call load_settings(text('SI', L, T, M), 'two.ini', .false., two, errors, notices)
    call kit%check('both files are right', errors%count() == 0)
    call kit%check('and say what they are', two%units%si_input .and. .not. one%units%si_input .and. &
                   two%units%given .and. one%units%given)
    call same('grid', [one%fluid%grid%length, one%fluid%grid%spacing], [two%fluid%grid%length, two%fluid%grid%spacing])
    call same('time', [one%fluid%time%t_max, one%fluid%time%dt_max, one%fluid%time%cfl], &
              [two%fluid%time%t_max, two%fluid%time%dt_max, two%fluid%time%cfl])
    call same('viscosity, penalization, sponge', [one%fluid%nu, one%fluid%solids%c_eta, one%fluid%sponge%damping_time], &
              [two%fluid%nu, two%fluid%solids%c_eta, two%fluid%sponge%damping_time])
    call same('mean flow', one%fluid%mean%velocity, two%fluid%mean%velocity)
    call same('place of the body', one%fluid%solids%centre, two%fluid%solids%centre)
    call same('thickness and smoothing', [one%flight%half_thickness, one%flight%smoothing], &
              [two%flight%half_thickness, two%flight%smoothing])
    call same('output', [one%output%fields%interval, one%output%t_integral, one%output%limits%stop_seconds], &
              [two%output%fields%interval, two%output%t_integral, two%output%limits%stop_seconds])
    wings = [allocated(one%flight%wings), allocated(two%flight%wings)]
    call kit%check('both have wings', all(wings))
    if (.not. all(wings)) return
    associate (a => one%flight%wings(2), b => two%flight%wings(2))
      call same('hinge and stroke plane', [a%mount%hinge, a%mount%eta], [b%mount%hinge, b%mount%eta])
      call same('frequency and ramp', [a%motion%frequency, a%motion%ramp], [b%motion%frequency, b%motion%ramp])
      call same('inertia', [a%inertia], [b%inertia])
      call kit%check('as many triangles', size(a%triangles, 2) == size(b%triangles, 2))
      call same('points of the wing', [a%points], [b%points])
    end associate
  end subroutine test_same_run

  subroutine same(what, a, b)
    character(*), intent(in) :: what
    real(rp), intent(in) :: a(:), b(:)
    call kit%check('the same '//what, size(a) == size(b) .and. any(abs(a) > 0))
    if (size(a) == size(b)) call kit%check_below('to round-off', maxval(abs(a - b)), 1.0e-14_rp*maxval(abs(a)))
  end subroutine same

  !> The run in units of which one L is `l`, one T `t` and one M `m`; writes the planform that it names.
  function text(input, l, t, m)
    character(*), intent(in) :: input
    real(rp), intent(in) :: l, t, m
    character(:), allocatable :: text
    integer :: unit
    open (newunit=unit, file='planform_'//input//'.ini', status='replace')
    write (unit, '(a)') '[Wing]', 'type = rectangular', 'front = 0.25', 'root = '//number(0.1_rp*l), &
      'length = '//number(0.8_rp*l), 'mean_chord = '//number(0.3_rp*l)
    close (unit)
    text = '[units]'//NL//'input='//input//NL//'length=9.0e-3'//NL//'frequency=158'//NL//'density=1.225'//NL// &
           '[Resolution]'//NL//'nx=32'//NL//'ny=32'//NL//'nz=16'//NL// &
           '[Geometry]'//NL//'xl='//number(4*l)//NL//'yl='//number(4*l)//NL//'zl='//number(2*l)//NL// &
           '[Time]'//NL//'Tmax='//number(1.5_rp*t)//NL//'dt_max='//number(0.01_rp*t)//NL//'CFL=0.4'//NL// &
           '[ReynoldsNumber]'//NL//'nu='//number(1.2e-3_rp*l**2/t)//NL// &
           '[InitialCondition]'//NL//'inicond=MeanFlow'//NL// &
           '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=Insect'//NL//'eps='//number(0.012_rp*t)//NL// &
           '[Insects]'//NL//'WingShape=from_file::planform_'//input//'.ini'//NL//'wing_edge='//number(0.05_rp*l)//NL// &
           'WingThickness='//number(0.6_rp*l)//NL//'wing_frequency='//number(1.25_rp/t)//NL//'wing_ramp='// &
           number(0.5_rp*t)//NL//'Jxx='//number(0.003_rp*m*l**2)//NL//'Jxy='//number(0.001_rp*m*l**2)//NL// &
       'x0='//number(2*l)//' '//number(2.1_rp*l)//' '//number(l)//NL//'x_pivot_l=0.0 '//number(0.5_rp*l)//' 0.0'//NL// &
           'x_pivot_r=0.0 '//number(-0.5_rp*l)//' 0.0'//NL//'eta0=-70'//NL// &
           '[Flexible_wing]'//NL//'wing_smoothing=1.5*dx'//NL// &
     '[MeanFlow]'//NL//'iMeanFlow=1'//NL//'ux='//number(0.95_rp*l/t)//NL//'uy=0'//NL//'uz='//number(-0.1_rp*l/t)//NL// &
        '[Sponge]'//NL//'iVorticitySponge=yes'//NL//'iSpongeType=outlet_x'//NL//'eps_sponge='//number(0.05_rp*t)//NL// &
           'sponge_thickness=8'//NL// &
           '[Saving]'//NL//'tsave='//number(0.25_rp*t)//NL//'tintegral='//number(0.01_rp*t)//NL//'wtimemax=2'//NL
  end function text

  function number(x)
    real(rp), intent(in) :: x
    character(:), allocatable :: number
    character(25) :: buffer
    write (buffer, '(es25.17)') x
    number = trim(adjustl(buffer))
  end function number

  !> SI numbers mean nothing without all units.
  subroutine test_missing()
    type(settings_t) :: settings
    type(message_list_t) :: errors, notices
    character(:), allocatable :: whole
    whole = text('SI', L, T, RHO*L**3)
    call load_settings('[units]'//NL//'input=SI'//NL//'length=9.0e-3'//NL//whole(index(whole, '[Resolution]'):), 'two.ini', &
                       .false., settings, errors, notices)
    call kit%check('input = SI needs every unit: both missing ones are reported', errors%count() == 2)
    call expect_missing('dimensionless', 'length=9.0e-3', '[units] length')
    call expect_missing('dimensionless', 'density=1.225', '[units] density')
    call expect_missing('SI', 'nu='//number(1.2e-3_rp*L**2/T), '[ReynoldsNumber] nu')
    call expect_missing('SI', 'eps='//number(0.012_rp*T), '[Penalization] eps')
    call expect_missing('SI', 'uy=0', '[MeanFlow] uy')
    call expect_missing('SI', 'xl='//number(4*L), '[Geometry] xl')
    call load_settings(whole//'[InitialCondition]'//NL//'omega1=3'//NL, 'two.ini', .false., settings, errors, notices)
    call kit%check('omega1 has no unit', has(errors, '[InitialCondition] omega1: cannot be given'))
  end subroutine test_missing

  !> Without `line` there is one message, about `key`.
  subroutine expect_missing(input, line, key)
    character(*), intent(in) :: input, line, key
    type(settings_t) :: settings
    type(message_list_t) :: errors, notices
    character(:), allocatable :: whole
    integer :: i
    if (input == 'SI') then
      whole = text(input, L, T, RHO*L**3)
    else
      whole = text(input, 1.0_rp, 1.0_rp, 1.0_rp)
    end if
    i = index(whole, NL//line//NL)
    call kit%check('the file has '//line, i > 0)
    call load_settings(whole(:i)//whole(i + len(line) + 2:), 'one.ini', .false., settings, errors, notices)
    call kit%check(input//': '//key//' is missed', errors%count() == 1 .and. has(errors, key//': is missing'))
  end subroutine expect_missing

  logical function has(errors, words)
    type(message_list_t), intent(in) :: errors
    character(*), intent(in) :: words
    integer :: i
    has = any([(index(errors%text(i), words) > 0, i=1, errors%count())])
  end function has

  !> What is printed of a file in SI units describes the same run: also where the file leaves defaults.
  subroutine test_printed()
    type(settings_t) :: one, two
    type(message_list_t) :: errors, notices
    character(:), allocatable :: printed, problem
    integer :: unit
    call load_settings(text('SI', L, T, RHO*L**3), 'one.ini', .false., one, errors, notices)
    open (newunit=unit, file='printed.ini', status='replace')
    call one%config%print_effective(unit)
    close (unit)
    call read_text_file('printed.ini', printed, problem)
    call load_settings(printed, 'printed.ini', .false., two, errors, notices)
    call errors%print(0, 'but: ')
    call kit%check('it is an input file', errors%count() == 0)
    call same('numbers of the fluid', &
              [one%fluid%grid%length, one%fluid%time%t_max, one%fluid%nu, one%fluid%solids%c_eta, one%fluid%mean%velocity], &
              [two%fluid%grid%length, two%fluid%time%t_max, two%fluid%nu, two%fluid%solids%c_eta, two%fluid%mean%velocity])
    call same('walls and the couette body', &
              [one%fluid%walls%thickness, one%fluid%walls%position, one%fluid%solids%r1, one%fluid%solids%r2], &
              [two%fluid%walls%thickness, two%fluid%walls%position, two%fluid%solids%r1, two%fluid%solids%r2])
    call same('frequency of the couette body', [one%fluid%solids%omega], [two%fluid%solids%omega])
    call same('mass of fluid', [one%fluid%mean%mass], [two%fluid%mean%mass])
    call same('times of output', &
              [one%output%fields%interval, one%output%t_integral, one%output%slices%interval, &
               one%output%fields%period, one%output%limits%stop_seconds], &
              [two%output%fields%interval, two%output%t_integral, two%output%slices%interval, &
               two%output%fields%period, two%output%limits%stop_seconds])
    call same('wings', [one%flight%wings(1)%points], [two%flight%wings(1)%points])
    call kit%check('the remark tells the units', index(printed, 'T in SI units, default') > 0)
  end subroutine test_printed
end program test_units
