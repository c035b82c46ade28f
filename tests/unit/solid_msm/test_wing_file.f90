! SPDX-License-Identifier: GPL-3.0-or-later
!> Wing files: what is read, and every way in which a file, its points or its triangles may be refused.
program test_wing_file
  use base_errors, only: message_list_t
  use base_kinds, only: rp, i8
  use solid_wing, only: wing_t, MEMBRANE_BILINEAR, MEMBRANE_UNIFORM, MEMBRANE_UNSTATED, &
                        SIDE_RIGHT_DORSAL, SIDE_UNSTATED, Z_SIDES
  use solid_wing_file, only: read_wing, load_wing
  use solid_wing_refine, only: refine_wing
  use testkit, only: testkit_t
  use wing_case, only: wing_case_t, PATH
  implicit none
  integer(i8), parameter :: QUIET_NAN = int(z'7FF8000000000000', i8)
  integer(i8), parameter :: SIGNALLING_NAN = int(z'7FF0000000000001', i8)
  type(testkit_t), target :: t
  type(wing_case_t) :: w

  call t%start(parallel=.true.)
  w%t => t
  if (t%world%is_root) then
    call test_valid()
    call test_header()
    call test_z_side()
    call test_mass()
    call test_points()
    call test_triangles()
    call test_other_files()
  end if
  call test_load()
  call t%finish()

contains

  subroutine test_valid()
    type(wing_t) :: wing, zero
    call w%sample(PATH)
    call w%accept('the sample', wing)
    call w%check('points', all(shape(wing%points) == [3, 9]) .and. all(abs(wing%points(:, 6) - &
                                                                           [2.0e-3_rp, 1.0e-3_rp, 0.0_rp]) < 1e-18_rp))
    call w%check('triangles', all(shape(wing%triangles) == [3, 8]) .and. all(wing%triangles(:, 2) == [1, 5, 4]))
    call w%check('veins by name', size(wing%veins) == 3 .and. wing%veins(2)%name == 'B' &
                 .and. all(wing%veins(2)%nodes == [4, 5, 6]))
    call w%check('joints by name: three points, and one on a vein', wing%joints(1)%name == 'A-C' &
                 .and. all(wing%joints(1)%nodes == [1, 2, 5]) .and. all(wing%joints(2)%nodes == [4, 5, 6]))
    call w%check('root and normal', all(wing%root == [1, 4, 7]) .and. abs(wing%plane_normal(3) - 1) <= 0)
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
    call w%accept('points counted from 0', zero)
    call w%check('with the same triangles', all(zero%triangles == wing%triangles))
    call w%check('with the same joints', all(zero%joints(2)%nodes == wing%joints(2)%nodes))
    call w%sample(PATH, is_new=.true.)
    call w%variable_text_attribute('/', 'schema', 'flusi-msm wing')
    call w%variable_text_attribute('/points', 'units', 'm')
    call w%accept('texts of variable length, newest layout', zero)
    call w%sample(PATH)
    call w%reals('/veins/A/diameters', [3], [1e-5_rp, 2e-5_rp, 3e-5_rp], is_single=.true.)
    call w%delete('/joints')
    call w%group('/extra')
    call w%reals('/extra/anything', [1], [1.0_rp])
    call w%accept('single precision, no joints, data of others in extra', zero)
  end subroutine test_valid

  subroutine test_header()
    call w%sample(PATH)
    call w%delete_attribute('/', 'schema')
    call w%refuse('attribute schema: missing')
    call w%sample(PATH)
    call w%text_attribute('/', 'schema', 'a plane')
    call w%refuse('attribute schema: is ''a plane'', expected ''flusi-msm wing''')
    call w%sample(PATH)
    call w%integer_attribute('/', 'version', 2)
    call w%refuse('attribute version: is 2; this program reads version 1')
    call w%sample(PATH)
    call w%text_attribute('/', 'version', '1')
    call w%refuse('attribute version: missing or not an integer')
    call w%sample(PATH)
    call w%integer_attribute('/', 'index_base', 2)
    call w%refuse('attribute index_base: is 2; valid: 0 or 1')
    call w%sample(PATH)
    call w%delete_attribute('/', 'index_base')
    call w%refuse('attribute index_base: missing')
    call w%sample(PATH)
    call w%group('/joint')
    call w%refuse('/: unknown object ''joint''; did you mean ''joints''?; valid: points, ')
  end subroutine test_header

  !> The side to which z points: what a file may say of it, and what it means.
  subroutine test_z_side()
    character(*), parameter :: VALID = '; valid: left ventral | right dorsal | left dorsal | right ventral, the wing '// &
                               'that was measured and the side of it to which z points'
    type(wing_t) :: wing, fine
    integer :: i
    call w%sample(PATH)
    call w%accept('no side', wing)
    call w%check('it is not stated', wing%z_side == SIDE_UNSTATED)
    call w%check('z is then on the ventral side',.not. wing%z_is_dorsal())
    do i = 1, size(Z_SIDES)
      call w%sample(PATH)
      if (i == 2) then
        call w%variable_text_attribute('/', 'z_side', trim(Z_SIDES(i)%word))
      else
        call w%text_attribute('/', 'z_side', trim(Z_SIDES(i)%word))
      end if
      call w%accept(trim(Z_SIDES(i)%word), wing)
      call w%check('it is known', wing%z_side == Z_SIDES(i)%kind)
      call w%check('up is up', wing%z_is_dorsal() .eqv. (i == 2 .or. i == 3))
      call refine_wing(wing, fine)
      call w%check('on a finer mesh, too', fine%z_side == Z_SIDES(i)%kind)
    end do
    call w%sample(PATH)
    call w%text_attribute('/', 'z_side', 'up')
    call w%refuse('attribute z_side: is ''up'''//VALID)
    call w%sample(PATH)
    call w%text_attribute('/', 'z_side', 'dorsal')
    call w%refuse('attribute z_side: is ''dorsal'''//VALID)
    call w%sample(PATH)
    call w%integer_attribute('/', 'z_side', 1)
    call w%refuse('attribute z_side: is not a text'//VALID)
  end subroutine test_z_side

  !> What a file may state of the mass.
  subroutine test_mass()
    character(*), parameter :: LAWS = '; valid: uniform | bilinear'
    type(wing_t) :: wing, fine
    call w%sample(PATH)
    call w%accept('no mass', wing)
    call w%check('nothing is stated', wing%mass%law == MEMBRANE_UNSTATED .and. .not. wing%mass%vein_density > 0)
    call sample_with_mass('bilinear')
    call w%real_attribute('/', 'membrane_weights', [1.75_rp, -147.0_rp, 101.0_rp])
    call w%accept('a bilinear law', wing)
    call check_mass(wing)
    call refine_wing(wing, fine)
    call check_mass(fine)
    call sample_with_mass('uniform')
    call w%accept('a uniform law', wing)
    call w%check('it is known', wing%mass%law == MEMBRANE_UNIFORM)
    call sample_with_mass('bilinear')
    call w%refuse('attribute membrane_weights: missing')
    call sample_with_mass('conical')
    call w%refuse('attribute membrane_law: is ''conical'''//LAWS)
    call sample_with_mass('uniform')
    call w%delete_attribute('/', 'membrane_law')
    call w%refuse('attribute membrane_law: missing, although there is membrane_mass'//LAWS)
    call sample_with_mass('uniform')
    call w%delete_attribute('/', 'membrane_mass')
    call w%refuse('attribute membrane_mass: missing or not a real [kg]')
    call sample_with_mass('uniform')
    call w%real_attribute('/', 'membrane_mass', [-1.0_rp])
    call w%refuse('attribute membrane_mass: is -1.0 kg; it must be positive')
    call sample_with_mass('uniform')
    call w%delete_attribute('/', 'mass_source')
    call w%refuse('attribute mass_source: missing')
    call w%sample(PATH)
    call w%integer_attribute('/', 'vein_density', 1300)
    call w%refuse('attribute vein_density: missing or not a real [kg/m^3]')
  end subroutine test_mass

  subroutine sample_with_mass(law)
    character(*), intent(in) :: law
    call w%sample(PATH)
    call w%text_attribute('/', 'membrane_law', law)
    call w%real_attribute('/', 'membrane_mass', [8.0e-8_rp])
    call w%real_attribute('/', 'vein_density', [1250.0_rp])
    call w%text_attribute('/', 'mass_source', 'a balance')
  end subroutine sample_with_mass

  subroutine check_mass(wing)
    type(wing_t), intent(in) :: wing
    call w%check('law, masses and source are known', wing%mass%law == MEMBRANE_BILINEAR .and. &
                 wing%mass%source == 'a balance' .and. &
                 maxval(abs([wing%mass%membrane/8.0e-8_rp - 1, wing%mass%vein_density/1250 - 1, &
                             wing%mass%weights - [1.75_rp, -147.0_rp, 101.0_rp]])) < 1e-14_rp)
  end subroutine check_mass

  subroutine test_points()
    real(rp) :: points(27)
    integer :: i
    points = [(real(modulo(7*i, 26), rp), i=1, 27)]
    call w%sample(PATH)
    call w%delete('/points')
    call w%refuse('/points: missing; it must hold rows of 3 real numbers')
    call w%sample(PATH)
    call w%reals('/points', [9, 3], points)
    call w%refuse('/points: must hold rows of 3 real numbers, but its shape is (3, 9)')
    call w%sample(PATH)
    call w%reals('/points', [27], points)
    call w%refuse('/points: must hold rows of 3 real numbers, but its shape is (27)')
    call w%sample(PATH)
    call w%integers('/points', [3, 9], [(i, i=1, 27)])
    call w%refuse('/points: must hold rows of 3 real numbers')
    call w%sample(PATH)
    call w%group('/joints/more')
    call w%refuse('/joints/more: must hold a list of integers')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], sample_points(), units='-')
    call w%refuse('/points: attribute units is missing or not a text; it must be ''m''')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], 1000*sample_points(), units='mm')
    call w%refuse('/points: attribute units is ''mm''; it must be ''m''')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], changed(14, transfer(QUIET_NAN, 1.0_rp)))
    call w%refuse('/points: point 5 has an infinite or undefined coordinate')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], changed(14, transfer(SIGNALLING_NAN, 1.0_rp)))
    call w%refuse('/points: point 5 has an infinite or undefined coordinate')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], changed(1, 1e300_rp))
    call w%refuse('/points: point 1 has the coordinate 1e300 m; coordinates are in metres')
    call w%sample(PATH)
    call w%reals('/points', [3, 10], [sample_points(), 5e-3_rp, 0.0_rp, 0.0_rp])
    call w%refuse('/: point 10 is in no triangle and no vein')
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
    call w%accept('the triangles of the sample', wing)
    call with_triangle([2, 3, 10])
    call w%refuse('/triangles: triangle 3: point 10 does not exist; the points are 1 to 9')
    call with_triangle([2, 3, -huge(1)])
    call w%refuse('/triangles: triangle 3: point -1000000000 does not exist')
    call with_triangle([2, 6, 3])
    call w%refuse_any('/triangles: triangle 3 (points 2, 6, 3) is inverted')
    call with_triangle([2, 6, 6])
    call w%refuse_any('/triangles: triangle 3 (points 2, 6, 6) has the same corner twice')
    call with_triangle([1, 2, 3])
    call w%refuse_any('/triangles: triangle 3 (points 1, 2, 3) is degenerate')
    call with_triangle([1, 2, 5])
    call w%refuse_any('/triangles: triangles 1 and 3 lie on the same side of their common edge 1-2, or '// &
                      'are the same')
    call with_triangle([2, 3, 5])
    call w%refuse_any('/triangles: triangles 3 and 4 lie on the same side of their common edge 5-2')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], changed(5, 2e-3_rp))
    call w%refuse_any('/triangles: triangle 1 (points 1, 2, 5) is inverted')
    call w%sample(PATH)
    call w%reals('/points', [3, 9], turned())
    call w%refuse_any('triangle 1 (points 1, 2, 5) is inverted: its corners must run counter-clockwise '// &
                      'seen from +z')
    call w%sample(PATH)
    call w%integers('/triangles', [2, 12], [1, 2, 5, 1, 5, 4, 2, 3, 6, 2, 6, 5, 4, 5, 8, 4, 8, 7, 5, 6, 9, &
                                            5, 9, 8])
    call w%refuse('/triangles: must hold rows of 3 integers, but its shape is (12, 2)')
    points(:27) = sample_points()
    points(28:) = [5e-3_rp, 0.0_rp, 0.0_rp, 6e-3_rp, 0.0_rp, 0.0_rp, 5e-3_rp, 1e-3_rp, 0.0_rp]
    call w%sample(PATH)
    call w%reals('/points', [3, 12], points)
    call w%integers('/triangles', [3, 9], [1, 2, 5, 1, 5, 4, 2, 3, 6, 2, 6, 5, 4, 5, 8, 4, 8, 7, 5, 6, 9, &
                                           5, 9, 8, &
                                           10, 11, 12])
    call w%refuse('/: point 10 and 2 more are not connected to root point 1')
    call w%sample(PATH)
    call w%reals('/points', [3, 10], [points(:27), 1e-3_rp, 0.0_rp, 0.0_rp])
    call w%refuse_any('/points: points 2 and 10 are at the same place')
  end subroutine test_triangles

  !> The sample seen from below.
  function turned() result(points)
    real(rp) :: points(27)
    points = sample_points()
    points(2::3) = -points(2::3)
  end function turned

  subroutine test_other_files()
    type(wing_t) :: wing
    type(message_list_t) :: messages
    integer :: unit
    call read_wing('missing.h5', wing, messages)
    call w%check('a missing file is refused', messages%count() == 1 .and. index(messages%text(1), &
                                                                                'missing.h5: does not exist') == 1)
    open (newunit=unit, file=PATH, status='replace')
    write (unit, '(a)') 'no HDF5'
    close (unit)
    call read_wing(PATH, wing, messages)
    call w%check('and one of another kind', messages%count() == 2)
    if (messages%count() == 2) call w%check('with the reason', index(messages%text(2), 'not an HDF5 file') > 0)
  end subroutine test_other_files

  !> All ranks get what rank 0 has read.
  subroutine test_load()
    type(wing_t) :: wing
    type(message_list_t) :: messages
    if (t%world%is_root) then
      call w%sample('all.h5')
      call w%text_attribute('/', 'z_side', 'right dorsal')
      call w%text_attribute('/', 'membrane_law', 'bilinear')
      call w%real_attribute('/', 'membrane_mass', [8.0e-8_rp])
      call w%real_attribute('/', 'membrane_weights', [1.75_rp, -147.0_rp, 101.0_rp])
      call w%text_attribute('/', 'mass_source', 'a balance')
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
    call t%check('the side to which z points', wing%z_side == SIDE_RIGHT_DORSAL)
    call t%check('the mass', wing%mass%law == MEMBRANE_BILINEAR .and. wing%mass%source == 'a balance' .and. &
                 abs(wing%mass%membrane - 8.0e-8_rp) < 1e-20_rp .and. abs(wing%mass%weights(2) + 147) < 1e-12_rp)
    call t%check('joints and root', all(wing%joints(2)%nodes == [4, 5, 6]) .and. all(wing%root == [1, 4, 7]))
    call load_wing(t%world, 'bad.h5', wing, messages)
    call t%check('all ranks refuse a bad file with the same messages', messages%count() >= 2)
    if (messages%count() >= 2) call t%check('that name it', index(messages%text(1), 'bad.h5: /points') == 1)
  end subroutine test_load
end program test_wing_file
