! SPDX-License-Identifier: GPL-3.0-or-later
!> Distinguishes the inputs of flusi, flusi --static, flusi --solid, msm_train and msm_diagnose from each other.
module common_foreign_inputs
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_foreign_inputs

  integer, parameter, public :: INPUT_OF_FLOW = 1, INPUT_OF_SOLID = 2, INPUT_OF_TRAIN = 3, INPUT_OF_DIAGNOSE = 4, &
                                INPUT_OF_STATIC = 5
  character(14), parameter :: PROGRAMS(5) = [character(14) :: 'flusi', 'flusi --solid', 'msm_train', 'msm_diagnose', &
                                                                                                    'flusi --static']
  !> These sections occur only in the inputs of one program each.
  character(65), parameter :: SECTIONS(5) = [character(65) :: 'Resolution|Geometry|ReynoldsNumber|InitialCondition|Penalization', &
                                        'Motion|Initial', 'Train|CMAES|Polish', 'Diagnose', 'Modes']
  character(*), parameter :: PARALLEL(5) = [character(12) :: 'mpirun -n 2', '', 'mpirun -n 2', 'mpirun -n 2', '']

contains

  !> Makes `registry` recognise the inputs of other programs, so that it can tell the user which program to run. `own`, one of
  !> the numbers above, is the program whose inputs the registry describes.
  subroutine register_foreign_inputs(registry, own)
    type(registry_t), intent(inout) :: registry
    integer, intent(in) :: own
    character(:), allocatable :: name
    integer :: i
    name = trim(PROGRAMS(own))
    call registry%foreign%set_own(trim(SECTIONS(own)))
    do i = 1, size(PROGRAMS)
      if (i /= own) call registry%foreign%add(trim(SECTIONS(i)), whose(i))
    end do
    if (own == INPUT_OF_FLOW .or. own == INPUT_OF_SOLID) call registry%foreign%add('Measurement', &
      'this is an input of msm_train or msm_diagnose, and not of '//name//'; run: mpirun -n 2 msm_train *')
    if (all(own /= [INPUT_OF_STATIC, INPUT_OF_SOLID])) call registry%foreign%add('Loads', whose(INPUT_OF_STATIC))
    call registry%foreign%add('kinematics', 'this is a motion of wings and not an input; name it in the input of a flight: '// &
                              '[Insects] FlappingMotion_left = from_file::*')
    if (own /= INPUT_OF_STATIC) call registry%foreign%set_fragment('Wing|Mass|Instrument', &
      'this describes a wing and is not a complete input; name it in an input of '//name//': [include] file = *')

  contains

    function whose(k) result(text)
      integer, intent(in) :: k
      character(:), allocatable :: text
      text = 'this is an input of '//trim(PROGRAMS(k))//', and not of '//name//'; run: '// &
             trim(adjustl(trim(PARALLEL(k))//' '//PROGRAMS(k)))//' *'
    end function whose
  end subroutine register_foreign_inputs
end module common_foreign_inputs
