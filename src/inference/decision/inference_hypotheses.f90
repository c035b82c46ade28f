! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the odds of all explanations of a misfit. Every effect, pairs of effects, and unknown causes are hypotheses about z.
!>
!> The evidence of a hypothesis is the density of z averaged over strengths (uniform in their logarithm over six decades of
!> variance, the same for all) and over positions, relative to the baseline alone (1). This penalises both small and large models
!> for data that they could have explained (Kass and Raftery 1995, DOI 10.1080/01621459.1995.10476572). Odds are evidences times
!> PRIOR_.., which say how often a cause is expected before the data.
module inference_hypotheses
  use base_kinds, only: rp
  use base_lapack, only: decompose
  use inference_calibration, only: calibration_t
  use inference_design, only: candidate_t, design_t
  use inference_families, only: family_t
  use inference_distributions, only: log_add
  implicit none
  private
  public :: hypotheses_t, explained_t, explain, add_effect, average_variants, remainder_log_p, expect_loss, log_prior, &
            log_odds_unknown

  real(rp), parameter, public :: PRIOR_NONE = 0.35_rp, PRIOR_ONE = 0.35_rp, PRIOR_TWO = 0.1_rp, PRIOR_UNKNOWN = 0.2_rp

  !> A set of candidates that act at the same time.
  type :: explained_t
    integer, allocatable :: members(:)      !< candidates
    integer :: df = 0
    real(rp), allocatable :: basis(:, :)    !< (k, df)
    real(rp), allocatable :: left(:)        !< (k) what they leave of z
    real(rp) :: square = 0                  !< |z|^2 - |left|^2
    real(rp) :: log_evidence = 0
  end type explained_t

  !> Log evidences of all single hypotheses.
  type :: hypotheses_t
    real(rp), allocatable :: effect(:)      !< (effects) averaged over its variants; very small if absorbed
    integer, allocatable :: best(:)         !< (effects) variant of the largest evidence, 0: none
    real(rp), allocatable :: unknown(:)     !< (families)
    real(rp), allocatable :: unknown_linear(:) !< (families) the same before any correction
    logical, allocatable :: is_fitted(:)    !< (effects) corrected by a nonlinear fit of the best variant
    real(rp), allocatable :: correction(:)  !< (effects) change of the log evidence by that fit
    real(rp), allocatable :: behind(:)      !< (effects) log evidence by the tangents that the fitted variant lacks to the best one
    real(rp), allocatable :: gain(:)        !< (effects) decrease of the sum of squares by that fit, in units of the noise
    real(rp), allocatable :: left(:)        !< (effects) sum of squares of the data after that fit, in units of the noise; no priors
    real(rp), allocatable :: remainder(:)   !< (effects) log p of what that fit leaves unexplained
    real(rp), allocatable :: z(:, :)        !< (k, effects) part of z that the variant explains, and that its fit leaves
  contains
    procedure :: init => hypotheses_init
    procedure :: correct => hypotheses_correct
    procedure :: correct_unknown => hypotheses_correct_unknown
    procedure :: is_misled => hypotheses_is_misled
    procedure :: tell_apart => hypotheses_tell_apart
  end type hypotheses_t

  real(rp), parameter, public :: IMPOSSIBLE = -1.0e4_rp !< log evidence of what cannot be tested

contains

  !> Evaluates all hypotheses for z(k), in units of the noise, in the linear approximation.
  subroutine hypotheses_init(self, design, n_effects, z)
    class(hypotheses_t), intent(out) :: self
    type(design_t), intent(in) :: design
    integer, intent(in) :: n_effects
    real(rp), intent(in) :: z(:)
    real(rp) :: most
    integer :: e, f
    allocate (self%effect(n_effects))
    allocate (self%best(n_effects))
    allocate (self%unknown(size(design%families)))
    allocate (self%is_fitted(n_effects), source=.false.)
    allocate (self%correction(n_effects), self%behind(n_effects), source=0.0_rp)
    allocate (self%gain(n_effects), self%left(n_effects), self%remainder(n_effects), source=0.0_rp)
    self%z = spread(z, 2, n_effects)
    do e = 1, n_effects
      call average_variants(design, e, z, self%best(e), most, self%effect(e))
    end do
    do f = 1, size(design%families)
      self%unknown(f) = unknown_evidence(design%families(f), z)
    end do
    self%unknown_linear = self%unknown
  end subroutine hypotheses_init

  !> Returns, for z(k), the variant of effect e that has the largest evidence, 0: none; the logarithm of its evidence; and that of
  !> the effect, which is averaged over its variants by their weights.
  pure subroutine average_variants(design, e, z, best, most, average)
    type(design_t), intent(in) :: design
    integer, intent(in) :: e
    real(rp), intent(in) :: z(:)
    integer, intent(out) :: best
    real(rp), intent(out) :: most, average
    real(rp) :: one
    integer :: c
    best = 0
    most = IMPOSSIBLE
    average = IMPOSSIBLE
    do c = 1, size(design%candidates)
      if (design%candidates(c)%effect /= e .or. design%candidates(c)%df == 0) cycle
      one = design%candidates(c)%size_prior%log_evidence(matmul(z, design%candidates(c)%basis))
      average = log_add(average, one + log(design%candidates(c)%weight))
      if (best > 0 .and. one <= most) cycle
      most = one
      best = c
    end do
  end subroutine average_variants

  !> Returns the logarithm of the prior probability that these n_causes (1, 2 or more) of n_effects are there, and no others. Each
  !> one beyond the second has the odds of a second one, spread over the catalogue.
  pure real(rp) function log_prior(n_causes, n_effects)
    integer, intent(in) :: n_causes, n_effects
    if (n_causes == 1) then
      log_prior = log(PRIOR_ONE) - log(real(max(1, n_effects), rp))
    else
      log_prior = log(PRIOR_TWO) - log(0.5_rp*n_effects*(n_effects - 1)) &
                  - (n_causes - 2)*log(n_effects*PRIOR_ONE/PRIOR_TWO)
    end if
  end function log_prior

  !> Returns the logarithm of the odds of an unknown cause, whatever its family, with these log evidences(families).
  pure real(rp) function log_odds_unknown(unknown) result(log_odds)
    real(rp), intent(in) :: unknown(:)
    integer :: f
    log_odds = IMPOSSIBLE
    do f = 1, size(unknown)
      log_odds = log_add(log_odds, unknown(f) + log(PRIOR_UNKNOWN) - log(real(size(unknown), rp)))
    end do
  end function log_odds_unknown

  !> Tells whether the fit of the most probable effect has found more than twice the evidence that its tangent shows. What tangents
  !> show of the other effects, or expect of them, is then no reason to leave them out or to count them in.
  pure logical function hypotheses_is_misled(self) result(is_it)
    class(hypotheses_t), intent(in) :: self
    real(rp), parameter :: LEAST = 10
    integer :: e
    is_it = .false.
    if (size(self%effect) == 0) return
    e = maxloc(self%effect, 1)
    is_it = self%correction(e) > max(LEAST, self%effect(e) - self%correction(e))
  end function hypotheses_is_misled

  !> Tells whether fits have shown effect b to leave more of the data than a, by more than 2*`loss`, where tangents mislead. It
  !> uses no prior.
  pure logical function hypotheses_tell_apart(self, a, b, loss) result(are_apart)
    class(hypotheses_t), intent(in) :: self
    integer, intent(in) :: a, b
    real(rp), intent(in) :: loss
    are_apart = self%is_fitted(a) .and. self%is_fitted(b) .and. self%is_misled()
    if (are_apart) are_apart = 0.5_rp*(self%left(b) - self%left(a)) > 2*loss
  end function hypotheses_tell_apart

  !> Takes the results of a nonlinear fit of effect e: by how much its evidence exceeds that in the linear approximation, by how
  !> much the fit lowers the sum of squares, the log p of the remainder of the fit, and z(k) in which this remainder replaces that
  !> of the linear approximation. The average over variants, which the best one dominates by its tangents, is that of the fitted
  !> variant if this is `behind` it. `left` is the sum of squares of the data after the fit.
  subroutine hypotheses_correct(self, e, correction, gain, remainder, z, behind, left)
    class(hypotheses_t), intent(inout) :: self
    integer, intent(in) :: e
    real(rp), intent(in) :: correction, gain, remainder, z(:)
    real(rp), intent(in), optional :: behind, left
    self%is_fitted(e) = .true.
    self%effect(e) = self%effect(e) + self%behind(e) - self%correction(e) + correction
    self%behind(e) = 0
    if (present(behind)) self%behind(e) = behind
    if (present(left)) self%left(e) = left
    self%effect(e) = self%effect(e) - self%behind(e)
    self%correction(e) = correction
    self%gain(e) = gain
    self%remainder(e) = remainder
    self%z(:, e) = z
  end subroutine hypotheses_correct

  !> Corrects the evidence of unknown causes, which only tangents can judge. Where the tangents are inaccurate, unknown causes would
  !> explain a part of the data that belongs to the best effect, as its fit has shown. Their evidence is therefore that for z with
  !> the remainder of this fit, with the correction of the effect: both then refer to the same remainder. The gain of the fit beyond
  !> its tangents counts only up to the part that the tangents show: an effect that its tangent hardly shows has no image in z that
  !> unknown causes could imitate.
  subroutine hypotheses_correct_unknown(self, design)
    class(hypotheses_t), intent(inout) :: self
    type(design_t), intent(in) :: design
    integer :: e, f
    real(rp) :: shared
    if (.not. any(self%is_fitted)) return
    e = maxloc(self%effect, 1, mask=self%is_fitted)
    shared = min(self%correction(e), max(0.0_rp, self%effect(e) - self%correction(e)))
    do f = 1, size(self%unknown)
      self%unknown(f) = unknown_evidence(design%families(f), self%z(:, e)) + shared
      if (self%correction(e) > 0) self%unknown(f) = max(self%unknown(f), self%unknown_linear(f))
    end do
  end subroutine hypotheses_correct_unknown

  !> Returns the log evidence of one family of unknown causes. A field over all positions and a single position have the same prior
  !> probability.
  pure real(rp) function unknown_evidence(family, z) result(log_evidence)
    type(family_t), intent(in) :: family
    real(rp), intent(in) :: z(:)
    real(rp) :: one
    integer :: i
    log_evidence = family%size_prior%log_evidence(matmul(z, family%basis))
    if (size(family%alone, 2) == 0) return
    one = IMPOSSIBLE
    do i = 1, size(family%alone, 2)
      one = log_add(one, family%size_prior_alone%log_evidence([dot_product(z, family%alone(:, i))]))
    end do
    log_evidence = log_add(log_evidence, one - log(real(size(family%alone, 2), rp))) - log(2.0_rp)
  end function unknown_evidence

  !> Finds the part of z(k) that candidates explain, each in the space that those before it leave.
  subroutine explain(design, members, z, explained)
    type(design_t), intent(in) :: design
    integer, intent(in) :: members(:)
    real(rp), intent(in) :: z(:)
    type(explained_t), intent(out) :: explained
    type(candidate_t) :: one
    integer :: i
    explained%members = members
    explained%left = z
    allocate (explained%basis(size(z), 0))
    do i = 1, size(members)
      one = orthogonal_to(design%candidates(members(i)), explained)
      if (one%df == 0) cycle
      explained%log_evidence = explained%log_evidence + one%size_prior%log_evidence(matmul(explained%left, one%basis))
      explained%left = explained%left - matmul(one%basis, matmul(explained%left, one%basis))
      explained%basis = reshape([explained%basis, one%basis], [size(z), explained%df + one%df])
      explained%df = explained%df + one%df
    end do
    explained%square = max(0.0_rp, sum(z**2) - sum(explained%left**2))
  end subroutine explain

  !> Returns the directions of a candidate without those that others have.
  type(candidate_t) function orthogonal_to(one, others) result(remainder)
    type(candidate_t), intent(in) :: one
    type(explained_t), intent(in) :: others
    real(rp), allocatable :: u(:, :), s(:), vt(:, :)
    integer :: m
    remainder = one
    if (one%df == 0 .or. others%df == 0) return
    call decompose(one%basis - matmul(others%basis, matmul(transpose(others%basis), one%basis)), u, s, vt)
    m = count(s > 0.05_rp)
    remainder%basis = u(:, :m)
    remainder%df = m
    if (m > 0) call remainder%size_prior%init(s(:m)/s(1))
  end function orthogonal_to

  !> Adds to the candidates of `known` the variant of effect e that explains most in addition. The evidence is averaged over all
  !> variants, which penalises an effect that may be at many positions.
  subroutine add_effect(design, known, e, explained)
    type(design_t), intent(in) :: design
    type(explained_t), intent(in) :: known
    integer, intent(in) :: e
    type(explained_t), intent(out) :: explained
    type(candidate_t) :: one, best
    real(rp) :: log_evidence, total, most
    integer :: c, member
    member = 0
    total = IMPOSSIBLE
    most = IMPOSSIBLE
    do c = 1, size(design%candidates)
      if (design%candidates(c)%effect /= e .or. design%candidates(c)%df == 0) cycle
      one = orthogonal_to(design%candidates(c), known)
      log_evidence = 0
      if (one%df > 0) log_evidence = one%size_prior%log_evidence(matmul(known%left, one%basis))
      total = log_add(total, log_evidence + log(design%candidates(c)%weight))
      if (one%df == 0 .or. log_evidence <= most) cycle
      most = log_evidence
      member = c
      best = one
    end do
    explained = known
    if (member == 0) then
      explained%log_evidence = IMPOSSIBLE
      return
    end if
    explained%members = [known%members, member]
    explained%log_evidence = known%log_evidence + total
    explained%left = known%left - matmul(best%basis, matmul(known%left, best%basis))
    explained%basis = reshape([known%basis, best%basis], [size(known%left), known%df + best%df])
    explained%df = known%df + best%df
    explained%square = known%square + sum(matmul(known%left, best%basis)**2)
  end subroutine add_effect

  !> Returns log p of the hypothesis that the remainder left(k) of z after some candidates is noise, against unknown causes. The
  !> reference distribution is that of z itself, which makes the test a little conservative.
  real(rp) function remainder_log_p(design, calibration, left) result(log_p)
    type(design_t), intent(in) :: design
    type(calibration_t), intent(in) :: calibration
    real(rp), intent(in) :: left(:)
    integer :: f
    log_p = 0
    do f = 1, size(design%families)
      associate (one => design%families(f))
        log_p = min(log_p, calibration%log_p_unknown(f, one%size_prior%log_likelihood(matmul(left, one%basis))) &
                    + log(real(size(design%families), rp)))
      end associate
    end do
  end function remainder_log_p

  !> Returns the expected loss of log likelihood of candidate b relative to a if a is true with the strength that was found, and
  !> this loss as a `fraction` of all that a adds to the baseline. It uses no prior: causes that differ only by their priors do
  !> not count as different.
  subroutine expect_loss(design, a, b, z, loss, fraction)
    type(design_t), intent(in) :: design
    integer, intent(in) :: a, b
    real(rp), intent(in) :: z(:)
    real(rp), intent(out) :: loss, fraction
    real(rp), parameter :: SAME = 1.0e-6_rp ! of the largest direction of b
    real(rp), allocatable :: signal(:), u(:, :), s(:), vt(:, :)
    real(rp) :: whole
    integer :: m
    loss = 0
    fraction = 1
    associate (one => design%candidates(a), other => design%candidates(b))
      signal = matmul(one%projected, matmul(one%solve, matmul(z, one%basis)))
      whole = 0.5_rp*sum(signal**2)
      if (.not. whole > 0) return
      call decompose(other%projected, u, s, vt)
      m = count(s > SAME*maxval(s))
      signal = signal - matmul(u(:, :m), matmul(signal, u(:, :m)))
      loss = 0.5_rp*sum(signal**2)
      fraction = loss/whole
    end associate
  end subroutine expect_loss
end module inference_hypotheses
