! SPDX-License-Identifier: GPL-3.0-or-later
!> Gathers the parts of a run: the flow, and the wings in it. These parts hold everything that a checkpoint contains.
module simulation_parts
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t, trial_t
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_free_flight, only: begin_flight, prepare_flight
  use fsi_thin_wings, only: thin_wings_t
  use parallel_world, only: world_t
  use fluid_averages, only: averages_t
  use simulation_settings, only: settings_t
  implicit none
  private
  public :: run_parts_t

  !> Holds the parts of a run. A part that the settings do not ask for is not allocated.
  type :: run_parts_t
    type(fluid_t) :: fluid
    type(flapping_wings_t), allocatable :: wings !< allocated if anything moves
    type(coupler_t), allocatable :: coupler      !< allocated if the flow bends the wings
    type(thin_wings_t), allocatable :: thin      !< of wings without thickness
    type(averages_t), allocatable :: averages    !< means over time, if the user wants them
  contains
    procedure :: build => parts_build
    procedure :: start => parts_start
    procedure :: settle_in => parts_settle_in
    procedure :: trial => parts_trial
  end type run_parts_t

contains

  !> Makes all parts that the settings ask for, but no state. Fails if a part cannot be made. Collective.
  subroutine parts_build(self, world, settings, failure)
    class(run_parts_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(settings_t), intent(in) :: settings
    type(failure_t), intent(inout) :: failure
    call self%fluid%init(world, settings%fluid, settings%needs_fields(), failure, settings%needs_pressure(), &
                         settings%needs_trials())
    if (settings%output%averages%is_on) allocate (self%averages)
    if (allocated(self%averages)) call self%averages%init(settings%output%averages, self%fluid%transform%block)
    if (settings%fluid%solids%is_moving) allocate (self%wings)
    if (allocated(self%wings)) call self%wings%init(settings%flight, settings%fluid%grid, self%fluid%transform%block)
    if (allocated(self%wings) .and. settings%flight%thin%is_thin) then
      allocate (self%thin)
      call self%thin%init(world, self%wings, self%fluid, failure)
    end if
    if (settings%flexible) then
      allocate (self%coupler)
      call self%coupler%init(world, settings%coupler, self%fluid, 0.0_rp, &
                             self%wings)
      if (allocated(self%thin)) call self%thin%init_flexible(settings%coupler%model%points, settings%coupler%units)
    end if
    if (settings%flight%flyer%is_free) call prepare_flight(self%wings)
  end subroutine parts_build

  !> Sets the state of a new run. Wings that bend start at the time of the flow. Collective.
  subroutine parts_start(self, failure)
    class(run_parts_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    call self%fluid%start(failure)
    ! A field from a file sets the time of the state.
    if (allocated(self%coupler)) self%coupler%states%time = self%fluid%rhs%state%time*self%coupler%params%units%time
  end subroutine parts_start

  !> Moves the wings to their positions at the time of the state, and starts a free flight. If the settings want it, the times of
  !> output limit the time steps. Collective.
  subroutine parts_settle_in(self, world, settings, failure)
    class(run_parts_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(settings_t), intent(in) :: settings
    type(failure_t), intent(inout) :: failure
    if (allocated(self%wings) .and. .not. failure%failed) &
      call self%wings%place(self%fluid%rhs%state%time, self%fluid%rhs%penalty, failure)
    if (settings%flight%flyer%is_free) call begin_flight(world, self%wings, self%fluid, failure, self%coupler)
    associate (o => settings%output)
      if (settings%fluid%time%intelligent_dt) self%fluid%rhs%intervals = &
        [o%fields%interval, o%t_integral, merge(o%slices%interval, 0.0_rp, o%slices%is_on), 0.0_rp]
    end associate
  end subroutine parts_settle_in

  !> Returns the trial with which the next step of the fluid may begin; without flexible wings there is none.
  type(trial_t) function parts_trial(self) result(trial)
    class(run_parts_t), intent(in) :: self
    if (allocated(self%coupler)) trial = self%coupler%trial
  end function parts_trial
end module simulation_parts
