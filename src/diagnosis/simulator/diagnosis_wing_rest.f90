! SPDX-License-Identifier: GPL-3.0-or-later
!> Prepares the wing at rest for natural modes and records of motion: a model with the sites of all effects that differ from
!> their null, all parameters at a point q, masses and damping included, and the direction of stiffness of each parameter. Veins
!> have sides, so that torsion can act.
module diagnosis_wing_rest
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_wing_parameters, only: differing, disc_at, scale_membrane, wing_parameter_t, KIND_DAMAGE, KIND_DAMPING, KIND_MASS, &
                                       KIND_MEMBRANE, KIND_PARAMETER, KIND_POINT_MASS, KIND_RELAXATION, KIND_SHAKE, KIND_SOFT
  use measurement_experiment, only: experiment_t
  use measurement_material_point, only: find_material_point, material_point_t
  use solid_damping_effects, only: damping_effects_t, DAMPING_RELAXATION
  use solid_effects, only: clamp_axis, is_thickness
  use solid_mass_effects, only: mass_effects_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_ringing, only: shake_t, SHAKE_COSINE, SHAKE_RATE, SHAKE_SINE
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: damage_direction, hinge_direction, parameter_direction
  use solid_usual_causes, only: PARAM_PLATE
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_rest_t, damping_at, mass_effects_at, put_mass_at, shake_at, shake_of, weighs

  type :: wing_rest_t
    type(experiment_t), pointer :: bare => null()
    type(wing_t), pointer :: wing => null()
    type(wing_parameter_t), allocatable :: parameters(:)
    integer, private :: placed(2) = -1 !< parameters whose sites are in the model: a soft hinge, a damage; 0: none
    real(rp), private :: disc(3) = 0   !< [m] that of this damage
  contains
    procedure :: init => rest_init
    procedure :: prepare => rest_prepare
    procedure :: params => rest_params
    procedure :: direction => rest_direction
    procedure :: clamp => rest_clamp
  end type wing_rest_t

contains

  !> Takes the experiment `bare`, which has no unknowns, and the wing. Both must live as long as this.
  subroutine rest_init(self, bare, wing, parameters)
    class(wing_rest_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    self%bare => bare
    self%wing => wing
    self%parameters = parameters
    self%placed = -1
  end subroutine rest_init

  !> Makes a model with the sites of all parameters that differ from their null at q, or of the bare wing if q is empty. It keeps
  !> the model of the last call if its sites are still right. `ok` is false if there is no such model.
  subroutine rest_prepare(self, q, model, ok)
    class(wing_rest_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    type(solid_model_t), allocatable, intent(out) :: model
    logical, intent(out) :: ok
    type(solid_params_t) :: params
    type(failure_t) :: failure
    integer, allocatable :: wanted(:)
    real(rp) :: disc(3)
    integer :: placed(2), i
    placed = 0
    disc = 0
    allocate (wanted(0))
    if (size(q) > 0) wanted = differing(self%parameters, q)
    do i = 1, size(wanted)
      if (self%parameters(wanted(i))%kind == KIND_SOFT) placed(1) = wanted(i)
      if (self%parameters(wanted(i))%kind == KIND_DAMAGE) placed(2) = wanted(i)
    end do
    if (placed(2) > 0) disc = disc_at(self%parameters, placed(2), q)
    ok = .true.
    if (all(placed == self%placed) .and. all(abs(disc - self%disc) <= 0)) return
    params = self%bare%model%params
    params%effects%has_sided_veins = size(self%bare%model%triangles) > 0
    if (placed(1) > 0) then
      associate (one => self%parameters(placed(1)))
        params%effects%soft_vein = trim(params%vein_names(one%vein))
        params%effects%soft_fraction = one%fraction
      end associate
    end if
    if (placed(2) > 0) params%effects%disc = disc
    allocate (model)
    call model%init(self%wing, params, failure)
    ok = .not. failure%failed
    if (ok) then
      self%placed = placed
      self%disc = disc
    end if
    if (.not. ok) deallocate (model)
  end subroutine rest_prepare

  !> Returns all parameters at q of the model that `prepare` has made for q.
  function rest_params(self, model, q) result(params)
    class(wing_rest_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: q(:)
    type(solid_params_t) :: params
    integer :: i
    params = model%params
    call params%set(PARAM_PLATE, self%bare%model%params%get(PARAM_PLATE))
    do i = 1, size(q)
      associate (one => self%parameters(i))
        select case (one%kind)
        case (KIND_PARAMETER)
          if (one%is_log) then
            call params%set(one%number, exp(q(i)))
          else
            call params%set(one%number, q(i))
          end if
        case (KIND_SOFT)
          if (i == self%placed(1)) call params%set_named(one%name, exp(q(i)))
        case (KIND_DAMAGE)
          if (i == self%placed(2)) call params%set_named(one%name, exp(q(i)))
        end select
      end associate
    end do
    call scale_membrane(self%parameters, q, params)
  end function rest_params

  !> Returns the axis about which parameter i lets the clamp turn, 1: x, 2: y; 0: the parameter is of another kind.
  integer function rest_clamp(self, model, i) result(axis)
    class(wing_rest_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: i
    axis = 0
    if (self%parameters(i)%kind == KIND_PARAMETER) &
      axis = clamp_axis(model%params%effects, self%parameters(i)%number - model%params%count_basic())
  end function rest_clamp

  !> Finds how all stiffness changes with parameter i at q. `is_any` is false if the parameter does not concern stiffness.
  subroutine rest_direction(self, model, q, i, direction, is_any)
    class(wing_rest_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: i
    type(stiffness_t), intent(inout) :: direction
    logical, intent(out) :: is_any
    is_any = .true.
    associate (one => self%parameters(i))
      select case (one%kind)
      case (KIND_PARAMETER)
        call parameter_direction(model, one%number, direction)
      case (KIND_MEMBRANE)
        call parameter_direction(model, PARAM_PLATE, direction)
      case (KIND_SOFT)
        call hinge_direction(model, one%number, direction)
      case (KIND_DAMAGE)
        if (abs(q(i) - one%null) > 0) then
          call parameter_direction(model, model%params%find(one%name), direction)
        else
          call damage_direction(model, disc_at(self%parameters, i, q), direction)
        end if
      case default
        is_any = .false.
      end select
    end associate
  end subroutine rest_direction

  !> Returns the values of the effects on the masses at q.
  function mass_effects_at(bare, parameters, q) result(effects)
    type(experiment_t), intent(in) :: bare
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    type(mass_effects_t) :: effects
    real(rp) :: disc(3)
    integer :: i
    do i = 1, size(q)
      associate (one => parameters(i))
        if (one%kind == KIND_MASS) then
          if (one%is_log) then
            call effects%set(one%number, exp(q(i)))
          else
            call effects%set(one%number, effects%get(one%number) + q(i))
          end if
        else if (one%kind == KIND_PARAMETER) then
          if (weighs(bare, one)) effects%gradient = effects%gradient + q(i) - one%null
        else if (one%kind == KIND_POINT_MASS .and. abs(q(i)) > 0) then
          disc = disc_at(parameters, i, q)
          call put_mass_at(bare, disc(:2), effects)
          effects%point = q(i)
        end if
      end associate
    end do
  end function mass_effects_at

  !> Tells whether the mass of the membrane follows a parameter, which is its thickness.
  logical function weighs(bare, parameter)
    type(experiment_t), intent(in) :: bare
    type(wing_parameter_t), intent(in) :: parameter
    weighs = parameter%kind == KIND_PARAMETER
    if (weighs) weighs = is_thickness(bare%model%params%effects, parameter%number - bare%model%params%count_basic())
  end function weighs

  !> Moves the point mass of `effects` to this position [m] on the wing.
  subroutine put_mass_at(bare, site, effects)
    type(experiment_t), intent(in) :: bare
    real(rp), intent(in) :: site(2)
    type(mass_effects_t), intent(inout) :: effects
    type(material_point_t) :: found
    found = find_material_point(bare%model%points(:, :bare%model%n_points), bare%model%triangles, bare%model%size, site)
    effects%corner = found%corner
    effects%weight = found%weight
  end subroutine put_mass_at

  !> Returns the damping at q.
  function damping_at(parameters, q) result(damping)
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    type(damping_effects_t) :: damping
    integer :: i
    do i = 1, size(q)
      associate (one => parameters(i))
        if (one%kind == KIND_DAMPING) then
          call damping%set(one%number, merge(exp(min(q(i), 700.0_rp)), q(i), one%is_log))
        else if (one%kind == KIND_RELAXATION .and. abs(q(i)) > 0) then
          call damping%set(DAMPING_RELAXATION, q(i))
          damping%relaxation_time = one%time*exp(q(one%number))
        end if
      end associate
    end do
  end function damping_at

  !> Returns the motion of the base at q, of which there is one at most.
  function shake_at(parameters, q) result(shake)
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    type(shake_t) :: shake
    integer :: i
    do i = 1, size(q)
      if (parameters(i)%kind /= KIND_SHAKE .or. parameters(i)%number == SHAKE_RATE) cycle
      if (.not. abs(q(i)) > 0) cycle
      shake = shake_of(parameters, i, q)
    end do
  end function shake_at

  !> Returns the motion of the base at q to which parameter i belongs.
  function shake_of(parameters, i, q) result(shake)
    type(wing_parameter_t), intent(in) :: parameters(:)
    integer, intent(in) :: i
    real(rp), intent(in) :: q(:)
    type(shake_t) :: shake
    associate (rate => parameters(i)%partner)
      shake%record = parameters(i)%record
      shake%rate = TWO_PI/parameters(i)%time*exp(q(rate))
      shake%amplitude = q(rate - SHAKE_RATE + [SHAKE_SINE, SHAKE_COSINE])
    end associate
  end function shake_of
end module diagnosis_wing_rest
