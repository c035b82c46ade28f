! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the stiffness of a wing as the section [Wing] of an ini file, for [include].
module common_wing_fragment
  use base_kinds, only: rp
  use base_named_kinds, only: word_of
  use base_parameter, only: parameter_t
  use base_text, only: number_text
  use common_wing_keys, only: OWN_KEYS
  use common_wing_size, only: wing_size
  use solid_effect_sites, only: effect_site_lines
  use solid_params, only: solid_params_t
  use solid_usual_causes, only: N_COMMON
  use solid_wing, only: SIDE_LEFT_VENTRAL, SIDE_UNSTATED, Z_SIDES
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: wing_lines

  character(*), parameter :: NL = new_line('a')

contains

  !> Returns the section as text. It holds every parameter whose value differs from its default, the side to which +z points for
  !> these values, and the fingerprint and the size of the wing. The values have no meaning for another wing.
  function wing_lines(p, wing_case) result(text)
    type(solid_params_t), intent(in) :: p
    type(wing_case_t), intent(in) :: wing_case !< the wing for which the values were found
    character(:), allocatable :: text, list, side
    type(parameter_t) :: known
    real(rp) :: found(2)
    integer :: i
    side = word_of(Z_SIDES, wing_case%wing%z_side)
    if (wing_case%wing%z_side == SIDE_UNSTATED) side = word_of(Z_SIDES, SIDE_LEFT_VENTRAL)
    text = '[Wing]'//NL//'fingerprint = '//wing_case%fingerprint//'; identifies the wing for which these values were found'//NL
    found = wing_size(wing_case%wing)
    text = text//'found_size = '//number_text(found(1))//' '//number_text(found(2))//'; m, length and mean chord of that wing'//NL
    if (wing_case%requested_size(1) > 0) text = text//'length = '//number_text(wing_case%requested_size(1))//'; m'//NL
    if (wing_case%requested_size(2) > 0) text = text//'mean_chord = '//number_text(wing_case%requested_size(2))//'; m'//NL
    text = text//'z_side = '//side//';'//NL//'E = '//number_text(p%young)//'; Pa'//NL//'D = '// &
           number_text(p%plate)//'; N m'//NL// &
           'cross_springs = '//trim(merge('yes', 'no ', p%cross_springs))//';'//NL//effect_site_lines(p%effects)
    if (p%slack < 1) text = text//'slack = '//number_text(p%slack)//';'//NL//'slack_width = '// &
                            number_text(p%slack_width)//'; m'//NL
    list = ''
    do i = 1, p%count()
      known = p%describe(i)
      if (any(known%name == OWN_KEYS)) cycle
      if (i > N_COMMON .and. i <= N_COMMON + size(p%vein_factor) .and. abs(p%get(i) - 1) <= 0) cycle
      if (known%is_effect .and. abs(p%get(i) - known%null) <= 0) cycle
      list = list//', '//known%name//' '//number_text(p%get(i))
    end do
    text = text//'parameters = '//list(3:)//'; N m/rad of joints, N/m of springs, factors'//NL
  end function wing_lines
end module common_wing_fragment
