! SPDX-License-Identifier: GPL-3.0-or-later
!> Wraps FFTW3 for this project: batches of one-dimensional transforms on buffers that FFTW itself allocated, so that they always
!> have the alignment for which a plan was made.
module spectral_fftw
  use, intrinsic :: iso_c_binding, only: c_int, c_ptr, c_size_t, c_double, c_double_complex, c_f_pointer, &
                                                    c_null_ptr, c_associated, c_char, c_int32_t, c_intptr_t, c_funptr, &
                                                                            c_float, c_float_complex, c_null_char
  use base_kinds, only: rp
  use base_memory, only: check_allocation, COMPLEX_BYTES, REAL_BYTES
  use base_named_kinds, only: named_kind_t
  implicit none
  private
  public :: alloc_complex, alloc_real, free_buffer, plan_lines, plan_columns, plan_c2r, plan_r2c, &
            execute_complex, execute_c2r, execute_r2c, free_plan, plan_t, effort_flag, PLANNERS, &
            export_wisdom, import_wisdom, wisdom_text, learn_wisdom, forget_wisdom

  include 'fftw3.f03'

  integer, parameter, public :: PLAN_ESTIMATE = 1 !< results repeat to the last bit
  integer, parameter, public :: PLAN_MEASURE = 2  !< fast
  integer, parameter, public :: PLAN_AUTO = 3     !< the program has to choose one of both
  type(named_kind_t), parameter :: PLANNERS(3) = [named_kind_t('auto', PLAN_AUTO), named_kind_t('estimate', PLAN_ESTIMATE), &
                                                  named_kind_t('measure', PLAN_MEASURE)]

  interface
    pure function c_strlen(text) result(length) bind(c, name='strlen')
      import :: c_ptr, c_size_t
      type(c_ptr), value, intent(in) :: text
      integer(c_size_t) :: length
    end function c_strlen

    subroutine c_free(memory) bind(c, name='free')
      import :: c_ptr
      type(c_ptr), value :: memory
    end subroutine c_free
  end interface

  !> Handle of an FFTW plan.
  type :: plan_t
    private
    type(c_ptr) :: handle = c_null_ptr
  end type plan_t

contains

  !> Returns FFTW's planning flag for PLAN_MEASURE or PLAN_ESTIMATE.
  pure integer(c_int) function effort_flag(effort) result(flag)
    integer, intent(in) :: effort
    flag = merge(FFTW_MEASURE, FFTW_ESTIMATE, effort == PLAN_MEASURE)
  end function effort_flag

  !> Allocates `n` complex numbers (at least one), aligned for SIMD; free with `free_buffer`.
  subroutine alloc_complex(n, handle, array)
    integer(c_size_t), intent(in) :: n
    type(c_ptr), intent(out) :: handle
    complex(rp), pointer, contiguous, intent(out) :: array(:)
    handle = fftw_alloc_complex(max(n, 1_c_size_t))
    call check_allocation(merge(0, 1, c_associated(handle)), [int(n)], COMPLEX_BYTES, 'a buffer of the transforms')
    call c_f_pointer(handle, array, [max(n, 1_c_size_t)])
    array = 0
  end subroutine alloc_complex

  !> Allocates `n` real numbers (at least one), aligned for SIMD; free with `free_buffer`.
  subroutine alloc_real(n, handle, array)
    integer(c_size_t), intent(in) :: n
    type(c_ptr), intent(out) :: handle
    real(rp), pointer, contiguous, intent(out) :: array(:)
    handle = fftw_alloc_real(max(n, 1_c_size_t))
    call check_allocation(merge(0, 1, c_associated(handle)), [int(n)], REAL_BYTES, 'a buffer of the transforms')
    call c_f_pointer(handle, array, [max(n, 1_c_size_t)])
    array = 0
  end subroutine alloc_real

  !> Releases a buffer of `alloc_complex` or `alloc_real`.
  subroutine free_buffer(handle)
    type(c_ptr), intent(inout) :: handle
    if (c_associated(handle)) call fftw_free(handle)
    handle = c_null_ptr
  end subroutine free_buffer

  !> Plans in-place complex transforms of `howmany` contiguous lines of length `n`.
  subroutine plan_lines(plan, n, howmany, work, sign, flag)
    type(plan_t), intent(out) :: plan
    integer, intent(in) :: n, howmany
    complex(rp), contiguous, target, intent(inout) :: work(:)
    integer, intent(in) :: sign !< +1 backward (to physical space), -1 forward
    integer(c_int), intent(in) :: flag
    complex(rp), pointer, contiguous :: same(:) !< FFTW transforms in place if input and output coincide
    integer(c_int) :: length(1)
    same => work
    length(1) = n
    plan%handle = fftw_plan_many_dft(1_c_int, length, howmany, work, length, 1_c_int, n, same, length, &
                                     1_c_int, n, merge(FFTW_BACKWARD, FFTW_FORWARD, sign > 0), flag)
  end subroutine plan_lines

  !> Plans in-place complex transforms of length `n` along the second index of an array (width, n).
  subroutine plan_columns(plan, width, n, work, sign, flag)
    type(plan_t), intent(out) :: plan
    integer, intent(in) :: width, n
    complex(rp), contiguous, target, intent(inout) :: work(:)
    integer, intent(in) :: sign
    integer(c_int), intent(in) :: flag
    complex(rp), pointer, contiguous :: same(:) !< FFTW transforms in place if input and output coincide
    integer(c_int) :: length(1)
    same => work
    if (width == 0) return
    length(1) = n
    plan%handle = fftw_plan_many_dft(1_c_int, length, width, work, length, width, 1_c_int, same, length, &
                                     width, 1_c_int, merge(FFTW_BACKWARD, FFTW_FORWARD, sign > 0), flag)
  end subroutine plan_columns

  !> Plans complex-to-real transforms of `howmany` lines (n/2+1 complex in, n real out). A transform destroys its input.
  subroutine plan_c2r(plan, n, howmany, in, out, flag)
    type(plan_t), intent(out) :: plan
    integer, intent(in) :: n, howmany
    complex(rp), contiguous, intent(inout) :: in(:)
    real(rp), contiguous, intent(inout) :: out(:)
    integer(c_int), intent(in) :: flag
    integer(c_int) :: length(1), half(1)
    length(1) = n
    half(1) = n/2 + 1
    plan%handle = fftw_plan_many_dft_c2r(1_c_int, length, howmany, in, half, 1_c_int, half(1), out, length, &
                                         1_c_int, n, flag)
  end subroutine plan_c2r

  !> Plans real-to-complex transforms of `howmany` lines (n real in, n/2+1 complex out).
  subroutine plan_r2c(plan, n, howmany, in, out, flag)
    type(plan_t), intent(out) :: plan
    integer, intent(in) :: n, howmany
    real(rp), contiguous, intent(inout) :: in(:)
    complex(rp), contiguous, intent(inout) :: out(:)
    integer(c_int), intent(in) :: flag
    integer(c_int) :: length(1), half(1)
    length(1) = n
    half(1) = n/2 + 1
    plan%handle = fftw_plan_many_dft_r2c(1_c_int, length, howmany, in, length, 1_c_int, n, out, half, &
                                         1_c_int, half(1), flag)
  end subroutine plan_r2c

  !> Runs an in-place complex plan on a buffer of its size, aligned to 16 bytes.
  subroutine execute_complex(plan, work)
    type(plan_t), intent(in) :: plan
    complex(rp), contiguous, target, intent(inout) :: work(:)
    complex(rp), pointer, contiguous :: same(:)
    same => work
    if (c_associated(plan%handle)) call fftw_execute_dft(plan%handle, work, same)
  end subroutine execute_complex

  !> Runs a complex-to-real plan; the lines of `out` lie one behind the other.
  subroutine execute_c2r(plan, in, out)
    type(plan_t), intent(in) :: plan
    complex(rp), contiguous, intent(inout) :: in(:)
    real(rp), contiguous, intent(inout) :: out(:, :)
    call fftw_execute_dft_c2r(plan%handle, in, out)
  end subroutine execute_c2r

  !> Runs a real-to-complex plan; the lines of `in` lie one behind the other.
  subroutine execute_r2c(plan, in, out)
    type(plan_t), intent(in) :: plan
    real(rp), contiguous, intent(inout) :: in(:, :)
    complex(rp), contiguous, intent(inout) :: out(:)
    call fftw_execute_dft_r2c(plan%handle, in, out)
  end subroutine execute_r2c

  !> Releases a plan.
  subroutine free_plan(plan)
    type(plan_t), intent(inout) :: plan
    if (c_associated(plan%handle)) call fftw_destroy_plan(plan%handle)
    plan%handle = c_null_ptr
  end subroutine free_plan

  !> Writes the wisdom of the planner to `path`; `done` tells whether that was possible.
  subroutine export_wisdom(path, done)
    character(*), intent(in) :: path
    logical, intent(out) :: done
    done = fftw_export_wisdom_to_filename(path//c_null_char) == 1
  end subroutine export_wisdom

  !> Reads the wisdom of the planner from `path`, if the file exists and was made by this FFTW.
  subroutine import_wisdom(path, done)
    character(*), intent(in) :: path
    logical, intent(out) :: done
    done = fftw_import_wisdom_from_filename(path//c_null_char) == 1
  end subroutine import_wisdom

  !> Returns the wisdom of the planner of this process as text.
  function wisdom_text() result(text)
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    type(c_ptr) :: memory
    integer :: i
    memory = fftw_export_wisdom_to_string()
    call c_f_pointer(memory, letters, [c_strlen(memory)])
    allocate (character(size(letters)) :: text)
    do i = 1, size(letters)
      text(i:i) = letters(i)
    end do
    call c_free(memory)
  end function wisdom_text

  !> Adds the wisdom of the planner of another process.
  subroutine learn_wisdom(text)
    character(*), intent(in) :: text
    integer(c_int) :: understood
    understood = fftw_import_wisdom_from_string(text//c_null_char)
    if (understood /= 1) return ! in this case this process makes its own plans
  end subroutine learn_wisdom

  !> Discards the wisdom of the planner of this process.
  subroutine forget_wisdom()
    call fftw_forget_wisdom()
  end subroutine forget_wisdom
end module spectral_fftw
