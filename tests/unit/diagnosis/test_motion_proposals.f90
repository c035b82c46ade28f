! SPDX-License-Identifier: GPL-3.0-or-later
!> A release that is proposed as the next measurement tells as much as its record would in a diagnosis: with the same errors of
!> force and time, those of the time to second order too. The argument names a wing file.
program test_motion_proposals
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_motion_proposals, only: motion_proposer_t, PROPOSE_RELEASE
  use diagnosis_wing_catalogue, only: catalogue_t, make_catalogue
  use diagnosis_wing_parameters, only: KIND_DAMPING, KIND_MASS
  use diagnosis_wing_series, only: wing_series_t
  use loaded_wing, only: wing_of_argument
  use measurement_experiment, only: experiment_t
  use measurement_modes, only: MEDIUM_AIR
  use measurement_series, only: measured_series_t
  use solid_damping_effects, only: DAMPING_MASS
  use solid_mass, only: lump_mass, mass_params_t
  use solid_mass_effects, only: MASS_ADDED
  use solid_params, only: default_params
  use solid_ringing, only: EXCITED_RELEASE
  use solid_statics, only: static_options_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: SAMPLES = 40
  real(rp), parameter :: PERIODS = 8       !< the time errs by a fifth of a period
  real(rp), parameter :: DEFLECTION = 0.01_rp !< of the size of the wing, by the force
  type(testkit_t) :: t
  type(diagnosis_case_t), target :: s
  type(static_options_t) :: options
  type(motion_proposer_t), target :: proposer
  real(rp), allocatable :: normal(:, :, :)
  logical, allocatable :: ok(:)
  integer :: release

  call t%start(parallel=.false.)
  call make_case()
  call proposer%init(s, s%catalogue%parameters%null)
  call proposer%apply([1, 2], normal, ok)
  release = findloc(proposer%list%kind, PROPOSE_RELEASE, 1, back=.true.)
  call t%check('a release is proposed', release > 0)
  if (release > 0) call t%check('it can be simulated', ok(release))
  if (release > 0) call check_release()
  call t%finish()

contains

  !> A diagnosis without data of a wing whose E and D are unknown.
  subroutine make_case()
    type(mass_params_t) :: material
    type(message_list_t) :: messages
    type(failure_t) :: failure
    s%wing_case%wing = wing_of_argument()
    s%wing_case%requested = default_params(s%wing_case%wing)
    s%wing_case%material = material
    s%wing_case%has_mass = .true.
    s%states_mass = .true.
    call lump_mass(s%wing_case%wing, material, s%wing_case%mass, messages)
    call s%parts%init(s%wing_case%wing, s%wing_case%mass)
    allocate (s%measurement%loads(0), s%measurement%observations(0), s%measurement%zeros(0), s%measurement%x(0), s%measurement%y(0))
    s%proposals%n_samples = SAMPLES
    s%proposals%n_periods = PERIODS
    call s%experiment%init(s%measurement, s%wing_case%wing, s%wing_case%requested, [integer ::], options, failure, &
                           masses=s%masses())
    call t%check('the experiment is made', .not. failure%failed)
    call make_catalogue(s%experiment, s%wing_case%wing, [1, 2], 1.0_rp, s%catalogue)
  end subroutine make_case

  !> The same record as one of a measurement: the errors of a diagnosis of it, and its unknown damping and mass of the air.
  subroutine check_release()
    type(experiment_t), target :: planned
    type(wing_series_t) :: series
    type(catalogue_t) :: catalogue
    real(rp), allocatable :: q(:), residuals(:), tangents(:, :), errors(:, :), c(:, :), wanted(:, :)
    integer :: damping, air
    logical :: is_stable
    planned = s%experiment
    planned%measurement%series = [record()]
    call make_catalogue(planned, s%wing_case%wing, [1, 2], 1.0_rp, catalogue)
    associate (p => catalogue%parameters)
      damping = findloc(p%kind == KIND_DAMPING .and. p%number == DAMPING_MASS, .true., 1)
      air = findloc(p%kind == KIND_MASS .and. p%number == MASS_ADDED, .true., 1)
      q = p%null
      call series%init(planned, s%wing_case%wing, p, s%parts)
      allocate (residuals(series%n), tangents(series%n, 2), errors(series%n, series%n_nuisances + 2))
      call series%evaluate(q, residuals, is_stable)
      call series%tangents(q, [1, 2], tangents)
      call series%nuisances(errors(:, 3:))
      call series%tangents(q, [damping, air], errors(:, :2))
      errors(:, 1) = p(damping)%prior_sd*errors(:, 1)
      errors(:, 2) = p(air)%prior_sd*errors(:, 2)
    end associate
    call t%check('errors of force, time and its square', is_stable .and. series%n_nuisances == 3 .and. &
                 norm2(errors(:, 5)) > 0.3_rp*norm2(errors(:, 4)))
    c = matmul(transpose(errors), errors)
    wanted = matmul(transpose(tangents), tangents) - matmul(transpose(matmul(transpose(errors), tangents)), &
                                                            solved(c, matmul(transpose(errors), tangents)))
    call t%check_close('E is known as well', normal(1, 1, release), wanted(1, 1), rtol=1.0e-6_rp)
    call t%check_close('so is D', normal(2, 2, release), wanted(2, 2), rtol=1.0e-6_rp)
    call series%free()
  end subroutine check_release

  !> The release as a record.
  function record() result(r)
    type(measured_series_t) :: r
    associate (one => proposer%list(release))
      r%name = 'release'
      r%medium = MEDIUM_AIR
      r%excitation = EXCITED_RELEASE
      r%point = one%site
      r%direction = [0.0_rp, 0.0_rp, 1.0_rp]
      r%axis = r%direction
      r%size = one%force
      r%size_sigma = s%proposals%force_sd*one%force
      r%rate = one%rate
      r%trigger_sigma = 1/one%rate
      r%place = reshape(one%site, [2, 1])
      allocate (r%values(SAMPLES, 1), source=0.0_rp)
      allocate (r%is_known(SAMPLES, 1), source=.true.)
      r%sigma = [s%proposals%motion_sd*DEFLECTION*s%experiment%model%size]
      allocate (r%base(0))
    end associate
  end function record

  !> Returns (1 + c)^-1 b by elimination; c is positive.
  function solved(c, b) result(x)
    real(rp), intent(in) :: c(:, :), b(:, :)
    real(rp) :: x(size(b, 1), size(b, 2)), a(size(c, 1), size(c, 2)), factor
    integer :: i, k
    a = c
    x = b
    do i = 1, size(a, 1)
      a(i, i) = a(i, i) + 1
    end do
    do i = 1, size(a, 1)
      do k = 1, size(a, 1)
        if (k == i) cycle
        factor = a(k, i)/a(i, i)
        a(k, :) = a(k, :) - factor*a(i, :)
        x(k, :) = x(k, :) - factor*x(i, :)
      end do
    end do
    do i = 1, size(a, 1)
      x(i, :) = x(i, :)/a(i, i)
    end do
  end function solved
end program test_motion_proposals
