! SPDX-License-Identifier: GPL-3.0-or-later
!> A plane sheet of points with a patch that is higher by a factor: a simulator whose observations jump where a point enters or
!> leaves the patch. Baseline: height, and slopes along x and y. The patch is exp(s) - 1 high within a radius of its centre, with a
!> rim of a tenth of the radius. The sheet is the square from 0 to 1.
module patchy_surface
  use base_kinds, only: rp
  use inference_simulator, only: simulator_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: patchy_t, make_patchy

  integer, parameter, public :: SIDE = 15, N_BASE = 3, P_PATCH = 4 !< points along a side; number of the patch's strength

  type, extends(simulator_t) :: patchy_t
    real(rp), allocatable :: observed(:)
    integer :: n_evaluations = 0
  contains
    procedure :: evaluate => patchy_evaluate
    procedure :: covariance => patchy_covariance
    procedure :: directions => patchy_directions
    procedure :: has_place => patchy_has_place
    procedure :: heights => patchy_heights
  end type patchy_t

contains

  !> Makes the sheet; coordinates of the patch are x, y and the logarithm of its radius, with these first steps of a search.
  subroutine make_patchy(sheet, step, radius_step)
    type(patchy_t), intent(out) :: sheet
    real(rp), intent(in) :: step, radius_step
    integer :: i, j
    sheet%n_observations = SIDE**2
    sheet%n_baseline = N_BASE
    sheet%labels%block = [(1, i=1, SIDE**2)]
    sheet%labels%surface = sheet%labels%block
    sheet%labels%fold = [1]
    sheet%labels%site = reshape([(([i - 0.5_rp, j - 0.5_rp]/SIDE, i=1, SIDE), j=1, SIDE)], [2, SIDE**2])
    allocate (sheet%parameters(P_PATCH + 3), sheet%effects(1))
    sheet%parameters(:N_BASE)%lower = -1.0e3_rp
    sheet%parameters(:N_BASE)%upper = 1.0e3_rp
    sheet%parameters(P_PATCH)%is_log = .true.
    sheet%parameters(P_PATCH)%lower = -5
    sheet%parameters(P_PATCH)%upper = 5
    sheet%parameters(P_PATCH)%prior_sd = 1
    sheet%parameters(P_PATCH + 1:)%lower = [0.0_rp, 0.0_rp, log(0.05_rp)]
    sheet%parameters(P_PATCH + 1:)%upper = [1.0_rp, 1.0_rp, log(0.5_rp)]
    sheet%parameters(P_PATCH + 1:)%prior_sd = [step, step, radius_step]
    associate (effect => sheet%effects(1))
      allocate (effect%variants(1))
      effect%variants(1)%columns = [P_PATCH]
      effect%variants(1)%is_finer = .true.
      effect%anywhere = 1
      effect%place_columns = P_PATCH + [1, 2, 3]
    end associate
  end subroutine make_patchy

  !> Returns the heights(n) at q, and their derivative with respect to the strength of the patch.
  pure subroutine patchy_heights(self, q, heights, by_strength)
    class(patchy_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: heights(:), by_strength(:)
    real(rp) :: s
    integer :: i
    do i = 1, size(heights)
      associate (site => self%labels%site(:, i))
        s = (1.05_rp - norm2(site - q(P_PATCH + 1:P_PATCH + 2))/exp(q(P_PATCH + 3)))/0.1_rp
        s = max(0.0_rp, min(1.0_rp, s))
        heights(i) = q(1) + q(2)*site(1) + q(3)*site(2) + (exp(q(P_PATCH)) - 1)*s
        by_strength(i) = exp(q(P_PATCH))*s
      end associate
    end do
  end subroutine patchy_heights

  subroutine patchy_evaluate(self, q, columns, from, residuals, jacobian, is_valid, to, is_wanted)
    class(patchy_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out), optional :: to
    logical, intent(in), optional :: is_wanted(:)
    real(rp) :: by_strength(size(residuals))
    integer :: k
    self%n_evaluations = self%n_evaluations + 1
    call self%heights(q, residuals, by_strength)
    residuals = residuals - self%observed
    do k = 1, size(columns)
      select case (columns(k))
      case (1)
        jacobian(:, k) = 1
      case (2, 3)
        jacobian(:, k) = self%labels%site(columns(k) - 1, :)
      case default
        jacobian(:, k) = by_strength
      end select
    end do
    is_valid = .true.
    if (present(to)) allocate (to, source=from)
    if (present(is_wanted)) is_valid = all(is_wanted)
  end subroutine patchy_evaluate

  subroutine patchy_covariance(self, rows, independent_fraction, c)
    class(patchy_t), intent(in) :: self
    integer, intent(in) :: rows(:)
    real(rp), intent(in) :: independent_fraction
    real(rp), intent(out) :: c(:, :)
    integer :: i
    c = 0
    do i = 1, size(rows)
      c(i, i) = 0.01_rp**2 ! sd of the heights
    end do
    associate (unused => self, all_independent => independent_fraction)
    end associate
  end subroutine patchy_covariance

  subroutine patchy_directions(self, q, from, nuisances, patterns, is_valid)
    class(patchy_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: nuisances(:, :), patterns(:, :)
    logical, intent(out) :: is_valid
    nuisances = 0
    patterns = 0
    is_valid = size(q) == size(self%parameters)
    associate (unused => from)
    end associate
  end subroutine patchy_directions

  !> The corner behind the diagonal x + y = 1.6 was cut off.
  logical function patchy_has_place(self, e, place) result(has_it)
    class(patchy_t), intent(in) :: self
    integer, intent(in) :: e
    real(rp), intent(in) :: place(:)
    has_it = size(place) == size(self%effects(e)%place_columns) .and. sum(place(:2)) < 1.6_rp
  end function patchy_has_place
end module patchy_surface
