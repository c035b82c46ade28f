! SPDX-License-Identifier: GPL-3.0-or-later
!> A record whose axes are turned says the same as one along the axes of the case: with the matrix D that turns all of its vectors,
!> residuals are D r, derivatives D J, and errors and turns of the balance span the same, D N N^T D^T. All errors of a vector are as
!> large, so that D also keeps the covariance of the data; errors of another size for each component would become correlated ones
!> of the turned record, which a file does not state. Without the attribute nothing of this holds.
program test_flight_axes
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_flight_changes, only: FLOW_LEAD, N_FLOW
  use diagnosis_flight_data, only: flight_cases_t
  use diagnosis_flight_refinements, only: N_REFINEMENTS, REFINE_BOX, REFINE_SURFACE
  use diagnosis_flight_runner, only: flight_record_t, N_PHASES
  use diagnosis_wing_flights, only: wing_flights_t
  use diagnosis_wing_parameters, only: wing_parameter_t, KIND_BALANCE, KIND_FLIGHT
  use measurement_balance_causes, only: BALANCE_DELAY, BALANCE_GAIN, BALANCE_LOWPASS, BALANCE_MASS, BALANCE_TURN
  use measurement_flight, only: measured_flight_t, N_COMPONENTS, SAME_AXES
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 5, M = 2, ALL = N_COMPONENTS + 3*M !< times, landmarks, components of a flight
  integer, parameter :: N_ALL = N*ALL, TURNS(3) = [3, 4, 5], OTHERS(5) = [1, 2, 6, 7, 8]
  real(rp), parameter :: STEP = 0.1_rp, TOLERANCE = 1.0e-10_rp, ORIGIN(3) = [0.3_rp, -0.2_rp, 0.5_rp]
  type(testkit_t) :: t
  type(flight_cases_t) :: data
  type(wing_parameter_t) :: parameters(8) !< lead, gain, three turns, filter, delay and mass of the balance
  type(wing_flights_t) :: along, turned, ignored
  type(measured_flight_t) :: records(3)
  real(rp) :: axes(3, 3), d(N_ALL, N_ALL)
  call t%start(parallel=.false.)
  axes = matmul(about(3, 0.7_rp), matmul(about(1, -1.1_rp), about(2, 0.4_rp)))
  call make_case()
  call find_turn()
  call make_records(SAME_AXES, .false., records)
  call along%init(records, parameters, data)
  call make_records(axes, .true., records)
  call turned%init(records, parameters, data)
  call make_records(SAME_AXES, .true., records)
  call ignored%init(records, parameters, data)
  call check_values()
  call check_errors()
  call t%finish()

contains

  !> Returns the matrix of a turn by an angle [rad] about an axis.
  pure function about(axis, angle) result(matrix)
    integer, intent(in) :: axis
    real(rp), intent(in) :: angle
    real(rp) :: matrix(3, 3)
    integer :: j, k
    j = modulo(axis, 3) + 1
    k = modulo(axis + 1, 3) + 1
    matrix = SAME_AXES
    matrix(j, j) = cos(angle)
    matrix(k, k) = cos(angle)
    matrix(j, k) = sin(angle)
    matrix(k, j) = -sin(angle)
  end function about

  !> A case with two errors that refinements show, and an inertia: every component has waves of its own.
  subroutine make_case()
    type(flight_record_t) :: flights(5)
    type(failure_t) :: failure
    real(rp) :: steps(N_FLOW)
    integer :: i
    steps = 0
    steps(FLOW_LEAD) = STEP
    allocate (data%cases(1))
    associate (case => data%cases(1))
      case%last = 3
      case%refined([REFINE_BOX, REFINE_SURFACE]) = .true.
      case%facts%error_over_change(REFINE_SURFACE) = 0.5_rp
      case%model_sd = 0.02_rp
      case%facts%inertia = waves(20, N_COMPONENTS)
      case%facts%is_flexible = .true.
      case%facts%rigid = waves(30, 3*M)
      case%response%n_harmonics = 4
      do i = 1, size(flights)
        flights(i)%is_flown = .true.
        flights(i)%values = waves(0, ALL) + 0.1_rp*waves(i, ALL)
      end do
      call case%response%take(steps, case%refined, flights, failure)
    end associate
    call t%check('the flights are taken', .not. failure%failed)
    parameters%kind = KIND_BALANCE
    parameters(1)%kind = KIND_FLIGHT
    parameters%number = [FLOW_LEAD, BALANCE_GAIN, BALANCE_TURN + 1, BALANCE_TURN + 2, BALANCE_TURN + 3, BALANCE_LOWPASS, &
                         BALANCE_DELAY, BALANCE_MASS]
  end subroutine make_case

  pure function waves(seed, n_columns) result(x)
    integer, intent(in) :: seed, n_columns
    real(rp) :: x(N_PHASES, n_columns)
    integer :: i, k
    do k = 1, n_columns
      x(:, k) = [(cos(TWO_PI*i/N_PHASES + seed + k**2) + 0.3_rp*sin(2*TWO_PI*i/N_PHASES + seed*k) + 0.1_rp*modulo(seed + k, 5), &
                  i=0, N_PHASES - 1)]
    end do
  end function waves

  !> Three records: all components of the force, the landmark of one wing, and that of the other. If `is_turned` their numbers are
  !> along `axes`, whatever they say.
  subroutine make_records(said, is_turned, f)
    real(rp), intent(in) :: said(3, 3)
    logical, intent(in) :: is_turned
    type(measured_flight_t), intent(out) :: f(3)
    real(rp) :: x(N_PHASES, ALL)
    integer :: i, r, first
    x = waves(0, ALL) + 0.2_rp*waves(40, ALL)
    do first = 0, ALL - 3, 3
      i = first
      if (first > 3) i = first + 1 ! behind the power
      if (is_turned) x(:, i + 1:i + 3) = matmul(x(:, i + 1:i + 3), transpose(axes))
    end do
    do r = 1, 3
      f(r)%name = 'one'
      f(r)%frequency = 1.3_rp
      f(r)%reference = ORIGIN
      f(r)%axes = said
      f(r)%time = [((i + 0.4_rp)/N, i=0, N - 1)]
      f(r)%component = [(i, i=1, N_COMPONENTS)]
      if (r > 1) then
        f(r)%side = r - 1
        f(r)%first = r - 2
        f(r)%points = reshape([0.1_rp, 0.2_rp], [2, 1])
        f(r)%component = N_COMPONENTS + 3*(r - 2) + [1, 2, 3]
        f(r)%offset_sd = 0.3_rp
        f(r)%turn_sd = 2.0_rp
      else
        allocate (f(r)%points(2, 0))
      end if
      f(r)%mean = x([(1 + 37*i, i=1, N)], f(r)%component)
      allocate (f(r)%is_known(N, size(f(r)%component)), source=.true.)
      f(r)%sd = spread([(0.2_rp + 0.1_rp*i, i=1, N)], 2, size(f(r)%component))
    end do
  end subroutine make_records

  !> D of all observations, which are in the order of components and times.
  subroutine find_turn()
    integer :: first, i, j, k
    d = 0
    do first = 0, ALL - 1, 3
      if (first == 6) cycle
      do i = 1, 3
        do j = 1, 3
          associate (before => first - merge(2, 0, first > 6))
            do k = 1, N
              d((before + i - 1)*N + k, (before + j - 1)*N + k) = axes(i, j)
            end do
          end associate
        end do
      end do
    end do
    do k = 1, N
      d(6*N + k, 6*N + k) = 1 ! power
    end do
  end subroutine find_turn

  subroutine check_values()
    real(rp) :: q(8), r(N_ALL, 3), j(N_ALL, 8, 3)
    integer :: i
    q = [0.03_rp, 0.2_rp, 0.0_rp, 0.0_rp, 0.0_rp, 0.02_rp, -0.01_rp, 0.4_rp]
    call along%evaluate(q, [(i, i=1, 8)], r(:, 1), j(:, :, 1))
    call turned%evaluate(q, [(i, i=1, 8)], r(:, 2), j(:, :, 2))
    call ignored%evaluate(q, [(i, i=1, 8)], r(:, 3), j(:, :, 3))
    call t%check('all are observations', along%n == N_ALL)
    call t%check_below('D is a rotation', maxval(abs(matmul(d, transpose(d)) - unit())), 1.0e-14_rp)
    call t%check_below('residuals are those of the record along the case, turned', maxval(abs(matmul(d, r(:, 1)) - r(:, 2))), &
                       TOLERANCE)
    call t%check_below('and as large', abs(norm2(r(:, 1)) - norm2(r(:, 2))), TOLERANCE)
    call t%check_below('so are derivatives by the flow and by the balance', &
                       maxval(abs(matmul(d, j(:, OTHERS, 1)) - j(:, OTHERS, 2))), TOLERANCE)
    call t%check_below('turns of the balance are about its own axes, and span the same', &
                       different(j(:, TURNS, 1), j(:, TURNS, 2)), TOLERANCE)
    call t%check('without the axes the residuals are others', abs(norm2(r(:, 3)) - norm2(r(:, 1))) > 0.1_rp)
    call t%check('and so are the derivatives', maxval(abs(matmul(d, j(:, OTHERS, 1)) - j(:, OTHERS, 3))) > 0.1_rp)
  end subroutine check_values

  !> The errors are two of refinements, six of the cameras, and those of the simulation.
  subroutine check_errors()
    real(rp), allocatable :: errors(:, :), seen(:, :)
    real(rp) :: q(8)
    q = 0
    allocate (errors(N_ALL, along%n_nuisances), seen(N_ALL, turned%n_nuisances))
    call along%nuisances(q, errors)
    call turned%nuisances(q, seen)
    call t%check('there are as many errors', size(errors, 2) == size(seen, 2) .and. size(errors, 2) > 8)
    call t%check_below('errors that refinements show are turned with the record', &
                       maxval(abs(matmul(d, errors(:, :2)) - seen(:, :2))), TOLERANCE)
    call t%check_below('all errors span the same', different(errors, seen), TOLERANCE)
    call ignored%nuisances(q, seen)
    call t%check('without the axes they do not', different(errors, seen) > 0.1_rp)
  end subroutine check_errors

  !> Returns how far b b^T is from D a a^T D^T.
  real(rp) function different(a, b)
    real(rp), intent(in) :: a(:, :), b(:, :)
    associate (one => matmul(d, a))
      different = maxval(abs(matmul(one, transpose(one)) - matmul(b, transpose(b))))
    end associate
  end function different

  pure function unit()
    real(rp) :: unit(N_ALL, N_ALL)
    integer :: i
    unit = 0
    do i = 1, N_ALL
      unit(i, i) = 1
    end do
  end function unit
end program test_flight_axes
