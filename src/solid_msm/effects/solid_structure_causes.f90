! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists all causes of a misfit that are properties of the structure of a wing: wrong values of the usual parameters, and effects
!> that the usual model leaves out.
module solid_structure_causes
  use base_cause, only: append, cause_t, enlist
  use solid_effects, only: list_effect_causes
  use solid_usual_causes, only: list_usual_causes
  implicit none
  private
  public :: list_structure_causes

contains

  !> Returns the causes in the order of their places in the catalogue.
  pure function list_structure_causes() result(list)
    type(cause_t), allocatable :: list(:)
    type(cause_t), allocatable :: all_causes(:), usual(:)
    integer :: i, next
    logical, allocatable :: is_left(:)
    all_causes = list_effect_causes()
    usual = list_usual_causes()
    call append(all_causes, usual)
    allocate (is_left(size(all_causes)), source=.true.)
    do i = 1, size(all_causes)
      next = minloc(all_causes%place, 1, mask=is_left) ! the first one among equal places
      is_left(next) = .false.
      call enlist(list, all_causes(next))
    end do
  end function list_structure_causes
end module solid_structure_causes
