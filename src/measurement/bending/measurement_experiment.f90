! SPDX-License-Identifier: GPL-3.0-or-later
!> Repeats a measurement with a model of the wing. It knows the free parameters and their bounds, and compares every load.
!>
!> The unknowns are coordinates: the natural logarithm of parameters that vary by factors, the value of others. Those of
!> the wing come first, then those of the instrument, and the unknown offsets of observations last.
module measurement_experiment
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use measurement_comparison, only: comparison_t
  use measurement_data, only: measurement_t
  use measurement_instrument, only: instrument_t, missing_for
  use measurement_instrument_causes, only: GRAVITY_X, GRAVITY_Z, HEIGHT_SCALE, LOAD_SHIFT_X, LOAD_SHIFT_Y, MAP_SCALE, &
                                           MAP_SHIFT_X, N_INSTRUMENT
  use measurement_material_point, only: find_material_point, material_point_t
  use measurement_sampling, only: outline_edges
  use solid_effects, only: any_curves_rest, curves_rest
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_usual_causes, only: PARAM_PLATE, PARAM_THICKNESS
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: experiment_t, bends_rest

  !> Holds all data that do not depend on the unknowns. They stay the same during a fit.
  type :: experiment_t
    type(measurement_t) :: measurement
    type(solid_model_t) :: model                    !< with the values of all parameters that are not free
    type(static_options_t) :: options
    integer, allocatable :: numbers(:)              !< of the free parameters of the wing
    type(instrument_t) :: instrument                !< with the values of all parameters that are not free
    integer, allocatable :: instrument_numbers(:)   !< of the free parameters of the instrument
    logical, allocatable :: is_log(:)               !< (free parameters) their coordinates are logarithms
    real(rp), allocatable :: masses(:)              !< (n_points) [kg]; empty if there is no weight
    logical :: moves_rest = .false.                 !< the image of the unloaded wing differs from the wing file
    logical :: bends_rest = .false.                 !< weight or camber bends the unloaded wing
    type(load_t), allocatable :: loads(:)
    type(material_point_t), allocatable :: sites(:)  !< where the forces act
    type(comparison_t), allocatable :: comparisons(:)
    integer, allocatable :: edges(:, :)             !< (2, :) the outline
    real(rp) :: root(3) = 0                         !< [m] centre of the clamped points
    integer :: tip = 1                              !< the point farthest from the root
  contains
    procedure :: init => experiment_init
    procedure :: count => experiment_count
    procedure :: count_parameters => experiment_count_parameters
    procedure :: count_residuals => experiment_count_residuals
    procedure :: describe => experiment_describe
    procedure :: start => experiment_start
    procedure :: params => experiment_params
    procedure :: instrument_at => experiment_instrument_at
    procedure :: cost => experiment_cost
    procedure :: acts_on_wing => experiment_acts_on_wing
  end type experiment_t

contains

  !> Makes the experiment of a checked `measurement` of `wing`. The parameters of the wing with these `numbers` (see solid_params_t)
  !> are free; the others keep their values in `params`. The same holds for `instrument_numbers` and `instrument`; without
  !> `instrument`, the measurement has no errors. Weight needs masses(n_points) [kg]. Fails if the model cannot be made, if a free
  !> parameter on a logarithmic scale is not positive, or if the measurement lacks data that a free parameter of the instrument
  !> needs.
  subroutine experiment_init(self, measurement, wing, params, numbers, options, failure, instrument, &
                             instrument_numbers, masses)
    class(experiment_t), intent(out) :: self
    type(measurement_t), intent(in) :: measurement
    type(wing_t), intent(in) :: wing
    type(solid_params_t), intent(in) :: params
    integer, intent(in) :: numbers(:)
    type(static_options_t), intent(in) :: options
    type(failure_t), intent(out) :: failure
    type(instrument_t), intent(in), optional :: instrument
    integer, intent(in), optional :: instrument_numbers(:)
    real(rp), intent(in), optional :: masses(:)
    type(parameter_t) :: parameter
    real(rp) :: distance, farthest
    integer :: i, l, c
    self%measurement = measurement
    self%options = options
    self%numbers = numbers
    call self%model%init(wing, params, failure)
    if (failure%failed) return
    call require(.not. (any(numbers == PARAM_PLATE) .and. any(numbers == PARAM_THICKNESS)), &
                 'experiment_t: D and thickness are one parameter')
    do i = 1, size(numbers)
      parameter = self%model%params%describe(numbers(i))
      if (parameter%is_log .and. .not. self%model%params%get(numbers(i)) > 0) &
        call failure%raise('parameter '//parameter%name//' must start above 0')
    end do
    if (failure%failed) return
    self%root = sum(wing%points(:, wing%root), 2)/size(wing%root)
    farthest = -1
    do i = 1, size(wing%points, 2)
      distance = norm2(wing%points(:, i) - self%root)
      if (distance > farthest) self%tip = i
      farthest = max(farthest, distance)
    end do
    if (present(instrument)) self%instrument = instrument
    call self%instrument%set_scales(measurement, farthest)
    allocate (self%instrument_numbers(0), self%masses(0))
    if (present(instrument_numbers)) self%instrument_numbers = instrument_numbers
    if (present(masses)) self%masses = masses
    call check_instrument(self, wing, failure)
    if (failure%failed) return
    call find_scales(self)
    self%edges = outline_edges(size(wing%points, 2), wing%triangles)
    allocate (self%loads(size(measurement%loads)), self%sites(size(measurement%loads)), &
              self%comparisons(size(measurement%loads)))
    do l = 1, size(self%loads)
      associate (load => measurement%loads(l))
        self%sites(l) = find_material_point(wing%points, wing%triangles, farthest, load%point)
        call require(self%sites(l)%is_found, 'experiment_t: the measurement was not checked')
        call self%loads(l)%init(self%model)
        do c = 1, 3
          call self%loads(l)%add_point(self%sites(l)%corner(c), self%sites(l)%weight(c)*load%force*load%direction)
        end do
      end associate
      call self%comparisons(l)%init(measurement, l, wing, self%edges, farthest)
    end do
  end subroutine experiment_init

  !> Finds the free parameters whose coordinates are logarithms, once for all evaluations.
  subroutine find_scales(self)
    class(experiment_t), intent(inout) :: self
    type(parameter_t) :: p
    integer :: i
    allocate (self%is_log(self%count_parameters()))
    do i = 1, size(self%is_log)
      p = self%describe(i)
      self%is_log(i) = p%is_log
    end do
  end subroutine find_scales

  !> Finds the loads on the unloaded wing. Fails if data for a free parameter are missing.
  subroutine check_instrument(self, wing, failure)
    class(experiment_t), intent(inout) :: self
    type(wing_t), intent(in) :: wing
    type(failure_t), intent(inout) :: failure
    type(instrument_t) :: null
    type(parameter_t) :: p
    character(:), allocatable :: problem
    logical :: acts(N_INSTRUMENT)
    integer :: i
    do i = 1, N_INSTRUMENT
      acts(i) = any(self%instrument_numbers == i) .or. abs(self%instrument%get(i) - null%get(i)) > 0
      if (.not. acts(i)) cycle
      p = self%instrument%describe(i)
      problem = missing_for(i, self%measurement)
      if (problem == '' .and. any(i == [LOAD_SHIFT_X, LOAD_SHIFT_Y]) .and. size(wing%triangles) == 0) &
        problem = 'needs a wing with a membrane'
      if (problem == '' .and. i >= GRAVITY_X .and. i <= GRAVITY_Z .and. size(self%masses) == 0) &
        problem = 'needs the mass of the wing'
      if (problem == '' .and. p%is_log .and. .not. self%instrument%get(i) > 0) problem = 'must start above 0'
      if (problem /= '') call failure%raise('parameter '//p%name//' '//problem)
    end do
    self%bends_rest = any(acts(GRAVITY_X:GRAVITY_Z)) .or. any_curves_rest(self%model%params%effects)
    do i = 1, size(self%numbers)
      if (bends_rest(self%model%params, self%numbers(i))) self%bends_rest = .true.
    end do
    self%moves_rest = self%bends_rest .or. acts(HEIGHT_SCALE) .or. any(acts(MAP_SHIFT_X:MAP_SCALE))
  end subroutine check_instrument

  !> Tells whether parameter `number` of the wing curves the wing without a load.
  pure logical function bends_rest(params, number)
    type(solid_params_t), intent(in) :: params
    integer, intent(in) :: number
    bends_rest = curves_rest(params%effects, number - params%count_basic())
  end function bends_rest

  !> Returns the number of unknowns.
  pure integer function experiment_count(self) result(n)
    class(experiment_t), intent(in) :: self
    n = self%count_parameters() + size(self%measurement%zeros)
  end function experiment_count

  !> Returns the number of unknowns that are not offsets of observations.
  pure integer function experiment_count_parameters(self) result(n)
    class(experiment_t), intent(in) :: self
    n = size(self%numbers) + size(self%instrument_numbers)
  end function experiment_count_parameters

  !> Returns the number of residuals under load l, or under all loads for l = 0.
  pure integer function experiment_count_residuals(self, l) result(n)
    class(experiment_t), intent(in) :: self
    integer, intent(in) :: l
    if (l > 0) then
      n = self%comparisons(l)%n
    else
      n = sum(self%comparisons%n)
    end if
  end function experiment_count_residuals

  !> Returns name, unit, scale and bounds of unknown i: of a parameter, or of an offset, which is called 'zero:<name>'.
  function experiment_describe(self, i) result(p)
    class(experiment_t), intent(in) :: self
    integer, intent(in) :: i
    type(parameter_t) :: p
    integer :: zero, k
    if (i <= size(self%numbers)) then
      p = self%model%params%describe(self%numbers(i))
      return
    end if
    if (i <= self%count_parameters()) then
      p = self%instrument%describe(self%instrument_numbers(i - size(self%numbers)))
      return
    end if
    zero = i - self%count_parameters()
    p%name = 'zero:'//trim(self%measurement%zeros(zero))
    p%unit = 'm'
    p%is_log = .false.
    p%upper = self%model%size
    do k = 1, size(self%measurement%observations)
      associate (observation => self%measurement%observations(k))
        if (observation%zero == zero) p%upper = max(p%upper, 10*abs(observation%value))
      end associate
    end do
    p%lower = -p%upper
  end function experiment_describe

  !> Returns the coordinates that belong to the parameters in `model` and `instrument` and to offsets of 0.
  function experiment_start(self) result(coordinates)
    class(experiment_t), intent(in) :: self
    real(rp) :: coordinates(self%count())
    integer :: i
    coordinates = 0
    do i = 1, size(self%numbers)
      coordinates(i) = self%model%params%get(self%numbers(i))
      if (self%is_log(i)) coordinates(i) = log(coordinates(i))
    end do
    do i = size(self%numbers) + 1, self%count_parameters()
      coordinates(i) = self%instrument%get(self%instrument_numbers(i - size(self%numbers)))
      if (self%is_log(i)) coordinates(i) = log(coordinates(i))
    end do
  end function experiment_start

  !> Returns all parameters of the model at these coordinates.
  function experiment_params(self, coordinates) result(params)
    class(experiment_t), intent(in) :: self
    real(rp), intent(in) :: coordinates(:)
    type(solid_params_t) :: params
    integer :: i
    params = self%model%params
    do i = 1, size(self%numbers)
      if (self%is_log(i)) then
        call params%set(self%numbers(i), exp(coordinates(i)))
      else
        call params%set(self%numbers(i), coordinates(i))
      end if
    end do
  end function experiment_params

  !> Returns all parameters of the instrument at these coordinates.
  function experiment_instrument_at(self, coordinates) result(instrument)
    class(experiment_t), intent(in) :: self
    real(rp), intent(in) :: coordinates(:)
    type(instrument_t) :: instrument
    integer :: i, j
    instrument = self%instrument
    do i = 1, size(self%instrument_numbers)
      j = size(self%numbers) + i
      if (self%is_log(j)) then
        call instrument%set(self%instrument_numbers(i), exp(coordinates(j)))
      else
        call instrument%set(self%instrument_numbers(i), coordinates(j))
      end if
    end do
  end function experiment_instrument_at

  !> Returns h [m] of Truong et al.: the square root of the sum over loads of the mean squared difference of the deformations.
  !> residuals(:) are those of all loads, one load after another. Scalar observations do not count.
  pure real(rp) function experiment_cost(self, residuals) result(h)
    class(experiment_t), intent(in) :: self
    real(rp), intent(in) :: residuals(:)
    integer :: l, first
    h = 0
    first = 1
    do l = 1, size(self%comparisons)
      associate (n => self%comparisons(l)%n_heights)
        if (n > 0) h = h + sum(residuals(first:first + n - 1)**2)/n
      end associate
      first = first + self%comparisons(l)%n
    end do
    h = sqrt(h)
  end function experiment_cost

  !> Tells whether the point at the distance `load_offset` [m] from the declared site of load l is on the wing.
  logical function experiment_acts_on_wing(self, l, load_offset) result(acts)
    class(experiment_t), intent(in) :: self
    integer, intent(in) :: l
    real(rp), intent(in) :: load_offset(2)
    type(material_point_t) :: site
    site = find_material_point(self%model%points, self%model%triangles, self%model%size, &
                                self%measurement%loads(l)%point + load_offset)
    acts = site%is_found
  end function experiment_acts_on_wing
end module measurement_experiment
