! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes what a report of a training needs in addition to its outcome: the path of least squares, the profiles behind the
!> intervals, scalar readings, and how well each load is fitted. They are parts of NAME_history.h5; tools/plot_training draws
!> them.
module train_details
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use io_attributes, only: put_attribute
  use io_hdf5, only: hdf5_file_t
  use io_table, only: put_table
  use least_squares_profile, only: interval_t
  use measurement_data, only: QUANTITY_ROTATION
  use train_settings, only: train_settings_t
  use training_intervals, only: left_out_names
  use training_outcome, only: trained_t
  use training_space, only: search_space_t
  implicit none
  private
  public :: write_details

contains

  !> Writes /outcome/path, /profiles and /readings if the training has them, and adds attributes to /outcome and /loads, which
  !> must exist. Only the process that has opened the file calls it.
  subroutine write_details(file, settings, space, trained, failure)
    type(hdf5_file_t), intent(in) :: file
    type(train_settings_t), intent(in) :: settings
    type(search_space_t), intent(in) :: space
    type(trained_t), intent(in) :: trained
    type(failure_t), intent(inout) :: failure
    integer :: i, l
    call put_attribute(file, '/outcome', 'residuals', settings%experiment%count_residuals(0), failure)
    call put_attribute(file, '/outcome', 'evaluations_behind_the_search', trained%n_evaluations, failure)
    call put_attribute(file, '/outcome', 'is_polished', merge(1, 0, trained%is_polished), failure)
    if (allocated(trained%reason)) call put_attribute(file, '/outcome', 'polish_ended', trained%reason, failure)
    if (allocated(trained%path)) then
      call put_table(file, '/outcome/path', trained%path, 'evaluations chi2 prior_chi2 stage_errors', failure)
    end if
    if (allocated(trained%local_minima)) call write_local_minima(file, space, trained%local_minima, failure)
    if (trained%has_intervals) then
      call file%make_group('/profiles', failure)
      do i = 1, size(trained%intervals)
        call write_profile(file, '/profiles/'//trim(space%names(i)), trained%intervals(i), space%is_log(i), &
                           left_out_names(settings%experiment, trained, i), failure)
      end do
    end if
    do l = 1, size(trained%evaluations)
      call describe_load(file, settings, trained, l, failure)
    end do
    call write_readings(file, settings, trained, failure)
  end subroutine write_details

  !> Writes a row for each start of the polish: chi^2 and the values, in their units, where it ended.
  subroutine write_local_minima(file, space, local_minima, failure)
    type(hdf5_file_t), intent(in) :: file
    type(search_space_t), intent(in) :: space
    real(rp), intent(in) :: local_minima(:, :)
    type(failure_t), intent(inout) :: failure
    real(rp) :: rows(size(local_minima, 1), size(local_minima, 2))
    integer :: i
    rows = local_minima
    do i = 1, size(space%is_log)
      if (space%is_log(i)) rows(1 + i, :) = exp(local_minima(1 + i, :))
    end do
    call put_table(file, '/outcome/ends', rows, 'chi2, then the values', failure)
  end subroutine write_local_minima

  !> Writes a profile. Each row holds a tried value, in its unit, and the sum of squares minus its minimum. The values ascend.
  subroutine write_profile(file, name, interval, is_log, left_out, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    character(*), intent(in) :: left_out !< names of the loads that the interval leaves out
    type(interval_t), intent(in) :: interval
    logical, intent(in) :: is_log
    type(failure_t), intent(inout) :: failure
    real(rp) :: rows(2, size(interval%profile, 2))
    logical :: is_taken(size(interval%profile, 2))
    integer :: i, k
    is_taken = .false.
    do i = 1, size(rows, 2)
      k = minloc(interval%profile(1, :), 1, mask=.not. is_taken)
      is_taken(k) = .true.
      rows(:, i) = interval%profile(:, k)
      if (is_log) rows(1, i) = exp(rows(1, i))
    end do
    call put_table(file, name, rows, 'value chi2_above_minimum', failure)
    if (size(rows) == 0) return
    call put_attribute(file, name, 'is_complete', merge(1, 0, interval%is_complete), failure)
    call put_attribute(file, name, 'is_jump', merge([1, 1], [0, 0], interval%is_jump), failure)
    if (left_out /= '') call put_attribute(file, name, 'left_out', left_out, failure)
  end subroutine write_profile

  !> Writes attributes of a load with heights: what the load was, and how well the model fits it.
  subroutine describe_load(file, settings, trained, l, failure)
    type(hdf5_file_t), intent(in) :: file
    type(train_settings_t), intent(in) :: settings
    type(trained_t), intent(in) :: trained
    integer, intent(in) :: l
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: name
    associate (comparison => settings%experiment%comparisons(l), load => settings%experiment%measurement%loads(l), &
               evaluation => trained%evaluations(l))
      if (comparison%n_heights == 0) return
      name = '/loads/'//load%name
      call put_attribute(file, name, 'direction', load%direction, failure)
      call put_attribute(file, name, 'order', load%order, failure)
      call put_attribute(file, name, 'replicate', load%replicate, failure)
      call put_attribute(file, name, 'is_solved', merge(1, 0, evaluation%is_solved), failure)
      call put_attribute(file, name, 'violation', evaluation%violation, failure)
      call put_attribute(file, name, 'snaps', evaluation%snaps, failure)
      associate (n => comparison%n_heights)
        call put_attribute(file, name, 'chi2', sum((evaluation%residuals(:n)/comparison%sigma(:n))**2), failure)
      end associate
    end associate
  end subroutine describe_load

  !> Writes a row for each scalar reading: the number of its load, the measured and the computed value, the sd, and 1 if it is a
  !> rotation. The names of the observations are written too.
  subroutine write_readings(file, settings, trained, failure)
    type(hdf5_file_t), intent(in) :: file
    type(train_settings_t), intent(in) :: settings
    type(trained_t), intent(in) :: trained
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: rows(:, :)
    character(:), allocatable :: names, loads
    integer :: i, k, seen(size(settings%experiment%comparisons))
    associate (e => settings%experiment, m => settings%experiment%measurement)
      if (size(m%observations) == 0) return
      allocate (rows(5, size(m%observations)))
      seen = 0
      names = ''
      do i = 1, size(m%observations)
        associate (one => m%observations(i), comparison => e%comparisons(m%observations(i)%load))
          seen(one%load) = seen(one%load) + 1
          k = comparison%n_heights + seen(one%load)
          rows(:, i) = [real(one%load, rp), comparison%measured(k), &
                        comparison%measured(k) + trained%evaluations(one%load)%residuals(k), comparison%sigma(k), &
                        merge(1.0_rp, 0.0_rp, one%quantity == QUANTITY_ROTATION)]
          names = names//' '//one%name
        end associate
      end do
      loads = ''
      do i = 1, size(m%loads)
        loads = loads//' '//m%loads(i)%name
      end do
      call put_table(file, '/readings', rows, 'load measured computed sd is_rotation', failure)
      call put_attribute(file, '/readings', 'names', names(2:), failure)
      call put_attribute(file, '/readings', 'loads', loads(2:), failure)
    end associate
  end subroutine write_readings
end module train_details
