! SPDX-License-Identifier: GPL-3.0-or-later
!> Does the stages of the built-in pencil transform: buffers, plans, and the copies between them.
!>
!> Layout of the exchange buffers, fastest index first. Between sticks and planes (column exchange):
!> one block per column rank, (sticks of the owner of the sticks, planes of the owner of the planes,
!> fields). Between planes and lines (row exchange, only with more than one row): one block per row
!> rank, (kx of the owner of the plane part, y of the owner of the lines, planes, fields).
module spectral_pencil_stages
  use, intrinsic :: iso_c_binding, only: c_ptr, c_size_t, c_null_ptr, c_int
  use base_kinds, only: rp
  use parallel_block, only: block_t, split_evenly
  use spectral_fftw, only: alloc_complex, alloc_real, free_buffer, plan_t, plan_lines, plan_columns, plan_c2r, &
                           plan_r2c, execute_complex, execute_c2r, execute_r2c, free_plan
  use spectral_grid, only: grid_t
  use spectral_runs, only: runs_t
  use spectral_sticks, only: sticks_t
  implicit none
  private
  public :: stages_t, STICK_BATCH

  integer, parameter :: STICK_BATCH = 16 !< sticks per z transform: long pieces of the buffers, work in the L2 cache

  !> Small in-cache work buffers with their plans, and the geometry of the exchanges.
  type :: stages_t
    integer :: nx = 1, ny = 1, nz = 1
    integer :: n_kx = 0            !< kx columns of this row
    integer :: n_half = 1          !< nx/2+1
    integer :: line_batch = 1      !< lines per x transform
    integer :: rows = 1, columns = 1, row = 0
    integer, allocatable :: z_start(:), z_count(:)   !< (0:columns-1) planes of each column in the chosen part
    integer, allocatable :: y_start(:), y_count(:)   !< (0:rows-1) lines of each row
    integer, allocatable :: kx_count(:)              !< (0:rows-1) kx columns of each row
    complex(rp), pointer, contiguous :: z_work(:) => null()  !< (nz, STICK_BATCH)
    complex(rp), pointer, contiguous :: half(:) => null()    !< (n_half, line_batch)
    type(c_ptr), private :: z_handle = c_null_ptr, half_handle = c_null_ptr
    type(runs_t) :: runs
    type(plan_t), private :: z_backward, z_forward, y_backward, y_forward, x_backward, x_forward
  contains
    procedure :: init => stages_init
    procedure :: choose_part => stages_choose_part
    procedure :: free => stages_free
    procedure :: stick_to_buffer, buffer_to_stick
    procedure :: buffer_to_plane, curl_to_plane, plane_to_buffer
    procedure :: plane_to_rows, rows_to_plane
    procedure :: plane_to_lines, lines_to_plane, rows_to_lines, lines_to_rows
    procedure :: clear_rows
  end type stages_t

contains

  !> Makes buffers and plans for this rank's part of the grid. Not collective.
  subroutine stages_init(self, grid, sticks, block, rows, columns, row, flag)
    class(stages_t), intent(inout) :: self
    type(grid_t), intent(in) :: grid
    type(sticks_t), intent(in) :: sticks
    type(block_t), intent(in) :: block
    integer, intent(in) :: rows, columns, row
    integer(c_int), intent(in) :: flag
    complex(rp), pointer, contiguous :: plane(:)
    real(rp), pointer, contiguous :: line(:)
    type(c_ptr) :: plane_handle, line_handle
    integer :: i

    self%nx = grid%n(1)
    self%ny = grid%n(2)
    self%nz = grid%n(3)
    self%rows = rows
    self%columns = columns
    self%row = row
    self%n_kx = sticks%n_row_kx
    self%n_half = self%nx/2 + 1
    ! About 2000 points per batch: input and output of a nine-field product stay in the L2 cache. The number must not depend on the
    ! rank, because plans and the last bits of results would then depend on it, too.
    self%line_batch = max(1, min((self%ny + rows - 1)/rows, max(4, 2048/self%nx)))
    allocate (self%z_start(0:columns - 1), self%z_count(0:columns - 1))
    allocate (self%y_start(0:rows - 1), self%y_count(0:rows - 1), self%kx_count(0:rows - 1))
    call self%choose_part(1, 1)
    do i = 0, rows - 1
      call split_evenly(block%n(2), rows, i, self%y_start(i), self%y_count(i))
      self%kx_count(i) = (sticks%n_jx - 1 - i)/rows + 1
      if (i >= sticks%n_jx) self%kx_count(i) = 0
    end do

    call self%runs%init(sticks, columns)
    call alloc_complex(int(self%nz, c_size_t)*STICK_BATCH, self%z_handle, self%z_work)
    call alloc_complex(int(self%n_half, c_size_t)*self%line_batch, self%half_handle, self%half)
    call plan_lines(self%z_backward, self%nz, STICK_BATCH, self%z_work, 1, flag)
    call plan_lines(self%z_forward, self%nz, STICK_BATCH, self%z_work, -1, flag)
    ! The caller provides planes and lines; these two arrays serve the planner only.
    call alloc_complex(int(self%n_kx, c_size_t)*self%ny, plane_handle, plane)
    call alloc_real(int(self%nx, c_size_t)*self%line_batch, line_handle, line)
    call plan_columns(self%y_backward, self%n_kx, self%ny, plane, 1, flag)
    call plan_columns(self%y_forward, self%n_kx, self%ny, plane, -1, flag)
    call plan_c2r(self%x_backward, self%nx, self%line_batch, self%half, line, flag)
    call plan_r2c(self%x_forward, self%nx, self%line_batch, line, self%half, flag)
    call free_buffer(plane_handle)
    call free_buffer(line_handle)
    ! FFTW_MEASURE overwrites the buffers; a partly filled batch must not transform undefined numbers.
    self%z_work = 0
    self%half = 0
  end subroutine stages_init

  !> Makes all later copies use only part `part` of `parts` of the planes of each column.
  pure subroutine stages_choose_part(self, part, parts)
    class(stages_t), intent(inout) :: self
    integer, intent(in) :: part, parts
    integer :: q, start
    do q = 0, self%columns - 1
      call split_evenly(self%nz, self%columns, q, self%z_start(q), self%z_count(q))
      call split_evenly(self%z_count(q), parts, part - 1, start, self%z_count(q))
      self%z_start(q) = self%z_start(q) + start
    end do
  end subroutine stages_choose_part

  !> Releases buffers and plans.
  subroutine stages_free(self)
    class(stages_t), intent(inout) :: self
    call free_plan(self%z_backward)
    call free_plan(self%z_forward)
    call free_plan(self%y_backward)
    call free_plan(self%y_forward)
    call free_plan(self%x_backward)
    call free_plan(self%x_forward)
    call free_buffer(self%z_handle)
    call free_buffer(self%half_handle)
  end subroutine stages_free

  !> Transforms `count` sticks from local stick `first` on backward in z, and writes them to the column-exchange buffer as field
  !> `f` of `n_fields`. `modes` is (nkz, >= count), retained kz only.
  subroutine stick_to_buffer(self, modes, nkz, first, count, n_sticks, f, n_fields, buffer)
    class(stages_t), intent(inout) :: self
    integer, intent(in) :: nkz, first, count, n_sticks, f, n_fields
    complex(rp), contiguous, intent(in) :: modes(:, :)
    complex(rp), contiguous, intent(inout) :: buffer(:)
    call expand_modes(self%nz, nkz, count, modes, self%z_work)
    call execute_complex(self%z_backward, self%z_work)
    call scatter_columns(self, first, count, n_sticks, f, n_fields, buffer)
  end subroutine stick_to_buffer

  !> Zero-pads retained kz to full lines; unused lines of the batch are left as they are.
  pure subroutine expand_modes(nz, nkz, count, modes, work)
    integer, intent(in) :: nz, nkz, count
    complex(rp), intent(in) :: modes(nkz, count)
    complex(rp), intent(inout) :: work(nz, STICK_BATCH)
    integer :: s, n_low
    n_low = (nkz + 1)/2
    do s = 1, count
      work(1:n_low, s) = modes(1:n_low, s)
      work(n_low + 1:nz - (nkz - n_low), s) = 0
      work(nz - (nkz - n_low) + 1:nz, s) = modes(n_low + 1:nkz, s)
    end do
  end subroutine expand_modes

  !> Copies z_work(nz, batch) to blocks (sticks, planes, fields) per column rank.
  subroutine scatter_columns(self, first, count, n_sticks, f, n_fields, buffer)
    class(stages_t), intent(in) :: self
    integer, intent(in) :: first, count, n_sticks, f, n_fields
    complex(rp), contiguous, intent(inout) :: buffer(:)
    integer :: q, z, s, base
    base = 0
    do q = 0, self%columns - 1
      associate (nzq => self%z_count(q), z0 => self%z_start(q))
        do z = 1, nzq
          do s = 1, count
            buffer(base + first - 1 + s + n_sticks*(z - 1 + nzq*(f - 1))) = self%z_work(z0 + z + self%nz*(s - 1))
          end do
        end do
        base = base + n_sticks*nzq*n_fields
      end associate
    end do
  end subroutine scatter_columns

  !> Gathers sticks first .. first+count-1 of field `f` from the buffer, transforms them forward in z and returns the retained kz,
  !> multiplied by `scale`, in modes(nkz, 1:count).
  subroutine buffer_to_stick(self, buffer, nkz, first, count, n_sticks, f, n_fields, scale, modes)
    class(stages_t), intent(inout) :: self
    integer, intent(in) :: nkz, first, count, n_sticks, f, n_fields
    complex(rp), contiguous, intent(in) :: buffer(:)
    real(rp), intent(in) :: scale
    complex(rp), contiguous, intent(inout) :: modes(:, :)
    integer :: q, z, s, base
    base = 0
    if (sum(self%z_count) < self%nz) self%z_work(1:self%nz*count) = 0 ! planes outside of the chosen part
    do q = 0, self%columns - 1
      associate (nzq => self%z_count(q), z0 => self%z_start(q))
        do z = 1, nzq
          do s = 1, count
            self%z_work(z0 + z + self%nz*(s - 1)) = buffer(base + first - 1 + s + n_sticks*(z - 1 + nzq*(f - 1)))
          end do
        end do
        base = base + n_sticks*nzq*n_fields
      end associate
    end do
    call execute_complex(self%z_forward, self%z_work)
    call shrink_modes(self%nz, nkz, count, scale, self%z_work, modes)
  end subroutine buffer_to_stick

  !> Keeps the retained kz of full lines.
  pure subroutine shrink_modes(nz, nkz, count, scale, work, modes)
    integer, intent(in) :: nz, nkz, count
    real(rp), intent(in) :: scale
    complex(rp), intent(in) :: work(nz, STICK_BATCH)
    complex(rp), intent(inout) :: modes(nkz, count)
    integer :: s, n_low
    n_low = (nkz + 1)/2
    do s = 1, count
      modes(1:n_low, s) = scale*work(1:n_low, s)
      modes(n_low + 1:nkz, s) = scale*work(nz - (nkz - n_low) + 1:nz, s)
    end do
  end subroutine shrink_modes

  !> Assembles plane `z` (local) of field `f` from the column-exchange buffer and transforms it to
  !> physical y, in plane(n_kx, ny), which FFTW aligns or Fortran allocates.
  subroutine buffer_to_plane(self, buffer, z, n_planes, f, n_fields, plane)
    class(stages_t), intent(in) :: self
    complex(rp), contiguous, intent(in) :: buffer(:)
    integer, intent(in) :: z, n_planes, f, n_fields
    complex(rp), contiguous, intent(inout) :: plane(:)
    call self%runs%fill_plane(buffer, z, n_planes, f, n_fields, plane)
    call execute_complex(self%y_backward, plane)
  end subroutine buffer_to_plane

  !> Does the same for the field i (kx f2 - ky f1), made of the fields 1 and 2 of the buffer.
  subroutine curl_to_plane(self, buffer, z, n_planes, n_fields, plane)
    class(stages_t), intent(in) :: self
    complex(rp), contiguous, intent(in) :: buffer(:)
    integer, intent(in) :: z, n_planes, n_fields
    complex(rp), contiguous, intent(inout) :: plane(:)
    call self%runs%fill_curl(buffer, z, n_planes, n_fields, plane)
    call execute_complex(self%y_backward, plane)
  end subroutine curl_to_plane

  !> Transforms `plane` forward in y and puts its sticks into the column-exchange buffer.
  subroutine plane_to_buffer(self, plane, buffer, z, n_planes, f, n_fields)
    class(stages_t), intent(in) :: self
    complex(rp), contiguous, intent(inout) :: plane(:)
    complex(rp), contiguous, intent(inout) :: buffer(:)
    integer, intent(in) :: z, n_planes, f, n_fields
    call execute_complex(self%y_forward, plane)
    call self%runs%take_plane(plane, buffer, z, n_planes, f, n_fields)
  end subroutine plane_to_buffer

  !> Puts zeros where `lines_to_rows` would put lines first .. first+count-1.
  pure subroutine clear_rows(self, buffer, first, count, z, n_planes, f, n_fields)
    class(stages_t), intent(in) :: self
    complex(rp), contiguous, intent(inout) :: buffer(:)
    integer, intent(in) :: first, count, z, n_planes, f, n_fields
    integer :: p, base, to, ny
    ny = self%y_count(self%row)
    base = 0
    do p = 0, self%rows - 1
      to = base + self%kx_count(p)*(first - 1 + ny*(z - 1 + n_planes*(f - 1)))
      buffer(to + 1:to + self%kx_count(p)*count) = 0
      base = base + self%kx_count(p)*ny*n_planes*n_fields
    end do
  end subroutine clear_rows

  !> Copies plane(n_kx, ny) to the blocks per row rank of the row-exchange buffer.
  subroutine plane_to_rows(self, plane, buffer, z, n_planes, f, n_fields)
    class(stages_t), intent(in) :: self
    complex(rp), contiguous, intent(in) :: plane(:)
    complex(rp), contiguous, intent(inout) :: buffer(:)
    integer, intent(in) :: z, n_planes, f, n_fields
    integer :: p, n, from, to
    do p = 0, self%rows - 1
      n = self%n_kx*self%y_count(p)
      from = self%n_kx*self%y_start(p)
      to = from*n_planes*n_fields + n*(z - 1 + n_planes*(f - 1))
      buffer(to + 1:to + n) = plane(from + 1:from + n)
    end do
  end subroutine plane_to_rows

  !> Does the reverse of `plane_to_rows`.
  subroutine rows_to_plane(self, buffer, z, n_planes, f, n_fields, plane)
    class(stages_t), intent(in) :: self
    complex(rp), contiguous, intent(in) :: buffer(:)
    integer, intent(in) :: z, n_planes, f, n_fields
    complex(rp), contiguous, intent(inout) :: plane(:)
    integer :: p, n, from, to
    do p = 0, self%rows - 1
      n = self%n_kx*self%y_count(p)
      to = self%n_kx*self%y_start(p)
      from = to*n_planes*n_fields + n*(z - 1 + n_planes*(f - 1))
      plane(to + 1:to + n) = buffer(from + 1:from + n)
    end do
  end subroutine rows_to_plane

  !> Transforms lines first .. first+count-1 of `plane` (n_kx, ny) backward in x into lines(nx, line_batch), with one row of
  !> ranks. Lines beyond `count` are undefined.
  subroutine plane_to_lines(self, plane, first, count, lines)
    class(stages_t), intent(inout) :: self
    complex(rp), contiguous, intent(in) :: plane(:)
    integer, intent(in) :: first, count
    real(rp), contiguous, intent(inout) :: lines(:, :)
    integer :: l, from, to
    do l = 1, count
      from = self%n_kx*(first + l - 2)
      to = self%n_half*(l - 1)
      self%half(to + 1:to + self%n_kx) = plane(from + 1:from + self%n_kx)
      self%half(to + self%n_kx + 1:to + self%n_half) = 0
    end do
    call execute_c2r(self%x_backward, self%half, lines)
  end subroutine plane_to_lines

  !> Transforms `count` of lines(nx, line_batch) forward in x into lines first .. first+count-1 of `plane`. All must be finite.
  subroutine lines_to_plane(self, lines, plane, first, count)
    class(stages_t), intent(inout) :: self
    real(rp), contiguous, intent(inout) :: lines(:, :)
    complex(rp), contiguous, intent(inout) :: plane(:)
    integer, intent(in) :: first, count
    integer :: l, from, to
    call execute_r2c(self%x_forward, lines, self%half)
    do l = 1, count
      to = self%n_kx*(first + l - 2)
      from = self%n_half*(l - 1)
      plane(to + 1:to + self%n_kx) = self%half(from + 1:from + self%n_kx)
    end do
  end subroutine lines_to_plane

  !> Transforms lines first .. first+count-1 of plane `z`, field `f`, backward in x from the blocks of all row ranks into `lines`,
  !> as `plane_to_lines` does.
  subroutine rows_to_lines(self, buffer, first, count, z, n_planes, f, n_fields, lines)
    class(stages_t), intent(inout) :: self
    complex(rp), contiguous, intent(in) :: buffer(:)
    integer, intent(in) :: first, count, z, n_planes, f, n_fields
    real(rp), contiguous, intent(inout) :: lines(:, :)
    integer :: l, p, i, base, from, to, ny
    ny = self%y_count(self%row)
    do l = 1, count
      to = self%n_half*(l - 1)
      self%half(to + sum(self%kx_count) + 1:to + self%n_half) = 0
      base = 0
      do p = 0, self%rows - 1
        from = base + self%kx_count(p)*(first + l - 2 + ny*(z - 1 + n_planes*(f - 1)))
        do i = 1, self%kx_count(p)
          self%half(to + 1 + p + self%rows*(i - 1)) = buffer(from + i)
        end do
        base = base + self%kx_count(p)*ny*n_planes*n_fields
      end do
    end do
    call execute_c2r(self%x_backward, self%half, lines)
  end subroutine rows_to_lines

  !> Transforms `lines` forward in x into the blocks of all row ranks.
  subroutine lines_to_rows(self, lines, buffer, first, count, z, n_planes, f, n_fields)
    class(stages_t), intent(inout) :: self
    real(rp), contiguous, intent(inout) :: lines(:, :)
    complex(rp), contiguous, intent(inout) :: buffer(:)
    integer, intent(in) :: first, count, z, n_planes, f, n_fields
    integer :: l, p, i, base, from, to, ny
    ny = self%y_count(self%row)
    call execute_r2c(self%x_forward, lines, self%half)
    do l = 1, count
      from = self%n_half*(l - 1)
      base = 0
      do p = 0, self%rows - 1
        to = base + self%kx_count(p)*(first + l - 2 + ny*(z - 1 + n_planes*(f - 1)))
        do i = 1, self%kx_count(p)
          buffer(to + i) = self%half(from + 1 + p + self%rows*(i - 1))
        end do
        base = base + self%kx_count(p)*ny*n_planes*n_fields
      end do
    end do
  end subroutine lines_to_rows
end module spectral_pencil_stages
