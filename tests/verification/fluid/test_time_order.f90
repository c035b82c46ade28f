! SPDX-License-Identifier: GPL-3.0-or-later
!> Order in time from three-level ratios: the error of a step size is the distance to the run with half
!> that step; AB2 must show 2 (with its Euler start, whose one step of local error O(dt^2) does not spoil
!> the order) and RK4 must show 4, with solids present for AB2. The next term of the error lowers the
!> slope by O(dt); at these steps it is below 0.08, and the neighbouring order is 1 away.
program test_time_order
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use support_fluid, only: make_fluid, run_to_end, box_3d, NL
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test

  call test%start(parallel=.true.)
  call order_of('AB2', 1.0_rp/80, 2, '')
  call order_of('AB2', 1.0_rp/400, 2, '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=sphere'//NL//'eps=0.05'//NL)
  call order_of('RK4', 1.0_rp/8, 4, '')
  call test%finish()

contains

  subroutine order_of(scheme, dt, order, solids)
    character(*), intent(in) :: scheme, solids
    real(rp), intent(in) :: dt
    integer, intent(in) :: order
    complex(rp), allocatable :: coarse(:, :, :)
    real(rp) :: h(0:3), errors(0:3), distance(1)
    type(fluid_t) :: fluid
    character(24) :: number
    integer :: level
    do level = 0, 3
      write (number, '(es24.16)') dt/2**level
call make_fluid(test%world, box_3d(16, TWO_PI)//'Size=2.0'//NL//'[InitialCondition]'//NL//'inicond=taylor_green'//NL// &
                      '[ReynoldsNumber]'//NL//'nu=0.02'//NL//'[Time]'//NL//'Tmax=1.0'//NL//'dt_fixed='//number//NL// &
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
end program test_time_order
