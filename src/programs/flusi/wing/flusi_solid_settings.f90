! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads what `flusi --solid` must compute: it makes a mechanical model, its motion and its loads from the ini file, the wing
!> file and the kinematics file. It finds all mistakes of the user before the program computes or writes anything. SI units.
module flusi_solid_settings
  use base_constants, only: TWO_PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: word_of
  use base_text, only: number_text
  use common_wing_effects, only: refuse_root_compliance
  use common_wing_settings, only: read_damping, check_name, find_beside, load_wing
  use flusi_solid_loads, only: solid_loads_t
  use flusi_wing_sites, only: force_group_t, point_force_t, read_force_groups
  use fsi_body_motion, only: MOTION_FREE
  use fsi_body_motion_keys, only: read_body_motion
  use fsi_kinematics, only: wing_mount_t
  use fsi_kinematics_keys, only: kinematics_choices, kinematics_choices_t, motion_file, read_body, read_motion, read_mounts, SIDES
  use fsi_wing_frame, only: flapping_motion_t
  use fsi_wing_motion, only: wing_motion_t
  use io_broadcast_text, only: read_text_file
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  use io_registry, only: registry_t
  use simulation_output_params, only: output_params_t
  use simulation_solid_keys, only: load_keys, motion_keys, register_solid_keys, solid_choices_t, solid_keys, FRAMES, &
                                   FRAME_FLAPPING, FRAME_ROTATION, LAWS, ROTATION_NAMES
  use solid_inertia, only: inertia_t
  use solid_motion, only: motion_t, rotating_motion_t, steady_motion_t
  use solid_wing, only: wing_t
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: solid_settings_t, load_solid_settings

  integer, parameter :: MOST_SHAPES = 99999 !< their numbers have five digits

  !> Holds what a run of `flusi --solid` needs, read and checked.
  type, extends(solid_choices_t) :: solid_settings_t
    type(config_t) :: config
    type(wing_case_t) :: wing_case
    type(inertia_t) :: inertia
    class(motion_t), allocatable :: motion          !< along the axes of the wing file
    logical :: is_mirrored = .false.                !< the wing that flaps is the mirror image of the one in the file
    type(solid_loads_t) :: loads
    type(point_force_t), allocatable :: released(:) !< forces that bend the wing before time 0
    type(output_params_t) :: output                 !< times of shapes and backups, and when to stop
  end type solid_settings_t

contains

  !> Reads the ini file `path` into `s`. Adds all mistakes to `errors` and all remarks to `notices`; `s` is complete only if
  !> there is no mistake.
  subroutine load_solid_settings(path, flusi_compat, s, errors, notices)
    character(*), intent(in) :: path
    logical, intent(in) :: flusi_compat
    type(solid_settings_t), intent(out) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t) :: registry
    type(point_force_t), allocatable :: forces(:)
    logical :: found
    integer :: i
    call register_solid_keys(registry)
    call s%config%load_file(path, registry, errors, notices, flusi_compat)
    if (s%config%asks_for_unbuilt()) return
    call read_options(s, errors)
    select case (s%motion_type)
    case (FRAME_ROTATION)
      call read_rotation(s, errors)
    case (FRAME_FLAPPING)
      call read_flapping(s, errors, notices)
    case default
      call read_rest(s)
    end select
    call notice_idle_keys(s, notices)
    call load_wing(s%config, .true., s%wing_case, found, errors, notices)
    if (.not. found) return
    call mirror_motion(s%wing_case%wing, s%motion, s%is_mirrored)
    call refuse_root_compliance(s%config, s%wing_case%requested, errors)
    do i = 1, size(LAWS)
      call read_forces(s, 'Loads', trim(LAWS(i)%word), s%forces(i)%text, forces, errors)
      call s%loads%add(LAWS(i)%kind, forces)
    end do
    call read_forces(s, 'Initial', 'released', s%released_forces, s%released, errors)
    if (size(s%released) > 0 .and. s%mode > 0) &
      call s%config%complain(errors, 'Initial', 'mode', 'contradicts released: give one initial shape')
    if (s%mode > 3*s%wing_case%model%n_free) call s%config%complain(errors, 'Initial', 'mode', &
      'is larger than the number of modes of this wing, '//number_text(3*s%wing_case%model%n_free))
    if (.not. s%wing_case%has_mass) return
    call s%inertia%init(s%wing_case%model, s%wing_case%mass%nodal)
    call read_damping(s%config, s%wing_case%model, s%inertia)
  end subroutine load_solid_settings

  !> Reads motion, load, time step and output.
  subroutine read_options(s, errors)
    type(solid_settings_t), intent(inout), target :: s
    type(message_list_t), intent(inout) :: errors
    type(keys_t) :: keys
    keys = reading(s%config)
    call motion_keys(keys, s%solid_choices_t)
    call load_keys(keys, s%solid_choices_t)
    call solid_keys(keys, s%solid_choices_t)
    s%loads%ramp = s%load_ramp
    s%loads%frequency = s%load_frequency
    s%loads%phase = s%load_phase
    s%output%fields%interval = s%t_save
    s%output%backup = s%backup
    s%output%limits = s%limits
    s%output%progress_seconds = s%progress_seconds
    associate (c => s%config)
      call check_name(c, s%name, errors)
      if (s%t_max > MOST_SHAPES*s%output%fields%interval) &
        call c%complain(errors, 'Saving', 't_save', 'is too short: the run would write more than '// &
                        number_text(MOST_SHAPES)//' shapes; set a longer interval')
      if (s%dt > s%t_max .and. s%t_max > 0) & ! 0: its mistake has been reported
        call c%complain(errors, 'Time', 'dt', 'is longer than the run; valid: at most t_max')
    end associate
  end subroutine read_options

  !> Adds a notice for each key that belongs to another type of motion. Such keys are allowed but have no effect.
  subroutine notice_idle_keys(s, notices)
    type(solid_settings_t), intent(in) :: s
    type(message_list_t), intent(inout) :: notices
    type(kinematics_choices_t) :: kinematics
    integer :: i
    kinematics = kinematics_choices(s%config)
    do i = 1, size(ROTATION_NAMES)
      if (s%motion_type /= FRAME_ROTATION .and. s%rotation%given(i)) &
        call s%config%complain(notices, 'Motion', trim(ROTATION_NAMES(i)), 'has no effect with type = '// &
                               word_of(FRAMES, s%motion_type))
    end do
    do i = 1, size(SIDES)
      if (s%motion_type /= FRAME_FLAPPING .and. kinematics%motion(i)%is_given) &
        call s%config%complain(notices, 'Insects', 'FlappingMotion_'//trim(SIDES(i)), 'has no effect with [Motion] type = '// &
                               word_of(FRAMES, s%motion_type))
    end do
  end subroutine notice_idle_keys

  !> Sets the motion of a wing frame at rest.
  subroutine read_rest(s)
    type(solid_settings_t), intent(inout) :: s
    type(steady_motion_t) :: rest
    rest%frame%gravity = s%gravity
    allocate (s%motion, source=rest)
  end subroutine read_rest

  !> Sets the motion of a wing frame that turns about a fixed axis.
  subroutine read_rotation(s, errors)
    type(solid_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    type(rotating_motion_t) :: rotation
    associate (c => s%config, given => s%rotation)
      rotation%axis = given%axis
      if (norm2(rotation%axis) > 0) then
        rotation%axis = rotation%axis/norm2(rotation%axis)
      else
        call c%complain(errors, 'Motion', 'axis', 'has no direction; valid: three reals that are not all 0')
      end if
      rotation%through = given%through
      rotation%rate = TWO_PI*given%frequency
      rotation%ramp = given%ramp
      rotation%gravity = s%gravity
      if (.not. abs(rotation%rate) > 0) &
        call c%complain(errors, 'Motion', 'frequency', 'is 0; valid: a frequency for type = rotation')
    end associate
    allocate (s%motion, source=rotation)
  end subroutine read_rotation

  !> Reads the motion of one wing of [Insects].
  subroutine read_flapping(s, errors, notices)
    type(solid_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(flapping_motion_t) :: flapping
    type(wing_mount_t) :: mounts(2)
    type(wing_motion_t) :: motions(2)
    type(message_list_t) :: both
    real(rp), parameter :: AT_CENTRE(3) = 0.0_rp
    character(:), allocatable :: file, text, problem, key
    associate (c => s%config, wing => s%wing)
      key = 'FlappingMotion_'//trim(SIDES(wing))
      call read_body(c, flapping%body)
      call read_mounts(c, AT_CENTRE, mounts, motions, both) ! its check of overlapping wings cannot fail with one wing
      flapping%mount = mounts(wing)
      flapping%motion = motions(wing)
      flapping%length = s%unit_length
      flapping%frequency = s%unit_frequency
      flapping%gravity = s%gravity
      call read_body_motion(c, flapping%body, s%t_max*flapping%frequency, flapping%motion%frequency, flapping%carrier, &
                            errors, notices)
      if (flapping%carrier%kind == MOTION_FREE) call c%complain(errors, 'Insects', 'BodyMotion', &
        'is free_flight, which needs a flow; valid here: every other motion')
      text = ''
      file = motion_file(c, wing)
      if (file /= '') call find_beside(c%file_name(), motion_file(c, wing), file, problem)
      if (.not. allocated(problem) .and. file /= '') call read_text_file(file, text, problem)
      if (allocated(problem)) then
        call c%complain(errors, 'Insects', key, problem)
      else
        call read_motion(c, wing, text, file, flapping%motion, errors, notices)
        call flapping%motion%check_span(s%t_max*flapping%frequency, 'the motion of the '//trim(SIDES(wing))//' wing', errors)
      end if
    end associate
    allocate (s%motion, source=flapping)
  end subroutine read_flapping

  !> Mirrors the motion if necessary. The mechanics uses the axes of the wing file. If z of the flapping wing points to another
  !> side, this wing is the mirror image of the wing in the file, which then performs the mirrored motion.
  subroutine mirror_motion(wing, motion, is_mirrored)
    type(wing_t), intent(in) :: wing
    class(motion_t), intent(inout) :: motion
    logical, intent(out) :: is_mirrored
    is_mirrored = .false.
    select type (motion)
    type is (flapping_motion_t)
      is_mirrored = motion%mount%mirrors(wing%z_is_dorsal())
      motion%is_mirrored = is_mirrored
    end select
  end subroutine mirror_motion

  !> Reads the forces of `key`, all of which act at the same time.
  subroutine read_forces(s, section, key, text, forces, errors)
    type(solid_settings_t), intent(in) :: s
    character(*), intent(in) :: section, key, text
    type(point_force_t), allocatable, intent(out) :: forces(:)
    type(message_list_t), intent(inout) :: errors
    type(force_group_t), allocatable :: groups(:)
    integer :: i
    call read_force_groups(s%config, section, key, text, s%wing_case, groups, errors)
    allocate (forces(0))
    do i = 1, size(groups)
      forces = [forces, groups(i)%forces]
    end do
  end subroutine read_forces
end module flusi_solid_settings
