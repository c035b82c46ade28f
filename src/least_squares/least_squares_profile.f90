! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds intervals by profile likelihood: one unknown is held at a value, all others are fitted again, and the interval is where
!> the sum of squares stays within a threshold of its minimum.
!>
!> A sum of squares may jump, for instance where a solution moves to another branch; refits do not cross the jump. If a jump lies
!> between the minimum and an end, the data that jump are left out, and the interval is found from the others. It is that of a
!> smaller experiment: wider, but correct. If nothing can be left out, the interval ends at the jump, and `is_jump` says so.
!>
!> The prior of the unknown itself is left out: the result is what the data alone tell about it. If the profile stays below the
!> threshold up to the bound, there is no end on that side.
module least_squares_profile
  use base_kinds, only: rp
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use least_squares_interval, only: interval_t, profile_sentence
  use least_squares_problem, only: least_squares_t, unknowns_t
  use least_squares_state, only: solver_point_t, solver_state_t
  implicit none
  private
  public :: interval_t, linear_guess_t, profile_interval, profile_sentence

  real(rp), parameter, public :: THRESHOLD_90 = 2.705543454095404_rp !< 90 % of chi^2 with one degree of freedom
  integer, parameter :: MOST_REFITS = 25
  real(rp), parameter :: ACCURACY = 0.01_rp     !< of the root of the threshold
  real(rp), parameter :: RESOLUTION = 1.0e-3_rp !< of the threshold, left in the sums of squares of refits

  !> Guess from the linear approximation where the ends of the interval of an unknown are.
  type :: linear_guess_t
    real(rp) :: sd = 0                !< its standard deviation
    real(rp), allocatable :: slope(:) !< derivatives of all unknowns with respect to it, if known
  end type linear_guess_t

  !> The data of a search.
  type :: search_t
    integer :: i = 0                     !< the unknown
    type(linear_guess_t) :: guess
    real(rp) :: threshold = 0
    type(unknowns_t) :: unknowns         !< without the prior of unknown i
    type(fit_options_t) :: options
    type(fit_report_t) :: report         !< of the last fit
    type(solver_point_t) :: best         !< where the sum of squares is least so far
    real(rp) :: least = 0
    type(interval_t) :: interval
  contains
    procedure :: fit_from => search_fit_from
    procedure :: is_fitted => search_is_fitted
    procedure :: excess => search_excess
    procedure :: start_at => search_start_at
  end type search_t

  !> The bracket of an end of the interval between two values of the unknown, `inside` and, once it is known, `outside`. w is the
  !> root of the sum of squares above its minimum.
  type :: bracket_t
    real(rp) :: inside = 0, w_inside = 0, outside = 0, w_outside = 0
    logical :: has_outside = .false.
    type(solver_point_t) :: at_inside         !< where the last fit at `inside` has ended
    real(rp), allocatable :: at_outside(:)    !< where the last fit at `outside` has begun
    integer :: n_same = 0 !< points in a row on the same side of the end, without the first; inside > 0, outside < 0
  contains
    procedure :: move_inside => bracket_move_inside
    procedure :: next_point => bracket_next_point
  end type bracket_t

  !> One end of the interval.
  type :: end_t
    real(rp) :: x = 0
    logical :: is_there = .false., is_jump = .false.
  end type end_t

  !> Results of the search for an end: an end, or no end; not found after many fits; a lower minimum; data were left out. After
  !> the last two everything has to be found again.
  integer, parameter :: SETTLED = 0, UNSETTLED = 1, LOWER_MINIMUM = 2, FEWER_DATA = 3

contains

  !> Finds the interval of unknown i about the optimum of a fit with the same unknowns. The first fits of each side begin from
  !> the guess of the linear approximation. `threshold` is that of the sum of squares in units of the residuals' variance. A point
  !> at which the others cannot be fitted counts as outside.
  subroutine profile_interval(problem, unknowns, optimum, i, guess, threshold, options, interval)
    class(least_squares_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    class(solver_point_t), intent(in) :: optimum
    real(rp), intent(in) :: threshold
    integer, intent(in) :: i
    type(linear_guess_t), intent(in) :: guess
    type(fit_options_t), intent(in) :: options
    type(interval_t), intent(out) :: interval
    type(search_t) :: search
    logical :: is_less
    search%i = i
    search%guess = guess
    search%threshold = threshold
    search%unknowns = unknowns
    search%unknowns%prior_sd(i) = 0
    search%options = options
    search%options%is_smooth = .true.
    search%best%p = optimum%p
    allocate (search%best%state, source=optimum%state)
    do
      search%unknowns%is_fixed(i) = unknowns%is_fixed(i)
      search%options%reduction_tolerance = options%reduction_tolerance
      call search%fit_from(problem, optimum%p, search%best%state)
      is_less = .false.
      if (search%report%has_jumped) call search%best%state%leave_out(search%report%jumped, is_less)
      if (.not. is_less) call find_both_ends(search, problem, optimum%p(i), is_less)
      if (.not. is_less) exit
      search%interval = interval_t(n_refits=search%interval%n_refits, n_evaluations=search%interval%n_evaluations)
    end do
    interval = search%interval
    if (allocated(search%best%state%is_left_out)) interval%is_left_out = search%best%state%is_left_out
  end subroutine profile_interval

  !> Finds the interval about the point that was just fitted from the value p of the unknown. `is_less` is true if data were left
  !> out.
  subroutine find_both_ends(search, problem, p, is_less)
    type(search_t), intent(inout) :: search
    class(least_squares_t), intent(inout) :: problem
    real(rp), intent(in) :: p
    logical, intent(out) :: is_less
    type(end_t) :: ends(2)
    integer :: attempt, side, outcomes(2)
    associate (interval => search%interval, i => search%i)
      is_less = .false.
      allocate (interval%profile(2, 0))
      interval%best = p
      interval%lower = search%unknowns%lower(i)
      interval%upper = search%unknowns%upper(i)
      if (.not. search%is_fitted()) return
      search%best = search%report%solver_point_t
      search%least = search%report%cost()
      search%options%reduction_tolerance = max(search%options%reduction_tolerance, &
                                               RESOLUTION*search%threshold/(search%least + search%threshold))
      search%unknowns%is_fixed(i) = .true.
      ends%x = [interval%lower, interval%upper]
      outcomes = UNSETTLED
      do attempt = 1, 5 ! again if the profile has a lower minimum elsewhere
        interval%best = search%best%p(i)
        interval%profile = reshape([search%best%p(i), 0.0_rp], [2, 1])
        do side = 1, 2
          call find_end(search, problem, 2*side - 3, ends(side), outcomes(side))
          is_less = outcomes(side) == FEWER_DATA
          if (is_less) return
          if (outcomes(side) == LOWER_MINIMUM) exit
        end do
        if (side > 2) exit
      end do
      interval%lower = ends(1)%x
      interval%upper = ends(2)%x
      interval%has_lower = ends(1)%is_there
      interval%has_upper = ends(2)%is_there
      interval%is_jump = ends%is_jump
      interval%is_complete = all(outcomes == SETTLED)
    end associate
  end subroutine find_both_ends

  !> Finds the end of the interval in this direction: the root of w(x) = sqrt(threshold), where w grows linearly for linear
  !> problems. A lower sum of squares on the way becomes the new minimum.
  subroutine find_end(search, problem, direction, end, outcome)
    type(search_t), intent(inout) :: search
    class(least_squares_t), intent(inout) :: problem
    integer, intent(in) :: direction !< -1, 1
    type(end_t), intent(out) :: end
    integer, intent(out) :: outcome
    type(bracket_t) :: bracket
    real(rp), allocatable :: at(:)
    real(rp) :: x, w, goal, bound, room, step
    logical :: is_stuck
    integer :: n
    associate (i => search%i, best => search%best%p)
      goal = sqrt(search%threshold)
      bound = merge(search%unknowns%upper(i), search%unknowns%lower(i), direction > 0)
      end%x = bound
      outcome = SETTLED
      room = abs(bound - best(i))
      if (.not. room > 0) return
      bracket%inside = best(i)
      bracket%at_inside = search%best
      bracket%outside = bound
      step = min(search%guess%sd*goal, 2*max(search%options%largest_step, 1.0_rp)*search%unknowns%unit(i))
      x = best(i) + direction*min(room, max(step, 1.0e-6_rp*min(room, search%unknowns%unit(i))))
      do n = 1, MOST_REFITS
        at = search%start_at(x, bracket)
        call search%fit_from(problem, at, bracket%at_inside%state)
        if (search%report%n_evaluations > 1) call take_jump(search, outcome) ! a jump keeps the other unknowns from their minimum
        if (outcome == SETTLED) call take_value(search, x, w, outcome)
        if (outcome /= SETTLED) return
        if (abs(w - goal) <= ACCURACY*goal) then
          end = end_t(x, is_there=.true.)
          return
        end if
        if (w < goal) then
          if (.not. abs(x - bound) > 0) return ! inside up to the bound: no end
          is_stuck = bracket%has_outside .and. .not. abs(bracket%outside - x) > 1.0e-3_rp*abs(x - best(i))
          if (bracket%has_outside) bracket%n_same = max(0, bracket%n_same) + 1
          call bracket%move_inside(x, w, search%report%solver_point_t)
        else
          is_stuck = .not. abs(x - bracket%inside) > 1.0e-3_rp*abs(x - best(i))
          if (bracket%has_outside) bracket%n_same = min(0, bracket%n_same) - 1
          bracket%outside = x
          bracket%at_outside = at
          bracket%w_outside = w
          bracket%has_outside = .true.
        end if
        if (is_stuck) then ! the sum of squares jumps, or valid points end
          call probe_far_side(search, problem, goal, bracket, end, outcome)
          if (outcome /= SETTLED .or. end%is_there) return
        end if
        x = bracket%next_point(goal, best(i), bound)
      end do
      outcome = UNSETTLED
      if (bracket%has_outside) end%x = bracket%outside
      end%is_there = bracket%has_outside
    end associate
  end subroutine find_end

  !> Leaves data out if the last fit has jumped and some can be left out. The outcome is then FEWER_DATA; otherwise it does not
  !> change.
  subroutine take_jump(search, outcome)
    type(search_t), intent(inout) :: search
    integer, intent(inout) :: outcome
    logical :: is_less
    if (.not. search%report%has_jumped) return
    call search%best%state%leave_out(search%report%jumped, is_less)
    if (is_less) outcome = FEWER_DATA
  end subroutine take_jump

  !> Enters the last fit, with the unknown at x, in the profile and returns its w, which is huge without a fit. If the fit is lower
  !> than the minimum by more than the accuracy of fits, it becomes the minimum, and the outcome becomes LOWER_MINIMUM; otherwise
  !> the outcome does not change.
  subroutine take_value(search, x, w, outcome)
    type(search_t), intent(inout) :: search
    real(rp), intent(in) :: x
    real(rp), intent(out) :: w
    integer, intent(inout) :: outcome
    w = huge(w)
    if (.not. search%is_fitted()) return
    if (search%excess() < -1.0e-3_rp*search%threshold) then
      search%best = search%report%solver_point_t
      search%least = search%report%cost()
      outcome = LOWER_MINIMUM
      return
    end if
    w = sqrt(max(0.0_rp, search%excess()))
    search%interval%profile = reshape([search%interval%profile, x, w**2], [2, size(search%interval%profile, 2) + 1])
  end subroutine take_value

  !> Fits at the value just outside, starting from the point just inside. The interval ends there if residuals jump, if the fit
  !> fails, or if the sum of squares has grown enough. Otherwise the value is inside, because it can be reached from nearby without
  !> a jump.
  subroutine probe_far_side(search, problem, goal, bracket, end, outcome)
    type(search_t), intent(inout) :: search
    class(least_squares_t), intent(inout) :: problem
    real(rp), intent(in) :: goal
    type(bracket_t), intent(inout) :: bracket
    type(end_t), intent(inout) :: end
    integer, intent(inout) :: outcome
    real(rp) :: w
    call search%fit_from(problem, bracket%at_outside, bracket%at_inside%state)
    call take_jump(search, outcome)
    if (outcome == FEWER_DATA) return
    w = huge(w)
    if (search%is_fitted()) w = sqrt(max(0.0_rp, search%excess()))
    if (search%report%has_jumped .or. .not. w < (1 - ACCURACY)*goal) then
      end = end_t(bracket%outside, is_there=.true., is_jump=search%report%has_jumped .or. w > (1 + ACCURACY)*goal)
      return
    end if
    call bracket%move_inside(bracket%outside, w, search%report%solver_point_t)
    bracket%has_outside = .false.
    bracket%n_same = 0
  end subroutine probe_far_side

  !> Fits from `start` and the state `from`, and counts the fit.
  subroutine search_fit_from(self, problem, start, from)
    class(search_t), intent(inout) :: self
    class(least_squares_t), intent(inout) :: problem
    real(rp), intent(in) :: start(:)
    class(solver_state_t), intent(in) :: from
    call fit(problem, self%unknowns, start, from, self%options, self%report)
    self%interval%n_refits = self%interval%n_refits + 1
    self%interval%n_evaluations = self%interval%n_evaluations + self%report%n_evaluations
  end subroutine search_fit_from

  !> Tells whether the last fit has a result.
  pure logical function search_is_fitted(self) result(is_fitted)
    class(search_t), intent(in) :: self
    is_fitted = self%report%is_converged .or. self%report%n_accepted > 0
  end function search_is_fitted

  !> Returns the sum of squares of the last fit above the minimum.
  pure real(rp) function search_excess(self) result(excess)
    class(search_t), intent(in) :: self
    excess = self%report%cost() - self%least
  end function search_excess

  !> Returns the start of the fit with the unknown at x: the others follow the straight line through the last two fits.
  pure function search_start_at(self, x, bracket) result(at)
    class(search_t), intent(in) :: self
    real(rp), intent(in) :: x
    type(bracket_t), intent(in) :: bracket
    real(rp) :: at(size(self%best%p))
    associate (best => self%best%p, i => self%i)
      at = bracket%at_inside%p
      if (abs(bracket%inside - best(i)) > 0) then
        at = best + (bracket%at_inside%p - best)*((x - best(i))/(bracket%inside - best(i)))
      else if (allocated(self%guess%slope)) then
        at = best + self%guess%slope*(x - best(i))
      end if
      at(i) = x
    end associate
  end function search_start_at

  !> Moves the inner side to x, where a fit has ended at the point `at`.
  subroutine bracket_move_inside(self, x, w, at)
    class(bracket_t), intent(inout) :: self
    real(rp), intent(in) :: x, w
    type(solver_point_t), intent(in) :: at
    self%inside = x
    self%w_inside = w
    self%at_inside = at
  end subroutine bracket_move_inside

  !> Returns the next value to try. It lies on the straight line through the last two points, kept inside the bracket; farther
  !> out, at most at the bound, while there is no bracket; or in the middle of a bracket that shrinks slowly.
  pure real(rp) function bracket_next_point(self, goal, best, bound) result(x)
    class(bracket_t), intent(in) :: self
    real(rp), intent(in) :: goal, best, bound
    real(rp) :: fraction, factor
    if (.not. self%has_outside) then
      factor = 4
      if (self%w_inside > 0.25_rp*goal) factor = goal/self%w_inside
      x = best + factor*(self%inside - best)
      if (sign(1.0_rp, bound - best)*(x - bound) > 0) x = bound
    else
      fraction = 0.5_rp
      if (self%w_outside < 1.0e3_rp*goal .and. abs(self%n_same) <= 2) &
        fraction = (goal - self%w_inside)/(self%w_outside - self%w_inside)
      x = self%inside + max(0.05_rp, min(0.95_rp, fraction))*(self%outside - self%inside)
    end if
  end function bracket_next_point
end module least_squares_profile
