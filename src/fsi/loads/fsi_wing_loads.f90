! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes forces, torques and power of wings from the integrals of a pass or, for wings without thickness, from the forces of
!> their markers.
!>
!> The penalization force int chi/C_eta (u - u_s) also accelerates the fluid inside the mask. The outer flow acts on the wing with F
!> = int chi/C_eta (u - u_s) + d/dt int chi u_s, and the power that the wing gives to the flow is P = -int u_s . chi/C_eta (u - u_s)
!> - d/dt int chi u_s^2/2, for rigid and deforming wings (Engels et al. 2016, DOI 10.1137/15M1026006, for forces). For a rigid wing
!> about a hinge at rest it equals -M . omega, apart from an effect of the thickness of the sheet, across which u_s is constant
!> (docs/results/verification-wings.md).
module fsi_wing_loads
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_rotation, only: cross
  implicit none
  private
  public :: wing_loads_t, wing_loads

  !> Loads of one wing at one time, code units with density 1. `force` and `torque` contain the unsteady part.
  type :: wing_loads_t
    real(rp) :: force(3) = 0, unsteady_force(3) = 0       !< in space
    real(rp) :: torque(3) = 0, unsteady_torque(3) = 0     !< about the hinge, in space
    real(rp) :: power = 0, unsteady_power = 0             !< aerodynamic: from the wing to the flow
    real(rp) :: inertial_power = 0                        !< d/dt of the wing's own kinetic energy
  end type wing_loads_t

contains

  !> Returns the loads of wing i at the time of the fluid's last pass, where the wings must still be.
  function wing_loads(wings, i, fluid) result(loads)
    type(flapping_wings_t), intent(in) :: wings
    integer, intent(in) :: i
    type(fluid_t), intent(in) :: fluid
    type(wing_loads_t) :: loads
    real(rp) :: arm(3)
    loads%inertial_power = wings%inertial_power(i)
    if (allocated(wings%marker_loads)) then
      loads%force = wings%marker_loads(i)%force
      loads%torque = wings%marker_loads(i)%moment
      loads%power = wings%marker_loads(i)%power
      return
    end if
    associate (pose => wings%poses(i), c => wings%surfaces(i)%color, sums => fluid%sums)
      arm = pose%hinge - fluid%rhs%params%solids%centre
      loads%unsteady_force = fluid%unsteady_force(:, c)
      loads%unsteady_torque = fluid%unsteady_moment(:, c) - cross(arm, loads%unsteady_force)
      loads%force = sums%force(:, c) + loads%unsteady_force
      loads%torque = sums%moment(:, c) - cross(arm, sums%force(:, c)) + loads%unsteady_torque
      loads%unsteady_power = -wings%inertial_power_of_fluid(i)
      loads%power = sum(sums%power(:, c)) + loads%unsteady_power
    end associate
  end function wing_loads
end module fsi_wing_loads
