! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds what a user states about measurements of motion that may come next: [Next].
module measurement_proposal_choices
  use base_kinds, only: rp
  implicit none
  private
  public :: proposal_choices_t

  type :: proposal_choices_t
    integer :: n_modes = 4                  !< natural modes, the lowest ones
    real(rp) :: frequency_sd = 0.005_rp     !< of a frequency, relative
    real(rp) :: damping_sd = 0.05_rp        !< of a damping ratio, relative
    integer :: n_samples = 200              !< of a record
    real(rp) :: n_periods = 8               !< periods of the lowest mode in a record
    real(rp) :: motion_sd = 0.01_rp         !< of a value of a record, of the displacement before the release
    real(rp) :: force_sd = 0.05_rp          !< of the released force, relative
  end type proposal_choices_t
end module measurement_proposal_choices
