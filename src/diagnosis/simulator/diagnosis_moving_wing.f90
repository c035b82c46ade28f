! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds what natural modes and records of a vibrating wing have in common: the simulation of their residuals, the wing at rest, and
!> derivatives with respect to the parameters of its mechanics and to what an unknown cause may change at a site.
module diagnosis_moving_wing
  use base_cause, only: parameter_of
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use diagnosis_wing_parameters, only: disc_at, wing_parameter_t, KIND_BALANCE, KIND_DAMPING, KIND_FLIGHT, KIND_MASS, &
                                       KIND_POINT_MASS, KIND_RELAXATION, KIND_RELAXATION_TIME, KIND_SHAKE, KIND_SITE
  use diagnosis_wing_rest, only: mass_effects_at, put_mass_at, weighs, wing_rest_t
  use measurement_experiment, only: experiment_t
  use measurement_motion_simulation, only: motion_simulation_t
  use solid_damping_effects, only: DAMPING_RELAXATION, DAMPING_TIME
  use solid_mass_effects, only: list_mass_causes, mass_effects_t, mass_parts_t, MASS_GRADIENT, MASS_POINT
  use solid_model, only: solid_model_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: damage_direction
  use solid_wing, only: wing_t
  implicit none
  private
  public :: moving_wing_t

  type, abstract :: moving_wing_t
    integer :: n = 0                !< observations
    integer :: n_nuisances = 0      !< modes have none
    type(wing_rest_t) :: rest
    type(mass_parts_t) :: parts
    type(mass_effects_t) :: effects !< on the masses, at the last evaluation
    class(motion_simulation_t), pointer, private :: mechanics => null()
    type(stiffness_t), private :: direction !< work
    real(rp), allocatable, private :: last_q(:), last(:) !< the parameters and residuals of the last evaluation
  contains
    procedure :: start => moving_start
    procedure :: free => moving_free
    procedure :: prepare => moving_prepare
    procedure :: is_at => moving_is_at
    procedure :: keep => moving_keep
    procedure :: forget => moving_forget
    procedure :: take_last => moving_take_last
    procedure :: tangent => moving_tangent
    procedure :: mechanics_tangent => moving_mechanics_tangent
    procedure :: tangents => moving_tangents
    procedure :: patterns => moving_patterns
    procedure(model_taker), deferred :: take_model
  end type moving_wing_t

  abstract interface
    !> Gives the simulation this model of the wing at rest.
    subroutine model_taker(self, model)
      import :: moving_wing_t, solid_model_t
      class(moving_wing_t), intent(inout) :: self
      type(solid_model_t), intent(in) :: model
    end subroutine model_taker
  end interface

contains

  !> Takes what the measurement of `bare` has for `simulation`, on a wing of these masses. `bare` and `wing` must live as long as
  !> this, which releases the simulation.
  subroutine moving_start(self, simulation, bare, wing, parameters, parts)
    class(moving_wing_t), intent(inout) :: self
    class(motion_simulation_t), pointer, intent(in) :: simulation
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(mass_parts_t), intent(in) :: parts
    logical :: ok
    call self%free()
    self%mechanics => simulation
    call self%rest%init(bare, wing, parameters)
    self%parts = parts
    call self%prepare([real(rp) ::], ok)
    self%n = simulation%n
  end subroutine moving_start

  !> Releases everything.
  subroutine moving_free(self)
    class(moving_wing_t), intent(inout) :: self
    if (associated(self%mechanics)) then
      call self%mechanics%free()
      deallocate (self%mechanics)
    end if
    if (allocated(self%last_q)) deallocate (self%last_q, self%last)
    self%n = 0
    self%n_nuisances = 0
  end subroutine moving_free

  !> Tells whether the last evaluation was at q, to the bit, and has residuals.
  pure logical function moving_is_at(self, q) result(is_there)
    class(moving_wing_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    is_there = .false.
    if (.not. allocated(self%last_q)) return
    if (size(q) == size(self%last_q)) is_there = .not. any(abs(q - self%last_q) > 0)
  end function moving_is_at

  !> Forgets the last evaluation, because another one begins.
  subroutine moving_forget(self)
    class(moving_wing_t), intent(inout) :: self
    if (allocated(self%last_q)) deallocate (self%last_q, self%last)
  end subroutine moving_forget

  !> Keeps the residuals of an evaluation at q. If it failed (not `ok`), nothing is kept.
  subroutine moving_keep(self, q, residuals, ok)
    class(moving_wing_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), residuals(:)
    logical, intent(in) :: ok
    call self%forget()
    if (.not. ok) return
    self%last_q = q
    self%last = residuals
  end subroutine moving_keep

  !> Returns the residuals that were kept.
  pure subroutine moving_take_last(self, residuals)
    class(moving_wing_t), intent(in) :: self
    real(rp), intent(out) :: residuals(:)
    residuals = self%last
  end subroutine moving_take_last

  !> Gives the simulation the model for q, and finds the effects on the masses there. `ok` is false if there is no such model.
  subroutine moving_prepare(self, q, ok)
    class(moving_wing_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    logical, intent(out) :: ok
    type(solid_model_t), allocatable :: model
    call self%rest%prepare(q, model, ok)
    if (allocated(model)) call self%take_model(model)
    if (ok) self%effects = mass_effects_at(self%rest%bare, self%rest%parameters, q)
  end subroutine moving_prepare

  !> Returns column(n), the derivative of the residuals with respect to parameter i at q, after an evaluation there. It is 0 for
  !> parameters on which the residuals do not depend.
  subroutine moving_tangent(self, q, i, column)
    class(moving_wing_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: i
    real(rp), intent(out) :: column(:)
    call self%mechanics_tangent(q, i, column)
  end subroutine moving_tangent

  !> Returns the same for a parameter of mass, stiffness, clamp or damping; the column of another one is 0.
  subroutine moving_mechanics_tangent(self, q, i, column)
    class(moving_wing_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: i
    real(rp), intent(out) :: column(:)
    type(solid_model_t), pointer :: model
    type(mass_effects_t) :: moved
    real(rp) :: by_mass(size(column)), disc(3)
    logical :: is_any
    model => self%mechanics%model()
    column = 0
    associate (one => self%rest%parameters(i))
      select case (one%kind)
      case (KIND_FLIGHT, KIND_BALANCE, KIND_SHAKE, KIND_SITE) ! only forces of the air or records depend on them
      case (KIND_DAMPING)
        call self%mechanics%damping_tangent(one%number, 0.0_rp, column)
        if (one%is_log) column = exp(q(i))*column
      case (KIND_RELAXATION)
        call self%mechanics%damping_tangent(DAMPING_RELAXATION, one%time*exp(q(one%number)), column)
      case (KIND_RELAXATION_TIME)
        if (abs(q(one%number)) > 0) call self%mechanics%damping_tangent(DAMPING_TIME, 0.0_rp, column)
      case (KIND_MASS)
        call self%mechanics%mass_tangent(one%number, self%effects, column)
      case (KIND_POINT_MASS)
        moved = self%effects
        disc = disc_at(self%rest%parameters, i, q)
        call put_mass_at(self%rest%bare, disc(:2), moved)
        call self%mechanics%mass_tangent(MASS_POINT, moved, column)
      case default
        if (self%rest%clamp(model, i) > 0) then
          call self%mechanics%clamp_tangent(self%rest%clamp(model, i), column)
        else
          call self%rest%direction(model, q, i, self%direction, is_any)
          if (is_any) call self%mechanics%stiffness_tangent(self%direction, column)
          if (weighs(self%rest%bare, one)) then
            call self%mechanics%mass_tangent(MASS_GRADIENT, self%effects, by_mass)
            column = column + by_mass
          end if
        end if
      end select
    end associate
  end subroutine moving_mechanics_tangent

  !> Returns jacobian(n, size(columns)) with respect to the parameters `columns`, after an evaluation.
  subroutine moving_tangents(self, q, columns, jacobian)
    class(moving_wing_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    real(rp), intent(out) :: jacobian(:, :)
    integer :: k
    do k = 1, size(columns)
      call self%tangent(q, columns(k), jacobian(:, k))
    end do
  end subroutine moving_tangents

  !> Computes patterns(n, :), at the point of the last evaluation. The first columns are the effects of unit stiffness around each
  !> site(2, :) [m]. Without bending tests the forces of unknown causes are those of inertia: the next columns are the effects of a
  !> mass of the default prior at each site. Fewer columns ask for fewer patterns.
  subroutine moving_patterns(self, site, radius, patterns)
    class(moving_wing_t), intent(inout) :: self
    real(rp), intent(in) :: site(:, :), radius
    real(rp), intent(inout) :: patterns(:, :)
    type(solid_model_t), pointer :: model
    type(mass_effects_t) :: moved
    type(parameter_t) :: p
    integer :: i, n
    n = size(site, 2)
    model => self%mechanics%model()
    do i = 1, min(n, size(patterns, 2))
      call damage_direction(model, [site(:, i), radius], self%direction)
      call self%mechanics%stiffness_tangent(self%direction, patterns(:, i))
    end do
    if (size(self%rest%bare%loads) > 0 .or. size(patterns, 2) < 2*n) return
    p = parameter_of(list_mass_causes(sum(self%rest%bare%masses)), MASS_POINT)
    moved = self%effects
    do i = 1, n
      call put_mass_at(self%rest%bare, site(:, i), moved)
      call self%mechanics%mass_tangent(MASS_POINT, moved, patterns(:, n + i))
      patterns(:, n + i) = p%prior_sd*patterns(:, n + i)
    end do
  end subroutine moving_patterns
end module diagnosis_moving_wing
