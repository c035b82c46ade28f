! SPDX-License-Identifier: GPL-3.0-or-later
!> Searches the place at which an effect explains most: a point on the measured object, and perhaps a size.
!>
!> Between the places of a scan the residuals may have kinks (sides of triangles) and steps (elements enter a disc one by one), so
!> that derivatives with respect to the place mislead. The search compares places by one evaluation each: with the residuals r and
!> the tangents J of baseline and strength there, one Gauss-Newton step leaves the sum of squares
!>
!>     min |r + J d|^2 + sum of ((q + d - prior) weight)^2
!>
!> which is exact up to the curvature of baseline and strength, whatever the dependence on the place is. A compass search (Kolda,
!> Lewis and Torczon 2003, DOI 10.1137/S003614450242889) with these sums goes along the coordinates of the place, and halves its
!> steps where none of them is better.
!>
!> The same search finds the end of an interval of the strength over all places: at each place the sum of squares left, C, and the
!> strength a +- sd give the end a +- sd (limit - C)^(1/2), and the search moves to where the end is farthest. This is the profile
!> likelihood of the strength with the place as nuisance parameters, without derivatives with respect to the place.
module inference_search_place
  use base_kinds, only: rp
  use base_lapack, only: solve_least_squares
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: place_search_t, place_t

  integer, parameter :: N_LEVELS = 4      !< sizes of the steps; the last one is an eighth of the first
  integer, parameter :: N_SWEEPS = 3      !< most visits of all directions with the steps of one size
  integer, parameter :: N_SETTLING = 2    !< Gauss-Newton steps at each start
  real(rp), parameter :: LONGEST = 1.0_rp !< step of a strength: of a logarithm, or of its usual size

  !> A place that was tried.
  type :: place_t
    logical :: is_valid = .false.
    real(rp), allocatable :: at(:)        !< coordinates of the place
    real(rp), allocatable :: q(:)         !< all parameters after the Gauss-Newton step
    real(rp) :: cost = huge(1.0_rp)       !< the sum of squares that this step leaves
    real(rp) :: score = huge(1.0_rp)      !< what a search makes small: cost, or minus the distance of an end
  end type place_t

  !> A search. Simulator and whitener must live as long as it.
  type :: place_search_t
    class(simulator_t), pointer :: simulator => null()
    type(whitener_t), pointer :: whitener => null()
    real(rp), allocatable :: prior(:), weight(:) !< of the unknowns of the baseline; weight 0: no prior
    integer :: effect = 0                 !< whose place is sought
    integer :: strength = 0               !< parameter of its variant at any place
    real(rp) :: worth = 0                 !< decrease of the sum of squares that makes a place better than another one
    integer :: most = 60                  !< evaluations from one place, besides those at starts
    integer :: n_evaluations = 0
    integer, allocatable :: others(:)     !< further unknowns besides baseline and strength; not allocated: none
    integer :: side = 0                   !< -1, 1: the search goes for the lower or upper end of an interval of the strength
    real(rp) :: limit = 0                 !< largest sum of squares within that interval
  contains
    procedure :: run => search_run
    procedure :: find_end => search_find_end
    procedure, private :: try => search_try
    procedure, private :: explore => search_explore
    procedure, private :: is_near => search_is_near
  end type place_search_t

contains

  !> Searches from the best of the places starts(coordinates, :), and from the best one that is not near to it. The strengths there
  !> are about strengths(:), and the baseline is at q. `from` is near all solutions. found%is_valid is false if there is no result
  !> at any start. Rank 0 calls it, and its order of places depends on nothing else: results do not depend on the number of ranks.
  subroutine search_run(self, starts, strengths, q, from, found)
    class(place_search_t), intent(inout) :: self
    real(rp), intent(in) :: starts(:, :), strengths(:), q(:)
    class(solver_state_t), intent(in) :: from
    type(place_t), intent(out) :: found
    type(place_t) :: one, second
    type(place_t), allocatable :: tried(:)
    real(rp) :: begin(size(q))
    integer :: i, k
    allocate (tried(size(strengths)))
    do i = 1, size(strengths)
      begin = q
      begin(self%strength) = strengths(i)
      do k = 1, N_SETTLING
        call self%try(starts(:, i), begin, from, one)
        if (.not. one%is_valid) exit
        begin = one%q
      end do
      tried(i) = one
      if (one%is_valid .and. one%cost < found%cost) found = one
    end do
    if (.not. found%is_valid) return
    do i = 1, size(tried)
      if (.not. tried(i)%is_valid) cycle
      if (self%is_near(tried(i)%at, found%at)) cycle
      if (tried(i)%cost < second%cost) second = tried(i)
    end do
    call self%explore(from, found)
    if (second%is_valid) call self%explore(from, second)
    if (second%cost < found%cost) found = second
  end subroutine search_run

  !> Finds the place at which the end of the interval of the strength is farthest on the side `side`, from the fit q whose place is
  !> within the interval. `worth` is then a distance of ends. found%is_valid is false if there is no result at q. On rank 0.
  subroutine search_find_end(self, side, q, from, found)
    class(place_search_t), intent(inout) :: self
    integer, intent(in) :: side
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    type(place_t), intent(out) :: found
    self%side = side
    call self%try(q(self%simulator%effects(self%effect)%place_columns), q, from, found)
    if (found%is_valid) call self%explore(from, found)
  end subroutine search_find_end

  !> Tells whether two places are so near that a search from one of them reaches the other: by at most three steps in each
  !> coordinate.
  pure logical function search_is_near(self, one, other) result(is_near)
    class(place_search_t), intent(in) :: self
    real(rp), intent(in) :: one(:), other(:)
    associate (columns => self%simulator%effects(self%effect)%place_columns)
      is_near = all(abs(one - other) <= 3*self%simulator%parameters(columns)%prior_sd)
    end associate
  end function search_is_near

  !> Moves `best` along the coordinates of the place as long as its score decreases, with smaller and smaller steps.
  subroutine search_explore(self, from, best)
    class(place_search_t), intent(inout) :: self
    class(solver_state_t), intent(in) :: from
    type(place_t), intent(inout) :: best
    type(place_t) :: one
    real(rp), allocatable :: at(:)
    real(rp) :: step
    integer :: level, sweep, k, side, last
    logical :: is_better, has_moved
    last = self%n_evaluations + self%most
    associate (columns => self%simulator%effects(self%effect)%place_columns)
      do level = 1, N_LEVELS
        do sweep = 1, N_SWEEPS
          has_moved = .false.
          do k = 1, size(columns)
            step = self%simulator%parameters(columns(k))%prior_sd/2**(level - 1)
            do side = 1, 2
              at = best%at
              at(k) = at(k) + merge(step, -step, side == 1)
              if (self%n_evaluations >= last) return
              call self%try(at, best%q, from, one)
              is_better = one%is_valid .and. one%score < best%score - self%worth
              if (is_better) best = one
              has_moved = has_moved .or. is_better
              if (is_better) exit
            end do
          end do
          if (.not. has_moved) exit
        end do
      end do
    end associate
  end subroutine search_explore

  !> Evaluates the place `at` with the other parameters at q, and makes a Gauss-Newton step. A place outside of the bounds of its
  !> coordinates or off the object is not valid.
  subroutine search_try(self, at, q, from, one)
    class(place_search_t), intent(inout) :: self
    real(rp), intent(in) :: at(:), q(:)
    class(solver_state_t), intent(in) :: from
    type(place_t), intent(out) :: one
    real(rp) :: raw(self%simulator%n_observations)
    real(rp), allocatable :: rows(:, :), left(:), step(:), tangents(:, :)
    integer, allocatable :: columns(:)
    integer :: i, n, b, k
    logical :: ok
    b = size(self%prior)
    n = size(raw)
    associate (s => self%simulator, parameter => self%simulator%parameters(self%strength))
      if (any(at < s%parameters(s%effects(self%effect)%place_columns)%lower)) return
      if (any(at > s%parameters(s%effects(self%effect)%place_columns)%upper)) return
      if (.not. s%has_place(self%effect, at)) return
      columns = [(i, i=1, b)]
      if (allocated(self%others)) columns = [columns, self%others]
      columns = [columns, self%strength]
      k = size(columns)
      allocate (tangents(n, k))
      one%at = at
      one%q = q
      one%q(s%effects(self%effect)%place_columns) = at
      call s%evaluate(one%q, columns, from, raw, tangents, one%is_valid)
      self%n_evaluations = self%n_evaluations + 1
      if (.not. one%is_valid) return
      call self%whitener%apply_one(raw)
      call self%whitener%apply(tangents)
      allocate (rows(n + b, k), source=0.0_rp)
      rows(:n, :) = tangents
      do i = 1, b
        rows(n + i, i) = self%weight(i)
      end do
      left = [raw, (q(:b) - self%prior)*self%weight]
      allocate (step(k), source=0.0_rp)
      call solve_least_squares(rows, -left, step, ok)
      one%is_valid = ok
      if (.not. ok) return
      step = step*min(1.0_rp, longest_step(q(self%strength))/max(abs(step(k)), tiny(1.0_rp)))
      one%cost = sum((left + matmul(rows, step))**2)
      one%q(columns) = min(s%parameters(columns)%upper, max(s%parameters(columns)%lower, q(columns) + step))
      one%score = one%cost
      if (self%side /= 0) one%score = score_of_end(self, rows, one)
    end associate

  contains

    !> Returns the longest step of the strength from this value.
    pure real(rp) function longest_step(strength)
      real(rp), intent(in) :: strength
      longest_step = LONGEST
      associate (parameter => self%simulator%parameters(self%strength))
        if (.not. parameter%is_log) longest_step = LONGEST*max(parameter%prior_sd, abs(strength - parameter%null))
      end associate
    end function longest_step
  end subroutine search_try

  !> Returns the score of place `one`, whose tangents are rows(:, unknowns) with the strength last: minus how far the end of the
  !> interval is on its side, within the bounds. That of a place outside of the interval is huge.
  real(rp) function score_of_end(self, rows, one) result(score)
    class(place_search_t), intent(in) :: self
    real(rp), intent(in) :: rows(:, :)
    type(place_t), intent(in) :: one
    real(rp) :: shares(size(rows, 2) - 1), own
    integer :: k
    logical :: ok
    score = huge(1.0_rp)
    if (one%cost > self%limit) return
    k = size(rows, 2)
    call solve_least_squares(rows(:, :k - 1), rows(:, k), shares, ok)
    own = norm2(rows(:, k) - matmul(rows(:, :k - 1), shares))
    if (.not. (ok .and. own > 0)) return
    associate (parameter => self%simulator%parameters(self%strength))
      score = one%q(self%strength) + self%side*sqrt(self%limit - one%cost)/own
      score = -self%side*min(parameter%upper, max(parameter%lower, score))
    end associate
  end function score_of_end
end module inference_search_place
