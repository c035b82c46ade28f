! SPDX-License-Identifier: GPL-3.0-or-later
!> Converts between the coordinates of the search, u, and physical parameters. u in [0, 1] is the box; the parameter or its
!> logarithm is an affine function of u. No other module depends on this relation.
!>
!>     linear   value = lower + u (upper - lower)
!>     log      value = lower (upper/lower)^u
module cmaes_box
  use base_errors, only: require
  use base_kinds, only: rp
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  implicit none
  private
  public :: cmaes_box_t, make_box, box_problem, clip, bound_side

  !> Bounds, in the units of the parameters.
  type :: cmaes_box_t
    real(rp), allocatable :: lower(:), upper(:)
    logical, allocatable :: is_log(:)
  contains
    procedure :: value => box_value
    procedure :: coordinate => box_coordinate
  end type cmaes_box_t

contains

  !> Returns a sentence that says what is wrong with the bounds of one parameter; it is empty if they are valid.
  function box_problem(lower, upper, is_log) result(problem)
    real(rp), intent(in) :: lower, upper
    logical, intent(in) :: is_log
    character(:), allocatable :: problem
    problem = ''
    if (.not. (ieee_is_finite(lower) .and. ieee_is_finite(upper))) then
      problem = 'bounds must be finite'
    else if (.not. upper > lower) then
      problem = 'the upper bound must exceed the lower one'
    else if (is_log .and. .not. lower > 0) then
      problem = 'a logarithmic scale needs positive bounds'
    end if
  end function box_problem

  !> Returns a box whose bounds have no problems.
  function make_box(lower, upper, is_log) result(box)
    real(rp), intent(in) :: lower(:), upper(:)
    logical, intent(in) :: is_log(:)
    type(cmaes_box_t) :: box
    integer :: i
    call require(size(lower) == size(upper) .and. size(lower) == size(is_log), 'make_box: as many of each')
    do i = 1, size(lower)
      call require(box_problem(lower(i), upper(i), is_log(i)) == '', 'make_box: valid bounds')
    end do
    box%lower = lower
    box%upper = upper
    box%is_log = is_log
  end function make_box

  !> Returns the physical values of the coordinates u(n). At 0 and 1 they are exactly the bounds; u may also lie outside of [0, 1].
  pure function box_value(self, u) result(value)
    class(cmaes_box_t), intent(in) :: self
    real(rp), intent(in) :: u(:)
    real(rp) :: value(size(u))
    integer :: i
    do i = 1, size(u)
      if (u(i) <= 0 .and. u(i) >= 0) then
        value(i) = self%lower(i)
      else if (u(i) <= 1 .and. u(i) >= 1) then
        value(i) = self%upper(i)
      else if (self%is_log(i)) then
        value(i) = self%lower(i)*exp(u(i)*log(self%upper(i)/self%lower(i)))
      else
        value(i) = self%lower(i) + u(i)*(self%upper(i) - self%lower(i))
      end if
    end do
  end function box_value

  !> Returns the coordinates of physical values, which are positive where the scale is logarithmic.
  function box_coordinate(self, value) result(u)
    class(cmaes_box_t), intent(in) :: self
    real(rp), intent(in) :: value(:)
    real(rp) :: u(size(value))
    integer :: i
    do i = 1, size(value)
      if (self%is_log(i)) then
        call require(value(i) > 0, 'box_coordinate: a positive value on a logarithmic scale')
        u(i) = log(value(i)/self%lower(i))/log(self%upper(i)/self%lower(i))
      else
        u(i) = (value(i) - self%lower(i))/(self%upper(i) - self%lower(i))
      end if
    end do
  end function box_coordinate

  !> Returns the nearest coordinate in [0, 1].
  pure elemental real(rp) function clip(u)
    real(rp), intent(in) :: u
    clip = min(max(u, 0.0_rp), 1.0_rp)
  end function clip

  !> Returns -1, 0 or 1: u lies at or below the lower bound, inside, at or above the upper bound, within `tolerance`. At a bound the
  !> data do not limit the parameter on that side.
  pure elemental integer function bound_side(u, tolerance) result(side)
    real(rp), intent(in) :: u, tolerance
    side = 0
    if (u <= tolerance) side = -1
    if (u >= 1 - tolerance) side = 1
  end function bound_side
end module cmaes_box
