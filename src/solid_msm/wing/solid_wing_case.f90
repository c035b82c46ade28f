! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds a wing with its mechanical model and its mass. SI units.
module solid_wing_case
  use base_kinds, only: rp
  use solid_mass, only: mass_params_t, mass_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_wing, only: wing_t
  use solid_wing_fingerprint, only: FINGERPRINT_LENGTH
  implicit none
  private
  public :: wing_case_t

  type :: wing_case_t
    character(:), allocatable :: path      !< of the wing file
    type(wing_t) :: wing
    character(FINGERPRINT_LENGTH) :: fingerprint = '' !< of the wing in its file (solid_wing_fingerprint)
    type(solid_model_t) :: model
    type(solid_params_t) :: requested      !< parameters before joints became as stiff as their veins
    type(mass_params_t) :: material
    type(mass_t) :: mass
    logical :: has_mass = .false.
    real(rp) :: requested_size(2) = 0      !< largest x and mean chord that the input requests [m]; 0: as in the file
    real(rp) :: scale(2) = 1               !< scale factors along x and y relative to the wing in its file
    integer :: tip = 0                     !< the point farthest from the centre of the root
  end type wing_case_t
end module solid_wing_case
