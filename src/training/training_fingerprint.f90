! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the number by which a checkpoint recognises its training.
module training_fingerprint
  use base_checksum, only: checksum_add, checksum_reals, checksum_text
  use base_fingerprint, only: fingerprint_t
  use base_kinds, only: i8, rp
  use base_text, only: number_text
  use solid_effect_sites, only: effect_site_lines
  use solid_restart, only: points_fingerprint
  use training_case, only: training_case_t
  implicit none
  private
  public :: fingerprint_of

contains

  !> Returns the number for everything that determines the search, but not how long it runs. The settings stay as they are.
  integer(i8) function fingerprint_of(settings) result(fingerprint)
    class(training_case_t), intent(inout) :: settings
    type(fingerprint_t) :: entries
    integer :: i, l
    call settings%visit(entries)
    associate (e => settings%experiment, params => settings%experiment%model%params)
      call entries%visit('measurement', e%measurement)
      call omit_from_measurement(entries, size(e%measurement%loads), size(e%measurement%observations))
      call entries%visit('params', params)
      fingerprint = checksum_add(entries%rest(), points_fingerprint(e%model))
      fingerprint = checksum_add(fingerprint, checksum_text(effect_site_lines(params%effects)))
      call add([(params%get(i), i=params%count_basic() + 1, params%count())], 1000000_i8)
      call add(e%instrument%values, 2000000_i8)
      do l = 1, size(e%comparisons)
        call add([e%comparisons(l)%measured, e%comparisons(l)%sigma], l*10000000_i8)
      end do
    end associate

  contains

    subroutine add(numbers, first)
      real(rp), intent(in) :: numbers(:)
      integer(i8), intent(in) :: first
      fingerprint = checksum_add(fingerprint, checksum_reals(numbers, first))
    end subroutine add
  end function fingerprint_of

  !> Omits the components of a measurement on which a search under loads does not depend: names, and records that it does not
  !> compare. It also omits raw data: the fingerprint contains the values that the search compares, and their sd.
  subroutine omit_from_measurement(entries, n_loads, n_observations)
    type(fingerprint_t), intent(inout) :: entries
    integer, intent(in) :: n_loads, n_observations
    character(*), parameter :: PARTS(5) = [character(24) :: 'measurement_modes', 'measurement_series', 'measurement_flights', &
                                           'measurement_accuracy', 'measurement_calibration']
    character(*), parameter :: VALUES(5) = [character(30) :: 'measurement_has_unloaded', 'measurement_unloaded', &
                                            'measurement_unloaded_sigma', 'measurement_air_density', &
                                            'measurement_series_air_density']
    character(:), allocatable :: load, observation
    integer :: i
    do i = 1, size(PARTS)
      call entries%omit_part(trim(PARTS(i)))
      call entries%omit(trim(VALUES(i)))
    end do
    call entries%omit_part('measurement_zeros')
    call entries%omit('measurement_is_plan')
    do i = 1, n_loads
      load = 'measurement_loads_'//number_text(i)//'_'
      call entries%omit(load//'name')
      call entries%omit(load//'replicate')
      call entries%omit(load//'has_surface')
      call entries%omit(load//'node')
      call entries%omit(load//'height')
      call entries%omit(load//'sigma')
    end do
    do i = 1, n_observations
      observation = 'measurement_observations_'//number_text(i)//'_'
      call entries%omit(observation//'name')
      call entries%omit(observation//'value')
      call entries%omit(observation//'sigma')
    end do
  end subroutine omit_from_measurement
end module training_fingerprint
