! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads along which axes the numbers of a flight are: the attribute `axes` of a record, or of its landmarks, in a measurement file
!> (docs/formats/measurement-format.md). Its rows are the unit vectors x, y and z of the record along the axes of the case, so that
!>
!>     v_record = A v_case,   A A^T = I,   det A = 1.
module measurement_axes
  use base_kinds, only: rp
  use base_text, only: number_text
  use io_attributes, only: has_attribute
  use io_hdf5, only: hdf5_file_t
  use measurement_attributes, only: read_numbers
  use measurement_flight, only: SAME_AXES
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: read_axes

  real(rp), parameter :: LEAST_EXACT = 1.0e-4_rp !< of products of two axes; numbers of five digits are exact enough

contains

  !> Reads the attribute `axes` of a group. Without it, or after a mistake, which goes to `report`, the axes are those of the case.
  !> They are orthonormal to round-off and right-handed. Those of a section differ from those of the case by a turn about x alone.
  subroutine read_axes(file, group, is_section, axes, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    logical, intent(in) :: is_section
    real(rp), intent(out) :: axes(3, 3)
    type(wing_report_t), intent(inout) :: report
    real(rp) :: numbers(9), found(3, 3), wrong
    logical :: is_valid
    axes = SAME_AXES
    if (.not. has_attribute(file, group, 'axes')) return
    call read_numbers(file, group, 'axes', '', numbers, is_valid, report)
    if (.not. is_valid) return
    found = transpose(reshape(numbers, [3, 3]))
    wrong = maxval(abs(matmul(found, transpose(found)) - SAME_AXES))
    if (wrong > LEAST_EXACT) then
      call report%add(group, 'attribute axes: its rows are no unit vectors at right angles, by '//number_text(wrong)// &
                      '; valid: the axes x, y and z of the record along those of the case, up to '//number_text(LEAST_EXACT))
    else if (dot_product(cross(found(1, :), found(2, :)), found(3, :)) < 0) then
      call report%add(group, 'attribute axes is left-handed; valid: a third row that is the cross product of the first two')
    else if (is_section .and. abs(found(1, 1) - 1) > LEAST_EXACT) then
      call report%add(group, 'attribute axes turns about another axis than x, but per_length is 1; valid for a section: the '// &
                      'first row 1, 0, 0')
    else
      axes = exact(found, is_section)
    end if
  end subroutine read_axes

  !> Returns the nearby axes that are orthonormal to round-off and, for a section, have the x of the case. Those that are so already
  !> stay as they are.
  pure function exact(found, is_section) result(axes)
    real(rp), intent(in) :: found(3, 3)
    logical, intent(in) :: is_section
    real(rp), parameter :: ROUND_OFF = 1.0e-14_rp
    real(rp) :: axes(3, 3)
    axes = found
    if (maxval(abs(matmul(found, transpose(found)) - SAME_AXES)) <= ROUND_OFF .and. &
        .not. (is_section .and. abs(found(1, 1) - 1) > 0)) return
    axes(1, :) = found(1, :)
    if (is_section) axes(1, :) = [1, 0, 0]
    axes(1, :) = axes(1, :)/norm2(axes(1, :))
    axes(2, :) = found(2, :) - dot_product(found(2, :), axes(1, :))*axes(1, :)
    axes(2, :) = axes(2, :)/norm2(axes(2, :))
    axes(3, :) = cross(axes(1, :), axes(2, :))
  end function exact

  !> Returns a x b.
  pure function cross(a, b) result(c)
    real(rp), intent(in) :: a(3), b(3)
    real(rp) :: c(3)
    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross
end module measurement_axes
