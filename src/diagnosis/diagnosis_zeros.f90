! SPDX-License-Identifier: GPL-3.0-or-later
!> Compares the zero readings of instruments, which are unknowns of every fit: all offsets of readings at one position along one
!> axis should be equal.
!>
!> With the covariance C of the offsets, all other unknowns free, the differences d to the first one have the
!> covariance A C A^T, and d (A C A^T)^-1 d is a chi^2 if the zeros are equal.
module diagnosis_zeros
  use base_kinds, only: rp
  use base_lapack, only: orthogonalise, solve_lower
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_wing_parameters, only: find_parameter, KIND_ZERO
  use diagnosis_wing_simulator, only: wing_simulator_t
  use inference_distributions, only: log_chi2_tail
  use inference_engine, only: diagnosis_t
  use inference_refit, only: nested_fit_t
  use measurement_data, only: measurement_t
  implicit none
  private
  public :: zeros_t, compare_zeros

  !> Offsets of one sensor; there may be none.
  type :: zeros_t
    character(:), allocatable :: names(:)
    real(rp), allocatable :: value(:), sd(:)             !< [m]
    real(rp), allocatable :: difference(:), error(:)     !< [m] to the first, and its sd; 0 for the first
    real(rp) :: chi2 = 0, log_p = 0                      !< of their equality
  end type zeros_t

contains

  !> Compares the offsets of the first sensor that has more than one, in the extended wing if there is one and in the baseline
  !> otherwise. Rank 0 calls it; the others serve.
  subroutine compare_zeros(s, simulator, d, zeros)
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(zeros_t), intent(out) :: zeros
    type(nested_fit_t) :: found
    real(rp), allocatable :: r(:, :), inverse(:, :), c(:, :)
    integer, allocatable :: same(:), columns(:)
    integer :: i, k, n
    logical :: is_valid
    allocate (zeros%value(0))
    same = offsets_of_a_sensor(s%measurement)
    if (size(same) < 2) return
    found = d%model%baseline
    if (d%extended%is_found) found = d%extended
    call find_triangle(simulator, d, found, r, is_valid)
    if (.not. is_valid .and. d%extended%is_found) then ! a cause at a bound may have no effect
      found = d%model%baseline
      call find_triangle(simulator, d, found, r, is_valid)
    end if
    if (.not. is_valid) return ! what the data do not determine has no sd
    n = size(found%active)
    allocate (columns(0))
    allocate (inverse(n, n), source=0.0_rp)
    do i = 1, n
      inverse(i, i) = 1
    end do
    call solve_lower(transpose(r), inverse)
    c = d%tests%scale*matmul(transpose(inverse), inverse)
    do i = 1, size(same)
      do k = 1, n
        if (found%active(k) == find_parameter(simulator%wing_parameters, 0, KIND_ZERO, same(i))) &
          columns = [columns, k]
      end do
    end do
    zeros%names = s%measurement%zeros(same)
    zeros%value = found%q(found%active(columns))
    zeros%sd = [(sqrt(c(columns(i), columns(i))), i=1, size(columns))]
    zeros%difference = zeros%value - zeros%value(1)
    zeros%error = [(sqrt(max(0.0_rp, c(columns(i), columns(i)) + c(columns(1), columns(1)) - &
                             2*c(columns(i), columns(1)))), i=1, size(columns))]
    call test_equality(c(columns, columns), zeros)
  end subroutine compare_zeros

  !> Computes r, the triangle of the QR factorisation of all tangents at a fit, with rows for the priors. `is_valid` tells whether
  !> these rows determine all fitted parameters.
  subroutine find_triangle(simulator, d, found, r, is_valid)
    type(wing_simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(nested_fit_t), intent(in) :: found
    real(rp), allocatable, intent(out) :: r(:, :)
    logical, intent(out) :: is_valid
    real(rp) :: residuals(simulator%n_observations), jacobian(simulator%n_observations, size(found%active))
    real(rp) :: rows(simulator%n_observations + size(found%active), size(found%active))
    real(rp), allocatable :: basis(:, :)
    integer :: i, m, n
    m = size(jacobian, 1)
    n = size(jacobian, 2)
    call simulator%evaluate(found%q, found%active, found%state, residuals, jacobian, is_valid)
    if (.not. is_valid) return
    call d%model%whitener%apply(jacobian)
    rows = 0
    rows(:m, :) = jacobian
    do i = 1, n
      associate (sd => simulator%parameters(found%active(i))%prior_sd)
        if (sd > 0) rows(m + i, i) = 1/sd
      end associate
    end do
    call orthogonalise(rows, basis, r)
    is_valid = size(r, 1) == n
    if (is_valid) is_valid = all([(abs(r(i, i)) > 1.0e-12_rp*norm2(r(:, i)), i=1, n)])
  end subroutine find_triangle

  !> Returns chi^2 of the differences with covariance c(:, :) of the values.
  subroutine test_equality(c, zeros)
    real(rp), intent(in) :: c(:, :)
    type(zeros_t), intent(inout) :: zeros
    real(rp) :: left(size(c, 1), 1), ones(size(c, 1), 1)
    real(rp), allocatable :: basis(:, :), r(:, :)
    real(rp) :: root(size(c, 1), size(c, 1)), weight
    integer :: i, j
    ! c = L L^T; the weighted mean is the only unknown of equal zeros.
    root = 0
    do j = 1, size(c, 1)
      root(j, j) = sqrt(c(j, j) - sum(root(j, :j - 1)**2))
      do i = j + 1, size(c, 1)
        root(i, j) = (c(i, j) - sum(root(i, :j - 1)*root(j, :j - 1)))/root(j, j)
      end do
    end do
    left(:, 1) = zeros%value
    ones = 1
    call solve_lower(root, left)
    call solve_lower(root, ones)
    call orthogonalise(ones, basis, r)
    weight = sum(basis(:, 1)*left(:, 1))
    zeros%chi2 = sum(left**2) - weight**2
    zeros%log_p = log_chi2_tail(max(0.0_rp, zeros%chi2), size(c, 1) - 1)
  end subroutine test_equality

  !> Returns the numbers of the unknown offsets of readings at one position along one axis, for the first such group of two or more.
  pure function offsets_of_a_sensor(m) result(same)
    type(measurement_t), intent(in) :: m
    integer, allocatable :: same(:)
    integer :: i, k
    do i = 1, size(m%observations)
      if (allocated(same)) deallocate (same)
      allocate (same(0))
      if (m%observations(i)%zero == 0) cycle
      do k = 1, size(m%observations)
        associate (a => m%observations(i), b => m%observations(k))
          if (b%zero == 0 .or. any(same == b%zero) .or. a%quantity /= b%quantity) cycle
          if (norm2(a%point - b%point) <= 1.0e-9_rp*norm2(a%point) .and. norm2(a%axis - b%axis) <= 1.0e-9_rp) &
            same = [same, b%zero]
        end associate
      end do
      if (size(same) > 1) return
    end do
    if (.not. allocated(same)) allocate (same(0))
    same = same(:0)
  end function offsets_of_a_sensor
end module diagnosis_zeros
