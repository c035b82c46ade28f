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
  contains
    procedure :: evaluate => snapping_evaluate
    procedure :: initial_state => snapping_initial_state
  end type snapping_t

contains

  subroutine snapping_evaluate(self, q, columns, from, residuals, jacobian, is_valid, to, is_wanted)
    class(snapping_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out), optional :: to
    logical, intent(in), optional :: is_wanted(:)
    type(site_t) :: site
    call self%beam_t%evaluate(q, columns, from, residuals, jacobian, is_valid, is_wanted=is_wanted)
    select type (from)
    type is (site_t)
      site = site_t(is_snapped=from%is_snapped, is_known=.true., x=q(self%column))
      if (from%is_known .and. abs(site%x - from%x) > self%farthest) site%is_snapped = .true.
    end select
    if (site%x > self%fold) site%is_snapped = .true.
    if (present(to)) allocate (to, source=site)
    if (.not. site%is_snapped) return
    ! Not a tilt or a piston, which are nuisances.
    where (self%labels%surface == self%surface)
      residuals = residuals + HEIGHT*self%sigma*sin(20*self%labels%site(1, :))
    end where
  end subroutine snapping_evaluate

  !> Nowhere yet.
  subroutine snapping_initial_state(self, state)
    class(snapping_t), intent(in) :: self
    class(solver_state_t), allocatable, intent(out) :: state
    associate (unused => self)
    end associate
    allocate (state, source=site_t())
  end subroutine snapping_initial_state
end module snapping_beam
