! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the sites of effects of a wing as text, for input files and to distinguish wings.
module solid_effect_sites
  use base_text, only: number_text
  use solid_effects, only: effects_t
  implicit none
  private
  public :: effect_site_lines

contains

  !> Returns the lines of the section [Wing] of an ini file that say where the effects act; empty if no effect has a site.
  function effect_site_lines(effects) result(text)
    type(effects_t), intent(in) :: effects
    character(:), allocatable :: text
    integer :: i
    text = ''
    if (effects%has_damage()) then
      text = 'damage_disc ='
      do i = 1, 3
        text = text//' '//number_text(effects%disc(i))
      end do
      text = text//'; m'//new_line('a')
    end if
    if (effects%has_sides) text = text//'sided_joints = yes;'//new_line('a')
    if (effects%has_sided_veins) text = text//'sided_veins = yes;'//new_line('a')
    if (allocated(effects%soft_vein)) text = text//'soft_place = '//effects%soft_vein//' '// &
                                             number_text(effects%soft_fraction)//';'//new_line('a')
  end function effect_site_lines
end module solid_effect_sites
