! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a parameter of a cause in a sentence for people: its direction, size, unit and uncertainty.
!>
!> | known about the parameter | the sentence contains |
!> |---|---|
!> | an interval that excludes no effect | the value and both ends |
!> | an interval that contains no effect | both ends, and "perhaps" |
!> | one end of the interval | "at least" or "at most", and no value |
!> | no end of the interval | that the data do not determine it, and no value |
!> | no interval was computed | "about" and the value |
!>
!> The words of each parameter are in the record of its cause: see diagnosis_causes. diagnose_wordings finds them.
module diagnose_words
  use base_decimal, only: fixed
  use base_kinds, only: rp
  use diagnose_wordings, only: find_wording
  use base_wording, only: displayed, wording_t, SCALE_PLAIN, SCALE_FRACTION
  implicit none
  private
  public :: finding_t, finding_text, strength_text

  real(rp), parameter :: TIMES_FROM = 2.0_rp !< factors from which "3.1 times" says more than "210 % more"
  real(rp), parameter :: LEAST_TIMES = 0.01_rp
  real(rp), parameter :: SMALL = 1.0e-3_rp

  !> A finding is a parameter that was found, in its unit. Factors are stored as factors, not as logarithms.
  type :: finding_t
    character(:), allocatable :: name    !< of the parameter, as in ini files
    character(:), allocatable :: unit
    character(:), allocatable :: site   !< in words, or empty
    real(rp) :: null = 0                 !< assumed value
    real(rp) :: best = 0
    logical :: has_interval = .false.    !< an interval was computed
    logical :: has_lower = .false., has_upper = .false.
    real(rp) :: lower = 0, upper = 0     !< ends of the 90 % interval, if it has them
    logical :: is_jump = .false.         !< the interval ends where a shape jumps
  end type finding_t

  !> These are the numbers of a finding as they are displayed.
  type :: numbers_t
    type(wording_t) :: w
    real(rp) :: shown(3) = 0        !< lower end, value and upper end
    real(rp) :: nothing = 0         !< what is displayed if nothing happens
    logical :: is_times = .false.   !< displayed as "3.1 times"
    logical :: is_absolute = .false. !< not displayed as a difference
    logical :: is_up = .false.      !< the value is above `nothing`
    integer :: decimals = 0           !< digits behind the decimal point
  end type numbers_t

contains

  !> Returns the sentence on a finding, without a full stop at its end.
  function finding_text(finding) result(text)
    type(finding_t), intent(in) :: finding
    character(:), allocatable :: text
    type(numbers_t) :: n
    logical :: has(2)
    n%w = find_wording(finding%name, finding%unit, finding%site, finding%null, finding%best)
    n%shown = displayed(n%w, [finding%lower, finding%best, finding%upper])
    has = [finding%has_lower, finding%has_upper]
    if (displayed(n%w, finding%best + max(abs(finding%best), SMALL)*SMALL) < n%shown(2)) then ! it decreases with the value
      n%shown = n%shown([3, 2, 1])
      has = has([2, 1])
    end if
    n%nothing = 0
    if (n%w%scale == SCALE_FRACTION) then
      n%nothing = n%w%reference
    else if (n%w%scale /= SCALE_PLAIN) then
      n%is_times = n%shown(2) >= TIMES_FROM .or. (n%shown(2) < LEAST_TIMES .and. n%shown(2) > 0)
      if (n%is_times) n%nothing = 1
      if (.not. n%is_times) n%shown = 100*(n%shown - 1)
    end if
    n%is_absolute = n%is_times .or. n%w%scale == SCALE_FRACTION
    n%is_up = n%shown(2) >= n%nothing
    n%decimals = decimals_for(n%shown, has .and. finding%has_interval)
    text = told(n, has, finding%has_interval)
    if (finding%is_jump) text = text//' (an end of the interval is where the wing snaps to another shape)'
    if (n%w%is_natural .and. abs(finding%null - n%w%reference) > 0) text = text//'; the input assumes that it is present'
  end function finding_text

  !> Returns by how much a parameter at `best` differs from no effect, without the words before the number, as in "25 % higher than
  !> at the root".
  function strength_text(finding) result(text)
    type(finding_t), intent(in) :: finding
    character(:), allocatable :: text
    type(finding_t) :: one
    integer :: i
    one = finding
    one%has_interval = .false.
    text = finding_text(one)
    i = index(text, ' about ')
    text = text(i + len(' about '):)
  end function strength_text

  !> Returns the sentence for numbers that are already converted for display.
  function told(n, has, has_interval) result(text)
    type(numbers_t), intent(in) :: n
    logical, intent(in) :: has(2), has_interval
    character(:), allocatable :: text, lead, tail
    character(*), parameter :: SURE = ' with 90 % confidence', HALF = ' with 95 % confidence', &
                               UNKNOWN = ' (these data do not say how much)'
    real(rp) :: inner, outer ! the ends toward `nothing` and away from it
    lead = n%w%down
    if (n%is_up) lead = n%w%up
    inner = merge(n%shown(1), n%shown(3), n%is_up)
    outer = merge(n%shown(3), n%shown(1), n%is_up)
    if (.not. has_interval) then
      text = lead//' about '//amount(n, n%shown(2))//tail_of(n)
    else if (.not. any(has)) then
      text = perhaps(lead)//' some amount'//tail_of(n)//UNKNOWN
    else if (all(has) .and. n%shown(1) < n%nothing .and. n%shown(3) > n%nothing) then
      tail = n%w%than
      if (n%is_times) tail = n%w%times
      text = perhaps(lead)//' from '//amount(n, n%shown(1))//side(n, .false.)//' to '//amount(n, n%shown(3))// &
             side(n, .true.)//blank_before(tail)//SURE
    else if (all(has) .and. n%is_absolute) then
      text = lead//' '//amount(n, n%shown(2))//tail_of(n)//', '//number_of(n, n%shown(1))//' to '//amount(n, n%shown(3))//SURE
    else if (all(has)) then
      text = lead//' '//amount(n, n%shown(2))//tail_of(n)//', '//number_of(n, inner)//' to '//amount(n, outer)//SURE
    else if (has(1) .neqv. n%is_up) then
      text = perhaps(lead)//' at most '//amount(n, outer)//tail_of(n)//HALF
    else if (merge(inner > n%nothing, inner < n%nothing, n%is_up)) then
      text = lead//' at least '//amount(n, inner)//tail_of(n)//HALF
    else
      text = perhaps(lead)//' some amount'//tail_of(n)//UNKNOWN
    end if
  end function told

  !> Returns a number with its decimals, without its sign unless the sign counts.
  function number_of(n, x) result(text)
    type(numbers_t), intent(in) :: n
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    text = fixed(merge(x, abs(x), n%is_absolute), n%decimals)
  end function number_of

  !> Returns a number with its unit.
  function amount(n, x) result(words)
    type(numbers_t), intent(in) :: n
    real(rp), intent(in) :: x
    character(:), allocatable :: words
    words = number_of(n, x)
    if (n%is_times) then
      words = words//' times'
    else if (n%w%unit /= '') then
      words = words//' '//n%w%unit
    end if
  end function amount

  !> Returns the word for more if `is_up`, else the word for less.
  function side(n, is_up) result(word)
    type(numbers_t), intent(in) :: n
    logical, intent(in) :: is_up
    character(:), allocatable :: word
    word = ''
    if (n%is_absolute) return
    word = blank_before(n%w%less)
    if (is_up) word = blank_before(n%w%more)
    if (word == '') word = merge(' more', ' less', is_up)
  end function side

  !> Returns the words that follow the number.
  function tail_of(n) result(words)
    type(numbers_t), intent(in) :: n
    character(:), allocatable :: words
    if (n%is_times) then
      words = blank_before(n%w%times)
    else if (n%is_absolute) then
      words = blank_before(n%w%than)
    else
      words = blank_before(n%w%less)//blank_before(n%w%than)
      if (n%is_up) words = blank_before(n%w%more)//blank_before(n%w%than)
    end if
  end function tail_of

  !> Turns "The membrane .." into "Perhaps the membrane ..".
  function perhaps(lead) result(text)
    character(*), intent(in) :: lead
    character(:), allocatable :: text
    character :: first
    first = lead(1:1)
    if (lead(2:2) /= ' ' .and. first >= 'A' .and. first <= 'Z') first = achar(iachar(first) + 32)
    text = 'Perhaps '//first//lead(2:)
  end function perhaps

  !> Returns a word with a blank before it, or nothing for an empty word.
  function blank_before(word) result(text)
    character(*), intent(in) :: word
    character(:), allocatable :: text
    text = ''
    if (word /= '') text = ' '//word
  end function blank_before

  !> Returns how many decimals are displayed: enough to resolve the interval or, without an interval, to give two digits of the
  !> value.
  pure integer function decimals_for(shown, has) result(decimals)
    real(rp), intent(in) :: shown(3)
    logical, intent(in) :: has(2)
    integer, parameter :: MOST = 6
    real(rp) :: step
    step = 0.2_rp*abs(shown(2))
    if (any(has)) step = 0.2_rp*maxval(abs(pack(shown([1, 3]), has)))
    if (all(has)) step = min(shown(2) - shown(1), shown(3) - shown(2))
    if (all(has) .and. .not. step > 0) step = 0.5_rp*(shown(3) - shown(1))
    decimals = 0
    if (step > 0) decimals = max(0, min(MOST, -floor(log10(0.5_rp*step) + 1.0e-6_rp)))
  end function decimals_for
end module diagnose_words
