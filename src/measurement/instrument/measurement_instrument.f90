! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds how an experiment deviates from its file: values of the parameters that measurement_instrument_causes describes.
module measurement_instrument
  use base_cause, only: cause_t, find_parameter, parameter_of
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use measurement_data, only: measurement_t
  use measurement_instrument_causes, only: instrument_scales_t, list_instrument_causes, CREEP_TIME, INSTRUMENT_DEFAULTS, &
                                           N_INSTRUMENT, NEED_HEIGHTS, NEED_HOLD, NEED_ORDER, NEED_TIME, NONLINEARITY
  implicit none
  private
  public :: instrument_t, missing_for

  !> The values, by the numbers of the parameters, and the quantities that set their scales.
  type :: instrument_t
    real(rp) :: values(N_INSTRUMENT) = INSTRUMENT_DEFAULTS
    type(instrument_scales_t) :: scales
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
    self%scales%length = length
    if (any(m%loads%force > 0)) self%scales%smallest_force = minval(m%loads%force, mask=m%loads%force > 0)
    self%scales%last_order = max(2, maxval(m%loads%order))
    self%scales%last_time = max(1.0_rp, maxval(m%loads%time))
    self%scales%gain_sd = m%accuracy%force_gain
    self%scales%position_sd = m%accuracy%position
    self%scales%tilt_sd = m%accuracy%tilt
    self%scales%piston_sd = m%accuracy%piston
  end subroutine instrument_set_scales

  !> Returns name, unit, scale, bounds and null of parameter i. Priors are the declared sd where there are any.
  function instrument_describe(self, i) result(p)
    class(instrument_t), intent(in) :: self
    integer, intent(in) :: i
    type(parameter_t) :: p
    call require(i >= 1 .and. i <= N_INSTRUMENT, 'instrument_t: no such parameter')
    p = parameter_of(list_instrument_causes(self%scales), i)
  end function instrument_describe

  !> Returns the number of the parameter called `name`, 0 if there is none.
  integer function instrument_find(self, name) result(found)
    class(instrument_t), intent(in) :: self
    character(*), intent(in) :: name
    type(parameter_t) :: p
    do found = N_INSTRUMENT, 1, -1
      p = self%describe(found)
      if (p%name == name) return
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
    differs = abs(self%values - INSTRUMENT_DEFAULTS) > 0
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
    type(instrument_scales_t) :: scales
    type(cause_t), allocatable :: list(:)
    integer :: cause, k
    problem = ''
    if (size(m%loads) == 0) problem = 'needs bending tests'
    list = list_instrument_causes(scales)
    call find_parameter(list, i, cause, k)
    do k = 1, size(list(cause)%needs)
      select case (list(cause)%needs(k))
      case (NEED_ORDER)
        if (any(m%loads%order <= 0)) problem = 'needs the order of all loads'
      case (NEED_TIME)
        if (any(m%loads%time < 0)) problem = 'needs the time of all loads'
      case (NEED_HOLD)
        if (any(m%loads%hold < 0)) problem = 'needs the hold of all loads'
      case (NEED_HEIGHTS)
        if (.not. any(m%loads%has_surface)) problem = 'needs heights'
      end select
    end do
  end function missing_for
end module measurement_instrument
