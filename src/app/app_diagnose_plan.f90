! SPDX-License-Identifier: GPL-3.0-or-later
!> What the loads of a measurement could show, before anything is fitted: the smallest strength of every effect, and
!> which further load would lower it most.
module app_diagnose_plan
  use app_diagnose_places, only: new_load_t, normal_matrix, separation, shared_columns, try_loads
  use app_diagnose_settings, only: diagnose_settings_t
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_calibration, only: calibration_t, find_detectable
  use diagnosis_decision, only: LEVEL
  use diagnosis_design, only: build_design, design_t
  use diagnosis_wing_simulator, only: wing_simulator_t
  implicit none
  private
  public :: print_plan

contains

  !> The smallest strength of every effect that the loads would show with a probability of 90 %, from tangents at the
  !> wing as [Wing] has it. On rank 0; the others serve.
  subroutine print_plan(unit, s, simulator, failure)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(failure_t), intent(out) :: failure
    type(design_t) :: design
    type(calibration_t) :: calibration
    real(rp), allocatable :: snr(:)
    integer :: e
    call build_design(simulator, simulator%null_point(), design, failure)
    if (failure%failed) return
    call calibration%init(design, size(s%catalogue%effects), .true., s%options%n_draws, s%options%seed)
    call find_detectable(design, calibration, size(s%catalogue%effects), LEVEL, snr)
    write (unit, '(a)') &
      'effect                parameter          found with 90 % from  at                          '// &
      'seen beside baseline'
    do e = 1, size(s%catalogue%effects)
      if (s%catalogue%effects(e)%is_testable()) then
        call print_detectable(unit, s, design, e, snr(e))
      else
        write (unit, '(a)') s%catalogue%effects(e)%name//repeat(' ', max(1, 22 - len(s%catalogue%effects(e)%name)))// &
          'not testable with these data: '//s%catalogue%effects(e)%missing
      end if
    end do
    call print_loads(unit, s, simulator, design, snr)
    flush (unit)
  end subroutine print_plan

  !> For each effect the load at a new place that would lower this strength most.
  subroutine print_loads(unit, s, simulator, design, snr)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(design_t), intent(in) :: design
    real(rp), intent(in) :: snr(:)
    type(new_load_t), allocatable :: loads(:)
    real(rp), allocatable :: normal(:, :), lengths(:), shared_sd(:)
    integer, allocatable :: columns(:), effects(:), both(:), shared(:)
    real(rp) :: strength
    character(40) :: value
    integer :: e, i, k, n, best(2)
    logical :: ok
    call shared_columns(s, shared, shared_sd)
    columns = [(i, i=1, simulator%n_baseline), shared]
    n = size(columns)
    allocate (effects(0))
    do e = 1, size(s%catalogue%effects)
      if (.not. s%catalogue%effects(e)%is_testable()) cycle
      call find_best(s, design, e, snr(e), best, strength)
      if (best(1) == 0) cycle
      effects = [effects, e]
      columns = [columns, design%candidates(best(1))%columns(best(2))]
    end do
    allocate (normal(size(columns), size(columns)))
    call normal_matrix(simulator, simulator%null_point(), columns, shared_sd, normal, ok)
    if (.not. ok) return
    call try_loads(s, simulator, simulator%null_point(), columns, loads)
    if (size(loads) == 0) return
    write (unit, '(a)') '', &
      'effect                with one more load at x, y [m]      force [N]   found with 90 % from'
    allocate (lengths(size(loads)))
    do i = 1, size(effects)
      both = [(k, k=1, n), n + i]
      do k = 1, size(loads)
        lengths(k) = separation(normal(both, both) + loads(k)%normal(both, both), [1.0_rp])
      end do
      k = maxloc(lengths, 1)
      associate (effect => s%catalogue%effects(effects(i)), load => loads(k), &
                 q => s%catalogue%quantities(columns(n + i)))
        if (.not. lengths(k) > 0) cycle
        strength = snr(effects(i))/lengths(k)
        if (q%is_log) write (value, '(a,f0.4)') 'a factor of ', exp(min(50.0_rp, strength))
        if (.not. q%is_log) write (value, '(es10.3)') strength
        if (q%unit /= '1' .and. .not. q%is_log) value = trim(value)//' '//q%unit
        write (unit, '(a22,2es15.4,es16.3,3x,a)') effect%name//repeat(' ', 22), load%place, &
          load%force*sign(1.0_rp, load%direction(3)), trim(adjustl(value))
      end associate
    end do
  end subroutine print_loads

  !> The candidate and the number of its parameter that shows from the smallest share of the prior's sd; 0 if none does.
  subroutine find_best(s, design, e, snr, best, least)
    type(diagnose_settings_t), intent(in) :: s
    type(design_t), intent(in) :: design
    integer, intent(in) :: e
    real(rp), intent(in) :: snr
    integer, intent(out) :: best(2)
    real(rp), intent(out) :: least
    real(rp) :: strength, length
    integer :: c, i
    least = huge(least)
    best = 0
    do c = 1, size(design%candidates)
      associate (one => design%candidates(c))
        if (one%effect /= e .or. one%df == 0) cycle
        do i = 1, size(one%columns)
          length = norm2(one%tangents(:, i))
          if (.not. length > 0) cycle
          strength = snr/length/s%catalogue%quantities(one%columns(i))%prior_sd
          if (.not. strength < least) cycle
          least = strength
          best = [c, i]
        end do
      end associate
    end do
  end subroutine find_best

  !> The variant that shows best.
  subroutine print_detectable(unit, s, design, e, snr)
    integer, intent(in) :: unit, e
    type(diagnose_settings_t), intent(in) :: s
    type(design_t), intent(in) :: design
    real(rp), intent(in) :: snr
    real(rp) :: strength, least
    character(40) :: value
    integer :: best(2)
    call find_best(s, design, e, snr, best, least)
    associate (effect => s%catalogue%effects(e))
      if (best(1) == 0) then
        write (unit, '(a)') effect%name//repeat(' ', max(1, 22 - len(effect%name)))//'absorbed by the baseline'
        return
      end if
      associate (one => design%candidates(best(1)))
        associate (q => s%catalogue%quantities(one%columns(best(2))))
          strength = least*q%prior_sd
          if (q%is_log) write (value, '(a,f0.4)') 'a factor of ', exp(min(50.0_rp, strength))
          if (.not. q%is_log) write (value, '(es10.3)') strength
          if (q%unit /= '1' .and. .not. q%is_log) value = trim(value)//' '//q%unit
          write (unit, '(a22,a19,a22,a28,f6.3)') effect%name//repeat(' ', 22), q%name//repeat(' ', 19), &
            adjustl(value), effect%variants(one%variant)%label//repeat(' ', 28), one%retained
        end associate
      end associate
    end associate
  end subroutine print_detectable
end module app_diagnose_plan
