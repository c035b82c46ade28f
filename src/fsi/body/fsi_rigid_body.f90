! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a rigid solid made of shapes, in its frame: chi is the largest chi of its parts.
!>
!> Its moments int chi dV, int chi x dV, int chi x x^T dV are sums over points of its frame with a distance of half the smoothing.
!> With these moments, the momentum of the fluid in the mask follows from the motion of the frame.
module fsi_rigid_body
  use base_kinds, only: rp
  use fsi_kinematics, only: body_t
  use fsi_moments, only: inertia_of_second, moments_t
  use fsi_rotation, only: cross
  use fsi_solid_shape, only: shape_holder_t
  implicit none
  private
  public :: rigid_body_t

  !> Lengths in L.
  type :: rigid_body_t
    type(shape_holder_t), allocatable :: parts(:) !< not allocated: no body
    real(rp) :: low(3) = 0, high(3) = 0           !< its box, without smoothing
    real(rp) :: smoothing = 0                     !< half the width of the smoothing layer
    type(moments_t) :: displaced                  !< of the fluid in its mask, rho = 1
  contains
    procedure :: init => body_init
    procedure :: exists => body_exists
    procedure :: mask_at => body_mask_at
    procedure :: momentum_rate => body_momentum_rate
    procedure :: power_of_fluid => body_power_of_fluid
    procedure :: max_speed => body_max_speed
  end type rigid_body_t

contains

  !> Takes over the `parts`, at least one.
  subroutine body_init(self, parts, smoothing)
    class(rigid_body_t), intent(inout) :: self
    type(shape_holder_t), allocatable, intent(inout) :: parts(:)
    real(rp), intent(in) :: smoothing
    integer :: i
    call move_alloc(parts, self%parts)
    self%smoothing = smoothing
    self%low = huge(1.0_rp)
    self%high = -huge(1.0_rp)
    do i = 1, size(self%parts)
      self%low = min(self%low, self%parts(i)%shape%low)
      self%high = max(self%high, self%parts(i)%shape%high)
    end do
    call find_moments(self)
  end subroutine body_init

  !> Finds the volume that the body displaces, and its first and second moments.
  subroutine find_moments(self)
    type(rigid_body_t), intent(inout) :: self
    real(rp) :: x(3), step, volume
    integer :: first(3), last(3), i, j, k, c
    step = self%smoothing/2
    first = floor((self%low - self%smoothing)/step)
    last = ceiling((self%high + self%smoothing)/step)
    associate (m => self%displaced)
      m = moments_t()
      do k = first(3), last(3)
        do j = first(2), last(2)
          do i = first(1), last(1)
            x = [i, j, k]*step
            volume = self%mask_at(x)*step**3
            m%mass = m%mass + volume
            m%first = m%first + volume*x
            do c = 1, 3
              m%second(:, c) = m%second(:, c) + volume*x*x(c)
            end do
          end do
        end do
      end do
    end associate
  end subroutine find_moments

  !> Tells whether there is a body at all.
  pure logical function body_exists(self) result(exists)
    class(rigid_body_t), intent(in) :: self
    exists = allocated(self%parts)
  end function body_exists

  !> Returns chi, 0 to 1, at x [L] in the frame of the body.
  pure real(rp) function body_mask_at(self, x) result(chi)
    class(rigid_body_t), intent(in) :: self
    real(rp), intent(in) :: x(3)
    integer :: i
    chi = 0
    do i = 1, size(self%parts)
      if (self%parts(i)%shape%is_near(x, self%smoothing)) &
        chi = max(chi, self%parts(i)%shape%mask_at(x, self%smoothing))
    end do
  end function body_mask_at

  !> Adds d/dt int chi u_s dV and d/dt int chi (x - centre) x u_s dV of the fluid in the mask of the body in `frame`.
  pure subroutine body_momentum_rate(self, frame, centre, force, moment)
    class(rigid_body_t), intent(in) :: self
    type(body_t), intent(in) :: frame
    real(rp), intent(in) :: centre(3)
    real(rp), intent(inout) :: force(3), moment(3)
    real(rp) :: a(3), rate(3), spin(3)
    associate (m => self%displaced, r => frame%rotation)
      a = r%to_frame(frame%acceleration)
      rate = r%to_parent(m%mass*a + cross(r%omega_rate, m%first) + cross(r%omega, cross(r%omega, m%first)))
      spin = matmul(inertia_of_second(m%second), r%omega_rate) + cross(matmul(m%second, r%omega), r%omega) + &
             cross(m%first, a)
      force = force + rate
      moment = moment + r%to_parent(spin) + cross(frame%centre - centre, rate)
    end associate
  end subroutine body_momentum_rate

  !> Returns d/dt int chi u_s^2/2 dV [rho L^5/T^3] of the fluid in the mask of the body.
  pure real(rp) function body_power_of_fluid(self, frame) result(power)
    class(rigid_body_t), intent(in) :: self
    type(body_t), intent(in) :: frame
    real(rp) :: force(3), moment(3)
    force = 0
    moment = 0
    call self%momentum_rate(frame, frame%centre, force, moment)
    power = dot_product(frame%velocity, force) + dot_product(frame%rotation%omega, frame%rotation%to_frame(moment))
  end function body_power_of_fluid

  !> Returns a bound [L/T] of |u_s| in the body.
  pure real(rp) function body_max_speed(self, frame) result(speed)
    class(rigid_body_t), intent(in) :: self
    type(body_t), intent(in) :: frame
    speed = norm2(frame%velocity) + norm2(frame%rotation%omega)*norm2(max(abs(self%low), abs(self%high)))
  end function body_max_speed
end module fsi_rigid_body
