! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the stiffness of all elements of a model, or its derivative with respect to a parameter.
module solid_element_stiffness
  use base_kinds, only: rp
  use solid_extension, only: extensions_t
  use solid_junctions, only: hinge_plan_t
  implicit none
  private
  public :: stiffness_t, allocate_stiffness, clear_stiffness

  !> One number for every element, and a second one for hinges that are not linear.
  type :: stiffness_t
    real(rp), allocatable :: extension(:) !< [N/m]
    real(rp), allocatable :: hinge(:)     !< [N m/rad]
    real(rp), allocatable :: hardening(:) !< [1/rad^2] cubic over hinge, the sum of all effects
    real(rp), allocatable :: cubic(:)     !< [N m/rad^3] of hinges; 0: linear
    real(rp), allocatable :: lift(:)      !< [N m/rad] additional stiffness of hinges that bend up
    real(rp) :: plate = 0                 !< [N m]
    real(rp), allocatable :: edge(:)      !< (edges) [N m] additional stiffness of the plate at single edges
    logical :: has_edges = .false.        !< any of them is not 0
    real(rp), allocatable :: tension(:)   !< (springs) [N] of springs that have their length of the unloaded wing
    real(rp), allocatable :: arch(:)      !< (edges) [N m] moment that bends edges: see solid_arch
    real(rp), allocatable :: camber_moment(:)       !< (hinges) [N m] moment that bends them upward
    real(rp), allocatable :: twist(:)     !< (hinges) [N m/rad] see solid_twist
    logical :: has_tension = .false., has_arch = .false., has_twist = .false. !< any of them is not 0
  end type stiffness_t

contains

  !> Allocates the stiffness of all elements of a model; it is 0.
  pure subroutine allocate_stiffness(springs, plans, n_edges, self)
    type(extensions_t), intent(in) :: springs
    type(hinge_plan_t), intent(in) :: plans(:)
    integer, intent(in) :: n_edges
    type(stiffness_t), intent(out) :: self
    allocate (self%extension(springs%n), self%hinge(size(plans)), self%hardening(size(plans)), self%cubic(size(plans)), &
              self%lift(size(plans)), self%edge(n_edges), self%tension(springs%n), self%arch(n_edges), &
              self%twist(size(plans)), self%camber_moment(size(plans)), source=0.0_rp)
  end subroutine allocate_stiffness

  !> Sets all stiffness to 0.
  pure subroutine clear_stiffness(self)
    type(stiffness_t), intent(inout) :: self
    self%extension = 0
    self%hinge = 0
    self%hardening = 0
    self%cubic = 0
    self%lift = 0
    self%plate = 0
    self%edge = 0
    self%has_edges = .false.
    self%tension = 0
    self%arch = 0
    self%camber_moment = 0
    self%twist = 0
    self%has_tension = .false.
    self%has_arch = .false.
    self%has_twist = .false.
  end subroutine clear_stiffness
end module solid_element_stiffness
