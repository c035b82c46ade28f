! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the height maps of a measurement file: grid lines, the unloaded surface, the surfaces under loads.
module measurement_heights
  use base_kinds, only: rp, i8
  use base_text, only: number_text
  use io_arrays, only: is_finite
  use io_hdf5, only: hdf5_file_t
  use measurement_data, only: measurement_t, measured_load_t
  use solid_wing_datasets, only: read_real_dataset
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: read_reference, read_surface

  real(rp), parameter :: LARGEST = 1.0e4_rp !< [m] of any coordinate
  integer, parameter :: MOST_POINTS = 10000000 !< of the grid: far more than any scan has, but they fit into memory
  integer(i8), parameter :: MANTISSA_BITS = int(z'000FFFFFFFFFFFFF', i8)

contains

  !> Reads grid lines and unloaded heights, which are missing in a plan. The arrays are always allocated, empty after a mistake.
  subroutine read_reference(file, m, report)
    type(hdf5_file_t), intent(in) :: file
    type(measurement_t), intent(inout) :: m
    type(wing_report_t), intent(inout) :: report
    real(rp), allocatable :: z(:), sigma(:)
    logical, allocatable :: has(:)
    integer :: nx, ny
    call read_axis(file, 'x', m%x, report)
    call read_axis(file, 'y', m%y, report)
    if (size(m%x, kind=i8)*size(m%y, kind=i8) > MOST_POINTS) then
      call report%add('/reference', 'the grid has more than '//number_text(MOST_POINTS)//' points')
      m%x = m%x(:0)
      m%y = m%y(:0)
    end if
    nx = size(m%x)
    ny = size(m%y)
    allocate (m%unloaded(nx, ny), m%unloaded_sigma(nx, ny), source=0.0_rp)
    allocate (m%has_unloaded(nx, ny), source=.false.)
    if (nx == 0 .or. ny == 0) return
    call read_heights(file, '/reference/z', m, z, has, report)
    if (size(z) == 0) return
    if (.not. any(has)) call report%add('/reference/z', 'all heights are missing')
    m%unloaded(:, :) = reshape(z, [nx, ny])
    m%has_unloaded(:, :) = reshape(has, [nx, ny])
    m%unloaded_sigma = m%accuracy%height
    if (.not. file%has('/reference/sigma')) return
    call read_map(file, '/reference/sigma', nx, ny, .true., sigma, has, report)
    if (size(sigma) == 0) return
    if (m%is_plan) m%has_unloaded = reshape(has, [nx, ny])
    call check_sigma('/reference/sigma', sigma, pack(m%has_unloaded, .true.), has, report)
    m%unloaded_sigma = reshape(sigma, [nx, ny])
  end subroutine read_reference

  !> Reads the grid lines of one axis.
  subroutine read_axis(file, letter, axis, report)
    type(hdf5_file_t), intent(in) :: file
    character, intent(in) :: letter
    real(rp), allocatable, intent(out) :: axis(:)
    type(wing_report_t), intent(inout) :: report
    character(:), allocatable :: name
    integer :: i
    name = '/reference/'//letter
    call read_real_dataset(file, name, 0, axis, report)
    if (size(axis) == 0) return
    if (size(axis) < 2) call report%add(name, 'holds one grid line; at least 2 are needed')
    call report%begin(name)
    do i = 1, size(axis)
      if (.not. is_finite(axis(i))) then
        call report%found('grid line '//number_text(i)//' is infinite or undefined')
        axis(i) = 0
      else if (abs(axis(i)) > LARGEST) then
        call report%found('grid line '//number_text(i)//' is at '//number_text(axis(i))//' m; at most '// &
                          number_text(LARGEST)//' m is valid')
      end if
    end do
    call report%finish()
    call report%begin(name)
    do i = 2, size(axis)
      if (.not. axis(i) > axis(i - 1)) &
        call report%found('is not sorted: grid line '//number_text(i)//' at '//number_text(axis(i))// &
                          ' m follows '//number_text(axis(i - 1))//' m; grid lines must increase')
    end do
    call report%finish()
  end subroutine read_axis

  !> Reads the known heights of a load where the unloaded height is known too. In a plan, it takes all heights, or those whose sd is
  !> known.
  subroutine read_surface(file, group, m, load, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: group
    type(measurement_t), intent(in) :: m
    type(measured_load_t), intent(inout) :: load
    type(wing_report_t), intent(inout) :: report
    real(rp), allocatable :: z(:), sigma(:)
    logical, allocatable :: has(:), has_sigma(:)
    integer :: nx, ny, i, j, k, n
    nx = size(m%x)
    ny = size(m%y)
    if (nx == 0 .or. ny == 0) return
    call read_heights(file, group//'/z', m, z, has, report)
    if (size(z) == 0) return
    if (.not. any(has)) then
      call report%add(group//'/z', 'all heights are missing')
      return
    end if
    has = has .and. pack(m%has_unloaded, .true.)
    if (.not. any(has)) call report%add(group//'/z', 'has no height where the unloaded height is known')
    if (file%has(group//'/sigma')) then
      call read_map(file, group//'/sigma', nx, ny, .true., sigma, has_sigma, report)
      if (size(sigma) == 0) return
      if (m%is_plan) has = has .and. has_sigma
      call check_sigma(group//'/sigma', sigma, has, has_sigma, report)
    else
      allocate (sigma(nx*ny), source=m%accuracy%height)
    end if
    deallocate (load%node)
    allocate (load%node(2, count(has)))
    load%height = pack(z, has)
    load%sigma = pack(sigma, has)
    n = 0
    k = 0
    do j = 1, ny
      do i = 1, nx
        k = k + 1
        if (.not. has(k)) cycle
        n = n + 1
        load%node(:, n) = [i, j]
      end do
    end do
  end subroutine read_surface

  !> Reads a map of heights. In a plan it is 0, and all its heights count as known.
  subroutine read_heights(file, name, m, values, has, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    type(measurement_t), intent(in) :: m
    real(rp), allocatable, intent(out) :: values(:)
    logical, allocatable, intent(out) :: has(:)
    type(wing_report_t), intent(inout) :: report
    if (.not. m%is_plan) then
      call read_map(file, name, size(m%x), size(m%y), .false., values, has, report)
    else
      allocate (values(size(m%x)*size(m%y)), source=0.0_rp)
      allocate (has(size(values)), source=.true.)
    end if
  end subroutine read_heights

  !> Reads values(nx ny), 0 where they are missing, and tells which are present; both arrays are empty after a mistake of form.
  subroutine read_map(file, name, nx, ny, is_sigma, values, has, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(in) :: nx, ny
    logical, intent(in) :: is_sigma
    real(rp), allocatable, intent(out) :: values(:)
    logical, allocatable, intent(out) :: has(:)
    type(wing_report_t), intent(inout) :: report
    integer :: k
    call read_real_dataset(file, name, nx, values, report)
    if (size(values) > 0 .and. size(values, kind=i8) /= int(nx, i8)*ny) then
      call report%add(name, 'has '//number_text(size(values)/nx)//' rows; /reference/y has '//number_text(ny)//' values')
      values = values(:0)
    end if
    has = is_finite(values)
    call report%begin(name)
    do k = 1, size(values)
      if (has(k)) then
        if (abs(values(k)) > LARGEST) call report%found('the value at '//at(k)//' is '//number_text(values(k))// &
                                                        ' m; at most '//number_text(LARGEST)//' m is valid')
      else
        if (.not. is_nan(values(k)) .and. .not. is_sigma) &
          call report%found('the height at '//at(k)//' is infinite; missing heights are NaN')
        values(k) = 0
      end if
    end do
    call report%finish()

  contains

    !> Returns row and column counted from 0, as other programs show them.
    function at(number) result(text)
      integer, intent(in) :: number
      character(:), allocatable :: text
      text = '['//number_text((number - 1)/nx)//', '//number_text(mod(number - 1, nx))//']'
    end function at

  end subroutine read_map

  !> Tells whether a number is undefined (NaN).
  pure elemental logical function is_nan(x)
    real(rp), intent(in) :: x
    is_nan = .not. is_finite(x) .and. iand(transfer(x, 0_i8), MANTISSA_BITS) /= 0
  end function is_nan

  !> Checks that the standard deviation is a positive number wherever a height is known.
  subroutine check_sigma(name, sigma, is_needed, has, report)
    character(*), intent(in) :: name
    real(rp), intent(in) :: sigma(:)
    logical, intent(in) :: is_needed(:), has(:)
    type(wing_report_t), intent(inout) :: report
    integer :: n
    n = count(is_needed .and. .not. (has .and. sigma > 0))
    if (n > 0) call report%add(name, number_text(n)// &
                               ' standard deviations of known heights are missing or not positive')
  end subroutine check_sigma
end module measurement_heights
