! SPDX-License-Identifier: GPL-3.0-or-later
!> What the statistics of the diagnosis stand on: tails of distributions, and errors made independent.
program test_distributions
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_beam, only: beam_t, make_beam
  use inference_distributions, only: chi2_threshold, detectable_noncentrality, log_chi2_tail, log_f_tail, &
                                     noncentral_chi2_tail
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test

  call test%start(parallel=.false.)
  call test_tails()
  call test_whitening()
  call test%finish()

contains

  !> Against published tables and closed forms.
  subroutine test_tails()
    real(rp) :: x
    call check(abs(exp(log_chi2_tail(3.841458820694124_rp, 1)) - 0.05_rp) < 1.0e-12_rp, 'the tail of chi^2, 1 degree')
    call check(abs(exp(log_chi2_tail(18.307038053275146_rp, 10)) - 0.05_rp) < 1.0e-12_rp, 'the same, 10 degrees')
    call check(abs(log_chi2_tail(2000.0_rp, 2) + 1000) < 1.0e-9_rp, 'probabilities far below the smallest number')
    call check(abs(chi2_threshold(log(0.01_rp), 5) - 15.08627246938899_rp) < 1.0e-9_rp, 'the quantile of chi^2')
    call check(abs(exp(log_f_tail(4.964602743730711_rp, 1, 10)) - 0.05_rp) < 1.0e-10_rp, 'the tail of F(1, 10)')
    call check(abs(exp(log_f_tail(2.710889837096917_rp, 4, 25)) - 0.0528_rp) < 1.0e-3_rp, 'the tail of F(4, 25)')
    call check(abs(log_f_tail(20.0_rp, 2, 4) - log(1/(1 + 10.0_rp)**2)) < 1.0e-10_rp, &
               'the tail of F with two degrees above has a closed form')
    ! A non-central chi^2 with one degree is the square of a shifted normal variable.
    x = 0.5_rp*erfc((2 - 3)/sqrt(2.0_rp)) + 0.5_rp*erfc((2 + 3)/sqrt(2.0_rp))
    call check(abs(noncentral_chi2_tail(4.0_rp, 1, 9.0_rp) - x) < 1.0e-10_rp, 'the tail of non-central chi^2')
    x = detectable_noncentrality(log(0.05_rp), 1, 0.9_rp)
    call check(abs(sqrt(x) - (1.959963984540054_rp + 1.2815515655446004_rp)) < 1.0e-4_rp, &
               'the strength that is found nine times in ten is 3.24 sd at the level 0.05')
  end subroutine test_tails

  !> W C W^T = 1 with C = N + V V^T.
  subroutine test_whitening()
    type(beam_t) :: beam
    type(failure_t) :: failure
    type(whitener_t) :: whitener
    real(rp), allocatable :: nuisances(:, :), patterns(:, :), c(:, :), w(:, :)
    integer :: i, n
    logical :: is_valid
    call make_beam(beam)
    n = 56
    allocate (nuisances(beam%n_observations, beam%n_nuisances), patterns(beam%n_observations, beam%n_patterns), c(n, n))
    call beam%directions(beam%null_point(), solver_state_t(), nuisances, patterns, is_valid)
    call whitener%init(beam, [(i, i=1, n)], 1.0_rp, failure)
    call whitener%add_directions(nuisances(:n, :))
    c = matmul(nuisances(:n, :), transpose(nuisances(:n, :)))
    do i = 1, n
      c(i, i) = c(i, i) + beam%sigma**2
    end do
    w = c
    call whitener%apply(w)
    w = transpose(w)
    call whitener%apply(w)
    do i = 1, n
      w(i, i) = w(i, i) - 1
    end do
    call check(maxval(abs(w)) < 1.0e-9_rp, 'whitened errors are independent and of variance 1')
  end subroutine test_whitening

  !> A sentence that should be true.
  subroutine check(holds, sentence)
    logical, intent(in) :: holds
    character(*), intent(in) :: sentence
    call test%check(sentence, holds)
  end subroutine check
end program test_distributions
