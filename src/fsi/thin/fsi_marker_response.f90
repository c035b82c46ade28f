! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the velocities that forces at the markers of a wing cause there, and the forces that cause given velocities.
!>
!> Forces F on the fluid for a time dt change the velocities at the markers by dt M F, where the blocks of M are the
!> Green tensor of the differences of places (fsi_green). M is symmetric and positive definite as long as markers are
!> about two grid spacings apart; 1e-8 of its mean diagonal is added to it. It depends on relative places only, so
!> that it is made in the frame of the wing: once for a rigid one. If the markers have since turned together, by R, its
!> inverse is R M^-1 R^T. Of a section, the axis that the plane flow does not
!> know is y there, and x for the tensor.
module fsi_marker_response
  use base_kinds, only: rp
  use base_lapack, only: factorise, solve_factorised
  use fsi_green, only: green_t
  implicit none
  private
  public :: marker_response_t

  type :: marker_response_t
    real(rp), allocatable, private :: factor(:, :) !< (3n, 3n) Cholesky's factor of M, in its lower triangle
    real(rp), allocatable, private :: work(:)      !< (3n)
    integer, private :: axes(3) = [1, 2, 3]        !< of the wing frame, in the order of the tensor's
    real(rp), private :: rotation(3, 3) = 0        !< R, if the markers have turned
    logical, private :: has_turned = .false.
  contains
    procedure :: init => response_init
    procedure :: build => response_build
    procedure :: turn => response_turn
    procedure :: solve => response_solve
    procedure :: memory_bytes => response_memory_bytes
  end type marker_response_t

contains

  !> Makes room for n markers. With `is_2d` they are given in the frame of a wing that a plane flow sees as a section, whose y
  !> axis is that across the plane.
  subroutine response_init(self, n, is_2d)
    class(marker_response_t), intent(inout) :: self
    integer, intent(in) :: n
    logical, intent(in) :: is_2d
    if (is_2d) self%axes = [2, 1, 3]
    if (allocated(self%factor)) deallocate (self%factor, self%work)
    allocate (self%factor(3*n, 3*n), self%work(3*n), source=0.0_rp)
  end subroutine response_init

  !> Makes and factorises M for markers at x(3, n) [L], in any frame that is at rest for the moment. It has no factor if
  !> markers are too close to each other: then `solve` must not be called.
  subroutine response_build(self, green, x, has_factor)
    class(marker_response_t), intent(inout) :: self
    type(green_t), intent(in) :: green
    real(rp), intent(in) :: x(:, :)
    logical, intent(out) :: has_factor
    real(rp), parameter :: REGULARISATION = 1.0e-8_rp
    real(rp) :: own(3, 3)
    integer :: i, j, k
    self%has_turned = .false.
    own = green%at([0.0_rp, 0.0_rp, 0.0_rp])
    do k = 1, 3
      own(k, k) = own(k, k)*(1 + REGULARISATION)
    end do
    do j = 1, size(x, 2)
      do i = j + 1, size(x, 2)
        self%factor(3*i - 2:3*i, 3*j - 2:3*j) = green%at(x(self%axes, i) - x(self%axes, j))
      end do
      self%factor(3*j - 2:3*j, 3*j - 2:3*j) = own
    end do
    call factorise(self%factor, has_factor)
  end subroutine response_build

  !> Says that all markers have turned by `rotation` about any point since M was made.
  pure subroutine response_turn(self, rotation)
    class(marker_response_t), intent(inout) :: self
    real(rp), intent(in) :: rotation(3, 3)
    self%rotation = rotation
    self%has_turned = .true.
  end subroutine response_turn

  !> Returns the forces f(3, n) with M f = v for velocities v(3, n), along the axes of the frame in which M was made.
  subroutine response_solve(self, v, f)
    class(marker_response_t), intent(inout) :: self
    real(rp), intent(in) :: v(:, :)
    real(rp), intent(inout) :: f(:, :)
    real(rp) :: w(3)
    integer :: i
    do i = 1, size(v, 2)
      w = v(:, i)
      if (self%has_turned) w = matmul(w, self%rotation)
      self%work(3*i - 2:3*i) = w(self%axes)
    end do
    call solve_factorised(self%factor, self%work)
    do i = 1, size(v, 2)
      w(self%axes) = self%work(3*i - 2:3*i)
      if (self%has_turned) w = matmul(self%rotation, w)
      f(:, i) = w
    end do
  end subroutine response_solve

  !> Returns the bytes of the matrix.
  pure real(rp) function response_memory_bytes(self) result(bytes)
    class(marker_response_t), intent(in) :: self
    bytes = 0
    if (allocated(self%factor)) bytes = 8*real(size(self%factor), rp)
  end function response_memory_bytes
end module fsi_marker_response
