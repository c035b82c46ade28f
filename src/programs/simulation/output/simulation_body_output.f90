! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves the surface of the body with the fields, in `body_<label>.h5`, and the index `<run>_body.xmf`. A file holds points (n,
!> 3) [L] and velocities (n, 3) [L/T] in space, triangles (m, 3) counted from 0, and as attributes time, centre (3) and the axes
!> of the body.
module simulation_body_output
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use fsi_body_surface, only: body_surface
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_rotation, only: cross
  use io_attributes, only: put_attribute
  use io_datasets, only: write_integers, write_slab
  use io_fields, only: field_file
  use io_hdf5, only: hdf5_file_t
  use io_xdmf, only: xdmf_index_t
  use parallel_world, only: world_t
  use simulation_opening, only: opening_t
  implicit none
  private
  public :: body_output_t

  !> Writes the surface of the body. It does nothing if there is no body.
  type :: body_output_t
    private
    type(world_t) :: world
    type(xdmf_index_t) :: index
    real(rp), allocatable :: points(:, :) !< of the triangles, three each, in the body frame, L
  contains
    procedure :: init => output_init
    procedure :: write => output_write
  end type body_output_t

contains

  !> Opens the index of the run if there is a body. Collective.
  subroutine output_init(self, opening, wings)
    class(body_output_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    type(flapping_wings_t), intent(in) :: wings
    self%world = opening%world
    if (.not. wings%has_body()) return
    call body_surface(wings%params%solid, self%points)
    call self%index%open(opening%world, opening%name//'_body.xmf', opening%failure, opening%restart_time)
  end subroutine output_init

  !> Writes the body at its present position, if there is a body. Root writes; if it fails, all ranks fail. Collective.
  subroutine output_write(self, wings, label, note, failure)
    class(body_output_t), intent(inout) :: self
    type(flapping_wings_t), intent(in) :: wings
    character(*), intent(in) :: label
    character(*), intent(in) :: note !< on the units, stored unless it is empty
    type(failure_t), intent(inout) :: failure
    type(failure_t) :: writing
    character(:), allocatable :: path
    if (.not. allocated(self%points) .or. failure%failed) return
    path = field_file('body', label)
    if (self%world%is_root) call write_surface(self, wings, path, note, writing)
    if (self%world%max_integer(merge(1, 0, writing%failed)) > 0) call failure%raise(path//': cannot be written')
    call self%index%add_surface(wings%time, label, path, [size(self%points, 2), size(self%points, 2)/3], &
                                [character(12) :: 'velocities'], failure)
  end subroutine output_write

  !> Writes the surface of the body at the present time as an HDF5 file.
  subroutine write_surface(self, wings, path, note, failure)
    type(body_output_t), intent(in) :: self
    type(flapping_wings_t), intent(in) :: wings
    character(*), intent(in) :: path, note
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    real(rp) :: sites(3, size(self%points, 2)), speeds(3, size(self%points, 2))
    integer(i8) :: dims(2)
    integer :: i
    associate (body => wings%body)
      do i = 1, size(sites, 2)
        sites(:, i) = body%centre + body%rotation%to_parent(self%points(:, i))
        speeds(:, i) = body%velocity + body%rotation%to_parent(cross(body%rotation%omega, self%points(:, i)))
      end do
      dims = shape(sites, kind=i8)
      call file%create_serial(path//'.part', failure)
      call write_slab(file, 'points', dims, [0_i8, 0_i8], dims, [sites], .false., failure)
      call put_attribute(file, 'points', 'units', 'L', failure)
      call write_slab(file, 'velocities', dims, [0_i8, 0_i8], dims, [speeds], .false., failure)
      call put_attribute(file, 'velocities', 'units', 'L/T', failure)
      call write_integers(file, 'triangles', [3_i8, dims(2)/3], [(i, i=0, size(sites, 2) - 1)], failure)
      call put_attribute(file, '/', 'schema', 'flusi-msm body surface', failure)
      if (note /= '') call put_attribute(file, '/', 'units', note, failure)
      call put_attribute(file, '/', 'time', wings%time, failure)
      call put_attribute(file, '/', 'centre', body%centre, failure)
      call put_attribute(file, '/', 'axis_x', body%rotation%matrix(1, :), failure)
      call put_attribute(file, '/', 'axis_y', body%rotation%matrix(2, :), failure)
      call put_attribute(file, '/', 'axis_z', body%rotation%matrix(3, :), failure)
      call file%publish(path, .false., failure)
    end associate
  end subroutine write_surface
end module simulation_body_output
