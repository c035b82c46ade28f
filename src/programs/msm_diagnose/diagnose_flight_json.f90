! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes records over the beat, of forces and of landmarks, to NAME.json: measured, simulated by the given case, and simulated with
!> the causes that were found. It also writes the case with these causes for flusi.
module diagnose_flight_json
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_text_file, only: write_text
  use diagnose_counts, only: counts_t
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_flight_changes, only: FLOW_FREQUENCY, N_CHANGES, N_FLOW
  use diagnosis_flight_data, only: flight_cases_t, flight_data_t
  use diagnosis_flight_refinements, only: refinement_names, N_REFINEMENTS, REFINE_GRID
  use diagnosis_flight_runner, only: flight_request_t
  use diagnosis_wing_flights, only: wing_flights_t
  use diagnosis_wing_state, only: wing_state_t
  use inference_engine, only: diagnosis_t
  use inference_refit, only: nested_fit_t
  use io_json, only: json_t
  use measurement_flight, only: component_unit, measured_flight_t, SIDE_NAMES
  implicit none
  private
  public :: put_flights, write_extended_flight

contains

  !> Adds the facts of the flight and the list `sets` of its records of this kind of data to the open object.
  subroutine put_flights(json, s, counts, d, kind)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(counts_t), intent(in) :: counts
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: kind !< DATA_FLIGHT or DATA_LANDMARKS
    type(wing_flights_t) :: flight
    real(rp), allocatable :: baseline(:), extended(:), refined(:, :), nothing(:, :)
    integer :: r, k, at, n, surface, c
    if (.not. s%flights%is_ready) return
    call flight%init(s%measurement%flights, s%catalogue%parameters, s%flights)
    allocate (baseline(flight%n), extended(flight%n), refined(flight%n, flight%n_nuisances), nothing(flight%n, 0))
    call flight%evaluate(d%model%baseline%q, [integer ::], baseline, nothing)
    call flight%nuisances(d%model%baseline%q, refined)
    extended = baseline
    call use_flight_of(d%extended, s%flights, flight)
    if (d%extended%is_found) call flight%evaluate(d%extended%q, [integer ::], extended, nothing)
    call put_facts(json, s, d)
    call json%open_list('sets')
    at = 0
    surface = size(counts%kind) - sum([(size(s%measurement%flights(r)%component), r=1, size(s%measurement%flights))])
    do r = 1, size(s%measurement%flights)
      c = s%flights%case_of(r)
      associate (f => s%measurement%flights(r), case => s%flights%cases(c))
        do k = 1, size(f%component)
          n = count(f%is_known(:, k))
          at = at + n
          surface = surface + 1
          if (counts%kind(surface) /= kind) cycle
          call json%open_object('')
          call counts%put(json, s%measurement%surface_name(surface), surface, 1)
          call json%put('record', f%name)
          call put_component(json, f, k)
          call json%put('unit', component_unit(f%component(k), f%is_per_length))
          call json%put('time', pack(f%time, f%is_known(:, k)))
          call json%put('measured', pack(f%mean(:, k), f%is_known(:, k)))
          call json%put('sd', pack(f%sd(:, k), f%is_known(:, k)))
          call put_residuals('simulated', baseline(at - n + 1:at))
          call put_residuals('extended', extended(at - n + 1:at))
          call put_differences(json, case%refined, case%facts%error_over_change, &
                               refined(at - n + 1:at, flight%nuisance(c) + 1:))
          if (size(s%flights%cases) > 1) call json%put('case', case%facts%path)
          call json%close()
        end do
      end associate
    end do
    call json%close()

  contains

    !> Writes the measured values plus residuals(:), which are in sd, at the times with known values.
    subroutine put_residuals(name, residuals)
      character(*), intent(in) :: name
      real(rp), intent(in) :: residuals(:)
      associate (f => s%measurement%flights(r))
        call json%put(name, pack(f%mean(:, k), f%is_known(:, k)) + residuals*pack(f%sd(:, k), f%is_known(:, k)))
      end associate
    end subroutine put_residuals

  end subroutine put_flights

  !> Adds which cases were flown, and how. The facts of the first one are in the open object itself.
  subroutine put_facts(json, s, d)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer :: k
    call put_case(s%flights%cases(1))
    call put_rounds(json, d)
    if (size(s%flights%cases) == 1) return
    call json%open_list('cases')
    do k = 1, size(s%flights%cases)
      call json%open_object('')
      call put_case(s%flights%cases(k))
      call json%close()
    end do
    call json%close()

  contains

    !> Adds the facts of one case.
    subroutine put_case(data)
      type(flight_data_t), intent(in) :: data
      call json%put('case', data%facts%path)
      call json%put('frequency_hz', data%facts%frequency)
      call json%put('is_section', data%facts%is_section)
      call json%put('is_refined', data%refined(REFINE_GRID))
      call json%put('refinements', refinement_names(data%refined))
    end subroutine put_case

  end subroutine put_facts

  !> Adds which component of the force, or which coordinate of which landmark, column k of a record is.
  subroutine put_component(json, f, k)
    type(json_t), intent(inout) :: json
    type(measured_flight_t), intent(in) :: f
    integer, intent(in) :: k
    character(*), parameter :: AXES = 'xyz'
    integer :: at(2)
    if (f%side == 0) then
      call json%put('component', f%component_name(k))
      return
    end if
    at = f%landmark_of(k)
    call json%put('component', AXES(at(2):at(2)))
    call json%put('wing', trim(SIDE_NAMES(f%side)))
    call json%put('landmark', at(1))
    call json%put('point', f%points(:, at(1)))
  end subroutine put_component

  !> Adds the root mean squares of what refinements change, in sd. The first columns of refined(:, :) are the errors of the case
  !> that these changes show.
  subroutine put_differences(json, is_refined, error_over_change, refined)
    type(json_t), intent(inout) :: json
    logical, intent(in) :: is_refined(N_REFINEMENTS)
    real(rp), intent(in) :: error_over_change(N_REFINEMENTS)
    real(rp), intent(in) :: refined(:, :)
    real(rp) :: rms(count(is_refined))
    rms = sqrt(sum(refined(:, :size(rms))**2, 1)/size(refined, 1))/pack(error_over_change, is_refined)
    call json%put('grid_difference_sd', sum(rms(:min(1, size(rms))), is_refined(REFINE_GRID)))
    call json%put('refinement_differences_sd', rms)
  end subroutine put_differences

  !> Takes the approximation of forces with which a fit was made.
  subroutine use_flight_of(fitted, data, flight)
    type(nested_fit_t), intent(in) :: fitted
    type(flight_cases_t), intent(in) :: data
    type(wing_flights_t), intent(inout) :: flight
    integer :: i, number
    if (.not. fitted%is_found .or. .not. allocated(data%cases(1)%again)) return
    do i = 1, size(data%cases(1)%again)
      call flight%add(data, i, number)
    end do
    select type (state => fitted%state)
    type is (wing_state_t)
      call flight%use(state%flight)
    end select
  end subroutine use_flight_of

  !> Adds by how much the fitted values changed in each round of flights, if there were any.
  subroutine put_rounds(json, d)
    type(json_t), intent(inout) :: json
    type(diagnosis_t), intent(in) :: d
    if (.not. allocated(d%rounds%moved)) return
    if (size(d%rounds%moved) == 0 .and. d%rounds%reason == '') return
    call json%put('moved_sd', d%rounds%moved)
    call json%put('has_settled', d%rounds%has_settled)
    call json%put('no_more_rounds', d%rounds%reason)
  end subroutine put_rounds

  !> Writes NAME_extended_flight.ini, and for the further cases NAME_extended_flight_2.ini and so on: the case with the
  !> kinematics, the flow and the wing that were found. Another beat frequency is only mentioned in a comment. Writes no file for a
  !> case whose kinematics, flow and wing are those that were found.
  subroutine write_extended_flight(s, d, failure)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(failure_t), intent(inout) :: failure
    type(flight_request_t) :: request
    character(:), allocatable :: head, name
    real(rp) :: c(N_CHANGES)
    integer :: k
    if (failure%failed .or. .not. s%flights%is_ready .or. .not. d%extended%is_found) return
    do k = 1, size(s%flights%cases)
      head = '; Run this file in the folder of the case.'//new_line('a')
      c = s%flights%cases(k)%changes_at(s%catalogue%parameters, d%extended%q)
      request%change = c(:N_FLOW)
      if (abs(c(FLOW_FREQUENCY)) > 0) head = head//'; The beat that was found is '//number_text(exp(c(FLOW_FREQUENCY)))// &
        ' times as fast as the beat of the case. This file has the beat of the case: change it in the case.'//new_line('a')
      if (.not. any(abs(request%change) > 0)) cycle
      name = s%name//'_extended_flight'
      if (k > 1) name = name//'_'//number_text(k)
      call write_text(name//'.ini', head//s%runner%cases(k)%text(request), failure)
    end do
  end subroutine write_extended_flight
end module diagnose_flight_json
