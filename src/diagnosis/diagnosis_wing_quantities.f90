! SPDX-License-Identifier: GPL-3.0-or-later
!> The parameters that a diagnosis of a wing varies, and the experiment that has them.
!>
!> | kind | coordinate |
!> |---|---|
!> | PARAMETER | of a parameter of the wing, by its number in solid_params_t |
!> | INSTRUMENT | of a parameter of the measurement, by its number in instrument_t |
!> | SOFT | log of a factor on the stiffness of one hinge of a vein |
!> | DAMAGE | log of a factor on all stiffness inside a disc |
!> | ZERO | [m] unknown offset of scalar observations |
!> | MASS | of an effect of the masses, by its number in solid_mass_effects; natural modes alone feel it |
!> | POINT_MASS | [kg] a mass at a place, the same |
!> | DAMPING | of an effect of the damping, by its number in solid_damping_effects; records of motion alone feel it |
!> | RELAXATION | share of the stiffness that relaxes with a time, the same; `number` is that of this time's quantity |
!> | RELAXATION_TIME | log of a factor on that time; `number` is that of the share |
!>
!> Soft hinges, damage, point masses and relaxations have the same parameter at many places, or times, of which one at a time may
!> differ from its null; an experiment is made for those that do.
module diagnosis_wing_quantities
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use measurement_experiment, only: experiment_t
  use measurement_simulation, only: simulation_t
  use solid_effect, only: NEED_SIDED_VEINS
  use solid_effects, only: needs_of
  use solid_params, only: solid_params_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_quantity_t, differing, find_quantity, setup_t, make_setup, is_setup_for, setup_coordinates, &
            quantity_tangent, setup_params

  integer, parameter, public :: KIND_PARAMETER = 1, KIND_INSTRUMENT = 2, KIND_SOFT = 3, KIND_DAMAGE = 4, KIND_ZERO = 5, &
                                KIND_MASS = 6, KIND_POINT_MASS = 7, KIND_DAMPING = 8, KIND_RELAXATION = 9, &
                                KIND_RELAXATION_TIME = 10

  !> A wing at rest feels none of these.
  integer, parameter :: OF_MOTION(5) = [KIND_MASS, KIND_POINT_MASS, KIND_DAMPING, KIND_RELAXATION, KIND_RELAXATION_TIME]

  type :: wing_quantity_t
    integer :: kind = KIND_PARAMETER
    integer :: number = 0        !< of the parameter, the hinge, the offset or another quantity
    real(rp) :: disc(3) = 0      !< [m] x, y, radius of a damage; x, y of a point mass
    real(rp) :: time = 0         !< [s] of a relaxation
    logical :: is_log = .false.  !< of an effect of masses or damping: the coordinate is a logarithm
    integer :: vein = 0          !< of a soft hinge
    real(rp) :: share = 0        !< its place, of the vein's length
    real(rp) :: null = 0         !< coordinate at which it does nothing, or where the wing has it
  end type wing_quantity_t

  !> An experiment whose unknowns are the quantities `order`, in that order.
  type :: setup_t
    type(experiment_t) :: experiment
    integer, allocatable :: order(:)
  end type setup_t

contains

  !> Quantities of the shape under a load that differ from their null at q.
  pure function differing(quantities, q) result(numbers)
    type(wing_quantity_t), intent(in) :: quantities(:)
    real(rp), intent(in) :: q(:)
    integer, allocatable :: numbers(:)
    integer :: i
    numbers = pack([(i, i=1, size(q))], abs(q - quantities%null) > 0 .or. quantities%kind == KIND_ZERO)
    numbers = pack(numbers, [(all(quantities(numbers(i))%kind /= OF_MOTION), i=1, size(numbers))])
  end function differing

  !> The quantity of this kind and number behind the first `behind`; 0: none.
  pure integer function find_quantity(quantities, behind, kind, number) result(found)
    type(wing_quantity_t), intent(in) :: quantities(:)
    integer, intent(in) :: behind, kind, number
    integer :: i
    found = 0
    do i = behind + 1, size(quantities)
      if (quantities(i)%kind == kind .and. quantities(i)%number == number) found = i
    end do
  end function find_quantity

  !> Whether the experiment has what differs from its null at q as unknowns, and nothing else: a parameter at its null is not the
  !> same to the last bit as none, and what a rank has done before must not show.
  pure logical function is_setup_for(setup, quantities, q) result(is_it)
    type(setup_t), intent(in) :: setup
    type(wing_quantity_t), intent(in) :: quantities(:)
    real(rp), intent(in) :: q(:)
    integer, allocatable :: wanted(:)
    integer :: i
    is_it = .false.
    if (.not. allocated(setup%order)) return
    wanted = differing(quantities, q)
    is_it = size(wanted) == size(setup%order)
    if (is_it) is_it = all([(any(setup%order == wanted(i)), i=1, size(wanted))])
  end function is_setup_for

  !> The experiment for q, from one without unknowns.
  subroutine make_setup(bare, wing, quantities, q, setup)
    type(experiment_t), intent(in) :: bare
    type(wing_t), intent(in) :: wing
    type(wing_quantity_t), intent(in) :: quantities(:)
    real(rp), intent(in) :: q(:)
    type(setup_t), intent(out) :: setup
    type(solid_params_t) :: params
    type(failure_t) :: failure
    integer, allocatable :: wanted(:), numbers(:), instrument_numbers(:), wing_order(:), other_order(:), zero_order(:)
    integer :: i
    params = bare%model%params
    wanted = differing(quantities, q)
    call require(count(quantities(wanted)%kind == KIND_SOFT) <= 1 .and. &
                 count(quantities(wanted)%kind == KIND_DAMAGE) <= 1, 'diagnosis_wing_quantities: one place at a time')
    allocate (numbers(0), instrument_numbers(0), wing_order(0), other_order(0), zero_order(0))
    do i = 1, size(wanted)
      associate (one => quantities(wanted(i)))
        select case (one%kind)
        case (KIND_PARAMETER)
          numbers = [numbers, one%number]
          if (needs_sided_veins(params, one%number)) params%effects%has_sided_veins = .true.
        case (KIND_SOFT)
          params%effects%soft_vein = trim(params%vein_names(one%vein))
          params%effects%soft_share = one%share
          numbers = [numbers, params%find('soft')]
        case (KIND_DAMAGE)
          params%effects%disc = one%disc
          numbers = [numbers, params%find('damage')]
        case (KIND_INSTRUMENT)
          instrument_numbers = [instrument_numbers, one%number]
        end select
        if (one%kind == KIND_INSTRUMENT) then
          other_order = [other_order, wanted(i)]
        else if (one%kind == KIND_ZERO) then
          zero_order = [zero_order, wanted(i)]
        else
          wing_order = [wing_order, wanted(i)]
        end if
      end associate
    end do
    setup%order = [wing_order, other_order, zero_order]
    call setup%experiment%init(bare%measurement, wing, params, numbers, bare%options, failure, bare%instrument, &
                               instrument_numbers, bare%masses)
    call require(.not. failure%failed, 'diagnosis_wing_quantities: an experiment of tested parts')
  end subroutine make_setup

  logical function needs_sided_veins(params, number)
    type(solid_params_t), intent(in) :: params
    integer, intent(in) :: number
    needs_sided_veins = .false.
    if (number > params%count_usual()) &
      needs_sided_veins = any(needs_of(params%effects, number - params%count_usual()) == NEED_SIDED_VEINS)
  end function needs_sided_veins

  !> Coordinates of the experiment.
  pure function setup_coordinates(setup, q) result(coordinates)
    type(setup_t), intent(in) :: setup
    real(rp), intent(in) :: q(:)
    real(rp) :: coordinates(size(setup%order))
    coordinates = q(setup%order)
  end function setup_coordinates

  !> All parameters of the wing at q, with the places of effects.
  subroutine setup_params(bare, wing, quantities, q, setup, params)
    type(experiment_t), intent(in) :: bare
    type(wing_t), intent(in) :: wing
    type(wing_quantity_t), intent(in) :: quantities(:)
    real(rp), intent(in) :: q(:)
    type(setup_t), intent(out) :: setup
    type(solid_params_t), intent(out) :: params
    call make_setup(bare, wing, quantities, q, setup)
    params = setup%experiment%params(setup_coordinates(setup, q))
  end subroutine setup_params

  !> column(n): derivative of the residuals of load l with respect to quantity i at q, after `residuals` of the
  !> simulation.
  subroutine quantity_tangent(simulation, setup, quantities, q, i, l, column)
    class(simulation_t), intent(inout) :: simulation
    type(setup_t), intent(in) :: setup
    type(wing_quantity_t), intent(in) :: quantities(:)
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: i, l
    real(rp), intent(out) :: column(:)
    integer :: k
    associate (one => quantities(i), e => setup%experiment)
      select case (one%kind)
      case (KIND_PARAMETER)
        call simulation%parameter_tangent(e, l, one%number, column)
      case (KIND_INSTRUMENT)
        call simulation%instrument_tangent(e, l, one%number, column)
      case (KIND_SOFT)
        call simulation%hinge_tangent(e, l, one%number, column)
      case (KIND_DAMAGE)
        if (abs(q(i) - one%null) > 0) then
          call simulation%parameter_tangent(e, l, e%model%params%find('damage'), column)
        else
          call simulation%damage_tangent(e, l, one%disc, column)
        end if
      case (KIND_MASS, KIND_POINT_MASS, KIND_DAMPING, KIND_RELAXATION, KIND_RELAXATION_TIME) ! a wing at rest does not feel them
        column = 0
      case default
        do k = 1, size(setup%order)
          if (setup%order(k) == i) call simulation%derivative(e, l, k, column)
        end do
      end select
    end associate
  end subroutine quantity_tangent
end module diagnosis_wing_quantities
