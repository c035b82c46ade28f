! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes observations comparable by a linear map after which errors are independent with variance 1.
!>
!> C = N + V V^T, N the covariance of the noise, dense within blocks, V the directions of nuisances scaled by their sd.
!> With N = L L^T, A = L^-1 V and A^T A = X diag(g) X^T the map is (I - A X f(g) X^T A^T) L^-1, f(g) = (1 - (1 + g)^-1/2)/g,
!> whose square is C^-1 (the identity of Woodbury in its symmetric form). The map may be restricted to some of the
!> observations; their C is then that of the restriction, not a restriction of the map.
module inference_whitener
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_lapack, only: factorise, gram_upper, multiply, multiply_transposed, solve_lower, symmetric_eigen
  use inference_simulator, only: simulator_t
  implicit none
  private
  public :: whitener_t

  type :: block_t
    integer, allocatable :: rows(:)       !< observations, numbers among those of the whitener
    real(rp), allocatable :: factor(:, :) !< L
  end type block_t

  type :: whitener_t
    integer :: n = 0
    integer, allocatable :: rows(:)       !< (n) observations of the simulator
    real(rp) :: independent_fraction = 1  !< of the errors in N, see `covariance` of simulator_t
    real(rp) :: log_determinant = 0       !< of C
    type(block_t), allocatable, private :: blocks(:)
    real(rp), allocatable, private :: u(:, :), shrink(:) !< A X and f(g)
    real(rp), private :: noise_log_determinant = 0
  contains
    procedure :: init => whitener_init
    procedure :: add_directions => whitener_add_directions
    procedure :: apply => whitener_apply
    procedure :: apply_one => whitener_apply_one
  end type whitener_t

contains

  !> Makes the whitener of the observations `rows` of the simulator, without nuisances. Of the variance of a single error
  !> independent_fraction is independent. Fails if a covariance is not positive definite.
  subroutine whitener_init(self, simulator, rows, independent_fraction, failure)
    class(whitener_t), intent(out) :: self
    class(simulator_t), intent(in) :: simulator
    integer, intent(in) :: rows(:)
    real(rp), intent(in) :: independent_fraction
    type(failure_t), intent(out) :: failure
    integer :: b, i, k, first, last
    logical :: is_definite
    self%n = size(rows)
    self%rows = rows
    self%independent_fraction = independent_fraction
    allocate (self%u(self%n, 0), self%shrink(0))
    associate (block => simulator%labels%block)
      first = minval(block)
      last = maxval(block)
      allocate (self%blocks(last - first + 1))
      do b = first, last
        associate (one => self%blocks(b - first + 1))
          one%rows = pack([(i, i=1, self%n)], block(rows) == b)
          allocate (one%factor(size(one%rows), size(one%rows)))
          if (size(one%rows) == 0) cycle
          call simulator%covariance(rows(one%rows), independent_fraction, one%factor)
          call factorise(one%factor, is_definite)
          if (.not. is_definite) then
            call failure%raise('the covariance of the errors is not positive definite: '// &
                               'check the declared errors of the measurement')
            return
          end if
          do k = 1, size(one%rows)
            self%noise_log_determinant = self%noise_log_determinant + 2*log(one%factor(k, k))
          end do
        end associate
      end do
    end associate
    self%log_determinant = self%noise_log_determinant
  end subroutine whitener_init

  !> Takes v(n, :) as the directions of all nuisances, instead of those before.
  subroutine whitener_add_directions(self, v)
    class(whitener_t), intent(inout) :: self
    real(rp), intent(in) :: v(:, :)
    real(rp), allocatable :: white(:, :), gram(:, :), values(:)
    integer :: i
    if (allocated(self%u)) deallocate (self%u, self%shrink)
    allocate (self%u(self%n, 0), self%shrink(0))
    white = v
    call self%apply(white)
    allocate (gram(size(v, 2), size(v, 2)), values(size(v, 2)))
    call gram_upper(white, gram)
    if (size(gram) > 0) call symmetric_eigen(gram, values)
    values = max(values, 0.0_rp)
    deallocate (self%u)
    allocate (self%u(self%n, size(v, 2)), source=0.0_rp)
    call multiply(1.0_rp, white, gram, self%u)
    ! The form for small g does not divide rounding by rounding.
    self%shrink = [(1/(sqrt(1 + values(i))*(1 + sqrt(1 + values(i)))), i=1, size(values))]
    self%log_determinant = self%noise_log_determinant + sum(log(1 + values))
  end subroutine whitener_add_directions

  !> Whitens every column of a(n, :).
  subroutine whitener_apply(self, a)
    class(whitener_t), intent(in) :: self
    real(rp), intent(inout) :: a(:, :)
    real(rp), allocatable :: part(:, :)
    integer :: b, i
    do b = 1, size(self%blocks)
      associate (one => self%blocks(b))
        part = a(one%rows, :)
        call solve_lower(one%factor, part)
        a(one%rows, :) = part
      end associate
    end do
    if (size(self%shrink) == 0) return
    if (allocated(part)) deallocate (part)
    allocate (part(size(self%u, 2), size(a, 2)))
    call multiply_transposed(self%u, a, part)
    do i = 1, size(a, 2)
      part(:, i) = self%shrink*part(:, i)
    end do
    call multiply(-1.0_rp, self%u, part, a)
  end subroutine whitener_apply

  !> Whitens one vector a(n).
  subroutine whitener_apply_one(self, a)
    class(whitener_t), intent(in) :: self
    real(rp), intent(inout) :: a(:)
    real(rp) :: column(size(a), 1)
    column(:, 1) = a
    call self%apply(column)
    a = column(:, 1)
  end subroutine whitener_apply_one
end module inference_whitener
