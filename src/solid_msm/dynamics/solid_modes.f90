! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the lowest natural frequencies and shapes of a wing about an equilibrium.
!>
!> Subspace iteration with M^(1/2) K^-1 M^(1/2), which also finds the equal frequencies of symmetric structures; LAPACK solves the
!> dense part. K is factorised once.
module solid_modes
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use solid_equilibrium, only: equilibrium_t
  use base_lapack, only: symmetric_eigen
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  implicit none
  private
  public :: natural_modes

contains

  !> Computes frequencies [Hz], lowest first, and shapes(3, n_all, :), normalised to unit modal mass [kg^-1/2], of small undamped
  !> vibrations about the equilibrium u(3, n_all) under `load`, for masses(n_all) [kg]. Fails if the equilibrium is unstable or
  !> the iteration does not converge.
  subroutine natural_modes(work, model, load, masses, u, frequencies, shapes, failure)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: masses(:), u(:, :)
    real(rp), intent(out) :: frequencies(:), shapes(:, :, :)
    type(failure_t), intent(out) :: failure
    real(rp), parameter :: TOLERANCE = 1.0e-11_rp
    integer, parameter :: LIMIT = 400
    real(rp), allocatable :: q(:, :), z(:, :), t(:, :), root_mass(:), values(:), old_values(:)
    integer :: n, p, k, i, iteration
    logical :: is_spd

    k = size(frequencies)
    n = 3*model%n_free
    p = min(n, count(masses(model%movable) > 0)*3, max(2*k, k + 10))
    if (k > p) then
      call failure%raise('the wing has fewer natural modes than requested: ask for fewer, or use a finer wing')
      return
    end if
    work%stage = 1 ! the whole load
    call work%law_axial(model, u)
    call work%factorise(model, load, u, .false., 0.0_rp, is_spd)
    if (.not. is_spd) then
      call failure%raise('the wing is unstable in this shape, and has no natural modes there: make it stiffer (E, D or '// &
                         'joints of [Wing])')
      return
    end if
    allocate (q(n, p), z(n, p), t(p, p), values(p), old_values(p))
    root_mass = [(sqrt(masses(model%movable((i + 2)/3))), i=1, n)]
    do i = 1, p
      q(:, i) = root_mass*sin([(1.0_rp + 0.37_rp*i*iteration + 0.011_rp*real(iteration, rp)**2, &
                                iteration=1, n)])
    end do
    call orthonormalise(q)
    values = 0
    do iteration = 1, LIMIT
      z = q*spread(root_mass, 2, p)
      call work%cholesky%solve(p, z)
      z = z*spread(root_mass, 2, p)
      t = matmul(transpose(q), z)
      old_values = values
      call symmetric_eigen(t, values) ! the largest, which are 1/omega^2, come last
      q = matmul(z, t)
      call orthonormalise(q)
      if (maxval(abs(values(p - k + 1:) - old_values(p - k + 1:))/values(p - k + 1:)) < TOLERANCE) exit
    end do
    if (iteration > LIMIT) then
      call failure%raise('the natural modes did not converge: check that [Wing] and [Mass] are in SI units')
      return
    end if
    z = q*spread(root_mass, 2, p)
    call work%cholesky%solve(p, z)
    shapes = 0
    do i = 1, k
      frequencies(i) = 1/(TWO_PI*sqrt(values(p + 1 - i)))
      shapes(:, model%movable, i) = reshape(z(:, p + 1 - i)/values(p + 1 - i), [3, model%n_free])
    end do
  end subroutine natural_modes

  !> Orthogonalises by modified Gram-Schmidt, twice, beginning with the last column: the order of the eigenvalues.
  subroutine orthonormalise(q)
    real(rp), intent(inout) :: q(:, :)
    integer :: i, j, pass
    do i = size(q, 2), 1, -1
      q(:, i) = q(:, i)/norm2(q(:, i))
      do pass = 1, 2
        do j = size(q, 2), i + 1, -1
          q(:, i) = q(:, i) - dot_product(q(:, j), q(:, i))*q(:, j)
        end do
        q(:, i) = q(:, i)/norm2(q(:, i))
      end do
    end do
  end subroutine orthonormalise
end module solid_modes
