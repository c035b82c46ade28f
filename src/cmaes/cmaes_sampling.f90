! SPDX-License-Identifier: GPL-3.0-or-later
!> Draws candidates. They depend on the state and on (seed, restart, generation, attempt, candidate) alone: x = m + sigma B
!> diag(d) B^T z with z from a counter-based generator.
!>
!> The symmetric root makes x independent of the signs and, for equal eigenvalues, of the choice of the
!> eigenvectors, which differ between LAPACK libraries.
module cmaes_sampling
  use base_kinds, only: rp, i8
  use base_random, only: fill_gaussians, random_uniforms
  use cmaes_products, only: multiply
  use cmaes_state, only: cmaes_state_t, cmaes_work_t
  implicit none
  private
  public :: draw_candidate, draw_uniforms

  integer, parameter :: ATTEMPT_BITS = 8

contains

  !> Draws candidate k of the present generation, x(n), from the roots in `work`.
  subroutine draw_candidate(state, work, k, x)
    type(cmaes_state_t), intent(in) :: state
    type(cmaes_work_t), intent(inout) :: work
    integer, intent(in) :: k
    real(rp), intent(out), contiguous :: x(:)
    call draw_normals(state%seed, state%restart, state%generation + 1, state%attempt, k, work%z)
    call multiply(work%root, work%z, x)
    x = state%mean + state%sigma*x
  end subroutine draw_candidate

  !> Draws independent numbers of mean 0 and variance 1. `restart` is below 2^23, `attempt` below 2^8; the others are not
  !> negative.
  pure subroutine draw_normals(seed, restart, generation, attempt, candidate, z)
    integer(i8), intent(in) :: seed
    integer, intent(in) :: restart, generation, attempt, candidate
    real(rp), intent(out), contiguous :: z(:)
    integer(i8) :: stream
    stream = shiftl(ior(shiftl(int(restart, i8), ATTEMPT_BITS), int(attempt, i8)), 32) + generation
    call fill_gaussians(seed, stream, shiftl(int(candidate, i8), 32), z)
  end subroutine draw_normals

  !> Draws independent numbers in (0, 1) for the start of run `restart`. They differ from the numbers of all candidates, whose
  !> generations count from 1. `purpose` separates different uses.
  pure subroutine draw_uniforms(seed, restart, purpose, u)
    integer(i8), intent(in) :: seed
    integer, intent(in) :: restart, purpose
    real(rp), intent(out) :: u(:)
    real(rp) :: pair(2)
    integer(i8) :: stream
    integer :: i
    stream = shiftl(shiftl(int(restart, i8), ATTEMPT_BITS), 32)
    do i = 1, size(u)
      pair = random_uniforms(seed, stream, shiftl(int(purpose, i8), 32) + i)
      u(i) = pair(1)
    end do
  end subroutine draw_uniforms
end module cmaes_sampling
