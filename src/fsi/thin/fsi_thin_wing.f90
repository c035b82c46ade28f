! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds one wing without thickness: its markers, and the response of the flow there to forces at them (fsi_thin_wings). One rank
!> owns the wing. The owner holds the response alone, or it shares it with the other ranks of a group, its helpers.
module fsi_thin_wing
  use base_kinds, only: rp
  use fsi_flow_reaction, only: flow_reaction_t
  use fsi_green, only: green_t
  use fsi_kinematics, only: wing_pose_t
  use fsi_markers, only: markers_t
  use fsi_thin_keys, only: SHARING_GROUP, SHARING_ONE
  use fsi_wing_mirror, only: mirror_vectors
  use parallel_world, only: world_t
  implicit none
  private
  public :: thin_wing_t, form_group

  !> One wing, whose markers are numbers first .. last of the markers of all wings.
  type :: thin_wing_t
    type(markers_t) :: markers
    type(flow_reaction_t) :: reaction
    integer :: first = 1, last = 0, owner = 0
    logical :: is_owner = .false., is_helper = .false. !< the role of this rank for the wing
    logical :: is_mirrored = .false. !< the wing file's axes are those of the wing frame, mirrored
    real(rp), allocatable :: shape(:, :) !< (3, n) positions of markers in the wing frame for which the response is computed, L
    real(rp), allocatable :: flat(:, :)  !< (3, n) markers of the unloaded wing, in its frame, L
    real(rp), allocatable :: bent(:, :)  !< (3, n) their displacements in this frame when they sampled the flow, L
    real(rp), allocatable :: work(:, :)  !< (3, n)
    !> (3, n) force on the flow in the last step, or in its last part, along the axes of the wing file, rho L^4/T^2
    real(rp), allocatable :: last_force(:, :)
  contains
    procedure :: init => wing_init
    procedure :: hold_response => wing_hold_response
    procedure :: build_response => wing_build_response
    procedure :: update_reaction => wing_update_reaction
    procedure :: end_solutions => wing_end_solutions
    procedure :: solve => wing_solve
  end type thin_wing_t

contains

  !> Puts markers on an unloaded wing of points(3, :) [L] and triangles(3, :). They are about `spacing` [L] apart. Their numbers
  !> begin after the n_before markers of the other wings.
  subroutine wing_init(self, points, triangles, spacing, is_2d, n_before)
    class(thin_wing_t), intent(inout) :: self
    real(rp), intent(in) :: points(:, :), spacing
    integer, intent(in) :: triangles(:, :), n_before
    logical, intent(in) :: is_2d
    call self%markers%init(points, triangles, spacing, is_2d)
    self%first = n_before + 1
    self%last = n_before + self%markers%n
    allocate (self%shape(3, self%markers%n), self%flat(3, self%markers%n), self%bent(3, self%markers%n), &
              self%work(3, self%markers%n), self%last_force(3, self%markers%n), source=0.0_rp)
    call self%markers%positions(points, self%flat)
    self%shape = self%flat
  end subroutine wing_init

  !> Decides whether the ranks of `world` form one group for each wing to share its response; wing i has n_markers(i) markers. If
  !> so, `is_shared` is true and `group` is the group of this rank. Ranks are dealt to the groups in turn, so that rank i - 1, the
  !> owner of wing i, is the first of its group. If `sharing` is automatic, groups form only if this is faster: an inverse takes six
  !> times the operations of a factor. Collective.
  subroutine form_group(world, n_markers, sharing, is_shared, group)
    type(world_t), intent(in) :: world
    integer, intent(in) :: n_markers(:), sharing
    logical, intent(out) :: is_shared
    type(world_t), intent(out) :: group
    integer, parameter :: FEWEST_RANKS = 8, FEWEST_MARKERS = 1000
    integer :: n_ranks
    n_ranks = world%size/size(n_markers)
    is_shared = n_ranks >= FEWEST_RANKS .and. maxval(n_markers) >= FEWEST_MARKERS
    if (sharing == SHARING_GROUP) is_shared = n_ranks > 1
    if (sharing == SHARING_ONE) is_shared = .false.
    if (is_shared) call world%split(mod(world%rank, size(n_markers)), group)
  end subroutine form_group

  !> Allocates the response of this wing, number i of n_wings, on the ranks that hold it. If it `is_shared`, these are the ranks
  !> of `group`, which form_group made; else it is the owner alone. Collective.
  subroutine wing_hold_response(self, world, i, n_wings, is_2d, is_shared, group)
    class(thin_wing_t), intent(inout) :: self
    type(world_t), intent(in) :: world, group
    integer, intent(in) :: i, n_wings
    logical, intent(in) :: is_2d, is_shared
    self%owner = mod(i - 1, world%size)
    self%is_owner = self%owner == world%rank
    self%is_helper = is_shared .and. .not. self%is_owner .and. mod(world%rank, n_wings) == i - 1
    if (is_shared .and. (self%is_owner .or. self%is_helper)) then
      call self%reaction%response%init(self%markers%n, is_2d, group)
    else if (self%is_owner) then
      call self%reaction%response%init(self%markers%n, is_2d)
    end if
  end subroutine wing_hold_response

  !> Computes the response for markers at `shape` on the ranks that hold it, and updates the reaction of a flexible wing.
  !> `has_factor` is false on the owner if markers are too close together. Collective over the owner and its helpers.
  subroutine wing_build_response(self, green, has_factor)
    class(thin_wing_t), intent(inout) :: self
    type(green_t), intent(in) :: green
    logical, intent(out) :: has_factor
    has_factor = .true.
    if (.not. (self%is_owner .or. self%is_helper)) return
    self%work = self%shape
    if (self%is_mirrored) call mirror_vectors(self%work)
    call self%reaction%response%build(green, self%work, has_factor)
    if (has_factor) call self%update_reaction()
  end subroutine wing_build_response

  !> Updates the reaction of a flexible wing after its response has changed. Collective over the owner and its helpers.
  subroutine wing_update_reaction(self)
    class(thin_wing_t), intent(inout) :: self
    if (self%is_owner) call self%reaction%update_response()
    call self%end_solutions()
  end subroutine wing_update_reaction

  !> Ends the service of the helpers. The owner calls it when it has all solutions that it needs; helpers call it to take part in
  !> the solutions until then. Collective over the owner and its helpers.
  subroutine wing_end_solutions(self)
    class(thin_wing_t), intent(inout) :: self
    if (self%is_owner) call self%reaction%response%release()
    if (self%is_helper) call self%reaction%response%serve()
  end subroutine wing_end_solutions

  !> Returns the forces f(3, n) at the n markers of this wing that cause the velocities v(3, n) at the markers in the absence of
  !> other wings. Both are vectors in space, and `pose` is the pose of the wing. Only the owner sets f. Collective over the owner
  !> and its helpers.
  subroutine wing_solve(self, pose, v, f)
    class(thin_wing_t), intent(inout) :: self
    type(wing_pose_t), intent(in) :: pose
    real(rp), intent(in) :: v(:, :)
    real(rp), intent(inout) :: f(:, :)
    integer :: m
    if (self%is_owner) then
      do m = 1, self%markers%n
        self%work(:, m) = pose%vector_to_wing(v(:, m))
      end do
      if (self%is_mirrored) call mirror_vectors(self%work)
      call self%reaction%response%solve(self%work, f)
      if (self%is_mirrored) call mirror_vectors(f)
      do m = 1, self%markers%n
        f(:, m) = pose%vector_to_space(f(:, m))
      end do
    end if
    call self%end_solutions()
  end subroutine wing_solve
end module fsi_thin_wing
