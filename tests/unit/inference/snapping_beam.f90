! SPDX-License-Identifier: GPL-3.0-or-later
!> A beam one of whose loads may snap to another shape: for tests of refits and intervals.
!>
!> It snaps where the point goes too far at once from where the solver stands, and then stays snapped however the point moves:
!> two equilibria of which a solver finds that beside which it begins. And it snaps behind a fold, where there is only one.
module snapping_beam
  use base_kinds, only: rp
  use diagnosis_beam, only: beam_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: site_t, snapping_t

  real(rp), parameter :: HEIGHT = 3.0_rp !< of the other shape over that of the model, in sd of the noise

  type, extends(solver_state_t) :: site_t
    logical :: is_snapped = .false., is_known = .false.
    real(rp) :: x = 0                      !< of the parameter that decides
  end type site_t

  type, extends(beam_t) :: snapping_t
    integer :: surface = 5, column = 1     !< that snaps, parameter that decides
    real(rp) :: farthest = huge(1.0_rp)    !< step at which it does not snap
    real(rp) :: fold = huge(1.0_rp)        !< it has the other shape above
    type(site_t) :: here, tried
  contains
    procedure :: evaluate => snapping_evaluate
    procedure :: accept => snapping_accept
    procedure :: get_state => snapping_get_state
    procedure :: set_state => snapping_set_state
  end type snapping_t

contains

  subroutine snapping_evaluate(self, q, columns, residuals, jacobian, is_valid)
    class(snapping_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    call self%beam_t%evaluate(q, columns, residuals, jacobian, is_valid)
    self%tried = site_t(is_snapped=self%here%is_snapped, is_known=.true., x=q(self%column))
    associate (x => self%tried%x)
      if (self%here%is_known .and. abs(x - self%here%x) > self%farthest) self%tried%is_snapped = .true.
      if (x > self%fold) self%tried%is_snapped = .true.
    end associate
    if (.not. self%tried%is_snapped) return
    ! Not a tilt or a piston, which are nuisances.
    where (self%labels%surface == self%surface)
      residuals = residuals + HEIGHT*self%sigma*sin(20*self%labels%site(1, :))
    end where
  end subroutine snapping_evaluate

  subroutine snapping_accept(self)
    class(snapping_t), intent(inout) :: self
    self%here = self%tried
  end subroutine snapping_accept

  subroutine snapping_get_state(self, state)
    class(snapping_t), intent(in) :: self
    class(solver_state_t), allocatable, intent(out) :: state
    allocate (state, source=self%here)
  end subroutine snapping_get_state

  subroutine snapping_set_state(self, state, only_shapes)
    class(snapping_t), intent(inout) :: self
    class(solver_state_t), intent(in) :: state
    logical, intent(in), optional :: only_shapes
    if (present(only_shapes)) call self%beam_t%set_state(state, only_shapes)
    select type (state)
    type is (site_t)
      self%here = state
    end select
  end subroutine snapping_set_state
end module snapping_beam
