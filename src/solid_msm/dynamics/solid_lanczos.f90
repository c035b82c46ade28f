! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the largest eigenvalues of a symmetric positive definite operator and their eigenvectors, by block Lanczos iteration with
!> full orthogonalisation. The iteration ends when the residuals are small, and not only the changes of the eigenvalues. Blocks are
!> needed for multiple eigenvalues.
module solid_lanczos
  use base_kinds, only: rp
  use base_lapack, only: multiply, multiply_transposed, orthogonalise, symmetric_eigen
  implicit none
  private
  public :: symmetric_operator_t, find_largest

  !> The operator A, given by its products with vectors.
  type, abstract :: symmetric_operator_t
  contains
    procedure(apply_interface), deferred :: apply
  end type symmetric_operator_t

  abstract interface
    !> Returns A x, column by column, for x(n, :).
    function apply_interface(self, x) result(z)
      import :: rp, symmetric_operator_t
      class(symmetric_operator_t), intent(in) :: self
      real(rp), intent(in) :: x(:, :)
      real(rp) :: z(size(x, 1), size(x, 2))
    end function apply_interface
  end interface

contains

  !> Returns x(n, n_vectors), n = size(start), the eigenvector of the largest eigenvalue first, and the largest ratio of a residual
  !> to its eigenvalue, which is above `tolerance` after a failure. `start`(n) scales the components of the first block. In small
  !> problems one block spans the whole space.
  subroutine find_largest(operator, start, n_vectors, tolerance, x, residual)
    class(symmetric_operator_t), intent(in) :: operator
    real(rp), intent(in) :: start(:), tolerance
    integer, intent(in) :: n_vectors
    real(rp), allocatable, intent(out) :: x(:, :)
    real(rp), intent(out) :: residual
    integer, parameter :: BLOCK_SIZE = 4, SMALL = 100, BETWEEN = 5
    real(rp), allocatable :: q(:, :), t(:, :), s(:, :), v(:, :), w(:, :), c(:, :), r(:, :), values(:)
    integer :: n, b, m, most, i, k
    n = size(start)
    b = merge(n, BLOCK_SIZE, n <= SMALL)
    most = min(n, 20*n_vectors + SMALL)
    allocate (q(n, most), v(n, b), w(n, b), t(most, most), source=0.0_rp)
    do i = 1, b ! shapes without symmetry, the same in every run
      v(:, i) = start*sin([(1.0_rp + 0.37_rp*i*k + 0.011_rp*real(k, rp)**2, k=1, n)])
    end do
    call make_orthonormal(v)
    m = 0
    residual = huge(1.0_rp)
    do while (m + b <= most)
      q(:, m + 1:m + b) = v
      w = operator%apply(v)
      m = m + b
      c = project(w)
      t(:m, m - b + 1:m) = c
      t(m - b + 1:m, :m) = transpose(c)
      c = project(w)
      if (m == n .or. (mod(m/b, BETWEEN) == 0 .and. m > n_vectors)) then
        call orthogonalise(w, v, r)
        s = 0.5_rp*(t(:m, :m) + transpose(t(:m, :m)))
        if (allocated(values)) deallocate (values)
        allocate (values(m))
        call symmetric_eigen(s, values) ! the largest come last
        s = s(:, m:m - n_vectors + 1:-1)
        values = values(m:m - n_vectors + 1:-1)
        residual = maxval(norm2(matmul(r, s(m - b + 1:, :)), 1)/values)
        if (allocated(x)) deallocate (x)
        allocate (x(n, n_vectors), source=0.0_rp)
        call multiply(1.0_rp, q(:, :m), s, x)
        if (m == n .or. residual < tolerance) exit
      end if
      v = w
      call make_orthonormal(v)
      c = project(v)
      call make_orthonormal(v)
    end do
    if (m == n) residual = 0

  contains

    !> Removes from a(n, b) its components in the space of the first m vectors, and returns these components.
    function project(a) result(components)
      real(rp), intent(inout), contiguous :: a(:, :)
      real(rp) :: components(m, size(a, 2))
      call multiply_transposed(q(:, :m), a, components)
      call multiply(-1.0_rp, q(:, :m), components, a)
    end function project

  end subroutine find_largest

  !> Orthonormalises the columns in their order.
  subroutine make_orthonormal(q)
    real(rp), intent(inout) :: q(:, :)
    real(rp), allocatable :: basis(:, :), r(:, :)
    call orthogonalise(q, basis, r)
    q = basis
  end subroutine make_orthonormal
end module solid_lanczos
