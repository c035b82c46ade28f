! SPDX-License-Identifier: GPL-3.0-or-later
!> Compares errors of which only an sd is declared, such as tilts of scans, with this sd.
!>
!> r are the whitened residuals of a fit of the baseline (projector P). W = P C^-1/2 V, where V are the directions of one kind of
!> error scaled by their sd, and G = W^T W = X diag(g) X^T. If these errors are k times as large as declared, the components of
!> X^T W^T r are independent with the variances g + (k^2 - 1) g^2. (C contains them once.) The sum of their squares over these
!> variances is then chi^2 distributed, which gives k as a variance component (Searle, Casella and McCulloch 1992, ISBN
!> 0-471-62162-5): its interval, and p of the hypothesis that k is at most TOLERATED.
module inference_declared_errors
  use base_decimal, only: fixed
  use base_kinds, only: rp
  use base_lapack, only: symmetric_eigen
  use inference_residual_checks, only: make_check, residual_check_t
  use inference_design, only: design_t
  use inference_distributions, only: chi2_threshold, log_chi2_tail
  implicit none
  private
  public :: check_declared_errors, SIZE_WORDS

  character(*), parameter :: SIZE_WORDS = 'size of ' !< names of these checks begin with it
  real(rp), parameter :: TOLERATED = 1.5_rp  !< times the declared sd
  real(rp), parameter :: VISIBLE = 0.2_rp    !< g of directions that noise hides
  integer, parameter :: FEWEST = 6           !< directions
  real(rp), parameter :: SMALLEST = 1.0e-2_rp, LARGEST = 1.0e4_rp !< of k

contains

  !> Adds a check for every kind of error to checks(:). kinds(:) are those of the first nuisances of the design, 1, 2, ..
  !> with the name names(kind), or 0; residuals(n) are whitened.
  subroutine check_declared_errors(design, kinds, names, residuals, checks)
    type(design_t), intent(in) :: design
    integer, intent(in) :: kinds(:)
    character(*), intent(in) :: names(:)
    real(rp), intent(in) :: residuals(:)
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    real(rp), allocatable :: directions(:, :)
    integer, allocatable :: columns(:)
    integer :: k, i
    do k = 1, size(names)
      columns = pack([(i, i=1, size(kinds))], kinds == k)
      columns = pack(columns, norm2(design%nuisances(:, columns), 1) > 0)
      if (size(columns) < FEWEST) cycle
      directions = design%nuisances(:, columns)
      call design%whitener%apply(directions)
      call check_one(trim(names(k)), design%project_out_baseline(directions), residuals, checks)
    end do
  end subroutine check_declared_errors

  !> Tests one kind of error. directions(n, :) are W.
  subroutine check_one(name, directions, residuals, checks)
    character(*), intent(in) :: name
    real(rp), intent(in) :: directions(:, :), residuals(:)
    type(residual_check_t), allocatable, intent(inout) :: checks(:)
    real(rp) :: vectors(size(directions, 2), size(directions, 2)), values(size(directions, 2))
    real(rp), allocatable :: squares(:), g(:)
    type(residual_check_t) :: one
    real(rp) :: ratio, ends(2)
    vectors = matmul(transpose(directions), directions)
    call symmetric_eigen(vectors, values)
    squares = pack(matmul(matmul(residuals, directions), vectors)**2, values > VISIBLE)
    g = pack(values, values > VISIBLE)
    if (size(g) < FEWEST) return
    ratio = size_for(real(size(g), rp))
    ends = [size_for(chi2_threshold(log(0.05_rp), size(g))), size_for(chi2_threshold(log(0.95_rp), size(g)))]
    one = make_check(SIZE_WORDS//name, ratio, log_chi2_tail(sum_at(TOLERATED), size(g)), &
                        name//' are '//fixed(ratio, 1)//' times as large as declared (90 % interval '// &
                        fixed(ends(1), 1)//' to '//fixed(ends(2), 1)//')', &
                        name//' are no more than 1.5 times as large as declared')
    one%interval = ends
    checks = [checks, one]

  contains

    !> Returns the sum of squares over variances at k.
    pure real(rp) function sum_at(k)
      real(rp), intent(in) :: k
      sum_at = sum(squares/(g + (k**2 - 1)*g**2))
    end function sum_at

    !> Returns the k at which the sum has this value; an end of the range if it has it nowhere.
    pure real(rp) function size_for(wanted) result(k)
      real(rp), intent(in) :: wanted
      real(rp) :: lower, upper
      integer :: i
      lower = SMALLEST
      upper = LARGEST
      do i = 1, 60
        k = sqrt(lower*upper)
        if (sum_at(k) > wanted) then
          lower = k
        else
          upper = k
        end if
      end do
    end function size_for
  end subroutine check_one
end module inference_declared_errors
