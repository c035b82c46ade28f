! SPDX-License-Identifier: GPL-3.0-or-later
!> Data on a line that are linear in everything: an offset, and a bump at one of several places, closer to each other than the bump
!> is wide. Errors are independent with variance 1.
module bump_places
  use base_kinds, only: rp
  use inference_design, only: design_t
  use inference_simulator, only: simulator_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: bump_at, bumps_t, make_bumps

  integer, parameter, public :: N_PLACES = 9 !< parameters 2 to N_PLACES + 1; the last parameter is a slope

  type, extends(simulator_t) :: bumps_t
    real(rp), allocatable :: data(:)
  contains
    procedure :: evaluate => bumps_evaluate
    procedure :: covariance => bumps_covariance
    procedure :: directions => bumps_directions
  end type bumps_t

contains

  !> Makes n points on [0, 1] without data, and a design that has candidates only: the places, and the slope.
  subroutine make_bumps(n, bumps, design)
    integer, intent(in) :: n
    type(bumps_t), intent(out) :: bumps
    type(design_t), intent(out) :: design
    integer :: i
    bumps%n_observations = n
    bumps%n_baseline = 1
    allocate (bumps%data(n), source=0.0_rp)
    allocate (bumps%labels%surface(n), bumps%labels%block(n), bumps%labels%fold(1), source=1)
    allocate (bumps%parameters(N_PLACES + 2), design%candidates(N_PLACES + 1))
    do i = 1, size(bumps%parameters)
      bumps%parameters(i)%name = merge('bump ', 'other', i > 1 .and. i <= N_PLACES + 1)
      bumps%parameters(i)%prior_sd = 1
    end do
    bumps%parameters(1)%prior_sd = 0.5_rp
    do i = 1, N_PLACES + 1
      design%candidates(i)%effect = merge(1, 2, i <= N_PLACES)
      design%candidates(i)%columns = [i + 1]
    end do
    design%prior = [0.0_rp]
    design%weight = [2.0_rp]
  end subroutine make_bumps

  !> Returns the bump of place i on n points; in place of one beside the last the slope.
  pure function bump_at(i, n) result(bump)
    integer, intent(in) :: i, n
    real(rp) :: bump(n)
    integer :: k
    bump = [(real(k - 1, rp)/(n - 1), k=1, n)]
    if (i <= N_PLACES) bump = (1 + 0.4_rp*i)*exp(-50*(bump - 0.45_rp - 0.015_rp*(i - 5))**2)
  end function bump_at

  !> See `simulator_t`.
  subroutine bumps_evaluate(self, q, columns, from, residuals, jacobian, is_valid, to, is_wanted)
    class(bumps_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out), optional :: to
    logical, intent(in), optional :: is_wanted(:)
    integer :: i
    is_valid = .true.
    if (present(to)) allocate (to, source=from)
    residuals = q(1) - self%data
    do i = 2, size(q)
      residuals = residuals + q(i)*bump_at(i - 1, size(residuals))
    end do
    do i = 1, size(columns)
      jacobian(:, i) = 1
      if (columns(i) > 1) jacobian(:, i) = bump_at(columns(i) - 1, size(residuals))
    end do
    associate (unused => is_wanted)
    end associate
  end subroutine bumps_evaluate

  !> See `simulator_t`.
  subroutine bumps_covariance(self, rows, independent_fraction, c)
    class(bumps_t), intent(in) :: self
    integer, intent(in) :: rows(:)
    real(rp), intent(in) :: independent_fraction
    real(rp), intent(out) :: c(:, :)
    integer :: i
    c = 0
    do i = 1, size(rows)
      c(i, i) = 1
    end do
    associate (unused => self, nothing => independent_fraction)
    end associate
  end subroutine bumps_covariance

  !> See `simulator_t`.
  subroutine bumps_directions(self, q, from, nuisances, patterns, is_valid)
    class(bumps_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: nuisances(:, :), patterns(:, :)
    logical, intent(out) :: is_valid
    nuisances = 0
    patterns = 0
    is_valid = .true.
    associate (unused => self, nothing => q, neither => from)
    end associate
  end subroutine bumps_directions
end module bump_places
