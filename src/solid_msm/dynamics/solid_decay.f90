! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes how a natural mode of a damped wing decays: with lambda of the mode without damping, and J = phi^T K_joints phi, it
!> moves as exp(s t), where
!>
!>     s^2 + d s + lambda (1 + g s/(s + 1/tau)) = 0,   d = alpha + beta lambda + theta J
!>
!> (solid_damping_effects). Without a relaxation the mode has the frequency sqrt(lambda)/(2 pi) and the damping ratio
!> d/(2 sqrt(lambda)), which exceeds 1 if the mode does not swing; with it, |s|/(2 pi) and -Re(s)/|s|, which are the same for g = 0
!> as long as the mode swings. What damping takes from one mode and gives to another is left out. Drag with the
!> square of the speed has no ratio.
module solid_decay
  use base_kinds, only: rp
  use solid_damping_effects, only: damping_effects_t, DAMPING_JOINTS, DAMPING_MASS, DAMPING_RELAXATION, DAMPING_STIFFNESS, &
                                   DAMPING_TIME
  implicit none
  private
  public :: decay_t

  type :: decay_t
    real(rp) :: log_rate = 0   !< ln of |s| [rad/s]
    real(rp) :: ratio = 0      !< damping ratio
    complex(rp), private :: s = (0, 0)
    real(rp), private :: lambda = 1, joint = 0, rate = 0 !< the last is d
    type(damping_effects_t), private :: damping
  contains
    procedure :: init => decay_init
    procedure :: slope_of_damping => decay_slope_of_damping
    procedure :: slope_of_mode => decay_slope_of_mode
  end type decay_t

contains

  !> Finds the decay of a mode of lambda [1/s^2] > 0 and J = joint [1/s^2]; with a relaxation by Newton's method from weak damping.
  pure subroutine decay_init(self, lambda, joint, damping)
    class(decay_t), intent(inout) :: self
    real(rp), intent(in) :: lambda, joint
    type(damping_effects_t), intent(in) :: damping
    complex(rp) :: step
    real(rp) :: d
    integer :: k
    self%lambda = lambda
    self%joint = joint
    self%damping = damping
    d = damping%mass + damping%stiffness*lambda + damping%joints*joint
    self%rate = d
    self%log_rate = 0.5_rp*log(lambda)
    self%ratio = 0.5_rp*d/sqrt(lambda)
    if (.not. abs(damping%relaxation) > 0) return
    self%s = sqrt(cmplx(d**2/4 - lambda, 0.0_rp, rp)) - d/2
    do k = 1, 50
      associate (s => self%s, r => 1/damping%relaxation_time, g => damping%relaxation)
        step = (s**2 + d*s + lambda*(1 + g*s/(s + r)))/slope_of_root(self)
      end associate
      self%s = self%s - step
      if (abs(step) <= 1.0e-14_rp*abs(self%s)) exit
    end do
    self%log_rate = log(abs(self%s))
    self%ratio = -real(self%s, rp)/abs(self%s)
  end subroutine decay_init

  !> Returns the derivative of the equation with respect to s.
  pure complex(rp) function slope_of_root(self) result(slope)
    type(decay_t), intent(in) :: self
    associate (s => self%s, e => self%damping, r => 1/self%damping%relaxation_time)
      slope = 2*s + self%rate + self%lambda*e%relaxation*r/(s + r)**2
    end associate
  end function slope_of_root

  !> Returns the derivatives of `log_rate` and `ratio` with respect to damping effect `number` (DAMPING_TIME: to the logarithm of
  !> the relaxation time).
  pure function decay_slope_of_damping(self, number) result(slopes)
    class(decay_t), intent(in) :: self
    integer, intent(in) :: number
    real(rp) :: slopes(2)
    complex(rp) :: p
    if (.not. abs(self%damping%relaxation) > 0) then
      slopes = plain_slopes_of_damping(self, number)
      return
    end if
    associate (s => self%s, r => 1/self%damping%relaxation_time)
      select case (number)
      case (DAMPING_MASS)
        p = s
      case (DAMPING_STIFFNESS)
        p = self%lambda*s
      case (DAMPING_JOINTS)
        p = self%joint*s
      case (DAMPING_RELAXATION)
        p = self%lambda*s/(s + r)
      case (DAMPING_TIME)
        p = self%lambda*self%damping%relaxation*s*r/(s + r)**2
      case default
        p = 0
      end select
    end associate
    slopes = slopes_from(self, p)
  end function decay_slope_of_damping

  !> Returns the same without a relaxation. To first order in g, with r = 1/tau, the equation is
  !> (s^2 + (d + g a) s + lambda + g b) (s + r - g a) = 0, where a = lambda r/(r^2 - d r + lambda) and b = a lambda/r. So there is a
  !> derivative also where the mode ceases to swing.
  pure function plain_slopes_of_damping(self, number) result(slopes)
    type(decay_t), intent(in) :: self
    integer, intent(in) :: number
    real(rp) :: slopes(2), a
    associate (lambda => self%lambda, r => 1/self%damping%relaxation_time)
      select case (number)
      case (DAMPING_MASS)
        slopes = plain_slopes(self, 1.0_rp, 0.0_rp)
      case (DAMPING_STIFFNESS)
        slopes = plain_slopes(self, lambda, 0.0_rp)
      case (DAMPING_JOINTS)
        slopes = plain_slopes(self, self%joint, 0.0_rp)
      case (DAMPING_RELAXATION)
        a = lambda*r/(r**2 - self%rate*r + lambda)
        slopes = plain_slopes(self, a, a*lambda/r)
      case default
        slopes = 0
      end select
    end associate
  end function plain_slopes_of_damping

  !> Returns the change of `log_rate` and `ratio` by changes of d and lambda, without a relaxation.
  pure function plain_slopes(self, d_rate, d_lambda) result(slopes)
    type(decay_t), intent(in) :: self
    real(rp), intent(in) :: d_rate, d_lambda
    real(rp) :: slopes(2)
    slopes(1) = 0.5_rp*d_lambda/self%lambda
    slopes(2) = 0.5_rp*d_rate/sqrt(self%lambda) - self%ratio*slopes(1)
  end function plain_slopes

  !> Returns their change by changes of lambda and J.
  pure function decay_slope_of_mode(self, d_lambda, d_joint) result(slopes)
    class(decay_t), intent(in) :: self
    real(rp), intent(in) :: d_lambda, d_joint
    real(rp) :: slopes(2)
    complex(rp) :: p
    associate (s => self%s, e => self%damping, r => 1/self%damping%relaxation_time)
      if (.not. abs(e%relaxation) > 0) then
        slopes = plain_slopes(self, d_lambda*e%stiffness + d_joint*e%joints, d_lambda)
        return
      end if
      p = d_lambda*(e%stiffness*s + 1 + e%relaxation*s/(s + r)) + d_joint*e%joints*s
    end associate
    slopes = slopes_from(self, p)
  end function decay_slope_of_mode

  !> Returns their change when the equation changes by p at s.
  pure function slopes_from(self, p) result(slopes)
    type(decay_t), intent(in) :: self
    complex(rp), intent(in) :: p
    real(rp) :: slopes(2)
    complex(rp) :: ds
    ds = -p/slope_of_root(self)
    slopes(1) = real(ds/self%s, rp)
    slopes(2) = -real(ds, rp)/abs(self%s) - self%ratio*slopes(1)
  end function slopes_from
end module solid_decay
