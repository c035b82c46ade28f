! SPDX-License-Identifier: GPL-3.0-or-later
!> The fit of a vibration over many periods finds its frequency if it begins with the first of them: another start loses count.
program test_growing_fit
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_growing_fit, only: grow_fit
  use inference_refit, only: fit_baseline, nested_fit_t
  use inference_whitener, only: whitener_t
  use least_squares_fit, only: fit_options_t
  use least_squares_state, only: solver_state_t
  use long_vibration, only: make_vibration, vibration_t, IN_PERIOD
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: PERIODS = 100, FIRST = 4
  real(rp), parameter :: TRUTH(2) = [0.1_rp, 0.1_rp] !< ten periods more in the record
  type(testkit_t) :: t
  type(vibration_t), target :: vibration
  class(solver_state_t), allocatable :: state
  type(fit_options_t) :: options
  real(rp) :: q(2), early(2)
  integer :: i

  call t%start(parallel=.false.)
  call make_vibration(PERIODS, TRUTH, vibration)
  call vibration%initial_state(state)
  call t%check('from its usual start the fit ends in another minimum', chi2_from([0.0_rp, 0.0_rp]) > 1000)
  q = 0
  call grow_fit(vibration, state, 1.0_rp, options, q)
  call t%check('observations without stages change no start', all(abs(q) <= 0))
  vibration%labels%stage = [(0, i=1, vibration%n_observations)]
  call grow_fit(vibration, state, 1.0_rp, options, q)
  call t%check('nor do those of one stage', all(abs(q) <= 0))
  ! The first periods, and then twice as many each time.
  do i = 1, vibration%n_observations
    vibration%labels%stage(i) = max(0, ceiling(log(real(i, rp)/(FIRST*IN_PERIOD))/log(2.0_rp)))
  end do
  call grow_fit(vibration, state, 1.0_rp, options, q)
  call t%check_close('in stages the frequency is found', q(1), TRUTH(1), atol=1.0e-6_rp)
  call t%check_below('and the fit to all observations is that of the truth', chi2_from(q), 0.1_rp)
  ! Only the last stage differs: what joins last is not part of the start.
  early = q
  where (vibration%labels%stage == maxval(vibration%labels%stage)) vibration%data = 0
  q = 0
  call grow_fit(vibration, state, 1.0_rp, options, q)
  call t%check('the last stage takes no part', all(abs(q - early) <= 0))
  call t%finish()

contains

  !> The sum of squares where the fit of the baseline from a start ends, priors included.
  real(rp) function chi2_from(start) result(chi2)
    real(rp), intent(in) :: start(2)
    type(whitener_t), target :: whitener
    type(nested_fit_t) :: found
    type(failure_t) :: failure
    class(solver_state_t), allocatable :: own
    real(rp), allocatable :: spread(:)
    integer :: k
    call whitener%init(vibration, [(k, k=1, vibration%n_observations)], 1.0_rp, failure)
    allocate (own, source=state)
    call fit_baseline(vibration, reshape(start, [2, 1]), options, own, whitener, found, spread, failure)
    chi2 = found%chi2
  end function chi2_from
end program test_growing_fit
