! SPDX-License-Identifier: GPL-3.0-or-later
!> The momentum of the fluid in the box.
module support_momentum
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: flow_momentum

contains

  !> int u dV over the box, which is the momentum of the fluid of density 1, rho L^4/T. Collective.
  function flow_momentum(world, fluid) result(momentum)
    type(world_t), intent(in) :: world
    type(fluid_t), intent(in) :: fluid
    real(rp) :: momentum(3)
    momentum = 0
    associate (zero => fluid%transform%sticks%zero)
      if (zero > 0) momentum = real(fluid%rhs%state%u(1, zero, :))*fluid%rhs%params%grid%volume()
    end associate
    call world%sum_reals(momentum)
  end function flow_momentum
end module support_momentum
