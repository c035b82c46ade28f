! SPDX-License-Identifier: GPL-3.0-or-later
!> Left wing against right wing, and what is up, in front and behind.
program test_kinematics_mirror
  use base_constants, only: PI
  use base_kinds, only: rp
  use fsi_kinematics, only: body_rotation, body_t, mirror_wing, pose_wing, swap_flusi_wing, wing_mount_t, wing_pose_t
  use fsi_rotation, only: angle_t, cross
  use fsi_wing_motion, only: wing_motion_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: ETA = -0.7_rp, HINGE(3) = [0.2_rp, 0.4_rp, -0.1_rp]
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call check_mirror(kit)
  call check_directions(kit)
  call check_up(kit)
  call kit%finish()

contains

  !> A pitch that swings, with its derivatives.
  pure type(angle_t) function nodding(t) result(pitch)
    real(rp), intent(in) :: t
    pitch = angle_t(value=0.4_rp + 0.5_rp*sin(1.7_rp*t), rate=0.85_rp*cos(1.7_rp*t), &
                    acceleration=-1.445_rp*sin(1.7_rp*t))
  end function nodding

  !> Both wings with the same angles on a body that pitches: mirror images in y, with their velocities.
  subroutine check_mirror(kit)
    type(testkit_t), intent(inout) :: kit
    type(body_t) :: body
    type(wing_motion_t) :: motion
    type(wing_mount_t) :: left, right
    type(wing_pose_t) :: l, r
    real(rp), parameter :: FLIP(3) = [1.0_rp, -1.0_rp, 1.0_rp], POINT(3) = [0.8_rp, 0.15_rp, 0.02_rp]
    real(rp) :: worst(4), t
    integer :: i
    worst = 0
    left = wing_mount_t(hinge=HINGE, eta=ETA)
    right = wing_mount_t(is_right=.true., hinge=HINGE*FLIP, eta=ETA)
    call motion%phi%set_fourier(0.3_rp, [1.1_rp, 0.1_rp], [0.2_rp, -0.1_rp])
    call motion%alpha%set_fourier(-0.5_rp, [0.2_rp, 0.1_rp], [0.9_rp, 0.2_rp])
    call motion%theta%set_fourier(0.1_rp, [0.2_rp, 0.1_rp], [0.2_rp, 0.3_rp])
    do i = 1, 100
      t = 0.077_rp*i
      body%rotation = body_rotation(roll=angle_t(), pitch=nodding(t), yaw=angle_t())
      call pose_wing(body, left, motion, t, l)
      call pose_wing(body, right, motion, t, r)
      worst(1) = max(worst(1), maxval(abs(l%point_to_space(POINT)*FLIP - r%point_to_space(mirror_wing(POINT)))))
      worst(2) = max(worst(2), maxval(abs(l%velocity_at(POINT)*FLIP - r%velocity_at(mirror_wing(POINT)))))
      worst(3) = max(worst(3), maxval(abs(l%acceleration_at(POINT)*FLIP - r%acceleration_at(mirror_wing(POINT)))))
      ! Angular velocity is an axial vector: its mirror image is -FLIP*omega.
      worst(4) = max(worst(4), maxval(abs(l%vector_to_space(l%omega)*FLIP + r%vector_to_space(r%omega))))
    end do
    ! Velocities are below 20, accelerations below 600.
    call kit%check_below('the right wing is the mirror image of the left one', worst(1), 1.0e-14_rp)
    call kit%check_below('so is its velocity', worst(2), 1.0e-13_rp)
    call kit%check_below('so is its acceleration', worst(3), 1.0e-12_rp)
    call kit%check_below('so is its angular velocity', worst(4), 1.0e-13_rp)
  end subroutine check_mirror

  !> Directions that can be told without formulas. Body axes: x forward, y left, z up.
  subroutine check_directions(kit)
    type(testkit_t), intent(inout) :: kit
    real(rp), parameter :: X(3) = [1.0_rp, 0.0_rp, 0.0_rp], Y(3) = [0.0_rp, 1.0_rp, 0.0_rp], &
                           Z(3) = [0.0_rp, 0.0_rp, 1.0_rp], SMALL = 0.1_rp
    type(wing_pose_t) :: l, r
    call still(l, r, 0.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 0.0_rp)
    call kit%check('the left wing points to the left', same(l%vector_to_space(X), Y))
    call kit%check('the right wing points to the right', same(r%vector_to_space(X), -Y))
    call kit%check('with all angles 0 the leading edges are in front', &
                   same(l%vector_to_space(Y), X) .and. same(r%vector_to_space(Y), X))
    call kit%check('the normals are x cross y: down on the left, up on the right', &
                   same(l%vector_to_space(Z), -Z) .and. same(r%vector_to_space(Z), Z))
    call kit%check('(y, x, -z) leads to FLUSI''s wing frame and back', &
                   same(swap_flusi_wing([1.0_rp, 2.0_rp, 3.0_rp]), [2.0_rp, 1.0_rp, -3.0_rp]))
    call still(l, r, 0.0_rp, 0.0_rp, SMALL, 0.0_rp, 0.0_rp)
    call kit%check('eta = 0: phi > 0 raises both tips', up(l) > 0.09_rp .and. up(r) > 0.09_rp)
    call still(l, r, 0.0_rp, -PI/2, SMALL, 0.0_rp, 0.0_rp)
    call kit%check('eta = -90: phi > 0 moves both tips back', front(l) < -0.09_rp .and. front(r) < -0.09_rp)
    call still(l, r, 0.0_rp, -PI/2, 0.0_rp, 0.0_rp, SMALL)
    call kit%check('eta = -90: theta > 0 lowers both tips', up(l) < -0.09_rp .and. up(r) < -0.09_rp)
    call still(l, r, 0.0_rp, -PI/2, 0.0_rp, 0.0_rp, 0.0_rp)
    call kit%check('eta = -90, alpha = 0: the leading edges are on top', &
                   same(l%vector_to_space(Y), Z) .and. same(r%vector_to_space(Y), Z))
    call still(l, r, 0.0_rp, -PI/2, 0.0_rp, PI/2, 0.0_rp)
    call kit%check('eta = -90, alpha = 90: the leading edges are in front', &
                   same(l%vector_to_space(Y), X) .and. same(r%vector_to_space(Y), X))
    call still(l, r, -SMALL, 0.0_rp, 0.0_rp, 0.0_rp, 0.0_rp)
    call kit%check('pitch < 0 lifts the nose', dot_product(l%vector_to_space(Y), Z) > 0.09_rp)
  end subroutine check_directions

  !> A force upward in space on the wings: on both it has the same part along the dorsal side, and that part is
  !> upward for a wing that lies flat or descends with alpha > 0. A pressure difference that pushes to the
  !> dorsal side lifts both wings.
  subroutine check_up(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_mount_t) :: left, right
    type(wing_pose_t) :: l, r
    real(rp) :: force(3, 2), lift(2), phi
    integer :: i
    logical :: symmetric, lifts
    right%is_right = .true.
    symmetric = .true.
    lifts = .true.
    do i = -8, 8
      phi = 0.15_rp*i
      call still(l, r, 0.0_rp, -1.2_rp, phi, PI/4, 0.1_rp)
      force(:, 1) = l%vector_to_wing([0.0_rp, 0.0_rp, 1.0_rp])
      force(:, 2) = r%vector_to_wing([0.0_rp, 0.0_rp, 1.0_rp])
      symmetric = symmetric .and. maxval(abs(mirror_wing(force(:, 1)) - force(:, 2))) < 1.0e-15_rp
      lift(1) = left%dorsal_sign()*force(3, 1)
      lift(2) = right%dorsal_sign()*force(3, 2)
      lifts = lifts .and. all(lift > 0.5_rp)
    end do
    call kit%check('an upward force is the same on both wings, mirrored', symmetric)
    call kit%check('an upward force pushes both wings to their dorsal side', lifts)
    call still(l, r, 0.0_rp, -PI/2, 0.0_rp, PI/2, 0.0_rp)
    call kit%check('the dorsal side of a wing that lies flat is up, on both sides', &
                   same(l%vector_to_space([0.0_rp, 0.0_rp, left%dorsal_sign()]), [0.0_rp, 0.0_rp, 1.0_rp]) .and. &
                   same(r%vector_to_space([0.0_rp, 0.0_rp, right%dorsal_sign()]), [0.0_rp, 0.0_rp, 1.0_rp]))
  end subroutine check_up

  !> Both wings at rest with these angles on a body with this pitch.
  subroutine still(l, r, pitch, eta_, phi, alpha, theta)
    type(wing_pose_t), intent(out) :: l, r
    real(rp), intent(in) :: pitch, eta_, phi, alpha, theta
    type(body_t) :: body
    type(wing_motion_t) :: motion
    body%rotation = body_rotation(roll=angle_t(), pitch=angle_t(value=pitch), yaw=angle_t())
    call motion%set_constant(phi, alpha, theta)
    call pose_wing(body, wing_mount_t(eta=eta_), motion, 0.0_rp, l)
    call pose_wing(body, wing_mount_t(is_right=.true., eta=eta_), motion, 0.0_rp, r)
  end subroutine still

  real(rp) function up(pose)
    type(wing_pose_t), intent(in) :: pose
    up = dot_product(pose%point_to_space([1.0_rp, 0.0_rp, 0.0_rp]), [0.0_rp, 0.0_rp, 1.0_rp])
  end function up

  real(rp) function front(pose)
    type(wing_pose_t), intent(in) :: pose
    front = dot_product(pose%point_to_space([1.0_rp, 0.0_rp, 0.0_rp]), [1.0_rp, 0.0_rp, 0.0_rp])
  end function front

  logical function same(a, b)
    real(rp), intent(in) :: a(3), b(3)
    same = maxval(abs(a - b)) < 1.0e-15_rp
  end function same
end program test_kinematics_mirror
