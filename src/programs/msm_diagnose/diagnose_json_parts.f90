! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes a part of NAME.json: the error of the mesh.
module diagnose_json_parts
  use diagnosis_discretisation, only: discretisation_error_t
  use io_json, only: json_t
  implicit none
  private
  public :: put_discretisation

contains

  !> Adds the member `mesh_band`, the error of the mesh, to the open object. `is_fitted_on` tells whether all fits use the finer
  !> mesh.
  subroutine put_discretisation(json, discretisation, is_fitted_on)
    type(json_t), intent(inout) :: json
    type(discretisation_error_t), intent(in) :: discretisation
    logical, intent(in) :: is_fitted_on
    call json%open_object('mesh_band')
    call json%put('is_found', discretisation%is_found)
    call json%put('points', discretisation%n_points)
    call json%put('is_fitted_on', is_fitted_on)
    call json%put('rms_m', discretisation%rms)
    call json%put('snr', discretisation%snr)
    call json%close()
  end subroutine put_discretisation
end module diagnose_json_parts
