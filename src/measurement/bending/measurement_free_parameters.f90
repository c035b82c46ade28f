! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists the free parameters of a wing and of the instrument, and their box.
module measurement_free_parameters
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  implicit none
  private
  public :: free_parameters_t

  !> Holds the free parameters by their numbers in solid_params_t and instrument_t. The parameters of the wing come first.
  type, extends(visited_t) :: free_parameters_t
    integer, allocatable :: numbers(:), instrument_numbers(:)
    real(rp), allocatable :: lower(:), upper(:) !< bounds, in the units of the parameters
    logical, allocatable :: is_log(:)           !< the search uses the logarithm
  contains
    procedure :: visit => free_parameters_visit
    procedure :: count => free_parameters_count
  end type free_parameters_t

contains

  !> Shows every component to the visitor.
  subroutine free_parameters_visit(self, visitor)
    class(free_parameters_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit_allocatable('numbers', self%numbers)
    call visitor%visit_allocatable('instrument_numbers', self%instrument_numbers)
    call visitor%visit_allocatable('lower', self%lower)
    call visitor%visit_allocatable('upper', self%upper)
    call visitor%visit_allocatable('is_log', self%is_log)
  end subroutine free_parameters_visit

  !> Returns the number of free parameters.
  pure integer function free_parameters_count(self) result(n)
    class(free_parameters_t), intent(in) :: self
    n = 0
    if (allocated(self%numbers)) n = size(self%numbers) + size(self%instrument_numbers)
  end function free_parameters_count
end module measurement_free_parameters
