! SPDX-License-Identifier: GPL-3.0-or-later
!> Which parameters can be seen in the shapes of a wing under ten loads: singular values of the
!> derivatives of all vertical displacements with respect to ln E and the ln of the joints' stiffness,
!> and the standard deviations of the parameters that a noise of 10 um at every point leaves.
program identifiability
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use sample_wings, only: make_fly_wing
  use solid_equilibrium, only: equilibrium_t
  use solid_lapack, only: singular_values, symmetric_eigen
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, parameter_t, default_params
  use solid_sensitivity, only: shape_sensitivities
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_wing, only: wing_t
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  integer, parameter :: NX = 60, NY = 16, N_LOADS = 10, N_PARAMETERS = 11
  real(rp), parameter :: NOISE = 1.0e-5_rp ! [m]
  real(rp), parameter :: PLACES(2, N_LOADS) = reshape([0.25_rp, 0.95_rp, 0.45_rp, 0.9_rp, 0.6_rp, 0.7_rp, &
    0.8_rp, 0.7_rp, 0.95_rp, 0.6_rp, 0.35_rp, 0.45_rp, 0.55_rp, 0.4_rp, 0.75_rp, 0.4_rp, 0.3_rp, 0.15_rp, &
    0.6_rp, 0.2_rp], [2, N_LOADS]) ! fractions of span and chord
  real(rp), parameter :: FORCES(N_LOADS) = 1.0e-4_rp* &
    [15.0_rp, 8.0_rp, 6.0_rp, 3.0_rp, 1.5_rp, 8.0_rp, 5.0_rp, 3.0_rp, 5.0_rp, 3.0_rp] ! [N]
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
  integer :: numbers(N_PARAMETERS), l, p, triangle

  wing = make_fly_wing(NX, NY)
  params = default_params(wing)
  params%young = 12.6e9_rp
  params%cross_springs = .true.
  call model%init(wing, params, failure)
  call require(.not. failure%failed, 'the wing is wrong')
  numbers = [model%params%find('E'), (model%params%count() - 10 + p, p=1, 10)]
  call work%init(model)
  allocate (u(3, model%n_all), d(3, model%n_all, N_PARAMETERS), rows(N_LOADS*model%n_points, N_PARAMETERS))
  do l = 1, N_LOADS
    triangle = 2*(floor(PLACES(2, l)*NY)*NX + floor(PLACES(1, l)*NX)) + 1
    call load%init(model)
    do p = 1, 3
      call load%add_point(model%triangles(p, triangle), [0.0_rp, 0.0_rp, FORCES(l)/3])
    end do
    call solve_static(work, model, load, .false., options, u, report)
    call shape_sensitivities(work, model, u, numbers, d)
    write (output_unit, '(a,i3,a,f7.3,a,l2,a,i4,a,i3)') 'load', l, ': w/R', &
      sum(u(3, model%triangles(:, triangle)))/3/model%size, '  converged', report%converged, &
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
    write (output_unit, '(a12,f10.4,a,es9.2,a)') parameter%name, sqrt(sum(normal(p, :)**2/eigenvalues)), &
      '   (rms signal per ln unit', NOISE*norm2(rows(:, p))/sqrt(real(size(rows, 1), rp)), ' m)'
  end do
end program identifiability
