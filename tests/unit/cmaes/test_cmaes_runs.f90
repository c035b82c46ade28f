! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs of CMA-ES on known functions, for the tests of it.
module test_cmaes_runs
  use base_kinds, only: rp, i8
  use base_random, only: random_uniforms
  use cmaes_optimiser, only: cmaes_t
  use cmaes_options, only: cmaes_options_t
  use cmaes_params, only: derive_params
  use cmaes_ranking, only: sort_values
  use cmaes_stop, only: RUNNING, FTARGET
  use search_functions, only: value_of
  implicit none
  private
  public :: median_evaluations, start_run, step

contains

  !> A run with the reference's start and step and without tolerances of f and x.
  subroutine start_run(name, n, lambda, seed, options, run)
    character(*), intent(in) :: name
    integer, intent(in) :: n, lambda, seed
    type(cmaes_options_t), intent(in) :: options
    type(cmaes_t), intent(out) :: run
    type(cmaes_options_t) :: chosen
    real(rp) :: mean(n)
    chosen = options
    chosen%lambda = lambda
    chosen%seed = seed
    chosen%sigma0 = merge(0.5_rp, 1.0_rp, name == 'rosen')
    chosen%tolfun = 0
    chosen%tolfunhist = 0
    chosen%tolx = 0
    mean = merge(0.0_rp, 1.0_rp, name == 'rosen')
    call run%start(chosen, derive_params(chosen, n), mean, has_box=.false.)
  end subroutine start_run

  !> One generation; a share `failing` of the candidates fails at random.
  subroutine step(name, run, failing)
    character(*), intent(in) :: name
    type(cmaes_t), intent(inout) :: run
    real(rp), intent(in) :: failing
    real(rp) :: x(run%params%n, run%params%lambda), f(run%params%lambda), u(2)
    logical :: has_failed(run%params%lambda)
    integer :: k
    call run%ask(x)
    do k = 1, size(f)
      f(k) = value_of(name, x(:, k))
      u = random_uniforms(run%options%seed, 99_i8, run%state%counts%evaluations + k)
      has_failed(k) = u(1) < failing
    end do
    call run%tell(f, has_failed=has_failed)
  end subroutine step

  !> Median over seeds of the evaluations to f <= 1e-10, whole generations; huge if half did not get there.
  real(rp) function median_evaluations(name, n, lambda, seeds, failing, options) result(median)
    character(*), intent(in) :: name
    integer, intent(in) :: n, lambda, seeds(:)
    real(rp), intent(in) :: failing
    type(cmaes_options_t), intent(in) :: options
    type(cmaes_options_t) :: chosen
    type(cmaes_t) :: run
    real(rp) :: evaluations(size(seeds))
    integer :: s
    chosen = options
    chosen%f_target = 1.0e-10_rp
    do s = 1, size(seeds)
      call start_run(name, n, lambda, seeds(s), chosen, run)
      do while (run%state%stop_code == RUNNING)
        call step(name, run, failing)
      end do
      evaluations(s) = huge(1.0_rp)
      if (run%state%stop_code == FTARGET) evaluations(s) = real(run%state%best%evaluation, rp)
    end do
    call sort_values(evaluations)
    median = evaluations((size(seeds) + 1)/2)
  end function median_evaluations
end module test_cmaes_runs
