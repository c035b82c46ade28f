! SPDX-License-Identifier: GPL-3.0-or-later
!> The lumped mass of veins and membranes against closed forms.
program test_mass
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use solid_mass, only: mass_params_t, mass_t, lump_mass, frustum
  use solid_wing, only: wing_t, MEMBRANE_BILINEAR, MEMBRANE_UNIFORM
  use solid_wing_refine, only: refine_wing
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: ROUND_OFF = 1.0e-13_rp
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_frustum()
  call test_tapered_vein()
  call test_membrane()
  call test_plate_inertia()
  call test_refined()
  call test_refusals()
  call t%finish()

contains

  !> Closed forms: cylinder, cone, and a frustum as a difference of two cones.
  subroutine test_frustum()
    real(rp) :: volume, centre, big, small
    call frustum(3.0_rp, 2.0_rp, 2.0_rp, volume, centre)
    call t%check_close('volume of a cylinder', volume, 3*PI, rtol=ROUND_OFF)
    call t%check_close('centre of a cylinder', centre, 0.5_rp, rtol=ROUND_OFF)
    call frustum(3.0_rp, 2.0_rp, 0.0_rp, volume, centre)
    call t%check_close('volume of a cone', volume, PI, rtol=ROUND_OFF)
    call t%check_close('centre of a cone', centre, 0.25_rp, rtol=ROUND_OFF)
    ! Radii 2 and 1, length 1: a cone of height 2 without its upper half.
    big = PI*4*2/3
    small = PI*1/3
    call frustum(1.0_rp, 4.0_rp, 2.0_rp, volume, centre)
    call t%check_close('volume of a frustum', volume, big - small, rtol=ROUND_OFF)
    call t%check_close('centre of a frustum', centre, (big*0.5_rp - small*1.25_rp)/(big - small), &
                       rtol=ROUND_OFF)
    call frustum(1.0_rp, 2.0_rp, 4.0_rp, volume, small)
    call t%check_close('the same from the thin end', small, 1 - centre, rtol=ROUND_OFF)
  end subroutine test_frustum

  !> A vein along (1, 2, 2)/3 whose diameter falls linearly from d1 to d2: together the pieces are one
  !> frustum.
  function vein_wing(n, length, d1, d2) result(wing)
    integer, intent(in) :: n
    real(rp), intent(in) :: length, d1, d2
    type(wing_t) :: wing
    real(rp) :: s
    integer :: i
    allocate (wing%points(3, n + 1), wing%triangles(3, 0), wing%veins(1), wing%joints(0))
    wing%root = [1]
    wing%veins(1)%name = 'A'
    allocate (wing%veins(1)%nodes(n + 1), wing%veins(1)%diameters(n + 1))
    do i = 1, n + 1
      s = (i - 1)/real(n, rp)
      s = s*(1 + s)/2 ! pieces of different lengths
      wing%points(:, i) = s*length*[1, 2, 2]/3
      wing%veins(1)%nodes(i) = i
      wing%veins(1)%diameters(i) = d1 + s*(d2 - d1)
    end do
  end function vein_wing

  subroutine test_tapered_vein()
    real(rp), parameter :: L = 9.0e-3_rp, D1 = 1.0e-4_rp, D2 = 2.0e-5_rp
    type(wing_t) :: wing
    type(mass_params_t) :: params
    type(mass_t) :: mass
    type(message_list_t) :: messages
    real(rp) :: volume, centre, inertia(3, 3)
    integer :: n
    call frustum(L, D1, D2, volume, centre)
    do n = 1, 7, 3
      wing = vein_wing(n, L, D1, D2)
      call lump_mass(wing, params, mass, messages)
      call t%check_close('mass of a tapered vein', mass%total, 1300*volume, rtol=ROUND_OFF)
      call t%check_close('its centre along x', mass%centre(1), centre*L/3, rtol=ROUND_OFF)
      call t%check_close('its centre along z', mass%centre(3), centre*L*2/3, rtol=ROUND_OFF)
    end do
    call t%check('no membrane, no message', mass%membrane <= 0 .and. messages%count() == 0)
    inertia = mass%inertia_about([0.0_rp, 0.0_rp, 0.0_rp])
    call t%check_close('parallel axes: inertia about the root', inertia(1, 1), &
                       sum(mass%nodal*(wing%points(2, :)**2 + wing%points(3, :)**2)), rtol=ROUND_OFF)
    call t%check_close('and its product', inertia(1, 2), &
                       -sum(mass%nodal*wing%points(1, :)*wing%points(2, :)), rtol=ROUND_OFF)
  end subroutine test_tapered_vein

  !> A plate a x b in n x n cells, rows skewed so that no two triangles are alike.
  function plate(n, a, b) result(wing)
    integer, intent(in) :: n
    real(rp), intent(in) :: a, b
    type(wing_t) :: wing
    real(rp) :: s, r
    integer :: i, j, k, corner
    allocate (wing%points(3, (n + 1)**2), wing%triangles(3, 2*n**2), wing%veins(0), wing%joints(0))
    wing%root = [1]
    do j = 0, n
      do i = 0, n
        s = i/real(n, rp)
        r = j/real(n, rp)
        k = 1 + i + j*(n + 1)
        wing%points(:, k) = [a*(s + 0.3_rp*s*(1 - s)*r), b*(r + 0.2_rp*r*(1 - r)*s), 0.0_rp]
      end do
    end do
    k = 0
    do j = 1, n
      do i = 1, n
        corner = i + (j - 1)*(n + 1)
        wing%triangles(:, k + 1) = [corner, corner + 1, corner + n + 2]
        wing%triangles(:, k + 2) = [corner, corner + n + 2, corner + n + 1]
        k = k + 2
      end do
    end do
  end function plate

  !> The same wing on a mesh of half the size: mass and centre stay, and every point lies between its parents, each pair
  !> of which has one point. Cones cut in the middle of linear diameters are the same cones.
  subroutine test_refined()
    type(wing_t) :: wing, fine
    type(mass_params_t) :: params
    type(mass_t) :: mass, fine_mass
    type(message_list_t) :: messages
    integer, allocatable :: parents(:, :)
    integer :: i, k, n
    wing = plate(4, 9.0e-3_rp, 3.0e-3_rp)
    wing%root = [1, 6]
    deallocate (wing%veins)
    allocate (wing%veins(1))
    wing%veins(1)%name = 'A'
    wing%veins(1)%nodes = [1, 2, 3, 9, 10]
    wing%veins(1)%diameters = [9.0e-5_rp, 7.0e-5_rp, 6.0e-5_rp, 3.0e-5_rp, 1.0e-5_rp]
    params%membrane_law = MEMBRANE_UNIFORM
    params%areal_density = 3.0e-3_rp
    call refine_wing(wing, fine, parents)
    n = size(wing%points, 2)
    call t%check('a point for every edge', size(fine%points, 2) == n + 4*5*2 + 4**2 .and. &
                 all(shape(parents) == [2, n + 56]))
    call t%check('every point lies between its parents', &
                 maxval(abs(2*fine%points - wing%points(:, parents(1, :)) - &
                            wing%points(:, parents(2, :)))) < 2.0e-18_rp)
    call t%check('old points are their own parents', all(parents(:, :n) == spread([(i, i=1, n)], 1, 2)))
    call t%check('no two points have the same ones', &
                 all([((any(parents(:, i) /= parents(:, k)), k=i + 1, size(parents, 2)), i=1, size(parents, 2))]))
    call t%check('the clamp has no gap', size(fine%root) == 3 .and. all(parents(:, fine%root(3)) == [1, 6]))
    call lump_mass(wing, params, mass, messages)
    call lump_mass(fine, params, fine_mass, messages)
    call t%check('both have a mass', messages%count() == 0 .and. mass%total > 0)
    call t%check_close('the same', fine_mass%total, mass%total, rtol=ROUND_OFF)
    do i = 1, 2
      call t%check_close('its centre', fine_mass%centre(i), mass%centre(i), rtol=ROUND_OFF)
    end do
  end subroutine test_refined

  !> Integrals over the plate of w = w1 + w2 x + w3 y, times 1, x, y.
  subroutine test_membrane()
    real(rp), parameter :: A = 9.0e-3_rp, B = 3.0e-3_rp
    type(wing_t) :: wing
    type(mass_params_t) :: params
    type(mass_t) :: mass
    type(message_list_t) :: messages
    real(rp) :: whole
    wing = plate(5, A, B)
    call lump_mass(wing, params, mass, messages)
    call t%check_close('bilinear membrane: its mass is the one given', mass%membrane, 81.475e-9_rp, &
                       rtol=ROUND_OFF)
    call t%check_close('area', mass%area, A*B, rtol=ROUND_OFF)
    associate (w => params%weights)
      whole = w(1) + w(2)*A/2 + w(3)*B/2
      call t%check_close('centre of mass along x', mass%centre(1), &
                         (w(1)*A/2 + w(2)*A**2/3 + w(3)*A*B/4)/whole, rtol=ROUND_OFF)
      call t%check_close('centre of mass along y', mass%centre(2), &
                         (w(1)*B/2 + w(2)*A*B/4 + w(3)*B**2/3)/whole, rtol=ROUND_OFF)
    end associate
    call t%check_close('thickness of cuticle of this mass', mass%thickness, 81.475e-9_rp/(1300*A*B), &
                       rtol=ROUND_OFF)
    params%membrane_law = MEMBRANE_UNIFORM
    params%areal_density = 2.0e-3_rp
    call lump_mass(wing, params, mass, messages)
    call t%check_close('uniform membrane: mass', mass%total, 2.0e-3_rp*A*B, rtol=ROUND_OFF)
    call t%check_close('centre', mass%centre(1), A/2, rtol=ROUND_OFF)
    call t%check('every point has a share', all(mass%nodal > 0) .and. messages%count() == 0)
  end subroutine test_membrane

  !> m b^2/12, m a^2/12 and their sum: lumping is second order in the mesh size.
  subroutine test_plate_inertia()
    real(rp), parameter :: A = 3.0_rp, B = 2.0_rp
    integer, parameter :: N(3) = [8, 16, 32]
    type(mass_params_t) :: params
    type(mass_t) :: mass
    type(message_list_t) :: messages
    real(rp) :: errors(3, 3)
    integer :: i
    params%membrane_law = MEMBRANE_UNIFORM
    params%areal_density = 0.5_rp
    do i = 1, 3
      call lump_mass(plate(N(i), A, B), params, mass, messages)
      errors(:, i) = abs([mass%inertia(1, 1)/(mass%total*B**2/12) - 1, &
                          mass%inertia(2, 2)/(mass%total*A**2/12) - 1, &
                          mass%inertia(3, 3)/(mass%total*(A**2 + B**2)/12) - 1])
    end do
    call t%check_order('Ixx of a plate', 1.0_rp/N, errors(1, :), 2.0_rp, 0.1_rp)
    call t%check_order('Iyy of a plate', 1.0_rp/N, errors(2, :), 2.0_rp, 0.1_rp)
    call t%check_order('Izz of a plate', 1.0_rp/N, errors(3, :), 2.0_rp, 0.1_rp)
    call t%check_close('a plane: Izz = Ixx + Iyy', mass%inertia(3, 3), &
                       mass%inertia(1, 1) + mass%inertia(2, 2), rtol=ROUND_OFF)
    call t%check_close('Ixy vanishes to second order', mass%inertia(1, 2), 0.0_rp, &
                       atol=0.01_rp*mass%inertia(3, 3))
  end subroutine test_plate_inertia

  subroutine test_refusals()
    type(mass_params_t) :: params
    type(mass_t) :: mass
    type(message_list_t) :: messages
    call lump_mass(plate(4, 2.0e-2_rp, 3.0e-3_rp), params, mass, messages)
    call t%check('a wing so long that the bilinear law gets negative is refused', messages%count() == 1)
    if (messages%count() == 1) call t%check('with the point named', index(messages%text(1), 'point 4 ') > 0)
    params%membrane_law = MEMBRANE_UNIFORM
    params%areal_density = 0
    call lump_mass(plate(4, 2.0e-3_rp, 3.0e-3_rp), params, mass, messages)
    call t%check('no areal density is refused', messages%count() == 2)
    params%membrane_law = MEMBRANE_BILINEAR
    params%membrane_mass = -1
    call lump_mass(plate(4, 2.0e-3_rp, 3.0e-3_rp), params, mass, messages)
    call t%check('a negative mass of the membrane is refused', messages%count() == 3)
    params%vein_density = 0
    call lump_mass(vein_wing(2, 1.0_rp, 1.0e-2_rp, 1.0e-2_rp), params, mass, messages)
    call t%check('veins without density are refused', messages%count() == 4)
    params%membrane_law = 0
    params%vein_density = 1
    call lump_mass(plate(4, 2.0e-3_rp, 3.0e-3_rp), params, mass, messages)
    call t%check('an unknown law is refused', messages%count() == 5)
  end subroutine test_refusals
end program test_mass
