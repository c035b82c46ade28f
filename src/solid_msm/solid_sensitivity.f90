! SPDX-License-Identifier: GPL-3.0-or-later
!> Derivatives of an equilibrium shape with respect to the parameters, by one back-substitution each.
!>
!> The equilibrium g(u, p) = F gives du/dp = -K^-1 dg/dp; K is factorised already when the statics end.
module solid_sensitivity
  use base_kinds, only: rp
  use solid_equilibrium, only: equilibrium_t
  use solid_model, only: solid_model_t
  use solid_params, only: parameter_t
  use solid_stiffness, only: stiffness_t
  implicit none
  private
  public :: shape_sensitivities, singular_values

  interface
    subroutine dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
      import :: rp
      character, intent(in) :: jobu, jobvt
      integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
      real(rp), intent(inout) :: a(lda, *)
      real(rp), intent(out) :: s(*), u(ldu, *), vt(ldvt, *), work(*)
      integer, intent(out) :: info
    end subroutine dgesvd
  end interface

contains

  !> derivatives(3, n_all, size(numbers)) [m per unit] of the equilibrium u with respect to the
  !> parameters with these numbers, per log unit where the parameter's scale is logarithmic. Right
  !> after a converged `solve_static` of the same model, whose factorisation it uses.
  subroutine shape_sensitivities(work, model, u, numbers, derivatives)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :)
    integer, intent(in) :: numbers(:)
    real(rp), intent(out) :: derivatives(:, :, :)
    type(parameter_t) :: parameter
    type(stiffness_t) :: dk
    integer :: p
    do p = 1, size(numbers)
      parameter = model%params%describe(numbers(p))
      call model%stiffness_derivative(numbers(p), parameter%is_log, dk)
      call model%gradient(u, work%g, dk)
      call work%newton_step(model, work%g)
      derivatives(:, :, p) = work%du
    end do
  end subroutine shape_sensitivities

  !> Singular values, largest first, of a matrix(m, n) with m >= n, such as the stacked derivatives of
  !> all observations; their ratios tell which combinations of parameters the data can see.
  function singular_values(matrix) result(values)
    real(rp), intent(in) :: matrix(:, :)
    real(rp), allocatable :: values(:)
    real(rp), allocatable :: a(:, :), work(:)
    real(rp) :: left(1, 1), right(1, 1)
    integer :: info
    allocate (a(size(matrix, 1), size(matrix, 2)))
    a(:, :) = matrix
    allocate (values(min(size(a, 1), size(a, 2))), work(8*(size(a, 1) + size(a, 2)) + 64))
    values = 0
    call dgesvd('N', 'N', size(a, 1), size(a, 2), a, size(a, 1), values, &
                left, 1, right, 1, work, size(work), info)
  end function singular_values
end module solid_sensitivity
