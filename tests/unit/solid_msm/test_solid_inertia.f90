! SPDX-License-Identifier: GPL-3.0-or-later
!> The forces of inertia and damping in a moving frame are linear in the displacement at the new time,
!> and the symmetric and the skew tangent together are their derivative, to round-off. Drag grows with the square of the velocity;
!> with it they are the derivative up to the error of central differences, and it takes the power that `loss` says.
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
  real(rp), parameter :: H = 1.0e-4_rp !< step of differences
  real(rp), parameter :: DRAG = 0.4_rp !< [kg/m^3]
  real(rp), parameter :: Q = 3.0_rp !< [1/s] d(rate)/d(value) of the time scheme; small, so that all terms count
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: model
  type(inertia_t) :: inertia
  type(frame_t) :: frame
  type(failure_t) :: failure
  real(rp), allocatable, dimension(:, :) :: u, x, forces, change, skew, symmetric
  real(rp), allocatable :: blocks(:, :, :)
  real(rp) :: power, v(3)
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
  call test_drag()
  call t%finish()

contains

  !> |v| v has a third derivative of some |x|^3/|v|, so that differences err by some H^2 |x|^2/|u|^2, 1e-8 except where u is small.
  subroutine test_drag()
    inertia%drag = DRAG
    inertia%area = 1
    call forces_at(u + H*x, change)
    call forces_at(u - H*x, forces)
    change = (change - forces)/(2*H)
    blocks = 0
    call add_inertia_tangent(inertia, model, frame, Q, Q*u, blocks)
    symmetric = 0
    call model%pattern%multiply(blocks, 1.0_rp, x(:, model%movable), symmetric)
    call t%check_below('so they are with drag', &
                       maxval(abs(change(:, model%movable) - symmetric - skew(:, model%movable)))/maxval(abs(change)), 1.0e-6_rp)
    v = [0.3_rp, -2.0_rp, 0.7_rp]
    power = inertia%loss(model%movable(1), v)
    inertia%drag = 0
    power = power - inertia%loss(model%movable(1), v)
    call t%check_close('drag takes its force times the speed', power, DRAG*norm2(v)**3, rtol=1.0e-13_rp)
    inertia%drag = DRAG
    call forces_at(u, change)
    inertia%drag = 0
    call forces_at(u, forces)
    call t%check_close('and this is the power of the forces', sum(Q*u*(change - forces)), &
                       DRAG*sum(norm2(Q*u(:, model%movable), 1)**3), rtol=1.0e-12_rp)
  end subroutine test_drag

  !> The forces at displacements w, with the rates that the time scheme gives them.
  subroutine forces_at(w, f)
    real(rp), intent(in) :: w(:, :)
    real(rp), intent(out) :: f(:, :)
    f = 0
    call add_inertia_forces(inertia, model, frame, w, Q*w, Q**2*w, f)
  end subroutine forces_at
end program test_solid_inertia
