! SPDX-License-Identifier: GPL-3.0-or-later
!> Recognises files that are not inputs of this program: files of another kind, and inputs of other programs. One message then says
!> what the file is and what to do with it, instead of one message for each of its keys.
module io_foreign
  use base_errors, only: message_list_t
  use base_text, only: number_text
  use io_ini, only: ini_document_t
  use io_key, only: matches_any
  implicit none
  private
  public :: foreign_inputs_t

  !> Inputs of one other program.
  type :: foreign_input_t
    character(:), allocatable :: sections, text
  end type foreign_input_t

  !> Sections that distinguish the inputs of a program from those of others. They are written 'a|b'.
  type :: foreign_inputs_t
    private
    character(:), allocatable :: own      !< sections that only inputs of this program have
    character(:), allocatable :: fragment !< a file with only these sections is a part of an input
    character(:), allocatable :: advice   !< advice for such a part
    type(foreign_input_t), allocatable :: others(:)
  contains
    procedure :: set_own => foreign_set_own
    procedure :: set_fragment => foreign_set_fragment
    procedure :: add => foreign_add
    procedure :: report => foreign_report
  end type foreign_inputs_t

contains

  !> States that a file with one of these sections is an input of this program, whatever other sections it has.
  subroutine foreign_set_own(self, sections)
    class(foreign_inputs_t), intent(inout) :: self
    character(*), intent(in) :: sections
    self%own = sections
  end subroutine foreign_set_own

  !> States that a file with only these sections is refused with `advice`, in which * stands for its name.
  subroutine foreign_set_fragment(self, sections, advice)
    class(foreign_inputs_t), intent(inout) :: self
    character(*), intent(in) :: sections, advice
    self%fragment = sections
    self%advice = advice
  end subroutine foreign_set_fragment

  !> States that a file with one of these sections is refused with `text`, in which * stands for its name. If several apply, the
  !> first counts.
  subroutine foreign_add(self, sections, text)
    class(foreign_inputs_t), intent(inout) :: self
    character(*), intent(in) :: sections, text
    if (.not. allocated(self%others)) allocate (self%others(0))
    self%others = [self%others, foreign_input_t(sections, text)]
  end subroutine foreign_add

  !> Sets `is_foreign` and adds the mistake to `errors` if `document` is not an input of this program.
  subroutine foreign_report(self, document, errors, is_foreign)
    class(foreign_inputs_t), intent(in) :: self
    type(ini_document_t), intent(in) :: document
    type(message_list_t), intent(inout) :: errors
    logical, intent(inout) :: is_foreign
    integer :: i, s
    if (.not. allocated(self%own) .or. document%n_sections == 0) return
    if (count_of(document, self%own) > 0) return
    do i = 1, size(self%others)
      do s = 1, document%n_sections
        associate (section => document%sections(s))
          if (.not. matches_any(section%name, self%others(i)%sections)) cycle
          call refuse(self%others(i)%text, s)
          return
        end associate
      end do
    end do
    if (.not. allocated(self%fragment)) return
    if (count_of(document, self%fragment) < document%n_sections) return
    call refuse(self%advice, 1)

  contains

    subroutine refuse(text, at)
      character(*), intent(in) :: text
      integer, intent(in) :: at !< section
      associate (section => document%sections(at))
        call errors%add(section%file//':'//number_text(section%line)//': ['//section%name//']: '//with_name(text, document%name))
      end associate
      is_foreign = .true.
    end subroutine refuse
  end subroutine foreign_report

  !> Counts the sections of `document` that are among `sections`.
  integer function count_of(document, sections) result(n)
    type(ini_document_t), intent(in) :: document
    character(*), intent(in) :: sections
    integer :: s
    n = 0
    do s = 1, document%n_sections
      if (matches_any(document%sections(s)%name, sections)) n = n + 1
    end do
  end function count_of

  !> Returns `text` with `name` in place of its *.
  function with_name(text, name) result(full)
    character(*), intent(in) :: text, name
    character(:), allocatable :: full
    integer :: star
    full = text
    star = index(text, '*')
    if (star > 0) full = text(:star - 1)//name//text(star + 1:)
  end function with_name
end module io_foreign
