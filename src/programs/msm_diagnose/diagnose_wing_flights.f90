! SPDX-License-Identifier: GPL-3.0-or-later
!> Flies a case with the wing of the baseline and with the extended wing of a diagnosis that has seen no flight, and along the
!> leading directions of the posterior of the extended wing, one sd to both sides. From these flights follow lift, drag, power, L/D
!> and L/P of both wings, and what the fit leaves of them: see diagnosis_flight_means.
module diagnose_wing_flights
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnose_files, only: wing_text
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_flight_comparison, only: posterior_of
  use diagnosis_flight_means, only: compare_means, draw_directions, find_directions, means_along, means_of, N_MEANS
  use diagnosis_flight_runner, only: flight_record_t, flight_request_t, N_PHASES
  use diagnosis_further_runs, only: further_runs_t
  use inference_engine, only: diagnosis_t
  implicit none
  private
  public :: fly_wings

  real(rp), parameter :: LEAST_STEP = 0.1_rp !< of an sd; nearer to a bound a direction has no flight on this side

contains

  !> Sets s%comparison, if [Flight] compare asks for it and a cause was found. A flight that ends by itself without a result leaves
  !> its reason there. Fails if the flights were stopped or cannot be made. Rank 0 calls it, while the others are in further%serve.
  subroutine fly_wings(s, d, further, failure)
    type(diagnose_settings_t), intent(inout) :: s
    type(diagnosis_t), intent(in) :: d
    type(further_runs_t), intent(inout) :: further
    type(failure_t), intent(inout) :: failure
    type(flight_request_t), allocatable :: requests(:)
    type(flight_record_t), allocatable :: records(:)
    real(rp), allocatable :: directions(:, :), steps(:, :), z(:, :)
    integer, allocatable :: columns(:)
    integer :: i
    if (.not. s%choices%flight%compare .or. .not. d%extended%is_found) return
    columns = wing_columns(s, d)
    associate (p => s%catalogue%parameters(columns), q => d%extended%q(columns), result => s%comparison)
      call find_directions(posterior_of(d, columns), merge(1.0_rp, max(p%prior_sd, tiny(1.0_rp)), p%is_log), &
                           s%choices%flight%directions, directions, result%share)
      steps = steps_within(q, directions, p%lower, p%upper)
      call list_wings(s, d, columns, directions, steps, requests)
      call further%fly(requests, records, failure)
      if (failure%failed) return
      do i = 1, size(records)
        if (records(i)%is_flown .or. allocated(result%reason)) cycle
        result%reason = records(i)%reason
      end do
      if (allocated(result%reason)) return
      call draw_directions(q, directions, p%lower, p%upper, s%options%seed, z)
      call compare_records(s, records, steps, z)
      result%n_directions = size(directions, 2)
    end associate
  end subroutine fly_wings

  !> Returns the parameters of the extended model that change the wing in a flight, unlike those of the measurement.
  function wing_columns(s, d) result(columns)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, allocatable :: columns(:)
    character(:), allocatable :: as_fitted
    real(rp) :: q(size(d%extended%q))
    integer :: i
    allocate (columns(0))
    as_fitted = wing_text(s, d%extended%q)
    do i = 1, size(d%extended%active)
      associate (k => d%extended%active(i))
        q = d%extended%q
        q(k) = q(k) + sqrt(max(tiny(1.0_rp), d%extended%covariance(i, i)))
        if (wing_text(s, q) /= as_fitted) columns = [columns, k]
      end associate
    end do
  end function wing_columns

  !> Returns steps(2, directions), in sd, to both sides of q along each direction: 1, or less where a bound is nearer, or 0.
  pure function steps_within(q, directions, lower, upper) result(steps)
    real(rp), intent(in) :: q(:), directions(:, :), lower(:), upper(:)
    real(rp) :: steps(2, size(directions, 2))
    integer :: i, k
    steps = 1
    do k = 1, size(directions, 2)
      do i = 1, size(q)
        associate (along => directions(i, k))
          if (along > 0) then
            steps(:, k) = min(steps(:, k), max(0.0_rp, [upper(i) - q(i), q(i) - lower(i)])/along)
          else if (along < 0) then
            steps(:, k) = min(steps(:, k), max(0.0_rp, [q(i) - lower(i), upper(i) - q(i)])/(-along))
          end if
        end associate
      end do
    end do
    where (steps < LEAST_STEP) steps = 0
  end function steps_within

  !> Lists the flights: with the wing of the baseline, with the extended wing, and with it one step up and down each direction.
  subroutine list_wings(s, d, columns, directions, steps, requests)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: columns(:)
    real(rp), intent(in) :: directions(:, :), steps(:, :)
    type(flight_request_t), allocatable, intent(out) :: requests(:)
    real(rp) :: q(size(d%extended%q))
    integer :: k, side, n
    allocate (requests(2 + count(steps > 0)))
    requests(1)%wing = wing_text(s, d%initial_baseline%q)
    requests(2)%wing = wing_text(s, d%extended%q)
    n = 2
    do k = 1, size(steps, 2)
      do side = 1, 2
        if (.not. steps(side, k) > 0) cycle
        n = n + 1
        q = d%extended%q
        q(columns) = q(columns) + merge(1, -1, side == 1)*steps(side, k)*directions(:, k)
        requests(n)%wing = wing_text(s, q)
      end do
    end do
  end subroutine list_wings

  !> Takes the records of the flights that `list_wings` lists, and the draws z(directions, :) of the posterior.
  subroutine compare_records(s, records, steps, z)
    type(diagnose_settings_t), intent(inout) :: s
    type(flight_record_t), intent(in) :: records(:)
    real(rp), intent(in) :: steps(:, :), z(:, :)
    real(rp) :: means(N_MEANS, size(records)), beside(N_MEANS, 2, size(steps, 2))
    integer :: i, k, side, n
    do i = 1, size(records)
      means(:, i) = means_of(sum(records(i)%values, 1)/N_PHASES, s%flights%cases(1)%facts%along)
    end do
    beside = 0
    n = 2
    do k = 1, size(steps, 2)
      do side = 1, 2
        if (.not. steps(side, k) > 0) cycle
        n = n + 1
        beside(:, side, k) = means(:, n)
      end do
    end do
    if (size(z, 2) == 0) then
      s%comparison%reason = 'the posterior of the extended wing lies beyond the bounds of its parameters'
      return
    end if
    call compare_means(means(:, 1), means(:, 2), means_along(z, means(:, 2), beside(:, 1, :), beside(:, 2, :), steps), s%comparison)
    s%comparison%is_flown = .true.
    s%comparison%path = s%flights%cases(1)%facts%path
    s%comparison%is_section = s%flights%cases(1)%facts%is_section
  end subroutine compare_records
end module diagnose_wing_flights
