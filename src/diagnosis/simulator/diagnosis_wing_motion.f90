! SPDX-License-Identifier: GPL-3.0-or-later
!> Collects all observations of a wing in motion: natural modes, then the records of a vibrating wing, then records of the forces
!> on a flapping wing. In vectors of observations they follow bending tests. Rank 0 computes them.
module diagnosis_wing_motion
  use base_kinds, only: rp
  use diagnosis_families, only: FAMILY_FLIGHT, FAMILY_SENSORS
  use diagnosis_flight_data, only: flight_cases_t
  use diagnosis_wing_flights, only: wing_flights_t
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
    integer :: n = 0           !< number of observations
    integer :: n_nuisances = 0 !< number of nuisances, those of records
    type(wing_modes_t) :: modes
    type(wing_series_t) :: series
    type(wing_flights_t) :: flight
  contains
    procedure :: init => motion_init
    procedure :: free => motion_free
    procedure :: evaluate => motion_evaluate
    procedure :: nuisances => motion_nuisances
    procedure :: patterns => motion_patterns
    procedure :: append_labels => motion_append_labels
    procedure :: covariance => motion_covariance
    procedure :: append_patterns => motion_append_patterns
  end type wing_motion_t

contains

  !> Takes the modes and records of the measurement of `bare`, on a wing of these masses. Both must live as long as this.
  subroutine motion_init(self, bare, wing, parameters, parts, flights)
    class(wing_motion_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(mass_parts_t), intent(in) :: parts
    type(flight_cases_t), intent(in) :: flights !< used if it is ready
    if (bare%measurement%count_modes() > 0) call self%modes%init(bare, wing, parameters, parts)
    if (bare%measurement%count_series() > 0) call self%series%init(bare, wing, parameters, parts)
    if (flights%is_ready) call self%flight%init(bare%measurement%flights, parameters, flights)
    self%n = self%modes%n + self%series%n + self%flight%n
    self%n_nuisances = self%series%n_nuisances + self%flight%n_nuisances
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
    integer :: n, m
    n = self%modes%n
    m = n + self%series%n
    ok = .true.
    if (self%flight%n > 0) call self%flight%evaluate(q, columns, residuals(m + 1:), jacobian(m + 1:, :))
    if (n > 0) call self%modes%evaluate(q, residuals(:n), ok)
    if (n > 0 .and. ok) call self%modes%tangents(q, columns, jacobian(:n, :))
    if (self%series%n == 0 .or. .not. ok) return
    call self%series%evaluate(q, residuals(n + 1:m), ok)
    if (ok) call self%series%tangents(q, columns, jacobian(n + 1:m, :))
  end subroutine motion_evaluate

  !> Returns nuisances(n, 1 + n_nuisances) at q. The first column is the effect on the residuals of an error of `membrane_sd` of the
  !> coordinate of D, which is parameter `membrane`. If D is no nuisance (0), this column does not change. The others are the
  !> effects of errors of the records. `ok` is false if the wing at rest is not stable.
  subroutine motion_nuisances(self, q, membrane, membrane_sd, nuisances, ok)
    class(wing_motion_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), membrane_sd
    integer, intent(in) :: membrane
    real(rp), intent(inout) :: nuisances(:, :)
    logical, intent(out) :: ok
    real(rp) :: residuals(self%n), derivative(self%n, merge(1, 0, membrane > 0))
    integer :: n, m, k
    n = self%modes%n
    m = n + self%series%n
    k = self%series%n_nuisances
    call self%evaluate(q, pack([membrane], [membrane > 0]), residuals, derivative, ok)
    if (.not. ok) return
    if (membrane > 0) nuisances(:, 1) = membrane_sd*derivative(:, 1)
    if (self%series%n > 0) call self%series%nuisances(nuisances(n + 1:m, 2:k + 1))
    if (self%flight%n > 0) call self%flight%nuisances(q, nuisances(m + 1:, k + 2:))
  end subroutine motion_nuisances

  !> Returns patterns(n, :), the changes of the residuals that unknown causes would make. First come causes at site(2, :) [m] of
  !> the wing (see `site_tangents`), then errors of sensors, then causes in flights. They are those at the parameters of the last
  !> call of `nuisances` or `evaluate`, which must precede.
  subroutine motion_patterns(self, site, radius, patterns)
    class(wing_motion_t), intent(inout) :: self
    real(rp), intent(in) :: site(:, :), radius
    real(rp), intent(inout) :: patterns(:, :)
    integer :: n, m, first, flown
    if (size(patterns, 2) == 0) return
    n = self%modes%n
    m = n + self%series%n
    flown = size(patterns, 2) - self%flight%n_patterns + 1
    first = flown - self%series%n_sensor_errors
    if (n > 0) call self%modes%patterns(site, radius, patterns(:n, :))
    if (self%series%n > 0) call self%series%patterns(site, radius, patterns(n + 1:m, :))
    if (self%series%n > 0) call self%series%sensor_errors(patterns(n + 1:m, first:flown - 1))
    if (self%flight%n > 0) call self%flight%patterns(patterns(m + 1:, flown:))
  end subroutine motion_patterns

  !> Adds the surfaces, folds and blocks of these observations.
  subroutine motion_append_labels(self, labels)
    class(wing_motion_t), intent(in) :: self
    type(labels_t), intent(inout) :: labels
    if (self%modes%n > 0) call self%modes%append_labels(labels)
    if (self%series%n > 0) call self%series%append_labels(labels)
    if (self%flight%n > 0) call self%flight%append_labels(labels)
  end subroutine motion_append_labels

  !> Adds the labels of the patterns of errors of sensors and of unknown causes in flights after the others, as separate families.
  !> The entries of `family` and `site` that belong to no pattern stay at the end.
  subroutine motion_append_patterns(self, n_patterns, family, site, kinds)
    class(wing_motion_t), intent(in) :: self
    integer, intent(inout) :: n_patterns
    integer, allocatable, intent(inout) :: family(:)
    real(rp), allocatable, intent(inout) :: site(:, :)
    integer, allocatable, intent(inout) :: kinds(:) !< of the families
    call append(self%series%n_sensor_errors, FAMILY_SENSORS)
    call append(self%flight%n_patterns, FAMILY_FLIGHT)

  contains

    subroutine append(n, kind)
      integer, intent(in) :: n, kind
      integer :: m
      if (n == 0) return
      m = 0
      if (size(family) > 0) m = maxval(family)
      kinds = [kinds(:m), kind]
      family = [family(:n_patterns), spread(m + 1, 1, n), family(n_patterns + 1:)]
      site = reshape([site(:, :n_patterns), spread([0.0_rp, 0.0_rp], 2, n), site(:, n_patterns + 1:)], [2, size(family)])
      n_patterns = n_patterns + n
    end subroutine append

  end subroutine motion_append_patterns

  !> Returns in c the covariance of the observations `rows`, which belong to one block.
  subroutine motion_covariance(self, rows, c)
    class(wing_motion_t), intent(in) :: self
    integer, intent(in) :: rows(:)
    real(rp), intent(out) :: c(:, :)
    integer :: i, m
    m = self%modes%n + self%series%n
    if (minval(rows) > m) then
      call self%flight%covariance(rows - m, c)
      return
    end if
    c = 0
    do i = 1, size(rows)
      c(i, i) = 1
    end do
  end subroutine motion_covariance
end module diagnosis_wing_motion
