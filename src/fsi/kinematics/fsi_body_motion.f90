! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the body as a moving frame at any time: tethered, in a prescribed motion of FLUSI's BodyMotion, in the states of a flight
!> from a table, or in free flight (fsi_flyer).
!>
!> Prescribed motions oscillate with the amplitudes and frequencies of FLUSI, in degrees and 1/T:
!>
!>     yawpitchroll   roll, pitch and yaw 30 sin(2 pi t), and the centre x0 + v0 t
!>     roll, pitch, yaw   one of them alone, the others 0
!>     roll_param     roll -60 sin(2 pi 6.25/152 t), pitch -24.5, yaw 180
!>     pitch_param    yawpitchroll_0, and 15 cos(2 pi t) added to the pitch
!>     buffeting      roll -7 sin(2 pi 23/152 t), pitch -24.5, yaw 180, y - 0.45/13.2 sin(2 pi 23/152 t)
!>     casting        roll -20 sin(2 pi 2/152 t), pitch -24.5, yaw 180, y + 22/13.2 sin(2 pi 2/152 t)
!>     wheeling       roll -30, yaw 360 t/20, and a circle of radius 1.5 about x0, begun at its lowest y
!>
!> Derivatives are exact. Between the rows of a table, centre and quaternion are cubics with the velocities of the table as slopes;
!> FLUSI interpolates linearly.
module fsi_body_motion
  use base_constants, only: PI, TWO_PI
  use base_errors, only: require
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use fsi_kinematics, only: body_rotation, body_t
  use fsi_quaternion, only: angles_of, matrix_of, rate_of, spin_of
  use fsi_rotation, only: angle_t
  implicit none
  private
  public :: body_motion_t, SWINGS, MOTIONS, TABLE_WORD, LOADER_WORD

  integer, parameter, public :: MOTION_TETHERED = 0, MOTION_TABLE = 1, MOTION_FREE = 2, MOTION_YAWPITCHROLL = 3, MOTION_ROLL = 4, &
                                MOTION_PITCH = 5, MOTION_YAW = 6, MOTION_ROLL_PARAM = 7, MOTION_PITCH_PARAM = 8, &
                                MOTION_BUFFETING = 9, MOTION_CASTING = 10, MOTION_WHEELING = 11
  !> Positions and attitudes of early versions of FLUSI, and the take-off. They are translated into other keys before a body moves.
  integer, parameter, public :: MOTION_POSE = 12, MOTION_TAKEOFF = 13

  !> Words of BodyMotion for oscillations.
  type(named_kind_t), parameter :: SWINGS(9) = [ &
    named_kind_t('yawpitchroll', MOTION_YAWPITCHROLL), named_kind_t('roll', MOTION_ROLL), named_kind_t('pitch', MOTION_PITCH), &
    named_kind_t('yaw', MOTION_YAW), named_kind_t('roll_param', MOTION_ROLL_PARAM), &
    named_kind_t('pitch_param', MOTION_PITCH_PARAM), named_kind_t('buffeting', MOTION_BUFFETING), &
    named_kind_t('casting', MOTION_CASTING), named_kind_t('wheeling', MOTION_WHEELING)]

  !> All words of BodyMotion.
  character(*), parameter :: TABLE_WORD = 'from_file::', LOADER_WORD = 'kinematics_loader::'
  type(named_kind_t), parameter :: MOTIONS(20) = [ &
    named_kind_t('tethered', MOTION_TETHERED), named_kind_t('fixed', MOTION_POSE), named_kind_t('fixed45', MOTION_POSE), &
    named_kind_t('forward', MOTION_POSE), named_kind_t('hovering', MOTION_POSE), named_kind_t('x0y0z0', MOTION_POSE), &
    named_kind_t('flapper', MOTION_POSE), named_kind_t('free_flight', MOTION_FREE), named_kind_t('takeoff', MOTION_TAKEOFF), &
    SWINGS, named_kind_t(TABLE_WORD//'*', MOTION_TABLE), named_kind_t(LOADER_WORD//'*', MOTION_TABLE)]

  real(rp), parameter :: BUFFETING = 23.0_rp/152, CASTING = 2.0_rp/152 !< frequencies, 1/T

  type :: body_motion_t
    integer :: kind = MOTION_TETHERED
    real(rp) :: centre(3) = 0             !< x0, L
    real(rp) :: velocity(3) = 0           !< v0, L/T
    real(rp) :: angles(3) = 0             !< roll, pitch, yaw of yawpitchroll_0, rad
    real(rp), allocatable :: table(:, :)  !< (14, n) time, centre, velocity, quaternion, angular velocity in the body
    type(body_t) :: known(2)              !< of a free flight, at two times; equal before it begins
    real(rp) :: times(2) = 0              !< T
  contains
    procedure :: at => motion_at
    procedure :: moves => motion_moves
    procedure :: show => motion_show
    procedure :: mean_speed => motion_mean_speed
  end type body_motion_t

contains

  !> Tells whether the body moves; a tethered body does not.
  pure logical function motion_moves(self) result(moves)
    class(body_motion_t), intent(in) :: self
    moves = self%kind /= MOTION_TETHERED
  end function motion_moves

  !> Returns the mean speed [L/T] of the body's centre. It depends on the motion alone, not on the length of a run. For a table it
  !> is the mean from the first row to the last, with linear interpolation; for periodic motions, the mean over one period; for a
  !> free flight, the initial speed.
  real(rp) function motion_mean_speed(self) result(speed)
    class(body_motion_t), intent(in) :: self
    integer, parameter :: N_SAMPLES = 2000
    real(rp) :: period
    type(body_t) :: body
    integer :: i
    speed = 0
    select case (self%kind)
    case (MOTION_TETHERED)
    case (MOTION_FREE)
      speed = norm2(self%known(1)%velocity)
    case (MOTION_TABLE)
      associate (t => self%table)
        do i = 2, size(t, 2)
          speed = speed + (t(1, i) - t(1, i - 1))*(norm2(t(5:7, i - 1)) + norm2(t(5:7, i)))/2
        end do
        speed = speed/(t(1, size(t, 2)) - t(1, 1))
      end associate
    case default
      period = 1
      if (self%kind == MOTION_BUFFETING) period = 1/BUFFETING
      if (self%kind == MOTION_CASTING) period = 1/CASTING
      do i = 1, N_SAMPLES
        body = swinging_body(self, (i - 0.5_rp)*period/N_SAMPLES)
        speed = speed + norm2(body%velocity)/N_SAMPLES
      end do
    end select
  end function motion_mean_speed

  !> Records the body of a free flight at `time`. The motion then has the body at this time and at the previous one.
  pure subroutine motion_show(self, time, body)
    class(body_motion_t), intent(inout) :: self
    real(rp), intent(in) :: time
    type(body_t), intent(in) :: body
    if (abs(time - self%times(2)) > 0) then
      self%known(1) = self%known(2)
      self%times(1) = self%times(2)
    end if
    self%known(2) = body
    self%times(2) = time
  end subroutine motion_show

  !> Returns the body at `time` [T]; `tethered` is the body that does not move.
  function motion_at(self, time, tethered) result(body)
    class(body_motion_t), intent(in) :: self
    real(rp), intent(in) :: time
    type(body_t), intent(in) :: tethered
    type(body_t) :: body
    select case (self%kind)
    case (MOTION_TETHERED)
      body = tethered
    case (MOTION_FREE)
      body = self%known(2)
      if (abs(time - self%times(1)) < abs(time - self%times(2))) body = self%known(1)
    case (MOTION_TABLE)
      body = table_body(self%table, time)
    case default
      body = swinging_body(self, time)
    end select
  end function motion_at

  !> Returns the body of one of FLUSI's named motions at a time.
  pure type(body_t) function swinging_body(self, time) result(body)
    type(body_motion_t), intent(in) :: self
    real(rp), intent(in) :: time
    real(rp), parameter :: DEGREE = PI/180, FLIGHT(2) = [-24.5_rp, 180.0_rp]*DEGREE
    real(rp), parameter :: CIRCLE = 1.5_rp, TURN = 20.0_rp !< radius [L], time [T] of wheeling
    type(angle_t) :: roll, pitch, yaw, side
    body%centre = self%centre
    select case (self%kind)
    case (MOTION_ROLL_PARAM, MOTION_BUFFETING, MOTION_CASTING)
      pitch%value = FLIGHT(1)
      yaw%value = FLIGHT(2)
    end select
    select case (self%kind)
    case (MOTION_YAWPITCHROLL)
      roll = swing(30*DEGREE, 1.0_rp, 0.0_rp, time)
      pitch = roll
      yaw = roll
      body%centre = self%centre + self%velocity*time
      body%velocity = self%velocity
    case (MOTION_ROLL)
      roll = swing(30*DEGREE, 1.0_rp, 0.0_rp, time)
    case (MOTION_PITCH)
      pitch = swing(30*DEGREE, 1.0_rp, 0.0_rp, time)
    case (MOTION_YAW)
      yaw = swing(30*DEGREE, 1.0_rp, 0.0_rp, time)
    case (MOTION_ROLL_PARAM)
      roll = swing(-60*DEGREE, 6.25_rp/152, 0.0_rp, time)
    case (MOTION_PITCH_PARAM)
      pitch = swing(15*DEGREE, 1.0_rp, PI/2, time)
      roll%value = self%angles(1)
      pitch%value = pitch%value + self%angles(2)
      yaw%value = self%angles(3)
    case (MOTION_BUFFETING)
      roll = swing(-7*DEGREE, BUFFETING, 0.0_rp, time)
      side = swing(-0.45_rp/13.2_rp, BUFFETING, 0.0_rp, time)
    case (MOTION_CASTING)
      roll = swing(-20*DEGREE, CASTING, 0.0_rp, time)
      side = swing(22/13.2_rp, CASTING, 0.0_rp, time)
    case (MOTION_WHEELING)
      roll%value = -30*DEGREE
      yaw = angle_t(TWO_PI*time/TURN, TWO_PI/TURN, 0.0_rp)
      associate (out => CIRCLE*[sin(yaw%value), -cos(yaw%value), 0.0_rp], &
                 ahead => CIRCLE*[cos(yaw%value), sin(yaw%value), 0.0_rp])
        body%centre = self%centre + out
        body%velocity = yaw%rate*ahead
        body%acceleration = -yaw%rate**2*out
      end associate
    end select
    body%centre(2) = body%centre(2) + side%value
    body%velocity(2) = body%velocity(2) + side%rate
    body%acceleration(2) = body%acceleration(2) + side%acceleration
    body%angles = [roll%value, pitch%value, yaw%value]
    body%rotation = body_rotation(roll, pitch, yaw)
  end function swinging_body

  !> Returns amplitude sin(2 pi frequency t + phase) with its derivatives.
  pure type(angle_t) function swing(amplitude, frequency, phase, time)
    real(rp), intent(in) :: amplitude, frequency, phase, time
    real(rp) :: w
    w = TWO_PI*frequency
    swing%value = amplitude*sin(w*time + phase)
    swing%rate = amplitude*w*cos(w*time + phase)
    swing%acceleration = -amplitude*w**2*sin(w*time + phase)
  end function swing

  !> Returns the body between the rows of a table; before and after the table the first or last cubic continues.
  function table_body(table, time) result(body)
    real(rp), intent(in) :: table(:, :), time
    type(body_t) :: body
    real(rp) :: x(3, 0:2), q(0:3, 0:2), length(0:2)
    integer :: i, above, middle
    call require(size(table, 2) > 1, 'fsi_body_motion: a table has two or more rows')
    i = 1
    above = size(table, 2)
    do while (above - i > 1)
      middle = (i + above)/2
      if (table(1, middle) <= time) then
        i = middle
      else
        above = middle
      end if
    end do
    associate (a => table(:, i), b => table(:, i + 1))
      call cubic(time, a(1), b(1), a(2:4), b(2:4), a(5:7), b(5:7), x)
      call cubic(time, a(1), b(1), a(8:11), b(8:11), rate_of(a(8:11), a(12:14)), rate_of(b(8:11), b(12:14)), q)
    end associate
    ! The normalised quaternion, with its derivatives.
    length(0) = norm2(q(:, 0))
    q(:, 0) = q(:, 0)/length(0)
    length(1) = dot_product(q(:, 0), q(:, 1))
    q(:, 1) = (q(:, 1) - length(1)*q(:, 0))/length(0)
    length(2) = dot_product(q(:, 1), q(:, 1)*length(0) + length(1)*q(:, 0)) + dot_product(q(:, 0), q(:, 2))
    q(:, 2) = (q(:, 2) - 2*length(1)*q(:, 1) - length(2)*q(:, 0))/length(0)
    body%centre = x(:, 0)
    body%velocity = x(:, 1)
    body%acceleration = x(:, 2)
    body%angles = angles_of(q(:, 0))
    body%rotation%matrix = matrix_of(q(:, 0))
    body%rotation%omega = spin_of(q(:, 0), q(:, 1))
    body%rotation%omega_rate = spin_of(q(:, 0), q(:, 2))
  end function table_body

  !> Returns the cubic with values y and slopes d at times a and b, and its first and second derivative.
  pure subroutine cubic(time, a, b, ya, yb, da, db, f)
    real(rp), intent(in) :: time, a, b, ya(:), yb(:), da(:), db(:)
    real(rp), intent(out) :: f(:, 0:)
    real(rp), dimension(size(ya)) :: c2, c3
    real(rp) :: h, s
    h = b - a
    s = (time - a)/h
    c2 = 3*(yb - ya) - h*(2*da + db)
    c3 = h*(da + db) - 2*(yb - ya)
    f(:, 0) = ya + s*(h*da + s*(c2 + s*c3))
    f(:, 1) = da + s*(2*c2 + 3*s*c3)/h
    f(:, 2) = (2*c2 + 6*s*c3)/h**2
  end subroutine cubic
end module fsi_body_motion
