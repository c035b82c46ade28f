! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds 90 % intervals of the parameters of a training by profile likelihood, and describes them in words. On rank 0.
module training_intervals
  use base_process, only: wall_seconds
  use least_squares_problem, only: unknowns_t
  use least_squares_profile, only: linear_guess_t, profile_interval, profile_sentence, THRESHOLD_90
  use least_squares_state, only: solver_point_t
  use measurement_experiment, only: experiment_t
  use training_case, only: training_case_t
  use training_fit, only: counted
  use training_listener, only: training_listener_t
  use training_outcome, only: trained_t
  use training_pool_problem, only: pool_problem_t
  use training_space, only: search_space_t
  implicit none
  private
  public :: find_intervals, interval_sentence, left_out_names

contains

  !> Finds 90 % intervals of all unknowns about the end of the polish and the state there, each from all loads except those that
  !> jump between its ends.
  subroutine find_intervals(settings, problem, unknowns, space, at_end, log, trained)
    class(training_case_t), intent(in) :: settings
    type(pool_problem_t), intent(inout) :: problem
    type(unknowns_t), intent(in) :: unknowns
    type(search_space_t), intent(in) :: space
    type(solver_point_t), intent(in) :: at_end
    class(training_listener_t), intent(inout) :: log
    type(trained_t), intent(inout) :: trained
    integer :: i, l, n_loads
    n_loads = size(settings%experiment%loads)
    problem%n_parts = size(trained%coordinates)
    problem%begun = wall_seconds()
    allocate (trained%intervals(size(trained%coordinates)))
    allocate (trained%is_left_out(n_loads, size(trained%coordinates)))
    do i = 1, size(trained%coordinates)
      problem%part = i
      problem%name = trim(space%names(i))
      call profile_interval(problem, unknowns, at_end, i, linear_guess_t(trained%posterior%sd(i)), THRESHOLD_90, settings%fit, &
                            trained%intervals(i))
      if (problem%pool%is_stopped) return
      trained%n_evaluations = trained%n_evaluations + trained%intervals(i)%n_evaluations
      trained%is_left_out(:, i) = trained%intervals(i)%is_left_out
      call log%say('          '//interval_sentence(settings%experiment, space, trained, i))
    end do
    trained%has_intervals = .true.
    do l = 1, n_loads
      i = count(trained%is_left_out(l, :))
      if (i > 0) call log%say('warning   the shape under '//settings%experiment%measurement%loads(l)%name// &
                              ' jumps, so this load is left out of '//counted(i, 'interval'))
    end do
  end subroutine find_intervals

  !> Returns a sentence about parameter i, with the loads that its interval leaves out.
  function interval_sentence(experiment, space, trained, i) result(sentence)
    type(experiment_t), intent(in) :: experiment
    type(search_space_t), intent(in) :: space
    type(trained_t), intent(in) :: trained
    integer, intent(in) :: i
    character(:), allocatable :: sentence, names
    sentence = profile_sentence(trim(space%names(i)), trim(space%units(i)), space%is_log(i), trained%intervals(i))
    names = left_out_names(experiment, trained, i)
    if (names /= '') sentence = sentence//'; found without '//names//', where the shape snaps as the parameter changes'
  end function interval_sentence

  !> Returns the names of the loads that interval i leaves out, with a blank between them; empty if there are none.
  function left_out_names(experiment, trained, i) result(names)
    type(experiment_t), intent(in) :: experiment
    type(trained_t), intent(in) :: trained
    integer, intent(in) :: i
    character(:), allocatable :: names
    integer :: l
    names = ''
    do l = 1, size(trained%is_left_out, 1)
      if (trained%is_left_out(l, i)) names = names//' '//experiment%measurement%loads(l)%name
    end do
    names = trim(adjustl(names))
  end function left_out_names
end module training_intervals
