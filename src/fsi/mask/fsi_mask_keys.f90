! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads thickness and smoothing of wings in the mask, with FLUSI's names.
!>
!> [Insects] WingThickness is the whole thickness t of a rigid wing, [Flexible_wing] t_wing the half of it; here both describe the
!> same sheet. By default t = 4 max(dx) and h = max(dx).
module fsi_mask_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use io_config, only: config_t
  use io_keys, only: keys_t, reading
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: mask_choices_t, mask_choices, mask_keys, read_mask_keys

  character(*), parameter :: RIGID = 'Insects', FLEXIBLE = 'Flexible_wing'
  character(*), parameter :: TOO_THIN = 'makes wings thinner than the grid spacing: the mask would miss them'

  type :: mask_choices_t
    real(rp) :: thickness = 0, half = 0, smoothing = 0 !< L
    logical :: has_thickness = .false., has_half = .false., has_smoothing = .false.
  contains
    procedure :: say_thickness => choices_say_thickness
  end type mask_choices_t

contains

  !> Declares and reads the keys of the mask of the wings.
  subroutine mask_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(mask_choices_t), intent(inout) :: c
    call keys%section(RIGID)
    call keys%length('WingThickness', c%thickness, '4 max(dx)', 'thickness of the wings in the mask', unit='L', above=0.0_rp, &
                     given=c%has_thickness)
    call keys%section(FLEXIBLE)
    call keys%length('t_wing', c%half, '2 max(dx)', 'half the thickness of the wings in the mask', unit='L', above=0.0_rp, &
                     given=c%has_half)
    call keys%length('wing_smoothing', c%smoothing, 'max(dx)', 'half the width of the smoothing layer of the mask at the wings', &
                     unit='L', above=0.0_rp, &
                     given=c%has_smoothing)
  end subroutine mask_keys

  !> Returns what the user chose.
  function mask_choices(config) result(c)
    type(config_t), intent(in), target :: config
    type(mask_choices_t) :: c
    type(keys_t) :: keys
    keys = reading(config)
    call mask_keys(keys, c)
  end function mask_choices

  !> Tells whether the file gives the thickness of the wings.
  pure logical function choices_say_thickness(self) result(say)
    class(mask_choices_t), intent(in) :: self
    say = self%has_thickness .or. self%has_half .or. self%has_smoothing
  end function choices_say_thickness

  !> Finds the half-thickness t/2 and the smoothing h [L]. Adds contradictions to `errors`. The smoothing is at most t/2, so that
  !> chi reaches 1, with a notice if this is less than the given value or max(dx). Wings that FLUSI draws with a soft mask keep
  !> their h.
  subroutine read_mask_keys(config, grid, half_thickness, smoothing, errors, notices, may_be_soft)
    type(config_t), intent(in) :: config
    type(grid_t), intent(in) :: grid
    real(rp), intent(out) :: half_thickness, smoothing
    type(message_list_t), intent(inout) :: errors, notices
    logical, intent(in), optional :: may_be_soft
    type(mask_choices_t) :: c
    logical :: is_soft
    is_soft = .false.
    if (present(may_be_soft)) is_soft = may_be_soft
    c = mask_choices(config)
    half_thickness = 2*grid%max_spacing()
    smoothing = grid%max_spacing()
    if (c%has_half) half_thickness = c%half
    if (c%has_thickness) half_thickness = c%thickness/2
    if (c%has_half .and. c%has_thickness) then
      if (abs(half_thickness - c%half) > 1.0e-9_rp*half_thickness) &
        call config%complain(errors, FLEXIBLE, 't_wing', 'is not half of [Insects] WingThickness; give only one of them')
    end if
    if (c%has_smoothing) smoothing = c%smoothing
    if (smoothing > half_thickness) then
      if (2*half_thickness < grid%max_spacing() .and. c%has_thickness) then
        call config%complain(errors, RIGID, 'WingThickness', TOO_THIN)
      else if (2*half_thickness < grid%max_spacing()) then
        call config%complain(errors, FLEXIBLE, 't_wing', TOO_THIN)
      else if (is_soft) then
        call notices%add('[Insects] wing_edges = flusi: the smoothing layer of the mask is wider than the wings are thick: '// &
                         'chi does not reach 1, and some of the flow passes through the wings; wing_edges = auto avoids this')
      else
        smoothing = half_thickness
        call config%complain(notices, FLEXIBLE, 'wing_smoothing', 'is set to half the thickness of the wings, not to '// &
                             trim(merge('what is given', 'max(dx)      ', c%has_smoothing))// &
                             ', so that chi reaches 1')
      end if
    end if
  end subroutine read_mask_keys
end module fsi_mask_keys
