! SPDX-License-Identifier: GPL-3.0-or-later
!> Builds the linear design: everything that can be computed before the residuals are known.
!> J are the whitened tangents of the baseline (priors as further rows) and S those of all effects. The part that the baseline can
!> imitate is projected out: S_perp = (I - Q Q^T) S, Q an orthonormal basis of J. The remainders of all effects and of patterns of
!> unknown causes span k dimensions with the orthonormal basis X. Directions that the errors of the tangents alone can produce are
!> left out (inference_span). z = X^T r contains all that the tests need of the residuals r: k independent numbers of variance 1 if
!> the baseline is true. This is the min-max test of Doehler, Mevel and Zhang, Annual Reviews in Control 42 (2016) 244, which
!> rejects nuisance parameters by projection.
module inference_design
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_lapack, only: decompose
  use base_parameter, only: parameter_t
  use inference_effect_size, only: effect_size_prior_t
  use inference_families, only: family_t, make_families
  use inference_probability, only: MAP_OF_BENDING
  use inference_simulator, only: simulator_t, TANGENT_ERROR
  use inference_span, only: find_span
  use inference_weights, only: cell_weights
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: design_t, candidate_t, build_design, is_part_of

  real(rp), parameter :: ABSORBED = 0.05_rp !< retained fraction below which the baseline imitates an effect
  !> An effect below this fraction still counts as visible if its remainder has this signal-to-noise ratio for one prior sd, down
  !> to the fraction at which the remainder may be an error of the linear approximation.
  real(rp), parameter :: SHOWN = 2.0_rp, RELIABLE = 0.01_rp
  real(rp), parameter :: FAINT = 0.5_rp !< [sd] smallest effect that a parameter must have at the farthest value in its reach
  real(rp), parameter :: FARTHEST = 1.0e6_rp    !< [prior sd], for parameters without bounds

  !> One variant of one effect.
  type :: candidate_t
    integer :: effect = 0, variant = 0
    logical :: is_finer = .false.           !< not part of the scan
    real(rp) :: weight = 0                  !< prior probability within its effect; those of variants with df > 0 add up to 1
    integer, allocatable :: columns(:)      !< its parameters
    integer :: df = 0                       !< directions that the baseline does not absorb; 0: absorbed
    real(rp) :: retained = 0                !< largest retained fraction of a direction
    real(rp), allocatable :: basis(:, :)    !< (k, df) orthonormal
    real(rp), allocatable :: tangents(:, :) !< (k, parameters) S_perp
    real(rp), allocatable :: solve(:, :)    !< (parameters, df) the estimate is -solve*(basis^T z)
    real(rp), allocatable :: projected(:, :)   !< (n, parameters) whitened tangents orthogonal to the baseline's, no priors
    type(effect_size_prior_t) :: size_prior
  end type candidate_t

  type :: design_t
    real(rp), allocatable :: q(:)           !< the point at which tangents were taken
    type(whitener_t) :: whitener
    integer :: probability_map = MAP_OF_BENDING !< that of the simulator
    integer :: k = 0
    integer :: n_rows = 0                   !< observations and priors
    real(rp) :: margin = 0                  !< of the span of z: see inference_span
    integer :: residual_dof = 0                   !< degrees of freedom other than those of baseline and z
    type(candidate_t), allocatable :: candidates(:)
    type(family_t), allocatable :: families(:)
    real(rp), allocatable :: prior(:), weight(:) !< of the unknowns of the baseline; weight 0: no prior
    real(rp), allocatable, private :: q_base(:, :), q_all(:, :)
    integer, allocatable, private :: columns(:)  !< parameters of the tangents
    real(rp), allocatable :: nuisances(:, :) !< as the simulator gave them
    real(rp), allocatable, dimension(:, :), private :: tangents, patterns
  contains
    procedure :: compress => design_compress
    procedure :: observed => design_observed
    procedure :: project_out_baseline => design_project_out_baseline
  end type design_t

contains

  !> Tells whether a candidate releases a part of the parameters of another one.
  pure logical function is_part_of(one, other)
    type(candidate_t), intent(in) :: one, other
    integer :: k
    is_part_of = size(one%columns) < size(other%columns) .and. &
                 all([(any(other%columns == one%columns(k)), k=1, size(one%columns))])
  end function is_part_of

  !> Builds the design of a simulator at q. `state` is near q before, and belongs to q afterwards. For independent_fraction see
  !> `covariance` of simulator_t. The design leaves out candidates whose data are missing, and finer variants that are not released.
  !> Fails if the simulator has no result at q. `known`, where given, is a design of the same simulator at q or at a point close by.
  !> Its tangents and patterns are reused, and only missing tangents are computed. nuisances(n, :), where given, replace those of
  !> the simulator or of `known`; each candidate then keeps at least as many directions as it has in `known`.
  subroutine build_design(simulator, q, state, independent_fraction, design, failure, known, nuisances)
    class(simulator_t), intent(inout) :: simulator
    real(rp), intent(in) :: q(:), independent_fraction
    class(solver_state_t), allocatable, intent(inout) :: state
    type(design_t), intent(out) :: design
    type(failure_t), intent(out) :: failure
    type(design_t), intent(in), optional :: known
    real(rp), intent(in), optional :: nuisances(:, :)
    real(rp), allocatable :: tangents(:, :), patterns(:, :), r(:, :), errors(:)
    integer, allocatable :: columns(:), least(:)
    logical :: is_valid
    integer :: i, n, b
    n = simulator%n_observations
    b = simulator%n_baseline
    columns = [(i, i=1, b), effect_columns(simulator)]
    design%q = q
    design%probability_map = simulator%probability_map
    call evaluate_tangents(simulator, q, columns, state, design, is_valid, known)
    if (.not. is_valid) then
      call failure%raise('the model cannot be computed at the best fit of the baseline: check the loads, their units and the input')
      return
    end if
    if (present(nuisances)) design%nuisances = nuisances
    call design%whitener%init(simulator, [(i, i=1, n)], independent_fraction, failure)
    if (failure%failed) return
    call design%whitener%add_directions(design%nuisances)
    tangents = design%tangents
    patterns = design%patterns
    call design%whitener%apply(tangents)
    call design%whitener%apply(patterns)
    design%prior = simulator%parameters(:b)%null
    allocate (design%weight(b), source=0.0_rp)
    where (simulator%parameters(:b)%prior_sd > 0) design%weight = 1/simulator%parameters(:b)%prior_sd
    design%n_rows = n + b
    errors = [(simulator%tangent_error(columns(i)), i=1, size(columns)), spread(TANGENT_ERROR, 1, size(patterns, 2))]
    call find_spans(tangents, patterns, errors, design, r)
    allocate (least(0))
    if (present(nuisances) .and. present(known)) least = known%candidates%df
    call make_candidates(simulator, columns(b + 1:), tangents(:, b + 1:), r(:, :size(columns) - b), &
                         project_out_baseline(tangents, errors(:b)), errors(b + 1:), least, design)
    call make_families(simulator, r(:, [(i, i=size(columns) - b + 1, size(r, 2)), &
                                        field_among(simulator, columns(b + 1:))]), design%families)
  end subroutine build_design

  !> Computes at q all that the design needs from the simulator; `state` then belongs to q. Reuses what `known` has.
  subroutine evaluate_tangents(simulator, q, columns, state, design, is_valid, known)
    class(simulator_t), intent(inout) :: simulator
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    class(solver_state_t), allocatable, intent(inout) :: state
    type(design_t), intent(inout) :: design
    logical, intent(out) :: is_valid
    type(design_t), intent(in), optional :: known
    class(solver_state_t), allocatable :: next
    real(rp), allocatable :: residuals(:), fresh(:, :)
    integer, allocatable :: missing(:)
    integer :: i, n
    n = simulator%n_observations
    design%columns = columns
    missing = columns
    if (present(known)) missing = pack(columns, [(all(known%columns /= columns(i)), i=1, size(columns))])
    allocate (residuals(n), fresh(n, size(missing)), design%tangents(n, size(columns)))
    call simulator%evaluate(q, missing, state, residuals, fresh, is_valid, next)
    if (.not. is_valid) return
    call move_alloc(next, state)
    do i = 1, size(columns)
      if (any(missing == columns(i))) then
        design%tangents(:, i) = fresh(:, findloc(missing, columns(i), 1))
      else
        design%tangents(:, i) = known%tangents(:, findloc(known%columns, columns(i), 1))
      end if
    end do
    if (present(known)) then
      design%nuisances = known%nuisances
      design%patterns = known%patterns
    else
      allocate (design%nuisances(n, simulator%n_nuisances), design%patterns(n, simulator%n_patterns))
      call simulator%directions(q, state, design%nuisances, design%patterns, is_valid)
    end if
  end subroutine evaluate_tangents

  !> Finds the spans of baseline and z, and r(k, :), the remainders of all other tangents and patterns in the latter. errors(:), of
  !> tangents and patterns, are relative to the lengths; they become those of the remainders, which contain errors of the baseline.
  subroutine find_spans(tangents, patterns, errors, design, r)
    real(rp), intent(in) :: tangents(:, :), patterns(:, :)
    real(rp), intent(inout) :: errors(:)
    type(design_t), intent(inout) :: design
    real(rp), allocatable, intent(out) :: r(:, :)
    real(rp), allocatable :: all(:, :), lengths(:)
    real(rp) :: margin
    integer :: i, n, b
    n = size(tangents, 1)
    b = size(design%weight)
    allocate (all(n + b, size(errors)), source=0.0_rp)
    all(:n, :) = reshape([tangents, patterns], [n, size(errors)])
    do i = 1, b
      all(n + i, i) = design%weight(i)
    end do
    lengths = norm2(all, 1)
    call find_span(all(:, :b), lengths(:b)*errors(:b), design%q_base, margin)
    if (margin > 0) errors(b + 1:) = errors(b + 1:) + 1/margin
    all = all(:, b + 1:)
    do i = 1, 2 ! the second pass removes rounding errors
      all = all - matmul(design%q_base, matmul(transpose(design%q_base), all))
    end do
    call find_span(all, lengths(b + 1:)*errors(b + 1:), design%q_all, design%margin)
    r = matmul(transpose(design%q_all), all)
    design%k = size(r, 1)
    design%residual_dof = n + count(design%weight > 0) - size(design%q_base, 2) - design%k
  end subroutine find_spans

  !> Returns the tangents behind the first size(errors), which have these relative errors, without the part that the first can
  !> imitate, whatever their priors.
  function project_out_baseline(tangents, errors) result(projected)
    real(rp), intent(in) :: tangents(:, :), errors(:)
    real(rp) :: projected(size(tangents, 1), size(tangents, 2) - size(errors))
    real(rp), allocatable :: basis(:, :)
    real(rp) :: margin
    integer :: i
    associate (b => size(errors))
      call find_span(tangents(:, :b), errors*norm2(tangents(:, :b), 1), basis, margin)
      projected = tangents(:, b + 1:)
    end associate
    do i = 1, 2 ! the second pass removes rounding errors
      projected = projected - matmul(basis, matmul(transpose(basis), projected))
    end do
  end function project_out_baseline

  !> Returns the parameters of all effects that the data can show, each once.
  function effect_columns(simulator) result(columns)
    class(simulator_t), intent(in) :: simulator
    integer, allocatable :: columns(:)
    integer :: e, v, i
    allocate (columns(0))
    do e = 1, size(simulator%effects)
      if (.not. simulator%effects(e)%is_testable()) cycle
      do v = 1, size(simulator%effects(e)%variants)
        if (.not. simulator%effects(e)%variants(v)%is_tried()) cycle
        associate (wanted => simulator%effects(e)%variants(v)%columns)
          do i = 1, size(wanted)
            if (.not. any(columns == wanted(i))) columns = [columns, wanted(i)]
          end do
        end associate
      end do
    end do
  end function effect_columns

  !> Returns the positions in columns(:) of the parameters of the simulator's field.
  pure function field_among(simulator, columns) result(at)
    class(simulator_t), intent(in) :: simulator
    integer, intent(in) :: columns(:)
    integer, allocatable :: at(:)
    integer :: i
    allocate (at(0))
    if (allocated(simulator%field)) at = [(findloc(columns, simulator%field(i), 1), i=1, size(simulator%field))]
  end function field_among

  !> Makes the candidates. raw(n, :) and retained(k, :) are the tangents of the parameters `columns` before and after the
  !> projection, errors(:) those of the latter over the lengths of the former; for projected(n, :) see candidate_t. Candidate i
  !> keeps at least least(i) directions.
  subroutine make_candidates(simulator, columns, raw, retained, projected, errors, least, design)
    class(simulator_t), intent(in) :: simulator
    integer, intent(in) :: columns(:), least(:)
    real(rp), intent(in) :: raw(:, :), retained(:, :), projected(:, :), errors(:)
    type(design_t), intent(inout) :: design
    integer :: e, v, n, i, j, first
    integer, allocatable :: at(:)
    n = 0
    do e = 1, size(simulator%effects)
      if (simulator%effects(e)%is_testable()) n = n + count(simulator%effects(e)%variants%is_tried())
    end do
    allocate (design%candidates(n))
    n = 0
    do e = 1, size(simulator%effects)
      if (.not. simulator%effects(e)%is_testable()) cycle
      first = n + 1
      do v = 1, size(simulator%effects(e)%variants)
        if (.not. simulator%effects(e)%variants(v)%is_tried()) cycle
        n = n + 1
        associate (c => design%candidates(n))
          c%effect = e
          c%variant = v
          c%is_finer = simulator%effects(e)%variants(v)%is_finer
          c%columns = simulator%effects(e)%variants(v)%columns
          if (allocated(at)) deallocate (at)
          allocate (at(size(c%columns)))
          do i = 1, size(at)
            at(i) = findloc(columns, c%columns(i), 1)
          end do
          call require(all(simulator%parameters(c%columns)%prior_sd > 0), 'inference_design: effects need a prior')
          c%tangents = retained(:, at)
          c%projected = projected(:, at)
          call fill_candidate(raw(:, at), errors(at), [(simulator%parameters(c%columns(j))%prior_sd, j=1, size(at))], &
                              [(reach(simulator%parameters(c%columns(j))), j=1, size(at))], &
                              sum(least(n:min(n, size(least)))), c)
        end associate
      end do
      associate (own => design%candidates(first:n), variants => simulator%effects(e)%variants)
        own%weight = cell_weights(reshape([(variants(own(i)%variant)%site, i=1, size(own))], [2, size(own)]), &
                                  own%is_finer, own%df > 0)
      end associate
    end do
  end subroutine make_candidates

  !> Returns the largest distance of a parameter from its null.
  elemental real(rp) function reach(parameter)
    type(parameter_t), intent(in) :: parameter
    reach = max(abs(parameter%upper - parameter%null), abs(parameter%null - parameter%lower))
  end function reach

  !> Finds the directions of the candidate in units of prior sd, without those that the baseline absorbs and without parameters
  !> that would not show even at the farthest value in their reach(:). The first `least` are kept. No direction is kept that errors
  !> of tangents may make up: for the bound see inference_span; the errors' norm takes the place of sqrt(m).
  subroutine fill_candidate(raw, errors, prior_sd, reach, least, c)
    real(rp), intent(in) :: raw(:, :), errors(:), prior_sd(:), reach(:)
    integer, intent(in) :: least
    type(candidate_t), intent(inout) :: c
    real(rp) :: scaled(size(c%tangents, 1), size(prior_sd)), length
    real(rp), allocatable :: u(:, :), s(:), vt(:, :)
    logical, allocatable :: keep(:)
    integer :: i, m
    do i = 1, size(prior_sd)
      scaled(:, i) = c%tangents(:, i)*prior_sd(i)
      if (norm2(c%tangents(:, i))*min(reach(i), FARTHEST*prior_sd(i)) < FAINT) scaled(:, i) = 0
    end do
    call decompose(scaled, u, s, vt)
    allocate (keep(size(s)), source=.false.)
    do i = 1, size(s)
      length = norm2(matmul(raw, prior_sd*vt(i, :)))
      if (.not. length > 0) cycle
      c%retained = max(c%retained, min(1.0_rp, s(i)/length))
      if (.not. s(i) > norm2(errors*prior_sd*norm2(raw, 1))) cycle
      keep(i) = i <= least .or. s(i) >= ABSORBED*length .or. (s(i) >= SHOWN .and. s(i) >= RELIABLE*length)
    end do
    c%df = count(keep)
    allocate (c%basis(size(u, 1), c%df), c%solve(size(prior_sd), c%df))
    m = 0
    do i = 1, size(s)
      if (.not. keep(i)) cycle
      m = m + 1
      c%basis(:, m) = u(:, i)
      c%solve(:, m) = prior_sd*vt(i, :)/s(i)
    end do
    if (c%df > 0) call c%size_prior%init(pack(s, keep)/maxval(s, mask=keep))
  end subroutine fill_candidate

  !> Compresses residuals(n), which the simulator has at the baseline unknowns p(:), to z(k). residual_square is the sum of
  !> squares of the part that lies neither in the span of the baseline nor in that of z.
  subroutine design_compress(self, residuals, p, z, residual_square)
    class(design_t), intent(in) :: self
    real(rp), intent(in) :: residuals(:), p(:)
    real(rp), intent(out) :: z(:), residual_square
    real(rp) :: r(self%n_rows)
    integer :: n
    n = size(residuals)
    r(:n) = residuals
    call self%whitener%apply_one(r(:n))
    r(n + 1:) = (p - self%prior)*self%weight
    r = r - matmul(self%q_base, matmul(r, self%q_base))
    z = matmul(r, self%q_all)
    residual_square = max(0.0_rp, sum(r**2) - sum(z**2))
  end subroutine design_compress

  !> Removes from whitened columns (n, :) the part that the baseline, held by its priors, imitates.
  function design_project_out_baseline(self, columns) result(projected)
    class(design_t), intent(in) :: self
    real(rp), intent(in) :: columns(:, :)
    real(rp) :: projected(size(columns, 1), size(columns, 2))
    associate (basis => self%q_base(:size(columns, 1), :))
      projected = columns - matmul(basis, matmul(transpose(basis), columns))
    end associate
  end function design_project_out_baseline

  !> Returns the whitened observations (n) that correspond to z(k).
  function design_observed(self, z) result(r)
    class(design_t), intent(in) :: self
    real(rp), intent(in) :: z(:)
    real(rp) :: r(self%whitener%n)
    r = matmul(self%q_all(:self%whitener%n, :), z)
  end function design_observed
end module inference_design
