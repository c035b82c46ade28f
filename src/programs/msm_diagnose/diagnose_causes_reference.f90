! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the list of all causes that a diagnosis knows as tables for readers.
module diagnose_causes_reference
  use base_cause, only: cause_t
  use base_kinds, only: rp
  use base_magnitude, only: rounded
  use base_text, only: number_text
  use diagnosis_causes, only: list_causes
  implicit none
  private
  public :: write_causes_reference

contains

  !> Writes the reference of all causes, docs/formats/causes.md, to `unit`.
  subroutine write_causes_reference(unit)
    integer, intent(in) :: unit
    type(cause_t), allocatable :: list(:)
    character(:), allocatable :: titles, meanings, names, units, bounds, priors
    integer :: i, k
    list = list_causes()
    write (unit, '(a)') '# Causes', '', '<!-- Written by `msm_diagnose --causes`; a test compares. -->', '', &
      'What a diagnosis can name: properties of the wing, its masses and its damping, errors of the measurement, changes of '// &
      'kinematics and flow, and errors of the force balance. The prior sd is that of the coordinate: the value, or the '// &
      'logarithm of a factor. Where an accuracy is declared, the prior of the measurement is that one. T is the length of the '// &
      'longest record; without records, the longest time in which a mode decays. n are the radians that the wing, or the '// &
      'fastest mode, turns in it.', '', &
      '| cause | what it means | parameters | unit | bounds | prior sd | data that it needs |', '|---|---|---|---|---|---|---|'
    do i = 1, size(list)
      titles = '`'//list(i)%name//'`: '//list(i)%title
      meanings = list(i)%sentence
      names = ''
      units = ''
      bounds = ''
      priors = ''
      do k = 1, size(list(i)%parameters)
        associate (one => list(i)%parameters(k))
          if (.not. one%is_tried) cycle
          call collect(names, '`'//family_of(one%value%name)//'`')
          call collect(units, one%value%unit)
          call collect(bounds, number(one%value%lower)//', '//number(one%value%upper)//times(one%scale))
          if (one%value%prior_sd > 0) call collect(priors, number(one%value%prior_sd)//times(one%prior_scale))
        end associate
      end do
      write (unit, '(a)') '| '//titles//' | '//meanings//' | '//names//' | '//units//' | '//bounds//' | '//priors//' | '// &
        list(i)%data//' |'
    end do
    write (unit, '(a)') ''
  end subroutine write_causes_reference

  !> Appends an item to a list unless it is there.
  subroutine collect(list, item)
    character(:), allocatable, intent(inout) :: list
    character(*), intent(in) :: item
    if (index('; '//list//'; ', '; '//item//'; ') > 0) return
    if (list /= '') list = list//'; '
    list = list//item
  end subroutine collect

  !> Returns the name of a parameter, or a common name for all names that differ only behind a colon.
  pure function family_of(name) result(family)
    character(*), intent(in) :: name
    character(:), allocatable :: family
    family = name
    if (index(name, ':') > 0) family = name(:index(name, ':'))//'<part>'
  end function family_of

  !> Returns a number as text, without the last digits that rounding leaves.
  function number(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    integer, parameter :: DIGITS = 6
    text = number_text(sign(rounded(abs(x), DIGITS), x))
  end function number

  !> Returns words that follow a number and say of what it is a multiple.
  function times(scale) result(text)
    character(*), intent(in) :: scale
    character(:), allocatable :: text
    text = ''
    if (scale /= '') text = ' times '//scale
  end function times
end module diagnose_causes_reference
