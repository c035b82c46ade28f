! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads [Measurement]: the measurement file, and whether outliers among the heights are used.
module common_measurement_keys
  use base_errors, only: message_list_t
  use base_text, only: number_text
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  use measurement_data, only: measurement_t
  use measurement_outliers, only: leave_out_outliers, outliers_t
  implicit none
  private
  public :: measurement_choices_t, register_measurement_keys, read_measurement_keys, choose_heights

  !> Holds what the section says.
  type :: measurement_choices_t
    character(:), allocatable :: file, outliers
    logical :: has_file = .false.
  end type measurement_choices_t

contains

  !> Declares and reads the section. `more` continues the help on its file. `words` lists what a program can do about outliers,
  !> and `fallback` is the default among them.
  subroutine measurement_keys(keys, c, more, words, fallback)
    type(keys_t), intent(inout) :: keys
    type(measurement_choices_t), intent(inout) :: c
    character(*), intent(in) :: more, words, fallback
    call keys%section('Measurement', 'the measured shapes and motions of the wing')
    call keys%text('file', c%file, '', 'measurement file (docs/formats/measurement-format.md); the program looks in the '// &
                   'current folder, then in the folder of the input file'//more, required=.true., given=c%has_file)
    call keys%word('outliers', c%outliers, fallback, words, &
                   'what to do with heights that differ from all heights around them by more than 6 standard deviations')
  end subroutine measurement_keys

  !> Declares the section in `registry`, with the arguments of `measurement_keys`.
  subroutine register_measurement_keys(registry, more, words, fallback)
    type(registry_t), intent(inout), target :: registry
    character(*), intent(in) :: more, words, fallback
    type(measurement_choices_t) :: unused
    type(keys_t) :: keys
    keys = declaring(registry)
    call measurement_keys(keys, unused, more, words, fallback)
  end subroutine register_measurement_keys

  !> Returns what [Measurement] says.
  subroutine read_measurement_keys(config, choices)
    type(config_t), intent(in), target :: config
    type(measurement_choices_t), intent(out) :: choices
    type(keys_t) :: keys
    keys = reading(config)
    call measurement_keys(keys, choices, '', '', '')
  end subroutine read_measurement_keys

  !> Removes outliers among the heights from the measurement, unless the user keeps them or, with `keeps`, the preset of the program
  !> does. Adds a notice on their number to `notices`.
  subroutine choose_heights(config, path, keeps, measurement, outliers, notices)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: path !< of the measurement
    logical, intent(in) :: keeps
    type(measurement_t), intent(inout) :: measurement
    type(outliers_t), intent(out) :: outliers
    type(message_list_t), intent(inout) :: notices
    type(measurement_choices_t) :: choices
    character(8) :: percent
    if (.not. allocated(measurement%loads)) return
    call read_measurement_keys(config, choices)
    select case (choices%outliers)
    case ('keep')
      return
    case ('preset')
      if (keeps) return
    end select
    call leave_out_outliers(measurement, outliers)
    if (outliers%n == 0) return
    write (percent, '(f8.2)') 100.0*outliers%n/real(max(1, outliers%n_tested))
    call notices%add(path//': '//number_text(outliers%n)//' heights ('//trim(adjustl(percent))//' %) differ by more than 6 '// &
                     'standard deviations from the heights around them and are left out; [Measurement] outliers = keep keeps them')
  end subroutine choose_heights
end module common_measurement_keys
