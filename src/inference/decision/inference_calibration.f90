! SPDX-License-Identifier: GPL-3.0-or-later
!> Calibrates all tests jointly by a parametric bootstrap of the design: it draws data that contain noise only.
!>
!> If the baseline is true, z is a vector of independent normal numbers, from which the test statistics of all candidates and of
!> unknown causes follow. Their joint distribution gives p of scans (the largest of many positions), p of unknown causes, and one
!> global p of the combined rule: the smallest p of any effect, which has EFFECTS_FRACTION of the level, or of any unknown cause,
!> which has the rest. Local and global p differ by the look-elsewhere effect.
!>
!> Draw number d of a seed is the same on every rank. Beyond the range of the draws p is extrapolated: by the law of p of an
!> independent number of tests, and by an exponential tail for unknown causes.
module inference_calibration
  use base_kinds, only: i8, rp
  use base_random, only: fill_gaussians, random_stream_t
  use base_sort, only: sort_reals
  use inference_design, only: design_t
  use inference_distributions, only: detectable_noncentrality, draw_chi2, log_chi2_tail, log_f_tail
  implicit none
  private
  public :: calibration_t, statistics_t, find_detectable, find_statistics

  real(rp), parameter :: EFFECTS_FRACTION = 0.8_rp !< of the level, the rest is for unknown causes
  integer(i8), parameter :: NOISE_STREAM = 1, SCALE_STREAM = 2

  !> Statistics of one z.
  type :: statistics_t
    real(rp), allocatable :: squares(:)      !< (candidates) |basis^T z|^2
    real(rp), allocatable :: log_p(:)        !< (candidates) local, 0 if absorbed
    real(rp), allocatable :: effect(:)       !< (effects) largest -log_p of its variants that are scanned
    integer, allocatable :: best(:)          !< (effects) candidate with it, 0: none
    real(rp), allocatable :: unknown(:)      !< (families) log likelihood ratio
  end type statistics_t

  type :: calibration_t
    integer :: n_draws = 0
    logical :: is_scale_known = .true.       !< the noise is as declared; otherwise estimated from the remainder
    real(rp), allocatable :: n_tests(:)      !< (effects) number of independent tests that is equivalent to its variants
    real(rp), allocatable :: unknown(:, :)   !< (n_draws, families) sorted
    real(rp), allocatable :: combined(:)     !< (n_draws) sorted smallest weighted log p
    real(rp) :: n_combined = 1               !< number of independent tests that is equivalent to all tests
  contains
    procedure :: init => calibration_init
    procedure :: is_of => calibration_is_of
    procedure :: log_p_effect => calibration_log_p_effect
    procedure :: log_p_unknown => calibration_log_p_unknown
    procedure :: log_p_global => calibration_log_p_global
    procedure :: local_level => calibration_local_level
    procedure, private :: combine => calibration_combine
  end type calibration_t

contains

  !> Finds all statistics of z(k). `rest` is the sum of squares in other directions: if the scale of the noise is not known, z is
  !> divided by it, and tests are F tests. With `only_best` it does not find p of a variant if another variant of its effect with
  !> as many directions has a larger square.
  subroutine find_statistics(design, n_effects, is_scale_known, z, residual_square, statistics, only_best)
    type(design_t), intent(in) :: design
    integer, intent(in) :: n_effects
    logical, intent(in) :: is_scale_known
    real(rp), intent(in) :: z(:), residual_square
    type(statistics_t), intent(out) :: statistics
    logical, intent(in), optional :: only_best
    real(rp) :: scale
    integer :: c, f
    logical :: is_brief
    is_brief = .false.
    if (present(only_best)) is_brief = only_best
    scale = 1
    if (.not. is_scale_known) scale = residual_square/design%residual_dof
    associate (s => statistics)
      allocate (s%squares(size(design%candidates)), s%log_p(size(design%candidates)), s%effect(n_effects), &
                s%unknown(size(design%families)), source=0.0_rp)
      allocate (s%best(n_effects), source=0)
      do c = 1, size(design%candidates)
        associate (one => design%candidates(c))
          if (one%df == 0) cycle
          s%squares(c) = sum(matmul(z, one%basis)**2)/scale
          if (is_brief .and. s%best(one%effect) > 0) then
            if (design%candidates(s%best(one%effect))%df == one%df .and. &
                s%squares(c) <= s%squares(s%best(one%effect))) cycle
          end if
          if (is_scale_known) then
            s%log_p(c) = log_chi2_tail(s%squares(c), one%df)
          else
            s%log_p(c) = log_f_tail(s%squares(c)/one%df, one%df, design%residual_dof)
          end if
          if (one%is_finer) cycle
          if (s%best(one%effect) > 0 .and. -s%log_p(c) <= s%effect(one%effect)) cycle
          s%effect(one%effect) = -s%log_p(c)
          s%best(one%effect) = c
        end associate
      end do
      do f = 1, size(design%families)
        s%unknown(f) = design%families(f)%size_prior%log_likelihood(matmul(z, design%families(f)%basis)/sqrt(scale))
      end do
    end associate
  end subroutine find_statistics

  !> Draws the distribution, with `n_draws` >= 200 draws.
  subroutine calibration_init(self, design, n_effects, is_scale_known, n_draws, seed)
    class(calibration_t), intent(out) :: self
    type(design_t), intent(in) :: design
    integer, intent(in) :: n_effects, n_draws
    logical, intent(in) :: is_scale_known
    integer(i8), intent(in) :: seed
    type(statistics_t) :: statistics
    real(rp), allocatable :: effects(:, :), raw(:, :), sorted(:)
    integer :: d, e
    self%n_draws = n_draws
    self%is_scale_known = is_scale_known
    allocate (effects(n_draws, n_effects), raw(n_draws, size(design%families)), self%combined(n_draws), &
              self%unknown(n_draws, size(design%families)), self%n_tests(n_effects))
    do d = 1, n_draws
      call draw_null(design, is_scale_known, n_effects, seed, d, statistics)
      effects(d, :) = statistics%effect
      raw(d, :) = statistics%unknown
    end do
    do e = 1, n_effects
      sorted = effects(:, e)
      call sort_reals(sorted)
      self%n_tests(e) = independent_tests(-sorted(n_draws + 1 - nint(0.05_rp*n_draws)), 0.05_rp)
    end do
    do e = 1, size(raw, 2)
      sorted = raw(:, e)
      call sort_reals(sorted)
      self%unknown(:, e) = sorted
    end do
    do d = 1, n_draws
      self%combined(d) = self%combine(effects(d, :), raw(d, :))
    end do
    call sort_reals(self%combined)
    self%n_combined = independent_tests(self%combined(max(1, nint(0.02_rp*n_draws))), 0.02_rp)
  end subroutine calibration_init

  !> Tells whether these are the draws that `init` would make: their numbers are right, and the results of the first few draws are
  !> among them to the last bit.
  logical function calibration_is_of(self, design, n_effects, is_scale_known, n_draws, seed) result(is_it)
    class(calibration_t), intent(in) :: self
    type(design_t), intent(in) :: design
    integer, intent(in) :: n_effects, n_draws
    logical, intent(in) :: is_scale_known
    integer(i8), intent(in) :: seed
    integer, parameter :: TRIED = 10
    type(statistics_t) :: statistics
    integer :: d, f
    is_it = self%n_draws == n_draws .and. (self%is_scale_known .eqv. is_scale_known)
    is_it = is_it .and. allocated(self%n_tests) .and. allocated(self%unknown) .and. allocated(self%combined)
    if (.not. is_it) return
    is_it = size(self%n_tests) == n_effects .and. size(self%combined) == n_draws .and. &
            all(shape(self%unknown) == [n_draws, size(design%families)])
    if (.not. is_it) return
    do d = 1, min(TRIED, n_draws)
      call draw_null(design, is_scale_known, n_effects, seed, d, statistics)
      do f = 1, size(design%families)
        is_it = is_it .and. has(self%unknown(:, f), statistics%unknown(f))
      end do
      is_it = is_it .and. has(self%combined, self%combine(statistics%effect, statistics%unknown))
    end do
  end function calibration_is_of

  !> Tells whether x is one of the numbers of the sorted list.
  pure logical function has(sorted, x)
    real(rp), intent(in) :: sorted(:), x
    integer :: n
    n = count_above(sorted, x)
    has = n > 0
    if (has) has = sorted(size(sorted) + 1 - n) <= x
  end function has

  !> Computes the statistics of draw number d if the baseline is true.
  subroutine draw_null(design, is_scale_known, n_effects, seed, d, statistics)
    type(design_t), intent(in) :: design
    logical, intent(in) :: is_scale_known
    integer, intent(in) :: n_effects, d
    integer(i8), intent(in) :: seed
    type(statistics_t), intent(out) :: statistics
    type(random_stream_t) :: stream
    real(rp) :: z(design%k), residual_square
    call fill_gaussians(seed, NOISE_STREAM, int(d, i8)*design%k, z)
    residual_square = 0
    if (.not. is_scale_known) then
      stream = random_stream_t(seed=seed, stream=SCALE_STREAM, position=int(d, i8)*200000_i8)
      call draw_chi2(stream, design%residual_dof, residual_square)
    end if
    call find_statistics(design, n_effects, is_scale_known, z, residual_square, statistics, only_best=.true.)
  end subroutine draw_null

  !> Returns the number n of independent tests whose smallest p is exp(log_p) with probability `level`.
  pure real(rp) function independent_tests(log_p, level) result(n)
    real(rp), intent(in) :: log_p, level
    n = 1
    if (log_p < 0) n = max(1.0_rp, log(1 - level)/log_one_minus(log_p))
  end function independent_tests

  !> Returns log(1 - exp(log_p)).
  pure elemental real(rp) function log_one_minus(log_p) result(y)
    real(rp), intent(in) :: log_p
    if (log_p > -1.0e-300_rp) then
      y = log(tiny(y))
    else if (log_p > -30) then
      y = log(1 - exp(log_p))
    else
      y = -exp(max(-700.0_rp, log_p))
    end if
  end function log_one_minus

  !> Returns the logarithm of 1 - (1 - p)^n.
  pure real(rp) function log_any_of(log_p, n) result(y)
    real(rp), intent(in) :: log_p, n
    real(rp) :: exponent
    if (log_p < -30) then
      y = min(0.0_rp, log_p + log(n))
    else
      exponent = n*log_one_minus(log_p)
      y = log(max(tiny(y), 1 - exp(max(-700.0_rp, exponent))))
      if (exponent > -1.0e-8_rp) y = log(-exponent)
    end if
  end function log_any_of

  !> Returns log p of effect e, whose best variant has -log p = statistic.
  pure real(rp) function calibration_log_p_effect(self, e, statistic) result(log_p)
    class(calibration_t), intent(in) :: self
    integer, intent(in) :: e
    real(rp), intent(in) :: statistic
    log_p = log_any_of(-statistic, self%n_tests(e))
  end function calibration_log_p_effect

  !> Returns log p of unknown causes of family f.
  pure real(rp) function calibration_log_p_unknown(self, f, statistic) result(log_p)
    class(calibration_t), intent(in) :: self
    integer, intent(in) :: f
    real(rp), intent(in) :: statistic
    real(rp) :: at_95, at_99
    at_95 = self%unknown(nint(0.95_rp*self%n_draws), f)
    at_99 = self%unknown(nint(0.99_rp*self%n_draws), f)
    if (statistic > at_99) then
      log_p = log(0.01_rp) - log(5.0_rp)*(statistic - at_99)/max(at_99 - at_95, tiny(at_99))
    else
      log_p = log(real(1 + count_above(self%unknown(:, f), statistic), rp)/(1 + self%n_draws))
    end if
  end function calibration_log_p_unknown

  !> Returns how many numbers of the sorted list are at least x.
  pure integer function count_above(sorted, x) result(n)
    real(rp), intent(in) :: sorted(:), x
    integer :: lower, upper, middle
    lower = 1
    upper = size(sorted) + 1
    do while (lower < upper)
      middle = (lower + upper)/2
      if (sorted(middle) < x) then
        lower = middle + 1
      else
        upper = middle
      end if
    end do
    n = size(sorted) + 1 - lower
  end function count_above

  !> Returns the smallest weighted log p of all tests.
  pure real(rp) function calibration_combine(self, effects, unknown) result(least)
    class(calibration_t), intent(in) :: self
    real(rp), intent(in) :: effects(:), unknown(:)
    integer :: e
    least = 0
    do e = 1, size(effects)
      least = min(least, self%log_p_effect(e, effects(e)) - log(EFFECTS_FRACTION))
    end do
    do e = 1, size(unknown)
      least = min(least, self%log_p_unknown(e, unknown(e)) - log((1 - EFFECTS_FRACTION)/size(unknown)))
    end do
  end function calibration_combine

  !> Returns the logarithm of the probability that, by chance alone, the combined rule gives a p as small as this.
  pure real(rp) function calibration_log_p_global(self, statistics) result(log_p)
    class(calibration_t), intent(in) :: self
    type(statistics_t), intent(in) :: statistics
    real(rp) :: least
    integer :: n
    least = self%combine(statistics%effect, statistics%unknown)
    n = self%n_draws - count_above(self%combined, least)
    if (n < 0.02_rp*self%n_draws) then
      log_p = log_any_of(min(0.0_rp, least), self%n_combined)
    else
      log_p = log(real(1 + n, rp)/(1 + self%n_draws))
    end if
  end function calibration_log_p_global

  !> Returns the logarithm of the local p of a variant of effect e at which the combined rule reaches the global level.
  pure real(rp) function calibration_local_level(self, e, level) result(log_p)
    class(calibration_t), intent(in) :: self
    integer, intent(in) :: e
    real(rp), intent(in) :: level
    real(rp) :: wanted
    wanted = self%combined(max(1, nint(level*self%n_draws))) + log(EFFECTS_FRACTION)
    ! Solves log_any_of(log_p, n) = wanted.
    log_p = log_one_minus(log_one_minus(min(wanted, -1.0e-6_rp))/self%n_tests(e))
  end function calibration_local_level

  !> Finds the smallest signal-to-noise ratio at which each effect is found with a probability of 90 % at the global `level`, for
  !> its variant of the fewest directions; huge if the baseline absorbs it.
  subroutine find_detectable(design, calibration, n_effects, level, snr)
    type(design_t), intent(in) :: design
    type(calibration_t), intent(in) :: calibration
    integer, intent(in) :: n_effects
    real(rp), intent(in) :: level
    real(rp), allocatable, intent(out) :: snr(:)
    integer :: c
    allocate (snr(n_effects), source=huge(1.0_rp))
    do c = 1, size(design%candidates)
      associate (one => design%candidates(c))
        if (one%df == 0) cycle
        if (snr(one%effect) < huge(1.0_rp)) cycle
        snr(one%effect) = sqrt(detectable_noncentrality(calibration%local_level(one%effect, level), one%df, 0.9_rp))
      end associate
    end do
  end subroutine find_detectable
end module inference_calibration
