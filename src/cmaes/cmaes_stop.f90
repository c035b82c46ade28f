! SPDX-License-Identifier: GPL-3.0-or-later
!> Decides when a run of CMA-ES ends. Criteria of pycma have their names and defaults of pycma. The tolerances of f are relative to
!> `f_scale`, because f may have any unit.
module cmaes_stop
  use base_kinds, only: rp
  use cmaes_options, only: cmaes_options_t
  use cmaes_params, only: cmaes_params_t
  use cmaes_ranking, only: FEASIBLE, sort_values
  use cmaes_state, only: cmaes_state_t, cmaes_work_t, WINDOW
  implicit none
  private
  public :: find_stop, note_history, stop_text, stop_name

  integer, parameter, public :: RUNNING = 0, FTARGET = 1, MAXFEVALS = 2, MAXITER = 3, TOLFUN = 4, TOLFUNHIST = 5
  integer, parameter, public :: TOLX = 6, TOLFACUPX = 7, TOLUPSIGMA = 8, STAGNATION = 9, FLAT_FITNESS = 10
  integer, parameter, public :: NOEFFECTAXIS = 11, NOEFFECTCOORD = 12, CONDITIONCOV = 13, TOO_MANY_FAILED = 14
  integer, parameter, public :: N_STOPS = 14
  integer, parameter :: N_HISTORY = 10 ! generations after which a flat history counts

contains

  !> Returns the name of a criterion, `running` for 0.
  pure function stop_name(code) result(name)
    integer, intent(in) :: code
    character(:), allocatable :: name
    character(13), parameter :: NAMES(0:N_STOPS) = &
      [character(13) :: 'running', 'ftarget', 'maxfevals', 'maxiter', 'tolfun', 'tolfunhist', 'tolx', &
       'tolfacupx', 'tolupsigma', 'tolstagnation', 'flatfitness', 'noeffectaxis', 'noeffectcoord', &
       'conditioncov', 'toomanyfailed']
    name = 'unknown'
    if (code >= 0 .and. code <= N_STOPS) name = trim(NAMES(code))
  end function stop_name

  !> Returns the name of a criterion and its meaning.
  pure function stop_text(code) result(text)
    integer, intent(in) :: code
    character(:), allocatable :: text
    select case (code)
    case (RUNNING)
      text = 'the run goes on'
    case (FTARGET)
      text = 'the target was reached'
    case (MAXFEVALS)
      text = 'the allowed evaluations do not suffice for another generation'
    case (MAXITER)
      text = 'all allowed generations are spent'
    case (TOLFUN)
      text = 'f varies less than tolfun in a generation and between recent ones'
    case (TOLFUNHIST)
      text = 'the best f of recent generations varies less than tolfunhist'
    case (TOLX)
      text = 'the step is shorter than tolx in all coordinates'
    case (TOLFACUPX)
      text = 'the step grew by tolfacupx: sigma0 is far too small, or the search diverges'
    case (TOLUPSIGMA)
      text = 'the step size grows while the axes of the distribution shrink: the search makes no progress'
    case (STAGNATION)
      text = 'neither the best nor the median f has improved for tolstagnation generations'
    case (FLAT_FITNESS)
      text = 'all parents are equal in f'
    case (NOEFFECTAXIS)
      text = 'a tenth of the step along an axis no longer changes the mean'
    case (NOEFFECTCOORD)
      text = 'a fifth of the step in a coordinate no longer changes the mean'
    case (CONDITIONCOV)
      text = 'the covariance matrix is ill-conditioned'
    case (TOO_MANY_FAILED)
      text = 'more than half of the candidates failed, also with smaller steps'
    case default
      text = 'unknown'
    end select
    text = stop_name(code)//': '//text
  end function stop_text

  !> Puts the generation's best and median f into the histories and counts flat generations. `f` has the values of this generation;
  !> work%order, classes and keys describe its ranking.
  subroutine note_history(p, state, work, f)
    type(cmaes_params_t), intent(in) :: p
    type(cmaes_state_t), intent(inout) :: state
    type(cmaes_work_t), intent(inout) :: work
    real(rp), intent(in) :: f(:)
    integer :: place, last
    place = modulo(state%history%n, size(state%history%best)) + 1
    state%history%best(place) = f_at(1)
    state%history%median(place) = f_at((p%lambda + 1)/2)
    state%history%n = state%history%n + 1
    if (state%history%f_scale < 0 .and. f_at((p%lambda + 1)/2) < huge(1.0_rp)) &
      state%history%f_scale = abs(f_at((p%lambda + 1)/2))
    last = work%order(p%mu)
    if (work%classes(work%order(1)) == work%classes(last) .and. &
        work%keys(work%order(1)) >= work%keys(last)) then
      state%history%n_flat = state%history%n_flat + 1
    else
      state%history%n_flat = 0
    end if

  contains

    !> Returns f of the candidate with this rank; it is huge if the candidate is not feasible.
    real(rp) function f_at(r)
      integer, intent(in) :: r
      f_at = huge(1.0_rp)
      if (work%classes(work%order(r)) == FEASIBLE) f_at = f(work%order(r))
    end function f_at

  end subroutine note_history

  !> Returns the first criterion of the list above that holds after a generation, or RUNNING.
  integer function find_stop(options, p, state, work, f) result(code)
    type(cmaes_options_t), intent(in) :: options
    type(cmaes_params_t), intent(in) :: p
    type(cmaes_state_t), intent(in) :: state
    type(cmaes_work_t), intent(inout) :: work
    real(rp), intent(in) :: f(:)
    real(rp) :: range
    integer :: i, axis
    logical :: holds(N_STOPS)
    holds = .false.
    if (state%best%is_seen) holds(FTARGET) = state%best%f <= options%f_target
    holds(MAXFEVALS) = state%counts%evaluations > options%max_evaluations - p%lambda
    holds(MAXITER) = state%generation >= p%max_iterations
    if (state%history%n >= N_HISTORY .and. state%history%f_scale >= 0) then
      range = recent_range(p, state)
      holds(TOLFUNHIST) = range <= options%tolfunhist*state%history%f_scale
      holds(TOLFUN) = max(range, generation_range(work, f)) <= options%tolfun*state%history%f_scale
    end if
    holds(TOLX) = .true.
    axis = modulo(state%generation, p%n) + 1
    holds(NOEFFECTAXIS) = .true.
    do i = 1, p%n
      associate (deviation => state%sigma*sqrt(state%c(i, i)))
        holds(TOLX) = holds(TOLX) .and. max(deviation, state%sigma*abs(state%p_c(i))) < options%tolx*p%sigma0
        holds(TOLFACUPX) = holds(TOLFACUPX) .or. deviation > options%tolfacupx*p%sigma0
        holds(NOEFFECTCOORD) = holds(NOEFFECTCOORD) .or. same(state%mean(i), state%mean(i) + 0.2_rp*deviation)
      end associate
      holds(NOEFFECTAXIS) = holds(NOEFFECTAXIS) .and. &
                            same(state%mean(i), state%mean(i) + 0.1_rp*state%sigma*state%d(axis)*state%b(i, axis))
    end do
    holds(TOLUPSIGMA) = state%sigma/p%sigma0 > options%tolupsigma*maxval(state%d)
    holds(STAGNATION) = is_stagnant(p, state, work)
    holds(FLAT_FITNESS) = state%history%n_flat > options%tolflatfitness
    holds(CONDITIONCOV) = state%condition > options%condition_limit
    code = RUNNING
    do i = N_STOPS, 1, -1
      if (holds(i)) code = i
    end do
  end function find_stop

  !> Tells whether two reals are equal.
  pure logical function same(a, b)
    real(rp), intent(in) :: a, b
    same = abs(a - b) <= 0
  end function same

  !> Returns the range of the best f of the last n_recent generations; huge if one had no feasible candidate.
  pure real(rp) function recent_range(p, state) result(range)
    type(cmaes_params_t), intent(in) :: p
    type(cmaes_state_t), intent(in) :: state
    real(rp) :: low, high, value
    integer :: i
    low = huge(1.0_rp)
    high = -huge(1.0_rp)
    do i = 1, min(p%n_recent, state%history%n)
      value = state%history%best(modulo(state%history%n - i, size(state%history%best)) + 1)
      low = min(low, value)
      high = max(high, value)
    end do
    range = huge(1.0_rp)
    if (high < huge(1.0_rp)) range = high - low
  end function recent_range

  !> Returns the range of f in the last generation; huge unless all candidates were feasible.
  pure real(rp) function generation_range(work, f) result(range)
    type(cmaes_work_t), intent(in) :: work
    real(rp), intent(in) :: f(:)
    range = huge(1.0_rp)
    if (all(work%classes == FEASIBLE)) range = maxval(f) - minval(f)
  end function generation_range

  !> Tells whether the run stagnates: the medians over the newest WINDOW generations are not better than the medians over WINDOW
  !> generations that lie tolstagnation generations earlier.
  logical function is_stagnant(p, state, work)
    type(cmaes_params_t), intent(in) :: p
    type(cmaes_state_t), intent(in) :: state
    type(cmaes_work_t), intent(inout) :: work
    is_stagnant = .false.
    if (state%history%n < p%tolstagnation + WINDOW) return
    is_stagnant = window_median(state%history%best, 0) >= window_median(state%history%best, p%tolstagnation)
    if (is_stagnant) is_stagnant = window_median(state%history%median, 0) >= &
      window_median(state%history%median, p%tolstagnation)

  contains

    !> Returns the median of WINDOW entries that end `back` generations ago.
    real(rp) function window_median(history, back)
      real(rp), intent(in) :: history(:)
      integer, intent(in) :: back
      integer :: i
      do i = 1, WINDOW
        work%window(i) = history(modulo(state%history%n - back - i, size(history)) + 1)
      end do
      call sort_values(work%window)
      window_median = work%window(WINDOW/2)/2 + work%window(WINDOW/2 + 1)/2
    end function window_median

  end function is_stagnant
end module cmaes_stop
