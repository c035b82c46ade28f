! SPDX-License-Identifier: GPL-3.0-or-later
!> Fits the bending stiffness of a cantilever and the unknown zero of every loading to readings of its tip
!> (docs/results/prepazy.md). Prints them with 90 % intervals, and every reading next to the value that the beam predicts.
!>
!> usage: bench_prepazy WING.h5 MEASUREMENT.h5, as tools/import_prepazy makes them
program prepazy
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_constants, only: PI
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use least_squares_posterior, only: find_posterior, posterior_t
  use least_squares_problem, only: unknowns_t
  use least_squares_profile, only: interval_t, linear_guess_t, profile_interval, THRESHOLD_90
  use measurement_data, only: measurement_t
  use measurement_experiment, only: experiment_t
  use measurement_file, only: read_measurement
  use measurement_problem, only: wing_point_t, wing_problem_t, wing_unknowns
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use base_outcome, only: exit_code_of, OUTCOME_MISTAKE, OUTCOME_NOT_CONVERGED
  use base_process, only: exit_with
  implicit none
  !> [N/m] Stretching stiffness of a segment. The beam has about 100 of them and grows longer by 0.1 mm under 35 N along it, which
  !> no reading can show.
  real(rp), parameter :: EXTENSION = 3.0e7_rp
  !> [Pa] Young's modulus with which the fit begins: a beam so stiff that no load bends it far.
  real(rp), parameter :: STIFF = 1.0e11_rp
  type(wing_t) :: wing
  type(measurement_t) :: m
  type(experiment_t), target :: experiment
  type(wing_problem_t) :: problem
  type(wing_point_t) :: at_end
  type(solid_params_t) :: params
  type(static_options_t) :: options
  type(fit_options_t) :: fit_options
  type(fit_report_t) :: report
  type(posterior_t) :: posterior
  type(unknowns_t) :: unknowns
  type(interval_t) :: interval
  type(parameter_t) :: unknown
  type(failure_t) :: failure
  type(message_list_t) :: messages
  character(1000) :: path
  real(rp) :: scale, best, ends(2)
  integer :: i, l

  call get_command_argument(1, path)
  call read_wing(trim(path), wing, messages)
  call stop_if_wrong()
  call get_command_argument(2, path)
  call read_measurement(trim(path), wing, m, messages)
  call stop_if_wrong()
  params = default_params(wing)
  params%k_vein = EXTENSION
  params%young = STIFF
  call experiment%init(m, wing, params, [params%find('E')], options, failure)
  if (.not. failure%failed) call problem%init(experiment)
  unknowns = wing_unknowns(experiment, experiment%start(), 1.0_rp)
  if (.not. failure%failed) call fit(problem, unknowns, experiment%start(), problem%initial_state(), fit_options, report)
  if (.not. report%is_converged) then
    write (error_unit, '(a)') 'bench_prepazy: the fit did not converge'
    call exit_with(exit_code_of(OUTCOME_NOT_CONVERGED))
  end if
  posterior = find_posterior(unknowns, report)
  do i = 1, experiment%count()
    call profile_interval(problem, unknowns, report, i, linear_guess_t(posterior%sd(i)), THRESHOLD_90, fit_options, interval)
    unknown = experiment%describe(i)
    best = report%p(i)
    ends = [interval%lower, interval%upper]
    if (unknown%is_log) then ! E, shown as the bending stiffness of the section that the wing file has
      scale = PI/64*wing%veins(1)%diameters(1)**4
      best = scale*exp(best)
      ends = scale*exp(ends)
      unknown%name = 'EI'
      unknown%unit = 'N m^2'
    end if
    write (output_unit, '(a,3es17.9,3a)') '% '//trim(unknown%name)//' ', best, ends, ' ', trim(unknown%unit), &
      trim(merge(' : value and ends of the 90 % interval', ' : not determined                     ', &
                 interval%has_lower .and. interval%has_upper .and. interval%is_complete))
  end do
  write (output_unit, '(a,es17.9,a,i0,a,i0,a)') '% chi2 ', report%chi2, ' of ', size(report%residuals), &
    ' readings with ', experiment%count(), ' unknowns'
  write (output_unit, '(a)') '% loading force [N] reading [m] computed [m] sd [m]'
  call problem%solve(report%p, report%state, at_end)
  do l = 1, size(m%observations)
    associate (o => m%observations(l))
      write (output_unit, '(a,4es17.9)') trim(m%zeros(o%zero)), m%loads(o%load)%force, o%value, &
        o%value + at_end%evaluations(o%load)%residuals(1), o%sigma
    end associate
  end do
  call problem%free()

contains

  subroutine stop_if_wrong()
    if (messages%count() == 0) return
    call messages%print(error_unit, 'bench_prepazy: ')
    call exit_with(exit_code_of(OUTCOME_MISTAKE))
  end subroutine stop_if_wrong
end program prepazy
