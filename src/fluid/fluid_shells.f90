! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the energy spectrum of a velocity: the kinetic energy of the modes in each shell of wavenumbers.
!>
!> As in FLUSI, shell i = 0, 1, ... has the modes whose |k|/dk is nearest to i, where dk is the smallest wavenumber of the
!> box, 2 pi over its longest side. The energy of a shell is the sum of |u(k)|^2/2 over its modes: the sum over all shells
!> is the mean of |u|^2/2, and times the volume of the box the kinetic energy. There are shells up to the last one with a
!> retained mode.
module fluid_shells
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  use spectral_sticks, only: sticks_t
  implicit none
  private
  public :: shell_width, count_shells, shell_energies

contains

  !> Returns dk [1/L], the difference of the wavenumbers of neighbouring shells.
  pure real(rp) function shell_width(grid) result(width)
    type(grid_t), intent(in) :: grid
    width = TWO_PI/maxval(grid%length, mask=grid%n > 1)
  end function shell_width

  !> Returns the number of shells, including the shell of k = 0, the same on all ranks. Collective.
  integer function count_shells(world, grid, sticks) result(n)
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    type(sticks_t), intent(in) :: sticks
    integer :: s, i
    n = 0
    do s = 1, sticks%n
      do i = 1, sticks%nkz
        if (abs(sticks%jz(i)) <= sticks%jz_max(s)) n = max(n, shell_of(sticks, s, i, shell_width(grid)))
      end do
    end do
    n = world%max_integer(n) + 1
  end function count_shells

  !> Returns the energies (0:shells-1, 3) [L^2/T^2] of the components of the velocity with the spectrum `u`, the same on all
  !> ranks. Collective.
  subroutine shell_energies(world, grid, sticks, u, energies)
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    type(sticks_t), intent(in) :: sticks
    complex(rp), intent(in) :: u(:, :, :)          !< (nkz, sticks, 3)
    real(rp), intent(inout) :: energies(0:, :)     !< as many shells as `count_shells` says
    real(rp) :: width
    integer :: s, i, c, shell
    width = shell_width(grid)
    energies = 0
    do s = 1, sticks%n
      do i = 1, sticks%nkz
        if (abs(sticks%jz(i)) > sticks%jz_max(s)) cycle
        shell = shell_of(sticks, s, i, width)
        energies(shell, :) = energies(shell, :) + 0.5_rp*sticks%weight(s)*(real(u(i, s, :))**2 + aimag(u(i, s, :))**2)
      end do
    end do
    do c = 1, size(energies, 2)
      call world%sum_reals(energies(:, c))
    end do
  end subroutine shell_energies

  !> Returns the shell of mode `i` on stick `s`.
  pure integer function shell_of(sticks, s, i, width) result(shell)
    type(sticks_t), intent(in) :: sticks
    integer, intent(in) :: s, i
    real(rp), intent(in) :: width
    shell = nint(norm2([sticks%kx(s), sticks%ky(s), sticks%kz(i)])/width)
  end function shell_of
end module fluid_shells
