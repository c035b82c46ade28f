! SPDX-License-Identifier: GPL-3.0-or-later
!> Implements `msm_train --evaluate`: computes the cost of the wing with the values in [Wing], load by load, from the unloaded wing.
!> Rank 0 runs it while the other ranks serve the pool.
module train_evaluation
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_kinds, only: rp
  use measurement_bending_pool, only: bending_pool_t
  use measurement_evaluation, only: evaluation_t
  use measurement_experiment, only: experiment_t
  use train_settings, only: train_settings_t
  use training_objective, only: full_results
  implicit none
  private
  public :: evaluate_wing, print_loads, solve_all_cold

contains

  !> Prints the table of loads and, if every shape was found, the cost h [m]; `are_solved` is then true. Prints nothing if the pool
  !> is stopped meanwhile. Only rank 0 calls it.
  subroutine evaluate_wing(settings, pool, are_solved)
    type(train_settings_t), intent(in) :: settings
    type(bending_pool_t), intent(inout) :: pool
    logical, intent(out) :: are_solved
    type(evaluation_t), allocatable :: evaluations(:)
    real(rp), allocatable :: residuals(:)
    integer :: l
    are_solved = .false.
    call solve_all_cold(settings%experiment, pool, settings%experiment%start(), evaluations)
    if (pool%is_stopped) return
    call fit_offsets(settings%experiment, evaluations)
    call print_loads(output_unit, settings%experiment, evaluations)
    allocate (residuals(0))
    are_solved = .true.
    do l = 1, size(evaluations)
      are_solved = are_solved .and. evaluations(l)%is_solved
      residuals = [residuals, evaluations(l)%residuals]
    end do
    if (.not. are_solved) return
    write (output_unit, '(a,es23.15,a)') 'h = ', settings%experiment%cost(residuals), ' m'
  end subroutine evaluate_wing

  !> Fits the unknown offsets of observations, which are not properties of the wing, by least squares. Corrects the residuals by the
  !> offsets and prints the offsets.
  subroutine fit_offsets(experiment, evaluations)
    type(experiment_t), intent(in) :: experiment
    type(evaluation_t), intent(inout) :: evaluations(:)
    real(rp) :: slope, square, offset
    integer :: i, l
    do i = experiment%count_parameters() + 1, experiment%count()
      slope = 0
      square = 0
      do l = 1, size(evaluations)
        if (.not. evaluations(l)%is_solved) cycle
        associate (column => evaluations(l)%jacobian(:, i), sigma => experiment%comparisons(l)%sigma)
          slope = slope + sum(column*evaluations(l)%residuals/sigma**2)
          square = square + sum((column/sigma)**2)
        end associate
      end do
      if (.not. square > 0) cycle
      offset = -slope/square
      do l = 1, size(evaluations)
        evaluations(l)%residuals = evaluations(l)%residuals + offset*evaluations(l)%jacobian(:, i)
      end do
      write (output_unit, '(a,es14.6,a)') 'fitted value of zero:'// &
        trim(experiment%measurement%zeros(i - experiment%count_parameters()))//':', offset, ' m'
    end do
  end subroutine fit_offsets

  !> Solves all loads at these coordinates from the unloaded wing. Results are incomplete if the pool was stopped meanwhile.
  subroutine solve_all_cold(experiment, pool, coordinates, evaluations)
    type(experiment_t), intent(in) :: experiment
    type(bending_pool_t), intent(inout) :: pool
    real(rp), intent(in) :: coordinates(:)
    type(evaluation_t), allocatable, intent(out) :: evaluations(:)
    real(rp), allocatable :: starts(:, :, :), shapes(:, :, :)
    logical :: is_start(size(experiment%loads))
    allocate (starts(3, experiment%model%n_all, size(experiment%loads)), source=0.0_rp)
    is_start = .false.
    call full_results(experiment, pool, coordinates, is_start, starts, evaluations, shapes)
  end subroutine solve_all_cold

  !> Prints a header and a row for every load: force, number of points, misfit, and the work of the solution.
  subroutine print_loads(unit, experiment, evaluations)
    integer, intent(in) :: unit
    type(experiment_t), intent(in) :: experiment
    type(evaluation_t), intent(in) :: evaluations(:)
    real(rp), parameter :: UM = 1.0e6_rp
    real(rp) :: rms, largest, chi2
    integer :: l, n
    write (unit, '(a)') 'load              force [N]   points   rms [um]   largest [um]   chi^2/points  factors  snaps'
    do l = 1, size(evaluations)
      associate (e => evaluations(l), comparison => experiment%comparisons(l), load => experiment%measurement%loads(l))
        n = comparison%n_heights
        rms = 0
        largest = 0
        if (n > 0) rms = sqrt(sum(e%residuals(:n)**2)/n)
        if (n > 0) largest = maxval(abs(e%residuals(:n)))
        chi2 = sum((e%residuals/comparison%sigma)**2)/max(1, comparison%n)
        if (e%is_solved) then
          write (unit, '(a16,es11.3,i9,f11.4,f15.4,es15.4,i9,i7,a)') load%name//repeat(' ', 16), load%force, &
            comparison%n, UM*rms, UM*largest, chi2, e%factorisations, e%snaps, &
            trim(merge('  in an excluded zone', '                     ',.not. e%is_feasible()))
        else
          write (unit, '(a16,es11.3,i9,a)') load%name//repeat(' ', 16), load%force, comparison%n, &
            '  no equilibrium found'
        end if
      end associate
    end do
    flush (unit)
  end subroutine print_loads
end module train_evaluation
