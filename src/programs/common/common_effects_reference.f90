! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the list of all effects of wings as tables for readers.
module common_effects_reference
  use base_cause, only: cause_parameter_t, cause_t
  use base_text, only: number_text
  use solid_effects, only: list_effect_causes
  implicit none
  private
  public :: write_effects_reference

contains

  !> Writes the tables to `unit` as Markdown: the parameters of each effect, and what each means in a diagnosis.
  subroutine write_effects_reference(unit)
    integer, intent(in) :: unit
    type(cause_t), allocatable :: causes(:)
    integer :: e
    causes = list_effect_causes()
    write (unit, '(a)') '# Effects of a wing', '', 'What a wing may do beyond the usual model, for `[Wing] parameters`, '// &
      '`[Train] parameters` and `[Diagnose] parameters`; [more about them](../theory/effects.md).', '', &
      '| name | definition | unit | null | bounds | prior sd | data that it needs |', '|---|---|---|---|---|---|---|'
    do e = 1, size(causes)
      associate (one => causes(e), p => causes(e)%parameters)
        write (unit, '(a)') '| '//names_of(p)//' | '//one%definition//' | '//p(1)%value%unit//' | '// &
          merge('1', '0', p(1)%value%is_log)//' | '//bounds_of(p)//' | '//priors_of(p)//' | '//one%data//' |'
      end associate
    end do
    write (unit, '(a)') '', '| cause in a diagnosis | parameters | what it means | confused with |', '|---|---|---|---|'
    do e = 1, size(causes)
      associate (one => causes(e))
        write (unit, '(a)') '| `'//one%name//'`: '//one%title//' | '//names_of(one%parameters)//' | '//one%sentence//' | '// &
          one%confused//' |'
      end associate
    end do
    write (unit, '(a)') ''
  end subroutine write_effects_reference

  !> Returns the names of the parameters of an effect, separated by commas.
  function names_of(p) result(text)
    type(cause_parameter_t), intent(in) :: p(:)
    character(:), allocatable :: text
    integer :: k
    text = ''
    do k = 1, size(p)
      if (k > 1) text = text//', '
      text = text//'`'//p(k)%value%name
      if (index(p(k)%value%name, ':') > 0) text = text//'<joint>'
      text = text//'`'
    end do
  end function names_of

  !> Returns the bounds of the parameters of an effect; equal bounds appear once.
  function bounds_of(p) result(text)
    type(cause_parameter_t), intent(in) :: p(:)
    character(:), allocatable :: text
    integer :: k
    text = ''
    do k = 1, size(p)
      associate (one => p(k)%value, first => p(1)%value)
        if (k > 1) then
          if (all(abs([one%lower, one%upper] - [first%lower, first%upper]) <= 0)) cycle
          text = text//'; '
        end if
        text = text//number_text(one%lower)//', '//number_text(one%upper)
      end associate
    end do
  end function bounds_of

  !> Returns the prior standard deviations of the parameters of an effect; equal ones appear once.
  function priors_of(p) result(text)
    type(cause_parameter_t), intent(in) :: p(:)
    character(:), allocatable :: text
    integer :: k
    text = number_text(p(1)%value%prior_sd)
    do k = 2, size(p)
      if (abs(p(k)%value%prior_sd - p(1)%value%prior_sd) > 0) text = text//'; '//number_text(p(k)%value%prior_sd)
    end do
  end function priors_of
end module common_effects_reference
