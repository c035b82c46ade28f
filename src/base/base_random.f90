! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes random numbers as a function of a key and a counter: Philox4x32-10 of Salmon, Moraes, Dror and Shaw, SC'11, DOI
!> 10.1145/2063384.2063405.
!>
!> There is no state that must be seeded or shared: the n-th number of stream s of seed k is the same on any rank, in any order and
!> after any restart. 32-bit words are held in 64-bit integers.
module base_random
  use base_constants, only: TWO_PI
  use base_kinds, only: rp, i8
  implicit none
  private
  public :: philox, unit_real, random_uniforms, random_gaussians, fill_gaussians, random_stream_t

  integer(i8), parameter :: WORD = int(z'FFFFFFFF', i8)
  integer(i8), parameter :: MULTIPLIER(2) = [int(z'D2511F53', i8), int(z'CD9E8D57', i8)]
  integer(i8), parameter :: WEYL(2) = [int(z'9E3779B9', i8), int(z'BB67AE85', i8)]
  integer, parameter :: ROUNDS = 10

  !> A sequence of random numbers. Its whole state are three integers, to be stored in a checkpoint.
  type :: random_stream_t
    integer(i8) :: seed = 0     !< one seed for a run
    integer(i8) :: stream = 0   !< streams of one seed are independent
    integer(i8) :: position = 0 !< draws so far
  contains
    procedure :: uniform => stream_uniform
    procedure :: gaussian => stream_gaussian
    procedure :: gaussians => stream_gaussians
  end type random_stream_t

contains

  !> Returns four random 32-bit words from a key of two and a counter of four 32-bit words.
  pure function philox(key, counter) result(words)
    integer(i8), intent(in) :: key(2), counter(4)
    integer(i8) :: words(4)
    integer(i8) :: w1, w2, w3, w4, k1, k2, high1, high2, low1, low2 ! scalars stay in registers
    integer :: round
    w1 = counter(1)
    w2 = counter(2)
    w3 = counter(3)
    w4 = counter(4)
    k1 = key(1)
    k2 = key(2)
    do round = 1, ROUNDS
      call multiply(MULTIPLIER(1), w1, high1, low1)
      call multiply(MULTIPLIER(2), w3, high2, low2)
      w1 = ieor(ieor(high2, w2), k1)
      w2 = low2
      w3 = ieor(ieor(high1, w4), k2)
      w4 = low1
      k1 = iand(k1 + WEYL(1), WORD)
      k2 = iand(k2 + WEYL(2), WORD)
    end do
    words = [w1, w2, w3, w4]
  end function philox

  !> Computes both halves of the 64-bit product of two 32-bit words, of which a >= 2^31: (a - 2^32) b stays within 63 bits and a
  !> sign, and b is added to its upper half.
  pure subroutine multiply(a, b, high, low)
    integer(i8), intent(in) :: a, b
    integer(i8), intent(out) :: high, low
    integer(i8) :: product
    product = (a - (WORD + 1))*b
    high = shifta(product, 32) + b
    low = iand(product, WORD)
  end subroutine multiply

  !> Returns a real number strictly between 0 and 1 from two 32-bit words: the middle of one of 2**52 equal intervals.
  pure elemental real(rp) function unit_real(high, low)
    integer(i8), intent(in) :: high, low
    unit_real = (real(ior(shiftl(high, 20), shiftr(low, 12)), rp) + 0.5_rp)*2.0_rp**(-52)
  end function unit_real

  !> Returns two independent numbers, uniform in (0, 1), at a place of a stream.
  pure function random_uniforms(seed, stream, position) result(u)
    integer(i8), intent(in) :: seed, stream, position
    real(rp) :: u(2)
    integer(i8) :: words(4)
    words = philox([iand(seed, WORD), shiftr(seed, 32)], [iand(position, WORD), shiftr(position, 32), &
                                                          iand(stream, WORD), shiftr(stream, 32)])
    u(1) = unit_real(words(1), words(2))
    u(2) = unit_real(words(3), words(4))
  end function random_uniforms

  !> Returns two independent numbers of mean 0 and variance 1 at a place of a stream (Box and Muller).
  pure function random_gaussians(seed, stream, position) result(g)
    integer(i8), intent(in) :: seed, stream, position
    real(rp) :: g(2), radius, angle
    g = random_uniforms(seed, stream, position)
    radius = sqrt(-2*log(g(1)))
    angle = TWO_PI*g(2)
    g(1) = radius*cos(angle)
    g(2) = radius*sin(angle)
  end function random_gaussians

  !> Returns independent numbers of mean 0 and variance 1, two from each place of a stream beginning at `position`:
  !> the same as those of `random_gaussians`.
  pure subroutine fill_gaussians(seed, stream, position, values)
    integer(i8), intent(in) :: seed, stream, position
    real(rp), intent(out), contiguous :: values(:)
    real(rp) :: pair(2)
    integer :: i
    do i = 1, size(values), 2
      pair = random_gaussians(seed, stream, position + i/2)
      values(i) = pair(1)
      if (i < size(values)) values(i + 1) = pair(2)
    end do
  end subroutine fill_gaussians

  !> Returns the next number, uniform in (0, 1).
  real(rp) function stream_uniform(self) result(u)
    class(random_stream_t), intent(inout) :: self
    real(rp) :: pair(2)
    ! The second number is not kept, because it would be a state that the position does not determine.
    pair = random_uniforms(self%seed, self%stream, self%position)
    u = pair(1)
    self%position = self%position + 1
  end function stream_uniform

  !> Returns the next number, of mean 0 and variance 1.
  real(rp) function stream_gaussian(self) result(g)
    class(random_stream_t), intent(inout) :: self
    real(rp) :: pair(2)
    pair = random_gaussians(self%seed, self%stream, self%position)
    g = pair(1)
    self%position = self%position + 1
  end function stream_gaussian

  !> Fills an array with numbers of mean 0 and variance 1, two from each position.
  subroutine stream_gaussians(self, values)
    class(random_stream_t), intent(inout) :: self
    real(rp), intent(out), contiguous :: values(:)
    call fill_gaussians(self%seed, self%stream, self%position, values)
    self%position = self%position + (size(values) + 1)/2
  end subroutine stream_gaussians
end module base_random
