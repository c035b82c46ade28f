! SPDX-License-Identifier: GPL-3.0-or-later
!> Where full fits of a diagnosis begin and end, where that is not all the same.
!>
!> A wing has another equilibrium for the same parameters: an effect is judged by the one in which its fit has ended. Errors
!> whose directions never settle: baseline and design have the same ones, so that what the baseline leaves is what the design
!> sees. An effect that its tangents at the baseline do not lead to, and one of which it is a part.
program test_refits
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_beam, only: make_beam, E_ONE_WAY, E_SPAN, E_TORSION, N_ALL, N_BASE, P_BOTH, P_ONE_WAY, P_TORSION
  use inference_decision, only: VERDICT_NAMED
  use inference_engine, only: diagnosis_options_t, diagnosis_t, refit_t, run_diagnosis
  use inference_refit, only: fit_nested
  use inference_top_candidates, only: refit_top_candidates
  use snapping_beam, only: snapping_t
  use stubborn_beams, only: curled_t, fickle_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(diagnosis_options_t) :: options

  call t%start(parallel=.false.)
  options%n_draws = 500
  call test_other_equilibrium()
  call test_fickle_error()
  call test_part()
  call t%finish()

contains

  !> The joint is found in steps of which none snaps, but all of them at once would.
  subroutine test_other_equilibrium()
    real(rp), parameter :: TRUTH = -1.5_rp
    type(snapping_t), target :: beam
    type(diagnosis_t), target :: smooth, snapping
    type(failure_t) :: failure
    real(rp) :: q0(N_ALL), q(N_ALL)
    call make_beam(beam%beam_t)
    beam%column = P_ONE_WAY
    beam%sigma = 0.0004_rp
    q0 = beam%parameters%null
    q = q0
    q(P_ONE_WAY) = TRUTH
    call beam%observe(q, beam%sigma, 920001)
    call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, smooth, failure)
    call t%check('the joint is named where nothing snaps', smooth%decision%verdict == VERDICT_NAMED .and. &
                 all(smooth%decision%set == E_ONE_WAY))
    beam%farthest = 1.3_rp
    call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, snapping, failure)
    call t%check('and where the way back snaps', snapping%decision%verdict == VERDICT_NAMED .and. &
                 all(snapping%decision%set == E_ONE_WAY))
    call t%check_close('with what is left for noise', snapping%decision%remainder_log_p, &
                       smooth%decision%remainder_log_p, rtol=1.0e-6_rp)
    call t%check_close('the interval has the same lower end', snapping%intervals(1)%lower, smooth%intervals(1)%lower, &
                       rtol=1.0e-3_rp)
    call t%check_close('and upper end', snapping%intervals(1)%upper, smooth%intervals(1)%upper, rtol=1.0e-3_rp)
    call t%check_close('and the gain is the same', snapping%prediction%gain, smooth%prediction%gain, rtol=1.0e-3_rp)
  end subroutine test_other_equilibrium

  !> With the bow of the data among the errors the beam is as stiff as it is, where errors are no bow; without it it is softer,
  !> where they are.
  subroutine test_fickle_error()
    type(fickle_t), target :: beam
    type(diagnosis_t), target :: d
    type(failure_t) :: failure
    real(rp) :: q0(N_ALL), before(2)
    call make_beam(beam%beam_t)
    beam%n_nuisances = beam%n_nuisances + 1
    beam%size = 20
    q0 = beam%parameters%null
    call beam%observe(q0, beam%sigma, 930001)
    beam%data = beam%data - 3*beam%error(.true.)
    beam%edge = huge(beam%edge)
    call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, d, failure)
    before(1) = d%model%baseline%q(1)
    beam%edge = -huge(beam%edge)
    call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, d, failure)
    before(2) = d%model%baseline%q(1)
    call t%check('either direction leads to the other side', before(1) > before(2) .and. .not. failure%failed)
    beam%edge = sum(before)/2
    call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, d, failure)
    call t%check('there is a diagnosis',.not. failure%failed)
    ! Both are sums of squares about 700; the fit ends where steps gain less than 1e-5 of it.
    call t%check_close('what the baseline leaves is what the design sees', sum(d%tests%z**2)*d%tests%scale + &
                       d%tests%residual_square, d%model%baseline%cost(), atol=0.1_rp)
  end subroutine test_fickle_error

  !> From the baseline the torsion goes the wrong way. Fitted with a second parameter, from elsewhere, it does not.
  subroutine test_part()
    real(rp), parameter :: TRUTH = 1.5_rp
    type(curled_t), target :: beam
    type(diagnosis_t), target :: d
    type(refit_t) :: whole(1)
    type(failure_t) :: failure
    real(rp) :: q0(N_ALL), q(N_ALL)
    integer :: i
    call make_beam(beam%beam_t)
    beam%effects(E_SPAN)%variants(1)%columns = [P_TORSION]
    q0 = beam%parameters%null
    q = q0
    q(P_TORSION) = TRUTH
    call beam%observe(q, beam%sigma, 940001)
    call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, d, failure)
    i = findloc(d%model%design%candidates(d%refits%candidate)%effect, E_SPAN, 1)
    call t%check('from the baseline it is not found',.not. failure%failed .and. i > 0)
    call t%check('but goes the other way', d%refits(max(1, i))%found%q(P_TORSION) < 0)
    whole%candidate = findloc(d%model%design%candidates%effect, E_TORSION, 1)
    call fit_nested(beam, d%model%whitener, [d%model%baseline%active, P_TORSION, P_BOTH], q, &
                    d%model%baseline%state, options%fit, whole(1)%found)
    d%refits = whole
    call refit_top_candidates(beam, options, d%model, d%tests, d%hypotheses, d%refits, d%decision)
    i = findloc(d%model%design%candidates(d%refits%candidate)%effect, E_SPAN, 1)
    call t%check_close('beside a fit of which it is a part it is', d%refits(i)%found%q(P_TORSION), TRUTH, &
                       atol=4*sqrt(whole(1)%found%covariance(N_BASE + 1, N_BASE + 1)))
    call t%check('and leads', maxloc(d%hypotheses%effect, 1) == E_SPAN)
  end subroutine test_part
end program test_refits
