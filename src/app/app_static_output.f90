! SPDX-License-Identifier: GPL-3.0-or-later
!> Files of `flusi --static`: for each load the deformed wing in HDF5 with an XDMF index, and a table of all
!> loads.
!>
!> `<name>_NN.h5` holds points, displacement, force (n x 3) and triangles (m x 3, from 0) of the membrane; the
!> veins have points of their own, since a point where veins meet has several diameters: vein_points,
!> vein_displacement, vein_diameter, and vein_cells, one polyline a vein in XDMF's mixed topology: 2, number
!> of points, points. SI units, 64 bits. Every file gets its name when it is complete.
module app_static_output
  use app_static_settings, only: static_load_t, static_settings_t
  use base_errors, only: failure_t
  use base_files, only: name_of, remove_file
  use base_kinds, only: rp, i8
  use base_text, only: number_text
  use base_text_file, only: write_text
  use io_attributes, only: put_attribute
  use io_datasets, only: write_integers, write_slab
  use io_hdf5, only: hdf5_file_t
  use solid_statics, only: static_report_t
  use solid_wing, only: wing_t
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  implicit none
  private
  public :: static_table_t, static_row_t, write_shape, remove_shape

  character(*), parameter :: NL = new_line('a')
  integer, parameter :: POLYLINE = 2 !< XDMF's number of this kind of cell
  character(*), parameter :: COLUMNS(19) = [character(14) :: 'load [-]', 'x [m]', 'y [m]', 'fx [N]', 'fy [N]', &
      'fz [N]', 'converged [-]', 'residual [-]', 'factors [-]', 'snaps [-]', 'stages [-]', 'rcond [-]', 'at_load [m]', &
                                               'tip_x [m]', 'tip_y [m]', 'tip_z [m]', 'largest [m]', 'R [m]', 'CPU [s]']

  !> What came out for one load; the shape is defined if it converged.
  type :: static_row_t
    type(static_report_t) :: report
    real(rp) :: at_load = 0  !< [m] movement of the loaded place along the force
    real(rp) :: tip(3) = 0   !< [m] displacement of the point farthest from the root
    real(rp) :: largest = 0  !< [m]
    real(rp) :: seconds = 0  !< CPU time
  end type static_row_t

  !> The table of loads, rewritten as a whole after every load.
  type :: static_table_t
    private
    character(:), allocatable :: path, text
  contains
    procedure :: start => table_start
    procedure :: add => table_add
  end type static_table_t

contains

  !> Writes the header of the table, which also shows whether files can be written at all.
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

  !> Adds the row of load number `number`; what a failed load leaves unknown is NaN.
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
      write (line, '(es16.8,*(es17.8))') real(number, rp), l%place, l%force, merge(1.0_rp, 0.0_rp, r%converged), &
        residual, real([r%factorisations, r%snaps, r%stages], rp), condition, shape, settings%model%size, row%seconds
    end associate
    self%text = self%text//NL//trim(line)
    call save(self, failure)
  end subroutine table_add

  subroutine save(self, failure)
    type(static_table_t), intent(in) :: self
    type(failure_t), intent(inout) :: failure
    logical :: ok
    call write_text(self%path, self%text, ok)
    if (.not. ok) call failure%raise(self%path//': cannot be written; is the folder missing or the disk full?')
  end subroutine save

  !> Name of the files of load number `number`, without .h5 or .xmf.
  function shape_file(settings, number) result(path)
    type(static_settings_t), intent(in) :: settings
    integer, intent(in) :: number
    character(:), allocatable :: path
    character(12) :: text
    write (text, '(i0.2)') number
    path = settings%name//'_'//trim(text)
  end function shape_file

  !> Removes the files of a load that an earlier run may have left.
  subroutine remove_shape(settings, number)
    type(static_settings_t), intent(in) :: settings
    integer, intent(in) :: number
    logical :: ignored
    call remove_file(shape_file(settings, number)//'.xmf', ignored)
    call remove_file(shape_file(settings, number)//'.h5', ignored)
  end subroutine remove_shape

  !> Writes the wing displaced by u(3, n_all) [m] under load number `number`.
  subroutine write_shape(settings, number, u, row, failure)
    type(static_settings_t), intent(in) :: settings
    integer, intent(in) :: number
    real(rp), intent(in) :: u(:, :)
    type(static_row_t), intent(in) :: row
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    character(:), allocatable :: path
    integer, allocatable :: vein_nodes(:), cells(:)
    real(rp), allocatable :: diameters(:)
    logical :: ok
    integer :: n
    path = shape_file(settings, number)
    n = settings%model%n_points
    call list_veins(settings%wing, vein_nodes, diameters, cells)
    associate (wing => settings%wing, moved => settings%wing%points + u(:, :n), load => settings%loads(number))
      call file%create_serial(path//'.h5.part', failure)
      if (size(wing%triangles) > 0) then
        call put_vectors(file, 'points', 'm', moved, failure)
        call put_vectors(file, 'displacement', 'm', u(:, :n), failure)
        call put_vectors(file, 'force', 'N', load%load%force(:, :n), failure)
        call write_integers(file, 'triangles', int(shape(wing%triangles), i8), &
                            [wing%triangles - 1], failure)
      end if
      if (size(wing%veins) > 0) then
        call put_vectors(file, 'vein_points', 'm', moved(:, vein_nodes), failure)
        call put_vectors(file, 'vein_displacement', 'm', u(:, vein_nodes), failure)
        call write_slab(file, 'vein_diameter', [size(diameters, kind=i8)], [0_i8], [size(diameters, kind=i8)], &
                        diameters, .false., failure)
        call put_attribute(file, 'vein_diameter', 'units', 'm', failure)
        call write_integers(file, 'vein_cells', [size(cells, kind=i8)], cells, failure)
      end if
      call put_attribute(file, '/', 'schema', 'flusi-msm static shape', failure)
      call put_attribute(file, '/', 'wing', settings%wing_path, failure)
      call put_attribute(file, '/', 'load', number, failure)
      call put_attribute(file, '/', 'place', load%place, failure)
      call put_attribute(file, '/', 'force', load%force, failure)
      call put_attribute(file, '/', 'E', settings%model%params%young, failure)
      call put_attribute(file, '/', 'D', settings%model%params%plate, failure)
      call put_attribute(file, '/', 'residual', row%report%residual, failure)
      call file%publish(path//'.h5', .false., failure)
      if (failure%failed) return
      call write_text(path//'.xmf', index_text(name_of(path)//'.h5', wing, size(vein_nodes), size(cells)), ok)
    end associate
    if (.not. ok) call failure%raise(path//'.xmf: cannot be written; is the disk full?')
  end subroutine write_shape

  subroutine put_vectors(file, name, units, values, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name, units
    real(rp), intent(in) :: values(:, :)
    type(failure_t), intent(inout) :: failure
    integer(i8) :: dims(2)
    dims = shape(values, kind=i8)
    call write_slab(file, name, dims, [0_i8, 0_i8], dims, [values], .false., failure)
    call put_attribute(file, name, 'units', units, failure)
  end subroutine put_vectors

  !> Points and diameters of all veins one after the other, and the cells that join them.
  subroutine list_veins(wing, nodes, diameters, cells)
    type(wing_t), intent(in) :: wing
    integer, allocatable, intent(out) :: nodes(:), cells(:)
    real(rp), allocatable, intent(out) :: diameters(:)
    integer :: i, k, n
    allocate (nodes(0), cells(0), diameters(0))
    do i = 1, size(wing%veins)
      n = size(wing%veins(i)%nodes)
      cells = [cells, POLYLINE, n, [(size(nodes) + k, k=0, n - 1)]]
      nodes = [nodes, wing%veins(i)%nodes]
      diameters = [diameters, wing%veins(i)%diameters]
    end do
  end subroutine list_veins

  !> The XDMF index: membrane and veins as two grids of one collection.
  function index_text(file, wing, n_vein_points, n_cells) result(xml)
    character(*), intent(in) :: file
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: n_vein_points, n_cells
    character(:), allocatable :: xml
    integer :: n, m
    n = size(wing%points, 2)
    m = size(wing%triangles, 2)
    xml = '<?xml version="1.0" ?>'//NL//'<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>'//NL//'<Xdmf Version="3.0">'//NL// &
          '<Domain>'//NL//'<Grid Name="wing" GridType="Collection" CollectionType="Spatial">'//NL
    if (m > 0) xml = xml//'<Grid Name="membrane" GridType="Uniform">'//NL// &
                     '<Topology TopologyType="Triangle" NumberOfElements="'//number_text(m)//'">'//NL// &
                     item('triangles', 'Int', number_text(m)//' 3')//'</Topology>'//NL//geometry('points', n)// &
                     vector('displacement', 'displacement', n)//vector('force', 'force', n)//'</Grid>'//NL
    if (n_vein_points > 0) xml = xml//'<Grid Name="veins" GridType="Uniform">'//NL// &
                        '<Topology TopologyType="Mixed" NumberOfElements="'//number_text(size(wing%veins))//'">'//NL// &
          item('vein_cells', 'Int', number_text(n_cells))//'</Topology>'//NL//geometry('vein_points', n_vein_points)// &
                                 vector('displacement', 'vein_displacement', n_vein_points)// &
                                 '<Attribute Name="diameter" AttributeType="Scalar" Center="Node">'//NL// &
                           item('vein_diameter', 'Float', number_text(n_vein_points))//'</Attribute>'//NL//'</Grid>'//NL
    xml = xml//'</Grid>'//NL//'</Domain>'//NL//'</Xdmf>'

  contains

    function item(dataset, kind, dimensions) result(text)
      character(*), intent(in) :: dataset, kind, dimensions
      character(:), allocatable :: text
      text = '<DataItem Format="HDF" NumberType="'//kind//'" Precision="'//merge('4', '8', kind == 'Int')// &
             '" Dimensions="'//dimensions//'">'//file//':/'//dataset//'</DataItem>'//NL
    end function item

    function geometry(dataset, count) result(text)
      character(*), intent(in) :: dataset
      integer, intent(in) :: count
      character(:), allocatable :: text
      text = '<Geometry GeometryType="XYZ">'//NL//item(dataset, 'Float', number_text(count)//' 3')//'</Geometry>'//NL
    end function geometry

    function vector(name, dataset, count) result(text)
      character(*), intent(in) :: name, dataset
      integer, intent(in) :: count
      character(:), allocatable :: text
      text = '<Attribute Name="'//name//'" AttributeType="Vector" Center="Node">'//NL// &
             item(dataset, 'Float', number_text(count)//' 3')//'</Attribute>'//NL
    end function vector
  end function index_text
end module app_static_output
