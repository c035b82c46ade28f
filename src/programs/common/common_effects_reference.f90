! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the list of all effects of wings as tables for readers.
module common_effects_reference
  use base_kinds, only: rp
  use base_text, only: number_text
  use solid_effect, only: effect_t, effect_text_t
  use solid_effects, only: list_effects
  implicit none
  private
  public :: write_effects_reference

contains

  !> Writes the tables to `unit` as Markdown: the parameters of each effect, and what each means in a diagnosis.
  subroutine write_effects_reference(unit)
    integer, intent(in) :: unit
    type(effect_t), allocatable :: list(:)
    type(effect_text_t) :: text
    integer :: e
    list = list_effects()
    write (unit, '(a)') '# Effects of a wing', '', 'What a wing may do beyond the usual model, for `[Wing] parameters`, '// &
      '`[Train] parameters` and `[Diagnose] parameters`; [more about them](../theory/effects.md).', '', &
      '| name | definition | unit | null | bounds | prior sd | data that it needs |', '|---|---|---|---|---|---|---|'
    do e = 1, size(list)
      call list(e)%tell(text)
      associate (p => list(e)%parameters(:list(e)%n))
        write (unit, '(a)') '| '//names_of(list(e))//' | '//text%definition//' | '//trim(p(1)%unit)//' | '// &
          merge('1', '0', p(1)%is_log)//' | '//bounds_of(list(e))//' | '//priors_of(list(e))//' | '//text%data//' |'
      end associate
    end do
    write (unit, '(a)') '', '| cause in a diagnosis | parameters | what it means | confused with |', '|---|---|---|---|'
    do e = 1, size(list)
      call list(e)%tell(text)
      write (unit, '(a)') '| `'//text%cause//'`: '//text%title//' | '//names_of(list(e))//' | '//text%sentence//' | '// &
        text%confused//' |'
    end do
    write (unit, '(a)') ''
  end subroutine write_effects_reference

  !> Returns the names of the parameters of an effect, separated by commas.
  function names_of(effect) result(text)
    type(effect_t), intent(in) :: effect
    character(:), allocatable :: text
    integer :: k
    text = ''
    do k = 1, effect%n
      if (k > 1) text = text//', '
      text = text//'`'//trim(effect%parameters(k)%name)
      if (effect%is_per_joint) text = text//'<joint>'
      text = text//'`'
    end do
  end function names_of

  !> Returns the bounds of the parameters of an effect; equal bounds appear once.
  function bounds_of(effect) result(text)
    type(effect_t), intent(in) :: effect
    character(:), allocatable :: text
    integer :: k
    text = ''
    do k = 1, effect%n
      associate (p => effect%parameters(k))
        if (k > 1) then
          if (all(abs([p%lower, p%upper] - [effect%parameters(1)%lower, effect%parameters(1)%upper]) <= 0)) cycle
          text = text//'; '
        end if
        text = text//number_text(p%lower)//', '//number_text(p%upper)
      end associate
    end do
  end function bounds_of

  !> Returns the prior standard deviations of the parameters of an effect; equal ones appear once.
  function priors_of(effect) result(text)
    type(effect_t), intent(in) :: effect
    character(:), allocatable :: text
    real(rp) :: first
    integer :: k
    first = effect%parameters(1)%prior_sd
    text = number_text(first)
    do k = 2, effect%n
      if (abs(effect%parameters(k)%prior_sd - first) > 0) text = text//'; '//number_text(effect%parameters(k)%prior_sd)
    end do
  end function priors_of
end module common_effects_reference
