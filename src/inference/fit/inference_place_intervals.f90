! SPDX-License-Identifier: GPL-3.0-or-later
!> Widens the interval of the strength of a cause by what its place may be. The profile likelihood of the strength is the largest
!> over all other unknowns, and the place is one of them:
!>
!>     interval = { a : min over places v of cost_v(a) <= least + threshold }.
!>
!> At the fit with strength a0 at place 0, a strength a at place v has the residuals r - S0 a0 + S_v a (inference_refine_location).
!> This tells which places may move an end. The program fits the causes with these, and takes the end from the fit:
!> a_v -+ sd_v (threshold - (cost_v - least))^(1/2).
!>
!> The coordinates of a place that was searched are nuisance parameters, in the bounds of these coordinates and on the object. Steps
!> of the residuals exclude derivatives with respect to them: a compass search goes to the place where the end is farthest
!> (inference_search_place), and a profile at that place gives the end.
module inference_place_intervals
  use base_kinds, only: rp
  use base_lapack, only: orthogonalise
  use inference_design, only: design_t
  use inference_intervals, only: find_intervals
  use inference_refit, only: fit_nested, nested_fit_t
  use inference_search_place, only: place_search_t, place_t
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  use least_squares_fit, only: fit_options_t
  use least_squares_profile, only: interval_t, THRESHOLD_90
  implicit none
  private
  public :: widen_over_places

  integer, parameter :: MOST = 3            !< places that are fitted for each end
  integer, parameter :: MOST_STEPS = 40     !< evaluations of the search for each end
  real(rp), parameter :: WORTH = 0.05_rp    !< sd by which an end must move to be worth a step of the search

contains

  !> Widens `interval`, that of the one parameter of candidate c in the fit `extended`, over the other candidates of its effect and,
  !> if its place was searched, over all places. Nothing changes if there are none. `scale` is the variance of the noise over that
  !> of the whitener.
  subroutine widen_over_places(simulator, design, whitener, scale, options, c, extended, interval)
    class(simulator_t), intent(inout), target :: simulator
    type(design_t), intent(in) :: design
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: scale
    type(fit_options_t), intent(in) :: options
    integer, intent(in) :: c
    type(nested_fit_t), intent(in) :: extended
    type(interval_t), intent(inout) :: interval
    integer, allocatable :: rivals(:)
    real(rp), allocatable :: ends(:, :)
    logical, allocatable :: is_open(:)
    integer :: i, n, side
    if (is_searched(simulator, design, c)) &
      call widen_around(simulator, design, whitener, scale, options, c, extended, interval)
    rivals = pack([(i, i=1, size(design%candidates))], design%candidates%effect == design%candidates(c)%effect)
    rivals = pack(rivals, rivals /= c)
    rivals = pack(rivals, [(is_same_quantity(simulator, design, c, rivals(i)), i=1, size(rivals))])
    if (size(rivals) == 0) return
    call predict_ends(simulator, design, whitener, scale, c, extended, rivals, ends)
    do side = 1, 2
      is_open = ends(1, :) <= ends(2, :)
      do n = 1, MOST
        if (.not. any(is_open)) exit
        if (side == 1) i = minloc(ends(1, :), 1, mask=is_open)
        if (side == 2) i = maxloc(ends(2, :), 1, mask=is_open)
        is_open(i) = .false.
        if (side == 1 .and. (.not. interval%has_lower .or. ends(1, i) >= interval%lower)) exit
        if (side == 2 .and. (.not. interval%has_upper .or. ends(2, i) <= interval%upper)) exit
        call widen_by(simulator, whitener, scale, options, design%candidates(c)%columns(1), &
                      design%candidates(rivals(i))%columns(1), extended, interval)
      end do
    end do
  end subroutine widen_over_places

  !> Tells whether candidate c has a place that is not on a lattice.
  pure logical function is_searched(simulator, design, c)
    class(simulator_t), intent(in) :: simulator
    type(design_t), intent(in) :: design
    integer, intent(in) :: c
    is_searched = .false.
    if (.not. allocated(simulator%effects)) return
    associate (effect => simulator%effects(design%candidates(c)%effect))
      is_searched = allocated(effect%place) .and. design%candidates(c)%variant == effect%anywhere
    end associate
  end function is_searched

  !> Widens the interval of the strength of candidate c over all places. The place of `extended` is within the interval.
  subroutine widen_around(simulator, design, whitener, scale, options, c, extended, interval)
    class(simulator_t), intent(inout), target :: simulator
    type(design_t), intent(in) :: design
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: scale
    type(fit_options_t), intent(in) :: options
    integer, intent(in) :: c
    type(nested_fit_t), intent(in) :: extended
    type(interval_t), intent(inout) :: interval
    type(place_search_t) :: search
    type(place_t) :: found
    integer :: k, side
    search%simulator => simulator
    search%whitener => whitener
    search%prior = design%prior
    search%weight = design%weight
    search%effect = design%candidates(c)%effect
    search%strength = design%candidates(c)%columns(1)
    search%others = pack(extended%active(simulator%n_baseline + 1:), &
                         extended%active(simulator%n_baseline + 1:) /= search%strength)
    k = findloc(extended%active, search%strength, 1)
    search%worth = WORTH*sqrt(extended%covariance(k, k))
    search%most = MOST_STEPS
    search%limit = extended%cost() + THRESHOLD_90*scale
    do side = -1, 1, 2
      call search%find_end(side, extended%q, extended%state, found)
      if (found%is_valid) call widen_at(simulator, whitener, scale, options, search%strength, found%q, extended, interval)
    end do
  end subroutine widen_around

  !> Widens the interval of the strength `own` by that at the place in q.
  subroutine widen_at(simulator, whitener, scale, options, own, q, extended, interval)
    class(simulator_t), intent(inout), target :: simulator
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: scale
    type(fit_options_t), intent(in) :: options
    integer, intent(in) :: own
    real(rp), intent(in) :: q(:)
    type(nested_fit_t), intent(in) :: extended
    type(interval_t), intent(inout) :: interval
    type(nested_fit_t) :: found
    type(interval_t), allocatable :: there(:)
    real(rp) :: left
    integer :: k
    call fit_nested(simulator, whitener, extended%active, q, extended%state, options, found)
    if (.not. found%is_found) return
    left = scale - max(0.0_rp, found%cost() - extended%cost())/THRESHOLD_90
    if (.not. left > 0) return
    call find_intervals(simulator, whitener, left, options, found, there)
    k = findloc(extended%active(simulator%n_baseline + 1:), own, 1)
    associate (other => there(k))
      if (.not. other%is_complete) return
      if (interval%has_lower .and. other%lower < interval%lower) then
        interval%lower = other%lower
        interval%has_lower = other%has_lower
        interval%is_jump(1) = other%is_jump(1)
      end if
      if (interval%has_upper .and. other%upper > interval%upper) then
        interval%upper = other%upper
        interval%has_upper = other%has_upper
        interval%is_jump(2) = other%is_jump(2)
      end if
    end associate
  end subroutine widen_at

  !> Tells whether candidates c and d have one parameter each, and the same one but for its place.
  pure logical function is_same_quantity(simulator, design, c, d) result(is_same)
    class(simulator_t), intent(in) :: simulator
    type(design_t), intent(in) :: design
    integer, intent(in) :: c, d
    is_same = size(design%candidates(c)%columns) == 1 .and. size(design%candidates(d)%columns) == 1
    if (is_same) is_same = simulator%parameters(design%candidates(c)%columns(1))%name == &
                           simulator%parameters(design%candidates(d)%columns(1))%name
  end function is_same_quantity

  !> Predicts the ends(2, rivals) of the interval of the strength at each place; the first is above the second where the place is
  !> too improbable.
  subroutine predict_ends(simulator, design, whitener, scale, c, extended, rivals, ends)
    class(simulator_t), intent(inout) :: simulator
    type(design_t), intent(in) :: design
    type(whitener_t), intent(in) :: whitener
    real(rp), intent(in) :: scale
    integer, intent(in) :: c, rivals(:)
    type(nested_fit_t), intent(in) :: extended
    real(rp), allocatable, intent(out) :: ends(:, :)
    integer, allocatable :: others(:), columns(:)
    real(rp), allocatable :: rows(:, :), left(:), tangents(:, :), basis(:, :), r(:, :)
    real(rp) :: least, square, strength, room
    integer :: i, k, n, b, own
    logical :: is_valid
    allocate (ends(2, size(rivals)))
    ends(1, :) = 1
    ends(2, :) = 0
    n = simulator%n_observations
    b = simulator%n_baseline
    own = design%candidates(c)%columns(1)
    others = pack(extended%active, extended%active /= own) ! the baseline, and other causes
    columns = [others, own, (design%candidates(rivals(i))%columns(1), i=1, size(rivals))]
    allocate (left(n + b), tangents(n, size(columns)), rows(n + b, size(columns)), source=0.0_rp)
    call simulator%evaluate(extended%q, columns, extended%state, left(:n), tangents, is_valid)
    if (.not. is_valid) return
    call whitener%apply_one(left(:n))
    call whitener%apply(tangents)
    rows(:n, :) = tangents
    do i = 1, b
      rows(n + i, i) = design%weight(i)
    end do
    left(n + 1:) = (extended%q(:b) - design%prior)*design%weight
    k = size(others)
    call orthogonalise(rows(:, :k), basis, r)
    rows(:, k + 1:) = rows(:, k + 1:) - matmul(basis, matmul(transpose(basis), rows(:, k + 1:)))
    left = left - matmul(basis, matmul(left, basis))
    least = sum(left**2)
    left = left - rows(:, k + 1)*(extended%q(own) - simulator%parameters(own)%null)
    do i = 1, size(rivals)
      associate (s => rows(:, k + 1 + i), null => simulator%parameters(columns(k + 1 + i))%null)
        square = sum(s**2)
        if (.not. square > 0) cycle
        strength = -dot_product(s, left)/square
        room = THRESHOLD_90*scale - (sum((left + strength*s)**2) - least)
        if (room < 0) cycle
        ends(:, i) = null + strength + [-1, 1]*sqrt(room/square)
      end associate
    end do
  end subroutine predict_ends

  !> Fits the causes with parameter `new` in place of `own`, and widens the interval by that of `new`.
  subroutine widen_by(simulator, whitener, scale, options, own, new, extended, interval)
    class(simulator_t), intent(inout), target :: simulator
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: scale
    type(fit_options_t), intent(in) :: options
    integer, intent(in) :: own, new
    type(nested_fit_t), intent(in) :: extended
    type(interval_t), intent(inout) :: interval
    type(nested_fit_t) :: found
    real(rp) :: q(size(extended%q)), room, reach
    integer :: k
    k = findloc(extended%active, own, 1)
    q = extended%q
    q(new) = q(own)
    q(own) = simulator%parameters(own)%null
    call fit_nested(simulator, whitener, [extended%active(:k - 1), new, extended%active(k + 1:)], q, extended%state, options, found)
    if (.not. found%is_found) return
    room = THRESHOLD_90*scale - max(0.0_rp, found%cost() - extended%cost())
    if (room < 0) return
    reach = sqrt(room*found%covariance(k, k))
    if (interval%has_lower) interval%lower = min(interval%lower, max(simulator%parameters(new)%lower, found%q(new) - reach))
    if (interval%has_upper) interval%upper = max(interval%upper, min(simulator%parameters(new)%upper, found%q(new) + reach))
  end subroutine widen_by
end module inference_place_intervals
