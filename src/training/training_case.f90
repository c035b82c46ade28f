! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds one training as search and least squares see it: the experiment, its free parameters, and their options. SI units.
module training_case
  use cmaes_options, only: cmaes_options_t
  use least_squares_fit, only: fit_options_t
  use measurement_bending_case, only: bending_case_t
  implicit none
  private
  public :: training_case_t

  !> The experiment has the free parameters as its unknowns.
  type, extends(bending_case_t) :: training_case_t
    type(cmaes_options_t) :: search
    character(:), allocatable :: restarts   !< none, ipop or bipop
    integer :: max_restarts = 0
    logical :: starts_at_wing = .false., use_chi2 = .false.
    integer :: n_stages = 1
    logical :: polish = .true., intervals = .true.
    integer :: polish_starts = 1            !< points of the search from which a polish may begin
    type(fit_options_t) :: fit
    character(:), allocatable :: name       !< first part of the names of checkpoints
    integer :: checkpoint_every = 1         !< generations
  end type training_case_t
end module training_case
