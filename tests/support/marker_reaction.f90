! SPDX-License-Identifier: GPL-3.0-or-later
!> A linear response at markers of a wing, for tests and benchmarks: impulses J at the markers give them the velocities
!> M J, and the wing feels the forces that keep them at the velocities s + M J of what surrounds it,
!> f = -W^T M^-1 (W (v + velocity of the frame) - s)/dt. With s the markers' velocities when the step begins it is
!> an added mass W^T M^-1 W.
module marker_reaction
  use base_errors, only: require
  use base_kinds, only: rp
  use solid_model, only: solid_model_t
  use solid_motion, only: frame_t, inertial_velocity
  use solid_reaction, only: reaction_t
  use solid_vectors, only: IDENTITY, outer
  implicit none
  private
  public :: marker_reaction_t, place_markers, exponential_kernel, layer_kernel

  !> Marker k lies at the sum of weights(:, k) times the points nodes(:, k).
  type, extends(reaction_t) :: marker_reaction_t
    integer, allocatable :: nodes(:, :)    !< (3, m)
    real(rp), allocatable :: weights(:, :) !< (3, m)
    real(rp), allocatable :: points(:, :)  !< (3, n_all) [m] of the unloaded wing
    real(rp), allocatable :: answer(:, :)  !< (3 m, 3 m) [kg/s] M^-1/dt
    real(rp), allocatable :: around(:)     !< (3 m) [m/s] s
    real(rp), allocatable :: blocks(:, :, :) !< (3, 3, n_all) [kg/s]
    integer :: calls = 0                   !< products with M^-1
    integer :: ended = 0                   !< parts of steps that have ended
    real(rp), private, allocatable :: velocity(:), impulse(:)
    real(rp), private, allocatable :: begun(:), flow(:) !< (3 m) [m/s] velocities of markers when the step begins; flow of the part
    integer, private :: parts = 1
  contains
    procedure :: begin_part => marker_begin_part
    procedure :: end_part => marker_end_part
    procedure :: init => marker_init
    procedure :: begin_step => marker_begin_step
    procedure :: force => marker_force
    procedure :: tangent => marker_tangent
    procedure :: block_diagonal => marker_block_diagonal
  end type marker_reaction_t

  interface
    subroutine dpotrf(uplo, n, a, lda, info)
      import :: rp
      character, intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(rp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotrf
    subroutine dpotri(uplo, n, a, lda, info)
      import :: rp
      character, intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(rp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotri
    subroutine dsymv(uplo, n, alpha, a, lda, x, incx, beta, y, incy)
      import :: rp
      character, intent(in) :: uplo
      integer, intent(in) :: n, lda, incx, incy
      real(rp), intent(in) :: alpha, beta, a(lda, *), x(*)
      real(rp), intent(inout) :: y(*)
    end subroutine dsymv
  end interface

contains

  !> Markers at the given places that answer with m(3 m, 3 m) [1/kg], symmetric positive definite, over dt [s].
  subroutine marker_init(self, model, nodes, weights, m, dt)
    class(marker_reaction_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: nodes(:, :)
    real(rp), intent(in) :: weights(:, :), m(:, :), dt
    real(rp) :: x(3, model%n_all), y(3, model%n_all)
    integer :: n, info, j, p
    n = size(m, 1)
    self%parts = 1
    self%nodes = nodes
    self%weights = weights
    self%points = model%points
    self%answer = m
    call dpotrf('L', n, self%answer, n, info)
    call require(info == 0, 'marker_reaction: the response must be positive definite')
    call dpotri('L', n, self%answer, n, info)
    call require(info == 0, 'marker_reaction: the response has no inverse')
    do j = 1, n
      self%answer(j, j + 1:) = self%answer(j + 1:, j)
    end do
    self%answer = self%answer/dt
    self%around = spread(0.0_rp, 1, n)
    self%begun = self%around
    self%flow = self%around
    self%velocity = self%around
    self%impulse = self%around
    if (allocated(self%blocks)) deallocate (self%blocks)
    allocate (self%blocks(3, 3, model%n_all), source=0.0_rp)
    do j = 1, 3
      x = 0
      x(j, :) = 1
      y = 0
      call self%tangent(x, y)
      self%blocks(:, j, :) = y
    end do
    do p = 1, model%n_all
      associate (b => self%blocks(:, :, p))
        b = 0.5_rp*(b + transpose(b))
        if (.not. is_positive(b)) b = maxval([b(1, 1), b(2, 2), b(3, 3), 0.0_rp])*IDENTITY
      end associate
    end do
    self%calls = 0
    self%ended = 0
  end subroutine marker_init

  !> Whether a symmetric matrix is positive definite.
  pure logical function is_positive(b)
    real(rp), intent(in) :: b(3, 3)
    real(rp) :: minor
    minor = b(1, 1)*b(2, 2) - b(1, 2)**2
    is_positive = b(1, 1) > 0 .and. minor > 0 .and. &
                  b(3, 3)*minor - b(1, 1)*b(2, 3)**2 - b(2, 2)*b(1, 3)**2 + 2*b(1, 2)*b(2, 3)*b(1, 3) > 0
  end function is_positive

  !> What surrounds the wing has the velocities that its markers have at u, v.
  subroutine marker_begin_step(self, frame, u, v)
    class(marker_reaction_t), intent(inout) :: self
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :)
    self%around = velocities(self, frame, u, v)
    self%flow = self%around
    self%parts = 1
  end subroutine marker_begin_step

  !> Velocities of the markers in space.
  pure function velocities(self, frame, u, v) result(w)
    type(marker_reaction_t), intent(in) :: self
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :)
    real(rp) :: w(3*size(self%nodes, 2))
    integer :: k, i
    w = 0
    do k = 1, size(self%nodes, 2)
      do i = 1, 3
        associate (p => self%nodes(i, k), s => w(3*k - 2:3*k))
          s = s + self%weights(i, k)*inertial_velocity(frame, self%points(:, p) + u(:, p), v(:, p))
        end associate
      end do
    end do
  end function velocities

  !> What surrounds the wing goes evenly from the markers' velocities when the step begins to `around`, and has the impulses of the
  !> parts before.
  subroutine marker_begin_part(self, frame, u, v, parts, done, ratio)
    class(marker_reaction_t), intent(inout) :: self
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :), ratio
    integer, intent(in) :: parts, done
    call require(ratio >= 0, 'marker_reaction: a part has a length')
    self%parts = parts
    self%flow = self%around
    if (parts == 1) return
    self%flow = velocities(self, frame, u, v)
    if (done == 0) self%begun = self%flow
    self%flow = self%flow + (self%around - self%begun)/parts
  end subroutine marker_begin_part

  !> Counts the part.
  subroutine marker_end_part(self)
    class(marker_reaction_t), intent(inout) :: self
    self%ended = self%ended + 1
  end subroutine marker_end_part

  !> The forces [N].
  subroutine marker_force(self, frame, u, v, f)
    class(marker_reaction_t), intent(inout) :: self
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :)
    real(rp), intent(inout) :: f(:, :)
    self%velocity = self%flow - velocities(self, frame, u, v)
    f = 0
    call spread_answer(self, f)
  end subroutine marker_force

  !> y = y + W^T M^-1 W x/dt.
  subroutine marker_tangent(self, x, y)
    class(marker_reaction_t), intent(inout) :: self
    real(rp), intent(in) :: x(:, :)
    real(rp), intent(inout) :: y(:, :)
    integer :: k
    do k = 1, size(self%nodes, 2)
      self%velocity(3*k - 2:3*k) = self%weights(1, k)*x(:, self%nodes(1, k)) &
                                   + self%weights(2, k)*x(:, self%nodes(2, k)) &
                                   + self%weights(3, k)*x(:, self%nodes(3, k))
    end do
    call spread_answer(self, y)
  end subroutine marker_tangent

  !> y = y + W^T M^-1 velocity/dt.
  subroutine spread_answer(self, y)
    type(marker_reaction_t), intent(inout) :: self
    real(rp), intent(inout) :: y(:, :)
    integer :: k, i
    call dsymv('L', size(self%velocity), 1.0_rp, self%answer, size(self%velocity), self%velocity, 1, 0.0_rp, &
               self%impulse, 1)
    self%impulse = self%parts*self%impulse
    do k = 1, size(self%nodes, 2)
      do i = 1, 3
        y(:, self%nodes(i, k)) = y(:, self%nodes(i, k)) + self%weights(i, k)*self%impulse(3*k - 2:3*k)
      end do
    end do
    self%calls = self%calls + 1
  end subroutine spread_answer

  !> What all points feel when all have the same velocity: exact for the smoothest motion.
  subroutine marker_block_diagonal(self, d)
    class(marker_reaction_t), intent(inout) :: self
    real(rp), intent(inout) :: d(:, :, :)
    d = self%parts*self%blocks
  end subroutine marker_block_diagonal

  !> n places far from each other in the triangles of a wing: each next one in the triangle whose centroid is farthest
  !> from those that are chosen.
  subroutine place_markers(model, n, nodes, weights, sites)
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: n
    integer, allocatable, intent(out) :: nodes(:, :)
    real(rp), allocatable, intent(out) :: weights(:, :), sites(:, :)
    real(rp), parameter :: WITHIN(3) = [0.5_rp, 0.3_rp, 0.2_rp]
    real(rp) :: centroids(3, size(model%triangles, 2)), distance(size(model%triangles, 2))
    integer :: k, t, chosen
    do t = 1, size(centroids, 2)
      centroids(:, t) = sum(model%points(:, model%triangles(:, t)), 2)/3
    end do
    allocate (nodes(3, n), weights(3, n), sites(3, n))
    distance = huge(distance)
    chosen = 1
    do k = 1, n
      nodes(:, k) = model%triangles(:, chosen)
      weights(:, k) = WITHIN
      sites(:, k) = matmul(model%points(:, nodes(:, k)), WITHIN)
      do t = 1, size(centroids, 2)
        distance(t) = min(distance(t), norm2(centroids(:, t) - centroids(:, chosen)))
      end do
      chosen = maxloc(distance, 1)
    end do
  end subroutine place_markers

  !> exp(-r/length) plus `own` on the diagonal, for every component, times the factor with which all markers moving
  !> together make the added mass `mass` [kg].
  function exponential_kernel(sites, length, own, mass) result(m)
    real(rp), intent(in) :: sites(:, :), length, own, mass
    real(rp) :: m(3*size(sites, 2), 3*size(sites, 2))
    real(rp), allocatable :: inverse(:, :)
    integer :: i, j, n, info
    m = 0
    n = size(sites, 2)
    allocate (inverse(n, n))
    do j = 1, n
      do i = 1, n
        inverse(i, j) = exp(-norm2(sites(:, i) - sites(:, j))/length)
      end do
      inverse(j, j) = inverse(j, j) + own
    end do
    do j = 1, n
      do i = 1, n
        m(3*i - 2:3*i, 3*j - 2:3*j) = inverse(i, j)*IDENTITY
      end do
    end do
    call dpotrf('L', n, inverse, n, info)
    call require(info == 0, 'marker_reaction: the kernel must be positive definite')
    call dpotri('L', n, inverse, n, info)
    do j = 1, n
      inverse(j, j + 1:) = inverse(j + 1:, j)
    end do
    m = m*(sum(inverse)/mass)
  end function exponential_kernel

  !> The velocities that impulses give to a fluid of density rho [kg/m^3] in which they and the velocities are
  !> smoothed by a Gaussian of width sigma [m] (both together): the projection of the Gaussian on fields without divergence,
  !> (phi I + grad grad chi)/rho with chi = erf(r/(sqrt 2 sigma))/(4 pi r). On a smooth sheet it resists normal
  !> motion of wave number k as rho/k, motion along itself as a layer of thickness sigma.
  function layer_kernel(sites, sigma, rho) result(m)
    real(rp), intent(in) :: sites(:, :), sigma, rho
    real(rp) :: m(3*size(sites, 2), 3*size(sites, 2))
    real(rp), parameter :: PI = acos(-1.0_rp)
    real(rp) :: d(3), r, a, phi, slope
    integer :: i, j
    a = 1/(sqrt(2.0_rp)*sigma)
    do j = 1, size(sites, 2)
      do i = 1, size(sites, 2)
        d = sites(:, i) - sites(:, j)
        r = norm2(d)
        phi = (a/sqrt(PI))**3*exp(-(a*r)**2)
        if (i == j) then
          m(3*i - 2:3*i, 3*j - 2:3*j) = 2*phi/(3*rho)*IDENTITY
          cycle
        end if
        slope = (2*a*r/sqrt(PI)*exp(-(a*r)**2) - erf(a*r))/(4*PI*r**3) ! chi'/r; chi'' = -phi - 2 chi'/r
        m(3*i - 2:3*i, 3*j - 2:3*j) = ((phi + slope)*IDENTITY - (phi + 3*slope)*outer(d/r, d/r))/rho
      end do
    end do
  end function layer_kernel
end module marker_reaction
