! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the files of `flusi --static`: for each load the deformed wing in HDF5, with the forces of the load, and an XDMF index
!> (see flusi_wing_output); and a table of all loads. Every file gets its name when it is complete.
module flusi_static_output
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use base_errors, only: failure_t
  use base_files, only: name_of, remove_file
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use flusi_static_settings, only: static_settings_t
  use flusi_wing_output, only: put_wing, put_wing_vectors, shape_grid, wing_lines_t
  use io_attributes, only: put_attribute
  use io_hdf5, only: hdf5_file_t
  use io_xdmf_series, only: xdmf_text
  use solid_statics, only: static_report_t
  implicit none
  private
  public :: static_table_t, static_row_t, write_shape, remove_shape

  character(*), parameter :: NL = new_line('a')
  character(*), parameter :: COLUMNS(19) = [character(14) :: 'load [-]', 'x [m]', 'y [m]', 'fx [N]', 'fy [N]', &
      'fz [N]', 'converged [-]', 'residual [-]', 'factors [-]', 'snaps [-]', 'stages [-]', 'rcond [-]', 'at_load [m]', &
                                               'tip_x [m]', 'tip_y [m]', 'tip_z [m]', 'largest [m]', 'R [m]', 'CPU [s]']

  !> Holds the result for one load. The shape is defined only if the solution converged.
  type :: static_row_t
    type(static_report_t) :: report
    real(rp) :: at_load = 0  !< [m] movement of the loaded point along the force
    real(rp) :: tip(3) = 0   !< [m] displacement of the point farthest from the root
    real(rp) :: largest = 0  !< [m]
    real(rp) :: seconds = 0  !< CPU time
  end type static_row_t

  !> Holds the table of loads. The whole table is written again after every load.
  type :: static_table_t
    private
    character(:), allocatable :: path, text
  contains
    procedure :: start => table_start
    procedure :: add => table_add
  end type static_table_t

contains

  !> Writes the header of the table <name>_loads.t. Fails if the file cannot be written.
  subroutine table_start(self, name, failure)
    class(static_table_t), intent(out) :: self
    character(*), intent(in) :: name
    type(failure_t), intent(inout) :: failure
    integer :: i
    self%path = name//'_loads.t'
    self%text = '%'
    do i = 1, size(COLUMNS)
      self%text = self%text//repeat(' ', merge(15, 17, i == 1) - len_trim(COLUMNS(i)))//trim(COLUMNS(i))
    end do
    call save(self, failure)
  end subroutine table_start

  !> Adds the row of load number `number` and writes the table again. Unknown values of a failed load are NaN. Fails if the table
  !> cannot be written.
  subroutine table_add(self, settings, number, row, failure)
    class(static_table_t), intent(inout) :: self
    type(static_settings_t), intent(in) :: settings
    integer, intent(in) :: number
    type(static_row_t), intent(in) :: row
    type(failure_t), intent(inout) :: failure
    character(17*size(COLUMNS)) :: line
    real(rp) :: residual, condition, shape(5)
    residual = row%report%residual
    condition = row%report%reciprocal_condition
    shape = [row%at_load, row%tip, row%largest]
    if (.not. row%report%converged) then
      residual = ieee_value(residual, ieee_quiet_nan)
      condition = residual
      shape = residual
    end if
    associate (l => settings%loads(number), r => row%report)
      write (line, '(es16.8,*(es17.8))') real(number, rp), l%site, l%force, merge(1.0_rp, 0.0_rp, r%converged), &
     residual, real([r%factorisations, r%snaps, r%stages], rp), condition, shape, settings%wing_case%model%size, row%seconds
    end associate
    self%text = self%text//NL//trim(line)
    call save(self, failure)
  end subroutine table_add

  !> Writes the results so far to their file.
  subroutine save(self, failure)
    type(static_table_t), intent(in) :: self
    type(failure_t), intent(inout) :: failure
    call write_text(self%path, self%text, failure)
  end subroutine save

  !> Returns the name of the files of load number `number`, without .h5 or .xmf.
  function shape_file(settings, number) result(path)
    type(static_settings_t), intent(in) :: settings
    integer, intent(in) :: number
    character(:), allocatable :: path
    character(12) :: text
    write (text, '(i0.2)') number
    path = settings%name//'_'//trim(text)
  end function shape_file

  !> Removes the files of load number `number` that an earlier run may have left.
  subroutine remove_shape(settings, number)
    type(static_settings_t), intent(in) :: settings
    integer, intent(in) :: number
    call remove_file(shape_file(settings, number)//'.xmf')
    call remove_file(shape_file(settings, number)//'.h5')
  end subroutine remove_shape

  !> Writes the wing displaced by u(3, n_all) [m] under load number `number`. Fails if the files cannot be written.
  subroutine write_shape(settings, number, u, row, failure)
    type(static_settings_t), intent(in) :: settings
    integer, intent(in) :: number
    real(rp), intent(in) :: u(:, :)
    type(static_row_t), intent(in) :: row
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    type(wing_lines_t) :: lines
    character(:), allocatable :: path
    character(8), parameter :: none(0) = [character(8) ::]
    path = shape_file(settings, number)
    associate (s => settings%wing_case, load => settings%loads(number))
      call lines%init(s%wing)
      call file%create_serial(path//'.h5.part', failure)
      call put_wing(file, lines, s%wing, u, failure)
      call put_wing_vectors(file, lines, 'force', 'N', load%load%force(:, :s%model%n_points), .false., failure)
      call put_attribute(file, '/', 'schema', 'flusi-msm static shape', failure)
      call put_attribute(file, '/', 'wing', s%path, failure)
      call put_attribute(file, '/', 'load', number, failure)
      call put_attribute(file, '/', 'place', load%site, failure)
      call put_attribute(file, '/', 'force', load%force, failure)
      call put_attribute(file, '/', 'E', s%model%params%young, failure)
      call put_attribute(file, '/', 'D', s%model%params%plate, failure)
      call put_attribute(file, '/', 'residual', row%report%residual, failure)
    end associate
    call file%publish(path//'.h5', .false., failure)
    if (failure%failed) return
    call write_text(path//'.xmf', xdmf_text(shape_grid(lines, name_of(path)//'.h5', 'wing', ['force'], none)), failure)
  end subroutine write_shape
end module flusi_static_output
