! SPDX-License-Identifier: GPL-3.0-or-later
!> Begins the fit of the baseline with a part of the observations, and lets the others join in stages.
!>
!> The phase of a vibration grows with time: over a long record an error of the frequency turns it by many periods, and the sum of
!> squares has a minimum for almost each of them. The beginning of the record has one minimum. It determines the frequency well
!> enough for the phase of a record twice as long, and so on.
module inference_growing_fit
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use inference_refit, only: fit_nested, loose_options, nested_fit_t, update_directions
  use inference_simulator, only: simulator_t
  use inference_whitener, only: whitener_t
  use least_squares_fit, only: fit_options_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: grow_fit

contains

  !> Moves q(parameters) to a fit of the baseline to the observations of all stages but the last, stage by stage, each roughly and
  !> from the fit before. `from` is a state of the simulator. A stage that has no fit leaves q as it is, and so does a simulator
  !> whose observations have one stage.
  subroutine grow_fit(simulator, from, independent_fraction, options, q)
    class(simulator_t), intent(inout), target :: simulator
    class(solver_state_t), intent(in) :: from
    real(rp), intent(in) :: independent_fraction !< of the errors, see `covariance` of simulator_t
    type(fit_options_t), intent(in) :: options
    real(rp), intent(inout) :: q(:)
    type(whitener_t), target :: whitener
    type(nested_fit_t) :: found
    type(failure_t) :: failure
    class(solver_state_t), allocatable :: state
    integer :: i, stage, active(simulator%n_baseline)
    logical :: is_valid
    if (.not. allocated(simulator%labels%stage)) return
    active = [(i, i=1, size(active))]
    do stage = 0, maxval(simulator%labels%stage) - 1
      call whitener%init(simulator, pack([(i, i=1, simulator%n_observations)], simulator%labels%stage <= stage), &
                         independent_fraction, failure)
      if (failure%failed) return
      if (allocated(state)) deallocate (state)
      allocate (state, source=from)
      call state%begin_at_rest()
      call update_directions(simulator, q, state, whitener, is_valid)
      if (.not. is_valid) return
      call fit_nested(simulator, whitener, active, q, state, loose_options(options), found)
      if (found%is_found) q = found%q
    end do
  end subroutine grow_fit
end module inference_growing_fit
