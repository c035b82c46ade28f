! SPDX-License-Identifier: GPL-3.0-or-later
!> Structures for tests and benchmarks: beams and a wing of a fly's size with a mapped mesh.
module sample_wings
  use base_kinds, only: rp
  use solid_wing, only: wing_t, vein_t, joint_t
  implicit none
  private
  public :: make_beam, make_fly_wing

contains

  !> A cantilever of n equal segments from the origin along `direction`; the section gives EI for
  !> Young's modulus E with the diameter d: EI = E pi d^4/64. The first point is clamped.
  function make_beam(n, length, diameter, direction) result(wing)
    integer, intent(in) :: n
    real(rp), intent(in) :: length, diameter, direction(3)
    type(wing_t) :: wing
    integer :: i
    allocate (wing%points(3, n + 1), wing%triangles(3, 0), wing%veins(1), wing%joints(0))
    do i = 0, n
      wing%points(:, i + 1) = (length*i/n)*direction/norm2(direction)
    end do
    wing%veins(1)%name = 'beam'
    wing%veins(1)%nodes = [(i, i=1, n + 1)]
    allocate (wing%veins(1)%diameters(n + 1), source=diameter)
    wing%root = [1]
  end function make_beam

  !> A fly-like wing of R = 9 mm and 27 mm^2 on a mapped mesh of (nx+1)(ny+1) points, ny >= 12,
  !> nx >= 24: seven tapering veins of which three are clamped with two points each, ten joints.
  function make_fly_wing(nx, ny) result(wing)
    integer, intent(in) :: nx, ny
    type(wing_t) :: wing
    real(rp), parameter :: R = 9.0e-3_rp, CHORD = 3.75e-3_rp
    integer :: i, j, t, costa, r1, r45, m, cu, rm, dmcu, first_m, first_r1
    real(rp) :: xi, local_chord

    allocate (wing%points(3, (nx + 1)*(ny + 1)), wing%triangles(3, 2*nx*ny))
    t = 0
    do j = 0, ny
      do i = 0, nx
        xi = real(i, rp)/nx
        local_chord = CHORD*sqrt(1 - ((xi - 0.53_rp)/0.58_rp)**2)
        wing%points(:, id(i, j)) = [R*xi, 0.35_rp*CHORD + local_chord*(real(j, rp)/ny - 1) &
                                    - 0.2_rp*(CHORD - local_chord), 0.0_rp]
        if (i == nx .or. j == ny) cycle
        if (mod(i + j, 2) == 0) then
          wing%triangles(:, t + 1) = [id(i, j), id(i + 1, j), id(i + 1, j + 1)]
          wing%triangles(:, t + 2) = [id(i, j), id(i + 1, j + 1), id(i, j + 1)]
        else
          wing%triangles(:, t + 1) = [id(i, j), id(i + 1, j), id(i, j + 1)]
          wing%triangles(:, t + 2) = [id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]
        end if
        t = t + 2
      end do
    end do
    costa = ny
    r1 = ny - 2
    r45 = ny - 5
    m = ny/2 - 1
    cu = 2
    rm = (9*nx)/20
    dmcu = (13*nx)/20
    first_r1 = nx/12
    first_m = nx/8
    allocate (wing%veins(8), wing%joints(10))
    wing%veins(1) = vein('C', [(id(i, costa), i=0, nx)], 100.0_rp, 30.0_rp)
    wing%veins(2) = vein('R1', [(id(first_r1, j), j=costa, r1 + 1, -1), (id(i, r1), i=first_r1, (7*nx)/10)], &
                         70.0_rp, 30.0_rp)
    wing%veins(3) = vein('R4+5', [(id(i, r45), i=0, nx)], 85.0_rp, 25.0_rp)
    wing%veins(4) = vein('M', [(id(first_m, j), j=r45, m + 1, -1), (id(i, m), i=first_m, (9*nx)/10)], &
                         60.0_rp, 20.0_rp)
    wing%veins(5) = vein('CuA', [(id(i, cu), i=0, (3*nx)/4)], 70.0_rp, 20.0_rp)
    wing%veins(6) = vein('r-m', [(id(rm, j), j=r45, m, -1)], 35.0_rp, 30.0_rp)
    wing%veins(7) = vein('dm-cu', [(id(dmcu, j), j=m, cu, -1)], 30.0_rp, 30.0_rp)
    wing%veins(8) = vein('h', [(id(nx/4, j), j=costa, r1, -1)], 30.0_rp, 30.0_rp)
    wing%joints(1) = joint('J1', id(nx/5 - 1, costa), id(nx/5, costa), id(nx/5 + 1, costa))
    wing%joints(2) = joint('J2', id(nx/6 - 1, r1), id(nx/6, r1), id(nx/6 + 1, r1))
    wing%joints(3) = joint('J3', id(nx/10 - 1, r45), id(nx/10, r45), id(nx/10 + 1, r45))
    wing%joints(4) = joint('J4', id(nx/2 - 1, r45), id(nx/2, r45), id(nx/2 + 1, r45))
    wing%joints(5) = joint('J5', id(nx/4 - 1, m), id(nx/4, m), id(nx/4 + 1, m))
    wing%joints(6) = joint('J6', id(nx/2 + 1, m), id(nx/2 + 2, m), id(nx/2 + 3, m))
    wing%joints(7) = joint('J7', id(nx/10 - 1, cu), id(nx/10, cu), id(nx/10 + 1, cu))
    wing%joints(8) = joint('J8', id(nx/2, cu), id(nx/2 + 1, cu), id(nx/2 + 2, cu))
    wing%joints(9) = joint('J9', id(rm - 1, r45), id(rm, r45), id(rm, r45 - 1))
    wing%joints(10) = joint('J10', id(dmcu - 1, m), id(dmcu, m), id(dmcu, m - 1))
    wing%root = [id(0, costa), id(1, costa), id(0, r45), id(1, r45), id(0, cu), id(1, cu)]

  contains

    pure integer function id(column, row)
      integer, intent(in) :: column, row
      id = row*(nx + 1) + column + 1
    end function id

  end function make_fly_wing

  function vein(name, nodes, first, last) result(v)
    character(*), intent(in) :: name
    integer, intent(in) :: nodes(:)
    real(rp), intent(in) :: first, last ! diameters [um]
    type(vein_t) :: v
    integer :: i, n
    n = size(nodes)
    v%name = name
    v%nodes = nodes
    v%diameters = [(1.0e-6_rp*(first + (last - first)*real(i - 1, rp)/(n - 1)), i=1, n)]
  end function vein

  function joint(name, a, b, c) result(j)
    character(*), intent(in) :: name
    integer, intent(in) :: a, b, c
    type(joint_t) :: j
    j%name = name
    j%nodes = [a, b, c]
  end function joint
end module sample_wings
