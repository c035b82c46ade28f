! SPDX-License-Identifier: GPL-3.0-or-later
!> The measurement of a file on all ranks.
module measurement_broadcast
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use io_hdf5, only: NAME_LENGTH
  use measurement_data, only: measurement_t, measured_load_t, observation_t
  use measurement_file, only: read_measurement
  use measurement_series_broadcast, only: broadcast_series
  use parallel_world, only: world_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: load_measurement

contains

  !> Rank 0 reads the file, which `may_be_plan` of an experiment (by default not); all ranks get the measurement and the
  !> messages. `wing` is the same on all. Collective.
  subroutine load_measurement(world, path, wing, measurement, messages, may_be_plan)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    type(wing_t), intent(in) :: wing
    type(measurement_t), intent(out) :: measurement
    type(message_list_t), intent(inout) :: messages
    logical, intent(in), optional :: may_be_plan
    type(message_list_t) :: found
    character(:), allocatable :: text
    integer :: n, i
    if (world%is_root) call read_measurement(path, wing, measurement, found, may_be_plan)
    n = found%count()
    call world%broadcast_integer(n)
    do i = 1, n
      if (world%is_root) text = found%text(i)
      call world%broadcast_text(text)
      call messages%add(text)
    end do
    if (n == 0) call broadcast_measurement(world, measurement)
  end subroutine load_measurement

  subroutine broadcast_measurement(world, m)
    type(world_t), intent(in) :: world
    type(measurement_t), intent(inout) :: m
    integer :: n(6), i
    n = 0
    if (world%is_root) n = [size(m%x), size(m%y), size(m%loads), size(m%observations), size(m%zeros), &
                            merge(1, 0, m%is_plan)]
    call world%broadcast_integers(n)
    m%is_plan = n(6) == 1
    if (.not. world%is_root) allocate (m%x(n(1)), m%y(n(2)), m%unloaded(n(1), n(2)), m%unloaded_sigma(n(1), n(2)), &
                                       m%has_unloaded(n(1), n(2)), m%loads(n(3)), m%observations(n(4)), m%zeros(n(5)))
    call world%broadcast_reals(m%x)
    call world%broadcast_reals(m%y)
    call broadcast_reference(world, n(1)*n(2), m)
    associate (a => m%accuracy)
      call broadcast_reals(world, a%height, a%correlation_length, a%force, a%force_gain)
      call broadcast_reals(world, a%position, a%tilt, a%piston)
    end associate
    associate (c => m%calibration)
      call world%broadcast_integer(c%force_by_weight)
      call world%broadcast_integer(c%height_by_gauge)
      call world%broadcast_integer(c%position_by_marks)
      call world%broadcast_integer(c%order_is_random)
    end associate
    do i = 1, n(3)
      call broadcast_load(world, m%loads(i))
    end do
    do i = 1, n(4)
      call broadcast_observation(world, m%observations(i))
    end do
    do i = 1, n(5)
      call broadcast_name(world, m%zeros(i))
    end do
    call broadcast_modes(world, m)
    call broadcast_series(world, m%series, m%series_air_density)
  end subroutine broadcast_measurement

  subroutine broadcast_reference(world, n, m)
    type(world_t), intent(in) :: world
    integer, intent(in) :: n
    type(measurement_t), intent(inout) :: m
    real(rp), allocatable :: flat(:)
    integer, allocatable :: known(:)
    flat = reshape(m%unloaded, [n])
    call world%broadcast_reals(flat)
    m%unloaded = reshape(flat, shape(m%unloaded))
    flat = reshape(m%unloaded_sigma, [n])
    call world%broadcast_reals(flat)
    m%unloaded_sigma = reshape(flat, shape(m%unloaded))
    allocate (known(n), source=0)
    if (world%is_root) known = merge(1, 0, reshape(m%has_unloaded, [n]))
    call world%broadcast_integers(known)
    m%has_unloaded = reshape(known == 1, shape(m%unloaded))
  end subroutine broadcast_reference

  subroutine broadcast_load(world, load)
    type(world_t), intent(in) :: world
    type(measured_load_t), intent(inout) :: load
    integer, allocatable :: flat(:)
    integer :: numbers(4)
    numbers = 0
    if (world%is_root) numbers = [load%count(), load%order, load%replicate, merge(1, 0, load%has_surface)]
    call world%broadcast_integers(numbers)
    if (.not. world%is_root) then
      allocate (load%node(2, numbers(1)), load%height(numbers(1)), load%sigma(numbers(1)))
      load%order = numbers(2)
      load%replicate = numbers(3)
      load%has_surface = numbers(4) == 1
    end if
    call world%broadcast_text(load%name)
    call broadcast_reals(world, load%force, load%time, load%hold)
    call world%broadcast_reals(load%direction)
    call world%broadcast_reals(load%point)
    flat = reshape(load%node, [2*numbers(1)])
    call world%broadcast_integers(flat)
    load%node = reshape(flat, [2, numbers(1)])
    call world%broadcast_reals(load%height)
    call world%broadcast_reals(load%sigma)
  end subroutine broadcast_load

  subroutine broadcast_observation(world, observation)
    type(world_t), intent(in) :: world
    type(observation_t), intent(inout) :: observation
    call world%broadcast_text(observation%name)
    call world%broadcast_integer(observation%load)
    call world%broadcast_integer(observation%quantity)
    call world%broadcast_integer(observation%zero)
    call world%broadcast_reals(observation%point)
    call world%broadcast_reals(observation%axis)
    call broadcast_reals(world, observation%value, observation%sigma)
  end subroutine broadcast_observation

  subroutine broadcast_modes(world, m)
    type(world_t), intent(in) :: world
    type(measurement_t), intent(inout) :: m
    real(rp), allocatable :: flat(:)
    real(rp) :: density(1)
    integer :: numbers(3), n, i
    n = m%count_modes()
    call world%broadcast_integer(n)
    if (.not. world%is_root) allocate (m%modes(n))
    density = m%air_density
    call world%broadcast_reals(density)
    m%air_density = density(1)
    do i = 1, n
      associate (mode => m%modes(i))
        call world%broadcast_text(mode%name)
        numbers = 0
        if (world%is_root) numbers = [mode%medium, mode%number, size(mode%shape)]
        call world%broadcast_integers(numbers)
        mode%medium = numbers(1)
        mode%number = numbers(2)
        call broadcast_reals(world, mode%frequency, mode%frequency_sigma, mode%damping, mode%damping_sigma)
        if (.not. world%is_root) allocate (mode%place(2, numbers(3)), mode%shape(numbers(3)), mode%sigma(numbers(3)))
        flat = reshape(mode%place, [2*numbers(3)])
        call world%broadcast_reals(flat)
        mode%place = reshape(flat, [2, numbers(3)])
        call world%broadcast_reals(mode%shape)
        call world%broadcast_reals(mode%sigma)
      end associate
    end do
  end subroutine broadcast_modes

  subroutine broadcast_name(world, name)
    type(world_t), intent(in) :: world
    character(NAME_LENGTH), intent(inout) :: name
    character(:), allocatable :: text
    if (world%is_root) text = trim(name)
    call world%broadcast_text(text)
    name = text
  end subroutine broadcast_name

  subroutine broadcast_reals(world, a, b, c, d)
    type(world_t), intent(in) :: world
    real(rp), intent(inout) :: a, b
    real(rp), intent(inout), optional :: c, d
    real(rp) :: values(4)
    values = [a, b, 0.0_rp, 0.0_rp]
    if (present(c)) values(3) = c
    if (present(d)) values(4) = d
    call world%broadcast_reals(values)
    a = values(1)
    b = values(2)
    if (present(c)) c = values(3)
    if (present(d)) d = values(4)
  end subroutine broadcast_reals
end module measurement_broadcast
