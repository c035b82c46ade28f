! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes forces on a wing as functions of time, from a list of forces with a law for each.
module flusi_solid_loads
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use simulation_solid_keys, only: LAW_CONSTANT, LAW_RAMP, LAW_SINE
  use flusi_wing_sites, only: add_force, point_force_t
  implicit none
  private
  public :: solid_loads_t

  !> Holds a force and its dependence on time, LAW_* of simulation_solid_keys.
  type :: solid_load_t
    type(point_force_t) :: force
    integer :: law = LAW_CONSTANT
  end type solid_load_t

  type :: solid_loads_t
    type(solid_load_t), allocatable :: list(:)
    real(rp) :: ramp = 1, frequency = 0, phase = 0 !< [s], [1/s], [rad]
  contains
    procedure :: add => loads_add
    procedure :: at => loads_at
  end type solid_loads_t

contains

  !> Adds forces that depend on time by `law`.
  subroutine loads_add(self, law, forces)
    class(solid_loads_t), intent(inout) :: self
    integer, intent(in) :: law
    type(point_force_t), intent(in) :: forces(:)
    integer :: i
    if (.not. allocated(self%list)) allocate (self%list(0))
    self%list = [self%list, (solid_load_t(forces(i), law), i=1, size(forces))]
  end subroutine loads_add

  !> Sets force(3, n_all) [N] to the sum of all forces at `time` [s].
  subroutine loads_at(self, time, force)
    class(solid_loads_t), intent(in) :: self
    real(rp), intent(in) :: time
    real(rp), intent(inout) :: force(:, :)
    integer :: i
    force = 0
    do i = 1, size(self%list)
      call add_force(self%list(i)%force, factor(self, self%list(i)%law, time), force)
    end do
  end subroutine loads_at

  !> Returns the factor on a force of this law at `time`.
  pure real(rp) function factor(self, law, time)
    class(solid_loads_t), intent(in) :: self
    integer, intent(in) :: law
    real(rp), intent(in) :: time
    real(rp) :: r
    select case (law)
    case (LAW_RAMP)
      r = min(time/self%ramp, 1.0_rp)
      factor = r**3*(10 - 15*r + 6*r**2)
    case (LAW_SINE)
      factor = sin(TWO_PI*self%frequency*time + self%phase)
    case default
      factor = 1
    end select
  end function factor
end module flusi_solid_loads
