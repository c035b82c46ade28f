! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the built-in transforms: FFTW in cache and MPI pencils, without the parts of the spectrum that are not needed.
!>
!> Only sticks inside the truncation are exchanged between ranks, and only retained kx are exchanged between planes and lines. The
!> pipeline is fused: products are computed on batches of lines while they are in cache, and physical fields are never stored. Two
!> buffers serve all exchanges, from one to the other and back, because products replace the fields from which they were computed.
!> Operation counts and measurements: docs/theory/transforms.md.
module spectral_pencil
  use, intrinsic :: iso_c_binding, only: c_size_t
  use base_errors, only: require
  use base_kinds, only: rp
  use mpi_f08, only: MPI_Comm, MPI_Comm_split, MPI_Comm_free, MPI_COMM_NULL, operator(/=)
  use parallel_block, only: split_evenly
  use parallel_exchange, only: exchange
  use parallel_world, only: world_t
  use spectral_buffer, only: buffer_t
  use spectral_copy, only: copy_backward, copy_forward
  use spectral_fftw, only: effort_flag, learn_wisdom, wisdom_text, PLAN_MEASURE
  use spectral_grid, only: grid_t
  use spectral_pencil_planes, only: is_wanted, leave_out_planes
  use spectral_pencil_stages, only: stages_t, STICK_BATCH
  use spectral_sticks, only: make_sticks, process_grid
  use spectral_transform, only: transform_t, kernels_t
  implicit none
  private
  public :: pencil_t

  type, extends(transform_t) :: pencil_t
    type(stages_t), private :: stages
    type(MPI_Comm), private :: row_comm = MPI_COMM_NULL, column_comm = MPI_COMM_NULL
    !> `near` holds sticks, and planes on their way to and from lines; `far` holds planes, and lines. Without columns sticks are
    !> copied directly to planes.
    type(buffer_t), private :: near, far
    integer, private :: n_fields = 0     !< of the running pipeline: room for so many fields lies between blocks
    integer, private :: z_first = 0, n_planes = 0 !< number of planes before the present part, and in it
    complex(rp), allocatable, private :: planes(:, :)  !< (n_kx*ny, fields) one plane of every field
    complex(rp), allocatable, private :: modes(:, :, :) !< (nkz, STICK_BATCH, fields)
    real(rp), allocatable, private :: fields_in(:, :, :), fields_out(:, :, :) !< (nx, lines, fields)
  contains
    procedure :: init => pencil_init
    procedure :: free => pencil_free
    procedure :: to_points => pencil_to_points
    procedure :: to_points_part => pencil_to_points_part
    procedure :: to_modes => pencil_to_modes
    procedure :: most_parts => pencil_most_parts
    procedure :: release => pencil_release
    procedure :: backward => pencil_backward
    procedure :: forward => pencil_forward
    procedure :: memory_bytes => pencil_memory_bytes
  end type pencil_t

contains

  !> Prepares transforms of up to `max_in` fields backward and `max_out` fields forward at once. Requires an existing process grid
  !> (`process_grid`). Collective.
  subroutine pencil_init(self, world, grid, dealias, wanted_rows, effort, max_in, max_out)
    class(pencil_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: dealias !< DEALIAS_* of spectral_sticks
    integer, intent(in) :: wanted_rows  !< rows of the process grid, 0 for the best
    integer, intent(in) :: effort  !< PLAN_ESTIMATE or PLAN_MEASURE of spectral_fftw
    integer, intent(in) :: max_in, max_out
    integer :: row, column, lines
    logical :: possible
    self%world = world
    self%grid = grid
    call process_grid(world%size, grid%n, wanted_rows, self%rows, self%columns, possible)
    call require(possible, 'pencil_t: no process grid for this number of ranks')
    row = mod(world%rank, self%rows)
    column = world%rank/self%rows
    ! Ranks of a row are neighbours, so that the larger exchange stays inside a node.
    call MPI_Comm_split(world%comm, column, row, self%row_comm)
    call MPI_Comm_split(world%comm, row, column, self%column_comm)

    self%sticks = make_sticks(grid, dealias, self%rows, self%columns, row, column)
    self%block%n = grid%n
    self%block%start(1) = 0
    self%block%count(1) = grid%n(1)
    call split_evenly(grid%n(2), self%rows, row, self%block%start(2), self%block%count(2))
    call split_evenly(grid%n(3), self%columns, column, self%block%start(3), self%block%count(3))
    ! Measured plans differ between measurements. Ranks of a row have the same sizes, and there are at most two kinds of rows. The
    ! first and the last row measure, and all other rows take their plans, so that equal sizes have equal plans.
    if (effort == PLAN_MEASURE) then
      call make_plans(self, row, effort, 0)
      if (self%rows > 1) call make_plans(self, row, effort, self%rows - 1)
      if (world%rank /= 0 .and. world%rank /= self%rows - 1) &
        call self%stages%init(grid, self%sticks, self%block, self%rows, self%columns, row, effort_flag(effort))
    else
      call self%stages%init(grid, self%sticks, self%block, self%rows, self%columns, row, effort_flag(effort))
    end if

    allocate (self%planes(self%stages%n_kx*grid%n(2), max(max_in, max_out)))
    allocate (self%modes(self%sticks%nkz, STICK_BATCH, max(max_in, max_out)))
    ! The number of lines is even: FFTW's plans need fields that begin at the address of a complex number.
    lines = self%stages%line_batch + mod(self%stages%line_batch, 2)
    allocate (self%fields_in(grid%n(1), lines, max_in), self%fields_out(grid%n(1), lines, max_out))
    self%modes = 0
    self%fields_in = 0
    self%fields_out = 0
  end subroutine pencil_init

  !> Makes the plans of rank `planning_rank` and gives its wisdom to all others. Collective.
  subroutine make_plans(self, row, effort, planning_rank)
    class(pencil_t), intent(inout) :: self
    integer, intent(in) :: row, effort, planning_rank
    character(:), allocatable :: learnt
    if (self%world%rank == planning_rank) then
      call self%stages%init(self%grid, self%sticks, self%block, self%rows, self%columns, row, effort_flag(effort))
      learnt = wisdom_text()
    end if
    call self%world%broadcast_text(learnt, planning_rank)
    call learn_wisdom(learnt)
  end subroutine make_plans

  !> Releases plans, buffers and communicators. Collective.
  subroutine pencil_free(self)
    class(pencil_t), intent(inout) :: self
    call self%stages%free()
    call self%release()
    if (self%row_comm /= MPI_COMM_NULL) call MPI_Comm_free(self%row_comm)
    if (self%column_comm /= MPI_COMM_NULL) call MPI_Comm_free(self%column_comm)
  end subroutine pencil_free

  !> Releases the exchange buffers.
  subroutine pencil_release(self)
    class(pencil_t), intent(inout) :: self
    call self%near%release()
    call self%far%release()
  end subroutine pencil_release

  !> Returns the bytes of this rank's exchange buffers.
  pure real(rp) function pencil_memory_bytes(self) result(bytes)
    class(pencil_t), intent(in) :: self
    bytes = self%near%bytes() + self%far%bytes()
  end function pencil_memory_bytes

  !> Runs the first part of the fused pipeline; see `spectral_transform` for the contract. Collective.
  subroutine pencil_to_points(self, kernels)
    class(pencil_t), intent(inout) :: self
    class(kernels_t), intent(inout) :: kernels
    call self%to_points_part(kernels, 1, 1)
  end subroutine pencil_to_points

  !> See `spectral_transform`. The inverse transform in z is repeated for every part. Collective.
  subroutine pencil_to_points_part(self, kernels, part, parts)
    class(pencil_t), intent(inout) :: self
    class(kernels_t), intent(inout) :: kernels
    integer, intent(in) :: part, parts
    integer :: z, column
    call require(kernels%n_in <= size(self%fields_in, 3) .and. kernels%n_out <= size(self%fields_out, 3), &
                 'pencil_t: more fields than the transform was made for')
    call require(parts == 1 .or. (parts <= self%most_parts() .and. kernels%n_out == 0), &
                 'pencil_t: parts have a plane of every rank, and no output')
    kernels%fill_curl = .false.
    self%n_fields = max(kernels%n_in, kernels%n_out)
    ! Lines have the curl, too; the buffers need no room for it if lines stay on their rank.
    if (self%rows == 1) self%n_fields = max(kernels%place_of(kernels%n_in), kernels%n_out)
    call self%stages%choose_part(part, parts)
    column = self%world%rank/self%rows
    if (parts == 1) call leave_out_planes(self%world, self%block, kernels, self%stages, column)
    self%z_first = self%stages%z_start(column) - self%block%start(3)
    self%n_planes = self%stages%z_count(column)
    call make_room(self)
    if (kernels%n_in > 0) call sticks_to_planes(self, kernels)
    if (self%rows == 1) then
      do z = 1, self%n_planes
        call slab_plane(self, kernels, z)
      end do
    else
      if (kernels%n_in > 0) call planes_to_lines_exchange(self, kernels)
      do z = 1, self%n_planes
        call pencil_lines(self, kernels, z)
      end do
      if (kernels%n_out > 0) call lines_to_planes_exchange(self, kernels%n_out)
    end if
  end subroutine pencil_to_points_part

  !> Returns the least number of planes that a rank has.
  pure integer function pencil_most_parts(self) result(most)
    class(pencil_t), intent(in) :: self
    most = self%grid%n(3)/self%columns
  end function pencil_most_parts

  !> Makes the buffers for the pipeline that begins.
  subroutine make_room(self)
    class(pencil_t), intent(inout) :: self
    integer(c_size_t) :: near, far
    near = 0
    if (self%columns > 1) near = int(self%sticks%n, c_size_t)*sum(self%stages%z_count)
    if (self%rows > 1) near = max(near, int(self%stages%n_kx, c_size_t)*self%grid%n(2)*self%n_planes)
    far = int(self%sticks%n_row_sticks, c_size_t)*self%n_planes
    if (self%rows > 1) far = max(far, int(self%sticks%n_jx, c_size_t)*self%block%count(2)*self%n_planes)
    call self%near%grow(near*self%n_fields)
    call self%far%grow(far*self%n_fields)
  end subroutine make_room

  !> Does spectral in, inverse z, column exchange.
  subroutine sticks_to_planes(self, kernels)
    class(pencil_t), intent(inout) :: self
    class(kernels_t), intent(inout) :: kernels
    complex(rp), pointer, contiguous :: sticks_side(:)
    integer :: first, count, f
    sticks_side => self%far%data
    if (self%columns > 1) sticks_side => self%near%data
    do first = 1, self%sticks%n, STICK_BATCH
      count = min(STICK_BATCH, self%sticks%n - first + 1)
      call kernels%spectral_in(first, count, self%modes(:, :, 1:kernels%n_in))
      do f = 1, kernels%n_in
        if (f == kernels%curl) cycle
        call self%stages%stick_to_buffer(self%modes(:, :, f), self%sticks%nkz, first, count, self%sticks%n, &
                                         kernels%place_of(f), self%n_fields, sticks_side)
      end do
    end do
    if (self%columns > 1) &
      call column_exchange(self, kernels%place_of(kernels%n_in), self%near%data, self%far%data, .true.)
  end subroutine sticks_to_planes

  !> Runs the second part of the pipeline: column exchange, forward z, spectral out; see `spectral_transform`. Collective.
  subroutine pencil_to_modes(self, kernels)
    class(pencil_t), intent(inout) :: self
    class(kernels_t), intent(inout) :: kernels
    complex(rp), pointer, contiguous :: sticks_side(:)
    real(rp) :: scale
    integer :: first, count, f, n_fields
    n_fields = kernels%n_out
    scale = 1/product(real(self%grid%n, rp))
    sticks_side => self%far%data
    if (self%columns > 1) sticks_side => self%near%data
    if (self%columns > 1) call column_exchange(self, n_fields, self%far%data, self%near%data, .false.)
    do first = 1, self%sticks%n, STICK_BATCH
      count = min(STICK_BATCH, self%sticks%n - first + 1)
      do f = 1, n_fields
        call self%stages%buffer_to_stick(sticks_side, self%sticks%nkz, first, count, self%sticks%n, f, self%n_fields, &
                                         scale, self%modes(:, :, f))
      end do
      call kernels%spectral_out(first, count, self%modes(:, :, 1:n_fields))
    end do
  end subroutine pencil_to_modes

  !> Returns field `f` of plane `z` in physical y, from the buffer of the planes.
  subroutine field_to_plane(self, kernels, f, z, plane)
    class(pencil_t), intent(inout) :: self
    class(kernels_t), intent(in) :: kernels
    integer, intent(in) :: f, z
    complex(rp), contiguous, intent(inout) :: plane(:)
    if (f == kernels%curl) then
      call self%stages%curl_to_plane(self%far%data, z, self%n_planes, self%n_fields, plane)
    else
      call self%stages%buffer_to_plane(self%far%data, z, self%n_planes, kernels%place_of(f), self%n_fields, plane)
    end if
  end subroutine field_to_plane

  !> Processes one z plane with a single row of ranks: y and x transforms and products while all is in cache.
  subroutine slab_plane(self, kernels, z)
    class(pencil_t), intent(inout) :: self
    class(kernels_t), intent(inout) :: kernels
    integer, intent(in) :: z
    integer :: f, first, count, nz, n_in, n_out, local
    nz = self%n_planes
    local = self%z_first + z
    n_in = kernels%n_in
    n_out = kernels%n_out
    if (.not. is_wanted(kernels, 1, self%block%count(2), local)) then
      do f = 1, n_out
        call self%stages%runs%clear_plane(self%far%data, z, nz, f, self%n_fields)
      end do
      return
    end if
    do f = 1, n_in
      call field_to_plane(self, kernels, f, z, self%planes(:, f))
    end do
    do first = 1, self%block%count(2), self%stages%line_batch
      count = min(self%stages%line_batch, self%block%count(2) - first + 1)
      if (.not. is_wanted(kernels, first, count, local)) then
        self%planes(self%stages%n_kx*(first - 1) + 1:self%stages%n_kx*(first + count - 1), 1:n_out) = 0
        cycle
      end if
      do f = 1, n_in
        call self%stages%plane_to_lines(self%planes(:, f), first, count, self%fields_in(:, :, f))
      end do
      call kernels%product(first, count, local, self%fields_in(:, :, 1:n_in), self%fields_out(:, :, 1:n_out))
      do f = 1, n_out
        call self%stages%lines_to_plane(self%fields_out(:, :, f), self%planes(:, f), first, count)
      end do
    end do
    do f = 1, n_out
      call self%stages%plane_to_buffer(self%planes(:, f), self%far%data, z, nz, f, self%n_fields)
    end do
  end subroutine slab_plane

  !> Does the same for several rows: the lines come from the row-exchange buffers, and return to them.
  subroutine pencil_lines(self, kernels, z)
    class(pencil_t), intent(inout) :: self
    class(kernels_t), intent(inout) :: kernels
    integer, intent(in) :: z
    integer :: f, first, count, nz, n_in, n_out, local
    nz = self%n_planes
    local = self%z_first + z
    n_in = kernels%n_in
    n_out = kernels%n_out
    do first = 1, self%block%count(2), self%stages%line_batch
      count = min(self%stages%line_batch, self%block%count(2) - first + 1)
      if (.not. is_wanted(kernels, first, count, local)) then
        do f = 1, n_out
          call self%stages%clear_rows(self%far%data, first, count, z, nz, f, self%n_fields)
        end do
        cycle
      end if
      do f = 1, n_in
        call self%stages%rows_to_lines(self%far%data, first, count, z, nz, f, self%n_fields, self%fields_in(:, :, f))
      end do
      call kernels%product(first, count, local, self%fields_in(:, :, 1:n_in), self%fields_out(:, :, 1:n_out))
      do f = 1, n_out
        call self%stages%lines_to_rows(self%fields_out(:, :, f), self%far%data, first, count, z, nz, f, self%n_fields)
      end do
    end do
  end subroutine pencil_lines

  !> Does the y transforms of all planes, then the row exchange. Collective over the row.
  subroutine planes_to_lines_exchange(self, kernels)
    class(pencil_t), intent(inout) :: self
    class(kernels_t), intent(in) :: kernels
    integer :: f, z, nz
    nz = self%n_planes
    do f = 1, kernels%n_in
      do z = 1, nz
        call field_to_plane(self, kernels, f, z, self%planes(:, 1))
        call self%stages%plane_to_rows(self%planes(:, 1), self%near%data, z, nz, f, self%n_fields)
      end do
    end do
    call row_exchange(self, kernels%n_in, self%near%data, self%far%data, .true.)
  end subroutine planes_to_lines_exchange

  !> Does the row exchange back, then y transforms of all planes. Collective over the row.
  subroutine lines_to_planes_exchange(self, n_fields)
    class(pencil_t), intent(inout) :: self
    integer, intent(in) :: n_fields
    integer :: f, z, nz
    nz = self%n_planes
    call row_exchange(self, n_fields, self%far%data, self%near%data, .false.)
    do f = 1, n_fields
      do z = 1, nz
        call self%stages%rows_to_plane(self%near%data, z, nz, f, self%n_fields, self%planes(:, 1))
        call self%stages%plane_to_buffer(self%planes(:, 1), self%far%data, z, nz, f, self%n_fields)
      end do
    end do
  end subroutine lines_to_planes_exchange

  !> Exchanges sticks to planes (`to_planes`) or back, all fields in one message per pair. Collective over the column.
  subroutine column_exchange(self, n_fields, send, receive, to_planes)
    class(pencil_t), intent(inout) :: self
    integer, intent(in) :: n_fields
    complex(rp), contiguous, intent(in) :: send(:)
    complex(rp), contiguous, intent(inout) :: receive(:)
    logical, intent(in) :: to_planes
    integer :: stick_side(0:self%columns - 1), plane_side(0:self%columns - 1), q
    do q = 0, self%columns - 1
      stick_side(q) = self%sticks%n*self%stages%z_count(q)
      plane_side(q) = (self%sticks%part_start(q + 1) - self%sticks%part_start(q))*self%n_planes
    end do
    call exchange(self%column_comm, send, merge(stick_side, plane_side, to_planes), receive, &
                  merge(plane_side, stick_side, to_planes), n_fields, self%n_fields, self%traffic)
  end subroutine column_exchange

  !> Exchanges planes to lines (`to_lines`) or back. Collective over the row.
  subroutine row_exchange(self, n_fields, send, receive, to_lines)
    class(pencil_t), intent(inout) :: self
    integer, intent(in) :: n_fields
    complex(rp), contiguous, intent(in) :: send(:)
    complex(rp), contiguous, intent(inout) :: receive(:)
    logical, intent(in) :: to_lines
    integer :: plane_side(0:self%rows - 1), line_side(0:self%rows - 1)
    plane_side = self%stages%n_kx*self%stages%y_count*self%n_planes
    line_side = self%stages%kx_count*self%block%count(2)*self%n_planes
    call exchange(self%row_comm, send, merge(plane_side, line_side, to_lines), receive, &
                  merge(line_side, plane_side, to_lines), n_fields, self%n_fields, self%traffic)
  end subroutine row_exchange

  !> Transforms spectral(nkz, n, nf) to physical(nx, ny_local, nz_local, nf). Collective.
  subroutine pencil_backward(self, spectral, physical)
    class(pencil_t), intent(inout) :: self
    complex(rp), contiguous, target, intent(in) :: spectral(:, :, :)
    real(rp), contiguous, target, intent(inout) :: physical(:, :, :, :)
    call copy_backward(self, size(self%fields_in, 3), spectral, physical)
  end subroutine pencil_backward

  !> Transforms physical(nx, ny_local, nz_local, nf) to spectral(nkz, n, nf). Collective.
  subroutine pencil_forward(self, physical, spectral)
    class(pencil_t), intent(inout) :: self
    real(rp), contiguous, target, intent(in) :: physical(:, :, :, :)
    complex(rp), contiguous, target, intent(inout) :: spectral(:, :, :)
    call copy_forward(self, size(self%fields_out, 3), physical, spectral)
  end subroutine pencil_forward
end module spectral_pencil
