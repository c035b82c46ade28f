! SPDX-License-Identifier: GPL-3.0-or-later
!> Wing files: what is read, and every way in which a file may be refused.
program test_wing_file
  use base_errors, only: message_list_t
  use base_kinds, only: rp, i8
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing, load_wing
  use testkit, only: testkit_t
  use wing_writer, only: wing_writer_t
  implicit none
  character(*), parameter :: PATH = 'case.h5'
  integer(i8), parameter :: QUIET_NAN = int(z'7FF8000000000000', i8)
  integer(i8), parameter :: SIGNALLING_NAN = int(z'7FF0000000000001', i8)
  type(testkit_t) :: t
  type(wing_writer_t) :: w

  call t%start(parallel=.true.)
  if (t%world%is_root) then
    call test_valid()
    call test_header()
    call test_points()
    call test_triangles()
    call test_veins()
    call test_joints()
    call test_root()
    call test_beams()
    call test_other_files()
  end if
  call test_load()
  call t%finish()

contains

  !> Checks on rank 0 alone.
  subroutine check(sentence, holds)
    character(*), intent(in) :: sentence
    logical, intent(in) :: holds
    logical :: parallel
    parallel = t%parallel
    t%parallel = .false.
    call t%check(sentence, holds)
    t%parallel = parallel
  end subroutine check

  !> Closes the file that was made and expects it to be accepted.
  subroutine accept(what, wing)
    character(*), intent(in) :: what
    type(wing_t), intent(out) :: wing
    type(message_list_t) :: messages
    integer :: i
    call w%close()
    call read_wing(PATH, wing, messages)
    call check('accepted: '//what, messages%count() == 0)
    do i = 1, messages%count()
      write (*, '(a)') '      '//messages%text(i)
    end do
  end subroutine accept

  !> Closes the file that was made and expects exactly one message that contains `fragment`.
  subroutine refuse(fragment)
    character(*), intent(in) :: fragment
    type(message_list_t) :: messages
    type(wing_t) :: wing
    integer :: i
    logical :: found
    call w%close()
    call read_wing(PATH, wing, messages)
    found = messages%count() == 1
    if (found) found = index(messages%text(1), PATH//': '//fragment) == 1
    call check('refused: '//fragment, found)
    if (found) return
    do i = 1, messages%count()
      write (*, '(a)') '      '//messages%text(i)
    end do
  end subroutine refuse

  subroutine test_valid()
    type(wing_t) :: wing, zero
    call w%sample(PATH)
    call accept('the sample', wing)
    call check('points', all(shape(wing%points) == [3, 9]) .and. all(abs(wing%points(:, 6) - &
                                                                         [2.0e-3_rp, 1.0e-3_rp, 0.0_rp]) < 1e-18_rp))
    call check('triangles', all(shape(wing%triangles) == [3, 8]) .and. all(wing%triangles(:, 2) == [1, 5, 4]))
    call check('veins by name', size(wing%veins) == 3 .and. wing%veins(2)%name == 'B' &
               .and. all(wing%veins(2)%nodes == [4, 5, 6]))
    call check('joints by name: three points, and one on a vein', wing%joints(1)%name == 'A-C' &
               .and. all(wing%joints(1)%nodes == [1, 2, 5]) .and. all(wing%joints(2)%nodes == [4, 5, 6]))
    call check('root and normal', all(wing%root == [1, 4, 7]) .and. abs(wing%plane_normal(3) - 1) <= 0)
    call w%sample(PATH)
    call w%integer_attribute('/', 'index_base', 0)
    call w%integers('/triangles', [3, 8], reshape(wing%triangles, [24]) - 1)
    call w%integers('/veins/A/nodes', [3], [0, 1, 2])
    call w%integers('/veins/B/nodes', [3], [3, 4, 5])
    call w%integers('/veins/C/nodes', [3], [1, 4, 7])
    call w%integers('/joints/at_B', [1], [4])
    call w%text_attribute('/joints/at_B', 'vein', 'B')
    call w%integers('/joints/A-C', [3], [0, 1, 4])
    call w%integers('/root/nodes', [3], [0, 3, 6])
    call accept('points counted from 0', zero)
    call check('with the same triangles', all(zero%triangles == wing%triangles))
    call check('with the same joints', all(zero%joints(2)%nodes == wing%joints(2)%nodes))
    call w%sample(PATH, is_new=.true.)
    call w%variable_text_attribute('/', 'schema', 'flusi-msm wing')
    call w%variable_text_attribute('/points', 'units', 'm')
    call accept('texts of variable length, newest layout', zero)
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [1e-5_rp, 2e-5_rp, 3e-5_rp], is_single=.true.)
    call w%delete('/joints')
    call w%group('/extra')
    call w%reals('/extra/anything', [1], [1.0_rp])
    call accept('single precision, no joints, data of others in extra', zero)
  end subroutine test_valid

  subroutine test_header()
    call w%sample(PATH)
    call w%delete_attribute('/', 'schema')
    call refuse('attribute schema: missing')
    call w%sample(PATH)
    call w%text_attribute('/', 'schema', 'a plane')
    call refuse('attribute schema: is ''a plane'', expected ''flusi-msm wing''')
    call w%sample(PATH)
    call w%integer_attribute('/', 'version', 2)
    call refuse('attribute version: is 2; this program reads version 1')
    call w%sample(PATH)
    call w%text_attribute('/', 'version', '1')
    call refuse('attribute version: missing or not an integer')
    call w%sample(PATH)
    call w%integer_attribute('/', 'index_base', 2)
    call refuse('attribute index_base: is 2; valid: 0 or 1')
    call w%sample(PATH)
    call w%delete_attribute('/', 'index_base')
    call refuse('attribute index_base: missing')
    call w%sample(PATH)
    call w%group('/joint')
    call refuse('/: unknown object ''joint''; valid: points, ')
  end subroutine test_header

  subroutine test_points()
    real(rp) :: points(27)
    integer :: i
    points = [(real(modulo(7*i, 26), rp), i=1, 27)]
    call w%sample(PATH)
    call w%delete('/points')
    call refuse('/points: missing; it must hold rows of 3 real numbers')
    call w%sample(PATH)
    call w%reals('/points', [9, 3], points)
    call refuse('/points: must hold rows of 3 real numbers, but its shape is (3, 9)')
    call w%sample(PATH)
    call w%reals('/points', [27], points)
    call refuse('/points: must hold rows of 3 real numbers, but its shape is (27)')
    call w%sample(PATH)
    call w%integers('/points', [3, 9], [(i, i=1, 27)])
    call refuse('/points: must hold rows of 3 real numbers')
    call w%sample(PATH)
    call w%group('/joints/more')
    call refuse('/joints/more: must hold a list of integers')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], sample_points(), units='-')
    call refuse('/points: attribute units is missing or not a text; it must be ''m''')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], 1000*sample_points(), units='mm')
    call refuse('/points: attribute units is ''mm''; it must be ''m''')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], changed(14, transfer(QUIET_NAN, 1.0_rp)))
    call refuse('/points: point 5 has an infinite or undefined coordinate')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], changed(14, transfer(SIGNALLING_NAN, 1.0_rp)))
    call refuse('/points: point 5 has an infinite or undefined coordinate')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], changed(1, 1e300_rp))
    call refuse('/points: point 1 has the coordinate 1e300 m; coordinates are in metres')
    call w%sample(PATH)
    call w%reals('/points', [3, 10], [sample_points(), 5e-3_rp, 0.0_rp, 0.0_rp])
    call refuse('/: point 10 is in no triangle and no vein')
  end subroutine test_points

  !> The points of the sample.
  function sample_points() result(points)
    real(rp) :: points(27)
    integer :: i
    points = [(modulo(i, 3)*1e-3_rp, floor((i + 0.5_rp)/3)*1e-3_rp, 0.0_rp, i=0, 8)]
  end function sample_points

  !> The same with one value replaced.
  function changed(i, value) result(points)
    integer, intent(in) :: i
    real(rp), intent(in) :: value
    real(rp) :: points(27)
    points = sample_points()
    points(i) = value
  end function changed

  !> The sample with triangle 3 (points 2, 3, 6) replaced.
  subroutine with_triangle(corners)
    integer, intent(in) :: corners(3)
    call w%sample(PATH)
    call w%integers('/triangles', [3, 8], [1, 2, 5, 1, 5, 4, corners, 2, 6, 5, 4, 5, 8, 4, 8, 7, 5, 6, 9, &
                                           5, 9, 8])
  end subroutine with_triangle

  subroutine test_triangles()
    real(rp) :: points(36)
    type(wing_t) :: wing
    call with_triangle([2, 3, 6])
    call accept('the triangles of the sample', wing)
    call with_triangle([2, 3, 10])
    call refuse('/triangles: triangle 3: point 10 does not exist; the points are 1 to 9')
    call with_triangle([2, 3, -huge(1)])
    call refuse('/triangles: triangle 3: point -1000000000 does not exist')
    call with_triangle([2, 6, 3])
    call refuse_any('/triangles: triangle 3 (points 2, 6, 3) is inverted')
    call with_triangle([2, 6, 6])
    call refuse_any('/triangles: triangle 3 (points 2, 6, 6) has the same corner twice')
    call with_triangle([1, 2, 3])
    call refuse_any('/triangles: triangle 3 (points 1, 2, 3) is degenerate')
    call with_triangle([1, 2, 5])
    call refuse_any('/triangles: triangles 1 and 3 lie on the same side of their common edge 1-2, or '// &
                    'are the same')
    call with_triangle([2, 3, 5])
    call refuse_any('/triangles: triangles 3 and 4 lie on the same side of their common edge 5-2')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], changed(5, 2e-3_rp))
    call refuse_any('/triangles: triangle 1 (points 1, 2, 5) is inverted')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], turned())
    call refuse_any('triangle 1 (points 1, 2, 5) is inverted: its corners must run counter-clockwise '// &
                    'seen from +z')
    call w%sample(PATH)
    call w%integers('/triangles', [2, 12], [1, 2, 5, 1, 5, 4, 2, 3, 6, 2, 6, 5, 4, 5, 8, 4, 8, 7, 5, 6, 9, &
                                            5, 9, 8])
    call refuse('/triangles: must hold rows of 3 integers, but its shape is (12, 2)')
    points(:27) = sample_points()
    points(28:) = [5e-3_rp, 0.0_rp, 0.0_rp, 6e-3_rp, 0.0_rp, 0.0_rp, 5e-3_rp, 1e-3_rp, 0.0_rp]
    call w%sample(PATH)
    call w%reals('/points', [3, 12], points)
    call w%integers('/triangles', [3, 9], [1, 2, 5, 1, 5, 4, 2, 3, 6, 2, 6, 5, 4, 5, 8, 4, 8, 7, 5, 6, 9, &
                                           5, 9, 8, &
                                           10, 11, 12])
    call refuse('/: point 10 and 2 more are not connected to root point 1')
    call w%sample(PATH)
    call w%reals('/points', [3, 10], [points(:27), 1e-3_rp, 0.0_rp, 0.0_rp])
    call refuse_any('/points: points 2 and 10 are at the same place')
  end subroutine test_triangles

  !> The sample seen from below.
  function turned() result(points)
    real(rp) :: points(27)
    points = sample_points()
    points(2::3) = -points(2::3)
  end function turned

  !> As `refuse`, but there may be other messages.
  subroutine refuse_any(fragment)
    character(*), intent(in) :: fragment
    type(message_list_t) :: messages
    type(wing_t) :: wing
    integer :: i
    logical :: found
    call w%close()
    call read_wing(PATH, wing, messages)
    found = .false.
    do i = 1, messages%count()
      found = found .or. index(messages%text(i), fragment) > 0
    end do
    call check('refused: '//fragment, found)
    if (found) return
    do i = 1, messages%count()
      write (*, '(a)') '      '//messages%text(i)
    end do
  end subroutine refuse_any

  !> The sample with other points on vein A.
  subroutine with_vein(nodes)
    integer, intent(in) :: nodes(:)
    integer :: i
    call w%sample(PATH)
    call w%delete('/joints')
    call w%integers('/veins/A/nodes', [size(nodes)], nodes)
    call w%reals('/veins/A/diameters', [size(nodes)], [(1e-5_rp, i=1, size(nodes))])
  end subroutine with_vein

  subroutine test_veins()
    type(wing_t) :: wing
    integer :: i
    call with_vein([1, 2, 3, 6, 9, 8, 7, 4, 1])
    call accept('a vein around the wing', wing)
    call with_vein([1, 2, 17])
    call refuse('/veins/A/nodes: point 17 does not exist; the points are 1 to 9')
    call with_vein([1, 2, 6, 9])
    call accept('a vein along a diagonal', wing)
    call with_vein([1, 2, 3, 5])
    call refuse('/veins/A/nodes: from point 3 to 5 there is no edge of the mesh')
    call with_vein([1, 2, 5])
    call refuse('/veins: segment 2-5 is in vein A and again in vein C')
    call with_vein([1, 2, 3, 2])
    call refuse_any('/veins/A/nodes: passes point 2 twice')
    call refuse_open_any('/veins: segment 2-3 is in vein A and again in vein A')
    call refuse_open_any('/veins/A/nodes: folds back on itself at point 3')
    call with_vein([1])
    call refuse('/veins/A/nodes: a vein has at least 2 points')
    call with_vein([integer ::])
    call refuse('/veins/A/nodes: a vein has at least 2 points')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [2], [1e-5_rp, 1e-5_rp])
    call refuse('/veins/A: 3 nodes, but 2 diameters')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [1e-5_rp, 0.0_rp, 1e-5_rp])
    call refuse('/veins/A/diameters: diameter 2 is 0.0 m; it must lie between 1e-9 and 10000.0')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [1e-5_rp, 1e-5_rp, -1e-5_rp])
    call refuse('/veins/A/diameters: diameter 3 is -1e-5 m')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [transfer(SIGNALLING_NAN, 1.0_rp), 1e-5_rp, -1e-5_rp])
    call refuse_any('/veins/A/diameters: diameter 1 is infinite or undefined')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [1e-5_rp, 1e-5_rp, 1e-5_rp], units='-')
    call refuse('/veins/A/diameters: attribute units is missing')
    call w%sample(PATH)
    call w%delete('/veins/A/diameters')
    call refuse_any('/veins/A/diameters: missing')
    call w%sample(PATH)
    call w%reals('/veins/A/nodes', [3], [1.0_rp, 2.0_rp, 3.0_rp])
    call refuse_any('/veins/A/nodes: must hold a list of integers')
    call w%sample(PATH)
    call w%integers('/veins/D', [1], [1])
    call refuse('/veins/D: is not a group with datasets nodes and diameters')
    call w%sample(PATH)
    call w%delete('/veins')
    call w%integers('/veins', [1], [1])
    call refuse_any('/veins: is not a group')
    call w%sample(PATH)
    call w%group('/veins/a b')
    call refuse_any('/veins: ''a b'' is not a valid name')
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [(-1e-5_rp, i=1, 3)])
    call w%reals('/veins/B/diameters', [20], [(-1e-5_rp, i=1, 20)])
    call refuse_any('/veins/B/diameters: and 15 more mistakes of this kind')
    call refuse_open_any('/veins/A/diameters: diameter 3 is')
  end subroutine test_veins

  !> The same for the file of the last `refuse`.
  subroutine refuse_open_any(fragment)
    character(*), intent(in) :: fragment
    call w%open(PATH)
    call refuse_any(fragment)
  end subroutine refuse_open_any

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
    call accept('a joint from B into C', wing)
    call with_joint([5], 'D')
    call refuse('/joints/at_B: there is no vein ''D''')
    call with_joint([5], 'A')
    call refuse('/joints/at_B: point 5 is not on vein A')
    call with_joint([6], 'B')
    call refuse('/joints/at_B: point 6 is an end of vein B; a joint between two veins is given by three points')
    call with_joint([5])
    call refuse('/joints/at_B: one point needs the text attribute vein')
    call with_joint([4, 5, 6], 'B')
    call refuse('/joints/at_B: holds three points and the attribute vein')
    call with_joint([4, 5])
    call refuse('/joints/at_B: holds 2 points; valid: three, or one with the attribute vein')
    call with_joint([4, 5, 99])
    call refuse('/joints/at_B: point 99 does not exist')
    call with_joint([4, 5, 4])
    call refuse('/joints/at_B: its three points must be different')
    call with_joint([4, 5, 9])
    call refuse('/joints/at_B: points 5 and 9 are not neighbours on a vein')
    call with_joint([5, 2, 1])
    call refuse('/joints/at_B: is the same hinge as joint A-C')
  end subroutine test_joints

  subroutine test_root()
    call w%sample(PATH)
    call w%delete('/root')
    call refuse_any('/root/nodes: missing; it must hold a list of integers')
    call w%sample(PATH)
    call w%integers('/root/nodes', [0], [integer ::])
    call refuse('/root/nodes: a wing is clamped at one point at least')
    call w%sample(PATH)
    call w%integers('/root/nodes', [2], [1, 0])
    call refuse('/root/nodes: point 0 does not exist; the points are 1 to 9')
    call w%sample(PATH)
    call w%integers('/root/nodes', [3], [1, 4, 1])
    call refuse('/root/nodes: point 1 is listed twice')
  end subroutine test_root

  subroutine test_beams()
    type(wing_t) :: wing
    call w%beam(PATH)
    call accept('a straight beam', wing)
    call check('its plane is that of z', abs(wing%plane_normal(3) - 1) <= 0 .and. size(wing%triangles, 2) == 0)
    call w%beam(PATH)
    call w%reals('/points', [3, 4], real([0, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0, 3], rp))
    call accept('a straight beam along z', wing)
    call check('its plane is that of y', abs(wing%plane_normal(2) - 1) <= 0)
    call w%beam(PATH)
    call w%reals('/points', [3, 4], real([0, 0, 0, 1, 0, 0, 2, 0, 1, 3, 0, 1], rp))
    call refuse('attribute plane_normal: a structure of veins that is not straight (point 2) needs the normal')
    call w%beam(PATH)
    call w%reals('/points', [3, 4], real([0, 0, 0, 1, 0, 0, 2, 0, 1, 3, 0, 1], rp))
    call w%real_attribute('/', 'plane_normal', [0.0_rp, -2.0_rp, 0.0_rp])
    call accept('a bent beam in a given plane', wing)
    call check('whose normal has length 1', abs(wing%plane_normal(2) + 1) <= 0)
    call w%beam(PATH)
    call w%reals('/points', [3, 4], real([0, 0, 0, 1, 0, 0, 2, 0, 1, 3, 1, 1], rp))
    call w%real_attribute('/', 'plane_normal', [0.0_rp, 1.0_rp, 0.0_rp])
    call refuse('attribute plane_normal: point 4 does not lie in the plane of the first point')
    call w%beam(PATH)
    call w%real_attribute('/', 'plane_normal', [0.0_rp, 0.0_rp, 0.0_rp])
    call refuse('attribute plane_normal: must be a vector of a length')
    call w%beam(PATH)
    call w%real_attribute('/', 'plane_normal', [0.0_rp, 1.0_rp])
    call refuse('attribute plane_normal: must be three real numbers')
    call w%beam(PATH)
    call w%real_attribute('/', 'plane_normal', [0.0_rp, 1.0_rp, transfer(SIGNALLING_NAN, 1.0_rp)])
    call refuse('attribute plane_normal: has an infinite or undefined component')
    call w%sample(PATH)
    call w%real_attribute('/', 'plane_normal', [0.0_rp, 0.0_rp, 1.0_rp])
    call refuse('attribute plane_normal: only structures without triangles may have one')
    call w%beam(PATH)
    call w%integers('/triangles', [3, 0], [integer ::])
    call accept('an empty list of triangles', wing)
    call w%beam(PATH)
    call w%delete('/veins')
    call refuse('/: there are neither triangles nor veins')
    call w%beam(PATH)
    call w%reals('/points', [3, 4], spread(1.0_rp, 1, 12))
    call refuse('/points: all points are at one place')
    call w%beam(PATH)
    call w%reals('/points', [3, 0], [real(rp) ::])
    call refuse_any('/points: a wing has at least 2 points')
  end subroutine test_beams

  subroutine test_other_files()
    type(wing_t) :: wing
    type(message_list_t) :: messages
    integer :: unit
    call read_wing('missing.h5', wing, messages)
    call check('a missing file is refused', messages%count() == 1 .and. index(messages%text(1), &
                                                                              'missing.h5: does not exist') == 1)
    open (newunit=unit, file=PATH, status='replace')
    write (unit, '(a)') 'no HDF5'
    close (unit)
    call read_wing(PATH, wing, messages)
    call check('and one of another kind', messages%count() == 2)
    if (messages%count() == 2) call check('with the reason', index(messages%text(2), 'not an HDF5 file') > 0)
  end subroutine test_other_files

  !> All ranks get what rank 0 has read.
  subroutine test_load()
    type(wing_t) :: wing
    type(message_list_t) :: messages
    if (t%world%is_root) then
      call w%sample('all.h5')
      call w%close()
      call w%sample('bad.h5')
      call w%delete('/root')
      call w%delete('/points')
      call w%close()
    end if
    call load_wing(t%world, 'all.h5', wing, messages)
    call t%check('all ranks accept the file', messages%count() == 0)
    call t%check('and have its points', all(abs(reshape(wing%points, [27]) - sample_points()) < 1e-15_rp))
    call t%check('triangles', all(wing%triangles(:, 8) == [5, 9, 8]))
    call t%check('veins', wing%veins(3)%name == 'C' .and. all(wing%veins(3)%nodes == [2, 5, 8]) &
                 .and. abs(wing%veins(3)%diameters(2) - 7e-5_rp) < 1e-18_rp)
    call t%check('joints and root', all(wing%joints(2)%nodes == [4, 5, 6]) .and. all(wing%root == [1, 4, 7]))
    call load_wing(t%world, 'bad.h5', wing, messages)
    call t%check('all ranks refuse a bad file with the same messages', messages%count() >= 2)
    if (messages%count() >= 2) call t%check('that name it', index(messages%text(1), 'bad.h5: /points') == 1)
  end subroutine test_load
end program test_wing_file
