! SPDX-License-Identifier: GPL-3.0-or-later
!> A beam one of whose loads may snap to another shape: for tests of refits and intervals.
!>
!> It snaps where the point goes too far at once from where the solver stands, and then stays snapped however the point moves:
!> two equilibria of which a solver finds that beside which it begins. And it snaps behind a fold, where there is only one.
module snapping_beam
  use base_kinds, only: rp
  use diagnosis_beam, only: beam_t
  use inference_simulator, only: N_SLOTS, slot_of
  implicit none
  private
  public :: snapping_t

  real(rp), parameter :: HEIGHT = 3.0_rp !< of the other shape over that of the model, in sd of the noise

  type :: place_t
    logical :: is_snapped = .false., is_known = .false.
    real(rp) :: x = 0                      !< of the quantity that decides
  end type place_t

  type, extends(beam_t) :: snapping_t
    integer :: surface = 5, column = 1     !< that snaps, quantity that decides
    real(rp) :: farthest = huge(1.0_rp)    !< step at which it does not snap
    real(rp) :: fold = huge(1.0_rp)        !< it has the other shape above
    type(place_t) :: here, tried, kept(0:N_SLOTS + 20)
  contains
    procedure :: evaluate => snapping_evaluate
    procedure :: accept => snapping_accept
    procedure :: keep => snapping_keep
    procedure :: recall => snapping_recall
  end type snapping_t

contains

  subroutine snapping_evaluate(self, q, columns, residuals, jacobian, is_valid)
    class(snapping_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    call self%beam_t%evaluate(q, columns, residuals, jacobian, is_valid)
    self%tried = place_t(self%here%is_snapped, .true., q(self%column))
    associate (x => self%tried%x)
      if (self%here%is_known .and. abs(x - self%here%x) > self%farthest) self%tried%is_snapped = .true.
      if (x > self%fold) self%tried%is_snapped = .true.
    end associate
    if (.not. self%tried%is_snapped) return
    ! Not a tilt or a piston, which are nuisances.
    where (self%labels%surface == self%surface)
      residuals = residuals + HEIGHT*self%sigma*sin(20*self%labels%place(1, :))
    end where
  end subroutine snapping_evaluate

  subroutine snapping_accept(self)
    class(snapping_t), intent(inout) :: self
    self%here = self%tried
  end subroutine snapping_accept

  subroutine snapping_keep(self, slot)
    class(snapping_t), intent(inout) :: self
    integer, intent(in), optional :: slot
    self%kept(slot_of(slot)) = self%here
  end subroutine snapping_keep

  subroutine snapping_recall(self, slot, only_shapes)
    class(snapping_t), intent(inout) :: self
    integer, intent(in), optional :: slot
    logical, intent(in), optional :: only_shapes
    if (present(only_shapes)) call self%beam_t%recall(slot, only_shapes)
    self%here = self%kept(slot_of(slot))
  end subroutine snapping_recall
end module snapping_beam
