! SPDX-License-Identifier: GPL-3.0-or-later
!> Causes together, in a space where they are vectors: three of them, right-angled and equally strong, and a fourth effect that
!> lies nearly along their sum. It explains more than any of them, and any pair with it more than any pair without; the first
!> three explain everything.
program test_joint_causes
  use base_kinds, only: rp
  use inference_decision, only: rank_effects
  use inference_design, only: design_t
  use inference_hypotheses, only: explained_t, hypotheses_t, IMPOSSIBLE
  use inference_joint_causes, only: find_joint_causes
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: K = 6, SUM_OF_ALL = 4
  real(rp), parameter :: STRENGTH = 20 !< [sd] of each
  type(testkit_t) :: t
  type(design_t) :: design
  type(hypotheses_t) :: hypotheses
  type(explained_t) :: found
  integer, allocatable :: order(:)
  real(rp) :: z(K), log_odds

  call t%start(parallel=.false.)
  call make_design()
  z = [STRENGTH, STRENGTH, STRENGTH, 0.0_rp, 0.0_rp, 0.0_rp]
  call hypotheses%init(design, size(design%candidates), z)
  order = rank_effects(hypotheses)
  call t%check('the sum leads', order(1) == SUM_OF_ALL)
  call find_joint_causes(design, hypotheses, order, found, log_odds)
  call t%check('it is exchanged for what it stood for', size(found%members) == 3 .and. .not. &
               any(found%members == SUM_OF_ALL))
  call t%check_close('which leaves nothing', sum(found%left**2), 0.0_rp, atol=1.0e-9_rp)
  z = [STRENGTH, STRENGTH, 0.0_rp, 0.0_rp, 0.0_rp, 0.0_rp]
  call hypotheses%init(design, size(design%candidates), z)
  call find_joint_causes(design, hypotheses, rank_effects(hypotheses), found, log_odds)
  call t%check('two are two', size(found%members) == 2 .and. all([1, 2] == sorted(found%members)))
  call find_joint_causes(design, hypotheses, [1], found, log_odds)
  call t%check('one is none together', size(found%members) == 0 .and. log_odds <= IMPOSSIBLE)
  call t%finish()

contains

  subroutine make_design()
    real(rp) :: direction(K)
    integer :: i
    design%k = K
    allocate (design%candidates(4), design%families(0))
    do i = 1, 4
      direction = 0
      direction(i) = 1
      if (i == SUM_OF_ALL) direction = [1.0_rp, 1.0_rp, 1.0_rp, 0.4_rp, 0.0_rp, 0.0_rp]
      associate (one => design%candidates(i))
        one%effect = i
        one%weight = 1
        one%df = 1
        one%columns = [i]
        one%basis = reshape(direction/norm2(direction), [K, 1])
        call one%size_prior%init([1.0_rp])
      end associate
    end do
  end subroutine make_design

  pure function sorted(pair)
    integer, intent(in) :: pair(:)
    integer :: sorted(2)
    sorted = [minval(pair), maxval(pair)]
  end function sorted
end program test_joint_causes
