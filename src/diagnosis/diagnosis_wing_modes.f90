! SPDX-License-Identifier: GPL-3.0-or-later
!> The natural modes of a measurement as a simulator of a wing sees them: residuals in units of their sd, with the unit matrix
!> as covariance, and exact tangents of all parameters of the catalogue. In vectors of observations bending tests come first and
!> modes follow. Each mode is a surface of its own, and a fold of its own. Without modes there are no observations here.
module diagnosis_wing_modes
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use diagnosis_wing_parameters, only: differing, wing_parameter_t, KIND_DAMAGE, KIND_MASS, KIND_PARAMETER, KIND_POINT_MASS, &
                                       KIND_SOFT
  use inference_simulator, only: labels_t
  use measurement_experiment, only: experiment_t
  use measurement_mode_simulation, only: mode_simulation_t
  use measurement_place, only: find_material_point, material_point_t
  use solid_effects, only: clamp_axis
  use solid_mass_effects, only: describe_mass_effect, mass_effects_t, mass_parts_t, MASS_POINT
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: damage_direction, hinge_direction, parameter_direction
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_modes_t, mass_effects_at, put_mass_at

  type :: wing_modes_t
    integer :: n = 0                                 !< observations
    !> One per simulator, of which no copy is ever wanted.
    type(mode_simulation_t), pointer :: simulation => null()
    type(experiment_t), pointer, private :: bare => null()
    type(wing_t), pointer, private :: wing => null()
    type(wing_parameter_t), allocatable, private :: parameters(:)
    type(mass_parts_t), private :: parts
    type(stiffness_t), private :: direction
    type(mass_effects_t), private :: effects
    integer, private :: placed(2) = -1               !< parameters whose place the model has: a soft hinge, a damage; 0: none
  contains
    procedure :: init => modes_init
    procedure :: free => modes_free
    procedure :: evaluate => modes_evaluate
    procedure :: tangent => modes_tangent
    procedure :: tangents => modes_tangents
    procedure :: directions => modes_directions
    procedure :: append_labels => modes_append_labels
  end type wing_modes_t

contains

  !> The modes of the measurement of `bare`, on a wing of these masses; both must live as long as this.
  subroutine modes_init(self, bare, wing, parameters, parts)
    class(wing_modes_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(mass_parts_t), intent(in) :: parts
    logical :: ok
    self%bare => bare
    self%wing => wing
    self%parameters = parameters
    self%parts = parts
    self%placed = -1
    if (.not. associated(self%simulation)) allocate (self%simulation)
    call prepare(self, spread(0.0_rp, 1, 0), ok)
    self%n = self%simulation%n
  end subroutine modes_init

  !> Releases everything.
  subroutine modes_free(self)
    class(wing_modes_t), intent(inout) :: self
    if (associated(self%simulation)) then
      call self%simulation%free()
      deallocate (self%simulation)
    end if
    self%n = 0
  end subroutine modes_free

  !> A model with the places of what differs from its null at q, or of the bare wing if q is empty. Veins have sides, so that
  !> torsion has room.
  subroutine prepare(self, q, ok)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    logical, intent(out) :: ok
    type(solid_model_t), allocatable :: model
    type(solid_params_t) :: params
    type(failure_t) :: failure
    integer, allocatable :: wanted(:)
    integer :: placed(2), i
    placed = 0
    allocate (wanted(0))
    if (size(q) > 0) wanted = differing(self%parameters, q)
    do i = 1, size(wanted)
      if (self%parameters(wanted(i))%kind == KIND_SOFT) placed(1) = wanted(i)
      if (self%parameters(wanted(i))%kind == KIND_DAMAGE) placed(2) = wanted(i)
    end do
    ok = .true.
    if (all(placed == self%placed)) return
    params = self%bare%model%params
    params%effects%has_sided_veins = size(self%bare%model%triangles) > 0
    if (placed(1) > 0) then
      associate (one => self%parameters(placed(1)))
        params%effects%soft_vein = trim(params%vein_names(one%vein))
        params%effects%soft_fraction = one%fraction
      end associate
    end if
    if (placed(2) > 0) params%effects%disc = self%parameters(placed(2))%disc
    allocate (model)
    call model%init(self%wing, params, failure)
    ok = .not. failure%failed
    if (.not. ok) return
    call self%simulation%init(self%bare%measurement, model, self%parts)
    self%placed = placed
  end subroutine prepare

  !> residuals(n) at q; `ok` false: the wing at rest is not stable. Tangents are those there.
  subroutine modes_evaluate(self, q, residuals, ok)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: residuals(:)
    logical, intent(out) :: ok
    type(solid_params_t) :: params
    type(solid_model_t), pointer :: model
    type(parameter_t) :: p
    integer :: i
    call prepare(self, q, ok)
    if (.not. ok) return
    model => self%simulation%model()
    params = model%params
    do i = 1, size(q)
      associate (one => self%parameters(i))
        select case (one%kind)
        case (KIND_PARAMETER)
          p = params%describe(one%number)
          if (p%is_log) then
            call params%set(one%number, exp(q(i)))
          else
            call params%set(one%number, q(i))
          end if
        case (KIND_SOFT)
          if (i == self%placed(1)) call params%set_named('soft', exp(q(i)))
        case (KIND_DAMAGE)
          if (i == self%placed(2)) call params%set_named('damage', exp(q(i)))
        end select
      end associate
    end do
    self%effects = mass_effects_at(self%bare, self%parameters, q)
    call self%simulation%evaluate(params, self%effects, residuals, ok)
  end subroutine modes_evaluate

  !> What the masses are at q.
  function mass_effects_at(bare, parameters, q) result(effects)
    type(experiment_t), intent(in) :: bare
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    type(mass_effects_t) :: effects
    integer :: i
    do i = 1, size(q)
      associate (one => parameters(i))
        if (one%kind == KIND_MASS) then
          if (one%is_log) then
            call effects%set(one%number, exp(q(i)))
          else
            call effects%set(one%number, q(i))
          end if
        else if (one%kind == KIND_POINT_MASS .and. abs(q(i)) > 0) then
          call put_mass_at(bare, one%disc(:2), effects)
          effects%point = q(i)
        end if
      end associate
    end do
  end function mass_effects_at

  !> The point mass of `effects` is at this place [m] of the wing.
  subroutine put_mass_at(bare, place, effects)
    type(experiment_t), intent(in) :: bare
    real(rp), intent(in) :: place(2)
    type(mass_effects_t), intent(inout) :: effects
    type(material_point_t) :: found
    found = find_material_point(bare%model%points(:, :bare%model%n_points), bare%model%triangles, bare%model%size, place)
    effects%corner = found%corner
    effects%weight = found%weight
  end subroutine put_mass_at

  !> column(n): derivative of the residuals with respect to parameter i at q, after `evaluate` there.
  subroutine modes_tangent(self, q, i, column)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: i
    real(rp), intent(out) :: column(:)
    type(solid_model_t), pointer :: model
    type(mass_effects_t) :: effects
    integer :: axis
    model => self%simulation%model()
    column = 0
    associate (one => self%parameters(i))
      select case (one%kind)
      case (KIND_PARAMETER)
        axis = clamp_axis(model%params%effects, one%number - model%params%count_usual())
        if (axis > 0) then
          call self%simulation%clamp_tangent(axis, column)
          return
        end if
        call parameter_direction(model, one%number, self%direction)
      case (KIND_SOFT)
        call hinge_direction(model, one%number, self%direction)
      case (KIND_DAMAGE)
        if (abs(q(i) - one%null) > 0) then
          call parameter_direction(model, model%params%find('damage'), self%direction)
        else
          call damage_direction(model, one%disc, self%direction)
        end if
      case (KIND_MASS)
        call self%simulation%mass_tangent(one%number, self%effects, column)
        return
      case (KIND_POINT_MASS)
        effects = self%effects
        call put_mass_at(self%bare, one%disc(:2), effects)
        call self%simulation%mass_tangent(MASS_POINT, effects, column)
        return
      case default ! of the measurement of bending
        return
      end select
    end associate
    call self%simulation%stiffness_tangent(self%direction, column)
  end subroutine modes_tangent

  !> jacobian(n, size(columns)) with respect to the parameters `columns`.
  subroutine modes_tangents(self, q, columns, jacobian)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    real(rp), intent(out) :: jacobian(:, :)
    integer :: k
    do k = 1, size(columns)
      call self%tangent(q, columns(k), jacobian(:, k))
    end do
  end subroutine modes_tangents

  !> At q: nuisance(n), what D in error by membrane_sd does, if parameter `membrane` is D (0: none), and, unless patterns(n, :)
  !> has no columns, in the first ones what unit stiffness around each place(2, :) [m] does. Without bending tests the forces of
  !> unknown causes are those of inertia: in the next ones a mass of the usual prior at each place.
  subroutine modes_directions(self, q, membrane, membrane_sd, place, radius, nuisance, patterns, ok)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), membrane_sd, place(:, :), radius
    integer, intent(in) :: membrane
    real(rp), intent(inout) :: nuisance(:), patterns(:, :)
    logical, intent(out) :: ok
    real(rp) :: residuals(self%n)
    type(mass_effects_t) :: effects
    type(parameter_t) :: p
    integer :: i, n
    call self%evaluate(q, residuals, ok)
    if (.not. ok) return
    if (membrane > 0) then
      call self%tangent(q, membrane, nuisance)
      nuisance = membrane_sd*nuisance
    end if
    do i = 1, min(size(place, 2), size(patterns, 2))
      call damage_tangent(self, [place(:, i), radius], patterns(:, i))
    end do
    n = size(place, 2)
    if (size(self%bare%loads) > 0 .or. size(patterns, 2) < 2*n) return
    p = describe_mass_effect(MASS_POINT, sum(self%bare%masses))
    effects = self%effects
    do i = 1, n
      call put_mass_at(self%bare, place(:, i), effects)
      call self%simulation%mass_tangent(MASS_POINT, effects, patterns(:, n + i))
      patterns(:, n + i) = p%prior_sd*patterns(:, n + i)
    end do
  end subroutine modes_directions

  !> The derivative with respect to the logarithm of a damage in disc = (x, y, radius) [m] that the wing does not have.
  subroutine damage_tangent(self, disc, column)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: disc(3)
    real(rp), intent(out) :: column(:)
    type(solid_model_t), pointer :: model
    model => self%simulation%model()
    call damage_direction(model, disc, self%direction)
    call self%simulation%stiffness_tangent(self%direction, column)
  end subroutine damage_tangent

  !> Every mode is a surface with a fold and a block of its own. What was observed has no size.
  subroutine modes_append_labels(self, labels)
    class(wing_modes_t), intent(in) :: self
    type(labels_t), intent(inout) :: labels
    integer :: k, j, n, surfaces, folds, blocks
    surfaces = size(labels%fold)
    folds = max(0, maxval(labels%fold))
    blocks = max(0, maxval(labels%block))
    do k = 1, size(self%simulation%targets)
      n = self%simulation%targets(k)%n
      labels%surface = [labels%surface, (surfaces + k, j=1, n)]
      labels%block = [labels%block, (blocks + k, j=1, n)]
      labels%observed = [labels%observed, (0.0_rp, j=1, n)]
      labels%place = reshape([labels%place, (0.0_rp, j=1, 2*n)], [2, size(labels%surface)])
      labels%fold = [labels%fold, folds + k]
      labels%level = [labels%level, 0.0_rp]
      labels%order = [labels%order, 0.0_rp]
      labels%hold = [labels%hold, -1.0_rp]
      labels%moment = [labels%moment, 0.0_rp]
      labels%replicate = [labels%replicate, surfaces + k]
    end do
  end subroutine modes_append_labels
end module diagnosis_wing_modes
