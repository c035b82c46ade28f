! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds one training with the data that search and least squares need: the experiment, its free parameters, and their options. SI
!> units.
module training_case
  use base_named_kinds, only: kind_of, word_of
  use base_visitor, only: visitor_t
  use cmaes_options, only: cmaes_options_t
  use cmaes_search, only: RESTART_RULES, RESTARTS_NONE
  use least_squares_fit, only: fit_options_t
  use measurement_bending_case, only: bending_case_t
  implicit none
  private
  public :: training_case_t

  !> Holds a training. The unknowns of its experiment are the free parameters.
  type, extends(bending_case_t) :: training_case_t
    type(cmaes_options_t) :: search
    integer :: restarts = RESTARTS_NONE
    integer :: max_restarts = 0
    logical :: starts_at_wing = .false., use_chi2 = .false.
    integer :: n_stages = 1
    logical :: search_is_short = .false.    !< the search ends with the first generation that has a feasible candidate
    logical :: polish = .true., moves = .true., intervals = .true.
    integer :: polish_starts = 1            !< points of the search from which a polish may begin
    type(fit_options_t) :: fit
    character(:), allocatable :: name       !< first part of the names of checkpoints
    integer :: checkpoint_every = 1         !< generations between two checkpoints
  contains
    procedure :: visit => case_visit
  end type training_case_t

contains

  !> Shows to the visitor what determines the search, but neither how long it runs nor what follows it. Experiment and measurement
  !> enter by numbers that are computed from them: see training_fingerprint.
  subroutine case_visit(self, visitor)
    class(training_case_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    character(:), allocatable :: restarts
    restarts = word_of(RESTART_RULES, self%restarts) ! checkpoints know it as a word
    call visitor%visit('search', self%search)
    call visitor%visit('restarts', restarts)
    self%restarts = kind_of(RESTART_RULES, restarts)
    call visitor%visit('starts_at_wing', self%starts_at_wing)
    call visitor%visit('use_chi2', self%use_chi2)
    call visitor%visit('n_stages', self%n_stages)
    call visitor%leave_out('max_restarts search_is_short polish moves intervals polish_starts fit name checkpoint_every')
    call visitor%leave_out('wing_case measurement_path measurement outliers instrument prior_decades')
    call visitor%visit('free', self%free_parameters)
    call visitor%visit('solver', self%experiment%options)
  end subroutine case_visit
end module training_case
