! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the pairs of vein segments that a bending hinge joins.
!>
!> Every two consecutive segments of a vein form a pair. A vein that ends at the clamped root gets a ghost point, which extends its
!> first segment backwards and is clamped, too. Where veins meet, a spanning tree of smallest turning angles joins the segments, so
!> that a branch continues the straighter arm of its parent. Hinges named by joints come first.
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

  !> The plan under construction.
  type :: draft_t
    type(hinge_plan_t), allocatable :: plans(:) !< the first n_plans
    real(rp), allocatable :: ghosts(:, :)       !< (3, :) [m] the first n_ghosts
    logical, allocatable :: clamped(:)          !< (points of the wing)
    integer :: n_plans = 0, n_ghosts = 0
  end type draft_t

contains

  !> Plans the hinges of a wing, and the ghost points ghosts(3, n) [m] that they need. The numbers of ghost points follow those of
  !> the points of the wing. `stray_joint` is the number of a joint that fits no pair of vein segments, or 0.
  subroutine plan_hinges(wing, plans, ghosts, stray_joint)
    type(wing_t), intent(in) :: wing
    type(hinge_plan_t), allocatable, intent(out) :: plans(:)
    real(rp), allocatable, intent(out) :: ghosts(:, :)
    integer, intent(out) :: stray_joint
    type(draft_t) :: draft
    integer :: used(size(wing%points, 2)) ! how often veins pass a point
    real(rp) :: station(size(wing%points, 2))
    logical :: fits
    integer :: v, p, j
    draft = empty_draft(wing)
    used = 0
    do v = 1, size(wing%veins)
      associate (nodes => wing%veins(v)%nodes)
        do p = 1, size(nodes) ! a ring passes its first point twice
          used(nodes(p)) = used(nodes(p)) + 1
        end do
      end associate
      call add_vein(draft, wing, v)
    end do
    stray_joint = 0
    do j = 1, size(wing%joints)
      call add_joint(draft, wing, j, fits)
      if (stray_joint == 0 .and. .not. fits) stray_joint = j
    end do
    do p = 1, size(used)
      if (used(p) > 1 .and. .not. draft%clamped(p)) call join_arms(draft, p, arms_at(wing, p))
    end do
    plans = draft%plans(:draft%n_plans)
    ghosts = draft%ghosts(:, :draft%n_ghosts)
    station = stations(wing)
    plans%station = station(plans%nodes(2))
  end subroutine plan_hinges

  !> Makes a draft with room for all hinges of the wing.
  pure function empty_draft(wing) result(draft)
    type(wing_t), intent(in) :: wing
    type(draft_t) :: draft
    integer :: v, capacity
    capacity = size(wing%joints)
    do v = 1, size(wing%veins)
      capacity = capacity + 2*size(wing%veins(v)%nodes) + 2
    end do
    allocate (draft%plans(capacity), draft%ghosts(3, 2*size(wing%veins)))
    allocate (draft%clamped(size(wing%points, 2)), source=.false.)
    draft%clamped(wing%root) = .true.
  end function empty_draft

  !> Adds the hinges along vein v, with those at a clamped end.
  subroutine add_vein(draft, wing, v)
    type(draft_t), intent(inout) :: draft
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: v
    integer :: p
    associate (nodes => wing%veins(v)%nodes)
      call add_ghost(draft, wing, v, 1, 2)
      do p = 2, size(nodes) - 1
        call add_hinge(draft, arm(wing, v, p, -1), nodes(p), arm(wing, v, p, 1), 0)
      end do
      call add_ghost(draft, wing, v, size(nodes), size(nodes) - 1)
    end associate
  end subroutine add_vein

  !> Adds the hinge between two arms of a point, unless both are clamped.
  subroutine add_hinge(draft, one, node, other, joint)
    type(draft_t), intent(inout) :: draft
    type(arm_t), intent(in) :: one, other
    integer, intent(in) :: node, joint
    logical :: fixed(2)
    fixed = draft%clamped(node) .and. [draft%clamped(one%node), draft%clamped(other%node)]
    if (all(fixed)) return
    draft%n_plans = draft%n_plans + 1
    associate (plan => draft%plans(draft%n_plans))
      plan%nodes = [one%node, node, other%node]
      plan%veins = [one%vein, other%vein]
      plan%lengths = merge(0.0_rp, [one%length, other%length], fixed)
      plan%diameters = [one%diameter, other%diameter]
      plan%joint = joint
      plan%is_root = any(fixed)
    end associate
  end subroutine add_hinge

  !> Adds the ghost point and the hinge where vein v ends at the clamped root: at its point `last`, which follows the point `inner`.
  subroutine add_ghost(draft, wing, v, last, inner)
    type(draft_t), intent(inout) :: draft
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: v, last, inner
    associate (root => wing%veins(v)%nodes(last), next => wing%veins(v)%nodes(inner))
      if (.not. draft%clamped(root) .or. draft%clamped(next)) return
      draft%n_ghosts = draft%n_ghosts + 1
      draft%ghosts(:, draft%n_ghosts) = 2*wing%points(:, root) - wing%points(:, next)
      draft%n_plans = draft%n_plans + 1
      associate (plan => draft%plans(draft%n_plans))
        plan%nodes = [size(wing%points, 2) + draft%n_ghosts, root, next]
        plan%veins = v
        plan%lengths = [0.0_rp, norm2(wing%points(:, next) - wing%points(:, root))]
        plan%diameters = wing%veins(v)%diameters(last)
        plan%is_root = .true.
      end associate
    end associate
  end subroutine add_ghost

  !> Assigns the hinge of its three nodes to a joint, or adds a hinge where two veins meet, if the joint `fits`.
  subroutine add_joint(draft, wing, number, fits)
    type(draft_t), intent(inout) :: draft
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: number
    logical, intent(out) :: fits
    type(arm_t), allocatable :: arms(:)
    integer :: h, one, other
    fits = .true.
    associate (n => wing%joints(number)%nodes)
      do h = 1, draft%n_plans
        associate (nodes => draft%plans(h)%nodes)
          if (nodes(2) /= n(2)) cycle
          if (any(nodes(1) == n([1, 3])) .and. any(nodes(3) == n([1, 3]))) then
            draft%plans(h)%joint = number
            return
          end if
        end associate
      end do
      arms = arms_at(wing, n(2))
      one = 0
      other = 0
      do h = 1, size(arms)
        if (arms(h)%node == n(1)) one = h
        if (arms(h)%node == n(3)) other = h
      end do
      fits = one > 0 .and. other > 0
      if (fits) call add_hinge(draft, arms(one), n(2), arms(other), number)
    end associate
  end subroutine add_joint

  !> Joins the groups of arms of a point that no hinge connects yet, smallest turning angle first.
  subroutine join_arms(draft, node, all_arms)
    type(draft_t), intent(inout) :: draft
    integer, intent(in) :: node
    type(arm_t), intent(in) :: all_arms(:)
    type(arm_t) :: arms(size(all_arms))
    integer :: a, b, h, best(2)
    arms = all_arms
    arms%group = [(a, a=1, size(arms))]
    do h = 1, draft%n_plans
      associate (nodes => draft%plans(h)%nodes)
        if (nodes(2) /= node) cycle
        do a = 1, size(arms)
          do b = 1, size(arms)
            if (arms(a)%node == nodes(1) .and. arms(b)%node == nodes(3)) call unite(arms, a, b)
          end do
        end do
      end associate
    end do
    do
      best = straightest_pair(arms)
      if (best(1) == 0) exit
      call add_hinge(draft, arms(best(1)), node, arms(best(2)), 0)
      call unite(arms, best(1), best(2))
    end do
  end subroutine join_arms

  !> Returns the two arms of different groups between which a vein would turn least; 0 if there is only one group.
  pure function straightest_pair(arms) result(best)
    type(arm_t), intent(in) :: arms(:)
    integer :: best(2)
    real(rp) :: straightness, least_turned
    integer :: a, b
    best = 0
    least_turned = -2
    do a = 1, size(arms)
      do b = a + 1, size(arms)
        if (arms(a)%group == arms(b)%group) cycle
        straightness = -dot_product(arms(a)%direction, arms(b)%direction)
        if (straightness <= least_turned) cycle
        least_turned = straightness
        best = [a, b]
      end do
    end do
  end function straightest_pair

  !> Lists the vein segments at a point.
  pure function arms_at(wing, node) result(arms)
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: node
    type(arm_t), allocatable :: arms(:)
    integer :: v, p
    allocate (arms(0))
    do v = 1, size(wing%veins)
      do p = 1, size(wing%veins(v)%nodes)
        if (wing%veins(v)%nodes(p) /= node) cycle
        if (p > 1) arms = [arms, arm(wing, v, p, -1)]
        if (p < size(wing%veins(v)%nodes)) arms = [arms, arm(wing, v, p, 1)]
      end do
    end do
  end function arms_at

  !> Returns the segment of vein v from its place p one step forward or backward.
  pure function arm(wing, v, p, step) result(a)
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: v, p, step
    type(arm_t) :: a
    a%vein = v
    a%node = wing%veins(v)%nodes(p + step)
    a%direction = wing%points(:, a%node) - wing%points(:, wing%veins(v)%nodes(p))
    a%length = norm2(a%direction)
    a%direction = a%direction/a%length
    a%diameter = wing%veins(v)%diameters(p)
  end function arm

  !> Merges the groups of arms a and b.
  pure subroutine unite(arms, a, b)
    type(arm_t), intent(inout) :: arms(:)
    integer, intent(in) :: a, b
    integer :: from, i
    from = arms(b)%group
    do i = 1, size(arms)
      if (arms(i)%group == from) arms(i)%group = arms(a)%group
    end do
  end subroutine unite

  !> Returns s(points), the station (x - x_root)/R - 1/2 of all points of a wing; without extent along x all are that of the root.
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
