! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads closed triangulated surfaces from STL files, binary or ASCII.
!>
!> Corners with the same coordinates are one point. The surface must be closed and oriented: every edge belongs to two
!> triangles, which pass it in opposite directions. Normals of the file are ignored.
module fsi_stl
  use, intrinsic :: iso_fortran_env, only: int32, real32
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use fsi_rotation, only: cross
  implicit none
  private
  public :: read_stl, surface_volume

  integer, parameter :: HEAD_BYTES = 84, FACET_BYTES = 50

contains

  !> Returns the points (3, n) and the outward triangles (3, m) from the content of the STL file called `name`. Mistakes go to
  !> `errors`. If the surface is inside out, its triangles are reversed, with a notice.
  subroutine read_stl(text, name, points, triangles, errors, notices)
    character(*), intent(in) :: text, name
    real(rp), allocatable, intent(out) :: points(:, :)
    integer, allocatable, intent(out) :: triangles(:, :)
    type(message_list_t), intent(inout) :: errors, notices
    real(rp), allocatable :: corners(:, :)
    character(:), allocatable :: problem
    integer :: i
    allocate (points(3, 0), triangles(3, 0))
    if (is_binary(text)) then
      call read_binary(text, corners)
    else
      call read_ascii(text, corners, problem)
    end if
    if (.not. allocated(problem)) then
      if (size(corners, 2) < 12) then
        problem = 'has '//number_text(size(corners, 2)/3)//' triangles; a closed surface has at least 4'
      else if (.not. all(abs(corners) < huge(1.0_rp))) then
        problem = 'has a coordinate that is not a number'
      end if
    end if
    if (.not. allocated(problem)) then
      call join_corners(corners, points, triangles)
      call check_closed(size(points, 2), triangles, problem)
    end if
    if (allocated(problem)) then
      call errors%add(name//': '//problem)
      return
    end if
    if (surface_volume(points, triangles) < 0) then
      call notices%add(name//': the normals of its triangles point inward; the program turns them outward')
      do i = 1, size(triangles, 2)
        triangles(2:3, i) = triangles([3, 2], i)
      end do
    end if
  end subroutine read_stl

  !> Tells whether a text is a binary STL file: whether its length fits the number of facets that it states.
  pure logical function is_binary(text)
    character(*), intent(in) :: text
    is_binary = .false.
    if (len(text) < HEAD_BYTES) return
    is_binary = len(text) - HEAD_BYTES == FACET_BYTES*int(transfer(text(81:84), 0_int32))
  end function is_binary

  !> Reads the corners of all facets of a binary STL file.
  subroutine read_binary(text, corners)
    character(*), intent(in) :: text
    real(rp), allocatable, intent(out) :: corners(:, :)
    integer :: i, j, axis, m, at
    m = (len(text) - HEAD_BYTES)/FACET_BYTES
    allocate (corners(3, 3*m))
    do i = 1, m
      at = HEAD_BYTES + FACET_BYTES*(i - 1) + 12 ! beyond the normal
      do j = 3*i - 2, 3*i
        do axis = 1, 3
          corners(axis, j) = transfer(text(at + 1:at + 4), 0.0_real32)
          at = at + 4
        end do
      end do
    end do
  end subroutine read_binary

  !> Reads the corners of all facets of a text STL file. `problem` says what is wrong with it.
  subroutine read_ascii(text, corners, problem)
    character(*), intent(in) :: text
    real(rp), allocatable, intent(out) :: corners(:, :)
    character(:), allocatable, intent(out) :: problem
    character(*), parameter :: WORD = 'vertex'
    integer :: at, next, n, status, stop_at
    if (index(text, 'facet') == 0) then
      problem = 'is no STL file: neither binary of this length, nor text with facets'
      return
    end if
    n = 0
    at = 1
    do
      next = index(text(at:), WORD)
      if (next == 0) exit
      n = n + 1
      at = at + next + len(WORD) - 1
    end do
    if (mod(n, 3) /= 0 .or. n == 0) then
      problem = 'has '//number_text(n)//' corners, which is no multiple of 3: the file is cut or damaged'
      return
    end if
    allocate (corners(3, n))
    at = 1
    do n = 1, size(corners, 2)
      at = at + index(text(at:), WORD) + len(WORD) - 1
      stop_at = scan(text(at:), new_line('a')//achar(13))
      if (stop_at == 0) stop_at = len(text) - at + 2
      read (text(at:at + stop_at - 2), *, iostat=status) corners(:, n)
      if (status == 0) cycle
      problem = 'corner '//number_text(n)//' is not three numbers'
      return
    end do
  end subroutine read_ascii

  !> Merges equal corners into one point.
  subroutine join_corners(corners, points, triangles)
    real(rp), intent(in) :: corners(:, :)
    real(rp), allocatable, intent(out) :: points(:, :)
    integer, allocatable, intent(out) :: triangles(:, :)
    integer, allocatable :: first(:), next(:)
    integer :: i, n, p, place, n_slots
    n_slots = 2*size(corners, 2) + 1
    allocate (first(n_slots), next(size(corners, 2)), source=0)
    allocate (points(3, size(corners, 2)), triangles(3, size(corners, 2)/3))
    n = 0
    do i = 1, size(corners, 2)
      place = 1 + modulo(ieor(hash(corners(1, i)), ieor(ishftc(hash(corners(2, i)), 11), &
                                                        ishftc(hash(corners(3, i)), 21))), n_slots)
      p = first(place)
      do while (p > 0)
        if (all(abs(points(:, p) - corners(:, i)) <= 0)) exit
        p = next(p)
      end do
      if (p == 0) then
        n = n + 1
        p = n
        points(:, p) = corners(:, i)
        next(p) = first(place)
        first(place) = p
      end if
      triangles(mod(i - 1, 3) + 1, (i - 1)/3 + 1) = p
    end do
    points = points(:, :n)
  end subroutine join_corners

  !> Returns a number that is equal for equal reals.
  pure integer function hash(x)
    real(rp), intent(in) :: x
    integer :: halves(2)
    halves = transfer(x + 0.0_rp, halves) ! -0 is 0
    hash = ieor(halves(1), ishftc(halves(2), 7))
  end function hash

  !> Reports edges with one triangle, with more than two, or passed twice in the same direction.
  subroutine check_closed(n_points, triangles, problem)
    integer, intent(in) :: n_points, triangles(:, :)
    character(:), allocatable, intent(out) :: problem
    integer, allocatable :: first(:), next(:), other(:), passes(:, :)
    integer :: i, k, e, n, from, upto
    allocate (first(n_points), source=0)
    allocate (next(3*size(triangles, 2)), other(3*size(triangles, 2)))
    allocate (passes(2, 3*size(triangles, 2)), source=0)
    n = 0
    do i = 1, size(triangles, 2)
      do k = 1, 3
        from = triangles(k, i)
        upto = triangles(mod(k, 3) + 1, i)
        if (from == upto) then
          problem = 'triangle '//number_text(i)//' has two corners at the same point: remove it'
          return
        end if
        e = first(min(from, upto))
        do while (e > 0)
          if (other(e) == max(from, upto)) exit
          e = next(e)
        end do
        if (e == 0) then
          n = n + 1
          e = n
          other(e) = max(from, upto)
          next(e) = first(min(from, upto))
          first(min(from, upto)) = e
        end if
        passes(merge(1, 2, from < upto), e) = passes(merge(1, 2, from < upto), e) + 1
      end do
    end do
    if (any(sum(passes(:, :n), 1) == 1)) then
      problem = 'is not closed: '//number_text(count(sum(passes(:, :n), 1) == 1))//' edges belong to one triangle only; '// &
                'close the holes of the surface, and join its points'
    else if (any(sum(passes(:, :n), 1) > 2)) then
      problem = number_text(count(sum(passes(:, :n), 1) > 2))//' edges belong to more than two triangles: remove the extra ones'
    else if (any(passes(1, :n) /= 1)) then
      problem = 'is not oriented: at '//number_text(count(passes(1, :n) /= 1))//' edges one triangle faces inward and the '// &
                'other outward; turn the triangles that face inward'
    end if
  end subroutine check_closed

  !> Returns the volume inside; it is negative if the triangles face inward.
  pure real(rp) function surface_volume(points, triangles) result(volume)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: triangles(:, :)
    integer :: i
    volume = 0
    do i = 1, size(triangles, 2)
      associate (c => triangles(:, i))
        volume = volume + dot_product(points(:, c(1)), cross(points(:, c(2)), points(:, c(3))))/6
      end associate
    end do
  end function surface_volume
end module fsi_stl
