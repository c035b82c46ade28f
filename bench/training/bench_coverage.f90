! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures how often 90 % intervals contain the truth: wings are drawn at random, measured with white noise and fitted from a
!> start near the truth; the intervals are those of the profile likelihood.
!>
!> The true values are log-uniform within a factor of ten of the defaults, which are the centre of the fit's priors. Every wing
!> has its own stream of random numbers, the same with every compiler; the optimiser draws nothing from it.
module bench_coverage
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_kinds, only: i8, rp
  use base_parameter, only: parameter_t
  use base_random, only: random_stream_t
  use bench_replicate, only: N_UNKNOWNS, replicate_t
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use least_squares_posterior, only: find_posterior, posterior_t
  use least_squares_problem, only: unknowns_t
  use least_squares_profile, only: interval_t, linear_guess_t, profile_interval, THRESHOLD_90
  use measurement_experiment, only: experiment_t
  use measurement_problem, only: ONE_DECADE, wing_problem_t, wing_unknowns
  implicit none
  private
  public :: cover

  integer(i8), parameter :: SEED = 20261122_i8
  real(rp), parameter :: NOISE = 1.0e-5_rp !< [m] of every deformation
  real(rp), parameter :: RESOLVED = 1.0e-3_rp !< of the sum of squares, whose threshold is 2.7
  real(rp), parameter :: NEAR = 0.2_rp     !< sd of the start about the truth, of a logarithm

  !> Counts of intervals by the number of ends they have, and of those that contain the truth.
  type :: tally_t
    integer :: n(0:2) = 0, n_hit(0:2) = 0
    integer :: n_incomplete = 0 !< the search of an end was given up; not counted otherwise
    integer :: n_failed = 0     !< wings whose fit did not converge
    integer :: n_redrawn = 0    !< truths with a shape that is not found, excluded or reached by a snap
  end type tally_t

contains

  !> Runs wing number `first` and the following ones; the last line is a JSON record.
  subroutine cover(replicate, n_wings, first)
    type(replicate_t), intent(in) :: replicate
    integer, intent(in) :: n_wings, first
    type(tally_t) :: tally
    real(rp) :: cpu, cpu_end, fraction, every
    integer :: w
    call cpu_time(cpu)
    do w = first, first + n_wings - 1
      call cover_wing(replicate, w, tally)
      call cpu_time(cpu_end)
      write (output_unit, '(a,i0,3(a,i0),a,i0,a,f0.1,a)') 'wing ', w, ': so far ', tally%n_hit(2), ' of ', tally%n(2), &
        ' intervals hold the truth; with one end ', tally%n(1), ', without ', tally%n(0), '; ', cpu_end - cpu, ' s'
      flush (output_unit)
    end do
    fraction = real(tally%n_hit(2), rp)/max(1, tally%n(2))
    every = real(sum(tally%n_hit), rp)/max(1, sum(tally%n))
    write (output_unit, '(7(a,i0),2(a,f6.4),5(a,i0),a,f0.1,a)') '{"wings":', n_wings, ',"first":', first, &
      ',"intervals":', tally%n(2), ',"covered":', tally%n_hit(2), ',"one_end":', tally%n(1), ',"one_end_covered":', &
      tally%n_hit(1), ',"no_end":', tally%n(0), ',"coverage":', fraction, ',"binomial_sd":', &
      sqrt(0.09_rp/max(1, tally%n(2))), ',"all":', sum(tally%n), ',"all_covered_percent":', nint(100*every), &
      ',"incomplete":', tally%n_incomplete, ',"failed_fits":', tally%n_failed, ',"redrawn":', tally%n_redrawn, &
      ',"cpu_s":', cpu_end - cpu, '}'
  end subroutine cover

  subroutine cover_wing(replicate, w, tally)
    type(replicate_t), intent(in) :: replicate
    integer, intent(in) :: w
    type(tally_t), intent(inout) :: tally
    type(experiment_t), target :: experiment
    type(random_stream_t) :: stream
    real(rp) :: truth(N_UNKNOWNS), start(N_UNKNOWNS)
    real(rp), allocatable :: errors(:)
    integer :: i, l
    logical :: is_done
    stream = random_stream_t(seed=SEED, stream=int(w, i8))
    do
      do i = 1, N_UNKNOWNS
        truth(i) = 2*stream%uniform() - 1
      end do
      truth = replicate%defaults() + ONE_DECADE*truth
      call replicate%measure(truth, NOISE, experiment, is_done)
      if (is_done) exit
      tally%n_redrawn = tally%n_redrawn + 1
    end do
    do l = 1, size(experiment%comparisons)
      associate (measured => experiment%comparisons(l)%measured)
        allocate (errors(size(measured)))
        call stream%gaussians(errors)
        measured = measured + NOISE*errors
        deallocate (errors)
      end associate
    end do
    call stream%gaussians(start)
    call fit_wing(experiment, replicate%defaults(), truth, truth + NEAR*start, tally)
  end subroutine cover_wing

  subroutine fit_wing(experiment, centre, truth, start, tally)
    type(experiment_t), intent(in), target :: experiment
    real(rp), intent(in) :: centre(:), truth(:), start(:)
    type(tally_t), intent(inout) :: tally
    type(wing_problem_t) :: problem
    type(unknowns_t) :: unknowns
    type(fit_options_t) :: options
    type(fit_report_t) :: report
    type(posterior_t) :: posterior
    type(interval_t) :: interval
    type(parameter_t) :: parameter
    logical :: is_hit
    integer :: i, n_ends
    call problem%init(experiment)
    unknowns = wing_unknowns(experiment, centre, 1.0_rp)
    options%reduction_tolerance = RESOLVED/problem%n_residuals
    call fit(problem, unknowns, start, problem%initial_state(), options, report)
    if (.not. report%is_converged) then
      tally%n_failed = tally%n_failed + 1
      call problem%free()
      return
    end if
    posterior = find_posterior(unknowns, report)
    do i = 1, N_UNKNOWNS
      call profile_interval(problem, unknowns, report, i, linear_guess_t(posterior%sd(i)), THRESHOLD_90, options, interval)
      if (.not. interval%is_complete) then
        tally%n_incomplete = tally%n_incomplete + 1
        cycle
      end if
      n_ends = count([interval%has_lower, interval%has_upper])
      is_hit = truth(i) >= interval%lower .and. truth(i) <= interval%upper
      tally%n(n_ends) = tally%n(n_ends) + 1
      if (is_hit) then
        tally%n_hit(n_ends) = tally%n_hit(n_ends) + 1
      else
        parameter = experiment%describe(i)
        write (output_unit, '(2x,a24,a,es11.4,a,es11.4,a,es11.4)') parameter%name, ' truth', exp(truth(i)), &
          ' outside', exp(interval%lower), ' to', exp(interval%upper)
      end if
    end do
    call problem%free()
  end subroutine fit_wing
end module bench_coverage
