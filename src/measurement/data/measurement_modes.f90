! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads natural modes that were measured on a wing: the part `/modes` of a measurement file (docs/formats/measurement-format.md).
module measurement_modes
  use base_kinds, only: rp
  use base_text, only: number_text, quoted
  use base_visitor, only: visited_t, visitor_t
  use io_arrays, only: is_finite, is_group
  use io_attributes, only: has_attribute
  use io_hdf5, only: hdf5_file_t, NAME_LENGTH
  use measurement_attributes, only: above_zero, check_names, from_zero, read_direction, read_real, read_vector, read_whole, &
                                    read_word
  use measurement_material_point, only: find_material_point, material_point_t
  use solid_wing, only: wing_t
  use solid_wing_datasets, only: check_members, read_names, read_real_dataset
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: measured_mode_t, read_modes, check_modes, read_names_and_air, read_medium

  integer, parameter, public :: MEDIUM_VACUUM = 1, MEDIUM_AIR = 2
  character(6), parameter, public :: MEDIUM_NAMES(2) = [character(6) :: 'vacuum', 'air']
  real(rp), parameter, public :: AIR_DENSITY = 1.2_rp !< [kg/m^3] unless the file says another one

  !> Holds one natural mode.
  type, extends(visited_t) :: measured_mode_t
    character(:), allocatable :: name
    integer :: medium = MEDIUM_VACUUM
    integer :: number = 0                     !< among all modes of the wing, from the lowest; 0: not declared
    real(rp) :: frequency = 0                 !< [Hz] of the undamped mode
    real(rp) :: frequency_sigma = 0           !< [Hz] its sd
    real(rp) :: damping = -1                  !< fraction of critical damping; negative: not measured
    real(rp) :: damping_sigma = 0             !< its sd
    real(rp), allocatable :: place(:, :)      !< (2, n) [m] (x, y) on the wing
    real(rp), allocatable :: shape(:)         !< (n) displacement along z there, in any unit
    real(rp), allocatable :: sigma(:)         !< (n) its sd, in the same unit
    !> Dead loads that bend the wing while it vibrates: sizes(m) [N], directions(3, m), unit vectors, and places(2, m) [m].
    real(rp), allocatable :: load_size(:), load_direction(:, :), load_place(:, :)
    real(rp) :: gravity(3) = 0                !< [m/s^2] gravity, if the weight bends the wing too
  contains
    procedure :: visit => mode_visit
    procedure :: is_loaded => mode_is_loaded
    procedure :: has_load_of => mode_has_load_of
  end type measured_mode_t

  real(rp), parameter :: FAR = 1.0e4_rp       !< [m]
  integer, parameter :: FEWEST = 2            !< smallest number of points that make a shape

contains

  !> Shows every component to the visitor.
  subroutine mode_visit(self, visitor)
    class(measured_mode_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit_allocatable('name', self%name)
    call visitor%visit('medium', self%medium)
    call visitor%visit('number', self%number)
    call visitor%visit('frequency', self%frequency)
    call visitor%visit('frequency_sigma', self%frequency_sigma)
    call visitor%visit('damping', self%damping)
    call visitor%visit('damping_sigma', self%damping_sigma)
    call visitor%visit_allocatable('place', self%place)
    call visitor%visit_allocatable('shape', self%shape)
    call visitor%visit_allocatable('sigma', self%sigma)
    call visitor%visit_allocatable('load_size', self%load_size)
    call visitor%visit_allocatable('load_direction', self%load_direction)
    call visitor%visit_allocatable('load_place', self%load_place)
    call visitor%visit('gravity', self%gravity)
  end subroutine mode_visit

  !> Tells whether the wing vibrates about a shape under loads or under its weight, and not about its unloaded shape.
  pure logical function mode_is_loaded(self) result(is_loaded)
    class(measured_mode_t), intent(in) :: self
    is_loaded = any(abs(self%gravity) > 0)
    if (allocated(self%load_size)) is_loaded = is_loaded .or. size(self%load_size) > 0
  end function mode_is_loaded

  !> Tells whether both vibrate in the same medium and about the same shape: under the same loads, or both without loads.
  pure logical function mode_has_load_of(self, other) result(same)
    class(measured_mode_t), intent(in) :: self, other
    same = self%medium == other%medium .and. .not. any(abs(self%gravity - other%gravity) > 0)
    same = same .and. count_loads(self) == count_loads(other)
    if (.not. same .or. count_loads(self) == 0) return
    same = .not. (any(abs(self%load_size - other%load_size) > 0) .or. any(abs(self%load_place - other%load_place) > 0) .or. &
                  any(abs(self%load_direction - other%load_direction) > 0))
  end function mode_has_load_of

  !> Returns the number of loads under which a mode was measured.
  pure integer function count_loads(mode) result(n)
    class(measured_mode_t), intent(in) :: mode
    n = 0
    if (allocated(mode%load_size)) n = size(mode%load_size)
  end function count_loads

  !> Reads the modes of a file, in alphabetical order, and the density of the air [kg/m^3]. Without modes in the file, the list is
  !> empty.
  subroutine read_modes(file, modes, density, report)
    type(hdf5_file_t), intent(in) :: file
    type(measured_mode_t), allocatable, intent(out) :: modes(:)
    real(rp), intent(out) :: density
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    integer :: i
    call read_names_and_air(file, '/modes', names, density, report)
    allocate (modes(size(names)))
    do i = 1, size(names)
      call read_mode(file, trim(names(i)), modes(i), report)
    end do
  end subroutine read_modes

  !> Reads the names in a group of modes or records, in alphabetical order, and the density of the air [kg/m^3]. If the file lacks
  !> such a group, there are no names.
  subroutine read_names_and_air(file, group, names, density, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    character(NAME_LENGTH), allocatable, intent(out) :: names(:)
    real(rp), intent(out) :: density
    type(wing_report_t), intent(inout) :: report
    density = AIR_DENSITY
    call read_names(file, group, names, report)
    if (.not. is_group(file, group)) return
    call check_names(file, group, [character(11) :: 'air_density'], report)
    call read_real(file, group, 'air_density', 'kg/m^3', above_zero(1.0e3_rp), density, report, AIR_DENSITY)
  end subroutine read_names_and_air

  !> Reads the attribute `medium` of a group. A mistake leaves `medium` as it is.
  subroutine read_medium(file, group, medium, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    integer, intent(inout) :: medium
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: text
    call read_word(file, group, 'medium', .true., text, report)
    select case (text)
    case ('vacuum')
      medium = MEDIUM_VACUUM
    case ('air')
      medium = MEDIUM_AIR
    case default
      if (len(text) > 0) call report%add(group, 'attribute medium is '//quoted(text)//'; valid: air, vacuum')
    end select
  end subroutine read_medium

  !> Reads one measured mode.
  subroutine read_mode(file, name, mode, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    type(measured_mode_t), intent(inout) :: mode
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: group
    group = '/modes/'//name
    mode%name = name
    allocate (mode%place(2, 0), mode%shape(0), mode%sigma(0), mode%load_size(0), mode%load_direction(3, 0), mode%load_place(2, 0))
    if (.not. is_group(file, group)) then
      call report%add(group, 'is not a group with the attributes frequency, frequency_sigma and medium')
      return
    end if
    call check_members(file, group, [character(6) :: 'points', 'shape', 'sigma', 'loads'], report)
    call check_names(file, group, [character(15) :: 'frequency', 'frequency_sigma', 'damping', 'damping_sigma', 'medium', &
                                   'number', 'gravity'], report)
    call read_real(file, group, 'frequency', 'Hz', above_zero(1.0e9_rp), mode%frequency, report)
    call read_real(file, group, 'frequency_sigma', 'Hz', above_zero(1.0e9_rp), mode%frequency_sigma, report)
    if (mode%frequency > 0 .and. mode%frequency_sigma > mode%frequency) &
      call report%add(group, 'attribute frequency_sigma is '//number_text(mode%frequency_sigma)// &
                      ' Hz, more than the frequency')
    call read_real(file, group, 'damping', '', from_zero(1.0_rp), mode%damping, report, -1.0_rp)
    if (mode%damping >= 0) call read_real(file, group, 'damping_sigma', '', above_zero(1.0_rp), mode%damping_sigma, report)
    call read_whole(file, group, 'number', 1, 1000, 0, mode%number, report)
    call read_medium(file, group, mode%medium, report)
    if (has_attribute(file, group, 'gravity')) call read_vector(file, group, 'gravity', 'm/s^2', 1.0e3_rp, mode%gravity, report)
    call read_loads(file, group//'/loads', mode, report)
    if (file%has(group//'/points') .or. file%has(group//'/shape') .or. file%has(group//'/sigma')) then
      call read_shape(file, group, mode, report)
    else if (mode%number == 0) then
      call report%add(group, 'cannot be identified: give it a shape (points, shape, sigma) or the attribute '// &
                      'number')
    end if
  end subroutine read_mode

  !> Reads the loads under which the mode was measured, possibly none, in alphabetical order.
  subroutine read_loads(file, group, mode, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_mode_t), intent(inout) :: mode
    type(wing_report_t), intent(inout) :: report
    character(NAME_LENGTH), allocatable :: names(:)
    character(:), allocatable :: load
    integer :: i
    call read_names(file, group, names, report)
    if (is_group(file, group) .and. size(names) == 0) call report%add(group, 'holds no load; remove it for a mode of the '// &
                                                                      'unloaded wing')
    deallocate (mode%load_size, mode%load_direction, mode%load_place)
    allocate (mode%load_size(size(names)), mode%load_direction(3, size(names)), mode%load_place(2, size(names)), source=0.0_rp)
    do i = 1, size(names)
      load = group//'/'//trim(names(i))
      if (.not. is_group(file, load)) then
        call report%add(load, 'is not a group with the attributes force, direction and point')
        cycle
      end if
      call check_members(file, load, [character(1) ::], report)
      call check_names(file, load, [character(9) :: 'force', 'direction', 'point'], report)
      call read_real(file, load, 'force', 'N', above_zero(1.0e6_rp), mode%load_size(i), report)
      call read_direction(file, load, 'direction', mode%load_direction(:, i), report)
      call read_vector(file, load, 'point', 'm', FAR, mode%load_place(:, i), report)
    end do
  end subroutine read_loads

  !> Reads the points, the shape and its sd of one mode, if the file has them, and reports their mistakes.
  subroutine read_shape(file, group, mode, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measured_mode_t), intent(inout) :: mode
    type(wing_report_t), intent(inout) :: report
    real(rp), allocatable :: places(:), values(:), sigma(:)
    integer :: n
    call read_real_dataset(file, group//'/points', 2, places, report)
    call read_real_dataset(file, group//'/shape', 0, values, report, has_units=.false.)
    call read_real_dataset(file, group//'/sigma', 0, sigma, report, has_units=.false.)
    n = size(values)
    if (min(size(places), n, size(sigma)) == 0) return
    if (size(places) /= 2*n .or. size(sigma) /= n) then
      call report%add(group, 'points has '//number_text(size(places)/2)//' rows, shape '//number_text(n)// &
                      ' and sigma '//number_text(size(sigma))//' numbers; they must be as many')
    else if (n < FEWEST) then
      call report%add(group//'/shape', 'holds one number; at least '//number_text(FEWEST)//' places make a shape')
    else if (.not. all(is_finite(places)) .or. .not. all(is_finite(values)) .or. .not. all(is_finite(sigma))) then
      call report%add(group, 'points, shape or sigma holds a number that is infinite or undefined; leave the place out')
    else if (any(abs(places) > FAR)) then
      call report%add(group//'/points', 'holds '//number_text(maxval(abs(places)))//' m; at most '//number_text(FAR)//' m is valid')
    else if (.not. all(sigma > 0)) then
      call report%add(group//'/sigma', 'holds '//number_text(minval(sigma))//'; standard deviations must be positive')
    else if (.not. any(abs(values) > 0)) then
      call report%add(group//'/shape', 'is 0 everywhere; at least two displacements must not be 0')
    else
      mode%place = reshape(places, [2, n])
      mode%shape = values
      mode%sigma = sigma
    end if
  end subroutine read_shape

  !> Reports places of shapes and of loads that are not on the wing of this length [m], and modes with the same number.
  subroutine check_modes(modes, wing, length, report)
    type(measured_mode_t), intent(in) :: modes(:)
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: length
    type(wing_report_t), intent(inout) :: report
    integer :: i, k
    do i = 1, size(modes)
      call report%begin('/modes/'//modes(i)%name//'/points')
      do k = 1, size(modes(i)%shape)
        call check_place('row '//number_text(k)//', (', modes(i)%place(:, k))
      end do
      call report%finish()
      call report%begin('/modes/'//modes(i)%name//'/loads')
      do k = 1, count_loads(modes(i))
        call check_place('attribute point of load '//number_text(k)//': (', modes(i)%load_place(:, k))
      end do
      call report%finish()
      if (modes(i)%number == 0) cycle
      do k = 1, i - 1
        if (modes(k)%number == modes(i)%number .and. modes(k)%has_load_of(modes(i))) &
          call report%add('/modes/'//modes(i)%name, 'attribute number is '//number_text(modes(i)%number)// &
                          ', as in '//modes(k)%name//'; modes in the same medium need different numbers')
      end do
    end do

  contains

    subroutine check_place(what, place)
      character(*), intent(in) :: what
      real(rp), intent(in) :: place(2)
      type(material_point_t) :: found
      found = find_material_point(wing%points, wing%triangles, length, place)
      if (.not. found%is_found) call report%found(what//number_text(place(1))//', '//number_text(place(2))// &
                                                  ') m, is not on the wing')
    end subroutine check_place

  end subroutine check_modes
end module measurement_modes
