! SPDX-License-Identifier: GPL-3.0-or-later
!> The wings' surfaces, saved with the fields: `wing_<side>_<label>.h5` and the index `<run>_<side>.xmf`.
!>
!> A file holds points (n, 3) [L] and velocities (n, 3) [L/T] in space, triangles (m, 3) from 0, and as
!> attributes time, hinge (3) and axis_x, axis_y, axis_z (3 each), the axes of the wing frame in space.
module app_flight_output
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use fsi_flapping_wings, only: flapping_wings_t
  use io_attributes, only: put_attribute
  use io_datasets, only: write_integers, write_slab
  use io_fields, only: field_file
  use io_hdf5, only: hdf5_file_t
  use io_xdmf, only: xdmf_index_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: flight_output_t

  type :: flight_output_t
    private
    type(world_t) :: world
    type(xdmf_index_t), allocatable :: index(:)
  contains
    procedure :: init => output_init
    procedure :: write => output_write
  end type flight_output_t

contains

  !> Opens the indices of the run called `name`; with `restart_time` >= 0 earlier entries are kept. Collective.
  subroutine output_init(self, world, wings, name, restart_time, failure)
    class(flight_output_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(flapping_wings_t), intent(in) :: wings
    character(*), intent(in) :: name
    real(rp), intent(in) :: restart_time
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: path
    integer :: i
    self%world = world
    allocate (self%index(size(wings%surfaces)))
    do i = 1, size(wings%surfaces)
      path = name//'_'//trim(wings%params%wings(i)%side)//'.xmf'
      if (restart_time >= 0) then
        call self%index(i)%open(world, path, failure, restart_time=restart_time)
      else
        call self%index(i)%open(world, path, failure)
      end if
    end do
  end subroutine output_init

  !> Writes all wings under one label. Root writes, all ranks share its verdict. Collective.
  subroutine output_write(self, wings, label, note, failure)
    class(flight_output_t), intent(inout) :: self
    type(flapping_wings_t), intent(in) :: wings
    character(*), intent(in) :: label
    character(*), intent(in) :: note !< on the units, stored unless it is empty
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: path
    type(failure_t) :: writing
    integer :: i
    do i = 1, size(wings%surfaces)
      if (failure%failed) return
      path = field_file('wing_'//trim(wings%params%wings(i)%side), label)
      if (self%world%is_root) call write_surface(wings, i, path, note, writing)
      if (self%world%max_integer(merge(1, 0, writing%failed)) > 0) call failure%raise(path//': cannot be written')
      call self%index(i)%add_surface(wings%time, label, path, size(wings%surfaces(i)%points, 2), &
                                     size(wings%surfaces(i)%triangles, 2), ['velocities'], failure)
    end do
  end subroutine output_write

  subroutine write_surface(wings, i, path, note, failure)
    type(flapping_wings_t), intent(in) :: wings
    integer, intent(in) :: i
    character(*), intent(in) :: path, note
    type(failure_t), intent(inout) :: failure
    type(hdf5_file_t) :: file
    associate (surface => wings%surfaces(i), pose => wings%poses(i))
      call file%create_serial(path//'.part', failure)
      call put_vectors('points', 'L', surface%points)
      call put_vectors('velocities', 'L/T', surface%velocities)
      call write_integers(file, 'triangles', int(shape(surface%triangles), i8), [surface%triangles - 1], failure)
      call put_attribute(file, '/', 'schema', 'flusi-msm wing surface', failure)
      if (note /= '') call put_attribute(file, '/', 'units', note, failure)
      call put_attribute(file, '/', 'time', wings%time, failure)
      call put_attribute(file, '/', 'hinge', pose%hinge, failure)
      call put_attribute(file, '/', 'axis_x', pose%matrix(1, :), failure)
      call put_attribute(file, '/', 'axis_y', pose%matrix(2, :), failure)
      call put_attribute(file, '/', 'axis_z', pose%matrix(3, :), failure)
      call file%publish(path, .false., failure)
    end associate

  contains

    subroutine put_vectors(name, units, values)
      character(*), intent(in) :: name, units
      real(rp), intent(in) :: values(:, :)
      integer(i8) :: dims(2)
      dims = shape(values, kind=i8)
      call write_slab(file, name, dims, [0_i8, 0_i8], dims, [values], .false., failure)
      call put_attribute(file, name, 'units', units, failure)
    end subroutine put_vectors
  end subroutine write_surface
end module app_flight_output
