! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads where landmarks of flapping wings were over the beat: the groups `/flight/<id>/landmarks/left` and `right` of a measurement
!> file (docs/formats/measurement-format.md). Each becomes a record whose components are the coordinates of its landmarks.
module measurement_landmarks
  use base_kinds, only: rp
  use base_text, only: number_text
  use io_arrays, only: is_finite, is_group
  use io_attributes, only: has_attribute
  use io_hdf5, only: hdf5_file_t
  use measurement_attributes, only: above_zero, check_names, from_zero, read_real, read_vector, read_whole
  use measurement_axes, only: read_axes
  use measurement_flight, only: measured_flight_t, read_times, read_values, FAR, N_COMPONENTS, SIDE_NAMES
  use solid_wing_datasets, only: check_members, read_real_dataset
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: has_landmarks, read_landmarks

  character(*), parameter :: FOLDER = '/landmarks'
  real(rp), parameter :: LARGEST = 10.0_rp      !< [m] coordinate of a landmark on the wing, and sd of the place of a camera
  real(rp), parameter :: MOST_TURN = 20.0_rp    !< [degree]

contains

  !> Tells whether the record of a flight in `group` has landmarks.
  logical function has_landmarks(file, group)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    has_landmarks = file%has(group//FOLDER)
  end function has_landmarks

  !> Reads the landmarks of one flight into `records`, one for each wing that has any. `of_flight` holds what is common to all
  !> records of the flight. The landmarks are numbered from first + 1 on. Mistakes go to `report`.
  subroutine read_landmarks(file, group, of_flight, first, records, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_flight_t), intent(in) :: of_flight
    integer, intent(in) :: first
    type(measured_flight_t), allocatable, intent(out) :: records(:)
    type(wing_report_t), intent(inout) :: report
    type(measured_flight_t) :: common
    real(rp) :: origin(3)
    integer :: sides(2), i, n, last
    allocate (records(0))
    associate (all_of_them => group//FOLDER)
      if (.not. is_group(file, all_of_them)) then
        call report%add(all_of_them, 'is not a group with the attribute origin and the groups left and right')
        return
      end if
      call check_members(file, all_of_them, SIDE_NAMES, report)
      call check_names(file, all_of_them, [character(16) :: 'origin', 'axes', 'beats', 'correlation_time', 'offset_sd', &
                                           'turn_sd'], report)
      common = of_flight
      common%component = [integer ::]
      common%time = [real(rp) ::]
      common%mean = reshape([real(rp) ::], [0, 0])
      common%sd = common%mean
      common%is_known = reshape([logical ::], [0, 0])
      call read_vector(file, all_of_them, 'origin', 'm', FAR, origin, report)
      call read_axes(file, all_of_them, of_flight%is_per_length, common%axes, report)
      call read_whole(file, all_of_them, 'beats', 1, huge(1), of_flight%beats, common%beats, report)
      call read_real(file, all_of_them, 'correlation_time', 's', from_zero(1.0e6_rp), common%correlation_time, report, 0.0_rp)
      if (has_attribute(file, all_of_them, 'offset_sd')) &
        call read_real(file, all_of_them, 'offset_sd', 'm', above_zero(LARGEST), common%offset_sd, report)
      if (has_attribute(file, all_of_them, 'turn_sd')) &
        call read_real(file, all_of_them, 'turn_sd', 'degree', above_zero(MOST_TURN), common%turn_sd, report)
      n = 0
      do i = 1, 2
        if (.not. file%has(all_of_them//'/'//trim(SIDE_NAMES(i)))) cycle
        n = n + 1
        sides(n) = i
      end do
      if (n == 0) call report%add(all_of_them, 'holds no landmarks; it must hold the group left or right, or both')
      deallocate (records)
      allocate (records(n))
      last = first
      do i = 1, n
        records(i) = common
        records(i)%side = sides(i)
        records(i)%first = last
        call read_wing(file, all_of_them//'/'//trim(SIDE_NAMES(sides(i))), matmul(common%axes, origin), records(i), report)
        last = last + records(i)%count_landmarks()
      end do
    end associate
  end subroutine read_landmarks

  !> Reads the landmarks of one wing. `origin` [m] is along the axes of the cameras.
  subroutine read_wing(file, group, origin, f, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    real(rp), intent(in) :: origin(3)
    type(measured_flight_t), intent(inout) :: f
    type(wing_report_t), intent(inout) :: report
    character(*), parameter :: NO_NAMES(0) = [character(1) ::]
    real(rp), allocatable :: points(:)
    integer :: k, axis
    if (.not. is_group(file, group)) then
      call report%add(group, 'is not a group with the datasets time, points, mean, and sd or spread')
      return
    end if
    call check_members(file, group, [character(6) :: 'time', 'points', 'mean', 'sd', 'spread'], report)
    call check_names(file, group, NO_NAMES, report)
    call read_real_dataset(file, group//'/points', 2, points, report)
    if (size(points) == 0) return
    if (.not. all(is_finite(points))) then
      call report%add(group//'/points', 'holds a number that is infinite or undefined')
      return
    else if (any(abs(points) > LARGEST)) then
      call report%add(group//'/points', 'holds '//number_text(maxval(abs(points)))//' m; at most '//number_text(LARGEST)// &
                      ' m are valid')
      return
    end if
    f%points = reshape(points, [2, size(points)/2])
    f%component = [(N_COMPONENTS + 3*f%first + k, k=1, 3*size(f%points, 2))]
    call read_times(file, group, f, report)
    if (size(f%time) == 0) return
    call read_values(file, group, f, report)
    if (size(f%mean) == 0) then
      f%component = f%component(:0)
      return
    end if
    call drop_unseen(f)
    do k = 1, size(f%component)
      axis = modulo(f%component(k) - N_COMPONENTS - 1, 3) + 1
      where (f%is_known(:, k)) f%mean(:, k) = f%mean(:, k) + origin(axis)
    end do
  end subroutine read_wing

  !> Leaves out the coordinates that were never seen.
  subroutine drop_unseen(f)
    type(measured_flight_t), intent(inout) :: f
    logical :: is_seen(size(f%component))
    integer, allocatable :: seen(:)
    integer :: k
    is_seen = any(f%is_known, 1)
    seen = pack([(k, k=1, size(is_seen))], is_seen)
    f%component = f%component(seen)
    f%mean = f%mean(:, seen)
    f%sd = f%sd(:, seen)
    f%is_known = f%is_known(:, seen)
  end subroutine drop_unseen
end module measurement_landmarks
