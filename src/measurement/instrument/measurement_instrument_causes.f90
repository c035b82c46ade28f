! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes what a measurement of bending can get wrong: the causes and their parameters. At its null value a parameter has no
!> effect. measurement_instrument holds the values, measurement_forces and measurement_map have the laws.
!>
!> docs/theory/effects.md has the law of each parameter. With `nonlinearity` 0 deflections are proportional to forces, as in the
!> theory of small deflections. They are computed as the response to a hundredth of the force, which differs from the limit by 1e-4
!> of the nonlinear part.
module measurement_instrument_causes
  use base_cause, only: cause_t, enlist, make_cause
  use base_kinds, only: rp
  use base_parameter, only: define_parameter, effect_parameter, parameter_t
  use base_wording, only: word_degrees, word_factor, word_fraction, word_plain, SCALE_FACTOR, SCALE_LINEAR
  use solid_effect, only: NEED_LEVELS, NEED_MEMBRANE, N_WING_NEEDS
  implicit none
  private
  public :: instrument_scales_t, list_instrument_causes

  !> Numbers of the parameters, in the order in which programs list them.
  integer, parameter, public :: FORCE_GAIN = 1, FORCE_OFFSET = 2, FORCE_TILT_X = 3, FORCE_TILT_Y = 4, &
                                LOAD_SHIFT_X = 5, LOAD_SHIFT_Y = 6, DRIFT = 7, DRIFT_RATE = 8, DRIFT_VEINS = 9, &
                                CREEP = 10, CREEP_TIME = 11, HEIGHT_SCALE = 12, TILT_X = 13, TILT_Y = 14, PISTON = 15, &
                                MAP_SHIFT_X = 16, MAP_SHIFT_Y = 17, MAP_ROTATION = 18, MAP_SCALE = 19, GRAVITY_X = 20, &
                                GRAVITY_Y = 21, GRAVITY_Z = 22, NONLINEARITY = 23
  integer, parameter, public :: N_INSTRUMENT = 23
  !> The values without effect (for creep_time the usual value), in the same order.
  real(rp), parameter, public :: INSTRUMENT_DEFAULTS(N_INSTRUMENT) = &
                                 [real(rp) :: 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1]

  !> Requirements on the measurement beside those of solid_effect. Module measurement_instrument checks the first four, what the
  !> file has to contain.
  integer, parameter, public :: NEED_ORDER = N_WING_NEEDS + 1, NEED_TIME = N_WING_NEEDS + 2, NEED_HOLD = N_WING_NEEDS + 3, &
                                NEED_HEIGHTS = N_WING_NEEDS + 4, NEED_TWO_HOLDS = N_WING_NEEDS + 5, &
                                NEED_MASS = N_WING_NEEDS + 6, NEED_SMALL_DEFLECTIONS = N_WING_NEEDS + 7, &
                                N_BENDING_NEEDS = N_WING_NEEDS + 7

  !> Holds quantities of an experiment. Bounds and priors are multiples of them. An sd of 0 means that the file declares none.
  type :: instrument_scales_t
    real(rp) :: length = 1            !< [m] of the wing
    real(rp) :: smallest_force = 1    !< [N] of all loads
    real(rp) :: last_order = 2, last_time = 1 !< [1], [s]
    real(rp) :: gain_sd = 0, position_sd = 0, tilt_sd = 0, piston_sd = 0 !< of the errors, as declared
  end type instrument_scales_t

  character(*), parameter :: OF_FORCE = 'the smallest force', OF_LENGTH = 'the length of the wing', &
                             OF_ORDER = '1/(largest order - 1)', OF_TIME = '1/(time of the last load)', OF_ONE = ''

contains

  !> Returns all causes, in the order in which the catalogue has them.
  pure function list_instrument_causes(scales) result(list)
    type(instrument_scales_t), intent(in) :: scales
    type(cause_t), allocatable :: list(:)
    call enlist(list, gain_of_force(scales))
    call enlist(list, offset_of_force(scales))
    call enlist(list, direction_of_force())
    call enlist(list, position_of_load(scales))
    call enlist(list, scale_of_heights())
    call enlist(list, plane_of_scans(scales))
    call enlist(list, registration_of_maps(scales))
    call enlist(list, drift_by_order(scales))
    call enlist(list, drift_by_time(scales))
    call enlist(list, creep_under_load())
    call enlist(list, weight_of_wing())
    call enlist(list, large_deflections())
  end function list_instrument_causes

  !> Returns an error of a bending test that needs the data of `needs`, so far without parameters.
  pure function measured(name, title, sentence, data, needs) result(cause)
    character(*), intent(in) :: name, title, sentence, data
    integer, intent(in) :: needs(:)
    type(cause_t) :: cause
    cause = make_cause(name, title, sentence, data)
    cause%is_measurement = .true.
    cause%needs = needs
  end function measured

  !> Adds a parameter, whose null is in INSTRUMENT_DEFAULTS.
  pure subroutine add(cause, number, p, scale)
    type(cause_t), intent(inout) :: cause
    integer, intent(in) :: number
    type(parameter_t), intent(in) :: p
    character(*), intent(in) :: scale
    type(parameter_t) :: own
    own = p
    own%null = INSTRUMENT_DEFAULTS(number)
    call cause%add(number, own, scale)
  end subroutine add

  !> Returns a declared sd, or a default if none is declared.
  pure real(rp) function declared_or_default(sd, default_value)
    real(rp), intent(in) :: sd, default_value
    declared_or_default = default_value
    if (sd > 0) declared_or_default = sd
  end function declared_or_default

  !> Returns the wrong gain of the force sensor.
  pure function gain_of_force(scales) result(c)
    type(instrument_scales_t), intent(in) :: scales
    type(cause_t) :: c
    c = measured('force_gain', 'wrong gain of the force sensor', 'All forces were larger or smaller than '// &
                 'declared, by one factor.', 'bending tests', [integer ::])
    call add(c, FORCE_GAIN, effect_parameter('force_gain', '1', .true., &
                                             0.1_rp, 10.0_rp, declared_or_default(scales%gain_sd, 0.1_rp)), OF_ONE)
    call word_factor(c%parameters(1)%words, SCALE_FACTOR, 'All forces were', 'All forces were', 'larger', 'smaller', &
                     'than declared', 'what is declared', 1.0_rp)
  end function gain_of_force

  !> Returns the zero error of the force sensor.
  pure function offset_of_force(scales) result(c)
    type(instrument_scales_t), intent(in) :: scales
    type(cause_t) :: c
    real(rp) :: most
    most = 0.9_rp*scales%smallest_force
    c = measured('force_offset', 'zero error of the force sensor', 'The same force was added to every declared force.', &
                 'two forces at one place', [NEED_LEVELS])
    call add(c, FORCE_OFFSET, effect_parameter('force_offset', 'N', .false., -most, most, most/3), OF_FORCE)
    call word_plain(c%parameters(1)%words, 'N', 'Every force was', 'Every force was', 'larger', 'smaller', 'than declared', 0.0_rp)
  end function offset_of_force

  !> Returns the tilt of all forces.
  pure function direction_of_force() result(c)
    type(cause_t) :: c
    character(*), parameter :: UPRIGHT = 'Forces were not upright but turned:'
    c = measured('force_direction', 'forces that were not upright', 'All forces leaned to one side.', 'bending tests', [integer ::])
    call add(c, FORCE_TILT_X, effect_parameter('force_tilt_x', 'rad', .false., -0.5_rp, 0.5_rp, 0.05_rp), OF_ONE)
    call add(c, FORCE_TILT_Y, effect_parameter('force_tilt_y', 'rad', .false., -0.5_rp, 0.5_rp, 0.05_rp), OF_ONE)
    call word_degrees(c%parameters(1)%words, UPRIGHT, 'about x, those that point up toward -y', &
                      'about x, those that point up toward +y')
    call word_degrees(c%parameters(2)%words, UPRIGHT, 'about y, those that point up toward +x', &
                      'about y, those that point up toward -x')
  end function direction_of_force

  !> Returns the shift of all points of application.
  pure function position_of_load(scales) result(c)
    type(instrument_scales_t), intent(in) :: scales
    type(cause_t) :: c
    character(*), parameter :: BESIDE = 'Forces acted beside the declared places:'
    real(rp) :: most, sd
    most = 0.05_rp*scales%length
    sd = declared_or_default(scales%position_sd, most/5)
    c = measured('load_position', 'forces beside the declared places', &
                 'All forces acted beside the declared places, shifted by the same distance in the same direction.', &
                 'a membrane', [NEED_MEMBRANE])
    call add(c, LOAD_SHIFT_X, effect_parameter('load_shift_x', 'm', .false., -most, most, sd), OF_LENGTH)
    call add(c, LOAD_SHIFT_Y, effect_parameter('load_shift_y', 'm', .false., -most, most, sd), OF_LENGTH)
    call word_plain(c%parameters(1)%words, 'm', BESIDE, BESIDE, 'toward +x', 'toward -x', '', 0.0_rp)
    call word_plain(c%parameters(2)%words, 'm', BESIDE, BESIDE, 'toward +y', 'toward -y', '', 0.0_rp)
  end function position_of_load

  !> Returns the wrong scale of heights.
  pure function scale_of_heights() result(c)
    type(cause_t) :: c
    c = measured('height_scale', 'wrong scale of the heights', 'All heights were larger or smaller than the maps '// &
                 'show, by one factor.', &
                 'heights', [NEED_HEIGHTS])
    call add(c, HEIGHT_SCALE, effect_parameter('height_scale', '1', .true., 0.5_rp, 2.0_rp, 0.05_rp), OF_ONE)
    call word_factor(c%parameters(1)%words, SCALE_FACTOR, 'The maps show all heights', 'The maps show all heights', 'larger', &
                     'smaller', 'than they are', 'as large as they are', 1.0_rp)
  end function scale_of_heights

  !> Returns the tilt and the lift of loaded scans.
  pure function plane_of_scans(scales) result(c)
    type(instrument_scales_t), intent(in) :: scales
    type(cause_t) :: c
    character(*), parameter :: TILTED = 'Loaded scans are tilted against the unloaded one:', &
                               MOVED = 'Loaded scans lie apart from the unloaded one:'
    real(rp) :: most, sd
    most = 0.05_rp*scales%length
    sd = declared_or_default(scales%tilt_sd, 1.0e-2_rp)
    c = measured('scan_plane', 'tilted or lifted scans', &
                 'All loaded scans were tilted or lifted against the unloaded one, in the same way.', 'heights', [NEED_HEIGHTS])
    call add(c, TILT_X, effect_parameter('tilt_x', 'rad', .false., -0.2_rp, 0.2_rp, sd), OF_ONE)
    call add(c, TILT_Y, effect_parameter('tilt_y', 'rad', .false., -0.2_rp, 0.2_rp, sd), OF_ONE)
    call add(c, PISTON, effect_parameter('piston', 'm', .false., &
                                         -most, most, declared_or_default(scales%piston_sd, most/5)), OF_LENGTH)
    call word_degrees(c%parameters(1)%words, TILTED, 'up toward +y', 'down toward +y')
    call word_degrees(c%parameters(2)%words, TILTED, 'down toward +x', 'up toward +x')
    call word_plain(c%parameters(3)%words, 'm', MOVED, MOVED, 'up', 'down', '', 0.0_rp)
  end function plane_of_scans

  !> Returns the shift, the turn and the scale of maps.
  pure function registration_of_maps(scales) result(c)
    type(instrument_scales_t), intent(in) :: scales
    type(cause_t) :: c
    character(*), parameter :: DISPLACED = 'The wing lies elsewhere in the maps than the file says:'
    real(rp) :: most
    most = 0.05_rp*scales%length
    c = measured('registration', 'shifted or turned maps', &
                 'In the height maps the wing was shifted, turned or magnified against what the file says.', 'heights', &
                 [NEED_HEIGHTS])
    call add(c, MAP_SHIFT_X, effect_parameter('map_shift_x', 'm', .false., -most, most, most/5), OF_LENGTH)
    call add(c, MAP_SHIFT_Y, effect_parameter('map_shift_y', 'm', .false., -most, most, most/5), OF_LENGTH)
    call add(c, MAP_ROTATION, effect_parameter('map_rotation', 'rad', .false., -0.2_rp, 0.2_rp, 0.02_rp), OF_ONE)
    call add(c, MAP_SCALE, effect_parameter('map_scale', '1', .true., 0.9_rp, 1.1_rp, 0.01_rp), OF_ONE)
    call word_plain(c%parameters(1)%words, 'm', DISPLACED, DISPLACED, 'toward +x', 'toward -x', '', 0.0_rp)
    call word_plain(c%parameters(2)%words, 'm', DISPLACED, DISPLACED, 'toward +y', 'toward -y', '', 0.0_rp)
    call word_degrees(c%parameters(3)%words, 'The wing is turned in the maps:', 'counter-clockwise', 'clockwise')
    call word_factor(c%parameters(4)%words, SCALE_FACTOR, 'The maps show the wing', 'The maps show the wing', 'larger', 'smaller', &
                     'than it is', 'as large as it is', 1.0_rp)
  end function registration_of_maps

  !> Returns the drift by order, with the drift of all stiffness and, for trainings alone, of the stiffness of veins.
  pure function drift_by_order(scales) result(c)
    type(instrument_scales_t), intent(in) :: scales
    type(cause_t) :: c
    real(rp) :: most
    integer :: k
    most = 0.9_rp/(scales%last_order - 1)
    c = measured('drift', 'a wing that changed during the experiment', &
                 'The wing became stiffer (it dried) or softer from one measurement to the next.', 'the order of all loads', &
                 [NEED_ORDER])
    call add(c, DRIFT, effect_parameter('drift', '1', .false., -most, most, most/3), OF_ORDER)
    call add(c, DRIFT_VEINS, effect_parameter('drift_veins', '1', .false., -most, most, most/3), OF_ORDER)
    c%parameters(2)%is_tried = .false.
    do k = 1, 2
      call word_factor(c%parameters(k)%words, SCALE_LINEAR, 'The wing became stiffer from one measurement to the next:', &
                       'The wing became softer from one measurement to the next:', 'stiffer', 'softer', 'each time', &
                       'as stiff each time', 0.0_rp)
    end do
  end function drift_by_order

  !> Returns the drift with time.
  pure function drift_by_time(scales) result(c)
    type(instrument_scales_t), intent(in) :: scales
    type(cause_t) :: c
    real(rp), parameter :: MINUTE = 60.0_rp ! [s]
    real(rp) :: most
    most = 0.9_rp/scales%last_time
    c = measured('drift_in_time', 'a wing that changed with time', 'The wing became stiffer (it dried) or softer with time.', &
                 'the time of all loads', [NEED_TIME])
    call add(c, DRIFT_RATE, effect_parameter('drift_rate', '1/s', .false., -most, most, most/3), OF_TIME)
    call word_factor(c%parameters(1)%words, SCALE_LINEAR, 'The wing became stiffer with time:', &
                     'The wing became softer with time:', 'stiffer', 'softer', 'in every minute', 'as stiff in every minute', &
                     0.0_rp)
    c%parameters(1)%words%factor = MINUTE
  end function drift_by_time

  !> Returns the creep, with its size and its time; the input gives the time.
  pure function creep_under_load() result(c)
    type(cause_t) :: c
    type(parameter_t) :: time
    c = measured('creep', 'creep under load', 'The wing went on bending while the force was held.', &
                 'loads whose `hold` differs by a factor of 1.5 or more', [NEED_TWO_HOLDS, NEED_HOLD])
    c%is_measurement = .false.
    call add(c, CREEP, effect_parameter('creep', '1', .false., -0.1_rp, 2.0_rp, 0.1_rp), OF_ONE)
    call define_parameter(time, 'creep_time', 's', .true., 1.0e-3_rp, 1.0e5_rp)
    call c%add(CREEP_TIME, time)
    c%parameters(2)%is_tried = .false.
    call word_factor(c%parameters(1)%words, SCALE_LINEAR, 'The wing goes on bending while a force is held:', &
                     'The wing bends back while a force is held:', 'more', 'less', 'in ten times the time', &
                     'as far in ten times the time', 0.0_rp)
  end function creep_under_load

  !> Returns the weight of the wing, with one acceleration along each axis.
  pure function weight_of_wing() result(c)
    type(cause_t) :: c
    character(*), parameter :: LEAD = 'The wing''s own weight bends it:', AXES = 'xyz'
    integer :: k
    c = measured('gravity', 'weight of the wing', 'The wing''s own weight bends it, also when nothing pushes.', &
                 'the mass of the wing', [NEED_MASS])
    do k = 1, 3
      call add(c, GRAVITY_X + k - 1, effect_parameter('gravity_'//AXES(k:k), 'm/s^2', .false., -20.0_rp, 20.0_rp, 10.0_rp), OF_ONE)
      call word_plain(c%parameters(k)%words, 'm/s^2', LEAD, LEAD, 'toward +'//AXES(k:k), 'toward -'//AXES(k:k), '', 0.0_rp)
    end do
  end function weight_of_wing

  !> Returns the nonlinearity of large deflections.
  pure function large_deflections() result(c)
    type(cause_t) :: c
    c = measured('nonlinearity', 'large deflections', &
                 'The wing bends so far that twice the force does not bend it twice as far. Geometry alone does that.', &
                 'two forces at one place', [NEED_SMALL_DEFLECTIONS])
    c%is_measurement = .false.
    call add(c, NONLINEARITY, effect_parameter('nonlinearity', '1', .false., 0.0_rp, 2.0_rp, 0.5_rp), OF_ONE)
    call word_fraction(c%parameters(1)%words, &
                       'The wing bends so far that twice the force does not bend it twice as far: with', &
                       'The wing bends more in proportion to the force than was assumed: with', 'of what geometry alone makes')
  end function large_deflections
end module measurement_instrument_causes
