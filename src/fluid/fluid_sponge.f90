! SPDX-License-Identifier: GPL-3.0-or-later
!> Applies the vorticity sponge: near the faces of the box the vorticity decays with the time C_sp.
!>
!> In physical space s = -(chi_sp/C_sp) omega; the velocity term is its Biot-Savart field
!> i k x s / k^2, which is solenoidal and leaves the mean flow alone (Engels, Kolomenskiy, Schneider &
!> Sesterhenn 2016, DOI 10.1137/15M1026006). chi_sp is 0 or 1, by index.
module fluid_sponge
  use base_kinds, only: rp
  use fluid_params, only: fluid_params_t
  use fluid_sponge_keys, only: SPONGE_CAVITY, SPONGE_FRAME, SPONGE_OPEN_Z, SPONGE_OUTLET_X, SPONGE_TOP, SPONGE_X, &
                               SPONGE_X_Y, SPONGE_X_Z
  use parallel_block, only: block_t
  implicit none
  private
  public :: sponge_t, make_sponge

  type :: sponge_t
    logical :: is_on = .false.
    real(rp) :: rate = 0                          !< 1/C_sp
    logical, allocatable :: whole_line(:, :)      !< (ny_local, nz_local) lines that lie in the sponge along their whole length
    integer :: low = 0                            !< sponge at x indices 1 .. low of every other line
    integer :: high = 0                           !< and at the last `high` indices
  contains
    procedure :: damp => sponge_damp
  end type sponge_t

contains

  !> Sets q to -chi_sp/C_sp omega on the line (y, z), for omega and q of (nx, 3).
  pure subroutine sponge_damp(self, y, z, omega, q)
    class(sponge_t), intent(in) :: self
    integer, intent(in) :: y, z
    real(rp), intent(in) :: omega(:, :)
    real(rp), intent(inout) :: q(:, :)
    integer :: nx
    nx = size(omega, 1)
    if (self%whole_line(y, z)) then
      q = -self%rate*omega
    else
      q = 0
      q(1:self%low, :) = -self%rate*omega(1:self%low, :)
      q(nx - self%high + 1:, :) = -self%rate*omega(nx - self%high + 1:, :)
    end if
  end subroutine sponge_damp

  !> Returns the sponge of `params` on this rank's block.
  function make_sponge(params, block) result(sponge)
    type(fluid_params_t), intent(in) :: params
    type(block_t), intent(in) :: block
    type(sponge_t) :: sponge
    integer :: y, z, t
    logical :: in_y, in_z, top
    sponge%is_on = params%sponge%is_on
    if (.not. sponge%is_on) return
    sponge%rate = 1/params%sponge%damping_time
    t = params%sponge%thickness
    allocate (sponge%whole_line(block%count(2), block%count(3)))
    do z = 1, block%count(3)
      in_z = at_edge(z - 1 + block%start(3), block%n(3), t)
      ! FLUSI's top cover is one plane thinner than the other types.
      top = z - 1 + block%start(3) > block%n(3) - t
      do y = 1, block%count(2)
        in_y = at_edge(y - 1 + block%start(2), block%n(2), t)
        select case (params%sponge%kind)
        case (SPONGE_CAVITY, SPONGE_FRAME)
          sponge%whole_line(y, z) = in_y .or. in_z
        case (SPONGE_OPEN_Z, SPONGE_X_Y)
          sponge%whole_line(y, z) = in_y
        case (SPONGE_X_Z)
          sponge%whole_line(y, z) = in_z
        case (SPONGE_TOP)
          sponge%whole_line(y, z) = top
        case default
          sponge%whole_line(y, z) = .false.
        end select
      end do
    end do
    select case (params%sponge%kind)
    case (SPONGE_CAVITY, SPONGE_OPEN_Z, SPONGE_X, SPONGE_X_Y, SPONGE_X_Z)
      sponge%low = t
      sponge%high = t
    case (SPONGE_OUTLET_X)
      sponge%high = t
    end select
    if (params%grid%n(1) <= 4) then
      sponge%low = 0
      sponge%high = 0
    end if
  end function make_sponge

  !> Tells whether index i (0-based) is among the first or last t of n.
  pure logical function at_edge(i, n, t)
    integer, intent(in) :: i, n, t
    at_edge = i < t .or. i >= n - t
  end function at_edge
end module fluid_sponge
