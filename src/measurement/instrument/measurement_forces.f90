! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the true force under a load with a given instrument, and its derivatives. Also computes the change of stiffness by
!> drying and creep up to that load.
module measurement_forces
  use base_kinds, only: rp
  use measurement_data, only: measured_load_t
  use measurement_instrument, only: instrument_t
  use measurement_instrument_causes, only: CREEP, CREEP_TIME, DRIFT, DRIFT_RATE, DRIFT_VEINS, FORCE_GAIN, FORCE_OFFSET, &
                                           FORCE_TILT_X, FORCE_TILT_Y, GRAVITY_X, GRAVITY_Z, LOAD_SHIFT_X, LOAD_SHIFT_Y
  use measurement_material_point, only: find_material_point, material_point_t, weight_gradient
  use solid_model, only: solid_model_t
  use solid_rotation, only: rotation_derivative, rotation_matrix
  implicit none
  private
  public :: applied_t, apply_load, add_weight, force_derivative, magnitude_derivative, position_derivative, &
            stiffness_factor, stiffness_slopes

  !> Describes where and how a force acts.
  type :: applied_t
    type(material_point_t) :: site
    real(rp) :: magnitude = 0             !< [N]
    real(rp) :: direction(3) = 0          !< unit vector
    logical :: is_applied = .false.       !< there is a force, and it acts on the wing
    logical :: is_valid = .true.          !< false: the force would act outside the wing
  end type applied_t

contains

  !> Sets force(3, :) [N] to the force of `load` on the points of `model`. `site` is the declared site of the load. The force acts
  !> at the distance load_offset(2) [m] from the site that the instrument gives. If it acts outside the wing, `applied` is not valid
  !> and the force is zero.
  subroutine apply_load(instrument, load, site, model, load_offset, applied, force)
    type(instrument_t), intent(in) :: instrument
    type(measured_load_t), intent(in) :: load
    type(material_point_t), intent(in) :: site
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: load_offset(2)
    type(applied_t), intent(out) :: applied
    real(rp), intent(inout) :: force(:, :)
    real(rp) :: shift(2)
    integer :: c
    shift = instrument%values([LOAD_SHIFT_X, LOAD_SHIFT_Y]) + load_offset
    applied%site = site
    if (any(abs(shift) > 0)) &
      applied%site = find_material_point(model%points, model%triangles, model%size, load%point + shift)
    applied%is_valid = applied%site%is_found
    applied%is_applied = load%force > 0 .and. applied%is_valid
    applied%direction = load%direction
    if (any(abs(tilt_of(instrument)) > 0)) &
      applied%direction = matmul(rotation_matrix(tilt_of(instrument)), load%direction)
    applied%magnitude = instrument%values(FORCE_GAIN)*load%force + instrument%values(FORCE_OFFSET)
    force = 0
    if (.not. applied%is_applied) return
    do c = 1, 3
      associate (node => applied%site%corner(c))
        force(:, node) = force(:, node) + applied%site%weight(c)*applied%magnitude*applied%direction
      end associate
    end do
  end subroutine apply_load

  !> Returns the tilt of all forces.
  pure function tilt_of(instrument) result(tilt)
    type(instrument_t), intent(in) :: instrument
    real(rp) :: tilt(3)
    tilt = [instrument%values(FORCE_TILT_X), instrument%values(FORCE_TILT_Y), 0.0_rp]
  end function tilt_of

  !> Adds the weight of masses(n_points) [kg] to force(3, :).
  pure subroutine add_weight(instrument, masses, force)
    type(instrument_t), intent(in) :: instrument
    real(rp), intent(in) :: masses(:)
    real(rp), intent(inout) :: force(:, :)
    integer :: i
    do i = 1, size(masses)
      force(:, i) = force(:, i) + masses(i)*instrument%values(GRAVITY_X:GRAVITY_Z)
    end do
  end subroutine add_weight

  !> Returns derivative(3, :) [N per unit] of the force with respect to the coordinate of parameter `number`, per log unit of the
  !> gain; 0 for parameters that do not change the force.
  subroutine force_derivative(instrument, load, applied, masses, points, number, derivative)
    type(instrument_t), intent(in) :: instrument
    type(measured_load_t), intent(in) :: load
    type(applied_t), intent(in) :: applied
    real(rp), intent(in) :: masses(:), points(:, :)
    integer, intent(in) :: number
    real(rp), intent(out) :: derivative(:, :)
    integer :: i
    derivative = 0
    select case (number)
    case (FORCE_GAIN)
      call spread_force(applied, instrument%values(FORCE_GAIN)*load%force*applied%direction, derivative)
    case (FORCE_OFFSET)
      call spread_force(applied, applied%direction, derivative)
    case (FORCE_TILT_X, FORCE_TILT_Y)
      call spread_force(applied, applied%magnitude* &
                        matmul(rotation_derivative(tilt_of(instrument), number - FORCE_TILT_X + 1), load%direction), &
                        derivative)
    case (LOAD_SHIFT_X, LOAD_SHIFT_Y)
      call position_derivative(applied, points, number - LOAD_SHIFT_X + 1, derivative)
    case (GRAVITY_X:GRAVITY_Z)
      do i = 1, size(masses)
        derivative(number - GRAVITY_X + 1, i) = masses(i)
      end do
    end select
  end subroutine force_derivative

  !> Returns derivative(3, :) of the force with respect to the magnitude of this force alone.
  subroutine magnitude_derivative(applied, derivative)
    type(applied_t), intent(in) :: applied
    real(rp), intent(out) :: derivative(:, :)
    derivative = 0
    call spread_force(applied, applied%direction, derivative)
  end subroutine magnitude_derivative

  !> Returns derivative(3, :) [N/m] of the force with respect to x (axis 1) or y of its site; 0 on a structure without triangles.
  subroutine position_derivative(applied, points, axis, derivative)
    type(applied_t), intent(in) :: applied
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: axis
    real(rp), intent(out) :: derivative(:, :)
    real(rp) :: slope(2, 3)
    integer :: c
    derivative = 0
    if (.not. (applied%is_applied .and. applied%site%is_in_triangle)) return
    slope = weight_gradient(points, applied%site)
    do c = 1, 3
      derivative(:, applied%site%corner(c)) = slope(axis, c)*applied%magnitude*applied%direction
    end do
  end subroutine position_derivative

  !> Adds a force to the three points of its triangle.
  subroutine spread_force(applied, vector, force)
    type(applied_t), intent(in) :: applied
    real(rp), intent(in) :: vector(3)
    real(rp), intent(inout) :: force(:, :)
    integer :: c
    if (.not. applied%is_applied) return
    do c = 1, 3
      associate (node => applied%site%corner(c))
        force(:, node) = force(:, node) + applied%site%weight(c)*vector
      end associate
    end do
  end subroutine spread_force

  !> Returns the factors under this load: (1) on all bending stiffness, (2) on the veins' E in addition.
  pure function stiffness_factor(instrument, load) result(factor)
    type(instrument_t), intent(in) :: instrument
    type(measured_load_t), intent(in) :: load
    real(rp) :: factor(2)
    associate (v => instrument%values)
      factor(1) = (1 + v(DRIFT)*(load%order - 1))*(1 + v(DRIFT_RATE)*max(0.0_rp, load%time))/ &
                  (1 + v(CREEP)*decades(v, load))
      factor(2) = 1 + v(DRIFT_VEINS)*(load%order - 1)
    end associate
  end function stiffness_factor

  !> Returns the derivatives of the logarithms of these factors with respect to the coordinate of parameter `number`.
  pure function stiffness_slopes(instrument, load, number) result(slope)
    type(instrument_t), intent(in) :: instrument
    type(measured_load_t), intent(in) :: load
    integer, intent(in) :: number
    real(rp) :: slope(2), ratio
    real(rp), parameter :: TEN = 10
    slope = 0
    associate (v => instrument%values)
      select case (number)
      case (DRIFT)
        slope(1) = (load%order - 1)/(1 + v(DRIFT)*(load%order - 1))
      case (DRIFT_RATE)
        slope(1) = max(0.0_rp, load%time)/(1 + v(DRIFT_RATE)*max(0.0_rp, load%time))
      case (DRIFT_VEINS)
        slope(2) = (load%order - 1)/(1 + v(DRIFT_VEINS)*(load%order - 1))
      case (CREEP)
        slope(1) = -decades(v, load)/(1 + v(CREEP)*decades(v, load))
      case (CREEP_TIME)
        ratio = max(0.0_rp, load%hold)/v(CREEP_TIME)
        slope(1) = v(CREEP)*ratio/((1 + ratio)*log(TEN)*(1 + v(CREEP)*decades(v, load)))
      end select
    end associate
  end function stiffness_slopes

  !> Returns log10(1 + hold/tau).
  pure real(rp) function decades(values, load)
    real(rp), intent(in) :: values(:)
    type(measured_load_t), intent(in) :: load
    decades = log10(1 + max(0.0_rp, load%hold)/values(CREEP_TIME))
  end function decades
end module measurement_forces
