! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the comparison of two flights, that of the baseline and that with what was found, for people and to NAME.json.
module diagnose_comparison
  use base_decimal, only: fixed
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_flight_means, only: COMPARED, flight_comparison_t, N_COMPARED
  use io_json, only: json_t
  implicit none
  private
  public :: print_comparison, put_comparison

  character(*), parameter :: UNITS(N_COMPARED) = [character(4) :: 'N', 'N', 'W', '1', 's/m']        !< SI, of wings in space
  character(*), parameter :: SHOWN(N_COMPARED) = [character(4) :: ' mN', ' mN', ' mW', '', ' s/m']  !< on the terminal
  real(rp), parameter :: SCALES(N_COMPARED) = [1.0e3_rp, 1.0e3_rp, 1.0e3_rp, 1.0_rp, 1.0_rp]        !< from SI to these
  integer, parameter :: LAST_WITH_LENGTH = 3 !< of a section these are per metre

contains

  !> Prints on `unit`, in up to seven lines, lift, drag, power, lift/drag and lift/power of both flights, with the 90 % interval of
  !> the second one and the change in percent of the first. Prints nothing if nothing was compared.
  subroutine print_comparison(unit, s)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    integer :: i
    associate (c => s%comparison)
      if (.not. c%is_known) then
        if (allocated(c%reason)) write (unit, '(a)') 'compared  the flights of both wings are not compared: '//c%reason
        flush (unit)
        return
      end if
      write (unit, '(a)') 'compared  '//what_is_compared(c)//': means over the beat, and 90 % of what the fit leaves'
      do i = 1, N_COMPARED
        write (unit, '(a)') '          '//line_of(c, i)
      end do
    end associate
    flush (unit)
  end subroutine print_comparison

  !> Says which two flights are compared.
  function what_is_compared(c) result(text)
    type(flight_comparison_t), intent(in) :: c
    character(:), allocatable :: text
    if (.not. c%is_flown) then
      text = 'the flight of the case, and with what was found'
      return
    end if
    text = 'the flight with the wing of the baseline, and with the extended wing'
    if (c%n_directions > 0) text = text//' and '//number_text(c%n_directions)//trim(merge(' directions', ' direction ', &
      c%n_directions > 1))//' of its errors ('//number_text(nint(100*c%share))//' % of their variance)'
  end function what_is_compared

  !> Returns one row: both values, the interval of the second one, and its change.
  function line_of(c, i) result(text)
    type(flight_comparison_t), intent(in) :: c
    integer, intent(in) :: i
    character(:), allocatable :: text, name
    real(rp) :: ends(2), change(3)
    integer :: n
    name = COMPARED(i)
    if (.not. c%is_determined(i)) then
      text = name//'not determined: its denominator may be 0'
      return
    end if
    ends = SCALES(i)*c%interval(:, i)
    n = decimals(ends(2) - ends(1))
    text = name//fixed(SCALES(i)*c%baseline(i), n)//' -> '//fixed(SCALES(i)*c%extended(i), n)//unit_of(c, i)//' ('// &
           fixed(ends(1), n)//' to '//fixed(ends(2), n)//')'
    if (.not. abs(c%baseline(i)) > 0) return
    change = 100*changes_of(c, i)
    n = decimals(change(3) - change(1))
    text = text//', '//signed(change(2), n)//' % ('//signed(change(1), n)//' to '//signed(change(3), n)//')'
  end function line_of

  !> Returns the unit of a row on the terminal.
  function unit_of(c, i) result(text)
    type(flight_comparison_t), intent(in) :: c
    integer, intent(in) :: i
    character(:), allocatable :: text
    text = trim(SHOWN(i))
    if (c%is_section .and. i <= LAST_WITH_LENGTH) text = text//'/m'
  end function unit_of

  !> Returns the change over the size of the baseline, which is not 0: lower end, best and upper end.
  pure function changes_of(c, i) result(change)
    type(flight_comparison_t), intent(in) :: c
    integer, intent(in) :: i
    real(rp) :: change(3)
    change = ([c%interval(1, i), c%extended(i), c%interval(2, i)] - c%baseline(i))/abs(c%baseline(i))
  end function changes_of

  !> Returns how many digits behind the decimal point show an interval of this width with two digits or three.
  pure integer function decimals(width)
    real(rp), intent(in) :: width
    integer, parameter :: MOST = 9
    decimals = MOST
    if (width > 10.0_rp**(1 - MOST)) decimals = max(0, min(MOST, 1 - floor(log10(width))))
  end function decimals

  !> Returns a number with its sign.
  function signed(x, n) result(text)
    real(rp), intent(in) :: x
    integer, intent(in) :: n
    character(:), allocatable :: text
    text = fixed(x, n)
    if (x > 0) text = '+'//text
  end function signed

  !> Adds the object `flights` to the open object, if two flights were compared or should have been.
  subroutine put_comparison(json, s)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    real(rp) :: change(3)
    integer :: i
    associate (c => s%comparison)
      if (.not. (c%is_known .or. allocated(c%reason))) return
      call json%open_object('flights')
      call json%put('is_known', c%is_known)
      if (.not. c%is_known) then
        call json%put('reason', c%reason)
        call json%close()
        return
      end if
      call json%put('case', c%path)
      call json%put('is_section', c%is_section)
      call json%put('wings_were_flown', c%is_flown)
      call json%put('directions', c%n_directions)
      call json%put('variance_share', c%share)
      call json%open_list('means')
      do i = 1, N_COMPARED
        call json%open_object('')
        call json%put('name', trim(COMPARED(i)))
        call json%put('unit', trim(UNITS(i))//trim(merge('/m', '  ', c%is_section .and. i <= LAST_WITH_LENGTH)))
        call json%put('is_determined', c%is_determined(i))
        call json%put('baseline', c%baseline(i))
        call json%put('extended', c%extended(i))
        if (c%is_determined(i)) then
          call json%put('interval_90', c%interval(:, i))
          if (abs(c%baseline(i)) > 0) then
            change = changes_of(c, i)
            call json%put('change', change(2))
            call json%put('change_interval_90', change([1, 3]))
          end if
        end if
        call json%close()
      end do
      call json%close()
      call json%close()
    end associate
  end subroutine put_comparison
end module diagnose_comparison
