! SPDX-License-Identifier: GPL-3.0-or-later
!> Implements `msm_train --screen`: tells which veins and joints these loads can determine at all. It uses the derivatives of all
!> measured values, in units of their errors, at the wing with the values in [Wing] (training_ranking). Rank 0 runs it while the
!> other ranks serve the pool.
module train_screening
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use measurement_bending_pool, only: bending_pool_t
  use measurement_evaluation, only: evaluation_t
  use measurement_experiment, only: experiment_t
  use solid_usual_causes, only: N_COMMON, PARAM_YOUNG
  use train_evaluation, only: print_loads, solve_all_cold
  use train_settings, only: train_settings_t
  use training_ranking, only: rank_parameters, ranking_t
  implicit none
  private
  public :: prepare_screen, screen_wing

contains

  !> Makes Young's modulus E, all veins and all joints the unknowns of the experiment. Every rank calls it.
  subroutine prepare_screen(settings, failure)
    type(train_settings_t), intent(inout) :: settings
    type(failure_t), intent(out) :: failure
    integer :: i
    associate (requested => settings%wing_case%requested)
      call settings%experiment%init(settings%measurement, settings%wing_case%wing, requested, &
                                    [PARAM_YOUNG, (i, i=N_COMMON + 1, requested%count_basic())], settings%choices%solver, &
                                    failure, settings%instrument, [integer ::], settings%masses())
    end associate
  end subroutine prepare_screen

  !> Prints the ranking and a proposal. `are_solved` tells whether every shape was found. Prints nothing if the pool is stopped
  !> meanwhile.
  subroutine screen_wing(settings, pool, are_solved)
    type(train_settings_t), intent(in) :: settings
    type(bending_pool_t), intent(inout) :: pool
    logical, intent(out) :: are_solved
    type(evaluation_t), allocatable :: evaluations(:)
    associate (e => settings%experiment)
      are_solved = .false.
      call solve_all_cold(e, pool, e%start(), evaluations)
      if (pool%is_stopped) return
      call print_loads(output_unit, e, evaluations)
      are_solved = all(evaluations%is_solved)
      if (.not. are_solved) return
      call print_ranking(e, rank_parameters(e, evaluations))
    end associate
  end subroutine screen_wing

  !> Prints the parameters in the order of their effect, and proposes those that the loads determine.
  subroutine print_ranking(e, ranking)
    type(experiment_t), intent(in) :: e
    type(ranking_t), intent(in) :: ranking
    real(rp), parameter :: UM = 1.0e6_rp, TENTH = 0.1_rp
    type(parameter_t) :: p
    character(:), allocatable :: proposal
    integer :: i
    proposal = ''
    write (output_unit, '(a)') '', 'effect of 10 %: rms movement of the measured points if the parameter changes by 10 %;', &
      'over noise: signal-to-noise ratio of a change by a factor e, at the declared errors;', &
      'sd: predicted standard deviation of the logarithm if this parameter alone is fitted, and if all parameters above it '// &
      'are fitted too', '', &
      'rank  parameter                 effect of 10 % [um]  over noise    sd alone  sd with those above  proposed'
    do i = 1, size(ranking%order)
      p = e%describe(ranking%order(i))
      if (i <= ranking%n_proposed) proposal = proposal//', '//p%name
      write (output_unit, '(i4,2x,a26,f19.4,es12.2,a,a,a)') i, p%name//repeat(' ', 26), UM*TENTH*ranking%moved(i), &
        ranking%effect(i), sd_text(ranking%effect(i), 12), sd_text(ranking%remaining(i), 21), &
        merge('       yes', '        no', i <= ranking%n_proposed)
    end do
    if (proposal == '') then
      write (output_unit, '(a)') '', 'these loads determine none of the parameters within a factor of two'
    else
      write (output_unit, '(a)') '', 'proposed:  parameters = '//proposal(3:)
    end if
    write (output_unit, '(a)') 'D is not ranked, because it is a regularisation. The results hold for the values of [Wing] '// &
      'and for the declared errors.'
    flush (output_unit)
  end subroutine print_ranking

  !> Returns 1/length as text of `width` characters.
  function sd_text(length, width) result(text)
    real(rp), intent(in) :: length
    integer, intent(in) :: width
    character(width) :: text
    character(16) :: buffer
    buffer = 'infinite'
    if (length > 1.0e-30_rp) write (buffer, '(es10.2)') 1/length
    text = repeat(' ', max(0, width - len_trim(buffer)))//buffer
  end function sd_text
end module train_screening
