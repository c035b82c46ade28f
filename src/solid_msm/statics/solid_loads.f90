! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the loads on a wing: dead forces at points or inside triangles, gravity, end couples of beams, and springs to the
!> ground.
module solid_loads
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use solid_model, only: solid_model_t
  use solid_vectors, only: cross, outer
  implicit none
  private
  public :: load_t, couple_t, support_t

  !> A moment about a fixed axis that follows the turning of one vein segment.
  type :: couple_t
    integer :: nodes(2) = 0          !< the segment
    real(rp) :: axis(3) = 0          !< unit vector
    real(rp) :: moment = 0           !< [N m]
  end type couple_t

  !> Springs that hold a point at its unloaded position; stiff springs along one axis act as a guide.
  type :: support_t
    integer :: point = 0
    real(rp) :: stiffness(3) = 0     !< [N/m] along x, y, z
  end type support_t

  !> All loads on a wing. The forces keep their direction.
  type :: load_t
    real(rp), allocatable :: force(:, :) !< (3, n_all) [N]
    type(couple_t), allocatable :: couples(:)
    type(support_t), allocatable :: supports(:)
  contains
    procedure :: init => load_init
    procedure :: add_point => load_add_point
    procedure :: add_at => load_add_at
    procedure :: add_gravity => load_add_gravity
    procedure :: work => load_work
    procedure :: subtract_from => load_subtract_from
    procedure :: subtract_tangent => load_subtract_tangent
  end type load_t

contains

  !> Makes an empty load on this model.
  subroutine load_init(self, model)
    class(load_t), intent(out) :: self
    type(solid_model_t), intent(in) :: model
    allocate (self%force(3, model%n_all), source=0.0_rp)
    allocate (self%couples(0), self%supports(0))
  end subroutine load_init

  !> Adds force(3) [N] at a point of the wing, by its number.
  subroutine load_add_point(self, point, force)
    class(load_t), intent(inout) :: self
    integer, intent(in) :: point
    real(rp), intent(in) :: force(3)
    self%force(:, point) = self%force(:, point) + force
  end subroutine load_add_point

  !> Adds force(3) [N] at the position (x, y) [m] of the unloaded wing. The corners of the triangle at this position share the force
  !> by their barycentric weights. Fails outside the membrane.
  subroutine load_add_at(self, model, site, force, failure)
    class(load_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: site(2), force(3)
    type(failure_t), intent(inout) :: failure
    real(rp), parameter :: TOLERANCE = 1.0e-9_rp
    real(rp) :: w(3), area
    integer :: t, c
    do t = 1, size(model%triangles, 2)
      associate (a => model%points(:2, model%triangles(1, t)), b => model%points(:2, model%triangles(2, t)), &
                 d => model%points(:2, model%triangles(3, t)))
        area = twice_area(a, b, d)
        w = [twice_area(site, b, d), twice_area(a, site, d), twice_area(a, b, site)]/area
      end associate
      if (minval(w) < -TOLERANCE) cycle
      do c = 1, 3
        call self%add_point(model%triangles(c, t), w(c)*force)
      end do
      return
    end do
    call failure%raise('the load acts outside the membrane of the wing')
  end subroutine load_add_at

  !> Returns twice the area of a triangle in the plane, negative if its corners go clockwise.
  pure real(rp) function twice_area(a, b, c) result(area)
    real(rp), intent(in) :: a(2), b(2), c(2)
    area = (b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1))
  end function twice_area

  !> Adds the weight of masses(n_points) [kg] under the acceleration g(3) [m/s^2].
  subroutine load_add_gravity(self, masses, g)
    class(load_t), intent(inout) :: self
    real(rp), intent(in) :: masses(:), g(3)
    integer :: i
    do i = 1, size(masses)
      self%force(:, i) = self%force(:, i) + masses(i)*g
    end do
  end subroutine load_add_gravity

  !> Returns minus the potential [J] of the load, times `factor`, at displacements u(3, n_all) [m]. The potential of a couple is
  !> defined up to full turns.
  pure real(rp) function load_work(self, model, u, factor) result(work)
    class(load_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :), factor
    real(rp) :: d(3), d0(3)
    integer :: c
    work = factor*sum(self%force*u)
    do c = 1, size(self%couples)
      associate (couple => self%couples(c))
        d0 = model%points(:, couple%nodes(2)) - model%points(:, couple%nodes(1))
        d = d0 + u(:, couple%nodes(2)) - u(:, couple%nodes(1))
        d0 = d0 - dot_product(d0, couple%axis)*couple%axis
        work = work + factor*couple%moment*atan2(dot_product(couple%axis, cross(d0, d)), dot_product(d0, d))
      end associate
    end do
    do c = 1, size(self%supports)
      associate (support => self%supports(c))
        work = work - 0.5_rp*sum(support%stiffness*u(:, support%point)**2)
      end associate
    end do
  end function load_work

  !> Subtracts the generalised forces at u(3, n_all) [m], times `factor`, from g(3, n_all) [N].
  pure subroutine load_subtract_from(self, model, u, factor, g)
    class(load_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :), factor
    real(rp), intent(inout) :: g(:, :)
    real(rp) :: p(3), q(3)
    integer :: c
    g = g - factor*self%force
    do c = 1, size(self%couples)
      associate (couple => self%couples(c))
        call lever(couple, model, u, p, q)
        g(:, couple%nodes(2)) = g(:, couple%nodes(2)) - factor*couple%moment*q
        g(:, couple%nodes(1)) = g(:, couple%nodes(1)) + factor*couple%moment*q
      end associate
    end do
    do c = 1, size(self%supports)
      associate (support => self%supports(c))
        g(:, support%point) = g(:, support%point) + support%stiffness*u(:, support%point)
      end associate
    end do
  end subroutine load_subtract_from

  !> Subtracts the derivative of the generalised forces, times `factor`, from blocks(3, 3, :) [N/m] of the tangent.
  pure subroutine load_subtract_tangent(self, model, u, factor, blocks)
    class(load_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :), factor
    real(rp), intent(inout) :: blocks(:, :, :)
    real(rp) :: p(3), q(3), h(3, 3)
    integer :: c, b, i, j, k
    do c = 1, size(self%couples)
      associate (couple => self%couples(c))
        call lever(couple, model, u, p, q) ! the angle's Hessian in the plane is -(p q^T + q p^T)
        h = -factor*couple%moment*(outer(p, q) + outer(q, p))
        i = model%free(couple%nodes(1))
        j = model%free(couple%nodes(2))
        b = model%pattern%block_index(i, i)
        if (b > 0) blocks(:, :, b) = blocks(:, :, b) - h
        b = model%pattern%block_index(j, j)
        if (b > 0) blocks(:, :, b) = blocks(:, :, b) - h
        b = abs(model%pattern%block_index(i, j))
        if (b > 0) blocks(:, :, b) = blocks(:, :, b) + h
      end associate
    end do
    do c = 1, size(self%supports)
      i = model%free(self%supports(c)%point)
      if (i == 0) cycle
      b = model%pattern%block_index(i, i)
      do k = 1, 3
        blocks(k, k, b) = blocks(k, k, b) + self%supports(c)%stiffness(k)
      end do
    end do
  end subroutine load_subtract_tangent

  !> Computes, for the segment d projected onto the plane of the couple, p = d/|d|^2 and q = axis x d/|d|^2, the gradient of its
  !> angle.
  pure subroutine lever(couple, model, u, p, q)
    type(couple_t), intent(in) :: couple
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(out) :: p(3), q(3)
    p = model%points(:, couple%nodes(2)) - model%points(:, couple%nodes(1)) &
        + u(:, couple%nodes(2)) - u(:, couple%nodes(1))
    p = p - dot_product(p, couple%axis)*couple%axis
    p = p/dot_product(p, p)
    q = cross(couple%axis, p)
  end subroutine lever
end module solid_loads
