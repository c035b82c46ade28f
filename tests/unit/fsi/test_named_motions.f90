! SPDX-License-Identifier: GPL-3.0-or-later
!> Motions that FLUSI knows by name: its angles and rates (of its own routine; some of its literals have single precision,
!> which limits the agreement), and rates and accelerations that are the derivatives of the angles.
program test_named_motions
  use base_constants, only: PI
  use base_kinds, only: rp
  use base_text, only: next_word
  use fsi_named_motions, only: NAMED_MOTIONS, set_named_motion
  use fsi_body_motion, only: body_motion_t, MOTION_WHEELING, SWINGS
  use fsi_kinematics, only: body_t
  use fsi_rotation, only: angle_t, cross
  use fsi_wing_motion, only: wing_motion_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: kit
  real(rp), parameter :: RESTING = 0.3_rp, FREQUENCY = 0.5_rp

  call kit%start(parallel=.false.)
  call check_flusi(kit)
  call check_archive(kit)
  call check_derivatives(kit)
  call check_turning(kit)
  call check_bodies(kit)
  call kit%finish()

contains

  !> phi, alpha, theta and their rates in radians and cycles.
  subroutine check_flusi(kit)
    type(testkit_t), intent(inout) :: kit
    call hold(kit, 'debug', 0.30_rp, [0.0_rp, -0.785398163_rp, 0.0_rp, 0.0_rp, 0.0_rp, 0.0_rp])
    call hold(kit, 'debug', 1.20_rp, [0.0_rp, -0.785398163_rp, 0.0_rp, 0.0_rp, 0.0_rp, 0.0_rp])
    call hold(kit, 'debug2', 0.30_rp, [0.0_rp, 0.785398163_rp, 0.0_rp, 0.0_rp, 0.0_rp, 0.0_rp])
    call hold(kit, 'debug2', 1.20_rp, [0.0_rp, 0.785398163_rp, 0.0_rp, 0.0_rp, 0.0_rp, 0.0_rp])
    call hold(kit, 'Drosophila_hovering_fry', 0.30_rp, [-0.0702547854_rp, 0.941657002_rp, -0.0475152891_rp, &
              -6.84843359_rp, -2.11054732_rp, 0.468538941_rp])
    call hold(kit, 'Drosophila_hovering_fry', 1.20_rp, [0.625216188_rp, 1.07369483_rp, -0.140178093_rp, &
              -6.67847792_rp, -1.55788166_rp, 1.34747045_rp])
    call hold(kit, 'Drosophila_hovering_sun', 0.30_rp, [0.837914606_rp, -0.647882014_rp, 0.0321287643_rp, &
              6.25175348_rp, -1.89801291_rp, -0.810121976_rp])
    call hold(kit, 'Drosophila_hovering_sun', 1.20_rp, [0.13180818_rp, -0.976882181_rp, 0.0373881128_rp, &
              8.54287982_rp, 7.18591545_rp, 1.35934925_rp])
    call hold(kit, 'Drosophila_hovering_maeda', 0.30_rp, [-0.0701093804_rp, 0.825702351_rp, -0.0420777634_rp, &
              -6.45440506_rp, -2.04163596_rp, 0.556111835_rp])
    call hold(kit, 'Drosophila_hovering_maeda', 1.20_rp, [0.619911359_rp, 1.18814665_rp, -0.155466697_rp, &
              -7.02410805_rp, -3.1440494_rp, 1.52170888_rp])
    call hold(kit, 'flapper_sane', 0.30_rp, [-0.314177704_rp, 1.57003962_rp, 0.0_rp, -6.2852259_rp, &
              -0.0269694634_rp, 0.0_rp])
    call hold(kit, 'flapper_sane', 1.20_rp, [0.314177704_rp, 1.57003962_rp, 0.0_rp, -6.2852259_rp, 0.0269694634_rp, &
              0.0_rp])
    call hold(kit, 'flapper_dickinson', 0.30_rp, [-0.27925268_rp, 0.860413376_rp, 0.0_rp, -5.5850535_rp, &
              -0.836138198_rp, 0.0_rp])
    call hold(kit, 'flapper_dickinson', 1.20_rp, [0.27925268_rp, 0.872664329_rp, 0.0_rp, -5.5850535_rp, &
              -4.35621064e-05_rp, 0.0_rp])
    call hold(kit, 'flapper_ramamurti', 0.30_rp, [-0.88078579_rp, -0.865442639_rp, 0.0_rp, 6.13618833_rp, &
              -0.397844999_rp, 0.0_rp])
    call hold(kit, 'flapper_ramamurti', 1.20_rp, [-1.19280328_rp, -0.559172509_rp, 0.0_rp, -2.43275076_rp, &
              -7.1405694_rp, 0.0_rp])
    call hold(kit, 'suzuki', 0.30_rp, [-0.43146912_rp, 0.784583793_rp, 0.0_rp, -8.3436014_rp, -0.037785252_rp, &
              0.0_rp])
    call hold(kit, 'suzuki', 1.20_rp, [0.43146912_rp, 0.784583793_rp, 0.0_rp, -8.3436014_rp, 0.037785252_rp, 0.0_rp])
    call hold(kit, 'simplified', 0.30_rp, [-0.43146912_rp, 0.746958041_rp, 0.0_rp, -8.3436014_rp, -1.52493774_rp, &
              0.0_rp])
    call hold(kit, 'simplified', 1.20_rp, [0.43146912_rp, 0.746958041_rp, 0.0_rp, -8.3436014_rp, 1.52493774_rp, &
              0.0_rp])
    call hold(kit, 'simplified2', 0.30_rp, [-0.32360184_rp, 0.0_rp, 0.0_rp, -6.25770105_rp, -0.0_rp, 0.0_rp])
    call hold(kit, 'simplified2', 1.20_rp, [0.32360184_rp, 0.0_rp, 0.0_rp, -6.25770105_rp, 0.0_rp, 0.0_rp])
    call hold(kit, 'revolving-set1', 0.30_rp, [0.488946626_rp, -0.785398163_rp, 0.0_rp, 0.527633442_rp, 0.0_rp, &
              0.0_rp])
    call hold(kit, 'revolving-set1', 1.20_rp, [1.21991483_rp, -0.785398163_rp, 0.0_rp, 0.950212929_rp, 0.0_rp, &
              0.0_rp])
    call hold(kit, 'revolving-set2', 0.30_rp, [0.0572957795_rp, -0.3_rp, 0.0_rp, 0.381971863_rp, 0.0_rp, 0.0_rp])
    call hold(kit, 'revolving-set2', 1.20_rp, [0.807300918_rp, -0.3_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp])
    call hold(kit, 'revolving-set3', 0.30_rp, [0.114591559_rp, -0.3_rp, 0.0_rp, 0.763943727_rp, 0.0_rp, 0.0_rp])
    call hold(kit, 'revolving-set3', 1.20_rp, [1.00365046_rp, -0.3_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp])
    call hold(kit, 'revolving-clock', 0.30_rp, [-0.558868096_rp, 0.785398163_rp, 0.0_rp, -3.31521869_rp, 0.0_rp, &
              0.0_rp])
    call hold(kit, 'revolving-clock', 1.20_rp, [-5.15167677_rp, 0.785398163_rp, 0.0_rp, -5.97036392_rp, 0.0_rp, &
              0.0_rp])
    call hold(kit, 'revolving-anticlock', 0.30_rp, [0.558868096_rp, -0.785398163_rp, 0.0_rp, 3.31521869_rp, 0.0_rp, &
              0.0_rp])
    call hold(kit, 'revolving-anticlock', 1.20_rp, [5.15167677_rp, -0.785398163_rp, 0.0_rp, 5.97036392_rp, 0.0_rp, &
              0.0_rp])
  end subroutine check_flusi

  !> FLUSI's file kinematics.t of its test insects_mask_jerry, 9 digits: a wing each of two motions at t = 0 and 1/2.
  subroutine check_archive(kit)
    type(testkit_t), intent(inout) :: kit
    call hold_angles(kit, 'flapper_dickinson', 0.0_rp, [1.23771337_rp, 7.61596053e-1_rp, 0.0_rp])
    call hold_angles(kit, 'flapper_dickinson', 0.5_rp, [-1.23771337_rp, -7.61596053e-1_rp, 0.0_rp])
    call hold_angles(kit, 'Drosophila_hovering_fry', 0.0_rp, [1.50497837_rp, -1.60553432e-1_rp, -3.67277216e-1_rp])
    call hold_angles(kit, 'Drosophila_hovering_fry', 0.5_rp, [-9.66044146e-1_rp, 1.92675635e-1_rp, -2.17489917e-1_rp])
  end subroutine check_archive

  subroutine hold_angles(kit, name, t, want)
    type(testkit_t), intent(inout) :: kit
    character(*), intent(in) :: name
    real(rp), intent(in) :: t, want(3)
    real(rp) :: got(3, 0:2)
    got = angles_of(name, t, 1.0_rp)
    call kit%check_below(name//': the angles of FLUSI''s test archive', maxval(abs(got(:, 0) - want)), 1.0e-7_rp)
  end subroutine hold_angles

  subroutine hold(kit, name, t, want)
    type(testkit_t), intent(inout) :: kit
    character(*), intent(in) :: name
    real(rp), intent(in) :: t, want(6)
    real(rp) :: got(3, 0:2)
    got = angles_of(name, t, 1.0_rp)
    call kit%check_below(name//': angles', maxval(abs(got(:, 0) - want(:3))), 2.0e-7_rp)
    call kit%check_below(name//': rates', maxval(abs(got(:, 1) - want(4:))), 4.0e-6_rp)
  end subroutine hold

  !> phi, alpha, theta (rows); value, rate, acceleration (columns).
  function angles_of(name, t, frequency) result(angles)
    character(*), intent(in) :: name
    real(rp), intent(in) :: t, frequency
    real(rp) :: angles(3, 0:2)
    type(wing_motion_t) :: motion
    type(angle_t) :: phi, alpha, theta
    logical :: known
    motion%frequency = frequency
    call set_named_motion(name, RESTING, motion, known)
    call motion%evaluate(t, phi, alpha, theta)
    angles(:, 0) = [phi%value, alpha%value, theta%value]
    angles(:, 1) = [phi%rate, alpha%rate, theta%rate]
    angles(:, 2) = [phi%acceleration, alpha%acceleration, theta%acceleration]
  end function angles_of

  !> Central differences with the step h are wrong by h^2/6 times the third derivative: of a series with N harmonics of
  !> size a that is (2 pi f N)^3 a h^2/6, 2e-5 for the rate and 2e-3 for the acceleration.
  subroutine check_derivatives(kit)
    type(testkit_t), intent(inout) :: kit
    real(rp), parameter :: H = 1.0e-5_rp, T = 1.37_rp
    real(rp) :: low(3, 0:2), at(3, 0:2), high(3, 0:2)
    integer :: position, first, last, n
    logical :: found, known
    type(wing_motion_t) :: motion
    position = 1
    n = 0
    do
      call next_word(NAMED_MOTIONS, '|', position, first, last, found)
      if (.not. found) exit
      n = n + 1
      associate (name => NAMED_MOTIONS(first:last))
        low = angles_of(name, T - H, FREQUENCY)
        at = angles_of(name, T, FREQUENCY)
        high = angles_of(name, T + H, FREQUENCY)
        call kit%check_below(name//': rates are the derivatives of the angles', &
                             maxval(abs((high(:, 0) - low(:, 0))/(2*H) - at(:, 1))), 1.0e-7_rp)
        call kit%check_below(name//': accelerations are the derivatives of the rates', &
                             maxval(abs((high(:, 1) - low(:, 1))/(2*H) - at(:, 2))), 1.0e-5_rp)
      end associate
    end do
    call kit%check('all names are known', n == 17)
    call set_named_motion('Drosophila_hovering', RESTING, motion, known)
    call kit%check('another one is not', .not. known)
  end subroutine check_derivatives

  !> A wing that revolves has the speed of its rate, and no stroke that repeats.
  subroutine check_turning(kit)
    type(testkit_t), intent(inout) :: kit
    type(wing_motion_t) :: motion
    real(rp) :: low, high
    logical :: known
    call set_named_motion('revolving-anticlock', RESTING, motion, known)
    call motion%stroke_extremes(low, high)
    call kit%check_close('a turn in a cycle', high - low, 2*PI, 1.0e-9_rp)
    call kit%check_close('is its path', motion%stroke_path(), 2*PI, 1.0e-9_rp)
    call kit%check('it does not repeat', .not. motion%phi%is_periodic())
    call set_named_motion('revolving-set2', RESTING, motion, known)
    call kit%check_close('a radian in a cycle', motion%stroke_path(), 1.0_rp, 1.0e-9_rp)
  end subroutine check_turning

  !> Bodies that move by a word: velocity and acceleration are the derivatives of the place, the angular velocity that of
  !> the attitude, M' = -omega x M.
  subroutine check_bodies(kit)
    type(testkit_t), intent(inout) :: kit
    real(rp), parameter :: H = 1.0e-5_rp, T = 1.37_rp
    type(body_motion_t) :: motion
    type(body_t) :: still, low, at, high
    real(rp) :: change(3, 3), turned(3, 3)
    integer :: i, k
    motion%centre = [1.0_rp, 2.0_rp, 3.0_rp]
    motion%velocity = [0.1_rp, -0.2_rp, 0.3_rp]
    do i = 1, size(SWINGS)
      motion%kind = SWINGS(i)%kind
      low = motion%at(T - H, still)
      at = motion%at(T, still)
      high = motion%at(T + H, still)
      change = (high%rotation%matrix - low%rotation%matrix)/(2*H)
      do k = 1, 3
        turned(:, k) = -cross(at%rotation%omega, at%rotation%matrix(:, k))
      end do
      call kit%check_below(trim(SWINGS(i)%word)//': velocity', maxval(abs((high%centre - low%centre)/(2*H) - &
                                                                       at%velocity)), 1.0e-8_rp)
      call kit%check_below(trim(SWINGS(i)%word)//': acceleration', maxval(abs((high%velocity - low%velocity)/(2*H) - &
                                                                           at%acceleration)), 1.0e-8_rp)
      call kit%check_below(trim(SWINGS(i)%word)//': angular velocity', maxval(abs(change - turned)), 1.0e-7_rp)
    end do
    motion%kind = MOTION_WHEELING
    at = motion%at(5.0_rp, still)
    call kit%check_below('wheeling: a quarter of the circle in 5 T', norm2(at%centre - [2.5_rp, 2.0_rp, 3.0_rp]) + &
                         norm2(at%angles - [-PI/6, 0.0_rp, PI/2]), 1.0e-14_rp)
  end subroutine check_bodies
end program test_named_motions
