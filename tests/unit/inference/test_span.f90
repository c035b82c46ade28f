! SPDX-License-Identifier: GPL-3.0-or-later
!> What the errors of tangents may make up is no direction of the design: the span of columns, and with it the variance ratio of a
!> strongly misfitting beam, moves by no more than their errors allow. The beam has causes that do the same by construction.
program test_span
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use base_random, only: fill_gaussians
  use diagnosis_beam, only: beam_t, make_beam, N_BASE
  use inference_design, only: build_design, design_t
  use inference_simulator, only: TANGENT_ERROR
  use inference_span, only: find_span
  use least_squares_state, only: solver_state_t
  use rough_beam, only: rough_beam_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test

  call test%start(parallel=.false.)
  call test_dependent()
  call test_errors_differ()
  call test_nothing()
  call test_ratio()
  call test%finish()

contains

  !> 30 columns of rank 12, and the same with errors: the span turns by less than Wedin's bound.
  subroutine test_dependent()
    integer, parameter :: N = 80, M = 30, RANK = 12
    real(rp), parameter :: ERROR = 1.0e-6_rp, SHARE = 0.1_rp
    real(rp) :: a(N, M), left(N*RANK), right(RANK*M), change(N*M), margin, unused
    real(rp), allocatable :: basis(:, :), turned(:, :)
    integer :: j
    call fill_gaussians(3_i8, 1_i8, 0_i8, left)
    call fill_gaussians(3_i8, 2_i8, 0_i8, right)
    call fill_gaussians(3_i8, 3_i8, 0_i8, change)
    a = matmul(reshape(left, [N, RANK]), reshape(right, [RANK, M]))
    call find_span(a, ERROR*norm2(a, 1), basis, margin)
    call test%check('dependent columns span what the independent ones do', size(basis, 2) == RANK)
    call test%check('the basis is orthonormal', maxval(abs(matmul(transpose(basis), basis) - identity(RANK))) < 1.0e-13_rp)
    call test%check('and holds all columns', norm2(a - matmul(basis, matmul(transpose(basis), a))) < 1.0e-12_rp*norm2(a))
    do j = 1, M
      associate (one => change((j - 1)*N + 1:j*N))
        a(:, j) = a(:, j) + SHARE*ERROR*norm2(a(:, j))*one/norm2(one)
      end associate
    end do
    call find_span(a, ERROR*norm2(a, 1), turned, unused)
    call test%check('errors add no direction', size(turned, 2) == RANK)
    if (size(turned, 2) /= RANK) return
    call test%check('and turn the span by no more than the bound', &
                    norm2(turned - matmul(basis, matmul(transpose(basis), turned))) < sqrt(real(RANK, rp))*SHARE/(margin - SHARE))
    call test%check('nor the basis, by more than mixtures are worse conditioned', norm2(turned - basis) < 1.0e3_rp*SHARE/margin)
  end subroutine test_dependent

  !> A column that another one holds but for less than its own error adds nothing; a column without errors adds it.
  subroutine test_errors_differ()
    real(rp) :: a(4, 2), margin
    real(rp), allocatable :: basis(:, :)
    a = 0
    a(1, :) = 1
    a(2, 2) = 1.0e-4_rp
    call find_span(a, [1.0e-3_rp, 1.0e-3_rp], basis, margin)
    call test%check('a difference below the errors is no direction', size(basis, 2) == 1)
    call find_span(a, [1.0e-6_rp, 1.0e-6_rp], basis, margin)
    call test%check('a larger one is', size(basis, 2) == 2)
  end subroutine test_errors_differ

  subroutine test_nothing()
    real(rp) :: a(4, 2), margin
    real(rp), allocatable :: basis(:, :)
    a = 0
    call find_span(a, [0.0_rp, 0.0_rp], basis, margin)
    call test%check('columns of length 0 span nothing', size(basis, 2) == 0 .and. .not. margin > 0)
    call find_span(a(:, :0), [real(rp) ::], basis, margin)
    call test%check('nor do no columns', size(basis, 2) == 0 .and. .not. margin > 0)
  end subroutine test_nothing

  !> A wave of compliance that the beam's model lacks, at a signal-to-noise ratio of some tens, and scans that have something of the
  !> next one, which no cause explains: errors in tangents turn the span of
  !> z by an angle of the sine SHARE/(margin - SHARE), and the sum of squares that is left moves by this times that of residuals.
  subroutine test_ratio()
    real(rp), parameter :: SHARE = 0.01_rp
    type(rough_beam_t) :: beam
    type(design_t) :: design
    real(rp) :: ratio, moved, square, unused, bound, most
    integer :: i, k
    call make_beam(beam%beam_t)
    beam%hidden = [(0.7_rp*sin(20*(i - 0.5_rp)/60), i=1, 60)]
    call beam%observe(beam%null_point(), beam%sigma, 800001)
    beam%data = beam%data + 0.05_rp*(cshift(beam%data, 28) - beam%data)
    call judge(beam, design, ratio, square)
    k = design%k
    bound = SHARE/(design%margin - SHARE)*square/design%residual_dof
    call test%check('the misfit is strong', square > 20**2)
    call test%check('causes that do the same add no direction', k < size(beam%parameters) - N_BASE + beam%n_patterns)
    most = 0
    do i = 1, 3
      beam%roughness = SHARE*TANGENT_ERROR
      beam%seed = i
      call judge(beam, design, moved, unused)
      most = max(most, abs(moved - ratio))
      if (design%k /= k) most = huge(most)
    end do
    call test%check('errors of tangents move the variance ratio by no more than the bound', most < bound .and. bound < 0.01_rp)
  end subroutine test_ratio

  !> The variance ratio of the residuals at the null, and their sum of squares without what the baseline imitates.
  subroutine judge(beam, design, ratio, square)
    type(rough_beam_t), intent(inout) :: beam
    type(design_t), intent(out) :: design
    real(rp), intent(out) :: ratio, square
    class(solver_state_t), allocatable :: state
    type(failure_t) :: failure
    real(rp), allocatable :: z(:)
    real(rp) :: residuals(beam%n_observations), nothing(beam%n_observations, 0), q(size(beam%parameters)), rest
    logical :: is_valid
    q = beam%null_point()
    allocate (state)
    call build_design(beam, q, state, 1.0_rp, design, failure)
    call beam%evaluate(q, [integer ::], state, residuals, nothing, is_valid)
    allocate (z(design%k))
    call design%compress(residuals, q(:N_BASE), z, rest)
    ratio = rest/design%residual_dof
    square = sum(z**2) + rest
    call test%check('the design exists', is_valid .and. .not. failure%failed)
  end subroutine judge

  !> The unit matrix.
  pure function identity(n) result(one)
    integer, intent(in) :: n
    real(rp) :: one(n, n)
    integer :: i
    one = 0
    do i = 1, n
      one(i, i) = 1
    end do
  end function identity
end program test_span
