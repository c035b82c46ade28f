! SPDX-License-Identifier: GPL-3.0-or-later
!> Declares the ini keys of `flusi --solid`. All units are SI; [units] states the units of [Insects].
module simulation_solid_keys
  use base_constants, only: PI
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use common_foreign_inputs, only: register_foreign_inputs, INPUT_OF_SOLID
  use common_instrument, only: register_idle_instrument
  use common_solver_keys, only: backup_keys, limit_keys
  use common_wing_keys, only: register_damping_keys, register_wing_keys, PLACE_HELP
  use fsi_kinematics_keys, only: register_kinematics_keys, SIDES
  use io_include, only: register_include
  use io_keys, only: declaring, keys_t
  use io_registry, only: registry_t
  use io_stop, only: job_limits_t
  use simulation_units, only: scale_keys
  use solid_dynamics, only: dynamic_options_t
  implicit none
  private
  public :: solid_choices_t, motion_keys, load_keys, solid_keys, register_solid_keys, write_solid_reference, LAWS, LAW_CONSTANT, &
            LAW_RAMP, LAW_SINE, FRAMES, ROTATION_NAMES

  !> The laws by which forces depend on time. Each law has a key of [Loads] with a list of forces. A new law also needs its factor
  !> in flusi_solid_loads.
  integer, parameter :: LAW_CONSTANT = 1, LAW_RAMP = 2, LAW_SINE = 3
  type(named_kind_t), parameter :: LAWS(3) = [named_kind_t('constant', LAW_CONSTANT), named_kind_t('ramped', LAW_RAMP), &
                                              named_kind_t('sinusoidal', LAW_SINE)]
  character(*), parameter :: LAW_HELP(3) = [character(72) :: 'forces that act from the beginning', &
                                            'forces that grow smoothly from 0 over the time `ramp` and then stay', &
                                            'forces times sin(2 pi frequency t + phase)']

  integer, parameter, public :: FRAME_REST = 1, FRAME_ROTATION = 2, FRAME_FLAPPING = 3 !< motions of the wing frame
  type(named_kind_t), parameter :: FRAMES(3) = [named_kind_t('rest', FRAME_REST), named_kind_t('rotation', FRAME_ROTATION), &
                                                named_kind_t('flapping', FRAME_FLAPPING)]

  character(9), parameter :: ROTATION_NAMES(4) = [character(9) :: 'axis', 'through', 'frequency', 'ramp']

  integer, parameter :: WING_LEFT = 1, WING_RIGHT = 2 !< numbers of the wings in SIDES
  type(named_kind_t), parameter :: WINGS(2) = [named_kind_t(SIDES(WING_LEFT), WING_LEFT), &
                                               named_kind_t(SIDES(WING_RIGHT), WING_RIGHT)]

  !> Holds forces as the user gives them.
  type :: force_list_t
    character(:), allocatable :: text
  end type force_list_t

  real(rp), parameter :: ZERO(3) = 0.0_rp

  !> Holds the keys of [Motion] on a rotation about a fixed axis.
  type :: rotation_choices_t
    real(rp) :: axis(3) = 0, through(3) = 0         !< [-] and [m]
    real(rp) :: frequency = 0, ramp = 0             !< [1/s] and [s]
    logical :: given(size(ROTATION_NAMES)) = .false. !< whether the file gives each of ROTATION_NAMES
  end type rotation_choices_t

  !> Holds what a user chooses apart from the wing and the kinematics of [Insects].
  type :: solid_choices_t
    integer :: motion_type = FRAME_REST
    integer :: wing = WING_LEFT                     !< its number in SIDES
    type(rotation_choices_t) :: rotation
    real(rp) :: unit_length = 1, unit_frequency = 1 !< of [Insects], [m] and [1/s]
    type(force_list_t) :: forces(size(LAWS))        !< of each law
    character(:), allocatable :: released_forces    !< list of forces that bend the wing before time 0
    real(rp) :: gravity(3) = 0                      !< [m/s^2]
    real(rp) :: load_ramp = 1, load_frequency = 0, load_phase = 0 !< [s], [1/s], [rad]
    integer :: mode = 0                             !< natural mode in which the wing starts
    real(rp) :: amplitude = 0                       !< [m]
    real(rp) :: dt = 0, t_max = 0                   !< [s]
    type(dynamic_options_t) :: options
    character(:), allocatable :: name               !< of the files to write
    integer :: series_every = 1
    real(rp) :: t_save = 0                          !< [s]
    logical :: backup = .true.
    type(job_limits_t) :: limits
    real(rp) :: progress_seconds = 30
  end type solid_choices_t

contains

  !> Fills `registry` with every key that `flusi --solid` accepts.
  subroutine register_solid_keys(registry)
    type(registry_t), intent(inout), target :: registry
    type(solid_choices_t) :: unused
    type(keys_t) :: keys
    call register_include(registry)
    call register_foreign_inputs(registry, INPUT_OF_SOLID)
    call register_wing_keys(registry, required=.true.)
    call register_idle_instrument(registry)
    call register_damping_keys(registry)
    keys = declaring(registry)
    call motion_keys(keys, unused)
    call registry%add_section('Insects', 'kinematics of the flapping wing, with the keys of a flow')
    call register_kinematics_keys(registry)
    call load_keys(keys, unused)
    call solid_keys(keys, unused)
  end subroutine register_solid_keys

  !> Writes the reference of these keys, the third part of docs/formats/parameters.md, to `unit`.
  subroutine write_solid_reference(unit)
    integer, intent(in) :: unit
    type(registry_t) :: registry
    call register_solid_keys(registry)
    write (unit, '(a)') '# Parameters of `flusi --solid`', '', &
      'The motion of a wing in time, without a fluid. All numbers are in SI units but those of [Insects].', ''
    call registry%write_markdown(unit)
  end subroutine write_solid_reference

  !> Declares and reads the keys on the motion of the frame and on the units of [Insects].
  subroutine motion_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(solid_choices_t), intent(inout) :: c
    call keys%section('Motion', 'motion of the wing frame, in which the root is at rest')
    call keys%kind('type', c%motion_type, 'rest', FRAMES, 'rotation about a fixed axis, or the wing beat of '// &
                   '[Insects]; the wing starts at rest in the frame')
    call keys%in_checkpoint()
    call rotation_keys(keys, c%rotation)
    call keys%kind('wing', c%wing, 'left', WINGS, 'which wing of [Insects] flaps; loads and results refer to the axes '// &
                   'of the wing file, even if this wing is the mirror image of the wing in the file')
    call keys%in_checkpoint()
    call keys%section('units', 'SI values of the units L and T of [Insects]')
    call scale_keys(keys, c%unit_length, c%unit_frequency)
  end subroutine motion_keys

  !> Declares and reads ROTATION_NAMES of [Motion], which must be the present section of `keys`.
  subroutine rotation_keys(keys, r)
    type(keys_t), intent(in) :: keys
    type(rotation_choices_t), intent(inout) :: r
    call keys%reals(trim(ROTATION_NAMES(1)), r%axis, [0.0_rp, 0.0_rp, 1.0_rp], 'axis of the rotation, a vector of any length', &
                    given=r%given(1))
    call keys%reals(trim(ROTATION_NAMES(2)), r%through, ZERO, 'a point of the axis, in the wing frame', unit='m', given=r%given(2))
    call keys%real(trim(ROTATION_NAMES(3)), r%frequency, 0.0_rp, 'frequency of the rotation; a positive one turns right-handed '// &
                   'about the axis', unit='1/s', given=r%given(3))
    call keys%real(trim(ROTATION_NAMES(4)), r%ramp, 0.0_rp, 'duration over which the rotation grows from rest to its full '// &
                   'speed; 0: full speed at once', unit='s', min=0.0_rp, given=r%given(4))
  end subroutine rotation_keys

  !> Declares and reads the keys on forces and on their dependence on time.
  subroutine load_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(solid_choices_t), intent(inout) :: c
    integer :: i
    call keys%section('Loads', 'forces of fixed direction in the wing frame: PLACE fx fy fz [N], separated by commas. '//PLACE_HELP)
    do i = 1, size(LAWS)
      call keys%text(trim(LAWS(i)%word), c%forces(i)%text, '', trim(LAW_HELP(i)))
    end do
    call keys%real('ramp', c%load_ramp, 1.0e-3_rp, 'duration of the ramp', unit='s', above=0.0_rp)
    call keys%real('frequency', c%load_frequency, 100.0_rp, 'of the sinusoidal forces', unit='1/s', above=0.0_rp)
    call keys%real('phase', c%load_phase, 0.0_rp, 'of the sinusoidal forces', unit='degree', scale=PI/180)
    call keys%reals('gravity', c%gravity, ZERO, 'acceleration of gravity, in the axes of the wing frame at time 0, or with '// &
                    'type = flapping in the axes in which [Insects] states the attitude', unit='m/s^2')
  end subroutine load_keys

  !> Declares and reads all other keys of `flusi --solid`.
  subroutine solid_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(solid_choices_t), intent(inout) :: c
    call keys%section('Initial', 'the wing at time 0: unloaded, bent and then released, or in a natural mode')
    call keys%text('released', c%released_forces, '', 'forces as in [Loads]: the wing starts at rest in the static '// &
                   'equilibrium under these forces (without gravity), and they end at time 0')
    call keys%integer('mode', c%mode, 0, 'start at rest, bent like this natural mode; 0: none', min=0, max=100)
    call keys%real('amplitude', c%amplitude, 1.0e-7_rp, 'largest displacement of the mode; keep it small, because large ones '// &
                   'stretch the springs', &
                   unit='m', above=0.0_rp)
    call keys%section('Time', 'time steps of equal size; a step that does not converge is halved')
    call keys%real('dt', c%dt, 0.0_rp, 'time step', unit='s', above=0.0_rp, required=.true.)
    call keys%real('t_max', c%t_max, 0.0_rp, 'end of the run', unit='s', above=0.0_rp, required=.true.)
    call keys%real('tolerance', c%options%tolerance, 1.0e-8_rp, 'tolerance of the residual, relative to the largest force in '// &
                   'the balance', &
                   min=1.0e-13_rp, max=1.0e-3_rp)
    call keys%integer('iterations', c%options%iterations, 10, 'largest number of Newton iterations in a step, before it is '// &
                      'halved', min=1, max=100)
    call keys%integer('halvings', c%options%halvings, 8, 'largest number of halvings of a step, before the run fails', min=0, &
                      max=20)
    call keys%section('Saving', 'what is written, and when to stop')
    call keys%text('name', c%name, 'solid', 'first part of the names of all output files; it may contain a folder')
    call keys%real('t_save', c%t_save, 9.0e9_rp, 'interval of shapes; the first and the last are always saved', unit='s', &
                   above=0.0_rp)
    call keys%integer('series_every', c%series_every, 1, 'steps between two records of the time series', min=1)
    call backup_keys(keys, c%backup, c%limits)
    call limit_keys(keys, c%limits, c%progress_seconds)
  end subroutine solid_keys
end module simulation_solid_keys
