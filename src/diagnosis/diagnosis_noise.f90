! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimates the errors of heights from the scatter of neighbouring pixels, before any fit.
!>
!> Heights of a smooth shape have small second differences of neighbours along x and along y. Independent errors of variance s^2
!> give them the variance 6 s^2, while errors that are correlated over many pixels hardly contribute. The median absolute second
!> difference, which is robust against outliers and kinks, is 0.6745 sqrt(6) s (Hall, Kay and Titterington 1990, DOI
!> 10.1093/biomet/77.3.521, for differences; Rousseeuw and Croux 1993 for the median).
module diagnosis_noise
  use base_decimal, only: fixed
  use base_kinds, only: rp
  use base_sort, only: sort_reals
  use diagnosis_wing_bins, only: noise_model_t
  use measurement_experiment, only: experiment_t
  implicit none
  private
  public :: noise_estimate_t, estimate_noise, check_declared_variance, assume_noise

  real(rp), parameter :: MEDIAN_OF_NORMAL = 0.6744897501960817_rp
  integer, parameter :: FEWEST = 50 !< differences
  real(rp), parameter :: TOO_LARGE = 1.5_rp !< ratio of declared to true sd, or its inverse, above which a warning is given

  type :: noise_estimate_t
    logical :: is_found = .false.     !< there were enough neighbours
    integer :: n = 0                  !< differences
    real(rp) :: declared = 0          !< [m] root mean square of the declared sd of deformations
    real(rp) :: white = 0             !< [m] sd of the part that is independent from pixel to pixel
    integer :: dof = 0                !< degrees of freedom of its square; 0: not found, the declared errors hold
    type(noise_model_t) :: model      !< what follows
    character(:), allocatable :: warning !< empty: the declared errors are plausible
  end type noise_estimate_t

contains

  !> Estimates the noise from deformations less a smooth model. values(pixels, loads) are residuals of any fit, or measured
  !> deformations [m].
  subroutine estimate_noise(experiment, values, estimate)
    type(experiment_t), intent(in) :: experiment
    real(rp), intent(in) :: values(:, :)
    type(noise_estimate_t), intent(out) :: estimate
    real(rp), allocatable :: differences(:)
    real(rp) :: sum_of_squares, ratio
    integer :: l, k, n, most, n_heights
    estimate%warning = ''
    n_heights = sum(experiment%comparisons%n_heights)
    most = 2*n_heights
    allocate (differences(most))
    n = 0
    sum_of_squares = 0
    do l = 1, size(experiment%comparisons)
      associate (comparison => experiment%comparisons(l))
        sum_of_squares = sum_of_squares + sum(comparison%sigma(:comparison%n_heights)**2)
        do k = 1, comparison%n_heights
          call add(comparison%node(:, k), [1, 0])
          call add(comparison%node(:, k), [0, 1])
        end do
      end associate
    end do
    estimate%n = n
    estimate%is_found = n >= FEWEST
    estimate%declared = sqrt(sum_of_squares/max(1, n_heights))
    estimate%model%length = experiment%measurement%accuracy%correlation_length
    if (.not. estimate%is_found) then
      if (n_heights > 0) estimate%warning = 'too few neighbouring heights to check the declared errors'
      return
    end if
    call sort_reals(differences(:n))
    ratio = differences((n + 1)/2)/(MEDIAN_OF_NORMAL*sqrt(6.0_rp))
    call fill_model(experiment, values, ratio, estimate)
    estimate%warning = warning_of(ratio, experiment%measurement%accuracy%correlation_length > 0)

  contains

    !> Returns the second difference at a grid point along one axis, over its declared sd.
    subroutine add(node, along)
      integer, intent(in) :: node(2), along(2)
      integer :: at(3), before(2), behind(2)
      before = node - along
      behind = node + along
      associate (comparison => experiment%comparisons(l))
        if (any(before < 1) .or. any(behind > shape(comparison%number))) return
        at = [comparison%number(before(1), before(2)), comparison%number(node(1), node(2)), &
              comparison%number(behind(1), behind(2))]
        if (any(at == 0)) return
        n = n + 1
        differences(n) = abs(values(at(1), l) - 2*values(at(2), l) + values(at(3), l))/ &
                         sqrt(sum(comparison%sigma(at)**2*[1, 4, 1])/6)
      end associate
    end subroutine add
  end subroutine estimate_noise

  !> Returns the model of the noise if pixels scatter by `ratio` times the declared sd.
  subroutine fill_model(experiment, values, ratio, estimate)
    type(experiment_t), intent(in) :: experiment
    real(rp), intent(in) :: values(:, :), ratio
    type(noise_estimate_t), intent(inout) :: estimate
    estimate%white = ratio*estimate%declared
    estimate%dof = effective_dof(estimate%n, size(experiment%comparisons), unloaded_fraction(experiment))
    if (estimate%model%length > 0) then
      estimate%model%white = min(1.0_rp, ratio**2)
      ! Pixels do not show errors that neighbours have in common: the data tell how large these are.
      estimate%model%factor = max(1.0_rp, ratio**2)
    else
      estimate%model%factor = ratio**2
      call separate_scan_variances(experiment, values, estimate)
    end if
  end subroutine fill_model

  !> Returns what is wrong with declared errors that must be multiplied by `ratio`; empty if nothing is wrong.
  pure function warning_of(ratio, is_correlated) result(warning)
    real(rp), intent(in) :: ratio
    logical, intent(in) :: is_correlated
    character(:), allocatable :: warning
    warning = ''
    if (ratio > TOO_LARGE) then
      warning = 'neighbouring heights scatter more than the declared errors allow'
    else if (ratio < 1/TOO_LARGE .and. .not. is_correlated) then
      warning = 'neighbouring heights scatter less than the declared errors: they are too large, or correlated'
    end if
  end function warning_of

  !> Separates the errors of the unloaded scan from those of the loaded ones. The unloaded scan is in every deformation but
  !> cancels in differences of two loads. These give the errors of loaded scans; the rest of all errors is that of the unloaded
  !> scan. Each load is in one pair. Where there are too few pairs both kinds of scans have the same ratio of true to declared
  !> variance.
  subroutine separate_scan_variances(experiment, values, estimate)
    type(experiment_t), intent(in) :: experiment
    real(rp), intent(in) :: values(:, :)
    type(noise_estimate_t), intent(inout) :: estimate
    real(rp), parameter :: LEAST = 0.01_rp ! of the ratio of loaded scans
    real(rp), allocatable :: differences(:)
    real(rp) :: loaded, fraction
    integer :: l, k, n
    fraction = unloaded_fraction(experiment)
    allocate (differences(2*sum(experiment%comparisons%n_heights)))
    n = 0
    do l = 1, size(experiment%comparisons) - 1, 2
      do k = 1, experiment%comparisons(l)%n_heights
        call add([1, 0])
        call add([0, 1])
      end do
    end do
    if (n < FEWEST .or. .not. fraction > 0) return
    call sort_reals(differences(:n))
    loaded = (differences((n + 1)/2)/(MEDIAN_OF_NORMAL*sqrt(6.0_rp)))**2
    estimate%model%unloaded = max(LEAST, (estimate%model%factor - loaded*(1 - fraction))/(loaded*fraction))
    estimate%model%factor = loaded
    estimate%dof = effective_dof(n, 1, 0.0_rp)

  contains

    !> Returns the second difference of the difference of two loads at height k of load l, over its declared sd.
    subroutine add(along)
      integer, intent(in) :: along(2)
      integer :: at(2), first(3), second(3), i
      real(rp) :: variance(3)
      associate (one => experiment%comparisons(l), other => experiment%comparisons(l + 1), m => experiment%measurement)
        do i = 1, 3
          at = one%node(:, k) + (i - 2)*along
          if (any(at < 1) .or. any(at > shape(one%number))) return
          first(i) = one%number(at(1), at(2))
          second(i) = other%number(at(1), at(2))
          if (first(i) == 0 .or. second(i) == 0) return
          variance(i) = one%sigma(first(i))**2 + other%sigma(second(i))**2 - 2*m%unloaded_sigma(at(1), at(2))**2
        end do
        if (.not. minval(variance) > 0) return
        n = n + 1
        differences(n) = abs(dot_product([1, -2, 1], values(first, l) - values(second, l + 1)))/ &
                         sqrt(dot_product([1, 4, 1], variance)/6)
      end associate
    end subroutine add
  end subroutine separate_scan_variances

  !> Returns the degrees of freedom of a variance that is found from the median of n second differences in as many loads. For
  !> independent differences the median is as good as 0.37 n squares (its efficiency). Neighbouring and crossing differences have
  !> heights in common, which correlates the events that determine the median as 1 : 2.2 in the sum over all. The same differences
  !> of two loads have the unloaded scan in common: its fraction s of the variance correlates these events by about 0.6 s^2.
  pure integer function effective_dof(n, loads, fraction) result(dof)
    integer, intent(in) :: n, loads
    real(rp), intent(in) :: fraction
    dof = max(1, int(0.37_rp*n/(2.2_rp*(1 + 0.6_rp*(loads - 1)*fraction**2))))
  end function effective_dof

  !> Returns the fraction of the unloaded scan in the declared variance of deformations.
  real(rp) function unloaded_fraction(experiment) result(fraction)
    type(experiment_t), intent(in) :: experiment
    real(rp) :: whole
    integer :: l, k
    fraction = 0
    whole = 0
    do l = 1, size(experiment%comparisons)
      associate (comparison => experiment%comparisons(l))
        do k = 1, comparison%n_heights
          fraction = fraction + experiment%measurement%unloaded_sigma(comparison%node(1, k), comparison%node(2, k))**2
        end do
        whole = whole + sum(comparison%sigma(:comparison%n_heights)**2)
      end associate
    end do
    fraction = fraction/max(whole, tiny(whole))
  end function unloaded_fraction

  !> Makes the model of the noise before there are heights. It is not known then how much of correlated errors is independent from
  !> pixel to pixel. They count as independent and as correlated errors of the declared sd at the same time, which no mix of both
  !> exceeds (w 1 + (1 - w) C <= 1 + C as matrices, for every fraction w and covariance C).
  subroutine assume_noise(experiment, estimate)
    type(experiment_t), intent(in) :: experiment
    type(noise_estimate_t), intent(out) :: estimate
    estimate%warning = ''
    estimate%model%length = experiment%measurement%accuracy%correlation_length
    if (.not. estimate%model%length > 0) return
    estimate%model%white = 0.5_rp
    estimate%model%factor = 2
  end subroutine assume_noise

  !> Compares the declared errors with what no test uses, whose variance is `scale` times that of `estimate%model`, as the fit has
  !> left it. The scatter of neighbours tells the size of independent errors of heights, but not that of errors that they share,
  !> nor that of other data. Adds a warning if there is none yet.
  subroutine check_declared_variance(estimate, scale)
    type(noise_estimate_t), intent(inout) :: estimate
    real(rp), intent(in) :: scale
    real(rp) :: ratio
    if (estimate%warning /= '' .or. estimate%is_found .and. .not. estimate%model%length > 0) return
    ratio = sqrt(estimate%model%factor*scale)
    if (ratio > TOO_LARGE) then
      estimate%warning = 'the data differ from the model '//fixed(ratio, 1)//' times as much as the declared errors allow: '// &
                         'these are too small, or the model is wrong in more than a cause'
    else if (ratio < 1/TOO_LARGE .and. estimate%is_found) then
      estimate%warning = 'heights differ less from smooth shapes than the declared errors allow: these are too large'
    else if (ratio < 1/TOO_LARGE) then
      estimate%warning = 'the data differ less from the model than the declared errors allow: these are too large'
    end if
  end subroutine check_declared_variance
end module diagnosis_noise
