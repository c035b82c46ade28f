! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the records of a vibrating wing: residuals in units of their sd, and their exact derivatives.
!>
!> The wing makes small motions about its flat unloaded shape, in its N_MODES lowest modes; in air, its membrane carries the added
!> mass of strip theory, and meets with the drag of the air. The motion that a release excites in higher modes is not computed.
module measurement_series_simulation
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use measurement_data, only: measurement_t
  use measurement_modes, only: MEDIUM_AIR
  use measurement_material_point, only: find_material_point, material_point_t
  use measurement_motion_simulation, only: motion_simulation_t
  use measurement_series, only: measured_series_t
  use measurement_series_projections, only: forcing_vector, inertia_along, no_change, no_matrix, observation_matrix, products, &
                                            record_views, ACROSS
  use measurement_series_slopes, only: series_slopes_t
  use solid_damping_effects, only: damping_effects_t, DAMPING_DRAG, DAMPING_RELAXATION
  use solid_dragged_flow, only: drag_t
  use solid_joint_forces, only: apply_joints
  use solid_mass_effects, only: mass_effects_t, mass_parts_t
  use solid_modal, only: modal_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_point_areas, only: point_areas
  use solid_ringing, only: ring_change_t, ringing_t, shake_t, EXCITED_BASE, SHAKE_RATE
  use solid_stiffness, only: stiffness_t
  implicit none
  private
  public :: series_simulation_t

  integer, parameter :: N_MODES = 16 !< number of modes in the motion
  integer, parameter :: BESIDE = 6   !< further modes that are computed for the derivatives

  !> Holds the simulation, one per process. An evaluation does not depend on earlier ones.
  type, extends(motion_simulation_t) :: series_simulation_t
    type(measured_series_t), allocatable :: series(:)
    integer, allocatable :: first(:)                   !< (series) their first observation: trace by trace, in time
    type(mass_parts_t) :: parts
    real(rp) :: density(2) = 0                         !< [kg/m^3] by medium
    real(rp), allocatable, private :: area(:)          !< (n_points) [m^2] that meets with drag
    integer, private :: n_modes = 0, n_known = 0
    class(modal_t), allocatable, private :: modal(:)   !< (2) by medium
    logical, private :: is_used(2) = .false.
    type(ringing_t), allocatable :: rings(:)           !< (series) their motions, after `evaluate`
    type(material_point_t), allocatable, private :: sites(:, :) !< (most traces, series)
    type(material_point_t), allocatable, private :: excited_sites(:)    !< (series)
    type(shake_t) :: shake                             !< of the next evaluation
    type(damping_effects_t), private :: damping
    type(mass_effects_t), private :: effects
    type(series_slopes_t), private :: slopes(2)        !< by medium
    integer, allocatable, private :: first_view(:)     !< (series) of `slopes`
    real(rp), allocatable, private :: mass(:, :, :)    !< (3, n_all, 2) [kg]
    real(rp), allocatable, private :: slope(:, :)      !< (3, n_all)
    real(rp), allocatable, private :: stiff(:, :, :, :) !< (3, n_all, modes, 2) K_joints Phi
  contains
    procedure :: init => simulation_init
    procedure :: free => simulation_free
    procedure :: evaluate => simulation_evaluate
    procedure :: computed => simulation_computed
    procedure :: nuisances => simulation_nuisances
    procedure :: stiffness_tangent => simulation_stiffness_tangent
    procedure :: mass_tangent => simulation_mass_tangent
    procedure :: clamp_tangent => simulation_clamp_tangent
    procedure :: damping_tangent => simulation_damping_tangent
    procedure :: shake_tangent => simulation_shake_tangent
    procedure :: model => simulation_model
  end type series_simulation_t

contains

  !> Takes the records of a checked measurement, none or more, of the wing of `model` with these masses.
  subroutine simulation_init(self, measurement, model, parts)
    class(series_simulation_t), intent(inout) :: self
    type(measurement_t), intent(in) :: measurement
    type(solid_model_t), intent(in) :: model
    type(mass_parts_t), intent(in) :: parts
    integer :: i, j, m
    call self%free()
    allocate (modal_t :: self%modal(2))
    self%parts = parts
    self%area = point_areas(model%points(:, :model%n_points), model%triangles)
    self%density(MEDIUM_AIR) = measurement%series_air_density
    self%series = measurement%series
    m = size(self%series)
    self%n_modes = min(N_MODES, 3*model%n_free)
    self%n_known = min(N_MODES + BESIDE, 3*model%n_free)
    allocate (self%first(m), self%rings(m), self%excited_sites(m), &
              self%sites(maxval([(size(self%series(i)%sigma), i=1, m), 0]), m))
    self%n = 0
    do i = 1, m
      associate (s => self%series(i), ring => self%rings(i))
        self%first(i) = self%n + 1
        self%n = self%n + s%count()
        self%is_used(s%medium) = .true.
        self%excited_sites(i) = place_of(s%point)
        do j = 1, size(s%sigma)
          self%sites(j, i) = place_of(s%place(:, j))
        end do
        ring%excitation = s%excitation
        ring%sees_velocity = s%is_velocity
        ring%interval = 1/s%rate
        ring%start = s%start
        ring%cutoff = TWO_PI*s%lowpass
        ring%order = s%order
      end associate
    end do
    do m = 1, 2
      if (self%is_used(m)) call self%modal(m)%init(model)
    end do
    allocate (self%mass(3, model%n_all, 2), self%slope(3, model%n_all), self%stiff(3, model%n_all, self%n_modes, 2), &
              source=0.0_rp)
    allocate (self%first_view(size(self%series)), source=0)

  contains

    type(material_point_t) function place_of(point)
      real(rp), intent(in) :: point(2)
      place_of = find_material_point(model%points(:, :model%n_points), model%triangles, model%size, point)
    end function place_of

  end subroutine simulation_init

  !> Releases everything.
  subroutine simulation_free(self)
    class(series_simulation_t), intent(inout) :: self
    integer :: m
    if (allocated(self%modal)) then
      do m = 1, 2
        call self%modal(m)%free()
      end do
      deallocate (self%modal, self%series, self%first, self%rings, self%excited_sites, self%sites, self%mass, self%slope, &
                  self%stiff, self%first_view, self%area)
    end if
    self%is_used = .false.
    self%n = 0
  end subroutine simulation_free

  !> Computes the motions with these parameters, masses and damping, and residuals(n). `ok` is false if there are no residuals,
  !> because the unloaded wing is unstable.
  subroutine simulation_evaluate(self, params, effects, damping, residuals, ok)
    class(series_simulation_t), intent(inout) :: self
    type(solid_params_t), intent(in) :: params
    type(mass_effects_t), intent(in) :: effects
    type(damping_effects_t), intent(in) :: damping
    real(rp), intent(out) :: residuals(:)
    logical, intent(out) :: ok
    type(failure_t) :: failure
    integer :: m, i
    residuals = 0
    ok = .true.
    self%damping = damping
    self%effects = effects
    self%slopes%is_ready = .false.
    do m = 1, 2
      if (.not. self%is_used(m)) cycle
      call self%modal(m)%model%set_params(params)
      call self%parts%masses(effects, self%density(m), self%mass(:, :, m))
      ok = minval(self%mass(:, self%modal(m)%model%movable, m)) > 0
      if (ok) call self%modal(m)%solve(self%mass(:, :, m), self%n_known, failure)
      ok = ok .and. .not. failure%failed
      if (.not. ok) return
      call apply_joints(self%modal(m), self%stiff(:, :, :, m))
    end do
    do i = 1, size(self%series)
      call ring_with(self, i, damping, self%shake, .false., self%rings(i))
      call gather(self, i, self%rings(i)%seen - self%series(i)%values, residuals)
    end do
  end subroutine simulation_evaluate

  !> Computes the motion of record i with this damping and motion of the base; with `keeps` so that those of 0 have tangents.
  subroutine ring_with(self, i, damping, shake, keeps, ring)
    class(series_simulation_t), intent(in) :: self
    integer, intent(in) :: i
    type(damping_effects_t), intent(in) :: damping
    type(shake_t), intent(in) :: shake
    logical, intent(in) :: keeps
    type(ringing_t), intent(inout) :: ring
    associate (s => self%series(i), modal => self%modal(self%series(i)%medium), n => self%n_modes)
      ring%drag = drag_t()
      if (s%medium == MEDIUM_AIR .and. (keeps .or. damping%drag > 0)) then
        ring%drag%strength = damping%drag
        ring%drag%area = self%area
        ring%drag%across = modal%shapes(3, :size(self%area), :n)
      end if
      if (allocated(ring%shaken)) deallocate (ring%shaken)
      if (shake%record == i) then
        ring%shake = shake
        ring%shaken = -inertia_along(self%mass(:, :, s%medium), ACROSS, modal%shapes(:, :, :n))
      end if
      call ring%run(modal%lambda(:n), products(modal%shapes(:, :, :n), self%stiff(:, :, :, s%medium)), &
                    observation_matrix(s, self%sites(:, i), modal%shapes(:, :, :n)), &
                    forcing_vector(s, self%excited_sites(i), self%mass(:, :, s%medium), modal%shapes(:, :, :n)), damping, &
                    size(s%values, 1), s%base)
    end associate
  end subroutine ring_with

  !> Adds seen(samples, traces) of record i, over their sd, to its part of column(n).
  subroutine gather(self, i, seen, column)
    class(series_simulation_t), intent(in) :: self
    integer, intent(in) :: i
    real(rp), intent(in) :: seen(:, :)
    real(rp), intent(inout) :: column(:)
    associate (first => self%first(i), last => self%first(i) + self%series(i)%count() - 1)
      column(first:last) = column(first:last) + self%series(i)%in_sd(seen)
    end associate
  end subroutine gather

  !> Returns seen(samples, traces) of record i, after `evaluate`; with the `errors` of the size and of the time of its excitation,
  !> in sd.
  function simulation_computed(self, i, errors) result(seen)
    class(series_simulation_t), intent(in) :: self
    integer, intent(in) :: i
    real(rp), intent(in), optional :: errors(2)
    real(rp), allocatable :: seen(:, :)
    seen = self%rings(i)%seen
    if (.not. present(errors)) return
    associate (s => self%series(i))
      seen = seen + errors(1)*s%size_sigma/s%size*seen + errors(2)*s%trigger_sigma*self%rings(i)%rate &
             + 0.5_rp*(errors(2)*s%trigger_sigma)**2*self%rings(i)%second
    end associate
  end function simulation_computed

  !> Returns columns(n, 2*series), the change of each record by one sd of the size of its excitation, and of its time; after
  !> `evaluate`.
  subroutine simulation_nuisances(self, columns)
    class(series_simulation_t), intent(in) :: self
    real(rp), intent(out) :: columns(:, :)
    integer :: i
    columns = 0
    do i = 1, size(self%series)
      associate (s => self%series(i), ring => self%rings(i))
        call gather(self, i, (s%size_sigma/s%size)*ring%seen, columns(:, 2*i - 1))
        call gather(self, i, s%trigger_sigma*ring%rate, columns(:, 2*i))
      end associate
    end do
  end subroutine simulation_nuisances

  !> Returns the change of the residuals by a change of stiffness; see motion_simulation_t.
  subroutine simulation_stiffness_tangent(self, direction, column)
    class(series_simulation_t), intent(inout) :: self
    type(stiffness_t), intent(in) :: direction
    real(rp), intent(out) :: column(:)
    real(rp) :: changed(3, size(self%mass, 2), self%n_modes)
    integer :: m
    column = 0
    changed = 0
    do m = 1, 2
      if (.not. self%is_used(m)) cycle
      call prepare_slopes(self, m)
      call self%slopes(m)%by_stiffness(self%modal(m), direction)
      if (abs(self%damping%joints) > 0) call apply_joints(self%modal(m), changed, direction)
      call project_change(self, m, products(self%modal(m)%shapes(:, :, :self%n_modes), changed), column)
    end do
  end subroutine simulation_stiffness_tangent

  !> Makes the slopes of medium m ready for parameters at the point of the last evaluation.
  subroutine prepare_slopes(self, m)
    class(series_simulation_t), intent(inout) :: self
    integer, intent(in) :: m
    real(rp), allocatable :: view(:, :, :)
    integer :: i
    logical :: has_shapes
    if (self%slopes(m)%is_ready) return
    has_shapes = abs(self%damping%joints) > 0
    allocate (view(3, size(self%mass, 2), 0))
    do i = 1, size(self%series)
      if (self%series(i)%medium /= m) cycle
      self%first_view(i) = size(view, 3) + 1
      view = reshape([view, record_views(self%series(i), self%sites(:, i), self%excited_sites(i), self%mass(:, :, m))], &
                     [3, size(view, 2), size(view, 3) + size(self%series(i)%sigma) + 2])
      has_shapes = has_shapes .or. allocated(self%rings(i)%drag%across)
    end do
    call self%slopes(m)%init(self%modal(m), self%n_modes, view, has_shapes)
  end subroutine prepare_slopes

  !> Returns the change of the residuals by a compliant clamp; see motion_simulation_t.
  subroutine simulation_clamp_tangent(self, k, column)
    class(series_simulation_t), intent(inout) :: self
    integer, intent(in) :: k
    real(rp), intent(out) :: column(:)
    integer :: m
    column = 0
    do m = 1, 2
      if (.not. self%is_used(m)) cycle
      call prepare_slopes(self, m)
      call self%slopes(m)%by_clamp(self%modal(m), k)
      call project_change(self, m, no_matrix(), column)
    end do
  end subroutine simulation_clamp_tangent

  !> Returns the change of the residuals by a change of the masses; see motion_simulation_t.
  subroutine simulation_mass_tangent(self, number, effects, column)
    class(series_simulation_t), intent(inout) :: self
    integer, intent(in) :: number
    type(mass_effects_t), intent(in) :: effects
    real(rp), intent(out) :: column(:)
    integer :: m
    column = 0
    do m = 1, 2
      if (.not. self%is_used(m)) cycle
      call self%parts%derivative(effects, self%density(m), number, self%slope)
      call prepare_slopes(self, m)
      call self%slopes(m)%by_mass(self%modal(m), self%slope)
      call project_change(self, m, no_matrix(), column)
    end do
  end subroutine simulation_mass_tangent

  !> Adds the change of the records in medium m by the last parameter of the slopes, whose change of the masses is self%slope.
  !> `joints` is the change of K_joints between the modes, or has size 0.
  subroutine project_change(self, m, joints, column)
    class(series_simulation_t), intent(inout) :: self
    integer, intent(in) :: m
    real(rp), intent(in) :: joints(:, :)
    real(rp), intent(inout) :: column(:)
    type(ring_change_t) :: change
    real(rp), allocatable :: seen(:, :), moved(:, :)
    integer :: i
    change = self%slopes(m)%change
    change%joints = joints
    if (abs(self%damping%joints) > 0) then
      moved = products(self%slopes(m)%shapes, self%stiff(:, :, :, m))
      if (size(joints) == 0) change%joints = 0*moved
      change%joints = change%joints + moved + transpose(moved)
    end if
    do i = 1, size(self%series)
      if (self%series(i)%medium /= m) cycle
      call self%slopes(m)%take(self%first_view(i), size(self%series(i)%sigma), size(self%area), change)
      if (size(change%mass) > 0) &
        change%shaken = change%shaken - inertia_along(self%slope, ACROSS, self%modal(m)%shapes(:, :, :self%n_modes))
      if (size(change%mass) > 0 .and. self%series(i)%excitation == EXCITED_BASE) &
        change%forcing = change%forcing - inertia_along(self%slope, self%series(i)%direction, &
                                                     self%modal(m)%shapes(:, :, :self%n_modes))
      call self%rings(i)%tangent(change, seen)
      call gather(self, i, seen, column)
    end do
  end subroutine project_change

  !> Returns the change of the residuals by damping effect `number`, of the relaxation with this time [s], or for the logarithm of
  !> the time of the present relaxation (DAMPING_TIME).
  subroutine simulation_damping_tangent(self, number, time, column)
    class(series_simulation_t), intent(inout) :: self
    integer, intent(in) :: number
    real(rp), intent(in) :: time
    real(rp), intent(out) :: column(:)
    type(ring_change_t) :: change
    type(damping_effects_t) :: damping
    type(ringing_t), allocatable :: ring
    real(rp), allocatable :: seen(:, :)
    integer :: i
    logical :: is_other, is_new
    column = 0
    change = no_change()
    change%damping = number
    damping = self%damping
    ! Another relaxation time needs separate states; the wing has only one relaxation.
    is_other = number == DAMPING_RELAXATION .and. abs(time - damping%relaxation_time) > 1.0e-12_rp*time
    if (is_other) damping%relaxation = 0
    if (is_other) damping%relaxation_time = time
    is_new = number == DAMPING_DRAG .and. .not. damping%drag > 0
    do i = 1, size(self%series)
      if (number == DAMPING_DRAG .and. self%series(i)%medium /= MEDIUM_AIR) cycle
      if (is_other .or. is_new) then
        ring = self%rings(i)
        call ring_with(self, i, damping, self%shake, is_new, ring)
        call ring%tangent(change, seen)
      else
        call self%rings(i)%tangent(change, seen)
      end if
      call gather(self, i, seen, column)
    end do
  end subroutine simulation_damping_tangent

  !> Returns the change of the residuals by a part (SHAKE_..) of this motion of the base; of its rate by the logarithm.
  subroutine simulation_shake_tangent(self, part, shake, column)
    class(series_simulation_t), intent(inout) :: self
    integer, intent(in) :: part
    type(shake_t), intent(in) :: shake
    real(rp), intent(out) :: column(:)
    type(ring_change_t) :: change
    type(ringing_t), allocatable :: ring
    real(rp), allocatable :: seen(:, :)
    column = 0
    change = no_change()
    change%shake = part
    if (part == SHAKE_RATE .and. .not. any(abs(shake%amplitude) > 0)) return
    ring = self%rings(shake%record)
    if (shake%record /= self%shake%record .or. abs(shake%rate - self%shake%rate) > 1.0e-12_rp*shake%rate) &
      call ring_with(self, shake%record, self%damping, shake, .false., ring)
    call ring%tangent(change, seen)
    call gather(self, shake%record, seen, column)
  end subroutine simulation_shake_tangent

  !> Returns the model with the parameters of the last evaluation, from which directions of stiffness are made.
  function simulation_model(self) result(model)
    class(series_simulation_t), intent(in), target :: self
    type(solid_model_t), pointer :: model
    model => self%modal(merge(1, 2, self%is_used(1)))%model
  end function simulation_model
end module measurement_series_simulation
