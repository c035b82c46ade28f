! SPDX-License-Identifier: GPL-3.0-or-later
!> A group of ranks that shares the response of markers finds the forces that one rank finds alone.
program test_shared_response
  use base_kinds, only: rp
  use fsi_green, only: green_t
  use fsi_marker_response, only: marker_response_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  integer, parameter :: NX = 14, NY = 5, N = NX*NY
  real(rp), parameter :: RADIUS = 20.0_rp, SPACING = 4.2_rp/RADIUS !< as of markers two grid spacings apart
  real(rp) :: x(3, N)
  integer :: i

  call test%start(parallel=.true.)
  do i = 1, N
    x(:, i) = SPACING*[real(mod(i - 1, NX), rp), real((i - 1)/NX, rp), 0.2_rp*sin(0.5_rp*i)]
  end do
  call compare(.false.)
  call compare(.true.)
  call find_crowd()
  call test%finish()

contains

  subroutine compare(is_2d)
    logical, intent(in) :: is_2d
    type(green_t) :: green
    type(marker_response_t) :: alone, shared
    real(rp) :: v(3, N), f(3, N, 2), error(1), turn(3, 3), sites(3, N)
    logical :: has_factor
    integer :: k
    call green%init(RADIUS, 2*NX*SPACING, is_2d)
    sites = x
    if (is_2d) sites(3, :) = [(SPACING*i, i=1, N)] ! a section lies in the plane of its first and its last axis
    call alone%init(N, is_2d)
    call shared%init(N, is_2d, test%world)
    call alone%build(green, sites, has_factor)
    call shared%build(green, sites, has_factor)
    call test%check('markers that are apart have a response', has_factor)
    turn = reshape([0.8_rp, 0.6_rp, 0.0_rp, -0.6_rp, 0.8_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp], [3, 3])
    call alone%turn(turn)
    call shared%turn(turn)
    error = 0
    if (test%world%is_root) then
      do k = 1, 3
        v = reshape([(sin(real(k*i, rp)), i=1, 3*N)], [3, N])
        call alone%solve(v, f(:, :, 1))
        call shared%solve(v, f(:, :, 2))
        error(1) = max(error(1), maxval(abs(f(:, :, 1) - f(:, :, 2)))/maxval(abs(f(:, :, 1))))
      end do
      call shared%release()
    else
      call shared%serve()
    end if
    call test%world%max_reals(error)
    ! The condition of M is some hundreds, in the plane, where the sheet is long, some ten thousands.
    call test%check_below('forces are those that one rank finds', error(1), 1.0e-10_rp)
  end subroutine compare

  !> Markers that are far too close: all ranks know that their motion does not determine their forces.
  subroutine find_crowd()
    type(green_t) :: green
    type(marker_response_t) :: shared
    real(rp) :: sites(3, N)
    logical :: has_factor
    sites = 0.05_rp*x
    call green%init(RADIUS, 2*NX*SPACING, .false.)
    call shared%init(N, .false., test%world)
    call shared%build(green, sites, has_factor)
    call test%check('markers that are too close do not have one, on any rank', .not. has_factor)
  end subroutine find_crowd
end program test_shared_response
