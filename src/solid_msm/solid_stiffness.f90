! SPDX-License-Identifier: GPL-3.0-or-later
!> Stiffness of every element from the parameters, and its derivatives.
!>
!> The energy is linear in the stiffness of the elements, so the derivative of the gradient with
!> respect to a parameter is the gradient evaluated with the derivatives of the stiffness.
!>
!> A hinge between half-segments of lengths l1/2 and l2/2 has the stiffness 1/(l1/(2 E1 I1) +
!> l2/(2 E2 I2)): EI/l inside a uniform vein, 2EI/l at the clamped root, I = pi d^4/64.
module solid_stiffness
  use base_constants, only: PI
  use base_kinds, only: rp
  use solid_extension, only: extensions_t, SPRING_VEIN, SPRING_MEMBRANE, SPRING_CROSS
  use solid_junctions, only: hinge_plan_t
  use solid_params, only: solid_params_t, N_COMMON, PARAM_YOUNG, PARAM_PLATE, PARAM_THICKNESS, PARAM_ROOT, &
                          PARAM_EXPONENT, PARAM_K_VEIN, PARAM_K_MEMBRANE, PARAM_K_CROSS
  implicit none
  private
  public :: stiffness_t, allocate_stiffness, evaluate_stiffness, differentiate_stiffness, bending_stiffness

  !> One number for every element.
  type :: stiffness_t
    real(rp), allocatable :: extension(:) !< [N/m]
    real(rp), allocatable :: hinge(:)     !< [N m/rad]
    real(rp) :: plate = 0                 !< [N m]
  end type stiffness_t

contains

  !> Room for the elements of a model.
  pure subroutine allocate_stiffness(springs, plans, self)
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    type(stiffness_t), intent(out) :: self
    allocate (self%extension(springs%n), self%hinge(size(plans)), source=0.0_rp)
  end subroutine allocate_stiffness

  !> Stiffness of all elements; `mean_diameter` [m] is the reference of the diameters' exponent.
  pure subroutine evaluate_stiffness(params, springs, plans, mean_diameter, self)
    type(solid_params_t), intent(in) :: params
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    real(rp), intent(in) :: mean_diameter
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
      self%hinge(h) = bending_stiffness(params, plans(h), mean_diameter)
      if (plans(h)%joint > 0) then
        if (params%joint(plans(h)%joint) >= 0) self%hinge(h) = params%joint(plans(h)%joint)
      end if
    end do
    self%plate = params%plate
  end subroutine evaluate_stiffness

  !> Derivatives of all stiffnesses with respect to parameter `number`, per unit of the parameter or,
  !> with `per_log`, per unit of its logarithm.
  pure subroutine differentiate_stiffness(params, springs, plans, mean_diameter, number, per_log, self)
    type(solid_params_t), intent(in) :: params
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    real(rp), intent(in) :: mean_diameter
    integer, intent(in) :: number
    logical, intent(in) :: per_log
    type(stiffness_t), intent(inout) :: self
    real(rp) :: k, share(2)
    integer :: h, n_veins, vein, joint
    n_veins = size(params%vein_factor)
    self%extension = 0
    self%hinge = 0
    self%plate = 0
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
        if (plans(h)%joint > 0) then
          if (params%joint(plans(h)%joint) >= 0) then
            if (plans(h)%joint == joint) self%hinge(h) = params%joint(joint)
            cycle
          end if
        end if
        k = bending_stiffness(params, plans(h), mean_diameter)
        share = compliances(params, plans(h), mean_diameter)
        share = share/sum(share)
        if (number == PARAM_YOUNG) then
          self%hinge(h) = k
        else if (number == PARAM_ROOT) then
          if (plans(h)%is_root) self%hinge(h) = k
        else if (number == PARAM_EXPONENT) then
          where (share > 0) share = share*log(plans(h)%diameters/mean_diameter)
          self%hinge(h) = k*sum(share)*params%diameter_exponent
        else if (vein <= n_veins) then
          self%hinge(h) = k*sum(share, mask=plans(h)%veins == vein)
        end if
      end do
    end select
    if (per_log) return
    k = 1/params%get(number)
    self%extension = self%extension*k
    self%hinge = self%hinge*k
    self%plate = self%plate*k
  end subroutine differentiate_stiffness

  !> Stiffness [N m/rad] of a hinge that no joint overrides.
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
  end function compliances
end module solid_stiffness
