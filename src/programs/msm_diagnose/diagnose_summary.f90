! SPDX-License-Identifier: GPL-3.0-or-later
!> What a diagnosis says on the terminal, in at most 15 lines.
module diagnose_summary
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_modes, only: print_modes
  use diagnose_settings, only: diagnose_settings_t
  use diagnose_unknown, only: print_unknown
  use diagnosis_band, only: mesh_band_t
  use diagnosis_next, only: next_t
  use diagnosis_unknown, only: candidate_name, unknown_t
  use diagnosis_zeros, only: zeros_t
  use inference_decision, only: decision_t, verdict_word, AT_BOUND, NO_FIT, NO_GAIN, NO_INTERVAL, VERDICT_ADEQUATE, &
                                VERDICT_NAMED, VERDICT_SET, VERDICT_UNKNOWN
  use inference_engine, only: diagnosis_t
  use inference_stated, only: stated_probability
  implicit none
  private
  public :: print_verdict, verdict_sentence, cause_name, probability_text, value_text

contains

  !> At most 14 lines, and 15 with the notice of a wrong declared error; two more with natural modes.
  subroutine print_verdict(unit, s, d, band, next, zeros, unknown)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(mesh_band_t), intent(in) :: band
    type(next_t), intent(in) :: next
    type(zeros_t), intent(in) :: zeros
    type(unknown_t), intent(in) :: unknown
    character(:), allocatable :: extended
    character(200) :: line
    integer :: i
    call print_data(unit, s)
    if (band%is_found) then
      write (line, '(a,f0.2,a,f0.1,a,i0,a)') 'mesh      changes heights by ', 1.0e6_rp*band%rms, &
        ' um rms after a refit, as a signal-to-noise ratio of ', band%snr, ' (', band%n_points, ' points)'
      if (s%bins%n == 0) write (line, '(a,f0.1,a,i0,a)') 'mesh      changes modes after a refit, as a signal-to-noise ratio of ', &
        band%snr, ' (', band%n_points, ' points)'
      if (s%fits_finer) line = line(:len_trim(line) - 1)//', on which all is fitted)'
      write (unit, '(a)') trim(line)
    end if
    write (line, '(a,f0.1,a,i0,a,f0.3)') 'baseline  chi^2 = ', d%plain%chi2, ' of ', &
        s%bins%n + s%measurement%count_mode_observations(), &
      '; variance over that of the noise model ', d%scale
    write (unit, '(a)') trim(line)
    write (line, '(a,a,a,f0.1)') 'misfit    global p = ', probability_text(d%decision%log_p_global), &
      '; signal-to-noise ratio of the causes ', d%decision%snr
    write (unit, '(a)') trim(line)
    write (unit, '(a)') 'verdict   '//verdict_word(d%decision%verdict)//': '//verdict_sentence(s, d)
    if (d%decision%verdict == VERDICT_UNKNOWN) then
      call print_unknown(unit, unknown)
    else if (d%decision%verdict /= VERDICT_ADEQUATE) then
      do i = 1, min(2, size(d%decision%causes))
        associate (effect => s%catalogue%effects(d%design%candidates(d%decision%causes(i))%effect))
          write (unit, '(a)') '          '//effect%sentence
        end associate
      end do
      do i = 1, min(merge(2, 3, size(zeros%value) > 1), parameter_count(d))
        write (unit, '(a)') '          '//value_text(s, d, i)
      end do
    end if
    if (size(zeros%value) > 1) call print_zeros(unit, zeros)
    if (d%has_gain) then
      write (line, '(a,f0.2,a,f0.2,a)') 'gain      of log predictive density ', d%gain, ' +- ', d%gain_error, &
        ' for a location that was left out'
      write (unit, '(a)') trim(line)
    end if
    call print_modes(unit, s, d)
    if (size(next%order) > 0) call print_next(unit, s, d, next)
    extended = ''
    if (d%extended%is_found) extended = ', _extended.ini'
    write (unit, '(a)') 'files     '//s%name//'.json, .h5, _baseline.ini'//extended//', _next_measurements.csv; '// &
      'tools/plot_diagnosis '//s%name//'.json makes the report'
    flush (unit)
  end subroutine print_verdict

  !> The sensor whose zero differs most from that of the first one.
  subroutine print_zeros(unit, zeros)
    integer, intent(in) :: unit
    type(zeros_t), intent(in) :: zeros
    character(200) :: line
    integer :: i
    i = maxloc(abs(zeros%difference)/max(zeros%error, tiny(1.0_rp)), 1)
    write (line, '(a,es9.2,a,es8.1,3a)') ' reads ', abs(zeros%difference(i)), ' m +-', zeros%error(i), ' m ', &
      merge('more', 'less', zeros%difference(i) > 0), ' than '
    write (unit, '(a)') 'zeros     '//trim(zeros%names(i))//trim(line)//' '//trim(zeros%names(1))// &
      '; they are equal with p = '//probability_text(zeros%log_p)
  end subroutine print_zeros

  !> The load that separates the cause from its nearest rival best: a repeat or a new place.
  subroutine print_next(unit, s, d, next)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(next_t), intent(in) :: next
    real(rp), parameter :: NOTHING = 1.0_rp ! [sd]
    character(:), allocatable :: what, cause, rival
    character(120) :: line
    real(rp) :: after
    cause = effect_name(next%cause)
    rival = effect_name(next%rivals(1))
    after = next%after(next%order(1))
    what = 'repeat '//s%measurement%surface_name(next%order(1))
    if (size(next%places) > 0) then
      associate (load => next%places(1))
        if (load%after > after) then
          after = load%after
          write (line, '(a,es10.3,a,es10.3,a,es10.2,a)') 'push at ', load%place(1), ' ', load%place(2), ' m with', &
            load%force*sign(1.0_rp, load%direction(3)), ' N'
          what = trim(line)
        end if
      end associate
    end if
    if (after < NOTHING) then
      write (unit, '(a)') 'next      no further load of this kind tells '//cause//' from '//rival
    else
      write (line, '(2(a,f0.1),a)') ' is then ', after, ' sd from all others, now ', next%now(1), ' sd from '
      write (unit, '(a)') 'next      '//what//': '//cause//trim(line)//' '//rival
    end if

  contains

    pure function effect_name(candidate) result(name)
      integer, intent(in) :: candidate
      character(:), allocatable :: name
      name = s%catalogue%effects(d%design%candidates(candidate)%effect)%name
    end function effect_name

  end subroutine print_next

  !> What was measured, and how exactly.
  subroutine print_data(unit, s)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    character(120) :: line
    if (s%measurement%count_modes() > 0) then
      write (line, '(a,i0,a,i0,a)') 'data      ', s%measurement%count_modes(), ' natural modes, ', &
        s%measurement%count_mode_observations(), ' numbers; '
      write (unit, '(a)') trim(line)//' '//s%measurement_path
      if (size(s%measurement%loads) == 0) return
    end if
    if (.not. any(s%measurement%loads%has_surface)) then
      write (line, '(a,i0,a,i0,a)') 'data      ', size(s%measurement%loads), ' loads, ', s%bins%n, &
        ' readings of single points; '
      write (unit, '(a)') trim(line)//' '//s%measurement_path
      write (unit, '(a)') 'noise     as the file declares for each reading'
      return
    end if
    write (line, '(a,i0,a,i0,a,es10.3,a)') 'data      ', size(s%measurement%loads), ' loads, ', s%bins%n, &
      ' averages over squares of ', s%bins%size, ' m; '
    write (unit, '(a)') trim(line)//' '//s%measurement_path
    write (line, '(a,f0.2,a,f0.2,a)') 'noise     neighbours scatter by ', 1.0e6_rp*s%noise%white, &
      ' um, declared are ', 1.0e6_rp*s%noise%declared, ' um'
    if (s%outliers%n > 0) line = trim(line)//'; '//number_text(s%outliers%n)//' heights stand out and are left out'
    write (unit, '(a)') trim(line)
  end subroutine print_data

  !> One sentence.
  function verdict_sentence(s, d) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    character(:), allocatable :: text
    character(8) :: percent
    integer :: i
    write (percent, '(f0.0)') 100*stated_probability(d%decision%verdict, d%decision%probability)
    percent = percent(:len_trim(percent) - 1)
    select case (d%decision%verdict)
    case (VERDICT_ADEQUATE)
      text = 'the model explains these data within their errors'
      return
    case (VERDICT_NAMED)
      text = ''
      do i = 1, size(d%decision%causes)
        text = text//' and '//cause_name(s, d, i)
      end do
      text = text(6:)
    case (VERDICT_SET)
      text = 'these data cannot tell apart:'
      do i = 1, size(d%decision%set)
        text = text//' '//s%catalogue%effects(d%decision%set(i))%title
        if (i < size(d%decision%set)) text = text//';'
      end do
      if (d%decision%is_together) then
        text = 'consistent with'
        do i = 1, size(d%decision%causes)
          text = text//' '//cause_name(s, d, i)//trim(merge(' and', '    ', i < size(d%decision%causes)))
        end do
        text = text//' together; other causes are not excluded'//because(d%decision)
      end if
      if (size(d%decision%set) == 1) text = 'consistent with '//s%catalogue%effects(d%decision%set(1))%title// &
                                            '; other causes are not excluded'//because(d%decision)
    case (VERDICT_UNKNOWN)
      text = 'something that is not in the catalogue'
    case default
      text = 'there are too few data to test anything'
      return
    end select
    text = text//' (probability '//trim(percent)//' %)'
  end function verdict_sentence

  !> Why the fit of what could have been a name speaks against it, or nothing.
  pure function because(decision) result(text)
    type(decision_t), intent(in) :: decision
    character(:), allocatable :: text
    select case (decision%reason)
    case (AT_BOUND)
      text = ', as the fit stands at a bound'
    case (NO_INTERVAL)
      text = ', as an interval holds that there is none'
    case (NO_GAIN)
      text = ', as it predicts no better'
    case (NO_FIT)
      text = ', as it cannot be fitted'
    case default
      text = ''
    end select
  end function because

  !> Title and place of a cause.
  function cause_name(s, d, i) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: i
    character(:), allocatable :: text
    text = candidate_name(s, d, d%decision%causes(i))
  end function cause_name

  !> Parameters of the causes that were fitted.
  pure integer function parameter_count(d) result(n)
    type(diagnosis_t), intent(in) :: d
    n = 0
    if (d%extended%is_found) n = size(d%extended%active) - size(d%baseline%active)
  end function parameter_count

  !> Parameter number i of the causes: value and, where it was sought, interval.
  function value_text(s, d, i) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: i
    character(:), allocatable :: text
    integer :: column
    column = d%extended%active(size(d%baseline%active) + i)
    associate (q => s%catalogue%quantities(column))
      text = q%name//' = '//shown(d%extended%q(column))//unit()
      if (.not. allocated(d%intervals)) return
      associate (one => d%intervals(i))
        if (one%has_lower .and. one%has_upper) then
          text = text//', with 90 % confidence between '//shown(one%lower)//' and '//shown(one%upper)//unit()
        else if (one%has_lower) then
          text = text//', with 95 % confidence more than '//shown(one%lower)//unit()
        else if (one%has_upper) then
          text = text//', with 95 % confidence less than '//shown(one%upper)//unit()
        end if
        if (any(one%is_jump)) text = text//' (it ends where a shape jumps)'
      end associate
    end associate

  contains

    function shown(x) result(number)
      real(rp), intent(in) :: x
      character(:), allocatable :: number
      character(16) :: buffer
      if (s%catalogue%quantities(column)%is_log) then
        write (buffer, '(es11.3)') exp(x)
      else
        write (buffer, '(es11.3)') x
      end if
      number = trim(adjustl(buffer))
    end function shown

    function unit() result(word)
      character(:), allocatable :: word
      word = ''
      if (s%catalogue%quantities(column)%unit /= '1') word = ' '//s%catalogue%quantities(column)%unit
    end function unit

  end function value_text

  !> A probability from its logarithm.
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
