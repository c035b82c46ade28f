! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads records of a vibrating wing: displacement or velocity of points over time after a release, a tap, or a known motion of
!> the clamp. They are the part `/series` of a measurement file (docs/formats/measurement-format.md).
module measurement_series
  use base_kinds, only: rp
  use base_text, only: number_text, quoted
  use base_visitor, only: visited_t, visitor_t
  use io_arrays, only: is_finite, is_group, is_infinite
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use measurement_attributes, only: above_zero, check_names, from_zero, read_direction, read_real, read_vector, read_whole, &
                                    read_word
  use measurement_modes, only: read_medium, read_names_and_air, MEDIUM_VACUUM
  use measurement_material_point, only: find_material_point, material_point_t
  use solid_ringing, only: EXCITED_BASE, EXCITED_RELEASE, EXCITED_TAP
  use solid_wing, only: wing_t
  use solid_wing_datasets, only: check_members, read_real_dataset
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: measured_series_t, check_series, read_series

  integer, parameter :: MOST_NUMBERS = 20000 !< of all series together

  !> Holds one record.
  type, extends(visited_t) :: measured_series_t
    character(:), allocatable :: name
    integer :: medium = MEDIUM_VACUUM
    integer :: excitation = EXCITED_RELEASE
    logical :: is_velocity = .false.
    real(rp) :: point(2) = 0                  !< [m] where the wing was held or tapped
    real(rp) :: direction(3) = 0              !< of the force that bent it, of the impulse, or of the base's motion
    real(rp) :: size = 1                      !< [N] force that was released, or [N s] impulse; 1 for a motion of the base
    real(rp) :: size_sigma = 0                !< its sd, in the same unit
    real(rp) :: axis(3) = 0                   !< direction of the measured motion
    real(rp) :: rate = 0                      !< [Hz] samples
    real(rp) :: start = 0                     !< [s] of the first sample after the excitation
    real(rp) :: trigger_sigma = 0             !< [s] sd of the time of the excitation
    real(rp) :: lowpass = 0                   !< [Hz] cut-off of the filter; 0: none
    integer :: order = 1                      !< of the filter
    real(rp), allocatable :: place(:, :)      !< (2, m) [m] (x, y) on the wing
    real(rp), allocatable :: values(:, :)     !< (n, m) [m] or [m/s]; 0 where unknown
    logical, allocatable :: is_known(:, :)    !< (n, m)
    real(rp), allocatable :: sigma(:)         !< (m) sd of a single value
    real(rp), allocatable :: base(:)          !< (n) [m/s2] acceleration of the clamp; empty unless it moves
  contains
    procedure :: visit => series_visit
    procedure :: count => series_count
    procedure :: in_sd => series_in_sd
    procedure :: length => series_length
  end type measured_series_t

  real(rp), parameter :: FAR = 1.0e4_rp       !< [m]

contains

  !> Shows every component to the visitor.
  subroutine series_visit(self, visitor)
    class(measured_series_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit_allocatable('name', self%name)
    call visitor%visit('medium', self%medium)
    call visitor%visit('excitation', self%excitation)
    call visitor%visit('is_velocity', self%is_velocity)
    call visitor%visit('point', self%point)
    call visitor%visit('direction', self%direction)
    call visitor%visit('size', self%size)
    call visitor%visit('size_sigma', self%size_sigma)
    call visitor%visit('axis', self%axis)
    call visitor%visit('rate', self%rate)
    call visitor%visit('start', self%start)
    call visitor%visit('trigger_sigma', self%trigger_sigma)
    call visitor%visit('lowpass', self%lowpass)
    call visitor%visit('order', self%order)
    call visitor%visit_allocatable('place', self%place)
    call visitor%visit_allocatable('values', self%values)
    call visitor%visit_allocatable('is_known', self%is_known)
    call visitor%visit_allocatable('sigma', self%sigma)
    call visitor%visit_allocatable('base', self%base)
  end subroutine series_visit

  !> Returns how many numbers are known.
  pure integer function series_count(self) result(n)
    class(measured_series_t), intent(in) :: self
    n = 0
    if (allocated(self%is_known)) n = count(self%is_known)
  end function series_count

  !> Returns column(count()), seen(samples, traces) over the sd of each trace where the record has values: trace by trace, in time.
  pure function series_in_sd(self, seen) result(column)
    class(measured_series_t), intent(in) :: self
    real(rp), intent(in) :: seen(:, :)
    real(rp) :: column(self%count())
    column = pack(seen/spread(self%sigma, 1, size(seen, 1)), self%is_known)
  end function series_in_sd

  !> Returns the time [s] from the excitation to the last sample.
  pure real(rp) function series_length(self) result(length)
    class(measured_series_t), intent(in) :: self
    length = self%start + (size(self%values, 1) - 1)/self%rate
  end function series_length

  !> Reads the records of a file, in alphabetical order, and the density of the air [kg/m^3]. Without records in the file, the list
  !> is empty.
  subroutine read_series(file, series, density, report)
    type(hdf5_file_t), intent(in) :: file
    type(measured_series_t), allocatable, intent(out) :: series(:)
    real(rp), intent(out) :: density
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    integer :: i, total
    call read_names_and_air(file, '/series', names, density, report)
    allocate (series(size(names)))
    total = 0
    do i = 1, size(names)
      series(i)%name = trim(names(i))
      allocate (series(i)%place(2, 0), series(i)%values(0, 0), series(i)%is_known(0, 0), series(i)%sigma(0), series(i)%base(0))
      call read_one(file, '/series/'//trim(names(i)), series(i), report)
      total = total + series(i)%count()
    end do
    if (total > MOST_NUMBERS) call report%add('/series', 'holds '//number_text(total)//' numbers; at most '// &
                                              number_text(MOST_NUMBERS)//' are valid: filter the records and take fewer samples')
  end subroutine read_series

  !> Reads one vibration record.
  subroutine read_one(file, group, s, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_series_t), intent(inout) :: s
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: text
    if (.not. is_group(file, group)) then
      call report%add(group, 'is not a group with the attributes excitation, medium, units and rate')
      return
    end if
    call check_members(file, group, [character(6) :: 'points', 'values', 'sigma', 'base'], report)
    call check_names(file, group, [character(13) :: 'excitation', 'medium', 'units', 'point', 'direction', 'size', 'size_sigma', &
                                   'axis', 'rate', 'start', 'trigger_sigma', 'lowpass', 'order'], report)
    call read_medium(file, group, s%medium, report)
    call read_word(file, group, 'units', .true., text, report)
    s%is_velocity = text == 'm/s'
    if (len(text) > 0 .and. text /= 'm' .and. text /= 'm/s') &
      call report%add(group, 'attribute units is '//quoted(text)//'; valid: m (displacement), m/s (velocity)')
    call read_direction(file, group, 'axis', s%axis, report)
    call read_real(file, group, 'rate', 'Hz', above_zero(1.0e9_rp), s%rate, report)
    call read_real(file, group, 'start', 's', from_zero(1.0e6_rp), s%start, report, 0.0_rp)
    call read_real(file, group, 'trigger_sigma', 's', from_zero(1.0e6_rp), s%trigger_sigma, report, 0.0_rp)
    call read_real(file, group, 'lowpass', 'Hz', above_zero(1.0e9_rp), s%lowpass, report, 0.0_rp)
    call read_whole(file, group, 'order', 1, 2, 1, s%order, report)
    call read_excitation(file, group, s, report)
    call read_values(file, group, s, report)
    call read_base(file, group, s, report)
  end subroutine read_one

  !> Reads what excites the wing in a record.
  subroutine read_excitation(file, group, s, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_series_t), intent(inout) :: s
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: text, unit
    call read_word(file, group, 'excitation', .true., text, report)
    call read_direction(file, group, 'direction', s%direction, report)
    unit = 'N'
    select case (text)
    case ('release')
      s%excitation = EXCITED_RELEASE
    case ('tap')
      s%excitation = EXCITED_TAP
      unit = 'N s'
    case ('base')
      s%excitation = EXCITED_BASE
      if (s%start > 0) call report%add(group, 'attribute start must be 0 with excitation base: the record of the base begins '// &
                                       'with the samples')
      return
    case default
      if (len(text) > 0) call report%add(group, 'attribute excitation is '//quoted(text)//'; valid: release, tap, base')
      return
    end select
    call read_vector(file, group, 'point', 'm', FAR, s%point, report)
    call read_real(file, group, 'size', unit, above_zero(1.0e6_rp), s%size, report)
    call read_real(file, group, 'size_sigma', unit, from_zero(1.0e6_rp), s%size_sigma, report)
  end subroutine read_excitation

  !> Reads the points, the values and their sd.
  subroutine read_values(file, group, s, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_series_t), intent(inout) :: s
    type(wing_report_t), intent(inout) :: report
    real(rp), allocatable :: places(:), values(:), sigma(:)
    integer :: n, m
    call read_real_dataset(file, group//'/points', 2, places, report)
    m = size(places)/2
    call read_real_dataset(file, group//'/sigma', 0, sigma, report, has_units=.false.)
    if (m == 0) return
    call read_real_dataset(file, group//'/values', m, values, report, has_units=.false.)
    n = size(values)/m
    if (min(n, size(sigma)) == 0) return
    if (size(sigma) /= m) then
      call report%add(group, 'points has '//number_text(m)//' rows and sigma '//number_text(size(sigma))// &
                      ' numbers; they must be as many')
    else if (n < 2) then
      call report%add(group//'/values', 'holds one row; at least 2 samples make a series')
    else if (.not. all(is_finite(places)) .or. .not. all(is_finite(sigma))) then
      call report%add(group, 'points or sigma holds a number that is infinite or undefined; leave the point out')
    else if (any(is_infinite(values))) then
      call report%add(group//'/values', 'holds an infinite number; only NaN means missing')
    else if (any(abs(places) > FAR)) then
      call report%add(group//'/points', 'holds '//number_text(maxval(abs(places)))//' m; at most '//number_text(FAR)//' m is valid')
    else if (.not. all(sigma > 0)) then
      call report%add(group//'/sigma', 'holds '//number_text(minval(sigma))//'; standard deviations must be positive')
    else if (.not. all(any(reshape(is_finite(values), [m, n]), 2))) then
      call report%add(group//'/values', 'holds a column without any number; leave the point out')
    else
      s%place = reshape(places, [2, m])
      s%is_known = transpose(reshape(is_finite(values), [m, n]))
      s%values = transpose(reshape(values, [m, n]))
      where (.not. s%is_known) s%values = 0
      s%sigma = sigma
    end if
  end subroutine read_values

  !> Reads the record of the clamp's acceleration, as long as the samples.
  subroutine read_base(file, group, s, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_series_t), intent(inout) :: s
    type(wing_report_t), intent(inout) :: report
    real(rp), allocatable :: base(:)
    if (s%excitation /= EXCITED_BASE) then
      if (file%has(group//'/base')) call report%add(group//'/base', 'is only valid where excitation is base')
      return
    end if
    call read_real_dataset(file, group//'/base', 0, base, report, has_units=.false.)
    if (size(base) == 0) return
    if (.not. all(is_finite(base))) then
      call report%add(group//'/base', 'holds a number that is infinite or undefined')
    else if (size(s%values) > 0 .and. size(base) /= size(s%values, 1)) then
      call report%add(group, 'values has '//number_text(size(s%values, 1))//' rows and base '//number_text(size(base))// &
                      ' numbers; they must be as many')
    else
      s%base = base
    end if
  end subroutine read_base

  !> Reports places that are not on the wing of this length [m].
  subroutine check_series(series, wing, length, report)
    type(measured_series_t), intent(in) :: series(:)
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: length
    type(wing_report_t), intent(inout) :: report
    integer :: i, k
    do i = 1, size(series)
      call report%begin('/series/'//series(i)%name//'/points')
      do k = 1, size(series(i)%place, 2)
        if (.not. is_on_wing(series(i)%place(:, k))) &
          call report%found('row '//number_text(k)//', ('//number_text(series(i)%place(1, k))//', '// &
                            number_text(series(i)%place(2, k))//') m, is not on the wing')
      end do
      call report%finish()
      if (series(i)%excitation == EXCITED_BASE) cycle
      if (.not. is_on_wing(series(i)%point)) &
        call report%add('/series/'//series(i)%name, 'attribute point: ('//number_text(series(i)%point(1))//', '// &
                        number_text(series(i)%point(2))//') m is not on the wing')
    end do

  contains

    logical function is_on_wing(point)
      real(rp), intent(in) :: point(2)
      type(material_point_t) :: place
      place = find_material_point(wing%points, wing%triangles, length, point)
      is_on_wing = place%is_found
    end function is_on_wing

  end subroutine check_series
end module measurement_series
