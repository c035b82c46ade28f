! SPDX-License-Identifier: GPL-3.0-or-later
!> [Measurement] outliers: whether heights that stand out from those around them count.
module common_outliers
  use base_errors, only: message_list_t
  use base_text, only: number_text
  use io_config, only: config_t
  use io_registry, only: registry_t
  use measurement_data, only: measurement_t
  use measurement_outliers, only: leave_out_outliers, outliers_t
  implicit none
  private
  public :: register_outliers, choose_heights

contains

  !> The key, of a program that has [Measurement]; `fallback` is what it does without.
  subroutine register_outliers(registry, words, fallback)
    type(registry_t), intent(inout) :: registry
    character(*), intent(in) :: words, fallback
    call registry%add_word('Measurement', 'outliers', fallback, words, &
                           'heights that stand out from all around them by more than 6 sd, as no normal errors do')
  end subroutine register_outliers

  !> Leaves them out, unless they are to be kept or the program's preset `keeps` them, and adds how many to `notices`.
  subroutine choose_heights(config, path, keeps, measurement, outliers, notices)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: path !< of the measurement
    logical, intent(in) :: keeps
    type(measurement_t), intent(inout) :: measurement
    type(outliers_t), intent(out) :: outliers
    type(message_list_t), intent(inout) :: notices
    character(8) :: percent
    if (.not. allocated(measurement%loads)) return
    select case (config%get_word('Measurement', 'outliers'))
    case ('keep')
      return
    case ('preset')
      if (keeps) return
    end select
    call leave_out_outliers(measurement, outliers)
    if (outliers%n == 0) return
    write (percent, '(f8.2)') 100.0*outliers%n/real(max(1, outliers%n_tested))
    call notices%add(path//': '//number_text(outliers%n)//' heights ('//trim(adjustl(percent))//' %) stand out '// &
                     'from those around them and are left out; [Measurement] outliers = keep keeps them')
  end subroutine choose_heights
end module common_outliers
