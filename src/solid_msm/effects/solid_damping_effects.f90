! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes energy losses of a moving wing, as parameters with a null value at which they have no effect.
!>
!> | name | what | unit | null |
!> |---|---|---|---|
!> | `rayleigh_mass` | damping force per mass and velocity: still air, to first order | 1/s | 0 |
!> | `rayleigh_stiffness` | damping force per rate of the elastic force | s | 0 |
!> | `joint_friction` | the same of the joints of veins alone: moment per rate of their elastic moment | s | 0 |
!> | `relaxation` | share g: for a sudden force the stiffness is 1 + g times larger; this relaxes in `relaxation_time` | 1 | 0 |
!>
!> The forces of a viscoelastic wing are those of a standard linear solid: f + g z with z' = f' - z/tau, f the elastic force.
module solid_damping_effects
  use base_kinds, only: rp
  use base_parameter, only: define_effect, parameter_t
  implicit none
  private
  public :: damping_effects_t, describe_damping

  integer, parameter, public :: DAMPING_MASS = 1, DAMPING_STIFFNESS = 2, DAMPING_JOINTS = 3, DAMPING_RELAXATION = 4, &
                                N_DAMPING_EFFECTS = 4, &
                                DAMPING_TIME = 5 !< logarithm of the relaxation time, needs a relaxation

  !> Values of the effects.
  type :: damping_effects_t
    real(rp) :: mass = 0            !< [1/s]
    real(rp) :: stiffness = 0       !< [s]
    real(rp) :: joints = 0          !< [s]
    real(rp) :: relaxation = 0
    real(rp) :: relaxation_time = 1 !< [s]
  contains
    procedure :: set => effects_set
  end type damping_effects_t

contains

  !> Returns name, unit, scale, bounds and null of effect i. The priors are those of a wing whose motion decays within `time` [s],
  !> in which it turns by `turns` [rad].
  function describe_damping(i, time, turns) result(p)
    integer, intent(in) :: i
    real(rp), intent(in) :: time, turns
    type(parameter_t) :: p
    real(rp) :: rate
    rate = 1/time
    select case (i)
    case (DAMPING_MASS)
      call define_effect(p, 'rayleigh_mass', '1/s', .false., 0.0_rp, 100*turns*rate, 2*rate)
    case (DAMPING_STIFFNESS)
      call define_effect(p, 'rayleigh_stiffness', 's', .false., 0.0_rp, 10*time/turns, 2*time/turns**2)
    case (DAMPING_JOINTS)
      call define_effect(p, 'joint_friction', 's', .false., 0.0_rp, 100*time/turns, 10*time/turns**2)
    case default
      call define_effect(p, 'relaxation', '1', .false., 0.0_rp, 10.0_rp, 4/turns)
    end select
  end function describe_damping

  !> Sets the value of effect i, in its unit.
  pure subroutine effects_set(self, i, value)
    class(damping_effects_t), intent(inout) :: self
    integer, intent(in) :: i
    real(rp), intent(in) :: value
    select case (i)
    case (DAMPING_MASS)
      self%mass = value
    case (DAMPING_STIFFNESS)
      self%stiffness = value
    case (DAMPING_JOINTS)
      self%joints = value
    case default
      self%relaxation = value
    end select
  end subroutine effects_set
end module solid_damping_effects
