! SPDX-License-Identifier: GPL-3.0-or-later
!> Order in time from three-level ratios: the error of a step size is the distance to the run with half
!> that step; AB2 must show 2 (with its Euler start, whose one step of local error O(dt^2) does not spoil
!> the order) and RK4 must show 4, with solids present for AB2. The next term of the error lowers the
!> slope by O(dt); at these steps it is below 0.08, and the neighbouring order is 1 away. And the order of all schemes by
!> an exact solution: a Taylor-Green vortex that a wind carries away, u = U + u0(x - U t) exp(-2 nu t).
program test_time_order
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use support_fluid, only: make_fluid, run_to_end, box_3d, NL
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test

  call test%start(parallel=.true.)
  call order_of('AB2', 1.0_rp, 1.0_rp/80, 2, '')
  call order_of('AB2', 0.25_rp, 1.0_rp/400, 2, '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=sphere'//NL//'eps=0.05'//NL)
  call order_of('RK4', 1.0_rp, 1.0_rp/8, 4, '')
  call order_of('RK2', 0.25_rp, 1.0_rp/400, 2, '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=sphere'//NL//'eps=0.05'//NL)
  call exact_order('AB2', 1.0_rp/20, 2)
  call exact_order('RK2', 1.0_rp/20, 2)
  call exact_order('RK4', 1.0_rp/10, 4)
  call exact_order('Euler', 1.0_rp/80, 1)
  call test%finish()

contains

  subroutine order_of(scheme, end_time, dt, order, solids)
    character(*), intent(in) :: scheme, solids
    real(rp), intent(in) :: end_time, dt
    integer, intent(in) :: order
    complex(rp), allocatable :: coarse(:, :, :)
    real(rp) :: h(0:3), errors(0:3), distance(1)
    type(fluid_t) :: fluid
    character(24) :: number, last
    integer :: level
    write (last, '(es24.16)') end_time
    do level = 0, 3
      write (number, '(es24.16)') dt/2**level
      call make_fluid(test%world, box_3d(16, TWO_PI)//'Size=2.0'//NL//'[InitialCondition]'//NL//'inicond=taylor_green'//NL// &
                      '[ReynoldsNumber]'//NL//'nu=0.02'//NL//'[Time]'//NL//'Tmax='//last//NL//'dt_fixed='//number//NL// &
                      'iTimeMethodFluid='//scheme//NL//'[MeanFlow]'//NL//'ux=0'//NL//solids, fluid)
      call run_to_end(fluid)
      if (level > 0) then
        h(level) = dt/2**(level - 1)
        distance(1) = maxval(abs(fluid%rhs%state%u - coarse))
        call test%world%max_reals(distance)
        errors(level) = distance(1)
      end if
      coarse = fluid%rhs%state%u
      call fluid%free()
    end do
    call test%check_order(scheme//merge(' with a solid', '             ', solids /= '')//' has its order in dt', &
                          h(1:), errors(1:), real(order, rp), 0.1_rp)
  end subroutine order_of

  !> The next term of the error lowers or raises the slope by about dt, which is 0.05 at most on the finer steps.
  subroutine exact_order(scheme, dt, order)
    character(*), intent(in) :: scheme
    real(rp), intent(in) :: dt
    integer, intent(in) :: order
    real(rp), parameter :: NU = 0.05_rp
    character(*), parameter :: BOX = '[Resolution]'//NL//'nx=1'//NL//'ny=22'//NL//'nz=34'//NL ! primes 11 and 17
    real(rp) :: h(0:2), errors(0:2), distance(1), y, z, decay
    type(fluid_t) :: fluid
    character(24) :: number
    integer :: level, iy, iz
    decay = exp(-2*NU)
    do level = 0, 2
      h(level) = dt/2**level
      write (number, '(es24.16)') h(level)
      call make_fluid(test%world, BOX//'[InitialCondition]'//NL//'inicond=taylor_green_2d'//NL// &
                      '[ReynoldsNumber]'//NL//'nu=0.05'//NL//'[Time]'//NL//'Tmax=1.0'//NL//'dt_fixed='//number//NL// &
                      'iTimeMethodFluid='//scheme//NL//'[MeanFlow]'//NL//'iMeanFlow_y=fixed'//NL//'uy=1'//NL, fluid)
      deallocate (fluid%rhs%initial) ! the wind blows from the beginning
      if (fluid%rhs%sticks%zero > 0) fluid%rhs%state%u(1, fluid%rhs%sticks%zero, 2) = 1
      call run_to_end(fluid)
      distance = 0
      do iz = 1, fluid%transform%block%count(3)
        do iy = 1, fluid%transform%block%count(2)
          y = (iy - 1 + fluid%transform%block%start(2))*fluid%rhs%params%grid%spacing(2) - 1
          z = (iz - 1 + fluid%transform%block%start(3))*fluid%rhs%params%grid%spacing(3)
          distance(1) = max(distance(1), abs(fluid%rhs%fields(1, iy, iz, 2) - 1 - sin(y)*cos(z)*decay), &
                            abs(fluid%rhs%fields(1, iy, iz, 3) + cos(y)*sin(z)*decay))
        end do
      end do
      call test%world%max_reals(distance)
      errors(level) = distance(1)
      call fluid%free()
    end do
    call test%check_order(scheme//' has its order against an exact solution', h, errors, real(order, rp), 0.1_rp)
  end subroutine exact_order
end program test_time_order
