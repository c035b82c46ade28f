! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes a search: successive runs of CMA-ES, which share one budget of evaluations.
!>
!> IPOP (Auger and Hansen, CEC 2005): every restart doubles lambda. BIPOP (Hansen, GECCO 2009 workshop): restarts with a doubled
!> lambda alternate with runs of small populations and steps, lambda_s = lambda_0 (lambda_l/(2 lambda_0))^(u^2), sigma_s = sigma_0
!> 10^(-2 v), u and v uniform. Both kinds use equal numbers of evaluations; a small run may use half the evaluations of the last
!> large run.
module cmaes_search
  use base_errors, only: require
  use base_kinds, only: rp, i8
  use base_named_kinds, only: named_kind_t
  use base_text, only: number_text
  use base_visitor, only: visited_t, visitor_t
  use cmaes_optimiser, only: cmaes_t
  use cmaes_options, only: cmaes_options_t
  use cmaes_params, only: cmaes_params_t, derive_params
  use cmaes_sampling, only: draw_uniforms
  use cmaes_stop, only: RUNNING, FTARGET, MAXFEVALS, TOO_MANY_FAILED, stop_text
  implicit none
  private
  public :: cmaes_search_t, start_region_t, FIRST_RUN, LARGE_RUN, SMALL_RUN, RESTART_RULES, RESTARTS_NONE, RESTARTS_IPOP, &
            RESTARTS_BIPOP

  integer, parameter :: RESTARTS_NONE = 1, RESTARTS_IPOP = 2, RESTARTS_BIPOP = 3
  type(named_kind_t), parameter :: RESTART_RULES(3) = [named_kind_t('none', RESTARTS_NONE), &
                                                       named_kind_t('ipop', RESTARTS_IPOP), &
                                                       named_kind_t('bipop', RESTARTS_BIPOP)]

  integer, parameter :: FIRST_RUN = 0, LARGE_RUN = 1, SMALL_RUN = 2
  integer, parameter :: START = 1, SCHEDULE = 2 ! purposes of random numbers

  !> The starting points of runs: uniformly distributed between two corners. The first run starts at `first`, if allocated.
  type :: start_region_t
    real(rp), allocatable :: lower(:), upper(:) !< of size n
    real(rp), allocatable :: first(:)
    logical :: is_box = .false. !< the search is confined to [0, 1]^n
  end type start_region_t

  !> The state of the restarts, a part of the checkpoint.
  type, extends(visited_t) :: cmaes_search_state_t
    integer :: restart = 0          !< number of the present run, from 0
    integer :: regime = FIRST_RUN
    integer :: n_large = 0          !< restarts with a doubled population
    integer :: lambda = 0           !< of the present run
    real(rp) :: sigma0 = 0          !< of the present run
    integer(i8) :: run_limit = 0    !< evaluations that the present run may spend
    integer(i8) :: evaluations = 0  !< of all finished runs
    integer(i8) :: spent_large = 0, spent_small = 0, last_large = 0 !< evaluations
    integer :: stop_code = RUNNING  !< why the search ended
    integer :: last_stop = RUNNING  !< why the last finished run ended
    logical :: has_best = .false.
    real(rp) :: best_f = huge(1.0_rp) !< of finished runs
    real(rp), allocatable :: best_x(:)
    integer(i8) :: best_evaluation = 0 !< counted through all runs, from 1
    real(rp) :: f_scale = -1
  contains
    procedure :: visit => state_visit
  end type cmaes_search_state_t

  type, extends(visited_t) :: cmaes_search_t
    type(cmaes_options_t) :: options
    integer :: restarts = RESTARTS_NONE
    integer :: max_restarts = 9
    type(start_region_t) :: region
    type(cmaes_search_state_t) :: state
    type(cmaes_t) :: run !< the present one
  contains
    procedure :: start => search_start
    procedure :: ask => search_ask
    procedure :: tell => search_tell
    procedure :: evaluations => search_evaluations
    procedure :: best => search_best
    procedure :: stop_sentence => search_stop_sentence
    procedure :: visit => search_visit
  end type cmaes_search_t

contains

  !> Begins the first run. The options must be valid.
  subroutine search_start(self, options, restarts, max_restarts, region)
    class(cmaes_search_t), intent(out) :: self
    type(cmaes_options_t), intent(in) :: options
    integer, intent(in) :: restarts !< RESTARTS_*
    integer, intent(in) :: max_restarts
    type(start_region_t), intent(in) :: region
    type(cmaes_params_t) :: p
    call require(any(restarts == RESTART_RULES%kind), 'search_start: a known kind of restarts')
    call require(size(region%lower) == size(region%upper), 'search_start: corners of equal size')
    self%options = options
    self%restarts = restarts
    self%max_restarts = max_restarts
    self%region = region
    p = derive_params(options, size(region%lower))
    allocate (self%state%best_x(p%n))
    self%state%best_x(:) = 0
    self%state%lambda = p%lambda
    self%state%sigma0 = p%sigma0
    self%state%run_limit = options%max_evaluations
    self%state%f_scale = options%f_scale
    call begin_run(self)
  end subroutine search_start

  !> Returns the run that the state describes.
  subroutine begin_run(self)
    class(cmaes_search_t), intent(inout) :: self
    type(cmaes_options_t) :: options
    real(rp) :: mean(size(self%region%lower))
    options = self%options
    options%max_evaluations = self%state%run_limit
    options%f_scale = self%state%f_scale
    call draw_uniforms(options%seed, self%state%restart, START, mean)
    mean = self%region%lower + mean*(self%region%upper - self%region%lower)
    if (self%state%restart == 0 .and. allocated(self%region%first)) mean = self%region%first
    call self%run%start(options, derive_params(self%options, size(mean), self%state%lambda, self%state%sigma0), mean, &
                        self%region%is_box, self%state%restart)
  end subroutine begin_run

  !> Returns the candidates of the present generation. x(n, lambda) is reallocated when lambda has changed.
  subroutine search_ask(self, x)
    class(cmaes_search_t), intent(inout) :: self
    real(rp), allocatable, intent(inout) :: x(:, :)
    call require(self%state%stop_code == RUNNING, 'search_ask: a search that has not ended')
    if (allocated(x)) then
      if (size(x, 2) /= self%state%lambda .or. size(x, 1) /= self%run%params%n) deallocate (x)
    end if
    if (.not. allocated(x)) allocate (x(self%run%params%n, self%state%lambda))
    call self%run%ask(x)
  end subroutine search_ask

  !> Updates the run as `cmaes_t%tell` does. When the run ends, the next run begins or the search ends (state%stop_code).
  subroutine search_tell(self, f, violation, has_failed)
    class(cmaes_search_t), intent(inout) :: self
    real(rp), intent(in) :: f(:)
    real(rp), intent(in), optional :: violation(:)
    logical, intent(in), optional :: has_failed(:)
    call self%run%tell(f, violation, has_failed)
    if (self%run%state%stop_code == RUNNING) return
    call finish_run(self)
    if (self%state%stop_code == RUNNING) call begin_run(self)
  end subroutine search_tell

  !> Records a run that has ended, and chooses the next one or ends the search.
  subroutine finish_run(self)
    class(cmaes_search_t), intent(inout) :: self
    integer(i8) :: spent, left
    logical :: has_best
    real(rp) :: best_f, best_x(self%run%params%n)
    integer(i8) :: best_evaluation
    call self%best(has_best, best_f, best_x, best_evaluation)
    self%state%has_best = has_best
    self%state%best_f = best_f
    self%state%best_x = best_x
    self%state%best_evaluation = best_evaluation
    spent = self%run%state%counts%evaluations
    self%state%evaluations = self%state%evaluations + spent
    if (self%state%regime == LARGE_RUN) then
      self%state%spent_large = self%state%spent_large + spent
      self%state%last_large = spent
    else if (self%state%regime == SMALL_RUN) then
      self%state%spent_small = self%state%spent_small + spent
    end if
    self%state%f_scale = self%run%state%history%f_scale
    self%state%last_stop = self%run%state%stop_code
    left = self%options%max_evaluations - self%state%evaluations
    if (self%state%last_stop == FTARGET .or. self%state%last_stop == TOO_MANY_FAILED .or. &
        self%restarts == RESTARTS_NONE .or. self%state%restart >= self%max_restarts) then
      self%state%stop_code = self%state%last_stop
      return
    end if
    call choose_next(self, left)
    if (self%state%lambda > left) self%state%stop_code = MAXFEVALS
  end subroutine finish_run

  !> Sets kind, population, step and budget of the next run.
  subroutine choose_next(self, left)
    class(cmaes_search_t), intent(inout) :: self
    integer(i8), intent(in) :: left
    type(cmaes_params_t) :: p
    real(rp) :: u(2), ratio
    p = derive_params(self%options, self%run%params%n)
    associate (state => self%state)
      state%restart = state%restart + 1
      state%run_limit = left
      if (self%restarts == RESTARTS_BIPOP .and. state%n_large > 0 .and. state%spent_small < state%spent_large) then
        state%regime = SMALL_RUN
        call draw_uniforms(self%options%seed, state%restart, SCHEDULE, u)
        ratio = 0.5_rp*2.0_rp**state%n_large
        state%lambda = max(p%lambda, int(p%lambda*ratio**(u(1)**2)))
        state%sigma0 = p%sigma0*10.0_rp**(-2*u(2))
        state%run_limit = min(left, max(state%last_large/2, int(state%lambda, i8)))
      else
        state%regime = LARGE_RUN
        state%n_large = state%n_large + 1
        state%lambda = p%lambda*2**state%n_large
        state%sigma0 = p%sigma0
      end if
    end associate
  end subroutine choose_next

  !> Returns the number of evaluations of the whole search so far.
  pure integer(i8) function search_evaluations(self) result(n)
    class(cmaes_search_t), intent(in) :: self
    n = self%state%evaluations
    if (self%state%stop_code == RUNNING) n = n + self%run%state%counts%evaluations
  end function search_evaluations

  !> Returns the best feasible candidate of the whole search, as it was evaluated; of equal ones the first.
  subroutine search_best(self, has_best, f, x, evaluation)
    class(cmaes_search_t), intent(in) :: self
    logical, intent(out) :: has_best
    real(rp), intent(out) :: f, x(:)
    integer(i8), intent(out) :: evaluation
    has_best = self%state%has_best
    f = self%state%best_f
    x = self%state%best_x
    evaluation = self%state%best_evaluation
    if (self%state%stop_code /= RUNNING .or. .not. self%run%state%best%is_seen) return
    if (has_best .and. self%run%state%best%f >= f) return
    has_best = .true.
    f = self%run%state%best%f
    x = self%run%state%best%x
    evaluation = self%state%evaluations + self%run%state%best%evaluation
  end subroutine search_best

  !> Returns why the search, or the last run before a restart, ended.
  function search_stop_sentence(self) result(text)
    class(cmaes_search_t), intent(in) :: self
    character(:), allocatable :: text
    text = stop_text(merge(self%state%last_stop, self%state%stop_code, self%state%stop_code == RUNNING))
    associate (state => self%run%state)
      if (state%counts%n_repairs + state%counts%n_floored > 0) text = text//'; in the last run the covariance was reset '// &
                                                     number_text(state%counts%n_repairs)//' times and raised to its floor '// &
                                                        number_text(state%counts%n_floored)//' times'
    end associate
  end function search_stop_sentence

  !> Stores the search in the visitor, or restores it from the visitor. Before a restoration `start` must have been called with the
  !> same options; only budgets and tolerances may differ. If the visitor fails, only its failure is defined.
  subroutine search_visit(self, visitor)
    class(cmaes_search_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    integer(i8) :: left
    call visitor%leave_out('options restarts max_restarts region')
    call visitor%visit('search', self%state)
    if (visitor%failure%failed) return
    if (visitor%is_reading) then
      ! The run may use the rest of the present budget; small runs have an additional limit.
      left = self%options%max_evaluations - self%state%evaluations
      if (self%state%regime == SMALL_RUN) left = min(left, self%state%run_limit)
      self%state%run_limit = left
      call begin_run(self)
    end if
    call self%run%state%visit(visitor)
    if (visitor%is_reading .and. .not. visitor%failure%failed) call self%run%restored()
  end subroutine search_visit

  !> Shows every component to the visitor; `best_x` has its size.
  subroutine state_visit(self, visitor)
    class(cmaes_search_state_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('restart', self%restart)
    call visitor%visit('regime', self%regime)
    call visitor%visit('n_large', self%n_large)
    call visitor%visit('lambda', self%lambda)
    call visitor%visit('sigma0', self%sigma0)
    call visitor%visit('run_limit', self%run_limit)
    call visitor%visit('evaluations', self%evaluations)
    call visitor%visit('spent_large', self%spent_large)
    call visitor%visit('spent_small', self%spent_small)
    call visitor%visit('last_large', self%last_large)
    call visitor%visit('stop_code', self%stop_code)
    call visitor%visit('last_stop', self%last_stop)
    call visitor%visit('has_best', self%has_best)
    call visitor%visit('best_f', self%best_f)
    call visitor%visit('best_x', self%best_x)
    call visitor%visit('best_evaluation', self%best_evaluation)
    call visitor%visit('f_scale', self%f_scale)
  end subroutine state_visit
end module cmaes_search
