! SPDX-License-Identifier: GPL-3.0-or-later
!> Motions of the body: FLUSI's words, tables of a flight, and what a free flight knows.
program test_body_motion
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fsi_body_motion, only: body_motion_t, MOTION_BUFFETING, MOTION_CASTING, MOTION_FREE, MOTION_PITCH_PARAM, MOTION_TABLE, &
                             MOTION_TETHERED, MOTION_WHEELING, MOTION_YAWPITCHROLL, SWINGS
  use fsi_body_motion_keys, only: read_flight_table, scale_way
  use fsi_kinematics, only: body_t
  use fsi_quaternion, only: attitude_of
  use fsi_wing_motion_table, only: read_body_states
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = new_line('a')
  type(testkit_t) :: kit

  call kit%start(parallel=.false.)
  call check_words(kit)
  call check_table(kit)
  call check_scaled(kit)
  call check_loader(kit)
  call check_known(kit)
  call check_mean_speed(kit)
  call kit%finish()

contains

  !> Rates and accelerations are the derivatives of place and attitude.
  subroutine check_derivatives(kit, motion, name, t, tolerance)
    type(testkit_t), intent(inout) :: kit
    type(body_motion_t), intent(in) :: motion
    character(*), intent(in) :: name
    real(rp), intent(in) :: t, tolerance
    real(rp), parameter :: H = 1.0e-4_rp
    type(body_t) :: a, b, m
    real(rp) :: turn(3, 3), error(4)
    a = motion%at(t - H, body_t())
    b = motion%at(t + H, body_t())
    m = motion%at(t, body_t())
    ! M' = -[omega] x M
    turn = -matmul((b%rotation%matrix - a%rotation%matrix)/(2*H), transpose(m%rotation%matrix))
    error = [norm2((b%centre - a%centre)/(2*H) - m%velocity), norm2((b%velocity - a%velocity)/(2*H) - m%acceleration), &
             norm2([turn(3, 2), turn(1, 3), turn(2, 1)] - m%rotation%omega), &
             norm2((b%rotation%omega - a%rotation%omega)/(2*H) - m%rotation%omega_rate)]
    call kit%check_below(name//': velocities and accelerations are derivatives', maxval(error), tolerance)
  end subroutine check_derivatives

  subroutine check_words(kit)
    type(testkit_t), intent(inout) :: kit
    type(body_motion_t) :: motion
    type(body_t) :: body
    integer :: i
    motion%centre = [1.0_rp, 2.0_rp, 3.0_rp]
    motion%velocity = [0.1_rp, 0.0_rp, 0.2_rp]
    motion%angles = [0.1_rp, 0.2_rp, 0.3_rp]
    do i = 1, size(SWINGS)
      motion%kind = SWINGS(i)%kind
      ! The fourth derivative of 30 degrees sin(2 pi t) times H^2/6 is 1.4e-6, of products of three such angles a few times it.
      call check_derivatives(kit, motion, trim(SWINGS(i)%word), 0.37_rp, 2.0e-5_rp)
    end do
    motion%kind = MOTION_YAWPITCHROLL
    body = motion%at(0.25_rp, body_t())
    call kit%check_below('after a quarter of T yawpitchroll is at 30 degrees', maxval(abs(body%angles - PI/6)), 1.0e-14_rp)
    call kit%check_below('and has moved on', norm2(body%centre - [1.025_rp, 2.0_rp, 3.05_rp]), 1.0e-14_rp)
    motion%kind = MOTION_PITCH_PARAM
    body = motion%at(0.0_rp, body_t())
    call kit%check_below('pitch_param begins 15 degrees above its pitch', &
                         maxval(abs(body%angles - [0.1_rp, 0.2_rp + PI/12, 0.3_rp])), 1.0e-14_rp)
    motion%kind = MOTION_CASTING
    body = motion%at(19.0_rp, body_t())
    call kit%check_close('casting is at its largest y after a quarter of 76 T', body%centre(2), 2 + 22/13.2_rp, atol=1.0e-13_rp)
  end subroutine check_words

  !> A table of a motion that is known.
  subroutine check_table(kit)
    type(testkit_t), intent(inout) :: kit
    type(body_motion_t) :: motion, swing
    type(body_t) :: found, want
    type(message_list_t) :: errors
    character(:), allocatable :: text
    character(400) :: row
    real(rp) :: error(2), t
    integer :: i, k, n
    swing%kind = MOTION_YAWPITCHROLL
    swing%velocity = [0.1_rp, 0.0_rp, 0.2_rp]
    error = 0
    do k = 1, 2
      n = 20*k
      text = '% time [T] x y z'//NL//NL
      do i = 0, n
        t = real(i, rp)/n
        want = curve(swing, t)
        write (row, '(14es24.16)') t, want%centre, want%velocity, &
          attitude_of(want%angles(1), want%angles(2), want%angles(3)), want%rotation%omega
        text = text//trim(row)//NL
      end do
      call read_flight_table(text, 'flight.t', motion%table, errors)
      motion%kind = MOTION_TABLE
      do i = 0, 100
        want = curve(swing, 0.01_rp*i)
        found = motion%at(0.01_rp*i, body_t())
        error(k) = max(error(k), maxval(abs(found%rotation%matrix - want%rotation%matrix)), norm2(found%centre - want%centre))
      end do
    end do
    call kit%check('a table of a flight is read', errors%count() == 0)
    call kit%check_close('between its rows the attitude is cubic: fourth order', log(error(1)/error(2))/log(2.0_rp), 4.0_rp, &
                         atol=0.4_rp)
    call check_derivatives(kit, motion, 'table', 0.373_rp, 2.0e-4_rp)
    call read_flight_table('0 0 0 0 0 0 0 1 0 0 0 0 0'//NL, 'bad.t', motion%table, errors)
    call read_flight_table('0 0 0 0 0 0 0 1 0 0 0 0 0 0'//NL//'0 0 0 0 0 0 0 1 0 0 0 0 0 0'//NL, 'bad.t', motion%table, errors)
    call read_flight_table('0 0 0 0 0 0 0 1 1 0 0 0 0 0'//NL//'1 0 0 0 0 0 0 1 0 0 0 0 0 0'//NL, 'bad.t', motion%table, errors)
    call kit%check('a short row, a time that stands and a quaternion of another length are refused', errors%count() == 3)
  end subroutine check_table

  !> A way that is larger by a factor keeps its middle, although the table goes on for a part of a beat. Of a part of a beat alone
  !> it keeps the mean of that part. Rows of equal distance give the mean of a sine over whole beats exactly.
  subroutine check_scaled(kit)
    type(testkit_t), intent(inout) :: kit
    integer, parameter :: N = 40
    real(rp), parameter :: F = 0.25_rp, MIDDLE(3) = [1.0_rp, 2.0_rp, 3.0_rp], FACTOR = 1.5_rp
    real(rp) :: table(14, 0:2*N + N/4), small(14, 0:N/2)
    integer :: i
    table = 0
    do i = 0, ubound(table, 2)
      associate (angle => 2*PI*i/N)
        table(1, i) = i/(N*F) + 7
        table(2:4, i) = MIDDLE + sin(angle + [0.0_rp, 1.0_rp, 2.0_rp])
        table(5:7, i) = cos(angle + [0.0_rp, 1.0_rp, 2.0_rp])
      end associate
    end do
    small = table(:, :N/2)
    call scale_way(FACTOR, F, table)
    call kit%check_below('the middle stays', &
                         maxval(abs(table(2:4, 3) - MIDDLE - FACTOR*sin(2*PI*3/N + [0.0_rp, 1.0_rp, 2.0_rp]))), 1.0e-13_rp)
    call kit%check_below('velocities follow', abs(table(5, 3) - FACTOR*cos(2*PI*3/N)), 1.0e-14_rp)
    call scale_way(FACTOR, F, small)
    call kit%check('half a beat has its own mean', small(2, 0) < MIDDLE(1) - 0.3_rp)
  end subroutine check_scaled

  !> A take-off in a table of FLUSI: horz and vert are cubics of time, the pitch is one, too.
  subroutine check_loader(kit)
    type(testkit_t), intent(inout) :: kit
    type(body_motion_t) :: motion
    type(body_t) :: body
    type(message_list_t) :: errors
    character(:), allocatable :: text
    character(400) :: row
    real(rp), parameter :: PERIOD = 4, LENGTH = 2, START(3) = [2.0_rp, 1.5_rp, 0.86_rp]
    real(rp) :: t, error(2)
    integer :: i
    text = '4'//NL//'2'//NL//'11'//NL
    do i = 0, 10
      t = 0.8_rp*i
      write (row, '(13es24.16)') t, 0.0_rp, 0.0_rp, 0.0_rp, 5 + 2*t + 0.9_rp*t**2, 0.5_rp*t**2, t**3 - t, &
        0.0_rp, 0.0_rp, 0.0_rp, 2 + 1.8_rp*t, t, 3*t**2 - 1
      text = text//trim(row)//NL
    end do
    call read_body_states(text, 'data_kin.dat', START, motion%table, errors)
    motion%kind = MOTION_TABLE
    call kit%check('a take-off is read', errors%count() == 0)
    error = 0
    do i = 0, 40
      t = 0.2_rp*i
      body = motion%at(t/PERIOD, body_t())
      error(1) = max(error(1), norm2(body%centre - START - [t**3 - t, 0.0_rp, 0.5_rp*t**2]/LENGTH), &
                     norm2(body%velocity - [3*t**2 - 1, 0.0_rp, t]*PERIOD/LENGTH))
      error(2) = max(error(2), maxval(abs(body%angles + [0.0_rp, 5 + 2*t + 0.9_rp*t**2, 0.0_rp]*PI/180)))
    end do
    ! The largest coordinate is 254; speeds are 4 times as large as their rounding.
    call kit%check_below('cubics of the way are exact', error(1), 1.0e-12_rp)
    ! h^4/384 of the fourth derivative of the quaternion, 3e-3 where the pitch is fastest, with h = 0.8; twice that as an angle.
    call kit%check_below('nose up is a negative pitch, to fourth order', error(2), 7.0e-6_rp)
    call check_derivatives(kit, motion, 'take-off', 0.93_rp, 2.0e-3_rp)
  end subroutine check_loader

  !> A body that swings, and whose centre goes along a wave.
  function curve(swing, t) result(body)
    type(body_motion_t), intent(in) :: swing
    real(rp), intent(in) :: t
    type(body_t) :: body
    body = swing%at(t, body_t())
    body%centre(1) = body%centre(1) + sin(3*t)
    body%velocity(1) = body%velocity(1) + 3*cos(3*t)
  end function curve

  !> A free flight is known at the last two times that were shown; a later word about the same time replaces the earlier.
  subroutine check_known(kit)
    type(testkit_t), intent(inout) :: kit
    type(body_motion_t) :: motion
    type(body_t) :: body
    motion%kind = MOTION_FREE
    body%centre = 1
    call motion%show(0.1_rp, body)
    body%centre = 2
    call motion%show(0.2_rp, body)
    body%centre = 3
    call motion%show(0.2_rp, body)
    body = motion%at(0.1_rp, body_t())
    call kit%check('the time before is still known', all(abs(body%centre - 1) <= 0))
    body = motion%at(0.2_rp + 1.0e-12_rp, body_t())
    call kit%check('and the last word about the last time', all(abs(body%centre - 3) <= 0))
    motion%kind = MOTION_TETHERED
    body%centre = 7
    body = motion%at(0.2_rp, body)
    call kit%check('a tethered body is where it is', all(abs(body%centre - 7) <= 0) .and. .not. motion%moves())
  end subroutine check_known

  !> Mean speeds are those of the motion: of a period, of the whole table however its rows are spaced.
  subroutine check_mean_speed(kit)
    type(testkit_t), intent(inout) :: kit
    type(body_motion_t) :: motion
    motion%velocity = [0.3_rp, 0.0_rp, 0.4_rp]
    motion%known%velocity(1) = 7
    call kit%check_below('a tethered body has no speed', motion%mean_speed(), tiny(1.0_rp))
    motion%kind = MOTION_FREE
    call kit%check_close('a free flight has that of its start', motion%mean_speed(), 7.0_rp, atol=1.0e-14_rp)
    motion%kind = MOTION_YAWPITCHROLL
    call kit%check_close('yawpitchroll goes straight on', motion%mean_speed(), 0.5_rp, atol=1.0e-12_rp)
    motion%kind = MOTION_WHEELING
    call kit%check_close('wheeling goes round in 20 T', motion%mean_speed(), 3*PI/20, atol=1.0e-12_rp)
    ! A beat is four ways of the amplitude. The midpoints of 2000 pieces err by pi^2/(24 1000^2) = 4e-7 of the mean.
    motion%kind = MOTION_CASTING
    call kit%check_close('casting', motion%mean_speed()/(4*22/13.2_rp*2/152), 1.0_rp, atol=1.0e-6_rp)
    motion%kind = MOTION_BUFFETING
    call kit%check_close('buffeting', motion%mean_speed()/(4*0.45_rp/13.2_rp*23/152), 1.0_rp, atol=1.0e-6_rp)
    motion%kind = MOTION_TABLE
    allocate (motion%table(14, 3), source=0.0_rp)
    motion%table(1, :) = [0.0_rp, 1.0_rp, 5.0_rp]
    motion%table(6, :) = [2.0_rp, -4.0_rp, 0.0_rp]
    call kit%check_close('rows of a table count for the time around them', motion%mean_speed(), (3 + 4*2)/5.0_rp, atol=1.0e-14_rp)
  end subroutine check_mean_speed
end program test_body_motion
