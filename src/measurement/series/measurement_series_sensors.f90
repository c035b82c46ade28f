! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes what an imperfect sensor makes of the motion x(t) that a record shows.
!>
!> The first terms of any linear distortion that is slow beside the motion are y = (1 + g) x - tau x' + kappa x''. A wrong gain has
!> g alone, samples that are late have kappa = tau^2/2, and a lag of first order, tau y' = x - y, has kappa = tau^2.
!>
!> The unit of each term is a distortion of about SHARE of the record. For tau it is the time T in which the motion changes by this
!> share, T = SHARE |x|/|x'|, and for kappa it is T^2, as for a lag of T. The rate of samples gives no such unit: it says how much
!> of the motion was stored, and nothing of the sensor.
module measurement_series_sensors
  use base_kinds, only: rp
  use measurement_series_simulation, only: series_simulation_t
  implicit none
  private
  public :: distortion_time, put_late_errors, put_sensor_errors, N_SENSOR_ERRORS

  integer, parameter :: N_SENSOR_ERRORS = 3 !< of each trace: gain, delay, smoothing
  real(rp), parameter :: SHARE = 0.1_rp

contains

  !> Returns T [s] of record i, whose traces count in units of their sd, after `evaluate`; 0 if nothing moves.
  pure real(rp) function distortion_time(simulation, i) result(time)
    type(series_simulation_t), intent(in) :: simulation
    integer, intent(in) :: i
    real(rp) :: rate
    time = 0
    associate (s => simulation%series(i), ring => simulation%rings(i))
      rate = norm2(s%in_sd(ring%rate))
      if (rate > 0) time = SHARE*norm2(s%in_sd(ring%seen))/rate
    end associate
  end function distortion_time

  !> Puts into columns(n, N_SENSOR_ERRORS * traces of all records) the changes of the residuals by a unit of g, of -tau and of kappa
  !> of each trace, after `evaluate`.
  subroutine put_sensor_errors(simulation, columns)
    type(series_simulation_t), intent(in) :: simulation
    real(rp), intent(inout) :: columns(:, :)
    real(rp), allocatable :: alone(:, :)
    real(rp) :: time
    integer :: i, j, k, column, last
    columns = 0
    column = 0
    do i = 1, size(simulation%series)
      associate (s => simulation%series(i), ring => simulation%rings(i), first => simulation%first(i))
        time = distortion_time(simulation, i)
        last = first + s%count() - 1
        do j = 1, size(s%sigma)
          do k = 1, N_SENSOR_ERRORS
            alone = 0*ring%seen
            if (k == 1) alone(:, j) = SHARE*ring%seen(:, j)
            if (k == 2) alone(:, j) = time*ring%rate(:, j)
            if (k == 3) alone(:, j) = time**2*ring%second(:, j)
            column = column + 1
            columns(first:last, column) = s%in_sd(alone)
          end do
        end do
      end associate
    end do
  end subroutine put_sensor_errors

  !> Puts into columns(n, records) what is of second order in the error d of the time of each excitation, d^2/2 x'', after
  !> `evaluate`. Its root mean square for d ~ N(0, sd^2) is sqrt(3)/2 sd^2 x''.
  subroutine put_late_errors(simulation, columns)
    type(series_simulation_t), intent(in) :: simulation
    real(rp), intent(out) :: columns(:, :)
    integer :: i
    columns = 0
    do i = 1, size(simulation%series)
      associate (s => simulation%series(i), first => simulation%first(i))
        columns(first:first + s%count() - 1, i) = 0.5_rp*sqrt(3.0_rp)*s%trigger_sigma**2*s%in_sd(simulation%rings(i)%second)
      end associate
    end do
  end subroutine put_late_errors
end module measurement_series_sensors
