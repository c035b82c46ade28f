! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes one angle as a function of the cycle number x = t f, with its exact first and second derivative.
!>
!>     constant   a0/2
!>     Fourier    a0/2 + sum_i a_i cos(2 pi i x) + b_i sin(2 pi i x)
!>     Hermite    cubic between a_i = value and b_i = slope at x = (i-1)/n, repeated with period 1
!>     table      cubic between value and slope at given x_i, without period
!>     start      a0/2 + r (c (exp(-x/c) - 1) + x): from rest to the rate r, which it approaches for ever
!>     spin-up    r x^2/(2 c) until x = c, then r (x - c/2): uniform acceleration to the rate r
!>     flip       A tanh(c sin(2 pi x))/tanh(c)
!>
!> An angle f may be altered: it is then mean + factor (f(x + lead) - mean) + offset, where `mean` is the mean over a typical cycle.
!> A wave of one cycle may be added to that.
!>
!> The cubic pieces join with value and slope. The second derivative jumps at the joints, where the later piece defines its value.
!> Forms and the factor 1/2 agree with FLUSI's kinematics files.
module fsi_wing_motion_series
  use base_constants, only: TWO_PI
  use base_errors, only: require
  use base_kinds, only: rp
  implicit none
  private
  public :: angle_series_t

  integer, parameter :: CONSTANT = 0, FOURIER = 1, HERMITE = 2, TABLE = 3, START = 4, SPIN_UP = 5, FLIP = 6
  real(rp), parameter :: SETTLED = 40.0_rp !< start-up times after which a turning wing has its rate

  type :: angle_series_t
    private
    integer :: kind = CONSTANT
    real(rp) :: mean = 0             !< rad
    real(rp) :: size = 0             !< of a flip, rad; rate of start and spin-up, rad per cycle
    real(rp) :: scale = 0            !< c of start, spin-up (cycles) and flip
    real(rp), allocatable :: a(:)    !< rad
    real(rp), allocatable :: b(:)    !< rad; of cubics rad per cycle
    real(rp), allocatable :: x(:)    !< cycles, increasing; only of a table
    logical :: is_altered = .false.
    real(rp) :: factor = 1, offset = 0, lead = 0 !< of an altered angle: 1, rad, cycles
    real(rp) :: centre = 0                       !< mean before the alteration, rad
    real(rp) :: wave(2) = 0                      !< of cos(2 pi x) and sin(2 pi x), added to the altered angle, rad
  contains
    procedure :: set_constant => series_set_constant
    procedure :: set_fourier => series_set_fourier
    procedure :: set_hermite => series_set_hermite
    procedure :: set_table => series_set_table
    procedure :: set_start => series_set_start
    procedure :: set_spin_up => series_set_spin_up
    procedure :: set_flip => series_set_flip
    procedure :: alter => series_alter
    procedure :: add_wave => series_add_wave
    procedure :: evaluate => series_evaluate
    procedure :: is_periodic => series_is_periodic
    procedure :: last => series_last
    procedure :: typical_cycle => series_typical_cycle
  end type angle_series_t

contains

  !> Makes the series the same angle [rad] for ever.
  subroutine series_set_constant(self, angle)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: angle
    call clear(self, CONSTANT)
    self%mean = angle
  end subroutine series_set_constant

  !> Takes a Fourier series, with coefficients in rad and as many cosines as sines.
  subroutine series_set_fourier(self, a0, a, b)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: a0, a(:), b(:)
    call require(size(a) == size(b), 'fsi_wing_motion_series: as many cosines as sines')
    call clear(self, FOURIER)
    self%mean = a0/2
    self%a = a
    self%b = b
  end subroutine series_set_fourier

  !> Takes values [rad] and slopes [rad per cycle] at equal distances over one cycle, its end left out.
  subroutine series_set_hermite(self, values, slopes)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: values(:), slopes(:)
    call require(size(values) == size(slopes) .and. size(values) > 0, &
                 'fsi_wing_motion_series: as many values as slopes, at least one')
    call clear(self, HERMITE)
    self%a = values
    self%b = slopes
  end subroutine series_set_hermite

  !> Takes values [rad] and slopes [rad per cycle] at the increasing cycle numbers `x`, at least two.
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

  !> Makes a revolving wing, which starts from rest at the angle `first` (rad) and approaches `rate` (rad per cycle) as
  !> exp(-x/duration).
  subroutine series_set_start(self, first, rate, duration)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: first, rate, duration
    call require(duration > 0, 'fsi_wing_motion_series: a start takes time')
    call clear(self, START)
    self%mean = first
    self%size = rate
    self%scale = duration
  end subroutine series_set_start

  !> Makes a revolving wing, which starts from rest at the angle 0, accelerates uniformly until `duration` cycles, and then turns at
  !> `rate` (rad per cycle).
  subroutine series_set_spin_up(self, rate, duration)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: rate, duration
    call require(duration > 0, 'fsi_wing_motion_series: a spin-up takes time')
    call clear(self, SPIN_UP)
    self%size = rate
    self%scale = duration
  end subroutine series_set_spin_up

  !> Makes a wing that keeps its angle `amplitude` (rad) during the half-strokes and turns over between them, the more quickly the
  !> larger `sharpness` is.
  subroutine series_set_flip(self, amplitude, sharpness)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: amplitude, sharpness
    call require(sharpness > 0, 'fsi_wing_motion_series: the sharpness of a flip is positive')
    call clear(self, FLIP)
    self%size = amplitude
    self%scale = sharpness
  end subroutine series_set_flip

  !> Makes a series of the given kind, without numbers.
  subroutine clear(self, kind)
    class(angle_series_t), intent(inout) :: self
    integer, intent(in) :: kind
    self%kind = kind
    self%mean = 0
    self%is_altered = .false.
    self%wave = 0
    if (allocated(self%a)) deallocate (self%a)
    if (allocated(self%b)) deallocate (self%b)
    if (allocated(self%x)) deallocate (self%x)
  end subroutine clear

  !> Tells whether the angle repeats in every cycle.
  pure logical function series_is_periodic(self) result(periodic)
    class(angle_series_t), intent(in) :: self
    periodic = all(self%kind /= [TABLE, START, SPIN_UP])
  end function series_is_periodic

  !> Returns the cycle number at which a table ends, with its lead; without a table the largest number.
  pure real(rp) function series_last(self) result(last)
    class(angle_series_t), intent(in) :: self
    last = huge(1.0_rp)
    if (self%kind == TABLE) last = self%x(size(self%x))
    if (self%kind == TABLE .and. self%is_altered) last = last - self%lead
  end function series_last

  !> Returns the beginning and the end of a typical cycle: the first cycle, the last cycle of a table, or for a revolving wing a
  !> cycle after it has reached its rate.
  pure function series_typical_cycle(self) result(limits)
    class(angle_series_t), intent(in) :: self
    real(rp) :: limits(2)
    limits = [0.0_rp, 1.0_rp]
    if (self%kind == TABLE) limits = [max(0.0_rp, self%last() - 1), self%last()]
    if (any(self%kind == [START, SPIN_UP])) limits = limits + SETTLED*self%scale
  end function series_typical_cycle

  !> Alters the angle: `factor` on its deviation from its mean, `offset` (rad), and `lead` (cycles) by which it is advanced. Cancels
  !> all earlier alterations.
  subroutine series_alter(self, factor, offset, lead)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: factor, offset, lead
    integer, parameter :: N = 1000
    real(rp) :: f(0:2), limits(2)
    integer :: i
    self%is_altered = .false.
    limits = self%typical_cycle()
    self%centre = 0
    do i = 0, N - 1
      call evaluate_altered(self, limits(1) + i*(limits(2) - limits(1))/N, f)
      self%centre = self%centre + f(0)/N
    end do
    self%factor = factor
    self%offset = offset
    self%lead = lead
    self%is_altered = abs(factor - 1) + abs(offset) + abs(lead) > 0
  end subroutine series_alter

  !> Adds the wave cosine cos(2 pi x) + sine sin(2 pi x) [rad] to the angle, instead of an earlier one.
  subroutine series_add_wave(self, cosine, sine)
    class(angle_series_t), intent(inout) :: self
    real(rp), intent(in) :: cosine, sine
    self%wave = [cosine, sine]
  end subroutine series_add_wave

  !> Returns f, the value and its first and second derivative with respect to x: rad, rad/cycle, rad/cycle^2. Outside a table its
  !> first or last cubic continues.
  pure subroutine series_evaluate(self, x, f)
    class(angle_series_t), intent(in) :: self
    real(rp), intent(in) :: x
    real(rp), intent(out) :: f(0:2)
    real(rp) :: wave(0:2)
    call evaluate_altered(self, x, f)
    if (.not. any(abs(self%wave) > 0)) return
    call evaluate_fourier(self%wave(1:1), self%wave(2:2), modulo(x, 1.0_rp), wave)
    f = f + wave
  end subroutine series_evaluate

  !> Evaluates the series and its two derivatives without the wave that is added.
  pure subroutine evaluate_altered(self, x, f)
    class(angle_series_t), intent(in) :: self
    real(rp), intent(in) :: x
    real(rp), intent(out) :: f(0:2)
    if (.not. self%is_altered) then
      call evaluate_original(self, x, f)
      return
    end if
    if (self%kind == TABLE .and. x + self%lead < self%x(1)) then ! at rest before the table begins
      call evaluate_original(self, self%x(1), f)
      f(1:) = 0
    else
      call evaluate_original(self, x + self%lead, f)
    end if
    f(0) = f(0) - self%centre
    f = self%factor*f
    f(0) = f(0) + self%centre + self%offset
  end subroutine evaluate_altered

  !> Evaluates the series and its two derivatives as given, without later changes.
  pure subroutine evaluate_original(self, x, f)
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
    case (START)
      f = self%size*[self%scale*(exp(-x/self%scale) - 1) + x, 1 - exp(-x/self%scale), exp(-x/self%scale)/self%scale]
      f(0) = f(0) + self%mean
    case (SPIN_UP)
      if (x < self%scale) then
        f = self%size*[x**2/2, x, 1.0_rp]/self%scale
      else
        f = self%size*[x - self%scale/2, 1.0_rp, 0.0_rp]
      end if
    case (FLIP)
      call evaluate_flip(self%scale, modulo(x, 1.0_rp), f)
      f = f*self%size
    case default
      f = [self%mean, 0.0_rp, 0.0_rp]
    end select
  end subroutine evaluate_original

  !> Evaluates a Fourier series without mean, and its two derivatives, at the phase x [cycles].
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

  !> Returns tanh(c sin(2 pi x))/tanh(c) and its derivatives.
  pure subroutine evaluate_flip(c, x, f)
    real(rp), intent(in) :: c, x
    real(rp), intent(out) :: f(0:2)
    real(rp) :: g, g_rate, h
    g = c*sin(TWO_PI*x)
    g_rate = TWO_PI*c*cos(TWO_PI*x)
    h = 1 - tanh(g)**2
    f = [tanh(g), h*g_rate, -h*(TWO_PI**2*g + 2*tanh(g)*g_rate**2)]/tanh(c)
  end subroutine evaluate_flip

  !> Evaluates the cubic with values y and slopes d at both ends of an interval of length h, at s = 0..1 in it.
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

  !> Returns the i with x(i) <= at < x(i+1); the first or last interval outside.
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
