! SPDX-License-Identifier: GPL-3.0-or-later
!> Moving frames of wings: velocity, acceleration and gravity against differences of the places of material
!> points, for a wing that flaps on a body that moves and turns; and the frame that turns about an axis.
program test_wing_frame
  use base_constants, only: PI, TWO_PI
  use base_kinds, only: rp
  use fsi_kinematics, only: body_rotation, body_t, pose_wing, wing_mount_t, wing_pose_t
  use fsi_rotation, only: angle_t
  use fsi_wing_frame, only: flapping_motion_t, frame_of_pose
  use fsi_wing_motion, only: wing_motion_t
  use solid_motion, only: frame_t, inertial_velocity, motion_t, rotating_motion_t
  use solid_vectors, only: cross
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: LENGTH = 9.0e-3_rp, FREQUENCY = 158, GRAVITY(3) = [1.0_rp, -2.0_rp, -9.0_rp]
  real(rp), parameter :: POINT(3) = [7.0e-3_rp, -1.0e-3_rp, 5.0e-4_rp] ! m, in the wing frame
  ! Central differences of order 8; the first derivative's and the second derivative's weights.
  real(rp), parameter :: FIRST(4) = [4.0_rp/5, -1.0_rp/5, 4.0_rp/105, -1.0_rp/280]
  real(rp), parameter :: SECOND(0:4) = [-205.0_rp/72, 8.0_rp/5, -1.0_rp/5, 8.0_rp/315, -1.0_rp/560]
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_moving_body(.false.)
  call test_moving_body(.true.)
  call test_tethered()
  call test_mirrored()
  call test_rotation(0.0_rp)
  call test_rotation(0.3_rp)
  call t%finish()

contains

  !> Angle a + b sin(c t) with its derivatives.
  pure type(angle_t) function swinging(a, b, c, time) result(angle)
    real(rp), intent(in) :: a, b, c, time
    angle = angle_t(a + b*sin(c*time), b*c*cos(c*time), -b*c**2*sin(c*time))
  end function swinging

  !> A wing that flaps with three harmonics on a body that flies an accelerated curve and tumbles.
  subroutine pose_at(is_right, time, pose)
    logical, intent(in) :: is_right
    real(rp), intent(in) :: time ! T
    type(wing_pose_t), intent(out) :: pose
    type(body_t) :: body
    type(wing_mount_t) :: mount
    type(wing_motion_t) :: motion
    real(rp), parameter :: A(3) = [1.0_rp, 2.0_rp, -1.0_rp], V(3) = [0.5_rp, -1.0_rp, 0.3_rp], W = 2.0_rp
    body%centre = V*time + A*sin(W*time)
    body%velocity = V + A*W*cos(W*time)
    body%acceleration = -A*W**2*sin(W*time)
    body%rotation = body_rotation(roll=swinging(0.2_rp, 0.5_rp, 3.0_rp, time), &
                                  pitch=swinging(-0.4_rp, 0.7_rp, 2.0_rp, time), &
                                  yaw=swinging(0.9_rp, 1.1_rp, 1.0_rp, time))
    mount%is_right = is_right
    mount%hinge = [0.2_rp, merge(-0.15_rp, 0.15_rp, is_right), 0.1_rp]
    mount%eta = -1.1_rp
    call motion%phi%set_fourier(0.1_rp, [1.1_rp, 0.1_rp], [0.2_rp, -0.05_rp])
    call motion%alpha%set_fourier(0.2_rp, [0.1_rp, -0.1_rp], [0.9_rp, 0.2_rp])
    call motion%theta%set_fourier(-0.1_rp, [0.05_rp, 0.2_rp], [0.1_rp, 0.0_rp])
    call pose_wing(body, mount, motion, time, pose)
  end subroutine pose_at

  !> Place in space [m] at `time` [s] of the point of the wing frame.
  function place(is_right, time) result(x)
    logical, intent(in) :: is_right
    real(rp), intent(in) :: time
    real(rp) :: x(3)
    type(wing_pose_t) :: pose
    call pose_at(is_right, time*FREQUENCY, pose)
    x = LENGTH*pose%point_to_space(POINT/LENGTH)
  end function place

  subroutine test_moving_body(is_right)
    logical, intent(in) :: is_right
    real(rp), parameter :: STEP = 2.0e-3_rp/FREQUENCY
    type(wing_pose_t) :: pose
    type(frame_t) :: frame
    real(rp), dimension(3) :: velocity, acceleration, found
    real(rp) :: time, worst(3), scale(2)
    integer :: i, j
    worst = 0
    scale = 0
    do i = 1, 20
      time = 0.0517_rp*i/FREQUENCY
      velocity = 0
      acceleration = SECOND(0)*place(is_right, time)
      do j = 1, 4
        velocity = velocity + FIRST(j)*(place(is_right, time + j*STEP) - place(is_right, time - j*STEP))
        acceleration = acceleration + SECOND(j)*(place(is_right, time + j*STEP) + place(is_right, time - j*STEP))
      end do
      velocity = velocity/STEP
      acceleration = acceleration/STEP**2
      call pose_at(is_right, time*FREQUENCY, pose)
      frame = frame_of_pose(pose, LENGTH, FREQUENCY, GRAVITY)
      found = pose%vector_to_space(inertial_velocity(frame, POINT, [0.0_rp, 0.0_rp, 0.0_rp]))
      worst(1) = max(worst(1), norm2(found - velocity))
      found = frame%acceleration + cross(frame%alpha, POINT) + cross(frame%omega, cross(frame%omega, POINT))
      worst(2) = max(worst(2), norm2(pose%vector_to_space(found) - acceleration))
      worst(3) = max(worst(3), norm2(pose%vector_to_space(frame%gravity) - GRAVITY))
      scale = max(scale, [norm2(velocity), norm2(acceleration)])
    end do
    ! Truncation: (4 pi STEP)^8/630 of the fastest harmonic, 3e-16; round-off: 1e-16 LENGTH/STEP^2, about 1e-10
    ! of the acceleration.
    call t%check_below('velocity of a point of the wing', worst(1)/scale(1), 1.0e-12_rp)
    call t%check_below('acceleration of a point of the wing', worst(2)/scale(2), 1.0e-9_rp)
    call t%check_below('gravity keeps its direction in space', worst(3), 1.0e-14_rp)
  end subroutine test_moving_body

  !> The motion of a wing on a body at rest is that of its poses, with a ramp in units of T.
  subroutine test_tethered()
    type(flapping_motion_t) :: flapping
    type(frame_t) :: frame, again
    type(wing_pose_t) :: pose
    real(rp) :: time
    flapping%mount%hinge = [0.1_rp, 0.2_rp, 0.0_rp]
    flapping%length = LENGTH
    flapping%frequency = FREQUENCY
    flapping%gravity = GRAVITY
    flapping%motion%ramp = 0.5_rp
    call flapping%motion%phi%set_fourier(0.1_rp, [1.1_rp], [0.2_rp])
    call flapping%motion%alpha%set_fourier(0.2_rp, [0.1_rp], [0.9_rp])
    call flapping%motion%theta%set_constant(0.1_rp)
    frame = flapping%at(0.0_rp)
    call t%check_below('a ramp begins at rest', norm2(frame%omega) + norm2(frame%alpha), 0.0_rp)
    time = 0.8_rp/FREQUENCY
    frame = flapping%at(time)
    call pose_wing(flapping%body, flapping%mount, flapping%motion, 0.8_rp, pose)
    again = frame_of_pose(pose, LENGTH, FREQUENCY, GRAVITY)
    call t%check_below('the frame at a time in seconds', norm2(frame%omega - again%omega)/norm2(frame%omega), &
                       1.0e-13_rp)
    call t%check_below('the hinge of a body at rest does not move', norm2(frame%velocity) + &
                       norm2(frame%acceleration), 0.0_rp)
    call check_identities(flapping, 0.3_rp/FREQUENCY, 1.0e-3_rp/FREQUENCY, 'in the ramp')
    call check_identities(flapping, 0.8_rp/FREQUENCY, 1.0e-3_rp/FREQUENCY, 'behind the ramp')
  end subroutine test_tethered

  !> Both wings of a body that climbs faster and faster while its nose turns up: along the axes of the file of the left
  !> wing, the frame of the right one moves as that of the left one does, in gravity, too.
  subroutine test_mirrored()
    type(flapping_motion_t) :: flapping(2)
    type(frame_t) :: left, right
    real(rp) :: worst(5), scale(5)
    integer :: i
    do i = 1, 2
      associate (f => flapping(i))
        f%body%velocity = [0.5_rp, 0.0_rp, 0.3_rp]
        f%body%acceleration = [2.0_rp, 0.0_rp, -3.0_rp]
        f%body%rotation = body_rotation(roll=angle_t(), pitch=angle_t(-0.4_rp, 1.4_rp, 0.7_rp), yaw=angle_t())
        f%mount%is_right = i == 2
        f%mount%hinge = [0.1_rp, merge(0.2_rp, -0.2_rp, i == 1), 0.05_rp]
        f%mount%eta = -1.1_rp
        f%length = LENGTH
        f%frequency = FREQUENCY
        f%gravity = [1.0_rp, 0.0_rp, -9.0_rp]
        call f%motion%phi%set_fourier(0.1_rp, [1.1_rp], [0.2_rp])
        call f%motion%alpha%set_fourier(0.2_rp, [0.1_rp], [0.9_rp])
        call f%motion%theta%set_fourier(0.1_rp, [0.1_rp], [0.2_rp])
        f%is_mirrored = f%mount%mirrors(z_is_dorsal=.false.)
      end associate
    end do
    call t%check('the right wing mirrors a left one', flapping(2)%is_mirrored .and. .not. flapping(1)%is_mirrored)
    call t%check('a left wing mirrors a right one', flapping(1)%mount%mirrors(z_is_dorsal=.true.) .and. &
                 .not. flapping(2)%mount%mirrors(z_is_dorsal=.true.))
    worst = 0
    scale = 0
    do i = 1, 20
      left = flapping(1)%at(0.0517_rp*i/FREQUENCY)
      right = flapping(2)%at(0.0517_rp*i/FREQUENCY)
      worst = max(worst, [norm2(left%velocity - right%velocity), norm2(left%acceleration - right%acceleration), &
                          norm2(left%omega - right%omega), norm2(left%alpha - right%alpha), &
                          norm2(left%gravity - right%gravity)])
      scale = max(scale, [norm2(left%velocity), norm2(left%acceleration), norm2(left%omega), norm2(left%alpha), &
                          norm2(left%gravity)])
    end do
    ! A dozen products of numbers of order 1.
    call t%check_below('mirrored frames move alike', maxval(worst/scale), 12*epsilon(1.0_rp))
  end subroutine test_mirrored

  subroutine test_rotation(ramp)
    real(rp), intent(in) :: ramp
    type(rotating_motion_t) :: turning
    type(frame_t) :: frame
    real(rp) :: angle, x(3), g(3)
    turning%axis = [1.0_rp, 2.0_rp, 2.0_rp]/3
    turning%through = [0.3_rp, -0.2_rp, 0.4_rp]
    turning%rate = TWO_PI
    turning%ramp = ramp
    turning%gravity = GRAVITY
    frame = turning%at(0.0_rp)
    call t%check_below('a rotation begins with the axes of space', norm2(frame%gravity - GRAVITY), 1.0e-14_rp)
    if (ramp > 0) call check_identities(turning, 0.4_rp*ramp, 1.0e-3_rp, 'of a rotation that begins')
    call check_identities(turning, 0.7_rp, 1.0e-3_rp, 'of a rotation')
    frame = turning%at(0.7_rp)
    call t%check_below('the axis rests', norm2(inertial_velocity(frame, turning%through, [0.0_rp, 0.0_rp, 0.0_rp])), &
                       1.0e-14_rp)
    x = frame%acceleration + cross(frame%omega, cross(frame%omega, turning%through))
    call t%check_below('and is not accelerated', norm2(x), 1.0e-13_rp)
    ! Half a turn after a ramp of duration tau takes half a period and tau/2.
    frame = turning%at(0.5_rp + 0.5_rp*ramp)
    g = 2*dot_product(turning%axis, GRAVITY)*turning%axis - GRAVITY
    call t%check_below('half a turn', norm2(frame%gravity - g), 1.0e-13_rp)
    turning%axis = [0.0_rp, 0.0_rp, 1.0_rp]
    turning%gravity = [1.0_rp, 0.0_rp, 0.0_rp]
    turning%ramp = 0
    angle = PI/6
    frame = turning%at(angle/TWO_PI)
    ! Seen from axes that turn to the left, a fixed direction turns to the right.
    call t%check_below('the sense of the turn', norm2(frame%gravity - [cos(angle), -sin(angle), 0.0_rp]), 1.0e-14_rp)
  end subroutine test_rotation

  !> omega' = alpha; v' + omega x v = acceleration; g' + omega x g = 0: what holds in any moving frame.
  subroutine check_identities(motion, time, step, what)
    class(motion_t), intent(in) :: motion
    real(rp), intent(in) :: time, step
    character(*), intent(in) :: what
    type(frame_t) :: frame, before, after
    real(rp) :: rate(3, 3)
    integer :: j
    rate = 0
    do j = 1, 4
      before = motion%at(time - j*step)
      after = motion%at(time + j*step)
      rate(:, 1) = rate(:, 1) + FIRST(j)/step*(after%omega - before%omega)
      rate(:, 2) = rate(:, 2) + FIRST(j)/step*(after%velocity - before%velocity)
      rate(:, 3) = rate(:, 3) + FIRST(j)/step*(after%gravity - before%gravity)
    end do
    frame = motion%at(time)
    call t%check_below('angular acceleration '//what, norm2(rate(:, 1) - frame%alpha), &
                       1.0e-10_rp*(norm2(frame%omega)/step*1.0e-3_rp))
    call t%check_below('acceleration of the origin '//what, &
                       norm2(rate(:, 2) + cross(frame%omega, frame%velocity) - frame%acceleration), &
                       1.0e-10_rp*max(norm2(frame%acceleration), 1.0_rp))
    call t%check_below('gravity in turning axes '//what, norm2(rate(:, 3) + cross(frame%omega, frame%gravity)), &
                       1.0e-10_rp*norm2(GRAVITY)*norm2(frame%omega))
  end subroutine check_identities
end program test_wing_frame
