! SPDX-License-Identifier: GPL-3.0-or-later
!> Conservation: the momentum that the fluid loses in a step is the penalization force that the solid
!> reports, and the projection leaves no divergence.
!>
!> The mean of u x omega vanishes for a solenoidal, dealiased field, so that the mean velocity obeys
!> U(n+1) = U(n) - (b10 F(n) + b11 F(n-1))/V exactly.
program test_force_balance
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use support_fluid, only: make_fluid, NL
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  type(fluid_t) :: fluid
  type(request_t) :: request
  type(failure_t) :: failure
  real(rp) :: f_old(3), dt_old, b10, b11, mean(3), worst, divergence, volume, expected_loss(3)
  integer :: step

  call test%start(parallel=.true.)
  call make_fluid(test%world, '[Resolution]'//NL//'nx=24'//NL//'ny=20'//NL//'nz=30'//NL// &
                  '[Geometry]'//NL//'xl=2.5'//NL// &
                  'yl=2.0'//NL//'zl=3.0'//NL//'Size=0.8'//NL//'[InitialCondition]'//NL//'inicond=MeanFlow'//NL// &
               '[ReynoldsNumber]'//NL//'nu=0.02'//NL//'[Time]'//NL//'Tmax=10.0'//NL//'CFL=0.2'//NL//'[MeanFlow]'//NL// &
              'ux=1.0'//NL//'uy=0.3'//NL//'uz=-0.2'//NL//'[Penalization]'//NL//'iPenalization=1'//NL//'iMask=sphere'// &
                  NL//'eps=0.02'//NL, fluid)
  request%integrals = .true.
  volume = 2.5_rp*2.0_rp*3.0_rp
  worst = 0
  divergence = 0
  expected_loss = 0
  do step = 1, 40
    dt_old = fluid%rhs%state%dt_old
    f_old = sum(fluid%sums%force, 2)
    mean = fluid%sums%mean
    call fluid%step(request, failure)
    divergence = max(divergence, fluid%sums%divergence)
    if (step > 1) then
      ! sums belong to the beginning of this step: compare with the step before.
      worst = max(worst, maxval(abs(fluid%sums%mean - mean + expected_loss)))
    end if
    b10 = fluid%dt
    b11 = 0
    if (step > 1) then
      b10 = fluid%dt/dt_old*(fluid%dt/2 + dt_old)
      b11 = -fluid%dt**2/(2*dt_old)
    end if
    expected_loss = (b10*sum(fluid%sums%force, 2) + b11*f_old)/volume
  end do
  call test%check('the flow stays healthy',.not. failure%failed)
  call test%check_below('momentum change equals the penalization force', worst, 1e-15_rp)
  call test%check_below('the velocity stays solenoidal', divergence, 1e-12_rp)
  call test%check('the sphere is dragged along', fluid%sums%force(1, 1) > 0 .and. fluid%sums%force(2, 1) > 0 .and. &
                  fluid%sums%force(3, 1) < 0)
  call fluid%free()
  call test%finish()
end program test_force_balance
