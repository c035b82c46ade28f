! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes how far a cause is from its rivals, and how far it would be with further data of any kind.
!>
!> The separation from a rival is the length of the part of the cause, at the strength that was found, that baseline and rival
!> together cannot imitate. Its square is a sum over independent data (Atkinson and Fedorov 1975, DOI 10.1093/biomet/62.1.57), so
!> that the normal matrix of further data is added to that of the data that there are.
module inference_discrimination
  use base_kinds, only: rp
  use base_lapack, only: factorise, solve_lower
  use inference_design, only: candidate_t
  use inference_rivals, only: ALIAS_LOSS
  implicit none
  private
  public :: discrimination_t, separation, marginal_normal

  real(rp), parameter, public :: APART = sqrt(2*ALIAS_LOSS) !< [sd] separation from which a set does not hold both causes

  type :: site_list_t
    integer, allocatable :: list(:)
  end type site_list_t

  !> The separation of a cause from its rivals by normal matrices.
  type :: discrimination_t
    integer, allocatable :: columns(:)       !< parameters: those of all hypotheses, those of the cause, those of rivals
    real(rp), allocatable :: white(:, :)     !< (observations, columns) whitened tangents, if the caller keeps them
    real(rp), allocatable :: now(:)          !< [sd] separation from each rival
    integer, private :: n_common = 0, n_cause = 0
    type(site_list_t), allocatable, private :: sites(:) !< of each rival in `columns`, without those of the cause
    real(rp), allocatable, private :: strength(:)     !< of the cause
    real(rp), allocatable, private :: normal(:, :)    !< of the data that there are
  contains
    procedure :: init => discrimination_init
    procedure :: begin => discrimination_begin
    procedure :: of_cause => discrimination_of_cause
    procedure :: needed => discrimination_needed
    procedure :: separations => discrimination_separations
    procedure, private :: block => discrimination_block
  end type discrimination_t

contains

  !> Finds `columns`. All hypotheses have the parameters `common`. The cause and its rivals are these numbers of `candidates`.
  subroutine discrimination_init(self, candidates, cause, rivals, common, strength)
    class(discrimination_t), intent(inout) :: self
    type(candidate_t), intent(in) :: candidates(:)
    integer, intent(in) :: cause, rivals(:), common(:)
    real(rp), intent(in) :: strength(:) !< of the parameters of the cause
    integer :: r, i
    self%strength = strength
    self%n_common = size(common)
    self%n_cause = size(candidates(cause)%columns)
    self%columns = [common, candidates(cause)%columns]
    if (allocated(self%sites)) deallocate (self%sites)
    allocate (self%sites(size(rivals)))
    do r = 1, size(rivals)
      allocate (self%sites(r)%list(0))
      associate (parameters => candidates(rivals(r))%columns)
        do i = 1, size(parameters)
          if (any(candidates(cause)%columns == parameters(i))) cycle
          if (all(self%columns(self%n_common + 1:) /= parameters(i))) self%columns = [self%columns, parameters(i)]
          self%sites(r)%list = [self%sites(r)%list, &
                                self%n_common + findloc(self%columns(self%n_common + 1:), parameters(i), 1)]
        end do
      end associate
    end do
  end subroutine discrimination_init

  !> Takes the normal matrix of `columns` of the data that there are, and finds `now`.
  subroutine discrimination_begin(self, normal)
    class(discrimination_t), intent(inout) :: self
    real(rp), intent(in) :: normal(:, :)
    integer :: r
    self%normal = normal
    if (allocated(self%now)) deallocate (self%now)
    allocate (self%now(size(self%sites)))
    do r = 1, size(self%now)
      self%now(r) = separation(normal(self%block(r), self%block(r)), self%strength)
    end do
  end subroutine discrimination_begin

  !> Returns the indices in `columns` of the parameters that are fitted if rival r replaces the cause, then those of the cause.
  pure function discrimination_block(self, r) result(block)
    class(discrimination_t), intent(in) :: self
    integer, intent(in) :: r
    integer, allocatable :: block(:)
    integer :: i
    block = [[(i, i=1, self%n_common)], self%sites(r)%list, self%of_cause()]
  end function discrimination_block

  !> Returns the indices in `columns` of the parameters of the cause.
  pure function discrimination_of_cause(self) result(of_cause)
    class(discrimination_t), intent(in) :: self
    integer, allocatable :: of_cause(:)
    integer :: i
    of_cause = [(i, i=self%n_common + 1, self%n_common + self%n_cause)]
  end function discrimination_of_cause

  !> Returns the indices in `columns` that these rivals need.
  pure function discrimination_needed(self, rivals) result(needed)
    class(discrimination_t), intent(in) :: self
    integer, intent(in) :: rivals(:)
    integer, allocatable :: needed(:)
    logical :: is_needed(size(self%columns))
    integer :: r
    is_needed = .false.
    do r = 1, size(rivals)
      is_needed(self%block(rivals(r))) = .true.
    end do
    needed = pack([(r, r=1, size(is_needed))], is_needed)
  end function discrimination_needed

  !> Returns the separations [sd] from these rivals with further data, of which `normal` is the normal matrix of the columns that
  !> the rivals need. Columns that are not in is_known(size(columns)) have an unknown effect on these data. Since no data lessen
  !> a separation, that from a rival with such a column is then at least the present one, which is returned.
  function discrimination_separations(self, rivals, normal, is_known) result(lengths)
    class(discrimination_t), intent(in) :: self
    integer, intent(in) :: rivals(:)
    real(rp), intent(in) :: normal(:, :)
    logical, intent(in), optional :: is_known(:)
    real(rp) :: lengths(size(rivals))
    integer :: position(size(self%columns)), i, r
    position = 0
    position(self%needed(rivals)) = [(i, i=1, size(normal, 1))]
    do i = 1, size(rivals)
      r = rivals(i)
      lengths(i) = self%now(r)
      if (present(is_known)) then
        if (.not. all(is_known(self%block(r)))) cycle
      end if
      associate (block => self%block(r))
        lengths(i) = separation(self%normal(block, block) + normal(position(block), position(block)), self%strength)
      end associate
    end do
  end function discrimination_separations

  !> Returns the length [sd] of the part of a direction that the columns before it cannot imitate. The direction is p(:) in the last
  !> size(p) columns.
  real(rp) function separation(normal, p) result(length)
    real(rp), intent(in) :: normal(:, :), p(:)
    real(rp), parameter :: RIDGE = 1.0e-10_rp ! of a diagonal element
    real(rp), allocatable :: g(:, :), h(:, :)
    integer :: i, m, n
    logical :: ok
    n = size(normal, 1)
    m = n - size(p)
    g = normal(:m, :m)
    do i = 1, m
      g(i, i) = g(i, i)*(1 + RIDGE) + tiny(1.0_rp)
    end do
    h = reshape(matmul(normal(:m, m + 1:), p), [m, 1])
    length = dot_product(p, matmul(normal(m + 1:, m + 1:), p))
    call factorise(g, ok)
    if (ok) call solve_lower(g, h)
    if (ok) length = length - sum(h**2)
    length = sqrt(max(0.0_rp, length))
  end function separation

  !> Returns the normal matrix of tangents(n, :) of data of unit variance that also have errors(n, :), the effects of independent
  !> errors of one sd. `ok` is false if the numbers are not finite.
  subroutine marginal_normal(tangents, errors, normal, ok)
    real(rp), intent(in) :: tangents(:, :), errors(:, :)
    real(rp), allocatable, intent(out) :: normal(:, :)
    logical, intent(out) :: ok
    real(rp) :: c(size(tangents, 1), size(tangents, 1)), white(size(tangents, 1), size(tangents, 2))
    integer :: i
    c = matmul(errors, transpose(errors))
    do i = 1, size(c, 1)
      c(i, i) = c(i, i) + 1
    end do
    white = tangents
    call factorise(c, ok)
    if (.not. ok) return
    call solve_lower(c, white)
    normal = matmul(transpose(white), white)
  end subroutine marginal_normal
end module inference_discrimination
