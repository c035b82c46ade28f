! SPDX-License-Identifier: GPL-3.0-or-later
!> Odds of several causes, and unknown causes made of known quantities, on a wing in closed form (diagnosis_beam).
program test_hypotheses
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_beam, only: beam_t, make_beam, E_DRIFT, E_SOFT, P_SOFT
  use diagnosis_design, only: build_design, design_t
  use diagnosis_hypotheses, only: add_effect, explain, explained_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  type(beam_t), target :: beam
  type(design_t) :: design
  type(failure_t) :: failure
  real(rp), allocatable :: q0(:)

  call test%start(parallel=.false.)
  call make_beam(beam)
  q0 = beam%null_point()
  call beam%observe(q0, beam%sigma, 1)
  call build_design(beam, q0, design, failure)
  call check(.not. failure%failed, 'the design exists')
  call test_choice()
  call test_field()
  call test%finish()

contains

  !> A sentence that should be true.
  subroutine check(holds, sentence)
    logical, intent(in) :: holds
    character(*), intent(in) :: sentence
    call test%check(sentence, holds)
  end subroutine check

  !> The evidence of a second effect that may be at many places is the mean over them, here one by one, and not that of
  !> the best place.
  subroutine test_choice()
    type(explained_t) :: first, pair, one
    real(rp) :: z(design%k), mean, most
    integer :: c, n, drift
    drift = 0
    do c = 1, size(design%candidates)
      if (design%candidates(c)%effect == E_DRIFT) drift = c
    end do
    z = [(sin(1.7_rp*c**2), c=1, size(z))] + 8*design%candidates(drift)%basis(:, 1)
    call explain(design, [drift], z, first)
    call add_effect(design, first, E_SOFT, pair)
    n = 0
    mean = 0
    most = -huge(most)
    do c = 1, size(design%candidates)
      if (design%candidates(c)%effect /= E_SOFT .or. design%candidates(c)%df == 0) cycle
      call explain(design, [drift, c], z, one)
      n = n + 1
      mean = mean + exp(one%log_evidence - first%log_evidence)
      most = max(most, one%log_evidence)
      if (c == pair%members(2)) call check(maxval(abs(one%left - pair%left)) < 1.0e-12_rp, 'what a pair leaves')
    end do
    call check(n > 5 .and. abs(pair%log_evidence - first%log_evidence - log(mean/n)) < 1.0e-10_rp, &
               'an effect that may be at many places pays for the choice')
    call check(pair%log_evidence < most - 0.1_rp, 'which is less than the best place promises')
  end subroutine test_choice

  !> Unknown strengths of all soft places at once: the family spans what single ones do.
  subroutine test_field()
    type(beam_t) :: other
    type(design_t) :: wide
    real(rp) :: worst
    integer :: c, n
    call make_beam(other)
    call other%observe(q0, other%sigma, 1)
    n = size(other%quantities) - P_SOFT + 1
    other%field = [(c, c=P_SOFT, size(other%quantities))]
    other%family = [other%family, (maxval(other%family) + 1, c=1, n)]
    call build_design(other, q0, wide, failure)
    worst = 0
    associate (field => wide%families(size(wide%families)))
      do c = 1, size(wide%candidates)
        if (wide%candidates(c)%effect /= E_SOFT) cycle
        associate (t => wide%candidates(c)%tangents(:, 1))
          worst = max(worst, norm2(t - matmul(field%basis, matmul(t, field%basis)))/norm2(t))
        end associate
      end do
      call check(size(wide%families) == size(design%families) + 1 .and. worst < 1.0e-5_rp .and. &
                 size(field%patterns) == n .and. size(field%alone, 2) == 0, 'a field of quantities is an unknown cause')
    end associate
    call check(wide%k == design%k, 'and costs no directions')
  end subroutine test_field
end program test_hypotheses
