! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the rows of energy spectra over time with FLUSI's file names. spectrum_tot.t, and spectrum_x.t, ..._y.t and ..._z.t for the
!> components of the velocity, have a column for each shell of wavenumbers. spectrum_k.t lists these wavenumbers.
module simulation_spectra
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use fluid_shells, only: count_shells, shell_energies, shell_width
  use fluid_solver, only: fluid_t
  use parallel_failure, only: broadcast_failure
  use parallel_world, only: world_t
  use simulation_opening, only: opening_t
  use simulation_series_table, only: moment_t, series_table_t, EVERY_INTEGRAL, TIME_COLUMN
  implicit none
  private
  public :: add_spectra, record_spectra, write_wavenumbers

  character(*), parameter :: NAMES(0:3) = ['tot', 'x  ', 'y  ', 'z  '], FILE_OF_WAVENUMBERS = 'spectrum_k.t'

contains

  !> Adds the four series, with columns if there is a `fluid`, and makes room in `now` for what `record_spectra` records.
  !> Collective.
  subroutine add_spectra(table, now, world, fluid)
    type(series_table_t), intent(inout) :: table
    type(moment_t), intent(inout) :: now
    type(world_t), intent(in) :: world
    type(fluid_t), intent(in), optional :: fluid
    character(40), allocatable :: columns(:)
    character(16) :: number
    integer :: i, n
    n = 0
    if (present(fluid)) n = count_shells(world, fluid%rhs%params%grid, fluid%transform%sticks)
    allocate (now%spectra(0:n - 1, 3), columns(0:n))
    columns(0) = TIME_COLUMN
    do i = 0, n - 1
      write (number, '(es10.3)') i*shell_width(fluid%rhs%params%grid)
      columns(i + 1) = 'E('//trim(adjustl(number))//') [L^2/T^2]'
    end do
    do i = 0, 3
      call table%add('spectrum_'//trim(NAMES(i))//'.t', columns, EVERY_INTEGRAL, spectrum_values, item=i)
    end do
    call table%add_name(FILE_OF_WAVENUMBERS)
  end subroutine add_spectra

  !> Writes the list of wavenumbers, after `opening` has opened the series without a failure. Collective.
  subroutine write_wavenumbers(opening, fluid)
    type(opening_t), intent(inout) :: opening
    type(fluid_t), intent(in) :: fluid
    character(16) :: number
    character(:), allocatable :: numbers
    type(failure_t) :: own
    integer :: i
    if (opening%failure%failed) return
    numbers = ''
    do i = 0, count_shells(opening%world, fluid%rhs%params%grid, fluid%transform%sticks) - 1
      write (number, '(es16.8)') i*shell_width(fluid%rhs%params%grid)
      numbers = numbers//number
    end do
    if (opening%world%is_root) call write_text(FILE_OF_WAVENUMBERS, '% wavenumbers [1/L] of the columns behind the time'// &
                                               new_line('a')//numbers//new_line('a'), own)
    call broadcast_failure(opening%world, own, opening%failure)
  end subroutine write_wavenumbers

  !> Computes and stores the spectra of the present state, before a step changes it; nothing if the run writes none. Collective.
  subroutine record_spectra(now, fluid)
    type(moment_t), intent(inout) :: now
    type(fluid_t), intent(in) :: fluid
    if (.not. allocated(now%spectra)) return
    call shell_energies(fluid%rhs%world, fluid%rhs%params%grid, fluid%transform%sticks, fluid%rhs%state%u, now%spectra)
  end subroutine record_spectra

  !> Returns the spectrum of all components of the velocity, or of one.
  subroutine spectrum_values(now, values)
    type(moment_t), intent(in) :: now
    real(rp), allocatable, intent(out) :: values(:)
    if (now%item == 0) then
      values = [now%fluid%sums_time, sum(now%spectra, 2)]
    else
      values = [now%fluid%sums_time, now%spectra(:, now%item)]
    end if
  end subroutine spectrum_values
end module simulation_spectra
