! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the residuals of the records of a vibrating wing in units of their sd (the covariance is the unit matrix), and exact
!> tangents of all parameters of the catalogue. The size and the time of every excitation are nuisances. Each trace is a surface
!> and a fold by itself. Without records there are no observations here.
module diagnosis_wing_series
  use base_kinds, only: rp
  use diagnosis_wing_labels, only: append_surface
  use diagnosis_wing_parameters, only: wing_parameter_t, KIND_DAMPING, KIND_RELAXATION, KIND_RELAXATION_TIME
  use diagnosis_wing_rest, only: damping_at, mass_effects_at, wing_rest_t
  use diagnosis_wing_tangents, only: mechanics_tangent, site_tangents
  use inference_simulator, only: labels_t
  use measurement_experiment, only: experiment_t
  use measurement_series_simulation, only: series_simulation_t
  use solid_damping_effects, only: DAMPING_RELAXATION, DAMPING_TIME
  use solid_mass_effects, only: mass_effects_t, mass_parts_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_stiffness, only: stiffness_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_series_t

  type :: wing_series_t
    integer :: n = 0                                 !< observations
    integer :: n_nuisances = 0
    !> There is one for each simulator. It is never copied.
    type(series_simulation_t), pointer :: simulation => null()
    type(wing_rest_t), private :: rest
    type(mass_parts_t), private :: parts
    type(stiffness_t), private :: direction
    type(mass_effects_t), private :: effects
  contains
    procedure :: init => series_init
    procedure :: free => series_free
    procedure :: evaluate => series_evaluate
    procedure :: tangents => series_tangents
    procedure :: nuisances => series_nuisances
    procedure :: patterns => series_patterns
    procedure :: append_labels => series_append_labels
    procedure, private :: tangent => series_tangent
    procedure, private :: prepare => series_prepare
  end type wing_series_t

contains

  !> Takes the records of the measurement of `bare`, on a wing of these masses. Both must live as long as this.
  subroutine series_init(self, bare, wing, parameters, parts)
    class(wing_series_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(mass_parts_t), intent(in) :: parts
    logical :: ok
    call self%rest%init(bare, wing, parameters)
    self%parts = parts
    if (.not. associated(self%simulation)) allocate (self%simulation)
    call self%prepare([real(rp) ::], ok)
    self%n = self%simulation%n
    self%n_nuisances = 2*bare%measurement%count_series()
  end subroutine series_init

  !> Releases everything.
  subroutine series_free(self)
    class(wing_series_t), intent(inout) :: self
    if (associated(self%simulation)) then
      call self%simulation%free()
      deallocate (self%simulation)
    end if
    self%n = 0
    self%n_nuisances = 0
  end subroutine series_free

  !> Gives the simulation the model for q.
  subroutine series_prepare(self, q, ok)
    class(wing_series_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    logical, intent(out) :: ok
    type(solid_model_t), allocatable :: model
    call self%rest%prepare(q, model, ok)
    if (allocated(model)) call self%simulation%init(self%rest%bare%measurement, model, self%parts)
  end subroutine series_prepare

  !> Computes residuals(n) at q, about which later tangents are taken. `ok` is false if the wing at rest is not stable.
  subroutine series_evaluate(self, q, residuals, ok)
    class(wing_series_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: residuals(:)
    logical, intent(out) :: ok
    type(solid_model_t), pointer :: model
    type(solid_params_t) :: params
    residuals = 0
    call self%prepare(q, ok)
    if (.not. ok) return
    model => self%simulation%model()
    params = self%rest%params(model, q)
    self%effects = mass_effects_at(self%rest%bare, self%rest%parameters, q)
    call self%simulation%evaluate(params, self%effects, damping_at(self%rest%parameters, q), residuals, ok)
  end subroutine series_evaluate

  !> Returns column(n), the derivative of the residuals with respect to parameter i at q, after `evaluate` there.
  subroutine series_tangent(self, q, i, column)
    class(wing_series_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: i
    real(rp), intent(out) :: column(:)
    column = 0
    associate (one => self%rest%parameters(i))
      select case (one%kind)
      case (KIND_DAMPING)
        call self%simulation%damping_tangent(one%number, 0.0_rp, column)
        if (one%is_log) column = exp(q(i))*column
      case (KIND_RELAXATION)
        call self%simulation%damping_tangent(DAMPING_RELAXATION, one%time*exp(q(one%number)), column)
      case (KIND_RELAXATION_TIME)
        if (abs(q(one%number)) > 0) call self%simulation%damping_tangent(DAMPING_TIME, 0.0_rp, column)
      case default
        call mechanics_tangent(self%simulation, self%rest, self%effects, q, i, self%direction, column)
      end select
    end associate
  end subroutine series_tangent

  !> Returns jacobian(n, size(columns)) with respect to the parameters `columns`, after `evaluate`.
  subroutine series_tangents(self, q, columns, jacobian)
    class(wing_series_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    real(rp), intent(out) :: jacobian(:, :)
    integer :: k
    do k = 1, size(columns)
      call self%tangent(q, columns(k), jacobian(:, k))
    end do
  end subroutine series_tangents

  !> Computes nuisances(n, n_nuisances), the effects on the residuals of errors of one sd of the sizes and times of the excitations,
  !> at the point of the last `evaluate`.
  subroutine series_nuisances(self, nuisances)
    class(wing_series_t), intent(inout) :: self
    real(rp), intent(inout) :: nuisances(:, :)
    call self%simulation%nuisances(nuisances)
  end subroutine series_nuisances

  !> Computes patterns(n, :), the effects of unknown causes at site(2, :) [m], at the point of the last `evaluate`; see
  !> `site_tangents`.
  subroutine series_patterns(self, site, radius, patterns)
    class(wing_series_t), intent(inout) :: self
    real(rp), intent(in) :: site(:, :), radius
    real(rp), intent(inout) :: patterns(:, :)
    call site_tangents(self%simulation, self%rest, self%effects, site, radius, self%direction, patterns)
  end subroutine series_patterns

  !> Adds labels. Every trace is a surface with its own fold and block.
  subroutine series_append_labels(self, labels)
    class(wing_series_t), intent(in) :: self
    type(labels_t), intent(inout) :: labels
    integer :: i, j
    do i = 1, size(self%simulation%series)
      associate (s => self%simulation%series(i))
        do j = 1, size(s%sigma)
          if (any(s%is_known(:, j))) call append_surface(labels, count(s%is_known(:, j)), s%place(:, j))
        end do
      end associate
    end do
  end subroutine series_append_labels
end module diagnosis_wing_series
