! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds which parameters can be determined from the shapes of a wing under ten loads. It computes the singular values of the
!> derivatives of all vertical displacements with respect to ln E and the ln of the joints' stiffness, and the standard deviations
!> of the parameters if every point has a measurement noise of 10 um.
!>
!> usage: bench_identifiability WING.h5, a wing with ten joints
program identifiability
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_lapack, only: singular_values, symmetric_eigen
  use base_parameter, only: parameter_t
  use loaded_wing, only: N_LOADS, MODERATE_FORCES, load_at, wing_of_argument
  use model_variation, only: shape_sensitivities
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_wing, only: wing_t
  implicit none
  integer, parameter :: N_PARAMETERS = 11
  real(rp), parameter :: NOISE = 1.0e-5_rp ! [m]
  type(wing_t) :: wing
  type(solid_params_t) :: params
  type(parameter_t) :: parameter
  type(solid_model_t) :: model
  type(equilibrium_t) :: work
  type(load_t) :: load
  type(failure_t) :: failure
  type(static_report_t) :: report
  type(static_options_t) :: options
  real(rp), allocatable :: u(:, :), d(:, :, :), rows(:, :), values(:)
  real(rp) :: normal(N_PARAMETERS, N_PARAMETERS), eigenvalues(N_PARAMETERS)
  integer :: numbers(N_PARAMETERS), l, p

  wing = wing_of_argument()
  params = default_params(wing)
  params%young = 12.6e9_rp
  params%cross_springs = .true.
  call model%init(wing, params, failure)
  call require(.not. failure%failed .and. size(wing%joints) == 10, 'a wing with ten joints is needed')
  numbers = [model%params%find('E'), (model%params%count_basic() - 10 + p, p=1, 10)]
  call work%init(model)
  allocate (u(3, model%n_all), d(3, model%n_all, N_PARAMETERS), rows(N_LOADS*model%n_points, N_PARAMETERS))
  do l = 1, N_LOADS
    call load_at(model, l, MODERATE_FORCES(l), load)
    call solve_static(work, model, load, .false., options, u, report)
    call shape_sensitivities(work, model, u, numbers, d)
    write (output_unit, '(a,i3,a,f7.3,a,l2,a,i4,a,i3)') 'load', l, ': w/R', &
      sum(load%force*u)/MODERATE_FORCES(l)/model%size, '  converged', report%converged, &
      '  factorisations', report%factorisations, '  snaps', report%snaps
    rows(1 + (l - 1)*model%n_points:l*model%n_points, :) = d(3, :model%n_points, :)/NOISE
  end do
  values = singular_values(rows)
  normal = matmul(transpose(rows), rows)
  call symmetric_eigen(normal, eigenvalues)
  write (output_unit, '(a)') 'singular values of d z/d ln p over 10 um:'
  write (output_unit, '(11es10.2)') values
  write (output_unit, '(a)') 'standard deviation of ln p when 10 um of noise is independent at all points:'
  do p = 1, N_PARAMETERS
    parameter = model%params%describe(numbers(p))
    write (output_unit, '(a24,f10.4,a,es9.2,a)') parameter%name, sqrt(sum(normal(p, :)**2/eigenvalues)), &
      '   (rms signal per ln unit', NOISE*norm2(rows(:, p))/sqrt(real(size(rows, 1), rp)), ' m)'
  end do
end program identifiability
