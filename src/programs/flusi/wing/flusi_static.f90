! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs `flusi --static INI`: it computes the shape of a wing under given loads, each from the unloaded state (see
!> solid_statics). It runs as one process and does not need MPI.
module flusi_static
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_outcome, only: outcome_t, OUTCOME_MISTAKE, OUTCOME_NOT_CONVERGED, OUTCOME_UNWRITABLE
  use common_wing_doubts, only: print_notices
  use common_wing_report, only: print_wing
  use flusi_command, only: command_t, ACTION_STATIC_CHECK
  use flusi_static_output, only: remove_shape, static_row_t, static_table_t, write_shape
  use flusi_static_settings, only: load_static_settings, static_settings_t
  use flusi_wing_modes, only: find_modes, save_modes
  use solid_bent_wing, only: bent_wing_t
  implicit none
  private
  public :: run_static

contains

  !> Reads the input and then checks it or computes, as `command` asks. Prints mistakes and reasons of failures; `outcome` tells
  !> how it ended.
  subroutine run_static(command, outcome)
    type(command_t), intent(in) :: command
    type(outcome_t), intent(inout) :: outcome
    type(static_settings_t) :: settings
    type(message_list_t) :: errors, notices
    integer :: n_failed

    call load_static_settings(command%ini, command%flusi_compat, settings, errors, notices)
    if (errors%count() > 0) then
      call errors%print(error_unit, '')
      call outcome%end_as(OUTCOME_MISTAKE)
      return
    end if
    call print_notices(notices, command%action == ACTION_STATIC_CHECK)
    if (command%action == ACTION_STATIC_CHECK) then
      call settings%config%print_effective(output_unit)
      return
    end if
    call print_wing(output_unit, 'end of the loading path from the flat wing', settings%wing_case)
    if (settings%n_modes > 0) call solve_modes(settings, outcome)
    n_failed = 0
    if (.not. outcome%failure%failed .and. size(settings%loads) > 0) call solve_all(settings, n_failed, outcome%failure)
    if (n_failed > 0) call outcome%end_as(OUTCOME_NOT_CONVERGED)
    if (.not. outcome%failure%failed) return
    write (error_unit, '(a)') outcome%failure%reason
    call outcome%classify(OUTCOME_UNWRITABLE)
  end subroutine run_static

  !> Prints and saves the natural modes of the unloaded wing. If there are none, the program still computes the loads.
  subroutine solve_modes(settings, outcome)
    type(static_settings_t), intent(in) :: settings
    type(outcome_t), intent(inout) :: outcome
    type(failure_t) :: numerical
    real(rp), allocatable :: frequencies(:), shapes(:, :, :)
    allocate (frequencies(settings%n_modes), shapes(3, settings%wing_case%model%n_all, settings%n_modes))
    call find_modes(settings%wing_case, frequencies, shapes, numerical)
    if (numerical%failed) then
      write (output_unit, '(a)') 'modes     failed: '//numerical%reason
      call outcome%end_as(OUTCOME_NOT_CONVERGED)
    else
      call save_modes(settings%wing_case, settings%name, settings%save_shapes, frequencies, shapes, outcome%failure)
    end if
  end subroutine solve_modes

  !> Solves and saves one load after another. `n_failed` counts the loads without a solution; `failure` means that files cannot
  !> be written.
  subroutine solve_all(settings, n_failed, failure)
    type(static_settings_t), intent(in) :: settings
    integer, intent(out) :: n_failed
    type(failure_t), intent(inout) :: failure
    type(static_table_t) :: table
    type(static_row_t) :: row
    type(bent_wing_t) :: work
    real(rp), allocatable :: u(:, :)
    integer :: i

    n_failed = 0
    call table%start(settings%name, failure)
    if (failure%failed) return
    allocate (u(3, settings%wing_case%model%n_all), source=0.0_rp)
    call work%init(settings%wing_case%model)
    call print_head(output_unit)
    do i = 1, size(settings%loads)
      call solve_one(settings, i, work, u, row)
      call print_row(output_unit, settings, i, row)
      if (.not. row%report%converged) n_failed = n_failed + 1
      if (settings%save_shapes) then
        if (row%report%converged) then
          call write_shape(settings, i, u, row, failure)
        else
          call remove_shape(settings, i)
        end if
      end if
      call table%add(settings, i, row, failure)
      if (failure%failed) exit
    end do
    call work%free()
    if (failure%failed) return
    write (output_unit, '(i0,a,i0,a)') size(settings%loads) - n_failed, ' of ', size(settings%loads), &
      ' loads converged; '//settings%name//'_loads.t lists them'
    if (settings%save_shapes .and. n_failed < size(settings%loads)) write (output_unit, '(a)') &
      'deformed wings in '//settings%name//'_NN.xmf, NN the number of the load, for ParaView'
  end subroutine solve_all

  !> Computes the equilibrium u(3, n_all) [m] under load i, and its row of the report.
  subroutine solve_one(settings, i, work, u, row)
    type(static_settings_t), intent(in) :: settings
    integer, intent(in) :: i
    type(bent_wing_t), intent(inout) :: work
    real(rp), intent(inout) :: u(:, :)
    type(static_row_t), intent(out) :: row
    real(rp) :: t0, t1
    integer :: n
    associate (model => settings%wing_case%model, l => settings%loads(i))
      call cpu_time(t0)
      call work%solve(l%load%force, .false., settings%options, u, row%report)
      u = work%moved
      call cpu_time(t1)
      row%seconds = t1 - t0
      if (.not. row%report%converged) return ! u is the shape under a part of the load only
      n = model%n_points
      row%at_load = sum(l%applied*u)/l%magnitude
      row%tip = u(:, settings%wing_case%tip)
      row%largest = sqrt(maxval(sum(u(:, :n)**2, 1)))
    end associate
  end subroutine solve_one

  !> Prints the column titles of the table of loads.
  subroutine print_head(unit)
    integer, intent(in) :: unit
    write (unit, '(a)') 'load    x [mm]    y [mm]   force [N]  converged  residual  factors  snaps  at load [mm]'// &
      '   tip z [mm]  CPU [ms]'
  end subroutine print_head

  !> Prints the result of load `i`, or why it has none.
  subroutine print_row(unit, settings, i, row)
    integer, intent(in) :: unit
    type(static_settings_t), intent(in) :: settings
    integer, intent(in) :: i
    type(static_row_t), intent(in) :: row
    real(rp), parameter :: MM = 1.0e3_rp
    associate (l => settings%loads(i), r => row%report)
      write (unit, '(i4,2f10.4,es12.3,a11)', advance='no') i, MM*l%site, &
        merge(l%force(3), l%magnitude, abs(l%force(3)) >= 0.999_rp*l%magnitude), merge('yes', 'NO ', r%converged)
      if (r%converged) then
        write (unit, '(es10.1,i9,i7,f14.5,f13.5,f10.1)') r%residual, r%factorisations, r%snaps, MM*row%at_load, &
          MM*row%tip(3), 1000*row%seconds
        if (r%was_repeated) write (unit, '(a)') '     found with finer settings, because the usual path did not reach the full load'
        if (row%largest > 2*settings%wing_case%model%size) write (unit, '(a,g0.4,a)') '     a point moves by ', MM*row%largest, &
          ' mm, more than twice the length of the wing, which is therefore stretched: is the force in newtons?'
      else
        write (unit, '(a10,i9,i7,a14,a13,f10.1)') '-', r%factorisations, r%snaps, '-', '-', 1000*row%seconds
        write (unit, '(a)') '     failed: '//r%reason
      end if
    end associate
    flush (unit)
  end subroutine print_row
end module flusi_static
