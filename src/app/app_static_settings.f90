! SPDX-License-Identifier: GPL-3.0-or-later
!> What `flusi --static` is to compute: from the ini file and the wing file to a mechanical model and its
!> loads. Whatever a user can do wrong is found here, before anything is computed or written. SI units.
module app_static_settings
  use app_static_keys, only: register_static_keys
  use base_errors, only: failure_t, message_list_t
  use base_files, only: file_exists, folder_of, join_path
  use base_kinds, only: rp
  use base_text, only: BLANKS, next_word, number_text, parse_real, quoted
  use io_config, only: config_t
  use io_registry, only: registry_t
  use solid_loads, only: load_t
  use solid_mass, only: lump_mass, mass_params_t, mass_t, MEMBRANE_BILINEAR, MEMBRANE_UNIFORM
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, membrane_note, parameter_t, solid_params_t
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  implicit none
  private
  public :: static_settings_t, static_load_t, load_static_settings

  !> One load of the list.
  type :: static_load_t
    type(load_t) :: load
    real(rp) :: place(2) = 0 !< [m] on the unloaded wing
    real(rp) :: force(3) = 0 !< [N]
  end type static_load_t

  type :: static_settings_t
    type(config_t) :: config
    character(:), allocatable :: wing_path
    type(wing_t) :: wing
    type(solid_model_t) :: model
    type(solid_params_t) :: asked          !< parameters before joints became as stiff as their veins
    type(mass_params_t) :: material
    type(mass_t) :: mass
    logical :: has_mass = .false.
    type(static_load_t), allocatable :: loads(:)
    type(static_options_t) :: options
    character(:), allocatable :: name      !< of the files to write
    logical :: save_shapes = .true.
  end type static_settings_t

contains

  !> Reads the ini file `path`; all mistakes go to `errors`, remarks to `notices`.
  subroutine load_static_settings(path, flusi_compat, s, errors, notices)
    character(*), intent(in) :: path
    logical, intent(in) :: flusi_compat
    type(static_settings_t), intent(out) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t) :: registry
    type(failure_t) :: failure
    integer :: n_before
    call register_static_keys(registry)
    call s%config%load_file(path, registry, errors, notices, flusi_compat)
    call read_options(s, errors)
    allocate (s%loads(0))
    call find_wing(s, path, errors)
    if (.not. allocated(s%wing_path)) return
    n_before = errors%count()
    call read_wing(s%wing_path, s%wing, errors)
    if (errors%count() > n_before) return
    call read_material(s, errors, notices)
    call s%model%init(s%wing, s%asked, failure)
    if (failure%failed) then
      call errors%add(s%wing_path//': '//failure%reason)
      return
    end if
    call read_loads(s, errors)
  end subroutine load_static_settings

  subroutine read_options(s, errors)
    type(static_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    associate (c => s%config)
      s%options%tolerance = c%get_real('Solver', 'tolerance')
      s%options%step_limit = c%get_real('Solver', 'step_limit')
      s%options%factorisation_limit = c%get_integer('Solver', 'factorisation_limit')
      s%name = c%get_text('Saving', 'name')
      s%save_shapes = c%get_switch('Saving', 'shapes')
      if (scan(s%name, '<>&"'':') > 0) &
        call c%complain(errors, 'Saving', 'name', 'must not contain < > & : or quotes')
    end associate
  end subroutine read_options

  !> Sets wing_path, unless the file is named nowhere or does not exist.
  subroutine find_wing(s, path, errors)
    type(static_settings_t), intent(inout) :: s
    character(*), intent(in) :: path
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: here, there
    if (.not. s%config%is_given('Wing', 'file')) return
    here = s%config%get_text('Wing', 'file')
    there = here
    if (index(here, '/') /= 1) there = join_path(folder_of(path), here)
    if (file_exists(here)) then
      s%wing_path = here
    else if (file_exists(there)) then
      s%wing_path = there
    else
      call s%config%complain(errors, 'Wing', 'file', quoted(here)//' does not exist, neither here nor beside '// &
                             'the input file')
    end if
  end subroutine find_wing

  subroutine read_material(s, errors, notices)
    type(static_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(message_list_t) :: mass_messages
    character(:), allocatable :: note
    real(rp) :: joint
    logical :: is_soft
    integer :: i
    associate (c => s%config, p => s%asked)
      p = default_params(s%wing)
      p%young = c%get_real('Wing', 'E')
      p%plate = c%get_real('Wing', 'D')
      p%k_vein = c%get_real('Wing', 'k_e')
      p%k_membrane = p%k_vein
      p%k_cross = p%k_vein
      p%cross_springs = c%get_word('Wing', 'cross_springs') == 'yes' .or. &
                        (c%get_word('Wing', 'cross_springs') == 'preset' .and. c%get_word('Wing', 'preset') == 'paper')
      joint = c%get_real('Wing', 'joint_stiffness')
      if (.not. joint > 0 .and. abs(joint + 1) > 0) &
        call c%complain(errors, 'Wing', 'joint_stiffness', 'must be positive, or -1: as the vein without the joint')
      p%joint = joint
      call read_parameters(s, errors)
      call membrane_note(p, note, is_soft)
      if (is_soft .and. size(s%wing%triangles) > 0) call notices%add(note)

      s%material%vein_density = c%get_real('Mass', 'vein_density')
  s%material%membrane_law = merge(MEMBRANE_BILINEAR, MEMBRANE_UNIFORM, c%get_word('Mass', 'membrane_law') == 'bilinear')
      s%material%membrane_mass = c%get_real('Mass', 'membrane_mass')
      s%material%areal_density = c%get_real('Mass', 'areal_density')
    end associate
    call lump_mass(s%wing, s%material, s%mass, mass_messages)
    s%has_mass = mass_messages%count() == 0
    do i = 1, mass_messages%count()
      call notices%add(mass_messages%text(i)//'; the mass is not reported')
    end do
  end subroutine read_material

  !> The pairs "name value" of [Wing] parameters.
  subroutine read_parameters(s, errors)
    type(static_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: text, problem, problems
    integer :: position, first, last
    logical :: found
    text = s%config%get_text('Wing', 'parameters')
    problems = ''
    position = 1
    do
      call next_word(text, ',', position, first, last, found)
      if (.not. found) exit
      call read_pair(text(first:last), s%asked, problem)
      if (allocated(problem)) problems = problems//'; '//problem
    end do
    if (len(problems) > 0) call s%config%complain(errors, 'Wing', 'parameters', problems(3:))
  end subroutine read_parameters

  subroutine read_pair(text, params, problem)
    character(*), intent(in) :: text
    type(solid_params_t), intent(inout) :: params
    character(:), allocatable, intent(out) :: problem
    type(parameter_t) :: known
    real(rp) :: value
    integer :: position, first, last, first_value, last_value, behind, end_behind, number
    logical :: has_name, has_value, has_more
    position = 1
    call next_word(text, BLANKS, position, first, last, has_name)
    call next_word(text, BLANKS, position, first_value, last_value, has_value)
    call next_word(text, BLANKS, position, behind, end_behind, has_more)
    if (.not. has_value .or. has_more) then
      problem = quoted(trim(adjustl(text)))//' is no pair of a name and a value'
      return
    end if
    associate (name => text(first:last))
      if (any(name == [character(9) :: 'E', 'D', 'thickness'])) then
        problem = quoted(name)//' has a key of its own: '//merge('E', 'D', name == 'E')
        return
      end if
      number = params%find(name)
      if (number == 0) then
        problem = quoted(name)//' is unknown; valid: '//names_of(params)
        return
      end if
      call parse_real(text(first_value:last_value), value, problem)
      if (allocated(problem)) return
      known = params%describe(number)
      if (known%is_log .and. .not. value > 0) then
        problem = quoted(name)//' must be positive'
      else
        call params%set(number, value)
      end if
    end associate
  end subroutine read_pair

  function names_of(params) result(text)
    type(solid_params_t), intent(in) :: params
    character(:), allocatable :: text
    type(parameter_t) :: known
    integer :: i
    text = ''
    do i = 1, params%count()
      known = params%describe(i)
      if (all(known%name /= [character(9) :: 'E', 'D', 'thickness'])) text = text//' | '//known%name
    end do
    text = text(4:)
  end function names_of

  subroutine read_loads(s, errors)
    type(static_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    type(failure_t) :: failure
    type(static_load_t), allocatable :: loads(:)
    real(rp), allocatable :: rows(:, :), points(:, :)
    character(:), allocatable :: problems
    integer :: i, n, point
    rows = s%config%get_matrix('Loads', 'forces')
    points = s%config%get_matrix('Loads', 'point_forces')
    n = size(rows, 1)
    allocate (loads(n + size(points, 1)))
    if (size(loads) == 0) call s%config%complain(errors, 'Loads', 'forces', &
                                                 'there are no loads; give rows of x y force, or point_forces')
    problems = ''
    if (n > 0 .and. size(s%wing%triangles) == 0) then
      problems = '; this wing has no membrane; use point_forces'
      n = 0
      deallocate (loads)
      allocate (loads(size(points, 1)))
    end if
    do i = 1, n
      call loads(i)%load%init(s%model)
      loads(i)%place = rows(i, 1:2)
      loads(i)%force(3) = rows(i, 3)
      failure = failure_t()
      call loads(i)%load%add_at(s%model, loads(i)%place, loads(i)%force, failure)
      if (failure%failed) then
        problems = problems//'; row '//number_text(i)//': the place '//number_text(rows(i, 1))//' '// &
                   number_text(rows(i, 2))//' m is not on the membrane'
      else
        call check_force(s%model, i, loads(i)%load, problems)
      end if
    end do
    if (len(problems) > 0) call s%config%complain(errors, 'Loads', 'forces', problems(3:))
    problems = ''
    do i = 1, size(points, 1)
      if (points(i, 1) < 0.5_rp .or. points(i, 1) > s%model%n_points + 0.5_rp .or. &
          abs(points(i, 1) - anint(points(i, 1))) > 0) then
        problems = problems//'; row '//number_text(i)//': '//number_text(points(i, 1))// &
                   ' is no point; valid: 1 to '//number_text(s%model%n_points)
        cycle
      end if
      point = nint(points(i, 1))
      associate (l => loads(n + i))
        call l%load%init(s%model)
        l%place = s%model%points(:2, point)
        l%force = points(i, 2:4)
        call l%load%add_point(point, l%force)
        call check_force(s%model, i, l%load, problems)
      end associate
    end do
    if (len(problems) > 0) call s%config%complain(errors, 'Loads', 'point_forces', problems(3:))
    call move_alloc(loads, s%loads)
  end subroutine read_loads

  !> A load must be able to move something.
  subroutine check_force(model, row, load, problems)
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: row
    type(load_t), intent(in) :: load
    character(:), allocatable, intent(inout) :: problems
    if (any(abs(load%force(:, model%movable)) > 0)) return
    if (any(abs(load%force) > 0)) then
      problems = problems//'; row '//number_text(row)//': the force acts on the clamped root only'
    else
      problems = problems//'; row '//number_text(row)//': the force is zero'
    end if
  end subroutine check_force
end module app_static_settings
