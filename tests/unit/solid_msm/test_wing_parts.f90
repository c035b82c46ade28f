! SPDX-License-Identifier: GPL-3.0-or-later
!> Parts of wings: every way in which veins, joints, the root or a structure without triangles may be refused.
program test_wing_parts
  use base_kinds, only: rp, i8
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use wing_case, only: wing_case_t, PATH
  implicit none
  integer(i8), parameter :: SIGNALLING_NAN = int(z'7FF0000000000001', i8)
  type(testkit_t), target :: t
  type(wing_case_t) :: w

  call t%start(parallel=.false.)
  w%t => t
  call test_veins()
  call test_diameters()
  call test_joints()
  call test_root()
  call test_beams()
  call test_held()
  call test_flat()
  call t%finish()

contains

  !> The sample with other points on vein A.
  subroutine with_vein(nodes)
    integer, intent(in) :: nodes(:)
    integer :: i
    call w%sample(PATH)
    call w%delete('/joints')
    call w%integers('/veins/A/nodes', [size(nodes)], nodes)
    call w%reals('/veins/A/diameters', [size(nodes)], [(1e-5_rp, i=1, size(nodes))])
  end subroutine with_vein

  subroutine test_diameters()
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [2], [1e-5_rp, 1e-5_rp])
    call w%refuse('/veins/A: 3 nodes, but 2 diameters')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [1e-5_rp, 0.0_rp, 1e-5_rp])
    call w%refuse('/veins/A/diameters: diameter 2 is 0.0 m; it must lie between 1e-9 and 10000.0')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [1e-5_rp, 1e-5_rp, -1e-5_rp])
    call w%refuse('/veins/A/diameters: diameter 3 is -1e-5 m')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [1e-5_rp, 10.0_rp, 1e-5_rp])
    call w%refuse('/veins/A/diameters: diameter 2 is 10.0 m, and the points extend over')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [transfer(SIGNALLING_NAN, 1.0_rp), 1e-5_rp, -1e-5_rp])
    call w%refuse_any('/veins/A/diameters: diameter 1 is infinite or undefined')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [1e-5_rp, 1e-5_rp, 1e-5_rp], units='-')
    call w%refuse('/veins/A/diameters: attribute units is missing')
    call w%sample(PATH)
    call w%delete('/veins/A/diameters')
    call w%refuse_any('/veins/A/diameters: missing')
  end subroutine test_diameters

  subroutine test_veins()
    type(wing_t) :: wing
    integer :: i
    call with_vein([1, 2, 3, 6, 9, 8, 7, 4, 1])
    call w%accept('a vein around the wing', wing)
    call with_vein([1, 2, 17])
    call w%refuse('/veins/A/nodes: point 17 does not exist; the points are 1 to 9')
    call with_vein([1, 2, 6, 9])
    call w%accept('a vein along a diagonal', wing)
    call with_vein([1, 2, 3, 5])
    call w%refuse('/veins/A/nodes: from point 3 to 5 there is no edge of the mesh')
    call with_vein([1, 2, 5])
    call w%refuse('/veins: segment 2-5 is in vein A and again in vein C')
    call with_vein([1, 2, 3, 2])
    call w%refuse_any('/veins/A/nodes: passes point 2 twice')
    call w%refuse_open_any('/veins: segment 2-3 is in vein A and again in vein A')
    call w%refuse_open_any('/veins/A/nodes: folds back on itself at point 3')
    call with_vein([1])
    call w%refuse('/veins/A/nodes: a vein has at least 2 points')
    call with_vein([integer ::])
    call w%refuse('/veins/A/nodes: a vein has at least 2 points')
    call w%sample(PATH)
    call w%reals('/veins/A/nodes', [3], [1.0_rp, 2.0_rp, 3.0_rp])
    call w%refuse_any('/veins/A/nodes: must hold a list of integers')
    call w%sample(PATH)
    call w%integers('/veins/D', [1], [1])
    call w%refuse('/veins/D: is not a group with datasets nodes and diameters')
    call w%sample(PATH)
    call w%delete('/veins')
    call w%integers('/veins', [1], [1])
    call w%refuse_any('/veins: is not a group')
    call w%sample(PATH)
    call w%group('/veins/a b')
    call w%refuse_any('/veins: ''a b'' is not a valid name')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [(-1e-5_rp, i=1, 3)])
    call w%reals('/veins/B/diameters', [20], [(-1e-5_rp, i=1, 20)])
    call w%refuse_any('/veins/B/diameters: and 15 more mistakes of this kind')
    call w%refuse_open_any('/veins/A/diameters: diameter 3 is')
  end subroutine test_veins

  subroutine with_joint(nodes, vein)
    integer, intent(in) :: nodes(:)
    character(*), intent(in), optional :: vein
    call w%sample(PATH)
    call w%integers('/joints/at_B', [size(nodes)], nodes)
    if (present(vein)) call w%text_attribute('/joints/at_B', 'vein', vein)
  end subroutine with_joint

  subroutine test_joints()
    type(wing_t) :: wing
    call with_joint([4, 5, 8])
    call w%accept('a joint from B into C', wing)
    call with_joint([5], 'D')
    call w%refuse('/joints/at_B: there is no vein ''D''')
    call with_joint([5], 'A')
    call w%refuse('/joints/at_B: point 5 is not on vein A')
    call with_joint([6], 'B')
    call w%refuse('/joints/at_B: point 6 is an end of vein B; a joint between two veins is given by three points')
    call with_joint([5])
    call w%refuse('/joints/at_B: one point needs the text attribute vein')
    call with_joint([4, 5, 6], 'B')
    call w%refuse('/joints/at_B: holds three points and the attribute vein')
    call with_joint([4, 5])
    call w%refuse('/joints/at_B: holds 2 points; valid: three, or one with the attribute vein')
    call with_joint([4, 5, 99])
    call w%refuse('/joints/at_B: point 99 does not exist')
    call with_joint([4, 5, 4])
    call w%refuse('/joints/at_B: its three points must be different')
    call with_joint([4, 5, 9])
    call w%refuse('/joints/at_B: points 5 and 9 are not neighbours on a vein')
    call with_joint([5, 2, 1])
    call w%refuse('/joints/at_B: is the same hinge as joint A-C')
  end subroutine test_joints

  subroutine test_root()
    call w%sample(PATH)
    call w%delete('/root')
    call w%refuse_any('/root/nodes: missing; it must hold a list of integers')
    call w%sample(PATH)
    call w%integers('/root/nodes', [0], [integer ::])
    call w%refuse('/root/nodes: a wing is clamped at one point at least')
    call w%sample(PATH)
    call w%integers('/root/nodes', [2], [1, 0])
    call w%refuse('/root/nodes: point 0 does not exist; the points are 1 to 9')
    call w%sample(PATH)
    call w%integers('/root/nodes', [3], [1, 4, 1])
    call w%refuse('/root/nodes: point 1 is listed twice')
  end subroutine test_root

  subroutine test_beams()
    type(wing_t) :: wing
    call w%beam(PATH)
    call w%accept('a straight beam', wing)
    call w%check('its plane is that of z', abs(wing%plane_normal(3) - 1) <= 0 .and. size(wing%triangles, 2) == 0)
    call w%beam(PATH)
    call w%reals('/points', [3, 4], real([0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3], rp))
    call w%accept('a straight beam along z', wing)
    call w%check('its plane is that of y', abs(wing%plane_normal(2) - 1) <= 0)
    call w%beam(PATH)
    call w%reals('/points', [3, 4], real([0, 0, 0, 1, 0, 0, 2, 0, 1, 3, 0, 1], rp))
    call w%refuse('attribute plane_normal: a structure of veins that is not straight (point 2) needs the normal')
    call w%beam(PATH)
    call w%reals('/points', [3, 4], real([0, 0, 0, 1, 0, 0, 2, 0, 1, 3, 0, 1], rp))
    call w%real_attribute('/', 'plane_normal', [0.0_rp, -2.0_rp, 0.0_rp])
    call w%accept('a bent beam in a given plane', wing)
    call w%check('whose normal has length 1', abs(wing%plane_normal(2) + 1) <= 0)
    call w%beam(PATH)
    call w%reals('/points', [3, 4], real([0, 0, 0, 1, 0, 0, 2, 0, 1, 3, 1, 1], rp))
    call w%real_attribute('/', 'plane_normal', [0.0_rp, 1.0_rp, 0.0_rp])
    call w%refuse('attribute plane_normal: point 4 does not lie in the plane of the first point')
    call w%beam(PATH)
    call w%real_attribute('/', 'plane_normal', [0.0_rp, 0.0_rp, 0.0_rp])
    call w%refuse('attribute plane_normal: must be a vector of a length')
    call w%beam(PATH)
    call w%real_attribute('/', 'plane_normal', [0.0_rp, 1.0_rp])
    call w%refuse('attribute plane_normal: must be three real numbers')
    call w%beam(PATH)
    call w%real_attribute('/', 'plane_normal', [0.0_rp, 1.0_rp, transfer(SIGNALLING_NAN, 1.0_rp)])
    call w%refuse('attribute plane_normal: has an infinite or undefined component')
    call w%sample(PATH)
    call w%real_attribute('/', 'plane_normal', [0.0_rp, 0.0_rp, 1.0_rp])
    call w%refuse('attribute plane_normal: only structures without triangles may have one')
    call w%beam(PATH)
    call w%integers('/triangles', [3, 0], [integer ::])
    call w%accept('an empty list of triangles', wing)
    call w%beam(PATH)
    call w%delete('/veins')
    call w%refuse('/: there are neither triangles nor veins')
    call w%beam(PATH)
    call w%reals('/points', [3, 4], spread(1.0_rp, 1, 12))
    call w%refuse('/points: all points coincide')
    call w%beam(PATH)
    call w%reals('/points', [3, 0], [real(rp) ::])
    call w%refuse_any('/points: a wing has at least 2 points')
  end subroutine test_beams

  !> Two squares of two triangles, 1-2-4-3 and 4-5-7-6, that share point 4; the first is clamped at 1 and 3. A vein runs
  !> along 1-2, and others where the test says.
  subroutine squares(nodes, more)
    integer, intent(in) :: nodes(:)
    integer, intent(in), optional :: more(:)
    integer :: i
    call w%sample(PATH)
    call w%delete('/joints')
    call w%reals('/points', [3, 7], 1.0e-3_rp*real([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0, 1, 2, 0, 2, 2, 0], rp))
    call w%integers('/triangles', [3, 4], [1, 2, 4, 1, 4, 3, 4, 5, 7, 4, 7, 6])
    call w%integers('/root/nodes', [2], [1, 3])
    call w%delete('/veins/C')
    call w%integers('/veins/A/nodes', [2], [1, 2])
    call w%reals('/veins/A/diameters', [2], [1e-5_rp, 1e-5_rp])
    call w%integers('/veins/B/nodes', [size(nodes)], nodes)
    call w%reals('/veins/B/diameters', [size(nodes)], [(1e-5_rp, i=1, size(nodes))])
    if (.not. present(more)) return
    call w%group('/veins/C')
    call w%integers('/veins/C/nodes', [size(more)], more)
    call w%reals('/veins/C/diameters', [size(more)], [(1e-5_rp, i=1, size(more))])
  end subroutine squares

  !> A part that could turn about the single point by which it hangs.
  subroutine test_held()
    type(wing_t) :: wing
    call squares([3, 4])
    call w%refuse('/: point 5 and 2 more hang on point 4 alone and can turn about it: join the two parts by '// &
                  'an edge of two triangles or by a vein')
    call squares([2, 4], [5, 7])
    call w%refuse('/: point 5 and 2 more hang on point 4 alone')
    call squares([3, 4]) ! two parts that meet at 4 and at 7: together they turn about 4
    call w%reals('/points', [3, 9], 1.0e-4_rp*real([0, 0, 0, 10, 0, 0, 0, 10, 0, 10, 10, 0, 20, 10, 0, 18, 13, 0, 20, 20, 0, &
                                                    13, 18, 0, 10, 20, 0], rp))
    call w%integers('/triangles', [3, 6], [1, 2, 4, 1, 4, 3, 4, 5, 6, 5, 7, 6, 4, 8, 9, 8, 7, 9])
    call w%refuse('/: point 5 and 4 more hang on point 4 alone')
    call squares([1, 4, 7])
    call w%accept('squares that meet at a point with a vein across', wing)
    call squares([3, 4], [4, 5])
    call w%accept('or with two veins that meet there', wing)
    call squares([3, 4])
    call w%integers('/root/nodes', [4], [1, 3, 5, 7])
    call w%accept('or both clamped', wing)
    call squares([3, 4])
    call w%integers('/triangles', [3, 5], [1, 2, 4, 1, 4, 3, 4, 5, 7, 4, 7, 6, 4, 6, 3])
    call w%accept('or with a triangle between them', wing)
    call w%sample(PATH)
    call w%delete('/joints')
    call w%delete('/veins')
    call w%integers('/root/nodes', [1], [1])
    call w%refuse('/: point 2 and 7 more hang on point 1 alone')
    call w%sample(PATH)
    call w%integers('/root/nodes', [1], [1])
    call w%accept('a wing that a single vein holds', wing)
    call w%beam(PATH)
    call w%integers('/root/nodes', [1], [2])
    call w%refuse('/: point 1 and 2 more hang on point 2 alone')
    call w%beam(PATH)
    call w%integers('/root/nodes', [2], [1, 2])
    call w%accept('a beam that is clamped at two points', wing)
    call w%beam(PATH)
    call w%integers('/veins/A/nodes', [2], [1, 2])
    call w%reals('/veins/A/diameters', [2], [1e-5_rp, 1e-5_rp])
    call w%group('/veins/B')
    call w%integers('/veins/B/nodes', [3], [2, 3, 4])
    call w%reals('/veins/B/diameters', [3], [1e-5_rp, 1e-5_rp, 1e-5_rp])
    call w%accept('two veins that meet at a free point', wing)
  end subroutine test_held

  !> Membranes and veins that leave the plane, in files that count from 0.
  subroutine test_flat()
    real(rp) :: points(3, 7)
    type(wing_t) :: wing
    points = 1.0e-3_rp*reshape(real([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0, 1, 2, 0, 2, 2, 0], rp), [3, 7])
    points(3, 5) = 1.0e-5_rp
    call squares([0, 3, 6])
    call from_zero()
    call w%reals('/points', [3, 7], reshape(points, [21]))
    call w%refuse('/points: the unloaded membrane must be flat; point 4 lies farthest from its plane')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], 1.0e-3_rp*real([0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 1, 0, 2, 0, 1, 2, 0, &
                                                    2, 2, 0], rp))
    call w%refuse('/points: the unloaded membrane must be flat; point 6 lies farthest from its plane')
    call w%sample(PATH) ! two rows of points, of which the middle of the second is raised
    call w%delete('/joints')
    call w%delete('/veins/C')
    call w%integer_attribute('/', 'index_base', 0)
    call w%reals('/points', [3, 6], 1.0e-3_rp*[0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 2.0_rp, 0.0_rp, 0.0_rp, &
                                               0.0_rp, 1.0_rp, 0.0_rp, 1.0_rp, 1.0_rp, 0.1_rp, 2.0_rp, 1.0_rp, 0.0_rp])
    call w%integers('/triangles', [3, 4], [0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4])
    call w%integers('/veins/A/nodes', [3], [0, 1, 2])
    call w%integers('/veins/B/nodes', [3], [3, 4, 5])
    call w%integers('/root/nodes', [2], [0, 3])
    call w%refuse('/points: the unloaded membrane must be flat; point 4 lies farthest from its plane')
    points(3, 5) = 1.0e-10_rp
    call squares([0, 3, 6])
    call from_zero()
    call w%reals('/points', [3, 7], reshape(points, [21]))
    call w%accept('a membrane that is flat to 1e-7', wing)
    call w%beam(PATH)
    call w%integer_attribute('/', 'index_base', 0)
    call w%integers('/veins/A/nodes', [4], [0, 1, 2, 3])
    call w%integers('/root/nodes', [1], [0])
    call w%reals('/points', [3, 4], [0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, 0.0_rp, 1.1_rp, 0.0_rp, 2.0e-7_rp, &
                                     3.0_rp, 0.0_rp, 0.0_rp])
    call w%refuse('/points: the veins at point 2 bend out of the plane of the wing; move the point into the plane')
  end subroutine test_flat

  !> The squares with everything counted from 0.
  subroutine from_zero()
    call w%integer_attribute('/', 'index_base', 0)
    call w%integers('/triangles', [3, 4], [0, 1, 3, 0, 3, 2, 3, 4, 6, 3, 6, 5])
    call w%integers('/root/nodes', [2], [0, 2])
    call w%integers('/veins/A/nodes', [2], [0, 1])
  end subroutine from_zero
end program test_wing_parts
