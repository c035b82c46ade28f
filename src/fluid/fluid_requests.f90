! SPDX-License-Identifier: GPL-3.0-or-later
!> A request lists what a pass over the right-hand side computes in addition to the right-hand side: sums, fields, pressure.
module fluid_requests
  use base_kinds, only: rp
  implicit none
  private
  public :: request_t, PASS_EVALUATE, PASS_AB2, PASS_RK_FIRST, PASS_RK_SECOND, PASS_RK_THIRD, PASS_RK_FOURTH, &
            PASS_HEUN_FIRST, PASS_HEUN_SECOND, pass_begin, pass_end

  integer, parameter :: PASS_EVALUATE = 0  !< compute, change nothing
  integer, parameter :: PASS_AB2 = 1       !< advance by Adams-Bashforth, or by Euler's step
  integer, parameter :: PASS_RK_FIRST = 2, PASS_RK_SECOND = 3, PASS_RK_THIRD = 4, PASS_RK_FOURTH = 5
  integer, parameter :: PASS_HEUN_FIRST = 6, PASS_HEUN_SECOND = 7

  !> What a pass computes in addition, for the state at the beginning of the step.
  type :: request_t
    logical :: integrals = .false. !< volume integrals and the largest divergence
    logical :: fields = .false.    !< keep velocity and vorticity in physical space
    logical :: flow = .false.      !< keep the spectrum of the velocity, from which these fields can be computed one at a time
    logical :: pressure = .false.  !< keep the pressure (fluid_pressure)
    logical :: rhs = .false.       !< keep the right-hand side of an evaluation, for a step that begins there
  contains
    procedure :: covers => request_covers
  end type request_t

contains

  !> Returns the time at which a pass evaluates the right-hand side, counted from the beginning of its step, in steps.
  pure real(rp) function pass_begin(pass) result(part)
    integer, intent(in) :: pass
    part = 0
    if (any(pass == [PASS_RK_SECOND, PASS_RK_THIRD])) part = 0.5_rp
    if (any(pass == [PASS_RK_FOURTH, PASS_HEUN_SECOND])) part = 1
  end function pass_begin

  !> Returns the time that the state has after a pass, counted from the beginning of its step, in steps.
  pure real(rp) function pass_end(pass) result(part)
    integer, intent(in) :: pass
    part = 1
    if (any(pass == [PASS_RK_FIRST, PASS_RK_SECOND])) part = 0.5_rp
  end function pass_end

  !> Tells whether a pass that did what `self` asks for also did what `other` asks for.
  pure logical function request_covers(self, other) result(covers)
    class(request_t), intent(in) :: self
    type(request_t), intent(in) :: other
    covers = (self%integrals .or. .not. other%integrals) .and. (self%fields .or. .not. other%fields) .and. &
             (self%flow .or. .not. other%flow) .and. &
             (self%pressure .or. .not. other%pressure) .and. (self%rhs .or. .not. other%rhs)
  end function request_covers
end module fluid_requests
