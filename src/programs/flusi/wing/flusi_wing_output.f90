! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes a deformed wing into an HDF5 file, and makes the part of an XDMF index that describes it.
!>
!> The file holds points, displacement, other vectors (n x 3) and triangles (m x 3, counted from 0) of the membrane. The veins
!> have points of their own, because a point where veins meet has several diameters: vein_points, vein_displacement,
!> vein_diameter, and vein_cells. The latter holds one polyline for each vein in XDMF's mixed topology: 2, the number of points,
!> the points. A filter such as ParaView's Tube makes tubes of them. SI units, 64 bits.
module flusi_wing_output
  use base_errors, only: failure_t
  use base_kinds, only: rp, i8
  use base_text, only: number_text
  use base_text_lines, only: real_text
  use io_attributes, only: put_attribute
  use io_datasets, only: write_integers, write_slab
  use io_hdf5, only: hdf5_file_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_lines_t, put_wing, put_wing_vectors, shape_grid

  character(*), parameter :: INTEGERS = 'Int', REALS = 'Float' !< types of numbers in an XDMF index

  character(*), parameter :: NL = new_line('a')
  integer, parameter :: POLYLINE = 2 !< number of this kind of cell in XDMF

  !> Holds the points and diameters of all veins, vein after vein, and the cells that join them.
  type :: wing_lines_t
    integer :: n_points = 0, n_triangles = 0, n_veins = 0 !< of the wing
    integer, allocatable :: nodes(:), cells(:)
    real(rp), allocatable :: diameters(:) !< [m]
  contains
    procedure :: init => lines_init
  end type wing_lines_t

contains

  !> Lists the points, diameters and cells of the veins of a wing.
  subroutine lines_init(self, wing)
    class(wing_lines_t), intent(out) :: self
    type(wing_t), intent(in) :: wing
    integer :: i, k, n
    self%n_points = size(wing%points, 2)
    self%n_triangles = size(wing%triangles, 2)
    self%n_veins = size(wing%veins)
    allocate (self%nodes(0), self%cells(0), self%diameters(0))
    do i = 1, size(wing%veins)
      n = size(wing%veins(i)%nodes)
      self%cells = [self%cells, POLYLINE, n, [(size(self%nodes) + k, k=0, n - 1)]]
      self%nodes = [self%nodes, wing%veins(i)%nodes]
      self%diameters = [self%diameters, wing%veins(i)%diameters]
    end do
  end subroutine lines_init

  !> Writes the wing displaced by u(3, n) [m] into an open file: points, displacement, triangles and veins.
  subroutine put_wing(file, lines, wing, u, failure)
    type(hdf5_file_t), intent(in) :: file
    type(wing_lines_t), intent(in) :: lines
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: u(:, :)
    type(failure_t), intent(inout) :: failure
    call put_wing_vectors(file, lines, 'points', 'm', wing%points + u(:, :lines%n_points), .true., failure)
    call put_wing_vectors(file, lines, 'displacement', 'm', u(:, :lines%n_points), .true., failure)
    if (lines%n_triangles > 0) call write_integers(file, 'triangles', int(shape(wing%triangles), i8), &
                                                   [wing%triangles - 1], failure)
    if (lines%n_veins == 0) return
    associate (n => size(lines%diameters, kind=i8))
      call write_slab(file, 'vein_diameter', [n], [0_i8], [n], lines%diameters, .false., failure)
    end associate
    call put_attribute(file, 'vein_diameter', 'units', 'm', failure)
    call write_integers(file, 'vein_cells', [size(lines%cells, kind=i8)], lines%cells, failure)
  end subroutine put_wing

  !> Writes vectors v(3, n) at the points of the membrane. If `on_veins`, it also writes them at the points of the veins as
  !> vein_<name>.
  subroutine put_wing_vectors(file, lines, name, units, v, on_veins, failure)
    type(hdf5_file_t), intent(in) :: file
    type(wing_lines_t), intent(in) :: lines
    character(*), intent(in) :: name, units
    real(rp), intent(in) :: v(:, :)
    logical, intent(in) :: on_veins
    type(failure_t), intent(inout) :: failure
    if (lines%n_triangles > 0) call put(name, v)
    if (on_veins .and. lines%n_veins > 0) call put('vein_'//name, v(:, lines%nodes))

  contains

    subroutine put(dataset, values)
      character(*), intent(in) :: dataset
      real(rp), intent(in) :: values(:, :)
      integer(i8) :: dims(2)
      dims = shape(values, kind=i8)
      call write_slab(file, dataset, dims, [0_i8, 0_i8], dims, [values], .false., failure)
      call put_attribute(file, dataset, 'units', units, failure)
    end subroutine put
  end subroutine put_wing_vectors

  !> Returns the part of an XDMF index that describes membrane and veins in `file` as a collection called `name`. `vectors`
  !> names the vectors of the membrane besides the displacement; those in `vein_vectors` are on the veins too. With `time` the
  !> collection belongs to that time.
  function shape_grid(lines, file, name, vectors, vein_vectors, time) result(xml)
    type(wing_lines_t), intent(in) :: lines
    character(*), intent(in) :: file, name, vectors(:), vein_vectors(:)
    real(rp), intent(in), optional :: time
    character(:), allocatable :: xml
    integer :: i
    xml = '<Grid Name="'//name//'" GridType="Collection" CollectionType="Spatial">'//NL
    if (present(time)) xml = xml//'<Time Value="'//real_text(time)//'"/>'//NL
    associate (n => lines%n_points, m => lines%n_triangles, k => size(lines%nodes))
      if (m > 0) then
        xml = xml//'<Grid Name="membrane" GridType="Uniform">'//NL// &
              '<Topology TopologyType="Triangle" NumberOfElements="'//number_text(m)//'">'//NL// &
              item('triangles', INTEGERS, number_text(m)//' 3')//'</Topology>'//NL//geometry('points', n)// &
              vector('displacement', 'displacement', n)
        do i = 1, size(vectors)
          xml = xml//vector(trim(vectors(i)), trim(vectors(i)), n)
        end do
        xml = xml//'</Grid>'//NL
      end if
      if (lines%n_veins > 0) then
        xml = xml//'<Grid Name="veins" GridType="Uniform">'//NL// &
              '<Topology TopologyType="Mixed" NumberOfElements="'//number_text(lines%n_veins)//'">'//NL// &
              item('vein_cells', INTEGERS, number_text(size(lines%cells)))//'</Topology>'//NL// &
              geometry('vein_points', k)//vector('displacement', 'vein_displacement', k)
        do i = 1, size(vein_vectors)
          xml = xml//vector(trim(vein_vectors(i)), 'vein_'//trim(vein_vectors(i)), k)
        end do
        xml = xml//'<Attribute Name="diameter" AttributeType="Scalar" Center="Node">'//NL// &
              item('vein_diameter', REALS, number_text(k))//'</Attribute>'//NL//'</Grid>'//NL
      end if
    end associate
    xml = xml//'</Grid>'//NL

  contains

    function item(dataset, kind, dimensions) result(text)
      character(*), intent(in) :: dataset, kind, dimensions
      character(:), allocatable :: text
      text = '<DataItem Format="HDF" NumberType="'//kind//'" Precision="'//merge('4', '8', kind == INTEGERS)// &
             '" Dimensions="'//dimensions//'">'//file//':/'//dataset//'</DataItem>'//NL
    end function item

    function geometry(dataset, count) result(text)
      character(*), intent(in) :: dataset
      integer, intent(in) :: count
      character(:), allocatable :: text
      text = '<Geometry GeometryType="XYZ">'//NL//item(dataset, REALS, number_text(count)//' 3')//'</Geometry>'//NL
    end function geometry

    function vector(title, dataset, count) result(text)
      character(*), intent(in) :: title, dataset
      integer, intent(in) :: count
      character(:), allocatable :: text
      text = '<Attribute Name="'//title//'" AttributeType="Vector" Center="Node">'//NL// &
             item(dataset, REALS, number_text(count)//' 3')//'</Attribute>'//NL
    end function vector
  end function shape_grid
end module flusi_wing_output
