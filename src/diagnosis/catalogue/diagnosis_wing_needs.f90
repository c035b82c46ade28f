! SPDX-License-Identifier: GPL-3.0-or-later
!> Tells which of its needs (constants NEED_*) a cause lacks in an experiment, before a diagnosis tries it.
module diagnosis_wing_needs
  use base_errors, only: require
  use base_kinds, only: rp
  use measurement_experiment, only: experiment_t
  use measurement_instrument_causes, only: NEED_HEIGHTS, NEED_HOLD, NEED_MASS, NEED_ORDER, NEED_SMALL_DEFLECTIONS, &
                                           NEED_TIME, NEED_TWO_HOLDS, NONLINEARITY
  use solid_effect, only: NEED_BOTH_DIRECTIONS, NEED_LEVELS, NEED_MEMBRANE, NEED_MODES_ABOUT_REST, &
                          NEED_NO_SLACK, NEED_SIDED_JOINTS, NEED_SIDED_VEINS, NEED_UNSTRESSED_REST
  use solid_effects, only: lacks
  implicit none
  private
  public :: missing_of

  real(rp), parameter :: SAME_SITE = 0.02_rp !< of the wing's size: sites that are nearer to each other are the same
  real(rp), parameter :: OTHER_FORCE = 0.05_rp !< of the other force

contains

  !> Returns what the data lack to show creep, which needs two times of holding; empty if they have them.
  function needs_holds(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    missing = ''
    associate (hold => e%measurement%loads%hold)
      if (size(hold) == 0) then
        missing = 'needs bending tests'
      else if (any(hold < 0)) then
        missing = 'needs the attribute `hold` of every load'
      else if (maxval(hold) < 1.5_rp*minval(hold)) then
        missing = 'needs loads whose `hold` differs by a factor of 1.5 or more'
      end if
    end associate
  end function needs_holds

  !> Returns what the data lack to show an effect of the strength of the force, which needs two forces at one site; empty if they
  !> have them.
  function needs_levels(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    integer :: i, k
    missing = 'needs two different forces at the same place'
    associate (loads => e%measurement%loads)
      do i = 1, size(loads)
        do k = 1, i - 1
          if (norm2(loads(i)%point - loads(k)%point) < SAME_SITE*e%model%size .and. &
              abs(loads(i)%force - loads(k)%force) > OTHER_FORCE*loads(k)%force) missing = ''
        end do
      end do
    end associate
  end function needs_levels

  !> Returns the first of the needs of a cause that is not met, in words; empty if all are.
  function missing_of(e, needs) result(missing)
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: needs(:)
    character(:), allocatable :: missing
    integer :: i
    missing = ''
    do i = 1, size(needs)
      if (missing /= '') return
      select case (needs(i))
      case (NEED_LEVELS)
        missing = needs_levels(e)
      case (NEED_BOTH_DIRECTIONS)
        missing = needs_both_directions(e)
      case (NEED_MEMBRANE)
        missing = needs_membrane(e)
      case (NEED_NO_SLACK)
        if (e%model%params%slack < 1) missing = 'needs a membrane that does not go slack'
      case (NEED_UNSTRESSED_REST) ! motion is that about a flat wing without stress
        if (e%measurement%moves()) missing = 'cannot be tested together with natural modes or '// &
                                             'records of motion, which need a wing that is flat and free of stress at rest'
      case (NEED_MODES_ABOUT_REST)
        if (e%measurement%has_loaded_modes()) missing = 'cannot be tested together with natural modes under '// &
                                                        'loads, which need a stiff clamp'
      case (NEED_SIDED_JOINTS)
        missing = lacks(e%model%params%effects, needs(i))
      case (NEED_TWO_HOLDS)
        missing = needs_holds(e)
      case (NEED_MASS)
        missing = needs_mass(e)
      case (NEED_SMALL_DEFLECTIONS)
        missing = needs_small_deflections(e)
      case default ! the diagnosis gives veins their sides, and missing_for tests what the measurement file has
        call require(any(needs(i) == [NEED_SIDED_VEINS, NEED_ORDER, NEED_TIME, NEED_HOLD, NEED_HEIGHTS]), &
                     'diagnosis_wing_needs: an unknown need')
      end select
    end do
  end function missing_of

  !> Returns what the data lack to have forces up and down; empty if they have both.
  function needs_both_directions(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    integer :: l
    missing = ''
    associate (up => [(e%measurement%loads(l)%force*e%measurement%loads(l)%direction(3), &
                       l=1, size(e%measurement%loads))])
      if (.not. (any(up > 0) .and. any(up < 0))) missing = 'needs forces up and down'
    end associate
  end function needs_both_directions

  !> Returns what is missing if the wing has no membrane; else it is empty.
  function needs_membrane(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    missing = ''
    if (size(e%model%triangles) == 0) missing = 'needs a wing with a membrane'
  end function needs_membrane

  !> Returns what is missing to know the weight, the mass of the wing; empty if nothing is.
  function needs_mass(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    missing = ''
    if (size(e%masses) == 0) missing = 'needs the mass of the wing: [Mass]'
  end function needs_mass

  !> Returns what is missing to show the geometric nonlinearity: a baseline of small deflections, and two forces at one place.
  !> Empty if nothing is.
  function needs_small_deflections(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    missing = needs_levels(e)
    if (e%instrument%get(NONLINEARITY) >= 1) &
      missing = 'is already part of the baseline; [Instrument] parameters = nonlinearity 0 takes it out'
  end function needs_small_deflections
end module diagnosis_wing_needs
