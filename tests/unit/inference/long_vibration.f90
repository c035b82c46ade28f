! SPDX-License-Identifier: GPL-3.0-or-later
!> Many periods of a decaying vibration exp(-d t) cos(w t) in units of the sd, which is a hundredth of its size. Errors are
!> independent, and there are none in the data.
module long_vibration
  use base_kinds, only: rp
  use bump_places, only: bumps_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: vibration_t, make_vibration

  real(rp), parameter :: PI = acos(-1.0_rp), SIGMA = 0.01_rp
  integer, parameter, public :: IN_PERIOD = 10 !< observations

  !> Parameters: the logarithms of frequency and decay, over those of the start.
  type, extends(bumps_t) :: vibration_t
  contains
    procedure :: evaluate => vibration_evaluate
  end type vibration_t

contains

  !> Makes the observations of `periods` periods of the frequency at null, with the parameters at `truth`.
  subroutine make_vibration(periods, truth, vibration)
    integer, intent(in) :: periods
    real(rp), intent(in) :: truth(2)
    type(vibration_t), intent(out) :: vibration
    real(rp), allocatable :: slopes(:, :)
    integer :: i, n
    n = periods*IN_PERIOD
    vibration%n_observations = n
    vibration%n_baseline = 2
    allocate (vibration%labels%surface(n), vibration%labels%block(n), vibration%labels%fold(1), source=1)
    allocate (vibration%data(n), slopes(n, 2), vibration%parameters(2))
    do i = 1, 2
      vibration%parameters(i)%name = 'p'
      vibration%parameters(i)%prior_sd = 1
    end do
    vibration%parameters(2)%upper = 0.3_rp ! with any decay a fit would leave the first periods alone, and find its way
    call find_values(truth, vibration%data, slopes)
  end subroutine make_vibration

  !> Returns the values and their derivatives.
  pure subroutine find_values(q, values, slopes)
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: values(:), slopes(:, :)
    real(rp) :: time, turn, decay
    integer :: i
    do i = 1, size(values)
      time = real(i, rp)/IN_PERIOD
      turn = 2*PI*exp(q(1))*time
      decay = 1/SIGMA*exp(-0.002_rp*exp(q(2))*time)
      values(i) = decay*cos(turn)
      slopes(i, 1) = -turn*decay*sin(turn)
      slopes(i, 2) = -0.002_rp*exp(q(2))*time*values(i)
    end do
  end subroutine find_values

  !> See `simulator_t`.
  subroutine vibration_evaluate(self, q, columns, from, residuals, jacobian, is_valid, to, is_wanted)
    class(vibration_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out), optional :: to
    logical, intent(in), optional :: is_wanted(:)
    real(rp) :: slopes(size(residuals), 2)
    is_valid = .true.
    if (present(to)) allocate (to, source=from)
    call find_values(q, residuals, slopes)
    residuals = residuals - self%data
    jacobian = slopes(:, columns)
    associate (unused => is_wanted)
    end associate
  end subroutine vibration_evaluate
end module long_vibration
