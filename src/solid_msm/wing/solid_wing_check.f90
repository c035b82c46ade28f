! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks a wing before anything is computed with it: every number is finite and of a possible size, every index is valid, the
!> triangles form a flat surface, the veins lie along its edges, and all parts are connected and held at the root.
!> docs/formats/wing-format.md lists the rules.
module solid_wing_check
  use base_kinds, only: rp
  use base_magnitude, only: rounded
  use base_text, only: number_text, quoted
  use io_arrays, only: is_finite
  use solid_flatness, only: find_flatness
  use solid_junctions, only: hinge_plan_t, plan_hinges
  use solid_sets, only: top, unite
  use solid_wing, only: wing_t, vein_t
  use solid_wing_check_held, only: check_held
  use solid_wing_check_mesh, only: check_triangles, check_veins
  use solid_wing_edges, only: edge_table_t, triangle_edges, vein_segments
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: check_wing, joint_on_vein

  real(rp), parameter :: LARGEST = 1.0e4_rp   !< coordinate [m]
  real(rp), parameter :: THINNEST = 1.0e-9_rp !< diameter [m]
  real(rp), parameter :: SAME = 1.0e-7_rp     !< points closer than this part of the size are one point

contains

  !> Reports all mistakes of `wing`, whose arrays must be allocated. Sets the normal of the plane if the file may omit it.
  subroutine check_wing(wing, report)
    type(wing_t), intent(inout) :: wing
    type(wing_report_t), intent(inout) :: report
    type(edge_table_t) :: edges, segments
    integer, allocatable :: nodes(:), first(:)
    call check_points(wing%points, report)
    call check_indices(wing, report)
    if (.not. report%is_clean()) return
    call check_distinct(wing%points, report)
    call flatten_veins(wing%veins, nodes, first)
    edges = triangle_edges(wing%triangles)
    segments = vein_segments(nodes, first)
    call check_triangles(wing, edges, report)
    call check_veins(wing, edges, segments, report)
    call check_joints(wing, segments, report)
    call check_connected(wing, report)
    if (size(wing%triangles) > 0) then
      wing%plane_normal = [0.0_rp, 0.0_rp, 1.0_rp]
    else if (report%is_clean()) then
      call check_plane(wing, report)
    end if
    if (report%is_clean()) call check_mechanics(wing, edges, segments, report)
  end subroutine check_wing

  !> Checks the requirements of the mechanics: a flat wing, of which no part is held by one point alone.
  subroutine check_mechanics(wing, edges, segments, report)
    type(wing_t), intent(in) :: wing
    type(edge_table_t), intent(in) :: edges, segments
    type(wing_report_t), intent(inout) :: report
    type(hinge_plan_t), allocatable :: plans(:)
    real(rp), allocatable :: ghosts(:, :)
    real(rp) :: normal(3)
    integer :: stray, raised, bent
    call plan_hinges(wing, plans, ghosts, stray)
    call find_flatness(wing, plans, normal, raised, bent)
    if (raised > 0) then
      call report%add('/points', 'the unloaded membrane must be flat; point '//report%point(raised)// &
                      ' lies farthest from its plane')
    else if (bent > 0) then
      call report%add('/points', 'the veins at point '//report%point(bent)//' bend out of the plane of the wing; '// &
                      'move the point into the plane')
    end if
    call check_held(wing, edges, segments, plans, report)
  end subroutine check_mechanics

  !> Finds the three points of a joint at one point inside a vein.
  subroutine joint_on_vein(veins, vein, node, object, nodes, report)
    type(vein_t), intent(in) :: veins(:)
    character(*), intent(in) :: vein, object
    integer, intent(in) :: node
    integer, intent(out) :: nodes(3)
    type(wing_report_t), intent(inout) :: report
    integer :: v, i, n
    nodes = node
    do v = 1, size(veins)
      if (veins(v)%name == vein) exit
    end do
    if (v > size(veins)) then
      call report%add(object, 'there is no vein '//quoted(vein))
      return
    end if
    n = size(veins(v)%nodes)
    do i = 1, n
      if (veins(v)%nodes(i) == node) exit
    end do
    if (i > n) then
      call report%add(object, 'point '//report%point(node)//' is not on vein '//vein)
    else if (i == 1 .and. node == veins(v)%nodes(n) .and. n > 3) then ! a ring
      nodes = [veins(v)%nodes(n - 1), node, veins(v)%nodes(2)]
    else if (i == 1 .or. i == n) then
      call report%add(object, 'point '//report%point(node)//' is an end of vein '//vein// &
                      '; a joint between two veins is given by three points')
    else
      nodes = veins(v)%nodes(i - 1:i + 1)
    end if
  end subroutine joint_on_vein

  !> Reports coordinates that are not finite or too large.
  subroutine check_points(points, report)
    real(rp), intent(in) :: points(:, :)
    type(wing_report_t), intent(inout) :: report
    integer :: i
    if (size(points, 2) < 2) call report%add('/points', 'a wing has at least 2 points')
    call report%begin('/points')
    do i = 1, size(points, 2)
      if (.not. all(is_finite(points(:, i)))) then
        call report%found('point '//report%point(i)//' has an infinite or undefined coordinate')
      else if (any(abs(points(:, i)) > LARGEST)) then
        call report%found('point '//report%point(i)//' has the coordinate '// &
                          number_text(maxval(abs(points(:, i))))//' m; coordinates are in metres, at most ' &
                          //number_text(LARGEST))
      end if
    end do
    call report%finish()
  end subroutine check_points

  !> Checks that indices are in range, lists have matching lengths, and diameters are positive numbers.
  subroutine check_indices(wing, report)
    type(wing_t), intent(in) :: wing
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: group
    integer :: n, i, k
    n = size(wing%points, 2)
    call report%begin('/triangles')
    do i = 1, size(wing%triangles, 2)
      call check_range(wing%triangles(:, i), n, 'triangle '//report%point(i)//': ', report)
    end do
    call report%finish()
    if (size(wing%triangles) == 0 .and. size(wing%veins) == 0) &
      call report%add('/', 'there are neither triangles nor veins')
    do i = 1, size(wing%veins)
      group = '/veins/'//wing%veins(i)%name
      call report%begin(group//'/nodes')
      call check_range(wing%veins(i)%nodes, n, '', report)
      call report%finish()
      if (size(wing%veins(i)%nodes) < 2) call report%add(group//'/nodes', 'a vein has at least 2 points')
      if (size(wing%veins(i)%nodes) /= size(wing%veins(i)%diameters)) &
        call report%add(group, number_text(size(wing%veins(i)%nodes))//' nodes, but '// &
                        number_text(size(wing%veins(i)%diameters))//' diameters')
      call report%begin(group//'/diameters')
      do k = 1, size(wing%veins(i)%diameters)
        call check_diameter(wing%veins(i)%diameters(k), diagonal(wing%points), report%point(k), report)
      end do
      call report%finish()
    end do
    call check_root(wing%root, n, report)
    do i = 1, size(wing%joints)
      call report%begin('/joints/'//wing%joints(i)%name)
      call check_range(wing%joints(i)%nodes, n, '', report)
      call report%finish()
    end do
  end subroutine check_indices

  !> Reports a diameter that no vein can have.
  subroutine check_diameter(diameter, wing_size, index, report)
    real(rp), intent(in) :: diameter, wing_size
    character(*), intent(in) :: index
    type(wing_report_t), intent(inout) :: report
    if (.not. is_finite(diameter)) then
      call report%found('diameter '//index//' is infinite or undefined')
    else if (diameter < THINNEST .or. diameter > LARGEST) then
      call report%found('diameter '//index//' is '//number_text(diameter)//' m; it must lie between '// &
                        number_text(THINNEST)//' and '//number_text(LARGEST))
    else if (wing_size > 0 .and. diameter > wing_size) then
      call report%found('diameter '//index//' is '//number_text(rounded(diameter, 3))//' m, and the points extend over '// &
                        number_text(rounded(wing_size, 3))//' m; are the diameters and the points in metres?')
    end if
  end subroutine check_diameter

  !> Reports clamped points that do not exist or are listed twice.
  subroutine check_root(root, n, report)
    integer, intent(in) :: root(:), n
    type(wing_report_t), intent(inout) :: report
    integer :: i
    if (size(root) == 0) call report%add('/root/nodes', 'a wing is clamped at one point at least')
    call report%begin('/root/nodes')
    call check_range(root, n, '', report)
    do i = 2, min(size(root), n + 1)
      if (any(root(:i - 1) == root(i))) call report%found('point '//report%point(root(i))//' is listed twice')
    end do
    call report%finish()
  end subroutine check_root

  !> Reports points that do not exist.
  subroutine check_range(nodes, n, prefix, report)
    integer, intent(in) :: nodes(:), n
    character(*), intent(in) :: prefix
    type(wing_report_t), intent(inout) :: report
    integer :: i
    do i = 1, size(nodes)
      if (nodes(i) < 1 .or. nodes(i) > n) &
        call report%found(prefix//'point '//report%point(nodes(i))//' does not exist; the points are '// &
                          report%point(1)//' to '//report%point(n))
    end do
  end subroutine check_range

  !> Checks that no two points are at one place.
  subroutine check_distinct(points, report)
    real(rp), intent(in) :: points(:, :)
    type(wing_report_t), intent(inout) :: report
    type(edge_table_t) :: cells
    real(rp) :: near, slice
    integer :: i, j, n
    n = size(points, 2)
    near = SAME*diagonal(points)
    if (.not. near > 0) then
      call report%add('/points', 'all points coincide')
      return
    end if
    ! Slices of x wider than `near`: equal points lie in the same or in neighbouring ones.
    slice = max((maxval(points(1, :)) - minval(points(1, :)))*1.0e-4_rp, 2*near)
    cells%from = int((points(1, :) - minval(points(1, :)))/slice)
    cells%to = [(i, i=1, n)]
    cells%owner = cells%to
    call cells%sort()
    call report%begin('/points')
    do i = 1, n
      do j = i + 1, n
        if (cells%from(j) > cells%from(i) + 1) exit
        if (maxval(abs(points(:, cells%to(i)) - points(:, cells%to(j)))) > near) cycle
        call report%found('points '//report%point(cells%to(i))//' and '//report%point(cells%to(j))// &
                          ' are at the same place')
      end do
    end do
    call report%finish()
  end subroutine check_distinct

  !> Returns the size of the box around the points [m].
  pure real(rp) function diagonal(points)
    real(rp), intent(in) :: points(:, :)
    diagonal = norm2(maxval(points, dim=2) - minval(points, dim=2))
  end function diagonal

  !> Makes one list of all veins; vein v is nodes(first(v):first(v+1)-1).
  subroutine flatten_veins(veins, nodes, first)
    type(vein_t), intent(in) :: veins(:)
    integer, allocatable, intent(out) :: nodes(:), first(:)
    integer :: v
    allocate (nodes(sum([(size(veins(v)%nodes), v=1, size(veins))])), first(size(veins) + 1))
    first(1) = 1
    do v = 1, size(veins)
      first(v + 1) = first(v) + size(veins(v)%nodes)
      nodes(first(v):first(v + 1) - 1) = veins(v)%nodes
    end do
  end subroutine flatten_veins

  !> Checks that a joint bends two segments of veins that meet, and that no two joints are the same hinge.
  subroutine check_joints(wing, segments, report)
    type(wing_t), intent(in) :: wing
    type(edge_table_t), intent(in) :: segments
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: object
    integer :: i, j, k
    do i = 1, size(wing%joints)
      object = '/joints/'//wing%joints(i)%name
      associate (nodes => wing%joints(i)%nodes)
        if (nodes(1) == nodes(2) .or. nodes(2) == nodes(3) .or. nodes(1) == nodes(3)) then
          call report%add(object, 'its three points must be different')
          cycle
        end if
        do k = 1, 2
          if (.not. segments%has_edge(nodes(k), nodes(k + 1))) &
            call report%add(object, 'points '//report%point(nodes(k))//' and '//report%point(nodes(k + 1))// &
                            ' are not neighbours on a vein')
        end do
        do j = 1, i - 1
          if (all(wing%joints(j)%nodes == nodes) .or. all(wing%joints(j)%nodes == nodes(3:1:-1))) &
            call report%add(object, 'is the same hinge as joint '//wing%joints(j)%name)
        end do
      end associate
    end do
  end subroutine check_joints

  !> Checks that all parts are connected: points united along triangles and veins end up in one set.
  subroutine check_connected(wing, report)
    type(wing_t), intent(in) :: wing
    type(wing_report_t), intent(inout) :: report
    integer, allocatable :: parent(:), members(:)
    integer :: i, k, main
    allocate (parent(size(wing%points, 2)), members(size(wing%points, 2)))
    parent = [(i, i=1, size(parent))]
    do i = 1, size(wing%triangles, 2)
      call unite(parent, wing%triangles(1, i), wing%triangles(2, i))
      call unite(parent, wing%triangles(1, i), wing%triangles(3, i))
    end do
    do i = 1, size(wing%veins)
      do k = 2, size(wing%veins(i)%nodes)
        call unite(parent, wing%veins(i)%nodes(k - 1), wing%veins(i)%nodes(k))
      end do
    end do
    members = 0
    do i = 1, size(parent)
      k = top(parent, i)
      members(k) = members(k) + 1
    end do
    main = top(parent, wing%root(1))
    call report%begin('/')
    do i = 1, size(parent)
      if (parent(i) /= i .or. i == main) cycle
      if (members(i) == 1) then
        call report%found('point '//report%point(i)//' is in no triangle and no vein')
      else
        call report%found('point '//report%point(i)//' and '//number_text(members(i) - 1)// &
                          ' more are not connected to root point '//report%point(wing%root(1)))
      end if
    end do
    call report%finish()
  end subroutine check_connected

  !> Checks that a structure of veins is straight, or lies in the given plane.
  subroutine check_plane(wing, report)
    type(wing_t), intent(inout) :: wing
    type(wing_report_t), intent(inout) :: report
    real(rp) :: along(3), r(3), flat
    integer :: i, far
    flat = SAME*diagonal(wing%points)
    far = 1
    do i = 2, size(wing%points, 2)
      if (norm2(wing%points(:, i) - wing%points(:, 1)) > norm2(wing%points(:, far) - wing%points(:, 1))) &
        far = i
    end do
    along = wing%points(:, far) - wing%points(:, 1)
    along = along/norm2(along)
    if (maxval(abs(wing%plane_normal)) > 0) then
      call report%begin('attribute plane_normal')
      do i = 2, size(wing%points, 2)
        if (abs(dot_product(wing%points(:, i) - wing%points(:, 1), wing%plane_normal)) > flat) &
          call report%found('point '//report%point(i)//' does not lie in the plane of the first point')
      end do
      call report%finish()
      return
    end if
    do i = 2, size(wing%points, 2)
      r = wing%points(:, i) - wing%points(:, 1)
      if (norm2(r - dot_product(r, along)*along) <= flat) cycle
      call report%add('attribute plane_normal', 'a structure of veins that is not straight (point '// &
                      report%point(i)//') needs the normal of the plane in which it lies')
      return
    end do
    ! Any normal will do for a straight structure: the one closest to z, or y for a structure along z.
    r = [0.0_rp, 0.0_rp, 1.0_rp]
    if (abs(along(3)) > 0.99_rp) r = [0.0_rp, 1.0_rp, 0.0_rp]
    r = r - dot_product(r, along)*along
    wing%plane_normal = r/norm2(r)
  end subroutine check_plane
end module solid_wing_check
