! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the known name nearest to a misspelt one, for messages "did you mean".
module io_suggest
  use base_kinds, only: rp
  use base_text, only: edit_distance, parse_real, quoted, to_lower
  implicit none
  private
  public :: suggestion_t, number_hint

  !> After known names were offered one by one, `best` is the nearest one; not allocated if none is near enough. A name that
  !> differs only in case has priority.
  type :: suggestion_t
    private
    character(:), allocatable :: misspelt
    character(:), allocatable, public :: best
    integer :: distance = huge(0)
  contains
    procedure :: start => suggestion_start
    procedure :: offer => suggestion_offer
    procedure :: hint => suggestion_hint
  end type suggestion_t

  integer, parameter :: LONGEST = 65 ! one more than edit_distance compares, so that it finds nothing

contains

  !> Begins a search for the name that `misspelt` may mean.
  subroutine suggestion_start(self, misspelt)
    class(suggestion_t), intent(out) :: self
    character(*), intent(in) :: misspelt
    self%misspelt = to_lower(misspelt(:min(len(misspelt), LONGEST)))
  end subroutine suggestion_start

  !> Offers a known name.
  subroutine suggestion_offer(self, name)
    class(suggestion_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer :: distance
    distance = edit_distance(self%misspelt, to_lower(name))
    ! A third of the letters may be wrong, and at least one, so that short names are found, too.
    if (distance > max(1, min(3, len(self%misspelt)/3))) return
    if (distance >= min(len(name), self%distance)) return
    self%distance = distance
    self%best = name
  end subroutine suggestion_offer

  !> Returns "; did you mean 'name'?", or nothing.
  function suggestion_hint(self) result(text)
    class(suggestion_t), intent(in) :: self
    character(:), allocatable :: text
    text = ''
    if (allocated(self%best)) text = "; did you mean '"//self%best//"'?"
  end function suggestion_hint

  !> Returns a hint if `raw`, which should be a number, is a number with a unit or with a decimal comma. The hint begins with a
  !> semicolon, or is empty.
  function number_hint(raw) result(text)
    character(*), intent(in) :: raw
    character(:), allocatable :: text, problem, point
    character(*), parameter :: NOT_UNITS = '+-.,*0123456789'
    real(rp) :: x
    integer :: n
    text = ''
    point = raw
    n = index(raw, ',')
    if (n > 0) point(n:n) = '.'
    call parse_real(point, x, problem)
    if (n > 0 .and. .not. allocated(problem)) then
      text = '; did you mean '//quoted(point)//'?'
      return
    end if
    do n = min(len(raw) - 1, LONGEST), 1, -1
      call parse_real(raw(:n), x, problem)
      if (.not. allocated(problem)) exit
    end do
    if (n < 1) return
    if (index(NOT_UNITS, first_letter(raw(n + 1:))) == 0) text = '; write the number without a unit, in the unit that --check shows'
  end function number_hint

  !> Returns the first character that is not blank.
  pure character(1) function first_letter(text) result(letter)
    character(*), intent(in) :: text
    character(:), allocatable :: shifted
    shifted = adjustl(text)
    letter = shifted(1:1)
  end function first_letter
end module io_suggest
