! SPDX-License-Identifier: GPL-3.0-or-later
!> What a Gaussian posterior leaves of lift, drag, power and their ratios, against closed forms.
program test_flight_means
  use base_kinds, only: i8, rp
  use diagnosis_flight_means, only: compare_means, draw_directions, find_directions, flight_comparison_t, means_along, means_of, &
                                    N_COMPARED, N_DRAWS, N_MEANS
  use measurement_flight, only: N_COMPONENTS
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: FAR = 1.0e9_rp, Z_95 = 1.6448536269514722_rp
  !> Four sd of the quantile of 5 % of N_DRAWS normal numbers, in sd: sqrt(0.05 0.95/N)/0.1031, the density of the normal
  !> distribution there.
  real(rp), parameter :: TOLERANCE = 4*sqrt(0.05_rp*0.95_rp/N_DRAWS)/0.1031_rp
  integer(i8), parameter :: SEED = 1
  type(testkit_t) :: t
  call t%start(parallel=.false.)
  call check_means()
  call check_directions()
  call check_parabolas()
  call check_linear()
  call check_unknown_sign()
  call check_bounds()
  call t%finish()

contains

  subroutine check_means()
    real(rp) :: components(N_COMPONENTS)
    components = [1.0_rp, 2.0_rp, 3.0_rp, 4.0_rp, 5.0_rp, 6.0_rp, 7.0_rp]
    call t%check_close('lift along z, drag along the wind, power', norm2(means_of(components, [0.6_rp, 0.8_rp, 0.0_rp]) - &
                                                                           [3.0_rp, 2.2_rp, 7.0_rp]), 0.0_rp, atol=1.0e-14_rp)
  end subroutine check_means

  !> All directions together are the covariance; the first ones have the largest variances in the units of the parameters.
  subroutine check_directions()
    real(rp), parameter :: FACTOR(3, 3) = reshape([3.0_rp, 1.0_rp, 0.5_rp, 0.0_rp, 2.0_rp, -1.0_rp, 0.0_rp, 0.0_rp, 0.2_rp], [3, 3])
    real(rp) :: covariance(3, 3), share
    real(rp), allocatable :: directions(:, :)
    covariance = matmul(FACTOR, transpose(FACTOR))
    call find_directions(covariance, [1.0_rp, 2.0_rp, 0.1_rp], 3, directions, share)
    call t%check_close('the directions make the covariance', maxval(abs(matmul(directions, transpose(directions)) - covariance)), &
                       0.0_rp, atol=1.0e-13_rp)
    call t%check_close('and have all of it', share, 1.0_rp, rtol=1.0e-14_rp)
    covariance = 0
    covariance(1, 1) = 4
    covariance(2, 2) = 9
    covariance(3, 3) = 1.0e-30_rp
    call find_directions(covariance, [1.0_rp, 3.0_rp, 1.0_rp], 1, directions, share)
    call t%check_close('the first is the largest in its unit, one sd long', abs(directions(1, 1)), 2.0_rp, rtol=1.0e-14_rp)
    call t%check_close('with its share of the variance', share, 0.8_rp, rtol=1.0e-12_rp)
    call find_directions(covariance, [1.0_rp, 1.0_rp, 1.0_rp], 3, directions, share)
    call t%check('what is known exactly is no direction', size(directions, 2) == 2)
    call t%check_close('another unit, another order', abs(directions(2, 1)), 3.0_rp, rtol=1.0e-14_rp)
  end subroutine check_directions

  !> Two flights on both sides show a parabola, whatever their distances are; one shows a line.
  subroutine check_parabolas()
    real(rp), parameter :: Z(3, 2) = reshape([0.7_rp, -1.2_rp, 0.4_rp, -2.0_rp, 0.3_rp, 1.5_rp], [3, 2])
    real(rp), parameter :: STEP(2, 3) = reshape([1.0_rp, 0.5_rp, 1.0_rp, 0.0_rp, 0.0_rp, 0.8_rp], [2, 3])
    real(rp), dimension(N_MEANS) :: centre, wanted
    real(rp), dimension(N_MEANS, 3) :: above, below
    real(rp) :: means(N_MEANS, 2)
    integer :: k
    centre = along([0.0_rp, 0.0_rp, 0.0_rp])
    do k = 1, 3
      above(:, k) = along([0.0_rp, 0.0_rp, 0.0_rp] + merge(STEP(1, k), 0.0_rp, [1, 2, 3] == k))
      below(:, k) = along([0.0_rp, 0.0_rp, 0.0_rp] - merge(STEP(2, k), 0.0_rp, [1, 2, 3] == k))
    end do
    means = means_along(Z, centre, above, below, STEP)
    do k = 1, 2
      wanted = along(Z(:, k))
      call t%check_close('the means are those of the parabola', norm2(means(:, k) - wanted), 0.0_rp, atol=1.0e-13_rp)
    end do
  end subroutine check_parabolas

  !> A parabola in the first direction and a line in the others.
  pure function along(z) result(means)
    real(rp), intent(in) :: z(3)
    real(rp) :: means(N_MEANS)
    means = [1.0_rp, 2.0_rp, 3.0_rp] + [0.3_rp, -0.1_rp, 0.2_rp]*z(1) + [0.05_rp, 0.2_rp, -0.1_rp]*z(1)**2 + &
            [0.1_rp, 0.4_rp, 0.0_rp]*z(2) - [0.2_rp, 0.1_rp, 0.3_rp]*z(3)
  end function along

  !> A linear response to correlated parameters. The interval of a mean m with the variance s^2 is m +- 1.645 s. The ends r of that
  !> of x/y solve (r y - x)^2 = 1.645^2 (s_x^2 - 2 r s_xy + r^2 s_y^2) (Fieller), as long as y hardly ever has another sign.
  subroutine check_linear()
    real(rp), parameter :: RESPONSE(N_MEANS, 2) = reshape([0.3_rp, -0.15_rp, 0.8_rp, 0.2_rp, 0.1_rp, -1.0_rp], [N_MEANS, 2])
    real(rp), parameter :: MEAN(N_MEANS) = [2.0_rp, 1.0_rp, 5.0_rp], REFERENCE(N_MEANS) = [2.5_rp, 1.1_rp, 6.0_rp]
    real(rp), parameter :: COVARIANCE(2, 2) = reshape([1.0_rp, 0.6_rp, 0.6_rp, 2.0_rp], [2, 2])
    type(flight_comparison_t) :: c
    real(rp), allocatable :: directions(:, :), z(:, :)
    real(rp) :: s(N_MEANS, N_MEANS), share, ends(2), sd
    integer :: i
    call find_directions(COVARIANCE, [1.0_rp, 1.0_rp], 2, directions, share)
    call draw_directions([0.0_rp, 0.0_rp], directions, [-FAR, -FAR], [FAR, FAR], SEED, z)
    call t%check('all draws count without bounds', size(z, 2) == N_DRAWS)
    call compare_means(REFERENCE, MEAN, means_along(z, MEAN, spread(MEAN, 2, 2) + matmul(RESPONSE, directions), &
                                                    spread(MEAN, 2, 2) - matmul(RESPONSE, directions), &
                                                    reshape([1.0_rp, 1.0_rp, 1.0_rp, 1.0_rp], [2, 2])), c)
    s = matmul(matmul(RESPONSE, COVARIANCE), transpose(RESPONSE))
    call t%check('everything is known', c%is_known .and. all(c%is_determined))
    call t%check_close('L/D of the reference', c%baseline(4), 2.5_rp/1.1_rp, rtol=1.0e-14_rp)
    call t%check_close('L/P of what was found', c%extended(5), 0.4_rp, rtol=1.0e-14_rp)
    do i = 1, N_MEANS
      call t%check_close('the lower end', c%interval(1, i), MEAN(i) - Z_95*sqrt(s(i, i)), atol=TOLERANCE*sqrt(s(i, i)))
      call t%check_close('the upper end', c%interval(2, i), MEAN(i) + Z_95*sqrt(s(i, i)), atol=TOLERANCE*sqrt(s(i, i)))
    end do
    do i = N_MEANS + 1, N_COMPARED
      associate (y => MEAN(i - 2), xx => s(1, 1), xy => s(1, i - 2), yy => s(i - 2, i - 2))
        ends = fieller(MEAN(1), y, xx, xy, yy)
        sd = (ends(2) - ends(1))/(2*Z_95)
        ! The upper quantile of a skewed ratio scatters more than that of a normal number: by up to twice.
        call t%check_close('the lower end of a ratio', c%interval(1, i), ends(1), atol=2*TOLERANCE*sd)
        call t%check_close('the upper end of a ratio', c%interval(2, i), ends(2), atol=2*TOLERANCE*sd)
      end associate
    end do
    call t%check('the interval of L/D is skewed', ends_are_skewed(c%interval(:, 4), c%extended(4)))
  end subroutine check_linear

  pure function fieller(x, y, xx, xy, yy) result(ends)
    real(rp), intent(in) :: x, y, xx, xy, yy
    real(rp) :: ends(2), a, b, c
    a = y**2 - Z_95**2*yy
    b = x*y - Z_95**2*xy
    c = x**2 - Z_95**2*xx
    ends = (b + [-1, 1]*sqrt(b**2 - a*c))/a
  end function fieller

  pure logical function ends_are_skewed(ends, best)
    real(rp), intent(in) :: ends(2), best
    ends_are_skewed = ends(2) - best > 1.1_rp*(best - ends(1))
  end function ends_are_skewed

  !> Hovering: the mean drag may be of either sign, and L/D has no interval. All else has.
  subroutine check_unknown_sign()
    real(rp), parameter :: MEAN(N_MEANS) = [2.0_rp, 0.1_rp, 5.0_rp], SD(N_MEANS) = [0.1_rp, 0.2_rp, 0.1_rp]
    type(flight_comparison_t) :: c
    real(rp), allocatable :: z(:, :)
    call draw_directions([0.0_rp], reshape([1.0_rp], [1, 1]), [-FAR], [FAR], SEED, z)
    call compare_means(MEAN, MEAN, means_along(z, MEAN, reshape(MEAN + SD, [N_MEANS, 1]), reshape(MEAN - SD, [N_MEANS, 1]), &
                                               reshape([1.0_rp, 1.0_rp], [2, 1])), c)
    call t%check('L/D is not determined, all else is', all(c%is_determined .eqv. [.true., .true., .true., .false., .true.]))
  end subroutine check_unknown_sign

  !> At a bound the posterior is one half of a normal distribution, whose quantiles of 5 and 95 % are at 0.0627 and 1.9600 sd.
  subroutine check_bounds()
    real(rp), parameter :: MEAN(N_MEANS) = [1.0_rp, 1.0_rp, 1.0_rp]
    type(flight_comparison_t) :: c
    real(rp), allocatable :: z(:, :)
    call draw_directions([0.0_rp], reshape([0.5_rp], [1, 1]), [0.0_rp], [FAR], SEED, z)
    call t%check('no draw is beyond the bound', all(z >= 0))
    call t%check('half of them are not', abs(size(z, 2) - N_DRAWS/2) < 4*sqrt(N_DRAWS/4.0_rp))
    call compare_means(MEAN, MEAN, means_along(z, MEAN, reshape(MEAN + 1, [N_MEANS, 1]), reshape(MEAN, [N_MEANS, 1]), &
                                               reshape([1.0_rp, 0.0_rp], [2, 1])), c)
    ! The density of half a normal distribution is twice that of the whole, 0.796 and 0.1169 there, and half of the draws are left.
    call t%check_close('the lower end', c%interval(1, 1), 1.0627_rp, atol=4*sqrt(0.05_rp*0.95_rp/(N_DRAWS/2))/0.796_rp)
    call t%check_close('the upper end', c%interval(2, 1), 2.9600_rp, atol=4*sqrt(0.05_rp*0.95_rp/(N_DRAWS/2))/0.1169_rp)
  end subroutine check_bounds
end program test_flight_means
