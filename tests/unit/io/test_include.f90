! SPDX-License-Identifier: GPL-3.0-or-later
!> Parameter files that include others: who has the last word, where mistakes are, missing files, circles. Files are
!> written by root; all ranks must see the same.
program test_include
  use base_errors, only: failure_t, message_list_t
  use base_files, only: real_path
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use io_config, only: config_t
  use io_include, only: register_include
  use io_registry, only: registry_t
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10)
  type(testkit_t) :: kit
  type(registry_t) :: registry

  call kit%start(parallel=.true.)
  call register_include(registry)
  call registry%add_section('Wing', 'numbers')
  call registry%add_real('Wing', 'E', 1.0_rp, 'a number')
  call registry%add_real('Wing', 'D', 2.0_rp, 'a number')
  call registry%add_real('Wing', 'k', 3.0_rp, 'a number', min=0.0_rp)
  call check_precedence()
  call check_mistakes()
  call check_circles()
  call kit%finish()

contains

  subroutine make(path, text)
    character(*), intent(in) :: path, text
    type(failure_t) :: failure
    if (kit%world%is_root) call write_text(path, text, failure)
    call kit%world%barrier()
    call kit%check(path//' is written', .not. failure%failed)
  end subroutine make

  subroutine load(text, config, errors)
    character(*), intent(in) :: text
    type(config_t), intent(inout) :: config
    type(message_list_t), intent(inout) :: errors
    type(message_list_t) :: notices
    call config%load_text(text, 'main.ini', registry, errors, notices, world=kit%world)
  end subroutine load

  !> The including file counts first, wherever [include] stands; its includes count before theirs.
  subroutine check_precedence()
    type(config_t) :: config
    type(message_list_t) :: errors
    call make('one.ini', '[Wing]'//NL//'E = 10'//NL//'D = 20'//NL//'[include]'//NL//'file = two.ini')
    call make('two.ini', '[Wing]'//NL//'D = 200'//NL//'k = 300')
    call load('[include]'//NL//'file = one.ini'//NL//'[Wing]'//NL//'E = 5', config, errors)
    call kit%check('no mistakes', errors%count() == 0)
    call kit%check_close('the file itself comes first', config%get_real('Wing', 'E'), 5.0_rp, 0.0_rp)
    call kit%check_close('then what it includes', config%get_real('Wing', 'D'), 20.0_rp, 0.0_rp)
    call kit%check_close('then what that includes', config%get_real('Wing', 'k'), 300.0_rp, 0.0_rp)
    call kit%check('what is included is given', config%is_given('Wing', 'k'))
    call load('[include]'//NL//'file = two.ini one.ini ./two.ini'//NL//'[Wing]'//NL//'D = 1', config, errors)
    call kit%check('a file that is included twice is read once', errors%count() == 0)
  end subroutine check_precedence

  !> Every mistake names the file in which it stands.
  subroutine check_mistakes()
    type(config_t) :: config
    type(message_list_t) :: errors, more
    call make('bad.ini', '[Wing]'//NL//'k = -1'//NL//'[Wnig]'//NL//'E = 1')
    call load('[include]'//NL//'file = bad.ini none.ini', config, errors)
    call kit%check('three mistakes', errors%count() == 3)
    call kit%check('a missing file', says(errors, "main.ini:2: [include] file: 'none.ini' does not exist"))
    call kit%check('a value', says(errors, 'bad.ini:2: [Wing] k: '))
    call kit%check('a section', says(errors, 'bad.ini:3: [Wnig]'))
    call make('a.ini', '[Wing]'//NL//'E = 1')
    call make('b.ini', '[Wing]'//NL//'E = 2')
    call load('[include]'//NL//'file = a.ini b.ini', config, more)
    call kit%check('side by side, no key twice', more%count() == 1)
    call kit%check('both are named', says(more, 'b.ini:2: [Wing] E: is given twice, first in line 2 of a.ini'))
    more = message_list_t()
    call load('[include]'//NL//'file = a.ini', config, more)
    call config%complain(more, 'Wing', 'E', 'is odd')
    call kit%check('what is said later names the file, too', says(more, 'a.ini:2: [Wing] E: is odd'))
  end subroutine check_mistakes

  subroutine check_circles()
    type(config_t) :: config
    type(message_list_t) :: errors
    call make('main.ini', '[include]'//NL//'file = ring.ini')
    call make('ring.ini', '[include]'//NL//'file = chain.ini'//NL//'[Wing]'//NL//'E = 1')
    call make('chain.ini', '[include]'//NL//'file = ./ring.ini')
    call load('[include]'//NL//'file = ring.ini', config, errors)
    call kit%check('a circle is one mistake', errors%count() == 1)
    call kit%check('it is drawn', &
                   says(errors, 'chain.ini:2: [include] file: a file must not include itself: '// &
                        'ring.ini includes chain.ini includes ./ring.ini'))
    call make('chain.ini', '[include]'//NL//'file = main.ini')
    call load('[include]'//NL//'file = ring.ini', config, errors)
    call kit%check('the first file is part of it', says(errors, 'chain.ini includes main.ini'))
    call kit%check('names become one', real_path('./main.ini') == real_path('main.ini'))
    call kit%check('a name without file stays', real_path('no/such') == 'no/such')
  end subroutine check_circles

  !> Whether one of the messages contains `text`.
  logical function says(errors, text)
    type(message_list_t), intent(in) :: errors
    character(*), intent(in) :: text
    integer :: i
    says = .false.
    do i = 1, errors%count()
      says = says .or. index(errors%text(i), text) > 0
    end do
  end function says
end program test_include
