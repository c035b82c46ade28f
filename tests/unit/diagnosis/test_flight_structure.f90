! SPDX-License-Identifier: GPL-3.0-or-later
!> Which parameters of the structure flights change: those of the first flights, and those that a round adds.
program test_flight_structure
  use base_cause, only: cause_t, make_cause
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: effect_parameter, parameter_t
  use diagnosis_flight_catalogue, only: exclude_unflown, flight_steps
  use diagnosis_flight_changes, only: FLOW_PLATE, FLOW_STRUCTURE, N_CHANGES, N_FLOW, N_STRUCTURE
  use diagnosis_flight_data, only: change_t, flight_data_t
  use diagnosis_flight_refinements, only: N_REFINEMENTS
  use diagnosis_flight_response, only: flight_response_t
  use diagnosis_flight_runner, only: flight_record_t, N_PHASES
  use diagnosis_flight_structure, only: acts_in_flight, add_structure, choose_structure, is_flown_first, structure_causes, &
                                        structure_step
  use diagnosis_wing_entries, only: append_variant, catalogue_t
  use diagnosis_wing_flight, only: wing_flight_t
  use diagnosis_wing_parameters, only: relate_to_file, wing_parameter, wing_parameter_t, KIND_BALANCE, KIND_DAMPING, KIND_MASS, &
                                       KIND_MEMBRANE, KIND_PARAMETER, KIND_POINT_MASS, KIND_SOFT
  use inference_simulator, only: variant_t
  use judging_runner, only: judging_runner_t, OWN_VALUE
  use measurement_flight, only: measured_flight_t, N_COMPONENTS
  use solid_damping_effects, only: DAMPING_DRAG, DAMPING_STIFFNESS
  use solid_mass_effects, only: MASS_ADDED, MASS_MEMBRANE
  use solid_params, only: solid_params_t
  use solid_usual_causes, only: N_COMMON, PARAM_EXPONENT, PARAM_K_VEIN, PARAM_ROOT, PARAM_PLATE, PARAM_YOUNG
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: JOINT = 12, GRADIENT = 40 !< numbers of parameters of the wing
  type(testkit_t) :: t
  call t%start(parallel=.false.)
  call check_kinds()
  call check_names()
  call check_steps()
  call check_choice()
  call check_alone()
  call check_full()
  call check_places()
  call check_round()
  call check_membrane()
  call check_finer_mesh()
  call t%finish()

contains

  !> E and D are changes of their own, the air is simulated, and the instrument and the balance are no wing.
  subroutine check_kinds()
    type(wing_parameter_t) :: p(9)
    p%kind = [KIND_PARAMETER, KIND_PARAMETER, KIND_PARAMETER, KIND_MASS, KIND_MASS, KIND_POINT_MASS, KIND_DAMPING, KIND_DAMPING, &
              KIND_BALANCE]
    p%number = [PARAM_YOUNG, PARAM_PLATE, PARAM_EXPONENT, MASS_MEMBRANE, MASS_ADDED, 0, DAMPING_STIFFNESS, DAMPING_DRAG, 1]
    call t%check('what acts on wings in flight', all(acts_in_flight(p) .eqv. [.false., .false., .true., .true., .false., .true., &
                                                                              .true., .false., .false.]))
  end subroutine check_kinds

  !> Without names those of the whole wing are flown first. Places are not, even if they are named.
  subroutine check_names()
    call t%check('a gradient is flown first', is_flown_first('', 'E_gradient') .and. is_flown_first('balance_gain E_gradient', &
                                                                                                    'E_gradient'))
    call t%check('not if others are named', .not. is_flown_first('balance_gain', 'E_gradient'))
    call t%check('one vein is flown first if it is named', .not. is_flown_first('', 'E_per_vein') .and. &
                 is_flown_first('E_per_vein', 'E_per_vein'))
    call t%check('a place is not', .not. is_flown_first('', 'damage') .and. .not. is_flown_first('damage', 'damage'))
    call t%check('nor can a user name it', index(structure_causes(), 'damage') == 0 .and. &
                 index(structure_causes(), 'stiffness_damping') == 0 .and. index(structure_causes(), 'membrane_mass') > 0)
  end subroutine check_names

  !> A factor of the prior sd or 0.3, 0.3 prior sd of what is no factor; in a round twice the sd of the fit.
  subroutine check_steps()
    type(flight_data_t) :: data
    real(rp) :: steps(N_FLOW), sd(N_FLOW)
    call t%check_close('a wide factor', structure_step(parameter_of('root', .true., 1.0_rp, 5)), 0.3_rp, rtol=1.0e-14_rp)
    call t%check_close('a narrow factor', structure_step(parameter_of('f', .true., 0.2_rp, 5)), 0.2_rp, rtol=1.0e-14_rp)
    call t%check_close('a value', structure_step(parameter_of('g', .false., 10.0_rp, 5)), 3.0_rp, rtol=1.0e-14_rp)
    data%facts%structure = [parameter_of('root', .true., 1.0_rp, 5), parameter_of('g', .false., 1.0_rp, 6)]
    data%facts%origin = [0.0_rp, 0.0_rp]
    data%facts%n_first = 1
    steps = flight_steps(data%facts, 'balance_gain')
    call t%check('the first flights are those of the first', count(steps > 0) == 1)
    call t%check_close('with its step', steps(FLOW_STRUCTURE + 1), 0.3_rp, rtol=1.0e-14_rp)
    sd = 0
    sd(FLOW_STRUCTURE + 2) = 0.051_rp
    steps = flight_steps(data%facts, 'balance_gain', sd)
    call t%check('a round flies what was fitted', count(steps > 0) == 1)
    call t%check_close('with twice its sd', steps(FLOW_STRUCTURE + 2), 0.1_rp, rtol=1.0e-12_rp)
    data%facts%missing(FLOW_STRUCTURE + 2) = 'cannot'
    steps = flight_steps(data%facts, 'balance_gain', sd)
    call t%check('unless the case cannot', .not. any(steps > 0))
  end subroutine check_steps

  !> Two cases that bend: the baseline's joint counts from the value of the case, a gradient from its null. The second case has no
  !> gradient, no case has `taper`, and damping can only grow.
  subroutine check_choice()
    type(catalogue_t) :: c
    type(flight_data_t), allocatable :: cases(:)
    type(judging_runner_t) :: runner
    type(change_t) :: change
    real(rp) :: changes(N_CHANGES)
    logical :: is_full
    integer :: k
    call make_catalogue(c)
    allocate (cases(2))
    do k = 1, 2
      cases(k)%facts%is_flexible = .true.
      cases(k)%facts%is_alone = .false.
      cases(k)%facts%shares = .true.
    end do
    call choose_structure(c, 'joint:*, E_gradient, taper, stiffness_damping', runner, cases, is_full)
    call t%check('the joint and the gradient are flown', .not. is_full .and. size(cases(1)%facts%structure) == 2 .and. &
                 cases(1)%facts%n_first == 2)
    change = cases(1)%change_by(c%parameters(1))
    call t%check('the joint is the first change, from the value of the case', change%number == FLOW_STRUCTURE + 1 .and. &
                 abs(change%origin - OWN_VALUE) <= 0)
    change = cases(2)%change_by(c%parameters(2))
    call t%check('the gradient is the second one, from its null', change%number == FLOW_STRUCTURE + 2 .and. &
                 abs(change%origin - 0.5_rp) <= 0)
    changes = cases(1)%changes_at(c%parameters(:2), [OWN_VALUE + 0.2_rp, 0.9_rp])
    call t%check_close('a gradient of 0.9 where 0.5 was assumed adds 0.4', changes(FLOW_STRUCTURE + 2), 0.4_rp, rtol=1.0e-14_rp)
    call t%check('one case cannot have it', cases(1)%facts%missing(FLOW_STRUCTURE + 2) == '' .and. &
                 cases(2)%facts%missing(FLOW_STRUCTURE + 2) == 'no gradient here')
    call t%check('other data show taper all the same', c%effects(2)%missing == '')
    change = cases(1)%change_by(c%parameters(3))
    call t%check('no flight changes it', change%number == 0)
  end subroutine check_choice

  !> D and its error, which other data share, are one change of the flights: the product of both over the D of the case.
  subroutine check_membrane()
    type(flight_data_t) :: data
    type(wing_parameter_t) :: p(2)
    real(rp) :: changes(N_CHANGES)
    p%kind = [KIND_MEMBRANE, KIND_PARAMETER]
    p%number = PARAM_PLATE
    data%facts%material = [1.0e10_rp, 2.0e-7_rp, 1.0e-5_rp]
    data%facts%shares = .true.
    changes = data%changes_at(p, [log(1.2_rp), log(3.0e-7_rp)])
    call t%check_close('the error of D changes flights', changes(FLOW_PLATE), log(1.8_rp), rtol=1.0e-13_rp)
    data%facts%shares = .false.
    changes = data%changes_at(p, [log(1.2_rp), log(3.0e-7_rp)])
    call t%check('but not of a wing that other data do not describe', .not. any(abs(changes) > 0))
  end subroutine check_membrane

  !> Fits on a mesh of half the size, where a joint as stiff as its vein is twice as stiff, a soft place stands for half the length
  !> and springs of veins are twice as stiff: flights have the wing of the file, with the same angle of each hinge beside its vein.
  subroutine check_finer_mesh()
    type(flight_data_t), allocatable :: cases(:)
    type(judging_runner_t) :: runner
    type(wing_parameter_t) :: p(6)
    type(solid_params_t) :: params
    type(change_t) :: change
    character(:), allocatable :: reason
    real(rp), parameter :: OF_VEIN = 3.0e-5_rp, STATED = 2.0e-5_rp, SOFTER = 1.0e-5_rp, H = 1.0e-6_rp
    real(rp) :: q(6), c(N_CHANGES)
    logical :: is_full
    integer :: i
    params%vein_factor = [1.0_rp]
    params%joint = [2*OF_VEIN, STATED, 2*OF_VEIN]
    do i = 1, 3
      p(i) = parameter_of('joint:'//achar(iachar('a') + i - 1), .true., 1.0_rp, N_COMMON + 1 + i)
      p(i)%null = log(params%joint(i))
    end do
    p(4) = parameter_of('soft', .true., 1.0_rp, 3)
    p(4)%kind = KIND_SOFT
    p(5) = parameter_of('k_e', .true., 1.0_rp, PARAM_K_VEIN)
    p(6) = parameter_of('root_stiffness', .true., 1.0_rp, PARAM_ROOT)
    call relate_to_file(p, params, [OF_VEIN, STATED, OF_VEIN])
    allocate (cases(1))
    cases(1)%facts%is_flexible = .true.
    is_full = .false.
    do i = 1, 6
      call add_structure(p(i), any(i == [1, 2, 5]), runner, cases, is_full, reason)
    end do
    q = [log(2*OF_VEIN), log(STATED), log(2*OF_VEIN), 0.0_rp, log(6.0_rp), log(0.1_rp)]
    c = cases(1)%changes_at(p, q)
    call t%check_close('a joint as its vein there is one here', c(FLOW_STRUCTURE + 1) + OWN_VALUE, log(OF_VEIN), rtol=1.0e-13_rp)
    call t%check_close('a stated one is the same', c(FLOW_STRUCTURE + 2) + OWN_VALUE, log(STATED), rtol=1.0e-13_rp)
    call t%check('nothing that is no cause changes a flight', &
                 maxval(abs(c(FLOW_STRUCTURE + 3:FLOW_STRUCTURE + 4))) < 1.0e-13_rp)
    call t%check_close('springs are half as stiff', c(FLOW_STRUCTURE + 5) + OWN_VALUE, log(3.0_rp), rtol=1.0e-13_rp)
    q(:4) = [log(SOFTER), log(SOFTER), log(SOFTER), log(0.2_rp)]
    c = cases(1)%changes_at(p, q)
    call t%check_close('it turns by as much more', exp(-c(FLOW_STRUCTURE + 1) - OWN_VALUE) - 1/OF_VEIN, &
                       1/SOFTER - 1/(2*OF_VEIN), rtol=1.0e-12_rp)
    call t%check_close('a stated one stays as it was found', c(FLOW_STRUCTURE + 2) + OWN_VALUE, log(SOFTER), rtol=1.0e-13_rp)
    call t%check_close('a cause turns by as much more than the joint of the case', (exp(-c(FLOW_STRUCTURE + 3)) - 1)/OF_VEIN, &
                       1/SOFTER - 1/(2*OF_VEIN), rtol=1.0e-12_rp)
    call t%check_close('so does a soft place', exp(-c(FLOW_STRUCTURE + 4)) - 1, (1/0.2_rp - 1)/2, rtol=1.0e-12_rp)
    call t%check_close('and so does the root', exp(-c(FLOW_STRUCTURE + 6)) - 1, (1/0.1_rp - 1)/2, rtol=1.0e-12_rp)
    params%root_factor = 0.5_rp
    call relate_to_file(p, params, [OF_VEIN, STATED, OF_VEIN])
    call t%check_close('whose stated factor holds on each mesh', p(6)%on_file%at(log(0.1_rp)), log(0.1_rp), rtol=1.0e-14_rp)
    change = cases(1)%change_by(p(1))
    call t%check_close('the slope is the derivative', change%slope(q(1)), (change%at(q(1) + H) - change%at(q(1) - H))/(2*H), &
                       rtol=1.0e-8_rp)
  end subroutine check_finer_mesh

  !> Where flights are all there is, what no flight shows is not testable, before flights and after.
  subroutine check_alone()
    type(catalogue_t) :: c
    type(flight_data_t), allocatable :: cases(:)
    type(judging_runner_t) :: runner
    logical :: is_full
    call make_catalogue(c)
    allocate (cases(1))
    cases(1)%facts%is_flexible = .true.
    call choose_structure(c, '', runner, cases, is_full)
    call t%check('taper is not testable', c%effects(2)%missing == 'no taper anywhere' .and. c%effects(1)%missing == '')
    cases(1)%response%reason(FLOW_STRUCTURE + 1) = 'it diverged'
    call exclude_unflown(c, cases)
    call t%check('nor is a gradient whose flights diverged', c%effects(1)%missing == 'it diverged')
    cases(1)%facts%is_flexible = .false.
    deallocate (cases(1)%facts%structure)
    c%effects(1)%missing = ''
    call choose_structure(c, '', runner, cases, is_full)
    call t%check('rigid wings have no structure', c%effects(1)%missing == 'needs wings that bend')
  end subroutine check_alone

  !> There is room for N_STRUCTURE parameters. The same one is there once.
  subroutine check_full()
    type(flight_data_t), allocatable :: cases(:)
    type(judging_runner_t) :: runner
    character(:), allocatable :: reason
    logical :: is_full
    integer :: i
    allocate (cases(1))
    cases(1)%facts%is_flexible = .true.
    is_full = .false.
    do i = 1, N_STRUCTURE
      call add_structure(parameter_of('p', .true., 1.0_rp, 100 + i), .false., runner, cases, is_full, reason)
    end do
    call add_structure(parameter_of('p', .true., 1.0_rp, 101), .false., runner, cases, is_full, reason)
    call t%check('the same again needs no room', .not. is_full .and. reason == '' .and. &
                 size(cases(1)%facts%structure) == N_STRUCTURE)
    call add_structure(parameter_of('p', .true., 1.0_rp, 100), .false., runner, cases, is_full, reason)
    call t%check('one more does', is_full .and. reason /= '')
  end subroutine check_full

  !> A point mass is flown at its place: one of the lattice, and one whose place is sought, which may move.
  subroutine check_places()
    type(flight_data_t), allocatable :: cases(:)
    type(judging_runner_t) :: runner
    type(wing_parameter_t) :: p
    character(:), allocatable :: reason
    logical :: is_full
    allocate (cases(1))
    cases(1)%facts%is_flexible = .true.
    is_full = .false.
    p = parameter_of('point_mass', .false., 1.0_rp, 0)
    p%kind = KIND_POINT_MASS
    p%disc = [4.0e-3_rp, 1.0e-3_rp, 0.0_rp]
    call add_structure(p, .false., runner, cases, is_full, reason)
    call t%check('one of the lattice is flown', reason == '' .and. size(cases(1)%facts%structure) == 1)
    call t%check('at its place', all(abs(cases(1)%facts%structure(1)%disc - p%disc) <= 0))
    p%partner = 2
    call add_structure(p, .false., runner, cases, is_full, reason)
    call t%check('one whose place is sought is another parameter', reason == '' .and. size(cases(1)%facts%structure) == 2)
    p%disc(1) = 5.0e-3_rp
    call add_structure(p, .false., runner, cases, is_full, reason)
    call t%check('the same after it has moved', reason == '' .and. size(cases(1)%facts%structure) == 2)
    call t%check('to its place', all(abs(cases(1)%facts%structure(2)%disc - p%disc) <= 0))
    call t%check('and the other one stays', abs(cases(1)%facts%structure(1)%disc(1) - 4.0e-3_rp) <= 0)
  end subroutine check_places

  !> Forces 1 + 2 g: without flights for g residuals do not depend on it, with those of a round they do, in that approximation.
  subroutine check_round()
    type(flight_data_t), allocatable :: cases(:)
    type(judging_runner_t) :: runner
    type(measured_flight_t) :: flights(1)
    type(wing_flight_t) :: wing
    type(wing_parameter_t) :: p(1)
    type(flight_response_t) :: about
    type(failure_t) :: failure
    character(:), allocatable :: reason
    logical :: is_full, none(N_REFINEMENTS)
    real(rp) :: steps(N_FLOW), origin(N_FLOW), residuals(3), jacobian(3, 1)
    integer :: number
    none = .false.
    allocate (cases(1))
    p = parameter_of('g', .false., 1.0_rp, 6)
    flights(1)%frequency = 1
    flights(1)%component = [3]
    flights(1)%time = [0.1_rp, 0.4_rp, 0.7_rp]
    allocate (flights(1)%mean(3, 1), flights(1)%sd(3, 1), source=0.5_rp)
    allocate (flights(1)%is_known(3, 1), source=.true.)
    cases(1)%first = 1
    cases(1)%last = 1
    cases(1)%facts%is_flexible = .true.
    cases(1)%response%n_harmonics = 2
    steps = 0
    call cases(1)%response%take(steps, none, [record(1.0_rp)], failure)
    call wing%init(flights, p, cases(1))
    call wing%evaluate([1.0_rp], [1], residuals, jacobian)
    call t%check('flights do not depend on what was not flown', all(abs(residuals - 1) < 1.0e-12_rp) .and. &
                 all(abs(jacobian) <= 0))
    is_full = .false.
    call add_structure(p(1), .false., runner, cases, is_full, reason)
    origin = 0
    origin(FLOW_STRUCTURE + 1) = 0.8_rp
    steps(FLOW_STRUCTURE + 1) = 0.1_rp
    about = cases(1)%response
    call about%move(origin, steps, none, [record(2.6_rp), record(2.8_rp), record(2.4_rp)], failure)
    call t%check('its flights are taken', .not. failure%failed .and. about%is_known(FLOW_STRUCTURE + 1))
    call wing%add(about, cases(1)%facts, number)
    call wing%evaluate([1.0_rp], [1], residuals, jacobian)
    call t%check('then they do', all(abs(residuals - (3 - 0.5_rp)/0.5_rp) < 1.0e-11_rp) .and. &
                 all(abs(jacobian - 2/0.5_rp) < 1.0e-11_rp))
    call wing%use(1)
    call wing%evaluate([1.0_rp], [1], residuals, jacobian)
    call t%check('in the approximation about the case they do not', all(abs(residuals - 1) < 1.0e-12_rp) .and. &
                 all(abs(jacobian) <= 0))
  end subroutine check_round

  !> Returns a flight with the constant force Fz.
  function record(force) result(r)
    real(rp), intent(in) :: force
    type(flight_record_t) :: r
    r%is_flown = .true.
    allocate (r%values(N_PHASES, N_COMPONENTS), source=0.0_rp)
    r%values(:, 3) = force
  end function record

  !> Returns a parameter of the wing about a coordinate of 0.
  function parameter_of(name, is_log, prior_sd, number) result(p)
    character(*), intent(in) :: name
    logical, intent(in) :: is_log
    real(rp), intent(in) :: prior_sd
    integer, intent(in) :: number
    type(wing_parameter_t) :: p
    type(parameter_t) :: one
    one = effect_parameter(name, '1', is_log, merge(1.0e-3_rp, -50.0_rp, is_log), 50.0_rp, prior_sd)
    p = wing_parameter(one%as_coordinate(one%null), KIND_PARAMETER, number)
  end function parameter_of

  !> A baseline with one joint; the causes E_gradient, where 0.5 is assumed, taper, and damping of 0 or more.
  subroutine make_catalogue(c)
    type(catalogue_t), intent(out) :: c
    type(wing_parameter_t) :: p
    integer :: n
    allocate (c%parameters(0), c%effects(0))
    n = c%add(parameter_of('joint:a', .true., 1.0_rp, JOINT))
    c%n_baseline = n
    p = parameter_of('E_gradient', .false., 1.0_rp, GRADIENT)
    p%null = 0.5_rp
    call enter(c, 'E_gradient', p)
    call enter(c, 'taper', parameter_of('diameter_exponent', .false., 1.0_rp, PARAM_EXPONENT))
    p = parameter_of('rayleigh_stiffness', .false., 1.0_rp, DAMPING_STIFFNESS)
    p%kind = KIND_DAMPING
    p%lower = 0
    call enter(c, 'stiffness_damping', p)
  end subroutine make_catalogue

  !> Enters a cause with one parameter.
  subroutine enter(c, name, one)
    type(catalogue_t), intent(inout) :: c
    character(*), intent(in) :: name
    type(wing_parameter_t), intent(in) :: one
    type(variant_t), allocatable :: variants(:)
    type(cause_t) :: cause
    allocate (variants(0))
    call append_variant(variants, '', c%add(one), [0.0_rp, 0.0_rp])
    cause = make_cause(name, name, name, '')
    call c%enter(cause, '', variants)
  end subroutine enter
end program test_flight_structure
