! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes what data tell about one unknown, in numbers and in a sentence.
module least_squares_interval
  use base_kinds, only: rp
  implicit none
  private
  public :: interval_t, profile_sentence

  !> What data tell about one unknown.
  type :: interval_t
    real(rp) :: best = 0                      !< where the sum of squares without the prior is smallest
    real(rp) :: lower = 0, upper = 0          !< ends of the interval; bounds of the box where it has none
    logical :: has_lower = .false., has_upper = .false.
    !> Tells whether the lower and the upper end are where the sum of squares jumps, or where valid points end.
    logical :: is_jump(2) = .false.
    logical :: is_complete = .false.          !< the search for both ends was completed
    logical, allocatable :: is_left_out(:) !< (groups) data that it does not use, see solver_state_t; not allocated: no groups
    integer :: n_refits = 0, n_evaluations = 0
    real(rp), allocatable :: profile(:, :)    !< (2, :) values tried, in that order, and the sum of squares above its
    !< minimum there
  end type interval_t

contains

  !> Returns a sentence about an unknown: its value and interval, or less if not all is known. The interval's numbers are
  !> logarithms if `is_log`.
  function profile_sentence(name, unit, is_log, interval) result(sentence)
    character(*), intent(in) :: name, unit
    logical, intent(in) :: is_log
    type(interval_t), intent(in) :: interval
    character(:), allocatable :: sentence
    character(*), parameter :: AT_JUMP = ' end shapes jump or cease to exist; the misfit is still within its limit)'
    if (interval%has_lower .and. interval%has_upper) then
      sentence = name//': '//shown(interval%best)//behind()//', with 90 % confidence between '// &
                 shown(interval%lower)//' and '//shown(interval%upper)//behind()
    else if (interval%has_lower) then
      sentence = name//': these data give a lower limit only: > '//shown(interval%lower)//behind()
    else if (interval%has_upper) then
      sentence = name//': these data give an upper limit only: < '//shown(interval%upper)//behind()
    else if (interval%is_complete) then
      sentence = name//': not determined by these data; every value from '//shown(interval%lower)//' to '// &
                 shown(interval%upper)//behind()//' fits as well'
    else
      sentence = name//': no statement is possible, because the search for its interval did not finish'
      return
    end if
    if (.not. interval%is_complete) sentence = sentence//' (the search for the interval did not finish)'
    if (interval%is_jump(1)) sentence = sentence//' (at the lower'//AT_JUMP
    if (interval%is_jump(2)) sentence = sentence//' (at the upper'//AT_JUMP

  contains

    function behind() result(text)
      character(:), allocatable :: text
      text = ''
      if (unit /= '1' .and. unit /= '') text = ' '//unit
    end function behind

    !> Returns a number with as many digits as distinguish the ends from the best value.
    function shown(x) result(text)
      real(rp), intent(in) :: x
      character(:), allocatable :: text
      character(30) :: buffer, form
      real(rp) :: ends(2)
      integer :: digits
      ends = [interval%lower, interval%upper]
      if (is_log) ends = exp(ends)
      digits = 3
      if (interval%has_lower .and. interval%has_upper .and. ends(2) > ends(1)) &
        digits = max(3, min(14, 2 - floor(log10((ends(2) - ends(1))/maxval(abs(ends))))))
      write (form, '(a,i0,a)') '(es24.', digits, ')'
      write (buffer, form) merge(exp(merge(x, 0.0_rp, is_log)), x, is_log)
      text = trim(adjustl(buffer))
    end function shown

  end function profile_sentence
end module least_squares_interval
