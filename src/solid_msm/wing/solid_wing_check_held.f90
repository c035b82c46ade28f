! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds parts of a wing that are connected to the rest by a single point about which they could turn freely.
!>
!> Triangles with a common edge and the segments of veins along them form bodies, and so do segments joined by a bending hinge; a
!> hinge at the root joins a body to the ground. Bodies, the ground among them, share points. If the removal of a point separates
!> bodies from the ground, the point is a mechanism. Such points are found by a search in depth through the graph of bodies and
!> points (Hopcroft and Tarjan 1973, doi:10.1145/362248.362272), in a time proportional to its size.
module solid_wing_check_held
  use base_text, only: number_text
  use solid_junctions, only: hinge_plan_t
  use solid_sets, only: top, unite
  use solid_wing, only: wing_t
  use solid_wing_edges, only: edge_table_t
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: check_held

  integer, parameter :: GROUND = 1 !< the first element; triangles and then segments of veins follow

contains

  !> Reports every part of the wing that is connected by one point alone. The wing must have no other mistakes.
  subroutine check_held(wing, edges, segments, plans, report)
    type(wing_t), intent(in) :: wing
    type(edge_table_t), intent(in) :: edges, segments !< of the triangles, of the veins
    type(hinge_plan_t), intent(in) :: plans(:)        !< the hinges of the veins
    type(wing_report_t), intent(inout) :: report
    integer, allocatable :: body(:)
    type(edge_table_t) :: graph
    body = bodies(wing, edges, segments, plans)
    graph = bodies_and_points(wing, segments, body)
    call report%begin('/')
    call search(graph, size(body), size(body) + size(wing%points, 2), report)
    call report%finish()
  end subroutine check_held

  !> Finds the body of every element, which is the number of its first element.
  pure function bodies(wing, edges, segments, plans) result(body)
    type(wing_t), intent(in) :: wing
    type(edge_table_t), intent(in) :: edges, segments
    type(hinge_plan_t), intent(in) :: plans(:)
    integer, allocatable :: body(:)
    logical :: is_clamped(size(wing%points, 2))
    integer :: i, k, first_segment
    is_clamped = .false.
    is_clamped(wing%root) = .true.
    first_segment = GROUND + size(wing%triangles, 2)
    body = [(i, i=1, first_segment + size(segments%from))]
    do i = 1, size(edges%from)
      k = edges%find(edges%to(i), edges%from(i))
      if (k > 0) call unite(body, GROUND + edges%owner(i), GROUND + edges%owner(k))
    end do
    do i = 1, size(segments%from)
      k = edges%find(segments%from(i), segments%to(i))
      if (k == 0) k = edges%find(segments%to(i), segments%from(i))
      if (k > 0) call unite(body, first_segment + i, GROUND + edges%owner(k))
    end do
    do i = 1, size(plans)
      associate (nodes => plans(i)%nodes)
        call unite(body, arm(nodes(1), nodes(2)), arm(nodes(2), nodes(3)))
      end associate
    end do
    do i = 1, size(body)
      body(i) = top(body, i)
    end do

  contains

    !> Returns the element of a segment of a hinge: the ground if it is clamped, like a segment to a ghost point.
    pure integer function arm(a, b)
      integer, intent(in) :: a, b
      arm = GROUND
      if (max(a, b) > size(is_clamped)) return
      if (is_clamped(a) .and. is_clamped(b)) return
      arm = first_segment + segments%find(min(a, b), max(a, b))
    end function arm
  end function bodies

  !> Lists pairs of a body and a point in it, in both directions; point p is node size(body) + p.
  pure function bodies_and_points(wing, segments, body) result(graph)
    type(wing_t), intent(in) :: wing
    type(edge_table_t), intent(in) :: segments
    integer, intent(in) :: body(:)
    type(edge_table_t) :: graph
    integer :: i, k, n, m
    m = size(wing%triangles, 2)
    n = size(wing%root) + 3*m + 2*size(segments%from)
    allocate (graph%from(2*n), graph%to(2*n), graph%owner(2*n))
    graph%owner = 0
    graph%from(:size(wing%root)) = body(GROUND)
    graph%to(:size(wing%root)) = wing%root
    k = size(wing%root)
    do i = 1, m
      graph%from(k + 1:k + 3) = body(GROUND + i)
      graph%to(k + 1:k + 3) = wing%triangles(:, i)
      k = k + 3
    end do
    do i = 1, size(segments%from)
      graph%from(k + 1:k + 2) = body(GROUND + m + i)
      graph%to(k + 1:k + 2) = [segments%from(i), segments%to(i)]
      k = k + 2
    end do
    graph%to(:n) = graph%to(:n) + size(body)
    graph%from(n + 1:) = graph%to(:n)
    graph%to(n + 1:) = graph%from(:n)
    call graph%sort()
  end function bodies_and_points

  !> Reports the points of the graph without which a part is cut off from the ground; nodes above n_bodies are points.
  subroutine search(graph, n_bodies, n_nodes, report)
    type(edge_table_t), intent(in) :: graph
    integer, intent(in) :: n_bodies, n_nodes
    type(wing_report_t), intent(inout) :: report
    integer, dimension(n_nodes) :: place, lowest, above, members, first ! of a node: in the order of the search, ...
    integer :: next(n_nodes + 1), i, node, other, n_visited
    next = first_edges(graph, n_nodes)
    place = 0
    n_visited = 0
    call visit(GROUND, 0)
    node = GROUND
    do
      i = next(node)
      if (is_of(i, node)) then
        next(node) = i + 1
        other = graph%to(i)
        if (other == above(node)) cycle
        if (place(other) > 0) then
          lowest(node) = min(lowest(node), place(other))
        else
          call visit(other, node)
          node = other
        end if
        cycle
      end if
      other = above(node)
      if (other == 0) exit
      if (other > n_bodies .and. lowest(node) >= place(other)) then
        call report%found('point '//report%point(first(node))//others(members(node) - 1)//' on point '// &
                          report%point(other - n_bodies)//' alone and can turn about it: join the two parts by '// &
                          'an edge of two triangles or by a vein')
      end if
      lowest(other) = min(lowest(other), lowest(node))
      members(other) = members(other) + members(node)
      first(other) = min(first(other), first(node))
      node = other
    end do

  contains

    pure logical function is_of(i, node)
      integer, intent(in) :: i, node
      is_of = i <= size(graph%from)
      if (is_of) is_of = graph%from(i) == node
    end function is_of

    !> Begins a node of the depth-first search, reached from another one.
    subroutine visit(node, from)
      integer, intent(in) :: node, from
      n_visited = n_visited + 1
      place(node) = n_visited
      lowest(node) = n_visited
      above(node) = from
      members(node) = merge(1, 0, node > n_bodies)
      first(node) = merge(node - n_bodies, huge(1), node > n_bodies)
    end subroutine visit
  end subroutine search

  !> Returns where the edges of each node begin in the graph, and after the last one.
  pure function first_edges(graph, n_nodes) result(first)
    type(edge_table_t), intent(in) :: graph
    integer, intent(in) :: n_nodes
    integer :: first(n_nodes + 1), i
    first = 0
    do i = 1, size(graph%from)
      first(graph%from(i) + 1) = first(graph%from(i) + 1) + 1
    end do
    first(1) = 1
    do i = 1, n_nodes
      first(i + 1) = first(i + 1) + first(i)
    end do
  end function first_edges

  !> Returns the words for n more points.
  function others(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text
    text = ' hangs'
    if (n > 0) text = ' and '//number_text(n)//' more hang'
  end function others
end module solid_wing_check_held
