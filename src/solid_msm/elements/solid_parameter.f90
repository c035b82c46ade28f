! SPDX-License-Identifier: GPL-3.0-or-later
!> What a parameter is called, how it is varied and where it may lie: those of wings and of instruments.
module solid_parameter
  use base_kinds, only: rp
  implicit none
  private
  public :: parameter_t, define_parameter, define_effect

  !> The coordinate of a parameter is its natural logarithm if `is_log`, and its value otherwise.
  type :: parameter_t
    character(:), allocatable :: name, unit
    logical :: is_log = .true.       !< to be varied by factors
    real(rp) :: lower = 0, upper = 0 !< bounds for optimisers
    logical :: is_effect = .false.   !< something that the usual model leaves out
    real(rp) :: null = 0             !< value at which an effect vanishes
    real(rp) :: prior_sd = 0         !< usual sd of the coordinate of an effect about that; 0: not stated
    real(rp) :: strong = 0           !< value of an effect from which fits begin too; 0: none
  end type parameter_t

contains

  !> A parameter that every wing has.
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

  !> An effect; it vanishes at 1 if it is varied by factors and at 0 otherwise.
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
end module solid_parameter
