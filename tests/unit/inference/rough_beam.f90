! SPDX-License-Identifier: GPL-3.0-or-later
!> A beam whose tangents and patterns have small errors, as those of a simulator that solves linear equations have.
module rough_beam
  use base_kinds, only: i8, rp
  use base_random, only: fill_gaussians
  use diagnosis_beam, only: beam_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: rough_beam_t

  type, extends(beam_t) :: rough_beam_t
    real(rp) :: roughness = 0 !< length of errors, as a fraction of a tangent's length
    integer :: seed = 1       !< of the errors
  contains
    procedure :: evaluate => rough_evaluate
    procedure :: directions => rough_directions
  end type rough_beam_t

contains

  !> See `beam_t`.
  subroutine rough_evaluate(self, q, columns, from, residuals, jacobian, is_valid, to, is_wanted)
    class(rough_beam_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out), optional :: to
    logical, intent(in), optional :: is_wanted(:)
    call self%beam_t%evaluate(q, columns, from, residuals, jacobian, is_valid, to, is_wanted)
    call add_errors(self, 1_i8, jacobian)
  end subroutine rough_evaluate

  !> See `beam_t`.
  subroutine rough_directions(self, q, from, nuisances, patterns, is_valid)
    class(rough_beam_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: nuisances(:, :), patterns(:, :)
    logical, intent(out) :: is_valid
    call self%beam_t%directions(q, from, nuisances, patterns, is_valid)
    call add_errors(self, 2_i8, patterns)
  end subroutine rough_directions

  !> Adds errors to all columns.
  subroutine add_errors(self, stream, columns)
    class(rough_beam_t), intent(in) :: self
    integer(i8), intent(in) :: stream
    real(rp), intent(inout) :: columns(:, :)
    real(rp) :: error(size(columns, 1))
    integer :: j
    do j = 1, size(columns, 2)
      call fill_gaussians(int(self%seed, i8), stream, int(j, i8)*size(error), error)
      columns(:, j) = columns(:, j) + self%roughness*norm2(columns(:, j))/norm2(error)*error
    end do
  end subroutine add_errors
end module rough_beam
