! SPDX-License-Identifier: GPL-3.0-or-later
!> The channel with inflow (iChannel = turek) without its cylinder: Poiseuille's parabola in its middle, from a flow that
!> begins as a plug, and the start from rest.
!>
!> With masks a few cells wide the flow sees its walls elsewhere than where they are drawn, by wall_shift, of the order of
!> dx; at sqrt(nu C_eta) = 0.33909 h that is zero.
program test_inflow_channel
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use support_fluid, only: make_fluid, run_to_end, NL
  use support_walls, only: wall_shift
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  real(rp), parameter :: HEIGHT = 1, WALL = 0.25_rp, LENGTH = 2.5_rp, ZONE = 0.5_rp, SPEED = 0.8_rp, NU = 0.2_rp
  real(rp), parameter :: FROM = 0.7_rp, UPTO = 1.3_rp
  real(rp), parameter :: NO_SHIFT = 0.33909_rp
  integer, parameter :: POINTS(2) = [16, 24]
  real(rp) :: errors(2), cells(2), shift, seen, drawn
  integer :: i

  call test%start(parallel=.true.)
  cells = HEIGHT/POINTS
  do i = 1, 2
    call channel_error(POINTS(i), NO_SHIFT, 0.0_rp, seen, errors(i))
  end do
  ! A third of a cell is not resolved: the walls seem to be dx/20 off. At the wall a parabola changes by 4/H.
  call test%check_order('the flow converges to the parabola with dx', cells, errors, 1.0_rp, 0.3_rp)
  call test%check_below('which sees its walls within a sixteenth of a cell', maxval(errors/cells), 4.0_rp/16)
  ! Walls that seem to be 0.36 dx outside of the channel; of second order are (0.6 dx/H)^2 times 12 and more.
  shift = wall_shift(NU, (0.6_rp*cells(2))**2/NU, cells(2))
  call channel_error(POINTS(2), 0.6_rp, shift, seen, drawn)
  call test%check_below('a thicker layer moves the walls as it should', seen/drawn, 0.3_rp)
  call test_start()
  call test%finish()

contains

  !> Ini text of the channel with `n` points over its height and a layer sqrt(nu C_eta) of `layer` cells.
  function channel(n, layer, t_max, start, inicond) result(text)
    integer, intent(in) :: n
    real(rp), intent(in) :: layer, t_max, start
    character(*), intent(in) :: inicond
    character(:), allocatable :: text
    character(800) :: buffer
    write (buffer, '(2(a,i0),10(a,es24.16))') '[Resolution]'//NL//'nx=1'//NL//'ny=', nint(n*LENGTH), NL//'nz=', &
      nint(n*(HEIGHT + WALL)), NL//'[Geometry]'//NL//'yl=', LENGTH, NL//'zl=', HEIGHT + WALL, NL//'Size=', 0.0_rp, &
      NL//'[ReynoldsNumber]'//NL//'nu=', NU, NL//'[Time]'//NL//'CFL=0.9'//NL//'CFL_eta=0.5'//NL//'Tmax=', t_max, &
      NL//'[Penalization]'//NL//'iPenalization=1'//NL//'iChannel=turek'//NL//'pos_wall=0.1'//NL//'thick_wall=', WALL, &
      NL//'inflow_velocity=', SPEED, NL//'inflow_length=', ZONE, NL//'inflow_start=', start, NL//'eps=', &
      (layer*HEIGHT/n)**2/NU
    text = trim(buffer)//NL//'[InitialCondition]'//NL//'inicond='//inicond//NL
  end function channel

  !> Largest distance of the steady velocity, two cells and more from the walls, from the parabola that carries the flow
  !> U H, over its largest.
  subroutine channel_error(n, layer, shift, seen, drawn)
    integer, intent(in) :: n
    real(rp), intent(in) :: layer, shift
    real(rp), intent(out) :: seen  !< to that between walls that stand `shift` inside of those drawn, in the middle
    real(rp), intent(out) :: drawn !< to that between the walls drawn, everywhere outside of the inflow
    type(fluid_t) :: fluid
    real(rp) :: s, y, dx, u(2), largest(2)
    integer :: iy, iz
    ! The slowest of the even shapes without flow decays with 4 (4.4934/H)^2 nu = 16/T, the inflow reaches the middle
    ! within 1 T.
    call make_fluid(test%world, channel(n, layer, 0.5_rp, 0.0_rp, 'MeanFlow'), fluid)
    call run_to_end(fluid)
    dx = HEIGHT/n
    largest = 0
    associate (block => fluid%transform%block)
      do iz = 1, block%count(3)
        s = modulo((iz - 1 + block%start(3))*dx - 0.1_rp, HEIGHT + WALL)
        if (s < 2*dx .or. s > HEIGHT - 2*dx) cycle
        do iy = 1, block%count(2)
          y = (iy - 1 + block%start(2))*dx
          u = fluid%rhs%fields(1, iy, iz, 2:3)
          if (y > FROM .and. y < UPTO) largest(1) = max(largest(1), norm2(u - [parabola(s, shift), 0.0_rp]))
          if (y > 2*dx .and. y < LENGTH - ZONE - 2*dx) &
            largest(2) = max(largest(2), norm2(u - [parabola(s, 0.0_rp), 0.0_rp]))
        end do
      end do
    end associate
    call test%world%max_reals(largest)
    seen = largest(1)/(1.5_rp*SPEED)
    drawn = largest(2)/(1.5_rp*SPEED)
    call fluid%free()
  end subroutine channel_error

  !> Velocity at height s over the wall drawn, of the flow U H between walls that stand `shift` inside of those.
  pure real(rp) function parabola(s, shift)
    real(rp), intent(in) :: s, shift
    parabola = 6*SPEED*HEIGHT*(s - shift)*(HEIGHT - shift - s)/(HEIGHT - 2*shift)**3
  end function parabola

  !> The flow grows from rest as (1 - cos(pi t/T))/2.
  subroutine test_start()
    type(fluid_t) :: fluid
    type(request_t) :: nothing
    type(failure_t) :: failure
    real(rp) :: off, t
    call make_fluid(test%world, channel(16, NO_SHIFT, 0.7_rp, 0.5_rp, 'quiescent'), fluid)
    off = 0
    do while (fluid%rhs%state%time < fluid%rhs%params%time%t_max)
      call fluid%step(nothing, failure)
      t = min(0.5_rp, fluid%sums_time)
      associate (mean => fluid%sums%mean)
        off = max(off, abs(mean(2)*(HEIGHT + WALL)/HEIGHT - SPEED*sin(PI*t/(2*0.5_rp))**2), abs(mean(3)))
      end associate
      if (failure%failed) exit
    end do
    call test%check('the flow starts',.not. failure%failed)
    call test%check_below('and its mean follows the inflow, with nothing across the channel', off, 1.0e-13_rp)
    call fluid%free()
  end subroutine test_start
end program test_inflow_channel
