! SPDX-License-Identifier: GPL-3.0-or-later
!> Mirrors vectors and states between the axes of the wing file and those of a wing's frame, so that the wings of both sides
!> have the same mechanics.
!>
!> All wings have the mechanics of the wing file, along its axes. If z of a wing's frame points to another side of the wing than z
!> of the file, the wing is the file's mirror image in the plane z = 0. Vectors are then mirrored between the frames: polar vectors
!> (displacement, velocity, force, gravity) change the sign of z, and axial vectors (angular velocity, angular momentum) change the
!> signs of x and y. Energies do not change. Mirroring twice changes nothing.
module fsi_wing_mirror
  use base_kinds, only: rp
  use fsi_kinematics, only: mirror_wing
  use solid_dynamics, only: dynamic_state_t
  use solid_inertia, only: momenta_t
  use solid_motion, only: frame_t
  implicit none
  private
  public :: mirror_vectors, mirror_state, mirror_frame, mirror_momenta

contains

  !> Mirrors polar vectors v(3, n).
  pure subroutine mirror_vectors(v)
    real(rp), intent(inout) :: v(:, :)
    v(3, :) = 0.0_rp - v(3, :) ! unlike -v it keeps the sign of a zero, which files show
  end subroutine mirror_vectors

  !> Mirrors the motion of a wing within its frame.
  pure subroutine mirror_state(state)
    type(dynamic_state_t), intent(inout) :: state
    call mirror_vectors(state%u)
    call mirror_vectors(state%v)
    call mirror_vectors(state%g)
    call mirror_vectors(state%old_u)
    call mirror_vectors(state%old_v)
    call mirror_vectors(state%old_g)
    call mirror_vectors(state%a)
  end subroutine mirror_state

  !> Returns the motion of a frame, mirrored.
  pure type(frame_t) function mirror_frame(frame) result(mirrored)
    type(frame_t), intent(in) :: frame
    mirrored%velocity = mirror_wing(frame%velocity)
    mirrored%acceleration = mirror_wing(frame%acceleration)
    mirrored%gravity = mirror_wing(frame%gravity)
    mirrored%omega = mirror_axial(frame%omega)
    mirrored%alpha = mirror_axial(frame%alpha)
  end function mirror_frame

  !> Mirrors the sums over a wing.
  pure type(momenta_t) function mirror_momenta(m) result(mirrored)
    type(momenta_t), intent(in) :: m
    mirrored = m
    mirrored%centre = mirror_wing(m%centre)
    mirrored%linear = mirror_wing(m%linear)
    mirrored%angular = mirror_axial(m%angular)
  end function mirror_momenta

  !> Mirrors an axial vector, such as an angular velocity.
  pure function mirror_axial(w) result(mirrored)
    real(rp), intent(in) :: w(3)
    real(rp) :: mirrored(3)
    mirrored = -mirror_wing(w)
  end function mirror_axial
end module fsi_wing_mirror
