! SPDX-License-Identifier: GPL-3.0-or-later
!> Sampling by the regularized delta function, and the pressure load on a surface.
program test_sampling
  use base_constants, only: PI
  use base_kinds, only: rp
  use fluid_sampling, only: delta_weights, sampler_t, samples_t
  use fsi_pressure_load, only: pressure_load_t
  use fsi_rotation, only: cross
  use fsi_surface, only: surface_t
  use parallel_block, only: block_t, split_evenly
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t, make_grid
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(world_t) :: world

  call t%start(parallel=.true.)
  world = t%world
  call test_weights()
  call test_smooth_field()
  call test_marks()
  call test_linear_pressure()
  call t%finish()

contains

  !> Sum 1, first moment 0, even and odd points share equally (Peskin's conditions), continuity at a cell.
  subroutine test_weights()
    real(rp) :: w(-1:2), s
    integer :: first, i
    do i = 0, 20
      s = -3 + 0.317_rp*i
      call delta_weights(s, first, w)
      call t%check_close('the weights add up to 1', sum(w), 1.0_rp, atol=1.0e-14_rp)
      call t%check_close('their first moment vanishes', sum(w*(first + [-1, 0, 1, 2] - s)), 0.0_rp, atol=1.0e-14_rp)
      call t%check_close('every second point has half the weight', w(-1) + w(1), 0.5_rp, atol=1.0e-14_rp)
    end do
    call delta_weights(2.0_rp, first, w)
    call t%check_close('on a point: 1/4, 1/2, 1/4', norm2(w - [0.25_rp, 0.5_rp, 0.25_rp, 0.0_rp]), 0.0_rp, &
                       atol=1.0e-14_rp)
  end subroutine test_weights

  !> Lines that are not marked are not looked at, and of those that are every one is near a point.
  subroutine test_marks()
    type(sampler_t) :: sampler
    type(grid_t) :: grid
    type(block_t) :: block
    real(rp), allocatable :: field(:, :, :)
    logical, allocatable :: lines(:, :)
    real(rp) :: points(3, 3), all_lines(3), some_lines(3), marked(1)
    integer :: y, z
    points = reshape([0.1_rp, 0.02_rp, 1.97_rp, 0.4_rp, 1.03_rp, -0.5_rp, 1.1_rp, 1.03_rp, 1.5_rp], [3, 3])
    grid = make_grid([16, 16, 16], [2.0_rp, 2.0_rp, 2.0_rp])
    call make_block(grid, block)
    call fill(grid, block, field)
    call sampler%init(world, grid, block)
    call sampler%sample(points, field, all_lines)
    allocate (lines(block%count(2), block%count(3)), source=.false.)
    call sampler%select_lines(points, lines)
    do z = 1, block%count(3)
      do y = 1, block%count(2)
        if (.not. lines(y, z)) field(:, y, z) = huge(1.0_rp)
      end do
    end do
    call sampler%sample(points, field, some_lines)
    call t%check('the lines that were marked suffice', all(abs(some_lines - all_lines) <= 0))
    marked = count(lines)
    call world%sum_reals(marked)
    ! Two of the three points share their lines.
    call t%check_close('sixteen for each place', marked(1), 32.0_rp, atol=0.1_rp)
  end subroutine test_marks

  !> Periodic sine waves: second order in dx, the same on every number of ranks.
  subroutine test_smooth_field()
    type(sampler_t) :: sampler
    type(grid_t) :: grid
    type(block_t) :: block
    real(rp), allocatable :: field(:, :, :)
    real(rp) :: points(3, 40), values(40), error(2)
    integer :: i, level, n
    do i = 1, 40
      points(:, i) = [1.7_rp*i, 0.31_rp*i**2, -0.9_rp*i] ! far outside of the box, too
    end do
    do level = 1, 2
      n = 16*2**level
      grid = make_grid([n, n, n], [2.0_rp, 2.0_rp, 2.0_rp])
      call make_block(grid, block)
      call fill(grid, block, field)
      call sampler%init(world, grid, block)
      call sampler%sample(points, field, values)
      error(level) = 0
      do i = 1, 40
        error(level) = max(error(level), abs(values(i) - wave(points(:, i))))
      end do
    end do
    ! The second moment of the function is at most 1/2 cell^2 in each direction: error <= (k dx)^2/4 each.
    call t%check_below('a wave is sampled', error(1), 3*(PI*2.0_rp/32)**2/4)
    call t%check_close('to second order', error(1)/error(2), 4.0_rp, rtol=0.1_rp)
  end subroutine test_smooth_field

  !> A pressure with the gradient g: every triangle of a closed or open surface feels -2 d (g.n) A n, exactly.
  subroutine test_linear_pressure()
    real(rp), parameter :: G(3) = [0.7_rp, -0.4_rp, 1.1_rp], D = 0.2_rp
    type(sampler_t) :: sampler
    type(grid_t) :: grid
    type(block_t) :: block
    type(surface_t) :: surface
    type(pressure_load_t) :: load
    type(samples_t) :: beside(1)
    real(rp), allocatable :: field(:, :, :)
    real(rp) :: normal(3), expected(3)
    integer :: i, x, y, z
    grid = make_grid([24, 24, 24], [2.4_rp, 2.4_rp, 2.4_rp])
    call make_block(grid, block)
    allocate (field(block%count(1), block%count(2), block%count(3)))
    do z = 1, block%count(3)
      do y = 1, block%count(2)
        do x = 1, block%count(1)
          field(x, y, z) = dot_product(G, (block%start + [x, y, z] - 1)*grid%spacing)
        end do
      end do
    end do
    call sampler%init(world, grid, block)
    call surface%init(reshape([0.8_rp, 0.8_rp, 1.0_rp, 1.6_rp, 0.9_rp, 1.1_rp, 1.0_rp, 1.5_rp, 1.3_rp, &
                               1.7_rp, 1.6_rp, 1.2_rp], [3, 4]), reshape([1, 2, 3, 2, 4, 3], [3, 2]), 2)
    call load%init(surface)
    call beside(1)%init(4)
    call surface%points_beside(D, beside(1)%points)
    call sampler%sample(beside(1)%points, field, beside(1)%values)
    call load%take_pressure(surface, beside)
    expected = 0
    do i = 1, 2
      associate (p => surface%points, c => surface%triangles(:, i))
        normal = cross(p(:, c(2)) - p(:, c(1)), p(:, c(3)) - p(:, c(1)))
      end associate
      call t%check_close('the jump of a linear pressure', load%jump(i), 2*D*dot_product(G, normal)/norm2(normal), &
                         rtol=1.0e-13_rp)
      expected = expected - D*dot_product(G, normal)*normal/norm2(normal)
    end do
    call t%check_close('the force on all points', norm2(sum(load%force, 2) - expected), 0.0_rp, atol=1.0e-13_rp)
    call t%check_close('a corner carries a third of its triangle', norm2(load%force(:, 4)), &
                       norm2(load%force(:, 2) - load%force(:, 1)), rtol=1.0e-12_rp)
  end subroutine test_linear_pressure

  subroutine make_block(grid, block)
    type(grid_t), intent(in) :: grid
    type(block_t), intent(out) :: block
    block%n = grid%n
    block%count = grid%n
    call split_evenly(grid%n(3), world%size, world%rank, block%start(3), block%count(3))
  end subroutine make_block

  subroutine fill(grid, block, field)
    type(grid_t), intent(in) :: grid
    type(block_t), intent(in) :: block
    real(rp), allocatable, intent(inout) :: field(:, :, :)
    integer :: x, y, z
    if (allocated(field)) deallocate (field)
    allocate (field(block%count(1), block%count(2), block%count(3)))
    do z = 1, block%count(3)
      do y = 1, block%count(2)
        do x = 1, block%count(1)
          field(x, y, z) = wave((block%start + [x, y, z] - 1)*grid%spacing)
        end do
      end do
    end do
  end subroutine fill

  pure real(rp) function wave(x)
    real(rp), intent(in) :: x(3)
    wave = sin(PI*x(1) + 0.3_rp)*cos(PI*x(2))*sin(PI*x(3) - 1)
  end function wave
end program test_sampling
