! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads what `flusi --static` must compute: it makes a mechanical model and its loads from the ini file and the wing file. It
!> finds all mistakes of the user before the program computes or writes anything. SI units.
module flusi_static_settings
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use common_wing_effects, only: refuse_root_compliance
  use common_wing_settings, only: check_name, load_wing
  use flusi_wing_sites, only: add_force, force_group_t, read_force_groups
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  use io_registry, only: registry_t
  use simulation_static_keys, only: register_static_keys, static_choices_t, static_keys
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: static_settings_t, load_static_settings

  !> Holds one load of the list.
  type :: static_load_t
    type(load_t) :: load                   !< all forces of the load
    real(rp), allocatable :: applied(:, :) !< (3, n_all) [N] its forces without weight; the weight if there are none
    real(rp) :: site(2) = 0               !< [m] of the first force, on the unloaded wing
    real(rp) :: force(3) = 0               !< [N] sum of the applied forces
    real(rp) :: magnitude = 0              !< [N] sum of the magnitudes
  end type static_load_t

  !> Holds what a run of `flusi --static` needs, read and checked.
  type, extends(static_choices_t) :: static_settings_t
    type(config_t) :: config
    type(wing_case_t) :: wing_case
    type(static_load_t), allocatable :: loads(:)
  end type static_settings_t

contains

  !> Reads the ini file `path` into `s`. Adds all mistakes to `errors` and all remarks to `notices`; `s` is complete only if
  !> there is no mistake.
  subroutine load_static_settings(path, flusi_compat, s, errors, notices)
    character(*), intent(in) :: path
    logical, intent(in) :: flusi_compat
    type(static_settings_t), intent(out) :: s
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t) :: registry
    logical :: found
    call register_static_keys(registry)
    call s%config%load_file(path, registry, errors, notices, flusi_compat)
    if (s%config%asks_for_unbuilt()) return
    call read_options(s, errors)
    allocate (s%loads(0))
    call load_wing(s%config, norm2(s%gravity) > 0 .or. s%n_modes > 0, s%wing_case, found, errors, notices)
    if (found) call read_loads(s, errors)
  end subroutine load_static_settings

  !> Reads the options of the static solver.
  subroutine read_options(s, errors)
    type(static_settings_t), intent(inout), target :: s
    type(message_list_t), intent(inout) :: errors
    type(keys_t) :: keys
    keys = reading(s%config)
    call static_keys(keys, s%static_choices_t)
    call check_name(s%config, s%name, errors)
  end subroutine read_options

  !> Reads all loads: the rows of forces, the rows of point_forces, and the list. Adds the weight to each of them.
  subroutine read_loads(s, errors)
    type(static_settings_t), intent(inout) :: s
    type(message_list_t), intent(inout) :: errors
    type(force_group_t), allocatable :: groups(:)
    integer :: i, n, m
    call read_force_groups(s%config, 'Loads', 'named_forces', s%named_forces, s%wing_case, groups, errors)
    n = size(s%forces, 1)
    m = size(s%point_forces, 1)
    if (n > 0 .and. size(s%wing_case%wing%triangles) == 0) then
      call s%config%complain(errors, 'Loads', 'forces', 'this wing has no membrane; use point_forces or named_forces')
      return
    end if
    deallocate (s%loads)
    allocate (s%loads(max(n + m + size(groups), merge(1, 0, norm2(s%gravity) > 0))))
    if (size(s%loads) == 0 .and. s%n_modes == 0) &
      call s%config%complain(errors, 'Loads', 'forces', 'there are no loads; give rows of x y force, point_forces, '// &
                             'named_forces, gravity, or [Modes] modes')
    do i = 1, size(s%loads)
      call s%loads(i)%load%init(s%wing_case%model)
      allocate (s%loads(i)%applied(3, s%wing_case%model%n_all), source=0.0_rp)
    end do
    call read_rows(s, s%forces, s%loads(:n), errors)
    call read_points(s, s%point_forces, s%loads(n + 1:n + m), errors)
    do i = 1, size(groups)
      call take_group(s%wing_case%model, groups(i), s%loads(n + m + i))
      if (.not. any(abs(s%loads(n + m + i)%load%force) > 0) .and. size(groups(i)%forces) > 1) &
        call s%config%complain(errors, 'Loads', 'named_forces', 'the forces of load '//number_text(i)//' cancel')
    end do
    if (s%n_modes > 0) call refuse_root_compliance(s%config, s%wing_case%requested, errors)
    if (errors%count() > 0) return ! after mistakes the mass may be missing
    do i = 1, size(s%loads)
      call complete(s, s%loads(i))
    end do
  end subroutine read_loads

  !> Reads rows of the form: x y force.
  subroutine read_rows(s, rows, loads, errors)
    type(static_settings_t), intent(in) :: s
    real(rp), intent(in) :: rows(:, :)
    type(static_load_t), intent(inout) :: loads(:)
    type(message_list_t), intent(inout) :: errors
    type(failure_t) :: failure
    character(:), allocatable :: problems
    integer :: i
    problems = ''
    do i = 1, size(loads)
      loads(i)%site = rows(i, 1:2)
      loads(i)%force(3) = rows(i, 3)
      failure = failure_t()
      call loads(i)%load%add_at(s%wing_case%model, loads(i)%site, loads(i)%force, failure)
      if (failure%failed) then
        problems = problems//'; row '//number_text(i)//': the place '//number_text(rows(i, 1))//' '// &
                   number_text(rows(i, 2))//' m is not on the membrane'
      else
        call check_force(s%wing_case%model, i, loads(i)%load, problems)
      end if
    end do
    if (len(problems) > 0) call s%config%complain(errors, 'Loads', 'forces', problems(3:))
  end subroutine read_rows

  !> Reads rows of the form: point fx fy fz.
  subroutine read_points(s, points, loads, errors)
    type(static_settings_t), intent(in) :: s
    real(rp), intent(in) :: points(:, :)
    type(static_load_t), intent(inout) :: loads(:)
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: problems
    integer :: i, point
    problems = ''
    associate (model => s%wing_case%model)
      do i = 1, size(loads)
        if (points(i, 1) < 0.5_rp .or. points(i, 1) > model%n_points + 0.5_rp .or. &
            abs(points(i, 1) - anint(points(i, 1))) > 0) then
          problems = problems//'; row '//number_text(i)//': '//number_text(points(i, 1))// &
                     ' is no point; valid: 1 to '//number_text(model%n_points)
          cycle
        end if
        point = nint(points(i, 1))
        loads(i)%site = model%points(:2, point)
        loads(i)%force = points(i, 2:4)
        call loads(i)%load%add_point(point, loads(i)%force)
        call check_force(model, i, loads(i)%load, problems)
      end do
    end associate
    if (len(problems) > 0) call s%config%complain(errors, 'Loads', 'point_forces', problems(3:))
  end subroutine read_points

  !> Adds forces that act at the same time to `load`.
  subroutine take_group(model, group, load)
    type(solid_model_t), intent(in) :: model
    type(force_group_t), intent(in) :: group
    type(static_load_t), intent(inout) :: load
    integer :: k
    do k = 1, size(group%forces)
      call add_force(group%forces(k), 1.0_rp, load%load%force)
      load%force = load%force + group%forces(k)%force
    end do
    associate (site => group%forces(1)%site)
      load%site = matmul(model%points(:2, site%points(:site%n)), site%weights(:site%n))
    end associate
  end subroutine take_group

  !> Adds the weight. The weight counts as the applied force only if there is no other force.
  subroutine complete(s, load)
    type(static_settings_t), intent(in) :: s
    type(static_load_t), intent(inout) :: load
    integer :: i
    load%applied = load%load%force
    if (norm2(s%gravity) > 0) then
      call load%load%add_gravity(s%wing_case%mass%nodal, s%gravity)
      if (.not. any(abs(load%applied) > 0)) then
        load%applied = load%load%force
        load%site = s%wing_case%mass%centre(:2)
        load%force = s%wing_case%mass%total*s%gravity
      end if
    end if
    do i = 1, size(load%applied, 2)
      load%magnitude = load%magnitude + norm2(load%applied(:, i))
    end do
  end subroutine complete

  !> Adds a problem if the load cannot move any point.
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
end module flusi_static_settings
