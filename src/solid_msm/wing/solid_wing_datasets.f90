! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads and checks header, contents and datasets of a wing file: kind, shape, units and values. Measurement files use the same
!> procedures. It reports every deviation.
module solid_wing_datasets
  use base_kinds, only: rp, i8
  use base_text, only: number_text, quoted
  use io_arrays, only: is_group, member_names, describe_array, read_attribute_integer, read_reals, read_integers, &
                       read_text, ARRAY_MISSING, ARRAY_REAL, ARRAY_INTEGER
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use io_suggest, only: suggestion_t
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: check_members, check_schema, report_unknown, read_names, read_real_dataset, read_index_dataset

  integer, parameter :: MOST_ROWS = 10000000 !< of any array: far beyond any wing, but it fits the memory
  integer, parameter :: MOST_NAMES = 10000   !< veins or joints
  character(*), parameter :: NAME_CHARACTERS = &
                             'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_+-'

contains

  !> Reports a file whose attributes `schema` and `version` are not these. `kind` is the name of such files in words.
  subroutine check_schema(file, kind, schema, version, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: kind, schema
    integer, intent(in) :: version
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: text
    integer :: number
    logical :: ok
    call read_text(file, '/', 'schema', text, ok)
    if (.not. ok) then
      call report%add('attribute schema', 'missing or not a text; a '//kind//' file has '//quoted(schema))
    else if (text /= schema) then
      call report%add('attribute schema', 'is '//quoted(text)//', expected '//quoted(schema))
    end if
    call read_attribute_integer(file, '/', 'version', number, ok)
    if (.not. ok) then
      call report%add('attribute version', 'missing or not an integer; this program reads version ' &
                      //number_text(version))
    else if (number /= version) then
      call report%add('attribute version', 'is '//number_text(number)//'; this program reads version ' &
                      //number_text(version))
    end if
  end subroutine check_schema

  !> Reports the objects of a group that are not among the words of `known`.
  subroutine check_members(file, group, known, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    character(*), intent(in) :: known(:)
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    logical :: ok
    call member_names(file, group, MOST_NAMES, names, ok)
    if (.not. ok) call report%add(group, 'the list of contents cannot be read')
    call report_unknown('object', group, names, known, report)
  end subroutine check_members

  !> Reports those of `names`, each a `kind` of thing in `object`, that are not among the words of `known`.
  subroutine report_unknown(kind, object, names, known, report)
    character(*), intent(in) :: kind, object, names(:), known(:)
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: valid
    type(suggestion_t) :: suggestion
    integer :: i, k
    valid = ''
    do k = 1, size(known)
      valid = valid//', '//trim(known(k))
    end do
    call report%begin(object)
    do i = 1, size(names)
      if (any(known == names(i))) cycle
      call suggestion%start(trim(names(i)))
      do k = 1, size(known)
        call suggestion%offer(trim(known(k)))
      end do
      call report%found('unknown '//kind//' '//quoted(trim(names(i)))//suggestion%hint()//'; valid: '//valid(3:)// &
                        '; data of your own belong into /extra')
    end do
    call report%finish()
  end subroutine report_unknown

  !> Reads the names of the members of a group, which may be missing.
  subroutine read_names(file, group, names, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    character(NAME_LENGTH), allocatable, intent(out) :: names(:)
    type(wing_report_t), intent(inout) :: report
    logical :: ok
    integer :: i
    allocate (names(0))
    if (.not. file%has(group)) return
    if (.not. is_group(file, group)) then
      call report%add(group, 'is not a group')
      return
    end if
    call member_names(file, group, MOST_NAMES, names, ok)
    if (.not. ok) call report%add(group, 'the list of contents cannot be read, or is longer than '// &
                                  number_text(MOST_NAMES))
    call report%begin(group)
    do i = 1, size(names)
      if (verify(trim(names(i)), NAME_CHARACTERS) /= 0 .or. len_trim(names(i)) > 64) &
        call report%found(quoted(trim(names(i)))// &
                          ' is not a valid name: at most 64 letters, digits and _ + -')
    end do
    call report%finish()
  end subroutine read_names

  !> Reads rows of `columns` real numbers (0: a plain list), in metres unless the data have no units. They are empty after a
  !> mistake, which goes to the report.
  subroutine read_real_dataset(file, name, columns, values, report, has_units)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(in) :: columns
    real(rp), allocatable, intent(out) :: values(:)
    type(wing_report_t), intent(inout) :: report
    logical, intent(in), optional :: has_units
    character(:), allocatable :: text
    integer :: n
    logical :: ok, is_length
    is_length = .true.
    if (present(has_units)) is_length = has_units
    allocate (values(0))
    call check_shape(file, name, columns, .false., n, report)
    if (n < 0) return
    text = 'm'
    ok = .true.
    if (is_length) call read_text(file, name, 'units', text, ok)
    if (.not. ok) then
      call report%add(name, 'attribute units is missing or not a text; it must be ''m''')
    else if (text /= 'm') then
      call report%add(name, 'attribute units is '//quoted(text)//'; it must be ''m''')
    end if
    deallocate (values)
    allocate (values(n))
    call read_reals(file, name, values, ok)
    if (ok) return
    call report%add(name, 'cannot be read: damaged')
    values = values(:0)
  end subroutine read_real_dataset

  !> Reads rows of `columns` point numbers (0: a plain list), which are 1-based on return. They are empty after a mistake, which
  !> goes to the report. Numbers beyond the range of points are cut to that range plus or minus one; checks find them later.
  subroutine read_index_dataset(file, name, columns, values, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(in) :: columns
    integer, allocatable, intent(out) :: values(:)
    type(wing_report_t), intent(inout) :: report
    integer(i8), allocatable :: stored(:)
    integer :: n
    logical :: ok
    allocate (values(0))
    call check_shape(file, name, columns, .true., n, report)
    if (n < 0) return
    allocate (stored(n))
    call read_integers(file, name, stored, ok)
    if (.not. ok) then
      call report%add(name, 'cannot be read: damaged')
      return
    end if
    values = int(max(-1000000000_i8, min(1000000000_i8, stored))) - report%base + 1
  end subroutine read_index_dataset

  !> Returns the number of values `n` of a dataset if it exists and has the right kind and shape; otherwise -1.
  subroutine check_shape(file, name, columns, is_index, n, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(in) :: columns
    logical, intent(in) :: is_index
    integer, intent(out) :: n
    type(wing_report_t), intent(inout) :: report
    integer(i8), allocatable :: dims(:)
    character(:), allocatable :: wanted, found
    integer :: kind, i
    logical :: fits
    n = -1
    wanted = 'a list of '
    if (columns > 0) wanted = 'rows of '//number_text(columns)//' '
    wanted = wanted//trim(merge('integers    ', 'real numbers', is_index))
    call describe_array(file, name, kind, dims)
    if (kind == ARRAY_MISSING) then
      call report%add(name, 'missing; it must hold '//wanted)
    else if (is_index .and. kind /= ARRAY_INTEGER .or. .not. is_index .and. kind /= ARRAY_REAL) then
      call report%add(name, 'must hold '//wanted)
    else
      fits = size(dims) == merge(2, 1, columns > 0)
      if (fits .and. columns > 0) fits = dims(1) == columns .or. dims(2) == 0
      if (.not. fits) then
        found = ''
        do i = size(dims), 1, -1 ! as other programs show it: last Fortran index first
          found = found//number_text(int(min(dims(i), int(huge(1), i8))))
          if (i > 1) found = found//', '
        end do
        call report%add(name, 'must hold '//wanted//', but its shape is ('//found//')')
      else if (dims(size(dims)) > MOST_ROWS) then
        call report%add(name, 'has more than '//number_text(MOST_ROWS)//' rows')
      else
        n = int(product(dims))
      end if
    end if
  end subroutine check_shape
end module solid_wing_datasets
