! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves and loads the fluid's part of a checkpoint: exactly `fluid_state_t`, in double precision, independent of the number of
!> ranks.
module fluid_restart
  use base_errors, only: failure_t
  use base_kinds, only: rp, i8
  use base_memory, only: check_allocation, REAL_BYTES
  use base_named_kinds, only: kind_of, word_of
  use fluid_params, only: fluid_params_t, SCHEME_AB2
  use fluid_state, only: fluid_state_t
  use io_checkpoint, only: checkpoint_writer_t, checkpoint_reader_t
  use io_checkpoint_values, only: checkpoint_loader_t, checkpoint_saver_t
  use spectral_sticks, only: sticks_t, TRUNCATIONS
  implicit none
  private
  public :: save_fluid, load_fluid

  character(*), parameter :: AXES = 'xyz'

contains

  !> Puts the state into an open checkpoint. Collective.
  subroutine save_fluid(writer, params, sticks, state)
    type(checkpoint_writer_t), intent(inout), target :: writer
    type(fluid_params_t), intent(in) :: params
    type(sticks_t), intent(in) :: sticks
    type(fluid_state_t), intent(inout) :: state !< stays as it is
    type(checkpoint_saver_t) :: saver
    integer :: c
    call writer%put_reals('grid', real(params%grid%n, rp))
    call writer%put_reals('length', params%grid%length)
    call writer%put_text('dealias', word_of(TRUNCATIONS, params%resolution%dealias))
    call writer%put_integer('scheme', int(params%time%scheme, i8))
    call saver%begin(writer, '')
    call state%visit(saver)
    do c = 1, 3
      call writer%put_rows('u'//AXES(c:c), as_reals(state%u(:, :, c)), sticks%rows)
      if (params%time%scheme == SCHEME_AB2) &
        call writer%put_rows('history_'//AXES(c:c), as_reals(state%history(:, :, c)), sticks%rows)
    end do
  end subroutine save_fluid

  !> Restores the state from an open checkpoint. Fails, naming the difference, if it belongs to another
  !> grid, box, truncation or scheme. Collective.
  subroutine load_fluid(reader, params, sticks, state, failure)
    type(checkpoint_reader_t), intent(inout), target :: reader
    type(fluid_params_t), intent(in) :: params
    type(sticks_t), intent(in) :: sticks
    type(fluid_state_t), intent(inout) :: state
    type(failure_t), intent(inout) :: failure
    type(checkpoint_loader_t) :: loader
    real(rp), allocatable :: numbers(:), rows(:, :)
    character(:), allocatable :: text
    integer(i8) :: number
    integer :: c, status
    call reader%get_reals('grid', numbers, failure)
    if (failure%failed) return
    if (any(nint(numbers) /= params%grid%n)) then
      call failure%raise('the checkpoint has another grid, '//three_integers(nint(numbers))//' instead of '// &
                         three_integers(params%grid%n)//': set nx, ny and nz of [Resolution] as in the run that wrote it')
      return
    end if
    call reader%get_reals('length', numbers, failure)
    if (.not. failure%failed) then
      if (any(abs(numbers - params%grid%length) > 1.0e-12_rp*params%grid%length)) &
        call failure%raise('the checkpoint has another box: set xl, yl and zl of [Geometry] as in the run that wrote it')
    end if
    call reader%get_text('dealias', text, failure)
    if (.not. failure%failed) then
      if (kind_of(TRUNCATIONS, text) /= params%resolution%dealias) &
        call failure%raise('the checkpoint has another truncation, '//text//': set [Dealiasing] as in the run that wrote it')
    end if
    call reader%get_integer('scheme', number, failure)
    if (.not. failure%failed .and. number /= params%time%scheme) &
      call failure%raise('the checkpoint was made with another time stepper: '// &
                         'set [Time] iTimeMethodFluid as in the run that wrote it')
    if (failure%failed) return
    call loader%begin(reader, '')
    call state%visit(loader)
    if (loader%failure%failed) call failure%raise(loader%failure%reason)
    allocate (rows(2*sticks%nkz, sticks%n), stat=status)
    call check_allocation(status, [2*sticks%nkz, sticks%n], REAL_BYTES, 'what is read of the checkpoint')
    do c = 1, 3
      call reader%get_rows('u'//AXES(c:c), rows, sticks%rows, failure)
      if (failure%failed) return
      state%u(:, :, c) = as_complex(rows)
      if (params%time%scheme /= SCHEME_AB2) cycle
      call reader%get_rows('history_'//AXES(c:c), rows, sticks%rows, failure)
      if (failure%failed) return
      state%history(:, :, c) = as_complex(rows)
    end do
  end subroutine load_fluid

  !> Converts complex (nkz, n) into real (2 nkz, n) numbers: real and imaginary parts alternate.
  pure function as_reals(z) result(x)
    complex(rp), intent(in) :: z(:, :)
    real(rp) :: x(2*size(z, 1), size(z, 2))
    x(1::2, :) = real(z)
    x(2::2, :) = aimag(z)
  end function as_reals

  !> Returns complex numbers whose real and imaginary parts alternate in `x`.
  pure function as_complex(x) result(z)
    real(rp), intent(in) :: x(:, :)
    complex(rp) :: z(size(x, 1)/2, size(x, 2))
    z = cmplx(x(1::2, :), x(2::2, :), rp)
  end function as_complex

  !> Returns three integers, separated by ' x '.
  function three_integers(n) result(text)
    integer, intent(in) :: n(3)
    character(:), allocatable :: text
    character(40) :: buffer
    write (buffer, '(i0,2(a,i0))') n(1), ' x ', n(2), ' x ', n(3)
    text = trim(buffer)
  end function three_integers
end module fluid_restart
