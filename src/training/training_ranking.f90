! SPDX-License-Identifier: GPL-3.0-or-later
!> Ranks the parameters of an experiment by what its measurements can determine of them.
!>
!> The ranking takes one parameter after another (QR with column pivoting). The next parameter is always the one whose effect the
!> parameters ranked so far imitate least. Parameters are proposed as long as the predicted 90 % interval of each, in a fit together
!> with all earlier proposals, is within a factor of two.
module training_ranking
  use base_kinds, only: rp
  use measurement_evaluation, only: evaluation_t
  use measurement_experiment, only: experiment_t
  implicit none
  private
  public :: ranking_t, rank_parameters

  real(rp), parameter :: QUANTILE_90 = 1.6448536269514722_rp !< of the normal distribution, two-sided
  real(rp), parameter :: WORTH = log(2.0_rp)/QUANTILE_90     !< largest sd of the logarithm of a parameter that is proposed

  !> Holds the parameters in the order of their rank. `effect` and `remaining` are lengths of the derivatives of all measured values
  !> by the logarithm of a parameter, in units of their errors: 1/effect is the sd of the parameter if it is fitted alone, and
  !> 1/remaining that if all parameters above it are fitted too.
  type :: ranking_t
    integer, allocatable :: order(:)      !< numbers of the parameters
    real(rp), allocatable :: effect(:), remaining(:)
    real(rp), allocatable :: moved(:)     !< rms movement of the measured points for the logarithm of a parameter [m]
    integer :: n_proposed = 0             !< the first ones are proposed
  end type ranking_t

contains

  !> Returns the ranking from the derivatives of the values of all loads.
  function rank_parameters(e, evaluations) result(ranking)
    type(experiment_t), intent(in) :: e
    type(evaluation_t), intent(in) :: evaluations(:)
    type(ranking_t) :: ranking
    real(rp), allocatable :: rows(:, :), moved(:), effect(:)
    integer :: n, l, k, first, points
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
    call pivot_columns(rows(:, :n), ranking%order, ranking%remaining)
    ranking%effect = effect(ranking%order)
    ranking%moved = moved(ranking%order)
    do while (ranking%n_proposed < n)
      if (ranking%remaining(ranking%n_proposed + 1)*WORTH < 1) exit
      ranking%n_proposed = ranking%n_proposed + 1
    end do
  end function rank_parameters

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
end module training_ranking
