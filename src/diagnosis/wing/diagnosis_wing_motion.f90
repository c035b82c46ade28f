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
    procedure :: nuisances => motion_nuisances
    procedure :: patterns => motion_patterns
    procedure :: append_labels => motion_append_labels
  end type wing_motion_t

contains

  !> Takes what the measurement of `bare` holds, on a wing of these masses. Both must live as long as this.
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

  !> Returns residuals(n) at q and their derivatives jacobian(n, size(columns)). `ok` is false if the wing at rest is not stable.
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

  !> Returns nuisances(n, 1 + n_nuisances) at q. The first column is what an error of `membrane_sd` of the coordinate of D does to
  !> the residuals, where parameter `membrane` is D; if D is no nuisance (0), the column stays what it was. The others are errors
  !> of the records. `ok` is false if the wing at rest is not stable.
  subroutine motion_nuisances(self, q, membrane, membrane_sd, nuisances, ok)
    class(wing_motion_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), membrane_sd
    integer, intent(in) :: membrane
    real(rp), intent(inout) :: nuisances(:, :)
    logical, intent(out) :: ok
    real(rp) :: residuals(self%n), derivative(self%n, merge(1, 0, membrane > 0))
    call self%evaluate(q, pack([membrane], [membrane > 0]), residuals, derivative, ok)
    if (.not. ok) return
    if (membrane > 0) nuisances(:, 1) = membrane_sd*derivative(:, 1)
    if (self%series%n > 0) call self%series%nuisances(nuisances(self%modes%n + 1:, 2:))
  end subroutine motion_nuisances

  !> Returns patterns(n, :), what unknown causes at site(2, :) [m] do, at the last `nuisances` or `evaluate`; see `site_tangents`.
  subroutine motion_patterns(self, site, radius, patterns)
    class(wing_motion_t), intent(inout) :: self
    real(rp), intent(in) :: site(:, :), radius
    real(rp), intent(inout) :: patterns(:, :)
    integer :: n
    n = self%modes%n
    if (n > 0) call self%modes%patterns(site, radius, patterns(:n, :))
    if (self%series%n > 0) call self%series%patterns(site, radius, patterns(n + 1:, :))
  end subroutine motion_patterns

  !> Adds their surfaces, folds and blocks.
  subroutine motion_append_labels(self, labels)
    class(wing_motion_t), intent(in) :: self
    type(labels_t), intent(inout) :: labels
    if (self%modes%n > 0) call self%modes%append_labels(labels)
    if (self%series%n > 0) call self%series%append_labels(labels)
  end subroutine motion_append_labels
end module diagnosis_wing_motion
