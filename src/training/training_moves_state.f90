! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the state of the moves to other minima, which a checkpoint carries: the lowest minimum so far, the other minima that were
!> met, and how far the moves have come. A move depends on the minimum from which it begins, and on nothing else.
module training_moves_state
  use base_checksum, only: checksum_reals
  use base_kinds, only: i8, rp
  use base_text, only: number_text
  use base_visitor, only: visited_t, visitor_t
  use training_case, only: training_case_t
  use training_outcome, only: trained_t
  implicit none
  private
  public :: moves_state_t

  type, extends(visited_t) :: moves_state_t
    logical :: is_begun = .false.
    integer(i8) :: mark = 0            !< of what determines the fits, besides the search
    integer :: n_done = 0              !< moves, with those that were passed over
    integer :: n_tried = 0             !< of single parameters
    integer :: n_without = 0           !< without one load
    integer :: n_in_vain = 0           !< since the last lower minimum
    integer :: n_lower = 0             !< moves that led to a lower minimum
    integer :: n_evaluations = 0       !< points solved by all fits
    real(rp) :: first_chi2 = 0         !< before the first move
    type(trained_t) :: trained         !< the lowest minimum
    real(rp), allocatable :: local_minima(:, :) !< see trained_t
  contains
    procedure :: visit => state_visit
    procedure :: begin => state_begin
    procedure :: is_of => state_is_of
    procedure :: text => state_text
  end type moves_state_t

contains

  !> Shows every component to the visitor.
  subroutine state_visit(self, visitor)
    class(moves_state_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('is_begun', self%is_begun)
    call visitor%visit('mark', self%mark)
    call visitor%visit('n_done', self%n_done)
    call visitor%visit('n_tried', self%n_tried)
    call visitor%visit('n_without', self%n_without)
    call visitor%visit('n_in_vain', self%n_in_vain)
    call visitor%visit('n_lower', self%n_lower)
    call visitor%visit('n_evaluations', self%n_evaluations)
    call visitor%visit('first_chi2', self%first_chi2)
    call visitor%visit('trained', self%trained)
    call visitor%visit_allocatable('local_minima', self%local_minima)
  end subroutine state_visit

  !> Begins at a minimum, with the evaluations of all fits so far.
  subroutine state_begin(self, settings, trained, local_minima)
    class(moves_state_t), intent(out) :: self
    class(training_case_t), intent(in) :: settings
    type(trained_t), intent(in) :: trained
    real(rp), intent(in) :: local_minima(:, :)
    self%is_begun = .true.
    self%mark = mark_of(settings)
    self%first_chi2 = trained%chi2
    self%n_evaluations = trained%n_evaluations
    self%trained = trained
    self%local_minima = local_minima
  end subroutine state_begin

  !> Tells whether moves with these settings may continue from here.
  logical function state_is_of(self, settings) result(is_of)
    class(moves_state_t), intent(in) :: self
    class(training_case_t), intent(in) :: settings
    is_of = self%is_begun .and. settings%moves .and. self%mark == mark_of(settings)
  end function state_is_of

  !> Returns how many moves were made, in words.
  function state_text(self) result(text)
    class(moves_state_t), intent(in) :: self
    character(:), allocatable :: text
    text = number_text(self%n_tried)//' move'
    if (self%n_tried /= 1) text = text//'s'
    text = text//' of single parameters'
    if (self%n_without > 0) text = text//' and '//number_text(self%n_without)//' without one load'
  end function state_text

  !> Returns the checksum of what determines the fits of a polish and is not in the mark of the search.
  integer(i8) function mark_of(settings) result(mark)
    class(training_case_t), intent(in) :: settings
    associate (f => settings%fit)
      mark = checksum_reals([real(settings%polish_starts, rp), settings%prior_decades, f%damping, f%step_tolerance, &
                             f%reduction_tolerance, f%largest_step, real(f%most_iterations, rp), &
                             real(f%most_rejections, rp), merge(1.0_rp, 0.0_rp, f%is_smooth)], 0_i8)
    end associate
  end function mark_of
end module training_moves_state
