! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines a load that responds instantaneously to the velocity of the wing, such as the flow around a wing without thickness. At
!> the displacements u and the velocities v it is f(u, v); -df/dv = C, symmetric and positive semidefinite, may be dense. A time
!> step that knows C is stable however light the wing is (Goza & Colonius 2017, doi:10.1016/j.jcp.2017.02.027, who solve for the
!> wing and the forces of the flow at the same time).
!>
!> A time step that fails in one piece is made in parts. The load must then be such that the momentum which BDF2 makes of it over
!> all parts is the impulse that the surroundings receive in the step.
module solid_reaction
  use base_kinds, only: rp
  use solid_motion, only: frame_t
  implicit none
  private
  public :: reaction_t

  !> Computes the load. It must not change during a part of a time step of the wing. Arrays are (3, n_all) over the points of the
  !> wing's model; values at its clamped points are ignored.
  type, abstract :: reaction_t
  contains
    procedure(reaction_begin_part), deferred :: begin_part
    procedure(reaction_end_part), deferred :: end_part
    procedure(reaction_force), deferred :: force
    procedure(reaction_tangent), deferred :: tangent
    procedure(reaction_block_diagonal), deferred :: block_diagonal
  end type reaction_t

  abstract interface
    !> Begins one of `parts` equal parts of the step, of which `done` are over; parts = 1, done = 0 is the step in one piece. At the
    !> beginning of this part the wing has the displacements u [m] and the velocities v [m/s] in `frame`. `ratio` is the length of
    !> this part over that of the one before, as BDF2 uses it; 0 if implicit Euler makes this part. A part that fails begins again
    !> with `parts` and `done` doubled.
    subroutine reaction_begin_part(self, frame, u, v, parts, done, ratio)
      import :: reaction_t, frame_t, rp
      class(reaction_t), intent(inout) :: self
      type(frame_t), intent(in) :: frame
      real(rp), intent(in) :: u(:, :), v(:, :), ratio
      integer, intent(in) :: parts, done
    end subroutine reaction_begin_part

    !> Ends the part that began last. The wing has made it under the load of the last call of `force`.
    subroutine reaction_end_part(self)
      import :: reaction_t
      class(reaction_t), intent(inout) :: self
    end subroutine reaction_end_part

    !> Returns f(3, n_all) [N], with components along the wing frame, at displacements u [m] and velocities v [m/s] in this frame,
    !> whose own motion is `frame`.
    subroutine reaction_force(self, frame, u, v, f)
      import :: reaction_t, frame_t, rp
      class(reaction_t), intent(inout) :: self
      type(frame_t), intent(in) :: frame
      real(rp), intent(in) :: u(:, :), v(:, :)
      real(rp), intent(inout) :: f(:, :)
    end subroutine reaction_force

    !> Adds C x [N] to y(3, n_all) for velocities x [m/s] in space, with one C [kg/s] for the whole part of the step. A change x of
    !> u changes these velocities by q x + omega x x, q = 3/2 over the length of the part, and f by minus C times this, if f depends
    !> on velocities in space alone. Newton's method corrects an error of the result, such as that of single precision.
    subroutine reaction_tangent(self, x, y)
      import :: reaction_t, rp
      class(reaction_t), intent(inout) :: self
      real(rp), intent(in) :: x(:, :)
      real(rp), intent(inout) :: y(:, :)
    end subroutine reaction_tangent

    !> Returns d(3, 3, n_all) [kg/s]: symmetric, positive semidefinite blocks that approximate C in the preconditioner. They
    !> change the number of iterations, not the solution.
    subroutine reaction_block_diagonal(self, d)
      import :: reaction_t, rp
      class(reaction_t), intent(inout) :: self
      real(rp), intent(inout) :: d(:, :, :)
    end subroutine reaction_block_diagonal
  end interface
end module solid_reaction
