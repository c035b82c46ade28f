! SPDX-License-Identifier: GPL-3.0-or-later
!> How the flow sees the wings: as sheets of a thickness in the mask, or as surfaces without thickness.
module fsi_thin_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use fluid_params, only: fluid_params_t, SCHEME_AB2
  use io_config, only: config_t
  use io_registry, only: registry_t
  use spectral_grid, only: grid_t
  use spectral_sticks, only: sphere_radius
  use spectral_window, only: WINDOW_WIDTH
  implicit none
  private
  public :: thin_params_t, register_thin_keys, read_thin_keys, prepare_thin_flow

  character(*), parameter :: SECTION = 'Insects'

  !> Choices of the user for wings without thickness.
  type :: thin_params_t
    logical :: is_thin = .false.
    real(rp) :: spacing = 0   !< wanted between markers, L
    real(rp) :: viscosity = 0 !< coefficient c of the vanishing viscosity
  end type thin_params_t

contains

  !> Declares the keys.
  subroutine register_thin_keys(registry)
    type(registry_t), intent(inout) :: registry
    call registry%add_word(SECTION, 'surface', 'penalized', 'thin|penalized', &
                           'how the flow sees the wings: as surfaces without thickness, or as sheets in the mask')
    call registry%add_real(SECTION, 'marker_spacing', 2.0_rp, 'surface = thin: distance of the markers, in max(dx); '// &
                           'closer ones make forces that alternate, others let the flow through', min=1.5_rp, max=2.5_rp)
    call registry%add_real(SECTION, 'surface_viscosity', 0.3_rp, 'surface = thin: vanishing viscosity; the largest '// &
                           'wavenumber K is damped at the rate c (u_tip + u_inf) K, of which nu K^2 is a part', &
                           min=0.0_rp)
  end subroutine register_thin_keys

  !> Takes the keys from `config`.
  subroutine read_thin_keys(config, grid, params)
    type(config_t), intent(in) :: config
    type(grid_t), intent(in) :: grid
    type(thin_params_t), intent(out) :: params
    params%is_thin = config%get_word(SECTION, 'surface') == 'thin'
    params%spacing = config%get_real(SECTION, 'marker_spacing')*grid%max_spacing()
    params%viscosity = config%get_real(SECTION, 'surface_viscosity')
  end subroutine read_thin_keys

  !> Prepares the flow for wings without thickness that move at `speed` [L/T] relative to it. It has no mask unless walls
  !> need one. The vanishing viscosity adds to nu K^2 what is missing to c speed K. Reports settings that the method does
  !> not support.
  subroutine prepare_thin_flow(config, params, speed, fluid, errors)
    type(config_t), intent(in) :: config
    type(thin_params_t), intent(in) :: params
    real(rp), intent(in) :: speed
    type(fluid_params_t), intent(inout) :: fluid
    type(message_list_t), intent(inout) :: errors
    character(2), parameter :: POINTS(3) = ['nx', 'ny', 'nz']
    real(rp) :: k
    integer :: i
    fluid%penalized = fluid%channel /= 'no' .or. fluid%cavity
    k = sphere_radius(fluid%grid)
    fluid%vanishing_rate = max(0.0_rp, params%viscosity*speed*k - fluid%nu*k**2)
    if (fluid%scheme /= SCHEME_AB2) call config%complain(errors, 'Time', 'iTimeMethodFluid', &
                                                         'wings without thickness ([Insects] surface = thin) need AB2')
    if (fluid%dealias /= 'ellipsoid') &
      call config%complain(errors, 'Dealiasing', 'iDealias', 'wings without thickness ([Insects] surface = thin) need 1')
    if (fluid%grid%is_2d) call config%complain(errors, SECTION, 'surface', 'thin needs a flow in space, nx > 1; valid '// &
                                               'with nx = 1: penalized')
    do i = merge(2, 1, fluid%grid%is_2d), 3
      if (fluid%grid%n(i) < WINDOW_WIDTH) call config%complain(errors, 'Resolution', POINTS(i), &
                                        'wings without thickness ([Insects] surface = thin) need at least 8 points')
    end do
  end subroutine prepare_thin_flow
end module fsi_thin_keys
