! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the bodies that FLUSI knows by name. To add one, add its name to NAMED_BODIES and a case to `make_named_body`.
!>
!> The numbers are FLUSI's, whose unit is the wing length or the body length; sources are named beside them. Body axes: x
!> forward, y left, z up.
module fsi_body_catalogue
  use base_constants, only: PI
  use base_kinds, only: rp
  use fsi_bent_body, only: make_beetle, make_fly, make_straight_fly, STYLE_FLAT, STYLE_ROUND, STYLE_SLIM
  use fsi_body_parts, only: make_barrel, make_disk, make_ellipsoid, make_plate, make_rod, make_sphere, make_spindle
  use fsi_shell_bodies, only: make_cone, make_pyramid
  use fsi_solid_shape, only: shape_holder_t, solid_shape_t
  implicit none
  private
  public :: body_numbers_t, make_named_body, named_body_pivot, NAMED_BODIES

  character(*), parameter :: NAMED_BODIES = 'ellipsoid|sphere|Sphere|SPHERE|jerry|Jerry|hawkmoth|Hawkmoth|bumblebee|drosophila|'// &
                             'drosophila_maeda|drosophila_slim|mosquito_iams|paratuposa_simple|suzuki_thin_rod|coin|'// &
                             'platicle|pyramid|cone'

  !> Values of the parameter file that some bodies use. Lengths in L.
  type :: body_numbers_t
    real(rp) :: length = 1           !< L_body
    real(rp) :: radius = 0.1_rp      !< b_body
    real(rp) :: head_radius = 0      !< R_head, 0: no head
    real(rp) :: eye_radius = 0       !< R_eye, 0: no eyes
    real(rp) :: head(3) = 0, eyes(3, 2) = 0
    real(rp) :: span = 0             !< L_span
    real(rp) :: thickness = 0        !< WingThickness
    real(rp) :: eta = 0              !< eta0, rad
    logical :: has_legs = .true.     !< HasDetails
    real(rp) :: smoothing = 0        !< h
  end type body_numbers_t

contains

  !> Returns the parts of the body called `name`, which is one of NAMED_BODIES.
  subroutine make_named_body(name, numbers, parts)
    character(*), intent(in) :: name
    type(body_numbers_t), intent(in) :: numbers
    type(shape_holder_t), allocatable, intent(out) :: parts(:)
    real(rp), parameter :: ORIGIN(3) = 0, MIDDLE(3) = [0.5_rp, 0.0_rp, 0.0_rp]
    real(rp) :: margin, half_width
    allocate (parts(0))
    margin = 3.5_rp*numbers%smoothing
    select case (name)
    case ('ellipsoid')
      call add(parts, make_ellipsoid(ORIGIN, [numbers%length/2, numbers%radius, numbers%radius]))
      if (numbers%head_radius > 0) call add(parts, make_sphere(numbers%head, numbers%head_radius))
      if (numbers%eye_radius > 0) call add_eyes(parts, numbers%eyes, numbers%eye_radius)
    case ('sphere', 'Sphere', 'SPHERE')
      call add(parts, make_sphere(ORIGIN, numbers%length/2))
    case ('jerry', 'Jerry')
      call add(parts, make_spindle(ORIGIN, 0.5_rp, 0.1_rp))
      call add(parts, make_sphere(MIDDLE, 0.125_rp))
      call add_eyes(parts, spread(MIDDLE, 2, 2) + cheeks(0.8_rp*0.125_rp), 0.0625_rp)
    case ('hawkmoth', 'Hawkmoth')
      call add(parts, make_spindle(ORIGIN, 0.5_rp, 0.15_rp))
      call add(parts, make_sphere(MIDDLE, 0.125_rp))
      call add_pair(parts, MIDDLE + first(cheeks(1.8_rp*0.125_rp)), MIDDLE + first(cheeks(0.8_rp*0.125_rp)), 0.0195_rp)
    case ('bumblebee')
      ! BB1 of Dudley & Ellington (1990), J. Exp. Biol. 148, 19-52.
      call add(parts, make_fly([0.0782301255230126_rp, -1.26512552301255_rp], 1.3_rp, 1.2_rp, STYLE_FLAT, margin))
      call add(parts, make_spindle([0.58125_rp, 0.0_rp, -0.1_rp], 0.10175_rp, 0.1485_rp, squeeze=1.04_rp))
      if (numbers%has_legs) call add_legs(parts)
    case ('drosophila')
      call add(parts, make_straight_fly())
    case ('drosophila_maeda', 'drosophila_slim')
      half_width = merge(1.09_rp, 1.0_rp, name == 'drosophila_slim')
      call add(parts, make_fly([-0.24476987447698745_rp, -0.9301255230125524_rp], 0.9464435146443515_rp, 0.8158996_rp, &
                               merge(STYLE_SLIM, STYLE_ROUND, name == 'drosophila_slim'), margin))
      call add(parts, make_spindle([0.17_rp, 0.0_rp, -0.1_rp], 0.0925_rp, 0.135_rp, squeeze=half_width))
    case ('mosquito_iams')
      ! Iams (2014), SIAM J. Appl. Math. 74(5), 1535-1550; the origin is the centre of gravity.
      call add(parts, make_sphere([0.5652_rp, 0.0_rp, -0.0434_rp], 0.1154_rp))
      call add(parts, make_spindle([0.2579_rp, 0.0_rp, 0.1267_rp], 0.2628_rp, 0.1603_rp, axis=3))
      call add(parts, make_spindle([-0.437_rp, 0.0_rp, -0.2024_rp], 0.6026_rp, 0.1282_rp, tilt=-30.44_rp*PI/180))
    case ('paratuposa_simple')
      call add(parts, make_beetle(0.84_rp))
    case ('suzuki_thin_rod')
      ! Suzuki, Minami & Inamuro (2015), J. Fluid Mech. 767, 659-695.
      call add(parts, make_barrel(0.5_rp + margin, numbers%thickness/2))
    case ('coin')
      call add(parts, make_disk(0.5_rp, numbers%thickness/2))
    case ('platicle')
      call add(parts, make_plate([numbers%span, numbers%length, numbers%thickness]/2))
    case ('pyramid')
      call add(parts, make_pyramid(numbers%radius, numbers%eta, numbers%thickness))
    case ('cone')
      call add(parts, make_cone(numbers%radius, numbers%eta, numbers%thickness))
    end select
  end subroutine make_named_body

  !> Returns the position [L] of the hinge of the left wing. Some bodies define their hinges; for others it lies beside the middle
  !> of the body.
  pure function named_body_pivot(name, numbers) result(pivot)
    character(*), intent(in) :: name
    type(body_numbers_t), intent(in) :: numbers
    real(rp) :: pivot(3)
    pivot = [0.0_rp, numbers%radius, 0.0_rp]
    if (any(name == ['jerry', 'Jerry'])) pivot = [0.05_rp, 0.2165_rp, 0.0_rp]
  end function named_body_pivot

  !> Adds legs, antennae and proboscis of the bumblebee.
  subroutine add_legs(parts)
    type(shape_holder_t), allocatable, intent(inout) :: parts(:)
    real(rp), parameter :: LEGS(3, 5, 3) = reshape([ &
      -0.74_rp, 0.32_rp, -0.35_rp, -0.63_rp, 0.32_rp, -0.37_rp, -0.4_rp, 0.31_rp, -0.2_rp, -0.1_rp, 0.3_rp, -0.1_rp, &
      0.1_rp, 0.12_rp, -0.16_rp, &
      -0.24_rp, 0.33_rp, -0.29_rp, -0.15_rp, 0.33_rp, -0.28_rp, 0.02_rp, 0.32_rp, -0.2_rp, 0.17_rp, 0.3_rp, -0.15_rp, &
      0.19_rp, 0.15_rp, -0.19_rp, &
      0.28_rp, 0.31_rp, -0.3_rp, 0.35_rp, 0.30_rp, -0.28_rp, 0.45_rp, 0.28_rp, -0.25_rp, 0.4_rp, 0.2_rp, -0.18_rp, &
      0.35_rp, 0.15_rp, -0.18_rp], [3, 5, 3])
    real(rp), parameter :: RADII(4, 3) = 1.3_rp*reshape([0.015_rp, 0.03_rp, 0.04_rp, 0.03_rp, 0.015_rp, 0.03_rp, &
                                                       0.04_rp, 0.03_rp, 0.015_rp, 0.02_rp, 0.03_rp, 0.02_rp], [4, 3])
    integer :: i, leg
    do i = 1, 4
      do leg = 1, 3
        call add_pair(parts, LEGS(:, i, leg), LEGS(:, i + 1, leg), RADII(i, leg))
      end do
    end do
    call add_pair(parts, [0.63_rp, 0.05_rp, -0.03_rp], [0.8_rp, 0.27_rp, 0.1_rp], 0.0195_rp)
    call add(parts, make_rod([0.43_rp, 0.0_rp, -0.28_rp], [0.6_rp, 0.0_rp, -0.23_rp], 0.0221_rp))
  end subroutine add_legs

  !> Adds a rod and its mirror image on the right.
  subroutine add_pair(parts, from, upto, radius)
    type(shape_holder_t), allocatable, intent(inout) :: parts(:)
    real(rp), intent(in) :: from(3), upto(3), radius
    real(rp), parameter :: MIRROR(3) = [1, -1, 1]
    call add(parts, make_rod(from, upto, radius))
    call add(parts, make_rod(MIRROR*from, MIRROR*upto, radius))
  end subroutine add_pair

  !> Adds two spheres as eyes.
  subroutine add_eyes(parts, sites, radius)
    type(shape_holder_t), allocatable, intent(inout) :: parts(:)
    real(rp), intent(in) :: sites(3, 2), radius
    call add(parts, make_sphere(sites(:, 1), radius))
    call add(parts, make_sphere(sites(:, 2), radius))
  end subroutine add_eyes

  !> Returns a vector whose components forward, to the left or right, and upward are sin 45 degrees times `distance`.
  pure function cheeks(distance) result(sites)
    real(rp), intent(in) :: distance
    real(rp) :: sites(3, 2)
    sites(:, 1) = sin(PI/4)*distance*[1, 1, 1]
    sites(:, 2) = sin(PI/4)*distance*[1, -1, 1]
  end function cheeks

  !> Returns the first of several sites.
  pure function first(sites) result(site)
    real(rp), intent(in) :: sites(:, :)
    real(rp) :: site(3)
    site = sites(:, 1)
  end function first

  !> Adds a shape to the parts of a body.
  subroutine add(parts, shape)
    type(shape_holder_t), allocatable, intent(inout) :: parts(:)
    class(solid_shape_t), intent(in) :: shape
    type(shape_holder_t), allocatable :: more(:)
    integer :: i
    allocate (more(size(parts) + 1))
    do i = 1, size(parts)
      call move_alloc(parts(i)%shape, more(i)%shape)
    end do
    allocate (more(size(more))%shape, source=shape)
    call move_alloc(more, parts)
  end subroutine add
end module fsi_body_catalogue
