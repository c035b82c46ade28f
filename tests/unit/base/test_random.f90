! SPDX-License-Identifier: GPL-3.0-or-later
!> Philox against its published vectors; numbers from it lie where they should.
program test_random
  use base_kinds, only: rp, i8
  use base_random, only: philox, unit_real, random_uniforms, random_gaussians, random_stream_t
  use testkit, only: testkit_t
  implicit none
  integer(i8), parameter :: ONES = int(z'FFFFFFFF', i8)
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_vectors()
  call test_uniform()
  call test_gaussian()
  call test_streams()
  call t%finish()

contains

  !> Vectors that come with the Random123 library of the authors.
  subroutine test_vectors()
    call t%check('zeros', all(philox([0_i8, 0_i8], [0_i8, 0_i8, 0_i8, 0_i8]) == &
                              [int(z'6627E8D5', i8), int(z'E169C58D', i8), int(z'BC57AC4C', i8), int(z'9B00DBD8', i8)]))
    call t%check('ones', all(philox([ONES, ONES], [ONES, ONES, ONES, ONES]) == &
                             [int(z'408F276D', i8), int(z'41C83B0E', i8), int(z'A20BC7C6', i8), int(z'6D5451FD', i8)]))
    call t%check('digits of pi', all(philox([int(z'A4093822', i8), int(z'299F31D0', i8)], &
                                   [int(z'243F6A88', i8), int(z'85A308D3', i8), int(z'13198A2E', i8), int(z'03707344', &
                                                                                                              i8)]) == &
                              [int(z'D16CFE09', i8), int(z'94FDCCEB', i8), int(z'5001E420', i8), int(z'24126EA1', i8)]))
  end subroutine test_vectors

  subroutine test_uniform()
    integer, parameter :: N = 100000
    real(rp) :: u(2), sums(5)
    integer(i8) :: i
    call t%check('the smallest words give more than 0', unit_real(0_i8, 0_i8) > 0)
    call t%check('the largest words give less than 1', unit_real(ONES, ONES) < 1)
    sums = 0
    do i = 1, N
      u = random_uniforms(12345_i8, 0_i8, i)
      sums = sums + [u(1), u(2), u(1)**2, u(2)**2, u(1)*u(2)]
    end do
    sums = sums/N
    call t%check_close('mean of the first', sums(1), 0.5_rp, atol=4.0e-3_rp) ! four standard deviations
    call t%check_close('mean of the second', sums(2), 0.5_rp, atol=4.0e-3_rp)
    call t%check_close('mean square', sums(3), 1.0_rp/3, atol=4.0e-3_rp)
    call t%check_close('mean square', sums(4), 1.0_rp/3, atol=4.0e-3_rp)
    call t%check_close('the two are independent', sums(5), 0.25_rp, atol=3.0e-3_rp)
  end subroutine test_uniform

  subroutine test_gaussian()
    integer, parameter :: N = 100000
    real(rp) :: g(2), moments(4), product_mean
    integer(i8) :: i
    moments = 0
    product_mean = 0
    do i = 1, N
      g = random_gaussians(-9876543210_i8, 77_i8, i)
      moments = moments + [sum(g), sum(g**2), sum(g**3), sum(g**4)]
      product_mean = product_mean + g(1)*g(2)
    end do
    moments = moments/(2*N)
    call t%check_close('mean', moments(1), 0.0_rp, atol=9.0e-3_rp) ! four standard deviations
    call t%check_close('variance', moments(2), 1.0_rp, atol=1.3e-2_rp)
    call t%check_close('third moment', moments(3), 0.0_rp, atol=3.5e-2_rp)
    call t%check_close('fourth moment', moments(4), 3.0_rp, atol=9.0e-2_rp)
    call t%check_close('the two are independent', product_mean/N, 0.0_rp, atol=1.3e-2_rp)
  end subroutine test_gaussian

  subroutine test_streams()
    type(random_stream_t) :: a, b, c
    real(rp) :: first(7), second(7), u, v
    integer :: i
    a%seed = 42
    u = a%uniform()
    call a%gaussians(first)
    call t%check('seven numbers take four places', a%position == 5)
    b%seed = 42
    b%position = 1
    call b%gaussians(second)
    call t%check('a stream continues from its position', all(abs(first - second) <= 0))
    b%stream = 1
    b%position = 1
    call b%gaussians(second)
    call t%check('another stream is another sequence', all(abs(first - second) > 0))
    c%seed = 42 + 2_i8**32
    v = c%uniform()
    call t%check('all bits of the seed count', abs(u - v) > 0)
    c = random_stream_t(seed=42, stream=0, position=2_i8**32)
    v = c%uniform()
    call t%check('all bits of the position count', abs(u - v) > 0)
    v = 0
    do i = 1, 100
      v = max(v, abs(a%gaussian()))
    end do
    call t%check('single draws move on', a%position == 105 .and. v > 1.5_rp .and. v < 5)
  end subroutine test_streams
end program test_random
