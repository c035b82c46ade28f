! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads [Instrument]: effects of the instrument that the measurement file does not contain. `msm_train` and `msm_diagnose` use the
!> section. Inputs of `flusi` may contain it together with a trained wing; there it has no effect.
module common_instrument
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use base_text, only: next_word, number_text, parse_real, quoted
  use common_words, only: find_words
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  use io_suggest, only: suggestion_t
  use measurement_instrument, only: instrument_t
  use measurement_instrument_causes, only: N_INSTRUMENT
  implicit none
  private
  public :: register_instrument_keys, register_idle_instrument, read_instrument, instrument_lines

contains

  !> Declares and reads the section for programs that use it.
  subroutine instrument_keys(keys, parameters)
    type(keys_t), intent(inout) :: keys
    character(:), allocatable, intent(inout) :: parameters
    call keys%section('Instrument', 'errors of the instrument that the measurement file does not state')
    call keys%text('parameters', parameters, '', 'pairs of name and value, separated by commas: force_gain, '// &
                   'force_offset [N], drift and others of docs/theory/effects.md')
  end subroutine instrument_keys

  !> Adds the section [Instrument] for programs that use it.
  subroutine register_instrument_keys(registry)
    type(registry_t), intent(inout), target :: registry
    character(:), allocatable :: unused
    type(keys_t) :: keys
    keys = declaring(registry)
    call instrument_keys(keys, unused)
  end subroutine register_instrument_keys

  !> Adds the section [Instrument] for programs that do not use it.
  subroutine register_idle_instrument(r)
    type(registry_t), intent(inout) :: r
    call r%add_inert_section('Instrument', 'Errors of the instrument, for msm_train; they are no property of the wing.')
    call r%add_inert('Instrument', 'parameters', 'belongs to the measurement, not to the wing')
  end subroutine register_idle_instrument

  !> Sets `instrument` from the section [Instrument]. Adds all mistakes to `errors` in one message.
  subroutine read_instrument(config, instrument, errors)
    type(config_t), intent(in), target :: config
    type(instrument_t), intent(inout) :: instrument
    type(message_list_t), intent(inout) :: errors
    type(keys_t) :: keys
    character(:), allocatable :: text, problem, problems
    integer :: position, first, last
    logical :: found
    keys = reading(config)
    call instrument_keys(keys, text)
    problems = ''
    position = 1
    do
      call next_word(text, ',', position, first, last, found)
      if (.not. found) exit
      call read_pair(text(first:last), instrument, problem)
      if (allocated(problem)) problems = problems//'; '//problem
    end do
    if (problems /= '') call config%complain(errors, 'Instrument', 'parameters', problems(3:))
  end subroutine read_instrument

  !> Reads a pair NAME VALUE of the instrument. `problem` says what is wrong with it.
  subroutine read_pair(text, instrument, problem)
    character(*), intent(in) :: text
    type(instrument_t), intent(inout) :: instrument
    character(:), allocatable, intent(out) :: problem
    type(parameter_t) :: known
    real(rp) :: value
    integer :: first(3), last(3), n, number
    call find_words(text, first, last, n)
    if (n /= 2) then
      problem = quoted(trim(adjustl(text)))//' is not a pair NAME VALUE'
      return
    end if
    associate (name => text(first(1):last(1)))
      number = instrument%find(name)
      if (number == 0) then
        problem = quoted(name)//' is unknown'//instrument_hint(name)
        return
      end if
      call parse_real(text(first(2):last(2)), value, problem)
      if (allocated(problem)) return
      known = instrument%describe(number)
      if (value >= known%lower .and. value <= known%upper) then
        call instrument%set(number, value)
      else
        problem = quoted(name)//' must lie between '//number_text(known%lower)//' and '//number_text(known%upper)// &
                  ' '//known%unit
      end if
    end associate
  end subroutine read_pair

  !> Returns text for a message about the unknown `name`: the valid names, and the name that the user may have meant.
  function instrument_hint(name) result(text)
    character(*), intent(in) :: name
    character(:), allocatable :: text
    type(instrument_t) :: instrument
    type(parameter_t) :: p
    type(suggestion_t) :: suggestion
    integer :: i
    call suggestion%start(name)
    text = '; valid: '
    do i = 1, N_INSTRUMENT
      p = instrument%describe(i)
      call suggestion%offer(p%name)
      if (i > 1) text = text//' | '
      text = text//p%name
    end do
    text = text//suggestion%hint()
  end function instrument_hint

  !> Returns the section as text of an ini file, or '' if the instrument has no effect.
  function instrument_lines(instrument) result(text)
    type(instrument_t), intent(in) :: instrument
    character(:), allocatable :: text
    type(instrument_t) :: null
    type(parameter_t) :: p
    integer :: i
    text = ''
    do i = 1, N_INSTRUMENT
      p = instrument%describe(i)
      if (abs(instrument%get(i) - null%get(i)) > 0) text = text//', '//p%name//' '//number_text(instrument%get(i))
    end do
    if (text /= '') text = '[Instrument]'//new_line('a')//'parameters = '//text(3:)//'; errors of the instrument'// &
                           new_line('a')
  end function instrument_lines
end module common_instrument
