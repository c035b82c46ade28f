! SPDX-License-Identifier: GPL-3.0-or-later
!> "Did you mean": the known name nearest to a misspelt one.
module io_suggest
  use base_text, only: edit_distance, to_lower
  implicit none
  private
  public :: suggestion_t

  !> Offer known names one by one; `best` is then the nearest, not allocated if none is near enough.
  !> A name that differs only in case always wins.
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

  !> Begins a search for what `misspelt` may have meant.
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
    ! A third of the letters may be wrong, but always one, so that short names are found too.
    if (distance > max(1, min(3, len(self%misspelt)/3))) return
    if (distance >= min(len(name), self%distance)) return
    self%distance = distance
    self%best = name
  end subroutine suggestion_offer

  !> "; did you mean 'name'?", or nothing.
  function suggestion_hint(self) result(text)
    class(suggestion_t), intent(in) :: self
    character(:), allocatable :: text
    text = ''
    if (allocated(self%best)) text = "; did you mean '"//self%best//"'?"
  end function suggestion_hint
end module io_suggest
