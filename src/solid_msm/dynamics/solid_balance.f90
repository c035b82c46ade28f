! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the energy balance of a wing's motion in its own frame, step by step:
!>
!>     T + U = (T + U)(0) + W_loads + W_weight + W_frame - Q
!>
!> with the kinetic energy T of the motion within the frame, the elastic energy U, the work of the external forces, of the weight
!> and of the fictitious forces -m (a + alpha x r + omega x (omega x r)) of the moving frame (the Coriolis force does no work),
!> and the loss Q to damping. Over a step from n to n+1 a force does the work (F_n + F_(n+1))/2 . (u_(n+1) - u_n), second order in
!> the step like the motion itself. The imbalance is therefore O(h^2): it is the energy that the time stepping loses.
module solid_balance
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  use solid_dynamic_state, only: dynamic_state_t
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  use solid_motion, only: frame_t
  use solid_vectors, only: cross
  implicit none
  private
  public :: work_t, balance_t

  !> Data of the balance that a restart needs: sums since time 0.
  type, extends(visited_t) :: work_t
    real(rp) :: start = 0      !< [J] T + U at time 0
    real(rp) :: loads = 0      !< [J] by external forces
    real(rp) :: weight = 0     !< [J]
    real(rp) :: frame = 0      !< [J] by the fictitious forces
    real(rp) :: damped = 0     !< [J] lost to damping
  contains
    procedure :: visit => work_visit
    procedure :: imbalance => work_imbalance
  end type work_t

  !> Forces and displacements at the beginning of a step; nothing is allocated after `init`.
  type :: balance_t
    private
    real(rp), dimension(:, :), allocatable :: u, g, force, weight, apparent, new_weight, new_apparent, elastic, new_elastic, &
                                              joints, new_joints
  contains
    procedure :: init => balance_init
    procedure :: record => balance_record
    procedure :: add_step => balance_add_step
  end type balance_t

contains

  !> Shows every component to the visitor.
  subroutine work_visit(self, visitor)
    class(work_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('start', self%start)
    call visitor%visit('loads', self%loads)
    call visitor%visit('weight', self%weight)
    call visitor%visit('frame', self%frame)
    call visitor%visit('damped', self%damped)
  end subroutine work_visit

  !> Returns the energy of the wing in excess of the balance [J]. `energy` is the present T + U [J]. The result is 0 for a balance
  !> that is closed, and O(h^2) for steps of length h.
  pure real(rp) function work_imbalance(self, energy) result(excess)
    class(work_t), intent(in) :: self
    real(rp), intent(in) :: energy
    excess = energy - self%start - self%loads - self%weight - self%frame + self%damped
  end function work_imbalance

  !> Allocates the work space for this model.
  subroutine balance_init(self, model)
    class(balance_t), intent(out) :: self
    type(solid_model_t), intent(in) :: model
    integer :: n
    n = model%n_all
    allocate (self%u(3, n), self%g(3, n), self%force(3, n), self%weight(3, n), self%apparent(3, n), &
              self%new_weight(3, n), self%new_apparent(3, n), self%elastic(3, n), self%new_elastic(3, n), &
              self%joints(3, n), self%new_joints(3, n), source=0.0_rp)
  end subroutine balance_init

  !> Records the state at the beginning of a step, in this frame, under the external forces force(3, n_all) [N].
  subroutine balance_record(self, model, inertia, frame, state, force)
    class(balance_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(frame_t), intent(in) :: frame
    type(dynamic_state_t), intent(in) :: state
    real(rp), intent(in) :: force(:, :)
    self%u = state%u
    self%g = state%g
    self%force = force
    call evaluate(model, inertia, frame, state%u, self%weight, self%apparent)
    self%elastic = state%g
    if (inertia%relaxation > 0) call model%gradient(state%u, self%elastic)
    if (inertia%rubs()) call inertia%joint_forces(state%u, self%joints)
  end subroutine balance_record

  !> Adds to `work` the work done in the step of h [s] that began at the last `record`. `frame`, `state` and force(3, n_all) [N]
  !> are those at its end.
  subroutine balance_add_step(self, model, inertia, frame, state, force, h, work)
    class(balance_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(frame_t), intent(in) :: frame
    type(dynamic_state_t), intent(in) :: state
    real(rp), intent(in) :: force(:, :), h
    type(work_t), intent(inout) :: work
    real(rp) :: du(3), loads, weight, apparent, damped
    integer :: i, p
    call evaluate(model, inertia, frame, state%u, self%new_weight, self%new_apparent)
    self%new_elastic = state%g
    if (inertia%relaxation > 0) call model%gradient(state%u, self%new_elastic)
    if (inertia%rubs()) call inertia%joint_forces(state%u, self%new_joints)
    loads = 0
    weight = 0
    apparent = 0
    damped = 0
    do i = 1, model%n_free
      p = model%movable(i)
      du = state%u(:, p) - self%u(:, p)
      loads = loads + dot_product(self%force(:, p) + force(:, p), du)
      weight = weight + dot_product(self%weight(:, p) + self%new_weight(:, p), du)
      apparent = apparent + dot_product(self%apparent(:, p) + self%new_apparent(:, p), du)
      damped = damped + h*inertia%loss(p, du/h) + &
               inertia%rayleigh_stiffness*dot_product(self%new_elastic(:, p) - self%elastic(:, p), du)/h
      if (inertia%rubs()) damped = damped + inertia%joint_friction*dot_product(self%new_joints(:, p) - self%joints(:, p), du)/h
      ! The work of a relaxing force; it returns a part of this work later.
      if (inertia%relaxation > 0) damped = damped + 0.5_rp*dot_product(state%g(:, p) + self%g(:, p) - self%elastic(:, p) - &
                                                                      self%new_elastic(:, p), du)
    end do
    work%loads = work%loads + 0.5_rp*loads
    work%weight = work%weight + 0.5_rp*weight
    work%frame = work%frame + 0.5_rp*apparent
    work%damped = work%damped + damped
  end subroutine balance_add_step

  !> Computes weight and fictitious forces [N] of all movable points.
  pure subroutine evaluate(model, inertia, frame, u, weight, apparent)
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(inout) :: weight(:, :), apparent(:, :)
    real(rp) :: x(3)
    integer :: i, p
    do i = 1, model%n_free
      p = model%movable(i)
      x = model%points(:, p) + u(:, p)
      weight(:, p) = inertia%mass(p)*frame%gravity
      apparent(:, p) = -inertia%mass(p)*(frame%acceleration + cross(frame%alpha, x) &
                                         + cross(frame%omega, cross(frame%omega, x)))
    end do
  end subroutine evaluate
end module solid_balance
