! SPDX-License-Identifier: GPL-3.0-or-later
!> Programmer errors stop the program with a sentence: the case named on the command line must not
!> return. The driver looks for the sentence.
program test_ini_misuse
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t
  use io_registry, only: registry_t
  use test_ini_sample, only: register_sample
  implicit none
  type(registry_t), target :: r, empty
  type(keys_t) :: keys
  type(config_t) :: c
  type(message_list_t) :: errors, notices
  character(32) :: which
  integer :: n
  real(rp) :: x

  call get_command_argument(1, which)
  call register_sample(r)
  if (which /= 'not_loaded') call c%load_text('', 'f.ini', r, errors, notices)
  n = 0
  x = 0
  select case (which)
  case ('twice')
    call r%add_real('Resolution', 'ny', 1.0_rp, 'again')
  case ('alias_taken')
    call r%add_alias('Time', 'Tmax', 'CFL')
  case ('alias_unknown')
    call r%add_alias('Time', 'tend', 'Tend')
  case ('default')
    call r%add_integer('Time', 'nt', 0, 'steps', min=1)
  case ('unregistered')
    n = c%get_integer('Time', 'nt')
  case ('type')
    x = c%get_real('Resolution', 'nx')
  case ('no_value')
    x = c%get_real('Geometry', 'y0')
  case ('no_key')
    keys = declaring(empty)
    call keys%section('Time', 'of the flow')
    call keys%in_checkpoint()
  case ('other_section')
    keys = declaring(r)
    call keys%section('Search', 'of a wing')
    call keys%in_checkpoint()
  case ('no_help')
    keys = declaring(r)
    call keys%section('Time', in_checkpoint=.true.)
  case ('not_loaded')
    n = c%get_integer('Resolution', 'nx')
  end select
  write (*, '(a,i0,es8.1)') 'it went on: ', n, x
end program test_ini_misuse
