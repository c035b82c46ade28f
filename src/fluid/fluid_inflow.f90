! SPDX-License-Identifier: GPL-3.0-or-later
!> Prescribes the inflow of a channel along y. In a zone at the end of the periodic box the flow is forced to Poiseuille's
!> parabola. The flow that leaves the channel enters this zone, loses its vorticity there, and re-enters the channel as its
!> inflow.
!>
!> The parabola grows from rest as (1 - cos(pi t/T))/2. The flow rate is the same in every section, so that the mean velocity is
!> known; it is prescribed (fluid_mean_flow).
module fluid_inflow
  use base_constants, only: PI
  use base_kinds, only: rp
  use fluid_params, only: fluid_params_t
  use fluid_penalty, only: penalty_t, COLOR_WALL
  implicit none
  private
  public :: inflow_t, inflow_profile, inflow_growth

  !> The penalized points of the inflow zone. Among the solids that do not move, only their u_s depends on time.
  type :: inflow_t
    real(rp), private :: growth = 1               !< the growth that `penalty` has at present
    integer, allocatable, private :: points(:)    !< their entries in `penalty`
    real(rp), allocatable, private :: velocity(:) !< their final u_s along y, L/T
  contains
    procedure :: init => inflow_init
    procedure :: set => inflow_set
  end type inflow_t

contains

  !> Finds the points of the inflow zone in `penalty`, which must have its fixed solids and no overlay.
  subroutine inflow_init(self, penalty)
    class(inflow_t), intent(inout) :: self
    type(penalty_t), intent(in) :: penalty
    logical, allocatable :: flows(:)
    integer :: n, i
    n = penalty%n_points
    allocate (flows(n))
    flows = penalty%color(1:n) == COLOR_WALL .and. penalty%us(2, 1:n) > 0
    self%points = pack([(i, i=1, n)], flows)
    self%velocity = penalty%us(2, self%points)
    self%growth = 1
  end subroutine inflow_init

  !> Gives the points of the inflow their velocity u_s at `time` [T].
  subroutine inflow_set(self, params, time, penalty)
    class(inflow_t), intent(inout) :: self
    type(fluid_params_t), intent(in) :: params
    real(rp), intent(in) :: time !< T
    type(penalty_t), intent(inout) :: penalty
    real(rp) :: growth
    integer :: i
    growth = inflow_growth(params, time)
    if (abs(growth - self%growth) <= 0) return
    do i = 1, size(self%points)
      penalty%us(2, self%points(i)) = growth*self%velocity(i)
    end do
    self%growth = growth
  end subroutine inflow_set

  !> Returns the velocity of the parabola at height `z` [L], over its mean; 0 in the wall.
  pure real(rp) function inflow_profile(params, z) result(profile)
    type(fluid_params_t), intent(in) :: params
    real(rp), intent(in) :: z !< L
    real(rp) :: height, s
    height = params%channel_height()
    s = modulo(z - params%walls%position, params%grid%length(3))
    profile = 6*max(0.0_rp, s*(height - s))/height**2
  end function inflow_profile

  !> Returns the share of its final velocity that the inflow has at `time` [T], 0 to 1.
  pure real(rp) function inflow_growth(params, time) result(growth)
    type(fluid_params_t), intent(in) :: params
    real(rp), intent(in) :: time
    growth = 1
    if (time < params%walls%inflow_start) growth = 0.5_rp*(1 - cos(PI*max(0.0_rp, time)/params%walls%inflow_start))
  end function inflow_growth
end module fluid_inflow
