! SPDX-License-Identifier: GPL-3.0-or-later
!> Reports the damping of a wing that rings: the section with which flusi runs it.
module diagnose_series
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_wing_rest, only: damping_at
  use solid_damping_effects, only: damping_effects_t
  implicit none
  private
  public :: damping_lines

contains

  !> Returns the section [Damping] of a wing at q; nothing without records of motion.
  function damping_lines(s, q) result(text)
    type(diagnose_settings_t), intent(in) :: s
    real(rp), intent(in) :: q(:)
    character(:), allocatable :: text
    character(*), parameter :: NL = new_line('a')
    type(damping_effects_t) :: damping
    text = ''
    if (s%measurement%count_series() == 0) return
    damping = damping_at(s%catalogue%parameters, q)
    text = NL//'[Damping]'//NL//'rayleigh_mass = '//number_text(damping%mass)//'; 1/s, still air among it'//NL
    if (abs(damping%stiffness) > 0) text = text//'rayleigh_stiffness = '//number_text(damping%stiffness)//'; s'//NL
    if (abs(damping%joints) > 0) &
      text = text//'; flusi has no friction of joints: '//number_text(damping%joints)//' s'//NL
    if (abs(damping%relaxation) > 0) &
      text = text//'relaxation = '//number_text(damping%relaxation)//';'//NL//'relaxation_time = '// &
             number_text(damping%relaxation_time)//'; s'//NL
  end function damping_lines
end module diagnose_series
