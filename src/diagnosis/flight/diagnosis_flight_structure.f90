! SPDX-License-Identifier: GPL-3.0-or-later
!> Chooses the parameters of the structure of wings that bend, beside E and D, that flights of a diagnosis change: gradients,
!> masses, joints, damping, places. Each becomes a change of a flight by its coordinate, FLOW_STRUCTURE + k, in all cases. Those of
!> few causes, or those that a user names, are flown first, with two flights each. What the other data find is flown afterwards,
!> about its fitted value.
module diagnosis_flight_structure
  use base_cause, only: append, cause_t
  use base_kinds, only: rp
  use base_text, only: next_word
  use diagnosis_flight_changes, only: FLOW_STRUCTURE, N_STRUCTURE
  use diagnosis_flight_data, only: flight_data_t
  use diagnosis_flight_runner, only: flight_runner_t
  use diagnosis_wing_entries, only: catalogue_t
  use diagnosis_wing_parameters, only: same_parameter, wing_parameter_t, KIND_DAMAGE, KIND_DAMPING, KIND_MASS, KIND_PARAMETER, &
                                       KIND_POINT_MASS, KIND_RELAXATION, KIND_RELAXATION_TIME, KIND_SOFT
  use solid_damping_effects, only: list_damping_causes, DAMPING_JOINTS, DAMPING_STIFFNESS
  use solid_mass_effects, only: list_mass_causes, MASS_ADDED
  use solid_structure_causes, only: list_structure_causes
  use solid_usual_causes, only: PARAM_PLATE, PARAM_THICKNESS, PARAM_YOUNG
  implicit none
  private
  public :: acts_in_flight, add_structure, choose_structure, is_flown_first, is_wanted, matches_word, structure_causes, &
            structure_step

  !> Causes of few parameters that act on the whole wing: flown first if a user names no effects.
  character(*), parameter :: GLOBAL = &
    'root_stiffness E_gradient taper thickness_gradient vein_mass membrane_mass membrane_gradient'
  !> Causes that first flights cannot show. Flights have E and D by other names, no clamp that gives way and their own air; the
  !> others act at places or with times that only other data find, or cannot go below their null.
  character(*), parameter :: NEVER_FIRST = &
    'root_compliance membrane_bending elasticity damage soft_place point_mass viscoelasticity air_drag '// &
    'stiffness_damping joint_friction'

contains

  !> Tells whether a parameter changes the structure of a wing in flight beside E and D, which are changes of their own. The air is
  !> simulated, so that its mass and its drag are none.
  pure elemental logical function acts_in_flight(p) result(acts)
    type(wing_parameter_t), intent(in) :: p
    select case (p%kind)
    case (KIND_PARAMETER)
      acts = all(p%number /= [PARAM_YOUNG, PARAM_PLATE, PARAM_THICKNESS])
    case (KIND_MASS)
      acts = p%number /= MASS_ADDED
    case (KIND_DAMPING)
      acts = any(p%number == [DAMPING_STIFFNESS, DAMPING_JOINTS])
    case (KIND_POINT_MASS, KIND_SOFT, KIND_DAMAGE, KIND_RELAXATION, KIND_RELAXATION_TIME)
      acts = .true.
    case default
      acts = .false.
    end select
  end function acts_in_flight

  !> Returns the names, separated by blanks, of the causes of the structure whose flights a user can ask for.
  pure function structure_causes() result(names)
    character(:), allocatable :: names
    type(cause_t), allocatable :: list(:), more(:)
    integer :: i
    list = list_structure_causes()
    more = list_mass_causes(1.0_rp)
    call append(list, more)
    more = list_damping_causes(1.0_rp, 1.0_rp, 1.0_rp)
    call append(list, more)
    names = ''
    do i = 1, size(list)
      if (.not. is_wanted(NEVER_FIRST, list(i)%name)) names = names//' '//list(i)%name
    end do
    names = names(2:)
  end function structure_causes

  !> Tells whether the first flights show a cause of the structure: one that the list `wanted` names or, if it is empty, one of few
  !> parameters that act on the whole wing.
  pure logical function is_flown_first(wanted, cause)
    character(*), intent(in) :: wanted, cause
    is_flown_first = is_wanted(wanted, cause) .and. .not. is_wanted(NEVER_FIRST, cause)
    if (wanted == '') is_flown_first = is_wanted(GLOBAL, cause)
  end function is_flown_first

  !> Tells whether a list of names has this one; an empty list has all.
  pure logical function is_wanted(wanted, name)
    character(*), intent(in) :: wanted, name
    integer :: position, first, last
    logical :: found
    is_wanted = wanted == ''
    position = 1
    do
      call next_word(wanted, ' ,', position, first, last, found)
      if (.not. found) return
      is_wanted = is_wanted .or. wanted(first:last) == name
    end do
  end function is_wanted

  !> Tells whether a word is the name of a parameter, or ends with :* and begins as this name.
  pure logical function matches_word(word, name)
    character(*), intent(in) :: word, name
    integer :: n
    matches_word = word == name
    n = len(word)
    if (n > 2) then
      if (word(n - 1:) == ':*') matches_word = index(name, word(:n - 1)) == 1
    end if
  end function matches_word

  !> Returns the step of the first flights for a parameter of the structure, in its coordinate. A factor has the sd of its prior, at
  !> most 0.3, which is that of masses. Other priors are wide, as they say how large an effect may be at all: the step is 0.3 of
  !> their sd.
  pure real(rp) function structure_step(p) result(step)
    type(wing_parameter_t), intent(in) :: p
    real(rp), parameter :: SHARE = 0.3_rp
    step = merge(min(p%prior_sd, SHARE), SHARE*p%prior_sd, p%is_log)
  end function structure_step

  !> Finds the parameters that the first flights change: those of the baseline that `wanted` names (by the name of a parameter, or
  !> with :* as in joint:*), then those of testable causes that are flown first. Sets facts%structure, origin, n_first and missing
  !> of all cases. A parameter that can move to one side of its null only is flown once it was found. Causes that no flight can show
  !> are excluded where there are no other data. `is_full` tells that there are more than N_STRUCTURE.
  subroutine choose_structure(c, wanted, runner, cases, is_full)
    type(catalogue_t), intent(inout) :: c
    character(*), intent(in) :: wanted
    class(flight_runner_t), intent(in) :: runner
    type(flight_data_t), intent(inout) :: cases(:)
    logical, intent(out) :: is_full
    character(:), allocatable :: reason
    integer :: i, e, v
    is_full = .false.
    do i = 1, c%n_baseline
      if (is_named(c%parameters(i)%name)) call take(i, .true.)
    end do
    do e = 1, size(c%effects)
      if (.not. is_flown_first(wanted, c%effects(e)%name) .or. c%effects(e)%missing /= '') cycle
      do v = 1, size(c%effects(e)%variants)
        do i = 1, size(c%effects(e)%variants(v)%columns)
          call take(c%effects(e)%variants(v)%columns(i), .false.)
          if (cases(1)%facts%is_alone .and. reason /= '') c%effects(e)%missing = reason
        end do
      end do
    end do
    do i = 1, size(cases)
      cases(i)%facts%n_first = 0
      if (allocated(cases(i)%facts%structure)) cases(i)%facts%n_first = size(cases(i)%facts%structure)
    end do

  contains

    !> Adds parameter `number` unless it is there.
    subroutine take(number, is_baseline)
      integer, intent(in) :: number
      logical, intent(in) :: is_baseline
      associate (p => c%parameters(number))
        reason = ''
        if (.not. acts_in_flight(p)) return
        if (.not. is_baseline .and. (p%null - structure_step(p) < p%lower .or. p%null + structure_step(p) > p%upper)) return
        call add_structure(p, is_baseline, runner, cases, is_full, reason)
      end associate
    end subroutine take

    !> Tells whether the list has a word for this parameter.
    pure logical function is_named(name)
      character(*), intent(in) :: name
      integer :: position, first, last
      logical :: found
      is_named = .false.
      position = 1
      do
        call next_word(wanted, ' ,', position, first, last, found)
        if (.not. found) return
        is_named = is_named .or. matches_word(wanted(first:last), name)
      end do
    end function is_named

  end subroutine choose_structure

  !> Makes parameter p a change of the flights of all cases, unless it is one. A parameter of the baseline has the value of the fit,
  !> whatever the case has; any other one changes the case by what it differs from its null, both on the mesh of the wing file.
  !> `reason` says why no case can be flown with another value; it is empty if one can. `is_full` is set if there is no room for
  !> another parameter.
  !> A damage or a point mass whose place is sought has the place `disc`, also if it is a change already.
  subroutine add_structure(p, is_baseline, runner, cases, is_full, reason)
    type(wing_parameter_t), intent(in) :: p
    logical, intent(in) :: is_baseline
    class(flight_runner_t), intent(in) :: runner
    type(flight_data_t), intent(inout) :: cases(:)
    logical, intent(inout) :: is_full
    character(:), allocatable, intent(out) :: reason
    character(200) :: missing(size(cases))
    character(:), allocatable :: why
    real(rp) :: own(size(cases))
    integer :: i, k, n
    reason = ''
    n = 0
    if (allocated(cases(1)%facts%structure)) n = size(cases(1)%facts%structure)
    do k = 1, n
      if (.not. same_parameter(cases(1)%facts%structure(k), p)) cycle
      do i = 1, size(cases)
        cases(i)%facts%structure(k)%disc = p%disc
      end do
      return
    end do
    do i = 1, size(cases)
      own(i) = p%null
      why = 'needs wings that bend'
      if (cases(i)%facts%is_flexible) call runner%judge_structure(i, p, own(i), why)
      missing(i) = why
    end do
    if (all(missing /= '')) then
      reason = trim(missing(1))
    else if (n == N_STRUCTURE) then
      is_full = .true.
      reason = 'too many parameters of the structure are flown'
    end if
    if (reason /= '') return
    do i = 1, size(cases)
      call append_parameter(cases(i)%facts%structure, p)
      if (n == 0) cases(i)%facts%origin = [real(rp) ::]
      cases(i)%facts%origin = [cases(i)%facts%origin, merge(own(i), p%on_file%at(p%null), is_baseline)]
      cases(i)%facts%missing(FLOW_STRUCTURE + n + 1) = missing(i)
    end do
  end subroutine add_structure

  !> Appends a parameter to a list; a list that is not allocated is empty.
  pure subroutine append_parameter(list, p)
    type(wing_parameter_t), allocatable, intent(inout) :: list(:)
    type(wing_parameter_t), intent(in) :: p
    type(wing_parameter_t), allocatable :: longer(:)
    integer :: i, n
    n = 0
    if (allocated(list)) n = size(list)
    allocate (longer(n + 1))
    do i = 1, n
      longer(i) = list(i)
    end do
    longer(n + 1) = p
    call move_alloc(longer, list)
  end subroutine append_parameter
end module diagnosis_flight_structure
