! SPDX-License-Identifier: GPL-3.0-or-later
!> The covariance of heights that were averaged over squares against the sum over all pairs of their pixels.
!>
!> Squares of 3 x 3, of 3 x 1 pixels at distance h = 0.3 and a single one, in two loads; correlated errors of length 1. The
!> formula takes the pixels for normal distributions with their second moments. What it misses first is the fourth cumulant
!> of the difference of two places, 2 (2/3) h^4 at most along an axis, times the largest fourth derivative 3 of the
!> correlation over 4!: 0.0014 for each axis. Between the means alone a variance of 1 is taken for one of 0.89.
program test_wing_bins
  use base_kinds, only: rp
  use diagnosis_wing_bins, only: bin_covariance, bins_t, noise_model_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: H = 0.3_rp, TOLERANCE = 0.0028_rp
  real(rp), parameter :: WHITE = 0.4_rp, FACTOR = 1.5_rp, LOADED = 2.0_rp, UNLOADED = 0.5_rp
  integer, parameter :: N = 4
  type(testkit_t) :: t
  type(bins_t) :: bins
  type(noise_model_t) :: noise
  real(rp) :: pixels(2, 9, N), c(N, N), expected(N, N)
  integer :: i, j

  call t%start(parallel=.false.)
  call make()
  noise = noise_model_t(white=WHITE, length=1.0_rp, factor=FACTOR)
  call bin_covariance(bins, noise, [(i, i=1, N)], c)
  do j = 1, N
    do i = 1, N
      expected(i, j) = pairs(i, j)
    end do
  end do
  call t%check_close('sums over pairs', maxval(abs(c - expected)), 0.0_rp, atol=FACTOR*(LOADED + UNLOADED)*TOLERANCE)
  call t%check_close('symmetric', maxval(abs(c - transpose(c))), 0.0_rp, atol=1.0e-15_rp)
  noise%white = 1
  call bin_covariance(bins, noise, [(i, i=1, N)], c)
  call t%check_close('white errors of a square', c(1, 1), FACTOR*(LOADED + UNLOADED)/9, rtol=1.0e-5_rp)
  call t%check_close('of another square', c(1, 2), 0.0_rp, atol=0.0_rp)
  call t%check_close('the unloaded scan is common', c(1, 4), FACTOR*UNLOADED/9, rtol=1.0e-12_rp)
  call t%finish()

contains

  !> Two squares side by side and a pixel in load 1, the first square again in load 2.
  subroutine make()
    integer :: k, b
    bins%n = N
    bins%load = [1, 1, 1, 2]
    bins%cell = reshape([1, 1, 2, 1, 3, 1, 1, 1], [2, N])
    bins%pixels = [9, 3, 1, 9]
    allocate (bins%site(2, N), bins%spread(2, N))
    bins%loaded = spread(LOADED, 1, N)
    bins%unloaded = spread(UNLOADED, 1, N)
    do k = 1, 9
      pixels(:, k, 1) = H*[real(mod(k - 1, 3), rp), real((k - 1)/3, rp)]
    end do
    pixels(:, :, 2) = pixels(:, :, 1) + spread([3*H, 0.0_rp], 2, 9)
    pixels(:, :, 3) = pixels(:, :, 1) + spread([7*H, H], 2, 9)
    pixels(:, :, 4) = pixels(:, :, 1)
    do b = 1, N
      associate (own => pixels(:, :bins%pixels(b), b))
        bins%site(:, b) = sum(own, 2)/bins%pixels(b)
        bins%spread(:, b) = sum((own - spread(bins%site(:, b), 2, bins%pixels(b)))**2, 2)/bins%pixels(b)
      end associate
    end do
  end subroutine make

  !> The mean covariance of all pairs of pixels of squares a and b.
  real(rp) function pairs(a, b)
    integer, intent(in) :: a, b
    real(rp) :: variance, one
    integer :: k, l
    variance = FACTOR*(UNLOADED + merge(LOADED, 0.0_rp, bins%load(a) == bins%load(b)))
    pairs = 0
    do k = 1, bins%pixels(a)
      do l = 1, bins%pixels(b)
        one = (1 - WHITE)*exp(-0.5_rp*sum((pixels(:, k, a) - pixels(:, l, b))**2))
        if (all(abs(pixels(:, k, a) - pixels(:, l, b)) < 1.0e-9_rp)) one = one + WHITE
        pairs = pairs + variance*one/(bins%pixels(a)*bins%pixels(b))
      end do
    end do
  end function pairs
end program test_wing_bins
