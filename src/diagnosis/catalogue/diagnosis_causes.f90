! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists all causes that a diagnosis knows, from the modules that own them: the structure of the wing, its masses, its damping, the
!> measurement, the kinematics and flow of a flight, and the force balance.
module diagnosis_causes
  use base_cause, only: append, cause_parameter_t, cause_t, find_wording
  use base_kinds, only: rp
  use base_wording, only: wording_t
  use diagnosis_flight_changes, only: change_scales_t, list_change_causes
  use measurement_balance_causes, only: balance_scales_t, list_balance_causes
  use measurement_instrument_causes, only: instrument_scales_t, list_instrument_causes
  use measurement_series_causes, only: list_series_causes
  use solid_damping_effects, only: list_damping_causes
  use solid_mass_effects, only: list_mass_causes
  use solid_structure_causes, only: list_structure_causes
  use solid_usual_causes, only: usual_parameter, N_USUAL
  implicit none
  private
  public :: list_causes, find_words

contains

  !> Returns all causes, with scales of 1: bounds and priors that depend on an experiment are multiples of what it gives.
  pure function list_causes() result(list)
    type(cause_t), allocatable :: list(:)
    type(instrument_scales_t) :: of_instrument
    type(change_scales_t) :: of_changes
    type(balance_scales_t) :: of_balance
    type(cause_t), allocatable :: more(:)
    list = list_structure_causes()
    more = list_mass_causes(1.0_rp)
    call append(list, more)
    more = list_damping_causes(1.0_rp, 1.0_rp, 1.0_rp)
    call append(list, more)
    more = list_series_causes(1.0_rp, 1.0_rp)
    call append(list, more)
    more = list_instrument_causes(of_instrument)
    call append(list, more)
    more = list_change_causes(of_changes)
    call append(list, more)
    more = list_balance_causes(of_balance)
    call append(list, more)
  end function list_causes

  !> Returns the words for parameter `name` at `site` with a value of about `best`. It is a usual parameter of the wing, which a
  !> baseline may fit, or a parameter of a cause. `words%is_known` is false if no parameter has this name.
  pure subroutine find_words(name, site, best, words)
    character(*), intent(in) :: name, site
    real(rp), intent(in) :: best
    type(wording_t), intent(out) :: words
    type(cause_parameter_t) :: usual(N_USUAL)
    type(cause_t), allocatable :: list(:)
    integer :: i
    do i = 1, N_USUAL
      usual(i) = usual_parameter(i)
    end do
    call find_wording(usual, name, site, best, words)
    if (words%is_known) return
    list = list_causes()
    do i = 1, size(list)
      call find_wording(list(i)%parameters, name, site, best, words)
      if (words%is_known) return
    end do
  end subroutine find_words
end module diagnosis_causes
