! SPDX-License-Identifier: GPL-3.0-or-later
!> What data an effect needs to show; functions give what an experiment lacks, '' if nothing.
module diagnosis_wing_needs
  use base_kinds, only: rp
  use measurement_experiment, only: experiment_t
  use measurement_instrument, only: NONLINEARITY
  implicit none
  private
  public :: needs_holds, needs_levels, needs_membrane, needs_mass, needs_sides, needs_small_deflections, &
            needs_springs_both_ways, needs_stress_free_rest

  real(rp), parameter :: SAME_PLACE = 0.02_rp !< of the wing's size
  real(rp), parameter :: OTHER_FORCE = 0.05_rp !< of the other force

contains

  !> Creep: two times of holding.
  function needs_holds(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    missing = ''
    associate (hold => e%measurement%loads%hold)
      if (size(hold) == 0) then
        missing = 'needs bending tests'
      else if (any(hold < 0)) then
        missing = 'needs the hold of all loads'
      else if (maxval(hold) < 1.5_rp*minval(hold)) then
        missing = 'needs two times of holding that differ'
      end if
    end associate
  end function needs_holds

  !> What depends on the strength of the force: two of them at one place.
  function needs_levels(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    integer :: i, k
    missing = 'needs two forces at one place'
    associate (loads => e%measurement%loads)
      do i = 1, size(loads)
        do k = 1, i - 1
          if (norm2(loads(i)%point - loads(k)%point) < SAME_PLACE*e%model%size .and. &
              abs(loads(i)%force - loads(k)%force) > OTHER_FORCE*loads(k)%force) missing = ''
        end do
      end do
    end associate
  end function needs_levels

  !> One-way joints: forces up and down, and joints that have sides.
  function needs_sides(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    integer :: l
    missing = ''
    associate (up => [(e%measurement%loads(l)%force*e%measurement%loads(l)%direction(3), &
                       l=1, size(e%measurement%loads))])
      if (.not. (any(up > 0) .and. any(up < 0))) missing = 'needs forces up and down'
    end associate
    if (missing == '' .and. .not. e%model%params%effects%has_sides) missing = 'needs [Wing] sided_joints = yes'
  end function needs_sides

  !> A wing with a membrane.
  function needs_membrane(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    missing = ''
    if (size(e%model%triangles) == 0) missing = 'needs a wing with a membrane'
  end function needs_membrane

  !> Pretension: a membrane that does not go slack by itself.
  function needs_springs_both_ways(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    missing = needs_membrane(e)
    if (e%model%params%slack < 1) missing = 'needs a membrane that does not go slack'
  end function needs_springs_both_ways

  !> What bends or stretches the wing at rest: no natural modes, which are those about a flat wing without stress. `otherwise` is
  !> what else is missing.
  function needs_stress_free_rest(e, otherwise) result(missing)
    type(experiment_t), intent(in) :: e
    character(*), intent(in) :: otherwise
    character(:), allocatable :: missing
    missing = otherwise
    if (e%measurement%count_modes() > 0) missing = 'cannot be sought where natural modes are in the data'
  end function needs_stress_free_rest

  !> Weight: the mass of the wing.
  function needs_mass(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    missing = ''
    if (size(e%masses) == 0) missing = 'needs the mass of the wing: [Mass]'
  end function needs_mass

  !> Geometric nonlinearity: a baseline of small deflections, and two forces at one place.
  function needs_small_deflections(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    missing = needs_levels(e)
    if (e%instrument%get(NONLINEARITY) >= 1) &
      missing = 'the baseline has it: [Instrument] parameters = nonlinearity 0 leaves it out'
  end function needs_small_deflections
end module diagnosis_wing_needs
