! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes a measurement of a wing from the model itself, on the same mesh, at ten places. The caller adds the errors. It serves to
!> validate fits, since it contains no error of the model.
module bench_replicate
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_text, only: number_text
  use loaded_wing, only: MODERATE_FORCES, N_LOADS, place_on_wing
  use measurement_data, only: measurement_t
  use measurement_evaluation, only: evaluate, evaluation_t, evaluation_work_t
  use measurement_experiment, only: experiment_t
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: replicate_t

  integer, parameter, public :: N_JOINTS = 10, N_UNKNOWNS = N_JOINTS + 1
  !> Unknown 1 is ln E, the others are the logarithms of the joints' stiffness.
  character(*), parameter, public :: UNKNOWN_YOUNG = 'E'

  !> A wing with ten joints and the way it is measured.
  type :: replicate_t
    type(wing_t) :: wing
    type(solid_params_t) :: params           !< defaults, joints as the veins would be
    integer :: numbers(N_UNKNOWNS) = 0       !< of the unknowns among the parameters
    integer :: n_grid(2) = [60, 30]          !< points of the measurement along x and y over the wing's extent
    type(static_options_t) :: options
  contains
    procedure :: init => replicate_init
    procedure :: defaults => replicate_defaults
    procedure :: measure => replicate_measure
  end type replicate_t

contains

  !> Stops unless the wing has ten joints.
  subroutine replicate_init(self, wing)
    class(replicate_t), intent(out) :: self
    type(wing_t), intent(in) :: wing
    type(solid_model_t) :: model
    type(failure_t) :: failure
    integer :: i
    call require(size(wing%joints) == N_JOINTS, 'a wing with ten joints is needed')
    self%wing = wing
    self%options%tolerance = 1.0e-8_rp
    self%params = default_params(wing)
    self%params%cross_springs = .true.
    call model%init(wing, self%params, failure)
    call require(.not. failure%failed, 'a wing that makes a model')
    self%params = model%params
    self%numbers = [self%params%find(UNKNOWN_YOUNG), (self%params%count_basic() - N_JOINTS + i, i=1, N_JOINTS)]
  end subroutine replicate_init

  !> Returns the logarithms of the unknowns at the defaults.
  pure function replicate_defaults(self) result(coordinates)
    class(replicate_t), intent(in) :: self
    real(rp) :: coordinates(N_UNKNOWNS)
    integer :: i
    coordinates = [(log(self%params%get(self%numbers(i))), i=1, N_UNKNOWNS)]
  end function replicate_defaults

  !> Computes in `experiment` the measurement of a wing with the unknowns truth(:) without any error; `sigma` [m] is the declared
  !> sd of every deformation. The forces are proportional to E, so that the deflections do not depend on it. Not `is_done` if a
  !> shape is not found, lies in an excluded zone, or is reached by a snap.
  subroutine replicate_measure(self, truth, sigma, experiment, is_done)
    class(replicate_t), intent(in) :: self
    real(rp), intent(in) :: truth(N_UNKNOWNS), sigma
    type(experiment_t), intent(out) :: experiment
    logical, intent(out) :: is_done
    type(measurement_t) :: m
    type(experiment_t) :: blank
    type(evaluation_t) :: evaluation
    type(evaluation_work_t) :: work
    type(failure_t) :: failure
    real(rp), allocatable :: u(:, :)
    integer :: l, k
    call lay_out(self, exp(truth(1))/self%params%young, sigma, m)
    call blank%init(m, self%wing, self%params, self%numbers, self%options, failure)
    call require(.not. failure%failed, 'a model of the wing')
    call work%init(blank)
    allocate (u(3, blank%model%n_all))
    is_done = .true.
    do l = 1, N_LOADS
      call evaluation%init(blank, l, .false.)
      u = 0
      call evaluate(blank, work, truth, l, .false., u, evaluation)
      is_done = is_done .and. evaluation%is_feasible() .and. evaluation%snaps == 0
      associate (comparison => blank%comparisons(l))
        do k = 1, comparison%n_heights
          m%loads(l)%height(comparison%node(1, k) + self%n_grid(1)*(comparison%node(2, k) - 1)) = &
            evaluation%residuals(k)
        end do
      end associate
    end do
    call work%free()
    call experiment%init(m, self%wing, self%params, self%numbers, self%options, failure)
  end subroutine replicate_measure

  !> Makes a flat measurement of a flat wing, whose unloaded heights are exact.
  subroutine lay_out(self, factor, sigma, m)
    type(replicate_t), intent(in) :: self
    real(rp), intent(in) :: factor, sigma
    type(measurement_t), intent(out) :: m
    type(solid_model_t) :: model
    type(failure_t) :: failure
    real(rp) :: low(2), step(2)
    integer :: i, j, l
    call model%init(self%wing, self%params, failure)
    low = minval(self%wing%points(:2, :), 2)
    step = (maxval(self%wing%points(:2, :), 2) - low)/self%n_grid
    m%x = [(low(1) + (i - 0.37_rp)*step(1), i=1, self%n_grid(1))] ! grid lines pass through no point of the mesh
    m%y = [(low(2) + (j - 0.41_rp)*step(2), j=1, self%n_grid(2))]
    allocate (m%unloaded(self%n_grid(1), self%n_grid(2)), source=0.0_rp)
    allocate (m%unloaded_sigma, source=m%unloaded)
    allocate (m%has_unloaded(self%n_grid(1), self%n_grid(2)), source=.true.)
    allocate (m%loads(N_LOADS), m%observations(0), m%zeros(0))
    m%accuracy%height = sigma
    do l = 1, N_LOADS
      associate (load => m%loads(l))
        load%name = 'load_'//number_text(l)
        load%force = factor*MODERATE_FORCES(l)
        load%direction = [0.0_rp, 0.0_rp, 1.0_rp]
        load%point = place_on_wing(model, l)
        load%has_surface = .true.
        load%node = reshape([((i, j, i=1, self%n_grid(1)), j=1, self%n_grid(2))], [2, product(self%n_grid)])
        allocate (load%height(product(self%n_grid)), source=0.0_rp)
        allocate (load%sigma(product(self%n_grid)), source=sigma)
      end associate
    end do
  end subroutine lay_out
end module bench_replicate
