! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds outliers among heights: single heights that differ from all heights around them, because of specks, gaps of the light or
!> wrong fringes. The rest of the program assumes normal errors, which have no outliers.
!>
!> The expected height follows from the heights within two grid lines, without the tested one: from the polynomial of second degree
!> through them, or from a plane if there are few heights. A height that differs by more than FAR sd, and by more than all heights
!> near it, is left out; the heights near it are then tested again. The sd are the declared ones, or larger ones that medians give
!> (Rousseeuw and Croux 1993, DOI 10.1080/01621459.1993.10476408). Normal errors do this to two heights in 10^9.
!>
!> Real features of a surface are kept. Ridges and steps also affect neighbouring heights; an outlier must therefore be ALONE,
!> except for one neighbour if it has all eight. A tip, as under a needle, changes its slope by less than TIP.
module measurement_outliers
  use base_kinds, only: rp
  use base_lapack, only: triangle_of
  use base_sort, only: sort_reals
  use measurement_data, only: measured_load_t, measurement_t
  implicit none
  private
  public :: leave_out_outliers, outliers_t

  real(rp), parameter :: FAR = 6.0_rp, ALONE = 4.0_rp, TIP = 0.1_rp
  real(rp), parameter :: MEDIAN_OF_NORMAL = 0.6744897501960817_rp, QUANTILE_95 = 1.6448536269514722_rp
  integer, parameter :: REACH = 2, WIDTH = 2*REACH + 1, CENTRE = (WIDTH**2 + 1)/2 !< of the window, in grid lines
  integer, parameter :: FEWEST(2) = [6, 10] !< heights for a plane, for second degree
  integer, parameter :: TERMS(2) = [3, 6]
  integer, parameter :: MOST_PASSES = 50

  !> Counts the heights that were left out.
  type :: outliers_t
    integer :: n = 0           !< number of outliers
    integer :: n_tested = 0    !< number of heights with enough heights around them
    real(rp) :: fraction(2) = 0 !< 90 % interval of the fraction of outliers (Wilson 1927, DOI 10.1080/01621459.1927.10502953)
  end type outliers_t

  !> Holds one scan on its grid, with a margin.
  type :: scan_t
    integer, allocatable :: number(:, :)         !< of the height; 0: none
    real(rp), allocatable :: value(:, :), sd(:, :) !< deformation and its declared sd
    real(rp), allocatable :: deviation(:, :)           !< from the expected height, in sd; 0 if there are too few
    real(rp), allocatable :: least(:, :)         !< smallest deviation of an outlier, in sd
  end type scan_t

contains

  !> Removes the outliers among the heights of `m`. The header of this module defines them.
  subroutine leave_out_outliers(m, outliers)
    type(measurement_t), intent(inout) :: m
    type(outliers_t), intent(out) :: outliers
    type(scan_t) :: scans(size(m%loads))
    real(rp) :: full(WIDTH**2), scale
    integer, allocatable :: rest(:)
    integer :: l, k
    call find_weights(spread(.true., 1, WIDTH**2), full)
    do l = 1, size(m%loads)
      if (m%loads(l)%count() > 0) call grid_scan(m, l, full, scans(l))
    end do
    scale = robust_scale(scans)
    do l = 1, size(m%loads)
      if (m%loads(l)%count() == 0) cycle
      outliers%n_tested = outliers%n_tested + count(scans(l)%least > 0)
      call remove_outliers(m, l, full, scale, scans(l))
      associate (node => m%loads(l)%node)
        rest = pack([(k, k=1, size(node, 2))], [(scans(l)%number(node(1, k), node(2, k)) > 0, k=1, size(node, 2))])
      end associate
      outliers%n = outliers%n + m%loads(l)%count() - size(rest)
      call remove_heights(m%loads(l), rest)
    end do
    outliers%fraction = wilson(outliers%n, outliers%n_tested)
  end subroutine leave_out_outliers

  !> Puts the heights of load `l` on their grid and finds the deviation of each.
  subroutine grid_scan(m, l, full, scan)
    type(measurement_t), intent(in) :: m
    integer, intent(in) :: l
    real(rp), intent(in) :: full(:)
    type(scan_t), intent(out) :: scan
    integer :: i, j, k
    associate (x => size(m%x) + REACH, y => size(m%y) + REACH)
      allocate (scan%number(1 - REACH:x, 1 - REACH:y), source=0)
      allocate (scan%value(1 - REACH:x, 1 - REACH:y), scan%sd(1 - REACH:x, 1 - REACH:y), &
                scan%deviation(1 - REACH:x, 1 - REACH:y), scan%least(1 - REACH:x, 1 - REACH:y), source=0.0_rp)
    end associate
    do k = 1, m%loads(l)%count()
      i = m%loads(l)%node(1, k)
      j = m%loads(l)%node(2, k)
      scan%number(i, j) = k
      scan%value(i, j) = m%deformation(l, k)
      scan%sd(i, j) = m%deformation_sigma(l, k)
    end do
    do j = 1, size(m%y)
      do i = 1, size(m%x)
        call find_deviation(m, i, j, full, scan)
      end do
    end do
  end subroutine grid_scan

  !> Finds the deviation of the height at grid point (i, j).
  subroutine find_deviation(m, i, j, full, scan)
    type(measurement_t), intent(in) :: m
    integer, intent(in) :: i, j
    real(rp), intent(in) :: full(:)
    type(scan_t), intent(inout) :: scan
    real(rp) :: weights(WIDTH**2), around(WIDTH**2), sd
    logical :: is_there(WIDTH**2)
    if (i < 1 .or. i > size(m%x) .or. j < 1 .or. j > size(m%y)) return
    scan%deviation(i, j) = 0
    scan%least(i, j) = 0
    if (scan%number(i, j) == 0) return
    is_there = reshape(scan%number(i - REACH:i + REACH, j - REACH:j + REACH) > 0, [WIDTH**2])
    weights = full
    if (.not. all(is_there)) call find_weights(is_there, weights)
    if (.not. any(abs(weights) > 0)) return
    around = reshape(scan%value(i - REACH:i + REACH, j - REACH:j + REACH), [WIDTH**2])
    sd = norm2([scan%sd(i, j), weights*reshape(scan%sd(i - REACH:i + REACH, j - REACH:j + REACH), [WIDTH**2])])
    scan%deviation(i, j) = (scan%value(i, j) - dot_product(weights, around))/sd
    scan%least(i, j) = max(tiny(sd), TIP*distance(m, i, j)/sd)
  end subroutine find_deviation

  !> Finds the weights with which the heights of a window predict the height at its centre; 0 if there are too few heights.
  subroutine find_weights(is_there, weights)
    logical, intent(in) :: is_there(:)
    real(rp), intent(out) :: weights(:)
    real(rp) :: a(WIDTH**2, maxval(TERMS)), r(maxval(TERMS), maxval(TERMS)), c(maxval(TERMS)), x, y
    integer :: degree, n, k
    weights = 0
    n = count(is_there) - merge(1, 0, is_there(CENTRE))
    a = 0
    do k = 1, WIDTH**2
      if (k == CENTRE .or. .not. is_there(k)) cycle
      x = modulo(k - 1, WIDTH) - REACH
      y = (k - 1)/WIDTH - REACH
      a(k, :) = [1.0_rp, x, y, x**2, x*y, y**2]
    end do
    do degree = 2, 1, -1
      if (n < FEWEST(degree)) cycle
      associate (t => TERMS(degree))
        r(:t, :t) = triangle_of(a(:, :t))
        if (.not. minval([(abs(r(k, k)), k=1, t)]) > 1.0e-6_rp*maxval(abs(r(:t, :t)))) cycle
        ! c = (a^T a)^-1 e_1
        c = 0
        do k = 1, t
          c(k) = (merge(1.0_rp, 0.0_rp, k == 1) - dot_product(r(:k - 1, k), c(:k - 1)))/r(k, k)
        end do
        do k = t, 1, -1
          c(k) = (c(k) - dot_product(r(k, k + 1:t), c(k + 1:t)))/r(k, k)
        end do
        weights = matmul(a(:, :t), c(:t))
      end associate
      return
    end do
  end subroutine find_weights

  !> Returns the smallest distance [m] of the grid lines about point (i, j).
  pure real(rp) function distance(m, i, j)
    type(measurement_t), intent(in) :: m
    integer, intent(in) :: i, j
    distance = huge(distance)
    if (i > 1) distance = min(distance, m%x(i) - m%x(i - 1))
    if (i < size(m%x)) distance = min(distance, m%x(i + 1) - m%x(i))
    if (j > 1) distance = min(distance, m%y(j) - m%y(j - 1))
    if (j < size(m%y)) distance = min(distance, m%y(j + 1) - m%y(j))
  end function distance

  !> Removes outliers from the scan, the largest deviation first, until none remains. sd are `scale` times as large as declared.
  subroutine remove_outliers(m, l, full, scale, scan)
    type(measurement_t), intent(in) :: m
    integer, intent(in) :: l
    real(rp), intent(in) :: full(:), scale
    type(scan_t), intent(inout) :: scan
    integer, allocatable :: struck(:, :)
    integer :: pass, i, j, k
    do pass = 1, MOST_PASSES
      allocate (struck(2, 0))
      do k = 1, m%loads(l)%count()
        associate (node => m%loads(l)%node(:, k))
          if (scan%number(node(1), node(2)) == 0) cycle
          if (is_outlier(scan, node(1), node(2), scale)) struck = reshape([struck, node], [2, size(struck, 2) + 1])
        end associate
      end do
      if (size(struck) == 0) return
      do k = 1, size(struck, 2)
        scan%number(struck(1, k), struck(2, k)) = 0
      end do
      do k = 1, size(struck, 2)
        do j = struck(2, k) - REACH, struck(2, k) + REACH
          do i = struck(1, k) - REACH, struck(1, k) + REACH
            call find_deviation(m, i, j, full, scan)
          end do
        end do
      end do
      deallocate (struck)
    end do
  end subroutine remove_outliers

  !> Tells whether the height at grid point (i, j) is an outlier.
  pure logical function is_outlier(scan, i, j, scale)
    type(scan_t), intent(in) :: scan
    integer, intent(in) :: i, j
    real(rp), intent(in) :: scale
    real(rp) :: alike(3, 3), deviation
    deviation = scan%deviation(i, j)
    is_outlier = abs(deviation) > max(FAR*scale, scan%least(i, j))
    if (is_outlier) &
      is_outlier = .not. any(abs(scan%deviation(i - REACH:i + REACH, j - REACH:j + REACH)) > abs(deviation))
    if (.not. is_outlier) return
    alike = sign(1.0_rp, deviation)*scan%deviation(i - 1:i + 1, j - 1:j + 1)
    alike(2, 2) = 0
    ! One in four of the heights around it may be an outlier too.
    is_outlier = count(alike > abs(deviation)/ALONE) <= max(0, (count(scan%number(i - 1:i + 1, j - 1:j + 1) > 0) - 5)/4)
  end function is_outlier

  !> Returns the ratio of the observed sd, from the median of all deviations, to the declared sd; at least 1.
  real(rp) function robust_scale(scans) result(scale)
    type(scan_t), intent(in) :: scans(:)
    real(rp), allocatable :: all(:)
    integer :: l
    allocate (all(0))
    do l = 1, size(scans)
      if (allocated(scans(l)%deviation)) all = [all, abs(pack(scans(l)%deviation, scans(l)%least > 0))]
    end do
    scale = 1
    if (size(all) == 0) return
    call sort_reals(all)
    scale = max(scale, all((size(all) + 1)/2)/MEDIAN_OF_NORMAL)
  end function robust_scale

  !> Keeps only the heights numbered in `rest`.
  subroutine remove_heights(load, rest)
    type(measured_load_t), intent(inout) :: load
    integer, intent(in) :: rest(:)
    load%node = load%node(:, rest)
    load%height = load%height(rest)
    load%sigma = load%sigma(rest)
  end subroutine remove_heights

  !> Returns the 90 % interval of a fraction that was n of `of` (Wilson 1927).
  pure function wilson(n, of) result(fraction)
    integer, intent(in) :: n, of
    real(rp) :: fraction(2), p, middle, half
    fraction = 0
    if (of == 0) return
    associate (z2 => QUANTILE_95**2/of)
      p = real(n, rp)/of
      middle = (p + z2/2)/(1 + z2)
      half = sqrt(z2*(p*(1 - p) + z2/4))/(1 + z2)
    end associate
    fraction = [max(0.0_rp, middle - half), min(1.0_rp, middle + half)]
  end function wilson
end module measurement_outliers
