! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads [Measurement]: the measurement file, and whether outliers among the heights are used.
module common_measurement_keys
  use base_errors, only: message_list_t
  use base_named_kinds, only: named_kind_t
  use base_text, only: number_text
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  use measurement_data, only: measurement_t
  use measurement_outliers, only: leave_out_outliers, outliers_t
  implicit none
  private
  public :: measurement_choices_t, register_measurement_keys, read_measurement_keys, choose_heights, OUTLIERS

  !> What happens to outliers among the heights. Only a training has a preset.
  integer, parameter, public :: OUTLIERS_PRESET = 1, OUTLIERS_LEAVE_OUT = 2, OUTLIERS_KEEP = 3
  type(named_kind_t), parameter :: OUTLIERS(3) = [named_kind_t('preset', OUTLIERS_PRESET), &
                                                  named_kind_t('leave_out', OUTLIERS_LEAVE_OUT), &
                                                  named_kind_t('keep', OUTLIERS_KEEP)]

  !> Holds what the section says.
  type :: measurement_choices_t
    character(:), allocatable :: file
    logical :: has_file = .false.
    integer :: outliers = OUTLIERS_LEAVE_OUT
  end type measurement_choices_t

contains

  !> Declares and reads the section for a training, which may have several individuals and a preset, or for another program.
  subroutine measurement_keys(keys, is_training, c)
    type(keys_t), intent(inout) :: keys
    logical, intent(in) :: is_training
    type(measurement_choices_t), intent(inout) :: c
    character(*), parameter :: LISTS = '. Several individuals: a list separated by commas; [Wing] file may then be a list of '// &
                               'the same length'
    integer :: first !< the first word is the default
    first = merge(1, 2, is_training)
    call keys%section('Measurement', 'the measured shapes and motions of the wing')
    call keys%text('file', c%file, '', 'measurement file (docs/formats/measurement-format.md); the program looks in the '// &
                   'current folder, then in the folder of the input file'//LISTS(:merge(len(LISTS), 0, is_training)), &
                   required=.true., given=c%has_file)
    call keys%kind('outliers', c%outliers, trim(OUTLIERS(first)%word), OUTLIERS(first:), &
                   'what to do with heights that differ from all heights around them by more than 6 standard deviations')
  end subroutine measurement_keys

  !> Declares the section in `registry`, as `measurement_keys` does.
  subroutine register_measurement_keys(registry, is_training)
    type(registry_t), intent(inout), target :: registry
    logical, intent(in) :: is_training
    type(measurement_choices_t) :: unused
    type(keys_t) :: keys
    keys = declaring(registry)
    call measurement_keys(keys, is_training, unused)
  end subroutine register_measurement_keys

  !> Returns what [Measurement] says to a training, or to another program.
  subroutine read_measurement_keys(config, is_training, choices)
    type(config_t), intent(in), target :: config
    logical, intent(in) :: is_training
    type(measurement_choices_t), intent(out) :: choices
    type(keys_t) :: keys
    keys = reading(config)
    call measurement_keys(keys, is_training, choices)
  end subroutine read_measurement_keys

  !> Removes outliers among the heights from the measurement, unless the `choice` of the user keeps them or, with `preset_keeps`,
  !> the preset of the program does. Adds a notice on their number to `notices`.
  subroutine choose_heights(choice, preset_keeps, path, measurement, found, notices)
    integer, intent(in) :: choice    !< OUTLIERS_*
    logical, intent(in) :: preset_keeps
    character(*), intent(in) :: path !< of the measurement
    type(measurement_t), intent(inout) :: measurement
    type(outliers_t), intent(out) :: found
    type(message_list_t), intent(inout) :: notices
    character(8) :: percent
    if (.not. allocated(measurement%loads)) return
    if (choice == OUTLIERS_KEEP .or. (choice == OUTLIERS_PRESET .and. preset_keeps)) return
    call leave_out_outliers(measurement, found)
    if (found%n == 0) return
    write (percent, '(f8.2)') 100.0*found%n/real(max(1, found%n_tested))
    call notices%add(path//': '//number_text(found%n)//' heights ('//trim(adjustl(percent))//' %) differ by more than 6 '// &
                     'standard deviations from the heights around them and are left out; [Measurement] outliers = keep keeps them')
  end subroutine choose_heights
end module common_measurement_keys
