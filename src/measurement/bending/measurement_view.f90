! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the image of a wing with and without a load in an instrument, and its change when points move.
module measurement_view
  use base_kinds, only: rp
  use measurement_comparison, only: observed_shape_t
  use measurement_experiment, only: experiment_t
  use measurement_instrument, only: instrument_t
  use measurement_instrument_causes, only: PISTON, TILT_X
  use measurement_map, only: plane_height, plane_slope, map_position_derivatives, map_positions, map_parameter_derivatives
  implicit none
  private
  public :: view_t

  !> Holds the image of the wing, one per process. Nothing is allocated after `init`.
  type :: view_t
    type(instrument_t) :: instrument
    real(rp) :: scale = 1                            !< factor on the forces; displacements are divided by it
    type(observed_shape_t), private :: loaded, rest  !< the wing with and without the load
    real(rp), allocatable, private :: shown(:, :)
    real(rp), allocatable, private :: rest_heights(:), slopes(:)
  contains
    procedure :: init => view_init
    procedure :: free => view_free
    procedure :: set => view_set
    procedure :: observe_rest => view_observe_rest
    procedure :: residuals => view_residuals
    procedure :: add_plane => view_add_plane
    procedure :: plane => view_plane
    procedure :: loaded_tangent => view_loaded_tangent
    procedure :: rest_tangent => view_rest_tangent
    procedure :: map_tangent => view_map_tangent
  end type view_t

contains

  !> Makes room for this experiment.
  subroutine view_init(self, experiment)
    class(view_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer :: n, n_heights
    call self%free()
    n = experiment%model%n_points
    n_heights = maxval(experiment%comparisons%n_heights)
    call self%loaded%init(n, n_heights)
    call self%rest%init(n, n_heights)
    allocate (self%shown(3, n), self%rest_heights(n_heights), self%slopes(n_heights), source=0.0_rp)
  end subroutine view_init

  !> Releases everything.
  subroutine view_free(self)
    class(view_t), intent(inout) :: self
    if (allocated(self%shown)) deallocate (self%shown, self%rest_heights, self%slopes)
  end subroutine view_free

  !> Sets the instrument.
  subroutine view_set(self, instrument)
    class(view_t), intent(inout) :: self
    type(instrument_t), intent(in) :: instrument
    self%instrument = instrument
    self%scale = instrument%load_scale()
  end subroutine view_set

  !> Finds the heights of the wing without a load at the measured points of load l. If weight bends the wing, it has moved it by
  !> moved(3, :) [m].
  subroutine view_observe_rest(self, experiment, l, moved)
    class(view_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(in), optional :: moved(:, :)
    integer :: n
    n = experiment%model%n_points
    associate (comparison => experiment%comparisons(l), m => experiment%measurement, model => experiment%model)
      self%rest%positions = model%points(:, :n)
      if (present(moved)) self%rest%positions = self%rest%positions + moved(:, :n)
      call map_positions(self%instrument, self%rest%positions, self%rest%seen)
      call comparison%locate(m%x, m%y, model%triangles, experiment%edges, self%rest)
      call comparison%heights(self%rest, self%rest_heights)
    end associate
  end subroutine view_observe_rest

  !> Returns residuals(n) under load l without the plane of the scan. The wing is moved by moved(3, :) [m]; zeros(:) are unknown
  !> offsets. If the instrument or the weight moves the unloaded wing, call `observe_rest` first.
  subroutine view_residuals(self, experiment, l, moved, zeros, residuals)
    class(view_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(in) :: moved(:, :), zeros(:)
    real(rp), intent(out) :: residuals(:)
    integer :: n
    n = experiment%model%n_points
    associate (comparison => experiment%comparisons(l), m => experiment%measurement, model => experiment%model)
      self%loaded%positions = model%points(:, :n) + moved(:, :n)
      call map_positions(self%instrument, self%loaded%positions, self%loaded%seen)
      if (.not. experiment%moves_rest) self%rest_heights(:comparison%n_heights) = comparison%unloaded
      call comparison%locate(m%x, m%y, model%triangles, experiment%edges, self%loaded)
      call comparison%residuals(model%points, self%loaded, self%rest_heights, 1/self%scale, zeros, residuals)
    end associate
  end subroutine view_residuals

  !> Adds the plane of the scan to residuals(n).
  subroutine view_add_plane(self, experiment, l, residuals)
    class(view_t), intent(in) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(inout) :: residuals(:)
    integer :: k
    if (self%instrument%is_null(TILT_X, PISTON)) return
    associate (comparison => experiment%comparisons(l), m => experiment%measurement)
      do k = 1, comparison%n_heights
        residuals(k) = residuals(k) + plane_height(self%instrument, m%x(comparison%node(1, k)), &
                                                   m%y(comparison%node(2, k)))
      end do
    end associate
  end subroutine view_add_plane

  !> Returns column(n), the derivative of the plane with respect to parameter `number`; 0 if the plane does not depend on it.
  subroutine view_plane(self, experiment, l, number, column)
    class(view_t), intent(in) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l, number
    real(rp), intent(out) :: column(:)
    integer :: k
    column = 0*self%scale
    associate (comparison => experiment%comparisons(l), m => experiment%measurement)
      do k = 1, comparison%n_heights
        column(k) = plane_slope(number, m%x(comparison%node(1, k)), m%y(comparison%node(2, k)))
      end do
    end associate
  end subroutine view_plane

  !> Returns column(n), the change of the residuals by motion(3, :) [m per unit] of the loaded wing.
  subroutine view_loaded_tangent(self, experiment, l, motion, column)
    class(view_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(in) :: motion(:, :)
    real(rp), intent(out) :: column(:)
    integer :: n
    n = experiment%model%n_points
    call map_position_derivatives(self%instrument, motion(:, :n), self%shown)
    associate (comparison => experiment%comparisons(l), m => experiment%measurement)
      call comparison%derivatives(m%x, m%y, self%loaded, motion(:, :n), self%shown, column)
    end associate
    column = column/self%scale
  end subroutine view_loaded_tangent

  !> Adds to column(n) the change by motion(3, :) [m per unit] of the wing without a load, after `observe_rest`.
  subroutine view_rest_tangent(self, experiment, l, motion, column)
    class(view_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(in) :: motion(:, :)
    real(rp), intent(inout) :: column(:)
    call map_position_derivatives(self%instrument, motion(:, :experiment%model%n_points), self%shown)
    call subtract_rest(self, experiment, l, column)
  end subroutine view_rest_tangent

  !> Returns column(n), the change of the residuals by parameter `number` of the map; 0 if they do not depend on it.
  subroutine view_map_tangent(self, experiment, l, number, column)
    class(view_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l, number
    real(rp), intent(out) :: column(:)
    column = 0
    call map_parameter_derivatives(self%instrument, number, self%loaded%positions, self%shown)
    if (.not. any(abs(self%shown) > 0)) return
    if (.not. experiment%moves_rest) call self%observe_rest(experiment, l)
    associate (comparison => experiment%comparisons(l), m => experiment%measurement)
      call comparison%height_slopes(m%x, m%y, self%loaded, self%shown, column)
    end associate
    column = column/self%scale
    call map_parameter_derivatives(self%instrument, number, self%rest%positions, self%shown)
    call subtract_rest(self, experiment, l, column)
  end subroutine view_map_tangent

  !> Subtracts the slopes of the unloaded shape from a tangent.
  subroutine subtract_rest(self, experiment, l, column)
    class(view_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(inout) :: column(:)
    associate (comparison => experiment%comparisons(l), m => experiment%measurement)
      call comparison%height_slopes(m%x, m%y, self%rest, self%shown, self%slopes)
      column(:comparison%n_heights) = column(:comparison%n_heights) - self%slopes(:comparison%n_heights)/self%scale
    end associate
  end subroutine subtract_rest
end module measurement_view
