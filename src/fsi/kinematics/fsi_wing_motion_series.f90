! SPDX-License-Identifier: GPL-3.0-or-later
!> One angle as a function of the cycle number x = t f, with its exact first and second derivative.
!>
!>     constant   a0/2
!>     Fourier    a0/2 + sum_i a_i cos(2 pi i x) + b_i sin(2 pi i x)
!>     Hermite    cubic between a_i = value and b_i = slope at x = (i-1)/n, repeated with period 1
!>     table      cubic between value and slope at given x_i, without period
!>
!> The cubic pieces join with value and slope; the second derivative jumps where they meet, and there
!> belongs to the later piece. Forms and factor 1/2 as FLUSI's kinematics files.
module fsi_wing_motion_series
  use base_constants, only: TWO_PI
  use base_errors, only: require
  use base_kinds, only: rp
  implicit none
  private
  public :: angle_series_t

  integer, parameter :: CONSTANT = 0, FOURIER = 1, HERMITE = 2, TABLE = 3

  type :: angle_series_t
    private
    integer :: kind = CONSTANT
    real(rp) :: mean = 0             !< rad
    real(rp), allocatable :: a(:)    !< rad
    real(rp), allocatable :: b(:)    !< rad; of cubics rad per cycle
    real(rp), allocatable :: x(:)    !< cycles, increasing; only of a table
  contains
    procedure :: set_constant => series_set_constant
    procedure :: set_fourier => series_set_fourier
    procedure :: set_hermite => series_set_hermite
    procedure :: set_table => series_set_table
    procedure :: evaluate => series_evaluate
    procedure :: is_periodic => series_is_periodic
    procedure :: last => series_last
  end type angle_series_t

contains

  !> The same angle for ever, in rad.
  subroutine series_set_constant(self, angle)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: angle
    call clear(self, CONSTANT)
    self%mean = angle
  end subroutine series_set_constant

  !> A Fourier series; coefficients in rad, as many cosines as sines.
  subroutine series_set_fourier(self, a0, a, b)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: a0, a(:), b(:)
    call require(size(a) == size(b), 'fsi_wing_motion_series: as many cosines as sines')
    call clear(self, FOURIER)
    self%mean = a0/2
    self%a = a
    self%b = b
  end subroutine series_set_fourier

  !> Values in rad and slopes in rad per cycle at equal distances over one cycle, its end left out.
  subroutine series_set_hermite(self, values, slopes)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: values(:), slopes(:)
    call require(size(values) == size(slopes) .and. size(values) > 0, &
                 'fsi_wing_motion_series: as many values as slopes, at least one')
    call clear(self, HERMITE)
    self%a = values
    self%b = slopes
  end subroutine series_set_hermite

  !> Values in rad and slopes in rad per cycle at the increasing cycle numbers `x`, at least two.
  subroutine series_set_table(self, x, values, slopes)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: x(:), values(:), slopes(:)
    call require(size(values) == size(slopes) .and. size(values) == size(x) .and. size(x) > 1, &
                 'fsi_wing_motion_series: a table has two or more times, values and slopes')
    call require(all(x(2:) > x(:size(x) - 1)), 'fsi_wing_motion_series: the times of a table increase')
    call clear(self, TABLE)
    self%x = x
    self%a = values
    self%b = slopes
  end subroutine series_set_table

  subroutine clear(self, kind)
    class(angle_series_t), intent(inout) :: self
    integer, intent(in) :: kind
    self%kind = kind
    self%mean = 0
    if (allocated(self%a)) deallocate (self%a)
    if (allocated(self%b)) deallocate (self%b)
    if (allocated(self%x)) deallocate (self%x)
  end subroutine clear

  !> Whether the angle is defined for all times.
  pure logical function series_is_periodic(self) result(periodic)
    class(angle_series_t), intent(in) :: self
    periodic = self%kind /= TABLE
  end function series_is_periodic

  !> Cycle number at which a table ends; without a table the largest number.
  pure real(rp) function series_last(self) result(last)
    class(angle_series_t), intent(in) :: self
    last = huge(1.0_rp)
    if (self%kind == TABLE) last = self%x(size(self%x))
  end function series_last

  !> f = value, first and second derivative with respect to x: rad, rad/cycle, rad/cycle^2. Outside a
  !> table its first or last cubic goes on.
  pure subroutine series_evaluate(self, x, f)
    class(angle_series_t), intent(in) :: self
    real(rp), intent(in) :: x
    real(rp), intent(out) :: f(0:2)
    integer :: n, i
    real(rp) :: s
    select case (self%kind)
    case (FOURIER)
      call evaluate_fourier(self%a, self%b, modulo(x, 1.0_rp), f)
      f(0) = f(0) + self%mean
    case (HERMITE)
      n = size(self%a)
      s = n*modulo(x, 1.0_rp)
      i = min(int(s), n - 1)
      call evaluate_cubic(s - i, 1.0_rp/n, self%a(i + 1), self%a(modulo(i + 1, n) + 1), &
                          self%b(i + 1), self%b(modulo(i + 1, n) + 1), f)
    case (TABLE)
      i = interval_of(self%x, x)
      s = self%x(i + 1) - self%x(i)
      call evaluate_cubic((x - self%x(i))/s, s, self%a(i), self%a(i + 1), self%b(i), self%b(i + 1), f)
    case default
      f = [self%mean, 0.0_rp, 0.0_rp]
    end select
  end subroutine series_evaluate

  pure subroutine evaluate_fourier(a, b, x, f)
    real(rp), intent(in) :: a(:), b(:), x
    real(rp), intent(out) :: f(0:2)
    real(rp) :: k, c, s
    integer :: i
    f = 0
    do i = 1, size(a)
      k = TWO_PI*i
      c = cos(k*x)
      s = sin(k*x)
      f(0) = f(0) + a(i)*c + b(i)*s
      f(1) = f(1) + k*(b(i)*c - a(i)*s)
      f(2) = f(2) - k**2*(a(i)*c + b(i)*s)
    end do
  end subroutine evaluate_fourier

  !> The cubic with values y and slopes d at both ends of an interval of length h, at s = 0..1 in it.
  pure subroutine evaluate_cubic(s, h, y1, y2, d1, d2, f)
    real(rp), intent(in) :: s, h, y1, y2, d1, d2
    real(rp), intent(out) :: f(0:2)
    real(rp) :: c2, c3
    c2 = 3*(y2 - y1) - h*(2*d1 + d2)
    c3 = h*(d1 + d2) - 2*(y2 - y1)
    f(0) = y1 + s*(h*d1 + s*(c2 + s*c3))
    f(1) = d1 + s*(2*c2 + 3*s*c3)/h
    f(2) = (2*c2 + 6*s*c3)/h**2
  end subroutine evaluate_cubic

  !> The i with x(i) <= at < x(i+1); the first or last interval outside.
  pure integer function interval_of(x, at) result(i)
    real(rp), intent(in) :: x(:), at
    integer :: above, middle
    i = 1
    above = size(x)
    do while (above - i > 1)
      middle = (i + above)/2
      if (x(middle) <= at) then
        i = middle
      else
        above = middle
      end if
    end do
  end function interval_of
end module fsi_wing_motion_series
