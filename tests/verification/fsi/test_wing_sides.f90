! SPDX-License-Identifier: GPL-3.0-or-later
!> Pressure and traction on both sides of a wing that turns in a flow that is known everywhere and does not feel it:
!> Taylor and Green's vortices. What is looked at is smoothed over four points: the error is of second order in the
!> spacing, the distance kept.
program test_wing_sides
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_rotation, only: cross
  use fsi_wing_sides, only: wing_sides_t
  use support_wings, only: make_wings, NL, write_lines
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: NU = 0.02_rp, DISTANCE = 0.4_rp, OMEGA = 0.7_rp, SPACING = 6.283185307179586_rp/48
  type(testkit_t) :: kit
  real(rp) :: errors(2, 2)

  call kit%start(parallel=.true.)
  call write_lines(kit%world, 'wing.ini', '[Wing]'//NL//'type=rectangular'//NL//'root=0.05'//NL//'length=2.0'//NL// &
                   'mean_chord=1.0'//NL//'front=0.5')
  call look(24, errors(:, 1))
  call look(48, errors(:, 2))
  if (kit%world%is_root) print '(a,4es10.2)', 'errors of pressure and traction on both grids', errors
  ! A window of second moment m h^2 in each direction changes a mode k by m (k h)^2/2, m < 1/2; k^2 is 12 and 3.
  call kit%check_below('pressure beside the wing', errors(1, 2), 12*SPACING**2/4)
  call kit%check_below('traction', errors(2, 2), 3*SPACING**2/4)
  call kit%check_close('both of second order', minval(log(errors(:, 1)/errors(:, 2)))/log(2.0_rp), 2.0_rp, atol=0.3_rp)
  call kit%finish()

contains

  !> Largest errors on n^3 points, over the largest pressure and traction.
  subroutine look(n, errors)
    integer, intent(in) :: n
    real(rp), intent(out) :: errors(2)
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(wing_sides_t) :: sides
    type(request_t) :: request
    type(failure_t) :: failure
    character(60) :: points
    real(rp) :: centre(3), normal(3), place(3), wall(3), shear(3), turn(3), largest(2)
    integer :: i, side, p
    write (points, '(3(a,i0))') 'nx=', n, NL//'ny=', n, NL//'nz=', n
    call make_wings(kit%world, '[Resolution]'//NL//trim(points)//NL// &
                    '[Geometry]'//NL//'xl=6.283185307179586'//NL//'yl=6.283185307179586'//NL//'zl=6.283185307179586'//NL// &
                    '[ReynoldsNumber]'//NL//'nu=0.02'//NL//'[InitialCondition]'//NL//'inicond=taylor_green'//NL// &
                    '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=Insect'//NL// &
                    '[Insects]'//NL//'surface=thin'//NL//'WingShape=from_file::wing.ini'//NL//'wing_edge=0.2'//NL// &
                    'RightWing=no'//NL//'x0=3.0 2.0 3.3'//NL//'yawpitchroll_0=17.0 -12.0 23.0'//NL//'eta0=-60'//NL, &
                    fluid, wings)
    call sides%init(fluid, wings)
    sides%distance = DISTANCE
    request%pressure = .true.
    request%flow = .true.
    call fluid%evaluate(request, failure, wings)
    ! The wing turns about its hinge; the flow does not know.
    turn = OMEGA*[1.0_rp, -2.0_rp, 0.5_rp]
    associate (surface => wings%surfaces(1))
      do p = 1, size(surface%points, 2)
        surface%velocities(:, p) = cross(turn, surface%points(:, p) - wings%poses(1)%hinge)
      end do
      call sides%sample(fluid, wings)
      errors = 0
      largest = 0
      do i = 1, size(surface%triangles, 2)
        associate (corners => surface%points(:, surface%triangles(:, i)))
          centre = sum(corners, 2)/3
          normal = cross(corners(:, 2) - corners(:, 1), corners(:, 3) - corners(:, 1))
        end associate
        normal = normal/norm2(normal)
        do side = 1, 2
          place = centre + merge(DISTANCE, -DISTANCE, side == 1)*normal
          wall = cross(turn, place - wings%poses(1)%hinge)
          shear = velocity(place) - wall
          shear = NU/DISTANCE*(shear - normal*dot_product(normal, shear))
          errors(1) = max(errors(1), abs(sides%wings(1)%pressure(i, side) - pressure(place)))
          errors(2) = max(errors(2), norm2(sides%wings(1)%traction(:, i, side) - shear))
          largest = max(largest, [abs(pressure(place)), norm2(shear)])
        end do
      end do
    end associate
    errors = errors/largest
    call kit%check('the pass succeeds',.not. failure%failed)
    call fluid%free()
  end subroutine look

  pure function velocity(x) result(u)
    real(rp), intent(in) :: x(3)
    real(rp) :: u(3)
    u = [sin(x(1))*cos(x(2))*cos(x(3)), -cos(x(1))*sin(x(2))*cos(x(3)), 0.0_rp]
  end function velocity

  !> Its mean is that of -|u|^2/2, as the mean total pressure is 0.
  pure real(rp) function pressure(x)
    real(rp), intent(in) :: x(3)
    pressure = -0.125_rp + (cos(2*x(1)) + cos(2*x(2)))*(cos(2*x(3)) + 2)/16
  end function pressure
end program test_wing_sides
