! SPDX-License-Identifier: GPL-3.0-or-later
!> Keeps the loads that the coupling of wings and flow needs from one step to the next, and extrapolates the load with them,
!>
!>     f(n+1) ~ f(n) + dt/dt_old (f(n) - f(n-1)),
!>
!> which is of second order in the step, for components along axes that move with the wings.
module fsi_coupling_history
  use base_kinds, only: rp
  implicit none
  private
  public :: coupling_history_t

  !> The data that a restart needs in addition to the motion of the wings. Loads are (3, points, wings) [N] along the axes of the
  !> wing file.
  type :: coupling_history_t
    real(rp) :: old_dt = 0                     !< of the last step, T; 0: none yet
    real(rp) :: relaxation = 1                 !< of the last sub-iteration of the strong coupling
    real(rp), allocatable :: force(:, :, :)    !< of the flow at the beginning of the last step
    real(rp), allocatable :: applied(:, :, :)  !< applied to the wings in the last step
  contains
    procedure :: init => history_init
    procedure :: extrapolate => history_extrapolate
    procedure :: record_step => history_record_step
    procedure :: relax => history_relax
  end type coupling_history_t

contains

  !> Makes a history without a step.
  subroutine history_init(self, n_points, n_wings)
    class(coupling_history_t), intent(out) :: self
    integer, intent(in) :: n_points, n_wings
    allocate (self%force(3, n_points, n_wings), self%applied(3, n_points, n_wings), source=0.0_rp)
  end subroutine history_init

  !> Returns the load at the end of a step dt [T] that begins under `force`; in the first step that is `force` itself.
  pure subroutine history_extrapolate(self, dt, force, later)
    class(coupling_history_t), intent(in) :: self
    real(rp), intent(in) :: dt
    real(rp), intent(in) :: force(:, :, :)
    real(rp), intent(inout) :: later(:, :, :)
    if (self%old_dt > 0) then
      later = force + dt/self%old_dt*(force - self%force)
    else
      later = force
    end if
  end subroutine history_extrapolate

  !> Records that a step dt [T] was made under `applied`; `force` has been set.
  pure subroutine history_record_step(self, dt, applied)
    class(coupling_history_t), intent(inout) :: self
    real(rp), intent(in) :: dt
    real(rp), intent(in) :: applied(:, :, :)
    self%old_dt = dt
    self%applied = applied
  end subroutine history_record_step

  !> Relaxes `applied` toward the computed load by Aitken's factor; `residual` is the difference between the two. A step begins with
  !> the last factor, but at most 1. On return `old_residual` is `residual`.
  pure subroutine history_relax(self, is_first, residual, old_residual, applied)
    class(coupling_history_t), intent(inout) :: self
    logical, intent(in) :: is_first
    real(rp), intent(in) :: residual(:, :, :)
    real(rp), intent(inout) :: old_residual(:, :, :), applied(:, :, :)
    real(rp) :: change
    associate (factor => self%relaxation)
      if (is_first) then
        if (factor <= 0 .or. factor > 1) factor = 1
      else
        change = sum((residual - old_residual)**2)
        if (change > 0) factor = -factor*sum(old_residual*(residual - old_residual))/change
      end if
      applied = applied + factor*residual
    end associate
    old_residual = residual
  end subroutine history_relax
end module fsi_coupling_history
