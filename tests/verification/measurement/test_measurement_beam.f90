! SPDX-License-Identifier: GPL-3.0-or-later
!> Readings of the displacement and the rotation of the tip of a cantilever, computed from the theory of slender beams,
!> w = F L^3/(3 E I) and w' = F L^2/(2 E I), with an unknown offset in the displacements: the fit finds E and the
!> offset.
program test_measurement_beam
  use base_constants, only: PI
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use least_squares_fit, only: fit, fit_options_t, fit_report_t
  use measurement_data, only: measurement_t, QUANTITY_DISPLACEMENT, QUANTITY_ROTATION
  use measurement_experiment, only: experiment_t
  use measurement_file, only: read_measurement
  use measurement_problem, only: wing_problem_t, wing_unknowns
  use sample_wings, only: make_beam
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  use whole_measurement, only: write_measurement
  implicit none
  integer, parameter :: N = 40, N_LOADS = 3
  real(rp), parameter :: LENGTH = 0.01_rp, DIAMETER = 1.0e-4_rp, YOUNG = 7.0e9_rp, OFFSET = 3.0e-4_rp, &
                         EI = YOUNG*PI/64*DIAMETER**4, STEP = 1.0e-3_rp*LENGTH, FORCE = 3*EI*STEP/LENGTH**3
  !> The chain of N segments differs from the beam by some 1/N^2 in the compliance; large deflections by STEP^2/L^2.
  real(rp), parameter :: TOLERANCE = 1.0_rp/N**2
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(measurement_t) :: m
  type(experiment_t), target :: experiment
  type(wing_problem_t) :: problem
  type(solid_params_t) :: params
  type(static_options_t) :: options
  type(fit_options_t) :: fit_options
  type(fit_report_t) :: report
  type(parameter_t) :: unknown
  type(failure_t) :: failure
  type(message_list_t) :: messages
  integer :: l, k

  call t%start(parallel=.false.)
  wing = make_beam(N, LENGTH, DIAMETER, [1.0_rp, 0.0_rp, 0.0_rp])
  allocate (m%x(0), m%y(0), m%loads(N_LOADS), m%observations(2*N_LOADS), m%zeros(1))
  m%zeros(1) = 'bench'
  do l = 1, N_LOADS
    m%loads(l)%name = 'load_'//achar(iachar('0') + l)
    m%loads(l)%force = (l - 1)*FORCE
    m%loads(l)%direction = [0.0_rp, 0.0_rp, -1.0_rp]
    m%loads(l)%point = [LENGTH, 0.0_rp]
    do k = 0, 1
      associate (observation => m%observations(l + k*N_LOADS))
        observation%name = achar(iachar('a') + k)//achar(iachar('0') + l)
        observation%load = l
        observation%point = [LENGTH, 0.0_rp]
        if (k == 0) then
          observation%quantity = QUANTITY_DISPLACEMENT
          observation%axis = [0.0_rp, 0.0_rp, 1.0_rp]
          observation%value = OFFSET - (l - 1)*STEP
          observation%sigma = 1.0e-8_rp
          observation%zero = 1
        else
          observation%quantity = QUANTITY_ROTATION
          observation%axis = [0.0_rp, 1.0_rp, 0.0_rp]
          observation%value = (l - 1)*1.5_rp*STEP/LENGTH ! the tip goes down, which is positive about y
          observation%sigma = 1.0e-6_rp
        end if
      end associate
    end do
  end do
  call write_measurement('beam_measurement.h5', m, failure)
  call read_measurement('beam_measurement.h5', wing, m, messages)
  call messages%print(6, '')
  call t%check('the measurement is valid', messages%count() == 0 .and. .not. failure%failed)
  params = default_params(wing)
  params%young = 3*YOUNG
  call experiment%init(m, wing, params, [params%find('E')], options, failure)
  unknown = experiment%describe(2)
  call t%check('the unknowns are E and the offset', experiment%count() == 2 .and. unknown%name == 'zero:bench' .and. &
               .not. unknown%is_log .and. unknown%unit == 'm')
  call problem%init(experiment)
  call fit(problem, wing_unknowns(experiment, experiment%start(), 1.0_rp), experiment%start(), problem%initial_state(), &
           fit_options, report)
  call t%check('the fit converges: '//report%reason, report%is_converged)
  call t%check_close('E is that of the beam', exp(report%p(1)), YOUNG, rtol=TOLERANCE)
  call t%check_close('the offset is found', report%p(2), OFFSET, atol=TOLERANCE*STEP)
  call problem%free()
  call t%finish()
end program test_measurement_beam
