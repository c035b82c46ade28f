! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks for tests, with or without MPI. A test makes a `testkit_t`, calls checks with a sentence that
!> should be true, and ends with `finish`, which gives exit code 1 if any check failed on any rank.
module testkit
  use base_kinds, only: rp
  use parallel_world, only: world_t
  use, intrinsic :: iso_fortran_env, only: output_unit
  implicit none
  private
  public :: testkit_t

  type :: testkit_t
    type(world_t) :: world
    logical :: parallel = .false.
    integer :: n_failed = 0
    integer :: n_checks = 0
  contains
    procedure :: start => testkit_start
    procedure :: check => testkit_check
    procedure :: check_close => testkit_check_close
    procedure :: check_below => testkit_check_below
    procedure :: check_order => testkit_check_order
    procedure :: finish => testkit_finish
    procedure :: skip => testkit_skip
  end type testkit_t

contains

  !> Starts a test program; `parallel` starts MPI, and then every check is collective.
  subroutine testkit_start(self, parallel)
    class(testkit_t), intent(inout) :: self
    logical, intent(in) :: parallel
    self%parallel = parallel
    if (parallel) call self%world%start()
  end subroutine testkit_start

  !> The sentence must hold on all ranks.
  subroutine testkit_check(self, sentence, holds)
    class(testkit_t), intent(inout) :: self
    character(*), intent(in) :: sentence
    logical, intent(in) :: holds
    integer :: bad
    bad = merge(0, 1, holds)
    if (self%parallel) bad = self%world%max_integer(bad)
    self%n_checks = self%n_checks + 1
    self%n_failed = self%n_failed + bad
    if (.not. self%world%is_root) return
    write (output_unit, '(a,a)') merge('pass  ', 'FAIL  ', bad == 0), sentence
    flush (output_unit)
  end subroutine testkit_check

  !> |got - want| <= atol + rtol*|want|, NaN fails.
  subroutine testkit_check_close(self, sentence, got, want, atol, rtol)
    class(testkit_t), intent(inout) :: self
    character(*), intent(in) :: sentence
    real(rp), intent(in) :: got, want
    real(rp), intent(in), optional :: atol, rtol
    real(rp) :: allowed
    character(120) :: detail
    allowed = 0
    if (present(atol)) allowed = allowed + atol
    if (present(rtol)) allowed = allowed + rtol*abs(want)
    write (detail, '(a,es23.15,a,es23.15,a,es9.2,a)') ' (got', got, ', want', want, ', allowed', allowed, ')'
    call self%check(sentence//trim(detail), abs(got - want) <= allowed)
  end subroutine testkit_check_close

  !> got <= limit, NaN fails.
  subroutine testkit_check_below(self, sentence, got, limit)
    class(testkit_t), intent(inout) :: self
    character(*), intent(in) :: sentence
    real(rp), intent(in) :: got, limit
    character(80) :: detail
    write (detail, '(a,es12.4,a,es12.4,a)') ' (got', got, ', limit', limit, ')'
    call self%check(sentence//trim(detail), got <= limit)
  end subroutine testkit_check_below

  !> Errors at step sizes h fall with the expected order: the slope between successive pairs must lie
  !> within `tolerance` of `order`.
  subroutine testkit_check_order(self, sentence, h, errors, order, tolerance)
    class(testkit_t), intent(inout) :: self
    character(*), intent(in) :: sentence
    real(rp), intent(in) :: h(:), errors(:), order, tolerance
    real(rp) :: slope
    character(80) :: detail
    integer :: i
    do i = 1, size(h) - 1
      slope = log(errors(i)/errors(i + 1))/log(h(i)/h(i + 1))
      write (detail, '(a,f7.3,a,f5.2,a,f5.2,a,2es10.2,a)') ' (slope', slope, ', want', order, ' +-', tolerance, &
        ', errors', errors(i), errors(i + 1), ')'
      call self%check(sentence//trim(detail), abs(slope - order) <= tolerance)
    end do
  end subroutine testkit_check_order

  !> Says why the test cannot be made here and ends the program with the exit code that stands for that.
  subroutine testkit_skip(self, sentence)
    class(testkit_t), intent(inout) :: self
    character(*), intent(in) :: sentence
    if (self%world%is_root) write (output_unit, '(a)') 'skipped: '//sentence
    flush (output_unit)
    if (self%parallel) call self%world%stop()
    stop 77
  end subroutine testkit_skip

  !> Prints the summary and ends the program, with exit code 1 if a check failed.
  subroutine testkit_finish(self)
    class(testkit_t), intent(inout) :: self
    if (self%world%is_root) write (output_unit, '(i0,a,i0,a)') self%n_checks - self%n_failed, ' passed, ', &
      self%n_failed, ' failed'
    flush (output_unit)
    if (self%parallel) call self%world%stop()
    if (self%n_failed > 0) stop 1
  end subroutine testkit_finish
end module testkit
