! SPDX-License-Identifier: GPL-3.0-or-later
!> Compares the flight of the baseline with that of the extended wing by their means over the beat: lift L, drag D, power P, L/D and
!> L/P, with the 90 % intervals that the fit leaves.
!>
!> The coordinates q of the extended wing have a Gaussian posterior with the covariance C = A A^T. The directions A are eigenvectors
!> times the square roots of the eigenvalues. Draws q + A z, with independent normal z, become draws of (L, D, P) by the response of
!> the flight, and of each ratio by division. Intervals are quantiles of these draws. This covers ratios whose denominator is
!> uncertain, for which the delta method fails. The baseline is a reference without an error: what would have flown without a
!> diagnosis.
module diagnosis_flight_means
  use base_errors, only: require
  use base_kinds, only: i8, rp
  use base_lapack, only: symmetric_eigen
  use base_random, only: fill_gaussians
  use base_sort, only: sort_reals
  use measurement_flight, only: COMPONENT_POWER, N_COMPONENTS
  implicit none
  private
  public :: compare_means, draw_directions, find_directions, flight_comparison_t, means_along, means_of

  integer, parameter, public :: N_MEANS = 3, N_COMPARED = 5 !< lift, drag, power; lift/drag and lift/power follow them
  integer, parameter :: LIFT = 1, DRAG = 2, POWER = 3
  integer, parameter :: DENOMINATOR(N_MEANS + 1:N_COMPARED) = [DRAG, POWER] !< of lift
  character(12), parameter, public :: COMPARED(N_COMPARED) = [character(12) :: 'lift', 'drag', 'power', 'lift/drag', 'lift/power']
  integer, parameter, public :: N_DRAWS = 10000 !< a quantile of 5 % then errs by 2 % of an sd
  real(rp), parameter :: TAIL = 0.05_rp         !< of the draws, beyond each end of an interval
  real(rp), parameter :: NEGLIGIBLE = 1.0e-12_rp !< share of the variance of a direction that does not count
  real(rp), parameter :: LEAST = 1.0e-9_rp      !< of a denominator, against overflow of a ratio
  integer(i8), parameter :: STREAM = 22

  !> Numbers are in SI units, of a section per metre.
  type :: flight_comparison_t
    logical :: is_known = .false.
    character(:), allocatable :: reason        !< why it is not known although it was asked for
    character(:), allocatable :: path          !< of the case
    logical :: is_section = .false.
    logical :: is_flown = .false.              !< both wings were flown; otherwise forces are those of the flights of the diagnosis
    integer :: n_directions = 0
    real(rp) :: share = 1                      !< of the variance of the parameters that these directions have
    real(rp) :: baseline(N_COMPARED) = 0, extended(N_COMPARED) = 0
    real(rp) :: interval(2, N_COMPARED) = 0    !< 90 %, of the extended wing
    logical :: is_determined(N_COMPARED) = .false. !< there is an interval: the sign of the denominator is known
  end type flight_comparison_t

contains

  !> Returns the mean lift, drag and power of the components of forces, torques and power averaged over the beat. Lift points along
  !> z, drag along the unit vector `along`.
  pure function means_of(components, along) result(means)
    real(rp), intent(in) :: components(N_COMPONENTS), along(3)
    real(rp) :: means(N_MEANS)
    means(LIFT) = components(3)
    means(DRAG) = dot_product(components(:3), along)
    means(POWER) = components(COMPONENT_POWER)
  end function means_of

  !> Finds the directions(n, :) of a covariance(n, n) of parameters, the one with the largest variance first, at most `most` of
  !> them. Each is one sd long. The variances are compared in the units(n) of the parameters. `share` is the part of the sum of all
  !> variances in these units that the directions have.
  subroutine find_directions(covariance, units, most, directions, share)
    real(rp), intent(in) :: covariance(:, :), units(:)
    integer, intent(in) :: most
    real(rp), allocatable, intent(out) :: directions(:, :)
    real(rp), intent(out) :: share
    real(rp) :: vectors(size(units), size(units)), values(size(units))
    integer :: n, k, i
    n = size(units)
    share = 1
    allocate (directions(n, 0))
    if (n == 0) return
    do k = 1, n
      vectors(:, k) = covariance(:, k)/(units*units(k))
    end do
    call symmetric_eigen(vectors, values)
    values = max(0.0_rp, values)
    k = min(most, count(values > NEGLIGIBLE*values(n)))
    deallocate (directions)
    allocate (directions(n, k))
    do i = 1, k
      directions(:, i) = units*vectors(:, n + 1 - i)*sqrt(values(n + 1 - i))
    end do
    if (values(n) > 0) share = sum(values(n + 1 - k:))/sum(values)
  end subroutine find_directions

  !> Draws z(directions, :) of independent normal numbers for which q + directions z lies between `lower` and `upper`: N_DRAWS of
  !> them, without those that lie outside. The same seed gives the same draws.
  subroutine draw_directions(q, directions, lower, upper, seed, z)
    real(rp), intent(in) :: q(:), directions(:, :), lower(:), upper(:)
    integer(i8), intent(in) :: seed
    real(rp), allocatable, intent(out) :: z(:, :)
    real(rp) :: one(size(directions, 2)), point(size(q)), all(size(directions, 2), N_DRAWS)
    integer :: i, n
    n = 0
    do i = 1, N_DRAWS
      call fill_gaussians(seed, STREAM, int(i - 1, i8)*(size(one)/2 + 1), one)
      point = q + matmul(directions, one)
      if (any(point < lower .or. point > upper)) cycle
      n = n + 1
      all(:, n) = one
    end do
    z = all(:, :n)
  end subroutine draw_directions

  !> Returns the means for the draws z(directions, :) from those at z = 0 and those of two flights for each direction k, above(:, k)
  !> at z_k = step(1, k) and below(:, k) at z_k = -step(2, k): the parabola through the three along each direction. A step of 0 has
  !> no flight; then it is a straight line.
  pure function means_along(z, centre, above, below, step) result(means)
    real(rp), intent(in) :: z(:, :), centre(N_MEANS), above(:, :), below(:, :), step(:, :)
    real(rp) :: means(N_MEANS, size(z, 2))
    real(rp) :: slope(N_MEANS), curvature(N_MEANS)
    integer :: i, k
    means = spread(centre, 2, size(z, 2))
    do k = 1, size(z, 1)
      associate (h => step(1, k), l => step(2, k), up => above(:, k) - centre, down => below(:, k) - centre)
        slope = 0
        curvature = 0
        if (h > 0 .and. l > 0) then
          slope = (up*l**2 - down*h**2)/(h*l*(h + l))
          curvature = 2*(up*l + down*h)/(h*l*(h + l))
        else if (h > 0) then
          slope = up/h
        else if (l > 0) then
          slope = -down/l
        end if
      end associate
      do i = 1, size(z, 2)
        means(:, i) = means(:, i) + slope*z(k, i) + curvature/2*z(k, i)**2
      end do
    end do
  end function means_along

  !> Takes the means of the baseline, of the extended wing, and of draws(N_MEANS, :) from its posterior into the comparison. A ratio
  !> whose denominator has another sign than its mean in more than TAIL of the draws has no interval.
  subroutine compare_means(baseline, extended, draws, comparison)
    real(rp), intent(in) :: baseline(N_MEANS), extended(N_MEANS), draws(:, :)
    type(flight_comparison_t), intent(inout) :: comparison
    real(rp) :: values(size(draws, 2))
    integer :: i
    call require(size(draws, 2) > 0, 'compare_means: there must be draws')
    comparison%baseline = with_ratios(baseline)
    comparison%extended = with_ratios(extended)
    do i = 1, N_MEANS
      comparison%is_determined(i) = .true.
      values = draws(i, :)
      comparison%interval(:, i) = interval_of(values)
    end do
    do i = N_MEANS + 1, N_COMPARED
      associate (below => draws(DENOMINATOR(i), :), best => extended(DENOMINATOR(i)))
        comparison%is_determined(i) = count(sign(1.0_rp, below)*best <= 0) <= TAIL*size(values) .and. &
                                      abs(baseline(DENOMINATOR(i))) > 0
        if (.not. comparison%is_determined(i)) cycle
        values = draws(LIFT, :)/sign(max(abs(below), LEAST*abs(best)), below)
        comparison%interval(:, i) = interval_of(values)
      end associate
    end do
    comparison%is_known = .true.
  end subroutine compare_means

  !> Returns lift, drag, power, lift/drag and lift/power; 0 for a ratio with the denominator 0.
  pure function with_ratios(means) result(values)
    real(rp), intent(in) :: means(N_MEANS)
    real(rp) :: values(N_COMPARED)
    integer :: i
    values = 0
    values(:N_MEANS) = means
    do i = N_MEANS + 1, N_COMPARED
      if (abs(means(DENOMINATOR(i))) > 0) values(i) = means(LIFT)/means(DENOMINATOR(i))
    end do
  end function with_ratios

  !> Returns the ends between which nine in ten of the values are. Sorts the values.
  function interval_of(values) result(ends)
    real(rp), intent(inout) :: values(:)
    real(rp) :: ends(2)
    call sort_reals(values)
    ends = [quantile(values, TAIL), quantile(values, 1 - TAIL)]
  end function interval_of

  !> Returns the quantile of sorted values, between its neighbours by a straight line.
  pure real(rp) function quantile(sorted, p)
    real(rp), intent(in) :: sorted(:), p
    real(rp) :: place
    integer :: i
    place = max(1.0_rp, min(real(size(sorted), rp), p*size(sorted) + 0.5_rp))
    i = min(int(place), size(sorted) - 1)
    if (i < 1) then
      quantile = sorted(1)
    else
      quantile = sorted(i) + (place - i)*(sorted(i + 1) - sorted(i))
    end if
  end function quantile
end module diagnosis_flight_means
