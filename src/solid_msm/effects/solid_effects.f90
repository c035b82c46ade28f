! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists the effects of a wing: deviations from the basic model, as parameters with a null value at which they have no effect.
!>
!> `list_effects` is the list of all effects; a new effect needs a line there, and raises N_EFFECTS. The order is that of the
!> parameters, so that files of older runs stay valid: parameters of the whole wing first, then those of each joint. Every
!> evaluation of a wing makes this list, and allocates nothing for it. The causes with all texts are made for reports and settings.
module solid_effects
  use base_cause, only: cause_t, enlist
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use solid_effect, only: effect_t, NEED_DISC, NEED_SIDED_JOINTS, NEED_SIDED_VEINS, NEED_SOFT_PLACE
  use solid_effect_camber, only: camber_effect
  use solid_effect_cuticle, only: cuticle_effect
  use solid_effect_damage, only: damage_effect
  use solid_effect_gradient, only: gradient_effect
  use solid_effect_joint_hardening, only: joint_hardening_effect
  use solid_effect_one_way, only: one_way_effect
  use solid_effect_orthotropy, only: orthotropy_effect
  use solid_effect_own_hardening, only: own_hardening_effect
  use solid_effect_pretension, only: pretension_effect
  use solid_effect_root, only: root_effect
  use solid_effect_soft, only: soft_effect
  use solid_effect_thickness, only: thickness_effect
  use solid_effect_torsion, only: torsion_effect
  use solid_effect_values, only: effects_t
  use solid_junctions, only: hinge_plan_t
  implicit none
  private
  public :: effects_t, list_effects, start_effects, describe_effect, find_effect, values_of, is_active, needs_of, active_needs, &
            lacks, curves_rest, any_curves_rest, clamp_axis, clamp_compliance, is_thickness, modulus_factors, list_effect_causes

  integer, parameter, public :: N_EFFECTS = 13

contains

  !> Returns all effects, in the order of their parameters.
  pure function list_effects() result(list)
    type(effect_t) :: list(N_EFFECTS)
    list = [gradient_effect(), &
            damage_effect(), &
            soft_effect(), &
            orthotropy_effect(), &
            joint_hardening_effect(), &
            cuticle_effect(), &
            root_effect(), &
            pretension_effect(), &
            camber_effect(), &
            torsion_effect(), &
            thickness_effect(), &
            own_hardening_effect(), &
            one_way_effect()]
  end function list_effects

  !> Returns the values of the effects of a wing with this number of joints, at which no effect acts.
  subroutine start_effects(n_joints, effects)
    integer, intent(in) :: n_joints
    type(effects_t), intent(inout) :: effects
    type(effect_t) :: list(N_EFFECTS)
    integer :: e, k, n
    list = list_effects()
    effects%n_joints = n_joints
    n = 0
    do e = 1, size(list)
      n = n + count_values(list(e), n_joints)
    end do
    if (allocated(effects%value)) deallocate (effects%value)
    allocate (effects%value(n))
    n = 0
    do e = 1, size(list)
      do k = 1, count_values(list(e), n_joints)
        n = n + 1
        effects%value(n) = null_of(list(e))
      end do
    end do
  end subroutine start_effects

  !> Returns the number of values of an effect of a wing with this number of joints.
  pure integer function count_values(effect, n_joints) result(n)
    type(effect_t), intent(in) :: effect
    integer, intent(in) :: n_joints
    n = merge(n_joints, effect%n, effect%is_per_joint)
  end function count_values

  !> Returns the value of the parameters of an effect at which it does nothing.
  pure real(rp) function null_of(effect) result(null)
    type(effect_t), intent(in) :: effect
    null = merge(1.0_rp, 0.0_rp, effect%is_log)
  end function null_of

  !> Finds the effect that has parameter i of a wing with this number of joints: its number in `list`, and the number k among its
  !> own parameters.
  pure subroutine find_effect(list, n_joints, i, e, k)
    type(effect_t), intent(in) :: list(:)
    integer, intent(in) :: n_joints, i
    integer, intent(out) :: e, k
    k = i
    do e = 1, size(list)
      if (k <= count_values(list(e), n_joints)) return
      k = k - count_values(list(e), n_joints)
    end do
    e = 0
  end subroutine find_effect

  !> Returns the number of the values of a wing that precede those of effect e of `list`.
  pure integer function count_before(list, e, n_joints) result(n)
    type(effect_t), intent(in) :: list(:)
    integer, intent(in) :: e, n_joints
    integer :: i
    n = 0
    do i = 1, e - 1
      n = n + count_values(list(i), n_joints)
    end do
  end function count_before

  !> Returns the values of effect e of `list`, in their units.
  pure function values_of(list, e, effects) result(values)
    type(effect_t), intent(in) :: list(:)
    integer, intent(in) :: e
    type(effects_t), intent(in) :: effects
    real(rp), allocatable :: values(:)
    integer :: before
    before = count_before(list, e, effects%n_joints)
    values = effects%value(before + 1:before + count_values(list(e), effects%n_joints))
  end function values_of

  !> Tells whether effect e of `list` has a value other than null.
  pure logical function is_active(list, e, effects) result(is_it)
    type(effect_t), intent(in) :: list(:)
    integer, intent(in) :: e
    type(effects_t), intent(in) :: effects
    integer :: before
    before = count_before(list, e, effects%n_joints)
    is_it = any(abs(effects%value(before + 1:before + count_values(list(e), effects%n_joints)) - null_of(list(e))) > 0)
  end function is_active

  !> Returns name, unit, scale, bounds, null and prior of parameter i; `joint_names` are those of the wing.
  function describe_effect(i, joint_names) result(p)
    integer, intent(in) :: i
    character(*), intent(in) :: joint_names(:)
    type(parameter_t) :: p
    type(effect_t) :: list(N_EFFECTS)
    type(cause_t) :: cause
    integer :: e, k
    list = list_effects()
    call find_effect(list, size(joint_names), i, e, k)
    call require(e > 0, 'describe_effect: no such parameter')
    call list(e)%tell(cause)
    if (list(e)%is_per_joint) then
      p = cause%parameters(1)%value
      p%name = p%name//trim(joint_names(k))
    else
      p = cause%parameters(k)%value
    end if
  end function describe_effect

  !> Returns what the effect of parameter i needs of the wing and of the measurement: a list of the constants NEED_* of
  !> solid_effect.
  pure function needs_of(effects, i) result(needs)
    type(effects_t), intent(in) :: effects
    integer, intent(in) :: i
    integer, allocatable :: needs(:)
    type(effect_t) :: list(N_EFFECTS)
    type(cause_t) :: cause
    integer :: e, k
    list = list_effects()
    call find_effect(list, effects%n_joints, i, e, k)
    call list(e)%tell(cause)
    needs = cause%needs
  end function needs_of

  !> Returns what all effects need whose values are not null: a list of constants NEED_*, some maybe more than once.
  pure function active_needs(effects) result(needs)
    type(effects_t), intent(in) :: effects
    integer, allocatable :: needs(:)
    type(effect_t) :: list(N_EFFECTS)
    type(cause_t) :: cause
    integer :: e
    list = list_effects()
    allocate (needs(0))
    do e = 1, size(list)
      if (.not. is_active(list, e, effects)) cycle
      call list(e)%tell(cause)
      needs = [needs, cause%needs]
    end do
  end function active_needs

  !> Returns what is missing in [Wing] for a need that keys of [Wing] fulfil, as words that follow the name of a parameter; empty if
  !> nothing is missing.
  function lacks(effects, need) result(problem)
    type(effects_t), intent(in) :: effects
    integer, intent(in) :: need
    character(:), allocatable :: problem
    problem = ''
    select case (need)
    case (NEED_DISC)
      if (.not. effects%has_damage()) problem = 'needs a disc: [Wing] damage_disc'
    case (NEED_SOFT_PLACE)
      if (.not. allocated(effects%soft_vein)) problem = 'needs a place: [Wing] soft_place'
    case (NEED_SIDED_JOINTS)
      if (.not. effects%has_sides) problem = 'needs [Wing] sided_joints = yes'
    case (NEED_SIDED_VEINS)
      if (.not. effects%has_sided_veins) problem = 'needs [Wing] sided_veins = yes'
    end select
  end function lacks

  !> Tells whether parameter i bends the wing without a load.
  pure logical function curves_rest(effects, i) result(does)
    type(effects_t), intent(in) :: effects
    integer, intent(in) :: i
    type(effect_t) :: list(N_EFFECTS)
    integer :: e, k
    does = .false.
    if (i < 1) return
    list = list_effects()
    call find_effect(list, effects%n_joints, i, e, k)
    does = list(e)%curves_rest
  end function curves_rest

  !> Tells whether the effects bend the wing without a load.
  pure logical function any_curves_rest(effects) result(does)
    type(effects_t), intent(in) :: effects
    type(effect_t) :: list(N_EFFECTS)
    integer :: e
    list = list_effects()
    does = .false.
    do e = 1, size(list)
      if (list(e)%curves_rest) does = does .or. is_active(list, e, effects)
    end do
  end function any_curves_rest

  !> Tells whether the mass of the membrane follows parameter i.
  pure logical function is_thickness(effects, i) result(is_it)
    type(effects_t), intent(in) :: effects
    integer, intent(in) :: i
    type(effect_t) :: list(N_EFFECTS)
    integer :: e, k
    is_it = .false.
    if (i < 1) return
    list = list_effects()
    call find_effect(list, effects%n_joints, i, e, k)
    is_it = list(e)%is_thickness
  end function is_thickness

  !> Returns the axis about which parameter i lets the clamp turn, 1: x, 2: y; 0 if it does not.
  pure integer function clamp_axis(effects, i) result(axis)
    type(effects_t), intent(in) :: effects
    integer, intent(in) :: i
    type(effect_t) :: list(N_EFFECTS)
    integer :: e, k
    axis = 0
    if (i < 1) return
    list = list_effects()
    call find_effect(list, effects%n_joints, i, e, k)
    if (.not. list(e)%is_per_joint) axis = list(e)%clamp_axis(k)
  end function clamp_axis

  !> Returns by how much the clamp turns about x and y for a moment [rad/(N m)].
  pure function clamp_compliance(effects) result(compliance)
    type(effects_t), intent(in) :: effects
    real(rp) :: compliance(2)
    type(effect_t) :: list(N_EFFECTS)
    integer :: e, k, before
    list = list_effects()
    compliance = 0
    do e = 1, size(list)
      before = count_before(list, e, effects%n_joints)
      do k = 1, size(list(e)%clamp_axis)
        associate (axis => list(e)%clamp_axis(k))
          if (axis > 0) compliance(axis) = compliance(axis) + effects%value(before + k)
        end associate
      end do
    end do
  end function clamp_compliance

  !> Returns the factors (hinges) by which the effects multiply E of the veins; exactly 1 where no effect changes it.
  pure function modulus_factors(effects, plans) result(factor)
    type(effects_t), intent(in) :: effects
    type(hinge_plan_t), intent(in) :: plans(:)
    real(rp) :: factor(size(plans))
    type(effect_t) :: list(N_EFFECTS)
    real(rp) :: value
    integer :: e, h
    list = list_effects()
    factor = 1
    do e = 1, size(list)
      if (.not. associated(list(e)%modulus)) cycle
      value = effects%value(count_before(list, e, effects%n_joints) + 1)
      do h = 1, size(plans)
        factor(h) = factor(h)*list(e)%modulus(value, plans(h))
      end do
    end do
  end function modulus_factors

  !> Returns the causes of the diagnosis that correspond to the effects, in the order of the list. Their parameters have no numbers,
  !> because these depend on the wing.
  pure function list_effect_causes() result(causes)
    type(cause_t), allocatable :: causes(:)
    type(effect_t) :: list(N_EFFECTS)
    type(cause_t) :: cause
    integer :: e
    list = list_effects()
    do e = 1, size(list)
      call list(e)%tell(cause)
      cause%is_joint = .not. list(e)%is_per_joint
      call enlist(causes, cause)
    end do
  end function list_effect_causes
end module solid_effects
