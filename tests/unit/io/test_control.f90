! SPDX-License-Identifier: GPL-3.0-or-later
!> Requests through files and signals are seen once.
program test_control
  use base_errors, only: message_list_t
  use base_files, only: file_exists, remove_file
  use base_signals, only: catch_signals, signal_caught
  use io_control, only: CONTROL_NOTHING, CONTROL_SAVE_STOP, prepare_control, poll_control
  use testkit, only: testkit_t
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  interface
    integer(c_int) function c_raise(number) bind(C, name='raise')
      import :: c_int
      integer(c_int), value :: number
    end function c_raise
  end interface
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_stop_file()
  call test_control_file()
  call test_signals()
  call t%finish()

contains

  subroutine write_file(path, text)
    character(*), intent(in) :: path, text
    integer :: unit
    open (newunit=unit, file=path, status='replace')
    write (unit, '(a)') text
    close (unit)
  end subroutine write_file

  subroutine test_stop_file()
    type(message_list_t) :: messages
    call remove_file('STOP')
    call remove_file('runtime_control.ini')
    call t%check('no file asks for nothing', poll_control('.', messages) == CONTROL_NOTHING)
    call write_file('STOP', '')
    call t%check('a file STOP asks to save and stop', poll_control('.', messages) == CONTROL_SAVE_STOP)
    call t%check('and is removed',.not. file_exists('STOP'))
    call t%check('so that it asks once', poll_control('.', messages) == CONTROL_NOTHING)
    call t%check('no messages', messages%count() == 0)
  end subroutine test_stop_file

  subroutine test_control_file()
    type(message_list_t) :: messages, folder
    call prepare_control('.', messages)
    call t%check('the prepared file asks for nothing', file_exists('runtime_control.ini') .and. &
                 poll_control('.', messages) == CONTROL_NOTHING)
    call write_file('runtime_control.ini', '; comment'//new_line('a')//'[other]'//new_line('a')// &
                    'runtime_control=save_stop;'//new_line('a')//'[runtime_control]'//new_line('a')// &
                    'runtime_control=nothing;')
    call t%check('other sections do not count', poll_control('.', messages) == CONTROL_NOTHING)
    call write_file('runtime_control.ini', &
                    '[runtime_control]'//new_line('a')//' runtime_control = save_stop ; now')
    call t%check('save_stop asks to save and stop', poll_control('.', messages) == CONTROL_SAVE_STOP)
    call t%check('once', poll_control('.', messages) == CONTROL_NOTHING .and. messages%count() == 0)
    call write_file('runtime_control.ini', &
                    '[runtime_control]'//new_line('a')//'runtime_control=reload_params;')
    call t%check('reload_params does nothing', poll_control('.', messages) == CONTROL_NOTHING)
    call t%check('but is refused with a message', messages%count() == 1)
    call t%check('once', poll_control('.', messages) == CONTROL_NOTHING .and. messages%count() == 1)
    call write_file('runtime_control.ini', '[runtime_control]'//new_line('a')//'runtime_control=save_stpo;')
    call t%check('a misspelt wish does nothing', poll_control('.', messages) == CONTROL_NOTHING)
    call t%check('but is told', messages%count() == 2)
    if (messages%count() == 2) call t%check('by name', index(messages%text(2), 'save_stpo') > 0)
    call prepare_control('no/such/folder', folder)
    call t%check('a missing folder is a message', folder%count() == 1)
    if (folder%count() == 1) call t%check('that names the file', &
                                          index(folder%text(1), 'no/such/folder/runtime_control.ini: cannot be written') == 1)
  end subroutine test_control_file

  subroutine test_signals()
    integer(c_int) :: status
    call catch_signals()
    call t%check('no signal was caught before any came', signal_caught() == 0)
    status = c_raise(10_c_int)
    call t%check('SIGUSR1 is remembered', signal_caught() == 10)
    status = c_raise(15_c_int)
    call t%check('and so is SIGTERM', signal_caught() == 15)
    status = c_raise(15_c_int)
    call t%check('also the second one does not end the program', signal_caught() == 15)
  end subroutine test_signals
end program test_control
