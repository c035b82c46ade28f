! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes what a fit tells about its unknowns in the linear approximation at the optimum.
module least_squares_posterior
  use base_kinds, only: rp
  use base_lapack, only: singular_vectors, triangle_of
  use least_squares_fit, only: fit_report_t
  use least_squares_problem, only: unknowns_t
  implicit none
  private
  public :: posterior_t, find_posterior

  !> Posterior of n unknowns; residuals count in units of their standard deviations.
  type :: posterior_t
    real(rp), allocatable :: covariance(:, :)      !< (n, n) with priors; huge where nothing is known
    real(rp), allocatable :: sd(:)                 !< (n) square roots of its diagonal
    real(rp), allocatable :: singular_values(:)    !< (n) of the derivatives, without priors, largest first
    real(rp), allocatable :: combinations(:, :)    !< (n, n) in column i, the combination of unknowns of singular value i
  end type posterior_t

contains

  !> Returns the posterior distribution in the linear approximation at the optimum of a fit. Fixed unknowns count as free.
  function find_posterior(unknowns, report) result(posterior)
    type(unknowns_t), intent(in) :: unknowns
    type(fit_report_t), intent(in) :: report
    type(posterior_t) :: posterior
    real(rp), parameter :: NOTHING = 1.0e-150_rp ! singular values below this are taken as this
    real(rp), allocatable :: triangle(:, :), rows(:, :), values(:), vectors(:, :)
    integer :: i, k, n
    n = size(report%p)
    allocate (posterior%singular_values(n), posterior%combinations(n, n), values(n), vectors(n, n), rows(2*n, n))
    triangle = triangle_of(report%jacobian)
    call singular_vectors(triangle, posterior%singular_values, posterior%combinations)
    rows = 0
    rows(:n, :) = triangle
    do i = 1, n
      if (unknowns%prior_sd(i) > 0) rows(n + i, i) = 1/unknowns%prior_sd(i)
    end do
    call singular_vectors(triangle_of(rows), values, vectors)
    allocate (posterior%covariance(n, n), source=0.0_rp)
    do k = 1, n
      do i = 1, n
        posterior%covariance(:, i) = posterior%covariance(:, i) &
                                     + vectors(:, k)*(vectors(i, k)/max(values(k), NOTHING)**2)
      end do
    end do
    posterior%sd = [(sqrt(posterior%covariance(i, i)), i=1, n)]
  end function find_posterior
end module least_squares_posterior
