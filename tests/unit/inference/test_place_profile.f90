! SPDX-License-Identifier: GPL-3.0-or-later
!> The interval of a strength whose place was searched, against the profile likelihood over a fine grid of places, at each of which
!> the problem is linear.
program test_place_profile
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_lapack, only: orthogonalise
  use dome_surface, only: dome_t
  use inference_design, only: design_t
  use inference_intervals, only: find_intervals
  use inference_place_intervals, only: widen_over_places
  use inference_refit, only: fit_nested, nested_fit_t
  use inference_search_place, only: place_search_t, place_t
  use inference_whitener, only: whitener_t
  use least_squares_fit, only: fit_options_t
  use least_squares_profile, only: interval_t, THRESHOLD_90
  use least_squares_state, only: solver_state_t
  use patchy_surface, only: make_patchy, N_BASE, P_PATCH
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: SD = 0.01_rp !< of the heights
  real(rp), parameter :: TRUTH(P_PATCH + 3) = [0.3_rp, 0.5_rp, -0.2_rp, 0.05_rp, 0.43_rp, 0.58_rp, -1.6_rp]
  !> Places of the search are as dense as about half the sd of a place. The end falls by half the square of what they miss, over
  !> the root of the threshold: by less than a tenth of a half width with all three coordinates.
  real(rp), parameter :: CLOSE = 0.1_rp
  type(testkit_t) :: t
  type(dome_t), target :: sheet
  type(whitener_t), target :: whitener
  type(design_t) :: design
  type(fit_options_t) :: options
  type(failure_t) :: failure
  class(solver_state_t), allocatable :: state
  integer :: i

  call t%start(parallel=.false.)
  call make_patchy(sheet%patchy_t, 0.08_rp, 0.3_rp)
  sheet%parameters(P_PATCH)%is_log = .false.
  sheet%parameters(P_PATCH)%name = 'dome'
  call observe()
  allocate (state, design%candidates(1))
  design%candidates(1)%effect = 1
  design%candidates(1)%variant = 1
  design%candidates(1)%columns = [P_PATCH]
  allocate (design%prior(N_BASE), design%weight(N_BASE), source=0.0_rp)
  call whitener%init(sheet, [(i, i=1, sheet%n_observations)], 1.0_rp, failure)
  call t%check('the errors have a covariance', .not. failure%failed)
  call test_profile()
  call t%finish()

contains

  !> The sheet with the dome, and errors of about one sd that are no dome.
  subroutine observe()
    real(rp) :: unused(sheet%n_observations)
    allocate (sheet%observed(sheet%n_observations))
    call sheet%heights(TRUTH, sheet%observed, unused)
    sheet%observed = sheet%observed + [(1.4_rp*SD*sin(real(i, rp)**2), i=1, size(unused))]
  end subroutine observe

  !> The interval at the place is too short, and that over all places has the ends of the grid.
  subroutine test_profile()
    type(place_search_t) :: search
    type(place_t) :: place
    type(nested_fit_t) :: found
    type(interval_t), allocatable :: intervals(:)
    type(interval_t) :: widened
    real(rp) :: ends(2)
    search%simulator => sheet
    search%whitener => whitener
    search%prior = design%prior
    search%weight = design%weight
    search%effect = 1
    search%strength = P_PATCH
    search%worth = 0.1_rp
    call search%run(reshape([0.5_rp, 0.5_rp, log(0.3_rp)], [3, 1]), [0.03_rp], sheet%null_point(), state, place)
    call t%check('a place is found', place%is_valid)
    call sheet%settle_place(1, place%at, place%q(P_PATCH))
    call fit_nested(sheet, whitener, [1, 2, 3, P_PATCH], place%q, state, options, found)
    call t%check('and fitted', found%is_found)
    call find_intervals(sheet, whitener, 1.0_rp, options, found, intervals)
    widened = intervals(1)
    call widen_over_places(sheet, design, whitener, 1.0_rp, options, 1, found, widened)
    call find_on_grid(place%at, found%cost() + THRESHOLD_90, ends)
    call t%check('the interval at one place is too short', intervals(1)%upper - intervals(1)%lower < 0.9_rp*(ends(2) - ends(1)))
    call t%check_close('the lower end is that over all places', widened%lower, ends(1), atol=CLOSE*(ends(2) - ends(1))/2)
    call t%check_close('so is the upper end', widened%upper, ends(2), atol=CLOSE*(ends(2) - ends(1))/2)
    call t%check('the fit keeps its place', all(abs(found%q(P_PATCH + 1:) - place%at) <= 0))
  end subroutine test_profile

  !> Returns the ends of the interval of the strength over a grid of places about `centre`.
  subroutine find_on_grid(centre, limit, ends)
    real(rp), intent(in) :: centre(3), limit
    real(rp), intent(out) :: ends(2)
    integer, parameter :: N = 16, N_RADII = 20 !< on each side
    real(rp), parameter :: WIDTH = 0.12_rp, LOG_WIDTH = 0.6_rp
    real(rp) :: q(P_PATCH + 3), heights(sheet%n_observations), dome(sheet%n_observations), left(sheet%n_observations)
    real(rp) :: plane(sheet%n_observations, N_BASE), room, reach
    real(rp), allocatable :: basis(:, :), r(:, :)
    logical :: is_at_edge
    integer :: ix, iy, ir
    plane(:, 1) = 1
    plane(:, 2:) = transpose(sheet%labels%site)
    call orthogonalise(plane, basis, r)
    left = sheet%observed/SD
    left = left - matmul(basis, matmul(left, basis))
    ends = [huge(1.0_rp), -huge(1.0_rp)]
    is_at_edge = .false.
    q = 0
    do ir = -N_RADII, N_RADII
      do iy = -N, N
        do ix = -N, N
          q(P_PATCH + 1:) = centre + [WIDTH*ix/N, WIDTH*iy/N, LOG_WIDTH*ir/N_RADII]
          call sheet%heights(q, heights, dome)
          dome = dome/SD
          dome = dome - matmul(basis, matmul(dome, basis))
          room = limit - (sum(left**2) - dot_product(left, dome)**2/sum(dome**2))
          if (room < 0) cycle
          is_at_edge = is_at_edge .or. any(abs([ix, iy]) == N) .or. abs(ir) == N_RADII
          reach = sqrt(room/sum(dome**2))
          ends(1) = min(ends(1), dot_product(left, dome)/sum(dome**2) - reach)
          ends(2) = max(ends(2), dot_product(left, dome)/sum(dome**2) + reach)
        end do
      end do
    end do
    call t%check('the grid holds all probable places', .not. is_at_edge)
  end subroutine find_on_grid
end program test_place_profile
