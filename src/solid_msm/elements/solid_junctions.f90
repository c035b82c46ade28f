! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the pairs of vein segments that a bending hinge joins.
!>
!> Along a vein every two consecutive segments are. A vein that ends at the clamped root gets a ghost
!> point, which prolongs its first segment backwards and is clamped too. Where veins meet, the
!> segments are joined by a spanning tree of smallest turning angles, so that a branch continues the
!> parent's straighter arm; hinges named by joints come first.
module solid_junctions
  use base_kinds, only: rp
  use solid_wing, only: wing_t
  implicit none
  private
  public :: hinge_plan_t, plan_hinges

  !> A hinge to be made: a-b-c with the half-segments that bend. On a clamped side the length is 0.
  type :: hinge_plan_t
    integer :: nodes(3) = 0
    integer :: veins(2) = 0          !< owners of a-b and b-c
    real(rp) :: lengths(2) = 0       !< [m] of the segments
    real(rp) :: diameters(2) = 0     !< [m] of both veins at b
    integer :: joint = 0             !< number of the joint that sets its stiffness
    logical :: is_root = .false.     !< joins the clamped root and a free segment
    real(rp) :: station = 0          !< place of b along the span, -1/2 at the root
  end type hinge_plan_t

  type :: arm_t ! a vein segment seen from a point
    integer :: vein = 0, node = 0, group = 0
    real(rp) :: length = 0, diameter = 0, direction(3) = 0
  end type arm_t

contains

  !> The hinges of a wing with its ghost points: ghosts(3, n) [m] are numbered behind the wing's own
  !> points. `stray_joint` is a joint that fits no pair of vein segments, or 0.
  subroutine plan_hinges(wing, plans, ghosts, stray_joint)
    type(wing_t), intent(in) :: wing
    type(hinge_plan_t), allocatable, intent(out) :: plans(:)
    real(rp), allocatable, intent(out) :: ghosts(:, :)
    integer, intent(out) :: stray_joint
    logical, allocatable :: clamped(:)
    integer, allocatable :: used(:)
    real(rp) :: station(size(wing%points, 2))
    integer :: v, p, j, n_points, n_plans, n_ghosts, capacity

    n_points = size(wing%points, 2)
    allocate (clamped(n_points), source=.false.)
    clamped(wing%root) = .true.
    allocate (used(n_points), source=0)
    capacity = size(wing%joints)
    do v = 1, size(wing%veins)
      capacity = capacity + 2*size(wing%veins(v)%nodes) + 2
      associate (nodes => wing%veins(v)%nodes)
        do p = 1, size(nodes) ! a ring passes its first point twice
          used(nodes(p)) = used(nodes(p)) + 1
        end do
      end associate
    end do
    allocate (plans(capacity), ghosts(3, 2*size(wing%veins)))
    n_plans = 0
    n_ghosts = 0
    do v = 1, size(wing%veins)
      associate (nodes => wing%veins(v)%nodes)
        call add_ghost(nodes(1), nodes(2))
        do p = 2, size(nodes) - 1
          call add(arm(v, p, -1), nodes(p), arm(v, p, 1), 0)
        end do
        call add_ghost(nodes(size(nodes)), nodes(size(nodes) - 1))
      end associate
    end do
    stray_joint = 0
    do j = 1, size(wing%joints)
      call add_joint(j)
    end do
    do p = 1, n_points
      if (used(p) > 1 .and. .not. clamped(p)) call join(p)
    end do
    plans = plans(:n_plans)
    ghosts = ghosts(:, :n_ghosts)
    station = stations(wing)
    plans%station = station(plans%nodes(2))

  contains

    !> The segment of vein `vein` from its place `place` one step forward or backward.
    function arm(vein, place, step) result(a)
      integer, intent(in) :: vein, place, step
      type(arm_t) :: a
      a%vein = vein
      a%node = wing%veins(vein)%nodes(place + step)
      a%direction = wing%points(:, a%node) - wing%points(:, wing%veins(vein)%nodes(place))
      a%length = norm2(a%direction)
      a%direction = a%direction/a%length
      a%diameter = wing%veins(vein)%diameters(place)
    end function arm

    subroutine add(one, node, other, joint)
      type(arm_t), intent(in) :: one, other
      integer, intent(in) :: node, joint
      logical :: fixed(2)
      fixed = clamped(node) .and. [clamped(one%node), clamped(other%node)]
      if (all(fixed)) return
      n_plans = n_plans + 1
      plans(n_plans)%nodes = [one%node, node, other%node]
      plans(n_plans)%veins = [one%vein, other%vein]
      plans(n_plans)%lengths = merge(0.0_rp, [one%length, other%length], fixed)
      plans(n_plans)%diameters = [one%diameter, other%diameter]
      plans(n_plans)%joint = joint
      plans(n_plans)%is_root = any(fixed)
    end subroutine add

    subroutine add_ghost(end_node, next)
      integer, intent(in) :: end_node, next
      if (.not. clamped(end_node) .or. clamped(next)) return
      n_ghosts = n_ghosts + 1
      ghosts(:, n_ghosts) = 2*wing%points(:, end_node) - wing%points(:, next)
      n_plans = n_plans + 1
      plans(n_plans)%nodes = [n_points + n_ghosts, end_node, next]
      plans(n_plans)%veins = v
      plans(n_plans)%lengths = [0.0_rp, norm2(wing%points(:, next) - wing%points(:, end_node))]
      plans(n_plans)%diameters = wing%veins(v)%diameters(merge(1, size(wing%veins(v)%nodes), &
                                                               end_node == wing%veins(v)%nodes(1)))
      plans(n_plans)%is_root = .true.
    end subroutine add_ghost

    !> A joint takes over the hinge of its three nodes, or adds one where two veins meet.
    subroutine add_joint(number)
      integer, intent(in) :: number
      type(arm_t), allocatable :: arms(:)
      integer :: h, one, other
      associate (n => wing%joints(number)%nodes)
        do h = 1, n_plans
          if (plans(h)%nodes(2) /= n(2)) cycle
          if (any(plans(h)%nodes(1) == n([1, 3])) .and. any(plans(h)%nodes(3) == n([1, 3]))) then
            plans(h)%joint = number
            return
          end if
        end do
        arms = arms_at(n(2))
        one = 0
        other = 0
        do h = 1, size(arms)
          if (arms(h)%node == n(1)) one = h
          if (arms(h)%node == n(3)) other = h
        end do
        if (one > 0 .and. other > 0) then
          call add(arms(one), n(2), arms(other), number)
        else if (stray_joint == 0) then
          stray_joint = number
        end if
      end associate
    end subroutine add_joint

    function arms_at(node) result(arms)
      integer, intent(in) :: node
      type(arm_t), allocatable :: arms(:)
      integer :: w, q
      allocate (arms(0))
      do w = 1, size(wing%veins)
        do q = 1, size(wing%veins(w)%nodes)
          if (wing%veins(w)%nodes(q) /= node) cycle
          if (q > 1) arms = [arms, arm(w, q, -1)]
          if (q < size(wing%veins(w)%nodes)) arms = [arms, arm(w, q, 1)]
        end do
      end do
    end function arms_at

    !> Joins the groups of arms that no hinge connects yet, smallest turning angle first.
    subroutine join(node)
      integer, intent(in) :: node
      type(arm_t), allocatable :: arms(:)
      integer :: a, b, h, best(2)
      real(rp) :: straightness
      arms = arms_at(node)
      do a = 1, size(arms)
        arms(a)%group = a
      end do
      do h = 1, n_plans
        if (plans(h)%nodes(2) /= node) cycle
        do a = 1, size(arms)
          do b = 1, size(arms)
            if (arms(a)%node == plans(h)%nodes(1) .and. arms(b)%node == plans(h)%nodes(3)) &
              call unite(arms, a, b)
          end do
        end do
      end do
      do
        best = 0
        straightness = -2
        do a = 1, size(arms)
          do b = a + 1, size(arms)
            if (arms(a)%group == arms(b)%group) cycle
            if (-dot_product(arms(a)%direction, arms(b)%direction) <= straightness) cycle
            straightness = -dot_product(arms(a)%direction, arms(b)%direction)
            best = [a, b]
          end do
        end do
        if (best(1) == 0) exit
        call add(arms(best(1)), node, arms(best(2)), 0)
        call unite(arms, best(1), best(2))
      end do
    end subroutine join
  end subroutine plan_hinges

  pure subroutine unite(arms, a, b)
    type(arm_t), intent(inout) :: arms(:)
    integer, intent(in) :: a, b
    integer :: from, i
    from = arms(b)%group
    do i = 1, size(arms)
      if (arms(i)%group == from) arms(i)%group = arms(a)%group
    end do
  end subroutine unite

  !> s(points): the station (x - x_root)/R - 1/2 of all points of a wing; without extent along x all are those of the root.
  pure function stations(wing) result(s)
    type(wing_t), intent(in) :: wing
    real(rp) :: s(size(wing%points, 2))
    real(rp) :: root, extent
    s = -0.5_rp
    extent = maxval(wing%points(1, :)) - minval(wing%points(1, :))
    if (.not. extent > 0) return
    root = sum(wing%points(1, wing%root))/max(1, size(wing%root))
    s = (wing%points(1, :) - root)/extent - 0.5_rp
  end function stations
end module solid_junctions
