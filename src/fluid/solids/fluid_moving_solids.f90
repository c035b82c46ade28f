! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines what the fluid needs of moving solids: that they draw themselves at a given time. Layers above extend this type, so
!> that the fluid knows no wings.
module fluid_moving_solids
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_penalty, only: N_COLORS, penalty_t
  use fluid_sums, only: sums_t
  implicit none
  private
  public :: moving_solids_t

  type, abstract :: moving_solids_t
  contains
    procedure(place_solids), deferred :: place
    procedure(solids_momentum_rate), deferred :: momentum_rate
    procedure(largest_speed), deferred :: max_speed
    procedure :: feel => solids_feel
    procedure :: refer => solids_refer
  end type moving_solids_t

  abstract interface
    !> Moves the solids to where they are at `time` and lays them over `penalty`, the same on all ranks for the
    !> same arguments. On failure nothing is laid over it. Communicates nothing, or is collective.
    subroutine place_solids(self, time, penalty, failure)
      import :: failure_t, moving_solids_t, penalty_t, rp
      class(moving_solids_t), intent(inout) :: self
      real(rp), intent(in) :: time !< T
      type(penalty_t), intent(inout) :: penalty
      type(failure_t), intent(inout) :: failure
    end subroutine place_solids

    !> Adds d/dt int chi u_s dV and d/dt int chi (x - centre) x u_s dV of these solids to their colours.
    subroutine solids_momentum_rate(self, centre, force, moment)
      import :: moving_solids_t, N_COLORS, rp
      class(moving_solids_t), intent(in) :: self
      real(rp), intent(in) :: centre(3)
      real(rp), intent(inout) :: force(3, 0:N_COLORS - 1)  !< L^4/T^2, density 1
      real(rp), intent(inout) :: moment(3, 0:N_COLORS - 1) !< L^5/T^2, density 1
    end subroutine solids_momentum_rate

    !> Returns the largest |u_s| at the time of the last `place`, L/T: it limits the time step as the speed of the fluid does.
    real(rp) function largest_speed(self)
      import :: moving_solids_t, rp
      class(moving_solids_t), intent(in) :: self
    end function largest_speed
  end interface

contains

  !> Takes the forces of the flow at the time of the last `place`. It is called before `momentum_rate`. Solids that move under these
  !> forces need them; others ignore them. The forces are the same on all ranks.
  subroutine solids_feel(self, sums)
    class(moving_solids_t), intent(inout) :: self
    type(sums_t), intent(in) :: sums
    associate (nobody => self, nothing => sums)
    end associate
  end subroutine solids_feel

  !> Sets the point about which moments are taken if it moves with the solids. It is called after each `place`.
  subroutine solids_refer(self, centre)
    class(moving_solids_t), intent(in) :: self
    real(rp), intent(inout) :: centre(3) !< L
    associate (nobody => self, as_it_is => centre)
    end associate
  end subroutine solids_refer
end module fluid_moving_solids
