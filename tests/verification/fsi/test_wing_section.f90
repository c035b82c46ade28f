! SPDX-License-Identifier: GPL-3.0-or-later
!> A wing in a two-dimensional flow is a strip of which the flow sees the section at x = 0: its mask, the fluid it
!> displaces, the pressure it feels.
program test_wing_section
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_penalty, only: penalty_t
  use fsi_displaced, only: displaced_volumes
  use fsi_mask, only: mask_t
  use fluid_sampling, only: sampler_t, samples_t
  use fsi_pressure_load, only: pressure_load_t
  use fsi_surface, only: surface_t
  use parallel_block, only: block_t
  use spectral_grid, only: grid_t, make_grid
  use support_mask, only: empty_penalty, field_t, fields_of, whole_block
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: LENGTH = 0.8_rp, THICKNESS = 0.2_rp, TILT = 0.4_rp, ROOT(2) = [0.61_rp, 0.83_rp]
  integer, parameter :: CELLS = 7
  type(testkit_t) :: t

  call t%start(parallel=.true.)
  call test_area()
  call test_load()
  call t%finish()

contains

  !> The strip, one wide, from ROOT in the direction (0, cos, sin) of TILT; it turns about its root with the rate 1.
  !> reference(3, :) are its points in the wing frame, in which its chord is along y.
  subroutine make_strip(surface, reference)
    type(surface_t), intent(out) :: surface
    real(rp), intent(out) :: reference(3, 2*CELLS + 2)
    real(rp) :: points(3, 2*CELLS + 2)
    integer :: triangles(3, 2*CELLS), i
    reference = 0
    do i = 0, CELLS
      reference(1, 2*i + 1:2*i + 2) = LENGTH*i/CELLS
      reference(2, 2*i + 1:2*i + 2) = [-0.5_rp, 0.5_rp]
      if (i == CELLS) exit
      triangles(:, 2*i + 1) = 2*i + [1, 3, 4]
      triangles(:, 2*i + 2) = 2*i + [1, 4, 2]
    end do
    points(1, :) = reference(2, :)
    points(2, :) = ROOT(1) + reference(1, :)*cos(TILT)
    points(3, :) = ROOT(2) + reference(1, :)*sin(TILT)
    call surface%init(points, triangles, 2)
    surface%velocities(2, :) = -(points(3, :) - ROOT(2))
    surface%velocities(3, :) = points(2, :) - ROOT(1)
  end subroutine make_strip

  !> The smoothed sheet has the area t L + pi (t^2/4 + h^2 (1 - 8/pi^2)): the variance of the step's derivative is
  !> h^2 (1 - 8/pi^2). With u_s that of the closest point its momentum is that of the displaced volumes, which
  !> leave h out: the round ends carry u_s of root and tip.
  subroutine test_area()
    integer, parameter :: N(3) = [48, 96, 192]
    type(surface_t) :: surfaces(1)
    type(field_t) :: field
    type(grid_t) :: grid
    real(rp), allocatable :: volumes(:)
    real(rp) :: reference(3, 2*CELLS + 2), area, h, error(3), momentum(2), tips
    integer :: i
    call make_strip(surfaces(1), reference)
    call displaced_volumes(reference, surfaces(1)%triangles, THICKNESS, volumes, is_section=.true.)
    call t%check_close('a section displaces t L + pi t^2/4', sum(volumes), THICKNESS*LENGTH + PI*THICKNESS**2/4, &
                       rtol=1.0e-14_rp)
    h = 0.05_rp
    tips = PI/2*(THICKNESS**2/4 + h**2*(1 - 8/PI**2)) ! area of one round end
    do i = 1, 3
      grid = make_grid([1, N(i), N(i)], [1.0_rp, 2.0_rp, 2.0_rp])
      call draw(surfaces, grid, h, field)
      area = sum(field%chi)*grid%cell_volume()
      error(i) = abs(area/(THICKNESS*LENGTH + 2*tips) - 1)
      momentum = [sum(field%chi*field%us(2, :, :, :)), sum(field%chi*field%us(3, :, :, :))]*grid%cell_volume()
    end do
    call t%check_below('its mask has this area', error(3), 1.0e-5_rp)
    ! The step has a continuous derivative, so that sums over the grid converge with the third power or better.
    call t%check_order('to third order or better', 2.0_rp/N, error, 3.7_rp, 0.7_rp)
    call t%check_close('and its momentum along y', momentum(1), -sin(TILT)*LENGTH*(THICKNESS*LENGTH/2 + tips), &
                       rtol=1.0e-5_rp)
    call t%check_close('and z', momentum(2), cos(TILT)*LENGTH*(THICKNESS*LENGTH/2 + tips), rtol=1.0e-5_rp)
    momentum = matmul(surfaces(1)%velocities(2:3, :), volumes)
    tips = PI/2*THICKNESS**2/4
    call t%check_close('which is that of the displaced volumes', momentum(2), &
                       cos(TILT)*LENGTH*(THICKNESS*LENGTH/2 + tips), rtol=1.0e-13_rp)
  end subroutine test_area

  subroutine draw(surfaces, grid, h, field)
    type(surface_t), intent(in) :: surfaces(:)
    type(grid_t), intent(in) :: grid
    real(rp), intent(in) :: h
    type(field_t), intent(out) :: field
    type(mask_t) :: mask
    type(penalty_t) :: penalty
    type(block_t) :: block
    type(failure_t) :: failure
    block = whole_block(grid)
    call empty_penalty(block, penalty)
    call mask%init(grid, block, THICKNESS/2, h)
    call mask%draw(surfaces, penalty, failure)
    call t%check('the strip is drawn',.not. failure%failed)
    call fields_of(penalty, block, field)
  end subroutine draw

  !> A pressure with a gradient in the plane: -2 d (g.n) per length and depth, along the normal.
  subroutine test_load()
    real(rp), parameter :: G(2) = [0.7_rp, -1.3_rp], D = 0.15_rp
    type(surface_t) :: surface
    type(pressure_load_t) :: load
    type(samples_t) :: beside(1)
    type(sampler_t) :: sampler
    type(grid_t) :: grid
    type(block_t) :: block
    real(rp) :: reference(3, 2*CELLS + 2), pressure(1, 64, 64), normal(2), force(3)
    integer :: y, z
    call make_strip(surface, reference)
    grid = make_grid([1, 64, 64], [1.0_rp, 2.0_rp, 2.0_rp])
    block = whole_block(grid)
    do z = 1, 64
      do y = 1, 64
        pressure(1, y, z) = dot_product(G, [y - 1, z - 1]*grid%spacing(2:3))
      end do
    end do
    call sampler%init(t%world, grid, block)
    call load%init(surface)
    call beside(1)%init(2*size(surface%triangles, 2))
    call surface%points_beside(D, beside(1)%points)
    call sampler%sample(beside(1)%points, pressure, beside(1)%values)
    call load%take_pressure(surface, beside)
    normal = [-sin(TILT), cos(TILT)]
    force = sum(load%force, 2)
    call t%check_close('the force per depth along y', force(2), -2*D*dot_product(G, normal)*LENGTH*normal(1), &
                       rtol=1.0e-12_rp)
    call t%check_close('and z', force(3), -2*D*dot_product(G, normal)*LENGTH*normal(2), rtol=1.0e-12_rp)
    call t%check_below('and none across the plane', abs(force(1)), 1.0e-14_rp)
  end subroutine test_load
end program test_wing_section
