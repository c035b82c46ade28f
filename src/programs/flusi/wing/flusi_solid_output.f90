! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the files of `flusi --solid`: the time series <name>.t, and at every save the wing in <name>_NNNNN.h5, with one index
!> <name>.xmf over all times (see flusi_wing_output). Positions and velocities have components along the axes of the wing file.
module flusi_solid_output
  use base_errors, only: failure_t
  use base_files, only: name_of
  use base_kinds, only: rp
  use flusi_solid_settings, only: solid_settings_t
  use flusi_wing_output, only: put_wing, put_wing_vectors, shape_grid, wing_lines_t
  use io_attributes, only: put_attribute
  use io_hdf5, only: hdf5_file_t
  use io_series, only: series_t
  use io_xdmf_series, only: xdmf_series_t
  use parallel_world, only: world_t
  use solid_balance, only: work_t
  use solid_dynamics, only: dynamic_state_t, step_report_t
  use solid_inertia, only: measure_motion, momenta_t
  use solid_motion, only: frame_t
  implicit none
  private
  public :: solid_output_t

  character(*), parameter :: COLUMNS(22) = [character(18) :: 'time [s]', 'tip_x [m]', 'tip_y [m]', 'tip_z [m]', &
                          'largest [m]', 'E_kin [J]', 'E_kin_rel [J]', 'E_elastic [J]', 'W_loads [J]', 'W_weight [J]', &
                          'W_frame [J]', 'Q_damping [J]', 'imbalance [J]', 'newton [-]', 'substeps [-]', 'residual [-]', &
                          'P_x [kg m/s]', 'P_y [kg m/s]', 'P_z [kg m/s]', &
                          'L_x [kg m^2/s]', 'L_y [kg m^2/s]', 'L_z [kg m^2/s]']
  character(*), parameter :: VECTORS(1) = ['velocity']
  integer, parameter :: DIGITS = 10
  real(rp), parameter :: PART = 1.0e-6_rp !< fraction of a step: times closer than this are equal

  !> Writes the series and the shapes of a run.
  type :: solid_output_t
    private
    type(series_t) :: series
    type(xdmf_series_t) :: index
    type(wing_lines_t) :: lines
    real(rp), allocatable :: u(:, :), v(:, :) !< (3, n_points)
    integer :: number = 0                     !< of the next shape
    real(rp) :: saved = -huge(1.0_rp)         !< [s] time of the last shape
    real(rp), public :: largest = 0           !< [m] largest displacement in the last record
  contains
    procedure :: open => output_open
    procedure :: is_due => output_is_due
    procedure :: record => output_record
    procedure :: save => output_save
    procedure :: close => output_close
  end type solid_output_t

contains

  !> Opens the series and the index. After a restart from `state` it keeps what they hold up to the time of that state.
  !> Collective.
  subroutine output_open(self, world, settings, state, is_restart, failure)
    class(solid_output_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(solid_settings_t), intent(in) :: settings
    type(dynamic_state_t), intent(in) :: state
    logical, intent(in) :: is_restart
    type(failure_t), intent(inout) :: failure
    call self%lines%init(settings%wing_case%wing)
    allocate (self%u(3, settings%wing_case%model%n_points), self%v(3, settings%wing_case%model%n_points))
    self%number = 0
    if (is_restart) then
      self%number = shape_number(settings, state%time) + 1
      ! The record at this time is kept too, because it has numbers of the last step.
      call self%series%open(world, settings%name//'.t', COLUMNS, failure, digits=DIGITS, &
                            restart_time=state%time + 0.5_rp*state%old_step)
      call self%index%open(settings%name//'.xmf', failure, restart_time=state%time)
    else
      call self%series%open(world, settings%name//'.t', COLUMNS, failure, digits=DIGITS)
      call self%index%open(settings%name//'.xmf', failure)
    end if
  end subroutine output_open

  !> Returns the number of the last multiple of t_save up to `time` [s].
  pure integer function shape_number(settings, time) result(number)
    type(solid_settings_t), intent(in) :: settings
    real(rp), intent(in) :: time
    number = int((time + PART*settings%dt)/settings%output%fields%interval)
  end function shape_number

  !> Tells whether a shape must be saved at `time` [s].
  pure logical function output_is_due(self, settings, time) result(is_due)
    class(solid_output_t), intent(in) :: self
    type(solid_settings_t), intent(in) :: settings
    real(rp), intent(in) :: time
    is_due = shape_number(settings, time) >= self%number
  end function output_is_due

  !> Writes one record of the time series. `close` reports a failure.
  subroutine output_record(self, settings, frame, state, work, report)
    class(solid_output_t), intent(inout) :: self
    type(solid_settings_t), intent(in) :: settings
    type(frame_t), intent(in) :: frame
    type(dynamic_state_t), intent(in) :: state
    type(work_t), intent(in) :: work
    type(step_report_t), intent(in) :: report
    type(momenta_t) :: m
    integer :: i
    associate (wing_case => settings%wing_case)
      m = measure_motion(settings%inertia, wing_case%model, frame, state%u, state%v)
      self%largest = 0
      do i = 1, wing_case%model%n_points
        self%largest = max(self%largest, norm2(state%u(:, i)))
      end do
      call self%series%write([state%time, state%u(:, wing_case%tip), self%largest, m%kinetic, m%relative_kinetic, &
                              m%elastic, work%loads, work%weight, work%frame, work%damped, &
                              work%imbalance(m%relative_kinetic + m%elastic), &
                              real([report%iterations, report%substeps], rp), report%residual, m%linear, m%angular])
    end associate
  end subroutine output_record

  !> Saves the shape of `state`, unless it is already saved.
  subroutine output_save(self, settings, frame, state, failure)
    class(solid_output_t), intent(inout) :: self
    type(solid_settings_t), intent(in) :: settings
    type(frame_t), intent(in) :: frame
    type(dynamic_state_t), intent(in) :: state
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    character(:), allocatable :: path
    character(12) :: label
    if (failure%failed .or. .not. state%time > self%saved) return
    self%saved = state%time
    write (label, '(i0.5)') self%number
    path = settings%name//'_'//trim(label)//'.h5'
    associate (wing_case => settings%wing_case, n => settings%wing_case%model%n_points)
      self%u = state%u(:, :n)
      self%v = state%v(:, :n)
      call file%create_serial(path//'.part', failure)
      call put_wing(file, self%lines, wing_case%wing, self%u, failure)
      call put_wing_vectors(file, self%lines, VECTORS(1), 'm/s', self%v, .true., failure)
      call put_attribute(file, '/', 'schema', 'flusi-msm shape', failure)
      call put_attribute(file, '/', 'wing', wing_case%path, failure)
      call put_attribute(file, '/', 'time', state%time, failure)
      call put_attribute(file, '/', 'frame_omega', frame%omega, failure)
      call put_attribute(file, '/', 'frame_acceleration', frame%acceleration, failure)
      call file%publish(path, .false., failure)
    end associate
    call self%index%add(state%time, trim(label), shape_grid(self%lines, name_of(path), 'wing', VECTORS, VECTORS, &
                                                            state%time), failure)
    self%number = max(self%number, shape_number(settings, state%time)) + 1
  end subroutine output_save

  !> Closes the series. Fails if it could not be written completely. Collective.
  subroutine output_close(self, failure)
    class(solid_output_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    call self%series%close(failure)
  end subroutine output_close
end module flusi_solid_output
