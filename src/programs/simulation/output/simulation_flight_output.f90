! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves the surfaces of the wings with the fields, in `wing_<side>_<label>.h5`, and the index `<run>_<side>.xmf`.
!>
!> A file holds points (n, 3) [L] and velocities (n, 3) [L/T] in space, triangles (m, 3) counted from 0, and as attributes the
!> time, the hinge (3), and axis_x, axis_y and axis_z (3 each), the axes of the wing frame in space. For flexible wings it also
!> holds displacement (n, 3) [L], the vector in space from the place of the point on the rigid wing; load (n, 3) [rho L^2/T^2],
!> the force in space on a point, divided by a third of the area of the triangles around it; and pressure_jump (m) [rho
!> L^2/T^2], the pressure on the side to which axis_z points minus that on the other side. On request it holds pressure_dorsal
!> and pressure_ventral (m) and traction_dorsal and traction_ventral (m, 3) [rho L^2/T^2], in space, of the flow at
!> `side_distance` [L] beside the triangles (fsi_wing_sides).
module simulation_flight_output
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_rotation, only: cross
  use fsi_surface, only: surface_t
  use fsi_wing_sides, only: wing_sides_t
  use io_attributes, only: put_attribute
  use io_datasets, only: write_integers, write_slab
  use io_fields, only: field_file
  use io_hdf5, only: hdf5_file_t
  use io_xdmf, only: xdmf_index_t
  use parallel_world, only: world_t
  use simulation_body_output, only: body_output_t
  use simulation_opening, only: opening_t
  implicit none
  private
  public :: flight_output_t

  !> Writes the surfaces of the body and of all wings.
  type :: flight_output_t
    private
    type(world_t) :: world
    type(xdmf_index_t), allocatable :: index(:)
    type(body_output_t) :: body
  contains
    procedure :: init => output_init
    procedure :: write => output_write
  end type flight_output_t

contains

  !> Opens the indices of the run, one for each wing and one for the body. Collective.
  subroutine output_init(self, opening, wings)
    class(flight_output_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    type(flapping_wings_t), intent(in) :: wings
    integer :: i
    self%world = opening%world
    call self%body%init(opening, wings)
    allocate (self%index(size(wings%surfaces)))
    do i = 1, size(wings%surfaces)
      call self%index(i)%open(opening%world, opening%name//'_'//trim(wings%params%wings(i)%side)//'.xmf', opening%failure, &
                              opening%restart_time)
    end do
  end subroutine output_init

  !> Writes the body and all wings under one label. With `coupler`, which knows the wings that bend, it also writes what bends them.
  !> Root writes; if it fails, all ranks fail. Collective.
  subroutine output_write(self, wings, label, note, failure, coupler, sides)
    class(flight_output_t), intent(inout) :: self
    type(flapping_wings_t), intent(in) :: wings
    character(*), intent(in) :: label
    character(*), intent(in) :: note !< on the units, stored unless it is empty
    type(failure_t), intent(inout) :: failure
    type(coupler_t), intent(in), optional :: coupler !< must have sampled the loads at the present positions of the wings
    type(wing_sides_t), intent(in), optional :: sides !< must have sampled the flow there as well
    character(:), allocatable :: path
    type(failure_t) :: writing
    character(12), allocatable :: vectors(:)
    character(16), allocatable :: cells(:)
    integer :: i
    call self%body%write(wings, label, note, failure)
    do i = 1, size(wings%surfaces)
      if (failure%failed) return
      path = field_file('wing_'//trim(wings%params%wings(i)%side), label)
      if (self%world%is_root) call write_surface(wings, i, path, note, writing, coupler, sides)
      if (self%world%max_integer(merge(1, 0, writing%failed)) > 0) call failure%raise(path//': cannot be written')
      associate (n => size(wings%surfaces(i)%points, 2), m => size(wings%surfaces(i)%triangles, 2))
        vectors = [character(12) :: 'velocities']
        if (present(coupler)) vectors = [character(12) :: 'velocities', 'displacement', 'load']
        allocate (cells(0))
        if (present(coupler)) cells = [character(16) :: 'pressure_jump']
        if (present(sides)) cells = [character(16) :: cells, 'pressure_dorsal', 'pressure_ventral']
        call self%index(i)%add_surface(wings%time, label, path, [n, m], vectors, failure, cells)
        deallocate (cells)
      end associate
    end do
  end subroutine output_write

  !> Writes the surface of wing `i` at the present time as an HDF5 file, with bending and loads where they are given.
  subroutine write_surface(wings, i, path, note, failure, coupler, sides)
    type(flapping_wings_t), intent(in) :: wings
    integer, intent(in) :: i
    character(*), intent(in) :: path, note
    type(failure_t), intent(inout) :: failure
    type(coupler_t), intent(in), optional :: coupler
    type(wing_sides_t), intent(in), optional :: sides
    type(hdf5_file_t) :: file
    associate (surface => wings%surfaces(i), pose => wings%poses(i))
      call file%create_serial(path//'.part', failure)
      call put_vectors(file, 'points', 'L', surface%points, failure)
      call put_vectors(file, 'velocities', 'L/T', surface%velocities, failure)
      call write_integers(file, 'triangles', int(shape(surface%triangles), i8), [surface%triangles - 1], failure)
      if (present(coupler)) call put_bending(file, wings, i, coupler, failure)
      if (present(sides)) call put_sides()
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

    !> Writes pressure and traction on the two sides of the wing.
    subroutine put_sides()
      character(7), parameter :: NAMES(2) = [character(7) :: 'dorsal', 'ventral']
      character(:), allocatable :: name
      logical :: is_dorsal
      integer :: side
      is_dorsal = wings%params%wings(i)%mount%dorsal_sign() > 0
      associate (loads => sides%wings(i))
        do side = 1, 2
          name = trim(NAMES(merge(side, 3 - side, is_dorsal)))
          associate (p => loads%pressure(:, side))
            call write_slab(file, 'pressure_'//name, shape(p, kind=i8), [0_i8], shape(p, kind=i8), p, .false., failure)
            call put_attribute(file, 'pressure_'//name, 'units', 'rho L^2/T^2', failure)
            call put_vectors(file, 'traction_'//name, 'rho L^2/T^2', loads%traction(:, :, side), failure)
          end associate
        end do
        call put_attribute(file, '/', 'side_distance', sides%distance, failure)
      end associate
    end subroutine put_sides
  end subroutine write_surface

  !> Writes the displacements, loads and pressure jumps of wing i, which bends.
  subroutine put_bending(file, wings, i, coupler, failure)
    type(hdf5_file_t), intent(in) :: file
    type(flapping_wings_t), intent(in) :: wings
    integer, intent(in) :: i
    type(coupler_t), intent(in) :: coupler
    type(failure_t), intent(inout) :: failure
    real(rp) :: force(3, size(wings%surfaces(i)%points, 2))
    real(rp) :: displacement(3, size(wings%surfaces(i)%points, 2)), areas(size(wings%surfaces(i)%points, 2))
    integer :: p
    force = coupler%surfaces(i)%force
    areas = point_areas(wings%surfaces(i))
    do p = 1, size(areas)
      displacement(:, p) = wings%poses(i)%vector_to_space(wings%deformation(i)%u(:, p))
      if (areas(p) > 0) force(:, p) = force(:, p)/areas(p)
    end do
    call put_vectors(file, 'displacement', 'L', displacement, failure)
    call put_vectors(file, 'load', 'rho L^2/T^2', force, failure)
    associate (jump => coupler%surfaces(i)%jump)
      call write_slab(file, 'pressure_jump', shape(jump, kind=i8), [0_i8], shape(jump, kind=i8), jump, .false., failure)
    end associate
    call put_attribute(file, 'pressure_jump', 'units', 'rho L^2/T^2', failure)
  end subroutine put_bending

  !> Writes vectors(3, :) with their units.
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

  !> Returns for each point a third of the area [L^2] of the triangles around it.
  pure function point_areas(surface) result(areas)
    type(surface_t), intent(in) :: surface
    real(rp) :: areas(size(surface%points, 2))
    integer :: t, k
    areas = 0
    do t = 1, size(surface%triangles, 2)
      associate (a => surface%points(:, surface%triangles(1, t)), b => surface%points(:, surface%triangles(2, t)), &
                 c => surface%points(:, surface%triangles(3, t)))
        do k = 1, 3
          associate (p => surface%triangles(k, t))
            areas(p) = areas(p) + norm2(cross(b - a, c - a))/6
          end associate
        end do
      end associate
    end do
  end function point_areas
end module simulation_flight_output
