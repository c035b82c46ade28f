! SPDX-License-Identifier: GPL-3.0-or-later
!> Implements `msm_train --screen`: tells which veins and joints these loads can determine at all. It uses the derivatives of all
!> measured values, in units of their errors, at the wing with the values in [Wing]. Rank 0 runs it while the other ranks serve the
!> pool.
!>
!> It ranks the parameters one after another (QR with column pivoting). The next parameter is always the one whose effect the
!> parameters ranked so far imitate least. Parameters are proposed as long as the predicted 90 % interval of each, in a fit together
!> with all earlier proposals, is within a factor of two.
module train_screening
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use measurement_bending_pool, only: bending_pool_t
  use measurement_evaluation, only: evaluation_t
  use measurement_experiment, only: experiment_t
  use solid_usual_causes, only: N_COMMON, PARAM_YOUNG
  use train_evaluation, only: print_loads, solve_all_cold
  use train_settings, only: train_settings_t
  implicit none
  private
  public :: prepare_screen, screen_wing

  real(rp), parameter :: QUANTILE_90 = 1.6448536269514722_rp !< of the normal distribution, two-sided
  real(rp), parameter :: WORTH = log(2.0_rp)/QUANTILE_90     !< largest sd of the logarithm of a parameter that is proposed

contains

  !> Makes Young's modulus E, all veins and all joints the unknowns of the experiment. Every rank calls it.
  subroutine prepare_screen(settings, failure)
    type(train_settings_t), intent(inout) :: settings
    type(failure_t), intent(out) :: failure
    integer :: i
    associate (requested => settings%wing_case%requested)
      call settings%experiment%init(settings%measurement, settings%wing_case%wing, requested, &
                                    [PARAM_YOUNG, (i, i=N_COMMON + 1, requested%count_basic())], settings%choices%solver, &
                                    failure, settings%instrument, [integer ::], settings%masses())
    end associate
  end subroutine prepare_screen

  !> Prints the ranking and a proposal. `are_solved` tells whether every shape was found. Prints nothing if the pool is stopped
  !> meanwhile.
  subroutine screen_wing(settings, pool, are_solved)
    type(train_settings_t), intent(in) :: settings
    type(bending_pool_t), intent(inout) :: pool
    logical, intent(out) :: are_solved
    type(evaluation_t), allocatable :: evaluations(:)
    real(rp), allocatable :: rows(:, :), effect(:), remaining(:), moved(:)
    integer, allocatable :: order(:)
    integer :: n, l, k, first, points
    associate (e => settings%experiment)
      are_solved = .false.
      call solve_all_cold(e, pool, e%start(), evaluations)
      if (pool%is_stopped) return
      call print_loads(output_unit, e, evaluations)
      are_solved = all(evaluations%is_solved)
      if (.not. are_solved) return
      n = e%count_parameters()
      allocate (rows(e%count_residuals(0), e%count()), moved(n), source=0.0_rp)
      first = 0
      points = 0
      do l = 1, size(evaluations)
        do k = 1, e%count_residuals(l)
          rows(first + k, :) = evaluations(l)%jacobian(k, :)/e%comparisons(l)%sigma(k)
        end do
        moved = moved + sum(evaluations(l)%jacobian(:e%comparisons(l)%n_heights, :n)**2, 1)
        points = points + e%comparisons(l)%n_heights
        first = first + e%count_residuals(l)
      end do
      moved = sqrt(moved/max(1, points))
      effect = norm2(rows(:, :n), 1)
      call remove_offsets(rows, n)
      call pivot_columns(rows(:, :n), order, remaining)
      call print_ranking(e, effect, moved, order, remaining)
    end associate
  end subroutine screen_wing

  !> Removes from the first n columns what the other columns, which belong to unknown offsets, can imitate.
  pure subroutine remove_offsets(rows, n)
    real(rp), intent(inout) :: rows(:, :)
    integer, intent(in) :: n
    integer :: i, k
    do i = n + 1, size(rows, 2)
      do k = 1, n
        call project_out(rows(:, i), rows(:, k))
      end do
    end do
  end subroutine remove_offsets

  !> Removes from b its component along a.
  pure subroutine project_out(a, b)
    real(rp), intent(in) :: a(:)
    real(rp), intent(inout) :: b(:)
    real(rp) :: square
    square = dot_product(a, a)
    if (square > 0) b = b - a*(dot_product(a, b)/square)
  end subroutine project_out

  !> Returns order(n), in which each column is the longest of the remaining ones after all earlier columns have been projected out.
  !> remaining(n) holds these lengths in the same order.
  pure subroutine pivot_columns(columns, order, remaining)
    real(rp), intent(in) :: columns(:, :)
    integer, allocatable, intent(out) :: order(:)
    real(rp), allocatable, intent(out) :: remaining(:)
    real(rp) :: left(size(columns, 1), size(columns, 2)), lengths(size(columns, 2)), length
    logical :: is_taken(size(columns, 2))
    integer :: i, k, n
    n = size(columns, 2)
    allocate (order(n), remaining(n))
    left = columns
    lengths = norm2(columns, 1)
    is_taken = .false.
    do i = 1, n
      order(i) = maxloc(norm2(left, 1), 1, mask=.not. is_taken)
      length = norm2(left(:, order(i)))
      ! A column that the others imitate exactly differs from zero by round-off only.
      if (.not. length > 1.0e-10_rp*lengths(order(i))) length = 0
      remaining(i) = length
      is_taken(order(i)) = .true.
      if (.not. length > 0) left(:, order(i)) = 0
      do k = 1, n
        if (.not. is_taken(k)) call project_out(left(:, order(i)), left(:, k))
      end do
    end do
  end subroutine pivot_columns

  !> Prints the parameters in the order of their effect, and proposes those that the loads determine.
  subroutine print_ranking(e, effect, moved, order, remaining)
    type(experiment_t), intent(in) :: e
    real(rp), intent(in) :: effect(:), moved(:), remaining(:)
    integer, intent(in) :: order(:)
    real(rp), parameter :: UM = 1.0e6_rp, TENTH = 0.1_rp
    type(parameter_t) :: p
    character(:), allocatable :: proposal
    logical :: is_proposed
    integer :: i
    proposal = ''
    write (output_unit, '(a)') '', 'effect of 10 %: rms movement of the measured points if the parameter changes by 10 %;', &
      'over noise: signal-to-noise ratio of a change by a factor e, at the declared errors;', &
      'sd: predicted standard deviation of the logarithm if this parameter alone is fitted, and if all parameters above it '// &
      'are fitted too', '', &
      'rank  parameter                 effect of 10 % [um]  over noise    sd alone  sd with those above  proposed'
    is_proposed = .true.
    do i = 1, size(order)
      p = e%describe(order(i))
      is_proposed = is_proposed .and. remaining(i)*WORTH >= 1
      if (is_proposed) proposal = proposal//', '//p%name
      write (output_unit, '(i4,2x,a26,f19.4,es12.2,a,a,a)') i, p%name//repeat(' ', 26), UM*TENTH*moved(order(i)), &
        effect(order(i)), sd_text(effect(order(i)), 12), sd_text(remaining(i), 21), &
        merge('       yes', '        no', is_proposed)
    end do
    if (proposal == '') then
      write (output_unit, '(a)') '', 'these loads determine none of the parameters within a factor of two'
    else
      write (output_unit, '(a)') '', 'proposed:  parameters = '//proposal(3:)
    end if
    write (output_unit, '(a)') 'D is not ranked, because it is a regularisation. The results hold for the values of [Wing] '// &
      'and for the declared errors.'
    flush (output_unit)
  end subroutine print_ranking

  !> Returns 1/length as text of `width` characters.
  function sd_text(length, width) result(text)
    real(rp), intent(in) :: length
    integer, intent(in) :: width
    character(width) :: text
    character(16) :: buffer
    buffer = 'infinite'
    if (length > 1.0e-30_rp) write (buffer, '(es10.2)') 1/length
    text = repeat(' ', max(0, width - len_trim(buffer)))//buffer
  end function sd_text
end module train_screening
