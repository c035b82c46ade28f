! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes how often unknown causes would be taken for causes of the catalogue: the probability that the naming rule would reject a
!> name if the truth were an unknown cause, and the probability that some causes of the catalogue together would imitate it.
!>
!> A name has no meaning if the rule would also have given it to most random fields of the same strength. The name is an effect and
!> not one of its positions. In every draw the rule therefore takes the position that fits best, as it has done with the data.
!> Several causes are the best of very many combinations. They are therefore compared with the best combination in each draw.
module inference_rejection
  use base_kinds, only: i8, rp
  use base_random, only: random_stream_t
  use inference_calibration, only: calibration_t
  use inference_design, only: design_t
  use inference_hypotheses, only: add_effect, average_variants, explain, explained_t, remainder_log_p, IMPOSSIBLE
  implicit none
  private
  public :: imitation, name_power

  integer(i8), parameter :: UNKNOWN_STREAM = 11

contains

  !> Returns the probability that a name, the effects(:) jointly, would be rejected if the truth were an unknown cause of
  !> signal-to-noise ratio `snr`. It draws n_draws random fields of each family, and counts the family that imitates the name best:
  !> an average over families would hide that one of them can imitate it. Names are rejected if log p of the remainder is at most
  !> log_level. (Odds take no part: they were already evaluated for the data, and because of the priors alone they hardly ever
  !> prefer a wrong name.)
  real(rp) function name_power(design, calibration, effects, snr, log_level, n_draws, seed) result(power)
    type(design_t), intent(in) :: design
    type(calibration_t), intent(in) :: calibration
    integer, intent(in) :: effects(:)
    real(rp), intent(in) :: snr, log_level
    integer, intent(in) :: n_draws
    integer(i8), intent(in) :: seed
    type(random_stream_t) :: stream
    real(rp) :: z(design%k), signal(design%k)
    integer :: d, f, n(size(design%families))
    power = 0
    if (size(design%families) == 0) return
    stream = random_stream_t(seed=seed, stream=UNKNOWN_STREAM)
    n = 0
    do f = 1, size(design%families)
      do d = 1, n_draws
        call draw_unknown(design, f, stream, signal)
        call stream%gaussians(z)
        if (is_rejected(design, calibration, effects, z + snr*signal, log_level)) n(f) = n(f) + 1
      end do
    end do
    power = real(minval(n), rp)/n_draws
  end function name_power

  !> Returns the probability that n_causes of `effects`, whichever fit best, would leave nothing but noise if the truth were an
  !> unknown cause of signal-to-noise ratio `snr`: the mean over n_draws random fields of each family, which are equally probable.
  !> Each cause is the one with the largest evidence for what those before it leave. 0 without unknown causes.
  real(rp) function imitation(design, calibration, effects, n_causes, snr, log_level, n_draws, seed)
    type(design_t), intent(in) :: design
    type(calibration_t), intent(in) :: calibration
    integer, intent(in) :: effects(:), n_causes, n_draws
    real(rp), intent(in) :: snr, log_level
    integer(i8), intent(in) :: seed
    type(random_stream_t) :: stream
    type(explained_t) :: known
    real(rp) :: z(design%k), signal(design%k)
    integer :: d, f, n, n_families
    imitation = 0
    stream = random_stream_t(seed=seed, stream=UNKNOWN_STREAM)
    n = 0
    n_families = 0
    do f = 1, size(design%families)
      if (size(design%families(f)%scale) == 0) cycle ! these data show nothing of this family
      n_families = n_families + 1
      do d = 1, n_draws
        call draw_unknown(design, f, stream, signal)
        call stream%gaussians(z)
        call explain_best(design, effects, n_causes, z + snr*signal, known)
        if (remainder_log_p(design, calibration, known%left) > log_level) n = n + 1
      end do
    end do
    if (n_families > 0) imitation = real(n, rp)/(n_draws*n_families)
  end function imitation

  !> Explains z(k) by n_causes of `effects`, one after the other.
  subroutine explain_best(design, effects, n_causes, z, known)
    type(design_t), intent(in) :: design
    integer, intent(in) :: effects(:), n_causes
    real(rp), intent(in) :: z(:)
    type(explained_t), intent(out) :: known
    type(explained_t) :: one, best
    integer :: i, j
    call explain(design, [integer ::], z, known)
    do i = 1, n_causes
      best = known
      best%log_evidence = IMPOSSIBLE
      do j = 1, size(effects)
        if (any(design%candidates(known%members)%effect == effects(j))) cycle
        call add_effect(design, known, effects(j), one)
        if (one%log_evidence > best%log_evidence) best = one
      end do
      known = best
    end do
  end subroutine explain_best

  !> Tells whether the remainder of z(k) after the named effects rejects the name. Each further effect takes the position that fits
  !> best to the remainder of those before it.
  logical function is_rejected(design, calibration, effects, z, log_level)
    type(design_t), intent(in) :: design
    type(calibration_t), intent(in) :: calibration
    integer, intent(in) :: effects(:)
    real(rp), intent(in) :: z(:), log_level
    type(explained_t) :: found
    real(rp) :: left(size(z)), most, average
    integer :: i, members(size(effects))
    left = z
    do i = 1, size(effects)
      call average_variants(design, effects(i), left, members(i), most, average)
      associate (basis => design%candidates(members(i))%basis)
        left = left - matmul(basis, matmul(left, basis))
      end associate
    end do
    call explain(design, members, z, found)
    is_rejected = remainder_log_p(design, calibration, found%left) <= log_level
  end function is_rejected

  !> Draws a random field of family f, of length 1.
  subroutine draw_unknown(design, f, stream, signal)
    type(design_t), intent(in) :: design
    integer, intent(in) :: f
    type(random_stream_t), intent(inout) :: stream
    real(rp), intent(out) :: signal(:)
    real(rp) :: amplitudes(size(design%families(f)%scale))
    call stream%gaussians(amplitudes)
    signal = matmul(design%families(f)%basis, amplitudes*design%families(f)%scale)
    signal = signal/max(norm2(signal), tiny(1.0_rp))
  end subroutine draw_unknown
end module inference_rejection
