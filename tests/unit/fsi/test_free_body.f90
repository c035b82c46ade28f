! SPDX-License-Identifier: GPL-3.0-or-later
!> A free body without a flow: a top that turns, a fall, and wings that flap in a vacuum.
program test_free_body
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_packing, only: pack_value, unpack_value
  use fsi_free_body, only: free_body_t
  use fsi_kinematics, only: body_rotation, body_t, pose_wing, wing_mount_t, wing_pose_t
  use fsi_moments, only: inertia_of_second, moments_of_points, moments_t, second_of_inertia, whole_t
  use fsi_quaternion, only: angles_of, attitude_of, matrix_of, rate_of, spin_of, turned
  use fsi_rotation, only: angle_t, cross
  use fsi_wing_motion, only: wing_motion_t
  use testkit, only: testkit_t
  implicit none
  logical, parameter :: FREE(6) = .false.
  real(rp), parameter :: NOTHING(3) = 0.0_rp
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call check_attitude(kit)
  call check_top(kit)
  call check_fall(kit)
  call check_flapper(kit)
  call check_acceleration(kit)
  call check_held(kit)
  call check_packing(kit)
  call kit%finish()

contains

  !> The quaternion is the attitude of the kinematics, keeps its length, and turns at its angular velocity.
  subroutine check_attitude(kit)
    type(testkit_t), intent(inout) :: kit
    real(rp), parameter :: A(3) = [0.4_rp, -1.1_rp, 2.3_rp], W(3) = [0.7_rp, -0.2_rp, 1.3_rp], H = 1.0e-5_rp
    type(body_t) :: body
    real(rp) :: q(0:3), rate(0:3)
    integer :: i
    body%rotation = body_rotation(roll=angle_t(value=A(1)), pitch=angle_t(value=A(2)), yaw=angle_t(value=A(3)))
    q = attitude_of(A(1), A(2), A(3))
    call kit%check_below('the quaternion of yaw, pitch and roll is that attitude', &
                         maxval(abs(matrix_of(q) - body%rotation%matrix)), 4*epsilon(1.0_rp))
    call kit%check_below('its angles are those', maxval(abs(angles_of(q) - A)), 8*epsilon(1.0_rp))
    rate = (turned(q, H*W) - turned(q, -H*W))/(2*H)
    call kit%check_below('a turn has the rate of its angular velocity', maxval(abs(rate - rate_of(q, W))), 1.0e-9_rp)
    call kit%check_below('which is found again', maxval(abs(spin_of(q, rate_of(q, W)) - W)), 8*epsilon(1.0_rp))
    do i = 1, 100000
      q = turned(q, 0.01_rp*W)
    end do
    call kit%check_below('after 100000 turns its length is 1', abs(norm2(q) - 1), 2*epsilon(1.0_rp))
  end subroutine check_attitude

  !> A rigid body alone.
  pure type(whole_t) function solid(mass, inertia)
    real(rp), intent(in) :: mass, inertia(3)
    real(rp) :: tensor(3, 3)
    integer :: i
    tensor = 0
    do i = 1, 3
      tensor(i, i) = inertia(i)
    end do
    solid%mass = mass
    solid%second = second_of_inertia(tensor)
  end function solid

  !> An asymmetric top without torque: its angular momentum in space is constant, its energy to the order of the scheme.
  subroutine check_top(kit)
    type(testkit_t), intent(inout) :: kit
    real(rp), parameter :: J(3) = [1.0_rp, 2.0_rp, 3.0_rp]
    integer, parameter :: STEPS(3) = [1000, 2000, 4000]
    type(free_body_t) :: top
    type(whole_t) :: whole
    real(rp) :: energy, drift(3), spin(3), change, attitude(0:3, 3)
    integer :: k, i
    whole = solid(2.0_rp, J)
    change = 0
    do k = 1, 3
      top = free_body_t(omega=[0.1_rp, 1.5_rp, 0.2_rp])
      call top%start(whole)
      energy = dot_product(J, top%omega**2)/2
      spin = matmul(J*top%omega, matrix_of(top%attitude))
      do i = 1, STEPS(k)
        call top%accelerate(whole, FREE, NOTHING, NOTHING)
        call top%advance(20.0_rp/STEPS(k), NOTHING, NOTHING)
        call top%settle(whole, FREE)
      end do
      drift(k) = abs(dot_product(J, top%omega**2)/2 - energy)
      change = max(change, maxval(abs(matmul(J*top%omega, matrix_of(top%attitude)) - spin)))
      attitude(:, k) = top%attitude
    end do
    call kit%check_below('the angular momentum of a top in space is constant to round-off', change, 1.0e-13_rp)
    call kit%check_below('its energy over three revolutions, in steps of 0.02', drift(1), 2.0e-3_rp)
    call kit%check_close('the energy drifts at least with the second order', &
                         min(2.0_rp, log(drift(2)/drift(3))/log(2.0_rp)), 2.0_rp, atol=0.15_rp)
    call kit%check_close('the attitude converges with the second order', &
                         log(norm2(attitude(:, 1) - attitude(:, 2))/norm2(attitude(:, 2) - attitude(:, 3)))/log(2.0_rp), &
                         2.0_rp, atol=0.1_rp)
  end subroutine check_top

  !> Free fall with steps of different lengths: exact.
  subroutine check_fall(kit)
    type(testkit_t), intent(inout) :: kit
    real(rp), parameter :: G(3) = [0.3_rp, 0.0_rp, -9.0_rp], V0(3) = [1.0_rp, 2.0_rp, 0.5_rp], M = 3.0_rp
    type(free_body_t) :: body
    type(whole_t) :: whole
    real(rp) :: time, dt
    integer :: i
    whole = solid(M, [1.0_rp, 2.0_rp, 3.0_rp])
    body = free_body_t(velocity=V0)
    call body%start(whole)
    time = 0
    do i = 1, 50
      dt = 0.02_rp*(1 + 0.5_rp*sin(1.0_rp*i))
      call body%accelerate(whole, FREE, M*G, NOTHING)
      call body%advance(dt, M*G, NOTHING)
      call body%settle(whole, FREE)
      time = time + dt
    end do
    call kit%check_below('a fall has the velocity v0 + g t', norm2(body%velocity - V0 - G*time), 1.0e-13_rp)
    call kit%check_below('and the way v0 t + g t^2/2', norm2(body%centre - V0*time - G*time**2/2), 1.0e-13_rp)
  end subroutine check_fall

  !> Two wings of one rigid mass distribution each, that flap and feather: the whole at time t.
  function flapper(t) result(whole)
    real(rp), intent(in) :: t
    type(whole_t) :: whole
    type(wing_mount_t) :: mounts(2)
    type(wing_motion_t) :: motion
    type(wing_pose_t) :: pose
    type(moments_t) :: wing
    integer :: i
    whole = solid(1.0_rp, [0.02_rp, 0.05_rp, 0.04_rp])
    wing = moments_of_points([0.05_rp, 0.02_rp, 0.03_rp], reshape([0.5_rp, 0.1_rp, 0.0_rp, 0.9_rp, -0.2_rp, 0.0_rp, &
                                                                   0.3_rp, -0.1_rp, 0.02_rp], [3, 3]))
    mounts(1) = wing_mount_t(hinge=[0.1_rp, 0.1_rp, 0.05_rp], eta=-0.7_rp)
    mounts(2) = wing_mount_t(is_right=.true., hinge=[0.1_rp, -0.1_rp, 0.05_rp], eta=-0.7_rp)
    do i = 1, 2
      call motion%phi%set_fourier(0.3_rp, [1.1_rp*i, 0.1_rp], [0.2_rp, -0.1_rp])
      call motion%alpha%set_fourier(-0.5_rp, [0.2_rp, 0.1_rp], [0.9_rp/i, 0.2_rp])
      call motion%theta%set_fourier(0.1_rp, [0.2_rp, 0.1_rp], [0.2_rp, 0.3_rp])
      call pose_wing(body_t(), mounts(i), motion, t, pose)
      call whole%add_moving(wing, mounts(i)%hinge, transpose(pose%matrix), pose%omega_relative, pose%omega_relative_rate)
    end do
  end function flapper

  !> Sums over the masses themselves: momentum and angular momentum about the origin of space.
  subroutine sums_of_masses(body, t, linear, angular)
    type(free_body_t), intent(in) :: body
    real(rp), intent(in) :: t
    real(rp), intent(out) :: linear(3), angular(3)
    type(whole_t) :: whole
    type(wing_mount_t) :: mounts(2)
    type(wing_motion_t) :: motion
    type(wing_pose_t) :: pose
    real(rp), parameter :: MU(3) = [0.05_rp, 0.02_rp, 0.03_rp]
    real(rp) :: x(3, 3)
    integer :: i, k
    whole = solid(1.0_rp, [0.02_rp, 0.05_rp, 0.04_rp])
    x = reshape([0.5_rp, 0.1_rp, 0.0_rp, 0.9_rp, -0.2_rp, 0.0_rp, 0.3_rp, -0.1_rp, 0.02_rp], [3, 3])
    mounts(1) = wing_mount_t(hinge=[0.1_rp, 0.1_rp, 0.05_rp], eta=-0.7_rp)
    mounts(2) = wing_mount_t(is_right=.true., hinge=[0.1_rp, -0.1_rp, 0.05_rp], eta=-0.7_rp)
    linear = whole%mass*body%velocity
    angular = cross(body%centre, linear) + matmul(matmul(whole%inertia(), body%omega), matrix_of(body%attitude))
    do i = 1, 2
      call motion%phi%set_fourier(0.3_rp, [1.1_rp*i, 0.1_rp], [0.2_rp, -0.1_rp])
      call motion%alpha%set_fourier(-0.5_rp, [0.2_rp, 0.1_rp], [0.9_rp/i, 0.2_rp])
      call motion%theta%set_fourier(0.1_rp, [0.2_rp, 0.1_rp], [0.2_rp, 0.3_rp])
      call pose_wing(body%body(), mounts(i), motion, t, pose)
      do k = 1, 3
        linear = linear + MU(k)*pose%velocity_at(x(:, k))
        angular = angular + MU(k)*cross(pose%point_to_space(x(:, k)), pose%velocity_at(x(:, k)))
      end do
    end do
  end subroutine sums_of_masses

  !> A body with two wings that flap unlike each other, far from the origin: both momenta, as sums over the masses, are
  !> constant to round-off; the path has the second order.
  subroutine check_flapper(kit)
    type(testkit_t), intent(inout) :: kit
    type(free_body_t) :: body
    real(rp) :: linear(3, 2), angular(3, 2), change(2), dt, centre(3, 3), time
    integer :: k, i, n
    change = 0
    do k = 1, 3
      n = 200*2**k
      dt = 2.0_rp/n
      body = free_body_t(centre=[3.0_rp, 1.0_rp, 2.0_rp], velocity=[0.4_rp, 0.0_rp, -0.3_rp], &
                         attitude=attitude_of(0.2_rp, -0.3_rp, 0.5_rp), omega=[0.2_rp, -0.1_rp, 0.3_rp])
      call body%start(flapper(0.0_rp))
      call sums_of_masses(body, 0.0_rp, linear(:, 1), angular(:, 1))
      do i = 1, n
        time = dt*i
        call body%accelerate(flapper(time - dt), FREE, NOTHING, NOTHING)
        call body%advance(dt, NOTHING, NOTHING)
        call body%settle(flapper(time), FREE)
        call sums_of_masses(body, time, linear(:, 2), angular(:, 2))
        change = max(change, [norm2(linear(:, 2) - linear(:, 1)), norm2(angular(:, 2) - angular(:, 1))])
      end do
      centre(:, k) = body%centre
    end do
    ! Round-off of 1600 steps of numbers of order 1.
    call kit%check_below('two wings that flap in a vacuum keep the momentum of the insect', change(1), 1.0e-13_rp)
    call kit%check_below('and its angular momentum', change(2), 1.0e-12_rp)
    call kit%check('although the body moves about', norm2(body%velocity - [0.4_rp, 0.0_rp, -0.3_rp]) > 0.01_rp)
    call kit%check_close('the path converges with the second order', &
                         log(norm2(centre(:, 1) - centre(:, 2))/norm2(centre(:, 2) - centre(:, 3)))/log(2.0_rp), &
                         2.0_rp, atol=0.15_rp)
  end subroutine check_flapper

  !> `accelerate` is the derivative of the velocities along the motion, with forces.
  subroutine check_acceleration(kit)
    type(testkit_t), intent(inout) :: kit
    real(rp), parameter :: F(3) = [0.5_rp, -0.2_rp, 0.9_rp], T(3) = [0.05_rp, 0.1_rp, -0.04_rp], AT = 0.37_rp
    type(free_body_t) :: before, after
    real(rp) :: h, error(2), rate(6), found(6)
    integer :: k
    do k = 1, 2
      h = 1.0e-4_rp/k
      before = free_body_t(velocity=[0.4_rp, 0.0_rp, -0.3_rp], attitude=attitude_of(0.2_rp, -0.3_rp, 0.5_rp), &
                           omega=[1.2_rp, -0.6_rp, 0.9_rp])
      call before%start(flapper(AT))
      after = before
      call before%accelerate(flapper(AT), FREE, F, T)
      found = [before%acceleration, before%omega_rate]
      call after%accelerate(flapper(AT), FREE, F, T)
      call after%advance(h, F, T)
      call after%settle(flapper(AT + h), FREE)
      rate = [after%velocity - before%velocity, after%omega - before%omega]/h
      error(k) = norm2(rate - found)/norm2(found)
    end do
    call kit%check_below('the acceleration is the derivative of the velocities', error(2), 1.0e-2_rp)
    call kit%check_close('to the order of a one-sided difference', error(1)/error(2), 2.0_rp, atol=0.05_rp)
  end subroutine check_acceleration

  !> What is held stays; the free turn about one axis is that of a wheel; reactions along moving axes have the second order.
  subroutine check_held(kit)
    type(testkit_t), intent(inout) :: kit
    type(free_body_t) :: body
    real(rp) :: attitude(0:3, 3), dt, t
    integer :: k, i, n
    do k = 1, 3
      n = 100*2**k
      dt = 2.0_rp/n
      body = free_body_t(velocity=[0.4_rp, 0.1_rp, -0.3_rp], omega=[0.7_rp, 0.3_rp, -0.2_rp])
      call body%start(flapper(0.0_rp))
      do i = 1, n
        t = dt*(i - 1)
        call body%accelerate(flapper(t), [.true., .false., .true., .false., .true., .false.], [1.0_rp, cos(t), 0.3_rp], &
                             [0.3_rp, 0.2_rp, 0.1_rp])
        call body%advance(dt, [1.0_rp, cos(t), 0.3_rp], [0.3_rp, 0.2_rp, 0.1_rp])
        call body%settle(flapper(t + dt), [.true., .false., .true., .false., .true., .false.])
      end do
      attitude(:, k) = body%attitude
    end do
    call kit%check('a direction that is held keeps its velocity', all(abs(body%velocity([1, 3]) - [0.4_rp, -0.3_rp]) <= 0))
    call kit%check('a rotation that is held keeps its angular velocity', abs(body%omega(2) - 0.3_rp) <= 0)
    call kit%check('the others move', abs(body%velocity(2) - 0.1_rp) > 0.1_rp .and. abs(body%omega(1) - 0.7_rp) > 0.1_rp)
    call kit%check_close('the attitude of a body that is held about one axis has the second order', &
                         log(norm2(attitude(:, 1) - attitude(:, 2))/norm2(attitude(:, 2) - attitude(:, 3)))/log(2.0_rp), &
                         2.0_rp, atol=0.15_rp)
    body = free_body_t()
    call body%start(solid(1.0_rp, [0.1_rp, 0.5_rp, 2.0_rp]))
    do i = 1, 10
      call body%accelerate(solid(1.0_rp, [0.1_rp, 0.5_rp, 2.0_rp]), [.true., .true., .true., .true., .false., .true.], &
                           NOTHING, [0.3_rp, 0.2_rp, 0.1_rp])
      call body%advance(0.1_rp, NOTHING, [0.3_rp, 0.2_rp, 0.1_rp])
      call body%settle(solid(1.0_rp, [0.1_rp, 0.5_rp, 2.0_rp]), [.true., .true., .true., .true., .false., .true.])
    end do
    call kit%check_close('a pitch that alone is free has the angular acceleration T/J', body%omega(2), 0.4_rp, &
                         atol=1.0e-14_rp)
    call kit%check_close('and has turned by T/J t^2/2', 2*asin(body%attitude(2)), 0.2_rp, atol=1.0e-13_rp)
  end subroutine check_held

  !> A state that was packed goes on to the same bits.
  subroutine check_packing(kit)
    type(testkit_t), intent(inout) :: kit
    type(free_body_t) :: body, copy
    type(whole_t) :: whole
    type(failure_t) :: failure
    real(rp), allocatable :: packed(:), other(:)
    integer :: i
    whole = flapper(0.3_rp)
    body = free_body_t(velocity=[0.4_rp, 0.1_rp, -0.3_rp], omega=[0.7_rp, 0.3_rp, -0.2_rp])
    call body%start(whole)
    do i = 1, 3
      call body%accelerate(whole, FREE, [1.0_rp, 2.0_rp, 3.0_rp], [0.1_rp, 0.2_rp, 0.3_rp])
      call body%advance(0.01_rp*i, [1.0_rp, 2.0_rp, 3.0_rp], [0.1_rp, 0.2_rp, 0.3_rp])
      call body%settle(whole, FREE)
      if (i == 2) call pack_value(body, packed)
      if (i == 2) call unpack_value(packed, copy, failure)
      if (i < 3) cycle
      call copy%accelerate(whole, FREE, [1.0_rp, 2.0_rp, 3.0_rp], [0.1_rp, 0.2_rp, 0.3_rp])
      call copy%advance(0.01_rp*i, [1.0_rp, 2.0_rp, 3.0_rp], [0.1_rp, 0.2_rp, 0.3_rp])
      call copy%settle(whole, FREE)
    end do
    call pack_value(body, packed)
    call pack_value(copy, other)
    call kit%check('a packed state goes on to the bit', .not. failure%failed .and. all(abs(other - packed) <= 0))
    call kit%check_below('the inertia of the second moments of an inertia is that', &
                         maxval(abs(inertia_of_second(second_of_inertia(whole%inertia())) - whole%inertia())), 1.0e-15_rp)
  end subroutine check_packing
end program test_free_body
