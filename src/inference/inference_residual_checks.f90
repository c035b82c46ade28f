! SPDX-License-Identifier: GPL-3.0-or-later
!> Plain questions to the residuals of the baseline, each with a statistic, its p if the baseline is true, and a
!> sentence.
!>
!> Residuals are whitened. With g the whitened response to each load, a = g r/(g g) is by how much of itself a
!> response is too large, with the sd 1/|g|; its slopes against the level, the order and so on are tested by weighted
!> regression. The fitted parameters are not accounted for, which makes p a little too large.
module inference_residual_checks
  use base_kinds, only: rp
  use base_text, only: number_text
  use inference_distributions, only: log_chi2_tail
  use inference_simulator, only: labels_t
  implicit none
  private
  public :: residual_check_t, check_residuals

  type :: residual_check_t
    character(:), allocatable :: name
    real(rp) :: statistic = 0
    real(rp) :: p = 1
    character(:), allocatable :: sentence
  end type residual_check_t

contains

  !> residuals(n) and responses(n), whitened with a noise of which `scale` is the estimated over the declared variance.
  subroutine check_residuals(labels, residuals, responses, n_fitted, scale, checks)
    type(labels_t), intent(in) :: labels
    real(rp), intent(in) :: residuals(:), responses(:), scale
    integer, intent(in) :: n_fitted
    type(residual_check_t), allocatable, intent(out) :: checks(:)
    real(rp), allocatable :: excess(:), weight(:)
    integer :: l, n
    n = size(labels%fold)
    allocate (checks(0), excess(n), weight(n))
    call check_chi2(residuals, n_fitted, checks)
    call check_neighbours(labels, residuals, checks)
    do l = 1, n
      weight(l) = sum(responses**2, mask=labels%surface == l)/scale
      excess(l) = -sum(responses*residuals, mask=labels%surface == l)/scale/max(weight(l), tiny(1.0_rp))
    end do
    call ask_slope('level', abs(labels%level), 'with the size of the force', spread(.true., 1, n))
    call ask_slope('sign', sign(1.0_rp, labels%level), 'with the sign of the force', spread(.true., 1, n))
    call ask_slope('order', labels%order, 'with the order of the measurements', labels%order > 0)
    call ask_slope('hold', log(max(labels%hold, 1.0e-3_rp)), 'with the time of holding', labels%hold >= 0)
    call ask_slope('root moment', labels%moment, 'with the moment about the root', spread(.true., 1, n))
    call check_influence(labels, residuals, scale, checks)
    call check_outliers(residuals/sqrt(scale), checks)
    call check_replicates(labels, residuals, scale, checks)

  contains

    !> Whether the response is larger or smaller than computed in proportion to x.
    subroutine ask_slope(name, x, words, is_known)
      character(*), intent(in) :: name, words
      real(rp), intent(in) :: x(:)
      logical, intent(in) :: is_known(:)
      real(rp) :: w(size(x)), mean, about, slope, square
      w = merge(weight, 0.0_rp, is_known)
      if (.not. all(is_known) .or. .not. sum(w) > 0) return
      mean = sum(w*x)/sum(w)
      about = sum(w*excess)/sum(w)
      square = sum(w*(x - mean)**2)
      if (.not. square > 1.0e-12_rp*sum(w*x**2)) return
      slope = sum(w*(x - mean)*(excess - about))/sqrt(square)
      call append(checks, name, slope, exp(log_chi2_tail(slope**2, 1)), &
                  'measured deflections grow '//trim(merge('more', 'less', slope > 0))//' than computed ones '//words, &
                  'deflections do not depart from the model '//words)
    end subroutine ask_slope

  end subroutine check_residuals

  !> Adds a question; the sentence is `yes` if p < 0.01.
  subroutine append(checks, name, statistic, p, yes, no)
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    character(*), intent(in) :: name, yes, no
    real(rp), intent(in) :: statistic, p
    type(residual_check_t), allocatable :: longer(:)
    integer :: i
    allocate (longer(size(checks) + 1))
    do i = 1, size(checks)
      longer(i) = checks(i)
    end do
    longer(i)%name = name
    longer(i)%statistic = statistic
    longer(i)%p = p
    longer(i)%sentence = no
    if (p < 0.01_rp) longer(i)%sentence = yes
    call move_alloc(longer, checks)
  end subroutine append

  subroutine check_chi2(residuals, n_fitted, checks)
    real(rp), intent(in) :: residuals(:)
    integer, intent(in) :: n_fitted
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    real(rp) :: square, p
    integer :: dof
    dof = max(1, size(residuals) - n_fitted)
    square = sum(residuals**2)
    p = exp(log_chi2_tail(square, dof))
    call append(checks, 'chi2', square/dof, 2*min(p, 1 - p), 'all differences together are '// &
                trim(merge('larger ', 'smaller', square > dof))//' than the declared errors allow', &
                'all differences together are as large as the declared errors')
  end subroutine check_chi2

  !> Moran's I of nearest neighbours within surfaces (Moran 1950, DOI 10.1093/biomet/37.1-2.17).
  subroutine check_neighbours(labels, residuals, checks)
    type(labels_t), intent(in) :: labels
    real(rp), intent(in) :: residuals(:)
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    real(rp) :: product, square, z, distance, nearest
    integer :: i, k, at, n
    product = 0
    square = 0
    n = 0
    do i = 1, size(residuals)
      nearest = huge(nearest)
      at = 0
      do k = 1, size(residuals)
        if (k == i .or. labels%surface(k) /= labels%surface(i)) cycle
        distance = sum((labels%place(:, i) - labels%place(:, k))**2)
        if (distance < nearest) at = k
        nearest = min(nearest, distance)
      end do
      if (at == 0) cycle
      n = n + 1
      product = product + residuals(i)*residuals(at)
      square = square + residuals(i)**2
    end do
    if (n == 0 .or. .not. square > 0) return
    ! Mutual neighbours count twice: at most double variance.
    z = product/square*sqrt(0.5_rp*n)
    call append(checks, 'neighbours', product/square, exp(log_chi2_tail(max(0.0_rp, z)**2, 1)), &
                'differences at neighbouring places have the same sign: they are a shape, not noise', &
                'differences at neighbouring places are independent')
  end subroutine check_neighbours

  !> The surface that fits worst.
  subroutine check_influence(labels, residuals, scale, checks)
    type(labels_t), intent(in) :: labels
    real(rp), intent(in) :: residuals(:), scale
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    real(rp) :: log_p, least
    integer :: l, n, worst
    least = 1
    worst = 1
    do l = 1, size(labels%fold)
      n = count(labels%surface == l)
      if (n == 0) cycle
      log_p = log_chi2_tail(sum(residuals**2, mask=labels%surface == l)/scale, n)
      if (log_p < least) worst = l
      least = min(least, log_p)
    end do
    call append(checks, 'single load', real(worst, rp), min(1.0_rp, size(labels%fold)*exp(least)), &
                'load number '//number_text(worst)//' fits worse than all others', 'no single load stands out')
  end subroutine check_influence

  !> Heavy tails: more residuals beyond three sd than normal errors have, as a Poisson number.
  subroutine check_outliers(residuals, checks)
    real(rp), intent(in) :: residuals(:)
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    real(rp), parameter :: BEYOND_THREE = 2.6997960632601866e-3_rp
    integer :: n
    n = count(abs(residuals) > 3)
    ! P(Poisson(m) >= n) is the tail of chi^2 with 2 n degrees of freedom below 2 m.
    associate (below => 2*BEYOND_THREE*size(residuals))
      call append(checks, 'outliers', real(n, rp)/size(residuals), &
                  merge(1 - exp(log_chi2_tail(below, max(2, 2*n))), 1.0_rp, n > 0), &
                'there are more outliers than normal errors have', 'there are no more outliers than normal errors have')
    end associate
  end subroutine check_outliers

  !> Pure error: repeats of the same load against each other.
  subroutine check_replicates(labels, residuals, scale, checks)
    type(labels_t), intent(in) :: labels
    real(rp), intent(in) :: residuals(:), scale
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    real(rp), allocatable :: one(:), other(:)
    real(rp) :: square
    integer :: l, n
    square = 0
    n = 0
    do l = 1, size(labels%fold)
      if (labels%replicate(l) == l) cycle
      one = pack(residuals, labels%surface == l)
      other = pack(residuals, labels%surface == labels%replicate(l))
      if (size(one) /= size(other)) cycle
      square = square + sum((one - other)**2)/(2*scale)
      n = n + size(one)
    end do
    if (n == 0) return
    call append(checks, 'repeats', square/n, exp(log_chi2_tail(square, n)), &
                'repeats of the same load differ more than their errors: something changed between them', &
                'repeats of the same load agree within their errors')
  end subroutine check_replicates
end module inference_residual_checks
