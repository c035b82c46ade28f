! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the velocities at the markers of each wing due to the forces at the markers of the other wings.
!>
!> The response of all markers is M = D + E. D has a block for each wing, in whose frame it is factorised once
!> (fsi_marker_response). E holds the Green tensors between markers of different wings, which change as the wings move. M is
!> symmetric and positive definite, and D is close to M. Conjugate gradients with D^-1 as preconditioner therefore solve M F = R
!> in a few iterations (fsi_thin_wings). They need no product with D: since z = D^-1 r, the directions p = z + beta p_old have D p
!> = r + beta D p_old.
!>
!> Each rank has the rows of every n-th marker. One rank sums a row, so that the result is the same to the last bit for any number
!> of ranks. Two markers interact through their nearest periodic images.
module fsi_wing_pairs
  use base_kinds, only: rp
  use fsi_green, only: green_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: wing_pairs_t

  type :: wing_pairs_t
    private
    type(world_t) :: world
    real(rp) :: length(3) = 1
    integer, allocatable :: first(:), last(:)  !< (markers) of the wing of a marker
    integer, allocatable :: own(:)             !< markers whose rows this rank has
    real(rp), allocatable :: rows(:, :, :)     !< (3 n, 3, own) blocks of all markers before and behind the wing
    !> (3, markers) of the conjugate gradients: residual, D^-1 of it, direction, M and D times it.
    real(rp), dimension(:, :), allocatable, public :: r, z, p, mp, dp
  contains
    procedure :: init => pairs_init
    procedure :: build => pairs_build
    procedure :: add_product => pairs_add_product
    procedure :: memory_bytes => pairs_memory_bytes
  end type wing_pairs_t

contains

  !> Makes room for wings whose markers are first .. last (wings) of all, one wing behind the other, in a box of this length [L],
  !> 0 across a plane flow. Allocates.
  subroutine pairs_init(self, world, first, last, length)
    class(wing_pairs_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    integer, intent(in) :: first(:), last(:)
    real(rp), intent(in) :: length(3)
    integer :: i, m, n
    self%world = world
    self%length = length
    n = maxval(last)
    allocate (self%first(n), self%last(n))
    do i = 1, size(first)
      self%first(first(i):last(i)) = first(i)
      self%last(first(i):last(i)) = last(i)
    end do
    self%own = [(m, m=world%rank + 1, n, world%size)]
    allocate (self%rows(3*n, 3, size(self%own)), source=0.0_rp)
    allocate (self%r(3, n), self%z(3, n), self%p(3, n), self%mp(3, n), self%dp(3, n), source=0.0_rp)
  end subroutine pairs_init

  !> Makes E for markers at x(3, n) [L] in space.
  subroutine pairs_build(self, green, x)
    class(wing_pairs_t), intent(inout) :: self
    type(green_t), intent(in) :: green
    real(rp), intent(in) :: x(:, :)
    real(rp) :: way(3)
    integer :: i, j, k, m
    do k = 1, size(self%own)
      m = self%own(k)
      i = 0
      do j = 1, size(x, 2)
        if (j >= self%first(m) .and. j <= self%last(m)) cycle
        way = x(:, m) - x(:, j)
        where (self%length > 0)
          way = way - self%length*anint(way/self%length)
        elsewhere
          way = 0
        end where
        self%rows(i + 1:i + 3, :, k) = green%at(way) ! symmetric
        i = i + 3
      end do
    end do
  end subroutine pairs_build

  !> Adds E times f(3, n) to v(3, n), the same on all ranks. Collective.
  subroutine pairs_add_product(self, f, v)
    class(wing_pairs_t), intent(in) :: self
    real(rp), contiguous, intent(in) :: f(:, :)
    real(rp), intent(inout) :: v(:, :)
    real(rp) :: sums(3*size(f, 2))
    sums = 0
    call multiply(self, f, sums)
    call self%world%sum_reals(sums)
    v = v + reshape(sums, shape(v))
  end subroutine pairs_add_product

  !> Multiplies the rows of this rank with the forces.
  pure subroutine multiply(self, f, sums)
    type(wing_pairs_t), intent(in) :: self
    real(rp), intent(in) :: f(3*size(self%first))
    real(rp), intent(inout) :: sums(:)
    integer :: c, k, m, before, behind, n
    n = size(f)
    do k = 1, size(self%own)
      m = self%own(k)
      before = 3*self%first(m) - 3
      behind = n - 3*self%last(m)
      do c = 1, 3
        sums(3*m - 3 + c) = dot_product(self%rows(:before, c, k), f(:before)) + &
                            dot_product(self%rows(before + 1:before + behind, c, k), f(n - behind + 1:))
      end do
    end do
  end subroutine multiply

  !> Returns the bytes of the rows of this rank.
  pure real(rp) function pairs_memory_bytes(self) result(bytes)
    class(wing_pairs_t), intent(in) :: self
    bytes = 0
    if (allocated(self%rows)) bytes = 8*real(size(self%rows), rp)
  end function pairs_memory_bytes
end module fsi_wing_pairs
