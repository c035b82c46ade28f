! SPDX-License-Identifier: GPL-3.0-or-later
!> Forces at points of the flow and velocities there: the fast sums are the sums over modes that they stand for, one is
!> the adjoint of the other, the mean flow takes up the total force, and the response is the Green tensor.
!>
!> usage: test_point_forces [builtin|p3dfft]
program test_point_forces
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_green, only: green_t
  use support_fluid, only: make_fluid, box_3d, box_2d, NL
  use test_pick, only: asked_transform
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  character(:), allocatable :: random
  character(*), parameter :: RANDOM_FLOW = '[InitialCondition]'//NL//'omega1=1'//NL//'inicond=turbulence_rogallo'//NL// &
                             '[MeanFlow]'//NL//'ux=0'//NL//'[Time]'//NL//'dt_fixed=1e-3'//NL//'Tmax=1'//NL
  !> Barnett et al. give errors of about 1e-6 for this width and oversampling, of the largest value.
  real(rp), parameter :: WINDOW_ERROR = 4.0e-6_rp
  integer, parameter :: N_POINTS = 7
  !> The sphere of modes ends in z: some sticks inside the truncation have none of its modes.
  character(*), parameter :: COARSER = '[Resolution]'//NL//'nx=24'//NL//'ny=24'//NL//'nz=16'//NL//'[Geometry]'//NL// &
                             'xl=6.0'//NL//'yl=6.0'//NL//'zl=6.0'//NL

  call test%start(parallel=.true.)
  random = RANDOM_FLOW//'[Parallel]'//NL//'transform='//asked_transform()//NL
  call check('3-D', box_3d(24, TWO_PI)//random, is_2d=.false.)
  call check('3-D, two rows of ranks', box_3d(24, TWO_PI)//random, is_2d=.false., rows=2)
  call check('3-D, a coarser direction', COARSER//random, is_2d=.false.)
  call check('2-D', box_2d(40, TWO_PI)//random, is_2d=.true.)
  call check_green('3-D', box_3d(64, TWO_PI)//random, is_2d=.false.)
  call check_green('2-D', box_2d(128, TWO_PI)//random, is_2d=.true.)
  call test%finish()

contains

  subroutine check(name, text, is_2d, rows)
    character(*), intent(in) :: name, text
    logical, intent(in) :: is_2d
    integer, intent(in), optional :: rows
    type(fluid_t) :: fluid
    real(rp) :: x(3, N_POINTS), velocities(3, N_POINTS), direct(3, N_POINTS), forces(3, N_POINTS), mean(3), volume, &
                products(2)
    complex(rp), allocatable :: flow(:, :, :)
    integer :: c
    if (present(rows)) then
      if (mod(test%world%size, rows) /= 0) return
      call make_fluid(test%world, text//'[Resolution]'//NL//'process_rows=2'//NL, fluid)
    else
      call make_fluid(test%world, text, fluid)
    end if
    call place(is_2d, x, forces)
    volume = fluid%transform%grid%volume()
    call fluid%hold_points(N_POINTS)
    call fluid%points%place(x)
    call fluid%velocities_at_points(velocities)
    call sum_directly(fluid, x, direct)
    call test%check_below(name//': velocities are the sums over modes', maxval(abs(velocities - direct)), &
                          WINDOW_ERROR*maxval(abs(direct)))
    allocate (flow, source=fluid%rhs%state%u)
    fluid%rhs%state%u = 0
    fluid%dt = 1
    call fluid%push_at_points(forces)
    products(1) = sum([(sum(fluid%transform%sticks%weight*sum(real(conjg(flow(:, :, c))*fluid%rhs%state%u(:, :, c)), 1)), &
                       c=1, 3)])
    call test%world%sum_reals(products(1:1))
    products(2) = sum(forces*velocities)/volume
    call test%check_close(name//': pushing is the adjoint of looking', products(1), products(2), &
                          atol=1e-12_rp*sum(abs(forces*velocities))/volume)
    mean = 0
    if (fluid%transform%sticks%zero > 0) mean = real(fluid%rhs%state%u(1, fluid%transform%sticks%zero, :))
    call test%world%sum_reals(mean)
    call test%check_below(name//': the mean flow takes up the total force', &
                          maxval(abs(mean*volume - sum(forces, 2))), 1e-13_rp*maxval(abs(sum(forces, 2))))
    call check_divergence(name, fluid)
    call fluid%free()
  end subroutine check

  !> The flow is free of divergence in every mode, up to rounding.
  subroutine check_divergence(name, fluid)
    character(*), intent(in) :: name
    type(fluid_t), intent(in) :: fluid
    real(rp) :: largest(2)
    integer :: s
    largest = 0
    associate (t => fluid%transform%sticks, u => fluid%rhs%state%u)
      do s = 1, t%n
        largest(1) = max(largest(1), maxval(abs(t%kx(s)*u(:, s, 1) + t%ky(s)*u(:, s, 2) + t%kz*u(:, s, 3))))
        largest(2) = max(largest(2), maxval(abs(u(:, s, :)))*fluid%points%radius)
      end do
    end associate
    call test%world%max_reals(largest)
    call test%check_below(name//': the forces leave no divergence', largest(1), 1e-14_rp*largest(2))
  end subroutine check_divergence

  !> Points inside, across the faces and outside the box, and forces.
  subroutine place(is_2d, x, forces)
    logical, intent(in) :: is_2d
    real(rp), intent(out) :: x(3, N_POINTS), forces(3, N_POINTS)
    integer :: i
    do i = 1, N_POINTS
      x(:, i) = [0.37_rp*i, 0.01_rp + 1.3_rp*i, -2.0_rp + 0.9_rp*i*i]
      forces(:, i) = [sin(1.0_rp*i), cos(2.0_rp*i), 1.0_rp + 0.2_rp*i]
    end do
    if (is_2d) x(1, :) = 0
    if (is_2d) forces(1, :) = 0
  end subroutine place

  !> sum Phi(k) u_k exp(i k.X), mode by mode.
  subroutine sum_directly(fluid, x, values)
    type(fluid_t), intent(in) :: fluid
    real(rp), intent(in) :: x(:, :)
    real(rp), intent(out) :: values(3, N_POINTS)
    complex(rp), parameter :: IMAGINARY = (0.0_rp, 1.0_rp)
    real(rp) :: k(3), kappa
    integer :: s, j, i
    values = 0
    associate (t => fluid%transform%sticks, u => fluid%rhs%state%u)
      do s = 1, t%n
        do j = 1, t%nkz
          k = [t%kx(s), t%ky(s), t%kz(j)]
          kappa = sum(k**2)/fluid%points%radius**2
          if (kappa >= 1) cycle
          do i = 1, N_POINTS
            values(:, i) = values(:, i) + t%weight(s)*sqrt(1 + kappa)*real(u(j, s, :)* &
                                                                                 exp(IMAGINARY*dot_product(k, x(:, i))))
          end do
        end do
      end do
    end associate
    do i = 1, N_POINTS
      call test%world%sum_reals(values(:, i))
    end do
  end subroutine sum_directly

  !> The response to one force at its own and at other places. In a periodic box the integral over the sphere of modes is
  !> a sum over lattice points, whose number differs from the volume by the order of R^(2/3) in the plane and less, relative
  !> to the volume, in space (Gauss's circle problem), R the radius in modes.
  subroutine check_green(name, text, is_2d)
    character(*), intent(in) :: name, text
    logical, intent(in) :: is_2d
    type(fluid_t) :: fluid
    type(green_t) :: green
    real(rp) :: x(3, 4), forces(3, 4), velocities(3, 4), error, own(3, 3), h
    integer :: c, i
    call make_fluid(test%world, text, fluid)
    h = fluid%transform%grid%min_spacing()
    call fluid%hold_points(4)
    call green%init(fluid%points%radius, 40*h, is_2d)
    own = green%at([0.0_rp, 0.0_rp, 0.0_rp])
    x(:, 1) = [1.0_rp, 2.03_rp, 3.01_rp]
    x(:, 2) = x(:, 1) + h*[1.1_rp, 1.3_rp, 0.9_rp]
    x(:, 3) = x(:, 1) + h*[2.0_rp, -3.0_rp, 3.7_rp]
    x(:, 4) = x(:, 1) + h*[0.5_rp, 8.0_rp, 0.4_rp]
    if (is_2d) x(1, :) = 0
    call fluid%points%place(x)
    error = 0
    do c = merge(2, 1, is_2d), 3
      forces = 0
      forces(c, 1) = 1
      fluid%rhs%state%u = 0
      fluid%dt = 1
      call fluid%push_at_points(forces)
      call fluid%velocities_at_points(velocities)
      do i = 1, 4
        associate (want => matmul(green%at(x(:, i) - x(:, 1)), forces(:, 1)))
          error = max(error, maxval(abs(velocities(:, i) - want)))
        end associate
      end do
    end do
    call test%check_below(name//': the response is the Green tensor', error, &
                          own(3, 3)*(fluid%points%radius*minval(fluid%transform%grid%length(2:))/TWO_PI)**(-4/3.0_rp))
    call fluid%free()
  end subroutine check_green
end program test_point_forces
