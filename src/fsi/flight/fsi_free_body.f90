! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the state of a body that flies freely and carries moving masses, advances it in time, and computes its acceleration.
!>
!> The state has the momentum p of everything and its angular momentum h about the body's origin, in space. With force F
!> and moment T about the origin
!>
!>     dp/dt = F,   dh/dt = T - V x p,   dX/dt = V,   dq/dt = q (0, omega)/2,
!>
!> They are advanced by Adams-Bashforth with the weights of the flow (fluid_rhs), q by a rotation with the weighted angular
!> velocity. In the first step F and T have Euler's weights, as in the flow; V and omega are extrapolated to the middle of the step
!> by the accelerations. V and omega then follow from p and h and from the motion of the masses in the body:
!>
!>     p = M V + R'(omega x S + sum mu r'),      R h = S x R V + J omega + sum mu r x r'.
!>
!> This conserves momentum to round-off, including the momentum that is exchanged with the flow: h + X x p, since X and h have the
!> same weights. The scheme is of second order. Degrees of freedom that are held have a reaction: along the axes of space for
!> translations, along the body's axes at the middle of the step for rotations.
!>
!> Equations of motion of a flapping flyer with the inertia of its wings, in another form: Gebert, Gallmeier & Evers 2002,
!> DOI 10.2514/6.2002-4875; quaternions as Maeda et al. 2012 (J. Aero Aqua Bio-mech. 2, 71).
module fsi_free_body
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  use fsi_kinematics, only: body_t
  use fsi_moments, only: cross_matrix, whole_t
  use fsi_quaternion, only: angles_of, matrix_of, turned
  use fsi_rotation, only: cross
  implicit none
  private
  public :: free_body_t, inertia_matrix

  !> Vectors are in space unless stated otherwise; code units with density 1.
  type, extends(visited_t) :: free_body_t
    real(rp) :: centre(3) = 0           !< X, L
    real(rp) :: velocity(3) = 0         !< V, L/T
    real(rp) :: attitude(0:3) = [1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp] !< q
    real(rp) :: omega(3) = 0            !< along the body's axes, 1/T
    real(rp) :: momentum(3) = 0         !< p, rho L^4/T
    real(rp) :: spin(3) = 0             !< h, rho L^5/T
    real(rp) :: old_dt = 0              !< length of the last step, 0 if there was none
    real(rp) :: old_velocity(3) = 0     !< rates at its beginning
    real(rp) :: old_omega(3) = 0
    real(rp) :: old_force(3) = 0
    real(rp) :: old_spin_rate(3) = 0
    real(rp) :: free_momentum(3) = 0    !< p and h without the reactions of this step, until `settle`
    real(rp) :: free_spin(3) = 0
    real(rp) :: turn(3) = 0             !< rotation vector of the last step, along the body's axes, rad
    real(rp) :: acceleration(3) = 0     !< dV/dt of the last `accelerate`, L/T^2
    real(rp) :: omega_rate(3) = 0       !< d omega/dt, along the body's axes, 1/T^2
  contains
    procedure :: start => free_start
    procedure :: advance => free_advance
    procedure :: push => free_push
    procedure :: settle => free_settle
    procedure :: accelerate => free_accelerate
    procedure :: body => free_body
    procedure :: visit => free_visit
  end type free_body_t

contains

  !> Computes p and h from the velocities and from the motion of the masses of `whole`.
  pure subroutine free_start(self, whole)
    class(free_body_t), intent(inout) :: self
    type(whole_t), intent(in) :: whole
    real(rp) :: r(3, 3)
    r = matrix_of(self%attitude)
    self%momentum = whole%mass*self%velocity + matmul(cross(self%omega, whole%first) + whole%first_rate, r)
    self%spin = matmul(cross(whole%first, matmul(r, self%velocity)) + matmul(whole%inertia(), self%omega) + &
                       whole%spin(), r)
    self%old_dt = 0
    self%free_momentum = self%momentum
    self%free_spin = self%spin
  end subroutine free_start

  !> Advances position and attitude to the end of a step dt [T] under `force` [rho L^4/T^2] and `moment` [rho L^5/T^2] about the
  !> origin at its beginning, for which `accelerate` must have been called. `settle` must find the velocities afterwards.
  pure subroutine free_advance(self, dt, force, moment)
    class(free_body_t), intent(inout) :: self
    real(rp), intent(in) :: dt, force(3), moment(3)
    real(rp) :: b10, b11, velocity(3), omega(3), spin_rate(3)
    velocity = self%velocity
    omega = self%omega
    b10 = dt
    b11 = 0
    if (self%old_dt > 0) then
      b10 = dt/self%old_dt*(dt/2 + self%old_dt)
      b11 = -dt**2/(2*self%old_dt)
    else
      velocity = velocity + dt/2*self%acceleration
      omega = omega + dt/2*self%omega_rate
    end if
    spin_rate = moment - cross(velocity, self%momentum)
    self%turn = b10*omega + b11*self%old_omega
    self%centre = self%centre + b10*velocity + b11*self%old_velocity
    self%attitude = turned(self%attitude, self%turn)
    self%free_momentum = self%momentum + b10*force + b11*self%old_force
    self%free_spin = self%spin + b10*spin_rate + b11*self%old_spin_rate
    self%old_dt = dt
    self%old_velocity = self%velocity
    self%old_omega = self%omega
    self%old_force = force
    self%old_spin_rate = moment - cross(self%velocity, self%momentum)
  end subroutine free_advance

  !> Adds an impulse [rho L^4/T] and its moment [rho L^5/T] about the origin to the step that is not yet settled.
  pure subroutine free_push(self, impulse, moment)
    class(free_body_t), intent(inout) :: self
    real(rp), intent(in) :: impulse(3), moment(3)
    self%free_momentum = self%free_momentum + impulse
    self%free_spin = self%free_spin + moment
  end subroutine free_push

  !> Finds the velocities for `whole` at the end of the step, and the reactions of the held degrees of freedom. The call may be
  !> repeated.
  pure subroutine free_settle(self, whole, held)
    class(free_body_t), intent(inout) :: self
    type(whole_t), intent(in) :: whole
    logical, intent(in) :: held(6) !< velocities along x, y, z of space, rotations about x, y, z of the body
    real(rp) :: a(6, 6), b(6), r(3, 3), axes(3, 3), half(0:3), y(6)
    r = matrix_of(self%attitude)
    ! The body's axes at the middle of the step, along those of its end.
    half = turned([1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp], -self%turn/2)
    axes = transpose(matrix_of(half))
    call inertia_matrix(whole, r, a)
    b(1:3) = self%free_momentum - matmul(whole%first_rate, r)
    b(4:6) = matmul(r, self%free_spin) - whole%spin()
    call solve_held(a, b, held, [self%velocity, self%omega], axes, y)
    self%momentum = self%free_momentum
    self%spin = self%free_spin
    where (held(:3))
      self%momentum = self%free_momentum + y(:3)
    elsewhere
      self%velocity = y(:3)
    end where
    self%spin = self%free_spin + matmul(matmul(axes, merge(y(4:), 0.0_rp, held(4:))), r)
    where (.not. held(4:)) self%omega = y(4:)
  end subroutine free_settle

  !> Finds the accelerations under `force` and `moment` about the origin, for the present place and motion of the body.
  pure subroutine free_accelerate(self, whole, held, force, moment)
    class(free_body_t), intent(inout) :: self
    type(whole_t), intent(in) :: whole
    logical, intent(in) :: held(6)
    real(rp), intent(in) :: force(3), moment(3)
    real(rp), parameter :: AXES(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])
    real(rp) :: a(6, 6), b(6), r(3, 3), y(6), zero(6)
    r = matrix_of(self%attitude)
    call inertia_matrix(whole, r, a)
    associate (w => self%omega, s => whole)
      b(1:3) = force - matmul(cross(w, cross(w, s%first)) + 2*cross(w, s%first_rate) + s%first_rate2, r)
      b(4:6) = matmul(r, moment) - cross(w, matmul(s%inertia(), w)) - 2*s%coriolis(w) - s%spin_rate()
    end associate
    zero = 0
    call solve_held(a, b, held, zero, AXES, y)
    self%acceleration = merge(0.0_rp, y(:3), held(:3))
    self%omega_rate = merge(0.0_rp, y(4:), held(4:))
  end subroutine free_accelerate

  !> Returns the matrix that maps V (in space) and omega (in the body) to the momentum (in space) and the angular momentum (in the
  !> body).
  pure subroutine inertia_matrix(whole, r, a)
    type(whole_t), intent(in) :: whole
    real(rp), intent(in) :: r(3, 3)
    real(rp), intent(out) :: a(6, 6)
    real(rp) :: lever(3, 3)
    integer :: i
    lever = cross_matrix(whole%first)
    a = 0
    do i = 1, 3
      a(i, i) = whole%mass
    end do
    a(1:3, 4:6) = -matmul(transpose(r), lever)
    a(4:6, 1:3) = matmul(lever, r)
    a(4:6, 4:6) = whole%inertia()
  end subroutine inertia_matrix

  !> Solves a y = b for the components that are free; those that are held have `given`, and y has their reactions, which
  !> act along space and, in rotation, along `axes`.
  pure subroutine solve_held(a, b, held, given, axes, y)
    real(rp), intent(inout) :: a(6, 6), b(6)
    logical, intent(in) :: held(6)
    real(rp), intent(in) :: given(6), axes(3, 3)
    real(rp), intent(out) :: y(6)
    integer :: i
    do i = 1, 6
      if (.not. held(i)) cycle
      b = b - a(:, i)*given(i)
      a(:, i) = 0
      if (i <= 3) then
        a(i, i) = -1
      else
        a(4:, i) = -axes(:, i - 3)
      end if
    end do
    call eliminate(a, b, y)
  end subroutine solve_held

  !> Solves linear equations by Gauss' elimination with row pivots. A singular matrix gives numbers that are not finite.
  pure subroutine eliminate(a, b, y)
    real(rp), intent(inout) :: a(6, 6), b(6)
    real(rp), intent(out) :: y(6)
    real(rp) :: row(6), swap
    integer :: i, j, p
    do i = 1, 6
      p = i - 1 + maxloc(abs(a(i:, i)), 1)
      row = a(i, :)
      a(i, :) = a(p, :)
      a(p, :) = row
      swap = b(i)
      b(i) = b(p)
      b(p) = swap
      do j = i + 1, 6
        swap = a(j, i)/a(i, i)
        a(j, i:) = a(j, i:) - swap*a(i, i:)
        b(j) = b(j) - swap*b(i)
      end do
    end do
    do i = 6, 1, -1
      y(i) = (b(i) - dot_product(a(i, i + 1:), y(i + 1:)))/a(i, i)
    end do
  end subroutine eliminate

  !> Returns the moving frame of the body.
  pure type(body_t) function free_body(self) result(body)
    class(free_body_t), intent(in) :: self
    body%centre = self%centre
    body%velocity = self%velocity
    body%acceleration = self%acceleration
    body%angles = angles_of(self%attitude)
    body%rotation%matrix = matrix_of(self%attitude)
    body%rotation%omega = self%omega
    body%rotation%omega_rate = self%omega_rate
  end function free_body

  !> Shows to the visitor the components that a restart needs. The others belong to the present step.
  subroutine free_visit(self, visitor)
    class(free_body_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('centre', self%centre)
    call visitor%visit('velocity', self%velocity)
    call visitor%visit('attitude', self%attitude)
    call visitor%visit('omega', self%omega)
    call visitor%visit('momentum', self%momentum)
    call visitor%visit('spin', self%spin)
    call visitor%visit('old_dt', self%old_dt)
    call visitor%visit('old_velocity', self%old_velocity)
    call visitor%visit('old_omega', self%old_omega)
    call visitor%visit('old_force', self%old_force)
    call visitor%visit('old_spin_rate', self%old_spin_rate)
    call visitor%leave_out('free_momentum free_spin turn acceleration omega_rate')
    if (.not. visitor%is_reading) return
    self%free_momentum = self%momentum
    self%free_spin = self%spin
  end subroutine free_visit
end module fsi_free_body
