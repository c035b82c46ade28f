! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the natural modes of the unloaded wing, prints them, and saves them as deformed wings for viewers.
module flusi_wing_modes
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t
  use base_files, only: name_of
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use flusi_wing_output, only: put_wing, shape_grid, wing_lines_t
  use io_attributes, only: put_attribute
  use io_hdf5, only: hdf5_file_t
  use io_xdmf_series, only: xdmf_text
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_modes, only: natural_modes
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: find_modes, save_modes

  character(*), parameter :: NL = new_line('a')
  real(rp), parameter :: SHOWN = 0.1_rp !< largest movement of a saved shape, relative to the wing's size

contains

  !> Finds the frequencies(:) [Hz], lowest first, and the shapes(3, n_all, :) of small undamped vibrations about the unloaded wing
  !> at rest. The largest movement in each shape is 1, and it points to +z unless it has no component along z. Fails if the modes
  !> cannot be found.
  subroutine find_modes(s, frequencies, shapes, failure)
    type(wing_case_t), intent(in) :: s
    real(rp), intent(out) :: frequencies(:), shapes(:, :, :)
    type(failure_t), intent(out) :: failure
    type(equilibrium_t) :: work
    type(load_t) :: nothing
    real(rp), allocatable :: masses(:), rest(:, :)
    real(rp) :: largest
    integer :: i, p
    allocate (masses(s%model%n_all), rest(3, s%model%n_all))
    masses = 0
    masses(:s%model%n_points) = s%mass%nodal
    rest = 0
    call nothing%init(s%model)
    call work%init(s%model)
    call natural_modes(work, s%model, nothing, masses, rest, frequencies, shapes, failure)
    call work%free()
    if (failure%failed) return
    do i = 1, size(frequencies)
      p = maxloc(sum(shapes(:, :s%model%n_points, i)**2, 1), 1)
      largest = norm2(shapes(:, p, i))
      shapes(:, :, i) = shapes(:, :, i)/sign(largest, shapes(3, p, i))
    end do
  end subroutine find_modes

  !> Prints the frequencies and writes <name>_modes.t; if `save_shapes`, it also writes <name>_mode_NN.h5 with .xmf. Fails if a
  !> file cannot be written.
  subroutine save_modes(s, name, save_shapes, frequencies, shapes, failure)
    type(wing_case_t), intent(in) :: s
    character(*), intent(in) :: name
    logical, intent(in) :: save_shapes
    real(rp), intent(in) :: frequencies(:), shapes(:, :, :)
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: table
    character(120) :: line
    integer :: i
    write (output_unit, '(a)') 'mode  frequency [Hz]  of the unloaded wing at rest'
    table = '%       mode [-]  frequency [Hz]      tip_x [-]      tip_y [-]      tip_z [-]'
    do i = 1, size(frequencies)
      write (output_unit, '(i4,f16.4)') i, frequencies(i)
      write (line, '(es16.8,es16.8,*(es15.7))') real(i, rp), frequencies(i), shapes(:, s%tip, i)
      table = table//NL//trim(line)
    end do
    call write_text(name//'_modes.t', table, failure)
    do i = 1, size(frequencies)
      if (save_shapes .and. .not. failure%failed) &
        call write_mode(s, name, i, frequencies(i), (SHOWN*s%model%size)*shapes(:, :, i), failure)
    end do
  end subroutine save_modes

  !> Writes a mode shape as an HDF5 file with an XDMF description.
  subroutine write_mode(s, name, number, frequency, u, failure)
    type(wing_case_t), intent(in) :: s
    character(*), intent(in) :: name
    integer, intent(in) :: number
    real(rp), intent(in) :: frequency, u(:, :)
    type(failure_t), intent(inout) :: failure
    type(wing_lines_t) :: lines
    type(hdf5_file_t) :: file
    character(:), allocatable :: path
    character(8), parameter :: none(0) = [character(8) ::]
    character(12) :: text
    write (text, '(i0.2)') number
    path = name//'_mode_'//trim(text)
    call lines%init(s%wing)
    call file%create_serial(path//'.h5.part', failure)
    call put_wing(file, lines, s%wing, u, failure)
    call put_attribute(file, '/', 'schema', 'flusi-msm mode shape', failure)
    call put_attribute(file, '/', 'wing', s%path, failure)
    call put_attribute(file, '/', 'frequency', frequency, failure)
    call file%publish(path//'.h5', .false., failure)
    if (failure%failed) return
    call write_text(path//'.xmf', xdmf_text(shape_grid(lines, name_of(path)//'.h5', 'mode', none, none)), failure)
  end subroutine write_mode
end module flusi_wing_modes
