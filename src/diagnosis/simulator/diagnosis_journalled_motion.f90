! SPDX-License-Identifier: GPL-3.0-or-later
!> Keeps what rank 0 computes of a wing in motion in the journal that has the tasks of all ranks. Natural modes and records of a
!> vibration are answers by themselves. Their key has the mesh, because a diagnosis asks the same of two meshes. What flights show
!> follows from approximations that a journal does not identify; it costs little and is computed again.
module diagnosis_journalled_motion
  use base_checksum, only: checksum_add, checksum_integers, checksum_reals
  use base_kinds, only: i8, rp
  use diagnosis_wing_motion, only: wing_motion_t
  use io_journal, only: journal_t
  use measurement_observed_wing, only: wing_patterns_t
  implicit none
  private
  public :: journalled_motion_t

  integer, parameter :: EVALUATION = 1, DIRECTIONS = 2

  type, extends(wing_motion_t) :: journalled_motion_t
    type(journal_t), pointer :: journal => null() !< of all results of the simulator, on rank 0
    integer :: mesh = 0                           !< number of its points
  contains
    procedure :: recall_evaluation => motion_recall_evaluation
    procedure :: recall_directions => motion_recall_directions
    procedure, private :: key => motion_key
  end type journalled_motion_t

contains

  !> Does `evaluate`, unless the journal has its result. Tangents and patterns must not be asked for after it. All numbers are 0 if
  !> the wing is not stable.
  subroutine motion_recall_evaluation(self, q, columns, residuals, jacobian, ok)
    class(journalled_motion_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: ok
    real(rp), allocatable :: answer(:, :)
    integer(i8) :: key
    integer :: m
    logical :: is_known, keeps
    m = self%modes%n + self%series%n
    keeps = associated(self%journal) .and. m > 0
    key = self%key(EVALUATION, q, columns)
    if (keeps) allocate (answer(m, size(columns) + 1))
    is_known = .false.
    ok = .false.
    if (keeps) call self%journal%recall(key, answer, ok, is_known)
    if (is_known) then
      residuals(:m) = answer(:, 1)
      jacobian(:m, :) = answer(:, 2:)
      if (self%n == m) return
      residuals(m + 1:) = 0
      jacobian(m + 1:, :) = 0
      if (ok) call self%flight%evaluate(q, columns, residuals(m + 1:), jacobian(m + 1:, :))
      return
    end if
    call self%evaluate(q, columns, residuals, jacobian, ok)
    if (.not. ok) residuals = 0
    if (.not. ok) jacobian = 0
    if (.not. keeps) return
    answer(:, 1) = residuals(:m)
    answer(:, 2:) = jacobian(:m, :)
    call self%journal%record(key, answer, ok)
  end subroutine motion_recall_evaluation

  !> Does `nuisances`, and `patterns` of these causes, unless the journal has their result.
  subroutine motion_recall_directions(self, q, membrane, membrane_sd, causes, nuisances, patterns, ok)
    class(journalled_motion_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), membrane_sd
    integer, intent(in) :: membrane
    type(wing_patterns_t), intent(in) :: causes
    real(rp), intent(inout) :: nuisances(:, :), patterns(:, :)
    logical, intent(out) :: ok
    real(rp), allocatable :: answer(:, :)
    integer(i8) :: key
    integer :: n
    logical :: is_known, keeps
    n = size(nuisances, 2)
    keeps = associated(self%journal) .and. self%n > 0 .and. self%flight%n == 0
    key = self%key(DIRECTIONS, q, [membrane])
    if (keeps) allocate (answer(self%n, n + size(patterns, 2)))
    is_known = .false.
    ok = .false.
    if (keeps) call self%journal%recall(key, answer, ok, is_known)
    if (is_known) then
      nuisances = answer(:, :n)
      patterns = answer(:, n + 1:)
      return
    end if
    call self%nuisances(q, membrane, membrane_sd, nuisances, ok)
    if (ok) call self%patterns(causes%site, causes%radius, patterns)
    if (.not. keeps) return
    answer(:, :n) = nuisances
    answer(:, n + 1:) = patterns
    call self%journal%record(key, answer, ok)
  end subroutine motion_recall_directions

  !> Returns the key of a question at q about these parameters on this mesh.
  pure integer(i8) function motion_key(self, question, q, columns) result(key)
    class(journalled_motion_t), intent(in) :: self
    integer, intent(in) :: question, columns(:)
    real(rp), intent(in) :: q(:)
    key = checksum_add(checksum_reals(q, 0_i8), &
                       checksum_integers(int([question, self%mesh, columns], i8), size(q, kind=i8)))
  end function motion_key
end module diagnosis_journalled_motion
