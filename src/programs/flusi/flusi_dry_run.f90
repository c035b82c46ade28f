! SPDX-License-Identifier: GPL-3.0-or-later
!> Reports what a run would need and write, without running it.
module flusi_dry_run
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_kinds, only: rp
  use parallel_world, only: world_t
  use simulation_memory, only: memory_t, estimate_memory
  use simulation_opening, only: opening_t
  use simulation_plans, only: expected_steps
  use simulation_report, only: print_scales
  use simulation_series, only: run_series_t
  use simulation_settings, only: settings_t
  implicit none
  private
  public :: print_dry_run

contains

  !> Prints the memory per rank for this and other numbers of ranks, the estimated length and number of the time steps, and the
  !> files that the run would write. Writes no file. Only root prints, and no rank waits for another.
  subroutine print_dry_run(world, settings)
    type(world_t), intent(in) :: world
    type(settings_t), intent(in) :: settings
    real(rp) :: speed, dt, steps
    integer :: ranks, i
    if (.not. world%is_root) return
    associate (p => settings%fluid, o => settings%output, unit => output_unit)
      write (unit, '(a,3(i0,a))') 'grid      ', p%grid%n(1), ' x ', p%grid%n(2), ' x ', p%grid%n(3), ''
      call print_scales(unit, settings)
      write (unit, '(a)') 'memory per rank                     while running      at the start'
      call print_memory(unit, world%size, settings)
      ranks = 1
      do i = 1, 14
        if (ranks /= world%size) call print_memory(unit, ranks, settings)
        ranks = 2*ranks
      end do
      call expected_steps(settings, dt, speed, steps)
      write (unit, '(a,es9.2,a,g0.4,a)') 'time step about', dt, ' (velocity scale ', speed, '; the flow decides)'
      if (p%time%t_max < 1.0e8_rp .or. p%time%nt < 900000000) write (unit, '(a,i0)') 'steps     about ', &
        ceiling(min(steps, 2.0e9_rp))
      call print_files(unit, settings, min(p%time%t_max, p%time%nt*dt))
    end associate
    flush (output_unit)
  end subroutine print_dry_run

  !> Prints the memory of each rank if the grid is shared among `ranks` ranks; prints nothing if it cannot be shared.
  subroutine print_memory(unit, ranks, settings)
    integer, intent(in) :: unit, ranks
    type(settings_t), intent(in) :: settings
    type(memory_t) :: m
    m = estimate_memory(settings, ranks)
    if (.not. m%possible) return
    if (m%largest_buffer > huge(1)) then
      write (unit, '(i8,a)') ranks, ' ranks: too few for this grid'
    else
      write (unit, '(i8,a,i0,a,i0,t30,2(f14.1,a))') ranks, ' ranks = ', m%rows, ' x ', m%columns, m%running/1.0e6_rp, &
        ' MB', m%starting/1.0e6_rp, ' MB'
    end if
  end subroutine print_memory

  !> Prints which files the run would write, and how large they would be.
  subroutine print_files(unit, settings, t_end)
    integer, intent(in) :: unit
    type(settings_t), intent(in) :: settings
    real(rp), intent(in) :: t_end
    character(:), allocatable :: prefixes
    real(rp) :: times, bytes
    integer :: n
    associate (o => settings%output, p => settings%fluid)
      prefixes = ''
      n = 0
      if (o%fields%velocity) call add('ux uy uz', 3)
      if (o%fields%vorticity) call add('vorx vory vorz', 3)
      if (o%fields%vorticity_magnitude) call add('vorabs', 1)
      if (o%fields%q_criterion) call add('Q', 1)
      if (o%fields%pressure) call add('p', 1)
      if (o%fields%mask) call add('mask', 1)
      if (o%fields%solid_velocity) call add('usx usy usz', 3)
      if (o%averages%is_on .and. o%averages%velocity) call add('uavgx uavgy uavgz', 3)
      if (o%averages%is_on .and. o%averages%kinetic_energy) call add('ekinavg', 1)
      if (o%averages%is_on .and. o%averages%enstrophy) call add('zavg', 1)
      write (unit, '(a)') 'files that would be written'
      call print_series(unit, settings)
      if (p%solids%is_moving) write (unit, '(a)') '  at the end summary.txt'
      if (p%solids%is_moving) write (unit, '(a)') '  surfaces '//of_sides(settings, 'wing')
      if (n > 0) then
        ! Fields are saved at the start, at each multiple of the interval, and at the end.
        times = ceiling(min(1.0e9_rp, max(0.0_rp, t_end - max(o%fields%first, 0.0_rp))/o%fields%interval - 1.0e-9_rp)) + 1
        bytes = n*times*product(real(p%grid%n, rp)/o%fields%stride)*merge(4, 8, o%fields%single_precision)
        write (unit, '(a,i0,a,f0.2,a)') '  fields    '//prefixes//' at about ', nint(min(times, 1.0e9_rp)), ' times: ', &
          bytes/1.0e9_rp, ' GB, and one .xmf index'
      end if
      if (o%slices%is_on) write (unit, '(a)') '  slices    sliceu1 sliceu2 sliceu3'// &
        trim(merge(' slice_times.t', '              ', o%slices%stack > 1))
      if (o%backup) write (unit, '(a)') '  backups   runtime_backup0.h5 runtime_backup1.h5'
    end associate

  contains

    subroutine add(names, count)
      character(*), intent(in) :: names
      integer, intent(in) :: count
      prefixes = trim(prefixes//' '//names)
      n = n + count
    end subroutine add
  end subroutine print_files

  !> Prints the names of all series, as many in each line as possible.
  subroutine print_series(unit, settings)
    integer, intent(in) :: unit
    type(settings_t), intent(in) :: settings
    integer, parameter :: WIDTH = 80
    type(opening_t) :: opening
    type(run_series_t) :: series
    character(:), allocatable :: line
    integer :: i
    opening%is_listing = .true.
    call series%open(opening, settings)
    line = '  series   '
    do i = 1, opening%series%count()
      if (len(line) + 1 + len(opening%series%text(i)) > WIDTH) then
        write (unit, '(a)') line
        line = repeat(' ', 11)
      end if
      line = line//' '//opening%series%text(i)
    end do
    write (unit, '(a)') line
  end subroutine print_series

  !> Returns the names of these files for all wings, with a blank before each name.
  function of_sides(settings, name) result(names)
    type(settings_t), intent(in) :: settings
    character(*), intent(in) :: name
    character(:), allocatable :: names
    integer :: i
    names = ''
    do i = 1, size(settings%flight%wings)
      names = names//' '//name//'_'//trim(settings%flight%wings(i)%side)
    end do
  end function of_sides
end module flusi_dry_run
