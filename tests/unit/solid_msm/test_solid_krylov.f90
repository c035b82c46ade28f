! SPDX-License-Identifier: GPL-3.0-or-later
!> A tangent inverted by the factors of another one: the residual that is reported is the true one, small, and as
!> small as asked for; with the factors of the tangent itself two steps suffice without spin. In time steps it takes the
!> place of further factorisations: the same motion with two of them.
program test_solid_krylov
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_random, only: random_stream_t
  use model_variation, only: set_parameter
  use sample_wings, only: make_beam
  use solid_cholesky, only: cholesky_t
  use solid_dynamics, only: copy_state, dynamics_t, dynamic_state_t, dynamic_options_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_krylov, only: krylov_t
  use solid_model, only: solid_model_t
  use solid_motion, only: steady_motion_t
  use solid_params, only: default_params
  use solid_pattern, only: pattern_t, make_pattern
  use solid_vectors, only: cross
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call invert_random()
  call step_hard()
  call t%finish()

contains

  !> A chain of random symmetric positive definite blocks, the same in each run, factors of one whose diagonal is a fifth larger.
  subroutine invert_random()
    integer, parameter :: N = 30
    real(rp), parameter :: ENOUGH = 1.0e-6_rp
    type(pattern_t) :: pattern
    type(cholesky_t) :: cholesky
    type(krylov_t) :: krylov
    type(random_stream_t) :: random
    real(rp), allocatable :: blocks(:, :, :), dense(:, :), still(:, :)
    real(rp) :: b(3, N), x(3, N), turns(3, N), left, residual(3*N), e(3)
    integer :: i, j, k, c
    pattern = make_pattern(N, reshape([([i, i + 1], i=1, N - 1), ([i, i + 7], i=1, N - 7)], [2, 2*N - 8]))
    allocate (blocks(3, 3, size(pattern%rows)), dense(3*N, 3*N), still(3, N))
    random%seed = 1
    blocks = reshape(uniforms(random, size(blocks)), shape(blocks))
    do j = 1, N
      k = pattern%start(j + 1) - 1
      blocks(:, :, k) = blocks(:, :, k) + transpose(blocks(:, :, k))
      do c = 1, 3
        blocks(c, c, k) = blocks(c, c, k) + 15 ! more than the four blocks beside it can hold
      end do
    end do
    b = reshape(uniforms(random, 3*N), [3, N])
    turns = 20*reshape(uniforms(random, 3*N), [3, N]) - 10
    still = 0
    dense = 0
    do j = 1, N
      do k = pattern%start(j), pattern%start(j + 1) - 1
        i = pattern%rows(k)
        dense(3*i - 2:3*i, 3*j - 2:3*j) = blocks(:, :, k)
        dense(3*j - 2:3*j, 3*i - 2:3*i) = transpose(blocks(:, :, k))
      end do
      do c = 1, 3
        e = 0
        e(c) = 1
        dense(3*j - 2:3*j, 3*j - 3 + c) = dense(3*j - 2:3*j, 3*j - 3 + c) + cross(turns(:, j), e)
      end do
    end do
    call cholesky%init(pattern%colptr, pattern%rowind)
    call krylov%init(N)

    call factorise(pattern, blocks, 1.2_rp, cholesky)
    call krylov%solve(pattern, blocks, turns, cholesky, b, ENOUGH, x, left)
    residual = matmul(dense, reshape(x, [3*N])) - reshape(b, [3*N])
    call t%check('as small as asked for', left <= ENOUGH)
    call t%check_close('the residual is the true one', norm2(residual)/norm2(b), left, rtol=1.0e-6_rp)

    call factorise(pattern, blocks, 1.0_rp, cholesky)
    call krylov%solve(pattern, blocks, still, cholesky, b, 1.0e-13_rp, x, left)
    call t%check('with its own factors and without spin it is exact', left <= 1.0e-13_rp)
    b = 0
    call krylov%solve(pattern, blocks, turns, cholesky, b, ENOUGH, x, left)
    call t%check('nothing for nothing',.not. (maxval(abs(x)) > 0 .or. left > 0))
    call krylov%free()
    call cholesky%free()
  end subroutine invert_random

  !> The next n numbers between 0 and 1.
  function uniforms(random, n) result(x)
    type(random_stream_t), intent(inout) :: random
    integer, intent(in) :: n
    real(rp) :: x(n)
    integer :: i
    do i = 1, n
      x(i) = random%uniform()
    end do
  end function uniforms

  !> Factorises the blocks with diagonal blocks `factor` times as large.
  subroutine factorise(pattern, blocks, factor, cholesky)
    type(pattern_t), intent(in) :: pattern
    real(rp), intent(in) :: blocks(:, :, :), factor
    type(cholesky_t), intent(inout) :: cholesky
    real(rp) :: other(3, 3, size(blocks, 3)), values(size(pattern%rowind))
    integer :: j, diagonal
    logical :: is_spd
    other = blocks
    do j = 1, pattern%n
      diagonal = pattern%start(j + 1) - 1
      other(:, :, diagonal) = factor*other(:, :, diagonal)
    end do
    call pattern%pack(other, values)
    call cholesky%factorise(values, is_spd)
    call t%check('positive definite', is_spd)
  end subroutine factorise

  !> A soft beam that is hit: Newton's method proper needs more than three factorisations in some steps.
  subroutine step_hard()
    integer, parameter :: N = 12, STEPS = 12
    real(rp), parameter :: DT = 4.0e-2_rp
    type(wing_t) :: wing
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(dynamics_t) :: stepper
    type(dynamic_state_t) :: state(2), begun
    type(dynamic_options_t) :: options(2)
    type(step_report_t) :: report
    type(steady_motion_t) :: motion
    type(failure_t) :: failure
    real(rp), allocatable :: force(:, :), guess(:, :)
    integer :: step, way, most(2)
    wing = make_beam(N, 1.0_rp, 0.1_rp, [1.0_rp, 0.0_rp, 0.0_rp])
    call model%init(wing, default_params(wing), failure)
    call t%check('the beam is valid',.not. failure%failed)
    call set_parameter(model, model%params%find('E'), 2.0e5_rp)
    call inertia%init(model, spread(1.0_rp/N, 1, N + 1))
    motion%frame%omega = [0.0_rp, 0.0_rp, 3.0_rp]
    allocate (force(3, model%n_all), source=0.0_rp)
    force(3, N + 1) = 4
    options(1)%worth_reuse = 0
    options(1)%factorisations = huge(1)
    options(1)%iterations = 20
    options(2)%factorisations = 2
    most = 0
    call stepper%init(model)
    do way = 1, 2
      call state(way)%init(model, 0.0_rp)
      do step = 1, STEPS
        call stepper%step(model, inertia, motion, force, DT, options(way), state(way), report)
        call t%check('a step', report%converged .and. report%substeps == 1)
        most(way) = max(most(way), report%factorisations)
      end do
    end do
    print '(a,2i4,es10.2)', 'factorisations, difference', most, maxval(abs(state(2)%u - state(1)%u))
    call t%check('Newton''s method needs more than three factorisations', most(1) > 3)
    call t%check('with iterations two suffice', most(2) <= 2)
    ! Residuals of 1e-8 of the forces, of which a tip of stiffness 3 E I/l^3 = 2.9 N/m makes 1e-8*4/2.9 m a step.
    call t%check_close('the same shape', maxval(abs(state(2)%u - state(1)%u)), 0.0_rp, atol=STEPS*1.4e-8_rp)
    ! One more step, and again under a force that differs a little, with the factors of the first time and afresh.
    begun = state(1)
    options(1) = dynamic_options_t()
    call stepper%step(model, inertia, motion, force, DT, options(1), state(1), report)
    call t%check('a step takes factorisations', report%converged .and. report%factorisations > 0)
    force = 1.01_rp*force
    guess = state(1)%u
    do way = 1, 2
      call copy_state(begun, state(way))
      if (way == 1) call stepper%step(model, inertia, motion, force, DT, options(1), state(1), report, guess)
      if (way == 2) call stepper%step(model, inertia, motion, force, DT, options(1), state(2), report)
      most(way) = report%factorisations
    end do
    call t%check('made again it needs none', most(1) == 0)
    call t%check('but afresh it does', most(2) > 0)
    call t%check_close('and ends alike', maxval(abs(state(2)%u - state(1)%u)), 0.0_rp, atol=2*1.4e-8_rp)
    call stepper%free()
  end subroutine step_hard
end program test_solid_krylov
