! SPDX-License-Identifier: GPL-3.0-or-later
!> The mask of wings: distance, velocity, volume, colours, solids that never move, redrawing.
program test_wing_mask
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_bodies, only: mask_profile
  use fluid_penalty, only: penalty_t
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fsi_mask, only: mask_t
  use fsi_planform, only: elliptic_planform, rectangular_planform
  use fsi_planform_mesh, only: triangulate_planform
  use fsi_rotation, only: cross
  use fsi_surface, only: surface_t
  use parallel_block, only: block_t
  use spectral_grid, only: grid_t, make_grid
  use support_fluid, only: make_fluid, box_3d, NL
  use support_mask, only: field_t, fields_of, whole_block, turn, same_fields, empty_penalty
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: SPAN = 0.5_rp, CHORD = 0.2_rp
  real(rp), parameter :: HINGE(3) = [0.31_rp, 0.27_rp, 0.43_rp], OMEGA(3) = [3.0_rp, -2.0_rp, 5.0_rp], &
                         VELOCITY(3) = [0.4_rp, 0.1_rp, -0.7_rp]
  type(testkit_t) :: kit

  call kit%start(parallel=.true.)
  call test_points()
  call test_volume()
  call test_volume_fixed_thickness()
  call test_two_wings()
  call test_body_and_redraw()
  call test_failure()
  call test_fluid()
  call kit%finish()

contains

  !> A rectangular wing from the hinge, turned by `angles`, moving rigidly.
  function plate(edge, angles, hinge, color) result(wing)
    real(rp), intent(in) :: edge, angles(3), hinge(3)
    integer, intent(in) :: color
    type(surface_t) :: wing
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    call triangulate_planform(rectangular_planform(0.0_rp, SPAN, CHORD, 0.5_rp), edge, points, triangles)
    call wing%init(points, triangles, color)
    call wing%place_rigid(points, turn(angles), hinge, VELOCITY, OMEGA)
  end function plate

  !> The mask of `wings` alone on a box of side 1 and n^3 points.
  subroutine draw(n, half, smoothing, wings, field, mask)
    integer, intent(in) :: n
    real(rp), intent(in) :: half, smoothing
    type(surface_t), intent(in) :: wings(:)
    type(field_t), intent(out) :: field
    type(mask_t), intent(out) :: mask
    type(grid_t) :: grid
    type(block_t) :: block
    type(penalty_t) :: penalty
    type(failure_t) :: failure
    grid = make_grid([n, n, n], [1.0_rp, 1.0_rp, 1.0_rp])
    block = whole_block(grid)
    call empty_penalty(block, penalty)
    call mask%init(grid, block, half, smoothing)
    call mask%draw(wings, penalty, failure)
    call fields_of(penalty, block, field)
  end subroutine draw

  !> Every point of the box against the closest point of a rectangle, which is worked out in the wing's frame:
  !> chi and u_s to round-off, nothing missing and nothing too much.
  subroutine test_points()
    integer, parameter :: N = 48
    real(rp), parameter :: DX = 1.0_rp/N, ANGLES(3) = [0.5_rp, -0.7_rp, 1.1_rp]
    type(field_t) :: field
    type(mask_t) :: mask
    type(surface_t) :: wings(1)
    real(rp) :: rotation(3, 3), p(3), q(3), arm(3), us(3), worst(2)
    integer :: x, y, z
    wings(1) = plate(0.03_rp, ANGLES, HINGE, 2)
    call draw(N, 2*DX, DX, wings, field, mask)
    rotation = turn(ANGLES)
    worst = 0
    do z = 1, N
      do y = 1, N
        do x = 1, N
          p = [x - 1, y - 1, z - 1]*DX - HINGE
          q = matmul(transpose(rotation), p)
          q = [min(SPAN, max(0.0_rp, q(1))), min(CHORD/2, max(-CHORD/2, q(2))), 0.0_rp]
          arm = matmul(rotation, q)
          us = VELOCITY + cross(OMEGA, arm)
          worst(1) = max(worst(1), abs(field%chi(x, y, z) - mask_profile(norm2(p - arm) - 2*DX, DX)))
          if (field%chi(x, y, z) > 0) worst(2) = max(worst(2), maxval(abs(field%us(:, x, y, z) - us)))
        end do
      end do
    end do
    call kit%check_below('chi is the profile of the exact distance at every point', worst(1), 1.0e-12_rp)
    call kit%check_below('u_s is the rigid motion of the closest point in the band', worst(2), 1.0e-12_rp)
    call kit%check('the mask tells how many points it has', mask%n_cells == count(field%chi > 0))
  end subroutine test_points

  !> t = 4 dx, h = dx. Steiner's formula for a flat convex plate, averaged over the smoothing, whose variance is
  !> h^2 (1 - 8/pi^2): V = A t + pi/2 P (t^2/4 + var) + 4/3 pi (t^3/8 + 3/2 t var).
  subroutine test_volume()
    real(rp), parameter :: ANGLES(3) = [0.5_rp, -0.7_rp, 1.1_rp]
    integer, parameter :: POINTS(3) = [40, 80, 160]
    real(rp) :: dx, t, variance, area, perimeter, volume, exact, smoothing_part, error(3)
    type(surface_t) :: wings(1)
    type(field_t) :: field
    type(mask_t) :: mask
    integer :: i
    area = SPAN*CHORD
    perimeter = 2*(SPAN + CHORD)
    do i = 1, 3
      dx = 1.0_rp/POINTS(i)
      t = 4*dx
      variance = dx**2*(1 - 8/PI**2)
      wings(1) = plate(2*dx, ANGLES, HINGE, 2)
      call draw(POINTS(i), t/2, dx, wings, field, mask)
      volume = sum(field%chi)*dx**3
      smoothing_part = PI/2*perimeter*variance + 2*PI*t*variance
      exact = area*t + PI*t**2*perimeter/8 + PI*t**3/6 + smoothing_part
      error(i) = (volume - (area*t + PI*t**2*perimeter/8 + PI*t**3/6))/exact
      ! Sums over the points of a smoothed step of four cells: 1e-4 of the volume at any resolution.
      call kit%check_close('volume of a sheet by Steiner''s formula, smoothing included', volume, exact, rtol=3.0e-4_rp)
    end do
    call kit%check_below('A t + pi t^2 P/8 + pi t^3/6 is met to the smoothing error', maxval(abs(error)), 0.025_rp)
   call kit%check_order('and to first order of the volume, as h/t is fixed', 1.0_rp/POINTS, abs(error), 1.0_rp, 0.25_rp)
  end subroutine test_volume

  !> The sheet keeps its thickness while the grid is refined: what remains is how well a sum over points takes
  !> the integral of chi, which has continuous slopes.
  subroutine test_volume_fixed_thickness()
    real(rp), parameter :: T = 0.16_rp, H = 0.08_rp, ANGLES(3) = [0.5_rp, -0.7_rp, 1.1_rp]
    integer, parameter :: POINTS(3) = [16, 32, 64]
    real(rp) :: variance, exact, error(3)
    type(surface_t) :: wings(1)
    type(field_t) :: field
    type(mask_t) :: mask
    integer :: i
    variance = H**2*(1 - 8/PI**2)
    exact = SPAN*CHORD*T + PI/2*2*(SPAN + CHORD)*(T**2/4 + variance) + 4*PI/3*(T**3/8 + 3*T*variance/2)
    wings(1) = plate(0.05_rp, ANGLES, HINGE, 2)
    do i = 1, 3
      call draw(POINTS(i), T/2, H, wings, field, mask)
      error(i) = abs(sum(field%chi)/real(POINTS(i), rp)**3/exact - 1)
    end do
    ! A jump of curvature leaves third order or better; limits fall by 8.
    call kit%check_below('a sheet of fixed thickness on 16^3 points has its volume', error(1), 1.0e-3_rp)
    call kit%check_below('on 32^3 points', error(2), 1.0e-3_rp/8)
    call kit%check_below('on 64^3 points, third order or better', error(3), 1.0e-3_rp/64)
  end subroutine test_volume_fixed_thickness

  !> The union of two crossing wings is where each of them is alone, with the nearer one's colour and velocity.
  subroutine test_two_wings()
    integer, parameter :: N = 48
    real(rp), parameter :: DX = 1.0_rp/N
    type(surface_t) :: wings(2), swapped(2)
    type(field_t) :: both, reverse, alone(2)
    type(mask_t) :: mask
    logical, allocatable :: first(:, :, :), second(:, :, :)
    integer :: c
    wings(1) = plate(0.03_rp, [0.2_rp, 0.3_rp, 0.4_rp], HINGE, 2)
    wings(2) = plate(0.04_rp, [1.2_rp, 0.3_rp, 0.2_rp], HINGE + [0.1_rp, 0.05_rp, 0.0_rp], 3)
    wings(2)%velocities = 2*wings(2)%velocities
    swapped = wings([2, 1])
    call draw(N, 2*DX, DX, wings, both, mask)
    call draw(N, 2*DX, DX, swapped, reverse, mask)
    call draw(N, 2*DX, DX, wings(1:1), alone(1), mask)
    call draw(N, 2*DX, DX, wings(2:2), alone(2), mask)
    first = alone(1)%chi > alone(2)%chi
    second = alone(2)%chi > alone(1)%chi
    call kit%check('the union of two wings has the larger chi', &
                   all(abs(both%chi - max(alone(1)%chi, alone(2)%chi)) <= 0))
    call kit%check('the wings do meet', any(alone(1)%chi > 0 .and. alone(2)%chi > 0 .and. first) .and. &
                   any(alone(1)%chi > 0 .and. alone(2)%chi > 0 .and. second))
    call kit%check('the nearer wing gives the colour', all(both%color == 2 .or. .not. first) .and. &
                   all(both%color == 3 .or. .not. second))
    do c = 1, 3
      call kit%check('and the velocity', &
                     all(abs(both%us(c, :, :, :) - alone(1)%us(c, :, :, :)) <= 0 .or. .not. first) .and. &
                     all(abs(both%us(c, :, :, :) - alone(2)%us(c, :, :, :)) <= 0 .or. .not. second))
    end do
    call kit%check('the order of the wings does not matter to chi', all(abs(both%chi - reverse%chi) <= 0))
  end subroutine test_two_wings

  !> A wing through a solid sphere: larger chi wins, erasing brings the sphere back, redrawing leaves nothing of
  !> the old place and needs no more memory.
  subroutine test_body_and_redraw()
    integer, parameter :: N = 48, STEPS = 20
    real(rp), parameter :: DX = 1.0_rp/N
    type(grid_t) :: grid
    type(block_t) :: block
    type(penalty_t) :: penalty, fresh, body
    type(mask_t) :: mask
    type(surface_t) :: wings(1), none(0)
    type(failure_t) :: failure
    type(field_t) :: field, want, sphere, alone
    integer :: i, room
    logical :: same, larger
    grid = make_grid([N, N, N], [1.0_rp, 1.0_rp, 1.0_rp])
    block = whole_block(grid)
    call add_sphere(block, DX, body)
    call add_sphere(block, DX, penalty)
    call fields_of(body, block, sphere)
    call mask%init(grid, block, 2*DX, DX)
    same = .true.
    larger = .true.
    do i = 0, STEPS
      wings(1) = plate(0.03_rp, [0.3_rp*i, 0.2_rp, 0.1_rp*i], HINGE, 3)
      call mask%draw(wings, penalty, failure)
      call add_sphere(block, DX, fresh)
      call mask%draw(wings, fresh, failure)
      call fields_of(penalty, block, field)
      call fields_of(fresh, block, want)
      same = same .and. same_fields(field, want)
      call draw(N, 2*DX, DX, wings, alone, mask)
      larger = larger .and. all(abs(field%chi - max(alone%chi, sphere%chi)) <= 0) .and. &
               all(field%color == merge(3, merge(1, -1, sphere%chi > 0), alone%chi > sphere%chi))
    end do
    call kit%check('a moving wing redrawn is a wing drawn afresh', same)
    call kit%check('wing and body: the larger chi wins, with its colour', larger)
    call kit%check('the wing does meet the body', any(alone%chi > 0 .and. sphere%chi > 0))
    call mask%draw(none, penalty, failure)
    call fields_of(penalty, block, field)
    call kit%check('no wing leaves the body as it was', same_fields(field, sphere))
    call mask%draw(wings, penalty, failure)
    room = size(penalty%x)
    do i = 1, STEPS
      call mask%draw(wings, penalty, failure)
    end do
    call kit%check('redrawing the same needs no more memory', size(penalty%x) == room)
    call kit%check('colours are counted without what is hidden', all(penalty%count_colors() == &
                       [0, count(field%chi > 0 .and. alone%chi <= sphere%chi), 0, count(alone%chi > sphere%chi), 0, 0]))

  end subroutine test_body_and_redraw

  !> A sphere as a solid that never moves.
  subroutine add_sphere(block, dx, penalty)
    type(block_t), intent(in) :: block
    real(rp), intent(in) :: dx
    type(penalty_t), intent(inout) :: penalty
    real(rp) :: chi(block%n(1)), us(3, block%n(1))
    integer :: color(block%n(1)), x, y, z
    color = 1
    call penalty%begin(block)
    do z = 1, block%n(3)
      do y = 1, block%n(2)
        do x = 1, block%n(1)
          chi(x) = mask_profile(norm2([x, y, z]*dx - HINGE - 0.1_rp) - 0.12_rp, 1.5_rp*dx)
          us(:, x) = [y, z, x]*dx
        end do
        call penalty%add_line(chi, us, color)
      end do
    end do
    call penalty%finish()
  end subroutine add_sphere

  !> A solid solver that has blown up must not hang the mask.
  subroutine test_failure()
    type(grid_t) :: grid
    type(block_t) :: block
    type(penalty_t) :: penalty
    type(mask_t) :: mask
    type(surface_t) :: wings(1)
    type(failure_t) :: failure
    grid = make_grid([16, 16, 16], [1.0_rp, 1.0_rp, 1.0_rp])
    block = whole_block(grid)
    call empty_penalty(block, penalty)
    call mask%init(grid, block, 0.125_rp, 0.0625_rp)
    wings(1) = plate(0.05_rp, [0.0_rp, 0.0_rp, 0.0_rp], HINGE, 2)
    call mask%draw(wings, penalty, failure)
    call kit%check('a wing in the box can be drawn',.not. failure%failed .and. penalty%n_points > 0)
    wings(1)%points(2, 7) = 1.0e30_rp
    call mask%draw(wings, penalty, failure)
   call kit%check('a wing with a point at 1e30 is a failure, and is erased', failure%failed .and. penalty%n_points == 0)
  end subroutine test_failure

  !> The fluid sees the wing: volume, momentum and the force on a wing that moves in fluid at rest.
  subroutine test_fluid()
    integer, parameter :: N = 32
    real(rp), parameter :: DX = 1.0_rp/N
    type(fluid_t) :: fluid
    type(mask_t) :: mask
    type(surface_t) :: wings(1)
    type(failure_t) :: failure
    type(request_t) :: integrals
    real(rp) :: total(4)
    integer :: i
    call make_fluid(kit%world, box_3d(N, 1.0_rp)//'[Penalization]'//NL//'iPenalization=1'//NL//'iMask=sphere'//NL// &
                    'eps=1.0e-2'//NL//'[Geometry]'//NL//'Size=0.3'//NL//'x0=0.8'//NL//'y0=0.8'//NL//'z0=0.8'//NL// &
                    '[ReynoldsNumber]'//NL//'nu=1.0e-2'//NL//'[Time]'//NL//'Tmax=1'//NL// &
                    '[InitialCondition]'//NL//'inicond=quiescent', fluid)
    wings(1) = plate(0.05_rp, [0.1_rp, 0.2_rp, 0.3_rp], [0.1_rp, 0.3_rp, 0.3_rp], 2)
    call mask%init(fluid%rhs%params%grid, fluid%rhs%block, 2*DX, DX)
    call mask%draw(wings, fluid%rhs%penalty, failure)
    total = 0
    associate (penalty => fluid%rhs%penalty)
      do i = 1, penalty%n_points
        if (penalty%color(i) == 2) total = total + penalty%chi(i)*[1.0_rp, penalty%us(:, i)]*DX**3
      end do
    end associate
    call kit%world%sum_reals(total)
    integrals%integrals = .true.
    call fluid%evaluate(integrals, failure)
    call kit%check_close('the fluid sees the volume of the wing', fluid%sums%solid_volume(2), total(1), rtol=1e-12_rp)
    do i = 1, 3
      call kit%check_close('and the force on it in fluid at rest', fluid%sums%force(i, 2), -total(i + 1)/1.0e-2_rp, &
                           atol=1.0e-12_rp)
    end do
    call kit%check('the sphere is there too', fluid%sums%solid_volume(1) > 0.01_rp)
    call fluid%free()
  end subroutine test_fluid
end program test_wing_mask
