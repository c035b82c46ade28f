! SPDX-License-Identifier: GPL-3.0-or-later
!> Handles [Flight] effects: which causes are sought in flights, and which parameters of the structure the first flights change.
module diagnose_flight_effects
  use base_errors, only: message_list_t
  use base_parameter, only: parameter_t
  use base_text, only: next_word, number_text, quoted
  use diagnose_flights, only: flusi_runner_t
  use diagnosis_flight_catalogue, only: flight_causes
  use diagnosis_flight_changes, only: N_STRUCTURE
  use diagnosis_flight_data, only: flight_cases_t
  use diagnosis_flight_structure, only: choose_structure, is_wanted, matches_word, structure_causes
  use diagnosis_wing_entries, only: catalogue_t
  use io_config, only: config_t
  use io_suggest, only: suggestion_t
  use solid_params, only: solid_params_t
  use solid_usual_causes, only: PARAM_PLATE, PARAM_THICKNESS, PARAM_YOUNG
  implicit none
  private
  public :: check_effects, take_structure

contains

  !> Adds a mistake for every name in `effects` that is neither a cause that flights show nor, with other data of the wing, a
  !> parameter that the baseline fits; and for causes of the structure of rigid wings. `free` are the parameters of the baseline.
  subroutine check_effects(config, effects, params, free, data, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: effects
    type(solid_params_t), intent(in) :: params
    integer, intent(in) :: free(:)
    type(flight_cases_t), intent(in) :: data
    type(message_list_t), intent(inout) :: errors
    type(suggestion_t) :: suggestion
    character(:), allocatable :: valid, of_wing
    integer :: position, first, last, at, begin, finish
    logical :: found, bends
    bends = any(data%cases%facts%is_flexible)
    of_wing = structure_causes()//names_of_baseline(params, free, data)
    valid = flight_causes()
    if (bends) valid = valid//' '//of_wing
    position = 1
    do
      call next_word(effects, ' ,', position, first, last, found)
      if (.not. found) return
      associate (word => effects(first:last))
        if (is_wanted(valid, word) .or. matches_any(word, valid)) cycle
        if (is_wanted(of_wing, word)) then
          call config%complain(errors, 'Flight', 'effects', word//' needs wings that bend, with [Insects] wings = flexible; '// &
                               'those of '//data%cases(1)%facts%path//' are rigid')
          cycle
        end if
        call suggestion%start(word)
        at = 1
        do
          call next_word(valid, ' ', at, begin, finish, found)
          if (.not. found) exit
          call suggestion%offer(valid(begin:finish))
        end do
        call config%complain(errors, 'Flight', 'effects', 'there is no effect '//quoted(word)//suggestion%hint()// &
                             '; valid: '//valid)
      end associate
    end do
  end subroutine check_effects

  !> Tells whether a word with a star matches any of the names.
  pure logical function matches_any(word, names)
    character(*), intent(in) :: word, names
    integer :: position, first, last
    logical :: found
    matches_any = .false.
    position = 1
    do
      call next_word(names, ' ', position, first, last, found)
      if (.not. found) return
      if (index(names(first:last), ':') > 0) matches_any = matches_any .or. matches_word(word, names(first:last))
    end do
  end function matches_any

  !> Returns the names of the parameters that the baseline fits, each with a blank before it. E and D have flights without a name.
  function names_of_baseline(params, free, data) result(names)
    type(solid_params_t), intent(in) :: params
    integer, intent(in) :: free(:)
    type(flight_cases_t), intent(in) :: data
    character(:), allocatable :: names
    type(parameter_t) :: p
    integer :: i
    names = ''
    if (any(data%cases%facts%is_alone)) return
    do i = 1, size(free)
      if (any(free(i) == [PARAM_YOUNG, PARAM_PLATE, PARAM_THICKNESS])) cycle
      p = params%describe(free(i))
      names = names//' '//p%name
    end do
  end function names_of_baseline

  !> Chooses the parameters of the structure that the first flights change, and tells the runner. Adds a mistake if there are too
  !> many. Not collective: all ranks do the same.
  subroutine take_structure(config, catalogue, data, runner, errors)
    type(config_t), intent(in) :: config
    type(catalogue_t), intent(inout) :: catalogue
    type(flight_cases_t), intent(inout) :: data
    type(flusi_runner_t), intent(inout) :: runner
    type(message_list_t), intent(inout) :: errors
    logical :: is_full
    if (.not. data%bend()) return
    call choose_structure(catalogue, data%effects, runner, data%cases, is_full)
    if (is_full) call config%complain(errors, 'Flight', 'effects', 'names more than '//number_text(N_STRUCTURE)// &
                                      ' parameters of the wing; name fewer')
    if (allocated(data%cases(1)%facts%structure)) runner%structure = data%cases(1)%facts%structure
  end subroutine take_structure
end module diagnose_flight_effects
