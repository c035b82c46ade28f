! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds what trainings and diagnoses have in common: a wing, its bending tests, and the free parameters. SI units.
module measurement_bending_case
  use base_kinds, only: rp
  use measurement_data, only: measurement_t
  use measurement_experiment, only: experiment_t
  use measurement_free_parameters, only: free_parameters_t
  use measurement_instrument, only: instrument_t
  use measurement_outliers, only: outliers_t
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: bending_case_t

  type :: bending_case_t
    type(wing_case_t) :: wing_case
    character(:), allocatable :: measurement_path !< not allocated if [Measurement] names no file
    type(measurement_t) :: measurement
    type(outliers_t) :: outliers            !< heights that were left out
    type(instrument_t) :: instrument        !< the assumed instrument
    type(free_parameters_t) :: free_parameters
    real(rp) :: prior_decades = 1           !< sd of the prior about the values of [Wing]
    type(experiment_t) :: experiment
  contains
    procedure :: masses => case_masses
  end type bending_case_t

contains

  !> Returns the masses of all points [kg]; of size 0 if the wing has no valid mass.
  pure function case_masses(self) result(masses)
    class(bending_case_t), intent(in) :: self
    real(rp), allocatable :: masses(:)
    allocate (masses(0))
    if (self%wing_case%has_mass) masses = self%wing_case%mass%nodal
  end function case_masses
end module measurement_bending_case
