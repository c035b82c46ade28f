! SPDX-License-Identifier: GPL-3.0-or-later
!> Reports records of a vibrating wing in a diagnosis, in a list in NAME.json and tables in NAME.h5. It also returns the damping
!> that flusi should use for the wing.
module diagnose_series
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_counts, only: counts_t, DATA_SERIES
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_wing_rest, only: damping_at
  use inference_engine, only: diagnosis_t
  use io_attributes, only: put_attribute
  use io_hdf5, only: hdf5_file_t
  use io_json, only: json_t
  use io_table, only: put_table
  use measurement_modes, only: MEDIUM_NAMES
  use solid_damping_effects, only: damping_effects_t
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  implicit none
  private
  public :: damping_lines, put_series, write_series_tables

contains

  !> Adds the list `sets` of the records to the open object of the JSON file.
  subroutine put_series(json, s, counts, d)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(counts_t), intent(in) :: counts
    type(diagnosis_t), intent(in) :: d
    integer :: i, at
    if (.not. allocated(s%series)) return
    call json%open_list('sets')
    at = counts%first(DATA_SERIES)
    do i = 1, size(s%series)
      associate (record => s%measurement%series(i), row => s%series(i))
        call json%open_object('')
        call counts%put(json, record%name, at, size(record%sigma))
        at = at + size(record%sigma)
        call json%put('medium', trim(MEDIUM_NAMES(record%medium)))
        call json%put('units', trim(merge('m/s', 'm  ', record%is_velocity)))
        call json%put('baseline_rms', row%rms(1))
        call json%put('baseline_size_error', row%size_error(1))
        call json%put('baseline_late_s', row%late(1))
        if (d%extended%is_found) then
          call json%put('extended_rms', row%rms(2))
          call json%put('extended_size_error', row%size_error(2))
          call json%put('extended_late_s', row%late(2))
        end if
        call json%close()
      end associate
    end do
    call json%close()
  end subroutine put_series

  !> Writes the group `series` of the HDF5 file, with a table RECORD/NUMBER for each trace.
  subroutine write_series_tables(file, s, failure)
    type(hdf5_file_t), intent(in) :: file
    type(diagnose_settings_t), intent(in) :: s
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: table(:, :)
    character(:), allocatable :: name
    integer :: i, j, k
    if (.not. allocated(s%series)) return
    call file%make_group('/series', failure)
    do i = 1, size(s%series)
      associate (record => s%measurement%series(i), row => s%series(i))
        if (.not. allocated(row%seen)) cycle
        call file%make_group('/series/'//record%name, failure)
        allocate (table(5, size(record%values, 1)))
        do j = 1, size(record%values, 2)
          do k = 1, size(record%values, 1)
            table(:, k) = [record%start + (k - 1)/record%rate, record%values(k, j), record%sigma(j), row%seen(k, j, :)]
            if (.not. record%is_known(k, j)) table(2, k) = ieee_value(0.0_rp, ieee_quiet_nan)
          end do
          name = '/series/'//record%name//'/'//number_text(j)
          call put_table(file, name, table, 'time measured sigma baseline extended', failure)
          call put_attribute(file, name, 'point', record%place(:, j), failure)
        end do
        call put_attribute(file, '/series/'//record%name, 'units', trim(merge('m/s', 'm  ', record%is_velocity)), failure)
        call put_attribute(file, '/series/'//record%name, 'rms', row%rms, failure)
        deallocate (table)
      end associate
    end do
  end subroutine write_series_tables

  !> Returns the text of the section [Damping] of a wing at the coordinates q. It is empty without data that show damping.
  function damping_lines(s, q) result(text)
    type(diagnose_settings_t), intent(in) :: s
    real(rp), intent(in) :: q(:)
    character(:), allocatable :: text
    character(*), parameter :: NL = new_line('a')
    type(damping_effects_t) :: damping
    text = ''
    if (.not. s%measurement%shows_damping()) return
    damping = damping_at(s%catalogue%parameters, q)
    text = NL//'[Damping]'//NL//'rayleigh_mass = '//number_text(damping%mass)//'; 1/s, still air among it'//NL
    if (abs(damping%stiffness) > 0) text = text//'rayleigh_stiffness = '//number_text(damping%stiffness)//'; s'//NL
    if (abs(damping%joints) > 0) &
      text = text//'joint_friction = '//number_text(damping%joints)//'; s'//NL
    if (abs(damping%drag) > 0) text = text//'drag = '//number_text(damping%drag)//'; kg/m^3, of still air'//NL
    if (abs(damping%relaxation) > 0) &
      text = text//'relaxation = '//number_text(damping%relaxation)//';'//NL//'relaxation_time = '// &
             number_text(damping%relaxation_time)//'; s'//NL
  end function damping_lines
end module diagnose_series
