! SPDX-License-Identifier: GPL-3.0-or-later
!> Draws the analytic bodies and walls into the sparse mask.
!>
!> Profile of FLUSI: chi = 1 inside d <= -h, 0 outside d >= h, (1 + cos(pi (d + h)/(2 h)))/2 between, with the signed distance d
!> from the surface (negative inside) and h = 1.5 max(dx). Walls are sharp. Only the walls and the cylinder of the channel with
!> inflow have the profile of wings, h = max(dx). Where bodies overlap, the larger chi wins.
module fluid_bodies
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_memory, only: check_allocation, REAL_BYTES
  use fluid_inflow, only: inflow_profile
  use fluid_params, only: fluid_params_t
  use fluid_penalty, only: penalty_t, COLOR_WALL, COLOR_BODY, COLOR_OBSTACLE
  use fluid_shapes, only: shape_t, NO_SHAPE
  use fluid_solid_keys, only: CHANNEL_NONE, CHANNEL_XY, CHANNEL_XY_SLIDING, CHANNEL_XZ_SLIDING, MASK_FILE
  use io_fields, only: read_field, field_meta_t
  use parallel_block, only: block_t
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: draw_bodies, mask_profile, check_box

  real(rp), parameter :: SMOOTHING_CELLS = 1.5_rp

contains

  !> Fills `penalty` with the solids of `params` on this rank's `block`. Fails if a mask file cannot be
  !> read. Collective (the mask may come from a file).
  subroutine draw_bodies(world, params, block, penalty, failure)
    type(world_t), intent(in) :: world
    type(fluid_params_t), intent(in) :: params
    type(block_t), intent(in) :: block
    type(penalty_t), intent(inout) :: penalty
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: chi(:), us(:, :), from_file(:, :, :)
    integer, allocatable :: color(:)
    type(field_meta_t) :: meta
    integer :: y, z, status
    real(rp) :: point(3)

    allocate (chi(block%count(1)), us(3, block%count(1)), color(block%count(1)))
    if (params%solids%is_on .and. params%solids%mask == MASK_FILE) then
      allocate (from_file(block%count(1), block%count(2), block%count(3)), stat=status)
      call check_allocation(status, block%count, REAL_BYTES, 'the mask of a file')
      call read_field(world, params%solids%mask_file(), block, from_file, meta, failure)
      if (.not. failure%failed) call check_box(params%solids%mask_file(), meta, params%grid, failure)
      if (failure%failed) return
    end if
    call penalty%begin(block)
    do z = 1, block%count(3)
      do y = 1, block%count(2)
        chi = 0
        us = 0
        color = merge(COLOR_OBSTACLE, COLOR_BODY, params%solids%obstacle /= NO_SHAPE)
        point = ([0, y - 1, z - 1] + block%start)*params%grid%spacing
        if (params%solids%is_on) then
          if (allocated(from_file)) then
            chi = min(1.0_rp, max(0.0_rp, from_file(:, y, z)))
            us = spread(params%solids%us_fixed, 2, size(chi))
          else
            call draw_body(params, block, point, chi, us)
          end if
          if (params%walls%has_inflow) then
            call draw_inflow_channel(params, point, chi, us, color)
          else
            call draw_channel(params, point, chi, us, color)
          end if
          if (params%walls%has_cavity) call draw_cavity(params, [0, y - 1, z - 1] + block%start, chi, us, color)
        end if
        call penalty%add_line(chi, us, color)
      end do
    end do
    call penalty%finish()
  end subroutine draw_bodies

  !> Fails if the field file `path` belongs to a box of another size.
  subroutine check_box(path, meta, grid, failure)
    character(*), intent(in) :: path
    type(field_meta_t), intent(in) :: meta
    type(grid_t), intent(in) :: grid
    type(failure_t), intent(inout) :: failure
    character(120) :: text
    if (all(abs(meta%domain_size - grid%length) <= 1.0e-6_rp*grid%length)) return
    write (text, '(a,3(1x,g0.6),a,3(1x,g0.6))') ': its box has the lengths', meta%domain_size, ', the run has', &
      grid%length
    call failure%raise(path//trim(text))
  end subroutine check_box

  !> Returns the smoothed step at the signed distance d (negative inside) with half-width h: 1 inside, 0 outside.
  elemental real(rp) function mask_profile(d, h) result(chi)
    real(rp), intent(in) :: d, h
    if (d <= -h) then
      chi = 1
    else if (d >= h) then
      chi = 0
    else
      chi = 0.5_rp*(1 + cos(PI*(d + h)/(2*h)))
    end if
  end function mask_profile

  !> Draws one line of the body of the mask, or of the obstacle beside an insect.
  subroutine draw_body(p, block, line_point, chi, us)
    type(fluid_params_t), intent(in) :: p
    type(block_t), intent(in) :: block
    real(rp), intent(in) :: line_point(3)
    real(rp), intent(inout) :: chi(:), us(:, :)
    type(shape_t) :: shape
    real(rp) :: h, point(3), distance
    integer :: x
    shape = p%solids%shape()
    if (shape%kind == NO_SHAPE) return
    h = SMOOTHING_CELLS*p%grid%max_spacing()
    ! Lines that cannot touch a compact body cost one comparison.
    point = nearest_image(line_point - p%solids%centre, p%grid)
    if (any(abs(point(2:3)) > shape%reach() + h)) return
    do x = 1, block%count(1)
      point = line_point
      point(1) = (x - 1)*p%grid%spacing(1)
      point = nearest_image(point - p%solids%centre, p%grid)
      us(:, x) = p%solids%us_fixed
      call shape%distance(point, p%grid, distance, us(:, x))
      chi(x) = mask_profile(distance, h)
    end do
  end subroutine draw_body

  !> Returns the shortest periodic image of a separation, because a body may reach across the faces of the box.
  pure function nearest_image(separation, grid) result(shortest)
    real(rp), intent(in) :: separation(3)
    type(grid_t), intent(in) :: grid
    real(rp) :: shortest(3)
    shortest = separation - grid%length*anint(separation/grid%length)
  end function nearest_image

  !> Draws a single wall, which in a periodic box forms both walls of a channel.
  subroutine draw_channel(p, line_point, chi, us, color)
    type(fluid_params_t), intent(in) :: p
    real(rp), intent(in) :: line_point(3)
    real(rp), intent(inout) :: chi(:), us(:, :)
    integer, intent(inout) :: color(:)
    real(rp) :: height
    if (p%walls%channel == CHANNEL_NONE) return
    height = merge(line_point(3), line_point(2), any(p%walls%channel == [CHANNEL_XY, CHANNEL_XY_SLIDING]))
    if (height < p%walls%position - p%walls%thickness .or. height > p%walls%position) return
    chi = 1
    color = COLOR_WALL
    us = 0
    ! A sliding wall moves with the mean flow. This is flight in still air above the ground, in the frame of the flyer.
    if (any(p%walls%channel == [CHANNEL_XY_SLIDING, CHANNEL_XZ_SLIDING])) us = spread(p%mean%velocity, 2, size(chi))
  end subroutine draw_channel

  !> Draws walls, inflow zone and cylinder of the channel along y; the flow does not depend on x.
  subroutine draw_inflow_channel(p, line_point, chi, us, color)
    type(fluid_params_t), intent(in) :: p
    real(rp), intent(in) :: line_point(3)
    real(rp), intent(inout) :: chi(:), us(:, :)
    integer, intent(inout) :: color(:)
    real(rp) :: h, middle(3), point(3), wall, inflow, cylinder
    h = p%grid%max_spacing()
    middle = [0.0_rp, p%grid%length(2) - p%walls%inflow_length/2, p%walls%position - p%walls%thickness/2]
    point = nearest_image(line_point - middle, p%grid)
    wall = mask_profile(abs(point(3)) - p%walls%thickness/2, h)
    inflow = mask_profile(abs(point(2)) - p%walls%inflow_length/2, h)
    point = nearest_image(line_point - [0.0_rp, p%walls%cylinder], p%grid)
    cylinder = 0
    if (p%solids%size > 0) cylinder = mask_profile(hypot(point(2), point(3)) - p%solids%size/2, h)
    chi = max(wall, inflow, cylinder)
    us = 0
    color = COLOR_WALL
    if (cylinder > max(wall, inflow)) then
      color = COLOR_BODY
    else if (inflow >= wall) then
      us(2, :) = p%walls%inflow_velocity*inflow_profile(p, line_point(3))
    end if
  end subroutine draw_inflow_channel

  !> Draws walls of cavity_size points on every face of the box.
  subroutine draw_cavity(p, line_index, chi, us, color)
    type(fluid_params_t), intent(in) :: p
    integer, intent(in) :: line_index(3) !< 0-based indices of the first point of the line
    real(rp), intent(inout) :: chi(:), us(:, :)
    integer, intent(inout) :: color(:)
    integer :: x, i(3), k
    logical :: wall
    do x = 1, size(chi)
      i = line_index
      i(1) = x - 1
      wall = .false.
      do k = merge(2, 1, p%grid%is_2d), 3
        wall = wall .or. i(k) < p%walls%cavity_size .or. i(k) >= p%grid%n(k) - p%walls%cavity_size
      end do
      if (.not. wall) cycle
      chi(x) = 1
      us(:, x) = 0
      color(x) = COLOR_WALL
    end do
  end subroutine draw_cavity
end module fluid_bodies
