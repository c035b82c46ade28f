! SPDX-License-Identifier: GPL-3.0-or-later
!> Prints what a diagnosis found on the terminal, in at most 22 lines.
module diagnose_summary
  use base_decimal, only: fixed
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_counts, only: print_kinds
  use diagnose_findings, only: cause_finding
  use diagnose_flight_tests, only: print_flight_tests
  use diagnose_modes, only: print_modes
  use diagnose_next, only: print_next
  use diagnose_settings, only: diagnose_settings_t
  use diagnose_unknown, only: print_unknown
  use diagnosis_discretisation, only: discretisation_error_t
  use diagnosis_next_measurement, only: next_measurement_t
  use diagnosis_unknown, only: candidate_name, unknown_t
  use diagnosis_zeros, only: zeros_t
  use inference_decision, only: decision_t, stated_probability, stated_rest, verdict_word, AT_BOUND, LEVEL, NO_FIT, NO_GAIN, &
                                NO_INTERVAL, TESTS_FRACTION, VERDICT_ADEQUATE, VERDICT_NAMED, VERDICT_SET, VERDICT_UNKNOWN
  use inference_residual_checks, only: most_significant
  use inference_engine, only: diagnosis_t
  implicit none
  private
  public :: alarm_of, cause_name, print_verdict, verdict_sentence, verdict_statement

contains

  !> Prints on `unit`, in at most 22 lines, the data, the misfit of the baseline, the verdict with its causes, and what to measure
  !> next.
  subroutine print_verdict(unit, s, d, discretisation, next, zeros, unknown)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(discretisation_error_t), intent(in) :: discretisation
    type(next_measurement_t), intent(in) :: next
    type(zeros_t), intent(in) :: zeros
    type(unknown_t), intent(in) :: unknown
    integer, parameter :: MOST_CAUSES = 3
    character(:), allocatable :: what
    integer :: i
    call print_data(unit, s)
    if (discretisation%is_found) then
      what = 'heights by '//fixed(1.0e6_rp*discretisation%rms, 2)//' um rms'
      if (s%bins%n == 0) what = 'the motion'
      what = what//' after a refit, as a signal-to-noise ratio of '//fixed(discretisation%snr, 1)//' ('// &
             number_text(discretisation%n_points)//' points'
      if (s%fits_finer) what = what//'; all fits use this mesh'
      write (unit, '(a)') 'mesh      changes '//what//')'
    end if
    call print_misfit(unit, s, d)
    if (allocated(d%tests%checks)) call print_alarm(unit, d)
    write (unit, '(a)') 'verdict   '//verdict_word(d%decision%verdict)//': '//verdict_sentence(s, d)
    if (d%decision%verdict == VERDICT_UNKNOWN) then
      call print_unknown(unit, unknown)
    else if (d%decision%verdict /= VERDICT_ADEQUATE) then
      do i = 1, min(MOST_CAUSES, size(d%decision%causes))
        write (unit, '(a)') '          '//told_cause(s, d, i)
      end do
    end if
    call print_flight_tests(unit, s, d)
    if (size(zeros%value) > 1) call print_zeros(unit, zeros)
    if (d%prediction%has_gain) then
      write (unit, '(a)') 'gain      of log predictive density '//fixed(d%prediction%gain, 2)//' +- '// &
        fixed(d%prediction%gain_error, 2)//' for each location that was left out'
    end if
    call print_modes(unit, s, d)
    call print_next(unit, s, d, next)
    flush (unit)
  end subroutine print_verdict

  !> Prints how well the baseline fits, and the probability that noise alone gives such a misfit.
  subroutine print_misfit(unit, s, d)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer :: n
    n = s%bins%n + s%measurement%count_mode_observations() + s%measurement%count_series_observations() + &
        s%measurement%count_flight_observations()
    write (unit, '(a)') 'baseline  chi^2 = '//fixed(d%initial_baseline%chi2, 1)//' of '//number_text(n)// &
      ' numbers; variance over that of the noise model '//fixed(d%tests%scale, 3)
    call print_kinds(unit, s, d)
    write (unit, '(a)') 'misfit    noise alone gives differences of this size with p = '// &
      probability_text(d%decision%log_p_global)// &
      ' (all tests and checks together); signal-to-noise ratio of the causes '//fixed(d%decision%snr, 1)
    if (hides_cause(n, d)) write (unit, '(a)') '          (a good chi^2 can hide a cause: it sums the noise of all '// &
      'observations, and a cause shows in few combinations of them)'
  end subroutine print_misfit

  !> Tells whether a misfit was found although the sum of squares is at most two sd above the mean that noise gives.
  pure logical function hides_cause(n, d) result(hides)
    integer, intent(in) :: n
    type(diagnosis_t), intent(in) :: d
    hides = d%decision%log_p_global < log(LEVEL) .and. d%initial_baseline%chi2 < n + 2*sqrt(2.0_rp*n)
  end function hides_cause

  !> Describes a cause with its sign, size and interval, or in general terms if it was not fitted. Without a name it begins with
  !> 'if'.
  function told_cause(s, d, i) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: i
    character(:), allocatable :: text
    text = cause_finding(s, d, i)
    if (text == '') text = s%catalogue%effects(d%model%design%candidates(d%decision%causes(i))%effect)%sentence
    if (d%decision%verdict == VERDICT_SET) &
      text = 'if it is '//s%catalogue%effects(d%model%design%candidates(d%decision%causes(i))%effect)%title//': '//text
  end function told_cause

  !> Prints the sensor whose zero differs most from that of the first one, in units of the error of the difference.
  subroutine print_zeros(unit, zeros)
    integer, intent(in) :: unit
    type(zeros_t), intent(in) :: zeros
    character(200) :: line
    integer :: i
    i = maxloc(abs(zeros%difference)/max(zeros%error, tiny(1.0_rp)), 1)
    write (line, '(a,es9.2,a,es8.1,3a)') ' is ', abs(zeros%difference(i)), ' m +-', zeros%error(i), ' m ', &
      merge('above', 'below', zeros%difference(i) > 0), ' that of '
    write (unit, '(a)') 'zeros     the zero of '//trim(zeros%names(i))//trim(line)//' '//trim(zeros%names(1))// &
      '; p = '//probability_text(zeros%log_p)//' if all zeros are equal'
  end subroutine print_zeros

  !> Prints the check of the residuals that speaks against the baseline, if there is one.
  subroutine print_alarm(unit, d)
    integer, intent(in) :: unit
    type(diagnosis_t), intent(in) :: d
    integer :: at
    at = alarm_of(d)
    if (at == 0) return
    write (unit, '(a)') 'check     of the residuals of the baseline: '//d%tests%checks(at)%sentence//' (p = '// &
      probability_text(d%tests%checks(at)%log_p)//' of '//number_text(count(d%tests%checks%takes_part))//' checks)'
  end subroutine print_alarm

  !> Prints what was measured, and how exactly, in two lines.
  subroutine print_data(unit, s)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    character(:), allocatable :: what
    what = 'data      '
    if (s%measurement%count_modes() > 0) what = what//number_text(s%measurement%count_modes())//' natural modes ('// &
                                                number_text(s%measurement%count_mode_observations())//' numbers), '
    if (s%measurement%count_series() > 0) what = what//number_text(s%measurement%count_series())//' records of motion ('// &
                                                 number_text(s%measurement%count_series_observations())//' numbers), '
    if (s%measurement%count_flights(.false.) > 0) what = what//number_text(s%measurement%count_flights(.false.))// &
                              ' records of forces ('//number_text(s%measurement%count_flight_observations(.false.))//' numbers), '
    if (s%measurement%count_flights(.true.) > 0) what = what//number_text(s%measurement%count_flights(.true.))// &
                            ' records of landmarks ('//number_text(s%measurement%count_flight_observations(.true.))//' numbers), '
    if (size(s%measurement%loads) == 0) then
      write (unit, '(a)') what(:len(what) - 2)//'; '//s%measurement_path
      return
    end if
    what = what//number_text(size(s%measurement%loads))//' loads, '//number_text(s%bins%n)
    if (.not. any(s%measurement%loads%has_surface)) then
      write (unit, '(a)') what//' readings of single points; '//s%measurement_path
      write (unit, '(a)') 'noise     as the file declares for each reading'
      return
    end if
    write (unit, '(a)') what//' averages over squares of '//fixed(1.0e3_rp*s%bins%size, 2)//' mm; '//s%measurement_path
    what = 'noise     neighbouring heights scatter by '//fixed(1.0e6_rp*s%noise%white, 2)// &
           ' um; the declared standard deviation is '//fixed(1.0e6_rp*s%noise%declared, 2)//' um'
    if (s%outliers%n > 0) what = what//'; '//number_text(s%outliers%n)//' outliers are left out'
    write (unit, '(a)') what
  end subroutine print_data

  !> Returns one sentence that states the verdict. Only a name says that a cause is there; a set says what else may be.
  function verdict_sentence(s, d) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    character(:), allocatable :: text
    select case (d%decision%verdict)
    case (VERDICT_ADEQUATE)
      text = 'the model explains these data within their errors'
      return
    case (VERDICT_NAMED)
      text = cause_names(s, d)
      if (d%decision%posterior_joint > LEVEL .and. .not. d%decision%is_joint) &
        text = text//'; a second cause beside it is not excluded ('//percent_text(d%decision%posterior_joint)//' %)'
    case (VERDICT_SET)
      text = set_sentence(s, d)
    case (VERDICT_UNKNOWN)
      text = 'something that is not in the catalogue'
      if (alarm_of(d) > 0 .and. d%decision%is_rejected_by_checks) text = text//', as '//d%tests%checks(alarm_of(d))%sentence
    case default
      text = 'there are too few data to test anything'
      return
    end select
    text = text//' (probability '//percent_text(stated_probability(d%decision))//' %)'//wider_text(s, d)//unsettled(d)
  end function verdict_sentence

  !> Returns the wider changes of which the first cause may be a part. The text is empty if there are none.
  function wider_text(s, d) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(d%decision%wider)
      text = text//' or '//s%catalogue%effects(d%decision%wider(i))%title
    end do
    if (text /= '') text = '; '//s%catalogue%effects(d%decision%set(1))%title//' may be a part of a wider change, '// &
                           'which explains the data as well: '//text(5:)
  end function wider_text

  !> Returns the causes of the verdict with 'and' between them.
  function cause_names(s, d) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(d%decision%causes)
      text = text//' and '//cause_name(s, d, i)
    end do
    text = text(6:)
  end function cause_names

  !> Returns the sentence on a set, without its probability: its causes, and what else may be.
  function set_sentence(s, d) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    character(:), allocatable :: text
    integer :: i
    if (d%decision%is_joint) then
      text = 'consistent with '//cause_names(s, d)//' together; other causes are not excluded'//because(d%decision)//': '// &
             rest_text(d%decision, ', ')
    else if (size(d%decision%set) == 1) then
      text = 'consistent with '//s%catalogue%effects(d%decision%set(1))%title//'; other causes are not excluded'// &
             because(d%decision)//': '//rest_text(d%decision, ', ')
    else
      text = 'these data cannot tell apart:'
      do i = 1, size(d%decision%set)
        text = text//' '//s%catalogue%effects(d%decision%set(i))%title//';'
      end do
      text = text//' nor from '//rest_text(d%decision, ', nor from ')
    end if
  end function set_sentence

  !> Returns with their probabilities what a set leaves: an unknown cause always, and what else is not excluded.
  function rest_text(decision, between) result(text)
    type(decision_t), intent(in) :: decision
    character(*), intent(in) :: between
    character(:), allocatable :: text
    character(*), parameter :: WHAT(2:4) = [character(22) :: 'several causes at once', 'another of its causes', 'no cause at all']
    real(rp) :: rest(4)
    integer :: i
    rest = stated_rest(decision)
    text = 'something that is not in the catalogue ('//percent_text(rest(1))//' %)'
    do i = 2, 4
      if (rest(i) > LEVEL) text = text//between//trim(WHAT(i))//' ('//percent_text(rest(i))//' %)'
    end do
  end function rest_text

  !> Returns the verdict in words with what is known of each of its causes: sign, size, unit and interval.
  function verdict_statement(s, d) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    character(:), allocatable :: text
    integer :: i
    text = verdict_sentence(s, d)
    if (all(d%decision%verdict /= [VERDICT_NAMED, VERDICT_SET])) return
    do i = 1, size(d%decision%causes)
      text = text//'. '//told_cause(s, d, i)
    end do
  end function verdict_statement

  !> Returns by how much the fitted values still changed in the last round of simulated flights. The text is empty if they have
  !> settled, if there are no causes, or if no flight was simulated again.
  function unsettled(d) result(text)
    type(diagnosis_t), intent(in) :: d
    character(:), allocatable :: text
    text = ''
    if (.not. allocated(d%rounds%moved)) return
    if (d%rounds%has_settled .or. .not. d%extended%is_found) return
    if (all(d%decision%verdict /= [VERDICT_NAMED, VERDICT_SET])) return
    if (d%rounds%reason /= '') then
      text = '; not simulated with the fitted values: '//d%rounds%reason
    else if (size(d%rounds%moved) > 0) then
      text = '; not settled: the last simulation with the fitted values still changed them by '// &
             fixed(d%rounds%moved(size(d%rounds%moved)), 1)//' sd'
    end if
  end function unsettled

  !> Returns a probability in percent, never as 0 or 100.
  function percent_text(probability) result(text)
    real(rp), intent(in) :: probability
    character(:), allocatable :: text
    text = number_text(nint(100*probability))
    if (100*probability < 1) text = 'below 1'
    if (nint(100*probability) >= 100) text = 'over 99'
  end function percent_text

  !> Returns the most significant check of the residuals of the baseline, if all together speak against it; else 0.
  pure integer function alarm_of(d) result(at)
    type(diagnosis_t), intent(in) :: d
    at = 0
    if (.not. allocated(d%tests%checks)) return
    if (d%decision%log_p_checks <= log(LEVEL*(1 - TESTS_FRACTION))) at = most_significant(d%tests%checks)
  end function alarm_of

  !> Returns why the fit of a cause that could have been named speaks against naming it. The text is empty if the fit does not.
  pure function because(decision) result(text)
    type(decision_t), intent(in) :: decision
    character(:), allocatable :: text
    select case (decision%reason)
    case (AT_BOUND)
      text = ', because the fitted value reached its bound'
    case (NO_INTERVAL)
      text = ', because its interval contains no effect at all'
    case (NO_GAIN)
      text = ', because it does not improve the prediction of data left out'
    case (NO_FIT)
      text = ', because its fit does not converge'
    case default
      text = ''
    end select
  end function because

  !> Returns the title and the site of cause i of the verdict.
  function cause_name(s, d, i) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: i
    character(:), allocatable :: text
    text = candidate_name(s, d, d%decision%causes(i))
  end function cause_name

  !> Returns the text of a probability whose logarithm is given.
  function probability_text(log_p) result(text)
    real(rp), intent(in) :: log_p
    character(:), allocatable :: text
    character(16) :: buffer
    if (log_p > log(1.0e-3_rp)) then
      write (buffer, '(f6.3)') exp(log_p)
    else
      write (buffer, '(a,i0)') '1e', floor(log_p/log(10.0_rp))
    end if
    text = trim(adjustl(buffer))
  end function probability_text
end module diagnose_summary
