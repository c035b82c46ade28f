! SPDX-License-Identifier: GPL-3.0-or-later
!> Builds a fluid from ini text, as the program does, for tests that look at it from inside.
module support_fluid
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use fluid_params, only: fluid_params_t, read_fluid_params, register_fluid_keys
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use io_config, only: config_t
  use io_registry, only: registry_t
  use parallel_world, only: world_t
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  private
  public :: make_fluid, run_to_end, box_2d, box_3d, NL

  character(*), parameter :: NL = new_line('a')

contains

  !> [Resolution] and [Geometry] of a cube of n^3 points and side `length`.
  function box_3d(n, length) result(text)
    integer, intent(in) :: n
    real(rp), intent(in) :: length
    character(:), allocatable :: text
    character(200) :: buffer
    write (buffer, '(3(a,i0),a,3(a,es24.16))') '[Resolution]'//NL//'nx=', n, NL//'ny=', n, NL//'nz=', n, &
      NL//'[Geometry]', NL//'xl=', length, NL//'yl=', length, NL//'zl=', length
    text = trim(buffer)//NL
  end function box_3d

  !> The same for a square in the y-z plane.
  function box_2d(n, length) result(text)
    integer, intent(in) :: n
    real(rp), intent(in) :: length
    character(:), allocatable :: text
    character(200) :: buffer
    write (buffer, '(2(a,i0),a,2(a,es24.16))') '[Resolution]'//NL//'nx=1'//NL//'ny=', n, NL//'nz=', n, &
      NL//'[Geometry]', NL//'yl=', length, NL//'zl=', length
    text = trim(buffer)//NL
  end function box_2d

  !> A fluid with its initial condition, from ini text. Stops with the messages if the text is refused.
  subroutine make_fluid(world, text, fluid, trials)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: text
    type(fluid_t), intent(out) :: fluid
    logical, intent(in), optional :: trials !< whether the fluid can make trials
    type(registry_t) :: registry
    type(config_t) :: config
    type(message_list_t) :: errors, notices
    type(fluid_params_t) :: params
    type(failure_t) :: failure
    call register_fluid_keys(registry)
    call registry%set_lattice('Resolution', 'ny', 'Geometry', 'yl')
    call config%load_text(text, 'test', registry, errors, notices)
    if (errors%count() == 0) call read_fluid_params(config, params, errors)
    if (errors%count() > 0) then
      call errors%print(error_unit, '')
      error stop 'the test has a wrong ini text'
    end if
    call fluid%init(world, params, .true., failure, keeps_rhs=trials)
    if (.not. failure%failed) call fluid%start(failure)
    if (failure%failed) error stop 'the test fluid cannot start'
  end subroutine make_fluid

  !> Steps to the end time, then evaluates: integrals and fields of the final state are available.
  subroutine run_to_end(fluid)
    type(fluid_t), intent(inout) :: fluid
    type(request_t) :: nothing, all
    type(failure_t) :: failure
    do while (fluid%rhs%state%time < fluid%rhs%params%time%t_max)
      call fluid%step(nothing, failure)
      if (failure%failed) error stop 'the test flow has failed'
    end do
    all%integrals = .true.
    all%fields = .true.
    call fluid%evaluate(all, failure)
    if (failure%failed) error stop 'the test flow has failed'
  end subroutine run_to_end
end module support_fluid
