! SPDX-License-Identifier: GPL-3.0-or-later
!> Interpolates a grid field at arbitrary points of the box, by Peskin's regularized delta function.
!>
!> The four-point function (Peskin, Acta Numerica 2002, eq. 6.27, DOI 10.1017/S0962492902000077) in each direction: its weights are
!> continuous in the position of the point and reproduce linear fields exactly.
module fluid_sampling
  use base_errors, only: require
  use base_kinds, only: rp
  use parallel_block, only: block_t
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: sampler_t, samples_t, delta_weights

  !> Points of the box, and the values that a field has there.
  type :: samples_t
    real(rp), allocatable :: points(:, :) !< (3, n) L
    real(rp), allocatable :: values(:)    !< (n)
  contains
    procedure :: init => samples_init
  end type samples_t

  type :: sampler_t
    private
    type(world_t) :: world
    type(grid_t) :: grid
    type(block_t) :: block
  contains
    procedure :: init => sampler_init
    procedure :: sample => sampler_sample
    procedure :: select_lines => sampler_select_lines
  end type sampler_t

contains

  !> Makes room for n points.
  pure subroutine samples_init(self, n)
    class(samples_t), intent(inout) :: self
    integer, intent(in) :: n
    if (allocated(self%values)) deallocate (self%points, self%values)
    allocate (self%points(3, n), self%values(n), source=0.0_rp)
  end subroutine samples_init

  !> Prepares sampling of fields on this rank's `block` of `grid`, which owns whole lines in x. In a two-dimensional box the
  !> position along x does not matter: all weights, whose sum is 1, fall on the single grid point in x.
  subroutine sampler_init(self, world, grid, block)
    class(sampler_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    call require(block%count(1) == grid%n(1), 'sampler_t: lines must be whole')
    call require(all(grid%n >= 4 .or. grid%n == 1), 'sampler_t: the function needs four points, or one, in each direction')
    self%world = world
    self%grid = grid
    self%block = block
  end subroutine sampler_init

  !> Returns the values (n) of `field` (nx, ny_local, nz_local) at points (3, n) [L], the same on all ranks; the box is periodic.
  !> Every rank adds the contribution of its grid points; the ranks exchange only the n values. Collective.
  subroutine sampler_sample(self, points, field, values)
    class(sampler_t), intent(in) :: self
    real(rp), contiguous, intent(in) :: points(:, :)
    real(rp), contiguous, intent(in) :: field(:, :, :)
    real(rp), contiguous, intent(inout) :: values(:)
    real(rp) :: w(-1:2, 3), line
    integer :: first(3), x(-1:2), y(-1:2), z(-1:2), i, j, k
    call require(size(points, 2) == size(values), 'sampler_t: one value for each point')
    do i = 1, size(values)
      values(i) = 0
      first = floor(points(:, i)/self%grid%spacing)
      x = modulo(first(1) + [-1, 0, 1, 2], self%grid%n(1)) + 1
      y = modulo(first(2) + [-1, 0, 1, 2], self%grid%n(2)) - self%block%start(2) + 1
      z = modulo(first(3) + [-1, 0, 1, 2], self%grid%n(3)) - self%block%start(3) + 1
      if (all(y < 1 .or. y > self%block%count(2)) .or. all(z < 1 .or. z > self%block%count(3))) cycle
      do j = 1, 3
        call delta_weights(points(j, i)/self%grid%spacing(j), first(j), w(:, j))
      end do
      do k = -1, 2
        if (z(k) < 1 .or. z(k) > self%block%count(3)) cycle
        do j = -1, 2
          if (y(j) < 1 .or. y(j) > self%block%count(2)) cycle
          line = w(-1, 1)*field(x(-1), y(j), z(k)) + w(0, 1)*field(x(0), y(j), z(k)) + &
                 w(1, 1)*field(x(1), y(j), z(k)) + w(2, 1)*field(x(2), y(j), z(k))
          values(i) = values(i) + w(j, 2)*w(k, 3)*line
        end do
      end do
    end do
    call self%world%sum_reals(values)
  end subroutine sampler_sample

  !> Marks in `lines` (ny_local, nz_local) the lines that `sample` will need for these points (3, n) [L]; leaves the others as
  !> they are.
  subroutine sampler_select_lines(self, points, lines)
    class(sampler_t), intent(in) :: self
    real(rp), intent(in) :: points(:, :)
    logical, intent(inout) :: lines(:, :)
    integer :: i, j, k, y, z, first(2)
    do i = 1, size(points, 2)
      first = floor(points(2:, i)/self%grid%spacing(2:))
      do k = first(2) - 1, first(2) + 2
        z = modulo(k, self%grid%n(3)) - self%block%start(3) + 1
        if (z < 1 .or. z > self%block%count(3)) cycle
        do j = first(1) - 1, first(1) + 2
          y = modulo(j, self%grid%n(2)) - self%block%start(2) + 1
          if (y >= 1 .and. y <= self%block%count(2)) lines(y, z) = .true.
        end do
      end do
    end do
  end subroutine sampler_select_lines

  !> Returns the weights of the points first - 1 .. first + 2 for the position s, in cells; their sum is 1.
  pure subroutine delta_weights(s, first, w)
    real(rp), intent(in) :: s
    integer, intent(out) :: first
    real(rp), intent(out) :: w(-1:2)
    real(rp) :: r, inner, outer
    first = floor(s)
    r = s - first
    inner = sqrt(1 + 4*r - 4*r**2)
    outer = sqrt(max(0.0_rp, -7 + 12*(1 + r) - 4*(1 + r)**2))
    w(0) = (3 - 2*r + inner)/8
    w(-1) = (5 - 2*(1 + r) - outer)/8
    w(1) = (3 - 2*(1 - r) + inner)/8
    w(2) = 1 - w(-1) - w(0) - w(1)
  end subroutine delta_weights
end module fluid_sampling
