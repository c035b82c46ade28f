! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the filter between modes and points of the flow (fluid_point_forces) on one stick at a time, and applies it.
!>
!> The filter is Phi divided by the transform of the window, for |k| < K, and 0 beyond. It does not depend on the sign of kz. Only
!> modes inside this sphere are touched.
module fluid_point_filter
  use base_kinds, only: rp
  use spectral_grid, only: grid_t
  use spectral_sticks, only: sphere_radius, sticks_t
  use spectral_window, only: window_transform
  implicit none
  private
  public :: point_filter_t

  type :: point_filter_t
    private
    real(rp), public :: radius = 0     !< K, 1/L
    integer, allocatable :: top(:)     !< (sticks) largest jz inside the sphere, -1 for none
    real(rp), allocatable :: kx(:), ky(:), kz(:)  !< wavenumbers of sticks and along them
    real(rp), allocatable :: inverse_xy(:), inverse_z(:) !< 1/transform of the window: of sticks; for jz = 0 .. limit
    real(rp), allocatable :: kappa_xy(:), kappa_z(:)     !< parts of (k/K)^2, the same
    real(rp), allocatable :: factor(:) !< (nkz) the filter, on the present stick
    real(rp), allocatable :: over_k2(:) !< (nkz) the filter over k^2; any finite number for k = 0, where k multiplies it
    integer :: zero = 0                !< the stick with k = 0
  contains
    procedure :: init => filter_init
    procedure :: take => filter_take
    procedure :: push => filter_push
    procedure :: memory_bytes => filter_memory_bytes
    procedure, private :: choose
  end type point_filter_t

contains

  !> Makes the tables for these sticks, which lie inside the ellipsoidal truncation.
  subroutine filter_init(self, grid, sticks)
    class(point_filter_t), intent(inout) :: self
    type(grid_t), intent(in) :: grid
    type(sticks_t), intent(in) :: sticks
    integer :: s, n
    n = sticks%kz_limit + 1
    self%radius = sphere_radius(grid)
    self%zero = sticks%zero
    self%kx = sticks%kx
    self%ky = sticks%ky
    self%kz = sticks%kz
    self%inverse_xy = 1/window_transform(sticks%ky*grid%spacing(2))
    if (.not. grid%is_2d) self%inverse_xy = self%inverse_xy/window_transform(sticks%kx*grid%spacing(1))
    self%inverse_z = 1/window_transform(sticks%kz(:n)*grid%spacing(3))
    self%kappa_xy = (sticks%kx**2 + sticks%ky**2)/self%radius**2
    self%kappa_z = sticks%kz(:n)**2/self%radius**2
    allocate (self%top(sticks%n), self%factor(sticks%nkz), self%over_k2(sticks%nkz))
    do s = 1, sticks%n
      self%top(s) = count(self%kappa_xy(s) + self%kappa_z < 1) - 1
    end do
    self%factor = 0
    self%over_k2 = 0
  end subroutine filter_init

  !> Computes `factor` times `scale` and, with `projects`, from it `over_k2` for the modes of stick `s` inside the sphere.
  pure subroutine choose(self, s, scale, projects)
    class(point_filter_t), intent(inout) :: self
    integer, intent(in) :: s
    real(rp), intent(in) :: scale
    logical, intent(in) :: projects
    real(rp), parameter :: LEAST = 1.0e-20_rp !< below (k/K)^2 of any mode but 0
    integer :: j, n
    n = self%top(s) + 1
    do j = 1, n
      self%factor(j) = sqrt(1 + (self%kappa_xy(s) + self%kappa_z(j)))*(scale*self%inverse_xy(s)*self%inverse_z(j))
    end do
    do j = 2, n
      self%factor(size(self%factor) + 2 - j) = self%factor(j)
    end do
    if (.not. projects) return
    do j = 1, n
      self%over_k2(j) = self%factor(j)/(self%radius**2*max(self%kappa_xy(s) + self%kappa_z(j), LEAST))
    end do
    do j = 2, n
      self%over_k2(size(self%factor) + 2 - j) = self%over_k2(j)
    end do
  end subroutine choose

  !> Returns the filtered modes of u(nkz, sticks, 3) on the sticks first .. first + count - 1 in out(nkz, 1:count, 3).
  pure subroutine filter_take(self, first, count, u, out)
    class(point_filter_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(in) :: u(:, :, :)
    complex(rp), contiguous, intent(inout) :: out(:, :, :)
    integer :: c, i, n, m, s, nkz
    nkz = size(self%factor)
    do i = 1, count
      s = first + i - 1
      call self%choose(s, 1.0_rp, .false.)
      n = self%top(s) + 1
      m = nkz + 1 - max(self%top(s), 0) ! first of the negative kz
      do c = 1, 3
        call scaled(n, self%factor, u(:, s, c), out(:, i, c))
        out(n + 1:m - 1, i, c) = 0
        call scaled(nkz + 1 - m, self%factor(m:), u(m:, s, c), out(m:, i, c))
      end do
    end do
  end subroutine filter_take

  !> Returns w u.
  pure subroutine scaled(n, w, u, out)
    integer, intent(in) :: n
    real(rp), intent(in) :: w(n)
    complex(rp), intent(in) :: u(n)
    complex(rp), intent(inout) :: out(n)
    integer :: j
    do j = 1, n
      out(j) = w(j)*u(j)
    end do
  end subroutine scaled

  !> Adds `scale` times the filtered modes f(nkz, 1:count, 3), without their divergence, to u(nkz, sticks, 3) on the sticks first ..
  !> first + count - 1. For k = 0 it adds `mean` instead.
  pure subroutine filter_push(self, first, count, scale, mean, f, u)
    class(point_filter_t), intent(inout) :: self
    integer, intent(in) :: first, count
    real(rp), intent(in) :: scale, mean(3)
    complex(rp), contiguous, intent(in) :: f(:, :, :)
    complex(rp), contiguous, intent(inout) :: u(:, :, :)
    integer :: i, n, m, s, nkz
    nkz = size(self%factor)
    do i = 1, count
      s = first + i - 1
      call self%choose(s, scale, .true.)
      n = self%top(s) + 1
      m = nkz + 1 - max(self%top(s), 0) ! first of the negative kz
      if (s == self%zero) then
        self%factor(1) = 0
        u(1, s, :) = u(1, s, :) + mean
      end if
      call add_projected(n, self%kx(s), self%ky(s), self%kz, self%factor, self%over_k2, f(:, i, 1), f(:, i, 2), f(:, i, 3), &
                         u(:, s, 1), u(:, s, 2), u(:, s, 3))
      call add_projected(nkz + 1 - m, self%kx(s), self%ky(s), self%kz(m:), self%factor(m:), self%over_k2(m:), &
                         f(m:, i, 1), f(m:, i, 2), f(m:, i, 3), u(m:, s, 1), u(m:, s, 2), u(m:, s, 3))
    end do
  end subroutine filter_push

  !> Adds w f - k (k.f) w/k^2 to u, where `v` is w/k^2.
  pure subroutine add_projected(n, kx, ky, kz, w, v, f1, f2, f3, u1, u2, u3)
    integer, intent(in) :: n
    real(rp), intent(in) :: kx, ky, kz(n), w(n), v(n)
    complex(rp), intent(in) :: f1(n), f2(n), f3(n)
    complex(rp), intent(inout) :: u1(n), u2(n), u3(n)
    complex(rp) :: along
    integer :: j
    do j = 1, n
      along = v(j)*(kx*f1(j) + ky*f2(j) + kz(j)*f3(j))
      u1(j) = u1(j) + (w(j)*f1(j) - kx*along)
      u2(j) = u2(j) + (w(j)*f2(j) - ky*along)
      u3(j) = u3(j) + (w(j)*f3(j) - kz(j)*along)
    end do
  end subroutine add_projected

  !> Returns the bytes of its tables.
  pure real(rp) function filter_memory_bytes(self) result(bytes)
    class(point_filter_t), intent(in) :: self
    bytes = 0
    if (allocated(self%top)) bytes = 36*real(size(self%top), rp)
  end function filter_memory_bytes
end module fluid_point_filter
