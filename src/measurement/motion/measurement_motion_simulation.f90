! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the common interface of simulations of a moving wing, natural modes and records: how many observations they have, and
!> derivatives of the residuals with respect to stiffness, mass, clamp and damping. All derivatives are at the last evaluation.
module measurement_motion_simulation
  use base_kinds, only: rp
  use solid_mass_effects, only: mass_effects_t
  use solid_model, only: solid_model_t
  use solid_stiffness, only: stiffness_t
  implicit none
  private
  public :: motion_simulation_t

  type, abstract :: motion_simulation_t
    integer :: n = 0 !< observations
  contains
    procedure(free_interface), deferred :: free
    procedure(stiffness_interface), deferred :: stiffness_tangent
    procedure(mass_interface), deferred :: mass_tangent
    procedure(clamp_interface), deferred :: clamp_tangent
    procedure(damping_interface), deferred :: damping_tangent
    procedure(model_interface), deferred :: model
  end type motion_simulation_t

  abstract interface
    !> Releases everything.
    subroutine free_interface(self)
      import :: motion_simulation_t
      class(motion_simulation_t), intent(inout) :: self
    end subroutine free_interface

    !> Returns column(n), the derivative when all stiffness changes along `direction`.
    subroutine stiffness_interface(self, direction, column)
      import :: motion_simulation_t, rp, stiffness_t
      class(motion_simulation_t), intent(inout) :: self
      type(stiffness_t), intent(in) :: direction
      real(rp), intent(out) :: column(:)
    end subroutine stiffness_interface

    !> Returns column(n), the derivative with respect to the coordinate of effect `number` of the masses; `effects` holds the
    !> place of a point mass.
    subroutine mass_interface(self, number, effects, column)
      import :: mass_effects_t, motion_simulation_t, rp
      class(motion_simulation_t), intent(inout) :: self
      integer, intent(in) :: number
      type(mass_effects_t), intent(in) :: effects
      real(rp), intent(out) :: column(:)
    end subroutine mass_interface

    !> Returns column(n), the derivative with respect to the compliance of the clamp about x (k = 1) or y (2).
    subroutine clamp_interface(self, k, column)
      import :: motion_simulation_t, rp
      class(motion_simulation_t), intent(inout) :: self
      integer, intent(in) :: k
      real(rp), intent(out) :: column(:)
    end subroutine clamp_interface

    !> Returns column(n), the derivative with respect to effect `number` of the damping: of the relaxation with this time [s], or of
    !> the logarithm of the time of the present relaxation (DAMPING_TIME).
    subroutine damping_interface(self, number, time, column)
      import :: motion_simulation_t, rp
      class(motion_simulation_t), intent(inout) :: self
      integer, intent(in) :: number
      real(rp), intent(in) :: time
      real(rp), intent(out) :: column(:)
    end subroutine damping_interface

    !> Returns the model with the parameters of the last evaluation, from which directions of stiffness are made.
    function model_interface(self) result(model)
      import :: motion_simulation_t, solid_model_t
      class(motion_simulation_t), intent(in), target :: self
      type(solid_model_t), pointer :: model
    end function model_interface
  end interface
end module measurement_motion_simulation
