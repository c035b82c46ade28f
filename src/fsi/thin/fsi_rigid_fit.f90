! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the rotation that maps one set of points to another about their centres with the smallest squared error.
!>
!> With y = R (from - its centre) and d = to - its centre - y, R is turned by the small vector w with sum (|y|^2 1 - y y^T) w = sum
!> y x d, until it converges (Gauss and Newton). If all points lie on a line, R does not rotate about this line.
module fsi_rigid_fit
  use base_kinds, only: rp
  use fsi_rotation, only: cross
  implicit none
  private
  public :: fit_rotation

contains

  !> Returns the rotation R for which to - centre ~ R (from - centre), for from(3, n) and to(3, n), and the largest remaining
  !> distance [L].
  pure subroutine fit_rotation(from, to, rotation, farthest)
    real(rp), intent(in) :: from(:, :), to(:, :)
    real(rp), intent(out) :: rotation(3, 3), farthest
    integer, parameter :: SWEEPS = 6
    real(rp), parameter :: SMALL = 1.0e-9_rp
    real(rp) :: centre(3, 2), y(3), d(3), moments(3, 3), turn(3), w(3)
    integer :: i, k, sweep
    centre = reshape([sum(from, 2), sum(to, 2)], [3, 2])/size(from, 2)
    rotation = turned_by([0.0_rp, 0.0_rp, 0.0_rp])
    do sweep = 1, SWEEPS
      moments = 0
      turn = 0
      do i = 1, size(from, 2)
        y = matmul(rotation, from(:, i) - centre(:, 1))
        d = to(:, i) - centre(:, 2) - y
        turn = turn + cross(y, d)
        do k = 1, 3
          moments(:, k) = moments(:, k) - y*y(k)
          moments(k, k) = moments(k, k) + sum(y**2)
        end do
      end do
      do k = 1, 3
        moments(k, k) = moments(k, k) + SMALL*(moments(1, 1) + moments(2, 2) + moments(3, 3)) + tiny(1.0_rp)
      end do
      w = solved(moments, turn)
      rotation = matmul(turned_by(w), rotation)
      if (norm2(w) < SMALL) exit
    end do
    farthest = 0
    do i = 1, size(from, 2)
      farthest = max(farthest, norm2(matmul(rotation, from(:, i) - centre(:, 1)) - (to(:, i) - centre(:, 2))))
    end do
  end subroutine fit_rotation

  !> Solves a x = b for a symmetric positive definite matrix by Cramer's rule.
  pure function solved(a, b) result(x)
    real(rp), intent(in) :: a(3, 3), b(3)
    real(rp) :: x(3), minors(3, 3)
    minors(:, 1) = cross(a(:, 2), a(:, 3))
    minors(:, 2) = cross(a(:, 3), a(:, 1))
    minors(:, 3) = cross(a(:, 1), a(:, 2))
    x = matmul(transpose(minors), b)/dot_product(a(:, 1), minors(:, 1))
  end function solved

  !> Returns the rotation by the vector w (Rodrigues).
  pure function turned_by(w) result(r)
    real(rp), intent(in) :: w(3)
    real(rp) :: r(3, 3), unit(3), axis(3), angle
    integer :: k
    angle = norm2(w)
    unit = w/max(angle, tiny(angle))
    do k = 1, 3
      axis = 0
      axis(k) = 1
      r(:, k) = cos(angle)*axis + sin(angle)*cross(unit, axis) + (1 - cos(angle))*unit(k)*unit
    end do
  end function turned_by
end module fsi_rigid_fit
