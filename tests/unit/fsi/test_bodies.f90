! SPDX-License-Identifier: GPL-3.0-or-later
!> Bodies beside the wings: volumes and moments, surfaces from STL files, the mask on the grid, FLUSI's wings.
program test_bodies
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fluid_penalty, only: COLOR_BODY, penalty_t
  use fsi_body_catalogue, only: body_numbers_t, make_named_body
  use fsi_body_parts, only: make_ellipsoid, make_revolution, make_sphere
  use fsi_closed_surface, only: closed_surface_t, make_closed_surface
  use fsi_kinematics, only: body_rotation, body_t
  use fsi_named_wings, only: make_named_wing, wing_numbers_t
  use fsi_planform, only: planform_t
  use fsi_rigid_body, only: rigid_body_t
  use fsi_rigid_mask, only: rigid_mask_t
  use fsi_rotation, only: angle_t
  use fsi_round_wing, only: make_round_wing
  use fsi_solid_shape, only: shape_holder_t, solid_shape_t
  use fsi_stl, only: read_stl, surface_volume
  use parallel_block, only: block_t
  use spectral_grid, only: grid_t, make_grid
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  character(*), parameter :: NL = new_line('a')

  call test%start(parallel=.false.)
  call check_volumes()
  call check_surface()
  call check_wedge()
  call check_stl_faults()
  call check_mask()
  call check_wing_volume()
  call check_round_edges()
  call test%finish()

contains

  function body_of(shape, h) result(body)
    class(solid_shape_t), intent(in) :: shape
    real(rp), intent(in) :: h
    type(rigid_body_t) :: body
    type(shape_holder_t), allocatable :: parts(:)
    allocate (parts(1))
    allocate (parts(1)%shape, source=shape)
    call body%init(parts, h)
  end function body_of

  !> The step adds O(h^2) to the volume: for a sphere 4 pi R h^2 (1 - 8/pi^2), the first moment of the half cosine.
  subroutine check_volumes()
    real(rp), parameter :: R = 0.3_rp, H(3) = [0.08_rp, 0.04_rp, 0.02_rp], A(3) = [0.5_rp, 0.2_rp, 0.3_rp]
    type(rigid_body_t) :: ball, egg, cone
    real(rp) :: errors(3, 3), exact, centre(3)
    integer :: i
    centre = [0.1_rp, -0.05_rp, 0.2_rp]
    do i = 1, 3
      ball = body_of(make_sphere(centre, R), H(i))
      exact = 4*PI/3*R**3
      errors(1, i) = ball%displaced%mass - exact
      if (i == 2) call test%check_close('a smoothed sphere has its exact volume', errors(1, i), &
                                        4*PI*R*H(i)**2*(1 - 8/PI**2), rtol=0.005_rp)
      call test%check_below('its centre is the centre', norm2(ball%displaced%first/ball%displaced%mass - centre), 1.0e-4_rp*R)
      egg = body_of(make_ellipsoid([0.0_rp, 0.0_rp, 0.0_rp], A), H(i))
      errors(2, i) = egg%displaced%second(1, 1)/(4*PI/15*product(A)*A(1)**2) - 1
      cone = body_of(make_revolution(reshape([0.0_rp, 0.0_rp, 0.6_rp, 0.3_rp], [2, 2])), H(i))
      errors(3, i) = cone%displaced%mass/(PI*0.3_rp**2*0.6_rp/3) - 1
    end do
    call test%check_order('sphere: the volume', H, abs(errors(1, :)), 2.0_rp, 0.1_rp)
    call test%check_order('ellipsoid: the second moment', H, abs(errors(2, :)), 2.0_rp, 0.3_rp)
    call test%check_order('cone by its profile: the volume', H, abs(errors(3, :)), 2.0_rp, 0.4_rp)
  end subroutine check_volumes

  !> A cube cut in 12 triangles: distance and sign are those of the cube everywhere, also beyond edges and corners.
  subroutine check_surface()
    type(closed_surface_t) :: cube
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    type(message_list_t) :: errors, notices
    real(rp) :: x(3), q(3), want, got, worst
    integer :: i
    logical :: signs
    call read_stl(cube_text(12), 'cube.stl', points, triangles, errors, notices)
    call test%check('a closed cube is read without a message', errors%count() == 0 .and. notices%count() == 0)
    call test%check('its corners are joined', size(points, 2) == 8)
    call test%check_close('its volume', surface_volume(points, triangles), 1.0_rp, rtol=1.0e-12_rp)
    cube = make_closed_surface(points, triangles, 0.1_rp)
    worst = 0
    signs = .true.
    do i = 1, 4000
      x = 1.6_rp*modulo(i*[0.754877666_rp, 0.569840291_rp, 0.438579021_rp], 1.0_rp) - 0.3_rp
      q = abs(x - 0.5_rp) - 0.5_rp
      want = norm2(max(q, 0.0_rp)) + min(maxval(q), 0.0_rp)
      got = cube%level_at(x)
      if (abs(want) < 0.1_rp) worst = max(worst, abs(got - want))
      signs = signs .and. (got < 0 .eqv. want < 0)
    end do
    call test%check_below('distances near the surface', worst, 1.0e-12_rp)
    call test%check('the sign is right everywhere', signs)
  end subroutine check_surface

  !> A flat tetrahedron: beyond its acute edges the normal of the nearest face alone has the wrong sign.
  subroutine check_wedge()
    type(closed_surface_t) :: wedge
    real(rp), parameter :: CORNERS(3, 4) = reshape([0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, &
                                                    0.0_rp, 0.0_rp, 0.2_rp], [3, 4])
    integer, parameter :: FACES(3, 4) = reshape([1, 3, 2, 1, 2, 4, 1, 4, 3, 2, 3, 4], [3, 4])
    real(rp) :: x(3)
    integer :: i
    logical :: signs, is_inside
    wedge = make_closed_surface(CORNERS, FACES, 0.05_rp)
    signs = .true.
    do i = 1, 8000
      x = [1.4_rp, 1.4_rp, 0.6_rp]*modulo(i*[0.754877666_rp, 0.569840291_rp, 0.438579021_rp], 1.0_rp) - 0.2_rp
      is_inside = all(x > 0) .and. x(1) + x(2) + 5*x(3) < 1
      signs = signs .and. (wedge%level_at(x) < 0 .eqv. is_inside)
    end do
    call test%check('the sign is right beyond acute edges', signs)
  end subroutine check_wedge

  subroutine check_stl_faults()
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    type(message_list_t) :: errors, notices
    call read_stl(cube_text(11), 'open.stl', points, triangles, errors, notices)
    call test%check('an open surface is refused', errors%count() == 1)
    call test%check('and told', index(errors%text(1), 'open.stl: is not closed: 3 edges') == 1)
    call read_stl(cube_text(12, flipped=5), 'turned.stl', points, triangles, errors, notices)
    call test%check('a triangle that faces in is told', index(errors%text(2), 'is not oriented') > 0)
    call read_stl('nothing', 'text.stl', points, triangles, errors, notices)
    call test%check('another file is told', index(errors%text(3), 'is no STL file') > 0)
  end subroutine check_stl_faults

  !> The unit cube as ASCII STL, its first n triangles; `flipped` is one that is turned.
  function cube_text(n, flipped) result(text)
    integer, intent(in) :: n
    integer, intent(in), optional :: flipped
    character(:), allocatable :: text
    integer, parameter :: QUADS(4, 6) = reshape([0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5], &
                                                [4, 6])
    integer :: i, k, c(3)
    character(80) :: line
    text = 'solid cube'//NL
    do i = 1, n
      c = QUADS(merge([1, 2, 3], [1, 3, 4], mod(i, 2) == 1), (i + 1)/2)
      if (present(flipped)) then
        if (i == flipped) c = c([1, 3, 2])
      end if
      text = text//'facet normal 0 0 0'//NL//'outer loop'//NL
      do k = 1, 3
        write (line, '(a,3(1x,i0))') 'vertex', mod(c(k), 2), mod(c(k)/2, 2), c(k)/4
        text = text//trim(line)//NL
      end do
      text = text//'endloop'//NL//'endfacet'//NL
    end do
    text = text//'endsolid'//NL
  end function cube_text

  !> A bumblebee that turns and moves across the faces of the box: its mask has the moments of its shape, u_s is that of the
  !> frame, and a line has every point once, in ascending order. A second drawing in the same place is the same.
  subroutine check_mask()
    type(grid_t) :: grid
    type(block_t) :: block
    type(penalty_t) :: penalty
    type(rigid_mask_t) :: mask
    type(rigid_body_t) :: bee
    type(shape_holder_t), allocatable :: parts(:)
    type(body_numbers_t) :: numbers
    type(body_t) :: frame
    real(rp) :: volume, force(3), moment(3)
    integer :: line, i, n
    logical :: ascending
    grid = make_grid([48, 48, 48], [2.0_rp, 2.0_rp, 2.0_rp])
    block%n = grid%n
    block%start = 0
    block%count = grid%n
    numbers%smoothing = grid%max_spacing()
    call make_named_body('bumblebee', numbers, parts)
    call bee%init(parts, numbers%smoothing)
    frame%centre = [1.9_rp, 0.1_rp, 1.0_rp]
    frame%velocity = [0.3_rp, 0.0_rp, -0.1_rp]
    frame%rotation = body_rotation(angle_t(value=0.3_rp), angle_t(value=-0.5_rp, rate=2.0_rp), angle_t(value=0.7_rp))
    call penalty%begin(block)
    do line = 1, grid%n(2)*grid%n(3)
      call penalty%add_line(spread(0.0_rp, 1, 48), spread([0.0_rp, 0.0_rp, 0.0_rp], 2, 48), spread(0, 1, 48))
    end do
    call penalty%finish()
    call mask%init(grid, block)
    do n = 1, 2
      call penalty%erase_overlay()
      call mask%draw(bee, frame, COLOR_BODY, penalty)
      volume = 0
      ascending = .true.
      do line = 1, penalty%n_lines
        do i = penalty%line_first(line), penalty%line_last(line)
          volume = volume + penalty%chi(i)*grid%cell_volume()
          if (i > penalty%line_first(line)) ascending = ascending .and. penalty%x(i) > penalty%x(i - 1)
        end do
      end do
      call test%check_close('a bee across the faces of the box has its volume', volume, bee%displaced%mass, rtol=0.01_rp)
      call test%check('points of a line ascend', ascending)
    end do
    ! d/dt of int chi u_s by a centred difference over a small turn.
    force = 0
    moment = 0
    frame%rotation%omega_rate = 0
    call bee%momentum_rate(frame, frame%centre, force, moment)
    call test%check_close('a body that turns at a constant rate: its fluid is driven to the axis', &
                          dot_product(force, frame%rotation%to_parent(frame%rotation%omega)), 0.0_rp, &
                          atol=1.0e-12_rp*norm2(force))
  end subroutine check_mask

  !> FLUSI's bumblebee wings in a box of 3: the mask of both has the volume 0.1143 at 64^3, 0.0569 at 128^3.
  subroutine check_wing_volume()
    type(planform_t) :: planform
    class(solid_shape_t), allocatable :: solid
    type(wing_numbers_t) :: numbers
    type(rigid_body_t) :: wing
    real(rp), parameter :: WANT(2) = [0.1143_rp, 0.0569_rp]
    real(rp) :: dx
    integer :: i
    do i = 1, 2
      dx = 3.0_rp/(64*i)
      call make_named_wing('bumblebee', numbers, 1.0_rp, 4*dx, planform, solid)
      wing = body_of(solid, dx)
      call test%check_close('two wings of a bumblebee as FLUSI draws them', 2*wing%displaced%mass, WANT(i), rtol=0.005_rp)
      deallocate (solid)
    end do
  end subroutine check_wing_volume

  !> Round edges end at the outline: a disk and a rectangle have the volumes of their sections, area times thickness less
  !> (1/2 - pi/8) t^2 for each length of the edge; the step adds half of d^2 V/dr^2 h^2 (1 - 8/pi^2).
  subroutine check_round_edges()
    integer, parameter :: N = 720
    real(rp), parameter :: T = 0.2_rp, R = T/2, RADIUS = 0.5_rp, A = 0.9_rp, B = 0.6_rp, STEP = 0.02_rp
    real(rp) :: disk(2, 2, N), around(2, 2, 4), core, volume, area
    class(solid_shape_t), allocatable :: solid
    type(rigid_body_t) :: wing
    type(planform_t) :: planform
    type(wing_numbers_t) :: numbers
    real(rp), parameter :: WANT(2) = [0.1143_rp, 0.0569_rp]
    integer :: i
    do i = 1, N
      disk(:, 1, i) = RADIUS*[cos(2*PI*(i - 1)/N), sin(2*PI*(i - 1)/N)]
      disk(:, 2, i) = RADIUS*[cos(2*PI*i/N), sin(2*PI*i/N)]
    end do
    allocate (solid, source=make_round_wing(disk, T, STEP, STEP))
    wing = body_of(solid, STEP)
    core = RADIUS - R
    volume = 2*PI*core**2*R + PI**2*R**2*core + 4*PI*R**3/3 + (PI**2*core + 4*PI*R)*STEP**2*(1 - 8/PI**2)
    call test%check_close('a disk with a round edge has its volume', wing%displaced%mass, volume, rtol=1.0e-3_rp)
    call test%check_close('which is area times thickness less what the edge lacks', wing%displaced%mass, &
                          PI*RADIUS**2*T - (0.5_rp - PI/8)*T**2*2*PI*RADIUS, rtol=0.01_rp)
    call test%check('and nothing is beyond the outline and the step', &
                    .not. wing%mask_at([RADIUS + STEP, 0.0_rp, 0.0_rp]) > 1.0e-3_rp)
    call test%check_close('where it has half of what is inside', wing%mask_at([0.0_rp, RADIUS, 0.0_rp]), 0.5_rp, atol=0.01_rp)
    deallocate (solid)
    around = reshape([0.0_rp, 0.0_rp, A, 0.0_rp, A, 0.0_rp, A, B, A, B, 0.0_rp, B, 0.0_rp, B, 0.0_rp, 0.0_rp], [2, 2, 4])
    allocate (solid, source=make_round_wing(around, T, STEP, STEP))
    wing = body_of(solid, STEP)
    volume = (A - T)*(B - T)*T + (A + B)*PI*R**2 - 16*(PI/4 - 1/3.0_rp)*R**3
    call test%check_close('a rectangle with round edges has its volume', wing%displaced%mass, volume, rtol=0.01_rp)
    deallocate (solid)
    ! A lattice in proportion to this step would have 1e17 points.
    allocate (solid, source=make_round_wing(around, T, 1.0e-8_rp, T/4))
    wing = body_of(solid, STEP)
    call test%check_close('so it has where the step is next to none', wing%displaced%mass, volume, rtol=0.01_rp)
    deallocate (solid)
    ! The wings of a bumblebee in a box of 3, as in check_wing_volume.
    do i = 1, 2
      core = 3.0_rp/(64*i)
      call make_named_wing('bumblebee', numbers, 1.0_rp, 0.0_rp, planform, solid)
      area = planform%area()
      allocate (solid, source=make_round_wing(segments_of(planform%outline), 4*core, core, core))
      wing = body_of(solid, core)
      call test%check('round edges do not make a wing larger than FLUSI''s', wing%displaced%mass < 1.01_rp*WANT(i)/2)
      call test%check('nor do they leave less than three quarters of it', wing%displaced%mass > 0.75_rp*WANT(i)/2)
      call test%check_close('FLUSI''s volume is area times thickness', WANT(i)/2, area*4*core, rtol=0.02_rp)
      deallocate (solid)
    end do
  end subroutine check_round_edges

  pure function segments_of(outline) result(segments)
    real(rp), intent(in) :: outline(:, :)
    real(rp) :: segments(2, 2, size(outline, 2))
    segments(:, 1, :) = outline
    segments(:, 2, :) = cshift(outline, 1, 2)
  end function segments_of
end program test_bodies
