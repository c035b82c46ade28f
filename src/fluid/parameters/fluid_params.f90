! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the parameters of the fluid that the user sets; they do not change afterwards. The keys of each group are declared next
!> to its type.
module fluid_params
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fluid_initial_keys, only: check_initial, initial_keys, initial_params_t, FLOW_BACKUP, FLOW_BACKUP_FILE, FLOW_FILES, &
                                FLOW_MEAN, FLOW_RING
  use fluid_mean_keys, only: drop_idle_velocity, fix_mean_flow, mean_keys, mean_params_t, MEAN_FIXED, MEAN_FREE
  use fluid_resolution_keys, only: check_resolution, dealiasing_keys, notice_slow_sizes, resolution_keys, resolution_t
  use fluid_shapes, only: NO_SHAPE
  use fluid_solid_keys, only: box_t, check_solids, geometry_keys, penalization_keys, solids_t, walls_t, CHANNEL_NONE, &
                              MASK_EMPTY, MASK_INSECT, MASK_NONE
  use fluid_sponge_keys, only: check_sponge, sponge_keys, sponge_params_t
  use fluid_time_keys, only: stepping_t, time_keys, viscosity_keys, SCHEME_AB2, SCHEME_EULER, SCHEMES, SCHEME_RK2, SCHEME_RK4
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  use spectral_grid, only: grid_t, make_grid
  implicit none
  private
  public :: fluid_params_t, register_fluid_keys, read_fluid_keys, read_fluid_params, SCHEME_AB2, SCHEME_RK4, SCHEME_RK2, &
            SCHEME_EULER, SCHEMES

  type :: fluid_params_t
    type(grid_t) :: grid
    type(resolution_t) :: resolution
    type(box_t) :: box                !< as the user gives it
    real(rp) :: nu = 0                !< kinematic viscosity
    logical :: has_nu = .false.       !< the user gives it
    real(rp) :: vanishing_rate = 0    !< of spectral vanishing viscosity at the cut-off, AB2 only, 1/T
    logical :: is_spherical = .false. !< only modes inside the largest sphere in the truncation remain, AB2 only
    type(stepping_t) :: time
    type(initial_params_t) :: initial
    type(solids_t) :: solids
    type(walls_t) :: walls
    type(sponge_params_t) :: sponge
    type(mean_params_t) :: mean
  contains
    procedure :: channel_height
  end type fluid_params_t

contains

  !> Adds every key the fluid reads to `registry`.
  subroutine register_fluid_keys(registry)
    type(registry_t), intent(inout), target :: registry
    type(fluid_params_t) :: unused
    type(keys_t) :: keys
    keys = declaring(registry)
    call fluid_keys(keys, unused)
  end subroutine register_fluid_keys

  !> Takes the values of the keys, but derives nothing from them.
  subroutine read_fluid_keys(config, params)
    type(config_t), intent(in), target :: config
    type(fluid_params_t), intent(out) :: params
    type(keys_t) :: keys
    keys = reading(config)
    call fluid_keys(keys, params)
  end subroutine read_fluid_keys

  !> Declares and reads all keys, one section after the other.
  subroutine fluid_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(fluid_params_t), intent(inout) :: p
    call resolution_keys(keys, p%resolution)
    call geometry_keys(keys, p%box, p%solids)
    call dealiasing_keys(keys, p%resolution)
    call time_keys(keys, p%time)
    call viscosity_keys(keys, p%nu, p%has_nu)
    call initial_keys(keys, p%initial)
    call penalization_keys(keys, p%solids, p%walls)
    call sponge_keys(keys, p%sponge)
    call mean_keys(keys, p%mean)
  end subroutine fluid_keys

  !> Takes the fluid's parameters from `config`; adds mistakes that concern several keys to `errors`, doubts to `notices`.
  subroutine read_fluid_params(config, params, errors, draws_solids, notices)
    type(config_t), intent(in) :: config
    type(fluid_params_t), intent(out) :: params
    type(message_list_t), intent(inout) :: errors
    logical, intent(in), optional :: draws_solids !< moving solids are in the mask; if not given they are
    type(message_list_t), intent(inout), optional :: notices
    call read_fluid_keys(config, params)
    associate (solids => params%solids, walls => params%walls)
      params%grid = make_grid(max(params%resolution%n, 1), params%box%length)
      if (params%grid%is_2d) solids%centre(1) = 0 ! the plane itself: no lever arm across it
      walls%cylinder = solids%centre(2:3)
      call check_resolution(config, params%resolution, errors)
      if (present(notices)) call notice_slow_sizes(config, params%resolution, notices)
      call check_initial(config, params%initial, params%grid%is_2d, solids%size, errors)
      call check_solids(config, solids, walls, errors)
      if (solids%is_moving .and. present(draws_solids)) &
        solids%is_on = draws_solids .or. walls%channel /= CHANNEL_NONE .or. walls%has_cavity .or. solids%obstacle /= NO_SHAPE
    end associate
    call check_sponge(config, params%sponge, params%grid%n, errors, notices)
    call fix_mean_flow(config, params%mean, errors)
    if (params%walls%has_inflow) call set_channel_flow(config, params, errors)
    if (params%walls%channel == CHANNEL_NONE .and. &
        .not. any(params%initial%flow == [FLOW_MEAN, FLOW_RING, FLOW_FILES])) &
      call drop_idle_velocity(config, params%mean, any(params%initial%flow == [FLOW_BACKUP, FLOW_BACKUP_FILE]), notices)
    call check_fixed_step(config, params, errors)
  end subroutine read_fluid_params

  !> Checks that a prescribed step is stable for the explicit terms whose limit is known in advance.
  subroutine check_fixed_step(c, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: p
    type(message_list_t), intent(inout) :: errors
    character(100) :: text
    real(rp) :: limit
    if (p%time%dt_fixed <= 0) return
    limit = huge(limit)
    if (p%solids%is_on) limit = p%time%cfl_eta*p%solids%c_eta
    if (p%sponge%is_on) limit = min(limit, p%sponge%damping_time)
    if (p%time%dt_fixed <= limit) return
    write (text, '(a,es10.3)') 'the step is unstable: penalization (CFL_eta*eps) and sponge (eps_sponge) allow at most', limit
    call c%complain(errors, 'Time', 'dt_fixed', trim(text))
  end subroutine check_fixed_step

  !> Checks a channel with inflow and sets its mean flow: the mean velocity of the inflow along y, and none through its walls.
  subroutine set_channel_flow(c, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    character(*), parameter :: AXES = 'yz'
    integer :: i
    if (p%channel_height() <= 0) call c%complain(errors, 'Penalization', 'thick_wall', &
                                                 'the wall leaves no channel: it must be thinner than zl')
    if (p%walls%inflow_length <= 0 .or. p%walls%inflow_length >= p%grid%length(2)) &
      call c%complain(errors, 'Penalization', 'inflow_length', 'the inflow of turek needs a length between 0 and yl')
    if (all(p%solids%mask /= [MASK_NONE, MASK_EMPTY, MASK_INSECT])) &
      call c%complain(errors, 'Penalization', 'iMask', 'turek has its own cylinder; valid with it: none, empty, Insect')
    do i = 1, 2
      if (p%mean%kind(i + 1) /= MEAN_FREE) &
        call c%complain(errors, 'MeanFlow', 'iMeanFlow_'//AXES(i:i), 'the inflow of turek prescribes the mean flow')
    end do
    p%mean%kind(2:3) = MEAN_FIXED
    p%mean%velocity(2:3) = [p%walls%inflow_velocity*p%channel_height()/p%grid%length(3), 0.0_rp]
  end subroutine set_channel_flow

  !> Returns the distance [L] of the walls of a channel with normal z.
  pure real(rp) function channel_height(self)
    class(fluid_params_t), intent(in) :: self
    channel_height = self%grid%length(3) - self%walls%thickness
  end function channel_height
end module fluid_params
