! SPDX-License-Identifier: GPL-3.0-or-later
!> The model of a wing with its masses, for tests of its motion.
module weighed_model
  use base_errors, only: failure_t, message_list_t
  use solid_mass, only: lump_mass, mass_params_t, mass_t
  use solid_mass_effects, only: mass_parts_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: make_weighed_model

contains

  !> Makes the model of a wing, and the parts of its mass with the usual densities. `is_valid` is false if the wing has a mistake.
  subroutine make_weighed_model(wing, params, parts, model, is_valid)
    type(wing_t), intent(in) :: wing
    type(solid_params_t), intent(in) :: params
    type(mass_parts_t), intent(inout) :: parts
    type(solid_model_t), intent(inout) :: model
    logical, intent(out) :: is_valid
    type(mass_t) :: mass
    type(mass_params_t) :: material
    type(message_list_t) :: messages
    type(failure_t) :: failure
    call lump_mass(wing, material, mass, messages)
    call parts%init(wing, mass)
    call model%init(wing, params, failure)
    is_valid = messages%count() == 0 .and. .not. failure%failed
  end subroutine make_weighed_model
end module weighed_model
