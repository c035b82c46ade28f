! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the lists [Train] parameters and [Diagnose] parameters: the free parameters and their bounds.
module common_free_parameters
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use base_text, only: next_word, number_text, parse_real, quoted
  use cmaes_box, only: box_problem
  use common_wing_effects, only: effect_without_site
  use common_words, only: find_words
  use io_config, only: config_t
  use io_suggest, only: suggestion_t
  use measurement_free_parameters, only: free_parameters_t
  use measurement_instrument, only: instrument_t
  use measurement_instrument_causes, only: N_INSTRUMENT
  use solid_params, only: solid_params_t
  use solid_usual_causes, only: N_COMMON, PARAM_PLATE, PARAM_THICKNESS
  implicit none
  private
  public :: read_free_parameters

  real(rp), parameter :: PAPER_JOINT(2) = [1.0e-6_rp, 1.0e-2_rp] ! [N m/rad] 0.1 to 1000 mN cm/rad

contains

  !> Reads the list in `text` into `free_parameters`. Adds all mistakes to `errors` in one message. Bounds that are not in the list
  !> are those of the parameters of the wing or, for joints, those of the search by Truong et al.
  subroutine read_free_parameters(config, section, text, params, instrument, scale_is_log, free_parameters, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: section, text !< the section with the key `parameters`, and the value of this key
    type(solid_params_t), intent(in) :: params
    type(instrument_t), intent(in) :: instrument
    logical, intent(in) :: scale_is_log
    type(free_parameters_t), intent(out) :: free_parameters
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: problem, problems
    integer :: position, first, last
    logical :: found
    allocate (free_parameters%numbers(0), free_parameters%instrument_numbers(0), free_parameters%lower(0), &
              free_parameters%upper(0), free_parameters%is_log(0))
    problems = ''
    position = 1
    do
      call next_word(text, ',', position, first, last, found)
      if (.not. found) exit
      call read_entry(text(first:last), params, instrument, scale_is_log, free_parameters, problem)
      if (allocated(problem)) problems = problems//'; '//problem
    end do
    if (problems == '' .and. free_parameters%count() == 0) problems = '; the list is empty: name at least one parameter'
    if (any(free_parameters%numbers == PARAM_PLATE) .and. any(free_parameters%numbers == PARAM_THICKNESS)) &
      problems = problems//'; D and thickness change the same stiffness: leave one of them out'
    if (problems /= '') call config%complain(errors, section, 'parameters', problems(3:))
  end subroutine read_free_parameters

  !> Reads one entry: NAME, NAME LOWER UPPER, or NAME LOWER UPPER SCALE.
  subroutine read_entry(text, params, instrument, scale_is_log, free_parameters, problem)
    character(*), intent(in) :: text
    type(solid_params_t), intent(in) :: params
    type(instrument_t), intent(in) :: instrument
    logical, intent(in) :: scale_is_log
    type(free_parameters_t), intent(inout) :: free_parameters
    character(:), allocatable, intent(out) :: problem
    integer :: first(5), last(5), n, k, i
    real(rp) :: bounds(2)
    type(parameter_t) :: p
    logical :: is_log, is_known
    call find_words(text, first, last, n)
    if (n == 0) then
      problem = 'an entry between commas is empty'
      return
    else if (n /= 1 .and. n /= 3 .and. n /= 4) then
      problem = quoted(trim(adjustl(text)))//' is not NAME, NAME LOWER UPPER or NAME LOWER UPPER log|linear'
      return
    end if
    do k = 2, min(n, 3)
      call parse_real(text(first(k):last(k)), bounds(k - 1), problem)
      if (allocated(problem)) return
    end do
    is_log = scale_is_log
    if (n == 4) then
      select case (text(first(4):last(4)))
      case ('log')
        is_log = .true.
      case ('linear')
        is_log = .false.
      case default
        problem = quoted(text(first(4):last(4)))//' is no scale; valid: log | linear'
        return
      end select
    end if
    is_known = .false.
    do i = 1, params%count() + N_INSTRUMENT
      p = description(params, instrument, i)
      if (.not. matches(text(first(1):last(1)), p%name)) cycle
      is_known = .true.
      if (n == 1) bounds = default_bounds(params, p, i)
      call add(free_parameters, params, p, i, bounds, is_log, n == 4, problem)
      if (allocated(problem)) return
    end do
    if (.not. is_known) problem = quoted(text(first(1):last(1)))//' is unknown'// &
                                  hint(text(first(1):last(1)), params, instrument)
  end subroutine read_entry

  !> Returns the description of parameter i. The parameters of the wing come first, then those of the instrument.
  function description(params, instrument, i) result(p)
    type(solid_params_t), intent(in) :: params
    type(instrument_t), intent(in) :: instrument
    integer, intent(in) :: i
    type(parameter_t) :: p
    if (i <= params%count()) then
      p = params%describe(i)
    else
      p = instrument%describe(i - params%count())
    end if
  end function description

  !> Tells whether `known` is this name or, if the name ends in :*, begins with the part before the star.
  pure logical function matches(name, known)
    character(*), intent(in) :: name, known
    matches = known == name
    if (len(name) > 2) then
      if (name(len(name) - 1:) == ':*') matches = index(known, name(:len(name) - 1)) == 1
    end if
  end function matches

  !> Returns the bounds of parameter `i` for an input without bounds. Joints have the bounds of the paper.
  function default_bounds(params, p, i) result(bounds)
    type(solid_params_t), intent(in) :: params
    type(parameter_t), intent(in) :: p
    integer, intent(in) :: i
    real(rp) :: bounds(2)
    bounds = [p%lower, p%upper]
    if (i > N_COMMON + size(params%vein_factor) .and. i <= params%count_basic()) bounds = PAPER_JOINT
  end function default_bounds

  !> Adds parameter `i` to the free parameters. `problem` says why this is not possible.
  subroutine add(free_parameters, params, p, i, bounds, is_log, scale_is_given, problem)
    type(free_parameters_t), intent(inout) :: free_parameters
    type(solid_params_t), intent(in) :: params
    type(parameter_t), intent(in) :: p
    integer, intent(in) :: i
    real(rp), intent(in) :: bounds(2)
    logical, intent(in) :: is_log, scale_is_given
    character(:), allocatable, intent(out) :: problem
    character(:), allocatable :: fault
    logical :: log_scale
    integer :: n
    log_scale = is_log .and. (p%is_log .or. scale_is_given)
    if (any(free_parameters%numbers == i) .or. any(free_parameters%instrument_numbers == i - params%count())) then
      problem = quoted(p%name)//' is given twice'
      return
    end if
    if (effect_without_site(params, i) /= '') then
      problem = quoted(p%name)//' '//effect_without_site(params, i)
      return
    end if
    fault = box_problem(bounds(1), bounds(2), log_scale)
    if (fault == '' .and. p%is_log .and. .not. bounds(1) > 0) fault = 'the lower bound must be positive'
    if (fault /= '') then
      problem = quoted(p%name)//': '//fault//', not '//number_text(bounds(1))//' and '//number_text(bounds(2))
      return
    end if
    n = free_parameters%count()
    if (i <= params%count()) n = size(free_parameters%numbers)
    if (i <= params%count()) then
      free_parameters%numbers = [free_parameters%numbers, i]
    else
      free_parameters%instrument_numbers = [free_parameters%instrument_numbers, i - params%count()]
    end if
    free_parameters%lower = [free_parameters%lower(:n), bounds(1), free_parameters%lower(n + 1:)]
    free_parameters%upper = [free_parameters%upper(:n), bounds(2), free_parameters%upper(n + 1:)]
    free_parameters%is_log = [free_parameters%is_log(:n), log_scale, free_parameters%is_log(n + 1:)]
  end subroutine add

  !> Returns the list of valid names, with the one that is most similar to `name`.
  function hint(name, params, instrument) result(text)
    character(*), intent(in) :: name
    type(solid_params_t), intent(in) :: params
    type(instrument_t), intent(in) :: instrument
    character(:), allocatable :: text
    type(parameter_t) :: p
    type(suggestion_t) :: suggestion
    integer :: i
    call suggestion%start(name)
    text = '; valid: '
    do i = 1, params%count() + N_INSTRUMENT
      p = description(params, instrument, i)
      call suggestion%offer(p%name)
      if (i > 1) text = text//' | '
      text = text//p%name
    end do
    text = text//' | joint:* | E:* | hardening:*'//suggestion%hint()
  end function hint
end module common_free_parameters
