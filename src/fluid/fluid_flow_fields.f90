! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes velocity and vorticity in physical space, one field at a time, from the spectrum of the velocity.
module fluid_flow_fields
  use base_errors, only: require
  use base_kinds, only: rp
  use fluid_kernels, only: stick_fields, stick_curl
  use spectral_transform, only: kernels_t, transform_t
  implicit none
  private
  public :: flow_field, VORTICITY_MAGNITUDE

  integer, parameter :: VORTICITY_MAGNITUDE = 0 !< other fields: 1 to 3, a component of u; 4 to 6, of omega

  type, extends(kernels_t) :: flow_kernels_t
    integer :: which = 1
    real(rp), allocatable :: kx(:), ky(:), kz(:)                  !< wavenumbers of the sticks, and along them
    complex(rp), allocatable :: stick(:, :)                       !< (nkz, 5) u, omega_x, omega_y
    complex(rp), pointer, contiguous :: u(:, :, :) => null()      !< (nkz, sticks, 3)
    real(rp), pointer, contiguous :: field(:, :, :, :) => null() !< (nx, ny_local, nz_local, 1)
  contains
    procedure :: spectral_in => flow_spectral_in
    procedure :: product => flow_product
    procedure :: spectral_out => flow_spectral_out
  end type flow_kernels_t

contains

  !> Computes the field `which` (1 to 3: velocity, 4 to 6: vorticity, or VORTICITY_MAGNITUDE) of the velocity with the spectrum
  !> `u`, on all points of this rank or on the wanted lines; it is undefined on other lines. The result equals that of a pass of
  !> the right-hand side to the last bit. The planes are processed in `parts` parts, which saves memory. Collective.
  subroutine flow_field(transform, u, which, parts, field, lines)
    class(transform_t), intent(inout) :: transform
    complex(rp), contiguous, target, intent(in) :: u(:, :, :)            !< (nkz, sticks, 3)
    integer, intent(in) :: which, parts
    real(rp), contiguous, target, intent(inout) :: field(:, :, :, :)     !< (nx, ny_local, nz_local, 1)
    logical, contiguous, target, optional, intent(in) :: lines(:, :)     !< (ny_local, nz_local) the wanted ones, or all
    type(flow_kernels_t) :: kernels
    integer :: part
    call require(which >= VORTICITY_MAGNITUDE .and. which <= 6, 'flow_field: no such field')
    if (present(lines)) kernels%lines => lines
    kernels%which = which
    kernels%n_in = 1
    if (which == 6) kernels%n_in = 3                   ! u, v, omega_z
    if (which == VORTICITY_MAGNITUDE) kernels%n_in = 5 ! u, v, omega_z, omega_x, omega_y
    if (kernels%n_in > 1) kernels%curl = 3
    kernels%kx = transform%sticks%kx
    kernels%ky = transform%sticks%ky
    kernels%kz = transform%sticks%kz
    allocate (kernels%stick(size(u, 1), 5))
    kernels%u => u
    kernels%field => field
    do part = 1, parts
      call transform%to_points_part(kernels, part, parts)
    end do
  end subroutine flow_field

  !> Fills `fields` with velocity and vorticity, as far as the field needs them; see kernels_t.
  subroutine flow_spectral_in(self, first, count, fields)
    class(flow_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    integer :: i, s
    do i = 1, count
      s = first + i - 1
      associate (f => self%stick)
        call stick_fields(size(self%kz), self%kx(s), self%ky(s), self%kz, self%u(:, s, 1), self%u(:, s, 2), &
                          self%u(:, s, 3), f(:, 1), f(:, 2), f(:, 3), f(:, 4), f(:, 5))
        if (self%curl > 0) then
          fields(:, i, 1:2) = f(:, 1:2)
          if (self%fill_curl) call stick_curl(size(self%kz), self%kx(s), self%ky(s), f(:, 1), f(:, 2), fields(:, i, 3))
          if (self%which == VORTICITY_MAGNITUDE) fields(:, i, 4:5) = f(:, 4:5)
        else
          fields(:, i, 1) = f(:, self%which)
        end if
      end associate
    end do
  end subroutine flow_spectral_in

  !> Stores the field on the lines of this batch; see kernels_t.
  subroutine flow_product(self, first, count, z, in, out)
    class(flow_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    associate (f => self%field(:, first:first + count - 1, z, 1))
      if (self%which == VORTICITY_MAGNITUDE) then
        f = sqrt(in(:, 1:count, 4)**2 + in(:, 1:count, 5)**2 + in(:, 1:count, 3)**2)
      else
        f = in(:, 1:count, merge(3, 1, self%curl > 0))
      end if
    end associate
    associate (nothing_to_transform => out)
    end associate
  end subroutine flow_product

  !> Does nothing, since nothing is transformed forward; see kernels_t.
  subroutine flow_spectral_out(self, first, count, fields)
    class(flow_kernels_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    associate (nothing_comes => self, there => first, is => count, here => fields)
    end associate
  end subroutine flow_spectral_out
end module fluid_flow_fields
