! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the words for a parameter in the record of its cause, and chooses prefixes of units. base_wording defines the scales.
module diagnose_wordings
  use base_kinds, only: rp
  use base_wording, only: displayed, word_by_name, wording_t, SCALE_PLAIN, UNIT_OF_PARAMETER
  use diagnosis_causes, only: find_words
  implicit none
  private
  public :: find_wording

  character(*), parameter :: NO_UNIT = '1' !< of a number without a unit

contains

  !> Returns the words of parameter `name` [unit] at `site`. `null` is its assumed value; `best`, its fitted value, determines the
  !> prefix of the unit.
  function find_wording(name, unit, site, null, best) result(w)
    character(*), intent(in) :: name, unit, site
    real(rp), intent(in) :: null, best
    type(wording_t) :: w
    call find_words(name, site, best, w)
    if (.not. w%is_known) call word_by_name(w, name)
    if (.not. w%is_natural) w%reference = null
    if (w%unit == UNIT_OF_PARAMETER) w%unit = trim(unit)
    if (w%unit == NO_UNIT) w%unit = ''
    if (w%scale == SCALE_PLAIN) call choose_prefix(w, best)
  end function find_wording

  !> Chooses a prefix that brings the number between 1 and 1000, if the unit can have one.
  subroutine choose_prefix(w, best)
    type(wording_t), intent(inout) :: w
    real(rp), intent(in) :: best
    character, parameter :: PREFIXES(4) = ['m', 'u', 'n', 'p']
    character(3), parameter :: PREFIXED(4) = [character(3) :: 'm', 'N', 'g', 'N/m']
    real(rp) :: size
    integer :: k
    if (all(w%unit /= PREFIXED)) return
    size = abs(displayed(w, best))
    if (.not. size > 0) return
    k = max(0, min(4, ceiling(-log10(size)/3 - 1.0e-9_rp)))
    if (k == 0) return
    w%factor = w%factor*1000.0_rp**k
    w%unit = PREFIXES(k)//w%unit
  end subroutine choose_prefix
end module diagnose_wordings
