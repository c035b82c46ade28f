! SPDX-License-Identifier: GPL-3.0-or-later
!> What a wing in motion shows comes from the journal of an interrupted diagnosis, to the bit, and not from that of another mesh, of
!> other parameters, or of another question. The argument names a wing file.
program test_journalled_motion
  use base_errors, only: failure_t, message_list_t
  use base_files, only: remove_file
  use base_kinds, only: i8, rp
  use diagnosis_flight_data, only: flight_cases_t
  use diagnosis_journalled_motion, only: journalled_motion_t
  use diagnosis_wing_catalogue, only: catalogue_t, make_catalogue
  use io_journal, only: journal_t
  use loaded_wing, only: wing_of_argument
  use measurement_data, only: measurement_t
  use measurement_experiment, only: experiment_t
  use measurement_modes, only: MEDIUM_VACUUM
  use measurement_observed_wing, only: wing_patterns_t
  use solid_mass, only: lump_mass, mass_params_t, mass_t
  use solid_mass_effects, only: mass_parts_t
  use solid_params, only: default_params
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 3 !< modes, of which the frequency is known
  character(*), parameter :: PATH = 'motion.journal'
  type(testkit_t) :: t
  type(wing_t), target :: wing
  type(experiment_t), target :: bare
  type(catalogue_t) :: catalogue
  type(journalled_motion_t) :: motion
  type(journal_t), target :: journal
  type(wing_patterns_t) :: causes
  real(rp), allocatable :: q(:), residuals(:), jacobian(:, :), nuisances(:, :), patterns(:, :)
  logical :: ok, goes_on

  call t%start(parallel=.false.)
  call make()
  q = catalogue%parameters%null
  allocate (residuals(N), jacobian(N, 2), nuisances(N, 1), patterns(N, 1))
  call remove_file(PATH)
  motion%journal => journal
  call ask_first()
  call ask_again()
  call ask_of_another_mesh()
  call journal%finish(.true.)
  call motion%free()
  call t%finish()

contains

  !> Three frequencies of the wing.
  subroutine make()
    type(measurement_t) :: m
    type(mass_t) :: mass
    type(mass_parts_t) :: parts
    type(mass_params_t) :: material
    type(static_options_t) :: options
    type(flight_cases_t) :: flights
    type(message_list_t) :: messages
    type(failure_t) :: failure
    integer :: i
    wing = wing_of_argument()
    allocate (m%loads(0), m%observations(0), m%zeros(0), m%x(0), m%y(0), m%modes(N), m%series(0))
    do i = 1, N
      associate (mode => m%modes(i))
        mode%name = achar(iachar('0') + i)
        mode%medium = MEDIUM_VACUUM
        mode%number = i
        mode%frequency = 300.0_rp*i
        mode%frequency_sigma = 1
        allocate (mode%place(2, 0), mode%shape(0), mode%sigma(0), mode%load_size(0), mode%load_direction(3, 0), &
                  mode%load_place(2, 0))
      end associate
    end do
    call lump_mass(wing, material, mass, messages)
    call parts%init(wing, mass)
    call bare%init(m, wing, default_params(wing), [integer ::], options, failure, masses=mass%nodal)
    call t%check('the experiment is made', .not. failure%failed)
    call make_catalogue(bare, wing, [1, 2], 1.0_rp, catalogue)
    causes%site = reshape(wing%points(:2, wing%triangles(1, size(wing%triangles, 2)/2)), [2, 1])
    causes%radius = 0.2_rp*bare%model%size
    call motion%init(bare, wing, catalogue%parameters, parts, flights)
    motion%mesh = bare%model%n_points
  end subroutine make

  !> Asks for residuals with tangents and for directions; both are computed.
  subroutine ask_first()
    call journal%start(PATH, 1_i8, goes_on)
    call motion%recall_evaluation(q, [1, 2], residuals, jacobian, ok)
    call t%check('frequencies are computed', ok .and. all(abs(residuals) > 0) .and. any(abs(jacobian) > 0))
    call motion%recall_directions(q, 0, 0.0_rp, causes, nuisances, patterns, ok)
    call t%check('the changes by an unknown cause are computed', ok .and. any(abs(patterns) > 0))
    call t%check('both are kept', journal%n_recorded == 2 .and. journal%n_recalled == 0)
  end subroutine ask_first

  !> Asks the same after an interruption.
  subroutine ask_again()
    real(rp) :: r(N), j(N, 2), d(N, 1), p(N, 1)
    call restart()
    call motion%recall_evaluation(q, [1, 2], r, j, ok)
    call t%check('frequencies are recalled', ok .and. all(abs(r - residuals) <= 0) .and. all(abs(j - jacobian) <= 0))
    d = 0
    p = 0
    call motion%recall_directions(q, 0, 0.0_rp, causes, d, p, ok)
    call t%check('and directions', ok .and. all(abs(d - nuisances) <= 0) .and. all(abs(p - patterns) <= 0))
    call t%check('nothing is computed', journal%n_recorded == 0 .and. journal%n_recalled == 2)
  end subroutine ask_again

  !> Asks for other parameters and of another mesh, with as many numbers: the journal does not know.
  subroutine ask_of_another_mesh()
    real(rp) :: r(N), j(N, 2)
    call restart()
    call motion%recall_evaluation(q, [2, 1], r, j, ok)
    call t%check('other tangents are computed', journal%n_recalled == 0 .and. all(abs(j(:, 1) - jacobian(:, 2)) <= 0))
    call begin_anew()
    call restart()
    call motion%recall_evaluation(q + 1.0e-3_rp, [1, 2], r, j, ok)
    call t%check('those of other values, too', journal%n_recalled == 0 .and. any(abs(r - residuals) > 0))
    call begin_anew()
    call restart()
    motion%mesh = motion%mesh + 1
    call motion%recall_evaluation(q, [1, 2], r, j, ok)
    call t%check('those of another mesh, too', journal%n_recalled == 0 .and. journal%n_recorded == 1)
    call restart()
    motion%mesh = motion%mesh - 1
    call motion%recall_evaluation(q, [1, 2], r, j, ok)
    call t%check('which are not those of this one', journal%n_recalled == 0 .and. all(abs(j - jacobian) <= 0))
  end subroutine ask_of_another_mesh

  !> A journal that has residuals with two tangents.
  subroutine begin_anew()
    real(rp) :: r(N), j(N, 2)
    call journal%finish(.true.)
    call journal%start(PATH, 1_i8, goes_on)
    call motion%recall_evaluation(q, [1, 2], r, j, ok)
  end subroutine begin_anew

  !> The program has ended and starts again.
  subroutine restart()
    call journal%finish(.false.)
    journal = journal_t()
    call journal%start(PATH, 1_i8, goes_on)
    call t%check('the journal goes on', goes_on)
  end subroutine restart
end program test_journalled_motion
