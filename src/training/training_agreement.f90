! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes in sentences where the starts of a polish ended: at the same point, in a higher minimum, or at another point that
!> fits as well.
module training_agreement
  use base_kinds, only: rp
  use base_text, only: number_text
  use least_squares_profile, only: THRESHOLD_90
  implicit none
  private
  public :: agreement_lines

  integer, parameter, public :: AGREEMENT_LENGTH = 160
  real(rp), parameter :: APART = 0.5_rp !< [sd] points that differ by more in some parameter are two minima

contains

  !> Returns one line for every start that ended away from the best point and, if at least two starts ended there, one line with
  !> their number. The best point has coordinates best(n) and the sum of squares chi2; sd(n) are the standard deviations of its
  !> parameters `names`. local_minima(1 + n, starts) holds chi^2 and the coordinates where each start ended. A minimum fits as well
  !> as the best one if its chi^2 lies within the threshold of the 90 % interval.
  function agreement_lines(names, best, chi2, sd, local_minima) result(lines)
    character(*), intent(in) :: names(:)
    real(rp), intent(in) :: best(:), chi2, sd(:), local_minima(:, :)
    character(AGREEMENT_LENGTH), allocatable :: lines(:)
    character(AGREEMENT_LENGTH) :: line
    real(rp) :: distance(size(best))
    integer :: i, k, n_same
    allocate (lines(0))
    n_same = 0
    do i = 1, size(local_minima, 2)
      distance = abs(local_minima(2:, i) - best)/max(sd, tiny(1.0_rp))
      if (maxval(distance) <= APART) then
        n_same = n_same + 1
        cycle
      end if
      k = maxloc(distance, 1)
      if (local_minima(1, i) <= chi2 + THRESHOLD_90) then
        write (line, '(a,f0.1,a)') 'warning   another start ends in an equally good fit, ', distance(k), &
          ' sd away in '//trim(names(k))//': the data cannot distinguish the two wings'
      else
        write (line, '(a,es11.4,a,es11.4,a)') 'polish    another start ends in a higher minimum: '// &
          'chi^2 =', local_minima(1, i), ' instead of', chi2, '; most different is '//trim(names(k))
      end if
      lines = [lines, line]
    end do
    if (n_same < 2) return
    line = 'polish    '//number_text(n_same)//' of '//number_text(size(local_minima, 2))//' starts end at this point'
    lines = [lines, line]
  end function agreement_lines
end module training_agreement
