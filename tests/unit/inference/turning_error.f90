! SPDX-License-Identifier: GPL-3.0-or-later
!> A beam with an error whose direction depends on the wing: for tests of the relinearisation of a diagnosis.
module turning_error
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_beam, only: beam_t, P_ONE_WAY
  use inference_relinearisation, only: model_error_t
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: twisted_t, turning_t, growing_t, angle_of, error_of, factor_of

  real(rp), parameter, public :: TRUTH = 1.5_rp
  real(rp), parameter :: BOW = 0.01_rp, TWIST = 0.02_rp

  type, extends(solver_state_t) :: twisted_state_t
    real(rp) :: angle = 0, factor = 1
  end type twisted_state_t

  !> A beam with the error: angle 0 is the bow, a right angle the twist.
  type, extends(beam_t) :: twisted_t
    real(rp) :: angle = 0 !< that a diagnosis begins with
  contains
    procedure :: directions => twisted_directions
    procedure :: initial_state => twisted_initial_state
  end type twisted_t

  type, extends(model_error_t) :: turning_t
    integer :: n_calls = 0
  contains
    procedure :: renew => turning_renew
    procedure :: linearise => turning_linearise
  end type turning_t

  !> An error that is a hundred times as large whenever it is renewed.
  type, extends(turning_t) :: growing_t
  contains
    procedure :: renew => growing_renew
  end type growing_t

contains

  pure real(rp) function angle_of(q)
    real(rp), intent(in) :: q(:)
    angle_of = 0.5_rp*acos(-1.0_rp)*q(P_ONE_WAY)/TRUTH
  end function angle_of

  pure function error_of(beam, angle) result(e)
    class(twisted_t), intent(in) :: beam
    real(rp), intent(in) :: angle
    real(rp) :: e(beam%n_observations)
    integer :: k
    do k = 1, size(e)
      associate (x => beam%labels%site(1, k), load => beam%load(:, beam%labels%surface(k)))
        e(k) = load(3)*(cos(angle)*BOW*(x*load(1))**2 + sin(angle)*TWIST*x*load(2))
      end associate
    end do
  end function error_of

  subroutine twisted_directions(self, q, from, nuisances, patterns, is_valid)
    class(twisted_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: nuisances(:, :), patterns(:, :)
    logical, intent(out) :: is_valid
    integer :: n
    n = self%n_nuisances
    call self%beam_t%directions(q, from, nuisances(:, :n - 1), patterns, is_valid)
    select type (from)
    type is (twisted_state_t)
      nuisances(:, n) = from%factor*error_of(self, from%angle)
    end select
  end subroutine twisted_directions

  subroutine twisted_initial_state(self, state)
    class(twisted_t), intent(in) :: self
    class(solver_state_t), allocatable, intent(out) :: state
    allocate (state, source=twisted_state_t(angle=self%angle))
  end subroutine twisted_initial_state

  subroutine turning_renew(self, whitener, q, state)
    class(turning_t), intent(inout) :: self
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(inout) :: state
    self%n_calls = self%n_calls + 1
    select type (state)
    type is (twisted_state_t)
      if (whitener%n > 0) state%angle = angle_of(q)
    end select
  end subroutine turning_renew

  !> The beam is exact: there is nothing to linearise.
  subroutine turning_linearise(self, q, sd, state, rows, unmade, failure)
    class(turning_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), sd(:)
    class(solver_state_t), intent(inout) :: state
    integer, allocatable, intent(out) :: rows(:)
    type(failure_t), intent(out) :: unmade
    type(failure_t), intent(inout) :: failure
    allocate (rows(0))
    associate (unused => self, point => q, error => sd, nothing => state, none => failure, no_reason => unmade)
    end associate
  end subroutine turning_linearise

  subroutine growing_renew(self, whitener, q, state)
    class(growing_t), intent(inout) :: self
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(inout) :: state
    self%n_calls = self%n_calls + 1
    select type (state)
    type is (twisted_state_t)
      if (whitener%n > 0 .and. size(q) > 0) state%factor = 100*state%factor
    end select
  end subroutine growing_renew

  !> The factor on the error in a state.
  real(rp) function factor_of(state)
    class(solver_state_t), intent(in) :: state
    factor_of = 0
    select type (state)
    type is (twisted_state_t)
      factor_of = state%factor
    end select
  end function factor_of
end module turning_error
