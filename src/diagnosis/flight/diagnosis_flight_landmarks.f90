! SPDX-License-Identifier: GPL-3.0-or-later
!> Says what records of landmarks on a wing need beyond those of forces: how an error of the cameras' axes moves all landmarks, and
!> how unknown causes may move a wing. Places are in metres from the origin of the case.
module diagnosis_flight_landmarks
  use base_constants, only: PI, TWO_PI
  use base_kinds, only: rp
  use diagnosis_flight_axes, only: along_axes
  use measurement_balance, only: balance_values
  use measurement_flight, only: measured_flight_t, N_COMPONENTS
  implicit none
  private
  public :: count_patterns, find_cameras, misplaced, pivot_of, put_misplacements, put_waves, put_wing_patterns

  integer, parameter, public :: N_WAVES = 6             !< harmonics of an unknown cause
  real(rp), parameter, public :: UNKNOWN_SHARE = 0.1_rp !< size of an unknown cause, as a fraction of a component's root mean square
  integer, parameter, public :: N_MISPLACED = 6         !< errors of the axes of cameras: shifts along x, y, z, turns about them
  real(rp), parameter :: DEGREE = PI/180

contains

  !> Returns for each record the number of the cameras that saw it if an error of their axes is stated, else 0. Records of one
  !> flight have the same cameras.
  pure function find_cameras(flights) result(camera)
    type(measured_flight_t), intent(in) :: flights(:)
    integer :: camera(size(flights))
    integer :: r, s
    camera = 0
    do r = 1, size(flights)
      if (flights(r)%side == 0 .or. max(flights(r)%offset_sd, flights(r)%turn_sd) <= 0) cycle
      camera(r) = maxval(camera) + 1
      do s = 1, r - 1
        if (camera(s) > 0 .and. flights(s)%name == flights(r)%name) camera(r) = camera(s)
      end do
    end do
  end function find_cameras

  !> Returns the mean place [m] of the landmarks of all records `is_seen`, over the beat that has the Fourier series `series`.
  pure function pivot_of(flights, is_seen, series) result(pivot)
    type(measured_flight_t), intent(in) :: flights(:)
    logical, intent(in) :: is_seen(:)
    complex(rp), intent(in) :: series(0:, :)
    real(rp) :: pivot(3)
    integer :: r, l, n, first
    pivot = 0
    n = 0
    do r = 1, size(flights)
      if (.not. is_seen(r)) cycle
      do l = 1, flights(r)%count_landmarks()
        first = N_COMPONENTS + 3*(flights(r)%first + l - 1)
        pivot = pivot + real(series(0, first + 1:first + 3), rp)
        n = n + 1
      end do
    end do
    pivot = pivot/max(n, 1)
  end function pivot_of

  !> Returns how far [m] one sd of error `number` (1 to N_MISPLACED) of the cameras' axes moves column k of record f at the times of
  !> the beat. `series` has the places of all landmarks, and turns are about `pivot`.
  pure function misplaced(f, k, time, series, pivot, number) result(shift)
    type(measured_flight_t), intent(in) :: f
    integer, intent(in) :: k, number
    real(rp), intent(in) :: time(:), pivot(3)
    complex(rp), intent(in) :: series(0:, :)
    real(rp) :: shift(size(time))
    integer :: at(2), about, other
    at = f%landmark_of(k)
    about = number - 3
    shift = 0
    if (number <= 3) then
      if (number == at(2)) shift = f%offset_sd
    else if (about /= at(2)) then
      other = 6 - about - at(2) ! the axis that the turn takes into the axis of the column
      shift = balance_values(series(:, N_COMPONENTS + 3*(f%first + at(1) - 1) + other), time) - pivot(other)
      shift = f%turn_sd*DEGREE*shift*merge(1, -1, modulo(at(2) - other, 3) == 1)
    end if
  end function misplaced

  !> Returns in fields(landmarks, :) displacements of a wing that are linear in the place on it, of size 1: a constant, and slopes
  !> along x and y as far as the landmarks differ in them.
  pure function linear_fields(points) result(fields)
    real(rp), intent(in) :: points(:, :)
    real(rp), allocatable :: fields(:, :)
    real(rp) :: along(size(points, 2)), most
    integer :: c, m
    m = size(points, 2)
    fields = reshape([(1.0_rp, c=1, m)], [m, 1])
    do c = 1, 2
      along = points(c, :) - sum(points(c, :))/m
      most = maxval(abs(along))
      if (most <= 1.0e-6_rp*maxval(abs(points))) cycle
      fields = reshape([fields, along/most], [m, size(fields, 2) + 1])
    end do
  end function linear_fields

  !> Returns the axes of the coordinates that a record of landmarks has.
  pure function seen_axes(f) result(axes)
    type(measured_flight_t), intent(in) :: f
    integer, allocatable :: axes(:)
    logical :: is_seen(3)
    integer :: k, at(2)
    is_seen = .false.
    do k = 1, size(f%component)
      at = f%landmark_of(k)
      is_seen(at(2)) = .true.
    end do
    axes = pack([1, 2, 3], is_seen)
  end function seen_axes

  !> Returns how many patterns of unknown causes a record has.
  pure integer function count_patterns(f) result(n)
    type(measured_flight_t), intent(in) :: f
    n = (2*N_WAVES + 1)*size(f%component)
    if (f%side > 0) n = (2*N_WAVES + 1)*size(seen_axes(f))*size(linear_fields(f%points), 2)
  end function count_patterns

  !> Sets patterns(n, count_patterns(f)): waves over the beat of displacements that are linear in the place on the wing, in sd.
  !> They stand for unknown causes. The rows are the known values of f, one column after another, at the times time(n).
  pure subroutine put_wing_patterns(f, time, patterns)
    type(measured_flight_t), intent(in) :: f
    real(rp), intent(in) :: time(:)
    real(rp), intent(out) :: patterns(:, :)
    real(rp) :: fields(f%count_landmarks(), size(linear_fields(f%points), 2)), motion
    real(rp), allocatable :: share(:)
    integer :: k, j, n, row, at(2), axis, first
    fields = linear_fields(f%points)
    patterns = 0
    motion = motion_of(f)
    row = 0
    associate (axes => seen_axes(f))
      do k = 1, size(f%component)
        at = f%landmark_of(k)
        axis = findloc(axes, at(2), 1)
        n = count(f%is_known(:, k))
        share = UNKNOWN_SHARE*motion/pack(f%sd(:, k), f%is_known(:, k))
        do j = 1, size(fields, 2)
          first = (2*N_WAVES + 1)*((axis - 1)*size(fields, 2) + j - 1)
          call put_waves(fields(at(1), j)*share, time(row + 1:row + n), &
                         patterns(row + 1:row + n, first + 1:first + 2*N_WAVES + 1))
        end do
        row = row + n
      end do
    end associate
  end subroutine put_wing_patterns

  !> Sets waves(n, 2 N_WAVES + 1): size(n) times cosines and sines of the harmonics from 0 to N_WAVES of the beat at time(n).
  pure subroutine put_waves(size_of, time, waves)
    real(rp), intent(in) :: size_of(:), time(:)
    real(rp), intent(out) :: waves(:, :)
    integer :: h
    waves(:, 1) = size_of
    do h = 1, N_WAVES
      waves(:, 2*h) = size_of*cos(TWO_PI*h*time)
      waves(:, 2*h + 1) = size_of*sin(TWO_PI*h*time)
    end do
  end subroutine put_waves

  !> Returns the root mean square [m] over the beat of the distance of all coordinates from their means.
  pure real(rp) function motion_of(f) result(motion)
    type(measured_flight_t), intent(in) :: f
    integer :: k
    motion = 0
    do k = 1, size(f%component)
      associate (known => f%is_known(:, k), mean => f%mean(:, k))
        motion = motion + sum((mean - sum(mean, known)/count(known))**2, known)
      end associate
    end do
    motion = sqrt(motion/count(f%is_known))
  end function motion_of

  !> Sets nuisances(n, N_MISPLACED) to the effects, in sd, of errors of the axes of `camera`, that of the records with this
  !> number in cameras(records), on the landmarks that have the places `series`.
  pure subroutine put_misplacements(flights, cameras, camera, time, series, nuisances)
    type(measured_flight_t), intent(in) :: flights(:)
    integer, intent(in) :: cameras(:), camera
    real(rp), intent(in) :: time(:)
    complex(rp), intent(in) :: series(0:, :)
    real(rp), intent(out) :: nuisances(:, :)
    real(rp) :: pivot(3)
    integer :: r, k, i, at, n
    pivot = pivot_of(flights, cameras == camera, series)
    nuisances = 0
    at = 0
    do r = 1, size(flights)
      associate (f => flights(r))
        do k = 1, size(f%component)
          n = count(f%is_known(:, k))
          if (cameras(r) == camera) then
            do i = 1, N_MISPLACED
              nuisances(at + 1:at + n, i) = misplaced(f, k, time(at + 1:at + n), along_axes(f, series), &
                                                      matmul(f%axes, pivot), i)/pack(f%sd(:, k), f%is_known(:, k))
            end do
          end if
          at = at + n
        end do
      end associate
    end do
  end subroutine put_misplacements
end module diagnosis_flight_landmarks
