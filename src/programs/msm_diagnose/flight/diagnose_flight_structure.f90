! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the sections of a flight whose wings have another structure than those of the case: [Wing] parameters and places, [Mass]
!> and [Damping]. The program adds each change to the value of the case. It writes nothing for a change of 0.
module diagnose_flight_structure
  use base_kinds, only: rp
  use base_text, only: number_text
  use common_wing_effects, only: effect_without_site
  use common_wing_keys, only: mass_choices_t, read_mass_keys, read_wing_keys, wing_choices_t
  use diagnosis_wing_parameters, only: wing_parameter_t, KIND_DAMAGE, KIND_DAMPING, KIND_MASS, KIND_PARAMETER, KIND_POINT_MASS, &
                                       KIND_RELAXATION, KIND_RELAXATION_TIME, KIND_SOFT
  use simulation_settings, only: settings_t
  use solid_damping_effects, only: DAMPING_JOINTS, DAMPING_STIFFNESS
  use solid_effect, only: NEED_SIDED_JOINTS, NEED_SIDED_VEINS
  use solid_effects, only: clamp_axis, is_thickness, needs_of
  use solid_mass_effects, only: MASS_GRADIENT, MASS_MEMBRANE, MASS_VEINS, N_MASS_EFFECTS
  use solid_params, only: solid_params_t
  implicit none
  private
  public :: diagnosed_wing_t, judge_structure, structure_text

  character(*), parameter :: NL = new_line('a')

  !> What the places of effects of a diagnosis belong to.
  type :: diagnosed_wing_t
    real(rp) :: size = 0                          !< [m]
    character(:), allocatable :: vein_names(:)
  end type diagnosed_wing_t

contains

  !> Returns the coordinate `own` of parameter p in the case with the settings s, whose wings bend, and in `reason` why its wings
  !> cannot have another value; empty if they can. Places of p are those of the wing `diagnosed`. Changes of masses and damping
  !> count from the values of the case, whatever these are: `own` is then the null of p.
  subroutine judge_structure(s, diagnosed, p, own, reason)
    type(settings_t), intent(in) :: s
    type(diagnosed_wing_t), intent(in) :: diagnosed
    type(wing_parameter_t), intent(in) :: p
    real(rp), intent(out) :: own
    character(:), allocatable, intent(out) :: reason
    type(mass_choices_t) :: mass
    own = p%null
    reason = ''
    associate (params => s%coupler%model%params, inertia => s%coupler%inertia)
      select case (p%kind)
      case (KIND_PARAMETER)
        call judge_parameter(params, p, own, reason)
      case (KIND_SOFT)
        if (allocated(params%effects%soft_vein)) reason = 'the wing of the case has another soft place'
        if (reason == '') reason = other_veins(params, diagnosed, p%vein)
      case (KIND_DAMAGE)
        if (params%effects%has_damage()) reason = 'the wing of the case has another damaged region'
        if (reason == '') reason = other_size(s, diagnosed)
      case (KIND_POINT_MASS)
        call read_mass_keys(s%config, mass)
        if (abs(mass%material%point(3)) > 0) reason = 'the wing of the case has another point mass'
        if (reason == '') reason = other_size(s, diagnosed)
      case (KIND_RELAXATION, KIND_RELAXATION_TIME)
        if (inertia%relaxation > 0) reason = 'the wing of the case relaxes with a time of its own'
      end select
    end associate
  end subroutine judge_structure

  !> Does this for a parameter of the wing.
  subroutine judge_parameter(params, p, own, reason)
    type(solid_params_t), intent(in) :: params
    type(wing_parameter_t), intent(in) :: p
    real(rp), intent(inout) :: own
    character(:), allocatable, intent(inout) :: reason
    type(solid_params_t) :: sided
    integer :: i
    i = params%find(p%name)
    if (i == 0) then
      reason = 'the wing of the case has no '//p%name
      return
    end if
    own = params%get(i)
    if (p%is_log) own = log(own)
    sided = params
    sided%effects%has_sides = .true.
    sided%effects%has_sided_veins = .true.
    reason = effect_without_site(sided, i)
    if (clamp_axis(params%effects, i - params%count_basic()) > 0) &
      reason = 'the frame holds a wing in flight: its clamp does not turn'
  end subroutine judge_parameter

  !> Returns why a vein of the diagnosed wing is none of the case; empty if it is.
  function other_veins(params, diagnosed, vein) result(reason)
    type(solid_params_t), intent(in) :: params
    type(diagnosed_wing_t), intent(in) :: diagnosed
    integer, intent(in) :: vein
    character(:), allocatable :: reason
    reason = 'the wing of the case has other veins'
    if (size(params%vein_names) < vein .or. size(diagnosed%vein_names) < vein) return
    if (params%vein_names(vein) == diagnosed%vein_names(vein)) reason = ''
  end function other_veins

  !> Returns why places on the diagnosed wing are none of the case; empty if they are.
  function other_size(s, diagnosed) result(reason)
    type(settings_t), intent(in) :: s
    type(diagnosed_wing_t), intent(in) :: diagnosed
    character(:), allocatable :: reason
    real(rp), parameter :: SAME = 1.0e-6_rp
    reason = ''
    if (abs(s%coupler%model%size/diagnosed%size - 1) > SAME) reason = 'the wing of the case has another size'
  end function other_size

  !> Returns the sections that change parameters `list` of the wings of a case by change(size(list)), in their coordinates. A
  !> change of 0, and of a parameter that the case cannot have, writes nothing. [Wing] has all its keys but E and D.
  function structure_text(s, list, change) result(text)
    type(settings_t), intent(in) :: s
    type(wing_parameter_t), intent(in) :: list(:)
    real(rp), intent(in) :: change(:)
    character(:), allocatable :: text
    type(mass_choices_t) :: mass
    character(:), allocatable :: pairs, places, damping, point
    real(rp) :: of_mass(N_MASS_EFFECTS)
    logical :: has_sides(2)
    integer :: k
    pairs = ''
    places = ''
    damping = ''
    point = ''
    of_mass = 0
    has_sides = .false.
    do k = 1, size(list)
      if (.not. abs(change(k)) > 0) cycle
      associate (p => list(k), c => change(k))
        select case (p%kind)
        case (KIND_PARAMETER)
          call put_parameter(s%coupler%model%params, p, c, pairs, has_sides, of_mass)
        case (KIND_SOFT)
          pairs = pairs//', '//p%name//' '//number_text(exp(c))
          places = places//'soft_place = '//trim(s%coupler%model%params%vein_names(p%vein))//' '// &
                   number_text(p%file_fraction)//NL
        case (KIND_DAMAGE)
          pairs = pairs//', '//p%name//' '//number_text(exp(c))
          places = places//'damage_disc = '//numbers(p%disc)//NL
        case (KIND_MASS)
          of_mass(p%number) = of_mass(p%number) + c
        case (KIND_POINT_MASS)
          point = 'point_mass = '//numbers([p%disc(:2), c])//NL
        case default
          damping = damping//damping_line(s, list, change, k)
        end select
      end associate
    end do
    if (has_sides(1)) places = places//'sided_joints = yes'//NL
    if (has_sides(2)) places = places//'sided_veins = yes'//NL
    text = ''
    if (pairs//places /= '') text = '[Wing]'//NL//places
    if (pairs /= '') text = text//'parameters = '//joined(s, pairs)//NL
    if (any(abs(of_mass) > 0) .or. point /= '') then
      call read_mass_keys(s%config, mass)
      associate (m => mass%material)
        text = text//'[Mass]'//NL//'vein_factor = '//number_text(m%vein_factor*exp(of_mass(MASS_VEINS)))//NL// &
               'membrane_factor = '//number_text(m%membrane_factor*exp(of_mass(MASS_MEMBRANE)))//NL//'membrane_gradient = '// &
               number_text(m%gradient + of_mass(MASS_GRADIENT))//NL//point
      end associate
    end if
    if (damping /= '') text = text//'[Damping]'//NL//damping
  end function structure_text

  !> Adds a parameter of the wing that differs by c from that of the case: its pair to `pairs`, and, if it is the thickness of the
  !> membrane, what it changes of the masses. `has_sides` (joints, veins) tells what of the wing must have sides.
  subroutine put_parameter(params, p, c, pairs, has_sides, of_mass)
    type(solid_params_t), intent(in) :: params
    type(wing_parameter_t), intent(in) :: p
    real(rp), intent(in) :: c
    character(:), allocatable, intent(inout) :: pairs
    logical, intent(inout) :: has_sides(2)
    real(rp), intent(inout) :: of_mass(:)
    integer, allocatable :: needs(:)
    integer :: i, of_effect
    i = params%find(p%name)
    if (i == 0) return
    pairs = pairs//', '//p%name//' '
    if (p%is_log) pairs = pairs//number_text(params%get(i)*exp(c))
    if (.not. p%is_log) pairs = pairs//number_text(params%get(i) + c)
    of_effect = i - params%count_basic()
    if (of_effect < 1) return
    needs = needs_of(params%effects, of_effect)
    has_sides = has_sides .or. [any(needs == NEED_SIDED_JOINTS), any(needs == NEED_SIDED_VEINS)]
    if (is_thickness(params%effects, of_effect)) of_mass(MASS_GRADIENT) = of_mass(MASS_GRADIENT) + c
  end subroutine put_parameter

  !> Returns the pairs of [Wing] parameters of the case, followed by `pairs`, which begin with a comma. The last of two counts.
  function joined(s, pairs) result(text)
    type(settings_t), intent(in) :: s
    character(*), intent(in) :: pairs
    character(:), allocatable :: text
    type(wing_choices_t) :: choices
    call read_wing_keys(s%config, choices)
    text = choices%parameters//pairs
    if (choices%parameters == '') text = pairs(3:)
  end function joined

  !> Returns the lines of [Damping] for change k.
  function damping_line(s, list, change, k) result(text)
    type(settings_t), intent(in) :: s
    type(wing_parameter_t), intent(in) :: list(:)
    real(rp), intent(in) :: change(:)
    integer, intent(in) :: k
    character(:), allocatable :: text
    real(rp) :: time
    integer :: i
    text = ''
    associate (p => list(k), c => change(k), inertia => s%coupler%inertia)
      if (p%kind == KIND_DAMPING .and. p%number == DAMPING_STIFFNESS) &
        text = 'rayleigh_stiffness = '//number_text(inertia%rayleigh_stiffness + c)//NL
      if (p%kind == KIND_DAMPING .and. p%number == DAMPING_JOINTS) &
        text = 'joint_friction = '//number_text(inertia%joint_friction + c)//NL
      if (p%kind /= KIND_RELAXATION) return
      time = p%time
      do i = 1, size(list) ! the factor on this time
        if (list(i)%kind == KIND_RELAXATION_TIME .and. list(i)%number == p%number - 1) time = p%time*exp(change(i))
      end do
      text = 'relaxation = '//number_text(c)//NL//'relaxation_time = '//number_text(time)//NL
    end associate
  end function damping_line

  !> Returns numbers, separated by blanks.
  function numbers(values) result(text)
    real(rp), intent(in) :: values(:)
    character(:), allocatable :: text
    integer :: i
    text = number_text(values(1))
    do i = 2, size(values)
      text = text//' '//number_text(values(i))
    end do
  end function numbers
end module diagnose_flight_structure
