! SPDX-License-Identifier: GPL-3.0-or-later
!> Products of vectors in space.
module solid_vectors
  use base_kinds, only: rp
  implicit none
  private
  public :: cross, skew, outer, longest

  real(rp), parameter, public :: IDENTITY(3, 3) = &
                               reshape([1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp], [3, 3])

contains

  !> Returns the cross product a x b.
  pure function cross(a, b) result(c)
    real(rp), intent(in) :: a(3), b(3)
    real(rp) :: c(3)
    c(1) = a(2)*b(3) - a(3)*b(2)
    c(2) = a(3)*b(1) - a(1)*b(3)
    c(3) = a(1)*b(2) - a(2)*b(1)
  end function cross

  !> Returns the matrix [a]x, for which [a]x b = a x b.
  pure function skew(a) result(m)
    real(rp), intent(in) :: a(3)
    real(rp) :: m(3, 3)
    m(:, 1) = [0.0_rp, a(3), -a(2)]
    m(:, 2) = [-a(3), 0.0_rp, a(1)]
    m(:, 3) = [a(2), -a(1), 0.0_rp]
  end function skew

  !> Returns the dyad a b^T.
  pure function outer(a, b) result(m)
    real(rp), intent(in) :: a(3), b(3)
    real(rp) :: m(3, 3)
    m(:, 1) = a*b(1)
    m(:, 2) = a*b(2)
    m(:, 3) = a*b(3)
  end function outer

  !> Returns the length of the longest column of a(3, :), or of the difference of two such arrays.
  pure real(rp) function longest(a, b) result(length)
    real(rp), intent(in) :: a(:, :)
    real(rp), intent(in), optional :: b(:, :)
    integer :: i
    length = 0
    do i = 1, size(a, 2)
      if (present(b)) then
        length = max(length, sum((a(:, i) - b(:, i))**2))
      else
        length = max(length, sum(a(:, i)**2))
      end if
    end do
    length = sqrt(length)
  end function longest
end module solid_vectors
