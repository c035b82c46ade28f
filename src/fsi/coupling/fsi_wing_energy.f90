! SPDX-License-Identifier: GPL-3.0-or-later
!> Balances the energy of a wing in the flow, in space, step by step:
!>
!>     T + U + Q = (T + U)(0) + W_hinge + W_load + W_weight
!>
!> with kinetic energy T, elastic energy U, the energy Q lost to damping, and the work of the weight and of the load under which
!> the wing was advanced, sums of F . (x_(n+1) - x_n) over the points. F is (F_n + F_(n+1))/2, or the mean load over the step if
!> that is known. The hinge moves the frame with V and omega. It supplies the missing part of the momentum p and of the angular
!> momentum l about it:
!>
!>     W_hinge = int (dp/dt - F - M g) . V + (dl/dt + V x p - m_F - m_g) . omega dt,
!>
!> all by centred differences and means over the step. Dampers are fixed to the frame. The balance does not use the equation of
!> motion of the wing. It therefore checks the time stepping; the imbalance is O(h^2).
module fsi_wing_energy
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  use fsi_kinematics, only: mirror_wing, wing_pose_t
  use fsi_rotation, only: cross
  use fsi_wing_frame, only: flapping_motion_t
  use fsi_wing_mirror, only: mirror_momenta
  use solid_dynamics, only: dynamic_state_t
  use solid_inertia, only: inertia_t, measure_motion, momenta_t
  use solid_model, only: solid_model_t
  implicit none
  private
  public :: wing_energy_t, energy_meter_t

  !> The data that a restart needs. Work is counted from the first step; powers are means over the last step.
  type, extends(visited_t) :: wing_energy_t
    real(rp) :: start = 0         !< [J] T + U before the first step
    real(rp) :: kinetic = 0       !< [J] now, in space
    real(rp) :: elastic = 0       !< [J] now
    real(rp) :: hinge_work = 0    !< [J] by the hinge on the wing
    real(rp) :: load_work = 0     !< [J] by the flow on the wing
    real(rp) :: weight_work = 0   !< [J]
    real(rp) :: damped = 0        !< [J] lost to damping
    real(rp) :: hinge_power = 0   !< [W] by the hinge on the wing
    real(rp) :: load_power = 0    !< [W] by the flow on the wing
    real(rp) :: weight_power = 0  !< [W]
    real(rp) :: damping_power = 0 !< [W] lost
  contains
    procedure :: imbalance => energy_imbalance
    procedure :: visit => energy_visit
  end type wing_energy_t

  !> A wing in space at one time, SI units.
  type :: snapshot_t
    real(rp), allocatable :: x(:, :), load(:, :)
    !> Along the axes of the wing file: displacements, elastic and viscoelastic forces, elastic forces alone, friction forces of
    !> joints.
    real(rp), allocatable :: u(:, :), g(:, :), elastic_force(:, :), joints(:, :)
    real(rp), dimension(3) :: hinge, velocity, omega, momentum, spin, force, moment, weight, weight_moment
    real(rp) :: kinetic = 0, elastic = 0
  end type snapshot_t

  !> Work space; nothing is allocated after `init`.
  type :: energy_meter_t
    private
    type(snapshot_t) :: snapshots(2)
    logical :: is_mean = .false. !< loads are means over steps
    integer :: last = 0 !< number of the record at the end of the last step; 0: no step yet
  contains
    procedure :: init => meter_init
    procedure :: begin => meter_begin
    procedure :: finish => meter_finish
  end type energy_meter_t

contains

  !> Shows every component to the visitor.
  subroutine energy_visit(self, visitor)
    class(wing_energy_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('start', self%start)
    call visitor%visit('kinetic', self%kinetic)
    call visitor%visit('elastic', self%elastic)
    call visitor%visit('hinge_work', self%hinge_work)
    call visitor%visit('load_work', self%load_work)
    call visitor%visit('weight_work', self%weight_work)
    call visitor%visit('damped', self%damped)
    call visitor%visit('hinge_power', self%hinge_power)
    call visitor%visit('load_power', self%load_power)
    call visitor%visit('weight_power', self%weight_power)
    call visitor%visit('damping_power', self%damping_power)
  end subroutine energy_visit

  !> Returns the energy [J] of the wing in excess of the balance.
  pure real(rp) function energy_imbalance(self) result(excess)
    class(wing_energy_t), intent(in) :: self
    excess = self%kinetic + self%elastic + self%damped - self%start - self%hinge_work - self%load_work - &
             self%weight_work
  end function energy_imbalance

  !> Allocates the work space for this model, whose loads are those at the ends of steps, or means over steps if `is_mean`.
  subroutine meter_init(self, model, is_mean)
    class(energy_meter_t), intent(out) :: self
    type(solid_model_t), intent(in) :: model
    logical, intent(in) :: is_mean
    self%is_mean = is_mean
    call make_room(self%snapshots(1))
    call make_room(self%snapshots(2))

  contains

    subroutine make_room(s)
      type(snapshot_t), intent(inout) :: s
      integer :: n
      n = model%n_all
      allocate (s%x(3, n), s%load(3, n), s%u(3, n), s%g(3, n), s%elastic_force(3, n), s%joints(3, n), source=0.0_rp)
    end subroutine make_room
  end subroutine meter_init

  !> Records the wing before a step, under the load(3, n_all) [N] of the end of the step before; state and load are along the axes
  !> of the wing file. After `finish` its record is used again; only steps may have changed the wing since then.
  subroutine meter_begin(self, model, inertia, motion, state, load, is_first, energy)
    class(energy_meter_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(flapping_motion_t), intent(in) :: motion
    type(dynamic_state_t), intent(in) :: state
    real(rp), intent(in) :: load(:, :)
    logical, intent(in) :: is_first !< the balance begins here
    type(wing_energy_t), intent(inout) :: energy
    if (self%last == 0) then
      self%last = 1
      call observe(model, inertia, motion, state, load, self%snapshots(1))
    end if
    associate (before => self%snapshots(self%last))
      if (is_first) energy%start = before%kinetic + before%elastic
    end associate
  end subroutine meter_begin

  !> Adds the work of the step h [s] since `begin` to `energy`; `load` is the load of this step.
  subroutine meter_finish(self, model, inertia, motion, state, load, h, energy)
    class(energy_meter_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(flapping_motion_t), intent(in) :: motion
    type(dynamic_state_t), intent(in) :: state
    real(rp), intent(in) :: load(:, :), h
    type(wing_energy_t), intent(inout) :: energy
    real(rp) :: du(3), velocity(3), omega(3), push(3), twist(3)
    integer :: p
    call observe(model, inertia, motion, state, load, self%snapshots(3 - self%last))
    energy%load_power = 0
    energy%weight_power = 0
    energy%damping_power = 0
    associate (a => self%snapshots(self%last), b => self%snapshots(3 - self%last))
      if (self%is_mean) then ! in the step before it was another one
        a%load = b%load
        a%force = b%force
        a%moment = 0
        do p = 1, model%n_points
          a%moment = a%moment + cross(a%x(:, p) - a%hinge, a%load(:, p))
        end do
      end if
      do p = 1, model%n_points
        energy%load_power = energy%load_power + dot_product(a%load(:, p) + b%load(:, p), b%x(:, p) - a%x(:, p))/(2*h)
        energy%weight_power = energy%weight_power + inertia%mass(p)*dot_product(motion%gravity, b%x(:, p) - a%x(:, p))/h
      end do
      do p = 1, model%n_all
        du = (b%u(:, p) - a%u(:, p))/h
        energy%damping_power = energy%damping_power + inertia%loss(p, du) + &
                               inertia%rayleigh_stiffness*dot_product(b%elastic_force(:, p) - a%elastic_force(:, p), du)/h
        if (inertia%rubs()) energy%damping_power = energy%damping_power + &
                                                   inertia%joint_friction*dot_product(b%joints(:, p) - a%joints(:, p), du)/h
        ! The work of a relaxing force; it returns a part of this work later.
        if (inertia%relaxation > 0) energy%damping_power = energy%damping_power + &
                                                           0.5_rp*dot_product(a%g(:, p) + b%g(:, p) - a%elastic_force(:, p) - &
                                                                              b%elastic_force(:, p), du)
      end do
      velocity = (a%velocity + b%velocity)/2
      omega = (a%omega + b%omega)/2
      push = (b%momentum - a%momentum)/h - (a%force + b%force)/2 - (a%weight + b%weight)/2
      twist = (b%spin - a%spin)/h + cross(velocity, (a%momentum + b%momentum)/2) - (a%moment + b%moment)/2 &
              - (a%weight_moment + b%weight_moment)/2
      energy%hinge_power = dot_product(push, velocity) + dot_product(twist, omega)
      energy%kinetic = b%kinetic
      energy%elastic = b%elastic
    end associate
    energy%hinge_work = energy%hinge_work + h*energy%hinge_power
    energy%load_work = energy%load_work + h*energy%load_power
    energy%weight_work = energy%weight_work + h*energy%weight_power
    energy%damped = energy%damped + h*energy%damping_power
    self%last = 3 - self%last
  end subroutine meter_finish

  !> Computes energies, momenta and forces of the wing at the time of `state`.
  subroutine observe(model, inertia, motion, state, load, s)
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(flapping_motion_t), intent(in) :: motion
    type(dynamic_state_t), intent(in) :: state
    real(rp), intent(in) :: load(:, :)
    type(snapshot_t), intent(inout) :: s
    type(wing_pose_t) :: pose
    type(momenta_t) :: m
    real(rp) :: place(3), push(3)
    integer :: p
    pose = motion%pose_at(state%time)
    m = measure_motion(inertia, model, motion%at(state%time), state%u, state%v)
    if (motion%is_mirrored) m = mirror_momenta(m)
    s%kinetic = m%kinetic
    s%elastic = m%elastic
    s%momentum = pose%vector_to_space(m%linear)
    s%spin = pose%vector_to_space(m%angular)
    s%weight = m%mass*motion%gravity
    s%weight_moment = cross(pose%vector_to_space(m%centre), s%weight)
    s%hinge = motion%length*pose%hinge
    s%velocity = motion%length*motion%frequency*pose%hinge_velocity
    s%omega = motion%frequency*pose%vector_to_space(pose%omega)
    s%u = state%u
    s%g = state%g
    s%elastic_force = state%g
    if (inertia%relaxation > 0) call model%gradient(state%u, s%elastic_force)
    if (inertia%relaxation > 0) call model%zero_clamped(s%elastic_force)
    if (inertia%rubs()) call inertia%joint_forces(state%u, s%joints)
    s%force = 0
    s%moment = 0
    do p = 1, model%n_points
      place = model%points(:, p) + state%u(:, p)
      push = load(:, p)
      if (motion%is_mirrored) then
        place = mirror_wing(place)
        push = mirror_wing(push)
      end if
      s%x(:, p) = pose%vector_to_space(place)
      s%load(:, p) = pose%vector_to_space(push)
      s%force = s%force + s%load(:, p)
      s%moment = s%moment + cross(s%x(:, p), s%load(:, p))
      s%x(:, p) = s%x(:, p) + s%hinge
    end do
  end subroutine observe
end module fsi_wing_energy
