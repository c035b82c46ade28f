! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes deviations of an experiment from its file, as parameters with a null value at which they have no effect.
!>
!> With q = 0 deflections are proportional to forces, as in the theory of small deflections. They are computed as the response to
!> a hundredth of the force, which differs from the limit by 1e-4 of the nonlinear part.
!>
!> | name | what | unit | null |
!> |---|---|---|---|
!> | `force_gain` | forces are this times what is stated | 1 | 1 |
!> | `force_offset` | and this more, along their direction | N | 0 |
!> | `force_tilt_x`, `_y` | rotation vector of all directions | rad | 0 |
!> | `load_shift_x`, `_y` | of all points of application | m | 0 |
!> | `drift` | r: all bending stiffness times 1 + r (order - 1) | 1 | 0 |
!> | `drift_rate` | r: all bending stiffness times 1 + r time | 1/s | 0 |
!> | `drift_veins` | as `drift`, of the veins' E alone | 1 | 0 |
!> | `creep`, `creep_time` | a, tau: all bending stiffness over 1 + a log10(1 + hold/tau) | 1, s | 0, - |
!> | `height_scale` | heights are shown as this times what they are | 1 | 1 |
!> | `tilt_x`, `tilt_y`, `piston` | p, q, h: loaded maps show p y - q x + h more | rad, m | 0 |
!> | `map_shift_x`, `_y`, `map_rotation`, `map_scale` | a place x is shown at scale R x + shift | m, rad, 1 | 0, 1 |
!> | `nonlinearity` | q: what is shown is that of the forces times sqrt q, over sqrt q | 1 | 1 |
!> | `gravity_x`, `_y`, `_z` | acceleration that bends the wing, also unloaded | m/s^2 | 0 |
module measurement_instrument
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: define_effect, define_parameter, parameter_t
  use measurement_data, only: measurement_t
  implicit none
  private
  public :: instrument_t, missing_for

  integer, parameter, public :: FORCE_GAIN = 1, FORCE_OFFSET = 2, FORCE_TILT_X = 3, FORCE_TILT_Y = 4, &
                                LOAD_SHIFT_X = 5, LOAD_SHIFT_Y = 6, DRIFT = 7, DRIFT_RATE = 8, DRIFT_VEINS = 9, &
                                CREEP = 10, CREEP_TIME = 11, HEIGHT_SCALE = 12, TILT_X = 13, TILT_Y = 14, PISTON = 15, &
                                MAP_SHIFT_X = 16, MAP_SHIFT_Y = 17, MAP_ROTATION = 18, MAP_SCALE = 19, GRAVITY_X = 20, &
                                GRAVITY_Y = 21, GRAVITY_Z = 22, NONLINEARITY = 23
  integer, parameter, public :: N_INSTRUMENT = 23
  character(12), parameter :: NAMES(N_INSTRUMENT) = [character(12) :: &
                                         'force_gain', 'force_offset', 'force_tilt_x', 'force_tilt_y', 'load_shift_x', &
                                          'load_shift_y', 'drift', 'drift_rate', 'drift_veins', 'creep', 'creep_time', &
                                           'height_scale', 'tilt_x', 'tilt_y', 'piston', 'map_shift_x', 'map_shift_y', &
                                     'map_rotation', 'map_scale', 'gravity_x', 'gravity_y', 'gravity_z', 'nonlinearity']
  !> The null, or the usual value, in the same order.
  real(rp), parameter :: DEFAULTS(N_INSTRUMENT) = [real(rp) :: 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 1, &
                                                                                                          0, 0, 0, 1]

  !> The values, in the order of the names, and the quantities that set their scales.
  type :: instrument_t
    real(rp) :: values(N_INSTRUMENT) = DEFAULTS
    real(rp), private :: length = 1            !< [m] of the wing
    real(rp), private :: smallest_force = 1    !< [N] that was applied
    real(rp), private :: last_order = 2, last_time = 1 !< [1], [s]
    real(rp), private :: gain_sd = 0, position_sd = 0, tilt_sd = 0, piston_sd = 0 !< declared
  contains
    procedure :: set_scales => instrument_set_scales
    procedure :: describe => instrument_describe
    procedure :: find => instrument_find
    procedure :: get => instrument_get
    procedure :: set => instrument_set
    procedure :: is_null => instrument_is_null
    procedure :: load_scale => instrument_load_scale
  end type instrument_t

contains

  !> Takes the scales of bounds and priors from a measurement of a wing of `length` [m]. Values stay.
  pure subroutine instrument_set_scales(self, m, length)
    class(instrument_t), intent(inout) :: self
    type(measurement_t), intent(in) :: m
    real(rp), intent(in) :: length
    self%length = length
    if (any(m%loads%force > 0)) self%smallest_force = minval(m%loads%force, mask=m%loads%force > 0)
    self%last_order = max(2, maxval(m%loads%order))
    self%last_time = max(1.0_rp, maxval(m%loads%time))
    self%gain_sd = m%accuracy%force_gain
    self%position_sd = m%accuracy%position
    self%tilt_sd = m%accuracy%tilt
    self%piston_sd = m%accuracy%piston
  end subroutine instrument_set_scales

  !> Returns name, unit, scale, bounds and null of parameter i. Priors are the declared sd where there are any.
  function instrument_describe(self, i) result(p)
    class(instrument_t), intent(in) :: self
    integer, intent(in) :: i
    type(parameter_t) :: p
    real(rp) :: most
    call require(i >= 1 .and. i <= N_INSTRUMENT, 'instrument_t: no such parameter')
    select case (i)
    case (FORCE_GAIN)
      call define_effect(p, 'force_gain', '1', .true., 0.1_rp, 10.0_rp, declared_or_default(self%gain_sd, 0.1_rp))
    case (FORCE_OFFSET)
      most = 0.9_rp*self%smallest_force
      call define_effect(p, 'force_offset', 'N', .false., -most, most, most/3)
    case (FORCE_TILT_X, FORCE_TILT_Y)
      call define_effect(p, trim(NAMES(i)), 'rad', .false., -0.5_rp, 0.5_rp, 0.05_rp)
    case (LOAD_SHIFT_X, LOAD_SHIFT_Y)
      most = 0.05_rp*self%length
      call define_effect(p, trim(NAMES(i)), 'm', .false., -most, most, declared_or_default(self%position_sd, most/5))
    case (DRIFT, DRIFT_VEINS)
      most = 0.9_rp/(self%last_order - 1)
      call define_effect(p, trim(NAMES(i)), '1', .false., -most, most, most/3)
    case (DRIFT_RATE)
      most = 0.9_rp/self%last_time
      call define_effect(p, 'drift_rate', '1/s', .false., -most, most, most/3)
    case (CREEP)
      call define_effect(p, 'creep', '1', .false., -0.1_rp, 2.0_rp, 0.1_rp)
    case (CREEP_TIME)
      call define_parameter(p, 'creep_time', 's', .true., 1.0e-3_rp, 1.0e5_rp)
    case (HEIGHT_SCALE)
      call define_effect(p, 'height_scale', '1', .true., 0.5_rp, 2.0_rp, 0.05_rp)
    case (TILT_X, TILT_Y)
      call define_effect(p, trim(NAMES(i)), 'rad', .false., -0.2_rp, 0.2_rp, declared_or_default(self%tilt_sd, 1.0e-2_rp))
    case (PISTON)
      most = 0.05_rp*self%length
      call define_effect(p, 'piston', 'm', .false., -most, most, declared_or_default(self%piston_sd, most/5))
    case (MAP_SHIFT_X, MAP_SHIFT_Y)
      most = 0.05_rp*self%length
      call define_effect(p, trim(NAMES(i)), 'm', .false., -most, most, most/5)
    case (MAP_ROTATION)
      call define_effect(p, 'map_rotation', 'rad', .false., -0.2_rp, 0.2_rp, 0.02_rp)
    case (MAP_SCALE)
      call define_effect(p, 'map_scale', '1', .true., 0.9_rp, 1.1_rp, 0.01_rp)
    case (NONLINEARITY)
      call define_effect(p, 'nonlinearity', '1', .false., 0.0_rp, 2.0_rp, 0.5_rp)
      p%null = 1
    case default
      call define_effect(p, trim(NAMES(i)), 'm/s^2', .false., -20.0_rp, 20.0_rp, 10.0_rp)
    end select
  end function instrument_describe

  !> Returns a declared sd, or a default if none is declared.
  pure real(rp) function declared_or_default(sd, default_value)
    real(rp), intent(in) :: sd, default_value
    declared_or_default = default_value
    if (sd > 0) declared_or_default = sd
  end function declared_or_default

  !> Returns the number of the parameter called `name`, 0 if there is none.
  pure integer function instrument_find(self, name) result(found)
    class(instrument_t), intent(in) :: self
    character(*), intent(in) :: name
    do found = size(self%values), 1, -1
      if (NAMES(found) == name) return
    end do
    found = 0
  end function instrument_find

  !> Returns the value of parameter i, in its unit.
  pure real(rp) function instrument_get(self, i) result(value)
    class(instrument_t), intent(in) :: self
    integer, intent(in) :: i
    value = self%values(i)
  end function instrument_get

  !> Sets parameter i, in its unit.
  pure subroutine instrument_set(self, i, value)
    class(instrument_t), intent(inout) :: self
    integer, intent(in) :: i
    real(rp), intent(in) :: value
    self%values(i) = value
  end subroutine instrument_set

  !> Tells whether parameters first to last, or all, do nothing.
  pure logical function instrument_is_null(self, first, last) result(is_null)
    class(instrument_t), intent(in) :: self
    integer, intent(in), optional :: first, last
    logical :: differs(N_INSTRUMENT)
    differs = abs(self%values - DEFAULTS) > 0
    differs(CREEP_TIME) = .false.
    if (present(first)) differs(:first - 1) = .false.
    if (present(last)) differs(last + 1:) = .false.
    is_null = .not. any(differs)
  end function instrument_is_null

  !> Returns sqrt q, by which the forces are multiplied.
  pure real(rp) function instrument_load_scale(self) result(scale)
    class(instrument_t), intent(in) :: self
    real(rp), parameter :: LEAST = 1.0e-4_rp ! of q, below which rounding is larger than the nonlinear part
    scale = sqrt(max(LEAST, self%values(NONLINEARITY)))
  end function instrument_load_scale

  !> Returns what the measurement lacks to determine parameter i; empty if nothing.
  function missing_for(i, m) result(problem)
    integer, intent(in) :: i
    type(measurement_t), intent(in) :: m
    character(:), allocatable :: problem
    problem = ''
    if (size(m%loads) == 0) problem = 'needs bending tests'
    select case (i)
    case (DRIFT, DRIFT_VEINS)
      if (any(m%loads%order <= 0)) problem = 'needs the order of all loads'
    case (DRIFT_RATE)
      if (any(m%loads%time < 0)) problem = 'needs the time of all loads'
    case (CREEP, CREEP_TIME)
      if (any(m%loads%hold < 0)) problem = 'needs the hold of all loads'
    case (HEIGHT_SCALE, TILT_X:MAP_SCALE)
      if (.not. any(m%loads%has_surface)) problem = 'needs heights'
    end select
  end function missing_for
end module measurement_instrument
