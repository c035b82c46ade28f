! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes energy losses of a moving wing, as parameters with a null value at which they have no effect.
!>
!> | name | what | unit | null |
!> |---|---|---|---|
!> | `rayleigh_mass` | damping force per mass and velocity: still air, to first order | 1/s | 0 |
!> | `rayleigh_stiffness` | damping force per rate of the elastic force | s | 0 |
!> | `joint_friction` | the same for the joints of veins alone: moment per rate of their elastic moment | s | 0 |
!> | `drag` | drag of the air per area and squared speed: half its density times the drag coefficient | kg/m^3 | 0 |
!> | `relaxation` | g: a sudden force meets 1 + g times the stiffness; the addition relaxes in `relaxation_time` | 1 | 0 |
!>
!> The forces of a viscoelastic wing are those of a standard linear solid: f + g z with z' = f' - z/tau, f the elastic force.
module solid_damping_effects
  use base_cause, only: cause_t, enlist, make_cause
  use base_kinds, only: rp
  use base_parameter, only: define_effect, define_parameter, parameter_t
  use base_wording, only: word_by_name
  use solid_effect, only: NEED_AIR, NEED_MEMBRANE
  implicit none
  private
  public :: damping_effects_t, list_damping_causes, mass_damping_parameter

  integer, parameter, public :: DAMPING_MASS = 1, DAMPING_STIFFNESS = 2, DAMPING_JOINTS = 3, DAMPING_RELAXATION = 4, &
                                DAMPING_DRAG = 5, N_DAMPING_EFFECTS = 5, &
                                DAMPING_TIME = 6 !< logarithm of the relaxation time; needs a relaxation

  real(rp), parameter, public :: RELAXATION_STEP = 2.0_rp !< ratio of the relaxation times that are tried
  character(*), parameter :: RECORDS = 'records of motion', LOSSES = RECORDS//' or damping of modes', &
                             PER_TURN = 'T/n', PER_TURN_SQUARED = 'T/n^2'

  !> Holds the values of the effects.
  type :: damping_effects_t
    real(rp) :: mass = 0            !< [1/s]
    real(rp) :: stiffness = 0       !< [s]
    real(rp) :: joints = 0          !< [s]
    real(rp) :: relaxation = 0
    real(rp) :: drag = 0            !< [kg/m^3]
    real(rp) :: relaxation_time = 1 !< [s]
  contains
    procedure :: set => effects_set
  end type damping_effects_t

contains

  !> Returns the causes that are losses of energy other than the damping in proportion to the mass. The priors are those of a wing
  !> whose motion decays within `time` [s], while its phase turns by `turns` [rad], in air of this density [kg/m^3].
  pure function list_damping_causes(time, turns, density) result(list)
    real(rp), intent(in) :: time, turns, density
    type(cause_t), allocatable :: list(:)
    call enlist(list, damping_by_stiffness(time, turns))
    call enlist(list, friction_of_joints(time, turns))
    call enlist(list, viscoelasticity(turns))
    call enlist(list, drag_of_air(density))
  end function list_damping_causes

  !> Returns the parameter of the damping in proportion to the mass, which a baseline fits, for such a wing.
  pure function mass_damping_parameter(time, turns) result(p)
    real(rp), intent(in) :: time, turns
    type(parameter_t) :: p
    real(rp) :: rate
    rate = 1/time
    call define_effect(p, 'rayleigh_mass', '1/s', .false., 0.0_rp, 100*turns*rate, 2*rate)
  end function mass_damping_parameter

  pure function damping_by_stiffness(time, turns) result(cause)
    real(rp), intent(in) :: time, turns
    type(cause_t) :: cause
    type(parameter_t) :: p
    cause = make_cause('stiffness_damping', 'damping in proportion to the stiffness', &
                       'What bends fast is damped more than still air would: the cuticle takes energy at every rate.', LOSSES)
    call define_effect(p, 'rayleigh_stiffness', 's', .false., 0.0_rp, 10*time/turns, 2*time/turns**2)
    call cause%add(DAMPING_STIFFNESS, p, PER_TURN, PER_TURN_SQUARED)
    call word_by_name(cause%parameters(1)%words, p%name)
  end function damping_by_stiffness

  pure function friction_of_joints(time, turns) result(cause)
    real(rp), intent(in) :: time, turns
    type(cause_t) :: cause
    type(parameter_t) :: p
    cause = make_cause('joint_friction', 'friction in the joints of veins', &
                       'The joints of veins take energy when they turn.', LOSSES)
    call define_effect(p, 'joint_friction', 's', .false., 0.0_rp, 100*time/turns, 10*time/turns**2)
    call cause%add(DAMPING_JOINTS, p, PER_TURN, PER_TURN_SQUARED)
    call word_by_name(cause%parameters(1)%words, p%name)
  end function friction_of_joints

  !> Returns the relaxation, with the fraction of the stiffness that relaxes and a factor on the time. It is tried with several
  !> times.
  pure function viscoelasticity(turns) result(cause)
    real(rp), intent(in) :: turns
    type(cause_t) :: cause
    type(parameter_t) :: p
    integer :: k
    cause = make_cause('viscoelasticity', 'viscoelastic veins and membrane', &
                       'The wing is stiffer when it bends fast, and loses energy in between: its material relaxes.', LOSSES)
    call define_effect(p, 'relaxation', '1', .false., 0.0_rp, 10.0_rp, 4/turns)
    call cause%add(DAMPING_RELAXATION, p, '', '1/n')
    call define_parameter(p, 'relaxation_time_factor', '1', .true., 1/RELAXATION_STEP, RELAXATION_STEP)
    p%prior_sd = log(RELAXATION_STEP)
    p%null = 1
    call cause%add(DAMPING_TIME, p)
    do k = 1, 2
      call word_by_name(cause%parameters(k)%words, cause%parameters(k)%value%name)
    end do
  end function viscoelasticity

  !> Returns the drag with the square of the speed. A plate that oscillates by a small part of its chord has a drag coefficient of
  !> about 10 (Graham 1980, J. Fluid Mech. 97, 331), a steadily moving one of 2: the prior sd is 10.
  pure function drag_of_air(density) result(cause)
    real(rp), intent(in) :: density
    type(cause_t) :: cause
    type(parameter_t) :: p
    cause = make_cause('air_drag', 'drag of the air with the square of the speed', &
                       'Large motion is damped more than small motion: the air separates from the wing.', RECORDS//' in air')
    cause%needs = [NEED_MEMBRANE, NEED_AIR]
    call define_effect(p, 'drag', 'kg/m^3', .false., 0.0_rp, 100*density, 5*density)
    call cause%add(DAMPING_DRAG, p, 'the density of the air')
    call word_by_name(cause%parameters(1)%words, p%name)
  end function drag_of_air

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
    case (DAMPING_DRAG)
      self%drag = value
    case default
      self%relaxation = value
    end select
  end subroutine effects_set
end module solid_damping_effects
