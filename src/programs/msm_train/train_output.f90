! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the files of a training: NAME.ini, a fragment with the trained wing that parameter files include, and NAME_history.h5
!> with everything that was computed. Each file gets its name only when it is complete.
module train_output
  use base_build, only: BUILD_COMMIT, BUILD_VERSION
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_text_file, only: write_text
  use common_instrument, only: instrument_lines
  use common_wing_fragment, only: wing_lines
  use io_attributes, only: put_attribute
  use io_hdf5, only: hdf5_file_t
  use io_table, only: put_table
  use solid_params, only: membrane_note, solid_params_t
  use train_details, only: write_details
  use train_settings, only: train_settings_t
  use training_history, only: train_history_t
  use training_intervals, only: interval_sentence
  use training_outcome, only: trained_t
  use training_space, only: search_space_t
  implicit none
  private
  public :: write_fragment, write_history, outcome_lines, free_note

  character(*), parameter :: NL = new_line('a')

contains

  !> Writes the fragment with the trained values and with all other values of the model that they belong to.
  subroutine write_fragment(settings, space, trained, failure)
    type(train_settings_t), intent(in) :: settings
    type(search_space_t), intent(in) :: space
    type(trained_t), intent(in) :: trained
    type(failure_t), intent(inout) :: failure
    type(solid_params_t) :: p
    character(:), allocatable :: text, note
    logical :: is_soft
    p = settings%experiment%params(trained%coordinates)
    call membrane_note(p, note, is_soft)
    text = '; Stiffness of '//settings%wing_case%path//', trained on '//settings%measurement_path//NL// &
           '; by msm_train '//BUILD_VERSION//' ('//BUILD_COMMIT//').'//NL//';'//NL// &
           outcome_lines(settings, space, trained, '; ')//free_note(space, trained)// &
           '; These values of E and joints belong to the '//note//'.'//NL// &
           '; [include] file = '//settings%result//NL//NL//wing_lines(p, settings%wing_case)// &
           instrument_lines(settings%experiment%instrument_at(trained%coordinates))
    call write_text(settings%result, text, failure)
  end subroutine write_fragment

  !> Returns a line that lists the values which the data do not determine, so that other values fit as well. It is empty if there
  !> are none.
  function free_note(space, trained) result(text)
    type(search_space_t), intent(in) :: space
    type(trained_t), intent(in) :: trained
    character(:), allocatable :: text
    integer :: i
    text = ''
    if (trained%has_failed_polish()) return ! the outcome says that no value is known
    do i = 1, size(trained%values)
      if (.not. trained%determines(i)) text = text//', '//trim(space%names(i))
    end do
    if (text /= '') text = '; Not determined; other values fit as well as the values below: '//text(3:)//'.'//NL
  end function free_note

  !> Returns the outcome in sentences, each behind `prefix`.
  function outcome_lines(settings, space, trained, prefix) result(text)
    type(train_settings_t), intent(in) :: settings
    type(search_space_t), intent(in) :: space
    type(trained_t), intent(in) :: trained
    character(*), intent(in) :: prefix
    character(:), allocatable :: text
    character(160) :: line
    integer :: i, n
    n = settings%experiment%count_residuals(0)
    text = prefix
    if (any(settings%experiment%comparisons%n_heights > 0)) then
      write (line, '(a,es11.4,a)') 'h = ', trained%h, ' m; '
      text = text//trim(line)//' '
    end if
    write (line, '(a,es11.4,a,i0,a)') 'chi^2 = ', trained%chi2, ' of ', n, ' residuals'
    text = text//trim(line)//NL
    if (.not. trained%fits) text = text//prefix//'warning: the fit does not agree with the declared errors, so the '// &
                                   'uncertainties of the parameters below are not valid'//NL
    if (trained%has_failed_polish()) &
      text = text//prefix//'warning: least squares failed ('//trained%reason//'): the values are those at the end of the '// &
             'search, and their uncertainties are not known'//NL
    do i = 1, size(trained%values)
      if (trained%has_intervals) then
        text = text//prefix//interval_sentence(settings%experiment, space, trained, i)//NL
      else
        text = text//prefix//trim(space%names(i))//': '//value_words(space, trained, i)//NL
      end if
    end do
  end function outcome_lines

  !> Describes unknown i if no interval was computed: its value, and how far the value can be trusted.
  function value_words(space, trained, i) result(words)
    type(search_space_t), intent(in) :: space
    type(trained_t), intent(in) :: trained
    integer, intent(in) :: i
    character(:), allocatable :: words, value
    character(40) :: buffer
    write (buffer, '(es13.6)') trained%values(i)
    value = trim(adjustl(buffer))//' '//trim(space%units(i))
    if (trained%bound(i) /= 0) then
      words = 'at the '//trim(merge('lower', 'upper', trained%bound(i) < 0))//' bound: '//value// &
              '; the bound limits it, not the data, and a '//trim(merge('smaller', 'larger ', trained%bound(i) < 0))// &
              ' value may fit better'
    else if (trained%has_failed_polish()) then
      words = 'not determined; the search ended at '//value
    else if (trained%is_polished) then
      words = value
      if (.not. trained%determines(i)) words = 'not determined by these data (intervals = yes gives its limits)'
      write (buffer, '(a,es9.2)') trim(merge('of the logarithm', '                ', space%is_log(i))), &
        trained%posterior%sd(i)
      words = words//', predicted sd '//trim(adjustl(buffer))
    else
      words = number_text(trained%values(i))//' '//trim(space%units(i))// &
              ', without an uncertainty'
    end if
  end function value_words

  !> Writes the history, and the outcome if `trained` is present.
  subroutine write_history(settings, space, history, failure, trained)
    type(train_settings_t), intent(in) :: settings
    type(search_space_t), intent(in) :: space
    type(train_history_t), intent(in) :: history
    type(failure_t), intent(inout) :: failure
    type(trained_t), intent(in), optional :: trained
    type(hdf5_file_t) :: file
    character(:), allocatable :: names, units, path
    integer :: i
    path = settings%name//'_history.h5'
    names = ''
    units = ''
    do i = 1, size(space%names)
      names = names//' '//trim(space%names(i))
      units = units//', '//trim(space%units(i))
    end do
    call file%create_serial(path//'.part', failure)
    call put_attribute(file, '/', 'schema', 'flusi-msm training history', failure)
    call put_attribute(file, '/', 'version', 1, failure)
    call put_attribute(file, '/', 'unknowns', names(2:), failure)
    call put_attribute(file, '/', 'units', units(3:), failure)
    call put_attribute(file, '/', 'cost', trim(merge('chi2', 'h   ', settings%use_chi2)), failure)
    call put_attribute(file, '/', 'wing', settings%wing_case%path, failure)
    call put_attribute(file, '/', 'measurement', settings%measurement_path, failure)
    call put_attribute(file, '/', 'lower', space%box%lower, failure)
    call put_attribute(file, '/', 'upper', space%box%upper, failure)
    call history%write_tables(file, names(2:), failure)
    if (present(trained)) call write_outcome(file, settings, space, trained, failure)
    call file%publish(path, .false., failure)
  end subroutine write_history

  !> Writes the parameters that were found, their uncertainty and the residuals of every load.
  subroutine write_outcome(file, settings, space, trained, failure)
    type(hdf5_file_t), intent(in) :: file
    type(train_settings_t), intent(in) :: settings
    type(search_space_t), intent(in) :: space
    type(trained_t), intent(in) :: trained
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: rows(:, :)
    integer :: i, l
    call file%make_group('/outcome', failure)
    call put_attribute(file, '/outcome', 'values', trained%values, failure)
    call put_attribute(file, '/outcome', 'h', trained%h, failure)
    call put_attribute(file, '/outcome', 'chi2', trained%chi2, failure)
    call put_attribute(file, '/outcome', 'cold_difference', trained%cold_difference, failure)
    if (trained%is_polished) then
      call put_attribute(file, '/outcome', 'sd', trained%posterior%sd, failure)
      call put_attribute(file, '/outcome', 'singular_values', trained%posterior%singular_values, failure)
      call put_table(file, '/outcome/covariance', trained%posterior%covariance, 'as unknowns', failure)
    end if
    if (trained%has_intervals) then
      allocate (rows(5, size(trained%values)))
      do i = 1, size(trained%values)
        associate (one => trained%intervals(i))
          rows(:, i) = [one%lower, one%best, one%upper, merge([1.0_rp, 1.0_rp], [0.0_rp, 0.0_rp], &
                                                              [one%has_lower, one%has_upper])]
        end associate
        if (space%is_log(i)) rows(:3, i) = exp(rows(:3, i))
      end do
      call put_table(file, '/outcome/intervals', rows, 'lower best upper has_lower has_upper', failure)
    end if
    call file%make_group('/loads', failure)
    do l = 1, size(trained%evaluations)
      call write_load(file, settings, l, trained%evaluations(l)%residuals, failure)
    end do
    call write_details(file, settings, space, trained, failure)
  end subroutine write_outcome

  !> Writes a row for every height of the load: x, y, the measured and the computed deformation, all in m.
  subroutine write_load(file, settings, l, residuals, failure)
    type(hdf5_file_t), intent(in) :: file
    type(train_settings_t), intent(in) :: settings
    integer, intent(in) :: l
    real(rp), intent(in) :: residuals(:)
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: rows(:, :)
    integer :: k
    associate (comparison => settings%experiment%comparisons(l), m => settings%experiment%measurement)
      if (comparison%n_heights == 0) return
      allocate (rows(4, comparison%n_heights))
      do k = 1, comparison%n_heights
        rows(:, k) = [m%x(comparison%node(1, k)), m%y(comparison%node(2, k)), comparison%measured(k), &
                      comparison%measured(k) + residuals(k)]
      end do
      call put_table(file, '/loads/'//m%loads(l)%name, rows, 'x y measured computed', failure)
      call put_attribute(file, '/loads/'//m%loads(l)%name, 'units', 'm', failure)
      call put_attribute(file, '/loads/'//m%loads(l)%name, 'point', m%loads(l)%point, failure)
      call put_attribute(file, '/loads/'//m%loads(l)%name, 'force', m%loads(l)%force, failure)
    end associate
  end subroutine write_load
end module train_output
