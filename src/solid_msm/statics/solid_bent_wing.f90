! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the shape of a wing at rest under dead loads in the frame of the laboratory, on a clamp that may be compliant, and the
!> displacements of its points due to any change of parameters or loads.
!>
!> A clamp with the compliances c = (twist, flap) turns by theta = (twist Mx, flap My, 0) about the centre of the clamped points, M
!> the moment of the loads there. The unknown u is the displacement in the frame of the clamp, where the load is R^T F, R =
!> R(theta): g(u, p) = R^T F and theta = c M(theta, u). The two angles are found by Newton's method on the second equation, each
!> step with one solution of the first. With du/dtheta_k = K^-1 dR^T/dtheta_k F, a change of parameters or loads costs one
!> back-substitution and a 2 x 2 system:
!>
!>   (1 - c dM/dtheta) dtheta = c (sum R du x F + sum R y x dF) + dc M,   y = arm + u
!>
!> and the points move by R (du + du/dtheta dtheta) + dR y. For a rigid clamp the result is that of the usual solution, to the
!> last bit.
module solid_bent_wing
  use base_kinds, only: rp
  use solid_equilibrium, only: equilibrium_t
  use solid_effects, only: clamp_axis, clamp_compliance
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_rotation, only: rotation_derivative, rotation_matrix
  use solid_sensitivity, only: direction_sensitivity, force_sensitivity
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: parameter_direction
  use solid_vectors, only: cross
  implicit none
  private
  public :: bent_wing_t

  !> One object per thread. Nothing is allocated after `init`, except directions of stiffness once. A solution does not depend on
  !> earlier ones.
  type :: bent_wing_t
    type(solid_model_t) :: model
    real(rp), allocatable :: moved(:, :)             !< (3, n_all) [m] of all points in the laboratory, after `solve`
    real(rp) :: turn(3) = 0                          !< [rad] of the clamp
    type(equilibrium_t), private :: equilibrium
    type(load_t), private :: held                    !< the load in the frame of the clamp
    type(stiffness_t), private :: direction
    real(rp), allocatable, private :: force(:, :), u(:, :), by_turn(:, :, :), lever(:, :)
    real(rp), private :: compliance(2) = 0, centre(3) = 0, moment(3) = 0, rotation(3, 3) = 0, turned(3, 3, 2) = 0, &
                         inverse(2, 2) = 0
    logical, private :: is_compliant = .false.
  contains
    procedure :: init => bent_init
    procedure :: free => bent_free
    procedure :: solve => bent_solve
    procedure :: stiffness_motion => bent_stiffness_motion
    procedure :: parameter_motion => bent_parameter_motion
    procedure :: force_motion => bent_force_motion
  end type bent_wing_t

contains

  !> Allocates the work space for this model.
  subroutine bent_init(self, model)
    class(bent_wing_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    integer :: i, n
    call self%free()
    self%model = model
    n = model%n_all
    allocate (self%moved(3, n), self%force(3, n), self%u(3, n), self%by_turn(3, n, 2), self%lever(3, n), source=0.0_rp)
    call self%held%init(model)
    call self%equilibrium%init(self%model)
    self%centre = 0
    do i = 1, model%n_points
      if (model%free(i) == 0) self%centre = self%centre + model%points(:, i)
    end do
    self%centre = self%centre/max(1, count(model%free(:model%n_points) == 0))
  end subroutine bent_init

  !> Releases everything.
  subroutine bent_free(self)
    class(bent_wing_t), intent(inout) :: self
    call self%equilibrium%free()
    if (allocated(self%moved)) deallocate (self%moved, self%force, self%u, self%by_turn, self%lever)
  end subroutine bent_free

  !> Finds the shape under force(3, n_all) [N] with the parameters of `self%model`, and sets `moved` and `turn`. u(3, n_all) [m], in
  !> the frame of the clamp, is the initial guess of a warm solution, and always the result. `report` says whether a shape was
  !> found; see `solve_static`.
  subroutine bent_solve(self, force, is_warm, options, u, report)
    class(bent_wing_t), intent(inout) :: self
    real(rp), intent(in) :: force(:, :)
    logical, intent(in) :: is_warm
    type(static_options_t), intent(in) :: options
    real(rp), intent(inout) :: u(:, :)
    type(static_report_t), intent(out) :: report
    self%force = force
    self%compliance = clamp_compliance(self%model%params%effects)
    self%is_compliant = any(abs(self%compliance) > 0)
    self%turn = 0
    if (is_warm .and. self%is_compliant) call guess_turn(self, u)
    call turn_load(self)
    call solve_static(self%equilibrium, self%model, self%held, is_warm, options, u, report)
    if (self%is_compliant) call find_turn(self, options, u, report)
    self%u = u
    self%moved = u
    if (.not. report%converged) return
    call turn_levers(self, u)
    if (self%is_compliant) self%moved = matmul(self%rotation, self%lever) + spread(self%centre, 2, size(u, 2)) - &
                                        self%model%points
  end subroutine bent_solve

  !> Computes the load in the frame of the clamp.
  subroutine turn_load(self)
    class(bent_wing_t), intent(inout) :: self
    self%held%force = self%force
    if (.not. any(abs(self%turn) > 0)) return
    self%held%force = matmul(transpose(rotation_matrix(self%turn)), self%force)
  end subroutine turn_load

  !> Finds the angles of the clamp for a given shape of the wing, by fixed-point iteration.
  subroutine guess_turn(self, u)
    class(bent_wing_t), intent(inout) :: self
    real(rp), intent(in) :: u(:, :)
    real(rp), parameter :: FAR = 1.0_rp ! [rad]
    integer :: k
    do k = 1, 8
      call turn_levers(self, u)
      self%turn(:2) = self%compliance*self%moment(:2)
      if (.not. norm2(self%turn) < FAR) self%turn = 0
    end do
  end subroutine guess_turn

  !> Does Newton's method on the angles, from a first solution.
  subroutine find_turn(self, options, u, report)
    class(bent_wing_t), intent(inout) :: self
    type(static_options_t), intent(in) :: options
    real(rp), intent(inout) :: u(:, :)
    type(static_report_t), intent(inout) :: report
    integer, parameter :: LIMIT = 20
    real(rp), parameter :: SHARP = 1.0e-2_rp, FAR = 1.0_rp, LONGEST = 0.3_rp ! of the tolerance; [rad]
    type(static_report_t) :: one
    real(rp) :: step(2)
    integer :: k
    do k = 1, LIMIT
      if (.not. report%converged) return
      call turn_levers(self, u)
      call find_turning(self)
      step = matmul(self%inverse, self%compliance*self%moment(:2) - self%turn(:2))
      if (norm2(step) <= SHARP*options%tolerance) return
      self%turn(:2) = self%turn(:2) + step*min(1.0_rp, LONGEST/norm2(step))
      if (.not. norm2(self%turn) < FAR) exit
      call turn_load(self)
      call solve_static(self%equilibrium, self%model, self%held, .true., options, u, one)
      one%factorisations = one%factorisations + report%factorisations
      one%snaps = one%snaps + report%snaps
      one%stages = one%stages + report%stages
      one%was_redone_cold = one%was_redone_cold .or. report%was_redone_cold
      one%was_repeated = one%was_repeated .or. report%was_repeated
      one%is_start = one%is_start .and. report%is_start
      report = one
    end do
    report%converged = .false.
    report%is_start = .false.
    report%reason = 'the clamp turns too far: root_flap or root_twist is too large for this load'
  end subroutine find_turn

  !> Computes the rotation, the levers from the centre of the clamp in its frame, and the moment of the load about it.
  subroutine turn_levers(self, u)
    class(bent_wing_t), intent(inout) :: self
    real(rp), intent(in) :: u(:, :)
    integer :: i
    self%rotation = rotation_matrix(self%turn)
    self%moment = 0
    do i = 1, size(u, 2)
      self%lever(:, i) = self%model%points(:, i) + u(:, i) - self%centre
      self%moment = self%moment + cross(matmul(self%rotation, self%lever(:, i)), self%force(:, i))
    end do
  end subroutine turn_levers

  !> Computes the derivative of the shape with respect to the angles, and the inverse of 1 - c dM/dtheta.
  subroutine find_turning(self)
    class(bent_wing_t), intent(inout) :: self
    real(rp) :: m(3), a(2, 2), determinant
    integer :: k, i
    do k = 1, 2
      self%turned(:, :, k) = rotation_derivative(self%turn, k)
      call force_sensitivity(self%equilibrium, self%model, matmul(transpose(self%turned(:, :, k)), self%force), &
                             self%by_turn(:, :, k))
      m = moment_of(self, self%by_turn(:, :, k))
      do i = 1, size(self%lever, 2)
        m = m + cross(matmul(self%turned(:, :, k), self%lever(:, i)), self%force(:, i))
      end do
      a(:, k) = -self%compliance*m(:2)
      a(k, k) = a(k, k) + 1
    end do
    determinant = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
    self%inverse(:, 1) = [a(2, 2), -a(2, 1)]/determinant
    self%inverse(:, 2) = [-a(1, 2), a(1, 1)]/determinant
  end subroutine find_turning

  !> Returns the change of the moment when the points move by du in the frame of the clamp.
  pure function moment_of(self, du) result(m)
    class(bent_wing_t), intent(in) :: self
    real(rp), intent(in) :: du(:, :)
    real(rp) :: m(3)
    integer :: i
    m = 0
    do i = 1, size(du, 2)
      m = m + cross(matmul(self%rotation, du(:, i)), self%force(:, i))
    end do
  end function moment_of

  !> Returns motion(3, n_all) [m], the displacements of all points in the laboratory when the stiffness changes along `direction`.
  !> Call it right after a converged `solve`.
  subroutine bent_stiffness_motion(self, direction, motion)
    class(bent_wing_t), intent(inout) :: self
    type(stiffness_t), intent(in) :: direction
    real(rp), intent(out) :: motion(:, :)
    call direction_sensitivity(self%equilibrium, self%model, self%u, direction, motion)
    if (self%is_compliant) call let_turn(self, self%compliance*lower(moment_of(self, motion)), motion)
  end subroutine bent_stiffness_motion

  !> Returns the displacements for a change of parameter `number` of the model, per unit, or per log unit if it varies by factors.
  subroutine bent_parameter_motion(self, number, motion)
    class(bent_wing_t), intent(inout) :: self
    integer, intent(in) :: number
    real(rp), intent(out) :: motion(:, :)
    integer :: k
    k = clamp_axis(self%model%params%effects, number - self%model%params%count_basic())
    if (k > 0) then
      motion = 0
      if (.not. self%is_compliant) call find_turning(self)
      call let_turn(self, merge(self%moment(:2), 0.0_rp, [k == 1, k == 2]), motion)
    else
      call parameter_direction(self%model, number, self%direction)
      call self%stiffness_motion(self%direction, motion)
    end if
  end subroutine bent_parameter_motion

  !> Returns the displacements when the load changes along force(3, n_all) [N].
  subroutine bent_force_motion(self, force, motion)
    class(bent_wing_t), intent(inout) :: self
    real(rp), intent(in) :: force(:, :)
    real(rp), intent(out) :: motion(:, :)
    real(rp) :: m(3)
    integer :: i
    if (.not. self%is_compliant) then
      call force_sensitivity(self%equilibrium, self%model, force, motion)
      return
    end if
    call force_sensitivity(self%equilibrium, self%model, matmul(transpose(self%rotation), force), motion)
    m = moment_of(self, motion)
    do i = 1, size(force, 2)
      m = m + cross(matmul(self%rotation, self%lever(:, i)), force(:, i))
    end do
    call let_turn(self, self%compliance*m(:2), motion)
  end subroutine bent_force_motion

  !> Returns the first two components of a moment.
  pure function lower(m) result(two)
    real(rp), intent(in) :: m(3)
    real(rp) :: two(2)
    two = m(:2)
  end function lower

  !> Adds the effect of the turning of the clamp to the motion in the frame of the clamp, and rotates the result into the
  !> laboratory. `push` [rad] is the rotation of the clamp at constant moment.
  subroutine let_turn(self, push, motion)
    class(bent_wing_t), intent(in) :: self
    real(rp), intent(in) :: push(2)
    real(rp), intent(inout) :: motion(:, :)
    real(rp) :: turning(2)
    integer :: k
    turning = matmul(self%inverse, push)
    do k = 1, 2
      motion = motion + turning(k)*self%by_turn(:, :, k)
    end do
    motion = matmul(self%rotation, motion)
    do k = 1, 2
      motion = motion + turning(k)*matmul(self%turned(:, :, k), self%lever)
    end do
  end subroutine let_turn
end module solid_bent_wing
