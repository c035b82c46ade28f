! SPDX-License-Identifier: GPL-3.0-or-later
!> Loads of flapping wings in their frames: which way is up, left and right as mirror images, torque and power.
!>
!> P is the work of the penalization force on u_s, and u_s in a sheet is the velocity of the closest point of its
!> middle surface. For a wing that turns about a hinge at rest the torque multiplies the same force with the velocity
!> of the point itself, so that exactly
!>
!>     P = -M . omega + int f . (omega x d)
!>
!> with f the force on the wing and d the way from the closest point, |d| <= t/2 + h. The unsteady parts belong to
!> the middle surface and have no such term: they fulfil P = -M . omega to round-off.
program test_wing_loads
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_wing_loads, only: wing_loads, wing_loads_t
  use support_wings, only: direct_loads, make_wings, NL, run_wings, wings_text, write_lines
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: kit
  real(rp), parameter :: LOW(2) = [0.05_rp, -0.2_rp], HIGH(2) = [0.75_rp, 0.1_rp]

  call kit%start(parallel=.true.)
  call write_lines(kit%world, 'wing.ini', '[Wing]'//NL//'type=rectangular'//NL//'root=0.05'//NL//'length=0.75'//NL// &
                   'mean_chord=0.3'//NL//'front=0.33333333333333333')
  call write_lines(kit%world, 'beat.ini', '[kinematics]'//NL//'type=fourier'//NL//'units=degree'//NL// &
                   'nfft_phi=1'//NL//'a0_phi=20.0'//NL//'ai_phi=55.0'//NL//'bi_phi=8.0'//NL// &
                   'nfft_alpha=2'//NL//'a0_alpha=-10.0'//NL//'ai_alpha=0.0 4.0'//NL//'bi_alpha=45.0 -6.0'//NL// &
                   'nfft_theta=1'//NL//'a0_theta=6.0'//NL//'ai_theta=3.0'//NL//'bi_theta=-9.0')
  call test_upward()
  call test_flapping('level', '0.0 0.0 0.0', '-90.0', 'ux=0.3'//NL//'uz=0.2')
  call test_flapping('pitched', '0.0 -25.0 0.0', '-60.0', 'ux=0.3'//NL//'uz=0.2')
  call test_turned()
  call kit%finish()

contains

  !> A uniform flow from below pushes wings at rest upward, in every frame.
  subroutine test_upward()
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(wing_loads_t) :: loads
    integer :: i
    call make_wings(kit%world, wings_text()//'eta0=-45'//NL//'[Time]'//NL//'Tmax=0.2'//NL//'[MeanFlow]'//NL// &
                    'iMeanFlow=1'//NL//'ux=0'//NL//'uy=0'//NL//'uz=1'//NL, fluid, wings)
    call run_wings(fluid, wings)
    do i = 1, 2
      loads = wing_loads(wings, i, fluid)
      associate (wing => wings%params%wings(i), pose => wings%poses(i))
        call kit%check('the '//trim(wing%side)//' wing is level', abs(abs(pose%matrix(3, 3)) - 1) < 1.0e-12_rp)
        call kit%check('a flow from below pushes it upward', loads%force(3) > 10*norm2(loads%force(1:2)))
        call kit%check_close('which in its frame is the dorsal side', &
                            dot_product([0.0_rp, 0.0_rp, wing%mount%dorsal_sign()], pose%vector_to_wing(loads%force)), &
                             loads%force(3), rtol=1.0e-12_rp)
        call kit%check('and lifts the tip: the left one rolls the insect to its right', &
                       merge(1, -1, wing%side == 'left')*loads%torque(1) > 0)
        call kit%check('wings at rest have no unsteady part and no power', &
                       norm2([loads%unsteady_force, loads%unsteady_torque, loads%power, loads%inertial_power]) <= 0)
      end associate
    end do
    call fluid%free()
  end subroutine test_upward

  !> Both wings follow the same angles in a flow without side wind: mirror images.
  subroutine test_flapping(name, attitude, eta, wind)
    character(*), intent(in) :: name, attitude, eta, wind
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(wing_loads_t) :: loads(2), direct
    real(rp) :: slip_work, slip_limit, scale, omega(3)
    integer :: i
    call make_wings(kit%world, wings_text()//'eta0='//eta//NL//'yawpitchroll_0='//attitude//NL// &
                    'Jxx=0.003'//NL//'Jyy=0.001'//NL//'Jzz=0.004'//NL//'Jxy=0.0005'//NL// &
                    'FlappingMotion_left=from_file::beat.ini'//NL//'FlappingMotion_right=from_file::beat.ini'//NL// &
                    '[Time]'//NL//'Tmax=0.15'//NL//'[MeanFlow]'//NL//'iMeanFlow=1'//NL//wind//NL//'uy=0'//NL, fluid, &
                    wings)
    call run_wings(fluid, wings)
    do i = 1, 2
      loads(i) = wing_loads(wings, i, fluid)
    end do
    call kit%check(name//': something pushes', all([(norm2(loads(i)%force) > 0.01_rp, i=1, 2)]) .and. &
                   abs(loads(1)%force(2)) > 1.0e-3_rp)
    call mirrored('force', loads(1)%force, loads(2)%force, [1, -1, 1])
    call mirrored('unsteady force', loads(1)%unsteady_force, loads(2)%unsteady_force, [1, -1, 1])
    call mirrored('torque', loads(1)%torque, loads(2)%torque, [-1, 1, -1])
    call mirrored('unsteady torque', loads(1)%unsteady_torque, loads(2)%unsteady_torque, [-1, 1, -1])
    call mirrored('force in the wing frame', wings%poses(1)%vector_to_wing(loads(1)%force), &
                  wings%poses(2)%vector_to_wing(loads(2)%force), [1, 1, -1])
    call mirrored('power', [loads(1)%power, loads(1)%unsteady_power, loads(1)%inertial_power], &
                  [loads(2)%power, loads(2)%unsteady_power, loads(2)%inertial_power], [1, 1, 1])
    do i = 1, 2
      call direct_loads(kit%world, fluid, wings, i, LOW, HIGH, direct, slip_work, slip_limit)
      associate (l => loads(i), pose => wings%poses(i))
        omega = pose%vector_to_space(pose%omega)
        scale = abs(direct%power) + norm2(direct%torque)*norm2(omega)
        call kit%check_below(name//': force by points', norm2(l%force - l%unsteady_force - direct%force), &
                             1.0e-12_rp*norm2(direct%force))
        call kit%check_below(name//': torque about the hinge by points', &
                             norm2(l%torque - l%unsteady_torque - direct%torque), 1.0e-12_rp*norm2(direct%torque))
       call kit%check_below(name//': power by points', abs(l%power - l%unsteady_power - direct%power), 1.0e-12_rp*scale)
        call kit%check_below(name//': P = -M . omega + int f . (omega x d)', &
                             abs(l%power + dot_product(l%torque, omega) - slip_work), 1.0e-12_rp*scale)
        call kit%check_below(name//': unsteady parts have P = -M . omega', &
                             abs(l%unsteady_power + dot_product(l%unsteady_torque, omega)), &
                             1.0e-13_rp*(abs(l%unsteady_power) + norm2(l%unsteady_torque)*norm2(omega)))
        call kit%check('the difference is within |omega| int |f| |d|', abs(slip_work) <= slip_limit)
        ! Front and back of the sheet have opposite d; what is left is friction and the edges: 4 % here.
        call kit%check_below('and small', abs(slip_work)/scale, 0.05_rp)
        call kit%check_close(name//': inertial power of the tensor', l%inertial_power, &
                         dot_product(pose%omega, matmul(wings%params%wings(i)%inertia, pose%omega_rate)), rtol=1e-13_rp)
      end associate
    end do
    call fluid%free()
  end subroutine test_flapping

  subroutine mirrored(what, left, right, signs)
    character(*), intent(in) :: what
    real(rp), intent(in) :: left(3), right(3)
    integer, intent(in) :: signs(3)
    call kit%check_below('mirror images: '//what, norm2(left - signs*right), 1.0e-11_rp*norm2(left))
  end subroutine mirrored

  !> The insect turned by 90 degrees about the vertical in a flow turned with it: the same loads in the wings'
  !> frames, though the grid lines run another way through the wings.
  subroutine test_turned()
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(wing_loads_t) :: loads(2, 2)
    real(rp) :: frames(3, 2, 2)
    integer :: i, k
    character(*), parameter :: YAW(2) = ['0.0 ', '90.0'], WIND(2) = ['ux=0.3'//NL//'uy=0.0', 'ux=0.0'//NL//'uy=0.3']
    do k = 1, 2
      call make_wings(kit%world, wings_text()//'eta0=-75'//NL//'yawpitchroll_0='//YAW(k)//' 10.0 0.0'//NL// &
                      'FlappingMotion_left=from_file::beat.ini'//NL//'FlappingMotion_right=from_file::beat.ini'//NL// &
                    '[Time]'//NL//'Tmax=0.1'//NL//'dt_fixed=0.005'//NL//'[MeanFlow]'//NL//'iMeanFlow=1'//NL//WIND(k)// &
                      NL//'uz=0'//NL, fluid, wings)
      call run_wings(fluid, wings)
      do i = 1, 2
        loads(i, k) = wing_loads(wings, i, fluid)
        frames(:, i, k) = wings%poses(i)%vector_to_wing(loads(i, k)%force)
      end do
      call fluid%free()
    end do
   call kit%check_below('an insect that looks along y has the loads of one that looks along x, in its wings'' frames', &
                         maxval(abs(frames(:, :, 2) - frames(:, :, 1))), 1.0e-11_rp*maxval(abs(frames)))
    call kit%check_below('in space turned by 90 degrees', maxval(abs([loads(:, 2)%force(2) - loads(:, 1)%force(1), &
                                                                      loads(:, 2)%force(1) + loads(:, 1)%force(2)])), &
                         1.0e-11_rp*maxval(abs(frames)))
  end subroutine test_turned
end program test_wing_loads
