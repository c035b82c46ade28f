! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes a run without a flow, as FLUSI's dry run does: it draws the mask, the velocity of the solids and the surfaces of the
!> wings every tsave.
module simulation_mask_run
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use simulation_output, only: output_t
  use simulation_settings, only: settings_t
  implicit none
  private
  public :: draw_masks

contains

  !> Writes the output that [Saving] asks for at 0, tsave, 2 tsave, ... up to Tmax. Stops at the first failure. Collective.
  subroutine draw_masks(settings, fluid, output, failure, wings)
    type(settings_t), intent(in) :: settings
    type(fluid_t), intent(inout) :: fluid
    type(output_t), intent(inout) :: output
    type(failure_t), intent(inout) :: failure
    type(flapping_wings_t), intent(inout), optional :: wings
    integer :: k
    associate (state => fluid%rhs%state, p => settings%output)
      do k = 0, int(settings%fluid%time%t_max/p%fields%interval + 1.0e-9_rp)
        if (k >= settings%fluid%time%nt .or. failure%failed) exit
        state%time = k*p%fields%interval
        state%step = k + 1 ! the output belongs to the previous step
        fluid%sums_time = state%time
        if (present(wings)) call wings%place(state%time, fluid%rhs%penalty, failure)
        output%fields_due = .not. failure%failed .and. state%time >= p%fields%first
        call output%write(fluid, failure, wings)
      end do
    end associate
  end subroutine draw_masks
end module simulation_mask_run
