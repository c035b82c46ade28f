! SPDX-License-Identifier: GPL-3.0-or-later
!> Compares the flight of the case with the flight that records of forces have led to: the fitted changes of kinematics and flow,
!> and what their posterior leaves of lift, drag and power. It needs no flights beyond those of the diagnosis, whose approximation
!> of forces it uses. Errors of the balance are no part of a flight.
module diagnosis_flight_comparison
  use base_kinds, only: rp
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_flight_changes, only: N_CHANGES
  use diagnosis_flight_data, only: change_t, flight_data_t
  use diagnosis_flight_means, only: compare_means, draw_directions, find_directions, means_of, N_MEANS
  use diagnosis_flight_response, only: flight_response_t
  use diagnosis_wing_state, only: wing_state, wing_state_t
  use inference_engine, only: diagnosis_t
  use inference_refit, only: nested_fit_t
  implicit none
  private
  public :: approximation_of, compare_flights, posterior_of

contains

  !> Sets s%comparison, if records of forces were diagnosed and a cause of the verdict changes the flight of a case: the first such
  !> case is compared. Parameters of the baseline count as changes, but they alone are no reason to compare.
  subroutine compare_flights(s, d)
    class(diagnosis_case_t), intent(inout) :: s
    type(diagnosis_t), intent(in) :: d
    type(flight_response_t) :: response
    type(change_t), allocatable :: change(:)
    integer, allocatable :: columns(:)
    real(rp), allocatable :: directions(:, :), z(:, :), draws(:, :)
    real(rp) :: c(N_CHANGES), nothing(N_CHANGES)
    integer :: i, k
    if (.not. s%flights%is_ready .or. .not. d%extended%is_found) return
    do k = 1, size(s%flights%cases)
      change = s%flights%cases(k)%change_by(s%catalogue%parameters(d%extended%active))
      if (any(change(size(d%model%baseline%active) + 1:)%number > 0)) exit
    end do
    if (k > size(s%flights%cases)) return
    columns = pack(d%extended%active, change%number > 0)
    response = approximation_of(d%extended, s%flights%cases(k))
    associate (p => s%catalogue%parameters(columns), q => d%extended%q(columns), result => s%comparison, case => s%flights%cases(k))
      call find_directions(posterior_of(d, columns), spread(1.0_rp, 1, size(columns)), size(columns), directions, result%share)
      call draw_directions(q, directions, p%lower, p%upper, s%options%seed, z)
      if (size(z, 2) == 0) return
      allocate (draws(N_MEANS, size(z, 2)))
      do i = 1, size(z, 2)
        draws(:, i) = means_at(response, case%changes_at(p, q + matmul(directions, z(:, i))), case)
      end do
      nothing = 0
      c = case%changes_at(p, q)
      call compare_means(means_at(case%response, nothing, case), means_at(response, c, case), draws, result)
      result%n_directions = size(directions, 2)
      result%path = case%facts%path
      result%is_section = case%facts%is_section
    end associate
  end subroutine compare_flights

  !> Returns the covariance of the parameters `columns` of the extended model, which must be active there, with the variance of the
  !> noise that its intervals have.
  function posterior_of(d, columns) result(covariance)
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: columns(:)
    real(rp) :: covariance(size(columns), size(columns))
    integer :: at(size(columns)), i
    at = [(findloc(d%extended%active, columns(i), 1), i=1, size(columns))]
    covariance = max(d%tests%scale, d%extended_scale)*d%extended%covariance(at, at)
  end function posterior_of

  !> Returns the approximation of forces with which a fit was made.
  function approximation_of(fit, data) result(response)
    type(nested_fit_t), intent(in) :: fit
    type(flight_data_t), intent(in) :: data
    type(flight_response_t) :: response
    type(wing_state_t) :: state
    response = data%response
    state = wing_state(fit%state)
    if (state%flight > 1) response = data%again(state%flight - 1)
  end function approximation_of

  !> Returns mean lift, drag and power of a flight with the changes c.
  pure function means_at(response, c, data) result(means)
    type(flight_response_t), intent(in) :: response
    real(rp), intent(in) :: c(N_CHANGES)
    type(flight_data_t), intent(in) :: data
    real(rp) :: means(N_MEANS)
    complex(rp), allocatable :: series(:, :)
    series = response%at(c)
    means = means_of(real(series(1, :), rp), data%facts%along)
  end function means_at
end module diagnosis_flight_comparison
