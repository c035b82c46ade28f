! SPDX-License-Identifier: GPL-3.0-or-later
!> The rotation between two sets of points, and the response of markers that have turned.
program test_rigid_fit
  use base_kinds, only: rp
  use fsi_green, only: green_t
  use fsi_marker_response, only: marker_response_t
  use fsi_rigid_fit, only: fit_rotation
  use fsi_rotation, only: cross
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  integer, parameter :: N = 12
  real(rp) :: flat(3, N), line(3, N), moved(3, N), rotation(3, 3), turn(3, 3), left
  integer :: i

  call test%start(parallel=.false.)
  do i = 1, N
    flat(:, i) = [0.2_rp*mod(i - 1, 4), 0.2_rp*((i - 1)/4), 0.0_rp]
    line(:, i) = [0.1_rp*i, 0.0_rp, 0.0_rp]
  end do
  turn = turned([0.5_rp, -0.3_rp, 0.7_rp])
  moved = matmul(turn, flat) + spread([3.0_rp, -1.0_rp, 0.5_rp], 2, N)
  call fit_rotation(flat, moved, rotation, left)
  call test%check_below('a plane that has turned: R is found', maxval(abs(rotation - turn)), 1.0e-10_rp)
  call test%check_below('and nothing is left', left, 1.0e-10_rp)
  moved(:, 1) = moved(:, 1) + 0.05_rp*turn(:, 3)
  call fit_rotation(flat, moved, rotation, left)
  call test%check('a point that has bent out of it is left', left > 0.02_rp .and. left < 0.05_rp)
  moved = matmul(turned([0.0_rp, 0.4_rp, 0.0_rp]), line)
  call fit_rotation(line, moved, rotation, left)
  call test%check_below('a line: R turns across it alone', &
                        maxval(abs(rotation - turned([0.0_rp, 0.4_rp, 0.0_rp]))), 1.0e-10_rp)
  call check_response()
  call test%finish()

contains

  !> The rotation by a vector, as a series: far from how it is computed.
  function turned(w) result(r)
    real(rp), intent(in) :: w(3)
    real(rp) :: r(3, 3), term(3, 3)
    integer :: k, j
    r = 0
    do k = 1, 3
      r(k, k) = 1
    end do
    term = r
    do j = 1, 30
      do k = 1, 3
        term(:, k) = cross(w, term(:, k))/j
      end do
      r = r + term
    end do
  end function turned

  !> A response that has turned with its markers is that made for them.
  subroutine check_response()
    type(green_t) :: green
    type(marker_response_t) :: old, new
    real(rp) :: v(3, N), f(3, N, 2)
    logical :: has_factor
    integer :: i
    call green%init(20.0_rp, 2.0_rp, .false.)
    call old%init(N, is_2d=.false.)
    call new%init(N, is_2d=.false.)
    call old%build(green, flat, has_factor)
    call new%build(green, matmul(turn, flat), has_factor)
    do i = 1, N
      v(:, i) = [sin(1.0_rp*i), cos(2.0_rp*i), 0.3_rp*i]
    end do
    call old%turn(turn)
    call old%solve(v, f(:, :, 1))
    call new%solve(v, f(:, :, 2))
    call test%check_below('a response that has turned is that of the turned markers', &
                          maxval(abs(f(:, :, 1) - f(:, :, 2)))/maxval(abs(f)), 1.0e-9_rp)
    call old%build(green, flat, has_factor)
    call old%solve(v, f(:, :, 1))
    call test%check('made anew, it has not turned', maxval(abs(f(:, :, 1) - f(:, :, 2))) > 0.01_rp*maxval(abs(f)))
  end subroutine check_response
end program test_rigid_fit
