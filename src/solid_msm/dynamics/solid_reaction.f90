! SPDX-License-Identifier: GPL-3.0-or-later
!> A load that answers the wing's own velocity at once, such as the flow around a wing without thickness: at the
!> displacements u and the velocities v it is f(u, v), and -df/dv = C, symmetric and positive semidefinite, may be
!> dense. A time step that knows C is stable however light the wing is (Goza & Colonius 2017,
!> doi:10.1016/j.jcp.2017.02.027, who solve for the wing and the forces of the flow together).
module solid_reaction
  use base_kinds, only: rp
  use solid_motion, only: frame_t
  implicit none
  private
  public :: reaction_t

  !> What gives the load. It must not change during a time step of the wing. Arrays are (3, n_all) over the points of
  !> the wing's model; values at its clamped points are ignored.
  type, abstract :: reaction_t
  contains
    procedure(reaction_force), deferred :: force
    procedure(reaction_tangent), deferred :: tangent
    procedure(reaction_block_diagonal), deferred :: block_diagonal
  end type reaction_t

  abstract interface
    !> f(3, n_all) [N], with components along the wing frame, at displacements u [m] and velocities v [m/s] in this
    !> frame, which itself moves as `frame` says.
    subroutine reaction_force(self, frame, u, v, f)
      import :: reaction_t, frame_t, rp
      class(reaction_t), intent(inout) :: self
      type(frame_t), intent(in) :: frame
      real(rp), intent(in) :: u(:, :), v(:, :)
      real(rp), intent(inout) :: f(:, :)
    end subroutine reaction_force

    !> y(3, n_all) = y + C x [N] for x [m/s], with one C [kg/s] for the whole step. Where df/du is small against q C,
    !> q = 3/2 over the time step, Newton's method does without it.
    subroutine reaction_tangent(self, x, y)
      import :: reaction_t, rp
      class(reaction_t), intent(inout) :: self
      real(rp), intent(in) :: x(:, :)
      real(rp), intent(inout) :: y(:, :)
    end subroutine reaction_tangent

    !> d(3, 3, n_all) [kg/s]: symmetric, positive semidefinite blocks that stand for C in the preconditioner. They
    !> decide how many iterations a solution takes, not what it is.
    subroutine reaction_block_diagonal(self, d)
      import :: reaction_t, rp
      class(reaction_t), intent(inout) :: self
      real(rp), intent(inout) :: d(:, :, :)
    end subroutine reaction_block_diagonal
  end interface
end module solid_reaction
