! SPDX-License-Identifier: GPL-3.0-or-later
!> What views of the modes of a wing see of a change, against products with the whole shapes that solid_modal finds by equations
!> for each parameter. The first argument names a wing file.
program test_solid_mode_views
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use loaded_wing, only: wing_of_argument
  use solid_mass, only: lump_mass, mass_params_t, mass_t
  use solid_mass_effects, only: mass_effects_t, mass_parts_t, N_MASS_EFFECTS
  use solid_modal, only: modal_t, mode_slopes_t
  use solid_mode_views, only: mode_views_t
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, solid_params_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: damage_direction, parameter_direction
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 5, N_KNOWN = 8, N_VIEWS = 2
  real(rp), parameter :: AIR = 1.2_rp         !< [kg/m^3]
  !> Both solve the same equations to residuals of 1e-13. Their condition beside eight known modes is
  !> lambda_9/(lambda_9 - lambda_5), below 10, and the modes themselves have residuals of 1e-12.
  real(rp), parameter :: LIMIT = 1.0e-9_rp
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(mass_parts_t) :: parts
  type(mass_effects_t) :: effects

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  call test_wing('with a stiff clamp', 0.0_rp)
  call test_wing('with a compliant clamp', 2.0e3_rp)
  call t%finish()

contains

  !> All kinds of changes, of a wing whose clamp has this compliance [rad/(N m)].
  subroutine test_wing(where, compliance)
    character(*), intent(in) :: where
    real(rp), intent(in) :: compliance
    type(mass_t) :: mass
    type(mass_params_t) :: material
    type(message_list_t) :: messages
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(modal_t) :: modal
    type(mode_views_t) :: views
    type(mode_slopes_t) :: slopes
    type(stiffness_t) :: direction
    type(failure_t) :: failure
    real(rp), allocatable :: masses(:, :), dm(:, :), view(:, :, :)
    logical :: same(N, N)
    integer :: i
    call lump_mass(wing, material, mass, messages)
    call parts%init(wing, mass)
    effects%corner = wing%triangles(:, size(wing%triangles, 2)/2)
    effects%weight = [0.5_rp, 0.3_rp, 0.2_rp]
    params = default_params(wing)
    params%joint = 1.0e-6_rp
    call params%set_named('root_flap', compliance)
    call params%set_named('root_twist', 0.5_rp*compliance)
    call model%init(wing, params, failure)
    call modal%init(model)
    allocate (masses(3, model%n_all), dm(3, model%n_all), view(3, model%n_all, N_VIEWS))
    call parts%masses(effects, AIR, masses)
    call modal%solve(masses, N_KNOWN, failure)
    call t%check('the modes are found '//where,.not. failure%failed)
    view = 0 ! the displacement of a point, and the inertia across the wing
    view(3, effects%corner(1), 1) = 1
    view(3, :, 2) = masses(3, :)
    same = .true.
    call views%init(modal, N, view)
    do i = 1, 3
      if (i < 3) call parameter_direction(modal%model, params%find(merge('E', 'D', i == 1)), direction)
      if (i == 3) call damage_direction(modal%model, [4.5e-3_rp, -0.5e-3_rp, 1.2e-3_rp], direction)
      call modal%slopes_of_stiffness(direction, same, slopes)
      call views%by_stiffness(modal, direction)
      call compare('a change of stiffness '//achar(48 + i)//' '//where, modal, views, slopes, view)
    end do
    do i = 1, N_MASS_EFFECTS
      call parts%derivative(effects, AIR, i, dm)
      call modal%slopes_of_mass(dm, same, slopes)
      call views%by_mass(modal, dm)
      call add_norms(modal, dm, slopes)
      call compare('a change of mass '//achar(48 + i)//' '//where, modal, views, slopes, view)
    end do
    do i = 1, 2
      call modal%slopes_of_clamp(i, same, slopes)
      call views%by_clamp(modal, i)
      call compare('a change of the clamp about axis '//achar(48 + i)//' '//where, modal, views, slopes, view)
    end do
    call modal%free()
  end subroutine test_wing

  !> Takes the change of the norms out of that of the shapes, which is then beside all N modes.
  subroutine add_norms(modal, dm, slopes)
    type(modal_t), intent(in) :: modal
    real(rp), intent(in) :: dm(:, :)
    type(mode_slopes_t), intent(inout) :: slopes
    integer :: i
    do i = 1, N
      slopes%shapes(:, :, i) = slopes%shapes(:, :, i) + 0.5_rp*sum(dm*modal%shapes(:, :, i)**2)*modal%shapes(:, :, i)
    end do
  end subroutine add_norms

  !> Compares forces and views of the change of the shapes, in units of the largest view of a mode times the relative change.
  subroutine compare(what, modal, views, slopes, view)
    character(*), intent(in) :: what
    type(modal_t), intent(in) :: modal
    type(mode_views_t), intent(in) :: views
    type(mode_slopes_t), intent(in) :: slopes
    real(rp), intent(in) :: view(:, :, :)
    real(rp) :: seen(N_VIEWS, N), error
    integer :: i, v
    do i = 1, N
      do v = 1, N_VIEWS
        seen(v, i) = sum(view(:, :, v)*slopes%shapes(:, :, i))
      end do
    end do
    error = maxval(abs(views%force - slopes%force))/maxval(abs(slopes%force))
    call t%check_below('forces by '//what, error, LIMIT)
    do v = 1, N_VIEWS
      error = maxval(abs(views%change(v, :) - seen(v, :)))
      call t%check_below('a view of '//what, error, LIMIT*maxval(abs(seen(v, :))))
    end do
    call t%check_close('the view of a mode', views%of_modes(2, 1), sum(view(:, :, 2)*modal%shapes(:, :, 1)), rtol=LIMIT)
  end subroutine compare
end program test_solid_mode_views
