! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the same wing on a mesh with half the edge length, to estimate the error of the mesh.
module solid_wing_refine
  use base_kinds, only: rp
  use solid_params, only: solid_params_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: refine_wing, refine_params, coarsen_params, equal_rotation

  !> The points of the fine mesh during its construction: the old points, and midpoints of two of them. The midpoints between a
  !> point and points with higher numbers form a linked list: first(point), next(midpoint); other(midpoint) is the point with the
  !> higher number.
  type :: fine_points_t
    integer :: n_old = 0, n = 0
    real(rp), allocatable :: points(:, :) !< (3, :) [m] the first n
    integer, allocatable :: first(:), next(:), other(:)
    logical, allocatable :: is_root(:)    !< the first n
  contains
    procedure :: init => fine_init
    procedure :: make_middle => fine_make_middle
    procedure :: parents => fine_parents
  end type fine_points_t

contains

  !> Cuts every triangle into four and every vein segment into two. Diameters are interpolated linearly, a joint stays at its point,
  !> and the middle of an edge between two root points is a root point. Old points, veins and joints keep their numbers. parents(2,
  !> fine points), if present, are the two old points between which each point lies; for an old point both are itself.
  subroutine refine_wing(wing, fine, parents)
    type(wing_t), intent(in) :: wing
    type(wing_t), intent(out) :: fine
    integer, allocatable, intent(out), optional :: parents(:, :)
    type(fine_points_t) :: made
    integer :: k
    call made%init(wing)
    call refine_triangles(wing, made, fine)
    call refine_veins(wing, made, fine)
    call refine_joints(wing, made, fine)
    fine%points = made%points(:, :made%n)
    fine%root = [wing%root, pack([(k, k=made%n_old + 1, made%n)], made%is_root(made%n_old + 1:made%n))]
    fine%plane_normal = wing%plane_normal
    fine%z_side = wing%z_side
    fine%mass = wing%mass
    if (present(parents)) parents = made%parents()
  end subroutine refine_wing

  !> Divides every triangle into four.
  subroutine refine_triangles(wing, made, fine)
    type(wing_t), intent(in) :: wing
    type(fine_points_t), intent(inout) :: made
    type(wing_t), intent(inout) :: fine
    integer :: t, k, m(3)
    allocate (fine%triangles(3, 4*size(wing%triangles, 2)))
    do t = 1, size(wing%triangles, 2)
      associate (c => wing%triangles(:, t))
        do k = 1, 3
          call made%make_middle(c(k), c(mod(k, 3) + 1), m(k))
        end do
        fine%triangles(:, 4*t - 3:4*t) = reshape([c(1), m(1), m(3), m(1), c(2), m(2), m(3), m(2), c(3), m], [3, 4])
      end associate
    end do
  end subroutine refine_triangles

  !> Divides every segment of the veins into two.
  subroutine refine_veins(wing, made, fine)
    type(wing_t), intent(in) :: wing
    type(fine_points_t), intent(inout) :: made
    type(wing_t), intent(inout) :: fine
    integer :: v, k
    fine%veins = wing%veins
    do v = 1, size(wing%veins)
      associate (old => wing%veins(v), new => fine%veins(v))
        deallocate (new%nodes, new%diameters)
        allocate (new%nodes(2*size(old%nodes) - 1), new%diameters(2*size(old%nodes) - 1))
        new%nodes(1::2) = old%nodes
        new%diameters(1::2) = old%diameters
        do k = 2, size(old%nodes)
          call made%make_middle(old%nodes(k - 1), old%nodes(k), new%nodes(2*k - 2))
          new%diameters(2*k - 2) = (old%diameters(k - 1) + old%diameters(k))/2
        end do
      end associate
    end do
  end subroutine refine_veins

  !> Gives the joints the new neighbours of their points.
  subroutine refine_joints(wing, made, fine)
    type(wing_t), intent(in) :: wing
    type(fine_points_t), intent(inout) :: made
    type(wing_t), intent(inout) :: fine
    integer :: j
    fine%joints = wing%joints
    do j = 1, size(wing%joints)
      associate (old => wing%joints(j)%nodes, new => fine%joints(j)%nodes)
        call made%make_middle(old(1), old(2), new(1))
        call made%make_middle(old(2), old(3), new(3))
      end associate
    end do
  end subroutine refine_joints

  !> Takes the old points, and makes room for the middles of all edges.
  pure subroutine fine_init(self, wing)
    class(fine_points_t), intent(inout) :: self
    type(wing_t), intent(in) :: wing
    integer :: capacity, v
    capacity = size(wing%points, 2) + 3*size(wing%triangles, 2)
    do v = 1, size(wing%veins)
      capacity = capacity + size(wing%veins(v)%nodes)
    end do
    self%n_old = size(wing%points, 2)
    self%n = self%n_old
    allocate (self%first(self%n_old), self%next(capacity), self%other(capacity), source=0)
    allocate (self%points(3, capacity), source=0.0_rp)
    allocate (self%is_root(capacity), source=.false.)
    self%points(:, :self%n) = wing%points
    self%is_root(wing%root) = .true.
  end subroutine fine_init

  !> Returns the number of the middle of two old points. The first call for a pair makes it.
  pure subroutine fine_make_middle(self, a, b, middle)
    class(fine_points_t), intent(inout) :: self
    integer, intent(in) :: a, b
    integer, intent(out) :: middle
    middle = self%first(min(a, b))
    do while (middle > 0)
      if (self%other(middle) == max(a, b)) return
      middle = self%next(middle)
    end do
    self%n = self%n + 1
    middle = self%n
    self%points(:, middle) = (self%points(:, a) + self%points(:, b))/2
    self%is_root(middle) = self%is_root(a) .and. self%is_root(b)
    self%other(middle) = max(a, b)
    self%next(middle) = self%first(min(a, b))
    self%first(min(a, b)) = middle
  end subroutine fine_make_middle

  !> Returns the old points (2, n) between which each point lies.
  pure function fine_parents(self) result(parents)
    class(fine_points_t), intent(in) :: self
    integer, allocatable :: parents(:, :)
    integer :: k, middle
    allocate (parents(2, self%n))
    parents(1, :self%n_old) = [(k, k=1, self%n_old)]
    parents(2, :self%n_old) = parents(1, :self%n_old)
    parents(2, self%n_old + 1:) = self%other(self%n_old + 1:self%n)
    do k = 1, self%n_old
      middle = self%first(k)
      do while (middle > 0)
        parents(1, middle) = k
        middle = self%next(middle)
      end do
    end do
  end function fine_parents

  !> Returns the parameters of the same wing on that mesh. Springs of veins are half as long and twice as stiff; a net of springs
  !> has the same stiffness at any size. Stiffnesses of joints stay, except that joints as stiff as their vein get the stiffness of
  !> the vein on the new mesh.
  pure function refine_params(params) result(fine)
    type(solid_params_t), intent(in) :: params
    type(solid_params_t) :: fine
    fine = params
    fine%k_vein = 2*params%k_vein
  end function refine_params

  !> Does the reverse of `refine_params`; single parameters may have changed in between.
  pure function coarsen_params(fine) result(params)
    type(solid_params_t), intent(in) :: fine
    type(solid_params_t) :: params
    params = fine
    params%k_vein = fine%k_vein/2
  end function coarsen_params

  !> Returns the stiffness of a hinge that turns as much more than a hinge of stiffness `to` as one of stiffness k turns more than
  !> one of stiffness `from`: 1/x - 1/to = 1/k - 1/from. `from` and `to` are those of a joint as stiff as its vein on two meshes; a
  !> joint whose stiffness is stated has the same on both. The result is 0 if there is no such hinge, because k is too stiff.
  pure real(rp) function equal_rotation(k, from, to) result(x)
    real(rp), intent(in) :: k, from, to
    real(rp) :: compliance
    compliance = 1/to + (1/k - 1/from)
    x = 0
    if (compliance > 0) x = 1/compliance
  end function equal_rotation
end module solid_wing_refine
