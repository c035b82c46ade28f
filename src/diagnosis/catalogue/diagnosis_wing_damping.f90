! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the entries of the catalogue that describe energy loss, which only records of a vibrating wing and damping ratios of modes
!> can show. The baseline has mass-proportional damping, as every wing comes to rest. Without such data the catalogue has none of
!> these entries.
module diagnosis_wing_damping
  use base_cause, only: cause_t
  use base_constants, only: TWO_PI
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use diagnosis_wing_entries, only: append_variant, catalogue_t
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_DAMPING, KIND_RELAXATION, KIND_RELAXATION_TIME
  use inference_simulator, only: variant_t
  use measurement_experiment, only: experiment_t
  use measurement_modes, only: MEDIUM_AIR
  use solid_effect, only: NEED_AIR, NEED_MEMBRANE
  use solid_damping_effects, only: list_damping_causes, mass_damping_parameter, DAMPING_MASS, DAMPING_RELAXATION, RELAXATION_STEP
  implicit none
  private
  public :: add_damping, enter_damping

  real(rp), parameter :: DECADE = 2.302585092994046_rp

contains

  !> Adds a parameter to the baseline. If there are such data, the baseline fits damping in proportion to the mass. The fit begins
  !> with a damping that ends the motion within the longest of the records; the sd of its logarithm is a decade.
  subroutine add_damping(c, e)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(parameter_t) :: p
    real(rp) :: time, turns
    integer :: n
    if (.not. e%measurement%shows_damping()) return
    call find_times(e, time, turns)
    p = mass_damping_parameter(time, turns)
    p%is_log = .true.
    p%null = log(2/time)
    p%prior_sd = DECADE
    p%lower = p%null - 4*DECADE
    p%upper = log(max(20.0_rp, turns)/time) ! above the start even for a short record
    n = c%add(wing_parameter(p, KIND_DAMPING, DAMPING_MASS))
  end subroutine add_damping

  !> Finds the length [s] of the longest record, and how many radians the wing turns in it at a tenth of the sampling rate: a
  !> record that resolves a motion has about ten samples in each of its periods. Without records these are the longest time in which
  !> a mode decays, and the radians of the fastest mode in it.
  subroutine find_times(e, time, turns)
    type(experiment_t), intent(in) :: e
    real(rp), intent(out) :: time, turns
    real(rp), parameter :: LEAST = 1.0e-3_rp ! damping ratio
    real(rp) :: fastest
    integer :: i
    time = 0
    do i = 1, e%measurement%count_series()
      associate (s => e%measurement%series(i))
        if (s%length() <= time) cycle
        time = s%length()
        turns = TWO_PI*0.1_rp*s%rate*time
      end associate
    end do
    if (time > 0) return
    fastest = 0
    do i = 1, e%measurement%count_modes()
      associate (mode => e%measurement%modes(i))
        if (mode%damping < 0) cycle
        time = max(time, 1/(TWO_PI*mode%frequency*max(mode%damping, LEAST)))
        fastest = max(fastest, mode%frequency)
      end associate
    end do
    turns = TWO_PI*fastest*time
  end subroutine find_times

  !> Enters the causes that are losses of energy.
  subroutine enter_damping(c, e)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(cause_t), allocatable :: list(:)
    type(variant_t), allocatable :: variants(:)
    real(rp) :: time, turns
    integer :: i, n
    if (.not. e%measurement%shows_damping()) return
    call find_times(e, time, turns)
    list = list_damping_causes(time, turns, e%measurement%series_air_density)
    do i = 1, size(list)
      associate (needs => list(i)%needs)
        call require(all(needs == NEED_AIR .or. needs == NEED_MEMBRANE), &
                     'diagnosis_wing_damping: an unknown need of '//list(i)%name)
        if (any(needs == NEED_AIR) .and. .not. has_record_in_air(e)) cycle
        if (any(needs == NEED_MEMBRANE) .and. size(e%model%triangles) == 0) cycle
      end associate
      allocate (variants(0))
      associate (one => list(i)%parameters(1))
        if (one%number == DAMPING_RELAXATION) then
          call scan_times(c, list(i), time, turns, variants)
        else
          n = c%add(wing_parameter(one%value%as_coordinate(one%value%null), KIND_DAMPING, one%number))
          call append_variant(variants, '', n, [0.0_rp, 0.0_rp])
        end if
      end associate
      call c%enter(list(i), '', variants)
      deallocate (variants)
    end do
  end subroutine enter_damping

  !> Tells whether there is a record of motion in air.
  pure logical function has_record_in_air(e) result(has)
    type(experiment_t), intent(in) :: e
    integer :: i
    has = any([(e%measurement%series(i)%medium == MEDIUM_AIR, i=1, e%measurement%count_series())])
  end function has_record_in_air

  !> Enters the fraction of the stiffness that relaxes and a factor on its relaxation time, for each of several times.
  subroutine scan_times(c, cause, time, turns, variants)
    type(catalogue_t), intent(inout) :: c
    type(cause_t), intent(in) :: cause
    real(rp), intent(in) :: time, turns
    type(variant_t), allocatable, intent(inout) :: variants(:)
    type(wing_parameter_t) :: relaxation
    real(rp) :: tau
    integer :: n, of_time
    associate (share => cause%parameters(1)%value, factor_of_time => cause%parameters(2)%value)
      tau = 0.5_rp*time/turns
      do while (tau < 0.5_rp*time)
        relaxation = wing_parameter(share%as_coordinate(share%null), KIND_RELAXATION, size(c%parameters) + 2)
        relaxation%time = tau
        n = c%add(relaxation)
        call append_variant(variants, 'with a relaxation time of about '//milliseconds(tau)//' ms', n, [0.0_rp, 0.0_rp])
        of_time = c%add(wing_parameter(factor_of_time%as_coordinate(factor_of_time%null), KIND_RELAXATION_TIME, n))
        variants(size(variants))%columns = [n, of_time]
        tau = RELAXATION_STEP*tau
      end do
    end associate
  end subroutine scan_times

  !> Returns a time [s] in milliseconds.
  function milliseconds(time) result(text)
    real(rp), intent(in) :: time
    character(:), allocatable :: text
    character(16) :: buffer
    write (buffer, '(f12.3)') 1000*time
    text = trim(adjustl(buffer))
  end function milliseconds
end module diagnosis_wing_damping
