! SPDX-License-Identifier: GPL-3.0-or-later
!> Averages heights over the squares of a lattice, so that a few hundred numbers hold what thousands of pixels say about smooth
!> shapes. It also gives the covariance of the errors of these averages.
!>
!> Errors of one height are white with the fraction `white` of the variance, and correlated as exp(-(r/length)^2/2) with the rest of
!> the variance. Averaging divides the white part by the number of pixels, and reduces the rest where it differs within a square.
!> Let s_a and s_b [m] be the spreads of the pixels of squares a and b about their means along an axis. Then the mean of
!> exp(-(r/length)^2/2) over all pairs of pixels is, up to fourth moments and for each axis, length/c exp(-(r/c)^2/2), c^2 =
!> length^2 + s_a^2 + s_b^2, with r between the means. (This is exact for normally distributed pixels, and therefore always positive
!> definite.) The error of the unloaded scan is common to all loads.
module diagnosis_wing_bins
  use base_kinds, only: rp
  use measurement_experiment, only: experiment_t
  implicit none
  private
  public :: bins_t, make_bins, bin_distortions, bin_rows, bin_covariance, noise_model_t, default_bin_size

  integer, parameter, public :: N_DISTORTIONS = 4 !< smooth errors of a scan

  !> Errors of one height.
  type :: noise_model_t
    real(rp) :: white = 1      !< fraction of the declared variance that is independent from pixel to pixel
    real(rp) :: length = 0     !< [m] of the correlation of the rest
    real(rp) :: factor = 1     !< of the declared variance
    real(rp) :: unloaded = 1   !< further factor on that of the unloaded scan
  contains
    procedure :: with_independent => noise_with_independent
  end type noise_model_t

  !> The observations of all loads: averages, then scalar observations as they are.
  type :: bins_t
    integer :: n = 0
    real(rp) :: size = 0                       !< [m] of a square
    integer, allocatable :: first(:), count(:) !< (loads) observations of a load
    integer, allocatable :: load(:)            !< (n)
    integer, allocatable :: cell(:, :)         !< (2, n) of the lattice; (0, k): scalar observation k
    integer, allocatable :: pixels(:)          !< (n) in it
    real(rp), allocatable :: site(:, :)       !< (2, n) [m] mean of its pixels
    real(rp), allocatable :: spread(:, :)      !< (2, n) [m2] mean square distance of its pixels from there, along x and y
    real(rp), allocatable :: loaded(:)         !< (n) mean declared variance of the loaded heights
    real(rp), allocatable :: unloaded(:)       !< (n) the same of the unloaded ones
    integer, allocatable :: of_pixel(:, :)     !< (pixels of a load at most, loads) observation that holds it
  end type bins_t

contains

  !> Returns the model in which the fraction `white` of the variance is independent, and the variance of independent errors is that
  !> of this model.
  pure type(noise_model_t) function noise_with_independent(self, white) result(noise)
    class(noise_model_t), intent(in) :: self
    real(rp), intent(in) :: white
    noise = self
    noise%white = white
    noise%factor = self%factor*(self%white/white) ! no rounding if nothing changes
  end function noise_with_independent

  !> Returns the size [m] of squares with which there are at most `most` observations in all.
  real(rp) function default_bin_size(experiment, most) result(size_of_bin)
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: most
    type(bins_t) :: bins
    size_of_bin = 0.02_rp*experiment%model%size
    do
      call make_bins(experiment, size_of_bin, bins)
      if (bins%n <= most) exit
      size_of_bin = 1.1_rp*size_of_bin
      if (size_of_bin > experiment%model%size) exit
    end do
  end function default_bin_size

  !> Averages the heights of each load over squares of this size [m], and keeps its scalar observations as they are.
  subroutine make_bins(experiment, size_of_bin, bins)
    type(experiment_t), intent(in) :: experiment
    real(rp), intent(in) :: size_of_bin
    type(bins_t), intent(out) :: bins
    integer, allocatable :: at(:, :)
    integer :: l, k, i, j, n, nx, ny, most, cell(2)
    bins%size = size_of_bin
    associate (m => experiment%measurement, comparisons => experiment%comparisons)
      most = sum(comparisons%n)
      nx = 1
      ny = 1
      if (size(m%x) > 0) nx = 1 + int((m%x(size(m%x)) - m%x(1))/size_of_bin)
      if (size(m%y) > 0) ny = 1 + int((m%y(size(m%y)) - m%y(1))/size_of_bin)
      allocate (at(nx, ny), bins%first(size(comparisons)), bins%count(size(comparisons)), bins%load(most), &
                bins%cell(2, most), bins%pixels(most))
      allocate (bins%site(2, most), bins%spread(2, most), bins%loaded(most), bins%unloaded(most), source=0.0_rp)
      allocate (bins%of_pixel(max(1, maxval(comparisons%n)), size(comparisons)), source=0)
      n = 0
      do l = 1, size(comparisons)
        bins%first(l) = n + 1
        at = 0
        do k = 1, comparisons(l)%n_heights
          i = comparisons(l)%node(1, k)
          j = comparisons(l)%node(2, k)
          cell = 1 + int([m%x(i) - m%x(1), m%y(j) - m%y(1)]/size_of_bin)
          if (at(cell(1), cell(2)) == 0) then
            n = n + 1
            at(cell(1), cell(2)) = n
            bins%load(n) = l
            bins%cell(:, n) = cell
            bins%pixels(n) = 0
          end if
          associate (b => at(cell(1), cell(2)))
            bins%of_pixel(k, l) = b
            bins%pixels(b) = bins%pixels(b) + 1
            bins%site(:, b) = bins%site(:, b) + [m%x(i), m%y(j)]
            bins%spread(:, b) = bins%spread(:, b) + [m%x(i), m%y(j)]**2
            bins%unloaded(b) = bins%unloaded(b) + m%unloaded_sigma(i, j)**2
            bins%loaded(b) = bins%loaded(b) + comparisons(l)%sigma(k)**2 - m%unloaded_sigma(i, j)**2
          end associate
        end do
        do k = comparisons(l)%n_heights + 1, comparisons(l)%n
          n = n + 1
          bins%of_pixel(k, l) = n
          bins%load(n) = l
          bins%cell(:, n) = [0, k]
          bins%pixels(n) = 1
          bins%loaded(n) = comparisons(l)%sigma(k)**2
        end do
        bins%count(l) = n - bins%first(l) + 1
      end do
    end associate
    bins%n = n
    do k = 1, n
      bins%site(:, k) = bins%site(:, k)/bins%pixels(k)
      bins%spread(:, k) = max(0.0_rp, bins%spread(:, k)/bins%pixels(k) - bins%site(:, k)**2)
      bins%loaded(k) = bins%loaded(k)/bins%pixels(k)
      bins%unloaded(k) = bins%unloaded(k)/bins%pixels(k)
    end do
  end subroutine make_bins

  !> Returns averages(count) of the values of all pixels of load l.
  pure subroutine bin_rows(bins, l, values, averages)
    type(bins_t), intent(in) :: bins
    integer, intent(in) :: l
    real(rp), intent(in) :: values(:)
    real(rp), intent(out) :: averages(:)
    integer :: k, b
    averages = 0
    do k = 1, size(values)
      b = bins%of_pixel(k, l)
      averages(b - bins%first(l) + 1) = averages(b - bins%first(l) + 1) + values(k)/bins%pixels(b)
    end do
  end subroutine bin_rows

  !> Returns the covariance c(:, :) of the observations `rows`.
  subroutine bin_covariance(bins, noise, rows, c)
    type(bins_t), intent(in) :: bins
    type(noise_model_t), intent(in) :: noise
    integer, intent(in) :: rows(:)
    real(rp), intent(out) :: c(:, :)
    integer :: i, j, a, b
    real(rp) :: near, white_part, c2(2)
    do j = 1, size(rows)
      b = rows(j)
      do i = 1, size(rows)
        a = rows(i)
        c(i, j) = 0
        if (bins%cell(1, a) == 0 .or. bins%cell(1, b) == 0) then ! scalar observations
          if (a == b) c(i, j) = bins%loaded(a)
          cycle
        end if
        near = 0
        if (noise%length > 0) then
          c2 = noise%length**2 + bins%spread(:, a) + bins%spread(:, b)
          near = (1 - noise%white)*noise%length**2/sqrt(product(c2))* &
                 exp(-0.5_rp*sum((bins%site(:, a) - bins%site(:, b))**2/c2))
        end if
        white_part = 0
        if (all(bins%cell(:, a) == bins%cell(:, b))) white_part = noise%white/max(bins%pixels(a), bins%pixels(b))
        c(i, j) = noise%unloaded*sqrt(bins%unloaded(a)*bins%unloaded(b))*(near + white_part)
        if (bins%load(a) == bins%load(b)) c(i, j) = c(i, j) + sqrt(bins%loaded(a)*bins%loaded(b))*(near + white_part)
        c(i, j) = noise%factor*c(i, j)
        ! Rounding must not make a smooth covariance indefinite.
        if (a == b) c(i, j) = c(i, j)*(1 + 1.0e-6_rp)
      end do
    end do
  end subroutine bin_covariance

  !> Returns smooth errors of the scan of load l besides its tilt and height, patterns(count, N_DISTORTIONS). A bent rig or a wing
  !> that keeps a part of an earlier deformation cause such errors. They are polynomials of second degree, and of third degree along
  !> the wing, from its root [m] over its size [m].
  subroutine bin_distortions(bins, l, root, size_of_wing, patterns)
    type(bins_t), intent(in) :: bins
    integer, intent(in) :: l
    real(rp), intent(in) :: root(:), size_of_wing
    real(rp), intent(out) :: patterns(:, :)
    real(rp) :: x(bins%count(l)), y(bins%count(l))
    associate (first => bins%first(l), last => bins%first(l) + bins%count(l) - 1)
      x = (bins%site(1, first:last) - root(1))/size_of_wing
      y = (bins%site(2, first:last) - root(2))/size_of_wing
      x = merge(x, 0.0_rp, bins%cell(1, first:last) > 0) ! 0 for scalar observations
      y = merge(y, 0.0_rp, bins%cell(1, first:last) > 0)
    end associate
    patterns(:, 1) = x**2
    patterns(:, 2) = x*y
    patterns(:, 3) = y**2
    patterns(:, 4) = x**3
  end subroutine bin_distortions
end module diagnosis_wing_bins
