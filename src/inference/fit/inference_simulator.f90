! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines what the statistics need of a simulator and of an experiment, whatever they are: observations, their covariance, a
!> baseline model with unknowns, and candidates for what it lacks.
!>
!> All parameters are in one vector: the unknowns of the baseline, then those of the effects, which have a null value at which the
!> effect is absent. A candidate is an effect with one or more variants (positions, for instance). A variant is a set of
!> parameters that are released at the same time. Types that extend `simulator_t` represent surfaces, vibrations or forces.
module inference_simulator
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use inference_probability, only: MAP_OF_BENDING
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: simulator_t, labels_t, effect_t, variant_t

  !> Error of a tangent over its length, if it is the solution of linear equations: rounding times a condition of about 1e7.
  real(rp), parameter, public :: TANGENT_ERROR = 1.0e-9_rp

  !> One way in which an effect may be present.
  type :: variant_t
    character(:), allocatable :: label        !< words for its position, or empty
    integer, allocatable :: columns(:)        !< parameters that it releases
    real(rp) :: site(2) = 0                  !< [m] its position, if it has one
    !> The variant is not part of the scan. It is tried after the scan has found its effect nearby and the variant is released.
    logical :: is_finer = .false., is_released = .false.
    real(rp), allocatable :: place(:)         !< coordinates of its place, if its effect has a variant at any place
  contains
    procedure :: is_tried => variant_is_tried
  end type variant_t

  !> An entry of the catalogue.
  type :: effect_t
    character(:), allocatable :: name         !< a word, as in ini files
    character(:), allocatable :: title
    character(:), allocatable :: sentence     !< for a biologist
    logical :: is_measurement = .false.       !< it belongs to the measurement, not to the measured object
    character(:), allocatable :: missing      !< what the data lack to test it; empty: nothing
    type(variant_t), allocatable :: variants(:)
    !> The variant whose place is not on a lattice: parameters have its coordinates, each with the first step of a search as sd.
    !> It has one parameter besides these, its strength, and is released once a search has found a place. 0: there is none.
    integer :: anywhere = 0
    integer, allocatable :: place_columns(:)  !< the parameters of that place, which belong to no variant
    real(rp), allocatable :: place(:)         !< coordinates that a search has found, in the units of their parameters
    real(rp) :: strength = 0                  !< about the best one there
  contains
    procedure :: is_testable => effect_is_testable
  end type effect_t

  !> The group to which every observation belongs. Surfaces are numbered from 1; arrays over surfaces have this number as index.
  type :: labels_t
    integer, allocatable :: surface(:)        !< (n) load under which it was observed
    integer, allocatable :: block(:)          !< (n) observations of different blocks have independent errors
    real(rp), allocatable :: site(:, :)      !< (2, n) [m]
    real(rp), allocatable :: observed(:)      !< (n) what was observed
    integer, allocatable :: fold(:)           !< (surfaces) location: all levels and repeats of it are one fold
    real(rp), allocatable :: level(:)         !< (surfaces) signed strength of the load
    real(rp), allocatable :: order(:)         !< (surfaces) in the sequence of measurements, 0: not given
    real(rp), allocatable :: hold(:)          !< (surfaces) [s], negative: not given
    real(rp), allocatable :: moment(:)        !< (surfaces) of the load about the root
    integer, allocatable :: replicate(:)           !< (surfaces) first surface under the same load, itself if none
    integer, allocatable :: stage(:)         !< (n) from 0: when it joins the fit of inference_growing_fit; absent: all at once
  end type labels_t

  type, abstract :: simulator_t
    integer :: n_observations = 0
    integer :: n_baseline = 0                 !< parameters 1 .. n_baseline are the unknowns of the baseline
    integer :: n_nuisances = 0                !< directions of errors that are known only by their sd
    !> (at most n_nuisances) Kind 1, 2, .. of each of the first nuisances, or 0. Errors of one kind have one declared sd.
    integer, allocatable :: nuisance_kind(:)
    character(:), allocatable :: nuisance_names(:) !< of the kinds, in the plural
    integer :: n_patterns = 0                 !< of unknown causes
    integer :: n_alone = huge(1)              !< each of the first n_alone of them may also be an unknown cause alone
    integer :: probability_map = MAP_OF_BENDING !< of inference_probability, from the study of such data
    type(labels_t) :: labels
    type(parameter_t), allocatable :: parameters(:) !< by their coordinates; those of the baseline start at their null
    type(effect_t), allocatable :: effects(:)
    !> Parameters whose values may all deviate at the same time, as a field. Their tangents are patterns too, after the others.
    integer, allocatable :: field(:)
    integer, allocatable :: family(:)         !< (n_patterns + size(field)) 1, 2, .. kind of unknown cause
    real(rp), allocatable :: pattern_site(:, :) !< (2, n_patterns + size(field)) [m] position
  contains
    procedure(evaluate_interface), deferred :: evaluate
    procedure(covariance_interface), deferred :: covariance
    procedure(directions_interface), deferred :: directions
    procedure :: initial_state => simulator_initial_state
    procedure :: linearise_at => simulator_linearise_at
    procedure :: has_nonlinear_nuisances => simulator_has_nonlinear_nuisances
    procedure :: tangent_error => simulator_tangent_error
    procedure :: null_point => simulator_null_point
    procedure :: take_places => simulator_take_places
    procedure :: has_place => simulator_has_place
    procedure :: settle_place => simulator_settle_place
    procedure :: has_common_errors => simulator_has_common_errors
    procedure :: independent_fraction => simulator_independent_fraction
  end type simulator_t

  abstract interface
    !> Computes residuals(n), simulated minus observed, at q(parameters), and their derivatives jacobian(n, size(columns)) with
    !> respect to the parameters `columns`. Solutions begin at the shapes of `from`, and `to` holds the shapes that were found.
    !> is_wanted(surfaces), where given, tells which surfaces count. A simulator may leave out the others, whose residuals are then
    !> 0. If `is_valid` is false, there is no result at q, and `to` is `from`.
    subroutine evaluate_interface(self, q, columns, from, residuals, jacobian, is_valid, to, is_wanted)
      import :: simulator_t, solver_state_t, rp
      class(simulator_t), intent(inout) :: self
      real(rp), intent(in) :: q(:)
      integer, intent(in) :: columns(:)
      class(solver_state_t), intent(in) :: from
      real(rp), intent(out) :: residuals(:), jacobian(:, :)
      logical, intent(out) :: is_valid
      class(solver_state_t), allocatable, intent(out), optional :: to
      logical, intent(in), optional :: is_wanted(:)
    end subroutine evaluate_interface

    !> Returns c(size(rows), size(rows)), the covariance of the noise of these observations, which are of one block. If neighbours
    !> have errors in common, independent_fraction is the fraction of the variance of a single error that they do not have in
    !> common. The variance of independent errors does not depend on it.
    subroutine covariance_interface(self, rows, independent_fraction, c)
      import :: simulator_t, rp
      class(simulator_t), intent(in) :: self
      integer, intent(in) :: rows(:)
      real(rp), intent(in) :: independent_fraction
      real(rp), intent(out) :: c(:, :)
    end subroutine covariance_interface

    !> Computes at q nuisances(n, n_nuisances), the change of the residuals by an error of one sd of each nuisance, and
    !> patterns(n, n_patterns), that by an unknown cause of unit strength at each position, or patterns(n, 0). Solutions
    !> begin at the shapes of `from`.
    subroutine directions_interface(self, q, from, nuisances, patterns, is_valid)
      import :: simulator_t, solver_state_t, rp
      class(simulator_t), intent(inout) :: self
      real(rp), intent(in) :: q(:)
      class(solver_state_t), intent(in) :: from
      real(rp), intent(out) :: nuisances(:, :), patterns(:, :)
      logical, intent(out) :: is_valid
    end subroutine directions_interface
  end interface

contains

  !> Tells whether the variant is among the candidates.
  pure elemental logical function variant_is_tried(self) result(is_tried)
    class(variant_t), intent(in) :: self
    is_tried = self%is_released .or. .not. self%is_finer
  end function variant_is_tried

  !> Tells whether the data can show the effect at all.
  pure logical function effect_is_testable(self) result(is_testable)
    class(effect_t), intent(in) :: self
    is_testable = .true.
    if (allocated(self%missing)) is_testable = self%missing == ''
  end function effect_is_testable

  !> Tells whether neighbours have a part of their errors in common, so that the data may show how large this part is.
  pure logical function simulator_has_common_errors(self) result(has_some)
    class(simulator_t), intent(in) :: self
    has_some = .false.
    associate (unused => self)
    end associate
  end function simulator_has_common_errors

  !> Returns the fraction of the variance of a single error that neighbours do not have in common, as it is known before any fit.
  pure real(rp) function simulator_independent_fraction(self) result(fraction)
    class(simulator_t), intent(in) :: self
    fraction = 1
    associate (unused => self)
    end associate
  end function simulator_independent_fraction

  !> Returns the state of a simulator before its first solution. A simulator without internal iterations has an empty state.
  subroutine simulator_initial_state(self, state)
    class(simulator_t), intent(in) :: self
    class(solver_state_t), allocatable, intent(out) :: state
    allocate (state)
    associate (unused => self)
    end associate
  end subroutine simulator_initial_state

  !> Linearises nuisances about errors(n_nuisances), in sd, as far as they are not linear. Residuals are then those with these
  !> errors, minus the linear effect of the errors by the tangents there, which are the new directions. `state` belongs to q, and
  !> holds the errors afterwards. It does not change if q has no result (`is_valid` is false). A whitener needs new directions
  !> afterwards.
  subroutine simulator_linearise_at(self, errors, q, state, is_valid)
    class(simulator_t), intent(inout) :: self
    real(rp), intent(in) :: errors(:), q(:)
    class(solver_state_t), allocatable, intent(inout) :: state
    logical, intent(out) :: is_valid
    is_valid = allocated(state)
    if (is_valid) is_valid = size(errors) == self%n_nuisances .and. size(q) == size(self%parameters)
  end subroutine simulator_linearise_at

  !> Tells whether nuisances are not linear, so that `linearise_at` does something.
  pure logical function simulator_has_nonlinear_nuisances(self) result(has_some)
    class(simulator_t), intent(in) :: self
    has_some = .false.
    associate (unused => self)
    end associate
  end function simulator_has_nonlinear_nuisances

  !> Returns the error of the tangent of parameter i, over the tangent's length.
  pure real(rp) function simulator_tangent_error(self, i) result(error)
    class(simulator_t), intent(in) :: self
    integer, intent(in) :: i
    error = TANGENT_ERROR
    associate (unused => self, nothing => i)
    end associate
  end function simulator_tangent_error

  !> Returns all parameters at their null values, and places where they were found.
  pure function simulator_null_point(self) result(q)
    class(simulator_t), intent(in) :: self
    real(rp) :: q(size(self%parameters))
    q = self%parameters%null
    call self%take_places(q)
  end function simulator_null_point

  !> Sets the coordinates of places in q to those that were found.
  pure subroutine simulator_take_places(self, q)
    class(simulator_t), intent(in) :: self
    real(rp), intent(inout) :: q(:)
    integer :: e
    if (.not. allocated(self%effects)) return
    do e = 1, size(self%effects)
      if (allocated(self%effects(e)%place)) q(self%effects(e)%place_columns) = self%effects(e)%place
    end do
  end subroutine simulator_take_places

  !> Tells whether effect e can be at a place with these coordinates.
  logical function simulator_has_place(self, e, place) result(has_it)
    class(simulator_t), intent(in) :: self
    integer, intent(in) :: e
    real(rp), intent(in) :: place(:)
    has_it = size(place) == size(self%effects(e)%place_columns)
  end function simulator_has_place

  !> Puts the variant of effect e that may be anywhere at a place with these coordinates, and releases it. The first two are its
  !> position [m]; `strength` is about the best value of its parameter.
  subroutine simulator_settle_place(self, e, place, strength)
    class(simulator_t), intent(inout) :: self
    integer, intent(in) :: e
    real(rp), intent(in) :: place(:), strength
    associate (effect => self%effects(e))
      effect%place = place
      effect%strength = strength
      effect%variants(effect%anywhere)%place = place
      effect%variants(effect%anywhere)%site = place(:2)
      effect%variants(effect%anywhere)%is_released = .true.
    end associate
  end subroutine simulator_settle_place
end module inference_simulator
