! SPDX-License-Identifier: GPL-3.0-or-later
!> Ranks the measurements that may come next by how well they discriminate between the possible causes: data that there are once
!> more, loads at new sites, natural modes of the wing and records of its motion.
!>
!> The rivals of the first cause are all causes that may stand in its place: each candidate of another effect, at each of its sites,
!> even where the baseline imitates it, because other data may show it. inference_discrimination says how far the cause is from a
!> rival; the value of a measurement is the distance from the nearest rival after it. Tangents are those at the baseline.
module diagnosis_next_measurement
  use base_kinds, only: rp
  use base_sort, only: key_of_real, sorting_order
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_load_sites, only: new_load_t, normal_matrix, common_columns, trial_t, whitened_tangents
  use diagnosis_motion_proposals, only: motion_proposal_t, motion_proposer_t, PROPOSE_RELEASE
  use diagnosis_wing_bins, only: noise_model_t
  use diagnosis_wing_simulator, only: wing_simulator_t
  use inference_discrimination, only: discrimination_t, APART
  use inference_engine, only: diagnosis_t
  implicit none
  private
  public :: next_measurement_t, next_option_t, rank_measurements

  integer, parameter, public :: NEXT_REPEAT = 1, NEXT_LOAD = 2, NEXT_MOTION = 3
  integer, parameter :: MOST_SITES = 10, MOST_RELEASES = 3

  !> A measurement that may come next.
  type :: next_option_t
    integer :: what = NEXT_REPEAT              !< NEXT_*
    integer :: surface = 0                     !< of the data, if they are measured once more
    real(rp) :: site(2) = 0                    !< [m] of a new load
    real(rp) :: force = 0                      !< [N] its size
    real(rp) :: direction(3) = 0               !< its direction
    type(motion_proposal_t) :: motion          !< a measurement of motion
    real(rp) :: after = 0                      !< [sd] separation from the nearest rival with this measurement too
    real(rp), allocatable :: from_members(:)   !< (members) [sd] separation from the nearest candidate of each
    logical, allocatable :: tells_apart(:)     !< (members) it separates the cause from this one, which is not separated yet
  end type next_option_t

  !> The ranking; empty without a cause and rivals.
  type :: next_measurement_t
    integer :: cause = 0                       !< the candidate
    integer, allocatable :: rivals(:)          !< candidates, the nearest first
    real(rp), allocatable :: now(:)            !< [sd] separation of the cause from each of these
    !> Effects that may stand in the place of the cause: the others of a set, and those that the data do not separate from it
    integer, allocatable :: members(:)
    real(rp), allocatable :: member_now(:)     !< [sd] separation from the nearest candidate of each of these
    type(next_option_t), allocatable :: options(:) !< the best first
    character(:), allocatable :: no_motion     !< why no measurement of motion is among them; empty if some are
  end type next_measurement_t

contains

  !> Ranks the measurements. Rank 0 calls it; the others serve.
  subroutine rank_measurements(s, simulator, d, next)
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(next_measurement_t), intent(out) :: next
    type(discrimination_t) :: discrimination
    integer, allocatable :: order(:), effects(:)
    integer :: c
    logical :: ok
    allocate (next%rivals(0), next%now(0), next%options(0), next%members(0), next%member_now(0))
    next%no_motion = ''
    if (size(d%decision%causes) == 0) return
    next%cause = d%decision%causes(1)
    associate (candidates => d%model%design%candidates)
      next%rivals = pack([(c, c=1, size(candidates))], candidates%effect /= candidates(next%cause)%effect)
      effects = candidates(next%rivals)%effect
    end associate
    call begin(s, simulator, d, next, discrimination, ok)
    if (.not. ok) next%rivals = [integer ::]
    if (size(next%rivals) == 0) return
    call find_members(d, effects, discrimination%now, next)
    call rank_repeats(simulator, discrimination, effects, next)
    call rank_sites(s, simulator, d, discrimination, effects, next)
    call rank_motion(s, d, discrimination, effects, next)
    order = sorting_order(key_of_real(-next%options%after))
    next%options = next%options(order)
    order = sorting_order(key_of_real(discrimination%now))
    next%rivals = next%rivals(order)
    next%now = discrimination%now(order)
  end subroutine rank_measurements

  !> Compares the cause with all rivals, with the data that there are.
  subroutine begin(s, simulator, d, next, discrimination, ok)
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(next_measurement_t), intent(in) :: next
    type(discrimination_t), intent(inout) :: discrimination
    logical, intent(out) :: ok
    integer, allocatable :: shared(:)
    real(rp), allocatable :: common_sd(:), white(:, :)
    call common_columns(s, shared, common_sd)
    associate (cause => d%model%design%candidates(next%cause))
      call discrimination%init(d%model%design%candidates, next%cause, next%rivals, [d%model%baseline%active, shared], &
                               -matmul(cause%solve, matmul(d%tests%z, cause%basis)))
    end associate
    call whitened_tangents(simulator, d%model%whitener%independent_fraction, d%model%baseline%q, d%model%baseline%state, &
                           discrimination%columns, white, ok)
    if (ok) call discrimination%begin(normal_matrix(simulator, discrimination%columns, common_sd, white))
    if (ok) call move_alloc(white, discrimination%white)
  end subroutine begin

  !> Finds the effects that may stand in the place of the cause. Rivals are of these effects, and at these distances `now`.
  subroutine find_members(d, effects, now, next)
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: effects(:)
    real(rp), intent(in) :: now(:)
    type(next_measurement_t), intent(inout) :: next
    integer :: e
    logical :: is_member
    do e = 1, maxval(effects)
      if (.not. any(effects == e)) cycle
      is_member = minval(now, mask=effects == e) < APART
      if (.not. d%decision%is_joint) is_member = is_member .or. any(d%decision%set == e)
      if (is_member) next%members = [next%members, e]
    end do
    next%member_now = nearest_of(next%members, effects, now)
    associate (order => sorting_order(key_of_real(next%member_now)))
      next%members = next%members(order)
      next%member_now = next%member_now(order)
    end associate
  end subroutine find_members

  !> Adds an option whose separations from all rivals, which are of these effects, are `lengths`.
  subroutine add_option(next, option, effects, lengths)
    type(next_measurement_t), intent(inout) :: next
    type(next_option_t), intent(in) :: option
    integer, intent(in) :: effects(:)
    real(rp), intent(in) :: lengths(:)
    type(next_option_t) :: one
    one = option
    one%after = minval(lengths)
    one%from_members = nearest_of(next%members, effects, lengths)
    one%tells_apart = one%from_members >= APART .and. next%member_now < APART
    next%options = [next%options, one]
  end subroutine add_option

  !> Returns, for each of the `members`, the least of the lengths(:) of rivals which are of these effects.
  pure function nearest_of(members, effects, lengths) result(least)
    integer, intent(in) :: members(:), effects(:)
    real(rp), intent(in) :: lengths(:)
    real(rp) :: least(size(members))
    integer :: m
    least = [(minval(lengths, mask=effects == members(m)), m=1, size(members))]
  end function nearest_of

  !> Adds the data that there are, once more: loads, modes, traces of records, components of flights.
  subroutine rank_repeats(simulator, discrimination, effects, next)
    type(wing_simulator_t), intent(in) :: simulator
    type(discrimination_t), intent(in) :: discrimination
    integer, intent(in) :: effects(:)
    type(next_measurement_t), intent(inout) :: next
    type(next_option_t) :: one
    integer, allocatable :: rows(:)
    integer :: l, i
    one%what = NEXT_REPEAT
    do l = 1, size(simulator%labels%fold)
      one%surface = l
      rows = pack([(i, i=1, simulator%n_observations)], simulator%labels%surface == l)
      associate (white => discrimination%white(rows, :), every => [(i, i=1, size(effects))])
        call add_option(next, one, effects, discrimination%separations(every, matmul(transpose(white), white)))
      end associate
    end do
  end subroutine rank_repeats

  !> Adds the best loads at new sites. There are hundreds of rivals with all their sites. The procedure first tries all loads
  !> against the nearest site of each effect, which gives an upper bound. It then tries the loads with the largest bounds against
  !> all rivals, until no other load can be better or 3 MOST_SITES have been tried.
  subroutine rank_sites(s, simulator, d, discrimination, effects, next)
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(in) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(discrimination_t), intent(in) :: discrimination
    integer, intent(in) :: effects(:)
    type(next_measurement_t), intent(inout) :: next
    type(trial_t) :: trial
    type(noise_model_t) :: noise
    type(new_load_t) :: load
    type(next_measurement_t) :: tried
    type(next_option_t) :: one
    integer, allocatable :: few(:), numbers(:), order(:)
    real(rp), allocatable :: bounds(:)
    integer :: l, i
    logical :: ok
    few = nearest_of_each(effects, discrimination%now)
    allocate (numbers(0), bounds(0))
    call start_tries(next, tried)
    noise = simulator%noise%with_independent(d%model%whitener%independent_fraction)
    call trial%begin(s, d%model%baseline%q)
    do l = 1, trial%n
      call trial%apply(noise, l, discrimination%columns(discrimination%needed(few)), load, ok)
      if (.not. ok) cycle
      numbers = [numbers, l]
      bounds = [bounds, minval(discrimination%separations(few, load%normal))]
    end do
    order = sorting_order(key_of_real(-bounds))
    one%what = NEXT_LOAD
    do i = 1, min(3*MOST_SITES, size(order))
      if (i > MOST_SITES) then
        if (maxval(tried%options%after) >= bounds(order(i))) exit
      end if
      call trial%apply(noise, numbers(order(i)), discrimination%columns, load, ok)
      if (.not. ok) cycle
      one%site = load%site
      one%force = load%force
      one%direction = load%direction
      call add_option(tried, one, effects, discrimination%separations([(l, l=1, size(effects))], load%normal))
    end do
    call trial%end()
    call keep_best(tried, MOST_SITES, next)
  end subroutine rank_sites

  !> Adds natural modes in both media, and the best places of a release. If there are none, next%no_motion says why.
  subroutine rank_motion(s, d, discrimination, effects, next)
    class(diagnosis_case_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(discrimination_t), intent(in) :: discrimination
    integer, intent(in) :: effects(:)
    type(next_measurement_t), intent(inout) :: next
    type(motion_proposer_t), target :: proposer
    type(next_measurement_t) :: releases
    type(next_option_t) :: one
    real(rp), allocatable :: normal(:, :, :)
    integer, allocatable :: columns(:), every(:)
    logical, allocatable :: is_known(:), ok(:)
    integer :: i
    if (s%only_flies()) return ! the mechanics of the wing do not matter
    call proposer%init(s, d%model%baseline%q)
    next%no_motion = proposer%reason
    if (size(proposer%list) == 0) return
    columns = discrimination%columns
    is_known = [(proposer%knows(columns(i)), i=1, size(columns))]
    if (.not. all(is_known(discrimination%of_cause()))) then
      next%no_motion = 'they need a wing that is flat and free of stress at rest, and the first cause bends or stretches it'
      return
    end if
    call proposer%apply(columns, normal, ok)
    call start_tries(next, releases)
    one%what = NEXT_MOTION
    every = [(i, i=1, size(effects))]
    do i = 1, size(proposer%list)
      if (.not. ok(i)) cycle
      one%motion = proposer%list(i)
      associate (lengths => discrimination%separations(every, normal(:, :, i), is_known))
        if (one%motion%kind == PROPOSE_RELEASE) call add_option(releases, one, effects, lengths)
        if (one%motion%kind /= PROPOSE_RELEASE) call add_option(next, one, effects, lengths)
      end associate
    end do
    call keep_best(releases, MOST_RELEASES, next)
  end subroutine rank_motion

  !> Makes an empty list of options for the same members of the set.
  subroutine start_tries(next, tried)
    type(next_measurement_t), intent(in) :: next
    type(next_measurement_t), intent(out) :: tried
    allocate (tried%options(0))
    tried%members = next%members
    tried%member_now = next%member_now
  end subroutine start_tries

  !> Adds the best of the options that were tried, n at most.
  subroutine keep_best(tried, n, next)
    type(next_measurement_t), intent(in) :: tried
    integer, intent(in) :: n
    type(next_measurement_t), intent(inout) :: next
    integer, allocatable :: order(:)
    order = sorting_order(key_of_real(-tried%options%after))
    next%options = [next%options, tried%options(order(:min(n, size(order))))]
  end subroutine keep_best

  !> Returns, for every effect, the rival with the least separation `now`(:).
  pure function nearest_of_each(effects, now) result(few)
    integer, intent(in) :: effects(:)
    real(rp), intent(in) :: now(:)
    integer, allocatable :: few(:)
    integer :: e
    few = [(minloc(now, 1, mask=effects == e), e=1, maxval(effects))]
    few = pack(few, few > 0)
  end function nearest_of_each
end module diagnosis_next_measurement
