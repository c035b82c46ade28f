! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads FLUSI's kinematics files of before 2015: numbers in a fixed order, without names.
!>
!>     n_phi  n_alpha  n_theta
!>     [a0_phi]    ai_phi (n_phi)      bi_phi (n_phi)       and likewise alpha, theta
!>
!> With a0 these are Fourier coefficients, without it values and slopes of Hermite's interpolation; the count of the numbers
!> distinguishes the two. Degrees, one cycle of period 1, FLUSI's signs (see fsi_wing_motion_file). Comments begin with % # ! or ;.
module fsi_wing_motion_list
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: BLANKS, count_words, number_text, parse_reals
  use fsi_wing_motion, only: wing_motion_t
  use fsi_wing_motion_series, only: angle_series_t
  implicit none
  private
  public :: read_motion_list

  character(*), parameter :: SEPARATORS = BLANKS//','//achar(10)//achar(13)
  real(rp), parameter :: MOST_COEFFICIENTS = 1.0e5_rp

contains

  !> Fills the three series of `motion` from `text`, the content of the file called `name`. After a mistake, which is added to
  !> `errors`, the motion is unchanged.
  subroutine read_motion_list(text, name, motion, errors)
    character(*), intent(in) :: text, name
    type(wing_motion_t), intent(inout) :: motion
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: content, problem
    real(rp), allocatable :: x(:)
    integer :: n(3), total, last
    logical :: is_hermite
    content = without_comments(text)
    allocate (x(count_words(content, SEPARATORS)))
    call parse_reals(content, SEPARATORS, x, problem)
    if (.not. allocated(problem)) then
      if (size(x) < 3) then
        problem = 'ends before the three numbers of coefficients'
      else if (any(x(:3) < 0 .or. x(:3) > MOST_COEFFICIENTS .or. abs(x(:3) - anint(x(:3))) > 0)) then
        problem = 'does not begin with three numbers of coefficients'
      end if
    end if
    if (allocated(problem)) then
      call errors%add(name//': has no section [kinematics], and as a file of before 2015 '//problem//' (docs/guide/kinematics.md)')
      return
    end if
    n = nint(x(:3))
    total = 3 + 2*sum(n)
    is_hermite = size(x) == total .and. all(n > 0)
    if (.not. is_hermite .and. size(x) /= total + 3) then
      call errors%add(name//': has no section [kinematics], and as a file of before 2015 it has '//number_text(size(x))// &
                      ' numbers; valid: '//number_text(total + 3)//' for Fourier, '//number_text(total)// &
                      ' for Hermite series of '//number_text(n(1))//', '//number_text(n(2))//' and '//number_text(n(3))// &
                      ' coefficients')
      return
    end if
    last = 3
    call take(motion%phi, n(1))
    call take(motion%alpha, n(2))
    call take(motion%theta, n(3))
  contains

    !> Sets the series of one angle from the next numbers of the list.
    subroutine take(series, n)
      type(angle_series_t), intent(inout) :: series
      integer, intent(in) :: n
      real(rp) :: a0
      a0 = 0
      if (.not. is_hermite) then
        last = last + 1
        a0 = x(last)*PI/180
      end if
      associate (a => x(last + 1:last + n)*PI/180, b => x(last + n + 1:last + 2*n)*PI/180)
        if (is_hermite) then
          call series%set_hermite(a, b)
        else if (n == 0) then
          call series%set_constant(a0/2)
        else
          call series%set_fourier(a0, a, b)
        end if
      end associate
      last = last + 2*n
    end subroutine take
  end subroutine read_motion_list

  !> Returns `text` with blanks in place of comments.
  pure function without_comments(text) result(content)
    character(*), intent(in) :: text
    character(len(text)) :: content
    logical :: is_comment
    integer :: i
    is_comment = .false.
    do i = 1, len(text)
      if (index('%#!;', text(i:i)) > 0) is_comment = .true.
      if (text(i:i) == achar(10)) is_comment = .false.
      content(i:i) = merge(' ', text(i:i), is_comment)
    end do
  end function without_comments
end module fsi_wing_motion_list
