! SPDX-License-Identifier: GPL-3.0-or-later
!> The records of a measurement on all ranks.
module measurement_series_broadcast
  use base_kinds, only: rp
  use measurement_series, only: measured_series_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: broadcast_series

  integer, parameter :: N_REALS = 16

contains

  !> Rank 0 has series(:), or none; all get them, and the density of the air. Collective.
  subroutine broadcast_series(world, series, density)
    type(world_t), intent(in) :: world
    type(measured_series_t), allocatable, intent(inout) :: series(:)
    real(rp), intent(inout) :: density
    real(rp) :: one(1)
    integer :: n, i
    n = 0
    if (world%is_root .and. allocated(series)) n = size(series)
    call world%broadcast_integer(n)
    if (.not. allocated(series)) allocate (series(n))
    one = density
    call world%broadcast_reals(one)
    density = one(1)
    do i = 1, n
      call broadcast_one(world, series(i))
    end do
  end subroutine broadcast_series

  subroutine broadcast_one(world, s)
    type(world_t), intent(in) :: world
    type(measured_series_t), intent(inout) :: s
    real(rp) :: reals(N_REALS)
    real(rp), allocatable :: flat(:)
    integer, allocatable :: known(:)
    integer :: numbers(7)
    numbers = 0
    reals = 0
    if (world%is_root) then
      numbers = [s%medium, s%excitation, merge(1, 0, s%is_velocity), s%order, size(s%values, 1), size(s%values, 2), size(s%base)]
      reals = [s%point, s%direction, s%size, s%size_sigma, s%axis, s%rate, s%start, s%trigger_sigma, s%lowpass, 0.0_rp, 0.0_rp]
    end if
    call world%broadcast_text(s%name)
    call world%broadcast_integers(numbers)
    call world%broadcast_reals(reals)
    if (.not. world%is_root) then
      s%medium = numbers(1)
      s%excitation = numbers(2)
      s%is_velocity = numbers(3) == 1
      s%order = numbers(4)
      s%point = reals(1:2)
      s%direction = reals(3:5)
      s%size = reals(6)
      s%size_sigma = reals(7)
      s%axis = reals(8:10)
      s%rate = reals(11)
      s%start = reals(12)
      s%trigger_sigma = reals(13)
      s%lowpass = reals(14)
      allocate (s%place(2, numbers(6)), s%values(numbers(5), numbers(6)), s%is_known(numbers(5), numbers(6)), &
                s%sigma(numbers(6)), s%base(numbers(7)))
    end if
    flat = reshape(s%place, [size(s%place)])
    call world%broadcast_reals(flat)
    s%place = reshape(flat, shape(s%place))
    flat = reshape(s%values, [size(s%values)])
    call world%broadcast_reals(flat)
    s%values = reshape(flat, shape(s%values))
    allocate (known(size(s%values)), source=0)
    if (world%is_root) known = merge(1, 0, reshape(s%is_known, [size(s%values)]))
    call world%broadcast_integers(known)
    s%is_known = reshape(known == 1, shape(s%values))
    call world%broadcast_reals(s%sigma)
    call world%broadcast_reals(s%base)
  end subroutine broadcast_one
end module measurement_series_broadcast
