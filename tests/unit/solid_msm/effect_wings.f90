! SPDX-License-Identifier: GPL-3.0-or-later
!> A wing with all effects, for the tests of their laws and of their derivatives.
module effect_wings
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use named_params, only: set_each
  use sample_wings, only: make_fly_wing
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, solid_params_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: make_plain, model_of

  real(rp), parameter, public :: STENCIL(4) = [4/5.0_rp, -1/5.0_rp, 4/105.0_rp, -1/280.0_rp] !< 8th-order difference
  real(rp), parameter, public :: DISC(3) = [4.0e-3_rp, 0.0_rp, 1.5e-3_rp]                    !< [m] of the damage

contains

  !> The wing without effects, and displacements u(3, :) and along(3, :) of its points.
  subroutine make_plain(wing, plain, u, along)
    type(wing_t), intent(out) :: wing
    type(solid_model_t), intent(out) :: plain
    real(rp), allocatable, intent(out) :: u(:, :), along(:, :)
    type(failure_t) :: failure
    integer :: i, j
    wing = make_fly_wing(24, 12)
    call plain%init(wing, default_params(wing), failure)
    allocate (u(3, plain%n_all), along(3, plain%n_all))
    do i = 1, plain%n_all
      u(:, i) = [(4.0e-5_rp*sin(2.9_rp*i + 1.1_rp*j**2), j=1, 3)]
      along(:, i) = [(sin(1.7_rp*i + 0.3_rp*j), j=1, 3)]
    end do
    call plain%zero_clamped(u)
    call plain%zero_clamped(along)
  end subroutine make_plain

  !> A model with places for damage and softness and room for torsion, and effects at values of their own or at null.
  function model_of(wing, is_null, has_sides, has_sided_veins) result(model)
    type(wing_t), intent(in) :: wing
    logical, intent(in) :: is_null, has_sides
    logical, intent(in), optional :: has_sided_veins
    type(solid_model_t) :: model
    type(solid_params_t) :: params
    type(failure_t) :: failure
    params = default_params(wing)
    params%effects%disc = DISC
    params%effects%soft_vein = 'R4+5'
    params%effects%soft_fraction = 0.45_rp
    params%joint = 2.0e-6_rp
    params%joint(3) = -1
    params%effects%has_sides = has_sides
    if (present(has_sided_veins)) params%effects%has_sided_veins = has_sided_veins
    if (.not. is_null) then
      if (has_sides) call set_each(params, 'one_way:', [1.4_rp, 0.6_rp, 1.4_rp, 0.6_rp, 1.4_rp, 0.6_rp, 1.4_rp, 0.6_rp, &
                                                       1.4_rp, 0.6_rp]) ! some bend up, some down
      call params%set_named('E_gradient', -0.8_rp)
      call params%set_named('damage', 0.3_rp)
      call params%set_named('soft', 0.2_rp)
      call params%set_named('orthotropy', 0.4_rp)
      call params%set_named('thickness_gradient', 0.6_rp)
      call params%set_named('joint_hardening', 5.0_rp)
      call params%set_named('hardening:'//trim(params%joint_names(2)), -0.5_rp)
      call params%set_named('cuticle', 2.0e-6_rp)
      call params%set_named('pretension', 0.7_rp)
      if (params%effects%has_sided_veins) then
        call params%set_named('camber_span', 2.0_rp)
        call params%set_named('camber_chord', -80.0_rp)
        call params%set_named('camber_twist', 15.0_rp)
        call params%set_named('torsion', 0.8_rp)
      end if
    end if
    call model%init(wing, params, failure)
    if (failure%failed) error stop 'effect_wings: the model cannot be built'
  end function model_of
end module effect_wings
