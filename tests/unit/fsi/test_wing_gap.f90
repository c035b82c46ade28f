! SPDX-License-Identifier: GPL-3.0-or-later
!> Gaps between plates in known places, through the sides of the box too.
program test_wing_gap
  use base_kinds, only: rp
  use fsi_planform, only: rectangular_planform
  use fsi_planform_mesh, only: triangulate_planform
  use fsi_surface, only: surface_t
  use fsi_wing_gap, only: gap_t, smallest_gap
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: BOX(3) = [3.0_rp, 4.0_rp, 2.0_rp], NOT_PERIODIC(3) = [0.0_rp, 4.0_rp, 2.0_rp]
  type(testkit_t) :: kit
  type(surface_t) :: wings(2)
  type(gap_t) :: gap
  real(rp), allocatable :: points(:, :)
  integer, allocatable :: triangles(:, :)
  integer :: i

  call kit%start(parallel=.false.)
  ! 1 x 0.4, from the hinge along x, y within +-0.2.
  call triangulate_planform(rectangular_planform(0.0_rp, 1.0_rp, 0.4_rp, 0.5_rp), 0.1_rp, points, triangles)
  do i = 1, 2
    call wings(i)%init(points, triangles, i + 1)
  end do
  call put(1, [1.0_rp, 1.0_rp, 1.0_rp])

  call put(2, [1.3_rp, 1.1_rp, 1.07_rp])
  gap = smallest_gap(wings, 0.1_rp, BOX)
  call kit%check_close('plates above each other', gap%distance, 0.07_rp, rtol=1.0e-13_rp)
  call kit%check('are two', gap%first == 1 .and. gap%second == 2 .and. .not. gap%is_image)
  gap = smallest_gap(wings, 0.06_rp, BOX)
  call kit%check('and not closer than asked for', gap%first == 0 .and. gap%distance > 1)

  call put(2, [1.0_rp, 1.45_rp, 1.03_rp])
  gap = smallest_gap(wings, 0.1_rp, BOX)
  call kit%check_close('beside each other', gap%distance, sqrt(0.05_rp**2 + 0.03_rp**2), rtol=1.0e-12_rp)

  call put(2, [1.0_rp, 1.0_rp, 1.0_rp + BOX(3) - 0.02_rp])
  gap = smallest_gap(wings, 0.1_rp, BOX)
  call kit%check_close('above each other through the top of the box', gap%distance, 0.02_rp, rtol=1.0e-12_rp)
  call kit%check('which is told', gap%is_image)

  call put(2, [2.5_rp, 3.0_rp, 1.5_rp])
  gap = smallest_gap(wings, 0.1_rp, BOX)
  call kit%check('far apart', gap%first == 0)
  gap = smallest_gap(wings, 0.1_rp, [1.05_rp, 4.0_rp, 2.0_rp])
  call kit%check_close('a wing and its image', gap%distance, 0.05_rp, rtol=1.0e-12_rp)
  call kit%check('are the same wing', gap%first == gap%second .and. gap%is_image)
  gap = smallest_gap(wings, 0.1_rp, NOT_PERIODIC)
  call kit%check('without images in this direction', gap%first == 0)
  call test_coarse_and_fine()
  call kit%finish()

contains

  !> A small fine wing over the middle of a large triangle, far from its corners: only its points are near, whichever of
  !> the two is the first.
  subroutine test_coarse_and_fine()
    real(rp), parameter :: HEIGHT = 0.04_rp, CORNERS(3, 3) = reshape([0.5_rp, 0.5_rp, 1.0_rp, 2.5_rp, 0.5_rp, 1.0_rp, &
                                                                      1.5_rp, 3.5_rp, 1.0_rp], [3, 3])
    type(surface_t) :: pair(2)
    integer :: fine
    do fine = 1, 2
      call pair(fine)%init(0.2_rp*points, triangles, 2)
      pair(fine)%points = pair(fine)%points + spread([1.45_rp, 1.5_rp, 1.0_rp + HEIGHT], 2, size(points, 2))
      call pair(3 - fine)%init(CORNERS, reshape([1, 2, 3], [3, 1]), 3)
      gap = smallest_gap(pair, 0.1_rp, BOX)
      call kit%check_close('a fine wing over a coarse one, '//merge('the first ', 'the second', fine == 1), &
                           gap%distance, HEIGHT, rtol=1.0e-12_rp)
    end do
  end subroutine test_coarse_and_fine

  subroutine put(i, hinge)
    integer, intent(in) :: i
    real(rp), intent(in) :: hinge(3)
    integer :: p
    do p = 1, size(points, 2)
      wings(i)%points(:, p) = points(:, p) + hinge
    end do
  end subroutine put
end program test_wing_gap
