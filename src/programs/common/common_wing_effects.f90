! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the [Wing] keys with the sites of effects that a usual wing does not have. [Wing] parameters gives the strength of these
!> effects.
module common_wing_effects
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: parse_real, quoted
  use common_words, only: find_words
  use io_config, only: config_t
  use io_keys, only: keys_t
  use io_suggest, only: suggestion_t
  use solid_effects, only: clamp_compliance, lacks, needs_of
  use solid_params, only: solid_params_t
  implicit none
  private
  public :: effect_sites_t, effect_keys, take_effect_sites, effect_without_site, refuse_root_compliance

  !> Holds the places where effects act, in the words of the user.
  type :: effect_sites_t
    real(rp) :: disc(3) = 0                  !< x, y, radius [m]
    character(:), allocatable :: soft_place  !< VEIN FRACTION
    logical :: sided_joints = .false., sided_veins = .false.
  end type effect_sites_t

contains

  !> Declares and reads the keys of effects in [Wing], which is the present section of `keys`.
  subroutine effect_keys(keys, sites)
    type(keys_t), intent(in) :: keys
    type(effect_sites_t), intent(inout) :: sites
    call keys%reals('damage_disc', sites%disc, [0.0_rp, 0.0_rp, 0.0_rp], 'x, y and radius of the disc in which the parameter '// &
                    'damage multiplies all stiffness; radius 0: none', unit='m')
    call keys%text('soft_place', sites%soft_place, '', 'VEIN FRACTION: the parameter soft multiplies the stiffness of the '// &
                   'hinge at the point inside this vein that is nearest to this fraction (0 to 1) of its length')
    call keys%switch('sided_joints', sites%sided_joints, .false., 'joints may have another stiffness when they bend up than '// &
                     'down, for the parameters one_way:NAME')
    call keys%switch('sided_veins', sites%sided_veins, .false., 'veins follow the rotation of the membrane, for the '// &
                     'parameters torsion, camber_span, camber_chord and camber_twist')
  end subroutine effect_keys

  !> Puts the `sites` into `params`. Adds mistakes to `errors`.
  subroutine take_effect_sites(c, sites, params, errors)
    type(config_t), intent(in) :: c
    type(effect_sites_t), intent(in) :: sites
    type(solid_params_t), intent(inout) :: params
    type(message_list_t), intent(inout) :: errors
    params%effects%disc = sites%disc
    params%effects%has_sides = sites%sided_joints
    params%effects%has_sided_veins = sites%sided_veins
    if (sites%disc(3) < 0) call c%complain(errors, 'Wing', 'damage_disc', 'the radius must not be negative')
    if (sites%soft_place /= '') call take_soft_place(c, sites%soft_place, params, errors)
  end subroutine take_effect_sites

  !> Reads `text` of the form VEIN FRACTION.
  subroutine take_soft_place(c, text, params, errors)
    type(config_t), intent(in) :: c
    character(*), intent(in) :: text
    type(solid_params_t), intent(inout) :: params
    type(message_list_t), intent(inout) :: errors
    character(*), parameter :: KEY = 'soft_place'
    character(:), allocatable :: problem
    type(suggestion_t) :: suggestion
    integer :: first(3), last(3), n, i
    call find_words(text, first, last, n)
    if (n /= 2) then
      call c%complain(errors, 'Wing', KEY, quoted(text)//' is not VEIN FRACTION: the name of a vein '// &
                      'and a number from 0 to 1')
      return
    end if
    call parse_real(text(first(2):last(2)), params%effects%soft_fraction, problem)
    if (allocated(problem)) then
      call c%complain(errors, 'Wing', KEY, problem)
    else if (.not. (params%effects%soft_fraction > 0 .and. params%effects%soft_fraction < 1)) then
      call c%complain(errors, 'Wing', KEY, 'the fraction of the length must lie between 0 and 1')
    end if
    associate (name => text(first(1):last(1)))
      if (all(params%vein_names /= name)) then
        call suggestion%start(name)
        do i = 1, size(params%vein_names)
          call suggestion%offer(trim(params%vein_names(i)))
        end do
        call c%complain(errors, 'Wing', KEY, 'there is no vein '//quoted(name)//suggestion%hint())
      else
        params%effects%soft_vein = name
      end if
    end associate
  end subroutine take_soft_place

  !> Adds a mistake if the clamp of a wing in motion is compliant. Only a wing on a test bench has such a clamp; a wing in motion is
  !> fixed to its frame.
  subroutine refuse_root_compliance(c, params, errors)
    type(config_t), intent(in) :: c
    type(solid_params_t), intent(in) :: params
    type(message_list_t), intent(inout) :: errors
    if (any(abs(clamp_compliance(params%effects)) > 0)) &
      call c%complain(errors, 'Wing', 'parameters', 'root_flap and root_twist turn the clamp of a test bench; a '// &
                      'wing in motion is held by its frame: leave them out')
  end subroutine refuse_root_compliance

  !> Returns what [Wing] must contain before parameter `number` can be fitted or set. It is empty if nothing is missing, and for
  !> parameters that are not effects.
  function effect_without_site(params, number) result(problem)
    type(solid_params_t), intent(in) :: params
    integer, intent(in) :: number
    character(:), allocatable :: problem
    integer, allocatable :: needs(:)
    integer :: i
    problem = ''
    if (number <= params%count_basic() .or. number > params%count()) return
    needs = needs_of(params%effects, number - params%count_basic())
    do i = 1, size(needs)
      if (problem == '') problem = lacks(params%effects, needs(i))
    end do
  end function effect_without_site
end module common_wing_effects
