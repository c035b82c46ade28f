! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds sticks that are neighbours both in the column-exchange buffer and in a plane of kx and ky, so that copies go run by run.
!>
!> The buffer holds, for each column of ranks, (its sticks, planes, fields), fastest index first.
module spectral_runs
  use base_kinds, only: rp
  use spectral_sticks, only: sticks_t
  implicit none
  private
  public :: runs_t

  type :: runs_t
    private
    integer, allocatable :: place(:), count(:) !< (runs) first place in a plane (n_kx*ny), in increasing order, and length
    integer, allocatable :: part(:)            !< (0:columns) runs of all columns before this one
    integer, allocatable :: start(:)           !< (0:columns) sticks of all columns before this one
    real(rp), allocatable :: kx(:), ky(:)      !< (sticks of the row) wavenumbers
  contains
    procedure :: init => runs_init
    procedure :: fill_plane, fill_curl, take_plane, clear_plane
    procedure, private :: before
  end type runs_t

contains

  !> Finds the runs of this rank's row.
  subroutine runs_init(self, sticks, columns)
    class(runs_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    integer, intent(in) :: columns
    integer :: q, s, n
    logical :: begins
    allocate (self%place(sticks%n_row_sticks), self%count(sticks%n_row_sticks), self%part(0:columns), self%start(0:columns))
    self%start = sticks%part_start(0:columns)
    self%kx = sticks%row_kx
    self%ky = sticks%row_ky
    n = 0
    do q = 0, columns - 1
      self%part(q) = n
      do s = self%start(q) + 1, self%start(q + 1)
        begins = s == self%start(q) + 1
        if (.not. begins) begins = sticks%plane_index(s) /= sticks%plane_index(s - 1) + 1
        if (begins) then
          n = n + 1
          self%place(n) = sticks%plane_index(s)
          self%count(n) = 0
        end if
        self%count(n) = self%count(n) + 1
      end do
    end do
    self%part(columns) = n
    self%place = self%place(:n)
    self%count = self%count(:n)
  end subroutine runs_init

  !> Puts the sticks of plane `z` of field `f` of the buffer in their places, and zeros elsewhere.
  pure subroutine fill_plane(self, buffer, z, n_planes, f, n_fields, plane)
    class(runs_t), intent(in) :: self
    complex(rp), contiguous, intent(in) :: buffer(:)
    integer, intent(in) :: z, n_planes, f, n_fields
    complex(rp), contiguous, intent(inout) :: plane(:)
    integer :: q, r, i, from, to, done
    done = 0
    do q = 0, size(self%part) - 2
      from = self%before(q, z, n_planes, f, n_fields)
      do r = self%part(q) + 1, self%part(q + 1)
        to = self%place(r) - 1
        plane(done + 1:to) = 0
        do i = 1, self%count(r)
          plane(to + i) = buffer(from + i)
        end do
        from = from + self%count(r)
        done = to + self%count(r)
      end do
    end do
    plane(done + 1:) = 0
  end subroutine fill_plane

  !> Puts i (kx f2 - ky f1) of the sticks of plane `z` of the fields 1 and 2 of the buffer in their places, and zeros elsewhere.
  pure subroutine fill_curl(self, buffer, z, n_planes, n_fields, plane)
    class(runs_t), intent(in) :: self
    complex(rp), contiguous, intent(in) :: buffer(:)
    integer, intent(in) :: z, n_planes, n_fields
    complex(rp), contiguous, intent(inout) :: plane(:)
    complex(rp) :: c
    integer :: q, r, i, s, from, to, next, done
    done = 0
    s = 0
    do q = 0, size(self%part) - 2
      from = self%before(q, z, n_planes, 1, n_fields)
      next = self%before(q, z, n_planes, 2, n_fields)
      do r = self%part(q) + 1, self%part(q + 1)
        to = self%place(r) - 1
        plane(done + 1:to) = 0
        do i = 1, self%count(r)
          c = self%kx(s + i)*buffer(next + i) - self%ky(s + i)*buffer(from + i)
          plane(to + i) = cmplx(-aimag(c), real(c), rp)
        end do
        s = s + self%count(r)
        from = from + self%count(r)
        next = next + self%count(r)
        done = to + self%count(r)
      end do
    end do
    plane(done + 1:) = 0
  end subroutine fill_curl

  !> Puts the sticks of `plane` into the buffer: the reverse of `fill_plane`.
  pure subroutine take_plane(self, plane, buffer, z, n_planes, f, n_fields)
    class(runs_t), intent(in) :: self
    complex(rp), contiguous, intent(in) :: plane(:)
    complex(rp), contiguous, intent(inout) :: buffer(:)
    integer, intent(in) :: z, n_planes, f, n_fields
    integer :: q, r, i, from, to
    do q = 0, size(self%part) - 2
      to = self%before(q, z, n_planes, f, n_fields)
      do r = self%part(q) + 1, self%part(q + 1)
        from = self%place(r) - 1
        do i = 1, self%count(r)
          buffer(to + i) = plane(from + i)
        end do
        to = to + self%count(r)
      end do
    end do
  end subroutine take_plane

  !> Puts zeros where `take_plane` would put sticks.
  pure subroutine clear_plane(self, buffer, z, n_planes, f, n_fields)
    class(runs_t), intent(in) :: self
    complex(rp), contiguous, intent(inout) :: buffer(:)
    integer, intent(in) :: z, n_planes, f, n_fields
    integer :: q, base
    do q = 0, size(self%part) - 2
      base = self%before(q, z, n_planes, f, n_fields)
      buffer(base + 1:base + self%start(q + 1) - self%start(q)) = 0
    end do
  end subroutine clear_plane

  !> Returns the number of words of the buffer before plane `z` of field `f` of the sticks of column `q`.
  pure integer function before(self, q, z, n_planes, f, n_fields)
    class(runs_t), intent(in) :: self
    integer, intent(in) :: q, z, n_planes, f, n_fields
    before = self%start(q)*n_planes*n_fields + (self%start(q + 1) - self%start(q))*(z - 1 + n_planes*(f - 1))
  end function before
end module spectral_runs
