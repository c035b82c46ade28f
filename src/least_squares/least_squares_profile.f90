! SPDX-License-Identifier: GPL-3.0-or-later
!> Intervals by profile likelihood: one unknown is held at a value, all others are fitted again, and the interval is
!> where the sum of squares stays within a threshold of its minimum.
!>
!> Where a sum of squares jumps, as where a load snaps, refits stay in front of the jump. If one stands between the
!> minimum and an end, the data that jump are left out and the interval is found from the others: a smaller
!> experiment, with a wider but honest interval. Where nothing can be left out the interval ends at the jump, and
!> `is_jump` says so.
!>
!> The prior of the unknown itself is left out: what is returned is what the data say about it. Where the
!> profile stays below the threshold up to the bound, there is no end on that side.
module least_squares_profile
  use base_kinds, only: rp
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use least_squares_problem, only: least_squares_t, unknowns_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: interval_t, profile_interval, profile_sentence

  real(rp), parameter, public :: THRESHOLD_90 = 2.705543454095404_rp !< 90 % of chi^2 with one degree of freedom
  integer, parameter :: MOST_REFITS = 25
  real(rp), parameter :: ACCURACY = 0.01_rp     !< of the root of the threshold
  real(rp), parameter :: RESOLUTION = 1.0e-3_rp !< of the threshold, left in the sums of squares of refits

  !> What can be said about one unknown.
  type :: interval_t
    real(rp) :: best = 0                      !< where the sum of squares without the prior is smallest
    real(rp) :: lower = 0, upper = 0          !< ends; bounds of the box where there is none
    logical :: has_lower = .false., has_upper = .false.
    !> The lower, the upper end is where the sum of squares jumps, or where what is valid ends.
    logical :: is_jump(2) = .false.
    logical :: is_complete = .false.          !< the search of both ends came to its end
    integer :: n_refits = 0, n_evaluations = 0
    real(rp), allocatable :: profile(:, :)    !< (2, :) values tried, in that order, and the sum of squares above its
    !< minimum there
  end type interval_t

contains

  !> The interval of unknown i about the optimum p of a fit with the same unknowns; sd is its standard deviation
  !> in the linear approximation, a guess where to look. `threshold` is that of the sum of squares in units of the
  !> residuals' variance. A point where the others cannot be fitted counts as outside. slope(unknowns), where given, is how
  !> all unknowns follow unknown i in the linear approximation, from which the first fits of each side begin.
  subroutine profile_interval(problem, unknowns, p, i, sd, threshold, options, interval, slope)
    class(least_squares_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    real(rp), intent(in) :: p(:), sd, threshold
    integer, intent(in) :: i
    type(fit_options_t), intent(in) :: options
    type(interval_t), intent(out) :: interval
    real(rp), intent(in), optional :: slope(:)
    type(unknowns_t) :: others
    type(fit_options_t) :: refits
    type(fit_report_t) :: report
    class(solver_state_t), allocatable :: state_at_best, state_inside
    real(rp), allocatable :: best(:)
    real(rp) :: least
    logical :: is_found(2), found_better, is_less
    others = unknowns
    others%prior_sd(i) = 0
    refits = options
    refits%is_smooth = .true.
    call problem%get_state(state_at_best)
    do
      others%is_fixed(i) = unknowns%is_fixed(i)
      refits%reduction_tolerance = options%reduction_tolerance
      call refit(p)
      is_less = .false.
      if (report%has_jumped) call problem%leave_out(is_less)
      if (.not. is_less) call find_both_ends()
      if (.not. is_less) exit
      call problem%set_state(state_at_best)
      interval = interval_t(n_refits=interval%n_refits, n_evaluations=interval%n_evaluations)
    end do

  contains

    !> The interval about the point that was just fitted. `is_less`: data were left out, and all has to be found again.
    subroutine find_both_ends()
      integer :: attempt
      allocate (interval%profile(2, 0))
      interval%best = p(i)
      interval%lower = unknowns%lower(i)
      interval%upper = unknowns%upper(i)
      if (.not. report%is_converged .and. report%n_accepted == 0) return
      best = report%p
      least = report%chi2 + report%prior_chi2
      refits%reduction_tolerance = max(options%reduction_tolerance, RESOLUTION*threshold/(least + threshold))
      others%is_fixed(i) = .true.
      is_found = .false.
      do attempt = 1, 5 ! again if the profile has a lower minimum elsewhere
        call problem%get_state(state_at_best)
        interval%best = best(i)
        interval%profile = reshape([best(i), 0.0_rp], [2, 1])
        call find_end(-1, interval%lower, interval%has_lower, interval%is_jump(1), is_found(1), found_better)
        if (is_less) return
        if (found_better) cycle
        call problem%set_state(state_at_best)
        call find_end(1, interval%upper, interval%has_upper, interval%is_jump(2), is_found(2), found_better)
        if (is_less) return
        if (.not. found_better) exit
      end do
      interval%is_complete = all(is_found) .and. .not. found_better
    end subroutine find_both_ends

    !> The end of the interval in this direction: the root of w(x) = sqrt(sum of squares - least), which grows linearly
    !> for linear problems, at sqrt(threshold). A lower sum of squares on the way becomes the new minimum.
    subroutine find_end(direction, end, has_end, is_jump, is_found, found_better)
      integer, intent(in) :: direction
      real(rp), intent(out) :: end
      logical, intent(out) :: has_end, is_jump, is_found, found_better
      real(rp) :: inside, outside, w_inside, w_outside, x, w, goal, bound, room
      real(rp), allocatable :: at(:), at_inside(:), at_outside(:)
      logical :: has_outside, is_stuck
      integer :: n, n_same ! points in a row on the same side of the end, but for the first: inside > 0, outside < 0
      goal = sqrt(threshold)
      bound = merge(others%upper(i), others%lower(i), direction > 0)
      inside = best(i)
      w_inside = 0
      at_inside = best
      outside = bound
      w_outside = 0
      has_outside = .false.
      has_end = .false.
      is_jump = .false.
      is_found = .true.
      found_better = .false.
      is_stuck = .false.
      n_same = 0
      end = bound
      room = abs(bound - inside)
      if (.not. room > 0) return
      call problem%get_state(state_inside)
      x = max(min(sd*goal, 2*max(options%largest_step, 1.0_rp)*others%unit(i)), 1.0e-6_rp*min(room, others%unit(i)))
      x = inside + direction*min(room, x)
      do n = 1, MOST_REFITS
        ! The others follow the straight line through the last two fits.
        at = at_inside
        if (present(slope) .and. .not. abs(inside - best(i)) > 0) at = best + slope*(x - best(i))
        if (abs(inside - best(i)) > 0) at = best + (at_inside - best)*((x - best(i))/(inside - best(i)))
        at(i) = x
        others%is_fixed(i) = .true.
        call problem%set_state(state_inside)
        call refit(at)
        if (report%has_jumped .and. report%n_evaluations > 1) then ! a jump keeps the others from their minimum
          call problem%leave_out(is_less)
          if (is_less) return
        end if
        w = huge(w)
        if (report%is_converged .or. report%n_accepted > 0) then
          w = report%chi2 + report%prior_chi2 - least
          if (w < -1.0e-3_rp*threshold) then
            best = report%p
            least = report%chi2 + report%prior_chi2
            found_better = .true.
            return
          end if
          w = sqrt(max(0.0_rp, w))
          interval%profile = reshape([interval%profile, x, w**2], [2, size(interval%profile, 2) + 1])
        end if
        if (abs(w - goal) <= ACCURACY*goal) then
          end = x
          has_end = .true.
          return
        end if
        if (w < goal) then
          if (.not. abs(x - bound) > 0) return ! inside up to the bound: no end
          is_stuck = has_outside .and. .not. abs(outside - x) > 1.0e-3_rp*abs(x - best(i))
          if (has_outside) n_same = max(0, n_same) + 1
          inside = x
          w_inside = w
          at_inside = report%p
          call problem%get_state(state_inside)
        else
          is_stuck = .not. abs(x - inside) > 1.0e-3_rp*abs(x - best(i))
          if (has_outside) n_same = min(0, n_same) - 1
          outside = x
          at_outside = at
          w_outside = w
          has_outside = .true.
        end if
        if (is_stuck) then ! the sum of squares jumps, or what is valid ends
          call problem%set_state(state_inside)
          call refit(at_outside)
          if (report%has_jumped) call problem%leave_out(is_less)
          if (is_less) return
          w = huge(w)
          if (report%is_converged .or. report%n_accepted > 0) &
            w = sqrt(max(0.0_rp, report%chi2 + report%prior_chi2 - least))
          if (report%has_jumped .or. .not. w < (1 - ACCURACY)*goal) then
            end = outside
            has_end = .true.
            is_jump = report%has_jumped .or. w > (1 + ACCURACY)*goal
            return
          end if
          inside = outside ! seen from nearby it is no jump
          w_inside = w
          at_inside = report%p
          call problem%get_state(state_inside)
          has_outside = .false.
          n_same = 0
        end if
        x = next_point(inside, w_inside, outside, w_outside, has_outside, abs(n_same) > 2, goal, best(i), bound, &
                       direction)
      end do
      is_found = .false.
      if (has_outside) end = outside
      has_end = has_outside
    end subroutine find_end

    subroutine refit(start)
      real(rp), intent(in) :: start(:)
      call fit(problem, others, start, refits, report)
      interval%n_refits = interval%n_refits + 1
      interval%n_evaluations = interval%n_evaluations + report%n_evaluations
    end subroutine refit

  end subroutine profile_interval

  !> Where to look for the end next: by the straight line through the last two points, kept inside the bracket, or
  !> farther out while there is none; in its middle if it `is_slow` to shrink.
  pure real(rp) function next_point(inside, w_inside, outside, w_outside, has_outside, is_slow, goal, best, bound, &
                                    direction) result(x)
    real(rp), intent(in) :: inside, w_inside, outside, w_outside, goal, best, bound
    logical, intent(in) :: has_outside, is_slow
    integer, intent(in) :: direction
    real(rp) :: fraction, factor
    if (.not. has_outside) then
      factor = 4
      if (w_inside > 0.25_rp*goal) factor = goal/w_inside
      x = best + factor*(inside - best)
      if (direction*(x - bound) > 0) x = bound
    else
      fraction = 0.5_rp
      if (w_outside < 1.0e3_rp*goal .and. .not. is_slow) fraction = (goal - w_inside)/(w_outside - w_inside)
      x = inside + max(0.05_rp, min(0.95_rp, fraction))*(outside - inside)
    end if
  end function next_point

  !> A sentence about an unknown: its value and interval, or what alone can be said. The interval's numbers are
  !> logarithms if `is_log`.
  function profile_sentence(name, unit, is_log, interval) result(sentence)
    character(*), intent(in) :: name, unit
    logical, intent(in) :: is_log
    type(interval_t), intent(in) :: interval
    character(:), allocatable :: sentence
    character(*), parameter :: AT_JUMP = ' jump or end, not where they fit no more)'
    if (interval%has_lower .and. interval%has_upper) then
      sentence = name//': '//shown(interval%best)//behind()//', with 90 % confidence between '// &
                 shown(interval%lower)//' and '//shown(interval%upper)//behind()
    else if (interval%has_lower) then
      sentence = name//': not determined by these data; only > '//shown(interval%lower)//behind()//' can be said'
    else if (interval%has_upper) then
      sentence = name//': not determined by these data; only < '//shown(interval%upper)//behind()//' can be said'
    else if (interval%is_complete) then
      sentence = name//': not determined by these data; every value from '//shown(interval%lower)//' to '// &
                 shown(interval%upper)//behind()//' is as good'
    else
      sentence = name//': nothing can be said; the search for its interval did not come to its end'
      return
    end if
    if (.not. interval%is_complete) sentence = sentence//' (the search did not come to its end)'
    if (interval%is_jump(1)) sentence = sentence//' (the lower end is where shapes'//AT_JUMP
    if (interval%is_jump(2)) sentence = sentence//' (the upper end is where shapes'//AT_JUMP

  contains

    function behind() result(text)
      character(:), allocatable :: text
      text = ''
      if (unit /= '1' .and. unit /= '') text = ' '//unit
    end function behind

    !> With as many digits as tell the ends apart from the best value.
    function shown(x) result(text)
      real(rp), intent(in) :: x
      character(:), allocatable :: text
      character(30) :: buffer, form
      real(rp) :: ends(2)
      integer :: digits
      ends = [interval%lower, interval%upper]
      if (is_log) ends = exp(ends)
      digits = 3
      if (interval%has_lower .and. interval%has_upper .and. ends(2) > ends(1)) &
        digits = max(3, min(14, 2 - floor(log10((ends(2) - ends(1))/maxval(abs(ends))))))
      write (form, '(a,i0,a)') '(es24.', digits, ')'
      write (buffer, form) merge(exp(merge(x, 0.0_rp, is_log)), x, is_log)
      text = trim(adjustl(buffer))
    end function shown

  end function profile_sentence
end module least_squares_profile
