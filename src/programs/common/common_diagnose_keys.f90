! SPDX-License-Identifier: GPL-3.0-or-later
!> The register of the ini keys of `msm_diagnose`. All units are SI.
module common_diagnose_keys
  use base_kinds, only: rp
  use common_foreign_inputs, only: register_foreign_inputs, INPUT_OF_DIAGNOSE
  use common_instrument, only: register_instrument_keys
  use common_outliers, only: register_outliers
  use common_wing_keys, only: register_wing_keys
  use io_include, only: register_include
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_diagnose_keys, write_diagnose_reference

contains

  !> Fills `registry` with every key that `msm_diagnose` accepts.
  subroutine register_diagnose_keys(registry)
    type(registry_t), intent(inout) :: registry
    call register_include(registry)
    call register_foreign_inputs(registry, INPUT_OF_DIAGNOSE)
    call register_wing_keys(registry, required=.true.)
    call registry%add_section('Measurement', 'what the wing did in the experiment')
    call registry%add_text('Measurement', 'file', '', 'measurement file (docs/formats/measurement-format.md); looked for '// &
                           'here and then in the folder of the input file', required=.true.)
    call register_outliers(registry, 'leave_out|keep', 'leave_out')
    call register_instrument_keys(registry)
    call register_diagnose(registry)
    call registry%add_section('Solver', 'path of the static solution')
    call registry%add_real('Solver', 'tolerance', 1.0e-8_rp, 'of the residual, relative to the load', min=1.0e-12_rp, &
                           max=1.0e-3_rp)
    call registry%add_real('Solver', 'step_limit', 0.025_rp, &
                           'largest movement in one stage, relative to the wing''s '// &
                           'size', above=0.0_rp, max=0.2_rp)
    call registry%add_integer('Solver', 'factorisation_limit', 300, 'give up after so many for one load', min=1)
    call registry%add_section('Saving', 'what is written')
    call registry%add_text('Saving', 'name', 'diagnosis', &
                           'first part of the names of all files, with a folder if wanted')
    call registry%add_text('Saving', 'draws', 'NAME_draws.h5', &
                           'file in which the draws of the bootstrap are kept for runs with the same loads and '// &
                           'baseline; the word none: they are not kept', computed=.true.)
  end subroutine register_diagnose_keys

  !> Writes the reference of these keys, a part of docs/formats/parameters.md.
  subroutine write_diagnose_reference(unit)
    integer, intent(in) :: unit
    type(registry_t) :: registry
    call register_diagnose_keys(registry)
    write (unit, '(a)') '# Parameters of `msm_diagnose`', '', &
      'What the model of a wing gets wrong in bending tests, and why. All numbers are in SI units.', ''
    call registry%write_markdown(unit)
  end subroutine write_diagnose_reference

  subroutine register_diagnose(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Diagnose', 'the baseline, and how sure one wants to be')
    call r%add_text('Diagnose', 'parameters', 'E, joint:*', 'what the baseline seeks, as in [Train] parameters of '// &
                    'msm_train; everything else that can vary is a candidate for what it lacks')
    call r%add_real('Diagnose', 'prior_decades', 1.0_rp, 'sd of the prior about the values of [Wing]', unit='decades', &
                    above=0.0_rp)
    call r%add_real('Diagnose', 'membrane_sd', 0.1_rp, &
                    'sd of log D that is no discovery: meshes change the effective D by '// &
                    '5 to 15 % (docs/guide/synthetic-measurements.md)', min=0.0_rp, max=3.0_rp)
    call r%add_word('Diagnose', 'refine', 'yes', 'yes|fit|no', 'fit the baseline on a mesh of half the size too, '// &
                    'and count the difference as an error; fit: and make the whole diagnosis on that mesh, which '// &
                    'takes several times as long; no: the data come from the same mesh, as those of a computed '// &
                    'wing may; --refine, --refine=fit and --no-refine go before it')
    call r%add_integer('Diagnose', 'starts', 3, &
                       'points from which the baseline is fitted: the values of [Wing], then '// &
                       'random ones', min=1, max=100)
    call r%add_integer('Diagnose', 'observations', 1600, &
                       'at most; heights are averaged over squares until there are no '// &
                       'more', min=50, max=20000)
    call r%add_word('Diagnose', 'noise', 'estimated', 'estimated|declared', &
                    'whether the size of the errors of heights is estimated from the data, or believed as declared')
    call r%add_integer('Diagnose', 'draws', 4000, 'of the bootstrap that calibrates all tests together', min=500, &
                       max=1000000)
    call r%add_integer('Diagnose', 'refits', 5, 'leading candidates that are fitted in full', min=1, max=100)
    call r%add_switch('Diagnose', 'validation', .true., 'leave every location out once and predict it')
    call r%add_switch('Diagnose', 'intervals', .true., '90 % intervals of what is found, by profile likelihood')
    call r%add_integer('Diagnose', 'seed', 1, 'of all random numbers', min=0)
    call r%add_integer('Diagnose', 'iterations', 60, 'steps of a fit tried at most', min=1, max=10000)
  end subroutine register_diagnose
end module common_diagnose_keys
