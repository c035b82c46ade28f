! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads thickness and smoothing of wings in the mask, with FLUSI's names.
!>
!> [Insects] WingThickness is the whole thickness t of a rigid wing, [Flexible_wing] t_wing the half of it; here
!> both name the same sheet. Not given, t = 4 max(dx) and h = max(dx).
module fsi_mask_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use io_config, only: config_t
  use io_registry, only: registry_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: register_mask_keys, read_mask_keys

  character(*), parameter :: RIGID = 'Insects', FLEXIBLE = 'Flexible_wing'
  character(*), parameter :: TOO_THIN = 'makes wings thinner than the grid spacing: the mask would miss them'

contains

  !> Declares the keys.
  subroutine register_mask_keys(registry)
    type(registry_t), intent(inout) :: registry
    call registry%add_length(RIGID, 'WingThickness', '4 max(dx)', 'thickness of the wings in the mask', &
                             unit='L', above=0.0_rp)
    call registry%add_length(FLEXIBLE, 't_wing', '2 max(dx)', 'half the thickness of the wings in the mask', &
                             unit='L', above=0.0_rp)
    call registry%add_length(FLEXIBLE, 'wing_smoothing', 'max(dx)', 'half the width of the step of the mask', &
                             unit='L', above=0.0_rp)
  end subroutine register_mask_keys

  !> Half-thickness t/2 and smoothing h [length]; adds what contradicts itself to `errors`. The smoothing is at most t/2,
  !> with a notice where that is less than what is given or max(dx), so that chi reaches 1; where wings may be soft, as
  !> FLUSI draws them, h is what it is.
  subroutine read_mask_keys(config, grid, half_thickness, smoothing, errors, notices, may_be_soft)
    type(config_t), intent(in) :: config
    type(grid_t), intent(in) :: grid
    real(rp), intent(out) :: half_thickness, smoothing
    type(message_list_t), intent(inout) :: errors, notices
    logical, intent(in), optional :: may_be_soft
    logical :: given(2), is_soft
    is_soft = .false.
    if (present(may_be_soft)) is_soft = may_be_soft
    given = [config%is_given(RIGID, 'WingThickness'), config%is_given(FLEXIBLE, 't_wing')]
    half_thickness = 2*grid%max_spacing()
    smoothing = grid%max_spacing()
    if (given(2)) half_thickness = config%get_real(FLEXIBLE, 't_wing')
    if (given(1)) half_thickness = config%get_real(RIGID, 'WingThickness')/2
    if (all(given)) then
      if (abs(half_thickness - config%get_real(FLEXIBLE, 't_wing')) > 1.0e-9_rp*half_thickness) &
        call config%complain(errors, FLEXIBLE, 't_wing', 'is not the half of [Insects] WingThickness; give one of them')
    end if
    if (config%is_given(FLEXIBLE, 'wing_smoothing')) smoothing = config%get_real(FLEXIBLE, 'wing_smoothing')
    if (smoothing > half_thickness) then
      if (2*half_thickness < grid%max_spacing() .and. given(1)) then
        call config%complain(errors, RIGID, 'WingThickness', TOO_THIN)
      else if (2*half_thickness < grid%max_spacing()) then
        call config%complain(errors, FLEXIBLE, 't_wing', TOO_THIN)
      else if (is_soft) then
        call notices%add('[Insects] wing_edges = flusi: the step of the mask is wider than the wings are thick, so that '// &
                         'chi does not reach 1 and some of the flow passes through them; wing_edges = auto avoids it')
      else
        smoothing = half_thickness
        call config%complain(notices, FLEXIBLE, 'wing_smoothing', 'is half the thickness of the wings, not '// &
                             trim(merge('what is given', 'max(dx)      ', config%is_given(FLEXIBLE, 'wing_smoothing')))// &
                             ', so that chi reaches 1')
      end if
    end if
  end subroutine read_mask_keys
end module fsi_mask_keys
