! SPDX-License-Identifier: GPL-3.0-or-later
!> Stiffness of every element from the parameters, and its derivatives.
!>
!> The energy is linear in the stiffness of the elements, so the derivative of the gradient with
!> respect to a parameter is the gradient evaluated with the derivatives of the stiffness.
!>
!> A hinge between half-segments of lengths l1/2 and l2/2 has the stiffness 1/(l1/(2 E1 I1) +
!> l2/(2 E2 I2)): EI/l inside a uniform vein, 2EI/l at the clamped root, I = pi d^4/64. Effects multiply
!> what the usual parameters give, each by its own factor; those of their own derivatives are in
!> solid_stiffness_effects.
module solid_stiffness
  use base_constants, only: PI
  use base_kinds, only: rp
  use solid_effect_damage, only: damage_weight
  use solid_effect_gradient, only: gradient_factor
  use solid_effect_hardening, only: hardening_of
  use solid_extension, only: extensions_t, SPRING_VEIN, SPRING_MEMBRANE, SPRING_CROSS
  use solid_junctions, only: hinge_plan_t
  use solid_layout, only: layout_t
  use solid_params, only: solid_params_t, N_COMMON, PARAM_YOUNG, PARAM_PLATE, PARAM_THICKNESS, PARAM_ROOT, &
                          PARAM_EXPONENT, PARAM_K_VEIN, PARAM_K_MEMBRANE, PARAM_K_CROSS
  implicit none
  private
  public :: stiffness_t, allocate_stiffness, clear_stiffness, evaluate_stiffness, differentiate_usual, &
            bending_stiffness, has_own_stiffness, apply_effects

  !> One number for every element, and a second one for hinges that are not linear.
  type :: stiffness_t
    real(rp), allocatable :: extension(:) !< [N/m]
    real(rp), allocatable :: hinge(:)     !< [N m/rad]
    real(rp), allocatable :: cubic(:)     !< [N m/rad^3] of hinges; 0: linear
    real(rp), allocatable :: lift(:)      !< [N m/rad] what hinges have more when they bend up
    real(rp) :: plate = 0                 !< [N m]
    real(rp), allocatable :: edge(:)      !< (edges) [N m] what the plate has more at single edges
    logical :: has_edges = .false.        !< any of them is not 0
    real(rp), allocatable :: tension(:)   !< (springs) [N] of springs that have their length of the unloaded wing
    real(rp), allocatable :: arch(:)      !< (edges) [N m] moment that bends edges: see solid_effect_camber
    real(rp), allocatable :: bow(:)       !< (hinges) [N m] moment that bends them upward
    real(rp), allocatable :: twist(:)     !< (hinges) [N m/rad] see solid_effect_torsion
    logical :: has_tension = .false., has_arch = .false., has_twist = .false. !< any of them is not 0
  end type stiffness_t

contains

  !> Room for the elements of a model; all stiffness is 0.
  pure subroutine allocate_stiffness(springs, plans, n_edges, self)
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    integer, intent(in) :: n_edges
    type(stiffness_t), intent(out) :: self
    allocate (self%extension(springs%n), self%hinge(size(plans)), self%cubic(size(plans)), self%lift(size(plans)), &
              self%edge(n_edges), self%tension(springs%n), self%arch(n_edges), self%twist(size(plans)), &
              self%bow(size(plans)), source=0.0_rp)
  end subroutine allocate_stiffness

  !> All stiffness 0.
  pure subroutine clear_stiffness(self)
    type(stiffness_t), intent(inout) :: self
    self%extension = 0
    self%hinge = 0
    self%cubic = 0
    self%lift = 0
    self%plate = 0
    self%edge = 0
    self%has_edges = .false.
    self%tension = 0
    self%arch = 0
    self%bow = 0
    self%twist = 0
    self%has_tension = .false.
    self%has_arch = .false.
    self%has_twist = .false.
  end subroutine clear_stiffness

  !> Stiffness of all elements.
  pure subroutine evaluate_stiffness(params, springs, plans, layout, self)
    type(solid_params_t), intent(in) :: params
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    type(layout_t), intent(in) :: layout
    type(stiffness_t), intent(inout) :: self
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
    do h = 1, size(plans)
      self%hinge(h) = bending_stiffness(params, plans(h), layout%mean_diameter)
      if (has_own_stiffness(params, plans(h))) self%hinge(h) = params%joint(plans(h)%joint)
    end do
    self%plate = params%plate
    self%has_tension = abs(params%effects%pretension) > 0
    self%tension = params%effects%pretension*layout%spring_width
    call apply_effects(params, springs, plans, layout, self)
  end subroutine evaluate_stiffness

  !> From the stiffness that the usual parameters give, or its derivative with respect to one of them, to that with all
  !> effects, or its derivative.
  pure subroutine apply_effects(params, springs, plans, layout, self)
    type(solid_params_t), intent(in) :: params
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    type(layout_t), intent(in) :: layout
    type(stiffness_t), intent(inout) :: self
    real(rp) :: lost
    integer :: h, s, e
    associate (effects => params%effects)
      if (layout%soft_hinge > 0) self%hinge(layout%soft_hinge) = effects%soft*self%hinge(layout%soft_hinge)
      if (abs(effects%orthotropy) > 0) then
        do s = 1, springs%n
          if (springs%family(s) == SPRING_MEMBRANE) &
            self%extension(s) = self%extension(s)*(1 + effects%orthotropy*layout%spring_cosine(s))
        end do
      end if
      self%edge = 0
      self%has_edges = effects%has_damage() .and. abs(effects%damage - 1) > 0
      if (self%has_edges) then
        lost = effects%damage - 1
        do s = 1, springs%n
          self%extension(s) = self%extension(s)*(1 + lost*damage_weight(effects%disc, layout%spring_place(:, s)))
        end do
        do h = 1, size(plans)
          self%hinge(h) = self%hinge(h)*(1 + lost*damage_weight(effects%disc, layout%hinge_place(:, h)))
        end do
        do e = 1, size(self%edge)
          self%edge(e) = self%plate*lost*(damage_weight(effects%disc, layout%edge_place(:, 1, e)) + &
                                          damage_weight(effects%disc, layout%edge_place(:, 2, e)))/2
        end do
      end if
      do h = 1, size(plans)
        self%cubic(h) = self%hinge(h)*hardening_of(effects, plans(h))
        self%lift(h) = 0
        if (effects%has_sides .and. plans(h)%joint > 0) &
          self%lift(h) = self%hinge(h)*(effects%one_way(plans(h)%joint) - 1)
      end do
      self%arch = 0
      self%bow = 0
      self%twist = 0
      self%has_arch = any(abs(effects%camber) > 0)
      if (self%has_arch) then
        self%arch = (self%plate + self%edge)*matmul(effects%camber, layout%edge_bend)
        self%bow = self%hinge*matmul(effects%camber, layout%hinge_turn)
      end if
      self%has_twist = abs(effects%torsion) > 0
      if (self%has_twist) self%twist = effects%torsion*self%hinge
    end associate
    if (.not. abs(params%bending_factor - 1) > 0) return
    self%hinge = params%bending_factor*self%hinge
    self%cubic = params%bending_factor*self%cubic
    self%lift = params%bending_factor*self%lift
    self%plate = params%bending_factor*self%plate
    self%edge = params%bending_factor*self%edge
    self%arch = params%bending_factor*self%arch
    self%bow = params%bending_factor*self%bow
    self%twist = params%bending_factor*self%twist
  end subroutine apply_effects

  !> Derivatives of all stiffnesses with respect to parameter `number` of the usual model, per unit of the parameter
  !> or, with `per_log`, per unit of its logarithm.
  pure subroutine differentiate_usual(params, springs, plans, layout, number, per_log, self)
    type(solid_params_t), intent(in) :: params
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    type(layout_t), intent(in) :: layout
    integer, intent(in) :: number
    logical, intent(in) :: per_log
    type(stiffness_t), intent(inout) :: self
    real(rp) :: k, share(2)
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
      do h = 1, size(plans)
        if (has_own_stiffness(params, plans(h))) then
          if (plans(h)%joint == joint) self%hinge(h) = params%joint(joint)
          cycle
        end if
        k = bending_stiffness(params, plans(h), layout%mean_diameter)
        share = compliances(params, plans(h), layout%mean_diameter)
        share = share/sum(share)
        if (number == PARAM_YOUNG) then
          self%hinge(h) = k
        else if (number == PARAM_ROOT) then
          if (plans(h)%is_root) self%hinge(h) = k
        else if (number == PARAM_EXPONENT) then
          where (share > 0) share = share*log(plans(h)%diameters/layout%mean_diameter)
          self%hinge(h) = k*sum(share)*params%diameter_exponent
        else if (vein <= n_veins) then
          self%hinge(h) = k*sum(share, mask=plans(h)%veins == vein)
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
  end subroutine differentiate_usual

  !> Whether a joint overrides the stiffness of the hinge.
  pure logical function has_own_stiffness(params, plan) result(has)
    type(solid_params_t), intent(in) :: params
    type(hinge_plan_t), intent(in) :: plan
    has = .false.
    if (plan%joint > 0) has = params%joint(plan%joint) >= 0
  end function has_own_stiffness

  !> Stiffness [N m/rad] of a hinge that no joint overrides; `mean_diameter` [m] is the reference of the diameters'
  !> exponent.
  pure real(rp) function bending_stiffness(params, plan, mean_diameter) result(k)
    type(solid_params_t), intent(in) :: params
    type(hinge_plan_t), intent(in) :: plan
    real(rp), intent(in) :: mean_diameter
    k = 1/sum(compliances(params, plan, mean_diameter))
    if (plan%is_root) k = k*params%root_factor
  end function bending_stiffness

  pure function compliances(params, plan, mean_diameter) result(c)
    type(solid_params_t), intent(in) :: params
    type(hinge_plan_t), intent(in) :: plan
    real(rp), intent(in) :: mean_diameter
    real(rp) :: c(2), area_moment(2)
    area_moment = PI/64*mean_diameter**4*(plan%diameters/mean_diameter)**params%diameter_exponent
    c = plan%lengths/(2*params%young*params%vein_factor(plan%veins)*area_moment)
    c = c/gradient_factor(params%effects%gradient, plan%station)
  end function compliances
end module solid_stiffness
