! SPDX-License-Identifier: GPL-3.0-or-later
!> Penalized walls against the no-slip solutions of Poiseuille and Couette flow. The penalized flow slips
!> over a layer delta = sqrt(nu C_eta), so that its error falls with the known half order in C_eta
!> (Carbou & Fabrie 2003) as long as the grid resolves the layer.
program test_penalized_walls
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use support_fluid, only: make_fluid, run_to_end, box_2d, NL
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  real(rp), parameter :: LAYERS(3) = [0.03_rp, 0.02_rp, 0.0133_rp]
  real(rp) :: errors(3), eta(3), profile(3)
  integer :: i

  call test%start(parallel=.true.)
  eta = LAYERS**2 ! viscosity 1
  do i = 1, 3
    call channel_error(eta(i), 0.9_rp, errors(i), profile(i))
  end do
  ! The channel flow settles in a time of 1/80 (k^2 with tan(k/2) = k/2), the flow between cylinders in 1/27. dt is less
  ! than C_eta, the limit of stability of extrapolated penalization, at which alternating errors would last longer.
  ! The leading term of the error is the slip delta |u'|; the next one, delta^2, lowers the slope by 0.05.
  call test%check_order('channel flow converges with half order in C_eta', eta, errors, 0.5_rp, 0.06_rp)

  ! At dt near C_eta the integrating factor shifts the steady layer by O((nu k^2 dt)^2), k = 1/delta: 8 % of
  ! the slip. With dt = C_eta/5 that is 25 times less, and the grid's error remains: the
  ! sharp mask ends between two points, and a sixth of a cell moves the slip by 4 dy/6 = 2.6e-3.
  call channel_error(eta(1), 0.2_rp, errors(1), profile(1))
  call test%check_below('the channel profile is that of the penalized equation', profile(1), 2.6e-3_rp)

  ! The layers are 10 to 4 % of the gap: the next term, layer over gap, lowers the slope by up to 0.1.
  eta = (2*LAYERS)**2
  do i = 1, 3
    errors(i) = couette_error(eta(i))
  end do
  call test%check_order('Couette flow converges with half order in C_eta', eta, errors, 0.5_rp, 0.12_rp)
  call test%finish()

contains

  !> Channel flow with prescribed flux. `slip_error` is the largest distance in the gap to Poiseuille's
  !> parabola, relative to its maximum; `profile_error` that to the exact solution of the penalized
  !> equation nu u'' = chi u/C_eta - g with the same flux, which leaves the grid's error only: the sharp
  !> mask is resolved to half a cell, 1/512 of the box, in a layer of a few cells.
  subroutine channel_error(c_eta, cfl_eta, slip_error, profile_error)
    real(rp), intent(in) :: c_eta, cfl_eta
    real(rp), intent(out) :: slip_error, profile_error
    integer, parameter :: N = 512, N_WALL = 256
    real(rp), parameter :: L = 2, DY = L/N, WALL = N_WALL*DY, GAP = L - WALL
    type(fluid_t) :: fluid
    character(400) :: text
    real(rp) :: s, parabola, penalized, largest, delta, g, slip
    integer :: iy
    write (text, '(a,f6.3,3(a,es24.16))') 'CFL_eta=', cfl_eta, NL//'[Penalization]'//NL//'iPenalization=1'//NL// &
      'iChannel=xz'//NL//'thick_wall=', WALL, NL//'pos_wall=', WALL - DY/2, NL//'eps=', c_eta
    ! nz = 4 keeps only modes that do not depend on z.
    call make_fluid(test%world, '[Resolution]'//NL//'nx=1'//NL//'ny=512'//NL//'nz=4'//NL//'[Geometry]'//NL// &
                    'yl=2.0'//NL//'zl=1.0'//NL//'[InitialCondition]'//NL//'inicond=MeanFlow'//NL// &
                    '[ReynoldsNumber]'//NL//'nu=1.0'//NL//'[MeanFlow]'//NL// &
                    'ux=0'//NL//'uy=0'//NL//'uz=1'//NL//'iMeanFlow_z=fixed'//NL//'[Time]'//NL//'Tmax=0.2'// &
                    NL//'CFL=0.9'//NL//trim(text)//NL, fluid)
    call run_to_end(fluid)
    ! In the wall u = (slip - g eta) exp(-s/delta) + g eta, and the stress is continuous:
    ! slip = g GAP delta/2 + g eta. The flux L fixes g.
    delta = sqrt(c_eta)
    g = L/(GAP**3/12 + (GAP*delta/2 + c_eta)*GAP + GAP*delta**2 + c_eta*WALL)
    slip = g*(GAP*delta/2 + c_eta)
    slip_error = 0
    profile_error = 0
    largest = 1.5_rp*L/GAP
    do iy = 1, N
      s = (iy - 1)*DY - (WALL - DY/2)
      if (s < 0 .or. s > GAP) cycle
      parabola = 6*L/GAP*(s/GAP)*(1 - s/GAP)
      penalized = slip + g/2*s*(GAP - s)
      slip_error = max(slip_error, abs(fluid%rhs%fields(1, iy, 1, 3) - parabola)/largest)
      profile_error = max(profile_error, abs(fluid%rhs%fields(1, iy, 1, 3) - penalized)/largest)
    end do
    call fluid%free()
  end subroutine channel_error

  !> Largest error of the velocity between two cylinders, relative to that of the inner one, which turns.
  real(rp) function couette_error(c_eta) result(error)
    real(rp), intent(in) :: c_eta
    integer, parameter :: N = 240
    real(rp), parameter :: L = 2.4_rp, R1 = 0.4_rp, R2 = 1, OMEGA = 1.25_rp
    type(fluid_t) :: fluid
    character(100) :: text
    real(rp) :: y, z, r, want(2), a, b
    integer :: iy, iz
    write (text, '(a,es24.16)') 'eps=', c_eta
 call make_fluid(test%world, box_2d(N, L)//'r1=0.4'//NL//'r2=1.0'//NL//'[InitialCondition]'//NL//'inicond=quiescent'// &
                    NL//'[ReynoldsNumber]'//NL//'nu=1.0'//NL//'[Time]'//NL//'Tmax=0.3'//NL//'CFL=0.5'//NL// &
                    '[MeanFlow]'//NL//'ux=0'//NL//'[Penalization]'//NL//'iPenalization=1'//NL//'iMask=couette'//NL// &
                    'omega=1.25'//NL//trim(text)//NL, fluid)
    call run_to_end(fluid)
    a = -OMEGA*R1**2/(R2**2 - R1**2)
    b = OMEGA*R1**2*R2**2/(R2**2 - R1**2)
    error = 0
    do iz = 1, N
      do iy = 1, N
        y = (iy - 1)*L/N - L/2
        z = (iz - 1)*L/N - L/2
        r = hypot(y, z)
        if (r < R1 .or. r > R2) cycle
        want = (a + b/r**2)*[-z, y]
        error = max(error, norm2(fluid%rhs%fields(1, iy, iz, 2:3) - want)/(OMEGA*R1))
      end do
    end do
    call fluid%free()
  end function couette_error
end program test_penalized_walls
