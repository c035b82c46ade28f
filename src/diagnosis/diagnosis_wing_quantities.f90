! SPDX-License-Identifier: GPL-3.0-or-later
!> The parameters of a wing and of its measurement as the diagnosis varies them, by one kind each, and what they do to the
!> model of one load.
!>
!> | kind | coordinate |
!> |---|---|
!> | PARAMETER | a parameter of the wing, by its number in solid_params_t |
!> | SOFT | log of a factor on the stiffness of one hinge of a vein |
!> | DAMAGE | log of a factor on all stiffness inside a disc |
!> | GAIN | log of the true over the stated forces |
!> | OFFSET | [N] true less stated force |
!> | SCALE | log of the shown over the true deformation |
!> | DRIFT | change of log of all bending stiffness over the whole sequence of measurements, in equal steps |
!> | CREEP | change of log of all bending stiffness for a tenfold time of holding |
!> | LEAN_X, LEAN_Y | [rad] turn of all forces about x and y |
!> | ZERO | [m] unknown offset of scalar observations |
module diagnosis_wing_quantities
  use base_kinds, only: rp
  use measurement_experiment, only: experiment_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_sensitivity, only: direction_sensitivity, force_sensitivity
  use solid_equilibrium, only: equilibrium_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: bending_direction, damage_direction, hinge_direction, parameter_direction
  implicit none
  private
  public :: wing_quantity_t, set_model, set_load, load_scale, differentiate_shape

  integer, parameter, public :: KIND_PARAMETER = 1, KIND_SOFT = 2, KIND_DAMAGE = 3, KIND_GAIN = 4, KIND_OFFSET = 5, &
                                KIND_SCALE = 6, KIND_DRIFT = 7, KIND_CREEP = 8, KIND_LEAN_X = 9, KIND_LEAN_Y = 10, &
                                KIND_ZERO = 11

  type :: wing_quantity_t
    integer :: kind = KIND_PARAMETER
    integer :: number = 0        !< of the parameter, the hinge or the offset
    logical :: is_log = .true.   !< of a parameter
    real(rp) :: disc(3) = 0      !< [m] x, y, radius of a damage
    integer :: vein = 0          !< of a soft hinge
    real(rp) :: share = 0        !< its place, of the vein's length
    real(rp) :: null = 0         !< coordinate at which it does nothing
  end type wing_quantity_t

contains

  !> Gives the model the parameters that belong to q under load l.
  subroutine set_model(quantities, q, experiment, l, model)
    type(wing_quantity_t), intent(in) :: quantities(:)
    real(rp), intent(in) :: q(:)
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    type(solid_model_t), intent(inout) :: model
    type(solid_params_t) :: params
    real(rp) :: bending
    integer :: i
    params = experiment%model%params
    bending = 0
    do i = 1, size(quantities)
      associate (one => quantities(i))
        select case (one%kind)
        case (KIND_PARAMETER)
          if (one%is_log) then
            call params%set(one%number, exp(q(i)))
          else
            call params%set(one%number, q(i))
          end if
        case (KIND_SOFT)
          if (abs(q(i)) <= 0) cycle
          model%layout%soft_hinge = one%number
          params%effects%soft = exp(q(i))
        case (KIND_DAMAGE)
          if (abs(q(i)) <= 0) cycle
          params%effects%disc = one%disc
          params%effects%damage = exp(q(i))
        case (KIND_DRIFT, KIND_CREEP)
          bending = bending + q(i)*lever(one%kind, experiment, l)
        end select
      end associate
    end do
    if (abs(bending) > 0) then
      params%young = params%young*exp(bending)
      params%plate = params%plate*exp(bending)
      where (params%joint > 0) params%joint = params%joint*exp(bending)
    end if
    call model%set_params(params)
  end subroutine set_model

  !> By how much a drift or a creep of 1 changes log of the bending stiffness under load l.
  pure real(rp) function lever(kind, experiment, l)
    integer, intent(in) :: kind, l
    type(experiment_t), intent(in) :: experiment
    associate (loads => experiment%measurement%loads)
      if (kind == KIND_DRIFT) then
        lever = 0
        if (size(loads) > 1) lever = (loads(l)%order - 0.5_rp*(size(loads) + 1))/(size(loads) - 1)
      else
        lever = log10(max(loads(l)%hold, 1.0e-3_rp)) - sum(log10(max(loads%hold, 1.0e-3_rp)))/size(loads)
      end if
    end associate
  end function lever

  !> The true load for the stated load l.
  subroutine set_load(quantities, q, experiment, l, load)
    type(wing_quantity_t), intent(in) :: quantities(:)
    real(rp), intent(in) :: q(:)
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    type(load_t), intent(inout) :: load
    real(rp) :: factor, lean(2), direction(3)
    integer :: i, c
    factor = 1
    lean = 0
    associate (stated => experiment%measurement%loads(l), place => experiment%places(l))
      do i = 1, size(quantities)
        select case (quantities(i)%kind)
        case (KIND_GAIN)
          factor = factor*exp(q(i))
        case (KIND_LEAN_X)
          lean(1) = lean(1) + q(i)
        case (KIND_LEAN_Y)
          lean(2) = lean(2) + q(i)
        end select
      end do
      do i = 1, size(quantities)
        if (quantities(i)%kind == KIND_OFFSET .and. stated%force > 0) factor = factor + q(i)/stated%force
      end do
      direction = turned(stated%direction, lean)
      load%force = 0
      do c = 1, 3
        call load%add_point(place%corner(c), place%share(c)*factor*stated%force*direction)
      end do
    end associate
  end subroutine set_load

  !> v after turns about x and then about y [rad].
  pure function turned(v, lean) result(w)
    real(rp), intent(in) :: v(3), lean(2)
    real(rp) :: w(3), t(3)
    t = [v(1), cos(lean(1))*v(2) - sin(lean(1))*v(3), sin(lean(1))*v(2) + cos(lean(1))*v(3)]
    w = [cos(lean(2))*t(1) + sin(lean(2))*t(3), t(2), -sin(lean(2))*t(1) + cos(lean(2))*t(3)]
  end function turned

  !> The shown over the true deformation.
  pure real(rp) function load_scale(quantities, q) result(scale)
    type(wing_quantity_t), intent(in) :: quantities(:)
    real(rp), intent(in) :: q(:)
    scale = exp(sum(q, mask=quantities%kind == KIND_SCALE))
  end function load_scale

  !> The derivative(3, n_all) [m] of the shape u under load l with respect to quantity i at q, right after the static
  !> solution in `work`. Zero for what does not move the wing.
  subroutine differentiate_shape(quantities, q, i, experiment, l, work, model, load, u, derivative)
    type(wing_quantity_t), intent(in) :: quantities(:)
    real(rp), intent(in) :: q(:), u(:, :)
    integer, intent(in) :: i, l
    type(experiment_t), intent(in) :: experiment
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(out) :: derivative(:, :)
    real(rp), parameter :: STEP = 1.0e-4_rp ! of an angle, for a central difference of smooth forces
    type(stiffness_t) :: direction
    type(load_t) :: above, below
    real(rp) :: moved(size(q))
    derivative = 0
    associate (one => quantities(i))
      select case (one%kind)
      case (KIND_PARAMETER)
        call parameter_direction(model, one%number, direction)
      case (KIND_SOFT)
        call hinge_direction(model, one%number, direction)
      case (KIND_DAMAGE)
        if (abs(q(i)) > 0) then
          call parameter_direction(model, model%params%find('damage'), direction)
        else
          call damage_direction(model, one%disc, direction)
        end if
      case (KIND_DRIFT, KIND_CREEP)
        call bending_direction(model, direction)
      case (KIND_GAIN, KIND_OFFSET, KIND_LEAN_X, KIND_LEAN_Y)
        above = load
        below = load
        moved = q
        if (one%kind == KIND_OFFSET) then
          moved(i) = q(i) + experiment%measurement%loads(l)%force
          call set_load(quantities, moved, experiment, l, above)
          call force_sensitivity(work, model, (above%force - load%force)/ &
                                 max(experiment%measurement%loads(l)%force, tiny(1.0_rp)), derivative)
          return
        end if
        moved(i) = q(i) + STEP
        call set_load(quantities, moved, experiment, l, above)
        moved(i) = q(i) - STEP
        call set_load(quantities, moved, experiment, l, below)
        call force_sensitivity(work, model, (above%force - below%force)/(2*STEP), derivative)
        return
      case default
        return
      end select
      call direction_sensitivity(work, model, u, direction, derivative)
      if (one%kind == KIND_DRIFT .or. one%kind == KIND_CREEP) derivative = derivative*lever(one%kind, experiment, l)
    end associate
  end subroutine differentiate_shape
end module diagnosis_wing_quantities
