! SPDX-License-Identifier: GPL-3.0-or-later
!> A fluid with flapping wings from ini text, as the program builds it, and the loads point by point.
module support_wings
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_rotation, only: cross
  use fsi_wing_loads, only: wing_loads_t
  use parallel_world, only: world_t
  use simulation_settings, only: load_settings, settings_t
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  private
  public :: make_wings, run_wings, wings_text, write_lines, direct_loads, NL

  character(*), parameter :: NL = new_line('a')

contains

  !> Root writes a small file for all ranks.
  subroutine write_lines(world, name, lines)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: name, lines
    integer :: unit
    if (world%is_root) then
      open (newunit=unit, file=name, status='replace')
      write (unit, '(a)') lines
      close (unit)
    end if
    call world%barrier()
  end subroutine write_lines

  !> What the tests with two small wings share: a rectangle of 0.7 x 0.3 on 4 dx at 1/16 in a box of 2.5 x 2.5 x 1.5.
  function wings_text(surface) result(text)
    character(*), intent(in), optional :: surface !< penalized if not given
    character(:), allocatable :: text, seen
    seen = 'penalized'
    if (present(surface)) seen = surface
    text = '[Resolution]'//NL//'nx=40'//NL//'ny=40'//NL//'nz=24'//NL// &
           '[Geometry]'//NL//'xl=2.5'//NL//'yl=2.5'//NL//'zl=1.5'//NL// &
           '[ReynoldsNumber]'//NL//'nu=0.02'//NL//'[InitialCondition]'//NL//'inicond=MeanFlow'//NL// &
           '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=Insect'//NL//'eps=0.01'//NL// &
           '[Insects]'//NL//'surface='//seen//NL//'WingShape=from_file::wing.ini'//NL//'wing_edge=0.0625'//NL// &
           'x0=1.25 1.25 0.75'//NL// &
           'x_pivot_l=0.0 0.3 0.0'//NL//'x_pivot_r=0.0 -0.3 0.0'//NL
  end function wings_text

  !> Fluid at its start and wings that are placed at time 0. Stops with the messages if the text is refused.
  !> Collective.
  subroutine make_wings(world, text, fluid, wings)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: text
    type(fluid_t), intent(out) :: fluid
    type(flapping_wings_t), intent(out) :: wings
    type(settings_t) :: settings
    type(message_list_t) :: errors, notices
    type(failure_t) :: failure
    call load_settings(text, 'test.ini', .false., settings, errors, notices, world)
    if (errors%count() > 0) then
      call errors%print(error_unit, '')
      error stop 'the test has a wrong ini text'
    end if
    call fluid%init(world, settings%fluid, .true., failure)
    if (.not. failure%failed) call fluid%start(failure)
    call wings%init(settings%flight, settings%fluid%grid, fluid%transform%block)
    if (.not. failure%failed) call wings%place(0.0_rp, fluid%rhs%penalty, failure)
    if (failure%failed) error stop 'the test fluid cannot start'
  end subroutine make_wings

  !> Steps to the end time, then evaluates with integrals and fields. Collective.
  subroutine run_wings(fluid, wings)
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(inout) :: wings
    type(request_t) :: nothing, all
    type(failure_t) :: failure
    do while (fluid%rhs%state%time < fluid%rhs%params%time%t_max)
      call fluid%step(nothing, failure, wings)
      if (failure%failed) error stop 'the test flow has failed'
    end do
    all%integrals = .true.
    all%fields = .true.
    call fluid%evaluate(all, failure, wings)
    if (failure%failed) error stop 'the test flow has failed'
  end subroutine run_wings

  !> Force, torque about the hinge and power of the penalization on wing i, summed point by point from the fields
  !> of the last evaluation. `slip_work` is int f . (omega x d), f the force on the wing and d the way from the
  !> closest point of the rectangle [low, high] of the wing's plane to the point: what -torque . omega has more than
  !> the power, because u_s in a sheet is that of the closest point. `slip_limit` is |omega| int |f| |d|. Collective.
  subroutine direct_loads(world, fluid, wings, i, low, high, loads, slip_work, slip_limit)
    type(world_t), intent(in) :: world
    type(fluid_t), intent(in) :: fluid
    type(flapping_wings_t), intent(in) :: wings
    integer, intent(in) :: i
    real(rp), intent(in) :: low(2), high(2)
    type(wing_loads_t), intent(out) :: loads
    real(rp), intent(out) :: slip_work, slip_limit
    real(rp) :: sums(9), f(3), x(3), q(3), d(3), omega(3), u(3)
    integer :: y, z, line, p
    sums = 0
    associate (block => fluid%rhs%block, penalty => fluid%rhs%penalty, pose => wings%poses(i), &
               grid => fluid%rhs%params%grid)
      omega = pose%vector_to_space(pose%omega)
      do z = 1, block%count(3)
        do y = 1, block%count(2)
          line = y + block%count(2)*(z - 1)
          do p = penalty%line_first(line), penalty%line_last(line)
            if (penalty%color(p) /= wings%surfaces(i)%color) cycle
            x = [penalty%x(p) - 1, y - 1 + block%start(2), z - 1 + block%start(3)]*grid%spacing
            u = fluid%rhs%fields(penalty%x(p), y, z, 1:3)
            f = penalty%chi(p)/fluid%rhs%params%solids%c_eta*(u - penalty%us(:, p))*grid%cell_volume()
            q = pose%vector_to_wing(x - pose%hinge)
            d = pose%vector_to_space(q - [min(max(q(1:2), low), high), 0.0_rp])
            sums(1:3) = sums(1:3) + f
            sums(4:6) = sums(4:6) + cross(x - pose%hinge, f)
            sums(7) = sums(7) - dot_product(penalty%us(:, p), f)
            sums(8) = sums(8) + dot_product(f, cross(omega, d))
            sums(9) = sums(9) + norm2(omega)*norm2(f)*norm2(d)
          end do
        end do
      end do
    end associate
    call world%sum_reals(sums)
    loads%force = sums(1:3)
    loads%torque = sums(4:6)
    loads%power = sums(7)
    slip_work = sums(8)
    slip_limit = sums(9)
  end subroutine direct_loads
end module support_wings
