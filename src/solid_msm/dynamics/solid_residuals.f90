! SPDX-License-Identifier: GPL-3.0-or-later
!> Solves with the Jacobian of a wing with a reaction, A = S + N + C (q + omega x), by the factors of another matrix, such as S +
!> q D: GMRES in the form that keeps its directions z with their images A z = Q R (adaptive simpler GMRES, Jiranek & Rozloznik
!> 2010, doi:10.1007/s11075-009-9311-1). It minimises the residual.
!>
!> As long as A is the same, the solution for the next right-hand side first uses the directions of the earlier ones (de Sturler
!> 1996, doi:10.1016/0377-0427(94)00123-5): later iterations of Newton's method with one tangent need fewer steps.
module solid_residuals
  use base_kinds, only: rp
  use solid_equilibrium, only: equilibrium_t
  use solid_model, only: solid_model_t
  use solid_reaction, only: reaction_t
  use solid_vectors, only: cross
  implicit none
  private
  public :: residuals_t

  integer, parameter :: MOST = 60 !< directions

  !> Work space; nothing is allocated after `init`.
  type :: residuals_t
    real(rp), allocatable :: answer(:, :) !< (3, n_free) [N] the part of A x that the reaction has, for the last solution x
    integer, private :: n = 0   !< directions that are known
    real(rp), private :: turning(3) = 0 !< angular velocity of the frame over q
    real(rp), private, allocatable :: upper(:, :) !< (MOST, MOST) R
    real(rp), private, allocatable :: directions(:, :, :), images(:, :, :) !< (3, n_free, MOST) z and Q
    real(rp), private, allocatable :: answers(:, :, :) !< (3, n_free, MOST) the part C (q + omega x) z of A z
    real(rp), private, allocatable :: left(:, :), image(:, :), all_x(:, :), all_y(:, :)
  contains
    procedure :: init => residuals_init
    procedure :: free => residuals_free
    procedure :: forget => residuals_forget
    procedure :: solve => residuals_solve
  end type residuals_t

contains

  !> Allocates the work space for this model.
  subroutine residuals_init(self, model)
    class(residuals_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    call self%free()
    allocate (self%directions(3, model%n_free, MOST), self%images(3, model%n_free, MOST), &
              self%answers(3, model%n_free, MOST), self%answer(3, model%n_free), source=0.0_rp)
    allocate (self%upper(MOST, MOST), self%left(3, model%n_free), self%image(3, model%n_free), &
              self%all_x(3, model%n_all), self%all_y(3, model%n_all), source=0.0_rp)
    self%n = 0
  end subroutine residuals_init

  !> Releases the arrays.
  subroutine residuals_free(self)
    class(residuals_t), intent(inout) :: self
    if (allocated(self%directions)) &
      deallocate (self%upper, self%directions, self%images, self%answers, self%answer, self%left, self%image, self%all_x, &
                  self%all_y)
  end subroutine residuals_free

  !> Discards the directions of earlier solutions. Call it when the matrix A has changed. `turning` is the new angular velocity of
  !> the frame over q, if it has changed.
  subroutine residuals_forget(self, turning)
    class(residuals_t), intent(inout) :: self
    real(rp), intent(in), optional :: turning(3)
    self%n = 0
    if (present(turning)) self%turning = turning
  end subroutine residuals_forget

  !> Finds x(3, n_free) [m] with A x = b, where A y = S y + t x y + C (q y + omega x y), q in 1/s: the velocity of y is that in
  !> space, and omega the one of the frame, given to `forget`. The equilibrium has the symmetric matrix S as
  !> `blocks`, b [N] as `right_hand_side`, and the factors of a matrix near A. turns(3, n_free) are the vectors t of the points. The
  !> reaction has C. On return |A x - b| = left |b|. `left` is above `enough` if `most_iterations` do not suffice, or 20 if earlier
  !> solutions left no room for more.
  subroutine residuals_solve(self, model, equilibrium, turns, reaction, q, enough, most_iterations, x, left, n_iterations)
    class(residuals_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(equilibrium_t), intent(inout) :: equilibrium
    real(rp), intent(in) :: turns(:, :), q, enough
    integer, intent(in) :: most_iterations !< at most 60
    class(reaction_t), intent(inout) :: reaction
    real(rp), intent(inout) :: x(:, :)
    real(rp), intent(out) :: left
    integer, intent(out) :: n_iterations
    real(rp), parameter :: LESS = 0.9_rp, DEPENDENT = 1.0e-12_rp
    integer, parameter :: FEW = 20
    real(rp) :: coefficient(MOST), size_b, size_image, last
    integer :: i, k
    x = 0
    self%answer = 0
    left = 0
    n_iterations = 0
    size_b = sqrt(inner(equilibrium%right_hand_side, equilibrium%right_hand_side))
    if (.not. size_b > 0) return
    if (self%n + min(most_iterations, FEW) > MOST) self%n = 0
    associate (z => self%directions, orthogonal => self%images, r => self%left, upper => self%upper)
      r = equilibrium%right_hand_side
      do k = 1, self%n
        call take(orthogonal(:, :, k), r, coefficient(k))
      end do
      left = sqrt(inner(r, r))/size_b
      last = huge(last)
      do k = self%n + 1, min(self%n + most_iterations, MOST)
        if (left <= enough) exit
        if (left < LESS*last) then
          z(:, :, k) = r
        else
          z(:, :, k) = orthogonal(:, :, k - 1)
        end if
        last = left
        call equilibrium%cholesky%solve(1, z(:, :, k))
        call multiply(self, model, equilibrium%blocks, turns, reaction, q, k)
        n_iterations = n_iterations + 1
        size_image = sqrt(inner(self%image, self%image))
        do i = 1, k - 1
          call take(orthogonal(:, :, i), self%image, upper(i, k))
        end do
        upper(k, k) = sqrt(inner(self%image, self%image))
        if (.not. upper(k, k) > DEPENDENT*size_image) exit ! also true for NaN
        orthogonal(:, :, k) = self%image/upper(k, k)
        self%n = k
        call take(orthogonal(:, :, k), r, coefficient(k))
        left = sqrt(inner(r, r))/size_b
      end do
      do k = self%n, 1, -1
        coefficient(k) = (coefficient(k) - dot_product(upper(k, k + 1:self%n), coefficient(k + 1:self%n)))/upper(k, k)
        x = x + coefficient(k)*z(:, :, k)
        self%answer = self%answer + coefficient(k)*self%answers(:, :, k)
      end do
    end associate
  end subroutine residuals_solve

  !> Computes `image` = A z for direction number k, and its part `answers` that the reaction has.
  subroutine multiply(self, model, blocks, turns, reaction, q, k)
    type(residuals_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: blocks(:, :, :), turns(:, :), q
    class(reaction_t), intent(inout) :: reaction
    integer, intent(in) :: k
    integer :: i
    associate (z => self%directions(:, :, k), y => self%image, answer => self%answers(:, :, k))
      do i = 1, model%n_free
        self%all_x(:, model%movable(i)) = z(:, i) + cross(self%turning, z(:, i))
      end do
      self%all_y = 0
      call reaction%tangent(self%all_x, self%all_y)
      do i = 1, model%n_free
        answer(:, i) = q*self%all_y(:, model%movable(i))
        y(:, i) = answer(:, i) + cross(turns(:, i), z(:, i))
      end do
      call model%pattern%multiply(blocks, 1.0_rp, z, y)
    end associate
  end subroutine multiply

  !> Removes from `r` its part along the unit vector `e`.
  pure subroutine take(e, r, coefficient)
    real(rp), intent(in), contiguous :: e(:, :)
    real(rp), intent(inout), contiguous :: r(:, :)
    real(rp), intent(out) :: coefficient
    coefficient = inner(e, r)
    r = r - coefficient*e
  end subroutine take

  !> Returns the inner product, computed as twelve simultaneous sums, which is faster than one sum.
  pure real(rp) function inner(a, b)
    real(rp), intent(in), contiguous :: a(:, :), b(:, :)
    real(rp) :: sums(3, 4)
    integer :: i, n
    n = size(a, 2) - mod(size(a, 2), 4)
    sums = 0
    do i = 1, n, 4
      sums = sums + a(:, i:i + 3)*b(:, i:i + 3)
    end do
    inner = sum(sums) + sum(a(:, n + 1:)*b(:, n + 1:))
  end function inner
end module solid_residuals
