! SPDX-License-Identifier: GPL-3.0-or-later
!> Reports natural modes in a diagnosis, in a line on the terminal, a list in NAME.json and tables in NAME.h5.
module diagnose_modes
  use base_decimal, only: fixed
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_counts, only: counts_t, DATA_MODES
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_wing_rest, only: mass_effects_at
  use diagnosis_wing_parameters, only: disc_at, KIND_MASS, KIND_POINT_MASS
  use inference_engine, only: diagnosis_t
  use io_attributes, only: put_attribute
  use io_hdf5, only: hdf5_file_t
  use io_json, only: json_t
  use io_table, only: put_table
  use measurement_modes, only: MEDIUM_NAMES
  use solid_mass_effects, only: mass_effects_t
  implicit none
  private
  public :: mass_lines, print_modes, put_modes, write_mode_tables

contains

  !> Prints a line on the mode whose frequency fits worst, in units of its sd. Prints nothing without modes.
  subroutine print_modes(unit, s, d)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    character(:), allocatable :: text
    integer :: i, k
    if (.not. allocated(s%modes)) return
    associate (modes => s%measurement%modes, rows => s%modes)
      i = maxloc([(abs(rows(k)%frequency(1) - modes(k)%frequency)/modes(k)%frequency_sigma, k=1, size(rows))], 1)
      text = 'modes     the worst fit is that of '//modes(i)%name//': '//fixed(modes(i)%frequency, 1)//' +- '// &
             fixed(modes(i)%frequency_sigma, 1)//' Hz, baseline '//fixed(rows(i)%frequency(1), 1)//' Hz (MAC '// &
             fixed(rows(i)%mac(1), 3)//')'
      if (d%extended%is_found) text = text//', extended '//fixed(rows(i)%frequency(2), 1)//' Hz (MAC '// &
                                      fixed(rows(i)%mac(2), 3)//')'
      write (unit, '(a)') text
    end associate
  end subroutine print_modes

  !> Adds the list `sets` of the natural modes to the open object of the JSON file.
  subroutine put_modes(json, s, counts, d)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(counts_t), intent(in) :: counts
    type(diagnosis_t), intent(in) :: d
    integer :: i
    if (.not. allocated(s%modes)) return
    call json%open_list('sets')
    do i = 1, size(s%modes)
      associate (mode => s%measurement%modes(i), row => s%modes(i))
        call json%open_object('')
        call counts%put(json, mode%name, counts%first(DATA_MODES) + i - 1, 1)
        call json%put('medium', trim(MEDIUM_NAMES(mode%medium)))
        if (mode%is_loaded()) call json%put('is_loaded', .true.)
        call json%put('frequency_hz', mode%frequency)
        call json%put('sd_hz', mode%frequency_sigma)
        if (mode%damping >= 0) then
          call json%put('damping_ratio', mode%damping)
          call json%put('damping_sd', mode%damping_sigma)
          call json%put('baseline_damping_ratio', row%damping(1))
          if (d%extended%is_found) call json%put('extended_damping_ratio', row%damping(2))
        end if
        call json%put('baseline_number', row%number(1))
        call json%put('baseline_hz', row%frequency(1))
        call json%put('baseline_mac', row%mac(1))
        if (d%extended%is_found) then
          call json%put('extended_number', row%number(2))
          call json%put('extended_hz', row%frequency(2))
          call json%put('extended_mac', row%mac(2))
        end if
        call json%close()
      end associate
    end do
    call json%close()
  end subroutine put_modes

  !> Returns the text of the section [Mass] of a wing at the coordinates q. It is empty if neither modes nor
  !> records of motion nor flights show the mass.
  function mass_lines(s, q) result(text)
    type(diagnose_settings_t), intent(in) :: s
    real(rp), intent(in) :: q(:)
    character(:), allocatable :: text
    character(*), parameter :: NL = new_line('a')
    type(mass_effects_t) :: effects
    real(rp) :: point(3)
    integer :: i
    text = ''
    if (.not. (s%measurement%moves() .or. any(s%catalogue%parameters%kind == KIND_MASS))) return
    effects = mass_effects_at(s%experiment, s%catalogue%parameters, q)
    point = s%wing_case%material%point
    do i = 1, size(q)
      if (s%catalogue%parameters(i)%kind /= KIND_POINT_MASS .or. .not. abs(q(i)) > 0) cycle
      point = disc_at(s%catalogue%parameters, i, q)
      point(3) = q(i)
    end do
    associate (m => s%wing_case%material)
      text = NL//'[Mass]'//NL//'vein_factor = '//number_text(m%vein_factor*effects%veins)//';'//NL//'membrane_factor = '// &
             number_text(m%membrane_factor*effects%membrane)//';'//NL//'membrane_gradient = '// &
             number_text(m%gradient + effects%gradient)//';'//NL
    end associate
    if (abs(point(3)) > 0) text = text//'point_mass = '//number_text(point(1))//' '//number_text(point(2))//' '// &
                                  number_text(point(3))//'; m, m, kg'//NL
    if (s%measurement%is_in_air()) text = text//'; the mass of the air that moves with the wing is '// &
      number_text(effects%added)//' of that of strip theory'//NL
  end function mass_lines

  !> Writes the group `modes` of the HDF5 file.
  subroutine write_mode_tables(file, s, failure)
    type(hdf5_file_t), intent(in) :: file
    type(diagnose_settings_t), intent(in) :: s
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: table(:, :)
    character(:), allocatable :: name
    integer :: i, k
    if (.not. allocated(s%modes)) return
    call file%make_group('/modes', failure)
    do i = 1, size(s%modes)
      associate (mode => s%measurement%modes(i), row => s%modes(i))
        name = '/modes/'//mode%name
        allocate (table(6, size(mode%shape)))
        do k = 1, size(mode%shape)
          table(:, k) = [mode%place(:, k), mode%shape(k), mode%sigma(k), row%shape(k, :)]
        end do
        if (size(table) == 0) call file%make_group(name, failure)
        call put_table(file, name, table, 'x y measured sigma baseline extended', failure)
        call put_attribute(file, name, 'frequency', mode%frequency, failure)
        call put_attribute(file, name, 'frequency_sigma', mode%frequency_sigma, failure)
        call put_attribute(file, name, 'medium', trim(MEDIUM_NAMES(mode%medium)), failure)
        call put_attribute(file, name, 'computed', row%frequency, failure)
        call put_attribute(file, name, 'mac', row%mac, failure)
        deallocate (table)
      end associate
    end do
  end subroutine write_mode_tables
end module diagnose_modes
