! SPDX-License-Identifier: GPL-3.0-or-later
!> Records of forces over the beat in NAME.json: measured, simulated by the case as it is, and with what was found.
module diagnose_flight_json
  use base_kinds, only: rp
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_wing_flight, only: wing_flight_t
  use inference_engine, only: diagnosis_t
  use io_json, only: json_t
  use measurement_flight, only: component_unit, COMPONENT_NAMES
  implicit none
  private
  public :: put_flights

contains

  !> The member `flight`; nothing without records.
  subroutine put_flights(json, s, d)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(wing_flight_t) :: flight
    real(rp), allocatable :: baseline(:), extended(:), of_grid(:, :), nothing(:, :)
    integer :: r, k, at, n
    if (.not. s%flights%is_ready) return
    call flight%init(s%measurement%flights, s%catalogue%parameters, s%flights)
    allocate (baseline(flight%n), extended(flight%n), of_grid(flight%n, 1), nothing(flight%n, 0))
    call flight%evaluate(d%baseline%q, [integer ::], baseline, nothing)
    extended = baseline
    if (d%extended%is_found) call flight%evaluate(d%extended%q, [integer ::], extended, nothing)
    of_grid = 0
    if (flight%n_nuisances > 0) call flight%nuisances(d%baseline%q, of_grid)
    call json%open_object('flight')
    call json%put('case', s%flights%facts%path)
    call json%put('frequency_hz', s%flights%facts%frequency)
    call json%put('is_section', s%flights%facts%is_section)
    call json%put('is_refined', s%flights%is_refined)
    call json%open_list('records')
    at = 0
    do r = 1, size(s%measurement%flights)
      associate (f => s%measurement%flights(r))
        do k = 1, size(f%component)
          n = count(f%is_known(:, k))
          call json%open_object('')
          call json%put('record', f%name)
          call json%put('component', trim(COMPONENT_NAMES(f%component(k))))
          call json%put('unit', component_unit(f%component(k), f%is_per_length))
          call json%put('time', pack(f%time, f%is_known(:, k)))
          call json%put('measured', pack(f%mean(:, k), f%is_known(:, k)))
          call json%put('sd', pack(f%sd(:, k), f%is_known(:, k)))
          call put_residuals('simulated', baseline(at + 1:at + n))
          call put_residuals('extended', extended(at + 1:at + n))
          call json%put('grid_difference_sd', sqrt(sum(of_grid(at + 1:at + n, 1)**2)/n))
          call json%close()
          at = at + n
        end do
      end associate
    end do
    call json%close()
    call json%close()

  contains

    !> The measured values plus residuals(:) in sd, at the times that are known.
    subroutine put_residuals(name, residuals)
      character(*), intent(in) :: name
      real(rp), intent(in) :: residuals(:)
      associate (f => s%measurement%flights(r))
        call json%put(name, pack(f%mean(:, k), f%is_known(:, k)) + residuals*pack(f%sd(:, k), f%is_known(:, k)))
      end associate
    end subroutine put_residuals

  end subroutine put_flights
end module diagnose_flight_json
