! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes parts of NAME.json: the error of the mesh, and what to measure next.
module diagnose_json_parts
  use diagnosis_discretisation, only: discretisation_error_t
  use diagnosis_next_measurement, only: next_measurement_t
  use io_json, only: json_t
  use measurement_data, only: measurement_t
  implicit none
  private
  public :: put_discretisation, put_next

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

  !> Adds the loads of the measurement that should be repeated and the loads at new sites to the open object.
  subroutine put_next(json, measurement, next)
    type(json_t), intent(inout) :: json
    type(measurement_t), intent(in) :: measurement
    type(next_measurement_t), intent(in) :: next
    integer :: i
    call json%open_list('next_measurements')
    do i = 1, size(next%order)
      call json%open_object('')
      call json%put('repeat', measurement%surface_name(next%order(i)))
      call json%put('separation_sd', next%after(next%order(i)))
      call json%put('separation_now_sd', next%now(1))
      call json%close()
    end do
    call json%close()
    call json%open_list('new_loads')
    do i = 1, size(next%sites)
      call json%open_object('')
      call json%put('place_m', next%sites(i)%site)
      call json%put('force_n', next%sites(i)%force)
      call json%put('direction', next%sites(i)%direction)
      call json%put('separation_sd', next%sites(i)%after)
      call json%put('separation_now_sd', next%now(1))
      call json%close()
    end do
    call json%close()
  end subroutine put_next
end module diagnose_json_parts
