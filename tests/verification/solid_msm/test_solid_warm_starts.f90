! SPDX-License-Identifier: GPL-3.0-or-later
!> Warm starts on the blowfly's wing, in the file that the first argument names: straight ones are used,
!> those on which Newton's method leaps over folds, and those from shapes beside a cusp, are redone cold, and both
!> end where the cold path ends.
program test_solid_warm_starts
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use loaded_wing, only: wing_of_argument
  use solid_equilibrium, only: equilibrium_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use wing_shapes, only: shape_t, measure_shape
  implicit none
  real(rp), parameter :: SAME = 1.0e-9_rp !< [m]; the issue's measure of equal shapes
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_params_t) :: params
  type(solid_model_t) :: model
  type(equilibrium_t) :: work
  type(failure_t) :: failure
  real(rp), allocatable :: stiff(:)

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  params = default_params(wing)
  params%young = 12.6e9_rp
  call model%init(wing, params, failure)
  call t%check('the wing is valid',.not. failure%failed)
  stiff = model%params%joint
  params = model%params
  call work%init(model)
  call check_case(5.0e9_rp, 5.0_rp, 8, 0.4e-3_rp, is_straight=.true.)
  call check_case(5.0e9_rp, 5.0_rp, 2, 4.73989640152215e-3_rp, is_straight=.false.)
  ! The neighbour's path goes around a cusp into another shape without a snap, and stumbles there (docs/theory/statics.md).
  call check_case(5.0e9_rp, 0.05_rp, 3, 1.63972085334973e-03_rp, is_straight=.false.)
  call work%free()
  call t%finish()

contains

  subroutine check_case(young, joints, place, force, is_straight)
    real(rp), intent(in) :: young, joints, force
    integer, intent(in) :: place
    logical, intent(in) :: is_straight
    type(shape_t) :: shape
    real(rp) :: u(3, model%n_all)
    params%young = young
    params%joint = joints*stiff
    call measure_shape(model, work, params, place, force, u, shape)
    call t%check('the shape is found, cold and warm', shape%cold .and. shape%warm)
    call t%check_below('steps of half the size lead to it', shape%step_difference, SAME)
    call t%check_below('a warm start leads to it', shape%warm_difference, SAME)
    if (is_straight) then
      call t%check('straight and in few factorisations',.not. shape%redone .and. &
                   shape%warm_factorisations <= 6 + 1)
    else
      call t%check('only because it was redone cold', shape%redone)
    end if
  end subroutine check_case
end program test_solid_warm_starts
