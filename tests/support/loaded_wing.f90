! SPDX-License-Identifier: GPL-3.0-or-later
!> The wing of benchmarks and tests and ten places on it where it is loaded.
module loaded_wing
  use base_errors, only: failure_t, message_list_t, require
  use base_kinds, only: rp
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use, intrinsic :: iso_fortran_env, only: error_unit
  use base_outcome, only: exit_code_of, OUTCOME_MISTAKE
  use base_process, only: exit_with
  implicit none
  private
  public :: wing_of_argument, place_on_wing, load_at

  integer, parameter, public :: N_LOADS = 10
  !> Places of the loads as fractions of the span and of the chord there.
  real(rp), parameter :: FRACTIONS(2, N_LOADS) = reshape([0.25_rp, 0.9_rp, 0.45_rp, 0.9_rp, 0.6_rp, 0.75_rp, &
                0.8_rp, 0.7_rp, 0.95_rp, 0.6_rp, 0.35_rp, 0.5_rp, 0.55_rp, 0.45_rp, 0.75_rp, 0.35_rp, 0.3_rp, 0.25_rp, &
                                                          0.55_rp, 0.15_rp], [2, N_LOADS])

  !> [N] Forces that move these places of the blowfly's wing by 0.01 to 0.08 R at 12.6 GPa.
  real(rp), parameter, public :: MODERATE_FORCES(N_LOADS) = 1.0e-4_rp* &
                                 [15.0_rp, 8.0_rp, 6.0_rp, 3.0_rp, 1.5_rp, 8.0_rp, 5.0_rp, 3.0_rp, 5.0_rp, 3.0_rp]

contains

  !> The wing in the file that the first argument of the program names.
  function wing_of_argument() result(wing)
    type(wing_t) :: wing
    type(message_list_t) :: messages
    character(1000) :: path
    call get_command_argument(1, path)
    call read_wing(trim(path), wing, messages)
    if (messages%count() == 0) return
    call messages%print(error_unit, '')
    call exit_with(exit_code_of(OUTCOME_MISTAKE))
  end function wing_of_argument

  !> Place (x, y) [m] number 1 to N_LOADS.
  function place_on_wing(model, number) result(place)
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: number
    real(rp) :: place(2), low, high
    integer :: i
    place(1) = minval(model%points(1, :model%n_points)) + FRACTIONS(1, number)* &
               (maxval(model%points(1, :model%n_points)) - minval(model%points(1, :model%n_points)))
    low = huge(low)
    high = -huge(high)
    do i = 1, model%n_points
      if (abs(model%points(1, i) - place(1)) > 0.03_rp*model%size) cycle
      low = min(low, model%points(2, i))
      high = max(high, model%points(2, i))
    end do
    place(2) = low + FRACTIONS(2, number)*(high - low)
  end function place_on_wing

  !> The force [N] along z at place number `number`.
  subroutine load_at(model, number, force, load)
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: number
    real(rp), intent(in) :: force
    type(load_t), intent(out) :: load
    type(failure_t) :: failure
    call load%init(model)
    call load%add_at(model, place_on_wing(model, number), [0.0_rp, 0.0_rp, force], failure)
    call require(.not. failure%failed, 'a load of the benchmark lies beside the wing')
  end subroutine load_at
end module loaded_wing
