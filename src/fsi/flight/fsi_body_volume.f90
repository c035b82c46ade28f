! SPDX-License-Identifier: GPL-3.0-or-later
!> Integrates the mask over the points of a penalized body: the volume of the fluid that it displaces, with its first and second
!> moments.
module fsi_body_volume
  use base_kinds, only: rp
  use fluid_penalty, only: penalty_t
  use fsi_moments, only: moments_t
  use parallel_block, only: block_t
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: displaced_moments

contains

  !> Returns int chi, int chi r and int chi r r^T over the points of `color`. r leads from `centre` to the nearest image of a
  !> point; its components are along the axes to which `matrix` takes those of space. The same on all ranks. Collective.
  type(moments_t) function displaced_moments(world, grid, block, penalty, color, centre, matrix) result(m)
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    type(penalty_t), intent(in) :: penalty
    integer, intent(in) :: color
    real(rp), intent(in) :: centre(3), matrix(3, 3)
    real(rp) :: total(13), r(3), volume
    integer :: y, z, line, i, k
    do z = 1, block%count(3)
      do y = 1, block%count(2)
        line = y + block%count(2)*(z - 1)
        do i = penalty%line_first(line), penalty%line_last(line)
          if (penalty%color(i) /= color) cycle
          r = ([penalty%x(i) - 1, y - 1, z - 1] + block%start)*grid%spacing - centre
          r = r - grid%length*anint(r/grid%length)
          r = matmul(matrix, r)
          volume = penalty%chi(i)*grid%cell_volume()
          m%mass = m%mass + volume
          m%first = m%first + volume*r
          do k = 1, 3
            m%second(:, k) = m%second(:, k) + volume*r*r(k)
          end do
        end do
      end do
    end do
    total = [m%mass, m%first, reshape(m%second, [9])]
    call world%sum_reals(total)
    m%mass = total(1)
    m%first = total(2:4)
    m%second = reshape(total(5:13), [3, 3])
  end function displaced_moments
end module fsi_body_volume
