! SPDX-License-Identifier: GPL-3.0-or-later
!> Reading the flow at points in a pass of the fluid: the weights give every mode the filter of point forces to the stated
!> error, and what a pass reads is the sum over modes, on every number of ranks, also across the faces of the box.
!>
!> usage: test_point_reader [builtin|p3dfft]
program test_point_reader
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_point_kernel, only: point_kernel_t, KERNEL_DECAYS, KERNEL_STRENGTHS, KERNEL_TERMS, KERNEL_WIDTH
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use support_fluid, only: make_fluid, box_3d, box_2d, NL
  use test_pick, only: asked_transform
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  real(rp), parameter :: CUTOFF = 2*PI/3
  !> The errors that the header of fluid_point_reader states, below these parts of K.
  real(rp), parameter :: PARTS(3) = [0.1_rp, 0.5_rp, 1.0_rp], STATED(3) = [2.0e-5_rp, 1.0e-4_rp, 1.5e-3_rp]
  integer, parameter :: N_POINTS = 9
  character(:), allocatable :: flow

  call test%start(parallel=.true.)
  flow = '[InitialCondition]'//NL//'omega1=1'//NL//'inicond=turbulence_rogallo'//NL//'[MeanFlow]'//NL//'ux=0'//NL// &
         '[Time]'//NL//'dt_fixed=1e-3'//NL//'Tmax=1'//NL//'[Parallel]'//NL//'transform='//asked_transform()//NL
  call check_filter()
  call check_modes()
  call check_pass('3-D', box_3d(24, 2*PI)//flow, is_2d=.false.)
  call check_pass('3-D, two rows of ranks', box_3d(24, 2*PI)//flow, is_2d=.false., rows=2)
  call check_pass('2-D', box_2d(40, 2*PI)//flow, is_2d=.true.)
  call test%finish()

contains

  !> The two products are the filter to the stated error.
  subroutine check_filter()
    real(rp) :: s, error
    integer :: i
    error = 0
    do i = 0, 100
      s = i/100.0_rp
      error = max(error, abs(sum(KERNEL_STRENGTHS*exp(-KERNEL_DECAYS*s)) - sqrt(1 + s)))
    end do
    call test%check_below('two products are the filter', error, 2.4e-4_rp)
    call test%check_below('more so for long waves', abs(sum(KERNEL_STRENGTHS) - 1), 1.0e-5_rp)
  end subroutine check_filter

  !> A mode along an axis and one along a diagonal get the filter at all places in a cell.
  subroutine check_modes()
    type(point_kernel_t) :: kernel
    real(rp) :: theta, x, errors(3), along
    complex(rp) :: axis, diagonal, turn
    integer :: i, j, k
    call kernel%init(CUTOFF)
    errors = 0
    do i = 0, 40
      theta = CUTOFF*i/40
      along = theta/sqrt(3.0_rp)
      do j = 0, 10
        x = 3.0_rp + j/10.0_rp
        turn = exp(cmplx(0.0_rp, -theta*x, rp))
        axis = turn*sum(KERNEL_STRENGTHS*factor(kernel, theta, x)*real(factor(kernel, 0.0_rp, x))**2)
        turn = exp(cmplx(0.0_rp, -3*along*x, rp))
        diagonal = turn*sum(KERNEL_STRENGTHS*factor(kernel, along, x)**3)
        do k = 1, 3
          if (i <= 40*PARTS(k)) errors(k) = max(errors(k), abs(axis - sqrt(1 + (theta/CUTOFF)**2)), &
                                                abs(diagonal - sqrt(1 + (theta/CUTOFF)**2)))
        end do
      end do
    end do
    do k = 1, 3
      call test%check_below('modes get the filter', errors(k), STATED(k))
    end do
  end subroutine check_modes

  !> A pass reads what the exact sum over modes is, to the largest of the stated errors, and to round-off as often as it is asked.
  subroutine check_pass(name, text, is_2d, rows)
    character(*), intent(in) :: name, text
    logical, intent(in) :: is_2d
    integer, intent(in), optional :: rows
    type(fluid_t) :: fluid
    type(request_t) :: request
    type(failure_t) :: failure
    real(rp), dimension(3, N_POINTS) :: x, exact, again, summed
    integer :: i
    if (present(rows)) then
      if (mod(test%world%size, rows) /= 0) return
      call make_fluid(test%world, text//'[Resolution]'//NL//'process_rows=2'//NL, fluid)
    else
      call make_fluid(test%world, text, fluid)
    end if
    do i = 1, N_POINTS
      x(:, i) = [0.37_rp*i, 0.01_rp + 1.3_rp*i, -2.0_rp + 0.9_rp*i*i]
    end do
    if (is_2d) x(1, :) = 0
    call fluid%hold_points(N_POINTS)
    associate (reader => fluid%rhs%reader)
      call test%check(name//': the flow can be read', reader%is_possible)
      call reader%ask(x)
      call fluid%step(request, failure)
      call test%check(name//': the untruncated initial flow is not read', reader%is_wanted .and. .not. reader%is_read)
      call fluid%points%place(x)
      call fluid%velocities_at_points(exact)
      call fluid%evaluate(request, failure)
      call test%check(name//': a pass reads the flow', reader%is_read .and. .not. reader%is_wanted)
      call test%check_below(name//': velocities are the sums over modes', maxval(abs(reader%velocities - exact)), &
                            STATED(3)*maxval(abs(exact)))
      again = reader%velocities
      call sum_factors(fluid, x, summed)
      call test%check_below(name//': velocities are the modes with their factors, on any number of ranks', &
                            maxval(abs(again - summed)), 1.0e-12_rp*maxval(abs(exact)))
      call reader%ask(x)
      request%integrals = .true.
      call fluid%step(request, failure)
      call test%check_below(name//': a step reads the flow at its beginning, to the last bit', &
                            maxval(abs(reader%velocities - again)), 0.0_rp)
    end associate
    call fluid%free()
  end subroutine check_pass

  !> The sum over modes, each with the factor that the weights give it at the point.
  subroutine sum_factors(fluid, x, values)
    type(fluid_t), intent(in) :: fluid
    real(rp), intent(in) :: x(:, :)
    real(rp), intent(out) :: values(3, N_POINTS)
    type(point_kernel_t) :: kernel
    complex(rp) :: factors(KERNEL_TERMS)
    integer :: i, s, j
    values = 0
    associate (t => fluid%transform%sticks, g => fluid%transform%grid, u => fluid%rhs%state%u)
      call kernel%init(fluid%points%radius*g%max_spacing())
      do i = 1, N_POINTS
        do s = 1, t%n
          do j = 1, t%nkz
            factors = KERNEL_STRENGTHS*factor(kernel, t%ky(s)*g%spacing(2), x(2, i)/g%spacing(2))* &
                      factor(kernel, t%kz(j)*g%spacing(3), x(3, i)/g%spacing(3))
            if (.not. g%is_2d) factors = factors*factor(kernel, t%kx(s)*g%spacing(1), x(1, i)/g%spacing(1))
            values(:, i) = values(:, i) + t%weight(s)*real(u(j, s, :)*sum(factors))
          end do
        end do
        call test%world%sum_reals(values(:, i))
      end do
    end associate
  end subroutine sum_factors

  !> What the weights around x [cells] make of a mode of `theta` radians per cell.
  function factor(kernel, theta, x)
    type(point_kernel_t), intent(in) :: kernel
    real(rp), intent(in) :: theta, x
    complex(rp) :: factor(KERNEL_TERMS)
    real(rp) :: w(KERNEL_WIDTH, KERNEL_TERMS)
    integer :: first, m
    call kernel%weights(x, first, w)
    factor = matmul([(exp(cmplx(0.0_rp, theta*(first + m - 1), rp)), m=1, KERNEL_WIDTH)], w)
  end function factor
end program test_point_reader
