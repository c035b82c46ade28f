! SPDX-License-Identifier: GPL-3.0-or-later
!> Problems of least squares with known answers. Misra1a and MGH09: https://www.itl.nist.gov/div898/strd/nls
module curve_problems
  use base_kinds, only: rp
  use least_squares_problem, only: least_squares_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: linear_t, misra1a_t, mgh09_t, compliance_t, two_wells_t, snapping_t, snapping_state_t

  !> residuals = a p - b
  type, extends(least_squares_t) :: linear_t
    real(rp), allocatable :: a(:, :), b(:)
  contains
    procedure :: evaluate => linear_evaluate
  end type linear_t

  !> y = b1 (1 - exp(-b2 x))
  type, extends(least_squares_t) :: misra1a_t
    real(rp) :: x(14) = 0, y(14) = 0
  contains
    procedure :: init => misra1a_init
    procedure :: evaluate => misra1a_evaluate
  end type misra1a_t

  !> y = b1 (x^2 + b2 x)/(x^2 + b3 x + b4)
  type, extends(least_squares_t) :: mgh09_t
    real(rp) :: x(11) = 0, y(11) = 0
  contains
    procedure :: init => mgh09_init
    procedure :: evaluate => mgh09_evaluate
  end type mgh09_t

  !> One reading of exp(-q), valid below some q.
  type, extends(least_squares_t) :: compliance_t
    real(rp) :: measured = 0, noise = 1, valid_below = huge(1.0_rp)
  contains
    procedure :: evaluate => compliance_evaluate
  end type compliance_t

  !> p^2 was read as 1, as often as there are residuals, with some error: p is 1 or -1. Valid where |p| < 10.
  type, extends(least_squares_t) :: two_wells_t
    real(rp) :: error = 1
    integer :: n_evaluations = 0
  contains
    procedure :: evaluate => two_wells_evaluate
  end type two_wells_t

  !> Where a snapping_t was.
  type, extends(solver_state_t) :: snapping_state_t
    real(rp) :: p = 0
  end type snapping_state_t

  !> Two readings of p, each a group of data: both are 0, with these errors. The first one is far away above some p, and not valid
  !> far below. It counts the points that are evaluated from another state than the best one so far.
  type, extends(least_squares_t) :: snapping_t
    real(rp) :: error(2) = 1, snaps_at = huge(1.0_rp)
    real(rp) :: least = huge(1.0_rp), at_least = 0
    integer :: n_wrong = 0
  contains
    procedure :: evaluate => snapping_evaluate
  end type snapping_t

contains

  subroutine linear_evaluate(self, p, from, residuals, jacobian, is_valid, to)
    class(linear_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out) :: to
    allocate (to, source=from)
    residuals = matmul(self%a, p) - self%b
    jacobian = self%a
    is_valid = .true.
  end subroutine linear_evaluate

  subroutine misra1a_init(self)
    class(misra1a_t), intent(out) :: self
    self%n_residuals = size(self%x)
    self%y = [10.07_rp, 14.73_rp, 17.94_rp, 23.93_rp, 29.61_rp, 35.18_rp, 40.02_rp, 44.82_rp, 50.76_rp, 55.05_rp, &
              61.01_rp, 66.40_rp, 75.47_rp, 81.78_rp]
    self%x = [77.6_rp, 114.9_rp, 141.1_rp, 190.8_rp, 239.9_rp, 289.0_rp, 332.8_rp, 378.4_rp, 434.8_rp, 477.3_rp, &
              536.8_rp, 593.1_rp, 689.1_rp, 760.0_rp]
  end subroutine misra1a_init

  subroutine misra1a_evaluate(self, p, from, residuals, jacobian, is_valid, to)
    class(misra1a_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out) :: to
    allocate (to, source=from)
    is_valid = p(2) > -0.1_rp
    residuals = 0
    jacobian = 0
    if (.not. is_valid) return
    residuals = p(1)*(1 - exp(-p(2)*self%x)) - self%y
    jacobian(:, 1) = 1 - exp(-p(2)*self%x)
    jacobian(:, 2) = p(1)*self%x*exp(-p(2)*self%x)
  end subroutine misra1a_evaluate

  subroutine mgh09_init(self)
    class(mgh09_t), intent(out) :: self
    self%n_residuals = size(self%x)
    self%y = [0.1957_rp, 0.1947_rp, 0.1735_rp, 0.1600_rp, 0.0844_rp, 0.0627_rp, 0.0456_rp, 0.0342_rp, 0.0323_rp, &
              0.0235_rp, 0.0246_rp]
    self%x = [4.0_rp, 2.0_rp, 1.0_rp, 0.5_rp, 0.25_rp, 0.167_rp, 0.125_rp, 0.1_rp, 0.0833_rp, 0.0714_rp, 0.0625_rp]
  end subroutine mgh09_init

  subroutine mgh09_evaluate(self, p, from, residuals, jacobian, is_valid, to)
    class(mgh09_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out) :: to
    real(rp), dimension(size(self%x)) :: top, bottom
    allocate (to, source=from)
    top = self%x**2 + self%x*p(2)
    bottom = self%x**2 + self%x*p(3) + p(4)
    is_valid = all(abs(bottom) > 1.0e-10_rp)
    residuals = 0
    jacobian = 0
    if (.not. is_valid) return
    residuals = p(1)*top/bottom - self%y
    jacobian(:, 1) = top/bottom
    jacobian(:, 2) = p(1)*self%x/bottom
    jacobian(:, 3) = -p(1)*top*self%x/bottom**2
    jacobian(:, 4) = -p(1)*top/bottom**2
  end subroutine mgh09_evaluate

  subroutine compliance_evaluate(self, p, from, residuals, jacobian, is_valid, to)
    class(compliance_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out) :: to
    allocate (to, source=from)
    is_valid = p(1) < self%valid_below
    residuals = (exp(-p(1)) - self%measured)/self%noise
    jacobian = -exp(-p(1))/self%noise
  end subroutine compliance_evaluate

  subroutine two_wells_evaluate(self, p, from, residuals, jacobian, is_valid, to)
    class(two_wells_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out) :: to
    allocate (to, source=from)
    self%n_evaluations = self%n_evaluations + 1
    is_valid = abs(p(1)) < 10
    residuals = (p(1)**2 - 1)/self%error
    jacobian = 2*p(1)/self%error
  end subroutine two_wells_evaluate

  subroutine snapping_evaluate(self, p, from, residuals, jacobian, is_valid, to)
    class(snapping_t), intent(inout) :: self
    real(rp), intent(in) :: p(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out) :: to
    real(rp), parameter :: FAR = -100.0_rp, JUMP = 2000.0_rp
    real(rp) :: before
    before = 0
    select type (from)
    type is (snapping_state_t)
      before = from%p
    end select
    if (self%least < huge(1.0_rp) .and. abs(before - self%at_least) > 0) self%n_wrong = self%n_wrong + 1
    is_valid = p(1) > FAR
    residuals = p(1)/self%error
    jacobian(:, 1) = 1/self%error
    if (p(1) > self%snaps_at) residuals(1) = residuals(1) + JUMP
    where (from%is_left_out)
      residuals = 0
      jacobian(:, 1) = 0
    end where
    if (is_valid .and. sum(residuals**2) < self%least) then
      self%least = sum(residuals**2)
      self%at_least = p(1)
    end if
    allocate (to, source=snapping_state_t(jumped=[before > self%snaps_at .neqv. p(1) > self%snaps_at, .false.], &
                                          is_left_out=from%is_left_out, p=p(1)))
    to%jumped = to%jumped .and. .not. to%is_left_out
  end subroutine snapping_evaluate
end module curve_problems
