! SPDX-License-Identifier: GPL-3.0-or-later
!> The search of a place finds a patch with sharp edges on a sheet, where derivatives with respect to the place are zero almost
!> everywhere: from a start so far away that a third of the patch is covered, with another size and a wrong strength.
program test_search_place
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_search_place, only: place_search_t, place_t
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  use patchy_surface, only: make_patchy, patchy_t, N_BASE, P_PATCH
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: TRUTH(P_PATCH + 3) = [0.3_rp, 0.5_rp, -0.2_rp, -1.6_rp, 0.43_rp, 0.58_rp, -1.514127732629776_rp]
  real(rp), parameter :: STEP = 0.08_rp, RADIUS_STEP = 0.3_rp, WORTH = 0.1_rp !< radius of the patch: 0.22
  type(testkit_t) :: test
  type(patchy_t), target :: sheet
  type(whitener_t), target :: whitener
  type(failure_t) :: failure
  class(solver_state_t), allocatable :: state

  call test%start(parallel=.false.)
  call make_patchy(sheet, STEP, RADIUS_STEP)
  allocate (sheet%observed(sheet%n_observations))
  call observe()
  allocate (state)
  call whitener%init(sheet, spread_rows(sheet%n_observations), 1.0_rp, failure)
  call test%check('the errors have a covariance', .not. failure%failed)
  call test_found()
  call test_starts()
  call test_limits()
  call test_settled()
  call test%finish()

contains

  !> The sheet with the patch, without errors.
  subroutine observe()
    real(rp) :: unused(sheet%n_observations)
    call sheet%heights(TRUTH, sheet%observed, unused)
  end subroutine observe

  pure function spread_rows(n) result(rows)
    integer, intent(in) :: n
    integer :: rows(n), i
    rows = [(i, i=1, n)]
  end function spread_rows

  !> A search for the patch with no prior on the baseline.
  function new_search() result(search)
    type(place_search_t) :: search
    search%simulator => sheet
    search%whitener => whitener
    allocate (search%prior(N_BASE), search%weight(N_BASE), source=0.0_rp)
    search%effect = 1
    search%strength = P_PATCH
    search%worth = WORTH
  end function new_search

  !> The place is found to the resolution of the last step, which is an eighth of the first, in each coordinate; and the points that
  !> the patch covers are found, so that nothing of what it leaves exceeds the noise.
  subroutine test_found()
    type(place_search_t) :: search
    type(place_t) :: found
    real(rp) :: q(size(TRUTH))
    search = new_search()
    q = 0
    call search%run(reshape([0.55_rp, 0.5_rp, log(0.3_rp)], [3, 1]), [-0.5_rp], q, state, found)
    call test%check('a place is found', found%is_valid)
    if (.not. found%is_valid) return
    call test%check('it is the right one to a last step', all(abs(found%at(:2) - TRUTH(5:6)) <= STEP/8 + 0.5_rp/15))
    call test%check('and so is the radius', abs(found%at(3) - TRUTH(7)) <= RADIUS_STEP/2)
    call test%check('with the strength', abs(found%q(P_PATCH) - TRUTH(P_PATCH)) < 0.1_rp)
    call test%check('what is left is at most a hundredth of what was there', found%cost < 0.01_rp*square_of(q))
    call test%check('coordinates of the place are parameters', all(abs(found%q(P_PATCH + 1:) - found%at) <= 0))
    call test%check('one evaluation for each place', sheet%n_evaluations == search%n_evaluations)
    call test%check('as many as allowed at most', search%n_evaluations <= search%most + 2)
  end subroutine test_found

  !> The sum of squares of the best sheet without a patch is at least that about its mean slope; here of the sheet at q.
  real(rp) function square_of(q)
    real(rp), intent(in) :: q(:)
    real(rp) :: heights(sheet%n_observations), unused(sheet%n_observations), point(size(q))
    point = TRUTH
    point(P_PATCH) = q(P_PATCH)
    call sheet%heights(point, heights, unused)
    square_of = sum(((heights - sheet%observed)/0.01_rp)**2)
  end function square_of

  !> Of several starts the best one counts.
  subroutine test_starts()
    type(place_search_t) :: search
    type(place_t) :: found, again
    real(rp) :: q(size(TRUTH)), far(3), near(3)
    q = 0
    far = [0.1_rp, 0.9_rp, log(0.1_rp)]
    near = TRUTH(5:7)
    search = new_search()
    search%most = 0
    call search%run(reshape([far, near], [3, 2]), [-0.1_rp, -1.0_rp], q, state, found)
    call test%check('without moves the best start is the result', all(abs(found%at - near) <= 0))
    search = new_search()
    call search%run(reshape([near, far], [3, 2]), [-1.0_rp, -0.1_rp], q, state, again)
    call test%check('whatever their order', all(abs(again%at - near) <= 0) .and. again%cost <= found%cost)
  end subroutine test_starts

  !> A place outside of the bounds or off the object is never evaluated.
  subroutine test_limits()
    type(place_search_t) :: search
    type(place_t) :: found
    real(rp) :: q(size(TRUTH))
    integer :: before
    q = 0
    before = sheet%n_evaluations
    search = new_search()
    call search%run(reshape([0.9_rp, 0.9_rp, log(0.2_rp), 1.1_rp, 0.1_rp, log(0.2_rp), 0.5_rp, 0.5_rp, 0.0_rp], [3, 3]), &
                    [-1.0_rp, -1.0_rp, -1.0_rp], q, state, found)
    call test%check('starts off the sheet, or too large, are no places', .not. found%is_valid .and. sheet%n_evaluations == before)
  end subroutine test_limits

  !> A place that was found is released, and all points have it.
  subroutine test_settled()
    real(rp) :: q(size(TRUTH))
    call test%check('before, the variant is not tried', .not. sheet%effects(1)%variants(1)%is_tried())
    call sheet%settle_place(1, TRUTH(5:7), TRUTH(P_PATCH))
    q = sheet%null_point()
    call test%check('then it is', sheet%effects(1)%variants(1)%is_tried())
    call test%check('at its place', all(abs(q(5:7) - TRUTH(5:7)) <= 0) .and. all(abs(sheet%effects(1)%variants(1)%site - &
                                                                                     TRUTH(5:6)) <= 0))
    call test%check('without strength', abs(q(P_PATCH)) <= 0)
    call test%check('but that is known', abs(sheet%effects(1)%strength - TRUTH(P_PATCH)) <= 0)
  end subroutine test_settled
end program test_search_place
