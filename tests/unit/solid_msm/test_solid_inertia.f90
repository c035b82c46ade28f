! SPDX-License-Identifier: GPL-3.0-or-later
!> The forces of inertia and damping in a moving frame are linear in the displacement at the new time,
!> and the symmetric and the skew tangent together are their derivative, to round-off.
program test_solid_inertia
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use sample_wings, only: make_fly_wing
  use solid_inertia, only: inertia_t, add_inertia_forces, add_inertia_tangent, apply_gyroscopic
  use solid_model, only: solid_model_t
  use solid_motion, only: frame_t
  use solid_params, only: default_params
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: Q = 3.0_rp !< [1/s] d(rate)/d(value) of the time scheme; small, so that all terms count
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(inertia_t) :: inertia
  type(frame_t) :: frame
  type(failure_t) :: failure
  real(rp), allocatable, dimension(:, :) :: u, x, forces, change, skew, symmetric
  real(rp), allocatable :: blocks(:, :, :)
  integer :: i, c

  call t%start(parallel=.false.)
  wing = make_fly_wing(24, 12)
  call model%init(wing, default_params(wing), failure)
  call t%check('the wing is valid',.not. failure%failed)
  call inertia%init(model, [(1.0_rp + 0.5_rp*sin(1.0_rp*i), i=1, model%n_points)])
  inertia%nodal = [(0.3_rp + 0.1_rp*cos(1.0_rp*i), i=1, model%n_all)]
  inertia%rayleigh_mass = 0.7_rp
  frame%omega = [1.0_rp, -2.0_rp, 1.5_rp]
  frame%alpha = [-4.0_rp, 3.0_rp, 2.0_rp]
  frame%acceleration = [1.0_rp, 2.0_rp, 3.0_rp]
  u = reshape([((sin(1.7_rp*i + c**2), c=1, 3), i=1, model%n_all)], [3, model%n_all])
  x = reshape([((cos(0.9_rp*i + c**2), c=1, 3), i=1, model%n_all)], [3, model%n_all])
  call model%zero_clamped(u)
  call model%zero_clamped(x)
  allocate (forces, change, skew, mold=u)
  allocate (symmetric(3, model%n_free), blocks(3, 3, size(model%pattern%rows)), source=0.0_rp)
  forces = 0
  call add_inertia_forces(inertia, model, frame, u, Q*u, Q**2*u, forces)
  change = 0
  call add_inertia_forces(inertia, model, frame, u + x, Q*(u + x), Q**2*(u + x), change)
  change = change - forces
  call add_inertia_tangent(inertia, model, frame, Q, Q*u, blocks)
  call model%pattern%multiply(blocks, 1.0_rp, x(:, model%movable), symmetric)
  skew = 0
  call apply_gyroscopic(inertia, model, frame, Q, x, skew)
  call t%check_below('the two tangents are the derivative of the forces', &
                     maxval(abs(change(:, model%movable) - symmetric - skew(:, model%movable)))/maxval(abs(change)), &
                     1.0e-13_rp)
  call t%check_below('the gyroscopic part does no work', abs(sum(x*skew))/sum(abs(x*skew)), 1.0e-14_rp)
  call t%finish()
end program test_solid_inertia
