! SPDX-License-Identifier: GPL-3.0-or-later
!> Scans of a line for tests of the noise of a diagnosis: errors that neighbours share and errors of their own, a constant
!> that the baseline knows, and a wave that only unknown causes can make.
module noise_scans
  use base_kinds, only: i8, rp
  use base_parameter, only: parameter_t
  use base_random, only: fill_gaussians
  use inference_simulator, only: simulator_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: scans_t, make_scans

  integer, parameter :: N_POINTS = 30, N_SCANS = 20
  real(rp), parameter :: LENGTH = 3

  type, extends(simulator_t) :: scans_t
    real(rp), allocatable :: data(:)
    real(rp) :: independent = 1 !< fraction of the variance, as it is believed before any fit
  contains
    procedure :: evaluate => scans_evaluate
    procedure :: covariance => scans_covariance
    procedure :: directions => scans_directions
    procedure :: has_common_errors => scans_has_common_errors
    procedure :: independent_fraction => scans_independent_fraction
  end type scans_t

contains

  !> Draws scans whose own errors have variance 1 and whose common ones are the part `fraction` of the whole.
  subroutine make_scans(scans, fraction, wave, seed)
    type(scans_t), intent(out) :: scans
    real(rp), intent(in) :: fraction, wave
    integer(i8), intent(in) :: seed
    real(rp) :: own(N_POINTS*N_SCANS), drawn(N_POINTS*N_SCANS), factor(N_POINTS, N_POINTS)
    integer :: i, j, n
    n = N_POINTS*N_SCANS
    scans%n_observations = n
    scans%n_baseline = 1
    scans%n_patterns = 1
    scans%labels%surface = [((j, i=1, N_POINTS), j=1, N_SCANS)]
    scans%labels%block = scans%labels%surface
    scans%parameters = [parameter_t('level', '1', prior_sd=10.0_rp)]
    call fill_gaussians(seed, 1_i8, 0_i8, own)
    call fill_gaussians(seed, 2_i8, 0_i8, drawn)
    factor = cholesky(correlation())
    scans%data = own + 3
    do j = 1, N_SCANS
      associate (rows => scans%data((j - 1)*N_POINTS + 1:j*N_POINTS))
        rows = rows + sqrt(fraction/(1 - fraction))*matmul(factor, drawn((j - 1)*N_POINTS + 1:j*N_POINTS)) + wave*wave_of()
      end associate
    end do
  end subroutine make_scans

  pure function wave_of() result(w)
    real(rp) :: w(N_POINTS)
    integer :: i
    w = [(sin(0.4_rp*i), i=1, N_POINTS)]
  end function wave_of

  pure function correlation() result(r)
    real(rp) :: r(N_POINTS, N_POINTS)
    integer :: i, j
    do j = 1, N_POINTS
      do i = 1, N_POINTS
        r(i, j) = exp(-0.5_rp*((i - j)/LENGTH)**2)
      end do
      r(j, j) = 1 + 1.0e-6_rp
    end do
  end function correlation

  pure function cholesky(a) result(l)
    real(rp), intent(in) :: a(:, :)
    real(rp) :: l(size(a, 1), size(a, 1))
    integer :: i, j
    l = 0
    do j = 1, size(a, 1)
      l(j, j) = sqrt(a(j, j) - sum(l(j, :j - 1)**2))
      do i = j + 1, size(a, 1)
        l(i, j) = (a(i, j) - sum(l(i, :j - 1)*l(j, :j - 1)))/l(j, j)
      end do
    end do
  end function cholesky

  subroutine scans_evaluate(self, q, columns, from, residuals, jacobian, is_valid, to, is_wanted)
    class(scans_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out), optional :: to
    logical, intent(in), optional :: is_wanted(:)
    residuals = q(1) - self%data
    jacobian = 1
    is_valid = size(columns) == size(jacobian, 2)
    if (present(is_wanted)) is_valid = is_valid .and. size(is_wanted) == N_SCANS
    if (present(to)) allocate (to, source=from)
  end subroutine scans_evaluate

  subroutine scans_covariance(self, rows, independent_fraction, c)
    class(scans_t), intent(in) :: self
    integer, intent(in) :: rows(:)
    real(rp), intent(in) :: independent_fraction
    real(rp), intent(out) :: c(:, :)
    real(rp) :: r(N_POINTS, N_POINTS)
    integer :: i
    associate (unused => self)
    end associate
    r = correlation()*(1 - independent_fraction)/independent_fraction
    c = r(mod(rows - 1, N_POINTS) + 1, mod(rows - 1, N_POINTS) + 1)
    do i = 1, size(rows)
      c(i, i) = c(i, i) + 1
    end do
  end subroutine scans_covariance

  subroutine scans_directions(self, q, from, nuisances, patterns, is_valid)
    class(scans_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from !< which scans do not need
    real(rp), intent(out) :: nuisances(:, :), patterns(:, :)
    logical, intent(out) :: is_valid
    integer :: j
    nuisances = 0
    associate (unused => from)
    end associate
    do j = 1, N_SCANS
      patterns((j - 1)*N_POINTS + 1:j*N_POINTS, 1) = wave_of()
    end do
    is_valid = size(q) == self%n_baseline
  end subroutine scans_directions

  pure logical function scans_has_common_errors(self) result(has_some)
    class(scans_t), intent(in) :: self
    has_some = self%n_observations > 0
  end function scans_has_common_errors

  pure real(rp) function scans_independent_fraction(self) result(fraction)
    class(scans_t), intent(in) :: self
    fraction = self%independent
  end function scans_independent_fraction
end module noise_scans
