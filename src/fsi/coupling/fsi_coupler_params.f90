! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the parameters of flexible wings and of their coupling with the flow (fsi_coupler), and quantities derived from them.
module fsi_coupler_params
  use base_kinds, only: rp
  use io_units, only: unit_scales_t
  use solid_dynamics, only: dynamic_options_t
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  implicit none
  private
  public :: coupler_params_t, COUPLING_WEAK, COUPLING_EXTRAPOLATED, COUPLING_STRONG

  integer, parameter :: COUPLING_WEAK = 1, COUPLING_EXTRAPOLATED = 2, COUPLING_STRONG = 3

  !> Properties of the wings: those of the wing file, of which every wing is a copy or a mirror image (fsi_wing_mirror). SI units.
  type :: coupler_params_t
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(dynamic_options_t) :: options
    real(rp) :: membrane = 0            !< [kg/m^2] mean mass of the membrane, for information
    real(rp) :: density = 0             !< [kg/m^3] of the cuticle, for information
    real(rp) :: light_layer = 0         !< [kg/m^2] a tenth of the wing has less, for information
    real(rp) :: added_mass = 0          !< ratio of the added mass to the mass of the wing (fsi_added_mass), for information
    type(unit_scales_t) :: units        !< SI values of one L, T and M
    real(rp) :: gravity(3) = 0          !< [m/s^2] in space
    logical :: states_gravity = .false. !< the user states it
    real(rp) :: distance = 0            !< from the surface at which the flow is sampled, L
    logical :: extrapolates = .false.   !< the pressure difference is extrapolated to the mid surface
    logical :: friction = .false.       !< the viscous traction is part of the load
    integer :: coupling = COUPLING_WEAK
    real(rp) :: tolerance = 1.0e-3_rp   !< strong: of the load, relative
    integer :: iterations = 20          !< strong: at most so many evaluations of the flow in a step
    real(rp) :: release = 0             !< the wings are held rigid until then, T
    real(rp) :: largest_deflection = 1  !< of any point, over the wing length: beyond it the run stops
  contains
    procedure :: needs_fields => params_needs_fields
    procedure :: needs_trials => params_needs_trials
    procedure :: stability_limit => params_stability_limit
  end type coupler_params_t

contains

  !> Tells whether the fluid must be able to keep velocities in physical space.
  pure logical function params_needs_fields(self) result(needs)
    class(coupler_params_t), intent(in) :: self
    needs = self%friction
  end function params_needs_fields

  !> Tells whether the coupling needs trials of the fluid.
  pure logical function params_needs_trials(self) result(needs)
    class(coupler_params_t), intent(in) :: self
    needs = self%coupling == COUPLING_STRONG
  end function params_needs_trials

  !> Returns the largest s = (dt/C_eta) rho t/(mass per area of the wing) that is certainly stable, where t is the thickness of
  !> the sheet.
  !>
  !> The fluid in the mask pulls a point of the wing with a force per area and velocity of rho t/C_eta. Under this force alone
  !> BDF2 moves the point by z^n with 3 z^2/2 - (2 - s) z + 1/2 = 0 if the load is that of t(n), and with 3 z^2/2 - (2 - 2 s) z +
  !> 1/2 - s = 0 if it is extrapolated: |z| < 1 below 4 and 4/3. Sub-iterations have no limit.
  pure real(rp) function params_stability_limit(self) result(limit)
    class(coupler_params_t), intent(in) :: self
    select case (self%coupling)
    case (COUPLING_WEAK)
      limit = 4
    case (COUPLING_EXTRAPOLATED)
      limit = 4.0_rp/3
    case default
      limit = huge(limit)
    end select
  end function params_stability_limit
end module fsi_coupler_params
