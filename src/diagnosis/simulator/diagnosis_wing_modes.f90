! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the residuals of the natural modes of a measurement in units of their sd (the covariance is the unit matrix), and
!> exact tangents of all parameters of the catalogue. In vectors of observations modes follow bending tests. Each mode is a
!> surface and a fold by itself. Without modes there are no observations here.
module diagnosis_wing_modes
  use base_kinds, only: rp
  use diagnosis_moving_wing, only: moving_wing_t
  use diagnosis_wing_labels, only: append_surface
  use diagnosis_wing_parameters, only: wing_parameter_t
  use diagnosis_wing_rest, only: damping_at
  use inference_simulator, only: labels_t
  use measurement_experiment, only: experiment_t
  use measurement_mode_simulation, only: mode_simulation_t
  use measurement_motion_simulation, only: motion_simulation_t
  use solid_mass_effects, only: mass_parts_t
  use solid_model, only: solid_model_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_modes_t

  type, extends(moving_wing_t) :: wing_modes_t
    type(mode_simulation_t), pointer :: simulation => null() !< one for each simulator. It is never copied.
  contains
    procedure :: init => modes_init
    procedure :: take_model => modes_take_model
    procedure :: evaluate => modes_evaluate
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
    class(motion_simulation_t), pointer :: mechanics
    allocate (self%simulation)
    mechanics => self%simulation
    call self%start(mechanics, bare, wing, parameters, parts)
  end subroutine modes_init

  !> Gives the simulation this model of the wing at rest.
  subroutine modes_take_model(self, model)
    class(wing_modes_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    call self%simulation%init(self%rest%bare%measurement, model, self%parts, self%rest%bare%options)
  end subroutine modes_take_model

  !> Computes residuals(n) at q, about which later tangents are taken. `ok` is false if the wing at rest is not stable.
  subroutine modes_evaluate(self, q, residuals, ok)
    class(wing_modes_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: residuals(:)
    logical, intent(out) :: ok
    type(solid_model_t), pointer :: model
    ok = self%is_at(q)
    if (ok) then
      call self%take_last(residuals)
      return
    end if
    call self%forget()
    call self%prepare(q, ok)
    if (.not. ok) return
    model => self%simulation%model()
    call self%simulation%evaluate(self%rest%params(model, q), self%effects, damping_at(self%rest%parameters, q), residuals, ok)
    call self%keep(q, residuals, ok)
  end subroutine modes_evaluate

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
