! SPDX-License-Identifier: GPL-3.0-or-later
!> How well a model predicts what it was not fitted to: locations are left out one after another, each with all its
!> levels, signs and repeats, and predicted by the fit to the others.
!>
!> The score of a fold is its log predictive density, normal about the prediction with the covariance of noise and
!> nuisances and what the fit leaves unknown of the parameters, in the linear approximation.
module diagnosis_validation
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_lapack, only: orthogonalise, solve_lower
  use diagnosis_refit, only: fit_nested, nested_fit_t, nested_unknowns
  use diagnosis_simulator, only: simulator_t
  use diagnosis_whitener, only: whitener_t
  use measurement_fit, only: fit_options_t
  use measurement_least_squares, only: unknowns_t
  implicit none
  private
  public :: validation_t, validate, compare_folds

  !> One row for every fold that could be predicted.
  type :: validation_t
    integer, allocatable :: fold(:)
    integer, allocatable :: n(:)           !< observations
    real(rp), allocatable :: density(:)    !< log predictive density, without the constant
    real(rp), allocatable :: chi2(:)       !< of the prediction over noise and nuisances alone
    real(rp), allocatable :: square(:)     !< sum of squared differences in the observations' units
    logical :: is_complete = .false.       !< all folds could be predicted
  end type validation_t

contains

  !> Validates the model with the quantities `active` free, from its fit q to everything.
  subroutine validate(simulator, active, q, options, validation)
    class(simulator_t), intent(inout), target :: simulator
    integer, intent(in) :: active(:)
    real(rp), intent(in) :: q(:)
    type(fit_options_t), intent(in) :: options
    type(validation_t), intent(out) :: validation
    integer :: f
    real(rp) :: scores(3)
    integer, allocatable :: outside(:)
    logical :: ok
    allocate (validation%fold(0), validation%n(0), validation%density(0), validation%chi2(0), validation%square(0))
    validation%is_complete = .true.
    do f = 1, maxval(simulator%labels%fold)
      call predict_fold(simulator, f, active, q, options, outside, scores, ok)
      if (size(outside) == 0) cycle
      validation%is_complete = validation%is_complete .and. ok
      if (.not. ok) cycle
      validation%fold = [validation%fold, f]
      validation%n = [validation%n, size(outside)]
      validation%density = [validation%density, scores(1)]
      validation%chi2 = [validation%chi2, scores(2)]
      validation%square = [validation%square, scores(3)]
    end do
  end subroutine validate

  !> Scores of fold f: log density, chi^2, sum of squares.
  subroutine predict_fold(simulator, f, active, q, options, outside, scores, ok)
    class(simulator_t), intent(inout), target :: simulator
    integer, intent(in) :: f, active(:)
    real(rp), intent(in) :: q(:)
    type(fit_options_t), intent(in) :: options
    integer, allocatable, intent(out) :: outside(:)
    real(rp), intent(out) :: scores(3)
    logical, intent(out) :: ok
    type(whitener_t), target :: inner, outer
    type(nested_fit_t) :: found
    type(failure_t) :: failure
    real(rp), allocatable :: residuals(:), jacobian(:, :), nuisances(:, :), patterns(:, :), left(:)
    integer, allocatable :: inside(:)
    integer :: i, n
    logical :: is_valid
    scores = 0
    n = simulator%n_observations
    associate (fold => simulator%labels%fold(simulator%labels%surface))
      outside = pack([(i, i=1, n)], fold == f)
      inside = pack([(i, i=1, n)], fold /= f)
    end associate
    ok = size(inside) > size(active)
    if (size(outside) == 0 .or. .not. ok) return
    allocate (residuals(n), jacobian(n, size(active)), nuisances(n, simulator%n_nuisances), &
              patterns(n, simulator%n_patterns))
    call directions_at(simulator, q, active, residuals, jacobian, nuisances, patterns, is_valid)
    ok = is_valid
    if (ok) call inner%init(simulator, inside, failure)
    ok = ok .and. .not. failure%failed
    if (.not. ok) return
    call inner%add_directions(nuisances(inside, :))
    call fit_nested(simulator, inner, active, q, options, found)
    ok = found%is_found
    if (ok) call directions_at(simulator, found%q, active, residuals, jacobian, nuisances, patterns, is_valid)
    ok = ok .and. is_valid
    if (ok) call outer%init(simulator, outside, failure)
    ok = ok .and. .not. failure%failed
    if (.not. ok) return
    scores(3) = sum(residuals(outside)**2)
    call outer%add_directions(nuisances(outside, :))
    left = residuals(outside)
    call outer%apply_one(left)
    scores(2) = sum(left**2)
    call add_uncertainty(simulator, active, inner, jacobian, nuisances, outside, outer)
    left = residuals(outside)
    call outer%apply_one(left)
    scores(1) = -0.5_rp*(sum(left**2) + outer%log_determinant)
  end subroutine predict_fold

  subroutine directions_at(simulator, q, active, residuals, jacobian, nuisances, patterns, is_valid)
    class(simulator_t), intent(inout) :: simulator
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: active(:)
    real(rp), intent(out) :: residuals(:), jacobian(:, :), nuisances(:, :), patterns(:, :)
    logical, intent(out) :: is_valid
    call simulator%evaluate(q, active, residuals, jacobian, is_valid)
    if (.not. is_valid) return
    call simulator%accept()
    call simulator%directions(q, nuisances, patterns, is_valid)
  end subroutine directions_at

  !> Gives `outer` the nuisances and, as further directions, J R^-1 with R^T R the inverse posterior covariance of the
  !> parameters.
  subroutine add_uncertainty(simulator, active, inner, jacobian, nuisances, outside, outer)
    class(simulator_t), intent(in) :: simulator
    integer, intent(in) :: active(:), outside(:)
    type(whitener_t), intent(in) :: inner
    real(rp), intent(in) :: jacobian(:, :), nuisances(:, :)
    type(whitener_t), intent(inout) :: outer
    real(rp), parameter :: RIDGE = 1.0e-8_rp ! of the largest derivative, for what neither data nor prior determine
    type(unknowns_t) :: unknowns
    real(rp), allocatable :: rows(:, :), basis(:, :), r(:, :), lower(:, :), directions(:, :), white(:, :)
    real(rp) :: largest
    integer :: i, n
    n = size(active)
    unknowns = nested_unknowns(simulator, active)
    white = jacobian(inner%rows, :)
    call inner%apply(white)
    allocate (rows(inner%n + n, n), source=0.0_rp)
    rows(:inner%n, :) = white
    largest = maxval(norm2(white, 1))
    do i = 1, n
      rows(inner%n + i, i) = RIDGE*largest
      if (unknowns%prior_sd(i) > 0) rows(inner%n + i, i) = rows(inner%n + i, i) + 1/unknowns%prior_sd(i)
    end do
    call orthogonalise(rows, basis, r)
    lower = transpose(r)
    directions = transpose(jacobian(outside, :))
    call solve_lower(lower, directions)
    white = reshape([nuisances(outside, :), transpose(directions)], &
                    [size(outside), size(nuisances, 2) + n])
    call outer%add_directions(white)
  end subroutine add_uncertainty

  !> Mean gain of log predictive density per fold of `other` over `one`, and the standard error of the mean over folds
  !> that both predict; their number is at least 2 if `ok`.
  subroutine compare_folds(one, other, gain, standard_error, ok)
    type(validation_t), intent(in) :: one, other
    real(rp), intent(out) :: gain, standard_error
    logical, intent(out) :: ok
    real(rp), allocatable :: gains(:)
    integer :: i, k
    allocate (gains(0))
    do i = 1, size(one%fold)
      do k = 1, size(other%fold)
        if (one%fold(i) == other%fold(k)) gains = [gains, other%density(k) - one%density(i)]
      end do
    end do
    gain = 0
    standard_error = huge(standard_error)
    ok = size(gains) >= 2
    if (.not. ok) return
    gain = sum(gains)/size(gains)
    standard_error = sqrt(sum((gains - gain)**2)/(size(gains) - 1)/size(gains))
  end subroutine compare_folds
end module diagnosis_validation
