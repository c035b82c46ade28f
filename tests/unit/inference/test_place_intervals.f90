! SPDX-License-Identifier: GPL-3.0-or-later
!> The interval of a cause whose place is one of several, against fits at all of them.
program test_place_intervals
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_beam, only: beam_t, make_beam, E_ROOT, E_SOFT, N_ALL, P_SOFT
  use inference_engine, only: diagnosis_options_t, diagnosis_t, run_diagnosis
  use inference_intervals, only: find_intervals
  use inference_place_intervals, only: widen_over_places
  use inference_refit, only: fit_nested, nested_fit_t
  use least_squares_profile, only: interval_t, THRESHOLD_90
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: TRUE_PLACE = 6
  real(rp), parameter :: SIGMA = 0.02_rp, TRUTH = 0.25_rp !< errors so large that neighbours are nearly as probable
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_widening()
  call t%finish()

contains

  subroutine test_widening()
    type(beam_t), target :: beam
    type(diagnosis_t), target :: d
    type(diagnosis_options_t) :: options
    type(nested_fit_t), allocatable :: found(:)
    type(interval_t), allocatable :: intervals(:), root(:)
    type(interval_t) :: widened
    type(failure_t) :: failure
    integer, allocatable :: places(:)
    real(rp) :: q(N_ALL), lower, upper, reach
    integer :: i, best, n_near
    options%n_draws = 500
    options%validates = .false.
    options%finds_intervals = .false.
    call make_beam(beam)
    beam%sigma = SIGMA
    q = beam%parameters%null
    q(P_SOFT + TRUE_PLACE - 1) = TRUTH
    call beam%observe(q, beam%sigma, 940001)
    call run_diagnosis(beam, reshape(beam%parameters%null, [N_ALL, 1]), options, d, failure)
    call t%check('the beam is diagnosed',.not. failure%failed)
    associate (model => d%model, candidates => d%model%design%candidates)
      places = pack([(i, i=1, size(candidates))], candidates%effect == E_SOFT)
      allocate (found(size(places)))
      do i = 1, size(places)
        call fit_nested(beam, model%whitener, [model%baseline%active, candidates(places(i))%columns], model%baseline%q, &
                        model%baseline%state, options%fit, found(i))
      end do
      best = minloc([(found(i)%cost(), i=1, size(found))], 1)
      lower = huge(lower)
      upper = -lower
      n_near = 0
      do i = 1, size(found)
        associate (c => size(found(i)%active), column => candidates(places(i))%columns(1))
          reach = THRESHOLD_90 - (found(i)%cost() - found(best)%cost())
          if (reach < 0) cycle
          n_near = n_near + 1
          reach = sqrt(reach*found(i)%covariance(c, c))
          lower = min(lower, found(i)%q(column) - reach)
          upper = max(upper, found(i)%q(column) + reach)
        end associate
      end do
      call t%check('several places are probable', n_near > 1)
      call find_intervals(beam, model%whitener, 1.0_rp, options%fit, found(best), intervals)
      widened = intervals(1)
      call widen_over_places(beam, model%design, model%whitener, 1.0_rp, options%fit, places(best), found(best), widened)
      ! That of the best place itself is found by profiles, and its reach above is linear: a tenth of it.
      reach = 0.1_rp*(intervals(1)%upper - intervals(1)%lower)
      call t%check('the place widens the interval', widened%upper - widened%lower > intervals(1)%upper - intervals(1)%lower + reach)
      call t%check_close('the lower end is that of the most distant probable place', widened%lower, lower, atol=reach)
      call t%check_close('so is the upper end', widened%upper, upper, atol=reach)
      i = findloc(candidates%effect, E_ROOT, 1)
      call fit_nested(beam, model%whitener, [model%baseline%active, candidates(i)%columns], model%baseline%q, &
                      model%baseline%state, options%fit, found(1))
      call find_intervals(beam, model%whitener, 1.0_rp, options%fit, found(1), root)
      widened = root(1)
      call widen_over_places(beam, model%design, model%whitener, 1.0_rp, options%fit, i, found(1), widened)
      call t%check_close('without other places the lower end stays', widened%lower, root(1)%lower, rtol=1.0e-15_rp)
      call t%check_close('and the upper end', widened%upper, root(1)%upper, rtol=1.0e-15_rp)
    end associate
  end subroutine test_widening
end program test_place_intervals
