! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes the causes of a verdict in words: one sentence for each cause, with a part for each of its parameters.
module diagnose_findings
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use diagnose_words, only: finding_t, finding_text, strength_text
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_wing_parameters, only: KIND_FLIGHT
  use inference_engine, only: diagnosis_t
  use inference_refit, only: nested_fit_t
  use least_squares_profile, only: interval_t
  implicit none
  private
  public :: cause_finding, effect_finding, parameter_finding, shows_from, make_finding

contains

  !> Returns a sentence on cause i of the verdict, from the fit of the extended model. It is empty if that model was not fitted.
  function cause_finding(s, d, i) result(text)
    class(diagnosis_case_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: i
    character(:), allocatable :: text
    text = ''
    if (d%extended%is_found) text = fit_text(s, d, d%decision%causes(i), d%extended, d%intervals)
  end function cause_finding

  !> Returns a sentence on parameter k of cause i of the verdict, from the fit of the extended model. It is empty if that model
  !> was not fitted.
  function parameter_finding(s, d, i, k) result(text)
    class(diagnosis_case_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: i, k
    character(:), allocatable :: text
    text = ''
    if (d%extended%is_found) text = fit_text(s, d, d%decision%causes(i), d%extended, d%intervals, k)
  end function parameter_finding

  !> Returns in words the smallest strength of effect e that these data would show in nine of ten experiments. There is a part for
  !> each of its parameters that is detectable alone, for an increase of its coordinate. The text is empty if none is detectable.
  function shows_from(s, d, e) result(text)
    class(diagnosis_case_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: e
    character(:), allocatable :: text
    real(rp), parameter :: FAINT = 1.0e-100_rp, FAR = 20.0_rp ! of a logarithm
    real(rp) :: size_of, step
    integer :: k
    text = ''
    associate (one => d%model%design%candidates(d%tests%statistics%best(e)))
      do k = 1, size(one%columns)
        size_of = norm2(one%tangents(:, k))
        if (size_of < FAINT) cycle
        step = d%detectable_snr(e)/size_of
        associate (q => s%catalogue%parameters(one%columns(k)))
          if (.not. step < min(merge(FAR, huge(step), q%is_log), q%upper - q%null)) cycle
          if (text /= '') text = text//'; '
          text = text//strength_text(make_finding(q, s%catalogue%effects(e)%variants(one%variant)%label, q%null + step))
        end associate
      end do
    end associate
  end function shows_from

  !> Returns a sentence on effect e as if it were the only cause, from its own fit. It is empty if that fit was not made.
  function effect_finding(s, d, e) result(text)
    class(diagnosis_case_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: e
    character(:), allocatable :: text
    integer :: r
    text = ''
    if (.not. allocated(d%refits)) return
    do r = 1, size(d%refits)
      if (d%model%design%candidates(d%refits(r)%candidate)%effect /= e .or. .not. d%refits(r)%found%is_found) cycle
      text = fit_text(s, d, d%refits(r)%candidate, d%refits(r)%found)
    end do
  end function effect_finding

  !> Describes the parameters of a candidate in a fit, or only its parameter number `only`. `intervals` belong to the parameters
  !> that follow those of the baseline.
  function fit_text(s, d, candidate, fit, intervals, only) result(text)
    class(diagnosis_case_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: candidate
    type(nested_fit_t), intent(in) :: fit
    type(interval_t), allocatable, intent(in), optional :: intervals(:)
    integer, intent(in), optional :: only
    character(:), allocatable :: text
    type(finding_t) :: finding
    integer :: k, at, n
    text = ''
    n = size(d%model%baseline%active)
    associate (one => d%model%design%candidates(candidate))
      do k = 1, size(one%columns)
        if (present(only)) then
          if (k /= only) cycle
        end if
        at = findloc(fit%active, one%columns(k), 1)
        if (at <= n) cycle
        finding = make_finding(s%catalogue%parameters(one%columns(k)), &
                               s%catalogue%effects(one%effect)%variants(one%variant)%label, fit%q(one%columns(k)))
        if (present(intervals)) then
          if (allocated(intervals)) call add_interval(finding, s%catalogue%parameters(one%columns(k))%is_log, intervals(at - n))
        end if
        if (text /= '') text = text//'; '
        text = text//finding_text(finding)
        ! Words for a change of the flight have no place for the records that show it.
        if (s%catalogue%parameters(one%columns(k))%kind == KIND_FLIGHT .and. finding%site /= '') &
          text = text//' ('//finding%site//')'
      end do
    end associate
  end function fit_text

  !> Returns a parameter with the coordinate q as a finding without an interval.
  function make_finding(parameter, site, q) result(finding)
    class(parameter_t), intent(in) :: parameter
    character(*), intent(in) :: site
    real(rp), intent(in) :: q
    type(finding_t) :: finding
    finding%name = parameter%name
    finding%unit = parameter%unit
    finding%site = site
    finding%null = parameter%null
    finding%best = q
    if (.not. parameter%is_log) return
    finding%null = exp(parameter%null)
    finding%best = exp(q)
  end function make_finding

  !> Gives a finding its interval, in the unit of the parameter.
  pure subroutine add_interval(finding, is_log, interval)
    type(finding_t), intent(inout) :: finding
    logical, intent(in) :: is_log
    type(interval_t), intent(in) :: interval
    finding%has_interval = .true.
    finding%has_lower = interval%has_lower
    finding%has_upper = interval%has_upper
    finding%best = interval%best
    finding%lower = interval%lower
    finding%upper = interval%upper
    finding%is_jump = any(interval%is_jump)
    if (.not. is_log) return
    finding%best = exp(interval%best)
    finding%lower = exp(interval%lower)
    finding%upper = exp(interval%upper)
  end subroutine add_interval
end module diagnose_findings
