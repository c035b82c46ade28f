! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes what the loads of a measurement, or of a plan without heights, could show: the smallest detectable strength of every
!> effect, and the further load that would lower it most. It uses tangents at the wing that [Wing] describes and the declared
!> errors, and needs no fit.
module diagnosis_detectability
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_load_sites, only: new_load_t, normal_matrix, separation, common_columns, try_loads, whitened_tangents
  use diagnosis_wing_simulator, only: wing_simulator_t
  use inference_calibration, only: calibration_t, find_detectable
  use inference_calibration_store, only: calibrate, calibration_store_t
  use inference_decision, only: LEVEL
  use inference_design, only: build_design, design_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: detectability_t, best_load_t, find_detectability, most_detectable

  !> The load that would lower the smallest strength of an effect most.
  type :: best_load_t
    logical :: is_found = .false.
    real(rp) :: site(2) = 0, force = 0     !< [m], [N] upwards
    real(rp) :: strength = 0                !< in the coordinate of the parameter
    integer :: parameter = 0                !< the parameter
  end type best_load_t

  type :: detectability_t
    type(design_t) :: design
    real(rp), allocatable :: snr(:)         !< (effects) that would show with a probability of 90 %
    type(best_load_t), allocatable :: best_loads(:) !< (effects)
    logical :: has_loads = .false.          !< loads at new sites could be tried
  end type detectability_t

contains

  !> Finds the strength from which each effect shows in these data. `store` keeps the draws. Rank 0 calls it; the others serve.
  subroutine find_detectability(s, simulator, found, failure, store)
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(detectability_t), intent(out) :: found
    type(failure_t), intent(out) :: failure
    class(calibration_store_t), intent(inout), optional :: store
    type(calibration_t) :: calibration
    class(solver_state_t), allocatable :: state
    call simulator%initial_state(state)
    call build_design(simulator, simulator%null_point(), state, simulator%independent_fraction(), found%design, failure)
    if (failure%failed) return
    call calibrate(found%design, size(s%catalogue%effects), .true., s%options%n_draws, s%options%seed, calibration, store)
    call find_detectable(found%design, calibration, size(s%catalogue%effects), LEVEL, found%snr)
    call find_best_loads(s, simulator, state, found)
  end subroutine find_detectability

  !> Finds, for each effect, the load at a new site that would lower this strength most.
  subroutine find_best_loads(s, simulator, from, found)
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    class(solver_state_t), intent(in) :: from
    type(detectability_t), intent(inout) :: found
    type(new_load_t), allocatable :: loads(:)
    real(rp), allocatable :: normal(:, :), white(:, :), lengths(:), common_sd(:)
    integer, allocatable :: columns(:), effects(:), both(:), shared(:)
    real(rp) :: strength
    integer :: e, i, k, n, best(2)
    logical :: ok
    allocate (found%best_loads(size(s%catalogue%effects)))
    call common_columns(s, shared, common_sd)
    columns = [(i, i=1, simulator%n_baseline), shared]
    n = size(columns)
    allocate (effects(0))
    do e = 1, size(s%catalogue%effects)
      if (.not. s%catalogue%effects(e)%is_testable()) cycle
      call most_detectable(s, found%design, e, found%snr(e), best, strength)
      if (best(1) == 0) cycle
      effects = [effects, e]
      columns = [columns, found%design%candidates(best(1))%columns(best(2))]
    end do
    call whitened_tangents(simulator, simulator%independent_fraction(), simulator%null_point(), from, columns, white, ok)
    if (.not. ok) return
    normal = normal_matrix(simulator, columns, common_sd, white)
    call try_loads(s, simulator%noise, simulator%null_point(), columns, loads)
    found%has_loads = size(loads) > 0
    if (.not. found%has_loads) return
    allocate (lengths(size(loads)))
    do i = 1, size(effects)
      both = [(k, k=1, n), n + i]
      do k = 1, size(loads)
        lengths(k) = separation(normal(both, both) + loads(k)%normal(both, both), [1.0_rp])
      end do
      k = maxloc(lengths, 1)
      associate (load => loads(k))
        if (.not. lengths(k) > 0) cycle
        strength = found%snr(effects(i))/lengths(k)
        found%best_loads(effects(i)) = best_load_t(.true., load%site, load%force*sign(1.0_rp, load%direction(3)), strength, &
                                              columns(n + i))
      end associate
    end do
  end subroutine find_best_loads

  !> Finds the candidate of effect e, and the number of its parameter, that shows from the smallest fraction of the prior's sd,
  !> `least`; 0 if none does.
  subroutine most_detectable(s, design, e, snr, best, least)
    class(diagnosis_case_t), intent(in) :: s
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
          strength = snr/length/s%catalogue%parameters(one%columns(i))%prior_sd
          if (.not. strength < least) cycle
          least = strength
          best = [c, i]
        end do
      end associate
    end do
  end subroutine most_detectable
end module diagnosis_detectability
