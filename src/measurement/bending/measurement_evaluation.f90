! SPDX-License-Identifier: GPL-3.0-or-later
!> Evaluates one load on one candidate, which is the task of all fits. The result depends on the arguments only and never on earlier
!> evaluations, so that tasks may run on any rank.
!>
!> Two zones are excluded, as by Truong et al.: the loaded point moves against the force, or the horizontal distance from root to
!> tip falls below half of the unloaded one. In contrast to Truong et al., shapes are ranked by how far they lie in these zones.
module measurement_evaluation
  use base_errors, only: require
  use base_kinds, only: rp
  use measurement_experiment, only: experiment_t
  use measurement_simulation, only: simulation_t
  use solid_statics, only: static_report_t
  implicit none
  private
  public :: evaluation_t, evaluation_work_t, evaluate, zone_violations

  integer, parameter, public :: VIOLATION_BACKWARD = 1, VIOLATION_FOLDED = 2

  !> Holds the result of an evaluation.
  type :: evaluation_t
    logical :: is_solved = .false.          !< the shape was found; otherwise all following components are 0
    real(rp) :: violation(2) = 0            !< >= 0, in lengths of the wing: how far the shape lies in the two zones
    integer :: factorisations = 0
    integer :: snaps = 0
    logical :: is_start = .false.           !< a start for warm solutions, see static_report_t
    logical :: was_redone_cold = .false.
    real(rp), allocatable :: residuals(:)   !< (n) [m] or [rad], computed minus measured
    real(rp), allocatable :: jacobian(:, :) !< (n, unknowns) their derivatives, or (0, 0)
  contains
    procedure :: init => evaluation_init
    procedure :: is_feasible => evaluation_is_feasible
    procedure :: terms => evaluation_terms
  end type evaluation_t

  !> Work space of evaluations, one per process. It does not affect the next evaluation. After an evaluation it can return
  !> derivatives with respect to parameters that are not unknowns: see simulation_t.
  type, extends(simulation_t) :: evaluation_work_t
  end type evaluation_work_t

contains

  !> Makes room for the result of load l.
  subroutine evaluation_init(self, experiment, l, has_jacobian)
    class(evaluation_t), intent(out) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    logical, intent(in) :: has_jacobian
    integer :: n
    n = experiment%count_residuals(l)
    allocate (self%residuals(n), source=0.0_rp)
    if (has_jacobian) then
      allocate (self%jacobian(n, experiment%count()), source=0.0_rp)
    else
      allocate (self%jacobian(0, 0))
    end if
  end subroutine evaluation_init

  !> Tells whether the shape was found and lies in none of the excluded zones.
  pure logical function evaluation_is_feasible(self) result(is_feasible)
    class(evaluation_t), intent(in) :: self
    is_feasible = self%is_solved .and. .not. any(self%violation > 0)
  end function evaluation_is_feasible

  !> Returns the contribution of load l to sums over loads, for callers that need no residuals: (1) the mean squared difference of
  !> heights [m^2], of which h^2 of Truong et al. is the sum; (2) the sum of squares over the declared variances.
  pure function evaluation_terms(self, experiment, l) result(terms)
    class(evaluation_t), intent(in) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp) :: terms(2)
    associate (comparison => experiment%comparisons(l))
      terms(1) = sum(self%residuals(:comparison%n_heights)**2)/max(1, comparison%n_heights)
      terms(2) = sum((self%residuals/comparison%sigma)**2)
    end associate
  end function evaluation_terms

  !> Solves load l at these coordinates and compares the result with the measurement. u(3, n_all) [m] is always the result, and the
  !> start of a warm solution, which must be a shape under the same load whose evaluation said `is_start`. `evaluation` was made by
  !> its `init`, which says whether derivatives are wanted. The comparison allocates nothing. If `load_offset` is given, the force
  !> acts at this distance [m] from its declared site.
  subroutine evaluate(experiment, work, coordinates, l, is_warm, u, evaluation, load_offset)
    type(experiment_t), intent(in) :: experiment
    type(evaluation_work_t), intent(inout) :: work
    real(rp), intent(in) :: coordinates(:)
    integer, intent(in) :: l
    logical, intent(in) :: is_warm
    real(rp), intent(inout) :: u(:, :)
    type(evaluation_t), intent(inout) :: evaluation
    real(rp), intent(in), optional :: load_offset(2)
    type(static_report_t) :: report
    integer :: i
    call require(size(coordinates) == experiment%count(), 'measurement_evaluation: unknowns of another experiment')
    call work%solve(experiment, coordinates, l, is_warm, u, report, load_offset)
    evaluation%is_solved = report%converged
    evaluation%factorisations = report%factorisations
    evaluation%snaps = report%snaps
    evaluation%is_start = report%is_start
    evaluation%was_redone_cold = report%was_redone_cold
    evaluation%violation = 0
    evaluation%residuals = 0
    evaluation%jacobian = 0
    if (.not. report%converged) return
    evaluation%violation = zone_violations(experiment, l, work%loaded%moved/work%view%scale)
    call work%residuals(experiment, coordinates, l, evaluation%residuals)
    do i = 1, size(evaluation%jacobian, 2)
      call work%derivative(experiment, l, i, evaluation%jacobian(:, i))
    end do
  end subroutine evaluate

  !> Returns how far the wing, moved by u(3, n_all) [m] under load l, lies in the two excluded zones, as fractions of the length of
  !> the wing; 0 outside. The numbers are the displacement of the loaded point against the force, and the difference of the
  !> horizontal distance from root to tip from one half of the unloaded one.
  pure function zone_violations(experiment, l, u) result(violation)
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(in) :: u(:, :)
    real(rp) :: violation(2), moved, unloaded(2)
    integer :: c
    moved = 0
    associate (site => experiment%sites(l), load => experiment%measurement%loads(l))
      do c = 1, 3
        moved = moved + site%weight(c)*dot_product(load%direction, u(:, site%corner(c)))
      end do
      if (.not. load%force > 0) moved = 0
    end associate
    unloaded = experiment%model%points(:2, experiment%tip) - experiment%root(:2)
    violation(VIOLATION_BACKWARD) = max(0.0_rp, -moved)/experiment%model%size
    violation(VIOLATION_FOLDED) = max(0.0_rp, 0.5_rp - norm2(unloaded + u(:2, experiment%tip))/norm2(unloaded))
  end function zone_violations
end module measurement_evaluation
