! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes derivatives of the observations of a moving wing, for natural modes and records alike: with respect to the parameters
!> of its mechanics, and to what an unknown cause may change at a site.
module diagnosis_wing_tangents
  use base_cause, only: parameter_of
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use diagnosis_wing_parameters, only: KIND_BALANCE, KIND_FLIGHT, KIND_MASS, KIND_POINT_MASS
  use diagnosis_wing_rest, only: put_mass_at, wing_rest_t
  use measurement_motion_simulation, only: motion_simulation_t
  use solid_mass_effects, only: list_mass_causes, mass_effects_t, MASS_POINT
  use solid_model, only: solid_model_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: damage_direction
  implicit none
  private
  public :: mechanics_tangent, site_tangents

contains

  !> Returns column(n), the derivative of the residuals of a simulation with respect to parameter i at q, after its evaluation
  !> there. The parameter is one of mass, stiffness or clamp; the column of another one is 0. `effects` are those of the masses at
  !> q, `direction` is work.
  subroutine mechanics_tangent(simulation, rest, effects, q, i, direction, column)
    class(motion_simulation_t), intent(inout) :: simulation
    type(wing_rest_t), intent(in) :: rest
    type(mass_effects_t), intent(in) :: effects
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: i
    type(stiffness_t), intent(inout) :: direction
    real(rp), intent(out) :: column(:)
    type(solid_model_t), pointer :: model
    type(mass_effects_t) :: moved
    logical :: is_any, is_joint
    model => simulation%model()
    column = 0
    associate (one => rest%parameters(i))
      select case (one%kind)
      case (KIND_FLIGHT, KIND_BALANCE) ! only forces of the air depend on them
      case (KIND_MASS)
        call simulation%mass_tangent(one%number, effects, column)
      case (KIND_POINT_MASS)
        moved = effects
        call put_mass_at(rest%bare, one%disc(:2), moved)
        call simulation%mass_tangent(MASS_POINT, moved, column)
      case default
        if (rest%clamp(model, i) > 0) then
          call simulation%clamp_tangent(rest%clamp(model, i), column)
        else
          call rest%direction(model, q, i, direction, is_any, is_joint)
          if (is_any) call simulation%stiffness_tangent(direction, is_joint, column)
        end if
      end select
    end associate
  end subroutine mechanics_tangent

  !> Computes patterns(n, :). The first columns are the effects of unit stiffness around each site(2, :) [m]. Without bending tests
  !> the forces of unknown causes are those of inertia: the next columns are the effects of a mass of the default prior at each
  !> site. Fewer columns ask for fewer patterns. `direction` is work.
  subroutine site_tangents(simulation, rest, effects, site, radius, direction, patterns)
    class(motion_simulation_t), intent(inout) :: simulation
    type(wing_rest_t), intent(in) :: rest
    type(mass_effects_t), intent(in) :: effects
    real(rp), intent(in) :: site(:, :), radius
    type(stiffness_t), intent(inout) :: direction
    real(rp), intent(inout) :: patterns(:, :)
    type(solid_model_t), pointer :: model
    type(mass_effects_t) :: moved
    type(parameter_t) :: p
    integer :: i, n
    n = size(site, 2)
    model => simulation%model()
    do i = 1, min(n, size(patterns, 2))
      call damage_direction(model, [site(:, i), radius], direction)
      call simulation%stiffness_tangent(direction, .false., patterns(:, i))
    end do
    if (size(rest%bare%loads) > 0 .or. size(patterns, 2) < 2*n) return
    p = parameter_of(list_mass_causes(sum(rest%bare%masses)), MASS_POINT)
    moved = effects
    do i = 1, n
      call put_mass_at(rest%bare, site(:, i), moved)
      call simulation%mass_tangent(MASS_POINT, moved, patterns(:, n + i))
      patterns(:, n + i) = p%prior_sd*patterns(:, n + i)
    end do
  end subroutine site_tangents
end module diagnosis_wing_tangents
