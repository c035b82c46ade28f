! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives effects with a site a variant that may be anywhere on the wing, besides those on a lattice. The coordinates of its site are
!> x and y [m] and, for a disc, the logarithm of the radius [m].
module diagnosis_wing_places
  use base_kinds, only: rp
  use base_parameter, only: define_parameter, parameter_t
  use diagnosis_wing_entries, only: append_variant, catalogue_t, millimetres
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_DAMAGE, KIND_SITE
  use inference_simulator, only: effect_t, variant_t
  use measurement_experiment, only: experiment_t
  use measurement_material_point, only: find_material_point
  implicit none
  private
  public :: append_anywhere, append_place, enter_anywhere, is_on_wing, take_places

  real(rp), parameter :: RADIUS_STEP = 0.4_rp !< first step of a search, of the logarithm of a radius

contains

  !> Adds a variant at a place of a lattice: a parameter with this site.
  subroutine append_place(c, one, is_finer, variants)
    type(catalogue_t), intent(inout) :: c
    type(wing_parameter_t), intent(in) :: one
    logical, intent(in) :: is_finer
    type(variant_t), allocatable, intent(inout) :: variants(:)
    real(rp), allocatable :: place(:)
    integer :: n
    place = one%disc(:2)
    if (one%kind == KIND_DAMAGE) place = [one%disc(:2), log(one%disc(3))]
    n = c%add(one)
    call append_variant(variants, place_label(place), n, place(:2))
    associate (last => variants(size(variants)))
      last%place = place
      last%is_finer = is_finer
    end associate
  end subroutine append_place

  !> Adds the variant that may be anywhere: parameter `one` without a site, and parameters for the coordinates. A search begins with
  !> steps of `step` [m]. radii(2) [m] are the smallest and the largest radius of a disc; a point has none.
  subroutine append_anywhere(c, e, one, step, radii, variants)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_parameter_t), intent(in) :: one
    real(rp), intent(in) :: step, radii(:)
    type(variant_t), allocatable, intent(inout) :: variants(:)
    type(wing_parameter_t) :: strength
    integer :: n
    strength = one
    strength%disc = 0
    n = size(c%parameters) + 1
    strength%partner = n + 1
    n = c%add(strength)
    call add_coordinate('x', .false., minval(e%model%points(1, :)), maxval(e%model%points(1, :)), step)
    call add_coordinate('y', .false., minval(e%model%points(2, :)), maxval(e%model%points(2, :)), step)
    if (size(radii) == 2) call add_coordinate('radius', .true., log(radii(1)), log(radii(2)), RADIUS_STEP)
    call append_variant(variants, '', n, [0.0_rp, 0.0_rp])
    variants(size(variants))%is_finer = .true.

  contains

    subroutine add_coordinate(name, is_log, lower, upper, first)
      character(*), intent(in) :: name
      logical, intent(in) :: is_log
      real(rp), intent(in) :: lower, upper, first
      type(parameter_t) :: p
      integer :: k
      call define_parameter(p, one%name//'_'//name, 'm', is_log, lower, upper)
      p%prior_sd = first
      k = c%add(wing_parameter(p, KIND_SITE, 0))
      ! Kind and number of the parameter that has this site distinguish the coordinates on any mesh.
      c%parameters(k)%number = 10*one%kind + k - n
    end subroutine add_coordinate

  end subroutine append_anywhere

  !> Tells the effect that was entered last that its last variant may be anywhere.
  subroutine enter_anywhere(c)
    type(catalogue_t), intent(inout) :: c
    integer :: k, first
    associate (effect => c%effects(size(c%effects)))
      effect%anywhere = size(effect%variants)
      first = effect%variants(effect%anywhere)%columns(1) + 1
      effect%place_columns = [(k, k=first, first + size(effect%variants(1)%place) - 1)]
    end associate
  end subroutine enter_anywhere

  !> Takes the effects of a diagnosis that has found places, with words for these.
  subroutine take_places(c, effects)
    type(catalogue_t), intent(inout) :: c
    type(effect_t), intent(in) :: effects(:)
    integer :: e
    c%effects = effects
    do e = 1, size(effects)
      if (allocated(effects(e)%place)) c%effects(e)%variants(effects(e)%anywhere)%label = place_label(effects(e)%place)
    end do
  end subroutine take_places

  !> Tells whether the point with these coordinates is on the wing.
  pure logical function is_on_wing(e, place)
    type(experiment_t), intent(in) :: e
    real(rp), intent(in) :: place(:)
    associate (found => find_material_point(e%model%points(:, :e%model%n_points), e%model%triangles, e%model%size, place(:2)))
      is_on_wing = found%is_found
    end associate
  end function is_on_wing

  !> Returns the words for a place: 'at (5.4, -2.7) mm', or for a disc 'around (5.4, -2.7) mm, radius 0.9 mm'.
  function place_label(place) result(label)
    real(rp), intent(in) :: place(:)
    character(:), allocatable :: label
    label = '('//millimetres(place(1))//', '//millimetres(place(2))//') mm'
    if (size(place) == 2) then
      label = 'at '//label
    else
      label = 'around '//label//', radius '//millimetres(exp(place(3)))//' mm'
    end if
  end function place_label
end module diagnosis_wing_places
