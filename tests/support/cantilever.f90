! SPDX-License-Identifier: GPL-3.0-or-later
!> A cantilever that moves, for tests of dynamics.
module cantilever
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use sample_wings, only: make_beam
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, solid_params_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: make_cantilever

contains

  !> Length 1, mass 1, n equal segments along x, bending stiffness `ei`, springs of stiffness k; ei = 0 is a rod without
  !> any stiffness of its hinges.
  subroutine make_cantilever(n, ei, k, model, inertia)
    integer, intent(in) :: n
    real(rp), intent(in) :: ei, k
    type(solid_model_t), intent(out) :: model
    type(inertia_t), intent(out) :: inertia
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(failure_t) :: failure
    real(rp) :: masses(n + 1)
    wing = make_beam(n, 1.0_rp, 1.0_rp, [1.0_rp, 0.0_rp, 0.0_rp])
    params = default_params(wing)
    params%young = ei*64/PI
    if (.not. ei > 0) then
      params%young = 1
      params%root_factor = 0
    end if
    params%k_vein = k
    call model%init(wing, params, failure)
    if (failure%failed) error stop 'the cantilever is no valid wing'
    masses = 1.0_rp/n
    masses(n + 1) = 0.5_rp/n
    call inertia%init(model, masses)
  end subroutine make_cantilever
end module cantilever
