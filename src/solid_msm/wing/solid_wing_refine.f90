! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the same wing on a mesh of half the size, to estimate the error of the mesh.
module solid_wing_refine
  use base_kinds, only: rp
  use solid_params, only: solid_params_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: refine_wing, refine_params, coarsen_params

contains

  !> Every triangle cut into four and every vein segment into two. Diameters are interpolated linearly, a joint stays at
  !> its point, and the middle of an edge between two root points is a root point. Numbers of old points, veins and
  !> joints stay. parents(2, fine points), where wanted, are the old points between which each lies; twice itself for an
  !> old one.
  subroutine refine_wing(wing, fine, parents)
    type(wing_t), intent(in) :: wing
    type(wing_t), intent(out) :: fine
    integer, allocatable, intent(out), optional :: parents(:, :)
    integer, allocatable :: first(:), next(:), other(:), root(:)
    logical :: is_root(size(wing%points, 2))
    integer :: n, n_old, t, v, k, m(3), capacity
    n_old = size(wing%points, 2)
    capacity = 3*size(wing%triangles, 2)
    do v = 1, size(wing%veins)
      capacity = capacity + size(wing%veins(v)%nodes)
    end do
    ! The middles of a point with higher ones are a list: first(point), next(middle), other(middle).
    allocate (first(n_old), next(n_old + capacity), other(n_old + capacity), source=0)
    allocate (fine%points(3, n_old + capacity), source=0.0_rp)
    fine%points(:, :n_old) = wing%points
    n = n_old
    is_root = .false.
    is_root(wing%root) = .true.
    root = wing%root
    allocate (fine%triangles(3, 4*size(wing%triangles, 2)))
    do t = 1, size(wing%triangles, 2)
      associate (c => wing%triangles(:, t))
        m = [middle(c(1), c(2)), middle(c(2), c(3)), middle(c(3), c(1))]
        fine%triangles(:, 4*t - 3:4*t) = reshape([c(1), m(1), m(3), m(1), c(2), m(2), m(3), m(2), c(3), m], [3, 4])
      end associate
    end do
    fine%veins = wing%veins
    do v = 1, size(wing%veins)
      associate (old => wing%veins(v), new => fine%veins(v))
        deallocate (new%nodes, new%diameters)
        allocate (new%nodes(2*size(old%nodes) - 1), new%diameters(2*size(old%nodes) - 1))
        new%nodes(1::2) = old%nodes
        new%diameters(1::2) = old%diameters
        do k = 2, size(old%nodes)
          new%nodes(2*k - 2) = middle(old%nodes(k - 1), old%nodes(k))
          new%diameters(2*k - 2) = (old%diameters(k - 1) + old%diameters(k))/2
        end do
      end associate
    end do
    fine%joints = wing%joints
    do k = 1, size(wing%joints)
      associate (nodes => wing%joints(k)%nodes)
        fine%joints(k)%nodes = [middle(nodes(1), nodes(2)), nodes(2), middle(nodes(2), nodes(3))]
      end associate
    end do
    fine%root = root
    fine%points = fine%points(:, :n)
    fine%plane_normal = wing%plane_normal
    fine%z_side = wing%z_side
    fine%mass = wing%mass
    if (present(parents)) then
      allocate (parents(2, n))
      parents(1, :n_old) = [(k, k=1, n_old)]
      parents(2, :n_old) = parents(1, :n_old)
      parents(2, n_old + 1:) = other(n_old + 1:n)
      do k = 1, n_old
        t = first(k)
        do while (t > 0)
          parents(1, t) = k
          t = next(t)
        end do
      end do
    end if

  contains

    !> The middle of two old points, made when it is asked for first.
    integer function middle(a, b)
      integer, intent(in) :: a, b
      middle = first(min(a, b))
      do while (middle > 0)
        if (other(middle) == max(a, b)) return
        middle = next(middle)
      end do
      n = n + 1
      middle = n
      fine%points(:, n) = (wing%points(:, a) + wing%points(:, b))/2
      other(n) = max(a, b)
      next(n) = first(min(a, b))
      first(min(a, b)) = n
      if (is_root(a) .and. is_root(b)) root = [root, n]
    end function middle

  end subroutine refine_wing

  !> Parameters of the same wing on that mesh: springs of veins are half as long and twice as stiff; a net of springs
  !> has the same stiffness at any size. Stiffnesses of joints stay, those that are as their vein are made anew.
  pure function refine_params(params) result(fine)
    type(solid_params_t), intent(in) :: params
    type(solid_params_t) :: fine
    fine = params
    fine%k_vein = 2*params%k_vein
  end function refine_params

  !> The reverse, for parameters of which single ones were changed since.
  pure function coarsen_params(fine) result(params)
    type(solid_params_t), intent(in) :: fine
    type(solid_params_t) :: params
    params = fine
    params%k_vein = fine%k_vein/2
  end function coarsen_params
end module solid_wing_refine
