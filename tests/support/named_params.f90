! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads and sets parameters of a wing by their names.
module named_params
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use solid_params, only: solid_params_t
  implicit none
  private
  public :: set_each, value_of

contains

  !> Returns the value of the parameter called `name`, in its unit. A name that the wing does not have stops the program.
  real(rp) function value_of(params, name) result(value)
    type(solid_params_t), intent(in) :: params
    character(*), intent(in) :: name
    integer :: i
    i = params%find(name)
    call require(i > 0, 'named_params: no parameter '//name)
    value = params%get(i)
  end function value_of

  !> Sets the parameters whose names begin with `beginning`, one after another, to `values`, which must be as many.
  subroutine set_each(params, beginning, values)
    type(solid_params_t), intent(inout) :: params
    character(*), intent(in) :: beginning
    real(rp), intent(in) :: values(:)
    type(parameter_t) :: p
    integer :: i, n
    n = 0
    do i = 1, params%count()
      p = params%describe(i)
      if (index(p%name, beginning) /= 1) cycle
      n = n + 1
      if (n <= size(values)) call params%set(i, values(n))
    end do
    call require(n == size(values), 'named_params: so many parameters begin with '//beginning)
  end subroutine set_each
end module named_params
