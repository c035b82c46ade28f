! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a parameter: its name, its scale and its bounds. Wings, instruments, fits and diagnoses use the same description.
module base_parameter
  use base_kinds, only: rp
  implicit none
  private
  public :: parameter_t, define_parameter, define_effect, effect_parameter

  !> The coordinate of a parameter is its natural logarithm if `is_log`, and its value otherwise. In the definition of a parameter
  !> `lower`, `upper` and `null` are values; in the result of `as_coordinate` they are coordinates.
  type :: parameter_t
    character(:), allocatable :: name, unit !< unit '1': a number without a unit
    logical :: is_log = .false.      !< varied by factors
    real(rp) :: lower = -huge(1.0_rp), upper = huge(1.0_rp)
    logical :: is_effect = .false.   !< something that the usual model leaves out
    real(rp) :: null = 0             !< value at which an effect vanishes; starting value of any other parameter
    real(rp) :: prior_sd = 0         !< usual standard deviation of the coordinate about null; 0: not stated
    !> Additional starting value of fits, for effects whose tangent at null is misleading; 0: none. For effects that are not varied
    !> by factors.
    real(rp) :: strong = 0
  contains
    procedure :: as_coordinate => parameter_as_coordinate
  end type parameter_t

contains

  !> Makes a parameter that every wing has.
  pure subroutine define_parameter(p, name, unit, is_log, lower, upper)
    type(parameter_t), intent(out) :: p
    character(*), intent(in) :: name, unit
    logical, intent(in) :: is_log
    real(rp), intent(in) :: lower, upper
    p%name = name
    p%unit = unit
    p%is_log = is_log
    p%lower = lower
    p%upper = upper
  end subroutine define_parameter

  !> Makes the parameter of an effect. The effect vanishes at 1 if it is varied by factors and at 0 otherwise.
  pure subroutine define_effect(p, name, unit, is_log, lower, upper, prior_sd)
    type(parameter_t), intent(out) :: p
    character(*), intent(in) :: name, unit
    logical, intent(in) :: is_log
    real(rp), intent(in) :: lower, upper, prior_sd
    call define_parameter(p, name, unit, is_log, lower, upper)
    p%is_effect = .true.
    p%null = merge(1.0_rp, 0.0_rp, is_log)
    p%prior_sd = prior_sd
  end subroutine define_effect

  !> Returns the parameter of an effect: see define_effect.
  pure function effect_parameter(name, unit, is_log, lower, upper, prior_sd) result(p)
    character(*), intent(in) :: name, unit
    logical, intent(in) :: is_log
    real(rp), intent(in) :: lower, upper, prior_sd
    type(parameter_t) :: p
    call define_effect(p, name, unit, is_log, lower, upper, prior_sd)
  end function effect_parameter

  !> Returns the same parameter with coordinates in place of values, and with the coordinate of `value` as its null. A parameter
  !> that varies by factors and has no positive lower bound gets the least positive number as its lower bound.
  pure function parameter_as_coordinate(self, value) result(p)
    class(parameter_t), intent(in) :: self
    real(rp), intent(in) :: value
    type(parameter_t) :: p
    p%name = self%name
    p%unit = self%unit
    p%is_log = self%is_log
    p%is_effect = self%is_effect
    p%prior_sd = self%prior_sd
    p%strong = self%strong
    p%lower = coordinate(self%lower)
    p%upper = coordinate(self%upper)
    p%null = coordinate(value)

  contains

    pure real(rp) function coordinate(x)
      real(rp), intent(in) :: x
      coordinate = x
      if (self%is_log) coordinate = log(max(x, tiny(x)))
    end function coordinate

  end function parameter_as_coordinate
end module base_parameter
