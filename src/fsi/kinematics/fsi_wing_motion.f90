! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes the motion of one wing at its hinge: the angles phi (position in the stroke plane), alpha (feathering) and theta
!> (deviation) over time, with exact first and second derivatives.
!>
!> Each angle is a function of the cycle number t f. With a start-up ramp of duration tau it is
!>
!>     phi(t) = phi(0) + s(t/tau) (phi*(t f) - phi(0)),   s(r) = r^3 (10 - 15 r + 6 r^2),
!>
!> so that the wing starts at rest at phi(0), without acceleration, and follows phi* from tau on. The signs of angles are those that
!> FLUSI uses internally: right-hand rule, theta > 0 is down in a horizontal stroke plane.
module fsi_wing_motion
  use base_errors, only: message_list_t, require
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_rotation, only: angle_t
  use fsi_wing_motion_series, only: angle_series_t
  implicit none
  private
  public :: wing_motion_t

  type :: wing_motion_t
    type(angle_series_t) :: phi, alpha, theta
    real(rp) :: frequency = 1 !< of the wing beat, 1/T
    real(rp) :: ramp = 0      !< duration of the start-up ramp, T; 0: none
  contains
    procedure :: set_constant => motion_set_constant
    procedure :: evaluate => motion_evaluate
    procedure :: check_span => motion_check_span
    procedure :: stroke_extremes => motion_stroke_extremes
    procedure :: stroke_path => motion_stroke_path
  end type wing_motion_t

contains

  !> Makes a wing keep its angles [rad].
  subroutine motion_set_constant(self, phi, alpha, theta)
    class(wing_motion_t), intent(inout) :: self
    real(rp), intent(in) :: phi, alpha, theta
    call self%phi%set_constant(phi)
    call self%alpha%set_constant(alpha)
    call self%theta%set_constant(theta)
  end subroutine motion_set_constant

  !> Returns the angles at time t [T], in rad, and their derivatives with respect to t. The time may be up to a tenth of a cycle
  !> beyond the end of a table, because the last step may pass the end of the run.
  subroutine motion_evaluate(self, t, phi, alpha, theta)
    class(wing_motion_t), intent(in) :: self
    real(rp), intent(in) :: t
    type(angle_t), intent(out) :: phi, alpha, theta
    real(rp), parameter :: BEYOND = 0.1_rp !< cycles
    call require(t*self%frequency <= self%phi%last() + BEYOND, &
                 'fsi_wing_motion: time behind the end of the table, see check_span')
    phi = angle_at(self, self%phi, t)
    alpha = angle_at(self, self%alpha, t)
    theta = angle_at(self, self%theta, t)
  end subroutine motion_evaluate

  !> Returns an angle and its two time derivatives at time t [T], with the start of the motion smoothed by the ramp.
  pure type(angle_t) function angle_at(self, series, t) result(angle)
    class(wing_motion_t), intent(in) :: self
    type(angle_series_t), intent(in) :: series
    real(rp), intent(in) :: t
    real(rp) :: f(0:2), start(0:2), r, s, s_rate, s_acceleration
    call series%evaluate(t*self%frequency, f)
    f(1) = f(1)*self%frequency
    f(2) = f(2)*self%frequency**2
    if (t < self%ramp) then
      call series%evaluate(0.0_rp, start)
      r = max(0.0_rp, t/self%ramp)
      s = r**3*(10 - 15*r + 6*r**2)
      s_rate = 30*r**2*(1 - r)**2/self%ramp
      s_acceleration = 60*r*(1 - r)*(1 - 2*r)/self%ramp**2
      f(0) = f(0) - start(0)
      f(2) = s_acceleration*f(0) + 2*s_rate*f(1) + s*f(2)
      f(1) = s_rate*f(0) + s*f(1)
      f(0) = start(0) + s*f(0)
    end if
    angle = angle_t(f(0), f(1), f(2))
  end function angle_at

  !> Adds a mistake unless the motion called `name` is known from time 0 up to `t_end`.
  subroutine motion_check_span(self, t_end, name, errors)
    class(wing_motion_t), intent(in) :: self
    real(rp), intent(in) :: t_end
    character(*), intent(in) :: name
    type(message_list_t), intent(inout) :: errors
    real(rp) :: last
    last = min(self%phi%last(), self%alpha%last(), self%theta%last())
    if (t_end*self%frequency <= last) return
    call errors%add(name//': the table ends after '//number_text(last)//' cycles, the run after '// &
                    number_text(t_end*self%frequency)//'; valid: a shorter run or a longer table')
  end subroutine motion_check_span

  !> Returns the smallest and largest position angle phi [rad] of the motion without ramp: over one cycle, or over a table. Their
  !> difference is the stroke amplitude. For a wing that revolves they are the angles in a cycle at its final rate.
  subroutine motion_stroke_extremes(self, smallest, largest)
    class(wing_motion_t), intent(in) :: self
    real(rp), intent(out) :: smallest, largest
    integer, parameter :: N = 1000
    real(rp) :: f(0:2), x_smallest, x_largest, first, length, limits(2)
    integer :: i
    limits = self%phi%typical_cycle()
    first = limits(1)
    length = limits(2) - first
    if (self%phi%last() < huge(1.0_rp)) then ! a table
      first = 0
      length = self%phi%last()
    end if
    smallest = huge(1.0_rp)
    largest = -huge(1.0_rp)
    x_smallest = 0
    x_largest = 0
    do i = 0, N
      call self%phi%evaluate(first + i*length/N, f)
      if (f(0) < smallest) x_smallest = first + i*length/N
      if (f(0) > largest) x_largest = first + i*length/N
      smallest = min(smallest, f(0))
      largest = max(largest, f(0))
    end do
    smallest = min(smallest, refined(x_smallest))
    largest = max(largest, refined(x_largest))

  contains

    !> Finds the angle where its rate vanishes, near x, by Newton's method with steps of at most one sample.
    real(rp) function refined(x) result(angle)
      real(rp), intent(in) :: x
      real(rp) :: at
      integer :: iteration
      at = x
      do iteration = 1, 4
        call self%phi%evaluate(at, f)
        if (abs(f(1)) >= abs(f(2))*length/N) exit
        at = min(max(at - f(1)/f(2), first), first + length)
      end do
      call self%phi%evaluate(at, f)
      angle = f(0)
    end function refined
  end subroutine motion_stroke_extremes

  !> Returns the angle [rad] that the wing sweeps, forward and back, in one cycle without ramp: twice the stroke amplitude. For a
  !> table the last cycle counts; for a wing that revolves, a cycle at its final rate.
  real(rp) function motion_stroke_path(self) result(path)
    class(wing_motion_t), intent(in) :: self
    integer, parameter :: N = 2000
    real(rp) :: f(0:2), before, low, high, limits(2)
    integer :: i
    if (self%phi%is_periodic()) then
      call self%stroke_extremes(low, high)
      path = 2*(high - low)
      return
    end if
    limits = self%phi%typical_cycle()
    path = 0
    call self%phi%evaluate(limits(1), f)
    do i = 1, N
      before = f(0)
      call self%phi%evaluate(limits(1) + (limits(2) - limits(1))*i/N, f)
      path = path + abs(f(0) - before)
    end do
    path = path/(limits(2) - limits(1))
  end function motion_stroke_path
end module fsi_wing_motion
