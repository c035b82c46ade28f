! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes what the loads of a measurement, or of a plan without heights, could show: the smallest detectable strength of every
!> effect, and what a further load, natural modes or a record of motion would make of it. It also finds the effects that these data
!> cannot tell apart, and what would. It uses tangents at the wing that [Wing] describes and the declared errors, and needs no fit.
module diagnosis_detectability
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_load_sites, only: new_load_t, normal_matrix, common_columns, try_loads, whitened_tangents
  use diagnosis_motion_proposals, only: motion_proposal_t, motion_proposer_t, PROPOSE_RELEASE
  use diagnosis_wing_simulator, only: wing_simulator_t
  use inference_calibration, only: calibration_t, find_detectable
  use inference_calibration_store, only: calibrate, calibration_store_t
  use inference_decision, only: LEVEL
  use inference_design, only: build_design, design_t
  use inference_discrimination, only: separation, APART
  use least_squares_state, only: solver_state_t
  use measurement_modes, only: MEDIUM_AIR, MEDIUM_VACUUM
  implicit none
  private
  public :: best_load_t, detectability_t, find_detectability, most_detectable

  !> Measurements of motion: natural modes in a vacuum, those in air, and a record after a release at the best place.
  integer, parameter, public :: MOTION_VACUUM = MEDIUM_VACUUM, MOTION_AIR = MEDIUM_AIR, MOTION_RELEASE = 3, N_MOTIONS = 3

  !> The load that would lower the smallest strength of an effect most.
  type :: best_load_t
    logical :: is_found = .false.
    real(rp) :: site(2) = 0, force = 0     !< [m], [N] upwards
    real(rp) :: strength = 0                !< in the coordinate of the parameter
    integer :: parameter = 0                !< the parameter
  end type best_load_t

  !> Two effects that the data cannot tell apart.
  type :: twins_t
    integer :: effect = 0                   !< it has the smallest strength that shows, or its prior's sd if the baseline absorbs it
    integer :: rival = 0                    !< the other one; 0: the baseline
    integer, private :: column = 0, candidate = 0 !< the parameter of `effect`, and the nearest candidate of `rival`
    real(rp) :: now = 0                     !< [sd] the separation,
    real(rp) :: with_load = 0               !< with the load that increases it most
    real(rp) :: with_motion(N_MOTIONS) = 0  !< with measurements of motion
  end type twins_t

  type :: detectability_t
    type(design_t) :: design
    real(rp), allocatable :: snr(:)         !< (effects) that would show with a probability of 90 %
    type(best_load_t), allocatable :: best_loads(:) !< (effects)
    logical :: has_loads = .false.          !< loads at new sites could be tried
    real(rp), allocatable :: with_motion(:, :) !< (N_MOTIONS, effects) smallest strength with motion too; 0: not computed
    type(motion_proposal_t), allocatable :: releases(:) !< (effects) the best one for each
    character(:), allocatable :: no_motion  !< why no motion could be tried; empty if some could
    type(twins_t), allocatable :: twins(:)
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
    call find_further(s, simulator, state, found)
  end subroutine find_detectability

  !> Finds, for each effect, the load at a new site that would lower this strength most, and what motion would make of it; then
  !> the same for effects that cannot be told apart.
  subroutine find_further(s, simulator, from, found)
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    class(solver_state_t), intent(in) :: from
    type(detectability_t), intent(inout) :: found
    type(new_load_t), allocatable :: loads(:)
    real(rp), allocatable :: normal(:, :), white(:, :), common_sd(:)
    integer, allocatable :: columns(:), effects(:), shared(:)
    real(rp) :: strength
    integer :: e, i, n, best(2)
    logical :: ok
    n = size(s%catalogue%effects)
    allocate (found%best_loads(n), found%releases(n), found%twins(0), effects(0))
    allocate (found%with_motion(N_MOTIONS, n), source=0.0_rp)
    found%no_motion = ''
    call common_columns(s, shared, common_sd)
    columns = [(i, i=1, simulator%n_baseline), shared]
    do e = 1, n
      if (.not. s%catalogue%effects(e)%is_testable()) cycle
      call most_detectable(s, found%design, e, found%snr(e), best, strength)
      if (best(1) == 0) call add_absorbed(found, e)
      if (best(1) == 0) cycle
      effects = [effects, e]
      columns = [columns, found%design%candidates(best(1))%columns(best(2))]
      call find_twin(s, found, e, best)
    end do
    do i = 1, size(found%twins)
      associate (twins => found%twins(i))
        if (twins%rival > 0) columns = [columns, found%design%candidates(twins%candidate)%columns]
        if (twins%rival == 0) columns = [columns, twins%column]
      end associate
    end do
    call whitened_tangents(simulator, simulator%independent_fraction(), simulator%null_point(), from, columns, white, ok)
    if (.not. ok) then
      deallocate (found%twins)
      allocate (found%twins(0))
      found%no_motion = 'the derivatives at the unloaded wing cannot be computed'
      return
    end if
    normal = normal_matrix(simulator, columns, common_sd, white)
    call try_loads(s, simulator%noise, simulator%null_point(), columns, loads)
    n = simulator%n_baseline + size(shared)
    do i = 1, size(found%twins)
      found%twins(i)%now = twin_separation(s, found, found%twins(i), normal, normal, columns, n)
    end do
    found%twins = pack(found%twins, found%twins%now < APART)
    found%twins%with_load = found%twins%now
    do i = 1, size(found%twins)
      found%twins(i)%with_motion = found%twins(i)%now
    end do
    found%has_loads = size(loads) > 0
    if (found%has_loads) call use_loads(s, loads, normal, columns, effects, n, found)
    call use_motion(s, simulator%null_point(), normal, columns, effects, n, found)
  end subroutine find_further

  !> Adds the effect that is nearest to parameter best(2) of candidate best(1) of effect e, if the data do not separate both at the
  !> smallest strength that shows.
  subroutine find_twin(s, found, e, best)
    class(diagnosis_case_t), intent(in) :: s
    type(detectability_t), intent(inout) :: found
    integer, intent(in) :: e, best(2)
    type(twins_t) :: one
    real(rp) :: length, least
    integer :: c
    least = APART
    associate (candidates => found%design%candidates)
      associate (tangent => candidates(best(1))%tangents(:, best(2)))
        do c = 1, size(candidates)
          if (candidates(c)%effect == e .or. candidates(c)%df == 0) cycle
          if (.not. s%catalogue%effects(candidates(c)%effect)%is_testable()) cycle
          length = sum(tangent**2) - sum(matmul(tangent, candidates(c)%basis)**2)
          length = found%snr(e)*sqrt(max(0.0_rp, length)/sum(tangent**2))
          if (.not. length < least) cycle
          least = length
          one = twins_t(e, candidates(c)%effect, candidates(best(1))%columns(best(2)), c)
        end do
      end associate
    end associate
    if (one%effect > 0) found%twins = [found%twins, one]
  end subroutine find_twin

  !> Adds an effect that the baseline absorbs.
  subroutine add_absorbed(found, e)
    type(detectability_t), intent(inout) :: found
    integer, intent(in) :: e
    integer :: c
    do c = 1, size(found%design%candidates)
      if (found%design%candidates(c)%effect /= e) cycle
      found%twins = [found%twins, twins_t(effect=e, column=found%design%candidates(c)%columns(1))]
      return
    end do
  end subroutine add_absorbed

  !> Finds what the loads would do. The first n of the columns are common to all hypotheses; the next ones belong to the `effects`.
  subroutine use_loads(s, loads, normal, columns, effects, n, found)
    class(diagnosis_case_t), intent(in) :: s
    type(new_load_t), intent(in) :: loads(:)
    real(rp), intent(in) :: normal(:, :)
    integer, intent(in) :: columns(:), effects(:), n
    type(detectability_t), intent(inout) :: found
    real(rp) :: lengths(size(loads)), strength
    integer, allocatable :: both(:)
    integer :: i, k
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
    do i = 1, size(found%twins)
      do k = 1, size(loads)
        found%twins(i)%with_load = max(found%twins(i)%with_load, &
                                       twin_separation(s, found, found%twins(i), normal + loads(k)%normal, normal, columns, n))
      end do
    end do
  end subroutine use_loads

  !> Returns the separation [sd] of twins by the normal matrix `normal` of `columns`, at the smallest strength that shows by the
  !> normal matrix `present` of the data that there are, or at one prior sd if it does not show.
  real(rp) function twin_separation(s, found, twins, normal, present, columns, n) result(length)
    class(diagnosis_case_t), intent(in) :: s
    type(detectability_t), intent(in) :: found
    type(twins_t), intent(in) :: twins
    real(rp), intent(in) :: normal(:, :), present(:, :)
    integer, intent(in) :: columns(:), n
    integer, allocatable :: block(:), alone(:)
    real(rp) :: strength
    integer :: i
    block = [(i, i=1, n)]
    alone = [block, findloc(columns, twins%column, 1)]
    strength = s%catalogue%parameters(twins%column)%prior_sd
    if (twins%rival > 0) then
      strength = found%snr(twins%effect)/max(separation(present(alone, alone), [1.0_rp]), tiny(1.0_rp))
      associate (rival => found%design%candidates(twins%candidate)%columns)
        do i = 1, size(rival)
          if (rival(i) /= twins%column) block = [block, findloc(columns, rival(i), 1)]
        end do
      end associate
    end if
    block = [block, alone(n + 1)]
    length = separation(normal(block, block), [strength])
  end function twin_separation

  !> Finds what measurements of motion would do, like `use_loads`.
  subroutine use_motion(s, q, normal, columns, effects, n, found)
    class(diagnosis_case_t), intent(in) :: s
    real(rp), intent(in) :: q(:), normal(:, :)
    integer, intent(in) :: columns(:), effects(:), n
    type(detectability_t), intent(inout) :: found
    type(motion_proposer_t), target :: proposer
    real(rp), allocatable :: more(:, :, :)
    logical, allocatable :: is_done(:)
    logical :: is_best
    integer :: p, k, i, m
    call proposer%init(s, q)
    found%no_motion = proposer%reason
    if (size(proposer%list) == 0) return
    call proposer%apply(columns, more, is_done)
    do p = 1, size(proposer%list)
      if (.not. is_done(p)) cycle
      m = merge(MOTION_RELEASE, proposer%list(p)%medium, proposer%list(p)%kind == PROPOSE_RELEASE)
      do i = 1, size(effects)
        if (.not. proposer%knows(columns(n + i))) cycle
        associate (both => [(k, k=1, n), n + i], least => found%with_motion(m, effects(i)))
          call take(found%snr(effects(i)), separation(normal(both, both) + more(both, both, p), [1.0_rp]), least, is_best)
        end associate
        if (is_best .and. m == MOTION_RELEASE) found%releases(effects(i)) = proposer%list(p)
      end do
      do i = 1, size(found%twins)
        associate (twins => found%twins(i))
          if (.not. proposer%knows(twins%column)) cycle
          if (twins%rival > 0) then
            if (.not. all([(proposer%knows(found%design%candidates(twins%candidate)%columns(k)), &
                            k=1, size(found%design%candidates(twins%candidate)%columns))])) cycle
          end if
          twins%with_motion(m) = max(twins%with_motion(m), &
                                     twin_separation(s, found, twins, normal + more(:, :, p), normal, columns, n))
        end associate
      end do
    end do
  end subroutine use_motion

  !> Takes the strength that has the signal-to-noise ratio `snr` if there is none yet or if it is less. A strength of 1 has the
  !> ratio `length`.
  subroutine take(snr, length, least, is_taken)
    real(rp), intent(in) :: snr, length
    real(rp), intent(inout) :: least
    logical, intent(out) :: is_taken
    is_taken = .false.
    if (length > 0) is_taken = .not. least > 0 .or. snr < least*length
    if (is_taken) least = snr/length
  end subroutine take

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
