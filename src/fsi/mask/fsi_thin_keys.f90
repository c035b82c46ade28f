! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads how the flow represents the wings: as sheets with a thickness in the mask, or as surfaces without thickness.
module fsi_thin_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use fluid_params, only: fluid_params_t, SCHEME_AB2
  use fluid_point_reader, only: can_read
  use fluid_resolution_keys, only: dealiasing_keys, resolution_t
  use fluid_time_keys, only: stepping_t, time_keys, ALSO_NOTHING
  use fsi_mask_keys, only: mask_choices, mask_choices_t
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  use spectral_grid, only: grid_t
  use spectral_sticks, only: sphere_radius, DEALIAS_ELLIPSOID
  use spectral_window, only: WINDOW_WIDTH
  implicit none
  private
  public :: thin_params_t, thin_keys, read_thin_keys, surface_choice, wants_thin_wings, prepare_thin_flow

  character(*), parameter :: SECTION = 'Insects', STEPPER = 'iTimeMethodFluid', TRUNCATION = 'iDealias'

  !> Ways to hold the response of a wing's markers: on one rank, on the ranks of a group, or the faster of both.
  integer, parameter, public :: SHARING_AUTO = 1, SHARING_ONE = 2, SHARING_GROUP = 3
  type(named_kind_t), parameter :: SHARINGS(3) = [named_kind_t('auto', SHARING_AUTO), named_kind_t('one', SHARING_ONE), &
                                                  named_kind_t('group', SHARING_GROUP)]

  !> Representations of wings in the flow.
  integer, parameter, public :: SURFACE_AUTO = 1, SURFACE_THIN = 2, SURFACE_PENALIZED = 3
  type(named_kind_t), parameter :: SURFACES(3) = [named_kind_t('auto', SURFACE_AUTO), named_kind_t('thin', SURFACE_THIN), &
                                                  named_kind_t('penalized', SURFACE_PENALIZED)]

  !> Choices of the user for wings without thickness.
  type :: thin_params_t
    integer :: surface = SURFACE_AUTO
    logical :: is_thin = .false. !< resulting choice: the wings have no thickness
    real(rp) :: spacing = 0   !< requested distance of markers, L
    real(rp) :: viscosity = 0 !< coefficient c of the vanishing viscosity
    integer :: slip_interval = 1 !< steps from one measurement of the slip to the next
    integer :: sharing = SHARING_AUTO !< whether ranks share the response of a wing
    real(rp) :: response_limit = 0.1_rp !< a marker that has left the shape of the response by so many spacings renews it
  end type thin_params_t

contains

  !> Declares and reads the keys.
  subroutine thin_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(thin_params_t), intent(inout) :: p
    call keys%section(SECTION)
    call keys%kind('surface', p%surface, 'auto', SURFACES, 'thin: wings are surfaces without thickness; penalized: '// &
                   'wings are sheets in the mask; auto: penalized if the file sets WingThickness, t_wing or wing_smoothing, '// &
                   'another scheme than AB2 or an iDealias other than 1, else thin')
    call keys%real('marker_spacing', p%spacing, 2.0_rp, 'surface = thin: distance of the markers, in max(dx); closer markers '// &
                   'make the forces alternate, markers farther apart let the flow through', min=1.5_rp, max=2.5_rp)
    call keys%real('surface_viscosity', p%viscosity, 0.3_rp, 'surface = thin: c of the spectral vanishing viscosity, which '// &
                   'damps the largest wavenumber K at the rate c u K, the share nu K^2 of viscosity included; u: sum of the '// &
                   'mean speeds of the wing tip, the body and the stream', min=0.0_rp)
    call keys%integer('slip_interval', p%slip_interval, 1, 'surface = thin: steps between two records of slip.t, which has '// &
                      'the slip after the forces and the powers that the flow receives and the wings lose; the next step '// &
                      'of the flow reads it at the markers, about 2 % of a step; with unequal spacings or less than 16 points '// &
                      'in a direction transforms sample it, 8 %', unit='steps', min=1)
    call keys%kind('marker_response', p%sharing, 'auto', SHARINGS, 'surface = thin: which ranks compute the forces at the '// &
                   'markers of a wing; one: one rank; group: a group of ranks together; auto: a group if there are eight '// &
                   'ranks for each wing and a wing has a thousand markers or more, else one rank')
    call keys%real('marker_response_limit', p%response_limit, 0.1_rp, 'surface = thin: a wing that bends needs a new response '// &
                   'of the flow when a marker has moved this far from the shape of the last response, in spacings of the '// &
                   'markers; 0.2 doubles the slip; choose it if a wing has a thousand markers or more, since responses then '// &
                   'take most of the time', min=0.01_rp, max=0.5_rp)
  end subroutine thin_keys

  !> Takes the values of the keys from `config`.
  subroutine read_thin_keys(config, grid, params, notices)
    type(config_t), intent(in), target :: config
    type(grid_t), intent(in) :: grid
    type(thin_params_t), intent(out) :: params
    type(message_list_t), intent(inout) :: notices
    type(mask_choices_t) :: mask
    type(keys_t) :: keys
    keys = reading(config)
    call thin_keys(keys, params)
    params%spacing = params%spacing*grid%max_spacing()
    params%is_thin = wants_thin_wings(config)
    mask = mask_choices(config)
    if (params%is_thin .and. mask%say_thickness()) &
      call notices%add('[Insects] WingThickness, t_wing and wing_smoothing have no effect with surface = thin')
  end subroutine read_thin_keys

  !> Returns the representation of the wings that the user requests, SURFACE_*.
  integer function surface_choice(config) result(surface)
    type(config_t), intent(in), target :: config
    type(thin_params_t) :: choices
    type(keys_t) :: keys
    keys = reading(config)
    call thin_keys(keys, choices)
    surface = choices%surface
  end function surface_choice

  !> Tells whether wings, if there are any, have no thickness in the flow.
  logical function wants_thin_wings(config) result(wants)
    type(config_t), intent(in), target :: config
    type(mask_choices_t) :: mask
    type(stepping_t) :: stepping
    type(resolution_t) :: resolution
    type(keys_t) :: keys
    integer :: surface
    surface = surface_choice(config)
    wants = surface == SURFACE_THIN
    if (surface /= SURFACE_AUTO) return
    mask = mask_choices(config)
    keys = reading(config)
    call time_keys(keys, stepping)
    call dealiasing_keys(keys, resolution)
    wants = .not. mask%say_thickness() .and. stepping%scheme == SCHEME_AB2 .and. stepping%also == ALSO_NOTHING .and. &
            resolution%dealias == DEALIAS_ELLIPSOID
  end function wants_thin_wings

  !> Prepares the flow for wings without thickness that move at `speed` [L/T] relative to it. The vanishing viscosity adds the
  !> difference of c speed K and nu K^2, if it is positive. With equal spacings, and 16 points or more in each
  !> direction, the flow keeps only modes |k| < K.
  !> Reports settings that the method does not support.
  subroutine prepare_thin_flow(config, params, speed, fluid, errors, notices)
    type(config_t), intent(in) :: config
    type(thin_params_t), intent(in) :: params
    real(rp), intent(in) :: speed
    type(fluid_params_t), intent(inout) :: fluid
    type(message_list_t), intent(inout) :: errors, notices
    real(rp), parameter :: LARGEST_CFL = 0.5_rp
    character(2), parameter :: POINTS(3) = ['nx', 'ny', 'nz']
    real(rp) :: k
    integer :: i
    ! Forces are proportional to slip over dt. In a tiny step the remaining slip of the previous step would therefore cause a large
    ! force.
    fluid%time%even_end = .true.
    k = sphere_radius(fluid%grid)
    fluid%vanishing_rate = max(0.0_rp, params%viscosity*speed*k - fluid%nu*k**2)
    ! The pass of the flow through space can then read the slip (fluid_point_reader). Unequal spacings would lose much of the
    ! truncation.
    fluid%is_spherical = can_read(fluid%grid)
    if (fluid%time%cfl > LARGEST_CFL .and. fluid%time%dt_fixed <= 0) &
      call notices%add('[Time] CFL is above 0.5: flows with wings without thickness may become unstable; 0.45 is safe')
    if (fluid%time%scheme /= SCHEME_AB2) call config%complain(errors, 'Time', STEPPER, &
                                                         'wings without thickness ([Insects] surface = thin) need AB2')
    if (fluid%resolution%dealias /= DEALIAS_ELLIPSOID) &
      call config%complain(errors, 'Dealiasing', TRUNCATION, &
                           'wings without thickness ([Insects] surface = thin) need iDealias = 1')
    do i = merge(2, 1, fluid%grid%is_2d), 3
      if (fluid%grid%n(i) < WINDOW_WIDTH) call config%complain(errors, 'Resolution', POINTS(i), &
                                        'wings without thickness ([Insects] surface = thin) need at least 8 points')
    end do
  end subroutine prepare_thin_flow
end module fsi_thin_keys
