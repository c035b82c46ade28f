! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes small free motion of a wing about its unloaded shape, in its lowest natural modes, and the exact derivatives of this
!> motion.
!>
!> With displacements u = Phi q of the modes of solid_modal (Phi^T M Phi = 1, Phi^T K Phi = Lambda) and forces of damping
!> (solid_damping_effects),
!>
!>     q'' + D q' + Lambda q + g Lambda z = f,   z' = q' - z/tau,   D = alpha + beta Lambda + theta J,   J = Phi^T K_joints Phi.
!>
!> The states are e = Omega q, p = q' and Omega z, with Omega^2 = Lambda, followed by the states of a filter of the observations, y
!> = L q or L q', and by the states of an input (base_linear_flow, which has no error in time). Filters: the first order y_f' = c (y
!> - y_f), or Butterworth's second order, c = 2 pi times the cut-off. Drag with the square of the speed, if there is any, adds to f
!> (solid_dragged_flow). A motion of the base that was not recorded adds two states, its sine and cosine.
!>
!> A change of stiffness or mass changes the modes. To first order, they then span the space of Phi + W with W M-orthogonal to Phi
!> (W of solid_modal if all modes form one cluster). In this basis the changes of the matrices are Phi^T dK Phi and Phi^T dM Phi, as
!> for a fixed basis, and no denominator contains a difference of frequencies.
module solid_ringing
  use base_kinds, only: rp
  use base_linear_flow, only: linear_flow_t
  use solid_damping_effects, only: damping_effects_t, DAMPING_DRAG, DAMPING_JOINTS, DAMPING_MASS, DAMPING_STIFFNESS, DAMPING_TIME
  use solid_dragged_flow, only: drag_change_t, drag_t, dragged_flow_t
  implicit none
  private
  public :: ringing_t, ring_change_t, shake_t

  integer, parameter, public :: EXCITED_RELEASE = 1, EXCITED_TAP = 2, EXCITED_BASE = 3

  !> Parts of a motion of the base: amplitudes of the sine and the cosine, and the logarithm of the rate.
  integer, parameter, public :: SHAKE_SINE = 1, SHAKE_COSINE = 2, SHAKE_RATE = 3

  !> A motion of the base after the excitation: its acceleration along z is amplitude(1) sin(rate t) + amplitude(2) cos(rate t).
  type :: shake_t
    integer :: record = 0           !< number of the record that has it; 0: none
    real(rp) :: rate = 1            !< [rad/s]
    real(rp) :: amplitude(2) = 0    !< [m/s^2]
  end type shake_t

  !> Change of the reduced equations by one parameter; arrays of size 0 are zero.
  type :: ring_change_t
    real(rp), allocatable :: stiffness(:, :)  !< (r, r) Phi^T dK Phi
    real(rp), allocatable :: mass(:, :)       !< (r, r) Phi^T dM Phi
    real(rp), allocatable :: joints(:, :)     !< (r, r) dJ
    real(rp), allocatable :: observation(:, :)       !< (seen, r) dL
    real(rp), allocatable :: forcing(:)          !< (r) of the excitation
    real(rp), allocatable :: across(:, :)     !< (points, r) of drag_t
    real(rp), allocatable :: shaken(:)        !< (r) of ringing_t
    integer :: damping = 0                    !< number of the damping effect that changes; 0: none
    integer :: shake = 0                      !< part of the motion of the base that changes; 0: none
  end type ring_change_t

  !> The flows from sample to sample and to the first sample, without and with drag.
  type :: flows_t
    type(linear_flow_t) :: linear, first
    type(dragged_flow_t) :: dragged, dragged_first
  end type flows_t

  !> One record. After `run` the result is seen(samples, places).
  type :: ringing_t
    integer :: excitation = EXCITED_RELEASE
    logical :: sees_velocity = .false.
    real(rp) :: interval = 0, start = 0       !< [s] between samples; of the first one after the excitation
    real(rp) :: cutoff = 0                    !< [rad/s] of the filter; 0: none
    integer :: order = 1
    type(drag_t) :: drag                      !< none if its arrays are not allocated
    type(shake_t) :: shake
    real(rp), allocatable :: shaken(:)        !< (r) minus the inertia along z of the modes; not allocated: no motion of the base
    real(rp), allocatable :: seen(:, :), rate(:, :) !< (samples, seen) for unit excitation, and their derivatives in time
    real(rp), allocatable :: second(:, :)     !< (samples, seen) their second derivatives
    integer, private :: r = 0, m = 0, n = 0   !< modes, places, states
    real(rp), allocatable, private :: omega(:), joints(:, :), observation(:, :), forcing(:), input(:), x(:, :), begin(:), a(:, :)
    type(damping_effects_t), private :: damping
    type(flows_t), private :: flows
  contains
    procedure :: run => ringing_run
    procedure :: tangent => ringing_tangent
    procedure, private :: matrix => ringing_matrix
    procedure, private :: output => ringing_output
    procedure, private :: move => ringing_move
  end type ringing_t

contains

  !> Computes `samples` samples of the motion of modes with lambda(r), J and L = observation(seen, r). forcing(r) is the unit
  !> excitation: Phi^T times the released force, times the impulse, or times minus the inertia per acceleration of the base. The
  !> record of that acceleration is input(:), one number in each interval; a driven motion starts from rest.
  subroutine ringing_run(self, lambda, joints, observation, forcing, damping, samples, input)
    class(ringing_t), intent(inout) :: self
    real(rp), intent(in) :: lambda(:), joints(:, :), observation(:, :), forcing(:), input(:)
    type(damping_effects_t), intent(in) :: damping
    integer, intent(in) :: samples
    integer :: f
    logical :: is_driven
    self%r = size(lambda)
    self%m = size(observation, 1)
    self%omega = sqrt(lambda)
    self%joints = joints
    self%observation = observation
    self%forcing = forcing
    self%damping = damping
    self%input = input
    is_driven = self%excitation == EXCITED_BASE
    f = merge(self%order*self%m, 0, self%cutoff > 0)
    self%n = 3*self%r + f + merge(2, 0, is_driven .or. allocated(self%shaken))
    call self%matrix(self%a)
    if (allocated(self%x)) deallocate (self%x)
    allocate (self%x(self%n, samples), source=0.0_rp)
    self%begin = spread(0.0_rp, 1, self%n)
    select case (self%excitation)
    case (EXCITED_RELEASE)
      self%begin(:self%r) = forcing/self%omega
      ! Before the release the filter is in its steady state for the bent wing at rest.
      if (f > 0 .and. .not. self%sees_velocity) self%begin(3*self%r + 1:3*self%r + self%m) = matmul(observation, forcing/lambda)
    case (EXCITED_TAP)
      self%begin(self%r + 1:2*self%r) = forcing
    end select
    if (allocated(self%shaken)) self%begin(self%n) = 1
    call self%move(is_driven)
  end subroutine ringing_run

  !> Computes the states, the observations and their derivatives in time from the first state.
  subroutine ringing_move(self, is_driven)
    class(ringing_t), intent(inout) :: self
    logical, intent(in) :: is_driven
    real(rp) :: change(self%n, size(self%x, 2)), second(self%n, size(self%x, 2)), ends(self%n, 2), f(self%r)
    type(drag_change_t) :: still
    integer :: k
    ends(:, 1) = self%begin
    ends(:, 2) = self%begin
    if (.not. allocated(self%drag%across)) then
      call self%flows%first%init(self%a, self%start, is_driven)
      self%x(:, 1) = matmul(self%flows%first%step, self%begin)
      call self%flows%linear%init(self%a, self%interval, is_driven)
      call self%flows%linear%march(self%x, self%input)
    else
      call self%flows%dragged_first%init(self%a, self%r, self%start, self%interval, .false.)
      if (self%start > 0) call self%flows%dragged_first%march(self%drag, ends, self%input)
      self%x(:, 1) = ends(:, 2)
      call self%flows%dragged%init(self%a, self%r, self%interval, self%interval, is_driven)
      call self%flows%dragged%march(self%drag, self%x, self%input)
    end if
    change = matmul(self%a, self%x)
    second = 0
    if (allocated(self%drag%across)) then
      allocate (still%across(0, 0), still%mass(0, 0))
      associate (p => self%r + 1, q => 2*self%r)
        do k = 1, size(self%x, 2)
          f = self%drag%force(self%x(p:q, k))
          change(p:q, k) = change(p:q, k) + f
          second(p:q, k) = self%drag%slope(still, self%x(p:q, k), change(p:q, k), f)
        end do
      end associate
    end if
    second = second + matmul(self%a, change)
    self%seen = self%output(self%x)
    self%rate = self%output(change)
    self%second = self%output(second)
  end subroutine ringing_move

  !> Makes the matrix A of the equations.
  subroutine ringing_matrix(self, a)
    class(ringing_t), intent(in) :: self
    real(rp), allocatable, intent(out) :: a(:, :)
    integer :: i, j, k, r
    r = self%r
    allocate (a(self%n, self%n), source=0.0_rp)
    associate (d => self%damping, w => self%omega)
      do i = 1, r
        a(i, r + i) = w(i)
        a(r + i, i) = -w(i)
        a(r + i, r + i) = -(d%mass + d%stiffness*w(i)**2)
        a(r + i, 2*r + i) = -d%relaxation*w(i)
        a(2*r + i, r + i) = w(i)
        a(2*r + i, 2*r + i) = -1/d%relaxation_time
      end do
      a(r + 1:2*r, r + 1:2*r) = a(r + 1:2*r, r + 1:2*r) - d%joints*self%joints
      if (self%cutoff > 0) then
        do j = 1, self%m
          k = 3*r + j
          i = k + (self%order - 1)*self%m ! the observations enter here
          if (self%order == 1) then
            a(k, k) = -self%cutoff
          else
            a(k, i) = self%cutoff
            a(i, k) = -self%cutoff
            a(i, i) = -sqrt(2.0_rp)*self%cutoff
          end if
          if (self%sees_velocity) then
            a(i, r + 1:2*r) = self%cutoff*self%observation(j, :)
          else
            a(i, :r) = self%cutoff*self%observation(j, :)/w
          end if
        end do
      end if
      if (self%excitation == EXCITED_BASE) then
        a(r + 1:2*r, self%n - 1) = self%forcing
        a(self%n - 1, self%n) = 1/self%interval
      end if
      if (allocated(self%shaken)) then ! the last states are sine and cosine
        a(r + 1:2*r, self%n - 1) = self%shake%amplitude(1)*self%shaken
        a(r + 1:2*r, self%n) = self%shake%amplitude(2)*self%shaken
        a(self%n - 1, self%n) = self%shake%rate
        a(self%n, self%n - 1) = -self%shake%rate
      end if
    end associate
  end subroutine ringing_matrix

  !> Returns the observations of states x(n, samples).
  function ringing_output(self, x) result(seen)
    class(ringing_t), intent(in) :: self
    real(rp), intent(in) :: x(:, :)
    real(rp), allocatable :: seen(:, :)
    if (self%cutoff > 0) then
      seen = transpose(x(3*self%r + 1:3*self%r + self%m, :))
    else
      seen = observed(self, self%observation, x)
    end if
  end function ringing_output

  !> Returns the same of an unfiltered observation(seen, r).
  function observed(self, observation, x) result(seen)
    class(ringing_t), intent(in) :: self
    real(rp), intent(in) :: observation(:, :), x(:, :)
    real(rp), allocatable :: seen(:, :)
    if (self%sees_velocity) then
      seen = transpose(matmul(observation, x(self%r + 1:2*self%r, :)))
    else
      seen = transpose(matmul(observation/spread(self%omega, 1, size(observation, 1)), x(:self%r, :)))
    end if
  end function observed

  !> Returns seen(samples, places), the derivative of the observations, after `run`.
  subroutine ringing_tangent(self, change, seen)
    class(ringing_t), intent(in) :: self
    type(ring_change_t), intent(in) :: change
    real(rp), allocatable, intent(out) :: seen(:, :)
    real(rp) :: da(self%n, self%n), dx(self%n, size(self%x, 2)), ends(self%n, 2), begin(self%n, 2)
    type(drag_change_t) :: of_drag
    call differentiate(self, change, da)
    begin = 0
    call differentiate_begin(self, change, begin(:, 1))
    if (.not. allocated(self%drag%across)) then
      ends(:, 1) = self%begin
      ends(:, 2) = self%x(:, 1)
      call self%flows%first%tangent(da, ends, begin)
      dx(:, 1) = begin(:, 2)
      call self%flows%linear%tangent(da, self%x, dx)
    else
      of_drag%strength = merge(1.0_rp, 0.0_rp, change%damping == DAMPING_DRAG)
      of_drag%across = change%across
      of_drag%mass = change%mass
      dx(:, 1) = begin(:, 1)
      if (self%start > 0) call self%flows%dragged_first%tangent(self%drag, da, of_drag, begin)
      if (self%start > 0) dx(:, 1) = begin(:, 2)
      call self%flows%dragged%tangent(self%drag, da, of_drag, dx)
    end if
    seen = self%output(dx)
    if (size(change%observation) > 0 .and. .not. self%cutoff > 0) seen = seen + observed(self, change%observation, self%x)
  end subroutine ringing_tangent

  !> Returns da(n, n), the derivative of A.
  subroutine differentiate(self, change, da)
    class(ringing_t), intent(in) :: self
    type(ring_change_t), intent(in) :: change
    real(rp), intent(out) :: da(:, :)
    real(rp) :: slow(self%r, self%r)
    integer :: k, r
    r = self%r
    da = 0
    call differentiate_damping(self, change%damping, da)
    call differentiate_observation(self, change%observation, da)
    if (allocated(self%shaken)) call differentiate_shake(self, change, da)
    associate (d => self%damping, w => self%omega, rows => da(r + 1:2*r, :))
      if (size(change%stiffness) > 0) then
        do k = 1, r
          rows(:, k) = -change%stiffness(:, k)/w(k)
          rows(:, r + k) = -d%stiffness*change%stiffness(:, k)
          rows(:, 2*r + k) = -d%relaxation*change%stiffness(:, k)/w(k)
        end do
      end if
      if (size(change%joints) > 0) rows(:, r + 1:2*r) = rows(:, r + 1:2*r) - d%joints*change%joints
      if (size(change%mass) > 0) then
        slow = d%joints*self%joints
        do k = 1, r
          slow(k, k) = slow(k, k) + d%stiffness*w(k)**2
          rows(:, k) = rows(:, k) + change%mass(:, k)*w(k)
          rows(:, 2*r + k) = rows(:, 2*r + k) + d%relaxation*change%mass(:, k)*w(k)
        end do
        rows(:, r + 1:2*r) = rows(:, r + 1:2*r) + matmul(change%mass, slow)
        if (self%excitation == EXCITED_BASE) rows(:, self%n - 1) = rows(:, self%n - 1) - matmul(change%mass, self%forcing)
      end if
      if (self%excitation == EXCITED_BASE .and. size(change%forcing) > 0) &
        rows(:, self%n - 1) = rows(:, self%n - 1) + change%forcing
    end associate
  end subroutine differentiate

  !> Adds to it the derivative with respect to effect `number` of the damping; 0: none.
  subroutine differentiate_damping(self, number, da)
    class(ringing_t), intent(in) :: self
    integer, intent(in) :: number
    real(rp), intent(inout) :: da(:, :)
    integer :: k, r
    r = self%r
    do k = 1, r
      select case (number)
      case (0, DAMPING_DRAG)
        exit
      case (DAMPING_MASS)
        da(r + k, r + k) = -1
      case (DAMPING_STIFFNESS)
        da(r + k, r + k) = -self%omega(k)**2
      case (DAMPING_JOINTS)
        da(r + k, r + 1:2*r) = -self%joints(k, :)
      case (DAMPING_TIME)
        da(2*r + k, 2*r + k) = 1/self%damping%relaxation_time
      case default
        da(r + k, 2*r + k) = -self%omega(k)
      end select
    end do
  end subroutine differentiate_damping

  !> Adds to it the derivative of the motion of the base.
  subroutine differentiate_shake(self, change, da)
    class(ringing_t), intent(in) :: self
    type(ring_change_t), intent(in) :: change
    real(rp), intent(inout) :: da(:, :)
    real(rp) :: slope(self%r)
    associate (rows => da(self%r + 1:2*self%r, :), n => self%n, shake => self%shake)
      select case (change%shake)
      case (SHAKE_SINE)
        rows(:, n - 1) = self%shaken
      case (SHAKE_COSINE)
        rows(:, n) = self%shaken
      case (SHAKE_RATE)
        da(n - 1, n) = shake%rate
        da(n, n - 1) = -shake%rate
      end select
      slope = 0
      if (size(change%shaken) > 0) slope = change%shaken
      if (size(change%mass) > 0) slope = slope - matmul(change%mass, self%shaken)
      rows(:, n - 1) = rows(:, n - 1) + shake%amplitude(1)*slope
      rows(:, n) = rows(:, n) + shake%amplitude(2)*slope
    end associate
  end subroutine differentiate_shake

  !> Adds to it the derivative of the input of a filter.
  subroutine differentiate_observation(self, observation, da)
    class(ringing_t), intent(in) :: self
    real(rp), intent(in) :: observation(:, :)
    real(rp), intent(inout) :: da(:, :)
    integer :: j, i, r
    if (.not. self%cutoff > 0 .or. size(observation) == 0) return
    r = self%r
    do j = 1, self%m
      i = 3*r + j + (self%order - 1)*self%m
      if (self%sees_velocity) then
        da(i, r + 1:2*r) = self%cutoff*observation(j, :)
      else
        da(i, :r) = self%cutoff*observation(j, :)/self%omega
      end if
    end do
  end subroutine differentiate_observation

  !> Returns the derivative of the states with which a motion begins.
  subroutine differentiate_begin(self, change, begin)
    class(ringing_t), intent(in) :: self
    type(ring_change_t), intent(in) :: change
    real(rp), intent(inout) :: begin(:)
    real(rp) :: q(self%r), forcing(self%r)
    integer :: r
    r = self%r
    forcing = 0
    if (size(change%forcing) > 0) forcing = change%forcing
    select case (self%excitation)
    case (EXCITED_RELEASE)
      q = forcing
      if (size(change%stiffness) > 0) q = q - matmul(change%stiffness, self%forcing/self%omega**2)
      q = q/self%omega**2
      begin(:r) = self%omega*q
      if (self%cutoff > 0 .and. .not. self%sees_velocity) then
        begin(3*r + 1:3*r + self%m) = matmul(self%observation, q)
        if (size(change%observation) > 0) begin(3*r + 1:3*r + self%m) = begin(3*r + 1:3*r + self%m) + &
                                                                 matmul(change%observation, self%forcing/self%omega**2)
      end if
    case (EXCITED_TAP)
      begin(r + 1:2*r) = forcing
      if (size(change%mass) > 0) begin(r + 1:2*r) = forcing - matmul(change%mass, self%forcing)
    end select
  end subroutine differentiate_begin
end module solid_ringing
