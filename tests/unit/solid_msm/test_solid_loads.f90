! SPDX-License-Identifier: GPL-3.0-or-later
!> A force at a place of the membrane is the same force with the same moment on the corners of the
!> triangle there; gravity is the weight of all points; places beside the wing are refused.
program test_solid_loads
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use sample_wings, only: make_fly_wing
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: default_params
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: FORCE(3) = [1.0e-4_rp, -2.0e-4_rp, 3.0e-4_rp], NEAR = 1.0e-7_rp
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(load_t) :: load
  type(failure_t) :: failure
  real(rp) :: place(2), centre(2), weights(3)
  integer :: triangle, i

  call t%start(parallel=.false.)
  wing = make_fly_wing(24, 12)
  call model%init(wing, default_params(wing), failure)
  call t%check('the wing is valid',.not. failure%failed)
  do triangle = 1, size(wing%triangles, 2), 37
    weights = [0.2_rp, 0.5_rp, 0.3_rp]
    place = matmul(wing%points(:2, wing%triangles(:, triangle)), weights)
    call load%init(model)
    call load%add_at(model, place, FORCE, failure)
    call t%check_below('the whole force acts', norm2(sum(load%force, 2) - FORCE)/norm2(FORCE), 1.0e-14_rp)
    centre = [(sum(load%force(3, :)*model%points(i, :))/FORCE(3), i=1, 2)]
    call t%check_below('at its place', norm2(centre - place)/model%size, 1.0e-14_rp)
    call t%check('on the corners of its triangle', count(abs(load%force(3, :)) > 1.0e-12_rp) == 3 .and. &
                 all(abs(load%force(3, wing%triangles(:, triangle))) > 1.0e-12_rp))
  end do
  i = maxloc(wing%points(1, :), 1)
  call load%init(model)
  call load%add_at(model, wing%points(:2, i) - [NEAR, 0.0_rp], FORCE, failure)
  call t%check('a place just inside the tip is on the wing',.not. failure%failed)
  call load%add_at(model, wing%points(:2, i) + [NEAR, 0.0_rp], FORCE, failure)
  call t%check('one just outside is not', failure%failed)
  call load%init(model)
  call load%add_gravity(spread(2.0e-9_rp, 1, model%n_points), [0.0_rp, 0.0_rp, -9.81_rp])
  call t%check_close('gravity is the weight of all points', sum(load%force(3, :)), &
                     -9.81_rp*2.0e-9_rp*model%n_points, rtol=1.0e-13_rp)
  call load%add_point(5, FORCE)
  call t%check_close('loads add up', load%force(1, 5), FORCE(1), rtol=1.0e-13_rp)
  call t%finish()
end program test_solid_loads
