! SPDX-License-Identifier: GPL-3.0-or-later
!> Collects all observations of a wing in motion: natural modes, then the records of a wing that rings. In vectors of
!> observations they follow bending tests. Rank 0 computes them.
module diagnosis_wing_motion
  use base_kinds, only: rp
  use diagnosis_wing_modes, only: wing_modes_t
  use diagnosis_wing_parameters, only: wing_parameter_t
  use diagnosis_wing_series, only: wing_series_t
  use inference_simulator, only: labels_t
  use measurement_experiment, only: experiment_t
  use solid_mass_effects, only: mass_parts_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_motion_t

  type :: wing_motion_t
    integer :: n = 0           !< observations
    integer :: n_nuisances = 0 !< of records
    type(wing_modes_t) :: modes
    type(wing_series_t) :: series
  contains
    procedure :: init => motion_init
    procedure :: free => motion_free
    procedure :: evaluate => motion_evaluate
    procedure :: directions => motion_directions
    procedure :: append_labels => motion_append_labels
  end type wing_motion_t

contains

  !> What the measurement of `bare` holds, on a wing of these masses; both must live as long as this.
  subroutine motion_init(self, bare, wing, parameters, parts)
    class(wing_motion_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(mass_parts_t), intent(in) :: parts
    if (bare%measurement%count_modes() > 0) call self%modes%init(bare, wing, parameters, parts)
    if (bare%measurement%count_series() > 0) call self%series%init(bare, wing, parameters, parts)
    self%n = self%modes%n + self%series%n
    self%n_nuisances = self%series%n_nuisances
  end subroutine motion_init

  !> Releases everything.
  subroutine motion_free(self)
    class(wing_motion_t), intent(inout) :: self
    call self%modes%free()
    call self%series%free()
    self%n = 0
  end subroutine motion_free

  !> residuals(n) at q and their derivatives jacobian(n, size(columns)); `ok` false: the wing at rest is not stable.
  subroutine motion_evaluate(self, q, columns, residuals, jacobian, ok)
    class(wing_motion_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: ok
    integer :: n
    n = self%modes%n
    ok = .true.
    if (n > 0) call self%modes%evaluate(q, residuals(:n), ok)
    if (n > 0 .and. ok) call self%modes%tangents(q, columns, jacobian(:n, :))
    if (self%series%n == 0 .or. .not. ok) return
    call self%series%evaluate(q, residuals(n + 1:), ok)
    if (ok) call self%series%tangents(q, columns, jacobian(n + 1:, :))
  end subroutine motion_evaluate

  !> At q: membrane(n) is what an error of D of membrane_sd does, where parameter `number` is D (0: D is no nuisance);
  !> record_nuisances(n, n_nuisances) are those of the records; patterns(n, :) those of unknown causes, with no columns if they are
  !> not wanted.
  subroutine motion_directions(self, q, number, membrane_sd, site, radius, membrane, record_nuisances, patterns, ok)
    class(wing_motion_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), membrane_sd, site(:, :), radius
    integer, intent(in) :: number
    real(rp), intent(inout) :: membrane(:), record_nuisances(:, :), patterns(:, :)
    logical, intent(out) :: ok
    integer :: n
    n = self%modes%n
    ok = .true.
    if (n > 0) call self%modes%directions(q, number, membrane_sd, site, radius, membrane(:n), patterns(:n, :), ok)
    if (self%series%n == 0 .or. .not. ok) return
    call self%series%directions(q, number, membrane_sd, site, radius, membrane(n + 1:), record_nuisances(n + 1:, :), &
                                patterns(n + 1:, :), ok)
  end subroutine motion_directions

  !> Adds their surfaces, folds and blocks.
  subroutine motion_append_labels(self, labels)
    class(wing_motion_t), intent(in) :: self
    type(labels_t), intent(inout) :: labels
    if (self%modes%n > 0) call self%modes%append_labels(labels)
    if (self%series%n > 0) call self%series%append_labels(labels)
  end subroutine motion_append_labels
end module diagnosis_wing_motion
