! SPDX-License-Identifier: GPL-3.0-or-later
!> Beams whose fits do not end where they began: for tests of the refits of a diagnosis.
module stubborn_beams
  use base_kinds, only: rp
  use diagnosis_beam, only: beam_t, P_TORSION
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: curled_t, fickle_t

  !> A beam with an error that has another direction on each side of a stiffness. Either makes the best fit be on the other
  !> side.
  type, extends(beam_t) :: fickle_t
    real(rp) :: edge = 0       !< of q(1)
    real(rp) :: size = 0       !< [sd of the noise] of the error at the tip
  contains
    procedure :: directions => fickle_directions
    procedure :: error => fickle_error
  end type fickle_t

  !> A beam that twists with the third power of a parameter, and against it near its null.
  type, extends(beam_t) :: curled_t
  contains
    procedure :: shape => curled_shape
  end type curled_t

contains

  !> What one sd of the error does where q(1) is above or below the edge.
  pure function fickle_error(self, is_above) result(e)
    class(fickle_t), intent(in) :: self
    logical, intent(in) :: is_above
    real(rp) :: e(self%n_observations)
    integer :: k
    do k = 1, size(e)
      associate (x => self%labels%site(1, k), y => self%labels%site(2, k), &
                 load => self%load(:, self%labels%surface(k)))
        e(k) = self%size*self%sigma*merge(x**2*load(1)**2, x*y, is_above)*load(3)
      end associate
    end do
  end function fickle_error

  subroutine fickle_directions(self, q, from, nuisances, patterns, is_valid)
    class(fickle_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: nuisances(:, :), patterns(:, :)
    logical, intent(out) :: is_valid
    integer :: n
    n = self%n_nuisances
    call self%beam_t%directions(q, from, nuisances(:, :n - 1), patterns, is_valid)
    nuisances(:, n) = self%error(q(1) > self%edge)
  end subroutine fickle_directions

  pure subroutine curled_shape(self, q, w)
    class(curled_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: w(:)
    real(rp) :: curled(size(q))
    curled = q
    curled(P_TORSION) = q(P_TORSION)**3 - 0.3_rp*q(P_TORSION)
    call self%beam_t%shape(curled, w)
  end subroutine curled_shape
end module stubborn_beams
