! SPDX-License-Identifier: GPL-3.0-or-later
!> The whole diagnosis of one set of data, whatever simulates it: baseline, design, calibration, odds, nonlinear
!> refits of the leaders, verdict, validation on locations that were left out, intervals.
module diagnosis_engine
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use diagnosis_calibration, only: calibration_t, find_detectable, find_statistics, statistics_t
  use diagnosis_calibration_store, only: calibrate, calibration_store_t
  use diagnosis_decision, only: decide, decision_t, rank_effects, reject_catalogue, take_back_name, LEVEL, &
                                NO_FIT, NO_GAIN, NO_INTERVAL, AT_BOUND, VERDICT_ADEQUATE, VERDICT_INSUFFICIENT, &
                                VERDICT_NAMED, VERDICT_SET, VERDICT_UNKNOWN
  use diagnosis_design, only: build_design, design_t, is_part_of
  use diagnosis_exchange, only: add_finer, find_exchange
  use diagnosis_hypotheses, only: explain, explained_t, hypotheses_t, remainder_log_p
  use diagnosis_intervals, only: find_intervals, find_support, move_to_better
  use diagnosis_noise_share, only: find_share
  use diagnosis_refit, only: fit_baseline, fit_nested, nested_fit_t
  use diagnosis_simulator, only: simulator_t
  use diagnosis_validation, only: compare_folds, validate, validation_t
  use diagnosis_whitener, only: whitener_t
  use measurement_fit, only: fit_options_t
  use measurement_profile, only: interval_t
  implicit none
  private
  public :: diagnosis_options_t, diagnosis_t, refit_t, run_diagnosis

  real(rp), parameter :: LARGEST_SCALE = 2 !< times the variance of the noise, as far as that may be wrong
  integer, parameter :: FEWEST_REST = 30    !< degrees of freedom from which the size of the noise is estimated

  type :: diagnosis_options_t
    !> Of a sum of squares of about a thousand, to a hundredth: log evidences are compared in units of one.
    type(fit_options_t) :: fit = fit_options_t(reduction_tolerance=1.0e-5_rp, most_rejections=4)
    integer :: n_draws = 4000            !< of the bootstrap
    integer(i8) :: seed = 1
    integer :: most_refits = 5           !< leaders that are fitted in full
    logical :: is_scale_known = .false.  !< the declared noise is believed; otherwise its scale is estimated
    logical :: validates = .true.
    logical :: finds_intervals = .true.
  end type diagnosis_options_t

  !> A leader that was fitted in full.
  type :: refit_t
    integer :: candidate = 0
    type(nested_fit_t) :: found
    real(rp) :: gain = 0                 !< of the sum of squares over the baseline, in units of the noise
    real(rp) :: promised = 0             !< the same by the tangents
    real(rp) :: remainder_log_p = 0
  end type refit_t

  !> Everything that came out.
  type :: diagnosis_t
    type(whitener_t) :: whitener
    type(nested_fit_t) :: baseline
    real(rp), allocatable :: spread(:)   !< of the starts, see fit_baseline
    type(design_t) :: design
    type(calibration_t) :: calibration
    real(rp) :: scale = 1                !< estimated over declared variance of the noise
    real(rp), allocatable :: z(:)        !< in units of the noise
    real(rp) :: rest = 0
    real(rp) :: extended_scale = 0       !< variance of what the extended model leaves over that of the noise model
    type(statistics_t) :: statistics
    type(hypotheses_t) :: hypotheses
    type(decision_t) :: linear, decision !< before and after the refits
    type(refit_t), allocatable :: refits(:)
    type(nested_fit_t) :: extended       !< with the causes of the verdict; not found: none
    type(interval_t), allocatable :: intervals(:) !< of the parameters of the causes
    logical :: is_null_excluded = .false. !< for each of the causes
    logical :: is_at_bound = .false.     !< a parameter that excludes its null
    type(validation_t) :: validated, validated_extended
    real(rp) :: gain = 0, gain_error = 0 !< log predictive density per location left out
    logical :: has_gain = .false.
    real(rp), allocatable :: detectable_snr(:) !< (effects)
    integer :: n_design_evaluations = 0
  end type diagnosis_t

contains

  !> Diagnoses from starts(quantities, :) of the baseline. Fails if the baseline has no fit. `store` keeps what is drawn.
  subroutine run_diagnosis(simulator, starts, options, d, failure, store)
    class(simulator_t), intent(inout), target :: simulator
    real(rp), intent(in) :: starts(:, :)
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(out), target :: d
    type(failure_t), intent(out) :: failure
    class(calibration_store_t), intent(inout), optional :: store
    integer :: n_effects
    real(rp), allocatable :: again(:), best(:, :)
    logical :: is_scale_known, has_finer, is_new
    type(design_t) :: finer
    n_effects = size(simulator%effects)
    allocate (d%refits(0))
    call fit_baseline(simulator, starts, options%fit, d%whitener, d%baseline, d%spread, failure)
    if (failure%failed) return
    if (.not. options%is_scale_known) then
      call find_share(simulator, d%baseline%q, is_new)
      best = reshape(d%baseline%q, [size(d%baseline%q), 1])
      if (is_new) call fit_baseline(simulator, best, options%fit, d%whitener, d%baseline, again, failure)
      if (failure%failed) return
    end if
    call build_design(simulator, d%baseline%q, d%design, failure)
    if (failure%failed) return
    call simulator%keep() ! where all refits begin
    ! Without directions that no test uses the noise model is believed.
    is_scale_known = options%is_scale_known .or. d%design%n_rest < FEWEST_REST
    if (simulator%n_observations < 2*simulator%n_baseline) then
      d%decision%verdict = VERDICT_INSUFFICIENT
      allocate (d%decision%causes(0), d%decision%set(0))
      return
    end if
    call calibrate(d%design, n_effects, is_scale_known, options%n_draws, options%seed, d%calibration, store)
    call find_detectable(d%design, d%calibration, n_effects, LEVEL, d%detectable_snr)
    call judge(simulator, options, is_scale_known, d, failure)
    if (failure%failed) return
    if (d%linear%verdict == VERDICT_ADEQUATE .or. d%linear%verdict == VERDICT_INSUFFICIENT) then
      if (options%validates) call validate(simulator, d%baseline%active, d%baseline%q, options%fit, d%validated)
      return
    end if
    call add_finer(simulator, d%design, d%hypotheses%best, has_finer)
    if (has_finer) then
      call build_design(simulator, d%baseline%q, finer, failure, d%design)
      finer%n_rest = d%design%n_rest
      d%design = finer
      if (.not. failure%failed) call judge(simulator, options, is_scale_known, d, failure)
      if (failure%failed) return
    end if
    call refit_leaders(simulator, options, d)
    call confirm(simulator, options, d)
  end subroutine run_diagnosis

  !> What the tangents alone say: z, statistics, odds, and a first verdict. Statistics that are there already are those of
  !> the scan, with which the global p and the size of the noise stay: finer places may leave nothing to tell it from.
  subroutine judge(simulator, options, is_scale_known, d, failure)
    class(simulator_t), intent(inout) :: simulator
    type(diagnosis_options_t), intent(in) :: options
    logical, intent(in) :: is_scale_known
    type(diagnosis_t), intent(inout) :: d
    type(failure_t), intent(out) :: failure
    type(statistics_t) :: scan
    real(rp) :: rest
    integer :: n_effects
    n_effects = size(simulator%effects)
    scan = d%statistics
    rest = d%rest
    if (allocated(d%z)) deallocate (d%z)
    allocate (d%z(d%design%k))
    call compress_at(simulator, d%baseline%q, d%design, d%z, d%rest, failure)
    if (failure%failed) return
    if (allocated(scan%effect)) d%rest = rest
    call find_statistics(d%design, n_effects, is_scale_known, d%z, d%rest, d%statistics)
    if (allocated(scan%effect)) then
      d%statistics%effect = scan%effect
      d%statistics%unknown = scan%unknown
    end if
    if (.not. is_scale_known) d%scale = d%rest/d%design%n_rest
    d%z = d%z/sqrt(d%scale)
    call d%hypotheses%init(d%design, n_effects, d%z)
    call decide(d%design, d%calibration, d%statistics, d%hypotheses, d%z, options%seed, d%linear)
    d%decision = d%linear
  end subroutine judge

  !> z and rest of the data at the point q.
  subroutine compress_at(simulator, q, design, z, rest, failure)
    class(simulator_t), intent(inout) :: simulator
    real(rp), intent(in) :: q(:)
    type(design_t), intent(in) :: design
    real(rp), intent(out) :: z(:), rest
    type(failure_t), intent(out) :: failure
    real(rp) :: residuals(simulator%n_observations), jacobian(simulator%n_observations, 0)
    logical :: is_valid
    call simulator%evaluate(q, [integer ::], residuals, jacobian, is_valid)
    if (.not. is_valid) then
      z = 0
      rest = 0
      call failure%raise('the simulator has no result at a point that was fitted')
      return
    end if
    call design%compress(residuals, q(:simulator%n_baseline), z, rest)
  end subroutine compress_at

  !> Fits the leaders in full, corrects their evidence by what the linear approximation has missed, and decides anew. One
  !> that lies far behind in that approximation is not fitted, unless others have shown it to be wrong by as much; a part of
  !> a fitted one is; and if most of the misfit is left, all are until one leaves less. An unknown cause, or several together,
  !> are the answer only after all were fitted that the tangents prefer to nothing: some effects change their shape with
  !> their strength.
  subroutine refit_leaders(simulator, options, d)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout) :: d
    real(rp), parameter :: FAR = 10.0_rp ! of the log evidence
    type(refit_t) :: one
    type(explained_t) :: alone
    real(rp) :: linear(size(d%hypotheses%effect)), least
    logical :: is_tried(size(d%hypotheses%effect))
    integer, allocatable :: order(:)
    integer :: i, round, n_fitted
    order = rank_effects(d%hypotheses)
    linear = d%hypotheses%effect
    least = huge(least)
    is_tried = .false.
    do round = 1, 2
      n_fitted = size(d%refits)
      do i = 1, size(order)
        one%candidate = d%hypotheses%best(order(i))
        if (is_tried(order(i)) .or. .not. is_worth_it()) cycle
        is_tried(order(i)) = .true.
        call fit_extended(simulator, options, d, [one%candidate], one%found)
        if (.not. one%found%is_found) cycle
        call explain(d%design, [one%candidate], d%z, alone)
        one%promised = alone%square
        call take_refit(simulator, d, one)
        d%refits = [d%refits, one]
        least = min(least, one%found%chi2/max(1, simulator%n_observations - size(one%found%active)))
      end do
      if (round == 2 .and. size(d%refits) == n_fitted) exit
      do i = n_fitted + 1, size(d%refits)
        if (is_behind(d%design%candidates(d%refits(i)%candidate)%effect)) cycle
        call improve_place(simulator, options, d, d%refits(i))
      end do
      call d%hypotheses%correct_unknown(d%design)
      call decide(d%design, d%calibration, d%statistics, d%hypotheses, d%z, options%seed, d%decision)
      if (d%decision%verdict /= VERDICT_UNKNOWN .and. size(d%decision%causes) < 2) exit
    end do

  contains

    !> Whether the effect in place i of the order is to be fitted in this round.
    logical function is_worth_it()
      integer :: k
      if (round == 2) then
        is_worth_it = linear(order(i)) > 0
        return
      end if
      is_worth_it = any([(is_part_of(d%design%candidates(one%candidate), d%design%candidates(d%refits(k)%candidate)), &
                          k=1, size(d%refits))])
      if (is_worth_it) return
      is_worth_it = i <= options%most_refits .or. least >= LARGEST_SCALE
      if (.not. is_worth_it .or. any(d%linear%set == order(i))) return
      is_worth_it = linear(order(i)) >= linear(order(1)) - FAR - maxval(abs(d%hypotheses%correction))
    end function is_worth_it

    !> Whether effect e has become so improbable that fits are not worth their time.
    logical function is_behind(e)
      integer, intent(in) :: e
      is_behind = d%hypotheses%effect(e) < maxval(d%hypotheses%effect) - FAR
    end function is_behind

  end subroutine refit_leaders

  !> Enters what a refit found.
  subroutine take_refit(simulator, d, one)
    class(simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(inout) :: d
    type(refit_t), intent(inout) :: one
    type(explained_t) :: alone
    type(failure_t) :: failure
    real(rp) :: z(d%design%k), rest
    one%gain = (d%baseline%cost() - one%found%cost())/d%scale
    call explain(d%design, [one%candidate], d%z, alone)
    call compress_at(simulator, one%found%q, d%design, z, rest, failure)
    if (failure%failed) return
    z = z/sqrt(d%scale)
    z = z - matmul(alone%basis, matmul(z, alone%basis))
    one%remainder_log_p = min(0.0_rp, remainder_log_p(d%design, d%calibration, z))
    associate (e => d%design%candidates(one%candidate)%effect)
      d%hypotheses%best(e) = one%candidate
      call d%hypotheses%correct(e, 0.5_rp*(one%gain - one%promised), one%remainder_log_p, z + d%z - alone%left)
    end associate
  end subroutine take_refit

  !> Exchanges the variant of a refit for others of its effect as long as they promise to be better, and are.
  subroutine improve_place(simulator, options, d, one)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout) :: d
    type(refit_t), intent(inout) :: one
    integer, parameter :: MOST = 4
    real(rp), parameter :: WORTH = 2.0_rp ! of the sum of squares, in units of the noise
    type(refit_t) :: other
    real(rp) :: gain
    integer :: n
    other = one
    do n = 1, MOST
      call find_exchange(simulator, d%design, d%whitener, one%candidate, one%found, other%candidate, gain)
      if (other%candidate == 0 .or. gain < WORTH*d%scale) return
      call fit_extended(simulator, options, d, [other%candidate], other%found, one)
      if (.not. other%found%is_found) return
      if (other%found%cost() > one%found%cost() - WORTH*d%scale) return
      call take_refit(simulator, d, other)
      one = other
    end do
  end subroutine improve_place

  !> The baseline with candidates, fitted in full: from the fit of the baseline, and if that finds much less than the
  !> tangents promise, also from the values before any fit, as joints that a wrong model made rigid do not come back.
  !> `near`, where given, is the fit of another variant, from which one candidate is then fitted.
  subroutine fit_extended(simulator, options, d, candidates, found, near)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(in), target :: d
    integer, intent(in) :: candidates(:)
    type(nested_fit_t), intent(out) :: found
    type(refit_t), intent(in), optional :: near
    real(rp), parameter :: DISAPPOINTING = 20.0_rp ! of the sum of squares
    type(nested_fit_t) :: other
    type(explained_t) :: together
    integer, allocatable :: active(:)
    real(rp) :: q(size(simulator%quantities)), usual(size(simulator%quantities))
    integer :: i
    do i = 1, size(d%refits)
      if (size(candidates) > 1 .or. d%refits(i)%candidate /= candidates(1)) cycle
      found = d%refits(i)%found
      return
    end do
    active = d%baseline%active
    q = simulator%null_point()
    do i = 1, size(candidates)
      associate (one => d%design%candidates(candidates(i)))
        active = [active, one%columns]
        if (one%df > 0) q(one%columns) = q(one%columns) - matmul(one%solve, matmul(d%z*sqrt(d%scale), one%basis))
      end associate
    end do
    usual = q
    call simulator%recall()
    if (present(near)) then
      associate (old => d%design%candidates(near%candidate)%columns, new => d%design%candidates(candidates(1))%columns)
        q = near%found%q
        q(old) = simulator%quantities(old)%null
        q(new) = near%found%q(old)
      end associate
      call fit_nested(simulator, d%whitener, active, q, options%fit, found, usual)
      return
    end if
    call fit_nested(simulator, d%whitener, active, d%baseline%q, options%fit, found, usual)
    call explain(d%design, candidates, d%z, together)
    if (found%is_found .and. d%baseline%cost() - found%cost() > d%scale*(together%square - DISAPPOINTING)) return
    call simulator%recall()
    q = max(simulator%quantities%lower, min(simulator%quantities%upper, q))
    call fit_nested(simulator, d%whitener, active, q, options%fit, other, usual)
    if (.not. other%is_found) return
    if (.not. found%is_found .or. other%cost() < found%cost()) found = other
  end subroutine fit_extended

  !> The causes of the verdict: fitted together, with intervals, and tried on locations that the fit did not see. A name
  !> is not given if a cause of it has no interval that excludes the null, or an estimate that stands at a bound, or if it
  !> does not predict better. The rest of several causes gets no name either, as it has been found to explain too little.
  subroutine confirm(simulator, options, d)
    class(simulator_t), intent(inout), target :: simulator
    type(diagnosis_options_t), intent(in) :: options
    type(diagnosis_t), intent(inout), target :: d
    logical :: ok
    if (size(d%decision%causes) == 0) return
    call fit_extended(simulator, options, d, d%decision%causes, d%extended)
    if (.not. d%extended%is_found) then
      if (d%decision%verdict == VERDICT_NAMED) call take_back_name(d%decision, NO_FIT)
      return
    end if
    d%extended_scale = d%extended%chi2/max(1, simulator%n_observations - size(d%extended%active))
    ! Whatever the causes explain, most of the misfit is something else.
    if (d%extended_scale > LARGEST_SCALE .and. any(d%decision%verdict == [VERDICT_NAMED, VERDICT_SET])) then
      call reject_catalogue(d%decision, max(1 - LEVEL, d%decision%posterior_unknown))
    end if
    if (options%finds_intervals) then
      call find_intervals(simulator, d%whitener, d%scale, options%fit, d%extended, d%intervals)
      call move_to_better(simulator, d%whitener, options%fit, d%intervals, d%extended, ok)
      if (ok) call find_intervals(simulator, d%whitener, d%scale, options%fit, d%extended, d%intervals)
      call find_support(simulator%quantities, d%design%candidates(d%decision%causes), simulator%n_baseline, &
                        d%extended, d%intervals, d%is_null_excluded, d%is_at_bound)
    end if
    if (options%validates) then
      call validate(simulator, d%baseline%active, d%baseline%q, options%fit, d%validated)
      call validate(simulator, d%extended%active, d%extended%q, options%fit, d%validated_extended)
      call compare_folds(d%validated, d%validated_extended, d%gain, d%gain_error, ok)
      d%has_gain = ok
    end if
    if (d%decision%verdict /= VERDICT_NAMED) return
    if (options%finds_intervals .and. .not. d%is_null_excluded) then
      call take_back_name(d%decision, NO_INTERVAL)
    else if (d%is_at_bound) then
      call take_back_name(d%decision, AT_BOUND)
    else if (options%validates .and. .not. (d%has_gain .and. d%gain > d%gain_error)) then
      call take_back_name(d%decision, NO_GAIN)
    end if
  end subroutine confirm
end module diagnosis_engine
