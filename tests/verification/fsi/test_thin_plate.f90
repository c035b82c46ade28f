! SPDX-License-Identifier: GPL-3.0-or-later
!> A plate without thickness, fixed in a plane stream at Re = 100 that starts at once: drag and lift on 12 points per
!> chord against the same on 40, where they differ by less than 1 % from those on 64 points; the flow does not pass.
program test_thin_plate
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fsi_green, only: green_t
  use fsi_marker_response, only: marker_response_t
  use support_fluid, only: make_fluid, box_2d, NL
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  real(rp), parameter :: BOX = 4, REYNOLDS = 100, T_FIRST = 0.4_rp, T_END = 2, COEFFICIENT = 0.3_rp
  real(rp) :: coarse(2), fine(2), slip

  call test%start(parallel=.true.)
  call fly(40, 30.0_rp, fine, slip)
  call fly(12, 30.0_rp, coarse, slip)
  call test%check_below('30 degrees: drag within 5 %', abs(coarse(1)/fine(1) - 1), 0.05_rp)
  call test%check_below('30 degrees: lift within 8 %', abs(coarse(2)/fine(2) - 1), 0.08_rp)
  call test%check_below('30 degrees: slip below 1 % of the stream', slip, 0.01_rp)
  call fly(40, 90.0_rp, fine, slip)
  call fly(12, 90.0_rp, coarse, slip)
  call test%check_below('90 degrees: drag within 5 %', abs(coarse(1)/fine(1) - 1), 0.05_rp)
  call test%check_below('90 degrees: no lift but that of the window''s error', abs(coarse(2)), 1.0e-6_rp)
  call test%finish()

contains

  !> Mean drag and lift per depth of a chord of 1 in a stream of 1 along y, and the largest slip after the start.
  subroutine fly(points, degrees, mean, slip)
    integer, intent(in) :: points !< per chord
    real(rp), intent(in) :: degrees
    real(rp), intent(out) :: mean(2), slip
    type(fluid_t) :: fluid
    type(green_t) :: green
    type(marker_response_t) :: response
    type(request_t) :: nothing
    type(failure_t) :: failure
    real(rp), allocatable :: x(:, :), flow(:, :), force(:, :)
    character(200) :: time
    real(rp) :: h, k, duration, place
    integer :: i, n
    logical :: has_factor
    h = 1.0_rp/points
    write (time, '(2(a,es24.16),a)') '[Time]'//NL//'dt_fixed=', 0.15_rp*h, NL//'Tmax=9'//NL// &
      '[ReynoldsNumber]'//NL//'nu=', 1/REYNOLDS, NL
    call make_fluid(test%world, box_2d(nint(BOX)*points, BOX)//trim(time)//NL//'[InitialCondition]'//NL// &
                    'inicond=MeanFlow'//NL//'[MeanFlow]'//NL//'iMeanFlow=1'//NL//'ux=0'//NL//'uy=1'//NL// &
                    'uz=0'//NL, fluid)
    n = points/2 + 1
    allocate (x(3, n), flow(3, n), force(3, n))
    do i = 1, n
      place = (i - 1.0_rp)/(n - 1) - 0.5_rp
      x(:, i) = [0.0_rp, BOX/2 + place*cos(degrees*PI/180), BOX/2 - place*sin(degrees*PI/180)]
    end do
    call fluid%hold_points(n)
    k = fluid%points%radius
    fluid%rhs%stepper%full%rate = max(0.0_rp, COEFFICIENT*k - k**2/REYNOLDS)
    call green%init(k, 1.0_rp, .true.)
    call response%init(n, is_2d=.false.)
    call response%build(green, x, has_factor)
    call test%check('the response has a factor', has_factor)
    call fluid%points%place(x)
    mean = 0
    duration = 0
    slip = 0
    do while (fluid%rhs%state%time < T_END)
      call fluid%step(nothing, failure)
      if (failure%failed) exit
      call fluid%velocities_at_points(flow)
      call response%solve(-flow/fluid%dt, force)
      call fluid%push_at_points(force)
      if (fluid%rhs%state%time < T_FIRST) cycle
      mean = mean - fluid%dt*sum(force(2:3, :), 2)
      duration = duration + fluid%dt
      call fluid%velocities_at_points(flow)
      slip = max(slip, sqrt(maxval(sum(flow**2, 1))))
    end do
    mean = mean/duration
    call fluid%free()
  end subroutine fly
end program test_thin_plate
