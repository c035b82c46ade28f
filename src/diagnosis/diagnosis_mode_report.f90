! SPDX-License-Identifier: GPL-3.0-or-later
!> Compares the measured natural modes with those of the baseline and of the extended wing, for reports.
module diagnosis_mode_report
  use base_kinds, only: rp
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_wing_simulator, only: wing_simulator_t
  use inference_engine, only: diagnosis_t
  implicit none
  private
  public :: describe_modes

contains

  !> Makes s%modes, one row for each measured mode. On rank 0.
  subroutine describe_modes(s, simulator, d)
    class(diagnosis_case_t), intent(inout) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(in) :: d
    real(rp) :: residuals(simulator%motion%modes%n)
    logical :: ok
    integer :: side, i
    if (s%measurement%count_modes() == 0) return
    allocate (s%modes(s%measurement%count_modes()))
    do side = 1, 2
      if (side == 1 .or. .not. d%extended%is_found) then
        call simulator%motion%modes%evaluate(d%initial_baseline%q, residuals, ok)
      else
        call simulator%motion%modes%evaluate(d%extended%q, residuals, ok)
      end if
      if (.not. ok) cycle
      do i = 1, size(s%modes)
        associate (t => simulator%motion%modes%simulation%targets(i))
          s%modes(i)%number(side) = t%lo
          s%modes(i)%frequency(side) = t%frequency
          s%modes(i)%mac(side) = t%mac
          if (t%damping%is_measured) s%modes(i)%damping(side) = t%damping%decay%ratio
          if (side == 1) allocate (s%modes(i)%shape(size(t%seen), 2), source=0.0_rp)
          s%modes(i)%shape(:, side) = t%seen
        end associate
      end do
    end do
  end subroutine describe_modes
end module diagnosis_mode_report
