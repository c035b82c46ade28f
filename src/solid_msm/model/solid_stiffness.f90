! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the stiffness of every element from the parameters, and its derivatives.
!>
!> The energy is linear in the stiffness of the elements, so the derivative of the gradient with
!> respect to a parameter is the gradient evaluated with the derivatives of the stiffness.
!>
!> A hinge between half-segments of lengths l1/2 and l2/2 has the stiffness 1/(l1/(2 E1 I1) + l2/(2 E2 I2)): EI/l inside a uniform
!> vein, 2EI/l at the clamped root, I = pi d^4/64. Each effect multiplies the stiffness of the usual parameters by its own factor.
!> Derivatives with respect to effects are in solid_stiffness_effects.
module solid_stiffness
  use base_constants, only: PI
  use base_kinds, only: rp
  use solid_effect, only: effect_site_t, effect_t, STAGE_ELEMENTS, STAGE_LOADS, STAGE_MOMENTS
  use solid_effects, only: is_active, list_effects, modulus_factors, values_of, N_EFFECTS
  use solid_element_stiffness, only: allocate_stiffness, clear_stiffness, stiffness_t
  use solid_extension, only: extensions_t, SPRING_VEIN, SPRING_MEMBRANE, SPRING_CROSS
  use solid_junctions, only: hinge_plan_t
  use solid_layout, only: layout_t
  use solid_params, only: solid_params_t
  use solid_usual_causes, only: N_COMMON, PARAM_YOUNG, PARAM_PLATE, PARAM_THICKNESS, PARAM_ROOT, PARAM_EXPONENT, PARAM_K_VEIN, &
                                PARAM_K_MEMBRANE, PARAM_K_CROSS
  implicit none
  private
  public :: stiffness_t, allocate_stiffness, clear_stiffness, evaluate_stiffness, differentiate_basic, &
            bending_stiffness, has_own_stiffness, apply_effects

contains

  !> Computes the stiffness of all elements from the parameters, with all effects.
  subroutine evaluate_stiffness(params, springs, plans, layout, self)
    type(solid_params_t), intent(in) :: params
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    type(layout_t), intent(in) :: layout
    type(stiffness_t), intent(inout) :: self
    real(rp) :: modulus(size(plans))
    integer :: h, s
    do s = 1, springs%n
      select case (springs%family(s))
      case (SPRING_VEIN)
        self%extension(s) = params%k_vein
      case (SPRING_MEMBRANE)
        self%extension(s) = params%k_membrane
      case default
        self%extension(s) = params%k_cross
      end select
    end do
    modulus = modulus_factors(params%effects, plans)
    do h = 1, size(plans)
      self%hinge(h) = bending_stiffness(params, plans(h), layout%mean_diameter, modulus(h))
      if (has_own_stiffness(params, plans(h))) self%hinge(h) = params%joint(plans(h)%joint)
    end do
    self%plate = params%plate
    self%tension = 0
    self%has_tension = .false.
    call apply_stage(STAGE_LOADS, params, springs, plans, layout, self)
    call apply_effects(params, springs, plans, layout, self)
  end subroutine evaluate_stiffness

  !> Applies all effects to the stiffness that the usual parameters give, or to its derivative with respect to one of them.
  subroutine apply_effects(params, springs, plans, layout, self)
    type(solid_params_t), intent(in) :: params
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    type(layout_t), intent(in) :: layout
    type(stiffness_t), intent(inout) :: self
    integer :: stage
    self%hardening = 0
    self%lift = 0
    self%edge = 0
    self%has_edges = .false.
    self%arch = 0
    self%camber_moment = 0
    self%twist = 0
    self%has_arch = .false.
    self%has_twist = .false.
    do stage = STAGE_ELEMENTS, STAGE_MOMENTS
      call apply_stage(stage, params, springs, plans, layout, self)
    end do
    self%cubic = self%hinge*self%hardening
    if (.not. abs(params%bending_factor - 1) > 0) return
    self%hinge = params%bending_factor*self%hinge
    self%cubic = params%bending_factor*self%cubic
    self%lift = params%bending_factor*self%lift
    self%plate = params%bending_factor*self%plate
    self%edge = params%bending_factor*self%edge
    self%arch = params%bending_factor*self%arch
    self%camber_moment = params%bending_factor*self%camber_moment
    self%twist = params%bending_factor*self%twist
  end subroutine apply_effects

  !> Applies the active effects of one stage.
  subroutine apply_stage(stage, params, springs, plans, layout, self)
    integer, intent(in) :: stage
    type(solid_params_t), intent(in), target :: params
    type(extensions_t), intent(in), target :: springs
    type(hinge_plan_t), intent(in), target :: plans(:)
    type(layout_t), intent(in), target :: layout
    type(stiffness_t), intent(inout) :: self
    type(effect_t) :: list(N_EFFECTS)
    type(effect_site_t) :: site
    integer :: e
    list = list_effects()
    site%effects => params%effects
    site%springs => springs
    site%plans => plans
    site%layout => layout
    do e = 1, size(list)
      if (list(e)%stage /= stage) cycle
      if (.not. is_active(list, e, params%effects)) cycle
      site%values = values_of(list, e, params%effects)
      call list(e)%apply(site, self)
    end do
  end subroutine apply_stage

  !> Computes the derivatives of all stiffnesses with respect to parameter `number` of the usual model, per unit of the parameter
  !> or, with `per_log`, per unit of its logarithm.
  subroutine differentiate_basic(params, springs, plans, layout, number, per_log, self)
    type(solid_params_t), intent(in) :: params
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    type(layout_t), intent(in) :: layout
    integer, intent(in) :: number
    logical, intent(in) :: per_log
    type(stiffness_t), intent(inout) :: self
    real(rp) :: k, fraction(2), modulus(size(plans))
    integer :: h, n_veins, vein, joint
    n_veins = size(params%vein_factor)
    call clear_stiffness(self)
    vein = number - N_COMMON
    joint = number - N_COMMON - n_veins
    select case (number)
    case (PARAM_PLATE)
      self%plate = params%plate
    case (PARAM_THICKNESS)
      self%plate = 3*params%plate
    case (PARAM_K_VEIN)
      where (springs%family == SPRING_VEIN) self%extension = params%k_vein
    case (PARAM_K_MEMBRANE)
      where (springs%family == SPRING_MEMBRANE) self%extension = params%k_membrane
    case (PARAM_K_CROSS)
      where (springs%family == SPRING_CROSS) self%extension = params%k_cross
    case default
      modulus = modulus_factors(params%effects, plans)
      do h = 1, size(plans)
        if (has_own_stiffness(params, plans(h))) then
          if (plans(h)%joint == joint) self%hinge(h) = params%joint(joint)
          cycle
        end if
        k = bending_stiffness(params, plans(h), layout%mean_diameter, modulus(h))
        fraction = compliances(params, plans(h), layout%mean_diameter, modulus(h))
        fraction = fraction/sum(fraction)
        if (number == PARAM_YOUNG) then
          self%hinge(h) = k
        else if (number == PARAM_ROOT) then
          if (plans(h)%is_root) self%hinge(h) = k
        else if (number == PARAM_EXPONENT) then
          where (fraction > 0) fraction = fraction*log(plans(h)%diameters/layout%mean_diameter)
          self%hinge(h) = k*sum(fraction)*params%diameter_exponent
        else if (vein <= n_veins) then
          self%hinge(h) = k*sum(fraction, mask=plans(h)%veins == vein)
        end if
      end do
    end select
    if (.not. per_log) then
      k = 1/params%get(number)
      self%extension = self%extension*k
      self%hinge = self%hinge*k
      self%plate = self%plate*k
    end if
    call apply_effects(params, springs, plans, layout, self)
  end subroutine differentiate_basic

  !> Tells whether a joint overrides the stiffness of the hinge.
  pure logical function has_own_stiffness(params, plan) result(has)
    type(solid_params_t), intent(in) :: params
    type(hinge_plan_t), intent(in) :: plan
    has = .false.
    if (plan%joint > 0) has = params%joint(plan%joint) >= 0
  end function has_own_stiffness

  !> Returns the stiffness [N m/rad] of a hinge that no joint overrides. `mean_diameter` [m] is the reference for the exponent of
  !> the diameters, `modulus` the factor of the effects on E.
  pure real(rp) function bending_stiffness(params, plan, mean_diameter, modulus) result(k)
    type(solid_params_t), intent(in) :: params
    type(hinge_plan_t), intent(in) :: plan
    real(rp), intent(in) :: mean_diameter, modulus
    k = 1/sum(compliances(params, plan, mean_diameter, modulus))
    if (plan%is_root) k = k*params%root_factor
  end function bending_stiffness

  !> Returns the compliances [rad/(N m)] of the two halves of a hinge.
  pure function compliances(params, plan, mean_diameter, modulus) result(c)
    type(solid_params_t), intent(in) :: params
    type(hinge_plan_t), intent(in) :: plan
    real(rp), intent(in) :: mean_diameter, modulus
    real(rp) :: c(2), area_moment(2)
    area_moment = PI/64*mean_diameter**4*(plan%diameters/mean_diameter)**params%diameter_exponent
    c = plan%lengths/(2*params%young*params%vein_factor(plan%veins)*area_moment)
    c = c/modulus
  end function compliances
end module solid_stiffness
