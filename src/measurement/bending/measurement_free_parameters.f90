! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists the free parameters of a wing and of the instrument, and their box.
module measurement_free_parameters
  use base_kinds, only: rp
  implicit none
  private
  public :: free_parameters_t

  !> Parameters that are sought, by their numbers in solid_params_t and instrument_t; those of the wing come first.
  type :: free_parameters_t
    integer, allocatable :: numbers(:), instrument_numbers(:)
    real(rp), allocatable :: lower(:), upper(:) !< in their units
    logical, allocatable :: is_log(:)           !< scale of the search
  contains
    procedure :: count => free_parameters_count
  end type free_parameters_t

contains

  !> Number of parameters.
  pure integer function free_parameters_count(self) result(n)
    class(free_parameters_t), intent(in) :: self
    n = 0
    if (allocated(self%numbers)) n = size(self%numbers) + size(self%instrument_numbers)
  end function free_parameters_count
end module measurement_free_parameters
