! SPDX-License-Identifier: GPL-3.0-or-later
!> What landmarks add to a flight: errors of the cameras' axes are shifts and small turns of all places, unknown causes are waves of
!> motions that are linear in the place on the wing, and another frequency of the beat moves no landmark.
program test_flight_landmarks
  use base_constants, only: PI, TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_flight_changes, only: FLOW_FREQUENCY, FLOW_VISCOSITY, N_CHANGES, N_FLOW
  use diagnosis_flight_landmarks, only: count_patterns, find_cameras, misplaced, pivot_of, put_wing_patterns, N_WAVES, UNKNOWN_SHARE
  use diagnosis_flight_refinements, only: N_REFINEMENTS
  use diagnosis_flight_response, only: flight_response_t
  use diagnosis_flight_runner, only: flight_record_t, flight_request_t, N_PHASES
  use measurement_flight, only: measured_flight_t, COMPONENT_POWER, N_COMPONENTS
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 5, M = 2 !< times, landmarks
  real(rp), parameter :: TIME(N) = [0.0_rp, 0.15_rp, 0.4_rp, 0.5_rp, 0.85_rp], SD = 2.0e-5_rp
  type(testkit_t) :: t
  call t%start(parallel=.false.)
  call check_cameras()
  call check_turns()
  call check_patterns()
  call check_frequency()
  call t%finish()

contains

  !> A record of all coordinates but x of the second landmark.
  function record(name, first, offset_sd, turn_sd) result(f)
    character(*), intent(in) :: name
    integer, intent(in) :: first
    real(rp), intent(in) :: offset_sd, turn_sd
    type(measured_flight_t) :: f
    integer :: k
    f%name = name
    f%side = 1
    f%first = first
    f%offset_sd = offset_sd
    f%turn_sd = turn_sd
    f%points = reshape([8.0e-3_rp, 0.0_rp, 4.0e-3_rp, 0.0_rp], [2, M])
    f%component = N_COMPONENTS + 3*first + [1, 2, 3, 5, 6]
    f%time = TIME
    f%mean = reshape([(1.0e-3_rp*k + 1.0e-2_rp*modulo(3*k, 7), k=1, 5*N)], [N, 5])
    allocate (f%is_known(N, 5), source=.true.)
    f%is_known(3, 4) = .false.
    allocate (f%sd(N, 5), source=SD)
  end function record

  subroutine check_cameras()
    type(measured_flight_t) :: flights(5)
    flights(1)%name = 'one'
    flights(2) = record('one', 0, 0.0_rp, 0.0_rp)
    flights(3) = record('two', M, 1.0e-4_rp, 0.0_rp)
    flights(4) = record('two', 2*M, 1.0e-4_rp, 0.0_rp)
    flights(5) = record('three', 3*M, 0.0_rp, 1.0_rp)
    associate (camera => find_cameras(flights))
      call t%check('records of one flight share their cameras, if errors are stated', all(camera == [0, 0, 1, 1, 2]))
    end associate
  end subroutine check_cameras

  !> A turn of the axes by a small angle w about the pivot moves a place r by w x (r - pivot), up to its sign.
  subroutine check_turns()
    type(measured_flight_t) :: f
    complex(rp) :: series(0:1, N_COMPONENTS + 3*(M + 1))
    real(rp), parameter :: TURN = 2.0_rp, OFFSET = 3.0e-4_rp
    real(rp) :: pivot(3), place(3, N), r(3), w(3), wanted(3)
    integer :: axis, k, i, l, at(2)
    f = record('one', 1, OFFSET, TURN)
    series = 0
    do k = 1, 3*M
      series(0, N_COMPONENTS + 3 + k) = cmplx(1.0e-3_rp*(k**2), kind=rp)
      series(1, N_COMPONENTS + 3 + k) = cmplx(1.0e-3_rp*k, 2.0e-3_rp, rp)
    end do
    pivot = pivot_of([f], [.true.], series)
    call t%check_below('the pivot is the mean place', maxval(abs(pivot - 1.0e-3_rp*([1, 4, 9] + [16, 25, 36])/2)), 1.0e-16_rp)
    do k = 1, size(f%component)
      at = f%landmark_of(k)
      l = N_COMPONENTS + 3 + 3*(at(1) - 1)
      do i = 1, 3
        associate (x => series(:, l + i))
          place(i, :) = real(x(1), rp) + real(x(2), rp)*cos(TWO_PI*TIME) - aimag(x(2))*sin(TWO_PI*TIME)
        end associate
      end do
      do axis = 1, 3
        associate (moved => misplaced(f, k, TIME, series, pivot, axis))
          call t%check('a shift moves one coordinate', all(abs(moved - merge(OFFSET, 0.0_rp, axis == at(2))) <= 0))
        end associate
        w = 0
        w(axis) = TURN*PI/180
        associate (moved => misplaced(f, k, TIME, series, pivot, 3 + axis))
          do i = 1, N
            r = place(:, i) - pivot
            wanted = [w(2)*r(3) - w(3)*r(2), w(3)*r(1) - w(1)*r(3), w(1)*r(2) - w(2)*r(1)]
            call t%check_below('a turn moves places about the pivot', abs(moved(i) - wanted(at(2))), 1.0e-15_rp)
          end do
        end associate
      end do
    end do
  end subroutine check_turns

  !> Landmarks on a line along x: displacements are constant or grow with x. What is not known has no row.
  subroutine check_patterns()
    type(measured_flight_t) :: f
    real(rp), allocatable :: patterns(:, :), time_of_rows(:)
    real(rp) :: motion
    integer :: k, n_waves_each
    f = record('one', 0, 0.0_rp, 0.0_rp)
    n_waves_each = 2*N_WAVES + 1
    call t%check('three axes, two displacements of each', count_patterns(f) == 3*2*n_waves_each)
    time_of_rows = [(pack(TIME, f%is_known(:, k)), k=1, 5)]
    allocate (patterns(f%count(), count_patterns(f)))
    call put_wing_patterns(f, time_of_rows, patterns)
    motion = 0
    do k = 1, 5
      associate (known => f%is_known(:, k))
        motion = motion + sum((f%mean(:, k) - sum(f%mean(:, k), known)/count(known))**2, known)
      end associate
    end do
    motion = UNKNOWN_SHARE*sqrt(motion/f%count())/SD
    call t%check_close('a shift along y moves the first landmark', patterns(N + 1, n_waves_each*2 + 1), motion, rtol=1.0e-12_rp)
    call t%check_close('and of the second', patterns(3*N + 1, n_waves_each*2 + 1), motion, rtol=1.0e-12_rp)
    call t%check_close('a slope moves them in opposite ways', patterns(3*N + 1, n_waves_each*3 + 1), -motion, rtol=1.0e-12_rp)
    call t%check_close('a wave follows the beat', patterns(N + 2, n_waves_each*2 + 2), motion*cos(TWO_PI*TIME(2)), rtol=1.0e-12_rp)
    call t%check('it moves nothing along x', all(abs(patterns(:N, n_waves_each*2 + 1)) <= 0))
    call t%check_close('after a time that is not known comes the next one', patterns(3*N + 3, n_waves_each*2 + 3), &
                       motion*sin(TWO_PI*TIME(4)), atol=1.0e-9_rp)
  end subroutine check_patterns

  !> Forces grow with the square of the frequency, power with its third power; landmarks stay. Everything depends on the viscosity.
  subroutine check_frequency()
    type(flight_response_t) :: response
    type(flight_request_t), allocatable :: requests(:)
    type(flight_record_t), allocatable :: records(:)
    type(failure_t) :: failure
    real(rp), parameter :: E = 0.1_rp, H = 1.0e-5_rp
    real(rp) :: steps(N_FLOW), c(N_CHANGES), d(N_CHANGES)
    complex(rp), dimension(0:1, N_COMPONENTS + 3) :: values, slope
    integer :: i
    logical :: none(N_REFINEMENTS)
    none = .false.
    steps = 0
    steps(FLOW_VISCOSITY) = 0.05_rp
    response%n_harmonics = 1
    requests = response%requests(steps, none)
    allocate (records(size(requests)))
    do i = 1, size(records)
      records(i)%is_flown = .true.
      allocate (records(i)%values(N_PHASES, N_COMPONENTS + 3), source=1 + 0.2_rp*requests(i)%change(FLOW_VISCOSITY))
    end do
    call response%take(steps, none, records, failure)
    call t%check('the flights are taken', .not. failure%failed)
    c = 0
    c(FLOW_FREQUENCY) = E
    values = response%at(c)
    call t%check_close('landmarks', real(values(0, N_COMPONENTS + 2), rp), 1 - 0.2_rp*E, rtol=1.0e-12_rp)
    call t%check_close('forces', real(values(0, 2), rp), (1 - 0.2_rp*E)*exp(2*E), rtol=1.0e-12_rp)
    call t%check_close('power', real(values(0, COMPONENT_POWER), rp), (1 - 0.2_rp*E)*exp(3*E), rtol=1.0e-12_rp)
    d = 0
    d(FLOW_FREQUENCY) = H
    slope = (response%at(c + d) - response%at(c - d))/(2*H)
    call t%check('derivatives are those of the values', maxval(abs(slope - response%derivative(c, FLOW_FREQUENCY))) < 1.0e-8_rp)
  end subroutine check_frequency
end program test_flight_landmarks
