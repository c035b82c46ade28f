! SPDX-License-Identifier: GPL-3.0-or-later
!> Declares the ini keys of `msm_diagnose`. All units are SI.
module common_diagnose_keys
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use common_foreign_inputs, only: register_foreign_inputs, INPUT_OF_DIAGNOSE
  use common_instrument, only: register_instrument_keys
  use common_measurement_keys, only: register_measurement_keys
  use common_solver_keys, only: solver_keys
  use common_wing_keys, only: register_wing_keys
  use inference_record, only: diagnosis_options_t
  use io_include, only: register_include
  use io_keys, only: declaring, keys_t
  use io_registry, only: registry_t
  use measurement_proposal_choices, only: proposal_choices_t
  use solid_statics, only: static_options_t
  implicit none
  private
  public :: diagnose_choices_t, flight_choices_t, diagnose_keys, register_diagnose_keys, write_diagnose_reference, REFINES

  !> Whether a finer mesh is used: not stated, for its error, for all fits, or not at all.
  integer, parameter, public :: REFINE_UNSTATED = 0, REFINE_YES = 1, REFINE_FIT = 2, REFINE_NO = 3, REFINE_AUTO = 4
  type(named_kind_t), parameter :: REFINES(4) = [named_kind_t('auto', REFINE_AUTO), named_kind_t('yes', REFINE_YES), &
                                                 named_kind_t('fit', REFINE_FIT), named_kind_t('no', REFINE_NO)]
  integer, parameter, public :: NOISE_ESTIMATED = 1, NOISE_DECLARED = 2
  type(named_kind_t), parameter :: NOISES(2) = [named_kind_t('estimated', NOISE_ESTIMATED), &
                                                named_kind_t('declared', NOISE_DECLARED)]
  !> Where a wall may be that a case leaves out: toward -z or toward -y of the body.
  integer, parameter, public :: WALL_BELOW = 1, WALL_BESIDE = 2
  type(named_kind_t), parameter :: WALL_SIDES(2) = [named_kind_t('below', WALL_BELOW), named_kind_t('beside', WALL_BESIDE)]
  character(*), parameter, public :: DRAWS_NONE = 'none' !< the value of [Saving] draws that names no file

  !> Holds what a user chooses for the simulation of flights.
  type :: flight_choices_t
    character(:), allocatable :: file, records, folder, effects, refine
    integer :: ranks = 0, beats = 1, harmonics = 1, rounds = 0, directions = 1
    logical :: compare = .false.
    real(rp) :: model_sd = 0
    real(rp) :: wall_distance = 0, body_length = 0, body_radius = 0, wing_thickness = 0 !< m, 0: not stated
    integer :: wall_side = WALL_BELOW
  end type flight_choices_t

  !> Holds what a user chooses for a diagnosis.
  type :: diagnose_choices_t
    character(:), allocatable :: parameters
    real(rp) :: prior_decades = 1, membrane_sd = 0
    integer :: refine = REFINE_AUTO, noise = NOISE_ESTIMATED
    integer :: n_starts = 1
    integer :: observations = 0             !< largest number of observations
    type(flight_choices_t) :: flight
    type(diagnosis_options_t) :: options
    type(proposal_choices_t) :: proposals
    type(static_options_t) :: solver
    character(:), allocatable :: name, draws !< `draws` is not allocated unless the input has it
  end type diagnose_choices_t

contains

  !> Fills `registry` with every key that `msm_diagnose` accepts.
  subroutine register_diagnose_keys(registry)
    type(registry_t), intent(inout), target :: registry
    type(diagnose_choices_t) :: unused
    type(keys_t) :: keys
    call register_include(registry)
    call register_foreign_inputs(registry, INPUT_OF_DIAGNOSE)
    call register_wing_keys(registry, required=.true.)
    call register_measurement_keys(registry, is_training=.false.)
    call register_instrument_keys(registry)
    keys = declaring(registry)
    call diagnose_keys(keys, unused)
  end subroutine register_diagnose_keys

  !> Writes the reference of these keys, a part of docs/formats/parameters.md, to `unit`.
  subroutine write_diagnose_reference(unit)
    integer, intent(in) :: unit
    type(registry_t) :: registry
    call register_diagnose_keys(registry)
    write (unit, '(a)') '# Parameters of `msm_diagnose`', '', &
      'What the model of a wing gets wrong in bending tests, and why. All numbers are in SI units.', ''
    call registry%write_markdown(unit)
  end subroutine write_diagnose_reference

  !> Declares and reads all keys of a diagnosis except those of the wing, the measurement and the instrument.
  subroutine diagnose_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(diagnose_choices_t), intent(inout) :: c
    call keys%section('Diagnose', 'the baseline model, the tests of causes, and their settings')
    call keys%text('parameters', c%parameters, 'E, joint:*', 'parameters that the baseline fits, written as [Train] '// &
                   'parameters of msm_train; all other parameters are candidates for what the baseline lacks')
    call keys%real('prior_decades', c%prior_decades, 1.0_rp, 'standard deviation of the prior about the values of [Wing]', &
                   unit='decades', &
                   above=0.0_rp)
    call keys%real('membrane_sd', c%membrane_sd, 0.1_rp, &
                   'prior standard deviation of log D; a change of D within it is not reported as a cause, because a mesh '// &
                   'changes the effective D by 5 to 15 % (docs/guide/synthetic-measurements.md)', min=0.0_rp, max=3.0_rp)
    call keys%kind('refine', c%refine, 'auto', REFINES, 'yes: also fit the baseline on a mesh with half the edge length, '// &
                   'and count the difference as an error; fit: also run the whole diagnosis on the fine mesh, which takes '// &
                   'several times as long; auto: fit, if the data are natural modes or records of motion alone, and the '// &
                   'difference of the meshes has a signal-to-noise ratio above sqrt(6), which could decide between two causes; '// &
                   'yes otherwise; no: count no error of the mesh, for data that were computed on the same mesh; the '// &
                   'options --refine=.. and --no-refine override this key')
    call keys%integer('starts', c%n_starts, 3, 'number of starting points of the baseline fit: the values of [Wing], then '// &
                      'random points', min=1, max=100)
    call keys%integer('observations', c%observations, 1600, 'largest number of observations; heights are averaged over '// &
                      'squares until there are no more than this', min=50, max=20000)
    call keys%kind('noise', c%noise, 'estimated', NOISES, &
                   'standard deviation of heights: estimated from the scatter of neighbours, or as the measurement file '// &
                   'declares it. Nothing tells the errors of other data before a fit: they are as declared. With '// &
                   '"estimated" the tests of the catalogue allow for errors of another size. A misfit beyond the declared '// &
                   'errors is an alarm in both cases')
    call keys%integer('draws', c%options%n_draws, 4000, 'number of bootstrap draws, which calibrate all tests together', min=500, &
                      max=1000000)
    call keys%integer('refits', c%options%most_refits, 5, 'number of leading candidates that are fitted in full', min=1, max=100)
    call keys%switch('validation', c%options%validates, .true., 'cross-validation: leave out every location once and predict it')
    call keys%switch('intervals', c%options%finds_intervals, .true., '90 % intervals of the parameters of a found cause, by '// &
                     'profile likelihood')
    call keys%integer('seed', c%options%seed, 1, 'seed of all random numbers', min=0)
    call keys%integer('iterations', c%options%fit%most_iterations, 60, 'largest number of trial steps in a fit', min=1, max=10000)
    call solver_keys(keys, c%solver, 300)
    call proposal_keys(keys, c%proposals)
    call flight_keys(keys, c%flight)
    call keys%section('Saving', 'what is written')
    call keys%text('name', c%name, 'diagnosis', 'first part of the names of all output files; it may contain a folder')
    call keys%text('draws', c%draws, 'NAME_draws.h5', &
                   'file that keeps the bootstrap draws for later runs with the same loads and baseline; '// &
                   DRAWS_NONE//': the draws are '// &
                   'not kept', computed=.true.)
  end subroutine diagnose_keys

  !> Declares and reads the keys of [Next].
  subroutine proposal_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(proposal_choices_t), intent(inout) :: c
    call keys%section('Next', 'how well natural modes and a record of motion could be measured, for the table of what to '// &
                      'measure next')
    call keys%integer('modes', c%n_modes, 4, 'number of natural modes, the lowest ones; 0: neither new modes nor a new '// &
                      'record are ranked, which saves seconds', min=0, max=50)
    call keys%real('frequency_sd', c%frequency_sd, 0.005_rp, 'relative standard deviation of a frequency', above=0.0_rp, &
                   max=1.0_rp)
    call keys%real('damping_sd', c%damping_sd, 0.05_rp, 'relative standard deviation of a damping ratio', above=0.0_rp, &
                   max=10.0_rp)
    call keys%integer('samples', c%n_samples, 200, 'number of samples of a record after a release', min=10, max=1000)
    call keys%real('periods', c%n_periods, 8.0_rp, 'length of this record, in periods of the lowest mode in air', min=0.5_rp, &
                   max=1000.0_rp)
    call keys%real('motion_sd', c%motion_sd, 0.01_rp, 'standard deviation of a value of this record, as a fraction of the '// &
                   'displacement before the release', above=0.0_rp, max=1.0_rp)
    call keys%real('force_sd', c%force_sd, 0.05_rp, 'relative standard deviation of the released force', min=0.0_rp, max=1.0_rp)
  end subroutine proposal_keys

  !> Declares and reads the keys of [Flight].
  subroutine flight_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(flight_choices_t), intent(inout) :: c
    call keys%section('Flight', 'simulation of the experiment whose forces are in /flight of the measurement file, or '// &
                      'of flights with the wings of a diagnosis')
    call keys%text('file', c%file, '', 'parameter file of flusi that simulates the experiment, with the measured kinematics '// &
                   'and a section [units]')
    call keys%text('records', c%records, '', 'records of /flight that another case than `file` simulates: RECORD: FILE, with '// &
                   'commas between several; each case is flown for itself, and causes are sought in all cases together and '// &
                   'in the records of each case alone')
    call keys%text('folder', c%folder, 'flights', 'folder of the simulated flights; flights that are complete there are not '// &
                   'simulated again')
    call keys%integer('ranks', c%ranks, 0, 'ranks for each flight, so that several flights run at the same time; 0: all ranks '// &
                      'compute one flight together', min=0)
    call keys%integer('beats', c%beats, 3, 'number of simulated beats; the last beat is compared with the measurement', min=1, &
                      max=1000)
    call keys%text('effects', c%effects, '', 'effects of kinematics, flow, balance and the structure of wings that bend that '// &
                   'the first flights show: names separated by commas, also of parameters that the baseline fits, such as '// &
                   'joint:*; empty: all that the case permits of kinematics, flow and balance, and of the structure those of '// &
                   'the whole wing (docs/theory/flight-records.md)')
    call keys%text('refine', c%refine, 'yes', 'numerical errors, separated by commas: one further flight makes each of them '// &
                   'smaller, and the difference, times a factor by the order of the method, counts as an error; grid (1.5 '// &
                   'times as many points in each direction), step (1.5 times as many steps), penalization (half of eps), '// &
                   'thickness (0.7 times that of wings in the mask), box (1.5 times as large), sponge (twice as thick), beats '// &
                   '(one more), surface (wings in the mask where those of the case have no thickness, and the other way '// &
                   'round); yes: those that the case permits, without step, and surface only for wings without thickness with '// &
                   '`wing_thickness`; all: with both; no: none')
    call keys%real('wing_thickness', c%wing_thickness, 0.0_rp, 'thickness of the wings of the experiment, for the errors '// &
                   'thickness and surface of `refine`; 0: not known', unit='m', min=0.0_rp)
    call keys%integer('rounds', c%rounds, 3, 'largest number of rounds; a round simulates a clear cause with its fitted '// &
                      'values and fits it again; 0: the forces come from an approximation about the case', min=0, max=20)
    call keys%real('model_sd', c%model_sd, 0.02_rp, 'relative error of the simulated forces over the whole beat, both common '// &
                   'to all components and for each component, beyond what `refine` counts; give 0.05 if refine leaves out the '// &
                   'box, the thickness of the wing or the beats (docs/results/flight-records.md)', min=0.0_rp, max=1.0_rp)
    call keys%integer('harmonics', c%harmonics, 40, 'highest harmonic of the beat that is kept of the simulated '// &
                      'forces', min=1, max=99)
    call keys%switch('compare', c%compare, .false., 'for a measurement without /flight: if a cause is found, simulate the case '// &
                     'with the wing of the baseline and with the extended wing, and print lift, drag and power of both '// &
                     'with the intervals that the fit leaves')
    call keys%integer('directions', c%directions, 3, 'compare: number of directions, those with the largest variance, of what '// &
                      'the fit leaves of the extended wing; each takes two flights', min=1, max=100)
    call keys%real('wall_distance', c%wall_distance, 0.0_rp, 'effect `wall`: distance of a wall from [Insects] x0 that the '// &
                   'case leaves out; 0: none', unit='m', min=0.0_rp)
    call keys%kind('wall_side', c%wall_side, 'below', WALL_SIDES, 'side of this wall; below: toward -z, beside: toward -y')
    call keys%real('body_length', c%body_length, 0.0_rp, 'effect `body`: length of an ellipsoid about [Insects] x0 that the '// &
                   'case leaves out; 0: none', unit='m', min=0.0_rp)
    call keys%real('body_radius', c%body_radius, 0.0_rp, 'radius of this ellipsoid; 0: none', unit='m', min=0.0_rp)
  end subroutine flight_keys
end module common_diagnose_keys
