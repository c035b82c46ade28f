! SPDX-License-Identifier: GPL-3.0-or-later
!> Compares the measured records of motion with those of the baseline and of the extended wing, for reports.
module diagnosis_series_report
  use base_kinds, only: rp
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_wing_simulator, only: wing_simulator_t
  use inference_engine, only: diagnosis_t
  implicit none
  private
  public :: describe_series

contains

  !> Makes s%series, one row for each record. On rank 0.
  subroutine describe_series(s, simulator, d)
    class(diagnosis_case_t), intent(inout) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(in) :: d
    real(rp), allocatable :: residuals(:), nuisances(:, :)
    real(rp) :: errors(2)
    logical :: ok
    integer :: side, i, first, last
    if (s%measurement%count_series() == 0) return
    associate (motion => simulator%motion%series)
      allocate (s%series(s%measurement%count_series()), residuals(motion%n), nuisances(motion%n, 2*s%measurement%count_series()))
      do side = 1, 2
        if (side == 1 .or. .not. d%extended%is_found) then
          call motion%evaluate(d%initial_baseline%q, residuals, ok)
        else
          call motion%evaluate(d%extended%q, residuals, ok)
        end if
        if (.not. ok) cycle
        call motion%simulation%nuisances(nuisances)
        do i = 1, size(s%series)
          associate (row => s%series(i), record => s%measurement%series(i))
            first = motion%simulation%first(i)
            last = first + record%count() - 1
            errors = most_probable(nuisances(first:last, 2*i - 1:2*i), residuals(first:last))
            row%size_error(side) = errors(1)*record%size_sigma/record%size
            row%late(side) = errors(2)*record%trigger_sigma
            if (.not. allocated(row%seen)) &
              allocate (row%seen(size(record%values, 1), size(record%values, 2), 2), source=0.0_rp)
            row%seen(:, :, side) = motion%simulation%computed(i, errors)
            row%rms(side) = norm2(record%in_sd(row%seen(:, :, side) - record%values))/sqrt(real(record%count(), rp))
          end associate
        end do
      end do
    end associate
  end subroutine describe_series

  !> Finds two errors x with the variance 1 that minimise |r + A x|^2 + |x|^2.
  pure function most_probable(a, r) result(x)
    real(rp), intent(in) :: a(:, :), r(:)
    real(rp) :: x(2), normal(2, 2), right(2)
    normal = matmul(transpose(a), a)
    normal(1, 1) = normal(1, 1) + 1
    normal(2, 2) = normal(2, 2) + 1
    right = -matmul(r, a)
    x = [normal(2, 2)*right(1) - normal(1, 2)*right(2), normal(1, 1)*right(2) - normal(2, 1)*right(1)]/ &
        (normal(1, 1)*normal(2, 2) - normal(1, 2)*normal(2, 1))
  end function most_probable
end module diagnosis_series_report
