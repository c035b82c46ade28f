! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads what trainings and diagnoses have in common: the ini file, the wing, the measurement, the instrument, and the free
!> parameters.
module common_bending_case
  use base_errors, only: message_list_t
  use common_free_parameters, only: read_free_parameters
  use common_instrument, only: read_instrument
  use common_measurement_keys, only: choose_heights, measurement_choices_t
  use common_wing_keys, only: wing_choices_t
  use common_wing_settings, only: find_beside, load_wing
  use io_config, only: config_t
  use io_registry, only: registry_t
  use io_broadcast_text, only: read_broadcast_text
  use measurement_bending_case, only: bending_case_t
  use measurement_broadcast, only: load_measurement
  use parallel_world, only: world_t
  implicit none
  private
  public :: load_input, load_bending_case, bending_input_t

  !> Holds what differs between the programs.
  type :: bending_input_t
    type(wing_choices_t) :: wing               !< what [Wing] says, with the file of one wing
    type(measurement_choices_t) :: measurement !< what [Measurement] says, with one file
    character(:), allocatable :: section, parameters !< names of the free parameters, and the section that lists them
    logical :: scale_is_log = .true.        !< scale of bounds for which the input gives none
    logical :: may_plan = .false.           !< the measurement may have no heights
    logical :: keeps_outliers = .false.     !< the preset of [Measurement] outliers keeps them
  end type bending_input_t

contains

  !> Reads the ini file `path` on all ranks. `can_go_on` is false if there is no such file, or if a section asks for something that
  !> the program does not have. Adds mistakes to `errors` and remarks to `notices`. Collective.
  subroutine load_input(path, registry, world, config, errors, notices, can_go_on)
    character(*), intent(in) :: path
    type(registry_t), intent(in) :: registry
    type(world_t), intent(in) :: world
    type(config_t), intent(inout) :: config
    type(message_list_t), intent(inout) :: errors, notices
    logical, intent(out) :: can_go_on
    character(:), allocatable :: text, problem
    can_go_on = .false.
    call read_broadcast_text(path, text, problem, world)
    if (allocated(problem)) then
      call errors%add(problem)
      return
    end if
    call config%load_text(text, path, registry, errors, notices, .false., world)
    can_go_on = .not. config%asks_for_unbuilt()
  end subroutine load_input

  !> Reads the wing, the measurement, the instrument and the free parameters on all ranks. Adds all mistakes to `errors` and all
  !> remarks to `notices`. If there is no valid wing, it reads nothing else. Collective.
  subroutine load_bending_case(input, config, world, case, errors, notices)
    type(bending_input_t), intent(in) :: input
    type(config_t), intent(in) :: config
    type(world_t), intent(in) :: world
    class(bending_case_t), intent(inout) :: case
    type(message_list_t), intent(inout) :: errors, notices
    logical :: found
    call load_wing(config, .false., case%wing_case, found, errors, notices, world, input%wing)
    if (.not. found) return
    call read_measurement(input, config, world, case, errors, notices)
    if (allocated(case%measurement%loads)) call case%instrument%set_scales(case%measurement, case%wing_case%model%size)
    call read_instrument(config, case%instrument, errors)
    call read_free_parameters(config, input%section, input%parameters, case%wing_case%requested, case%instrument, &
                              input%scale_is_log, case%free_parameters, errors)
  end subroutine load_bending_case

  !> Reads the measurement that [Measurement] names, if it names one, and leaves out its outlying heights unless they are kept.
  subroutine read_measurement(input, config, world, case, errors, notices)
    type(bending_input_t), intent(in) :: input
    type(config_t), intent(in) :: config
    type(world_t), intent(in) :: world
    class(bending_case_t), intent(inout) :: case
    type(message_list_t), intent(inout) :: errors, notices
    character(:), allocatable :: problem
    if (.not. input%measurement%has_file) return
    call find_beside(config%file_name(), input%measurement%file, case%measurement_path, problem, world)
    if (allocated(problem)) then
      call config%complain(errors, 'Measurement', 'file', problem)
      return
    end if
    call load_measurement(world, case%measurement_path, case%wing_case%wing, case%measurement, errors, input%may_plan)
    if (errors%count() > 0) return
    if (case%measurement%is_plan .and. size(case%measurement%x) > 0) &
      call notices%add(case%measurement_path//': this plan of an experiment has no heights; only --plan can use it')
    call choose_heights(input%measurement%outliers, input%keeps_outliers, case%measurement_path, case%measurement, &
                        case%outliers, notices)
  end subroutine read_measurement
end module common_bending_case
