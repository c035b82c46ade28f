! SPDX-License-Identifier: GPL-3.0-or-later
!> Errors of the sensors of a record: a filter of first order is the delay and the smoothing of the family of unknown causes, and
!> derivatives in time are those of the motion. The argument names a wing file.
program test_series_sensors
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use loaded_wing, only: wing_of_argument
  use measurement_data, only: measurement_t
  use measurement_modes, only: MEDIUM_AIR, MEDIUM_VACUUM
  use measurement_series_sensors, only: distortion_time, put_late_errors, put_sensor_errors, N_SENSOR_ERRORS
  use measurement_series_simulation, only: series_simulation_t
  use solid_damping_effects, only: damping_effects_t
  use solid_mass_effects, only: mass_effects_t, mass_parts_t
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, solid_params_t
  use solid_ringing, only: EXCITED_BASE, EXCITED_RELEASE, EXCITED_TAP
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use weighed_model, only: make_weighed_model
  implicit none
  integer, parameter :: N = 25 !< samples of each of the two traces of a record
  real(rp), parameter :: TIP(2) = [8.5e-3_rp, -0.8e-3_rp], MIDDLE(2) = [5.0e-3_rp, -0.5e-3_rp]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(solid_params_t) :: params
  type(mass_parts_t) :: parts
  type(measurement_t) :: m
  type(series_simulation_t) :: simulation

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  params = default_params(wing)
  params%joint = 1.0e-6_rp
  call prepare()
  call measure()
  call test_lag()
  call test_times('filtered displacement', .true.)
  call test_times('velocity with drag', .false.)
  call t%finish()

contains

  subroutine prepare()
    logical :: is_valid
    call make_weighed_model(wing, params, parts, model, is_valid)
    call t%check('the wing is valid', is_valid)
  end subroutine prepare

  !> Three records: a release in air, the velocity after a tap in a vacuum, a moving base. All values are 0.
  subroutine measure()
    integer, parameter :: EXCITATIONS(3) = [EXCITED_RELEASE, EXCITED_TAP, EXCITED_BASE]
    real(rp), parameter :: SIZES(3) = [1.0e-5_rp, 1.0e-8_rp, 1.0_rp], SIGMA(3) = [1.0e-8_rp, 1.0e-5_rp, 1.0e-8_rp]
    integer :: i, k
    allocate (m%series(3))
    do i = 1, 3
      associate (s => m%series(i))
        s%name = 's'//achar(48 + i)
        s%excitation = EXCITATIONS(i)
        s%medium = merge(MEDIUM_AIR, MEDIUM_VACUUM, i == 1)
        s%is_velocity = i == 2
        s%point = TIP
        s%direction = [0.0_rp, 0.0_rp, 1.0_rp]
        s%size = SIZES(i)
        s%axis = [0.0_rp, 0.0_rp, 1.0_rp]
        s%rate = 2000.0_rp
        s%start = 1.0e-4_rp ! a filter has forgotten how the motion began
        s%place = reshape([TIP, MIDDLE], [2, 2])
        allocate (s%values(N, 2), source=0.0_rp)
        allocate (s%is_known(N, 2), source=.true.)
        s%sigma = [SIGMA(i), SIGMA(i)]
        allocate (s%base(0))
      end associate
    end do
    m%series(3)%base = [(10*sin(0.9_rp*(k - 1)**2), k=1, N)]
  end subroutine measure

  !> Residuals of these records, which are the motion in sd.
  function motion(records, drag) result(r)
    type(measurement_t), intent(in) :: records
    real(rp), intent(in) :: drag
    real(rp), allocatable :: r(:)
    type(damping_effects_t) :: damping
    logical :: ok
    damping = damping_effects_t(mass=60.0_rp, stiffness=2.0e-5_rp, joints=1.0e-4_rp, relaxation=0.1_rp, relaxation_time=1.0e-3_rp, &
                                drag=drag)
    call simulation%init(records, model, parts)
    allocate (r(simulation%n))
    call simulation%evaluate(params, mass_effects_t(), damping, r, ok)
    if (.not. ok) call t%check('there is a motion', .false.)
  end function motion

  !> A filter of first order with the time tau: -tau x' + tau^2 x'', up to tau^3. Without drag there is no error in time.
  subroutine test_lag()
    real(rp), parameter :: TAU(2) = [1.0e-6_rp, 5.0e-7_rp]
    type(measurement_t) :: other
    real(rp), allocatable :: columns(:, :), plain(:), change(:), terms(:)
    real(rp) :: error(3, 2), time(3), share
    integer :: i, j, k
    plain = motion(m, 0.0_rp)
    allocate (columns(simulation%n, 6*N_SENSOR_ERRORS))
    call put_sensor_errors(simulation, columns)
    time = [(distortion_time(simulation, i), i=1, 3)]
    other = m
    do k = 1, 2
      other%series%lowpass = 1/(TWO_PI*TAU(k))
      change = motion(other, 0.0_rp) - plain
      do i = 1, 3
        share = TAU(k)/time(i)
        terms = 0*plain
        do j = 2*i - 1, 2*i
          terms = terms - share*columns(:, 3*j - 1) + share**2*columns(:, 3*j)
        end do
        associate (first => simulation%first(i), last => simulation%first(i) + 2*N - 1)
          error(i, k) = norm2(change(first:last) - terms(first:last))/norm2(change(first:last))
        end associate
      end do
    end do
    do i = 1, 3
      call t%check_below('a lag is delay and smoothing in record '//achar(48 + i), error(i, 2), 2.0e-3_rp)
      call t%check_close('up to the third power of the lag', error(i, 1)/error(i, 2), 4.0_rp, rtol=0.1_rp)
    end do
    terms = 10*sum(columns(:, 1::3), 2)
    call t%check_below('a gain is a share of the record', norm2(terms - plain)/norm2(plain), 1.0e-14_rp)
    call t%check('every trace has errors of its own', all(count(abs(columns) > 0, 1) <= N))
  end subroutine test_lag

  !> Derivatives of the record in air against the same record a little earlier and later. Its samples are near to one another, and
  !> as many steps of time lead to the first one: drag has an error, which then hardly changes, but limits second differences.
  subroutine test_times(name, is_filtered)
    character(*), intent(in) :: name
    logical, intent(in) :: is_filtered
    real(rp), parameter :: STEP = 2.0e-6_rp, START = 1.97e-4_rp, DRAG = 20.0_rp
    type(measurement_t) :: other
    real(rp), allocatable :: columns(:, :), r(:), plus(:), minus(:), column(:, :)
    real(rp) :: time, error(2, 2), late(2*N, 1), h
    integer :: k
    other = m
    other%series = m%series(:1)
    other%series(1)%rate = 4.0e4_rp
    other%series(1)%is_velocity = .not. is_filtered
    if (is_filtered) other%series(1)%lowpass = 1500
    if (is_filtered) other%series(1)%order = 2
    other%series(1)%start = START
    other%series(1)%trigger_sigma = STEP
    r = motion(other, DRAG)
    allocate (columns(size(r), 2*N_SENSOR_ERRORS))
    call put_sensor_errors(simulation, columns)
    call put_late_errors(simulation, late)
    time = distortion_time(simulation, 1)
    column = columns(:, 2:3) + columns(:, 5:6)
    do k = 1, 2
      h = STEP/k
      other%series(1)%start = START + h
      plus = motion(other, DRAG)
      other%series(1)%start = START - h
      minus = motion(other, DRAG)
      error(1, k) = norm2((plus - minus)*time/(2*h) - column(:, 1))/norm2(column(:, 1))
      error(2, k) = norm2((plus - 2*r + minus)*(time/h)**2 - column(:, 2))/norm2(column(:, 2))
    end do
    do k = 1, 2
      call t%check_below('derivative '//achar(48 + k)//' in time: '//name, error(k, 2), 1.0e-4_rp)
    end do
    h = norm2(0.5_rp*sqrt(3.0_rp)*4*(plus - 2*r + minus) - late(:, 1))/norm2(late)
    call t%check_below('an error of the time has a part of second order: '//name, h, 1.0e-4_rp)
    call t%check_close('its differences err with the square of their step', error(1, 1)/error(1, 2), 4.0_rp, rtol=0.1_rp)
  end subroutine test_times
end program test_series_sensors
