! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the measurement of a noise-free replicate: what the model itself, on the same mesh, would show under the point
!> loads of ini/static.ini. For validations of fits only; no noise and no error of the model is in it. Every shape is solved
!> to 1e-11 of the load, or as far as rounding allows, which is told.
!>
!>     write_replicate WING.h5 MEASUREMENT.h5 N_LOADS SIGMA NX NY [NAME VALUE ...]
!>
!> Loads are spread over the list; SIGMA [m] is what is declared as the error of the heights; the pairs are
!> parameters of the wing, or `force` and a factor on all forces.
program write_replicate
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_errors, only: failure_t, message_list_t, require
  use base_kinds, only: rp
  use base_text, only: number_text, parse_integer, parse_real
  use measurement_data, only: measurement_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use whole_measurement, only: write_measurement
  use solid_params, only: default_params, solid_params_t
  use solid_usual_causes, only: PARAM_YOUNG
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  implicit none
  integer, parameter :: MOST = 10
  real(rp), parameter :: REST = 1.0e-4_rp !< [m] height of the unloaded wing
  real(rp), parameter :: TOLERANCES(3) = [1.0e-11_rp, 1.0e-10_rp, 1.0e-9_rp] !< of the load, the first that is reached
  !> x [m], y [m], force [N], in the order in which they are taken.
  real(rp), parameter :: LOADS(3, MOST) = reshape( &
                         [0.00721_rp, -0.00032_rp, 5.5e-4_rp, 0.00405_rp, 0.00066_rp, 1.2e-2_rp, &
                          0.00496_rp, -0.00228_rp, 2.7e-4_rp, 0.00856_rp, -0.00078_rp, 4.1e-4_rp, &
                          0.00315_rp, -0.00078_rp, 3.4e-2_rp, 0.00676_rp, -0.00150_rp, 6.7e-4_rp, &
                          0.00541_rp, 0.00005_rp, 6.3e-3_rp, 0.00270_rp, -0.00159_rp, 1.9e-2_rp, &
                          0.00496_rp, -0.00111_rp, 1.1e-3_rp, 0.00225_rp, 0.00059_rp, 4.7e-2_rp], [3, MOST])
  type(wing_t) :: wing
  type(solid_params_t) :: params
  type(static_options_t) :: options
  type(measurement_t) :: m
  type(experiment_t) :: experiment
  type(evaluation_work_t) :: work
  type(failure_t) :: failure
  type(message_list_t) :: messages
  integer :: i, n, nx, ny, l
  real(rp) :: factor

  call read_wing(argument(1), wing, messages)
  call messages%print(error_unit, 'write_replicate: ')
  if (messages%count() > 0) error stop 2
  params = default_params(wing)
  factor = 1
  do i = 7, command_argument_count() - 1, 2
    if (argument(i) == 'force') then
      factor = real_argument(i + 1)
      cycle
    end if
    n = params%find(argument(i))
    call require(n > 0, 'write_replicate: a parameter of the wing, not '//argument(i))
    call params%set(n, real_argument(i + 1))
  end do
  n = integer_argument(3)
  nx = integer_argument(5)
  ny = integer_argument(6)
  call lay_out()
  call experiment%init(m, wing, params, [PARAM_YOUNG], options, failure)
  call require(.not. failure%failed, 'write_replicate: a model')
  call work%init(experiment)
  do l = 1, n
    call measure(l)
  end do
  call write_measurement(argument(2), m, failure)
  call require(.not. failure%failed, 'write_replicate: a file that can be written')

contains

  !> A flat measurement on a grid over the wing.
  subroutine lay_out()
    integer :: i, j
    allocate (m%x(nx), m%y(ny), m%unloaded(nx, ny), m%unloaded_sigma(nx, ny), m%has_unloaded(nx, ny), m%loads(n), &
              m%observations(0), m%zeros(0))
    m%x = [(minval(wing%points(1, :)) + (i - 0.37_rp)*1.02_rp*span(1)/nx, i=1, nx)]
    m%y = [(minval(wing%points(2, :)) + (j - 0.41_rp)*1.02_rp*span(2)/ny, j=1, ny)]
    m%unloaded = REST
    m%unloaded_sigma = real_argument(4)/sqrt(2.0_rp)
    m%has_unloaded = .true.
    m%accuracy%height = real_argument(4)/sqrt(2.0_rp)
    do l = 1, n
      associate (load => m%loads(l))
        load%name = 'load_'//achar(iachar('a') + l - 1)
        load%force = factor*LOADS(3, l)
        load%direction = [0.0_rp, 0.0_rp, 1.0_rp]
        load%point = LOADS(:2, l)
        load%node = reshape([((i, j, i=1, nx), j=1, ny)], [2, nx*ny])
        allocate (load%height(nx*ny), source=0.0_rp)
        allocate (load%sigma(nx*ny), source=m%accuracy%height)
      end associate
    end do
  end subroutine lay_out

  !> Puts what the wing shows under load l in place of the flat heights.
  subroutine measure(l)
    integer, intent(in) :: l
    type(evaluation_t) :: evaluation
    real(rp), allocatable :: u(:, :)
    integer :: k, t
    allocate (u(3, experiment%model%n_all))
    do t = 1, size(TOLERANCES)
      experiment%options%tolerance = TOLERANCES(t)
      call evaluation%init(experiment, l, .false.)
      u = 0
      call evaluate(experiment, work, experiment%start(), l, .false., u, evaluation)
      if (evaluation%is_feasible()) exit
    end do
    call require(evaluation%is_feasible(), 'write_replicate: an equilibrium under load '//number_text(l))
    if (t > 1) write (output_unit, '(a,es8.1,a)') m%loads(l)%name//' is solved to', TOLERANCES(t), ' of the load'
    associate (comparison => experiment%comparisons(l))
      do k = 1, comparison%n_heights
        m%loads(l)%height(comparison%node(1, k) + nx*(comparison%node(2, k) - 1)) = evaluation%residuals(k)
      end do
    end associate
  end subroutine measure

  pure real(rp) function span(direction)
    integer, intent(in) :: direction
    span = maxval(wing%points(direction, :)) - minval(wing%points(direction, :))
  end function span

  function argument(i) result(text)
    integer, intent(in) :: i
    character(:), allocatable :: text
    integer :: length
    call get_command_argument(i, length=length)
    allocate (character(length) :: text)
    call get_command_argument(i, text)
  end function argument

  real(rp) function real_argument(i)
    integer, intent(in) :: i
    character(:), allocatable :: problem
    call parse_real(argument(i), real_argument, problem)
    call require(.not. allocated(problem), 'write_replicate: a number, not '//argument(i))
  end function real_argument

  integer function integer_argument(i)
    integer, intent(in) :: i
    character(:), allocatable :: problem
    call parse_integer(argument(i), integer_argument, problem)
    call require(.not. allocated(problem), 'write_replicate: an integer, not '//argument(i))
  end function integer_argument
end program write_replicate
