! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the natural modes of a measurement: pairs of measured and computed modes, residuals, and their exact derivatives.
!>
!> The wing is at rest and flat; in air, its membrane carries the added mass of strip theory. Modes are paired as follows: a
!> measured mode with a number is that mode. Of the others the pair with the largest score MAC exp(-(ln(f/f_m))^2/(2 SPREAD^2)) is
!> taken first, then the next one. Computed modes may remain without a pair, at any place: measurements miss modes.
module measurement_mode_simulation
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use measurement_data, only: measurement_t
  use measurement_mode_target, only: mode_target_t
  use measurement_modes, only: MEDIUM_AIR
  use measurement_motion_simulation, only: motion_simulation_t
  use solid_mass_effects, only: mass_effects_t, mass_parts_t
  use solid_modal, only: modal_t, mode_slopes_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_stiffness, only: stiffness_t
  implicit none
  private
  public :: mode_simulation_t

  real(rp), parameter :: GAP = 0.01_rp   !< relative difference of frequencies within a cluster
  real(rp), parameter :: SPREAD = 0.5_rp !< of ln(f/f_m) of a pair
  integer, parameter :: MISSED = 4       !< modes that a measurement may lack below its last one
  integer, parameter :: BESIDE = 3       !< further modes that are computed for the derivatives

  !> There is one per process. Nothing of an evaluation enters the next one.
  type, extends(motion_simulation_t) :: mode_simulation_t
    integer :: n = 0                                  !< observations
    type(mode_target_t), allocatable :: targets(:)    !< (modes)
    integer, allocatable :: first(:)                  !< (modes) their first observation
    type(mass_parts_t) :: parts
    real(rp) :: density(2) = 0                        !< [kg/m^3] by medium
    integer, private :: n_modes(2) = 0                !< that are computed, by medium
    integer, private :: n_paired(2) = 0               !< that may have a measured one as a pair
    class(modal_t), allocatable, private :: modal(:)  !< (2) by medium; polymorphic, so that compilers copy it by a call
    logical, allocatable, private :: same(:, :)
    type(mode_slopes_t), private :: slopes
    real(rp), allocatable, private :: mass(:, :)
  contains
    procedure :: init => simulation_init
    procedure :: free => simulation_free
    procedure :: evaluate => simulation_evaluate
    procedure :: stiffness_tangent => simulation_stiffness_tangent
    procedure :: mass_tangent => simulation_mass_tangent
    procedure :: clamp_tangent => simulation_clamp_tangent
    procedure :: model => simulation_model
  end type mode_simulation_t

contains

  !> Takes the modes of a checked measurement, none or more, of the wing of `model` with these masses.
  subroutine simulation_init(self, measurement, model, parts)
    class(mode_simulation_t), intent(inout) :: self
    type(measurement_t), intent(in) :: measurement
    type(solid_model_t), intent(in) :: model
    type(mass_parts_t), intent(in) :: parts
    integer :: i, m, most
    call self%free()
    allocate (modal_t :: self%modal(2))
    self%parts = parts
    self%density(MEDIUM_AIR) = measurement%air_density
    allocate (self%targets(measurement%count_modes()), self%first(measurement%count_modes()))
    self%n = 0
    do i = 1, size(self%targets)
      call self%targets(i)%init(measurement%modes(i), model)
      self%first(i) = self%n + 1
      self%n = self%n + self%targets(i)%n
    end do
    do m = 1, 2
      self%n_modes(m) = 0
      if (.not. any(self%targets%medium == m)) cycle
      most = max(count(self%targets%medium == m), maxval(self%targets%number, mask=self%targets%medium == m))
      self%n_modes(m) = min(most + MISSED + BESIDE, 3*model%n_free)
      self%n_paired(m) = min(most + MISSED, self%n_modes(m))
      call self%modal(m)%init(model)
    end do
    allocate (self%mass(3, model%n_all))
  end subroutine simulation_init

  !> Releases everything.
  subroutine simulation_free(self)
    class(mode_simulation_t), intent(inout) :: self
    integer :: m
    if (allocated(self%modal)) then
      do m = 1, 2
        call self%modal(m)%free()
      end do
      deallocate (self%modal)
    end if
    if (allocated(self%targets)) deallocate (self%targets, self%first, self%mass)
    self%n = 0
  end subroutine simulation_free

  !> Finds the modes with these parameters and masses, and residuals(n). `ok` is false if there are none, as the wing at rest is
  !> unstable.
  subroutine simulation_evaluate(self, params, effects, residuals, ok)
    class(mode_simulation_t), intent(inout) :: self
    type(solid_params_t), intent(in) :: params
    type(mass_effects_t), intent(in) :: effects
    real(rp), intent(out) :: residuals(:)
    logical, intent(out) :: ok
    type(failure_t) :: failure
    integer :: m, i
    residuals = 0
    ok = .true.
    do m = 1, 2
      if (self%n_modes(m) == 0) cycle
      call self%modal(m)%model%set_params(params)
      call self%parts%masses(effects, self%density(m), self%mass)
      ok = minval(self%mass(:, self%modal(m)%model%movable)) > 0
      if (ok) call self%modal(m)%solve(self%mass, self%n_modes(m), failure)
      ok = ok .and. .not. failure%failed
      if (.not. ok) return
      call make_pairs(self, m, ok)
      if (.not. ok) return
    end do
    do i = 1, size(self%targets)
      associate (t => self%targets(i))
        call t%residuals(self%modal(t%medium)%lambda(t%lo:t%hi), self%modal(t%medium)%shapes(:, :, t%lo:t%hi), &
                         residuals(self%first(i):self%first(i) + t%n - 1))
      end associate
    end do
  end subroutine simulation_evaluate

  !> Finds the computed modes of all measured ones in medium m.
  subroutine make_pairs(self, m, ok)
    class(mode_simulation_t), intent(inout) :: self
    integer, intent(in) :: m
    logical, intent(out) :: ok
    real(rp), allocatable :: score(:, :), f(:)
    integer, allocatable :: lo(:), hi(:), room(:)
    integer :: i, c, best(2)
    f = self%modal(m)%frequencies()
    call find_clusters(f(:self%n_paired(m)), lo, hi)
    room = hi - lo + 1
    allocate (score(size(self%targets), size(lo)), source=-1.0_rp)
    do i = 1, size(self%targets)
      associate (t => self%targets(i))
        if (t%medium /= m) cycle
        if (t%number > 0) then
          t%lo = t%number
          t%hi = t%number
          c = findloc(t%number >= lo .and. t%number <= hi, .true., 1)
          if (c > 0) room(c) = room(c) - 1
          cycle
        end if
        do c = 1, size(lo)
          score(i, c) = t%assurance(self%modal(m)%shapes(:, :, lo(c):hi(c)))* &
                        t%nearness(sqrt(f(lo(c))*f(hi(c))), SPREAD)
        end do
      end associate
    end do
    do while (any(score >= 0))
      best = maxloc(score)
      i = best(1)
      c = best(2)
      if (room(c) <= 0) then
        score(:, c) = -1
        cycle
      end if
      self%targets(i)%lo = lo(c)
      self%targets(i)%hi = hi(c)
      room(c) = room(c) - 1
      score(i, :) = -1
    end do
    ok = all(self%targets%lo > 0 .or. self%targets%medium /= m)
  end subroutine make_pairs

  !> Modes lo(c) to hi(c) are nearer to one another than GAP.
  pure subroutine find_clusters(f, lo, hi)
    real(rp), intent(in) :: f(:)
    integer, allocatable, intent(out) :: lo(:), hi(:)
    integer :: i
    lo = [1]
    hi = [1]
    do i = 2, size(f)
      if (f(i) - f(i - 1) < GAP*f(i)) then
        hi(size(hi)) = i
      else
        lo = [lo, i]
        hi = [hi, i]
      end if
    end do
  end subroutine find_clusters

  !> Returns the change of the residuals by a change of stiffness; see motion_simulation_t. A change of joints is treated in the
  !> same way here.
  subroutine simulation_stiffness_tangent(self, direction, is_joint, column)
    class(mode_simulation_t), intent(inout) :: self
    type(stiffness_t), intent(in) :: direction
    logical, intent(in) :: is_joint
    real(rp), intent(out) :: column(:)
    integer :: m
    associate (unused => is_joint)
    end associate
    do m = 1, 2
      if (self%n_modes(m) == 0) cycle
      call note_clusters(self, m)
      call self%modal(m)%slopes_of_stiffness(direction, self%same, self%slopes)
      call project_change(self, m, .false., column)
    end do
  end subroutine simulation_stiffness_tangent

  !> Returns the change of the residuals by a change of the masses; see motion_simulation_t.
  subroutine simulation_mass_tangent(self, number, effects, column)
    class(mode_simulation_t), intent(inout) :: self
    integer, intent(in) :: number
    type(mass_effects_t), intent(in) :: effects
    real(rp), intent(out) :: column(:)
    integer :: m
    do m = 1, 2
      if (self%n_modes(m) == 0) cycle
      call note_clusters(self, m)
      call self%parts%derivative(effects, self%density(m), number, self%mass)
      call self%modal(m)%slopes_of_mass(self%mass, self%same, self%slopes)
      call project_change(self, m, .true., column)
    end do
  end subroutine simulation_mass_tangent

  !> Returns the change of the residuals by a compliant clamp; see motion_simulation_t.
  subroutine simulation_clamp_tangent(self, k, column)
    class(mode_simulation_t), intent(inout) :: self
    integer, intent(in) :: k
    real(rp), intent(out) :: column(:)
    integer :: m
    do m = 1, 2
      if (self%n_modes(m) == 0) cycle
      call note_clusters(self, m)
      call self%modal(m)%slopes_of_clamp(k, self%same, self%slopes)
      call project_change(self, m, .false., column)
    end do
  end subroutine simulation_clamp_tangent

  !> Finds which of the modes up to the last paired one form a cluster.
  subroutine note_clusters(self, m)
    class(mode_simulation_t), intent(inout) :: self
    integer, intent(in) :: m
    integer :: i, n
    n = maxval(self%targets%hi, mask=self%targets%medium == m)
    if (allocated(self%same)) deallocate (self%same)
    if (allocated(self%slopes%shapes)) deallocate (self%slopes%shapes)
    allocate (self%same(n, n), source=.false.)
    do i = 1, size(self%targets)
      associate (t => self%targets(i))
        if (t%medium == m .and. t%hi > t%lo) self%same(t%lo:t%hi, t%lo:t%hi) = .true.
      end associate
    end do
  end subroutine note_clusters

  !> Turns the change of the modes in medium `m` into a column of the Jacobian.
  subroutine project_change(self, m, is_mass, column)
    class(mode_simulation_t), intent(in) :: self
    integer, intent(in) :: m
    logical, intent(in) :: is_mass
    real(rp), intent(inout) :: column(:)
    integer :: i
    do i = 1, size(self%targets)
      associate (t => self%targets(i))
        if (t%medium /= m) cycle
        call t%tangent(self%slopes%force(t%lo:t%hi, t%lo:t%hi), self%slopes%shapes(:, :, t%lo:t%hi), is_mass, &
                       column(self%first(i):self%first(i) + t%n - 1))
      end associate
    end do
  end subroutine project_change

  !> Returns the model with the parameters of the last evaluation, from which directions of stiffness are made.
  function simulation_model(self) result(model)
    class(mode_simulation_t), intent(in), target :: self
    type(solid_model_t), pointer :: model
    model => self%modal(merge(1, 2, self%n_modes(1) > 0))%model
  end function simulation_model
end module measurement_mode_simulation
