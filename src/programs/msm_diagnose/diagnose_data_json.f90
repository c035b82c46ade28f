! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the data of a diagnosis to NAME.json, one entry for each kind of data that was measured, all of the same form.
module diagnose_data_json
  use diagnose_counts, only: counts_t, DATA_BENDING, DATA_FLIGHT, DATA_LANDMARKS, DATA_MODES, DATA_SERIES
  use diagnose_flight_json, only: put_flights
  use diagnose_modes, only: put_modes
  use diagnose_series, only: put_series
  use diagnose_settings, only: diagnose_settings_t
  use inference_engine, only: diagnosis_t
  use io_json, only: json_t
  implicit none
  private
  public :: put_data

contains

  !> Adds the list `data` to the open object: each kind with its counts, chi^2 before and after, what was left out, and its `sets`.
  subroutine put_data(json, s, counts, d)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(counts_t), intent(in) :: counts
    type(diagnosis_t), intent(in) :: d
    integer :: kind
    call json%open_list('data')
    do kind = 1, DATA_LANDMARKS
      if (counts%first(kind) == 0) cycle
      call json%open_object('')
      call counts%put_kind(json, kind)
      select case (kind)
      case (DATA_BENDING)
        call put_loads(json, s, counts)
      case (DATA_MODES)
        call put_modes(json, s, counts, d)
      case (DATA_SERIES)
        call put_series(json, s, counts, d)
      case (DATA_FLIGHT, DATA_LANDMARKS)
        call put_flights(json, s, counts, d, kind)
      end select
      call json%close()
    end do
    call json%close()
  end subroutine put_data

  !> Adds the list `sets` of bending tests, one for each load.
  subroutine put_loads(json, s, counts)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(counts_t), intent(in) :: counts
    integer :: l
    call json%open_list('sets')
    do l = 1, size(s%measurement%loads)
      call json%open_object('')
      call counts%put(json, s%measurement%loads(l)%name, l, 1)
      call json%close()
    end do
    call json%close()
  end subroutine put_loads
end module diagnose_data_json
