! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the mass of a wing, lumped to its points so that total mass and centre of mass are kept exactly.
!>
!> Veins: every segment is a conical frustum of cuticle of length l and end radii r1, r2,
!>   m = rho pi l (r1^2 + r1 r2 + r2^2)/3,  with its centre  h = l (r1^2 + 2 r1 r2 + 3 r2^2)/
!>   (4 (r1^2 + r1 r2 + r2^2))  behind end 1;
!> end 2 gets m h/l and end 1 the rest. Membrane: an areal density that is constant, or proportional to w(x, y) = w1 + w2 x + w3 y
!> and scaled to a given mass, enters through its exact integrals with the linear shape functions of the triangles, A (2 w_i + w_j +
!> w_k)/12. The weights are those that Truong et al. give for a blowfly wing, x from the wing root and y from the rotation axis.
!> (Their text omits the division of h by l, and gives the density of the membrane per point and in kg, for which the membrane would
!> weigh 80 mg.)
module solid_mass
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use solid_wing, only: vein_t, wing_t, MEMBRANE_BILINEAR, MEMBRANE_UNIFORM
  implicit none
  private
  public :: mass_params_t, mass_t, lump_mass, frustum

  !> Properties of the wing's mass; the defaults are the blowfly wing of 250 ug whose membrane is 32.59 % of it.
  type :: mass_params_t
    real(rp) :: vein_density = 1300.0_rp       !< of cuticle [kg/m^3]
    integer :: membrane_law = MEMBRANE_BILINEAR !< with a given mass; MEMBRANE_UNIFORM: with a given areal density
    real(rp) :: membrane_mass = 81.475e-9_rp   !< [kg], for MEMBRANE_BILINEAR
    real(rp) :: weights(3) = [1.75_rp, -147.0_rp, 101.0_rp] !< w1 [-], w2 [1/m], w3 [1/m]
    real(rp) :: areal_density = 3.0e-3_rp      !< [kg/m^2], for MEMBRANE_UNIFORM
    real(rp) :: vein_factor = 1, membrane_factor = 1 !< on both
    real(rp) :: gradient = 0                   !< g: membrane times exp(g (x/R - 1/2)), R the extent along x from the root
    real(rp) :: point(3) = 0                   !< x, y [m] and mass [kg] of an object on the wing
  end type mass_params_t

  !> The lumped mass.
  type :: mass_t
    real(rp), allocatable :: nodal(:) !< mass of every point [kg], positive
    real(rp), allocatable :: of_veins(:) !< the part of it that is veins [kg]
    real(rp), allocatable :: of_point(:) !< the part of the object on the wing [kg]
    real(rp) :: veins = 0             !< [kg]
    real(rp) :: membrane = 0          !< [kg]
    real(rp) :: total = 0             !< [kg]
    real(rp) :: area = 0              !< of the membrane [m^2]
    real(rp) :: thickness = 0         !< mean thickness of the membrane if it has the density of the veins [m]
    real(rp) :: centre(3) = 0         !< centre of mass [m]
    real(rp) :: inertia(3, 3) = 0     !< about the centre of mass [kg m^2]
  contains
    procedure :: inertia_about => mass_inertia_about
  end type mass_t

contains

  !> Lumps the mass of a wing to its points. If a point has no positive mass, a message says so, and `mass` is undefined.
  subroutine lump_mass(wing, params, mass, messages)
    type(wing_t), intent(in) :: wing
    type(mass_params_t), intent(in) :: params
    type(mass_t), intent(out) :: mass
    type(message_list_t), intent(inout) :: messages
    integer :: i, n_before
    n_before = messages%count()
    call check_params(wing, params, messages)
    if (messages%count() > n_before) return
    allocate (mass%nodal(size(wing%points, 2)))
    mass%nodal = 0
    do i = 1, size(wing%veins)
      call add_vein(wing%points, wing%veins(i), params%vein_factor*params%vein_density, mass%nodal)
    end do
    mass%veins = sum(mass%nodal)
    mass%of_veins = mass%nodal
    if (size(wing%triangles) > 0) call add_membrane(wing, params, mass, messages)
    if (messages%count() > n_before) return
    call add_point(wing, params%point, mass, messages)
    if (messages%count() > n_before) return
    mass%total = mass%veins + mass%membrane + sum(mass%of_point)
    if (mass%area > 0) mass%thickness = mass%membrane/(mass%area*params%vein_density)
    do i = 1, size(mass%nodal)
      if (mass%nodal(i) > 0) cycle
      call messages%add('mass: point '//number_text(i)// &
                        ' (counted from 1) has no mass: give the veins or the membrane a mass there')
      return
    end do
    mass%centre = matmul(wing%points, mass%nodal)/mass%total
    mass%inertia = inertia_of(wing%points, mass%nodal, mass%centre)
  end subroutine lump_mass

  !> Adds messages about densities and masses that are not positive.
  subroutine check_params(wing, params, messages)
    type(wing_t), intent(in) :: wing
    type(mass_params_t), intent(in) :: params
    type(message_list_t), intent(inout) :: messages
    if (size(wing%veins) > 0 .and. .not. params%vein_density > 0) &
      call messages%add('mass: the density of the veins is '//number_text(params%vein_density)// &
                        ' kg/m^3; it must be positive')
    if (size(wing%triangles) == 0) return
    if (params%membrane_law == MEMBRANE_BILINEAR .and. .not. params%membrane_mass > 0) &
      call messages%add('mass: the mass of the membrane is '//number_text(params%membrane_mass)// &
                        ' kg; it must be positive')
    if (params%membrane_law == MEMBRANE_UNIFORM .and. .not. params%areal_density > 0) &
      call messages%add('mass: the areal density of the membrane is '//number_text(params%areal_density)// &
                        ' kg/m^2; it must be positive')
    if (all(params%membrane_law /= [MEMBRANE_BILINEAR, MEMBRANE_UNIFORM])) &
      call messages%add('mass: the law of the membrane is '//number_text(params%membrane_law)// &
                        '; valid: 1, 2')
  end subroutine check_params

  !> Returns the volume [m^3] of a conical frustum of `length` [m] between the diameters `d1` and `d2` [m], and the distance of
  !> its centre from end 1, divided by the length.
  pure subroutine frustum(length, d1, d2, volume, centre)
    real(rp), intent(in) :: length, d1, d2
    real(rp), intent(out) :: volume, centre
    real(rp) :: squares
    squares = d1**2 + d1*d2 + d2**2
    volume = PI*length*squares/12
    centre = (d1**2 + 2*d1*d2 + 3*d2**2)/(4*squares)
  end subroutine frustum

  !> Adds the mass of a vein to its points.
  pure subroutine add_vein(points, vein, density, nodal)
    real(rp), intent(in) :: points(:, :), density
    type(vein_t), intent(in) :: vein
    real(rp), intent(inout) :: nodal(:)
    real(rp) :: volume, centre
    integer :: i, a, b
    do i = 2, size(vein%nodes)
      a = vein%nodes(i - 1)
      b = vein%nodes(i)
      call frustum(norm2(points(:, b) - points(:, a)), vein%diameters(i - 1), vein%diameters(i), volume, &
                   centre)
      nodal(a) = nodal(a) + density*volume*(1 - centre)
      nodal(b) = nodal(b) + density*volume*centre
    end do
  end subroutine add_vein

  !> Adds the mass of the membrane to its points.
  subroutine add_membrane(wing, params, mass, messages)
    type(wing_t), intent(in) :: wing
    type(mass_params_t), intent(in) :: params
    type(mass_t), intent(inout) :: mass
    type(message_list_t), intent(inout) :: messages
    real(rp) :: weights(size(wing%points, 2)), membrane_nodal(size(wing%points, 2)), area, scale, root, span
    integer :: t, k
    if (params%membrane_law == MEMBRANE_BILINEAR) then
      weights = params%weights(1) + params%weights(2)*wing%points(1, :) + params%weights(3)*wing%points(2, :)
    else
      weights = 1
    end if
    do k = 1, size(weights)
      if (weights(k) > 0) cycle
      call messages%add('mass: the areal density of the membrane is not positive at point '// &
                        number_text(k)//' (counted from 1), x = '// &
                        number_text(wing%points(1, k))//' m, y = '// &
                        number_text(wing%points(2, k))//' m; use other weights or a constant density')
      return
    end do
    membrane_nodal = 0
    do t = 1, size(wing%triangles, 2)
      associate (c => wing%triangles(:, t))
        area = triangle_area(wing%points(:, c))
        mass%area = mass%area + area
        do k = 1, 3
          membrane_nodal(c(k)) = membrane_nodal(c(k)) + area*(sum(weights(c)) + weights(c(k)))/12
        end do
      end associate
    end do
    scale = params%areal_density
    if (params%membrane_law == MEMBRANE_BILINEAR) scale = params%membrane_mass/sum(membrane_nodal)
    root = sum(wing%points(1, wing%root))/max(1, size(wing%root))
    span = maxval(wing%points(1, :)) - minval(wing%points(1, :))
    membrane_nodal = scale*params%membrane_factor*exp(params%gradient*((wing%points(1, :) - root)/span - 0.5_rp))*membrane_nodal
    mass%nodal = mass%nodal + membrane_nodal
    mass%membrane = sum(membrane_nodal)
  end subroutine add_membrane

  !> Distributes the mass of an object on the wing to the corners of its triangle, or to the nearest point of a wing without
  !> triangles.
  subroutine add_point(wing, point, mass, messages)
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: point(3)
    type(mass_t), intent(inout) :: mass
    type(message_list_t), intent(inout) :: messages
    real(rp), parameter :: TOLERANCE = 1.0e-9_rp
    real(rp) :: w(3), place(3), area
    integer :: t, k
    allocate (mass%of_point(size(mass%nodal)), source=0.0_rp)
    if (.not. abs(point(3)) > 0) return
    place = [point(:2), 0.0_rp]
    do t = 1, size(wing%triangles, 2)
      associate (a => wing%points(:2, wing%triangles(1, t)), b => wing%points(:2, wing%triangles(2, t)), &
                 c => wing%points(:2, wing%triangles(3, t)))
        area = twice(a, b, c)
        w = [twice(place(:2), b, c), twice(a, place(:2), c), twice(a, b, place(:2))]/area
      end associate
      if (minval(w) < -TOLERANCE) cycle
      mass%of_point(wing%triangles(:, t)) = w*point(3)
      exit
    end do
    if (size(wing%triangles) == 0) then
      k = minloc(sum((wing%points(:2, :) - spread(place(:2), 2, size(wing%points, 2)))**2, 1), 1)
      mass%of_point(k) = point(3)
    end if
    if (.not. any(abs(mass%of_point) > 0)) call messages%add('mass: the point mass at x = '//number_text(point(1))// &
                                                              ' m, y = '//number_text(point(2))//' m is not on the wing')
    mass%nodal = mass%nodal + mass%of_point

  contains

    pure real(rp) function twice(p, q, r)
      real(rp), intent(in) :: p(2), q(2), r(2)
      twice = (q(1) - p(1))*(r(2) - p(2)) - (q(2) - p(2))*(r(1) - p(1))
    end function twice
  end subroutine add_point

  !> Returns the area [m^2] of the triangle with the corners corners(:, 1:3).
  pure real(rp) function triangle_area(corners) result(area)
    real(rp), intent(in) :: corners(3, 3)
    real(rp) :: a(3), b(3)
    a = corners(:, 2) - corners(:, 1)
    b = corners(:, 3) - corners(:, 1)
    area = norm2([a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)])/2
  end function triangle_area

  !> Returns the inertia tensor [kg m^2] of point masses about `origin`.
  pure function inertia_of(points, nodal, origin) result(inertia)
    real(rp), intent(in) :: points(:, :), nodal(:), origin(3)
    real(rp) :: inertia(3, 3), r(3)
    integer :: i, k
    inertia = 0
    do i = 1, size(nodal)
      r = points(:, i) - origin
      do k = 1, 3
        inertia(:, k) = inertia(:, k) - nodal(i)*r*r(k)
        inertia(k, k) = inertia(k, k) + nodal(i)*dot_product(r, r)
      end do
    end do
  end function inertia_of

  !> Returns the inertia tensor [kg m^2] about another point [m], by the parallel axis theorem.
  pure function mass_inertia_about(self, point) result(inertia)
    class(mass_t), intent(in) :: self
    real(rp), intent(in) :: point(3)
    real(rp) :: inertia(3, 3)
    real(rp) :: points(3, 1)
    points(:, 1) = self%centre
    inertia = self%inertia + inertia_of(points, [self%total], point)
  end function mass_inertia_about
end module solid_mass
