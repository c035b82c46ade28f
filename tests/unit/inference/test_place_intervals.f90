! SPDX-License-Identifier: GPL-3.0-or-later
!> The interval of a cause whose place is one of several, against the exact profile likelihood of a linear problem.
program test_place_intervals
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use bump_places, only: bump_at, bumps_t, make_bumps, N_PLACES
  use inference_design, only: design_t
  use inference_intervals, only: find_intervals
  use inference_place_intervals, only: widen_over_places
  use inference_refit, only: fit_nested, nested_fit_t
  use inference_whitener, only: whitener_t
  use least_squares_fit, only: fit_options_t
  use least_squares_profile, only: interval_t, THRESHOLD_90
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 101, TRUE_PLACE = 4
  !> Searches find an end to a hundredth of the root of the threshold (least_squares_profile): here of 1.6 sd.
  real(rp), parameter :: CLOSE = 0.02_rp
  type(testkit_t) :: t
  type(bumps_t), target :: bumps
  type(design_t) :: design
  type(whitener_t), target :: whitener
  type(fit_options_t) :: options
  type(failure_t) :: failure
  integer :: i

  call t%start(parallel=.false.)
  call make_bumps(N, bumps, design)
  call whitener%init(bumps, [(i, i=1, N)], 1.0_rp, failure)
  ! Errors that are no bump and no offset leave all places equally probable but for the bump.
  bumps%data = 0.3_rp + bump_at(TRUE_PLACE, N) + [(0.5_rp*(-1)**i, i=1, N)]
  call test_scale(2.0_rp)
  call test_scale(5.0_rp)
  call test_alone()
  call t%finish()

contains

  !> The interval is the union over the places of exact intervals, of this variance of the noise.
  subroutine test_scale(scale)
    real(rp), intent(in) :: scale
    type(nested_fit_t) :: found
    type(interval_t), allocatable :: intervals(:)
    type(interval_t) :: widened
    real(rp) :: strength(N_PLACES), sd(N_PLACES), cost(N_PLACES), reach(N_PLACES)
    integer :: best
    do i = 1, N_PLACES
      call solve_exactly(bump_at(i, N), strength(i), sd(i), cost(i))
    end do
    best = minloc(cost, 1)
    reach = sd*sqrt(max(0.0_rp, THRESHOLD_90*scale - (cost - minval(cost))))
    call t%check('several places are probable, and some are not', count(reach > 0) > 2 .and. count(reach > 0) < N_PLACES)
    call fit_place(best + 1, found)
    call find_intervals(bumps, whitener, scale, options, found, intervals)
    call t%check_close('the interval at one place is exact', intervals(1)%lower, strength(best) - reach(best), &
                       atol=CLOSE*reach(best))
    widened = intervals(1)
    call widen_over_places(bumps, design, whitener, scale, options, best, found, widened)
    call t%check('the place widens the interval', widened%upper - widened%lower > 1.05_rp*(intervals(1)%upper - intervals(1)%lower))
    call t%check_close('the lower end is that over all places', widened%lower, minval(strength - reach, mask=reach > 0), &
                       atol=CLOSE*reach(best))
    call t%check_close('so is the upper end', widened%upper, maxval(strength + reach, mask=reach > 0), atol=CLOSE*reach(best))
  end subroutine test_scale

  !> A cause without a place keeps its interval.
  subroutine test_alone()
    type(nested_fit_t) :: found
    type(interval_t), allocatable :: intervals(:)
    type(interval_t) :: widened
    call fit_place(N_PLACES + 2, found)
    call find_intervals(bumps, whitener, 1.0_rp, options, found, intervals)
    widened = intervals(1)
    call widen_over_places(bumps, design, whitener, 1.0_rp, options, N_PLACES + 1, found, widened)
    call t%check_close('without other places the lower end stays', widened%lower, intervals(1)%lower, rtol=1.0e-15_rp)
    call t%check_close('and the upper end', widened%upper, intervals(1)%upper, rtol=1.0e-15_rp)
  end subroutine test_alone

  !> Fits the offset and this parameter.
  subroutine fit_place(column, found)
    integer, intent(in) :: column
    type(nested_fit_t), intent(out) :: found
    class(solver_state_t), allocatable :: state
    call bumps%initial_state(state)
    call fit_nested(bumps, whitener, [1, column], bumps%null_point(), state, options, found)
    call t%check('the fit is found', found%is_found)
  end subroutine fit_place

  !> Solves the normal equations of offset, with its prior 0 +- 0.5, and strength of a bump.
  subroutine solve_exactly(bump, strength, sd, cost)
    real(rp), intent(in) :: bump(:)
    real(rp), intent(out) :: strength, sd, cost
    real(rp) :: a, b, c, offset, r1, r2
    a = size(bump) + 4
    b = sum(bump)
    c = sum(bump**2)
    r1 = sum(bumps%data)
    r2 = sum(bump*bumps%data)
    strength = (a*r2 - b*r1)/(a*c - b**2)
    offset = (r1 - b*strength)/a
    sd = sqrt(a/(a*c - b**2))
    cost = sum((bumps%data - offset - strength*bump)**2) + 4*offset**2
  end subroutine solve_exactly
end program test_place_intervals
