! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the residuals of the natural modes of a measurement in units of their sd (the covariance is the unit matrix), and
!> exact tangents of all parameters of the catalogue. In vectors of observations modes follow bending tests. Each mode is a
!> surface and a fold by itself. Without modes there are no observations here.
module diagnosis_wing_modes
  use base_kinds, only: rp
  use diagnosis_wing_labels, only: append_surface
  use diagnosis_wing_parameters, only: wing_parameter_t
  use diagnosis_wing_rest, only: mass_effects_at, wing_rest_t
  use diagnosis_wing_tangents, only: mechanics_tangent, site_tangents
  use inference_simulator, only: labels_t
  use measurement_experiment, only: experiment_t
  use measurement_mode_simulation, only: mode_simulation_t
  use solid_mass_effects, only: mass_effects_t, mass_parts_t
  use solid_model, only: solid_model_t
  use solid_stiffness, only: stiffness_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_modes_t

  type :: wing_modes_t
    integer :: n = 0                                 !< observations
    !> There is one for each simulator. It is never copied.
    type(mode_simulation_t), pointer :: simulation => null()
    type(wing_rest_t), private :: rest
    type(mass_parts_t), private :: parts
    type(stiffness_t), private :: direction
    type(mass_effects_t), private :: effects
  contains
    procedure :: init => modes_init
    procedure :: free => modes_free
    procedure :: evaluate => modes_evaluate
    procedure :: tangent => modes_tangent
    procedure :: tangents => modes_tangents
    procedure :: patterns => modes_patterns
    procedure :: append_labels => modes_append_labels
  end type wing_modes_t

contains

  !> Takes the modes of the measurement of `bare`, on a wing of these masses. Both must live as long as this.
  subroutine modes_init(self, bare, wing, parameters, parts)
    class(wing_modes_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(mass_parts_t), intent(in) :: parts
    logical :: ok
    call self%rest%init(bare, wing, parameters)
    self%parts = parts
    if (.not. associated(self%simulation)) allocate (self%simulation)
    call prepare(self, [real(rp) ::], ok)
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

  !> Gives the simulation the model for q.
  subroutine prepare(self, q, ok)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    logical, intent(out) :: ok
    type(solid_model_t), allocatable :: model
    call self%rest%prepare(q, model, ok)
    if (allocated(model)) call self%simulation%init(self%rest%bare%measurement, model, self%parts, &
                                                     self%rest%bare%options)
  end subroutine prepare

  !> Computes residuals(n) at q, about which later tangents are taken. `ok` is false if the wing at rest is not stable.
  subroutine modes_evaluate(self, q, residuals, ok)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: residuals(:)
    logical, intent(out) :: ok
    type(solid_model_t), pointer :: model
    call prepare(self, q, ok)
    if (.not. ok) return
    model => self%simulation%model()
    self%effects = mass_effects_at(self%rest%bare, self%rest%parameters, q)
    call self%simulation%evaluate(self%rest%params(model, q), self%effects, residuals, ok)
  end subroutine modes_evaluate

  !> Returns column(n), the derivative of the residuals with respect to parameter i at q, after `evaluate` there.
  subroutine modes_tangent(self, q, i, column)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: i
    real(rp), intent(out) :: column(:)
    call mechanics_tangent(self%simulation, self%rest, self%effects, q, i, self%direction, column)
  end subroutine modes_tangent

  !> Returns jacobian(n, size(columns)) with respect to the parameters `columns`, after `evaluate`.
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

  !> Computes patterns(n, :), the effects of unknown causes at site(2, :) [m], at the point of the last `evaluate`; see
  !> `site_tangents`.
  subroutine modes_patterns(self, site, radius, patterns)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: site(:, :), radius
    real(rp), intent(inout) :: patterns(:, :)
    call site_tangents(self%simulation, self%rest, self%effects, site, radius, self%direction, patterns)
  end subroutine modes_patterns

  !> Adds labels. Every mode is a surface with its own fold and block. Their `observed` is 0.
  subroutine modes_append_labels(self, labels)
    class(wing_modes_t), intent(in) :: self
    type(labels_t), intent(inout) :: labels
    integer :: k
    do k = 1, size(self%simulation%targets)
      call append_surface(labels, self%simulation%targets(k)%n, [0.0_rp, 0.0_rp])
    end do
  end subroutine modes_append_labels
end module diagnosis_wing_modes
