! SPDX-License-Identifier: GPL-3.0-or-later
!> Gathers volume integrals while the right-hand side is computed, and reduces them over the ranks in one message.
module fluid_sums
  use base_kinds, only: rp
  use fluid_penalty, only: penalty_t, N_COLORS
  use parallel_world, only: world_t
  implicit none
  private
  public :: lever_t, sums_t

  integer, parameter :: LAST = N_COLORS - 1

  !> Lever arms of the points of a line along x.
  type :: lever_t
    real(rp) :: arm(3) = 0  !< of its first point, L
    real(rp) :: spacing = 0 !< of its points, L
    real(rp) :: period = 0  !< period by which the arm in x is wrapped, L; 0: it is not
  end type lever_t

  !> Integrals over the box, at the time of the state. Integrals that contain chi are over the solids.
  type :: sums_t
    real(rp) :: kinetic_energy = 0              !< 1/2 int |u|^2, every step
    real(rp) :: force(3, 0:LAST) = 0            !< int chi/C_eta (u - u_s): force on the solid, every step
    real(rp) :: moment(3, 0:LAST) = 0           !< the same with lever arm
    real(rp) :: solid_momentum(3, 0:LAST) = 0   !< int chi u_s
    real(rp) :: solid_moment(3, 0:LAST) = 0     !< int chi r x u_s
    real(rp) :: solid_volume(0:LAST) = 0        !< int chi
    real(rp) :: slip(0:LAST) = 0                !< int chi |u - u_s|^2
    real(rp) :: power(3, 0:LAST) = 0            !< components of -int u_s . chi/C_eta (u - u_s)
    real(rp) :: energy(3) = 0                   !< 1/2 int u_i^2
    real(rp) :: enstrophy(3) = 0                !< int omega_i^2
    real(rp) :: energy_fluid(3) = 0             !< 1/2 int (1-chi)^2 u_i^2
    real(rp) :: enstrophy_fluid(3) = 0          !< int (1-chi)^2 omega_i^2
    real(rp) :: mean(3) = 0                     !< mean velocity
    ! Maxima
    real(rp) :: u_max = 0                       !< largest |u|
    real(rp) :: divergence = 0                  !< largest |div u|
    real(rp) :: divergence_fluid = 0            !< largest |div u| (1-chi)
    logical :: is_finite = .true.
  contains
    procedure :: clear => sums_clear
    procedure :: add_solid_line => sums_add_solid_line
    procedure :: reduce => sums_reduce
  end type sums_t

contains

  !> Sets all sums to zero.
  subroutine sums_clear(self)
    class(sums_t), intent(out) :: self
    associate (all_components_take_their_defaults => self)
    end associate
  end subroutine sums_clear

  !> Adds the penalized points of line `line` of `penalty` to the forces, the moments and the integrals over the mask; `lever` has
  !> the lever arms of the line. Adds the penalization term of the velocity u to `n`. The sums are not yet multiplied by the cell
  !> volume.
  subroutine sums_add_solid_line(self, penalty, line, c_eta, lever, u, n)
    class(sums_t), intent(inout) :: self
    type(penalty_t), intent(in) :: penalty
    integer, intent(in) :: line
    real(rp), intent(in) :: c_eta
    type(lever_t), intent(in) :: lever
    real(rp), intent(in) :: u(:, :)    !< (nx, 3)
    real(rp), intent(inout) :: n(:, :) !< (nx, 3)
    real(rp) :: slip(3), f(3), r(3), us(3), chi
    integer :: i, x, c
    do i = penalty%line_first(line), penalty%line_last(line)
      x = penalty%x(i)
      c = penalty%color(i)
      chi = penalty%chi(i)
      us = penalty%us(:, i)
      slip = u(x, :) - us
      f = chi/c_eta*slip
      n(x, :) = n(x, :) - f
      r = lever%arm
      r(1) = lever%arm(1) + (x - 1)*lever%spacing
      if (lever%period > 0) r(1) = r(1) - lever%period*anint(r(1)/lever%period)
      self%force(:, c) = self%force(:, c) + f
      self%moment(:, c) = self%moment(:, c) + cross(r, f)
      self%solid_momentum(:, c) = self%solid_momentum(:, c) + chi*us
      self%solid_moment(:, c) = self%solid_moment(:, c) + chi*cross(r, us)
      self%solid_volume(c) = self%solid_volume(c) + chi
      self%slip(c) = self%slip(c) + chi*sum(slip**2)
      self%power(:, c) = self%power(:, c) - us*f
    end do
  end subroutine sums_add_solid_line

  !> Returns the vector product.
  pure function cross(a, b) result(c)
    real(rp), intent(in) :: a(3), b(3)
    real(rp) :: c(3)
    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  !> Multiplies sums by the cell volume and reduces sums and maxima over the ranks. Collective.
  subroutine sums_reduce(self, world, cell_volume)
    class(sums_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    real(rp), intent(in) :: cell_volume
    real(rp) :: total(16 + 17*N_COLORS), largest(4)
    integer :: n
    n = 0
    call pack_or_unpack(self, total, n, packing=.true.)
    total = total*cell_volume
    call world%sum_reals(total)
    n = 0
    call pack_or_unpack(self, total, n, packing=.false.)
    largest = [self%u_max, self%divergence, self%divergence_fluid, merge(0.0_rp, 1.0_rp, self%is_finite)]
    call world%max_reals(largest)
    self%u_max = largest(1)
    self%divergence = largest(2)
    self%divergence_fluid = largest(3)
    self%is_finite = largest(4) < 0.5_rp
  end subroutine sums_reduce

  !> Goes through one list of all sums in both directions, so that packing and unpacking cannot disagree.
  subroutine pack_or_unpack(s, buffer, n, packing)
    class(sums_t), intent(inout) :: s
    real(rp), intent(inout) :: buffer(:)
    integer, intent(inout) :: n
    logical, intent(in) :: packing
    integer :: c, i
    call move(s%kinetic_energy)
    do i = 1, 3
      call move(s%mean(i))
      call move(s%energy(i))
      call move(s%enstrophy(i))
      call move(s%energy_fluid(i))
      call move(s%enstrophy_fluid(i))
    end do
    do c = 0, LAST
      call move(s%solid_volume(c))
      call move(s%slip(c))
      do i = 1, 3
        call move(s%force(i, c))
        call move(s%power(i, c))
        call move(s%moment(i, c))
        call move(s%solid_momentum(i, c))
        call move(s%solid_moment(i, c))
      end do
    end do

  contains

    !> Appends a number to the packed numbers, or takes the next one from them.
    subroutine move(x)
      real(rp), intent(inout) :: x
      n = n + 1
      if (packing) then
        buffer(n) = x
      else
        x = buffer(n)
      end if
    end subroutine move
  end subroutine pack_or_unpack
end module fluid_sums
