! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the words for hinges whose stiffness depends on how far they are bent. All effects of hardening share them.
module solid_hardening_words
  use base_cause, only: cause_parameter_t
  use base_kinds, only: rp
  use base_wording, only: word_factor, wording_t, DEGREES, SCALE_LINEAR
  implicit none
  private
  public :: word_hardening, word_joint

contains

  !> Gives `w` the words of a hardening with the value v, by which the stiffness is 1 + `factor` v times that without bending. `up`
  !> and `down` say where that is.
  pure subroutine word_hardening(w, up, down, factor)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: up, down
    real(rp), intent(in) :: factor
    call word_factor(w, SCALE_LINEAR, up, down, 'stiffer', 'softer', 'than when straight', 'as stiff as when straight', 0.0_rp)
    w%factor = factor
  end subroutine word_hardening

  !> Gives a hardening of joints [1/rad^2] its words: how stiff they are at 10 degrees and, if the value is large, at 1 degree.
  pure subroutine word_joint(one, up, down)
    type(cause_parameter_t), intent(inout) :: one
    character(*), intent(in) :: up, down
    real(rp), parameter :: STRONG = 100.0_rp ! [1/rad^2] from this value on, reports give the stiffness at 1 degree
    call word_hardening(one%words, up//' at 10 degrees', down//' at 10 degrees', (10/DEGREES)**2)
    call word_hardening(one%beyond, up//' at 1 degree', down//' at 1 degree', (1/DEGREES)**2)
    one%far = STRONG
  end subroutine word_joint
end module solid_hardening_words
