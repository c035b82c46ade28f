! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures how well, how reliably and at which cost wings are trained (docs/results/training-results.md).
!>
!> usage: bench_training WING.h5 [--seed S | --starts N [FIRST] | --coverage N [FIRST] | --budget GENERATIONS [log | linear]],
!> a wing with ten joints
!>
!> Without options or with --seed it runs one start of the paper's validation; its last line is a JSON record.
program training
  use base_kinds, only: rp
  use base_text, only: parse_integer
  use bench_budget, only: measure_budget
  use bench_coverage, only: cover
  use bench_replicate, only: N_UNKNOWNS, replicate_t
  use bench_validation, only: NOISE, predict_sd, validate, validation_truth
  use loaded_wing, only: wing_of_argument
  use measurement_experiment, only: experiment_t
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_outcome, only: exit_code_of, OUTCOME_MISTAKE, OUTCOME_NOT_CONVERGED
  use base_process, only: exit_with
  implicit none
  type(replicate_t) :: replicate
  type(experiment_t), target :: experiment
  real(rp) :: truth(N_UNKNOWNS), sd(N_UNKNOWNS)
  character(20) :: mode, box
  integer :: number, first, i, n_met
  logical :: is_done, is_met

  call replicate%init(wing_of_argument())
  mode = '--seed'
  if (command_argument_count() > 1) call get_command_argument(2, mode)
  number = whole_argument(3)
  if (mode /= '--budget') first = whole_argument(4)
  select case (mode)
  case ('--seed', '--starts')
    truth = validation_truth(replicate)
    call replicate%measure(truth, NOISE, experiment, is_done)
    if (.not. is_done) call exit_with(exit_code_of(OUTCOME_NOT_CONVERGED))
    sd = predict_sd(experiment, truth)
    if (mode == '--seed') then
      call validate(replicate, experiment, truth, sd, number, is_met)
    else
      n_met = 0
      do i = 1, number
        call validate(replicate, experiment, truth, sd, first + i - 1, is_met)
        if (is_met) n_met = n_met + 1
      end do
      write (output_unit, '(a,i0,a,i0,a)') '{"starts":', number, ',"starts_within_all_bars":', n_met, '}'
    end if
  case ('--coverage')
    call cover(replicate, number, first)
  case ('--budget')
    box = 'log'
    if (command_argument_count() > 3) call get_command_argument(4, box)
    if (box /= 'log' .and. box /= 'linear') call refuse(trim(box)//' is no box; log or linear')
    call measure_budget(replicate, number, trim(box))
  case default
    call refuse('unknown option '//trim(mode))
  end select

contains

  !> Returns argument number i as a number, 1 if there is none.
  integer function whole_argument(i)
    integer, intent(in) :: i
    character(:), allocatable :: problem
    character(20) :: text
    whole_argument = 1
    if (command_argument_count() < i) return
    call get_command_argument(i, text)
    call parse_integer(trim(text), whole_argument, problem)
    if (allocated(problem)) call refuse(trim(text)//': '//problem)
    if (whole_argument < 1) call refuse(trim(text)//': must be positive')
  end function whole_argument

  subroutine refuse(problem)
    character(*), intent(in) :: problem
    write (error_unit, '(a)') 'bench_training: '//problem
    call exit_with(exit_code_of(OUTCOME_MISTAKE))
  end subroutine refuse
end program training
