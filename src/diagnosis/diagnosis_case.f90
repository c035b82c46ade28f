! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds one diagnosis as its algorithms see it: the wing, the experiment, the catalogue of effects, and the choices of the
!> statistics. SI units.
module diagnosis_case
  use base_kinds, only: rp
  use diagnosis_mode_row, only: mode_row_t
  use diagnosis_series_row, only: series_row_t
  use diagnosis_flight_data, only: flight_cases_t
  use diagnosis_flight_means, only: flight_comparison_t
  use diagnosis_noise, only: noise_estimate_t
  use diagnosis_wing_bins, only: bins_t
  use diagnosis_wing_catalogue, only: catalogue_t
  use inference_engine, only: diagnosis_options_t
  use measurement_bending_case, only: bending_case_t
  use measurement_observed_wing, only: wing_patterns_t
  use measurement_proposal_choices, only: proposal_choices_t
  use solid_mass_effects, only: mass_parts_t
  use solid_params, only: solid_params_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: diagnosis_case_t

  !> The free parameters are those of the baseline. The experiment itself has no unknowns.
  type, extends(bending_case_t) :: diagnosis_case_t
    real(rp) :: membrane_sd = 0             !< of log D
    type(catalogue_t) :: catalogue
    type(wing_patterns_t) :: patterns
    type(bins_t) :: bins
    type(noise_estimate_t) :: noise
    type(mass_parts_t) :: parts             !< of the mass of the wing, if it has one
    logical :: states_mass = .false.        !< the mass of the membrane is stated, not assumed
    type(diagnosis_options_t) :: options
    type(proposal_choices_t) :: proposals   !< measurements of motion that may come next
    type(flight_cases_t) :: flights         !< of records of forces over the beat
    type(mode_row_t), allocatable :: modes(:) !< for reports, if natural modes were measured
    type(series_row_t), allocatable :: series(:) !< for reports, if records of motion were measured
    type(flight_comparison_t) :: comparison !< of the flights of both wings, for reports
    logical :: chooses_mesh = .false.       !< the error of the mesh decides whether all fits use the finer mesh
    logical :: fits_finer = .false.         !< all fits use a mesh of half the size of that in the file
    type(wing_t) :: file_wing               !< the wing of the file and the input, where `wing_case` has that with the finer mesh
    type(solid_params_t) :: file_requested
  contains
    procedure :: only_flies => case_only_flies
  end type diagnosis_case_t

contains

  !> Tells whether the measurement holds nothing but records of forces over the beat, so that the mechanics of the wing do not
  !> matter.
  pure logical function case_only_flies(self) result(only_flies)
    class(diagnosis_case_t), intent(in) :: self
    only_flies = size(self%measurement%loads) == 0 .and. .not. self%measurement%moves() .and. self%measurement%count_flights() > 0
  end function case_only_flies
end module diagnosis_case
