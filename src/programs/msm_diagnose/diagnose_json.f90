! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes NAME.json, which holds everything that a diagnosis found, for other programs. `schema_version` and
!> docs/guide/diagnosis.md define its form.
module diagnose_json
  use base_build, only: BUILD_COMMIT, BUILD_VERSION
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use diagnose_comparison, only: put_comparison
  use diagnose_json_parts, only: put_discretisation
  use diagnose_counts, only: counts_t
  use diagnose_data_json, only: put_data
  use diagnose_findings, only: cause_finding, effect_finding, parameter_finding, shows_from
  use diagnose_flight_tests, only: put_flight_test
  use diagnose_next, only: put_next
  use diagnose_settings, only: diagnose_settings_t
  use diagnose_summary, only: cause_name, verdict_sentence, verdict_statement
  use diagnose_unknown, only: put_unknown
  use diagnosis_discretisation, only: discretisation_error_t
  use diagnosis_next_measurement, only: next_measurement_t
  use diagnosis_unknown, only: unknown_t
  use diagnosis_zeros, only: zeros_t
  use diagnose_checks, only: alarm_name, put_checks
  use inference_decision, only: grade_of, stated_probability, verdict_word
  use inference_engine, only: diagnosis_t
  use inference_probability, only: provenance_of
  use inference_refit, only: nested_fit_t
  use inference_residual_checks, only: residual_check_t
  use inference_simulator, only: labels_t
  use inference_validation, only: validation_t
  use io_json, only: json_t
  implicit none
  private
  public :: write_diagnosis_json

  integer, parameter :: SCHEMA_VERSION = 2

contains

  !> Writes NAME.json; `labels` are those of the observations. `failure` says why if it cannot be written.
  subroutine write_diagnosis_json(s, labels, d, discretisation, next, zeros, unknown, failure)
    type(diagnose_settings_t), intent(in) :: s
    type(labels_t), intent(in) :: labels
    type(diagnosis_t), intent(in) :: d
    type(discretisation_error_t), intent(in) :: discretisation
    type(next_measurement_t), intent(in) :: next
    type(zeros_t), intent(in) :: zeros
    type(unknown_t), intent(in) :: unknown
    type(failure_t), intent(inout) :: failure
    type(json_t) :: json
    type(counts_t) :: counts
    integer :: i
    call counts%init(s, labels, d)
    call json%open_object('')
    call json%put('schema', 'flusi-msm diagnosis')
    call json%put('schema_version', SCHEMA_VERSION)
    call json%put('program', 'msm_diagnose '//BUILD_VERSION//' ('//BUILD_COMMIT//')')
    call json%put('wing', s%wing_case%path)
    call json%put('measurement', s%measurement_path)
    call json%put('seed', int(s%options%seed))
    call put_verdict(json, s, d, unknown)
    call put_data(json, s, counts, d)
    call put_noise(json, s, d)
    call put_discretisation(json, discretisation, s%fits_finer)
    call put_baseline(json, s, d)
    call json%open_list('effects')
    do i = 1, size(s%catalogue%effects)
      call put_effect(json, s, d, i)
    end do
    call json%close()
    call put_extension(json, s, d)
    call put_comparison(json, s)
    call put_validation(json, d)
    call put_zeros(json, zeros)
    if (allocated(d%tests%checks)) call put_checks(json, 'questions', d%tests%checks)
    if (.not. allocated(d%tests%checks)) call put_checks(json, 'questions', [residual_check_t ::])
    call put_rivals(json, s, d, next)
    call put_next(json, s, d, next)
    call json%close()
    call write_text(s%name//'.json', json%text, failure)
  end subroutine write_diagnosis_json

  !> Lists the rival effects, each with the variant that is hardest to distinguish from the first cause.
  subroutine put_rivals(json, s, d, next)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(next_measurement_t), intent(in) :: next
    logical :: is_told(size(s%catalogue%effects))
    integer :: r
    call json%open_list('rivals')
    is_told = .false.
    do r = 1, size(next%rivals)
      associate (one => d%model%design%candidates(next%rivals(r)))
        if (is_told(one%effect)) cycle
        is_told(one%effect) = .true.
        call json%open_object('')
        call json%put('effect', s%catalogue%effects(one%effect)%name)
        call json%put('variant', s%catalogue%effects(one%effect)%variants(one%variant)%label)
        call json%put('separation_now_sd', next%now(r))
        call json%close()
      end associate
    end do
    call json%close()
  end subroutine put_rivals

  !> Writes the verdict, its probability and the tests behind it.
  subroutine put_verdict(json, s, d, unknown)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(unknown_t), intent(in) :: unknown
    integer :: i
    associate (v => d%decision)
      call json%open_object('verdict')
      call json%put('word', verdict_word(v%verdict))
      call json%put('exit_code', v%verdict)
      call json%put('sentence', verdict_sentence(s, d))
      call json%put('statement', verdict_statement(s, d))
      call json%put('grade', trim(grade_of(v%verdict)))
      call json%put('probability', stated_probability(v))
      call json%put('probability_raw', v%probability)
      call json%put('probability_map', provenance_of(v%probability_map))
      call json%put('global_p', exp(max(-700.0_rp, v%log_p_global)))
      call json%put('log_global_p', v%log_p_global)
      call json%put('log_p_of_tests', v%log_p_tests)
      call json%put('log_p_of_checks', v%log_p_checks)
      call json%put('alarm', alarm_name(d))
      call json%put('snr', v%snr)
      call json%put('remainder_log_p', v%remainder_log_p)
      call json%put('rejection_power', v%name_power)
      call json%put('imitation', v%imitation)
      call json%put('is_together', v%is_joint)
      call json%put('set_because', trim(v%reason))
      call json%put('linear_word', verdict_word(d%tests%decision%verdict))
      call json%put('posterior_none', v%posterior_none)
      call json%put('posterior_together', v%posterior_joint)
      call json%put('posterior_unknown', v%posterior_unknown)
      call json%open_list('causes')
      do i = 1, size(v%causes)
        call json%open_object('')
        call json%put('effect', s%catalogue%effects(d%model%design%candidates(v%causes(i))%effect)%name)
        call json%put('name', cause_name(s, d, i))
        call json%put('finding', cause_finding(s, d, i))
        call put_flight_test(json, s, d, i)
        associate (one => d%model%design%candidates(v%causes(i)))
          call json%put('variant', s%catalogue%effects(one%effect)%variants(one%variant)%label)
          call json%put('place', s%catalogue%effects(one%effect)%variants(one%variant)%site)
        end associate
        call json%close()
      end do
      call json%close()
      call json%open_list('set')
      do i = 1, size(v%set)
        call json%put('', s%catalogue%effects(v%set(i))%name)
      end do
      call json%close()
      call json%open_list('wider')
      do i = 1, size(v%wider)
        call json%put('', s%catalogue%effects(v%wider(i))%name)
      end do
      call json%close()
      call put_unknown(json, s, unknown)
      call json%close()
    end associate
  end subroutine put_verdict

  !> Writes the declared and the estimated errors of the measurement.
  subroutine put_noise(json, s, d)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    call json%open_object('noise')
    call json%put('declared_m', s%noise%declared)
    call json%put('white_m', s%noise%white)
    call json%put('differences', s%noise%n)
    call json%put('white_share', s%noise%model%white)
    call json%put('correlation_length_m', s%noise%model%length)
    call json%put('variance_ratio', d%tests%scale)
    call json%put('is_scale_estimated',.not. s%options%is_scale_known)
    call json%put('warning', s%noise%warning)
    call json%open_object('heavy_tails')
    call json%put('title', 'heights that stand out')
    call json%put('sentence', 'Single heights do not belong to the surface around them: specks, gaps of the light or wrong '// &
                  'fringes.')
    call json%put('is_found', s%outliers%n > 0)
    call json%put('heights_left_out', s%outliers%n)
    call json%put('heights_tested', s%outliers%n_tested)
    call json%put('share_90', s%outliers%fraction)
    call json%close()
    call json%close()
  end subroutine put_noise

  !> Writes the fit without any effect.
  subroutine put_baseline(json, s, d)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    call json%open_object('baseline')
    call json%put('observations', s%bins%n + s%measurement%count_mode_observations() + &
                  s%measurement%count_series_observations() + s%measurement%count_flight_observations())
    call json%put('loads', size(s%measurement%loads))
    call json%put('square_m', s%bins%size)
    call json%put('chi2', d%initial_baseline%chi2)
    call json%put('prior_chi2', d%initial_baseline%prior_chi2)
    call json%put('spread_of_starts', d%spread)
    call put_parameters(json, s, d%initial_baseline)
    call json%close()
  end subroutine put_baseline

  !> Writes the fitted values in their units, and the sd of their coordinates.
  subroutine put_parameters(json, s, fit)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(nested_fit_t), intent(in) :: fit
    integer :: i
    call json%open_list('parameters')
    do i = 1, size(fit%active)
      associate (one => s%catalogue%parameters(fit%active(i)), q => fit%q(fit%active(i)))
        call json%open_object('')
        call json%put('name', one%name)
        call json%put('unit', one%unit)
        if (one%is_log) call json%put('value', exp(q))
        if (.not. one%is_log) call json%put('value', q)
        call json%put('is_log', one%is_log)
        if (allocated(fit%covariance)) call json%put('sd', sqrt(max(0.0_rp, fit%covariance(i, i))))
        call json%put('prior_sd', one%prior_sd)
        call json%close()
      end associate
    end do
    call json%close()
  end subroutine put_parameters

  !> Writes a sentence for every parameter of the causes that were fitted.
  subroutine put_findings(json, s, d)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer :: i, k
    call json%open_list('findings')
    do i = 1, size(d%decision%causes)
      associate (columns => d%model%design%candidates(d%decision%causes(i))%columns)
        do k = 1, size(columns)
          call json%open_object('')
          call json%put('name', s%catalogue%parameters(columns(k))%name)
          call json%put('sentence', parameter_finding(s, d, i, k))
          call json%close()
        end do
      end associate
    end do
    call json%close()
  end subroutine put_findings

  !> Writes what is known about effect `e`: whether it was tested, how likely it is and from which strength on it is detectable.
  subroutine put_effect(json, s, d, e)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: e
    real(rp), parameter :: FAINT = 1.0e-100_rp
    character(12) :: status
    integer :: c, i
    associate (effect => s%catalogue%effects(e))
      c = 0
      if (allocated(d%tests%statistics%best)) c = d%tests%statistics%best(e)
      status = 'tested'
      if (c == 0) status = 'absorbed'
      if (.not. effect%is_testable()) status = 'not_testable'
      call json%open_object('')
      call json%put('name', effect%name)
      call json%put('title', effect%title)
      call json%put('sentence', effect%sentence)
      call json%put('is_measurement', effect%is_measurement)
      call json%put('variants', size(effect%variants))
      call json%put('status', trim(status))
      call json%put('missing', effect%missing)
      if (effect_finding(s, d, e) /= '') call json%put('finding', effect_finding(s, d, e))
      if (c > 0) then
        associate (one => d%model%design%candidates(c))
          call json%put('variant', effect%variants(one%variant)%label)
          call json%put('place', effect%variants(one%variant)%site)
          call json%put('chi2', d%tests%statistics%squares(c))
          call json%put('df', one%df)
          call json%put('local_p', exp(max(-700.0_rp, d%tests%statistics%log_p(c))))
          call json%put('p', exp(max(-700.0_rp, d%model%calibration%log_p_effect(e, d%tests%statistics%effect(e)))))
          call json%put('retained', one%retained)
          call json%put('estimate', -matmul(one%solve, matmul(d%tests%z, one%basis))) ! z is computed less observed
          call json%put('standard_error', [(norm2(one%solve(i, :)), i=1, size(one%columns))])
          call json%put('log_evidence', d%hypotheses%effect(e))
          call json%put('posterior', d%decision%posterior(e))
          call json%put('detectable_snr', d%detectable_snr(e))
          ! A parameter that the baseline imitates completely is not detectable at any strength.
          call json%put('detectable', [(merge(huge(1.0_rp), d%detectable_snr(e)/max(norm2(one%tangents(:, i)), FAINT), &
                                              norm2(one%tangents(:, i)) < FAINT), i=1, size(one%columns))])
          call json%put('shows_from', shows_from(s, d, e))
          call json%open_list('parameters')
          do i = 1, size(one%columns)
            call json%put('', s%catalogue%parameters(one%columns(i))%name)
          end do
          call json%close()
        end associate
      end if
      call json%close()
    end associate
  end subroutine put_effect

  !> Writes the fit with the effects that were found, and their intervals.
  subroutine put_extension(json, s, d)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    real(rp) :: ends(3)
    integer :: i, column
    call json%open_object('extended')
    call json%put('is_found', d%extended%is_found)
    if (d%extended%is_found) then
      call json%put('chi2', d%extended%chi2)
      call json%put('prior_chi2', d%extended%prior_chi2)
      call put_parameters(json, s, d%extended)
      call put_findings(json, s, d)
      if (allocated(d%intervals)) then
        call json%put('is_null_excluded', d%support%is_null_excluded)
        call json%put('is_at_bound', d%support%is_at_bound)
        call json%open_list('intervals_90')
        do i = 1, size(d%intervals)
          column = d%extended%active(size(d%model%baseline%active) + i)
          ends = [d%intervals(i)%lower, d%intervals(i)%best, d%intervals(i)%upper]
          if (s%catalogue%parameters(column)%is_log) ends = exp(ends)
          call json%open_object('')
          call json%put('name', s%catalogue%parameters(column)%name)
          call json%put('lower_best_upper', ends)
          call json%put('has_lower', d%intervals(i)%has_lower)
          call json%put('has_upper', d%intervals(i)%has_upper)
          call json%put('lower_is_jump', d%intervals(i)%is_jump(1))
          call json%put('upper_is_jump', d%intervals(i)%is_jump(2))
          call json%close()
        end do
        call json%close()
      end if
    end if
    call json%close()
  end subroutine put_extension

  !> Writes how well the two fits predict loads that they did not see.
  subroutine put_validation(json, d)
    type(json_t), intent(inout) :: json
    type(diagnosis_t), intent(in) :: d
    call json%open_object('validation')
    call json%put('has_gain', d%prediction%has_gain)
    call json%put('gain_per_location', d%prediction%gain)
    call json%put('standard_error', d%prediction%gain_error)
    if (allocated(d%prediction%baseline%fold)) call put_folds(json, 'baseline', d%prediction%baseline)
    if (allocated(d%prediction%extended%fold)) call put_folds(json, 'extended', d%prediction%extended)
    call json%close()
  end subroutine put_validation

  !> Writes the zero readings of one instrument, if there are several, with their differences from the first one [m].
  subroutine put_zeros(json, zeros)
    type(json_t), intent(inout) :: json
    type(zeros_t), intent(in) :: zeros
    integer :: i
    call json%open_object('zeros')
    call json%put('p_equal', exp(max(-700.0_rp, zeros%log_p)))
    call json%open_list('readings')
    do i = 1, size(zeros%value)
      call json%open_object('')
      call json%put('name', trim(zeros%names(i)))
      call json%put('value_m', zeros%value(i))
      call json%put('sd_m', zeros%sd(i))
      call json%put('difference_to_first_m', zeros%difference(i))
      call json%put('difference_sd_m', zeros%error(i))
      call json%close()
    end do
    call json%close()
    call json%close()
  end subroutine put_zeros

  !> Writes the cross-validation of one fit, location by location.
  subroutine put_folds(json, name, v)
    type(json_t), intent(inout) :: json
    character(*), intent(in) :: name
    type(validation_t), intent(in) :: v
    call json%open_object(name)
    call json%put('location', real(v%fold, rp))
    call json%put('observations', real(v%n, rp))
    call json%put('log_density', v%density)
    call json%put('chi2', v%chi2)
    call json%put('sum_of_squares', v%square)
    call json%close()
  end subroutine put_folds
end module diagnose_json
