! SPDX-License-Identifier: GPL-3.0-or-later
!> Turns what a flight shows into the axes of a record. Forces, torques and places of a flight are along the axes of the case, and
!> those of a record are v_record = A v_case with the matrix A of the record (measurement_axes).
module diagnosis_flight_axes
  use base_kinds, only: rp
  use measurement_balance, only: move_torques
  use measurement_flight, only: measured_flight_t, N_COMPONENTS, SAME_AXES
  implicit none
  private
  public :: along_axes

contains

  !> Returns x(:, components), samples or Fourier coefficients of all that a flight shows [SI units], as record f has it: forces and
  !> torques along its axes, these about its reference, or else the places of its landmarks along its axes, from the origin of the
  !> case. Power is the same along all axes. Landmarks of other records stay along the axes of the case.
  pure function along_axes(f, x) result(seen)
    type(measured_flight_t), intent(in) :: f
    complex(rp), intent(in) :: x(:, :)
    complex(rp) :: seen(size(x, 1), size(x, 2))
    integer :: l
    seen = x
    if (f%side == 0) call move_torques(seen, f%reference)
    if (all(abs(f%axes - SAME_AXES) <= 0)) return
    if (f%side == 0) then
      call turn(seen, 0, f%axes)
      call turn(seen, 3, f%axes)
    end if
    do l = 1, f%count_landmarks()
      if (f%side > 0) call turn(seen, N_COMPONENTS + 3*(f%first + l - 1), f%axes)
    end do
  end function along_axes

  !> Turns the vectors in the three columns of x behind column `before` into the axes.
  pure subroutine turn(x, before, axes)
    complex(rp), intent(inout) :: x(:, :)
    integer, intent(in) :: before
    real(rp), intent(in) :: axes(3, 3)
    complex(rp) :: vector(size(x, 1), 3)
    integer :: i
    vector = x(:, before + 1:before + 3)
    do i = 1, 3
      x(:, before + i) = axes(i, 1)*vector(:, 1) + axes(i, 2)*vector(:, 2) + axes(i, 3)*vector(:, 3)
    end do
  end subroutine turn
end module diagnosis_flight_axes
