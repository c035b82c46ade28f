! SPDX-License-Identifier: GPL-3.0-or-later
!> Intervals of causes where a load may snap to another shape.
!>
!> Where there are two equilibria, what counts is the one in which the best fit is, and the interval is that of a beam which
!> does not snap: refits that have come into the other one on the way say nothing about this one. Where there is only the other
!> one, the interval ends, and says that it does so at a jump.
program test_snapping
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_beam, only: make_beam, N_ALL, N_BASE, P_ONE_WAY, P_TORSION
  use inference_intervals, only: find_intervals
  use inference_refit, only: fit_nested, nested_fit_t
  use inference_whitener, only: whitener_t
  use least_squares_fit, only: fit_options_t
  use least_squares_profile, only: interval_t
  use snapping_beam, only: site_t, snapping_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: ROOT = 0.02_rp !< of the half width: each end is where the root is within 1 % of its threshold
  type(testkit_t) :: t
  type(snapping_t), target :: beam
  type(interval_t) :: smooth, snapping, folded, smooth_twist, twist
  real(rp) :: best, width

  call t%start(parallel=.false.)
  call make_beam(beam%beam_t)
  beam%column = P_ONE_WAY
  call measure()
  call find(smooth, smooth_twist)
  best = smooth%best
  width = 0.5_rp*(smooth%upper - smooth%lower)
  call t%check('the beam that does not snap has two ends', smooth%has_lower .and. smooth%has_upper .and. width > 0)

  beam%farthest = 0.6_rp*width
  call find(snapping, twist)
  call t%check('two equilibria leave two ends', snapping%has_lower .and. snapping%has_upper)
  call t%check_close('the best is that of the beam that does not snap', snapping%best, best, atol=ROOT*width)
  call t%check_close('and so is the lower end', snapping%lower, smooth%lower, atol=ROOT*width)
  call t%check_close('and the upper one', snapping%upper, smooth%upper, atol=ROOT*width)
  call t%check('neither is a jump',.not. any(snapping%is_jump))

  beam%farthest = huge(1.0_rp)
  beam%fold = best + 0.5_rp*width
  call find(folded, twist)
  call t%check_close('a fold ends the interval', folded%upper, beam%fold, atol=ROOT*width)
  call t%check_close('on its side', folded%lower, smooth%lower, atol=ROOT*width)
  call t%check('which is said', folded%is_jump(2) .and. .not. folded%is_jump(1) .and. folded%has_upper)
  call t%check_close('the other parameter of the cause has the interval of the beam that does not snap', twist%lower, &
                     smooth_twist%lower, atol=ROOT*0.5_rp*(smooth_twist%upper - smooth_twist%lower))
  call t%check_close('at both ends', twist%upper, smooth_twist%upper, &
                     atol=ROOT*0.5_rp*(smooth_twist%upper - smooth_twist%lower))
  call t%finish()

contains

  subroutine measure()
    real(rp) :: q(N_ALL)
    q = beam%parameters%null
    q(P_ONE_WAY) = 1
    call beam%observe(q, beam%sigma, 910001)
  end subroutine measure

  !> The intervals of the one-way joint and, after it, of the torsion, after a fit of both and the baseline.
  subroutine find(interval, second)
    type(interval_t), intent(out) :: interval, second
    type(interval_t), allocatable :: intervals(:)
    type(whitener_t), target :: whitener
    type(nested_fit_t) :: found
    type(fit_options_t) :: options
    type(failure_t) :: failure
    real(rp) :: nuisances(beam%n_observations, beam%n_nuisances), patterns(beam%n_observations, 0), q(N_ALL)
    real(rp) :: farthest
    logical :: is_valid
    integer :: i
    farthest = beam%farthest
    beam%farthest = huge(farthest) ! the fit itself finds its way
    q = beam%parameters%null
    call beam%directions(q, site_t(), nuisances, patterns, is_valid)
    call whitener%init(beam, [(i, i=1, beam%n_observations)], 1.0_rp, failure)
    call whitener%add_directions(nuisances)
    q(P_ONE_WAY) = 0.9_rp
    call fit_nested(beam, whitener, [(i, i=1, N_BASE), P_ONE_WAY, P_TORSION], q, site_t(), options, found)
    call t%check('the fit has an end', found%is_found .and. .not. failure%failed)
    select type (site => found%state)
    type is (site_t)
      call t%check('beside the shape that it began with',.not. site%is_snapped)
    end select
    beam%farthest = farthest
    call find_intervals(beam, whitener, 1.0_rp, options, found, intervals)
    interval = intervals(1)
    second = intervals(2)
  end subroutine find
end program test_snapping
