! SPDX-License-Identifier: GPL-3.0-or-later
!> Handles the size of a wing: the size that [Wing] asks for, and the size for which its stiffness was found. SI units.
module common_wing_size
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_magnitude, only: rounded
  use base_text, only: number_text
  use io_config, only: config_t
  use solid_wing, only: wing_t
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: scale_wing, wing_size, notice_other_size

  real(rp), parameter :: SAME = 1.0e-6_rp !< sizes with a smaller relative difference are equal

contains

  !> Scales the wing to its requested size: first the whole wing by one factor to the requested length, then along y to the
  !> requested mean chord.
  subroutine scale_wing(s)
    type(wing_case_t), intent(inout) :: s
    real(rp) :: found(2), stretch
    integer :: i
    associate (points => s%wing%points, length => s%requested_size(1), chord => s%requested_size(2))
      if (length > 0) s%scale = length/maxval(points(1, :))
      points = s%scale(1)*points
      do i = 1, size(s%wing%veins)
        s%wing%veins(i)%diameters = s%scale(1)*s%wing%veins(i)%diameters
      end do
      found = wing_size(s%wing)
      if (chord > 0 .and. found(2) > 0) then
        stretch = chord/found(2)
        s%scale(2) = stretch*s%scale(2)
        points(2, :) = stretch*points(2, :)
      end if
    end associate
  end subroutine scale_wing

  !> Returns the largest x [m] and the mean chord [m], which is the area over the extent along x. The mean chord is 0 if the
  !> wing has no area.
  pure function wing_size(wing) result(found)
    type(wing_t), intent(in) :: wing
    real(rp) :: found(2), area, a(2), b(2), extent
    integer :: i
    area = 0
    associate (points => wing%points, triangles => wing%triangles)
      do i = 1, size(triangles, 2)
        a = points(:2, triangles(2, i)) - points(:2, triangles(1, i))
        b = points(:2, triangles(3, i)) - points(:2, triangles(1, i))
        area = area + (a(1)*b(2) - a(2)*b(1))/2
      end do
      found = [maxval(points(1, :)), 0.0_rp]
      extent = found(1) - minval(points(1, :))
      if (area > 0 .and. extent > 0) found(2) = area/extent
    end associate
  end function wing_size

  !> Adds a notice if the values in [Wing] were found for a wing of another size, because stiffness does not scale with the size.
  subroutine notice_other_size(config, then, wing, notices)
    type(config_t), intent(in) :: config
    real(rp), intent(in) :: then(2)  !< length and mean chord [m] of the wing for which the values were found
    type(wing_t), intent(in) :: wing !< as it is used
    type(message_list_t), intent(inout) :: notices
    real(rp) :: here(2)
    here = wing_size(wing)
    if (all(abs(then - here) <= SAME*abs(here))) return
    call config%complain(notices, 'Wing', 'found_size', 'these values were found for a wing of length '//mm(then(1))// &
                         ' and mean chord '//mm(then(2))//', but this wing has '//mm(here(1))//' and '//mm(here(2))// &
                         '; E, D and the stiffness of joints stay as they were found. [Wing] length and mean_chord set the size')
  end subroutine notice_other_size

  !> Returns a length [m] as text in mm.
  function mm(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    text = number_text(rounded(1.0e3_rp*x, 4))//' mm'
  end function mm
end module common_wing_size
