! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes parts of NAME.json: the error of the mesh, and what to measure next.
module diagnose_json_parts
  use diagnose_counts, only: counts_t, DATA_BENDING, DATA_NAMES
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

  !> Adds `next` to the open object: what to measure next in words, and all measurements of any kind, repeated or new, the one that
  !> separates the causes best first.
  subroutine put_next(json, measurement, counts, next, sentence)
    type(json_t), intent(inout) :: json
    type(measurement_t), intent(in) :: measurement
    type(counts_t), intent(in) :: counts
    type(next_measurement_t), intent(in) :: next
    character(*), intent(in) :: sentence
    integer :: i, k
    logical :: is_new
    call json%open_object('next')
    call json%put('sentence', sentence)
    call json%open_list('measurements')
    i = 1 ! of those that are repeated
    k = 1 ! of those at new sites
    do while (i <= size(next%order) .or. k <= size(next%sites))
      is_new = i > size(next%order)
      if (.not. is_new .and. k <= size(next%sites)) is_new = next%sites(k)%after > next%after(next%order(i))
      call json%open_object('')
      if (is_new) then
        call json%put('kind', trim(DATA_NAMES(DATA_BENDING)))
        call json%put('place_m', next%sites(k)%site)
        call json%put('force_n', next%sites(k)%force)
        call json%put('direction', next%sites(k)%direction)
        call json%put('separation_sd', next%sites(k)%after)
        k = k + 1
      else
        call json%put('kind', trim(DATA_NAMES(counts%kind(next%order(i)))))
        call json%put('repeat', measurement%surface_name(next%order(i)))
        call json%put('separation_sd', next%after(next%order(i)))
        i = i + 1
      end if
      call json%put('separation_now_sd', next%now(1))
      call json%close()
    end do
    call json%close()
    call json%close()
  end subroutine put_next
end module diagnose_json_parts
