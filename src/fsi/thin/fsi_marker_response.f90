! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the velocities that forces at the markers of a wing cause there, and the forces that cause given velocities.
!>
!> Forces F on the fluid for a time dt change the velocities at the markers by dt M F, where the blocks of M are the Green tensor of
!> the differences of positions (fsi_green). M is symmetric and positive definite as long as markers are about two grid spacings
!> apart; 1e-8 of its mean diagonal is added to it. It depends on relative places only. It is therefore made in the frame of the
!> wing, once for a rigid wing. If all markers have since turned by R, its inverse is R M^-1 R^T. For a section, the axis across the
!> plane flow is y of the wing frame and x of the tensor.
!>
!> One rank holds a factor of M if there are few markers. For many markers M is too large for one rank: it has (3n)^2 numbers, and
!> a factor takes 9 n^3 operations. A group of ranks then shares M^-1 (parallel_inverse): its first rank asks for solutions while
!> the others `serve`.
module fsi_marker_response
  use base_kinds, only: rp
  use base_lapack, only: factorise, solve_factorised
  use fsi_green, only: green_t
  use parallel_inverse, only: shared_inverse_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: marker_response_t

  integer, parameter :: MOST_IN_BLOCK = 32 !< markers whose rows of M are stored in one block on one rank

  type :: marker_response_t
    real(rp), allocatable, private :: factor(:, :) !< (3n, 3n) Cholesky's factor of M, in its lower triangle, if M is not shared
    type(shared_inverse_t), allocatable, private :: inverse !< if M is shared
    real(rp), allocatable, private :: work(:)      !< (3n)
    integer, private :: axes(3) = [1, 2, 3]        !< of the wing frame, in the order of the tensor's
    real(rp), private :: rotation(3, 3) = 0        !< R, if the markers have turned
    logical, private :: has_turned = .false.
  contains
    procedure :: init => response_init
    procedure :: build => response_build
    procedure :: turn => response_turn
    procedure :: solve => response_solve
    procedure :: serve => response_serve
    procedure :: release => response_release
    procedure :: memory_bytes => response_memory_bytes
  end type marker_response_t

contains

  !> Makes room for n markers. With `is_2d` they are in the frame of a wing that appears as a section in a plane flow; the y axis of
  !> this frame is normal to the plane. With `group` its ranks share the response; otherwise the calling rank holds it alone.
  !> Collective over the group.
  subroutine response_init(self, n, is_2d, group)
    class(marker_response_t), intent(inout) :: self
    integer, intent(in) :: n
    logical, intent(in) :: is_2d
    type(world_t), intent(in), optional :: group
    if (is_2d) self%axes = [2, 1, 3]
    if (allocated(self%factor)) deallocate (self%factor)
    if (allocated(self%inverse)) deallocate (self%inverse)
    if (allocated(self%work)) deallocate (self%work)
    allocate (self%work(3*n), source=0.0_rp)
    if (present(group)) then
      allocate (self%inverse)
      call self%inverse%init(group, 3*n, 3*min(MOST_IN_BLOCK, (n + group%size - 1)/group%size)) ! each rank has some
    else
      allocate (self%factor(3*n, 3*n), source=0.0_rp)
    end if
  end subroutine response_init

  !> Makes M and its factor, or its inverse, for markers at x(3, n) [L], in any frame that is at rest for the moment.
  !> `has_factor` is false if markers are too close to each other: then `solve` must not be called. Collective over the
  !> group that shares it.
  subroutine response_build(self, green, x, has_factor)
    class(marker_response_t), intent(inout) :: self
    type(green_t), intent(in) :: green
    real(rp), intent(in) :: x(:, :)
    logical, intent(out) :: has_factor
    real(rp), parameter :: REGULARISATION = 1.0e-8_rp
    real(rp) :: own(3, 3), at(3)
    integer :: i, j, k
    self%has_turned = .false.
    own = green%at([0.0_rp, 0.0_rp, 0.0_rp])
    do k = 1, 3
      own(k, k) = own(k, k)*(1 + REGULARISATION)
    end do
    if (allocated(self%inverse)) then
      do k = 1, size(self%inverse%own), 3
        i = (self%inverse%own(k) - 1)/3 + 1
        do j = 1, size(x, 2)
          self%inverse%rows(3*j - 2:3*j, k:k + 2) = green%at(x(self%axes, i) - x(self%axes, j)) ! symmetric
        end do
        self%inverse%rows(3*i - 2:3*i, k:k + 2) = own
      end do
      call self%inverse%invert(has_factor)
      return
    end if
    do j = 1, size(x, 2)
      self%work(3*j - 2:3*j) = x(self%axes, j)
    end do
    do j = 1, size(x, 2)
      at = self%work(3*j - 2:3*j)
      do i = j + 1, size(x, 2)
        self%factor(3*i - 2:3*i, 3*j - 2:3*j) = green%at(self%work(3*i - 2:3*i) - at)
      end do
      self%factor(3*j - 2:3*j, 3*j - 2:3*j) = own
    end do
    call factorise(self%factor, has_factor)
  end subroutine response_build

  !> Records that all markers have turned by `rotation` about any point since M was made.
  pure subroutine response_turn(self, rotation)
    class(marker_response_t), intent(inout) :: self
    real(rp), intent(in) :: rotation(3, 3)
    self%rotation = rotation
    self%has_turned = .true.
  end subroutine response_turn

  !> Returns the forces f(3, n) with M f = v for velocities v(3, n), along the axes of the frame in which M was made. On the first
  !> rank of the group that shares M^-1, while the others `serve`.
  subroutine response_solve(self, v, f)
    class(marker_response_t), intent(inout) :: self
    real(rp), intent(in) :: v(:, :)
    real(rp), intent(inout) :: f(:, :)
    call put_velocities(self, v)
    if (allocated(self%inverse)) then
      call self%inverse%multiply(self%work)
    else
      call solve_factorised(self%factor, self%work)
    end if
    call get_forces(self, f)
  end subroutine response_solve

  !> Sets `work` to the velocities v(3, n), along the axes of the tensor when M was made.
  pure subroutine put_velocities(self, v)
    type(marker_response_t), intent(inout) :: self
    real(rp), intent(in) :: v(:, :)
    real(rp) :: w(3)
    integer :: i
    do i = 1, size(v, 2)
      w = v(:, i)
      if (self%has_turned) w = [dot_product(self%rotation(:, 1), v(:, i)), dot_product(self%rotation(:, 2), v(:, i)), &
                                dot_product(self%rotation(:, 3), v(:, i))]
      self%work(3*i - 2:3*i) = w(self%axes)
    end do
  end subroutine put_velocities

  !> Returns the forces f(3, n) of `work`.
  pure subroutine get_forces(self, f)
    type(marker_response_t), intent(in) :: self
    real(rp), intent(inout) :: f(:, :)
    real(rp) :: w(3)
    integer :: i
    do i = 1, size(f, 2)
      w(self%axes) = self%work(3*i - 2:3*i)
      if (self%has_turned) w = self%rotation(:, 1)*w(1) + self%rotation(:, 2)*w(2) + self%rotation(:, 3)*w(3)
      f(:, i) = w
    end do
  end subroutine get_forces

  !> Takes part in the solutions of the first rank of the group, until it releases. On its other ranks; nothing is to be done
  !> if the response is not shared.
  subroutine response_serve(self)
    class(marker_response_t), intent(inout) :: self
    if (allocated(self%inverse)) call self%inverse%serve()
  end subroutine response_serve

  !> Ends `serve` on the other ranks of the group. On its first rank.
  subroutine response_release(self)
    class(marker_response_t), intent(inout) :: self
    if (allocated(self%inverse)) call self%inverse%release()
  end subroutine response_release

  !> Returns the bytes of what this rank has of the matrix.
  pure real(rp) function response_memory_bytes(self) result(bytes)
    class(marker_response_t), intent(in) :: self
    bytes = 0
    if (allocated(self%factor)) bytes = 8*real(size(self%factor), rp)
    if (allocated(self%inverse)) bytes = self%inverse%memory_bytes()
  end function response_memory_bytes
end module fsi_marker_response
