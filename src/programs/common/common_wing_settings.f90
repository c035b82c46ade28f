! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the wing of a run: it makes a mechanical model and its mass from [Wing], [Mass] and the wing file, and finds all
!> mistakes of the user in them. SI units.
module common_wing_settings
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: word_of
  use base_parameter, only: parameter_t
  use base_text, only: next_word, number_text, parse_real, quoted
  use common_wing_doubts, only: check_size, notice_assumptions, notice_magnitudes, size_hint
  use common_wing_effects, only: effect_without_site, take_effect_sites
  use common_wing_keys, only: mass_choices_t, read_damping_keys, read_mass_keys, read_wing_keys, wing_choices_t, CROSS_PRESET, &
                              CROSS_YES, OWN_KEYS, WING_PAPER
  use common_wing_size, only: notice_other_size, scale_wing
  use common_words, only: find_words
  use io_config, only: config_t
  use io_broadcast_text, only: named_path
  use parallel_world, only: world_t
  use solid_inertia, only: inertia_t
  use solid_mass, only: lump_mass
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, membrane_note, solid_params_t
  use solid_wing, only: wing_t, MEMBRANE_BILINEAR, MEMBRANE_UNSTATED, SIDE_UNSTATED, Z_SIDES
  use solid_wing_case, only: wing_case_t
  use solid_wing_file, only: read_wing, load_shared_wing => load_wing
  use solid_wing_fingerprint, only: wing_fingerprint, FINGERPRINT_LENGTH
  implicit none
  private
  public :: load_wing, read_damping, find_beside, check_name

contains

  !> Reads the wing that the keys in `config` describe. Adds all mistakes to `errors` and all remarks to `notices`. The model in
  !> `s` exists only if `found`. A wing without a valid mass is a mistake if `needs_mass`, and a remark otherwise.
  subroutine load_wing(config, needs_mass, s, found, errors, notices, world, wing)
    type(config_t), intent(in) :: config
    logical, intent(in) :: needs_mass
    type(wing_case_t), intent(out) :: s
    logical, intent(out) :: found
    type(message_list_t), intent(inout) :: errors, notices
    type(world_t), intent(in), optional :: world !< if present, root reads the file for all ranks, and the call is collective
    type(wing_choices_t), intent(in), optional :: wing !< what [Wing] says, if the caller has read it
    type(failure_t) :: failure
    type(wing_choices_t) :: choices
    type(mass_choices_t) :: mass
    type(wing_t) :: none
    real(rp) :: centre(3)
    integer :: n_before
    found = .false.
    if (present(wing)) then
      choices = wing
    else
      call read_wing_keys(config, choices)
    end if
    call read_mass_keys(config, mass)
    if (.not. choices%has_file) return
    n_before = errors%count()
    call read_file(config, choices%file, s, errors, world)
    if (errors%count() > n_before) then
      s%wing = none ! a wing with mistakes may name points that do not exist
      return
    end if
    call take_z_side(config, choices%z_side, s, notices)
    s%fingerprint = wing_fingerprint(s%wing)
    call check_size(config, [choices%length, choices%mean_chord], s%wing, errors, notices)
    if (errors%count() > n_before) return
    s%requested_size = [choices%length, choices%mean_chord]
    call scale_wing(s)
    if (choices%has_found_size) call notice_other_size(config, choices%found_size, s%wing, notices)
    if (choices%has_fingerprint) call check_fingerprint(config, choices, s, errors, notices)
    call take_material(config, choices, s, errors, notices)
    call take_mass(config, mass, needs_mass, s, errors, notices)
    call notice_assumptions(config, choices%preset == WING_PAPER, mass, s%wing, needs_mass, notices)
    if (s%has_mass) call notice_magnitudes(config, mass%law, s, notices)
    call s%model%init(s%wing, s%requested, failure)
    if (failure%failed) then
      call errors%add(s%path//': '//failure%reason)
      return
    end if
    associate (points => s%wing%points)
      centre = sum(points(:, s%wing%root), 2)/size(s%wing%root)
      s%tip = maxloc(sum((points - spread(centre, 2, size(points, 2)))**2, 1), 1)
    end associate
    found = .true.
  end subroutine load_wing

  !> Reads the wing from its file, with or without a `world`.
  subroutine read_file(config, name, s, errors, world)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: name
    type(wing_case_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    type(world_t), intent(in), optional :: world
    character(:), allocatable :: problem
    call find_beside(config%file_name(), name, s%path, problem, world)
    if (allocated(problem)) then
      call config%complain(errors, 'Wing', 'file', problem)
    else if (present(world)) then
      call load_shared_wing(world, s%path, s%wing, errors)
    else
      call read_wing(s%path, s%wing, errors)
    end if
  end subroutine read_file

  !> Sets the side to which z points. The value in [Wing] takes precedence over that in the file, because the parameters in
  !> [Wing] may have been found with another file.
  subroutine take_z_side(config, stated, s, notices)
    type(config_t), intent(in) :: config
    integer, intent(in) :: stated !< SIDE_*
    type(wing_case_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: notices
    integer :: in_file
    logical :: was_dorsal
    if (stated == SIDE_UNSTATED) return
    in_file = s%wing%z_side
    was_dorsal = s%wing%z_is_dorsal()
    s%wing%z_side = stated
    if (in_file /= SIDE_UNSTATED .and. (was_dorsal .neqv. s%wing%z_is_dorsal())) call config%complain(notices, 'Wing', 'z_side', &
      word_of(Z_SIDES, stated)//' replaces '//word_of(Z_SIDES, in_file)//' of '//s%path// &
      ', also for the direction of +z in [Wing] parameters')
  end subroutine take_z_side

  !> Adds a mistake if the values in [Wing] were found for another wing, or a notice if the user accepts that.
  subroutine check_fingerprint(config, choices, s, errors, notices)
    type(config_t), intent(in) :: config
    type(wing_choices_t), intent(in) :: choices
    type(wing_case_t), intent(in) :: s
    type(message_list_t), intent(inout) :: errors, notices
    character(:), allocatable :: text
    if (choices%fingerprint == s%fingerprint) return
    if (len(choices%fingerprint) /= FINGERPRINT_LENGTH .or. verify(choices%fingerprint, '0123456789ABCDEF') > 0) then
      call config%complain(errors, 'Wing', 'fingerprint', quoted(choices%fingerprint)//' is no fingerprint: valid are the '// &
                           number_text(FINGERPRINT_LENGTH)//' digits that msm_train and msm_diagnose write')
      return
    end if
    text = 'these values were found for another wing than '//s%path//', whose fingerprint is '//s%fingerprint
    if (choices%allow_other_wing) then
      call config%complain(notices, 'Wing', 'fingerprint', text//'; allow_other_wing = yes accepts them nevertheless')
    else
      call config%complain(errors, 'Wing', 'fingerprint', text//'; give the wing file of these values, or accept them with '// &
                           '[Wing] allow_other_wing = yes')
    end if
  end subroutine check_fingerprint

  !> Returns in `path` where the file `name` is. It looks first in the current folder, then in the folder of the input file `ini`.
  !> If the file is in neither place, `problem` says so; otherwise it is not allocated.
  subroutine find_beside(ini, name, path, problem, world)
    character(*), intent(in) :: ini, name
    character(:), allocatable, intent(out) :: path, problem
    type(world_t), intent(in), optional :: world !< if present, root looks for the file for all ranks, and the call is collective
    path = named_path(name, ini, world)
    if (path == '') problem = quoted(name)//' does not exist, neither here nor beside the input file'
  end subroutine find_beside

  !> Adds a mistake if `name`, with which the names of all files begin, has characters that are not allowed in XML, the format of
  !> indices for viewers.
  subroutine check_name(config, name, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: name
    type(message_list_t), intent(inout) :: errors
    if (scan(name, '<>&"'':') > 0) &
      call config%complain(errors, 'Saving', 'name', 'must not contain < > & : or quotes')
  end subroutine check_name

  !> Sets the stiffness parameters of the wing from [Wing].
  subroutine take_material(c, choices, s, errors, notices)
    type(config_t), intent(in) :: c
    type(wing_choices_t), intent(in) :: choices
    type(wing_case_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors, notices
    character(:), allocatable :: note
    logical :: is_soft
    associate (p => s%requested)
      p = default_params(s%wing)
      p%young = choices%young
      p%plate = choices%plate
      p%k_vein = choices%spring
      p%k_membrane = p%k_vein
      p%k_cross = p%k_vein
      p%cross_springs = choices%cross_springs == CROSS_YES .or. &
                        (choices%cross_springs == CROSS_PRESET .and. choices%preset == WING_PAPER)
      p%slack = choices%slack
      p%slack_width = choices%slack_width
      if (.not. choices%joint > 0 .and. abs(choices%joint + 1) > 0) &
        call c%complain(errors, 'Wing', 'joint_stiffness', 'must be positive, or -1 for the stiffness of the '// &
                        'vein without the joint')
      p%joint = choices%joint
      call take_effect_sites(c, choices%sites, p, errors)
      call take_parameters(c, choices%parameters, p, errors)
      call membrane_note(p, note, is_soft)
      if (is_soft .and. size(s%wing%triangles) > 0) call notices%add(note)
    end associate
  end subroutine take_material

  !> Sets the masses of the wing from [Mass] and the wing file. A wing without masses is an error if `needs_mass`.
  subroutine take_mass(c, choices, needs_mass, s, errors, notices)
    type(config_t), intent(in) :: c
    type(mass_choices_t), intent(in) :: choices
    logical, intent(in) :: needs_mass
    type(wing_case_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(message_list_t) :: messages
    character(:), allocatable :: hint
    integer :: i
    s%material = choices%material
    if (.not. choices%has_vein_density .and. s%wing%mass%vein_density > 0) s%material%vein_density = s%wing%mass%vein_density
    s%material%membrane_law = choices%law
    if (.not. (choices%has_law .or. choices%has_areal_density) .and. s%wing%mass%law /= MEMBRANE_UNSTATED) then
      s%material%membrane_law = MEMBRANE_BILINEAR ! the file has the law of this wing
      if (.not. choices%has_membrane_mass) s%material%membrane_mass = s%wing%mass%membrane
      s%material%weights = [1.0_rp, 0.0_rp, 0.0_rp]
      if (s%wing%mass%law == MEMBRANE_BILINEAR) s%material%weights = s%wing%mass%weights
    end if
    s%material%weights(2:) = s%material%weights(2:)/s%scale ! the law belongs to the unscaled wing
    call lump_mass(s%wing, s%material, s%mass, messages)
    s%has_mass = messages%count() == 0
    hint = size_hint(s%wing)
    do i = 1, messages%count()
      if (needs_mass) then
        call c%complain(errors, 'Mass', 'membrane_law', hint//messages%text(i))
      else
        call notices%add(hint//messages%text(i)//'; the mass is not reported')
      end if
    end do
  end subroutine take_mass

  !> Reads the pairs "name value" of [Wing] parameters.
  subroutine take_parameters(config, text, params, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: text
    type(solid_params_t), intent(inout) :: params
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: problem, problems
    integer :: position, first, last
    logical :: found
    problems = ''
    position = 1
    do
      call next_word(text, ',', position, first, last, found)
      if (.not. found) exit
      call read_pair(text(first:last), params, problem)
      if (allocated(problem)) problems = problems//'; '//problem
    end do
    if (len(problems) > 0) call config%complain(errors, 'Wing', 'parameters', problems(3:))
  end subroutine take_parameters

  !> Reads a pair NAME VALUE of [Wing] parameters. `problem` says what is wrong with it.
  subroutine read_pair(text, params, problem)
    character(*), intent(in) :: text
    type(solid_params_t), intent(inout) :: params
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
      if (any(name == OWN_KEYS)) then
        problem = quoted(name)//' has a key of its own: '//merge('E', 'D', name == OWN_KEYS(1))
        return
      end if
      number = params%find(name)
      if (number == 0) then
        problem = quoted(name)//' is unknown; valid: '//names_of(params)
        return
      end if
      call parse_real(text(first(2):last(2)), value, problem)
      if (allocated(problem)) return
      known = params%describe(number)
      if (known%is_log .and. .not. value > 0) then
        problem = quoted(name)//' must be positive'
      else if (effect_without_site(params, number) /= '') then
        problem = quoted(name)//' '//effect_without_site(params, number)
      else if (known%is_effect .and. .not. (value >= known%lower .and. value <= known%upper)) then
        problem = quoted(name)//' must lie between '//number_text(known%lower)//' and '//number_text(known%upper)
      else
        call params%set(number, value)
      end if
    end associate
  end subroutine read_pair

  !> Returns the names that [Wing] parameters takes, separated by ' | '.
  function names_of(params) result(text)
    type(solid_params_t), intent(in) :: params
    character(:), allocatable :: text
    type(parameter_t) :: known
    integer :: i
    text = ''
    do i = 1, params%count()
      known = params%describe(i)
      if (all(known%name /= OWN_KEYS)) text = text//' | '//known%name
    end do
    text = text(4:)
  end function names_of

  !> Reads [Damping] into `inertia`. This damping acts on the motion within the frame of the wing.
  subroutine read_damping(config, model, inertia)
    type(config_t), intent(in) :: config
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(inout) :: inertia !< initialised
    real(rp) :: nodal
    call read_damping_keys(config, inertia, nodal)
    inertia%nodal(model%movable) = nodal
    call inertia%hold_joints(model)
  end subroutine read_damping
end module common_wing_settings
