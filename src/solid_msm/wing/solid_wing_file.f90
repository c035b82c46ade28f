! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads a wing file (docs/formats/wing-format.md). All mistakes of a file are reported together, each with the object, the index
!> and the value; a wing that is returned has passed every check of solid_wing_check.
module solid_wing_file
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: kind_of
  use base_text, only: number_text, quoted
  use io_arrays, only: is_group, read_text, read_attribute_reals, read_attribute_integer, &
                       is_finite
  use io_attributes, only: has_attribute
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use io_seal, only: guard_input
  use parallel_broadcast, only: broadcast_value
  use parallel_world, only: world_t
  use solid_wing, only: wing_t, z_side_choices, SIDE_UNSTATED, Z_SIDES
  use solid_wing_check, only: check_wing, joint_on_vein
  use solid_wing_datasets, only: check_members, check_schema, read_names, read_real_dataset, read_index_dataset
  use solid_wing_mass, only: read_wing_mass
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: read_wing, read_wing_unguarded, load_wing

  character(*), parameter :: SCHEMA = 'flusi-msm wing'
  integer, parameter :: VERSION = 1

contains

  !> Reads the wing file `path` in this process alone; MPI need not run. If `messages` has no more entries
  !> than before, `wing` is complete and checked; otherwise its content is undefined. Damage becomes a message (see io_seal).
  subroutine read_wing(path, wing, messages)
    character(*), intent(in) :: path
    type(wing_t), intent(out) :: wing
    type(message_list_t), intent(inout) :: messages
    type(failure_t) :: failure
    call guard_input(path, 'wing', failure)
    if (failure%failed) then
      call messages%add(failure%reason)
    else
      call read_wing_unguarded(path, wing, messages)
    end if
  end subroutine read_wing

  !> Reads the wing file like `read_wing`, but without a check of the file as a whole. Damage that crashes the HDF5 library ends the
  !> process.
  subroutine read_wing_unguarded(path, wing, messages)
    character(*), intent(in) :: path
    type(wing_t), intent(out) :: wing
    type(message_list_t), intent(inout) :: messages
    type(wing_report_t) :: report
    type(hdf5_file_t) :: file
    type(failure_t) :: failure, ignored
    integer :: i
    report%path = path
    call file%open_serial(path, failure)
    if (failure%failed) then
      call messages%add(failure%reason)
      return
    end if
    call read_header(file, report)
    if (report%is_clean()) then
      call read_contents(file, wing, report)
      if (report%is_clean()) call check_wing(wing, report)
    end if
    call file%close(ignored)
    do i = 1, report%messages%count()
      call messages%add(report%messages%text(i))
    end do
  end subroutine read_wing_unguarded

  !> Reads the wing file on rank 0 and gives the wing and the messages to all ranks. Collective.
  subroutine load_wing(world, path, wing, messages)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    type(wing_t), intent(out) :: wing
    type(message_list_t), intent(inout) :: messages
    type(message_list_t) :: found
    character(:), allocatable :: text
    integer :: n, i
    if (world%is_root) call read_wing(path, wing, found)
    n = found%count()
    call world%broadcast_integer(n)
    do i = 1, n
      if (world%is_root) text = found%text(i)
      call world%broadcast_text(text)
      call messages%add(text)
    end do
    if (n == 0) call broadcast_value(world, wing)
  end subroutine load_wing

  !> Reads schema, version and index base, on which the meaning of all other data depends.
  subroutine read_header(file, report)
    type(hdf5_file_t), intent(in) :: file
    type(wing_report_t), intent(inout) :: report
    type(failure_t) :: failure
    integer :: number
    call check_schema(file, 'wing', SCHEMA, VERSION, report)
    call read_attribute_integer(file, '/', 'index_base', number, failure)
    if (failure%failed) then
      call report%add('attribute index_base', 'missing or not an integer; valid: 0 or 1, the number of the ' &
                      //'first point')
    else if (number /= 0 .and. number /= 1) then
      call report%add('attribute index_base', 'is '//number_text(number)//'; valid: 0 or 1')
    else
      report%base = number
    end if
  end subroutine read_header

  !> Reads everything in a wing file.
  subroutine read_contents(file, wing, report)
    type(hdf5_file_t), intent(in) :: file
    type(wing_t), intent(inout) :: wing
    type(wing_report_t), intent(inout) :: report
    real(rp), allocatable :: coordinates(:)
    integer, allocatable :: corners(:)
    call check_members(file, '/', [character(9) :: 'points', 'triangles', 'veins', 'joints', 'root', 'extra'], report)
    call read_real_dataset(file, '/points', 3, coordinates, report)
    wing%points = reshape(coordinates, [3, size(coordinates)/3])
    allocate (corners(0))
    if (file%has('/triangles')) call read_index_dataset(file, '/triangles', 3, corners, report)
    wing%triangles = reshape(corners, [3, size(corners)/3])
    call read_index_dataset(file, '/root/nodes', 0, wing%root, report)
    call read_veins(file, wing, report)
    call read_joints(file, wing, report)
    call read_plane(file, wing, report)
    call read_z_side(file, wing, report)
    call read_wing_mass(file, wing%mass, report)
  end subroutine read_contents

  !> Reads the points and diameters of all veins.
  subroutine read_veins(file, wing, report)
    type(hdf5_file_t), intent(in) :: file
    type(wing_t), intent(inout) :: wing
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    character(:), allocatable :: group
    integer :: i
    call read_names(file, '/veins', names, report)
    allocate (wing%veins(size(names)))
    do i = 1, size(names)
      group = '/veins/'//trim(names(i))
      wing%veins(i)%name = trim(names(i))
      allocate (wing%veins(i)%nodes(0), wing%veins(i)%diameters(0))
      if (.not. is_group(file, group)) then
        call report%add(group, 'is not a group with datasets nodes and diameters')
        cycle
      end if
      call read_index_dataset(file, group//'/nodes', 0, wing%veins(i)%nodes, report)
      call read_real_dataset(file, group//'/diameters', 0, wing%veins(i)%diameters, report)
    end do
  end subroutine read_veins

  !> Reads the joints: a joint is three points, or one point and the vein on which it lies.
  subroutine read_joints(file, wing, report)
    type(hdf5_file_t), intent(in) :: file
    type(wing_t), intent(inout) :: wing
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    character(:), allocatable :: object, vein
    integer, allocatable :: nodes(:)
    type(failure_t) :: failure
    integer :: i, n
    call read_names(file, '/joints', names, report)
    allocate (wing%joints(size(names)))
    do i = 1, size(names)
      object = '/joints/'//trim(names(i))
      wing%joints(i)%name = trim(names(i))
      n = report%messages%count()
      call read_index_dataset(file, object, 0, nodes, report)
      if (report%messages%count() > n) cycle
      failure = failure_t()
      call read_text(file, object, 'vein', vein, failure)
      if (size(nodes) == 3 .and. .not. has_attribute(file, object, 'vein')) then
        wing%joints(i)%nodes = nodes
      else if (size(nodes) == 1 .and. .not. failure%failed) then
        call joint_on_vein(wing%veins, vein, nodes(1), object, wing%joints(i)%nodes, report)
      else if (size(nodes) == 1) then
        call report%add(object, 'one point needs the text attribute vein, the name of the vein it lies on')
      else if (size(nodes) == 3) then
        call report%add(object, 'holds three points and the attribute vein; valid: three without, or one with')
      else
        call report%add(object, 'holds '//number_text(size(nodes))// &
                        ' points; valid: three, or one with the attribute vein')
      end if
    end do
  end subroutine read_joints

  !> Reads the normal of the plane of a structure of veins.
  subroutine read_plane(file, wing, report)
    type(hdf5_file_t), intent(in) :: file
    type(wing_t), intent(inout) :: wing
    type(wing_report_t), intent(inout) :: report
    type(failure_t) :: failure
    character(*), parameter :: NAME = 'attribute plane_normal'
    wing%plane_normal = 0
    if (.not. has_attribute(file, '/', 'plane_normal')) return
    if (size(wing%triangles) > 0) then
      call report%add(NAME, 'only structures without triangles may have one')
    else
      call read_attribute_reals(file, '/', 'plane_normal', wing%plane_normal, failure)
      if (failure%failed) then
        call report%add(NAME, 'must be three real numbers')
      else if (.not. all(is_finite(wing%plane_normal))) then
        call report%add(NAME, 'has an infinite or undefined component')
      else if (maxval(abs(wing%plane_normal)) < 1.0e-6_rp .or. maxval(abs(wing%plane_normal)) > 1.0e6_rp) then
        call report%add(NAME, 'must be a vector of a length between 1e-6 and 1e6')
      else
        wing%plane_normal = wing%plane_normal/norm2(wing%plane_normal)
      end if
    end if
  end subroutine read_plane

  !> Reads the side to which z points, if the file states it.
  subroutine read_z_side(file, wing, report)
    type(hdf5_file_t), intent(in) :: file
    type(wing_t), intent(inout) :: wing
    type(wing_report_t), intent(inout) :: report
    character(*), parameter :: NAME = 'attribute z_side'
    character(:), allocatable :: text, valid
    type(failure_t) :: failure
    if (.not. has_attribute(file, '/', 'z_side')) return
    valid = '; valid: '//z_side_choices(' | ')//', the wing that was measured and the side of it to which z points'
    call read_text(file, '/', 'z_side', text, failure)
    if (failure%failed) then
      call report%add(NAME, 'is not a text'//valid)
      return
    end if
    wing%z_side = kind_of(Z_SIDES, text)
    if (wing%z_side == SIDE_UNSTATED) call report%add(NAME, 'is '//quoted(text)//valid)
  end subroutine read_z_side

end module solid_wing_file
