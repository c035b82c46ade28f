! SPDX-License-Identifier: GPL-3.0-or-later
!> Which parameters of a wing and of the instrument are sought, and in which box.
module measurement_sought
  use base_kinds, only: rp
  implicit none
  private
  public :: sought_t

  !> Parameters that are sought, by their numbers in solid_params_t and instrument_t; those of the wing come first.
  type :: sought_t
    integer, allocatable :: numbers(:), instrument_numbers(:)
    real(rp), allocatable :: lower(:), upper(:) !< in their units
    logical, allocatable :: is_log(:)           !< scale of the search
  contains
    procedure :: count => sought_count
  end type sought_t

contains

  !> Number of parameters.
  pure integer function sought_count(self) result(n)
    class(sought_t), intent(in) :: self
    n = 0
    if (allocated(self%numbers)) n = size(self%numbers) + size(self%instrument_numbers)
  end function sought_count
end module measurement_sought
