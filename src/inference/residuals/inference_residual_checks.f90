! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks the residuals of the baseline. Each check has a statistic, its p if the baseline is true, and a sentence.
!>
!> Residuals are whitened. A check may ask whether responses to loads are too large in proportion to x, for instance the level or
!> the order. It uses the direction of such a change: computed response times x, whitened, without the part that the baseline and
!> one factor for all responses imitate. The residuals along it have the sd 1, whatever errors loads have in common. (The measured
!> response contains the noise: where the baseline imitates all but noise, direction and residuals are the same numbers, and their
!> product is not normally distributed.) The other checks do not account for the fitted parameters, which makes p a little too
!> large. `combined_log_p` combines the p of all checks that take part in a verdict.
module inference_residual_checks
  use base_decimal, only: fixed
  use base_kinds, only: rp
  use base_text, only: number_text
  use inference_design, only: design_t
  use inference_distributions, only: log_chi2_tail, log_f_tail
  use inference_simulator, only: labels_t
  implicit none
  private
  public :: combined_log_p, most_significant, make_check, residual_check_t, check_residuals

  type :: residual_check_t
    character(:), allocatable :: name
    real(rp) :: statistic = 0
    real(rp) :: log_p = 0
    logical :: takes_part = .true.        !< a small p speaks against the model
    character(:), allocatable :: sentence
    real(rp) :: interval(2) = 0           !< 90 %, of the statistic; 0, 0: none
  contains
    procedure :: p => check_p
  end type residual_check_t

contains

  !> Checks residuals(n), whitened as the design does, and responses(n) that the fit computes, not whitened. `scale` is the
  !> variance of the noise over that of the noise model. The variance of the noise model is known from other data, such as the
  !> scatter of pixels, with `noise_dof` > 0 degrees of freedom; huge: it is that of the declared errors, which hold.
  subroutine check_residuals(labels, design, residuals, responses, n_fitted, scale, noise_dof, checks)
    type(labels_t), intent(in) :: labels
    type(design_t), intent(in) :: design
    real(rp), intent(in) :: residuals(:), responses(:), scale
    integer, intent(in) :: n_fitted, noise_dof
    type(residual_check_t), allocatable, intent(out) :: checks(:)
    logical :: is_load(size(labels%level))
    allocate (checks(0))
    call check_chi2(residuals, n_fitted, noise_dof, checks)
    call check_neighbours(labels, residuals, checks)
    is_load = abs(labels%level) > 0
    call check_slope('level', abs(labels%level), 'with the size of the force', is_load)
    call check_slope('sign', sign(1.0_rp, labels%level), 'with the sign of the force', is_load)
    call check_slope('order', labels%order, 'with the order of the measurements', labels%order > 0)
    call check_slope('hold', log(max(labels%hold, 1.0e-3_rp)), 'with the time of holding', labels%hold >= 0)
    call check_slope('root moment', labels%moment, 'with the moment about the root', is_load)
    call check_influence(labels, residuals, scale, checks)
    call check_outliers(residuals/sqrt(scale), checks)
    call check_replicates(labels, residuals, scale, checks)

  contains

    !> Checks whether the response is larger or smaller than computed in proportion to x, of which all loads have one value. The
    !> check is omitted if a response that varies by its whole size would differ by less than one sd from the baseline.
    subroutine check_slope(name, x, words, is_known)
      character(*), intent(in) :: name, words
      real(rp), intent(in) :: x(:)
      logical, intent(in) :: is_known(:)
      real(rp) :: both(size(residuals), 2), slope, length, largest, least, mean
      if (.not. any(is_load) .or. .not. all(is_known .or. .not. is_load)) return
      largest = maxval(x, mask=is_load)
      least = minval(x, mask=is_load)
      if (.not. largest - least > 1.0e-6_rp*max(abs(largest), abs(least))) return
      mean = sum(x, mask=is_load)/count(is_load)
      both(:, 1) = merge(responses, 0.0_rp, is_load(labels%surface))
      both(:, 2) = both(:, 1)*(x(labels%surface) - mean)/(largest - least)
      call design%whitener%apply(both)
      both = design%project_out_baseline(both)
      length = sum(both(:, 1)**2)
      if (length > 0) both(:, 2) = both(:, 2) - both(:, 1)*(sum(both(:, 1)*both(:, 2))/length)
      length = norm2(both(:, 2))
      if (.not. length > 1) return
      slope = -sum(both(:, 2)*residuals)/length/sqrt(scale)
      call append(checks, name, slope, log_chi2_tail(slope**2, 1), &
                  'measured deflections grow '//trim(merge('more', 'less', slope > 0))//' than computed ones '//words, &
                  'deflections do not depart from the model '//words)
    end subroutine check_slope

  end subroutine check_residuals

  !> Returns p of a check.
  pure elemental real(rp) function check_p(self) result(p)
    class(residual_check_t), intent(in) :: self
    p = exp(max(-700.0_rp, self%log_p))
  end function check_p

  !> Returns a check. Its sentence is `yes` if p < 0.01.
  function make_check(name, statistic, log_p, yes, no) result(check)
    character(*), intent(in) :: name, yes, no
    real(rp), intent(in) :: statistic, log_p
    type(residual_check_t) :: check
    check%name = name
    check%statistic = statistic
    check%log_p = min(0.0_rp, log_p)
    check%sentence = no
    if (log_p < log(0.01_rp)) check%sentence = yes
  end function make_check

  !> Adds a check.
  subroutine append(checks, name, statistic, log_p, yes, no)
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    character(*), intent(in) :: name, yes, no
    real(rp), intent(in) :: statistic, log_p
    checks = [checks, make_check(name, statistic, log_p, yes, no)]
  end subroutine append

  !> Returns the check that speaks most against the model, 0: there is none.
  pure integer function most_significant(checks) result(at)
    type(residual_check_t), intent(in) :: checks(:)
    integer :: i
    at = 0
    do i = 1, size(checks)
      if (.not. checks(i)%takes_part) cycle
      if (at > 0) then
        if (checks(i)%log_p >= checks(at)%log_p) cycle
      end if
      at = i
    end do
  end function most_significant

  !> Returns log p of the hypothesis that all of these checks that take part are results of chance: the smallest p times their
  !> number (Bonferroni), which holds for dependent checks too.
  pure real(rp) function combined_log_p(checks) result(log_p)
    type(residual_check_t), intent(in) :: checks(:)
    integer :: at
    log_p = 0
    at = most_significant(checks)
    if (at > 0) log_p = min(0.0_rp, checks(at)%log_p + log(real(count(checks%takes_part), rp)))
  end function combined_log_p

  !> Checks whether all differences are as large as their errors. Smaller differences are no misfit. This check always takes part: a
  !> size of the noise that comes from the same residuals would hide every misfit that no test sees.
  subroutine check_chi2(residuals, n_fitted, noise_dof, checks)
    real(rp), intent(in) :: residuals(:)
    integer, intent(in) :: n_fitted, noise_dof
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    character(:), allocatable :: sentence
    real(rp) :: square, log_p
    integer :: dof
    dof = max(1, size(residuals) - n_fitted)
    square = sum(residuals**2)
    if (square < dof) then
      log_p = log(min(1.0_rp, 2*max(tiny(square), 1 - exp(log_chi2_tail(square, dof)))))
    else if (noise_dof < huge(1)) then
      log_p = log_f_tail(square/dof, dof, noise_dof)
    else
      log_p = log_chi2_tail(square, dof)
    end if
    if (square < dof) then
      sentence = 'all differences together are smaller than their errors allow'
    else if (noise_dof < huge(1)) then
      sentence = 'all differences together are larger than their errors allow'
    else
      sentence = 'all differences together are '//fixed(sqrt(square/dof), 1)//' times as large as the declared errors allow'
    end if
    call append(checks, 'chi2', square/dof, log_p, sentence, 'all differences together are as large as their errors')
    checks(size(checks))%takes_part = square > dof
  end subroutine check_chi2

  !> Computes Moran's I of nearest neighbours within surfaces (Moran 1950, DOI 10.1093/biomet/37.1-2.17).
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
        distance = sum((labels%site(:, i) - labels%site(:, k))**2)
        if (.not. distance > 0) cycle ! samples of one record, and readings without a position, are no neighbours
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
    call append(checks, 'neighbours', product/square, log_chi2_tail(max(0.0_rp, z)**2, 1), &
                'differences at neighbouring points have the same sign: they form a shape and are not noise', &
                'differences at neighbouring points are independent')
  end subroutine check_neighbours

  !> Checks the surface that fits worst.
  subroutine check_influence(labels, residuals, scale, checks)
    type(labels_t), intent(in) :: labels
    real(rp), intent(in) :: residuals(:), scale
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    real(rp) :: log_p, least
    integer :: l, n, worst
    least = 0
    worst = 1
    do l = 1, size(labels%fold)
      n = count(labels%surface == l)
      if (n == 0) cycle
      log_p = log_chi2_tail(sum(residuals**2, mask=labels%surface == l)/scale, n)
      if (log_p < least) worst = l
      least = min(least, log_p)
    end do
    call append(checks, 'single load', real(worst, rp), least + log(real(size(labels%fold), rp)), &
                'measurement number '//number_text(worst)//' fits worse than all others', 'no single measurement stands out')
  end subroutine check_influence

  !> Checks for heavy tails: more residuals beyond three sd than normal errors have, as a Poisson number.
  subroutine check_outliers(residuals, checks)
    real(rp), intent(in) :: residuals(:)
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    real(rp), parameter :: BEYOND_THREE = 2.6997960632601866e-3_rp
    integer :: n
    n = count(abs(residuals) > 3)
    ! P(Poisson(m) >= n) is the tail of chi^2 with 2 n degrees of freedom below 2 m.
    associate (below => 2*BEYOND_THREE*size(residuals))
      call append(checks, 'outliers', real(n, rp)/size(residuals), &
                  merge(log(max(1.0e-15_rp, 1 - exp(log_chi2_tail(below, max(2, 2*n))))), 0.0_rp, n > 0), &
                'there are more outliers than normal errors have', 'there are no more outliers than normal errors have')
    end associate
  end subroutine check_outliers

  !> Compares repeats of the same load with each other (pure error).
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
    call append(checks, 'repeats', square/n, log_chi2_tail(square, n), &
                'repeats of the same load differ more than their errors: something changed between them', &
                'repeats of the same load agree within their errors')
  end subroutine check_replicates
end module inference_residual_checks
