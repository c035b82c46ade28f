! SPDX-License-Identifier: GPL-3.0-or-later
!> Collects the mistakes in a wing file: every message names the file and the object, and of many mistakes of one kind only the
!> first few are shown.
module solid_wing_report
  use base_errors, only: message_list_t
  use base_text, only: number_text
  implicit none
  private
  public :: wing_report_t

  integer, parameter :: MOST_SHOWN = 5 !< messages of one kind

  type :: wing_report_t
    character(:), allocatable :: path !< of the file
    integer :: base = 1               !< number of the first point in the file, 0 or 1
    type(message_list_t) :: messages
    integer, private :: n_found = 0
    character(:), allocatable, private :: object
  contains
    procedure :: add => report_add
    procedure :: begin => report_begin
    procedure :: found => report_found
    procedure :: finish => report_finish
    procedure :: is_clean => report_is_clean
    procedure :: point => report_point
  end type wing_report_t

contains

  !> Adds one mistake of the object, for instance '/points'.
  subroutine report_add(self, object, text)
    class(wing_report_t), intent(inout) :: self
    character(*), intent(in) :: object, text
    call self%messages%add(self%path//': '//object//': '//text)
  end subroutine report_add

  !> Begins a search for mistakes of one kind in `object`.
  subroutine report_begin(self, object)
    class(wing_report_t), intent(inout) :: self
    character(*), intent(in) :: object
    self%object = object
    self%n_found = 0
  end subroutine report_begin

  !> Adds one more mistake of this kind.
  subroutine report_found(self, text)
    class(wing_report_t), intent(inout) :: self
    character(*), intent(in) :: text
    self%n_found = self%n_found + 1
    if (self%n_found <= MOST_SHOWN) call self%add(self%object, text)
  end subroutine report_found

  !> Ends the search, and says how many mistakes were not shown.
  subroutine report_finish(self)
    class(wing_report_t), intent(inout) :: self
    if (self%n_found > MOST_SHOWN) call self%add(self%object, 'and '//number_text(self%n_found - MOST_SHOWN) &
                                                 //' more mistakes of this kind')
    self%n_found = 0
  end subroutine report_finish

  !> Tells whether nothing was reported so far.
  pure logical function report_is_clean(self) result(is_clean)
    class(wing_report_t), intent(in) :: self
    is_clean = self%messages%count() == 0
  end function report_is_clean

  !> Returns the number that point, triangle or row `i` (1-based) has in the file, as text.
  pure function report_point(self, i) result(text)
    class(wing_report_t), intent(in) :: self
    integer, intent(in) :: i
    character(:), allocatable :: text
    text = number_text(i - 1 + self%base)
  end function report_point
end module solid_wing_report
