! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the attributes of a measurement file and reports every deviation in kind, range and name.
module measurement_attributes
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text, quoted
  use io_arrays, only: is_finite, read_attribute_integer, read_attribute_reals, read_text
  use io_attributes, only: ATTRIBUTE_INTEGER, attribute_class, attribute_names, get_attribute, has_attribute
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use solid_wing_datasets, only: report_unknown
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: check_names, read_numbers, read_real, read_direction, read_vector, read_whole, read_word, valid_range_t, above_zero, &
            from_zero

  !> Holds the range of valid values of a number in a file.
  type :: valid_range_t
    real(rp) :: lowest = 0, highest = huge(1.0_rp)
    logical :: is_open = .false. !< the lowest value itself is not valid
  end type valid_range_t

contains

  !> Returns the range of all numbers above zero, up to `highest`.
  pure type(valid_range_t) function above_zero(highest) result(range)
    real(rp), intent(in) :: highest
    range = valid_range_t(0.0_rp, highest, .true.)
  end function above_zero

  !> Returns the range from zero up to `highest`.
  pure type(valid_range_t) function from_zero(highest) result(range)
    real(rp), intent(in) :: highest
    range = valid_range_t(0.0_rp, highest, .false.)
  end function from_zero

  !> Reports the attributes of `object` that are not among the words of `known`.
  subroutine check_names(file, object, known, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object
    character(*), intent(in) :: known(:)
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    type(failure_t) :: failure
    call attribute_names(file, object, names, failure)
    if (failure%failed) call report%add(object, 'the list of attributes cannot be read')
    call report_unknown('attribute', object, names, known, report)
  end subroutine check_names

  !> Reads a real (or integer) attribute in `unit`, in the range that is valid. If it is missing, it is `default`; without a
  !> default, a missing attribute is a mistake. After a mistake, which goes to `report`, the value is the default or the lowest one
  !> of the range.
  subroutine read_real(file, object, name, unit, valid, value, report, default)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name, unit
    type(valid_range_t), intent(in) :: valid
    real(rp), intent(out) :: value
    type(wing_report_t), intent(inout) :: report
    real(rp), intent(in), optional :: default
    real(rp) :: values(1)
    logical :: is_valid
    value = valid%lowest
    if (present(default)) value = default
    if (present(default) .and. .not. has_attribute(file, object, name)) return
    call read_numbers(file, object, name, unit, values, is_valid, report)
    if (.not. is_valid) return
    if (values(1) < valid%lowest .or. values(1) > valid%highest .or. valid%is_open .and. .not. values(1) > valid%lowest) then
      call report%add(object, 'attribute '//name//' is '//number_text(values(1))//'; valid: '// &
                      trim(merge('above   ', 'at least', valid%is_open))//' '//number_text(valid%lowest)//', at most '// &
                      number_text(valid%highest)//' '//unit)
    else
      value = values(1)
    end if
  end subroutine read_real

  !> Reads a required attribute of several reals, of size `highest` or less. After a mistake, which goes to `report`, they are 0.
  subroutine read_vector(file, object, name, unit, highest, values, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name, unit
    real(rp), intent(in) :: highest
    real(rp), intent(out) :: values(:)
    type(wing_report_t), intent(inout) :: report
    logical :: is_valid
    call read_numbers(file, object, name, unit, values, is_valid, report)
    if (.not. is_valid) return
    if (all(abs(values) <= highest)) return
    call report%add(object, 'attribute '//name//' holds '//number_text(maxval(abs(values)))//'; at most '// &
                    number_text(highest)//' '//unit//' are valid')
    values = 0
  end subroutine read_vector

  !> Reads a required direction and makes it a unit vector. After a mistake, which goes to `report`, it is (0, 0, 1).
  subroutine read_direction(file, object, name, direction, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    real(rp), intent(out) :: direction(3)
    type(wing_report_t), intent(inout) :: report
    real(rp) :: longest
    logical :: is_valid
    call read_numbers(file, object, name, '', direction, is_valid, report)
    longest = maxval(abs(direction))
    if (is_valid .and. (longest < 1.0e-6_rp .or. longest > 1.0e6_rp)) then
      call report%add(object, 'attribute '//name//' must be a vector of a length between 1e-6 and 1e6')
      is_valid = .false.
    end if
    if (is_valid) direction = direction/norm2(direction)
    if (.not. is_valid) direction = [0.0_rp, 0.0_rp, 1.0_rp]
  end subroutine read_direction

  !> Reads as many finite numbers as `values` has elements. They are 0 after a mistake, which goes to `report`; `is_valid` is then
  !> false.
  subroutine read_numbers(file, object, name, unit, values, is_valid, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name, unit
    real(rp), intent(out) :: values(:)
    logical, intent(out) :: is_valid
    type(wing_report_t), intent(inout) :: report
    type(failure_t) :: failure
    character(:), allocatable :: wanted
    wanted = 'a real number'
    if (size(values) > 1) wanted = number_text(size(values))//' real numbers'
    if (unit /= '' .and. unit /= '1') wanted = wanted//' ['//unit//']'
    values = 0
    if (.not. has_attribute(file, object, name)) then
      is_valid = .false.
      call report%add(object, 'attribute '//name//' is missing; it must hold '//wanted)
      return
    end if
    if (attribute_class(file, object, name) == ATTRIBUTE_INTEGER) then
      call get_attribute(file, object, name, values, failure)
    else
      call read_attribute_reals(file, object, name, values, failure)
    end if
    is_valid = .not. failure%failed
    if (failure%failed) then
      call report%add(object, 'attribute '//name//' must hold '//wanted)
    else if (.not. all(is_finite(values))) then
      is_valid = .false.
      call report%add(object, 'attribute '//name//' is infinite or undefined')
    end if
    if (.not. is_valid) values = 0
  end subroutine read_numbers

  !> Reads an optional integer between `lowest` and `highest`. It is `default` if it is missing, or after a mistake, which goes to
  !> `report`.
  subroutine read_whole(file, object, name, lowest, highest, default, value, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer, intent(in) :: lowest, highest, default
    integer, intent(out) :: value
    type(wing_report_t), intent(inout) :: report
    type(failure_t) :: failure
    integer :: found
    value = default
    if (.not. has_attribute(file, object, name)) return
    call read_attribute_integer(file, object, name, found, failure)
    if (failure%failed) then
      call report%add(object, 'attribute '//name//' must be an integer')
    else if (found < lowest .or. found > highest) then
      call report%add(object, 'attribute '//name//' is '//number_text(found)//'; valid: '//number_text(lowest)// &
                      ' to '//number_text(highest))
    else
      value = found
    end if
  end subroutine read_whole

  !> Reads a text. If it is missing, it is empty, which is a mistake if `is_required`. After a mistake, which goes to `report`, it
  !> is empty.
  subroutine read_word(file, object, name, is_required, text, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: object, name
    logical, intent(in) :: is_required
    character(:), allocatable, intent(out) :: text
    type(wing_report_t), intent(inout) :: report
    type(failure_t) :: failure
    text = ''
    if (.not. has_attribute(file, object, name)) then
      if (is_required) call report%add(object, 'attribute '//name//' is missing; it must be a text')
      return
    end if
    call read_text(file, object, name, text, failure)
    if (failure%failed) then
      call report%add(object, 'attribute '//name//' must be a text')
    else if (len(text) == 0 .or. len(text) > NAME_LENGTH) then
      call report%add(object, 'attribute '//name//' is '//quoted(text)// &
                      '; a text of 1 to '//number_text(NAME_LENGTH)//' letters is valid')
      text = ''
    end if
  end subroutine read_word
end module measurement_attributes
