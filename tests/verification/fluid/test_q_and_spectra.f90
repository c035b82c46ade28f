! SPDX-License-Identifier: GPL-3.0-or-later
!> The Q criterion and the energy spectrum against those of known fields, on any number of ranks.
program test_q_and_spectra
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_q_criterion, only: q_criterion
  use fluid_requests, only: request_t
  use fluid_shells, only: count_shells, shell_energies, shell_width
  use fluid_solver, only: fluid_t
  use support_fluid, only: make_fluid, box_2d, box_3d, NL
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: AT_REST = '[MeanFlow]'//NL//'ux=0'//NL//'uy=0'//NL//'uz=0'//NL
  type(testkit_t) :: test

  call test%start(parallel=.true.)
  call known_gradient()
  call taylor_green()
  call given_spectrum()
  call plane_flow()
  call test%finish()

contains

  !> All nine derivatives differ from zero and from each other, and there is divergence. Round-off of the transforms is some
  !> 1e-15 of Q, which reaches 20; a margin of two digits.
  subroutine known_gradient()
    type(fluid_t) :: fluid
    real(rp), allocatable :: u(:, :, :, :), q(:, :, :)
    real(rp) :: r(3), a(3, 3), worst(2)
    integer :: x, y, z
    call make_fluid(test%world, '[Resolution]'//NL//'nx=24'//NL//'ny=16'//NL//'nz=20'//NL//'[Geometry]'//NL// &
                    'xl=3.0'//NL//'yl=2.0'//NL//'zl=2.5'//NL//'[InitialCondition]'//NL//'inicond=MeanFlow'//NL//AT_REST, &
                    fluid)
    associate (b => fluid%transform%block, grid => fluid%rhs%params%grid)
      allocate (u(b%count(1), b%count(2), b%count(3), 3), q(b%count(1), b%count(2), b%count(3)))
      do z = 1, b%count(3)
        do y = 1, b%count(2)
          do x = 1, b%count(1)
            r = TWO_PI*([x, y, z] - 1 + b%start)/grid%n
            u(x, y, z, :) = [sin(r(1))*cos(r(2)) + sin(2*r(2)) + cos(r(3)), &
                             0.3_rp*sin(2*r(1)) + 0.7_rp*cos(r(2))*sin(r(3)), &
                             cos(r(1))*sin(2*r(3)) + 0.2_rp*sin(r(2) + r(3)) + 0.4_rp]
          end do
        end do
      end do
      call fluid%transform%forward(u, fluid%rhs%state%u)
      q = huge(q)
      call q_criterion(fluid%transform, fluid%rhs%state%u, q)
      worst = 0
      do z = 1, b%count(3)
        do y = 1, b%count(2)
          do x = 1, b%count(1)
            r = TWO_PI*([x, y, z] - 1 + b%start)/grid%n
            a(1, :) = [cos(r(1))*cos(r(2)), -sin(r(1))*sin(r(2)) + 2*cos(2*r(2)), -sin(r(3))]
            a(2, :) = [0.6_rp*cos(2*r(1)), -0.7_rp*sin(r(2))*sin(r(3)), 0.7_rp*cos(r(2))*cos(r(3))]
            a(3, :) = [-sin(r(1))*sin(2*r(3)), 0.2_rp*cos(r(2) + r(3)), 2*cos(r(1))*cos(2*r(3)) + &
                                                                        0.2_rp*cos(r(2) + r(3))]
            a = a*spread(TWO_PI/grid%length, 1, 3)
            worst = max(worst, [abs(q(x, y, z) + sum(a*transpose(a))/2), abs(q(x, y, z))])
          end do
        end do
      end do
    end associate
    call test%world%max_reals(worst)
    call test%check('there is a Q', worst(2) > 10)
    call test%check_below('Q of a known gradient', worst(1), 1.0e-13_rp*worst(2))
    call fluid%free()
  end subroutine known_gradient

  !> All modes have |k| = sqrt(3): shell 2 of width 1 holds the energy 1/8, half of it in each of two components.
  subroutine taylor_green()
    type(fluid_t) :: fluid
    real(rp), allocatable :: energies(:, :)
    call make_fluid(test%world, box_3d(16, TWO_PI)//'[InitialCondition]'//NL//'inicond=taylor_green'//NL//AT_REST, fluid)
    call take_spectrum(fluid, energies)
    call test%check_close('Taylor-Green: dk', shell_width(fluid%rhs%params%grid), 1.0_rp, rtol=1.0e-15_rp)
    ! Modes lie inside 2/3 (16/2 - 1) = 4.67.
    call test%check('Taylor-Green: shells to the last retained mode', size(energies, 1) == 6)
    call test%check_close('Taylor-Green: energy of shell 2', sum(energies(2, :)), 0.125_rp, rtol=1.0e-14_rp)
    call test%check_close('Taylor-Green: of its x component', energies(2, 1), 0.0625_rp, rtol=1.0e-14_rp)
    energies(2, :) = 0
    call test%check_below('Taylor-Green: energy of the other shells', sum(energies), 1.0e-30_rp)
    call fluid%free()
  end subroutine taylor_green

  !> A random field whose shells were given their energies, in a box that is no cube; and the sum over all shells is the
  !> kinetic energy that the solver integrates in physical space.
  subroutine given_spectrum()
    type(fluid_t) :: fluid
    type(request_t) :: request
    type(failure_t) :: failure
    real(rp), allocatable :: energies(:, :), wanted(:)
    integer :: i
    call make_fluid(test%world, '[Resolution]'//NL//'nx=32'//NL//'ny=48'//NL//'nz=40'//NL//'[Geometry]'//NL// &
                    'xl=2.0'//NL//'yl=3.0'//NL//'zl=2.5'//NL//'[InitialCondition]'//NL//'inicond=turbulence_rogallo'// &
                    NL//'omega1=1.5'//NL//AT_REST//'[ReynoldsNumber]'//NL//'nu=1e-2'//NL//'[Time]'//NL// &
                    'dt_fixed=1e-3'//NL, fluid)
    call take_spectrum(fluid, energies)
    allocate (wanted(0:ubound(energies, 1)))
    wanted = [(i**4*exp(-0.5_rp*i**2), i=0, ubound(energies, 1))]
    wanted = wanted*(1.5_rp/sum(wanted))
    ! The field was made on all modes of the grid; beyond the shell 12 the truncation cuts some off.
    call test%check_below('random field: given energies of the shells', &
                          maxval(abs(sum(energies(0:12, :), 2) - wanted(0:12))), 1.0e-13_rp)
    ! The first step truncates; then all sums are over the same modes.
    call fluid%step(request, failure)
    call take_spectrum(fluid, energies)
    call fluid%evaluate(request, failure)
    call test%check_close('random field: the sum over shells is the kinetic energy', &
                          sum(energies)*product(fluid%rhs%params%grid%length), fluid%sums%kinetic_energy, &
                          rtol=1.0e-13_rp)
    call fluid%free()
  end subroutine given_spectrum

  !> In a plane: shell 1 (|k| = sqrt(2) is nearest to 1) has all of 1/4, and Q of the 2-D Taylor-Green vortex
  !> (sin y cos z, -cos y sin z) is -(cos^2 y cos^2 z - sin^2 y sin^2 z) = -cos(y + z) cos(y - z).
  subroutine plane_flow()
    type(fluid_t) :: fluid
    real(rp), allocatable :: energies(:, :), q(:, :, :)
    real(rp) :: y, z, worst(1)
    integer :: iy, iz
    call make_fluid(test%world, box_2d(16, TWO_PI)//'[InitialCondition]'//NL//'inicond=taylor_green_2d'//NL//AT_REST, &
                    fluid)
    call take_spectrum(fluid, energies)
    call test%check_close('plane flow: energy of shell 1', sum(energies(1, :)), 0.25_rp, rtol=1.0e-14_rp)
    associate (b => fluid%transform%block)
      allocate (q(b%count(1), b%count(2), b%count(3)))
      call q_criterion(fluid%transform, fluid%rhs%state%u, q)
      worst = 0
      do iz = 1, b%count(3)
        do iy = 1, b%count(2)
          y = TWO_PI*(iy - 1 + b%start(2))/16
          z = TWO_PI*(iz - 1 + b%start(3))/16
          worst = max(worst, abs(q(1, iy, iz) + cos(y + z)*cos(y - z)))
        end do
      end do
    end associate
    call test%world%max_reals(worst)
    call test%check_below('plane flow: Q', worst(1), 1.0e-13_rp)
    call fluid%free()
  end subroutine plane_flow

  subroutine take_spectrum(fluid, energies)
    type(fluid_t), intent(in) :: fluid
    real(rp), allocatable, intent(out) :: energies(:, :)
    integer :: n
    n = count_shells(test%world, fluid%rhs%params%grid, fluid%transform%sticks)
    allocate (energies(0:n - 1, 3), source=huge(1.0_rp))
    call shell_energies(test%world, fluid%rhs%params%grid, fluid%transform%sticks, fluid%rhs%state%u, energies)
  end subroutine take_spectrum
end program test_q_and_spectra
