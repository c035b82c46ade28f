! SPDX-License-Identifier: GPL-3.0-or-later
!> Rotations of body and wings against matrices written out here and differentiated by complex steps.
program test_kinematics_rotation
  use base_constants, only: PI
  use base_kinds, only: rp
  use fsi_kinematics, only: body_rotation, body_t, pose_wing, wing_mount_t, &
                            wing_pose_t, wing_rotation
  use fsi_rotation, only: angle_t, cross, rotation_t
  use fsi_wing_motion, only: wing_motion_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: ETA = -0.7_rp, HINGE(3) = [0.2_rp, 0.4_rp, -0.1_rp]
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call check_orthonormal(kit)
  call check_against_matrices(kit, is_right=.false.)
  call check_against_matrices(kit, is_right=.true.)
  call check_points(kit, is_right=.false.)
  call check_points(kit, is_right=.true.)
  call check_published_rates(kit)
  call check_angles_of_pose(kit)
  call kit%finish()

contains

  !> Six angles that move without relation to each other: roll, pitch, yaw, phi, alpha, theta are
  !> c + s sin(w t + p), for complex time.
  pure complex(rp) function moving(k, t) result(angle)
    integer, intent(in) :: k
    complex(rp), intent(in) :: t
    angle = 0.3_rp*k - 0.8_rp + (1.5_rp - 0.2_rp*k)*sin((1 + 0.4_rp*k)*t + 0.7_rp*k)
  end function moving

  !> The same angle at real time with its derivatives.
  pure type(angle_t) function angle_of(k, t) result(angle)
    integer, intent(in) :: k
    real(rp), intent(in) :: t
    real(rp) :: w, p
    w = 1 + 0.4_rp*k
    p = 0.7_rp*k
    angle%value = 0.3_rp*k - 0.8_rp + (1.5_rp - 0.2_rp*k)*sin(w*t + p)
    angle%rate = (1.5_rp - 0.2_rp*k)*w*cos(w*t + p)
    angle%acceleration = -(1.5_rp - 0.2_rp*k)*w**2*sin(w*t + p)
  end function angle_of

  pure function rx(a) result(r)
    complex(rp), intent(in) :: a
    complex(rp) :: r(3, 3)
    r = 0
    r(1, 1) = 1
    r(2, :) = [(0.0_rp, 0.0_rp), cos(a), sin(a)]
    r(3, :) = [(0.0_rp, 0.0_rp), -sin(a), cos(a)]
  end function rx

  pure function ry(a) result(r)
    complex(rp), intent(in) :: a
    complex(rp) :: r(3, 3)
    r = 0
    r(1, :) = [cos(a), (0.0_rp, 0.0_rp), -sin(a)]
    r(2, 2) = 1
    r(3, :) = [sin(a), (0.0_rp, 0.0_rp), cos(a)]
  end function ry

  pure function rz(a) result(r)
    complex(rp), intent(in) :: a
    complex(rp) :: r(3, 3)
    r = 0
    r(1, :) = [cos(a), sin(a), (0.0_rp, 0.0_rp)]
    r(2, :) = [-sin(a), cos(a), (0.0_rp, 0.0_rp)]
    r(3, 3) = 1
  end function rz

  pure function body_matrix(t) result(m)
    complex(rp), intent(in) :: t
    complex(rp) :: m(3, 3)
    m = matmul(rx(moving(1, t)), matmul(ry(moving(2, t)), rz(moving(3, t))))
  end function body_matrix

  !> Body to FLUSI's wing frame, as in FLUSI's paper.
  pure function flusi_matrix(is_right, t) result(m)
    logical, intent(in) :: is_right
    complex(rp), intent(in) :: t
    complex(rp) :: m(3, 3), stroke(3, 3)
    complex(rp) :: phi, alpha, theta
    phi = moving(4, t)
    alpha = moving(5, t)
    theta = moving(6, t)
    stroke = ry(cmplx(ETA, kind=rp))
    if (is_right) then
      m = matmul(ry(-alpha), matmul(rz(theta), matmul(rx(-phi), matmul(rx(cmplx(PI, kind=rp)), stroke))))
    else
      m = matmul(ry(alpha), matmul(rz(theta), matmul(rx(phi), stroke)))
    end if
  end function flusi_matrix

  pure type(rotation_t) function wing_at(is_right, t) result(wing)
    logical, intent(in) :: is_right
    real(rp), intent(in) :: t
    wing = wing_rotation(is_right, ETA, angle_of(4, t), angle_of(5, t), angle_of(6, t))
  end function wing_at

  pure type(rotation_t) function body_at(t) result(body)
    real(rp), intent(in) :: t
    body = body_rotation(roll=angle_of(1, t), pitch=angle_of(2, t), yaw=angle_of(3, t))
  end function body_at

  pure real(rp) function determinant(m) result(d)
    real(rp), intent(in) :: m(3, 3)
    d = dot_product(m(:, 1), cross(m(:, 2), m(:, 3)))
  end function determinant

  !> The derivative by a complex step, exact to round-off, and -M' M^T = [omega]x as a vector.
  function omega_by_steps(is_right, whole, t) result(omega)
    logical, intent(in) :: is_right, whole
    real(rp), intent(in) :: t
    real(rp) :: omega(3), m(3, 3), m_rate(3, 3), w(3, 3)
    complex(rp) :: z(3, 3)
    real(rp), parameter :: STEP = 1.0e-30_rp
    z = flusi_matrix(is_right, cmplx(t, STEP, rp))
    if (whole) z = matmul(z, body_matrix(cmplx(t, STEP, rp)))
    m = real(z, rp)
    m_rate = aimag(z)/STEP
    w = -matmul(m_rate, transpose(m))
    omega = [w(3, 2), w(1, 3), w(2, 1)]
  end function omega_by_steps

  !> Largest |M M^T - 1| and |det M - 1| of body, wings and their products.
  subroutine check_orthonormal(kit)
    type(testkit_t), intent(inout) :: kit
    type(rotation_t) :: body, wing, whole
    real(rp) :: worst(2)
    integer :: i, side
    worst = 0
    do i = 1, 500
      body = body_at(0.37_rp*i)
      call compare(body%matrix, worst)
      do side = 1, 2
        wing = wing_at(side == 2, 0.37_rp*i)
        call compare(wing%matrix, worst)
        whole = wing%after(body)
        call compare(whole%matrix, worst)
      end do
    end do
    ! Seven turns, each with an error of half a unit in the last place, 1.1e-16.
    call kit%check_below('matrices are orthonormal', worst(1), 1.0e-15_rp)
    call kit%check_below('matrices have the determinant 1', worst(2), 1.0e-15_rp)
  end subroutine check_orthonormal

  subroutine compare(m, worst)
    real(rp), intent(in) :: m(3, 3)
    real(rp), intent(inout) :: worst(2)
    real(rp) :: unity(3, 3)
    integer :: i
    unity = matmul(m, transpose(m))
    do i = 1, 3
      unity(i, i) = unity(i, i) - 1
    end do
    worst(1) = max(worst(1), maxval(abs(unity)))
    worst(2) = max(worst(2), abs(determinant(m) - 1))
  end subroutine compare

  !> Matrices, omega and omega' of the wing in the body and in space.
  subroutine check_against_matrices(kit, is_right)
    type(testkit_t), intent(inout) :: kit
    logical, intent(in) :: is_right
    character(:), allocatable :: side
    type(rotation_t) :: wing, whole
    real(rp) :: t, d(3), worst(5)
    integer :: i
    side = trim(merge('right wing: ', 'left wing:  ', is_right))
    worst = 0
    do i = 1, 100
      t = 0.31_rp*i
      wing = wing_at(is_right, t)
      whole = wing%after(body_at(t))
      worst(1) = max(worst(1), maxval(abs(wing%matrix - real(flusi_matrix(is_right, cmplx(t, kind=rp)), rp))), &
                     maxval(abs(whole%matrix - real(matmul(flusi_matrix(is_right, cmplx(t, kind=rp)), &
                                                           body_matrix(cmplx(t, kind=rp))), rp))))
      d = wing%omega - omega_by_steps(is_right, .false., t)
      worst(2) = max(worst(2), maxval(abs(d)))
      d = whole%omega - omega_by_steps(is_right, .true., t)
      worst(3) = max(worst(3), maxval(abs(d)))
      d = wing%omega_rate - omega_rate_by_differences(is_right, .false., t)
      worst(4) = max(worst(4), maxval(abs(d)))
      d = whole%omega_rate - omega_rate_by_differences(is_right, .true., t)
      worst(5) = max(worst(5), maxval(abs(d)))
    end do
    call kit%check_below(side//' matrices as FLUSI''s', worst(1), 1.0e-15_rp)
    call kit%check_below(side//' angular velocity in the body is that of the matrix', worst(2), 1.0e-13_rp)
    call kit%check_below(side//' angular velocity in space is that of the matrix', worst(3), 1.0e-13_rp)
    call kit%check_below(side//' angular acceleration in the body is that of the matrix', worst(4), 1.0e-10_rp)
    call kit%check_below(side//' angular acceleration in space is that of the matrix', worst(5), 1.0e-10_rp)
  end subroutine check_against_matrices

  !> Eighth order, step 0.005: (frequency*step)^8/630 and 1e-15/step are both below 1e-12.
  function omega_rate_by_differences(is_right, whole, t) result(rate)
    logical, intent(in) :: is_right, whole
    real(rp), intent(in) :: t
    real(rp) :: rate(3)
    real(rp), parameter :: WEIGHTS(4) = [4.0_rp/5, -1.0_rp/5, 4.0_rp/105, -1.0_rp/280], STEP = 0.005_rp
    integer :: i
    rate = 0
    do i = 1, 4
      rate = rate + WEIGHTS(i)/STEP*(omega_by_steps(is_right, whole, t + i*STEP) - &
                                     omega_by_steps(is_right, whole, t - i*STEP))
    end do
  end function omega_rate_by_differences

  !> A flapping wing on a body that moves in all ways: velocity and acceleration of a point of the wing are
  !> the derivatives of its place.
  subroutine check_points(kit, is_right)
    type(testkit_t), intent(inout) :: kit
    logical, intent(in) :: is_right
    character(:), allocatable :: side
    type(wing_pose_t) :: pose
    real(rp), parameter :: POINT(3) = [0.9_rp, -0.2_rp, 0.05_rp]
    real(rp) :: t, worst(4), place(3), back(3)
    integer :: i
    side = trim(merge('right wing: ', 'left wing:  ', is_right))
    worst = 0
    do i = 1, 50
      t = 0.41_rp*i
      call pose_at(is_right, t, pose)
      place = pose%point_to_space(POINT)
      back = pose%vector_to_wing(place - pose%hinge)
      worst(1) = max(worst(1), maxval(abs(back - POINT)))
      worst(2) = max(worst(2), maxval(abs(place - real(point_at(is_right, POINT, cmplx(t, kind=rp)), rp))))
      worst(3) = max(worst(3), maxval(abs(pose%velocity_at(POINT) - velocity_by_steps(is_right, POINT, t))))
      worst(4) = max(worst(4), maxval(abs(pose%acceleration_at(POINT) - &
                                          acceleration_by_differences(is_right, POINT, t))))
    end do
    call kit%check_below(side//' a point goes to space and back', worst(1), 1.0e-14_rp)
    call kit%check_below(side//' a point is where the matrices put it', worst(2), 1.0e-14_rp)
    call kit%check_below(side//' the velocity of a point is the derivative of its place', worst(3), 1.0e-12_rp)
    call kit%check_below(side//' the acceleration of a point is the derivative of its velocity', worst(4), 1.0e-10_rp)
  end subroutine check_points

  !> Pose of that wing at time t.
  subroutine pose_at(is_right, t, pose)
    logical, intent(in) :: is_right
    real(rp), intent(in) :: t
    type(wing_pose_t), intent(out) :: pose
    type(body_t) :: body
    type(wing_motion_t) :: motion
    body%centre = [sin(t), 2*cos(2*t), 0.3_rp*sin(3*t)]
    body%velocity = [cos(t), -4*sin(2*t), 0.9_rp*cos(3*t)]
    body%acceleration = [-sin(t), -8*cos(2*t), -2.7_rp*sin(3*t)]
    body%rotation = body_at(t)
    ! Fourier series of one term with the frequency 1/(2 pi): a + b sin(t).
    motion%frequency = 1/(2*PI)
    call motion%phi%set_fourier(0.4_rp, [0.0_rp], [1.1_rp])
    call motion%alpha%set_fourier(-0.6_rp, [0.0_rp], [0.9_rp])
    call motion%theta%set_fourier(0.2_rp, [0.0_rp], [-0.3_rp])
    call pose_wing(body, wing_mount_t(is_right=is_right, hinge=HINGE, eta=ETA), motion, t, pose)
  end subroutine pose_at

  !> Place in space of a point of that wing, from the matrices of this test.
  function point_at(is_right, w, t) result(x)
    logical, intent(in) :: is_right
    real(rp), intent(in) :: w(3)
    complex(rp), intent(in) :: t
    complex(rp) :: x(3), m(3, 3), phi, alpha, theta
    real(rp) :: flusi(3)
    flusi = [w(2), w(1), -w(3)]
    phi = 0.2_rp + 1.1_rp*sin(t)
    alpha = -0.3_rp + 0.9_rp*sin(t)
    theta = 0.1_rp - 0.3_rp*sin(t)
    if (is_right) then
      m = matmul(ry(-alpha), matmul(rz(theta), matmul(rx(-phi + PI), ry(cmplx(ETA, kind=rp)))))
    else
      m = matmul(ry(alpha), matmul(rz(theta), matmul(rx(phi), ry(cmplx(ETA, kind=rp)))))
    end if
    x = matmul(transpose(m), cmplx(flusi, kind=rp)) + HINGE
    x = matmul(transpose(body_matrix(t)), x) + [sin(t), 2*cos(2*t), 0.3_rp*sin(3*t)]
  end function point_at

  function velocity_by_steps(is_right, w, t) result(v)
    logical, intent(in) :: is_right
    real(rp), intent(in) :: w(3), t
    real(rp) :: v(3)
    v = aimag(point_at(is_right, w, cmplx(t, 1.0e-30_rp, rp)))/1.0e-30_rp
  end function velocity_by_steps

  function acceleration_by_differences(is_right, w, t) result(a)
    logical, intent(in) :: is_right
    real(rp), intent(in) :: w(3), t
    real(rp) :: a(3)
    real(rp), parameter :: WEIGHTS(4) = [4.0_rp/5, -1.0_rp/5, 4.0_rp/105, -1.0_rp/280], STEP = 0.005_rp
    integer :: i
    a = 0
    do i = 1, 4
      a = a + WEIGHTS(i)/STEP*(velocity_by_steps(is_right, w, t + i*STEP) - velocity_by_steps(is_right, w, t - i*STEP))
    end do
  end function acceleration_by_differences

  !> The closed forms of FLUSI's source for the relative angular velocity.
  subroutine check_published_rates(kit)
    type(testkit_t), intent(inout) :: kit
    type(angle_t) :: phi, alpha, theta
    type(rotation_t) :: wing
    real(rp) :: want(3), worst(3), t
    integer :: i, side
    worst = 0
    do i = 1, 20
      t = 0.7_rp*i
      phi = angle_of(4, t)
      alpha = angle_of(5, t)
      theta = angle_of(6, t)
      do side = 1, 2
        wing = wing_at(side == 2, t)
        if (side == 2) then
          phi = -phi
          alpha = -alpha
        end if
        associate (ca => cos(alpha%value), sa => sin(alpha%value), ct => cos(theta%value), st => sin(theta%value))
          want = [phi%rate*ca*ct - theta%rate*sa, alpha%rate - phi%rate*st, theta%rate*ca + phi%rate*sa*ct]
        end associate
        worst(side) = max(worst(side), maxval(abs(wing%omega - want)))
      end do
      wing = body_at(t)
      associate (roll => angle_of(1, t), pitch => angle_of(2, t), yaw => angle_of(3, t))
        want = [roll%rate - yaw%rate*sin(pitch%value), &
                pitch%rate*cos(roll%value) + yaw%rate*cos(pitch%value)*sin(roll%value), &
                yaw%rate*cos(pitch%value)*cos(roll%value) - pitch%rate*sin(roll%value)]
      end associate
      worst(3) = max(worst(3), maxval(abs(wing%omega - want)))
    end do
    call kit%check_below('left wing: angular velocity as FLUSI''s closed form', worst(1), 1.0e-14_rp)
    call kit%check_below('right wing: angular velocity as FLUSI''s closed form', worst(2), 1.0e-14_rp)
    call kit%check_below('body: angular velocity as FLUSI''s closed form', worst(3), 1.0e-14_rp)
  end subroutine check_published_rates

  !> The pose says what belongs to the body and what to space.
  subroutine check_angles_of_pose(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_pose_t) :: pose
    type(rotation_t) :: body
    real(rp) :: relative(3), omega(3)
    call pose_at(.false., 0.8_rp, pose)
    body = body_at(0.8_rp)
    omega = matmul(body%matrix, pose%vector_to_space(pose%omega))
    relative = matmul(body%matrix, pose%vector_to_space(pose%omega_relative))
    call kit%check_below('relative to space = relative to the body + body', &
                         maxval(abs(omega - relative - body%omega)), 1.0e-14_rp)
    call kit%check_close('the pose keeps phi', pose%phi%value, 0.2_rp + 1.1_rp*sin(0.8_rp), atol=1.0e-15_rp)
    call kit%check_close('the pose keeps the rate of alpha', pose%alpha%rate, 0.9_rp*cos(0.8_rp), atol=1.0e-15_rp)
  end subroutine check_angles_of_pose
end program test_kinematics_rotation
