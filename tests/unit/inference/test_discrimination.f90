! SPDX-License-Identifier: GPL-3.0-or-later
!> The separation of a cause from its rivals, with the data that there are and with further ones, against the remainder of a
!> projection by Gram and Schmidt on all data at once.
program test_discrimination
  use base_kinds, only: i8, rp
  use base_random, only: random_stream_t
  use inference_design, only: candidate_t
  use inference_discrimination, only: discrimination_t, marginal_normal, separation
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N = 12, M = 7, COLUMNS = 4, ERRORS = 2
  !> Relative. The squares of lengths lose what is projected out, at most 1e3 times what is left; the ridge is 1e-10.
  real(rp), parameter :: TOLERANCE = 1.0e-6_rp
  real(rp), parameter :: STRENGTH = 1.5_rp
  type(testkit_t) :: test
  type(random_stream_t) :: stream
  type(candidate_t) :: candidates(3)
  type(discrimination_t) :: discrimination
  real(rp) :: first(N, COLUMNS), further(M, COLUMNS), x(M, ERRORS), expected
  real(rp), allocatable :: normal(:, :), lengths(:)
  logical :: ok

  call test%start(parallel=.false.)
  stream = random_stream_t(seed=5_i8, stream=1_i8)
  call fill(first)
  call fill(further)
  call fill(x)
  candidates(1)%columns = [2]
  candidates(2)%columns = [3]
  candidates(3)%columns = [3, 4]
  call discrimination%init(candidates, 1, [2, 3], [1], [STRENGTH])
  call test%check('the columns are those of all, of the cause, and of rivals', all(discrimination%columns == [1, 2, 3, 4]))
  call test%check('the cause has the second one', all(discrimination%of_cause() == [2]))
  call discrimination%begin(matmul(transpose(first), first))
  call test%check('from a rival of one parameter', near(discrimination%now(1), remainder(first(:, [1, 3]), first(:, 2))))
  call test%check('from a rival of two', near(discrimination%now(2), remainder(first(:, [1, 3, 4]), first(:, 2))))
  call test_further()
  call test_errors()
  call test_unknown()
  call test%finish()

contains

  !> Further data have rows of their own.
  subroutine test_further()
    real(rp) :: all_data(N + M, COLUMNS)
    all_data(:N, :) = first
    all_data(N + 1:, :) = further
    lengths = discrimination%separations([1, 2], matmul(transpose(further), further))
    call test%check('with further data', near(lengths(1), remainder(all_data(:, [1, 3]), all_data(:, 2))))
    call test%check('with further data from two', near(lengths(2), remainder(all_data(:, [1, 3, 4]), all_data(:, 2))))
    lengths = discrimination%separations([1], matmul(transpose(further(:, 1:3)), further(:, 1:3)))
    call test%check('columns that no rival needs may be left out', near(lengths(1), remainder(all_data(:, [1, 3]), all_data(:, 2))))
  end subroutine test_further

  !> Errors of one sd are unknowns of these data alone, each with a row that says that it is 0 +- 1.
  subroutine test_errors()
    real(rp) :: wide(N + M + ERRORS, COLUMNS + ERRORS)
    integer :: i
    wide = 0
    wide(:N, :COLUMNS) = first
    wide(N + 1:N + M, :COLUMNS) = further
    wide(N + 1:N + M, COLUMNS + 1:) = x
    do i = 1, ERRORS
      wide(N + M + i, COLUMNS + i) = 1
    end do
    call marginal_normal(further, x, normal, ok)
    call test%check('data with errors have a normal matrix', ok)
    lengths = discrimination%separations([1, 2], normal)
    call test%check('with errors', near(lengths(1), remainder(wide(:, [1, 3, 5, 6]), wide(:, 2))))
    call test%check('with errors from two', near(lengths(2), remainder(wide(:, [1, 3, 4, 5, 6]), wide(:, 2))))
  end subroutine test_errors

  !> What further data show of a rival is not known: it may imitate all of it.
  subroutine test_unknown()
    lengths = discrimination%separations([1, 2], matmul(transpose(further), further), [.true., .true., .true., .false.])
    call test%check('a rival that is known is compared', lengths(1) > discrimination%now(1)*(1 + TOLERANCE))
    expected = discrimination%now(2)
    call test%check('one that is not stays where it is', near(lengths(2), expected))
    call test%check('two columns and a direction', near(separation(matmul(transpose(first), first), [1.0_rp, -2.0_rp]), &
                                                       remainder(first(:, :2), (first(:, 3) - 2*first(:, 4))/STRENGTH)))
  end subroutine test_unknown

  !> Fills an array with standard normal numbers.
  subroutine fill(a)
    real(rp), intent(out) :: a(:, :)
    integer :: j
    do j = 1, size(a, 2)
      call stream%gaussians(a(:, j))
    end do
  end subroutine fill

  !> Returns the length of the part of STRENGTH v normal to the columns of a.
  real(rp) function remainder(a, v) result(length)
    real(rp), intent(in) :: a(:, :), v(:)
    real(rp) :: q(size(a, 1), size(a, 2)), left(size(v))
    integer :: i, j, k
    q = a
    left = v
    do i = 1, size(q, 2)
      do k = 1, 2 ! twice is enough
        do j = 1, i - 1
          q(:, i) = q(:, i) - q(:, j)*dot_product(q(:, j), q(:, i))
        end do
      end do
      q(:, i) = q(:, i)/norm2(q(:, i))
      left = left - q(:, i)*dot_product(q(:, i), left)
    end do
    length = STRENGTH*norm2(left)
  end function remainder

  !> Tells whether two numbers are the same.
  logical function near(a, b)
    real(rp), intent(in) :: a, b
    near = abs(a - b) <= TOLERANCE*abs(b)
  end function near
end program test_discrimination
