! SPDX-License-Identifier: GPL-3.0-or-later
!> A fingerprint changes with everything that bends, and with nothing else.
program test_wing_fingerprint
  use base_kinds, only: rp
  use sample_wings, only: make_fly_wing
  use solid_wing, only: wing_t, SIDE_RIGHT_DORSAL
  use solid_wing_fingerprint, only: wing_fingerprint
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(wing_t) :: wing, other
  character(16) :: known
  call t%start(parallel=.false.)
  wing = make_fly_wing(24, 12)
  known = wing_fingerprint(wing)
  call t%check('the digits of this wing, which files hold', known == '92253D6B45FFF3F6')
  call t%check('sixteen digits', verify(known, '0123456789ABCDEF') == 0)

  other = wing
  other%z_side = SIDE_RIGHT_DORSAL
  other%mass%membrane = 1
  other%points(3, 5) = -other%points(3, 5) ! 0 becomes -0
  call t%check('sides, masses and the sign of 0 do not count', wing_fingerprint(other) == known)

  other = wing
  other%points(1, 7) = nearest(other%points(1, 7), 1.0_rp)
  call differs('a point')
  other = wing
  other%triangles(:, 3) = cshift(other%triangles(:, 3), 1)
  call differs('a triangle')
  other = wing
  other%veins(2)%diameters(1) = 1.01_rp*other%veins(2)%diameters(1)
  call differs('a diameter')
  other = wing
  other%veins(2)%name = other%veins(2)%name//'x'
  call differs('the name of a vein')
  other = wing
  other%veins(2)%nodes = other%veins(2)%nodes(size(other%veins(2)%nodes):1:-1)
  call differs('the direction of a vein')
  other = wing
  other%joints(1)%nodes = other%joints(2)%nodes
  call differs('the place of a joint')
  other = wing
  other%joints = wing%joints(2:)
  call differs('a joint')
  other = wing
  other%root = wing%root(2:)
  call differs('a root point')
  call t%finish()

contains

  subroutine differs(what)
    character(*), intent(in) :: what
    call t%check(what//' counts', wing_fingerprint(other) /= known)
  end subroutine differs
end program test_wing_fingerprint
