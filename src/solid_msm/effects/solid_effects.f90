! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists the effects of a wing: deviations from the basic model, as parameters with a null value at which they have no effect.
!>
!> `list_effects` is the list of all effects; a new effect needs a line there. The order is that of the parameters, so that files
!> of older runs stay valid: parameters of the whole wing first, then those of each joint.
module solid_effects
  use base_cause, only: cause_t, enlist, make_cause
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: define_effect, parameter_t
  use solid_effect, only: effect_t, effect_text_t, NEED_DISC, NEED_NOTHING, NEED_SIDED_JOINTS, NEED_SIDED_VEINS, &
                          NEED_SOFT_PLACE
  use solid_effect_camber, only: camber_effect
  use solid_effect_damage, only: damage_effect
  use solid_effect_gradient, only: gradient_effect
  use solid_effect_hardening, only: cuticle_effect, joint_hardening_effect, own_hardening_effect
  use solid_effect_one_way, only: one_way_effect
  use solid_effect_orthotropy, only: orthotropy_effect
  use solid_effect_pretension, only: pretension_effect
  use solid_effect_root, only: root_effect
  use solid_effect_soft, only: soft_effect
  use solid_effect_torsion, only: torsion_effect
  use solid_effect_values, only: effects_t
  use solid_junctions, only: hinge_plan_t
  implicit none
  private
  public :: effects_t, list_effects, start_effects, describe_effect, find_effect, values_of, is_active, needs_of, lacks, &
            curves_rest, any_curves_rest, clamp_axis, clamp_compliance, modulus_factors, list_effect_causes

contains

  !> Returns all effects, in the order of their parameters.
  pure function list_effects() result(list)
    type(effect_t), allocatable :: list(:)
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
            own_hardening_effect(), &
            one_way_effect()]
  end function list_effects

  !> Returns the values of the effects of a wing with this number of joints, at which no effect acts.
  subroutine start_effects(n_joints, effects)
    integer, intent(in) :: n_joints
    type(effects_t), intent(inout) :: effects
    type(effect_t), allocatable :: list(:)
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
        effects%value(n) = null_of(list(e), k)
      end do
    end do
  end subroutine start_effects

  !> Returns the number of values of an effect of a wing with this number of joints.
  pure integer function count_values(effect, n_joints) result(n)
    type(effect_t), intent(in) :: effect
    integer, intent(in) :: n_joints
    n = merge(n_joints, effect%n, effect%is_per_joint)
  end function count_values

  !> Returns the null of value k of an effect.
  pure real(rp) function null_of(effect, k) result(null)
    type(effect_t), intent(in) :: effect
    integer, intent(in) :: k
    null = merge(1.0_rp, 0.0_rp, effect%parameters(merge(1, k, effect%is_per_joint))%is_log)
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

  !> Returns the values of effect e of `list`, in their units.
  pure function values_of(list, e, effects) result(values)
    type(effect_t), intent(in) :: list(:)
    integer, intent(in) :: e
    type(effects_t), intent(in) :: effects
    real(rp), allocatable :: values(:)
    integer :: first, i
    first = 0
    do i = 1, e - 1
      first = first + count_values(list(i), effects%n_joints)
    end do
    values = effects%value(first + 1:first + count_values(list(e), effects%n_joints))
  end function values_of

  !> Tells whether effect e of `list` has a value other than null. All parameters of one effect have the same scale.
  pure logical function is_active(list, e, effects) result(is_it)
    type(effect_t), intent(in) :: list(:)
    integer, intent(in) :: e
    type(effects_t), intent(in) :: effects
    is_it = any(abs(values_of(list, e, effects) - null_of(list(e), 1)) > 0)
  end function is_active

  !> Returns name, unit, scale, bounds, null and prior of parameter i; `joint_names` are those of the wing.
  function describe_effect(i, joint_names) result(p)
    integer, intent(in) :: i
    character(*), intent(in) :: joint_names(:)
    type(parameter_t) :: p
    type(effect_t), allocatable :: list(:)
    integer :: e, k
    list = list_effects()
    call find_effect(list, size(joint_names), i, e, k)
    call require(e > 0, 'describe_effect: no such parameter')
    associate (one => list(e)%parameters(merge(1, k, list(e)%is_per_joint)))
      call define_effect(p, trim(one%name), trim(one%unit), one%is_log, one%lower, one%upper, one%prior_sd)
      p%strong = one%strong
      if (list(e)%is_per_joint) p%name = p%name//trim(joint_names(k))
    end associate
  end function describe_effect

  !> Returns what the effect of parameter i needs of the wing and of the measurement: a list of the constants NEED_* of
  !> solid_effect.
  pure function needs_of(effects, i) result(needs)
    type(effects_t), intent(in) :: effects
    integer, intent(in) :: i
    integer, allocatable :: needs(:)
    type(effect_t), allocatable :: list(:)
    integer :: e, k
    list = list_effects()
    call find_effect(list, effects%n_joints, i, e, k)
    needs = pack(list(e)%needs, list(e)%needs /= NEED_NOTHING)
  end function needs_of

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
    type(effect_t), allocatable :: list(:)
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
    type(effect_t), allocatable :: list(:)
    integer :: e
    list = list_effects()
    does = .false.
    do e = 1, size(list)
      if (list(e)%curves_rest) does = does .or. is_active(list, e, effects)
    end do
  end function any_curves_rest

  !> Returns the axis about which parameter i lets the clamp turn, 1: x, 2: y; 0 if it does not.
  pure integer function clamp_axis(effects, i) result(axis)
    type(effects_t), intent(in) :: effects
    integer, intent(in) :: i
    type(effect_t), allocatable :: list(:)
    integer :: e, k
    axis = 0
    if (i < 1) return
    list = list_effects()
    call find_effect(list, effects%n_joints, i, e, k)
    if (.not. list(e)%is_per_joint) axis = list(e)%parameters(k)%clamp_axis
  end function clamp_axis

  !> Returns by how much the clamp turns about x and y for a moment [rad/(N m)].
  pure function clamp_compliance(effects) result(compliance)
    type(effects_t), intent(in) :: effects
    real(rp) :: compliance(2)
    type(effect_t), allocatable :: list(:)
    real(rp), allocatable :: values(:)
    integer :: e, k
    list = list_effects()
    compliance = 0
    do e = 1, size(list)
      if (all(list(e)%parameters%clamp_axis == 0)) cycle
      values = values_of(list, e, effects)
      do k = 1, list(e)%n
        associate (axis => list(e)%parameters(k)%clamp_axis)
          if (axis > 0) compliance(axis) = compliance(axis) + values(k)
        end associate
      end do
    end do
  end function clamp_compliance

  !> Returns the factors (hinges) by which the effects multiply E of the veins; exactly 1 where no effect changes it.
  pure function modulus_factors(effects, plans) result(factor)
    type(effects_t), intent(in) :: effects
    type(hinge_plan_t), intent(in) :: plans(:)
    real(rp) :: factor(size(plans))
    type(effect_t), allocatable :: list(:)
    real(rp), allocatable :: values(:)
    integer :: e, h
    list = list_effects()
    factor = 1
    do e = 1, size(list)
      if (.not. associated(list(e)%modulus)) cycle
      values = values_of(list, e, effects)
      do h = 1, size(plans)
        factor(h) = factor(h)*list(e)%modulus(values(1), plans(h))
      end do
    end do
  end function modulus_factors

  !> Returns the causes of the diagnosis that correspond to the effects, in the order of the list. Their parameters have no numbers,
  !> because these depend on the wing.
  pure function list_effect_causes() result(causes)
    type(cause_t), allocatable :: causes(:)
    type(effect_t), allocatable :: list(:)
    integer :: e
    list = list_effects()
    do e = 1, size(list)
      call enlist(causes, cause_of(list(e)))
    end do
  end function list_effect_causes

  !> Returns the cause that corresponds to an effect.
  pure function cause_of(effect) result(cause)
    type(effect_t), intent(in) :: effect
    type(cause_t) :: cause
    type(effect_text_t) :: text
    type(parameter_t) :: p
    integer :: k
    call effect%tell(text)
    cause = make_cause(text%cause, text%title, text%sentence, text%data)
    cause%place = effect%place
    cause%needs = pack(effect%needs, effect%needs /= NEED_NOTHING)
    cause%is_joint = .not. effect%is_per_joint
    do k = 1, effect%n
      associate (one => effect%parameters(k))
        call define_effect(p, trim(one%name), trim(one%unit), one%is_log, one%lower, one%upper, one%prior_sd)
        p%strong = one%strong
      end associate
      call cause%add(0, p)
      cause%parameters(k)%words = text%words(k)
      cause%parameters(k)%beyond = text%beyond(k)
      cause%parameters(k)%far = text%far(k)
    end do
  end function cause_of
end module solid_effects
