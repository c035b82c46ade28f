! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes energy spectra over time with FLUSI's file names. spectrum_tot.t, and spectrum_x.t, ..._y.t and ..._z.t for the
!> components of the velocity, have a column for each shell of wavenumbers. spectrum_k.t lists these wavenumbers.
module simulation_spectra
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use fluid_shells, only: count_shells, shell_energies, shell_width
  use fluid_solver, only: fluid_t
  use io_series, only: series_t
  use parallel_failure, only: broadcast_failure
  use simulation_opening, only: opening_t
  implicit none
  private
  public :: spectra_t

  character(*), parameter :: NAMES(4) = ['tot', 'x  ', 'y  ', 'z  ']

  !> Writes the spectra. Call `record` before a step and `write` after it.
  type :: spectra_t
    private
    type(series_t) :: series(size(NAMES))
    real(rp), allocatable :: energies(:, :) !< (0:shells-1, 3) of the last `record`, L^2/T^2; not allocated: no spectra
  contains
    procedure :: open => spectra_open
    procedure :: record => spectra_record
    procedure :: write => spectra_write
    procedure :: close => spectra_close
  end type spectra_t

contains

  !> Opens all files through `opening`. Without `fluid`, nothing can be written. Without this call, the other calls do nothing.
  !> Collective.
  subroutine spectra_open(self, opening, fluid)
    class(spectra_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    type(fluid_t), intent(in), optional :: fluid
    character(40), allocatable :: columns(:)
    character(16) :: number
    character(:), allocatable :: numbers
    real(rp) :: width
    integer :: i, n
    type(failure_t) :: own
    n = 0
    if (present(fluid)) then
      width = shell_width(fluid%rhs%params%grid)
      n = count_shells(opening%world, fluid%rhs%params%grid, fluid%transform%sticks)
    end if
    allocate (self%energies(0:n - 1, 3), columns(0:n))
    columns(0) = 'time [T]'
    numbers = ''
    do i = 0, n - 1
      write (number, '(es16.8)') i*width
      numbers = numbers//number
      write (number, '(es10.3)') i*width
      columns(i + 1) = 'E('//trim(adjustl(number))//') [L^2/T^2]'
    end do
    do i = 1, size(NAMES)
      call opening%open(self%series(i), 'spectrum_'//trim(NAMES(i))//'.t', columns)
    end do
    call opening%list('spectrum_k.t')
    if (opening%failure%failed .or. opening%is_listing) return
    if (opening%world%is_root) call write_text('spectrum_k.t', '% wavenumbers [1/L] of the columns behind the time'// &
                                               new_line('a')//numbers//new_line('a'), own)
    call broadcast_failure(opening%world, own, opening%failure)
  end subroutine spectra_open

  !> Computes and stores the spectra of the present state, before a step changes it. Collective.
  subroutine spectra_record(self, fluid)
    class(spectra_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    if (.not. allocated(self%energies)) return
    call shell_energies(fluid%rhs%world, fluid%rhs%params%grid, fluid%transform%sticks, fluid%rhs%state%u, self%energies)
  end subroutine spectra_record

  !> Writes the spectra that the last `record` computed, which was at `time` [T]. `close` reports a failure.
  subroutine spectra_write(self, time)
    class(spectra_t), intent(inout) :: self
    real(rp), intent(in) :: time
    integer :: c
    if (.not. allocated(self%energies)) return
    call self%series(1)%write([time, sum(self%energies, 2)])
    do c = 1, 3
      call self%series(1 + c)%write([time, self%energies(:, c)])
    end do
  end subroutine spectra_write

  !> Closes all files. Fails if any of them could not be written completely. Collective.
  subroutine spectra_close(self, failure)
    class(spectra_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    integer :: i
    if (.not. allocated(self%energies)) return
    do i = 1, size(self%series)
      call self%series(i)%close(failure)
    end do
  end subroutine spectra_close
end module simulation_spectra
