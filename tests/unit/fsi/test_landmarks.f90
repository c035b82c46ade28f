! SPDX-License-Identifier: GPL-3.0-or-later
!> Landmarks move with the triangles of a wing: exactly if it is rigid or bends linearly, and also just outside of it.
program test_landmarks
  use base_kinds, only: rp
  use fsi_landmarks, only: landmarks_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: TRIANGLES(3, 2) = reshape([1, 2, 3, 1, 3, 4], [3, 2])
  real(rp), parameter :: POINTS(3, 4) = reshape([0.0_rp, -1.0_rp, 0.0_rp, 3.0_rp, -1.0_rp, 0.0_rp, 3.0_rp, 1.0_rp, 0.3_rp, &
                                                 0.0_rp, 1.0_rp, 0.0_rp], [3, 4])
  type(testkit_t) :: t
  call t%start(parallel=.false.)
  call check_places()
  call check_lost()
  call t%finish()

contains

  !> The motion x -> A x + b of all points moves landmarks in the same way. A sum of three products loses a few units of the last
  !> place of numbers of size 10.
  subroutine check_places()
    type(landmarks_t) :: marks
    real(rp), parameter :: SITES(2, 4) = reshape([0.0_rp, -1.0_rp, 2.0_rp, -0.5_rp, 0.5_rp, 0.9_rp, 3.2_rp, 0.0_rp], [2, 4]), &
                           A(3, 3) = reshape([0.8_rp, 0.6_rp, 0.1_rp, -0.6_rp, 0.8_rp, 0.2_rp, 0.3_rp, 0.0_rp, 1.0_rp], [3, 3]), &
                           B(3) = [1.0_rp, -2.0_rp, 5.0_rp], LEAST = 1.0e-14_rp
    real(rp) :: moved(3, 4), at_rest(3, 4)
    integer :: lost, i
    call marks%find(POINTS, TRIANGLES, SITES, lost)
    call t%check('all are found', lost == 0 .and. marks%count() == 4)
    at_rest = marks%places(POINTS)
    call t%check('at rest they are where they are', maxval(abs(at_rest(:2, :) - SITES)) < LEAST)
    call t%check('on the surface', abs(at_rest(3, 1)) < LEAST .and. at_rest(3, 2) > 0.01_rp)
    do i = 1, 4
      moved(:, i) = matmul(A, POINTS(:, i)) + B
    end do
    associate (places => marks%places(moved))
      call t%check('a wing takes them along', maxval(abs(places - matmul(A, at_rest) - spread(B, 2, 4))) < 10*LEAST)
    end associate
  end subroutine check_places

  !> A point far from the wing, and triangles without an area.
  subroutine check_lost()
    type(landmarks_t) :: marks
    integer :: lost
    call marks%find(POINTS, TRIANGLES, reshape([1.0_rp, 0.0_rp, 9.0_rp, 0.0_rp], [2, 2]), lost)
    call t%check('the second point is not on the wing', lost == 2)
    call marks%find(POINTS, reshape([1, 1, 2], [3, 1]), reshape([1.0_rp, 0.0_rp], [2, 1]), lost)
    call t%check('no point is on a triangle without an area', lost == 1)
    call marks%find(POINTS, TRIANGLES, reshape([1.0_rp, 0.0_rp], [2, 1]), lost)
    call t%check('landmarks are found anew', lost == 0 .and. marks%count() == 1)
  end subroutine check_lost
end program test_landmarks
