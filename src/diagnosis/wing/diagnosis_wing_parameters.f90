! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the parameters that a diagnosis of a wing varies, and makes the experiment that has them.
!>
!> | kind | coordinate |
!> |---|---|
!> | PARAMETER | of a parameter of the wing, by its number in solid_params_t |
!> | INSTRUMENT | of a parameter of the measurement, by its number in instrument_t |
!> | SOFT | log of a factor on the stiffness of one hinge of a vein |
!> | DAMAGE | log of a factor on all stiffness inside a disc |
!> | MEMBRANE | log of a factor on D beside that of PARAMETER, if there is one; its prior is how well D is known |
!> | ZERO | [m] unknown offset of scalar observations |
!> | MASS | of an effect of the masses, by its number in solid_mass_effects; only natural modes depend on it |
!> | POINT_MASS | [kg] a mass at a site, the same |
!> | DAMPING | of an effect of the damping, by its number in solid_damping_effects; only motion depends on it |
!> | RELAXATION | fraction of the stiffness that relaxes with a time, the same; `number` is that of this time's quantity |
!> | RELAXATION_TIME | log of a factor on that time; `number` is that of the fraction |
!> | SHAKE | a part of a motion of the base in one record, by its number in solid_ringing; `partner` is its frequency |
!> | SITE | a coordinate of the site of a damage or a point mass: x, y [m] or the logarithm of the radius; `number` is unique |
!> | FLIGHT | a change of kinematics or flow, by its number in diagnosis_flight_runner; only records of forces depend on it |
!> | BALANCE | an error of the force balance, by its number in measurement_balance, the same |
!>
!> Soft hinges, damage, point masses, relaxations and motions of the base exist once for each of many sites, times or frequencies.
!> An experiment has only those that differ from their null, at most one of each kind.
module diagnosis_wing_parameters
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use diagnosis_mesh_relation, only: mesh_relation_t
  use measurement_experiment, only: experiment_t
  use measurement_simulation, only: simulation_t
  use solid_effect, only: NEED_SIDED_VEINS
  use solid_effects, only: needs_of
  use solid_layout, only: free_place_in_vein
  use solid_params, only: solid_params_t
  use solid_usual_causes, only: PARAM_K_VEIN, PARAM_PLATE, PARAM_ROOT
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_parameter_t, wing_parameter, without_sites, differing, find_parameter, fit_case_t, make_fit_case, &
            is_fit_case_for, disc_at, fit_case_coordinates, is_hinge_of_piece, place_on_file, relate_to_file, scale_membrane, &
            same_parameter, wing_parameter_tangent, fit_case_params

  integer, parameter, public :: KIND_PARAMETER = 1, KIND_INSTRUMENT = 2, KIND_SOFT = 3, KIND_DAMAGE = 4, KIND_ZERO = 5, &
                                KIND_MASS = 6, KIND_POINT_MASS = 7, KIND_DAMPING = 8, KIND_RELAXATION = 9, &
                                KIND_RELAXATION_TIME = 10, KIND_FLIGHT = 11, KIND_BALANCE = 12, KIND_SHAKE = 13, &
                                KIND_SITE = 14, KIND_MEMBRANE = 15

  !> These parameters do not affect a wing at rest, or only with the parameter whose site they are.
  integer, parameter :: OF_MOTION(9) = [KIND_SITE, KIND_MASS, KIND_POINT_MASS, KIND_DAMPING, KIND_RELAXATION, &
                                        KIND_RELAXATION_TIME, KIND_FLIGHT, KIND_BALANCE, KIND_SHAKE]

  !> A parameter with its coordinates. At its null it has no effect, or the value that the wing has.
  type, extends(parameter_t) :: wing_parameter_t
    integer :: kind = KIND_PARAMETER
    integer :: number = 0        !< of the parameter, the hinge, the offset or another quantity
    real(rp) :: disc(3) = 0      !< [m] x, y, radius of a damage; x, y of a point mass
    real(rp) :: time = 0         !< [s] of a relaxation; of a period of the base
    integer :: record = 0        !< of a motion of the base; the case that a change of a flight belongs to, 0: all
    !> Its parameter for the frequency; the first one of those for the site of a damage or a point mass, 0: it has a fixed one.
    integer :: partner = 0
    integer :: vein = 0          !< of a soft hinge
    real(rp) :: fraction = 0     !< position of the hinge, as a fraction of the vein's length
    real(rp) :: file_fraction = 0 !< the same on the mesh of the wing file: of its nearest hinge
    type(mesh_relation_t) :: on_file !< its coordinate on the mesh of the wing file, if that is another one
  end type wing_parameter_t

  !> An experiment whose unknowns are the parameters `order`, in that order.
  type :: fit_case_t
    type(experiment_t) :: experiment
    integer, allocatable :: order(:)
    integer, allocatable, private :: wanted(:) !< all parameters that differ from their null
    !> Where in `order` the coordinate of D is, and the parameter of its error, which adds to it; 0: none.
    integer, private :: membrane(2) = 0
    real(rp), private :: stated = 0            !< that coordinate without error
  end type fit_case_t

contains

  !> Returns a parameter of this kind and number.
  pure function wing_parameter(parameter, kind, number) result(p)
    type(parameter_t), intent(in) :: parameter
    integer, intent(in) :: kind, number
    type(wing_parameter_t) :: p
    p%parameter_t = parameter
    p%kind = kind
    p%number = number
  end function wing_parameter

  !> Tells the parameters of a wing on the finer mesh, whose values there are `params`, what they are on the mesh of its file, where
  !> the joints have the stiffnesses of_file(joints). A joint whose stiffness is not stated is as stiff as its vein on each mesh,
  !> and so is the hinge at the clamp; a stated factor of this hinge holds on every mesh.
  pure subroutine relate_to_file(parameters, params, of_file)
    type(wing_parameter_t), intent(inout) :: parameters(:)
    type(solid_params_t), intent(in) :: params
    real(rp), intent(in) :: of_file(:)
    real(rp), parameter :: HALF = 0.5_rp !< of the length of an edge
    integer :: i, j
    do i = 1, size(parameters)
      associate (p => parameters(i), relation => parameters(i)%on_file)
        relation = mesh_relation_t()
        if (is_hinge_of_piece(p, params)) relation = mesh_relation_t(p%null, p%null, HALF)
        if (p%kind /= KIND_PARAMETER) cycle
        if (p%number == PARAM_K_VEIN) relation%file_null = log(HALF)
        if (.not. params%is_joint(p%number)) cycle
        j = p%number - params%count_basic() + size(params%joint)
        relation = mesh_relation_t(log(params%joint(j)), log(of_file(j)), min(1.0_rp, of_file(j)/params%joint(j)))
      end associate
    end do
  end subroutine relate_to_file

  !> Tells the soft places on a finer mesh where they are on `wing`, with the mesh of its file: at its nearest hinges that no joint
  !> has.
  pure subroutine place_on_file(parameters, wing)
    type(wing_parameter_t), intent(inout) :: parameters(:)
    type(wing_t), intent(in) :: wing
    integer :: i
    do i = 1, size(parameters)
      associate (p => parameters(i))
        if (p%kind == KIND_SOFT) p%file_fraction = free_place_in_vein(wing, p%vein, p%fraction)
      end associate
    end do
  end subroutine place_on_file

  !> Tells whether a parameter is the factor on a hinge that stands for a piece of vein of another length on each mesh: a soft
  !> place, and the root if `params` of the wing state no factor of it.
  pure logical function is_hinge_of_piece(p, params)
    type(wing_parameter_t), intent(in) :: p
    type(solid_params_t), intent(in) :: params
    is_hinge_of_piece = p%kind == KIND_SOFT .or. &
                        p%kind == KIND_PARAMETER .and. p%number == PARAM_ROOT .and. .not. abs(params%root_factor - 1) > 0
  end function is_hinge_of_piece

  !> Returns what the statistics see of the parameters.
  pure function without_sites(parameters) result(p)
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(parameter_t), allocatable :: p(:)
    integer :: i
    allocate (p(size(parameters)))
    do i = 1, size(parameters)
      p(i) = parameters(i)%parameter_t
    end do
  end function without_sites

  !> Returns the parameters of the shape under a load that differ from their null at q.
  pure function differing(parameters, q) result(numbers)
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    integer, allocatable :: numbers(:)
    integer :: i
    numbers = pack([(i, i=1, size(q))], abs(q - parameters%null) > 0 .or. parameters%kind == KIND_ZERO)
    numbers = pack(numbers, [(all(parameters(numbers(i))%kind /= OF_MOTION), i=1, size(numbers))])
  end function differing

  !> Tells whether two descriptions are those of one parameter at one place, or of one whose place is sought.
  pure logical function same_parameter(a, b) result(same)
    type(wing_parameter_t), intent(in) :: a, b
    same = a%kind == b%kind .and. a%number == b%number .and. a%record == b%record .and. a%vein == b%vein
    if (same) same = a%name == b%name .and. a%partner == b%partner .and. .not. abs(a%fraction - b%fraction) > 0 .and. &
                     .not. abs(a%time - b%time) > 0
    if (same .and. a%partner == 0) same = .not. any(abs(a%disc - b%disc) > 0)
  end function same_parameter

  !> Returns x, y [m] and the radius [m] of a damage, or x and y of a point mass and a number without meaning: the site of
  !> parameter i at q.
  pure function disc_at(parameters, i, q) result(disc)
    type(wing_parameter_t), intent(in) :: parameters(:)
    integer, intent(in) :: i
    real(rp), intent(in) :: q(:)
    real(rp) :: disc(3)
    disc = parameters(i)%disc
    associate (first => parameters(i)%partner)
      if (first == 0) return
      disc(:2) = q(first:first + 1)
      if (parameters(i)%kind == KIND_DAMAGE) disc(3) = exp(q(first + 2))
    end associate
  end function disc_at

  !> Returns the parameter of this kind and number behind the first `behind`; 0: none.
  pure integer function find_parameter(parameters, behind, kind, number) result(found)
    type(wing_parameter_t), intent(in) :: parameters(:)
    integer, intent(in) :: behind, kind, number
    integer :: i
    found = 0
    do i = behind + 1, size(parameters)
      if (parameters(i)%kind == kind .and. parameters(i)%number == number) found = i
    end do
  end function find_parameter

  !> Tells whether the unknowns of the experiment are exactly the parameters that differ from their null at q. A parameter at its
  !> null changes the last bit of a result. Without this rule results would depend on what a rank has computed before.
  pure logical function is_fit_case_for(fit_case, parameters, q) result(is_it)
    type(fit_case_t), intent(in) :: fit_case
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    integer, allocatable :: wanted(:)
    integer :: i
    is_it = .false.
    if (.not. allocated(fit_case%wanted)) return
    wanted = differing(parameters, q)
    is_it = size(wanted) == size(fit_case%wanted)
    if (is_it) is_it = all(fit_case%wanted == wanted)
    if (.not. is_it) return
    do i = 1, size(wanted)
      if (parameters(wanted(i))%kind /= KIND_DAMAGE) cycle
      is_it = is_it .and. all(abs(fit_case%experiment%model%params%effects%disc - disc_at(parameters, wanted(i), q)) <= 0)
    end do
  end function is_fit_case_for

  !> Makes the experiment for q from one without unknowns.
  subroutine make_fit_case(bare, wing, parameters, q, fit_case)
    type(experiment_t), intent(in) :: bare
    type(wing_t), intent(in) :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    type(fit_case_t), intent(out) :: fit_case
    type(solid_params_t) :: params
    type(failure_t) :: failure
    integer, allocatable :: wanted(:), numbers(:), instrument_numbers(:), wing_order(:), other_order(:), zero_order(:)
    integer :: i
    params = bare%model%params
    wanted = differing(parameters, q)
    fit_case%wanted = wanted
    wanted = take_membrane(bare, parameters, wanted, fit_case)
    call require(count(parameters(wanted)%kind == KIND_SOFT) <= 1 .and. &
                 count(parameters(wanted)%kind == KIND_DAMAGE) <= 1, 'diagnosis_wing_parameters: only one soft place, one damage')
    allocate (numbers(0), instrument_numbers(0), wing_order(0), other_order(0), zero_order(0))
    do i = 1, size(wanted)
      associate (one => parameters(wanted(i)))
        select case (one%kind)
        case (KIND_PARAMETER)
          numbers = [numbers, one%number]
          if (needs_sided_veins(params, one%number)) params%effects%has_sided_veins = .true.
        case (KIND_MEMBRANE)
          numbers = [numbers, PARAM_PLATE]
        case (KIND_SOFT)
          params%effects%soft_vein = trim(params%vein_names(one%vein))
          params%effects%soft_fraction = one%fraction
          numbers = [numbers, params%find(one%name)]
        case (KIND_DAMAGE)
          params%effects%disc = disc_at(parameters, wanted(i), q)
          numbers = [numbers, params%find(one%name)]
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
    fit_case%order = [wing_order, other_order, zero_order]
    if (fit_case%membrane(2) > 0) &
      fit_case%membrane(1) = findloc([(is_of_membrane(parameters(fit_case%order(i))), i=1, size(fit_case%order))], .true., 1)
    call fit_case%experiment%init(bare%measurement, wing, params, numbers, bare%options, failure, bare%instrument, &
                                  instrument_numbers, bare%masses)
    call require(.not. failure%failed, 'diagnosis_wing_parameters: the experiment must be valid')
  end subroutine make_fit_case

  !> Tells whether a parameter belongs to an effect that needs [Wing] sided_veins.
  logical function needs_sided_veins(params, number)
    type(solid_params_t), intent(in) :: params
    integer, intent(in) :: number
    needs_sided_veins = .false.
    if (number > params%count_basic()) &
      needs_sided_veins = any(needs_of(params%effects, number - params%count_basic()) == NEED_SIDED_VEINS)
  end function needs_sided_veins

  !> Returns the coordinates of q in this experiment.
  pure function fit_case_coordinates(fit_case, q) result(coordinates)
    type(fit_case_t), intent(in) :: fit_case
    real(rp), intent(in) :: q(:)
    real(rp) :: coordinates(size(fit_case%order))
    coordinates = q(fit_case%order)
    associate (at => fit_case%membrane(1), error => fit_case%membrane(2))
      if (error == 0) return
      if (fit_case%order(at) == error) then
        coordinates(at) = fit_case%stated + q(error)
      else
        coordinates(at) = coordinates(at) + q(error)
      end if
    end associate
  end function fit_case_coordinates

  !> Returns all parameters of the wing at q, with the sites of effects.
  subroutine fit_case_params(bare, wing, parameters, q, fit_case, params)
    type(experiment_t), intent(in) :: bare
    type(wing_t), intent(in) :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    type(fit_case_t), intent(out) :: fit_case
    type(solid_params_t), intent(out) :: params
    call make_fit_case(bare, wing, parameters, q, fit_case)
    params = fit_case%experiment%params(fit_case_coordinates(fit_case, q))
  end subroutine fit_case_params

  !> Notes the parameter of the error of D in the fit case, if it is wanted. Returns the wanted parameters without it if D itself is
  !> among them: both are one unknown of the experiment.
  function take_membrane(bare, parameters, wanted, fit_case) result(unknowns)
    type(experiment_t), intent(in) :: bare
    type(wing_parameter_t), intent(in) :: parameters(:)
    integer, intent(in) :: wanted(:)
    type(fit_case_t), intent(inout) :: fit_case
    integer, allocatable :: unknowns(:)
    type(parameter_t) :: p
    integer :: i
    unknowns = wanted
    do i = 1, size(wanted)
      if (parameters(wanted(i))%kind == KIND_MEMBRANE) fit_case%membrane(2) = wanted(i)
    end do
    if (fit_case%membrane(2) == 0) return
    p = bare%model%params%describe(PARAM_PLATE)
    p = p%as_coordinate(bare%model%params%get(PARAM_PLATE))
    fit_case%stated = p%null
    if (count([(is_of_membrane(parameters(wanted(i))), i=1, size(wanted))]) == 1) return
    unknowns = pack(wanted, wanted /= fit_case%membrane(2))
  end function take_membrane

  !> Tells whether a parameter is D, or the error of D.
  pure logical function is_of_membrane(parameter) result(is_it)
    type(wing_parameter_t), intent(in) :: parameter
    is_it = parameter%kind == KIND_MEMBRANE .or. parameter%kind == KIND_PARAMETER .and. parameter%number == PARAM_PLATE
  end function is_of_membrane

  !> Multiplies D by the factor of its error at q. It comes after all other parameters are set.
  subroutine scale_membrane(parameters, q, params)
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    type(solid_params_t), intent(inout) :: params
    integer :: i
    do i = 1, size(q)
      if (parameters(i)%kind == KIND_MEMBRANE) call params%set(PARAM_PLATE, params%get(PARAM_PLATE)*exp(q(i)))
    end do
  end subroutine scale_membrane

  !> Returns column(n), the derivative of the residuals of load l with respect to parameter i at q, after `residuals` of the
  !> simulation.
  subroutine wing_parameter_tangent(simulation, fit_case, parameters, q, i, l, column)
    class(simulation_t), intent(inout) :: simulation
    type(fit_case_t), intent(in) :: fit_case
    type(wing_parameter_t), intent(in) :: parameters(:)
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: i, l
    real(rp), intent(out) :: column(:)
    integer :: k
    associate (one => parameters(i), e => fit_case%experiment)
      select case (one%kind)
      case (KIND_PARAMETER)
        call simulation%parameter_tangent(e, l, one%number, column)
      case (KIND_MEMBRANE)
        call simulation%parameter_tangent(e, l, PARAM_PLATE, column)
      case (KIND_INSTRUMENT)
        call simulation%instrument_tangent(e, l, one%number, column)
      case (KIND_SOFT)
        call simulation%hinge_tangent(e, l, one%number, column)
      case (KIND_DAMAGE)
        if (abs(q(i) - one%null) > 0) then
          call simulation%parameter_tangent(e, l, e%model%params%find(one%name), column)
        else
          call simulation%damage_tangent(e, l, disc_at(parameters, i, q), column)
        end if
      case (KIND_MASS, KIND_POINT_MASS, KIND_DAMPING, KIND_RELAXATION, KIND_RELAXATION_TIME, KIND_FLIGHT, KIND_BALANCE, &
            KIND_SHAKE, KIND_SITE)
        ! These parameters do not affect a wing at rest.
        column = 0
      case default
        do k = 1, size(fit_case%order)
          if (fit_case%order(k) == i) call simulation%derivative(e, l, k, column)
        end do
      end select
    end associate
  end subroutine wing_parameter_tangent
end module diagnosis_wing_parameters
