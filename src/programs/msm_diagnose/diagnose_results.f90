! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists the result files of a diagnosis: all that guards inputs from them, moves earlier ones away and names them uses this list.
module diagnose_results
  use base_files, only: file_exists
  use diagnosis_flight_data, only: MOST_CASES
  implicit none
  private
  public :: print_results, RESULTS, PLAN_RESULT

  !> What is added to [Saving] name. The first one has the verdict, and is written last.
  character(24), parameter :: RESULTS(5 + MOST_CASES) = [character(24) :: &
    '.json', '.h5', '_baseline.ini', '_extended.ini', '_extended_flight.ini', '_extended_flight_2.ini', '_extended_flight_3.ini', &
    '_extended_flight_4.ini', '_extended_flight_5.ini', '_extended_flight_6.ini', '_extended_flight_7.ini', &
    '_extended_flight_8.ini', '_extended_flight_9.ini', '_next_measurements.csv']
  character(*), parameter :: PLAN_RESULT = '_plan.json' !< the result of a plan

contains

  !> Prints on `unit` which results with this `name` there are, and what makes a report of them.
  subroutine print_results(unit, name)
    integer, intent(in) :: unit
    character(*), intent(in) :: name
    character(:), allocatable :: list
    integer :: i
    list = ''
    do i = 1, size(RESULTS)
      if (file_exists(name//trim(RESULTS(i)))) list = list//', '//trim(RESULTS(i))
    end do
    write (unit, '(a)') 'files     '//name//list(3:)//'; tools/plot_diagnosis '//name//trim(RESULTS(1))//' makes the report'
    flush (unit)
  end subroutine print_results
end module diagnose_results
