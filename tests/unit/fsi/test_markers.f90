! SPDX-License-Identifier: GPL-3.0-or-later
!> Markers cover a sheet: none too close, no gap too large, on its edges too; what they pass on is the transpose of what
!> they take.
program test_markers
  use base_kinds, only: rp
  use fsi_markers, only: markers_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  real(rp), parameter :: ROUND_OFF = 1.0e-12_rp
  integer :: k

  call test%start(parallel=.false.)
  do k = 1, 3
    call check_sheet('flat plate', k, 0.0_rp)
    call check_sheet('curved plate', k, 1.5_rp)
  end do
  call test%finish()

contains

  !> A plate of 1 x 0.4 of 20 x 8 squares cut in two, rolled up by `angle` along its length, with markers 0.2/k apart.
  subroutine check_sheet(name, k, angle)
    character(*), intent(in) :: name
    integer, intent(in) :: k
    real(rp), intent(in) :: angle
    integer, parameter :: NX = 20, NY = 8
    type(markers_t) :: markers, again
    real(rp) :: points(3, (NX + 1)*(NY + 1)), spacing, s
    integer :: triangles(3, 2*NX*NY), i, j, p, t
    real(rp), allocatable :: at_markers(:, :), forces(:, :), gathered(:, :)
    t = 0
    do j = 0, NY
      do i = 0, NX
        p = 1 + i + (NX + 1)*j
        s = real(i, rp)/NX
        points(:, p) = [s, 0.4_rp*j/NY, 0.0_rp]
        if (angle > 0) points([1, 3], p) = [sin(angle*s), 1 - cos(angle*s)]/angle
        if (i == NX .or. j == NY) cycle
        triangles(:, t + 1) = [p, p + 1, p + NX + 2]
        triangles(:, t + 2) = [p, p + NX + 2, p + NX + 1]
        t = t + 2
      end do
    end do
    spacing = 0.2_rp/k
    call markers%init(points, triangles, spacing, .false.)
    call test%check(name//': there are markers inside and on edges', count(markers%is_edge) > 8 .and. .not. all(markers%is_edge))
    call test%check_below(name//': no two are closer than 3/4 spacings', 0.75_rp, markers%least*(1 + ROUND_OFF))
    call test%check_below(name//': no point is farther than 3/4 spacings from one', markers%gap, 0.75_rp)
    call test%check_below(name//': weights sum to 1', maxval(abs(sum(markers%weights, 1) - 1)), ROUND_OFF)
    call test%check(name//': weights are not negative', minval(markers%weights) >= -ROUND_OFF)
    allocate (at_markers(3, markers%n), gathered(3, markers%n), forces(3, size(points, 2)), source=0.0_rp)
    do i = 1, markers%n
      at_markers(:, i) = [sin(1.0_rp*i), cos(3.0_rp*i), 0.1_rp*i]
    end do
    call markers%spread(at_markers, forces)
    call markers%positions(points, gathered)
    call test%check_close(name//': spreading is the transpose of gathering', sum(forces*points), sum(at_markers*gathered), &
                          rtol=ROUND_OFF)
    call test%check_below(name//': the forces are the same in sum', maxval(abs(sum(forces, 2) - sum(at_markers, 2))), &
                          ROUND_OFF*sum(abs(at_markers)))
    call again%init(points, triangles, spacing, .false.)
    call test%check(name//': the same again', all(again%nodes == markers%nodes))
  end subroutine check_sheet
end program test_markers
