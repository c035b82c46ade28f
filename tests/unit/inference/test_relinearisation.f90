! SPDX-License-Identifier: GPL-3.0-or-later
!> An error of the model that looks otherwise where the cause is than where the baseline is.
!>
!> The beam has a one-way joint, and an error of the size of its sd: for the baseline it is a bow of the span, where the joint
!> is one-way it is a twist. Seen from the baseline the twist is nothing that errors do: a second cause stands beside the
!> joint. Seen from the fit of the joint there is no second one, and the joint is as strong as if its error were known.
!>
!> An error that grows whenever it is renewed makes any cause fit better. That is no evidence: what it grows by counts against it.
program test_relinearisation
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_beam, only: make_beam, E_ONE_WAY, E_TORSION, N_ALL, N_BASE, P_ONE_WAY
  use inference_decision, only: VERDICT_ADEQUATE, VERDICT_NAMED
  use inference_engine, only: diagnosis_options_t, diagnosis_t, run_diagnosis
  use testkit, only: testkit_t
  use turning_error, only: angle_of, error_of, factor_of, growing_t, turning_t, twisted_t, TRUTH
  implicit none
  type(testkit_t) :: t
  type(twisted_t), target :: beam
  type(turning_t) :: error
  type(growing_t) :: growing
  type(diagnosis_t), target :: known, blind, seeing, refused, none
  type(diagnosis_options_t) :: options
  type(failure_t) :: failure
  real(rp) :: q0(N_ALL), q(N_ALL)

  call t%start(parallel=.false.)
  call make_beam(beam%beam_t)
  beam%n_nuisances = beam%n_nuisances + 1
  options%n_draws = 1000
  options%validates = .false.
  q0 = beam%parameters%null
  q = q0
  q(P_ONE_WAY) = TRUTH
  call beam%observe(q, beam%sigma, 800001)
  beam%angle = angle_of(q)
  beam%data = beam%data + error_of(beam, beam%angle)
  call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, known, failure)
  call t%check('with the right error the joint is named', known%decision%verdict == VERDICT_NAMED .and. &
               all(known%decision%set == E_ONE_WAY) .and. .not. known%decision%is_joint)
  beam%angle = 0
  call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, blind, failure)
  call t%check('with that of the baseline the twist is a second cause', any(blind%decision%set == E_TORSION))
  call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, seeing, failure, model_error=error)
  call t%check('the error is taken where the joint is', error%n_calls > 0 .and. .not. failure%failed)
  call t%check('and then the joint is named alone', seeing%decision%verdict == VERDICT_NAMED .and. &
               size(seeing%decision%causes) == 1 .and. all(seeing%decision%set == E_ONE_WAY))
  call t%check('its interval holds the truth', seeing%intervals(1)%lower < TRUTH)
  call t%check('and does not end before it', TRUTH < seeing%intervals(1)%upper)
  call t%check_close('as it does where the error is known, to a tenth of its sd', seeing%extended%q(P_ONE_WAY), &
                     known%extended%q(P_ONE_WAY), atol=0.1_rp*deviation(known))
  call t%check_close('with the p of the first linearisation', seeing%decision%log_p_global, blind%decision%log_p_global, &
                     rtol=1.0e-12_rp)
  call t%check_close('and its size of the noise', seeing%tests%scale, blind%tests%scale, rtol=1.0e-12_rp)
  call beam%observe(q, beam%sigma, 800001)
  beam%data = beam%data + error_of(beam, beam%angle)
  call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, blind, failure)
  call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, refused, failure, model_error=growing)
  call t%check('an error that grows is asked for', growing%n_calls > 0 .and. .not. failure%failed)
  call t%check('and not taken, though everything fits better with it', &
               abs(factor_of(refused%model%baseline%state) - 1) < epsilon(1.0_rp))
  call t%check_close('the estimate is that of the first linearisation', refused%extended%q(P_ONE_WAY), &
                     blind%extended%q(P_ONE_WAY), rtol=1.0e-12_rp)
  call t%check_close('and so is its sd', deviation(refused), deviation(blind), rtol=1.0e-12_rp)
  ! Without a cause nothing is linearised again.
  error%n_calls = 0
  call beam%observe(q0, beam%sigma, 800002)
  call run_diagnosis(beam, reshape(q0, [N_ALL, 1]), options, none, failure, model_error=error)
  call t%check('noise is no reason to linearise again', none%decision%verdict == VERDICT_ADEQUATE .and. error%n_calls == 0)
  call t%finish()

contains

  real(rp) function deviation(d)
    type(diagnosis_t), intent(in) :: d
    deviation = sqrt(d%extended%covariance(N_BASE + 1, N_BASE + 1))
  end function deviation
end program test_relinearisation
