! SPDX-License-Identifier: GPL-3.0-or-later
!> The Green tensor of markers: its value at one point, how it conditions lattices of markers, and the added mass that it gives to a
!> strip. docs/theory/thin-wings-derivation.md has these numbers.
program test_green
  use base_constants, only: PI
  use base_kinds, only: rp
  use base_lapack, only: symmetric_eigen, factorise, solve_factorised
  use fsi_green, only: green_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  real(rp), parameter :: RADIUS = 2*PI/3 !< K for a grid spacing of 1

  call test%start(parallel=.false.)
  call check_lattices()
  call check_strips()
  call test%finish()

contains

  !> The ratio of the largest to the smallest eigenvalue of M for 12 x 12 markers. Markers that are 2 grid spacings apart are felt
  !> one by one. A square lattice of 1.5 spacings has forces that alternate along its diagonal with a wave number beyond K: the flow
  !> does not feel them.
  subroutine check_lattices()
    integer, parameter :: ALONG = 12, N = ALONG**2
    real(rp), parameter :: SPACINGS(5) = [1.5_rp, 1.75_rp, 2.0_rp, 2.5_rp, 3.0_rp]
    type(green_t) :: green
    real(rp), allocatable :: m(:, :), values(:)
    real(rp) :: ratio(5), x(3, N), own(3, 3)
    integer :: i, j, k
    allocate (m(3*N, 3*N), values(3*N))
    call green%init(RADIUS, 3*ALONG*sqrt(2.0_rp), .false.)
    own = green%at([0.0_rp, 0.0_rp, 0.0_rp])
    call test%check_close('the velocity at the force itself', own(1, 1), 8*RADIUS**3/(45*PI**2), rtol=1.0e-12_rp)
    do k = 1, 5
      do i = 1, N
        x(:, i) = SPACINGS(k)*[real(mod(i - 1, ALONG), rp), real((i - 1)/ALONG, rp), 0.0_rp]
      end do
      do j = 1, N
        do i = 1, N
          m(3*i - 2:3*i, 3*j - 2:3*j) = green%at(x(:, i) - x(:, j))
        end do
      end do
      call symmetric_eigen(m, values)
      ratio(k) = values(3*N)/values(1)
    end do
    print '(a,5es10.2)', 'ratios of eigenvalues', ratio
    ! The table of the tensor has an error of 1e-6 of its value at 0, which the smallest eigenvalue of the closest lattice is about.
    call test%check('forces of the lattice of 1.5 spacings are not determined', ratio(1) > 1.0e6_rp)
    call test%check_close('1.75 spacings condition M badly', ratio(2), 5.7e3_rp, rtol=0.1_rp)
    call test%check_close('two spacings condition M well', ratio(3), 33.3_rp, rtol=1.0e-2_rp)
    call test%check_close('so do 2.5', ratio(4), 36.1_rp, rtol=1.0e-2_rp)
    call test%check_close('and three', ratio(5), 4.1_rp, rtol=1.0e-2_rp)
  end subroutine check_lattices

  !> A strip of unit chord that moves normal to itself in a box of 6 chords: the sum of the elements of M^-1 over pi/4, and the
  !> margin in cells with which the exact added mass would be this. K is that of the truncation, 2/3 (n/2 - 1) waves in the box.
  subroutine check_strips()
    integer, parameter :: POINTS(6) = [8, 12, 16, 24, 32, 64], BOX = 6
    real(rp), parameter :: OF_FLUSI(6) = [1.774_rp, 1.480_rp, 1.353_rp, 1.229_rp, 1.170_rp, 1.083_rp]
    type(green_t) :: green
    real(rp), allocatable :: m(:, :), force(:)
    real(rp) :: mass(6), g(3, 3)
    logical :: is_positive
    integer :: i, j, k, n
    do k = 1, 6
      n = POINTS(k)/2 + 1
      allocate (m(n, n), force(n))
      call green%init(2*PI/BOX*2*(BOX*POINTS(k)/2.0_rp - 1)/3, 1.0_rp, .true.)
      do j = 1, n
        do i = 1, n
          g = green%at([0.0_rp, 2*(i - j)/real(POINTS(k), rp), 0.0_rp])
          m(i, j) = g(3, 3)
        end do
      end do
      call factorise(m, is_positive)
      force = 1
      call solve_factorised(m, force)
      mass(k) = sum(force)/(PI/4)
      deallocate (m, force)
    end do
    ! Three decimals are printed there. The flow of flusi differs by the window's error, 1e-6, and by images of the order (K L)^-2.
    do k = 1, 6
      call test%check_close('the added mass of a strip is that of its first step in flusi', mass(k), OF_FLUSI(k), atol=6.0e-4_rp)
    end do
    ! A plate that is wider by a number of cells that does not depend on the grid.
    call test%check_below('margins of strips are 1.3 cells', maxval(abs((sqrt(mass) - 1)*POINTS/2 - 1.31_rp)), 0.03_rp)
  end subroutine check_strips
end program test_green
