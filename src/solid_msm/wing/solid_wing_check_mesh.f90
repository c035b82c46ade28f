! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks triangles and veins whose indices are known to be valid.
module solid_wing_check_mesh
  use base_kinds, only: rp
  use solid_wing, only: wing_t, vein_t
  use solid_wing_edges, only: edge_table_t
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: check_triangles, check_veins

  real(rp), parameter :: FLATTEST = 1.0e-4_rp  !< height of a triangle by its longest edge, at least
  real(rp), parameter :: SHARPEST = -0.985_rp  !< cosine of the turn of a vein at a point: 170 degrees

contains

  !> Reports triangles that are degenerate, that do not run counter-clockwise seen from +z, or that form no surface: every edge
  !> must belong to one triangle, or to two that lie on either side of it.
  subroutine check_triangles(wing, edges, report)
    type(wing_t), intent(in) :: wing
    type(edge_table_t), intent(in) :: edges !< of the triangles
    type(wing_report_t), intent(inout) :: report
    real(rp) :: a(3), b(3), normal(3), longest
    integer :: t, e
    call report%begin('/triangles')
    do t = 1, size(wing%triangles, 2)
      associate (c => wing%triangles(:, t))
        if (c(1) == c(2) .or. c(2) == c(3) .or. c(1) == c(3)) then
          call report%found(triangle_text(wing, t, report)//' has the same corner twice')
          cycle
        end if
        a = wing%points(:, c(2)) - wing%points(:, c(1))
        b = wing%points(:, c(3)) - wing%points(:, c(1))
        normal = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
        longest = max(dot_product(a, a), dot_product(b, b), dot_product(a - b, a - b))
        if (norm2(normal) < FLATTEST*longest) then
          call report%found(triangle_text(wing, t, report)//' is degenerate: its corners lie on a line')
        else if (normal(3) < FLATTEST*longest) then
          call report%found(triangle_text(wing, t, report)// &
                            ' is inverted: its corners must run counter-clockwise seen from +z')
        end if
      end associate
    end do
    call report%finish()
    ! A directed edge belongs to one triangle. If all triangles have the same orientation, a second triangle with this edge lies on
    ! the same side and covers the first.
    call report%begin('/triangles')
    do e = 2, size(edges%from)
      if (edges%from(e) /= edges%from(e - 1) .or. edges%to(e) /= edges%to(e - 1)) cycle
      if (edges%owner(e) == edges%owner(e - 1)) cycle ! reported above
      call report%found('triangles '//report%point(edges%owner(e - 1))//' and '// &
                        report%point(edges%owner(e))//' lie on the same side of their common edge '// &
                        report%point(edges%from(e))//'-'//report%point(edges%to(e))//', or are the same')
    end do
    call report%finish()
  end subroutine check_triangles

  !> Returns the number of a triangle and its points.
  function triangle_text(wing, t, report) result(text)
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: t
    type(wing_report_t), intent(in) :: report
    character(:), allocatable :: text
    text = 'triangle '//report%point(t)//' (points '//report%point(wing%triangles(1, t))//', '// &
           report%point(wing%triangles(2, t))//', '//report%point(wing%triangles(3, t))//')'
  end function triangle_text

  !> Reports veins that pass a point twice (unless they close a ring), that leave the edges of the mesh if there is one, that
  !> share a segment, or that fold back on themselves.
  subroutine check_veins(wing, edges, segments, report)
    type(wing_t), intent(in) :: wing
    type(edge_table_t), intent(in) :: edges, segments !< of the triangles, of the veins
    type(wing_report_t), intent(inout) :: report
    integer :: v, e
    logical, allocatable :: is_seen(:)
    allocate (is_seen(size(wing%points, 2)))
    is_seen = .false.
    do v = 1, size(wing%veins)
      call check_vein(wing, wing%veins(v), edges, is_seen, report)
    end do
    call report%begin('/veins')
    do e = 2, size(segments%from)
      if (segments%from(e) /= segments%from(e - 1) .or. segments%to(e) /= segments%to(e - 1)) cycle
      call report%found('segment '//report%point(segments%from(e))//'-'//report%point(segments%to(e))// &
                        ' is in vein '//wing%veins(segments%owner(e - 1))%name//' and again in vein '// &
                        wing%veins(segments%owner(e))%name)
    end do
    call report%finish()
  end subroutine check_veins

  !> Reports a vein that passes a point twice or leaves the edges of the mesh.
  subroutine check_vein(wing, vein, edges, is_seen, report)
    type(wing_t), intent(in) :: wing
    type(vein_t), intent(in) :: vein
    type(edge_table_t), intent(in) :: edges
    logical, intent(inout) :: is_seen(:) !< all false on entry and on return
    type(wing_report_t), intent(inout) :: report
    real(rp) :: a(3), b(3), scale
    integer :: n, i
    n = size(vein%nodes)
    call report%begin('/veins/'//vein%name//'/nodes')
    do i = 1, n
      if (is_seen(vein%nodes(i)) .and. .not. (i == n .and. n > 3 .and. vein%nodes(i) == vein%nodes(1))) &
        call report%found('passes point '//report%point(vein%nodes(i))//' twice')
      is_seen(vein%nodes(i)) = .true.
    end do
    do i = 2, n
      if (size(wing%triangles) == 0) exit
      if (.not. edges%has_edge(vein%nodes(i - 1), vein%nodes(i))) &
        call report%found('from point '//report%point(vein%nodes(i - 1))//' to '// &
                          report%point(vein%nodes(i))//' there is no edge of the mesh')
    end do
    do i = 2, n - 1
      a = wing%points(:, vein%nodes(i)) - wing%points(:, vein%nodes(i - 1))
      b = wing%points(:, vein%nodes(i + 1)) - wing%points(:, vein%nodes(i))
      scale = norm2(a)*norm2(b)
      if (scale > 0 .and. dot_product(a, b) < SHARPEST*scale) &
        call report%found('folds back on itself at point '//report%point(vein%nodes(i)))
    end do
    call report%finish()
    do i = 1, n
      is_seen(vein%nodes(i)) = .false.
    end do
  end subroutine check_vein
end module solid_wing_check_mesh
