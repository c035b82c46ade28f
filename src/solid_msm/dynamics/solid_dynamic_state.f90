! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the state of a moving wing at one time.
module solid_dynamic_state
  use base_kinds, only: rp
  use base_visitor, only: visited_t, visitor_t
  use solid_model, only: solid_model_t
  implicit none
  private
  public :: copy_state, dynamic_state_t, step_ratio

  !> Data that a restart needs. All arrays are (3, n_all).
  type, extends(visited_t) :: dynamic_state_t
    real(rp) :: time = 0                                    !< [s]
    real(rp) :: old_step = 0                                !< [s] size of the last step; 0: none yet
    real(rp), dimension(:, :), allocatable :: u, v          !< [m], [m/s] now, in the wing frame
    real(rp), dimension(:, :), allocatable :: old_u, old_v  !< one step before
    real(rp), dimension(:, :), allocatable :: g, old_g      !< [N] elastic, and viscoelastic, forces of both times
    real(rp), dimension(:, :), allocatable :: a             !< [m/s^2] rate of v in the wing frame, of order 2
  contains
    procedure :: init => state_init
    procedure :: visit => state_visit
  end type dynamic_state_t

contains

  !> Makes the state of a wing at `time` [s]: at u [m] and v [m/s], both (3, n_all), if they are given; otherwise unloaded and at
  !> rest in its frame. The state has no previous step.
  subroutine state_init(self, model, time, u, v)
    class(dynamic_state_t), intent(out) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: time
    real(rp), intent(in), optional :: u(:, :), v(:, :)
    integer :: n
    n = model%n_all
    self%time = time
    allocate (self%u(3, n), self%v(3, n), self%g(3, n), source=0.0_rp)
    if (present(u)) self%u(:, :) = u
    if (present(v)) self%v(:, :) = v
    call model%zero_clamped(self%u)
    call model%zero_clamped(self%v)
    call model%gradient(self%u, self%g)
    allocate (self%old_u(3, n), self%old_v(3, n), self%old_g(3, n), self%a(3, n), source=0.0_rp)
  end subroutine state_init

  !> Shows every component to the visitor; all arrays have their size.
  subroutine state_visit(self, visitor)
    class(dynamic_state_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('time', self%time)
    call visitor%visit('old_step', self%old_step)
    call visitor%visit('u', self%u)
    call visitor%visit('v', self%v)
    call visitor%visit('g', self%g)
    call visitor%visit('old_u', self%old_u)
    call visitor%visit('old_v', self%old_v)
    call visitor%visit('old_g', self%old_g)
    call visitor%visit('a', self%a)
  end subroutine state_visit

  !> Returns the ratio of the step h [s] from this state to the one that led to it, for BDF2. It is 0 if implicit Euler makes the
  !> step: the first one, and one so long that BDF2 would not be stable.
  pure real(rp) function step_ratio(state, h) result(r)
    type(dynamic_state_t), intent(in) :: state
    real(rp), intent(in) :: h
    real(rp), parameter :: LARGEST_RATIO = 2.4_rp ! variable-step BDF2 is stable below 1 + sqrt 2
    r = 0
    if (state%old_step > 0) r = h/state%old_step
    if (r > LARGEST_RATIO) r = 0
  end function step_ratio

  !> Copies a state to another one of the same wing. Allocates nothing.
  subroutine copy_state(from, to)
    type(dynamic_state_t), intent(in) :: from
    type(dynamic_state_t), intent(inout) :: to
    to%time = from%time
    to%old_step = from%old_step
    to%u = from%u
    to%v = from%v
    to%old_u = from%old_u
    to%old_v = from%old_v
    to%g = from%g
    to%old_g = from%old_g
    to%a = from%a
  end subroutine copy_state
end module solid_dynamic_state
