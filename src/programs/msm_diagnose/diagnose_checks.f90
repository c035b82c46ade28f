! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes the checks of the residuals of a fit to NAME.json.
module diagnose_checks
  use diagnose_summary, only: alarm_of
  use inference_engine, only: diagnosis_t
  use inference_residual_checks, only: residual_check_t
  use io_json, only: json_t
  implicit none
  private
  public :: alarm_name, put_checks

contains

  !> Returns the name of the check that speaks against the baseline. It is empty if none does.
  function alarm_name(d) result(name)
    type(diagnosis_t), intent(in) :: d
    character(:), allocatable :: name
    name = ''
    if (alarm_of(d) > 0) name = d%tests%checks(alarm_of(d))%name
  end function alarm_name

  !> Adds to the open object of `json` the member `name`, which lists the checks of the residuals and their results.
  subroutine put_checks(json, name, checks)
    type(json_t), intent(inout) :: json
    character(*), intent(in) :: name
    type(residual_check_t), intent(in) :: checks(:)
    integer :: i
    call json%open_list(name)
    do i = 1, size(checks)
      call json%open_object('')
      call json%put('name', checks(i)%name)
      call json%put('statistic', checks(i)%statistic)
      call json%put('p', checks(i)%p())
      call json%put('log_p', checks(i)%log_p)
      call json%put('takes_part', checks(i)%takes_part)
      if (any(checks(i)%interval > 0)) call json%put('interval_90', checks(i)%interval)
      call json%put('sentence', checks(i)%sentence)
      call json%close()
    end do
    call json%close()
  end subroutine put_checks
end module diagnose_checks
