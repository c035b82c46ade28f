! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the load of the flow on a flexible wing without thickness. The load is a linear function of the motion of the wing
!> in the present step, which the solid does not know yet.
!>
!> Let s be the velocities that the flow would have at the markers without the wing, W the weights that interpolate from points to
!> markers, and M the response of the flow to forces at the markers. The forces on the flow that make it follow a wing whose points
!> have the velocities v in space, and the load on the points, are
!>
!>     F = M^-1 (W v - s)/dt,          f = -W^T F,          -df/dv = W^T M^-1 W/dt.
!>
!> The last expression is the added mass divided by dt, plus a friction. The time step of the wing solves for v and F together
!> (solid_reaction), so that light wings are as stable as heavy ones (Goza & Colonius 2017, DOI 10.1016/j.jcp.2017.02.027).
!>
!> F is the mean force over the step: the impulse that the flow gets, over dt. The load of BDF2 belongs to the end of the step. With
!> the ratio r of this step to the one before, whose force was F_old, it is
!>
!>     f = -W^T [(1 + 2 r) F - r F_old]/(1 + r),
!>
!> the force at the end of the step to second order. These are the weights with which BDF2 makes a rate of the changes of v in both
!> steps, so that in each step the momentum of the points changes by the impulse -dt W^T F. C gets the factor (1 + 2 r)/(1 + r).
!> Implicit Euler has r = 0.
!>
!> If the wing makes the step in parts h, the flow at the markers goes from their velocities w at the beginning of the step to s
!> evenly in time, and has the impulses of the parts before:
!>
!>     h M F_k = W v_k - (w + (s - w) t_k/dt) - sum over j < k of h_j M F_j = W v_k - W v_(k-1) - (s - w) h/dt.
!>
!> The sum over all parts is dt M F of one piece, with v of the end: the flow receives the impulses that the wing feels, and then
!> follows the wing. If s were the flow of all parts, the first would have to take up all that the flow did by itself. F_old is the
!> force of the part before.
!>
!> Mechanics in SI units, flow in L, T and rho; all components along the axes of the wing file.
module fsi_flow_reaction
  use base_kinds, only: rp
  use fsi_marker_response, only: marker_response_t
  use fsi_markers, only: markers_t
  use io_units, only: unit_scales_t
  use solid_motion, only: frame_t, inertial_velocity
  use solid_reaction, only: reaction_t
  implicit none
  private
  public :: flow_reaction_t

  !> The reaction on one wing. `init` allocates; nothing else does.
  type, extends(reaction_t) :: flow_reaction_t
    type(marker_response_t) :: response
    real(rp), allocatable :: on_flow(:, :)            !< (3, n) mean F of the step, of the parts that have ended, rho L^4/T^2
    real(rp), allocatable :: last(:, :)               !< (3, n) F of the last part that has ended
    type(markers_t), private :: markers
    real(rp), private :: speed = 1, newton = 1        !< [m/s] of L/T, [N] of rho L^4/T^2
    real(rp), private :: dt = 1, h = 1                !< [T] of the step and of its present part
    integer, private :: parts = 1, done = 0           !< into which the step is divided at present, and how many are over
    real(rp), private :: weight = 1, old_weight = 0   !< of F and of `last` in the load
    real(rp), allocatable, private :: points(:, :)    !< (3, n_all) [m] unloaded
    real(rp), allocatable, private :: flow(:, :)      !< (3, n) s, L/T
    real(rp), allocatable, private :: begun(:, :)     !< (3, n) w, L/T
    real(rp), allocatable, private :: around(:, :)    !< (3, n) the flow without the forces of the present part, L/T
    real(rp), allocatable, private :: exerted(:, :)   !< (3, n) F of the last call of `force`
    real(rp), allocatable, private :: velocity(:, :), work(:, :) !< (3, n)
    real(rp), allocatable, private :: moved(:, :)     !< (3, n_all)
    real(rp), allocatable, private :: blocks(:, :, :) !< (3, 3, n_all) approximation of W^T M^-1 W, rho L^3
  contains
    procedure :: init => reaction_init
    procedure :: update_response => reaction_update_response
    procedure :: begin => reaction_begin
    procedure :: begin_part => reaction_begin_part
    procedure :: end_part => reaction_end_part
    procedure :: force => reaction_force
    procedure :: tangent => reaction_tangent
    procedure :: block_diagonal => reaction_block_diagonal
  end type flow_reaction_t

contains

  !> Makes room for a wing of points(3, n_all) [m] with these markers. The response must have been allocated; it is not computed
  !> here.
  subroutine reaction_init(self, markers, points, units)
    class(flow_reaction_t), intent(inout) :: self
    type(markers_t), intent(in) :: markers
    real(rp), intent(in) :: points(:, :)
    type(unit_scales_t), intent(in) :: units
    self%markers = markers
    self%points = points
    self%speed = units%length/units%time
    self%newton = units%mass*units%length/units%time**2
    allocate (self%on_flow(3, markers%n), self%flow(3, markers%n), self%begun(3, markers%n), self%around(3, markers%n), &
              self%exerted(3, markers%n), self%velocity(3, markers%n), self%work(3, markers%n), self%last(3, markers%n), &
              source=0.0_rp)
    allocate (self%moved(3, size(points, 2)), self%blocks(3, 3, size(points, 2)), source=0.0_rp)
  end subroutine reaction_init

  !> Takes over a changed response. It must be called after every change; before `init` it does nothing. The preconditioner of the
  !> wing's equations replaces the tangent by the force on the points when all have the same velocity, which is exact for the
  !> smoothest motion.
  subroutine reaction_update_response(self)
    class(flow_reaction_t), intent(inout) :: self
    integer :: c, p
    if (.not. allocated(self%blocks)) return
    do c = 1, 3
      self%velocity = 0
      self%velocity(c, :) = 1
      call self%response%solve(self%velocity, self%work)
      self%moved = 0
      call self%markers%spread(self%work, self%moved)
      self%blocks(:, c, :) = self%moved
    end do
    do p = 1, size(self%blocks, 3)
      associate (b => self%blocks(:, :, p))
        b = (b + transpose(b))/2
        if (.not. is_positive(b)) b = diagonal(maxval([b(1, 1), b(2, 2), b(3, 3), 0.0_rp]))
      end associate
    end do
  end subroutine reaction_update_response

  !> Tells whether a symmetric matrix is positive definite.
  pure logical function is_positive(b)
    real(rp), intent(in) :: b(3, 3)
    real(rp) :: minor
    minor = b(1, 1)*b(2, 2) - b(1, 2)**2
    is_positive = b(1, 1) > 0 .and. minor > 0 .and. &
                  b(3, 3)*minor - b(1, 1)*b(2, 3)**2 - b(2, 2)*b(1, 3)**2 + 2*b(1, 2)*b(2, 3)*b(1, 3) > 0
  end function is_positive

  !> Returns value times the unit matrix (3, 3).
  pure function diagonal(value) result(b)
    real(rp), intent(in) :: value
    real(rp) :: b(3, 3)
    integer :: c
    b = 0
    do c = 1, 3
      b(c, c) = value
    end do
  end function diagonal

  !> Begins a time step dt [T] in one piece, at whose end the flow without the wing has the velocities flow(3, n) [L/T] at the
  !> markers. last(3, n) is `last` at the end of the step before.
  subroutine reaction_begin(self, flow, last, dt)
    class(flow_reaction_t), intent(inout) :: self
    real(rp), intent(in) :: flow(:, :), last(:, :), dt
    self%flow = flow
    self%around = flow
    self%last = last
    self%weight = 1
    self%old_weight = 0
    self%dt = dt
    self%h = dt
    self%parts = 1
    self%done = 0
  end subroutine reaction_begin

  !> Begins a part of the step; see reaction_t.
  subroutine reaction_begin_part(self, frame, u, v, parts, done, ratio)
    class(flow_reaction_t), intent(inout) :: self
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :), ratio
    integer, intent(in) :: parts, done
    self%parts = parts
    self%done = done
    self%h = self%dt/parts
    self%old_weight = ratio/(1 + ratio)
    self%weight = 1 + self%old_weight
    if (parts == 1) then
      self%around = self%flow
      return
    end if
    call find_velocities(self, frame, u, v)
    if (done == 0) self%begun = self%velocity
    self%around = self%velocity + (self%flow - self%begun)/parts
  end subroutine reaction_begin_part

  !> Ends a part: adds its impulse to that of the step; see reaction_t.
  subroutine reaction_end_part(self)
    class(flow_reaction_t), intent(inout) :: self
    if (self%done == 0) self%on_flow = 0
    self%on_flow = self%on_flow + self%exerted/self%parts
    self%last = self%exerted
  end subroutine reaction_end_part

  !> Sets `velocity` to the velocities of the markers in space [L/T] for points at displacements u [m] with velocities v [m/s].
  subroutine find_velocities(self, frame, u, v)
    type(flow_reaction_t), intent(inout) :: self
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :)
    integer :: p
    do p = 1, size(u, 2)
      self%moved(:, p) = inertial_velocity(frame, self%points(:, p) + u(:, p), v(:, p))/self%speed
    end do
    call self%markers%positions(self%moved, self%velocity)
  end subroutine find_velocities

  !> Sets f(3, n_all) [N] to the force of the flow in the present part of the step; see reaction_t.
  subroutine reaction_force(self, frame, u, v, f)
    class(flow_reaction_t), intent(inout) :: self
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :)
    real(rp), intent(inout) :: f(:, :)
    call find_velocities(self, frame, u, v)
    self%velocity = (self%velocity - self%around)/self%h
    call self%response%solve(self%velocity, self%exerted)
    self%work = self%weight*self%exerted - self%old_weight*self%last
    f = 0
    call self%markers%spread(self%work, f)
    f = -self%newton*f
  end subroutine reaction_force

  !> Adds C x to y; see reaction_t.
  subroutine reaction_tangent(self, x, y)
    class(flow_reaction_t), intent(inout) :: self
    real(rp), intent(in) :: x(:, :)
    real(rp), intent(inout) :: y(:, :)
    call self%markers%positions(x, self%velocity)
    self%velocity = (self%weight*self%newton/(self%speed*self%h))*self%velocity
    call self%response%solve(self%velocity, self%work)
    call self%markers%spread(self%work, y)
  end subroutine reaction_tangent

  !> Sets the blocks that replace C in the preconditioner; see reaction_t.
  subroutine reaction_block_diagonal(self, d)
    class(flow_reaction_t), intent(inout) :: self
    real(rp), intent(inout) :: d(:, :, :)
    d = (self%weight*self%newton/(self%speed*self%h))*self%blocks
  end subroutine reaction_block_diagonal
end module fsi_flow_reaction
