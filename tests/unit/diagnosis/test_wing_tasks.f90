! SPDX-License-Identifier: GPL-3.0-or-later
!> A task of a diagnosis gives the same to the bit whatever its rank has done before: the wing in the file that the first
!> argument names, with E off its null, and in between every other parameter of the catalogue off its own. Ranks that have done
!> other tasks would give other numbers otherwise, and results depend on their number.
program test_wing_tasks
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_wing_bins, only: bins_t, make_bins
  use diagnosis_wing_catalogue, only: catalogue_t, make_catalogue
  use diagnosis_wing_lattice, only: make_patterns
  use diagnosis_wing_observed, only: diagnosed_wing_t
  use base_parameter, only: define_parameter, parameter_t
  use diagnosis_wing_parameters, only: fit_case_coordinates, fit_case_params, fit_case_t, is_fit_case_for, wing_parameter, &
                                       wing_parameter_t, KIND_MEMBRANE, KIND_PARAMETER
  use loaded_wing, only: wing_of_argument
  use measurement_bending_runner, only: bending_runner_t
  use measurement_bending_task, only: bending_task_t, task_input, N_FACTS, TASK_DIRECTIONS, TASK_EVALUATE
  use measurement_data, only: measurement_t
  use measurement_experiment, only: experiment_t
  use measurement_observed_wing, only: observed_wing_t, wing_patterns_t
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_usual_causes, only: PARAM_PLATE, PARAM_THICKNESS
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: NX = 12, NY = 8, TASKS(2) = [TASK_EVALUATE, TASK_DIRECTIONS]
  real(rp), parameter :: FORCE = 2.0e-4_rp !< [N] moves the place by some 0.01 of the wing's length
  type(testkit_t) :: t
  type(wing_t), target :: wing
  type(experiment_t), target :: bare
  type(catalogue_t) :: catalogue
  type(bending_runner_t) :: runner
  real(rp), allocatable :: q(:), other(:), before(:, :), now(:)
  character(:), allocatable :: name
  integer :: i, k, n_moved, status

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  call make()
  q = catalogue%parameters%null
  q(1) = q(1) + 0.1_rp
  allocate (before(runner%most_output(), 2), now(runner%most_output()))
  do k = 1, 2
    before(:, k) = done(k, q)
    call t%check('the task is done', status == 0 .and. any(abs(before(N_FACTS + 1:, k)) > 0))
  end do
  n_moved = 0
  name = ''
  do i = 2, size(q)
    if (catalogue%parameters(i)%name == name) cycle ! one of its places is enough
    name = catalogue%parameters(i)%name
    other = q
    other(i) = min(other(i) + 0.01_rp*catalogue%parameters(i)%prior_sd, catalogue%parameters(i)%upper)
    now = done(1, other)
    if (status == 0 .and. any(abs(now - before(:, 1)) > 0)) n_moved = n_moved + 1
    do k = 1, 2
      now = done(k, q)
      call t%check('after '//name, status == 0 .and. .not. any(abs(now - before(:, k)) > 0))
    end do
  end do
  call t%check('most quantities change the shape or what is seen', n_moved >= 30)
  call check_thickness()
  call check_membrane()
  call runner%free()
  call t%finish()

contains

  !> One load, seen on a coarse grid; what the heights are does not matter.
  subroutine make()
    type(measurement_t) :: m
    type(solid_params_t) :: params
    type(static_options_t) :: options
    type(failure_t) :: failure
    type(bins_t) :: bins
    type(wing_patterns_t) :: patterns
    type(diagnosed_wing_t), allocatable :: diagnosed
    class(observed_wing_t), allocatable :: observed
    real(rp) :: low(2), high(2)
    integer :: a, b
    low = minval(wing%points(:2, :), 2)
    high = maxval(wing%points(:2, :), 2)
    m%x = [(low(1) + (a - 0.5_rp)*(high(1) - low(1))/NX, a=1, NX)]
    m%y = [(low(2) + (b - 0.5_rp)*(high(2) - low(2))/NY, b=1, NY)]
    allocate (m%unloaded(NX, NY), source=0.0_rp)
    allocate (m%unloaded_sigma(NX, NY), source=1.0e-5_rp)
    allocate (m%has_unloaded(NX, NY), source=.true.)
    allocate (m%loads(1), m%observations(0), m%zeros(0))
    m%accuracy%height = 1.0e-5_rp
    params = default_params(wing)
    associate (load => m%loads(1))
      load%name = 'one'
      load%has_surface = .true.
      load%force = FORCE
      load%direction = [0.0_rp, 0.0_rp, 1.0_rp]
      load%order = 2
      load%time = 60
      load%hold = 10
      load%point = sum(wing%points(:2, wing%triangles(:, size(wing%triangles, 2)/2)), 2)/3
      load%node = reshape([((a, b, a=1, NX), b=1, NY)], [2, NX*NY])
      allocate (load%height(NX*NY), source=0.0_rp)
      allocate (load%sigma(NX*NY), source=1.0e-5_rp)
    end associate
    call bare%init(m, wing, params, [integer ::], options, failure, masses=spread(1.0e-9_rp, 1, size(wing%points, 2)))
    call t%check('the experiment is made',.not. failure%failed)
    call make_bins(bare, 0.1_rp*bare%model%size, bins)
    call make_catalogue(bare, wing, [params%find('E')], 1.0_rp, catalogue)
    call make_patterns(bare, wing, patterns)
    allocate (diagnosed)
    call diagnosed%init(bare, wing, catalogue%parameters, bins, patterns)
    call move_alloc(diagnosed, observed)
    call runner%init(observed)
  end subroutine make

  !> A baseline that fits the thickness has D already: D is no parameter of a cause, and a cause of D alone says why
  !> it is not tested.
  subroutine check_thickness()
    type(catalogue_t) :: of_thickness
    integer :: e
    call make_catalogue(bare, wing, [PARAM_THICKNESS], 1.0_rp, of_thickness)
    associate (p => of_thickness%parameters)
      call t%check('D is not fitted twice', .not. any(p%kind == KIND_PARAMETER .and. p%number == PARAM_PLATE))
    end associate
    do e = 1, size(of_thickness%effects)
      associate (effect => of_thickness%effects(e))
        if (effect%name == 'membrane_bending') call t%check('the membrane is a part of the baseline', &
                                                            effect%missing == 'it is a free parameter of the baseline')
        if (effect%name == 'elasticity') call t%check('the springs are tested without it', &
                                                      effect%missing == '' .and. size(effect%variants(1)%columns) == 3)
      end associate
    end do
  end subroutine check_thickness

  !> An error of D is a factor on D, whether D itself is another parameter or not.
  subroutine check_membrane()
    type(wing_parameter_t) :: list(2)
    type(parameter_t) :: p
    type(fit_case_t) :: fit_case
    type(solid_params_t) :: params
    real(rp) :: error(2), both(2), stated
    stated = bare%model%params%get(PARAM_PLATE)
    call define_parameter(p, 'membrane_error', '1', .true., 0.1_rp, 10.0_rp)
    list(1) = wing_parameter(p%as_coordinate(1.0_rp), KIND_MEMBRANE, PARAM_PLATE)
    p = bare%model%params%describe(PARAM_PLATE)
    list(2) = wing_parameter(p%as_coordinate(stated), KIND_PARAMETER, PARAM_PLATE)
    error = [log(1.2_rp), log(stated)]
    both = [log(1.2_rp), log(1.5_rp*stated)]
    call fit_case_params(bare, wing, list, error, fit_case, params)
    call t%check_close('the error multiplies D', params%get(PARAM_PLATE), 1.2_rp*stated, rtol=1.0e-13_rp)
    call t%check('it is one unknown', size(fit_case_coordinates(fit_case, error)) == 1 .and. is_fit_case_for(fit_case, list, error))
    call fit_case_params(bare, wing, list, both, fit_case, params)
    call t%check_close('and another D, too', params%get(PARAM_PLATE), 1.8_rp*stated, rtol=1.0e-13_rp)
    call t%check('both are one unknown', size(fit_case_coordinates(fit_case, both)) == 1 .and. &
                 is_fit_case_for(fit_case, list, both) .and. .not. is_fit_case_for(fit_case, list, error))
  end subroutine check_membrane

  !> What task k gives at the point, without warm start, with a derivative with respect to E.
  function done(k, point) result(output)
    integer, intent(in) :: k
    real(rp), intent(in) :: point(:)
    real(rp) :: output(size(now))
    output = 0
    call runner%run_task(task_input(bending_task_t(TASKS(k), load=1), point, [1]), output, status)
  end function done
end program test_wing_tasks
