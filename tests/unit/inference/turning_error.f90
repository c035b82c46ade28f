! SPDX-License-Identifier: GPL-3.0-or-later
!> A beam with an error whose direction depends on the wing: for tests of the second look of a diagnosis.
module turning_error
  use base_kinds, only: rp
  use diagnosis_beam, only: beam_t, P_ONE_WAY
  use inference_relinearisation, only: model_error_t
  use inference_whitener, only: whitener_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: twisted_t, turning_t, growing_t, angle_of, error_of

  real(rp), parameter, public :: TRUTH = 1.5_rp
  real(rp), parameter :: BOW = 0.01_rp, TWIST = 0.02_rp

  type, extends(solver_state_t) :: twisted_state_t
    real(rp) :: factor = 1
  end type twisted_state_t

  !> A beam with the error: angle 0 is the bow, a right angle the twist.
  type, extends(beam_t) :: twisted_t
    real(rp) :: angle = 0, factor = 1
  contains
    procedure :: directions => twisted_directions
    procedure :: get_state => twisted_get_state
    procedure :: set_state => twisted_set_state
  end type twisted_t

  type, extends(model_error_t) :: turning_t
    type(twisted_t), pointer :: beam => null()
    integer :: n_calls = 0
  contains
    procedure :: renew => turning_renew
  end type turning_t

  !> An error that may be a hundred times as large as before whenever it is looked at.
  type, extends(turning_t) :: growing_t
  contains
    procedure :: renew => growing_renew
  end type growing_t

contains

  pure real(rp) function angle_of(q)
    real(rp), intent(in) :: q(:)
    angle_of = 0.5_rp*acos(-1.0_rp)*q(P_ONE_WAY)/TRUTH
  end function angle_of

  pure function error_of(beam) result(e)
    class(twisted_t), intent(in) :: beam
    real(rp) :: e(beam%n_observations)
    integer :: k
    do k = 1, size(e)
      associate (x => beam%labels%site(1, k), load => beam%load(:, beam%labels%surface(k)))
        e(k) = beam%factor*load(3)*(cos(beam%angle)*BOW*(x*load(1))**2 + sin(beam%angle)*TWIST*x*load(2))
      end associate
    end do
  end function error_of

  subroutine twisted_directions(self, q, nuisances, patterns, is_valid)
    class(twisted_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: nuisances(:, :), patterns(:, :)
    logical, intent(out) :: is_valid
    integer :: n
    n = self%n_nuisances
    call self%beam_t%directions(q, nuisances(:, :n - 1), patterns, is_valid)
    nuisances(:, n) = error_of(self)
  end subroutine twisted_directions

  subroutine twisted_get_state(self, state)
    class(twisted_t), intent(in) :: self
    class(solver_state_t), allocatable, intent(out) :: state
    allocate (state, source=twisted_state_t(factor=self%factor))
  end subroutine twisted_get_state

  subroutine twisted_set_state(self, state, only_shapes)
    class(twisted_t), intent(inout) :: self
    class(solver_state_t), intent(in) :: state
    logical, intent(in), optional :: only_shapes
    if (present(only_shapes)) return
    select type (state)
    type is (twisted_state_t)
      self%factor = state%factor
    end select
  end subroutine twisted_set_state

  subroutine turning_renew(self, whitener, q)
    class(turning_t), intent(inout) :: self
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: q(:)
    self%n_calls = self%n_calls + 1
    if (whitener%n > 0) self%beam%angle = angle_of(q)
  end subroutine turning_renew

  subroutine growing_renew(self, whitener, q)
    class(growing_t), intent(inout) :: self
    type(whitener_t), intent(in), target :: whitener
    real(rp), intent(in) :: q(:)
    self%n_calls = self%n_calls + 1
    if (whitener%n > 0 .and. size(q) > 0) self%beam%factor = 100*self%beam%factor
  end subroutine growing_renew
end module turning_error
