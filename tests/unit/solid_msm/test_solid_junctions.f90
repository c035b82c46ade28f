! SPDX-License-Identifier: GPL-3.0-or-later
!> Which vein segments bend against each other, and how stiffly: at the root, inside veins, where veins
!> meet, and at joints.
program test_solid_junctions
  use base_constants, only: PI
  use base_kinds, only: rp
  use solid_junctions, only: hinge_plan_t, plan_hinges
  use solid_params, only: solid_params_t, default_params
  use solid_stiffness, only: bending_stiffness
  use solid_wing, only: wing_t, vein_t, joint_t
  use solid_wing_refine, only: equal_rotation
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: ANGLE = PI/6, LENGTHS(4) = [1.0_rp, 2.0_rp, 1.5_rp, 0.5_rp] !< of the parent's segments
  real(rp), parameter :: DIAMETERS(5) = [0.5_rp, 0.4_rp, 0.3_rp, 0.2_rp, 0.1_rp]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(hinge_plan_t), allocatable :: plans(:)
  real(rp), allocatable :: ghosts(:, :)
  integer :: stray

  call t%start(parallel=.false.)
  call test_root(is_reversed=.false.)
  call test_root(is_reversed=.true.)
  call test_clamped_segment()
  call test_branch()
  call test_crossing()
  call test_ring()
  call test_equal_rotation()
  call t%finish()

contains

  !> A hinge of another mesh that adds the same rotation to that of its vein.
  subroutine test_equal_rotation()
    real(rp), parameter :: K = 0.3_rp, FROM = 0.7_rp, ROUND_OFF = 1.0e-14_rp
    call t%check_close('as stiff as the vein here, as stiff as the vein there', equal_rotation(FROM, FROM, 2*FROM), 2*FROM, &
                       rtol=ROUND_OFF)
    call t%check_close('stated on both meshes, the same', equal_rotation(K, FROM, FROM), K, rtol=ROUND_OFF)
    call t%check_close('much softer than the vein, the same', equal_rotation(1.0e-9_rp, FROM, 2*FROM), 1.0e-9_rp, rtol=1.0e-8_rp)
    call t%check_close('there and back', equal_rotation(equal_rotation(K, FROM, 2*FROM), 2*FROM, FROM), K, rtol=ROUND_OFF)
    call t%check('twice as stiff as the vein, there is none of half the length', &
                 .not. equal_rotation(2*FROM, FROM, 2*FROM) > 0)
  end subroutine test_equal_rotation

  !> A tapering parent vein along x through the points 1 to 5 and a branch that leaves it at point 3,
  !> 30 degrees from its forward direction, through 6 to 7; point 1 is clamped.
  subroutine make_wing(is_reversed)
    logical, intent(in) :: is_reversed
    integer :: i
    wing = wing_t()
    allocate (wing%points(3, 7), source=0.0_rp)
    do i = 2, 5
      wing%points(1, i) = wing%points(1, i - 1) + LENGTHS(i - 1)
    end do
    do i = 6, 7
      wing%points(:, i) = wing%points(:, 3) + (i - 5)*[cos(ANGLE), sin(ANGLE), 0.0_rp]
    end do
    allocate (wing%triangles(3, 0), wing%joints(0), wing%veins(2))
    wing%veins(1)%name = 'parent'
    wing%veins(1)%nodes = [1, 2, 3, 4, 5]
    wing%veins(1)%diameters = DIAMETERS
    if (is_reversed) then
      wing%veins(1)%nodes = wing%veins(1)%nodes(5:1:-1)
      wing%veins(1)%diameters = DIAMETERS(5:1:-1)
    end if
    wing%veins(2)%name = 'branch'
    wing%veins(2)%nodes = [3, 6, 7]
    wing%veins(2)%diameters = [0.3_rp, 0.2_rp, 0.1_rp]
    wing%root = [1]
  end subroutine make_wing

  !> Number of the hinge a-b-c or c-b-a, 0 if there is none.
  integer function hinge(a, b, c)
    integer, intent(in) :: a, b, c
    integer :: h
    hinge = 0
    do h = 1, size(plans)
      if (all(plans(h)%nodes == [a, b, c]) .or. all(plans(h)%nodes == [c, b, a])) hinge = h
    end do
  end function hinge

  !> Checks that there is such a hinge of that stiffness for E = 1 Pa.
  subroutine check_stiffness(what, nodes, expected)
    character(*), intent(in) :: what
    integer, intent(in) :: nodes(3)
    real(rp), intent(in) :: expected
    type(solid_params_t) :: params
    integer :: h
    h = hinge(nodes(1), nodes(2), nodes(3))
    call t%check(what//': there is a hinge', h > 0)
    if (h == 0) return
    params = default_params(wing)
    params%young = 1
    call t%check_close(what//': its stiffness', bending_stiffness(params, plans(h), 0.25_rp, 1.0_rp), expected, &
                       rtol=1.0e-13_rp)
  end subroutine check_stiffness

  pure real(rp) function area_moment(diameter)
    real(rp), intent(in) :: diameter
    area_moment = PI*diameter**4/64
  end function area_moment

  !> A clamped end gets a ghost behind it and the hinge 2EI/l; inside a vein it is 2EI/(l1 + l2).
  subroutine test_root(is_reversed)
    logical, intent(in) :: is_reversed
    call make_wing(is_reversed)
    call plan_hinges(wing, plans, ghosts, stray)
    call t%check('one ghost for one clamped end', size(ghosts, 2) == 1 .and. stray == 0)
    call t%check_below('it prolongs the first segment', norm2(ghosts(:, 1) - [-LENGTHS(1), 0.0_rp, 0.0_rp]), &
                       1.0e-15_rp)
    call check_stiffness('the root', [8, 1, 2], 2*area_moment(DIAMETERS(1))/LENGTHS(1))
    call check_stiffness('inside', [1, 2, 3], 2*area_moment(DIAMETERS(2))/(LENGTHS(1) + LENGTHS(2)))
    call check_stiffness('near the tip', [3, 4, 5], 2*area_moment(DIAMETERS(4))/(LENGTHS(3) + LENGTHS(4)))
    call t%check('the root is marked', plans(hinge(8, 1, 2))%is_root .and. .not. plans(hinge(1, 2, 3))%is_root)
  end subroutine test_root

  !> Of a hinge with one clamped segment only the other half bends.
  subroutine test_clamped_segment()
    call make_wing(.false.)
    wing%root = [1, 2]
    call plan_hinges(wing, plans, ghosts, stray)
    call t%check('no ghost where a segment is clamped', size(ghosts, 2) == 0)
    call check_stiffness('behind a clamped segment', [1, 2, 3], 2*area_moment(DIAMETERS(2))/LENGTHS(2))
    call t%check('it is marked as the root', plans(hinge(1, 2, 3))%is_root)
  end subroutine test_clamped_segment

  !> A branch continues the straighter arm of its parent, unless a joint says otherwise.
  subroutine test_branch()
    call make_wing(.false.)
    call plan_hinges(wing, plans, ghosts, stray)
    call check_stiffness('the branch', [2, 3, 6], 2*area_moment(0.3_rp)/(LENGTHS(2) + 1))
    call t%check('and bends against that arm only', hinge(4, 3, 6) == 0 .and. size(plans) == 6)
    deallocate (wing%joints)
    allocate (wing%joints(2))
    wing%joints(1) = joint_t('fork', [4, 3, 6])
    wing%joints(2) = joint_t('parent', [4, 3, 2])
    call plan_hinges(wing, plans, ghosts, stray)
    call t%check('a joint between two veins replaces the hinge that the geometry gives', hinge(4, 3, 6) > 0 .and. &
                 hinge(2, 3, 6) == 0 .and. size(plans) == 6 .and. stray == 0)
    call t%check('and is told apart', plans(hinge(4, 3, 6))%joint == 1 .and. plans(hinge(2, 3, 4))%joint == 2 &
                 .and. plans(hinge(1, 2, 3))%joint == 0)
    wing%joints(2) = joint_t('nowhere', [5, 3, 2])
    call plan_hinges(wing, plans, ghosts, stray)
    call t%check('a joint beside the segments is named', stray == 2)
  end subroutine test_branch

  !> Two veins that cross are joined once, by the arms that turn least into each other.
  subroutine test_crossing()
    call make_wing(.false.)
    wing%points(:, 7) = wing%points(:, 3) - [cos(ANGLE), sin(ANGLE), 0.0_rp]
    wing%veins(2)%nodes = [7, 3, 6]
    call plan_hinges(wing, plans, ghosts, stray)
    call t%check('crossing veins keep their own hinges', hinge(2, 3, 4) > 0 .and. hinge(7, 3, 6) > 0)
    call t%check('and have one in common', size(plans) == 6 .and. count([hinge(2, 3, 6), hinge(4, 3, 7)] > 0) == 1)
  end subroutine test_crossing

  !> A vein that ends where it begins bends at every point, that one too.
  subroutine test_ring()
    integer, parameter :: N = 8
    integer :: i
    wing = wing_t()
    allocate (wing%points(3, N), source=0.0_rp)
    do i = 1, N
      wing%points(:2, i) = [cos(2*PI*i/N), sin(2*PI*i/N)]
    end do
    allocate (wing%triangles(3, 0), wing%joints(0), wing%veins(1), wing%root(0))
    wing%veins(1)%name = 'ring'
    wing%veins(1)%nodes = [(i, i=1, N), 1]
    allocate (wing%veins(1)%diameters(N + 1), source=0.1_rp)
    call plan_hinges(wing, plans, ghosts, stray)
    call t%check('a ring has as many hinges as points', size(plans) == N)
    call t%check('one of them where it closes', hinge(N, 1, 2) > 0)
  end subroutine test_ring
end program test_solid_junctions
