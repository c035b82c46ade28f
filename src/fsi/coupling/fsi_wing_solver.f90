! SPDX-License-Identifier: GPL-3.0-or-later
!> Advances one flexible wing. One rank solves it, and all ranks get its state; a step can be repeated under another load. All
!> vectors are along the axes of the wing file.
module fsi_wing_solver
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fsi_wing_frame, only: flapping_motion_t
  use parallel_world, only: world_t
  use solid_dynamics, only: copy_state, dynamic_options_t, dynamic_state_t, dynamics_t, step_report_t
  use solid_inertia, only: inertia_t
  use solid_model, only: solid_model_t
  use solid_reaction, only: reaction_t
  implicit none
  private
  public :: wing_solver_t

  !> Work space. Nothing is allocated after `init`.
  type :: wing_solver_t
    type(flapping_motion_t) :: motion
    type(step_report_t) :: report                 !< of the last step, on the owner
    integer :: factorisations = 0                 !< of the last step, with all its repetitions, on all ranks
    integer :: owner = 0                          !< rank that solves the wing
    type(dynamic_state_t), private :: begun       !< at the beginning of the step
    type(dynamics_t), private :: stepper
    logical, private :: is_mine = .false.         !< this rank is the owner
    logical, private :: is_repeated = .false.     !< the step has been solved under another load
    real(rp), allocatable, private :: guess(:, :), packed(:)
  contains
    procedure :: init => solver_init
    procedure :: begin => solver_begin
    procedure :: solve => solver_solve
    procedure :: broadcast => solver_broadcast
    procedure :: rewind => solver_rewind
    procedure :: free => solver_free
  end type wing_solver_t

contains

  !> Allocates the work space and, on the owner, analyses the pattern of the matrices. The caller sets `motion`.
  subroutine solver_init(self, world, model, owner)
    class(wing_solver_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(solid_model_t), intent(in) :: model
    integer, intent(in) :: owner
    self%owner = owner
    self%is_mine = owner == world%rank
    if (self%is_mine) then
      call self%stepper%init(model)
      call self%begun%init(model, 0.0_rp)
    end if
    allocate (self%guess(3, model%n_all), self%packed(21*model%n_all + 3))
  end subroutine solver_init

  !> Records the state before a step.
  subroutine solver_begin(self, state)
    class(wing_solver_t), intent(inout) :: self
    type(dynamic_state_t), intent(in) :: state
    if (self%is_mine) call copy_state(state, self%begun)
    self%is_repeated = .false.
    self%factorisations = 0
  end subroutine solver_begin

  !> Makes the step dt [s] on the owner, from the recorded state, under force(3, n_all) [N] and a reaction, if there is one. A
  !> second call for the same step begins with the displacements found before. The other ranks return at once.
  subroutine solver_solve(self, model, inertia, options, force, dt, state, reaction)
    class(wing_solver_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(dynamic_options_t), intent(in) :: options
    real(rp), intent(in) :: force(:, :), dt
    type(dynamic_state_t), intent(inout) :: state
    class(reaction_t), intent(inout), optional :: reaction
    if (.not. self%is_mine) return
    if (self%is_repeated) then
      self%guess = state%u
      call copy_state(self%begun, state)
      call self%stepper%step(model, inertia, self%motion, force, dt, options, state, self%report, self%guess, reaction)
    else
      call self%stepper%step(model, inertia, self%motion, force, dt, options, state, self%report, &
                             reaction=reaction)
    end if
    self%factorisations = self%factorisations + self%report%factorisations
    self%is_repeated = .true.
  end subroutine solver_solve

  !> Gives the result of `solve`, or its failure, to all ranks. Collective.
  subroutine solver_broadcast(self, world, state, failure)
    class(wing_solver_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(dynamic_state_t), intent(inout) :: state
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: reason
    integer :: verdict
    verdict = 0
    if (self%is_mine) verdict = merge(0, 1, self%report%converged)
    if (world%max_integer(verdict) > 0) then
      if (self%is_mine) reason = self%report%reason
      call world%broadcast_text(reason, from=self%owner)
      call failure%raise('the time step of a wing failed: '//reason// &
                         '; set a smaller [Time] CFL, and check the units of [Wing] and [Mass]')
      return
    end if
    call broadcast_state(self, world, state)
  end subroutine solver_broadcast

  !> Sets the state back to the beginning of the step. Collective.
  subroutine solver_rewind(self, world, state)
    class(wing_solver_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(dynamic_state_t), intent(inout) :: state
    if (self%is_mine) call copy_state(self%begun, state)
    call broadcast_state(self, world, state)
  end subroutine solver_rewind

  !> Gives the owner's state to all ranks. Collective.
  subroutine broadcast_state(self, world, state)
    class(wing_solver_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(dynamic_state_t), intent(inout) :: state
    logical :: is_packed
    integer :: n
    is_packed = .false.
    call move_all()
    self%packed(n + 1:) = [state%time, state%old_step, real(self%factorisations, rp)]
    call world%broadcast_reals(self%packed, from=self%owner)
    is_packed = .true.
    call move_all()
    state%time = self%packed(n + 1)
    state%old_step = self%packed(n + 2)
    self%factorisations = nint(self%packed(n + 3))

  contains

    !> Packs all arrays of the state, or unpacks them.
    subroutine move_all()
      n = 0
      call move(state%u)
      call move(state%v)
      call move(state%g)
      call move(state%old_u)
      call move(state%old_v)
      call move(state%old_g)
      call move(state%a)
    end subroutine move_all

    !> Appends an array to the packed numbers, or takes it from them.
    subroutine move(array)
      real(rp), intent(inout) :: array(:, :)
      integer :: k
      do k = 1, size(array, 2)
        if (is_packed) then
          array(:, k) = self%packed(n + 1:n + 3)
        else
          self%packed(n + 1:n + 3) = array(:, k)
        end if
        n = n + 3
      end do
    end subroutine move
  end subroutine broadcast_state

  !> Releases everything.
  subroutine solver_free(self)
    class(wing_solver_t), intent(inout) :: self
    call self%stepper%free()
  end subroutine solver_free
end module fsi_wing_solver
