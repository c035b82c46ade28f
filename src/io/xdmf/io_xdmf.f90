! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the index (`<run>.xmf`, XDMF 3) with which ParaView shows the field files of a run as one time series.
!>
!> One uniform grid per saved time: 3DCoRectMesh, point values, sizes in the order z y x. Every prefix is
!> a scalar; prefixes that end in x, y and z with a common stem are also one vector of that stem. (Of
!> ParaView 5.11's readers 'XDMF Reader' shows both, 'Xdmf3 Reader' skips the vectors.) The index is
!> rewritten as a whole at every save. A restarted run keeps the text of the grids up to its restart
!> time from the existing index, so that one index describes the whole run.
module io_xdmf
  use base_errors, only: failure_t, require
  use base_files, only: file_exists
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_text_file, only: write_text
  use base_text_lines, only: real_text
  use io_fields, only: field_file, field_form_t, field_meta_t, strided_points
  use io_xdmf_grids, only: grid_marks_t, read_grids
  use parallel_failure, only: broadcast_failure
  use parallel_world, only: world_t
  implicit none
  private
  public :: xdmf_index_t

  character(*), parameter :: NL = new_line('a')
  character(*), &
    parameter :: HEAD = '<?xml version="1.0" ?>'//NL//'<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>'//NL// &
                 '<Xdmf Version="3.0">'//NL//'<Domain>'//NL// &
                 '<Grid Name="fields" GridType="Collection" CollectionType="Temporal">'//NL
  character(*), parameter :: TAIL = '</Grid>'//NL//'</Domain>'//NL//'</Xdmf>'
  ! Beginning and end of a grid in the index; the procedure that reads an index back relies on them.
  character(*), parameter :: GRID_HEAD = '<Grid GridType="Uniform" Name="', GRID_TAIL = '</Grid>'
  character(*), parameter :: TIME_HEAD = '<Time Value="', TIME_TAIL = '"/>'

  !> The index of one run, on rank 0; the other ranks hold nothing.
  type :: xdmf_index_t
    private
    type(world_t) :: world
    character(:), allocatable :: path
    character(:), allocatable :: grids !< the text of all grids so far
  contains
    procedure :: open => index_open
    procedure :: add => index_add
    procedure :: add_surface => index_add_surface
  end type xdmf_index_t

contains

  !> Starts the index `path`, in the folder of the field files. With `restart_time` the grids up to that
  !> time of an existing index are kept. Nothing is written yet. Fails if an existing index was not
  !> written by this module. Collective.
  subroutine index_open(self, world, path, failure, restart_time)
    class(xdmf_index_t), intent(out) :: self
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    real(rp), intent(in), optional :: restart_time
    type(failure_t) :: own
    type(grid_marks_t) :: marks
    self%world = world
    self%path = path
    self%grids = ''
    if (failure%failed) return
    if (world%is_root .and. present(restart_time)) then
      ! A run also saves the fields of its last step, which is not saved if the run goes on.
      marks = grid_marks_t(begin=GRID_HEAD, end=GRID_TAIL, time=TIME_HEAD, before='"', closing=TIME_TAIL, keeps_last=.false.)
      if (file_exists(path)) call read_grids(path, marks, restart_time, self%grids, own)
    end if
    call broadcast_failure(world, own, failure)
  end subroutine index_open

  !> Adds the fields saved at one time under one label and rewrites the index; an earlier grid with this label is removed, because
  !> its files have been replaced. Collective.
  subroutine index_add(self, prefixes, meta, form, failure)
    class(xdmf_index_t), intent(inout) :: self
    character(*), intent(in) :: prefixes(:)  !< one file `<prefix>_<label>.h5` each
    type(field_meta_t), intent(in) :: meta   !< time, origin, and size and points of the computation
    type(field_form_t), intent(in) :: form   !< how the fields were written
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: text, size_text, stem
    integer :: i, y, z

    if (failure%failed) return
    call require(form%stride >= 1, 'io_xdmf: stride below 1')
    text = ''
    if (self%world%is_root) then
      size_text = sizes(strided_points(meta%nxyz, form%stride))
      text = '<Topology TopologyType="3DCoRectMesh" Dimensions="'//size_text//'"/>'//NL// &
             '<Geometry GeometryType="ORIGIN_DXDYDZ">'//NL// &
             triple(meta%origin)//triple(form%stride*meta%domain_size/meta%nxyz)//'</Geometry>'//NL
      do i = 1, size(prefixes)
        if (partners(prefixes, trim(prefixes(i)), y, z, stem)) then
          text = text//attribute(stem, 'Vector', &
                                 '<DataItem ItemType="Function" Function="JOIN($0, $1, $2)" Dimensions="'// &
                                 size_text//' 3">'//NL//item(prefixes(i))//item(prefixes(y))// &
                                 item(prefixes(z))//'</DataItem>'//NL)
        end if
        text = text//attribute(trim(prefixes(i)), 'Scalar', item(prefixes(i)))
      end do
    end if
    call add_grid(self, meta%time, form%label, text, failure)

  contains

    function item(prefix) result(xml)
      character(*), intent(in) :: prefix
      character(:), allocatable :: xml
      xml = '<DataItem Format="HDF" NumberType="Float" Precision="'//achar(iachar('0') + form%precision)// &
            '" Dimensions="'//size_text//'">'//field_file(prefix, form%label)//':/'//trim(prefix)//'</DataItem>'//NL
    end function item
  end subroutine index_add

  !> Adds a surface of n(1) points and n(2) triangles saved at one time in `file`, with the
  !> datasets points (n, 3), triangles (m, 3) of 32 bits from 0, `vectors` (n, 3) and, of each triangle,
  !> `cell_scalars` (m); then as `add`. Collective.
  subroutine index_add_surface(self, time, label, file, n, vectors, failure, cell_scalars)
    class(xdmf_index_t), intent(inout) :: self
    real(rp), intent(in) :: time
    character(*), intent(in) :: label, file
    integer, intent(in) :: n(2)
    character(*), intent(in) :: vectors(:)
    type(failure_t), intent(inout) :: failure
    character(*), intent(in), optional :: cell_scalars(:)
    character(:), allocatable :: text
    integer :: i
    if (failure%failed) return
    text = '<Topology TopologyType="Triangle" NumberOfElements="'//number_text(n(2))//'">'//NL// &
           item('triangles', 'Int', 4, n(2), ' 3')//'</Topology>'//NL//'<Geometry GeometryType="XYZ">'//NL// &
           item('points', 'Float', 8, n(1), ' 3')//'</Geometry>'//NL
    do i = 1, size(vectors)
      text = text//attribute(trim(vectors(i)), 'Vector', item(trim(vectors(i)), 'Float', 8, n(1), ' 3'))
    end do
    if (present(cell_scalars)) then
      do i = 1, size(cell_scalars)
        text = text//attribute(trim(cell_scalars(i)), 'Scalar', &
                               item(trim(cell_scalars(i)), 'Float', 8, n(2), ''), 'Cell')
      end do
    end if
    call add_grid(self, time, label, text, failure)

  contains

    function item(dataset, kind, precision, rows, columns) result(xml)
      character(*), intent(in) :: dataset, kind, columns
      integer, intent(in) :: precision, rows
      character(:), allocatable :: xml
      xml = '<DataItem Format="HDF" NumberType="'//kind//'" Precision="'//number_text(precision)//'" Dimensions="'// &
            number_text(rows)//columns//'">'//file//':/'//dataset//'</DataItem>'//NL
    end function item
  end subroutine index_add_surface

  !> Adds the grid of this content and rewrites the index. Collective.
  subroutine add_grid(self, time, label, content, failure)
    class(xdmf_index_t), intent(inout) :: self
    real(rp), intent(in) :: time
    character(*), intent(in) :: label, content
    type(failure_t), intent(inout) :: failure
    type(failure_t) :: own
    if (self%world%is_root) then
      self%grids = without(self%grids, label)//GRID_HEAD//label//'">'//NL//TIME_HEAD//real_text(time)//TIME_TAIL//NL// &
                   content//GRID_TAIL//NL
      call write_text(self%path, HEAD//self%grids//TAIL, own)
    end if
    call broadcast_failure(self%world, own, failure)
  end subroutine add_grid

  !> Returns `grids` without the grid of this label.
  function without(grids, label) result(others)
    character(*), intent(in) :: grids, label
    character(:), allocatable :: others
    integer :: first, past
    others = grids
    first = index(grids, GRID_HEAD//label//'">')
    if (first == 0) return
    past = first + index(grids(first:), GRID_TAIL//NL) + len(GRID_TAIL//NL) - 1
    others = grids(:first - 1)//grids(past:)
  end function without

  !> Tells whether `prefix` is the x component of a vector; if so, also the other components and the stem of their names.
  logical function partners(prefixes, prefix, y, z, stem)
    character(*), intent(in) :: prefixes(:), prefix
    integer, intent(out) :: y, z
    character(:), allocatable, intent(out) :: stem
    integer :: i
    stem = prefix(:len(prefix) - 1)
    y = 0
    z = 0
    do i = 1, size(prefixes)
      if (prefixes(i) == stem//'y') y = i
      if (prefixes(i) == stem//'z') z = i
    end do
    partners = len(stem) > 0 .and. prefix == stem//'x' .and. y > 0 .and. z > 0
  end function partners

  !> Returns the XML of one field of a grid.
  pure function attribute(name, kind, content, centre) result(xml)
    character(*), intent(in) :: name, kind, content
    character(*), intent(in), optional :: centre !< Cell, else Node
    character(:), allocatable :: xml, place
    place = 'Node'
    if (present(centre)) place = centre
    xml = '<Attribute Name="'//name//'" AttributeType="'//kind//'" Center="'//place//'">'//NL//content// &
          '</Attribute>'//NL
  end function attribute

  !> Returns 'nz ny nx'.
  pure function sizes(n) result(text)
    integer, intent(in) :: n(3)
    character(:), allocatable :: text
    character(36) :: buffer
    write (buffer, '(i0,1x,i0,1x,i0)') n(3), n(2), n(1)
    text = trim(buffer)
  end function sizes

  !> Returns three numbers as a data item, in the order z y x.
  function triple(x) result(xml)
    real(rp), intent(in) :: x(3)
    character(:), allocatable :: xml
    xml = '<DataItem Format="XML" NumberType="Float" Precision="8" Dimensions="3">'//real_text(x(3))//' '// &
          real_text(x(2))//' '//real_text(x(1))//'</DataItem>'//NL
  end function triple
end module io_xdmf
