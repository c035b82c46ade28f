! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the strength of the effects of a wing, and the sites where they act. The module solid_effect_* of an effect defines it;
!> solid_effects lists all effects, which gives the order of the values.
module solid_effect_values
  use base_kinds, only: rp
  implicit none
  private
  public :: effects_t

  type :: effects_t
    integer :: n_joints = 0
    real(rp), allocatable :: value(:)         !< of all parameters, each in its unit
    real(rp) :: disc(3) = 0                   !< [m] x, y and radius of the damage; radius 0: none
    character(:), allocatable :: soft_vein    !< vein with an additional soft hinge; not allocated: none
    real(rp) :: soft_fraction = 0                !< site of this hinge, as a fraction of the length of the vein
    logical :: has_sided_veins = .false.      !< veins feel the membrane's normal
    logical :: has_sides = .false.            !< joints distinguish up from down
  contains
    procedure :: count => effects_count
    procedure :: get => effects_get
    procedure :: set => effects_set
    procedure :: has_damage => effects_has_damage
  end type effects_t

contains

  !> Returns the number of parameters of all effects.
  pure integer function effects_count(self) result(n)
    class(effects_t), intent(in) :: self
    n = size(self%value)
  end function effects_count

  !> Returns the value of parameter i, in its unit.
  pure real(rp) function effects_get(self, i) result(value)
    class(effects_t), intent(in) :: self
    integer, intent(in) :: i
    value = self%value(i)
  end function effects_get

  !> Sets the value of parameter i, in its unit.
  pure subroutine effects_set(self, i, value)
    class(effects_t), intent(inout) :: self
    integer, intent(in) :: i
    real(rp), intent(in) :: value
    self%value(i) = value
  end subroutine effects_set

  !> Tells whether the site of a damage is given.
  pure logical function effects_has_damage(self) result(has)
    class(effects_t), intent(in) :: self
    has = self%disc(3) > 0
  end function effects_has_damage
end module solid_effect_values
