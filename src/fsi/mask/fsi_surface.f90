! SPDX-License-Identifier: GPL-3.0-or-later
!> Represents a thin wing for the fluid: a triangulated surface with velocities, in the global frame.
!>
!> Rigid and deforming wings use the same type. `place_at` places a rigid one; the solid solver fills `points` and `velocities` of
!> a deforming one. The orientation of the normals does not matter to the mask.
module fsi_surface
  use base_errors, only: require
  use base_kinds, only: rp
  use fsi_kinematics, only: wing_pose_t
  use fsi_rotation, only: cross
  implicit none
  private
  public :: surface_t

  !> Lengths and velocities in code units. The same on all ranks.
  type :: surface_t
    real(rp), allocatable :: points(:, :)     !< (3, n)
    real(rp), allocatable :: velocities(:, :) !< (3, n) du/dt of the points
    integer, allocatable :: triangles(:, :)   !< (3, m) numbers of the corners, 1-based
    integer :: color = 2                      !< 2 left wing, 3 right wing, 4 and 5 second pair
  contains
    procedure :: init => surface_init
    procedure :: place_at => surface_place_at
    procedure :: place_rigid => surface_place_rigid
    procedure :: place_deformed => surface_place_deformed
    procedure :: area => surface_area
    procedure :: points_beside => surface_points_beside
  end type surface_t

contains

  !> Takes points and triangles; the surface is at rest.
  subroutine surface_init(self, points, triangles, color)
    class(surface_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :)    !< (3, n)
    integer, intent(in) :: triangles(:, :)  !< (3, m)
    integer, intent(in) :: color
    call require(size(points, 1) == 3 .and. size(triangles, 1) == 3, 'surface_t: points and triangles are (3, :)')
    call require(all(triangles >= 1 .and. triangles <= size(points, 2)), 'surface_t: a triangle names no point')
    self%points = points
    self%triangles = triangles
    self%color = color
    if (allocated(self%velocities)) deallocate (self%velocities)
    allocate (self%velocities(3, size(points, 2)))
    self%velocities = 0
  end subroutine surface_init

  !> Places the wing rigidly in the pose of the kinematics.
  subroutine surface_place_at(self, reference, pose)
    class(surface_t), intent(inout) :: self
    real(rp), intent(in) :: reference(:, :) !< (3, n) points in the wing frame
    type(wing_pose_t), intent(in) :: pose
    call self%place_rigid(reference, transpose(pose%matrix), pose%hinge, pose%hinge_velocity, &
                          pose%vector_to_space(pose%omega))
  end subroutine surface_place_at

  !> Places a wing that is deformed in its frame: x = hinge + R (X + u), moving with R (omega x (X + u) + v).
  subroutine surface_place_deformed(self, reference, u, v, pose)
    class(surface_t), intent(inout) :: self
    real(rp), intent(in) :: reference(:, :) !< (3, n) X in the wing frame
    real(rp), intent(in) :: u(:, :)         !< (3, n) displacement in the wing frame, L
    real(rp), intent(in) :: v(:, :)         !< (3, n) its rate, L/T
    type(wing_pose_t), intent(in) :: pose
    integer :: i
    do i = 1, size(reference, 2)
      self%points(:, i) = pose%point_to_space(reference(:, i) + u(:, i))
      self%velocities(:, i) = pose%velocity_at(reference(:, i) + u(:, i)) + pose%vector_to_space(v(:, i))
    end do
  end subroutine surface_place_deformed

  !> Places the wing rigidly: x = origin + rotation X, dx/dt = velocity + omega x (x - origin).
  subroutine surface_place_rigid(self, reference, rotation, origin, velocity, omega)
    class(surface_t), intent(inout) :: self
    real(rp), intent(in) :: reference(:, :) !< (3, n) X in the wing frame
    real(rp), intent(in) :: rotation(3, 3)  !< from the wing frame to the global one
    real(rp), intent(in) :: origin(3)       !< hinge, global frame
    real(rp), intent(in) :: velocity(3)     !< of the hinge, global frame
    real(rp), intent(in) :: omega(3)        !< angular velocity, global frame [rad/time]
    real(rp) :: arm(3)
    integer :: i
    call require(size(reference, 2) == size(self%points, 2), 'surface_t: the reference has other points')
    do i = 1, size(reference, 2)
      arm = rotation(:, 1)*reference(1, i) + rotation(:, 2)*reference(2, i) + rotation(:, 3)*reference(3, i)
      self%points(:, i) = origin + arm
      self%velocities(:, i) = velocity + cross(omega, arm)
    end do
  end subroutine surface_place_rigid

  !> Returns the places (3, 2 m) at `distance` [L] from the centres of the m triangles along their normals: above, where a normal
  !> points, then those below.
  pure subroutine surface_points_beside(self, distance, places)
    class(surface_t), intent(in) :: self
    real(rp), intent(in) :: distance
    real(rp), intent(inout) :: places(:, :)
    real(rp) :: normal(3), centre(3)
    integer :: i, m
    m = size(self%triangles, 2)
    do i = 1, m
      associate (a => self%points(:, self%triangles(1, i)), b => self%points(:, self%triangles(2, i)), &
                 c => self%points(:, self%triangles(3, i)))
        centre = (a + b + c)/3
        normal = cross(b - a, c - a)
      end associate
      normal = normal/norm2(normal)
      places(:, i) = centre + distance*normal
      places(:, m + i) = centre - distance*normal
    end do
  end subroutine surface_points_beside

  !> Returns the sum of the areas of the triangles [L^2].
  pure real(rp) function surface_area(self) result(area)
    class(surface_t), intent(in) :: self
    real(rp) :: b(3), c(3)
    integer :: i
    area = 0
    do i = 1, size(self%triangles, 2)
      b = self%points(:, self%triangles(2, i)) - self%points(:, self%triangles(1, i))
      c = self%points(:, self%triangles(3, i)) - self%points(:, self%triangles(1, i))
      area = area + norm2(cross(b, c))/2
    end do
  end function surface_area
end module fsi_surface
