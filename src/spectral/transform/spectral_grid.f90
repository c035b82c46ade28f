! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes the periodic box and its points x_i = i L/n, i = 0 .. n-1, in each direction.
module spectral_grid
  use base_kinds, only: rp
  implicit none
  private
  public :: grid_t, make_grid, is_fft_friendly

  !> Number of points, lengths and spacings of the box, in x, y, z.
  type :: grid_t
    integer :: n(3) = 1
    real(rp) :: length(3) = 1
    real(rp) :: spacing(3) = 1
    logical :: is_2d = .false. !< one point in x: the flow lives in the y-z plane
  contains
    procedure :: min_spacing => grid_min_spacing
    procedure :: max_spacing => grid_max_spacing
    procedure :: cell_volume => grid_cell_volume
    procedure :: volume => grid_volume
  end type grid_t

contains

  !> Returns the grid of a box of `length` [L] with `n` points. With n(1) = 1 the box is two-dimensional. As in FLUSI its length
  !> in x is then 1, so that integrals are per unit depth.
  pure function make_grid(n, length) result(grid)
    integer, intent(in) :: n(3)
    real(rp), intent(in) :: length(3)
    type(grid_t) :: grid
    grid%n = n
    grid%length = length
    grid%is_2d = n(1) == 1
    if (grid%is_2d) grid%length(1) = 1
    grid%spacing = grid%length/n
  end function make_grid

  !> Returns the smallest spacing of the resolved directions.
  pure real(rp) function grid_min_spacing(self) result(h)
    class(grid_t), intent(in) :: self
    h = minval(self%spacing(merge(2, 1, self%is_2d):))
  end function grid_min_spacing

  !> Returns the largest spacing of the resolved directions.
  pure real(rp) function grid_max_spacing(self) result(h)
    class(grid_t), intent(in) :: self
    h = maxval(self%spacing(merge(2, 1, self%is_2d):))
  end function grid_max_spacing

  !> Returns the volume of one cell [L^3] (area per unit depth in 2-D).
  pure real(rp) function grid_cell_volume(self) result(volume)
    class(grid_t), intent(in) :: self
    volume = product(self%spacing)
  end function grid_cell_volume

  !> Returns the volume of the box [L^3].
  pure real(rp) function grid_volume(self) result(volume)
    class(grid_t), intent(in) :: self
    volume = product(self%length)
  end function grid_volume

  !> Tells whether `n` is 2^a 3^b 5^c 7^d, the sizes FFTW transforms fast.
  pure logical function is_fft_friendly(n) result(friendly)
    integer, intent(in) :: n
    integer, parameter :: PRIMES(4) = [2, 3, 5, 7]
    integer :: rest, i
    rest = n
    friendly = n > 0
    if (.not. friendly) return
    do i = 1, size(PRIMES)
      do while (mod(rest, PRIMES(i)) == 0)
        rest = rest/PRIMES(i)
      end do
    end do
    friendly = rest == 1
  end function is_fft_friendly
end module spectral_grid
