! SPDX-License-Identifier: GPL-3.0-or-later
!> What a wing may do beyond the usual model, as parameters with a value at which nothing happens.
!>
!> | name | what | unit | null |
!> |---|---|---|---|
!> | `E_gradient` | g: E of the veins times exp(g (x/R - 1/2)) | 1 | 0 |
!> | `damage` | factor on all stiffness inside the disc `disc` | 1 | 1 |
!> | `soft` | factor on the stiffness of one more hinge | 1 | 1 |
!> | `orthotropy` | a: springs of the membrane times 1 + a cos 2 phi, phi their angle to the span | 1 | 0 |
!> | `joint_hardening` | h: moment of all joints k Theta (1 + h Theta^2) | 1/rad^2 | 0 |
!> | `hardening:<joint>` | what is added to h for one joint | 1/rad^2 | 0 |
!> | `one_way:<joint>` | factor on the stiffness of one joint when it bends up, toward the normal | 1 | 1 |
!> | `cuticle` | c: moment of all other hinges EI kappa (1 + c kappa^2) | m^2 | 0 |
!> | `pretension` | tension of the membrane in the unloaded wing | N/m | 0 |
!> | `camber_span`, `_chord`, `_twist` | curvature of the wing where it is free of stress: xx, yy, xy | 1/m | 0 |
!> | `torsion` | GJ/EI of veins and joints, through the turning of the membrane's normal along them | 1 | 0 |
!> | `root_flap`, `root_twist` | the clamp turns about y and about x by this times the moment | rad/(N m) | 0 |
!>
!> The laws are in the modules solid_effect_* and, of the clamp, in solid_bent_wing; where they act is given beside them
!> and is not sought.
module solid_effects
  use base_kinds, only: rp
  use solid_parameter, only: define_effect, parameter_t
  implicit none
  private
  public :: effects_t, describe_effect

  integer, parameter, public :: EFFECT_GRADIENT = 1, EFFECT_DAMAGE = 2, EFFECT_SOFT = 3, EFFECT_ORTHOTROPY = 4, &
                                EFFECT_HARDENING = 5, EFFECT_CUTICLE = 6, EFFECT_ROOT_FLAP = 7, EFFECT_ROOT_TWIST = 8, &
                                EFFECT_PRETENSION = 9, EFFECT_CAMBER = 9, & !< EFFECT_CAMBER + 1 to 3: xx, yy, xy
                                EFFECT_TORSION = 13
  integer, parameter, public :: N_EFFECTS = 13 !< of the whole wing; the hardening of single joints follows

  !> Values of the effects, and where they act.
  type :: effects_t
    real(rp) :: gradient = 0
    real(rp) :: damage = 1
    real(rp) :: disc(3) = 0                   !< [m] x, y and radius of the damage; radius 0: none
    real(rp) :: soft = 1
    character(:), allocatable :: soft_vein    !< with one more soft hinge; not allocated: none
    real(rp) :: soft_share = 0                !< its place, of the vein's length
    real(rp) :: orthotropy = 0
    real(rp) :: hardening = 0                 !< [1/rad^2]
    real(rp) :: cuticle = 0                   !< [m^2]
    real(rp) :: root_flap = 0                 !< [rad/(N m)]
    real(rp) :: root_twist = 0                !< [rad/(N m)]
    real(rp) :: pretension = 0                !< [N/m]
    real(rp) :: camber(3) = 0                 !< [1/m] xx, yy, xy
    real(rp) :: torsion = 0
    logical :: has_sided_veins = .false.      !< veins feel the membrane's normal: needed by `camber` and `torsion`
    real(rp), allocatable :: joint_hardening(:) !< (joints) [1/rad^2] beside `hardening`
    logical :: has_sides = .false.              !< joints can tell up from down: needed by `one_way`
    real(rp), allocatable :: one_way(:)         !< (joints)
  contains
    procedure :: count => effects_count
    procedure :: get => effects_get
    procedure :: set => effects_set
    procedure :: has_damage => effects_has_damage
  end type effects_t

contains

  !> Number of effects.
  pure integer function effects_count(self) result(n)
    class(effects_t), intent(in) :: self
    n = N_EFFECTS + size(self%joint_hardening) + size(self%one_way)
  end function effects_count

  !> Name, unit, scale, bounds and null of effect i; `joint_names` are those of the wing.
  function describe_effect(i, joint_names) result(p)
    integer, intent(in) :: i
    character(*), intent(in) :: joint_names(:)
    type(parameter_t) :: p
    select case (i)
    case (EFFECT_GRADIENT)
      call define_effect(p, 'E_gradient', '1', .false., -5.0_rp, 5.0_rp, 1.0_rp)
    case (EFFECT_DAMAGE)
      call define_effect(p, 'damage', '1', .true., 1.0e-2_rp, 1.0e2_rp, 1.0_rp)
    case (EFFECT_SOFT)
      call define_effect(p, 'soft', '1', .true., 1.0e-4_rp, 1.0e2_rp, 2.0_rp)
    case (EFFECT_ORTHOTROPY)
      call define_effect(p, 'orthotropy', '1', .false., -0.9_rp, 0.9_rp, 0.5_rp)
    case (EFFECT_HARDENING)
      call define_effect(p, 'joint_hardening', '1/rad^2', .false., -1.0_rp, 1.0e5_rp, 10.0_rp)
    case (EFFECT_CUTICLE)
      call define_effect(p, 'cuticle', 'm^2', .false., -1.0e-5_rp, 1.0e-3_rp, 1.0e-5_rp)
    case (EFFECT_ROOT_FLAP)
      call define_effect(p, 'root_flap', 'rad/(N m)', .false., 0.0_rp, 1.0e5_rp, 1.0e4_rp)
    case (EFFECT_ROOT_TWIST)
      call define_effect(p, 'root_twist', 'rad/(N m)', .false., 0.0_rp, 1.0e5_rp, 1.0e4_rp)
    case (EFFECT_PRETENSION)
      call define_effect(p, 'pretension', 'N/m', .false., 0.0_rp, 10.0_rp, 0.1_rp)
    case (EFFECT_CAMBER + 1)
      call define_effect(p, 'camber_span', '1/m', .false., -20.0_rp, 20.0_rp, 3.0_rp)
    case (EFFECT_CAMBER + 2)
      call define_effect(p, 'camber_chord', '1/m', .false., -300.0_rp, 300.0_rp, 30.0_rp)
    case (EFFECT_CAMBER + 3)
      call define_effect(p, 'camber_twist', '1/m', .false., -60.0_rp, 60.0_rp, 10.0_rp)
    case (EFFECT_TORSION)
      call define_effect(p, 'torsion', '1', .false., 0.0_rp, 10.0_rp, 1.0_rp)
    case (N_EFFECTS + 1:)
      if (i <= N_EFFECTS + size(joint_names)) then
        call define_effect(p, 'hardening:'//trim(joint_names(i - N_EFFECTS)), '1/rad^2', .false., -1.0_rp, 1.0e5_rp, &
                           10.0_rp)
      else
        call define_effect(p, 'one_way:'//trim(joint_names(i - N_EFFECTS - size(joint_names))), '1', .true., 0.1_rp, &
                           10.0_rp, 0.5_rp)
      end if
    end select
  end function describe_effect

  !> Value of effect i in its unit.
  pure real(rp) function effects_get(self, i) result(value)
    class(effects_t), intent(in) :: self
    integer, intent(in) :: i
    select case (i)
    case (EFFECT_GRADIENT)
      value = self%gradient
    case (EFFECT_DAMAGE)
      value = self%damage
    case (EFFECT_SOFT)
      value = self%soft
    case (EFFECT_ORTHOTROPY)
      value = self%orthotropy
    case (EFFECT_HARDENING)
      value = self%hardening
    case (EFFECT_CUTICLE)
      value = self%cuticle
    case (EFFECT_ROOT_FLAP)
      value = self%root_flap
    case (EFFECT_ROOT_TWIST)
      value = self%root_twist
    case (EFFECT_PRETENSION)
      value = self%pretension
    case (EFFECT_CAMBER + 1:EFFECT_CAMBER + 3)
      value = self%camber(i - EFFECT_CAMBER)
    case (EFFECT_TORSION)
      value = self%torsion
    case default
      if (i <= N_EFFECTS + size(self%one_way)) then
        value = self%joint_hardening(i - N_EFFECTS)
      else
        value = self%one_way(i - N_EFFECTS - size(self%one_way))
      end if
    end select
  end function effects_get

  !> Sets effect i.
  pure subroutine effects_set(self, i, value)
    class(effects_t), intent(inout) :: self
    integer, intent(in) :: i
    real(rp), intent(in) :: value
    select case (i)
    case (EFFECT_GRADIENT)
      self%gradient = value
    case (EFFECT_DAMAGE)
      self%damage = value
    case (EFFECT_SOFT)
      self%soft = value
    case (EFFECT_ORTHOTROPY)
      self%orthotropy = value
    case (EFFECT_HARDENING)
      self%hardening = value
    case (EFFECT_CUTICLE)
      self%cuticle = value
    case (EFFECT_ROOT_FLAP)
      self%root_flap = value
    case (EFFECT_ROOT_TWIST)
      self%root_twist = value
    case (EFFECT_PRETENSION)
      self%pretension = value
    case (EFFECT_CAMBER + 1:EFFECT_CAMBER + 3)
      self%camber(i - EFFECT_CAMBER) = value
    case (EFFECT_TORSION)
      self%torsion = value
    case default
      if (i <= N_EFFECTS + size(self%one_way)) then
        self%joint_hardening(i - N_EFFECTS) = value
      else
        self%one_way(i - N_EFFECTS - size(self%one_way)) = value
      end if
    end select
  end subroutine effects_set

  !> Whether a place of damage is given.
  pure logical function effects_has_damage(self) result(has)
    class(effects_t), intent(in) :: self
    has = self%disc(3) > 0
  end function effects_has_damage
end module solid_effects
