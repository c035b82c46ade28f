! SPDX-License-Identifier: GPL-3.0-or-later
!> Triangulated wings: area, free edges, and the pose that the kinematics give.
program test_surface
  use base_kinds, only: rp
  use free_perimeter, only: perimeter_of
  use fsi_kinematics, only: wing_pose_t
  use fsi_surface, only: surface_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: kit
  type(surface_t) :: wing
  type(wing_pose_t) :: pose
  real(rp) :: points(3, 5), worst(2)
  integer :: i

  call kit%start(parallel=.false.)
  ! A square of four triangles around its centre, which is lifted by 1/2.
  points = reshape([0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, &
                    0.5_rp, 0.5_rp, 0.5_rp], [3, 5])
  call wing%init(points, reshape([1, 2, 5, 2, 3, 5, 3, 4, 5, 4, 1, 5], [3, 4]), 3)
  call kit%check_close('the area of a pyramid', wing%area(), sqrt(2.0_rp), rtol=1.0e-15_rp)
  call kit%check_close('its free edges are those of the square', perimeter_of(wing), 4.0_rp, rtol=1.0e-15_rp)
  call kit%check('a new wing is at rest', all(abs(wing%velocities) <= 0) .and. wing%color == 3)

  ! Some rotation matrix: a quarter about y after an angle about z.
  pose%matrix = reshape([0.0_rp, 0.8_rp, 0.6_rp, 0.0_rp, -0.6_rp, 0.8_rp, 1.0_rp, 0.0_rp, 0.0_rp], [3, 3])
  pose%hinge = [1.0_rp, 2.0_rp, 3.0_rp]
  pose%hinge_velocity = [-0.5_rp, 0.25_rp, 0.125_rp]
  pose%omega = [3.0_rp, -7.0_rp, 2.0_rp]
  call wing%place_at(points, pose)
  worst = 0
  do i = 1, 5
    worst(1) = max(worst(1), maxval(abs(wing%points(:, i) - pose%point_to_space(points(:, i)))))
    worst(2) = max(worst(2), maxval(abs(wing%velocities(:, i) - pose%velocity_at(points(:, i)))))
  end do
  call kit%check_below('its points are where the kinematics put them', worst(1), 1.0e-14_rp)
  call kit%check_below('its velocities are those of the kinematics', worst(2), 1.0e-14_rp)
  call kit%check_close('placing keeps the area', wing%area(), sqrt(2.0_rp), rtol=1.0e-14_rp)
  call kit%finish()
end program test_surface
