! SPDX-License-Identifier: GPL-3.0-or-later
!> Fields and slices: what is due, and writing it.
module flusi_output
  use base_errors, only: failure_t
  use base_kinds, only: rp, i8
  use fluid_fields, only: mask_field, solid_velocity_field
  use fluid_flow_fields, only: VORTICITY_MAGNITUDE
  use fluid_q_criterion, only: q_criterion
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fluid_timestep, only: is_due
  use flusi_averages, only: averages_t, MOST_AVERAGES
  use flusi_flight_output, only: flight_output_t
  use flusi_settings, only: output_params_t
  use flusi_slices, only: slices_t
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_wing_sides, only: wing_sides_t
  use io_fields, only: field_meta_t, write_field, write_slice, field_label, finest_naming, PRECISION_SINGLE, &
                       PRECISION_DOUBLE
  use io_xdmf, only: xdmf_index_t
  use parallel_block, only: allocate_fields
  use parallel_world, only: world_t
  implicit none
  private
  public :: output_t

  !> Due dates of the present step and scratch for one field.
  type :: output_t
    type(output_params_t) :: params
    character(:), allocatable, private :: note
    logical :: fields_due = .false., slices_due = .false., integrals_due = .false.
    logical, private :: last = .false., saves_wings = .false.
    type(xdmf_index_t), private :: index
    type(flight_output_t), private :: wings
    type(wing_sides_t), private :: sides
    type(slices_t), allocatable, private :: stack !< of slices
    real(rp), allocatable, private :: scratch(:, :, :, :)
  contains
    procedure :: init => output_init
    procedure :: request_fields => output_request_fields
    procedure :: write => output_write
    procedure :: flush => output_flush
    procedure :: write_failed => output_write_failed
  end type output_t

  character(*), parameter :: AXES = 'xyz'

contains

  !> Opens the index of fields, `name`.xmf; with `restart_time` earlier entries are kept. Collective.
  subroutine output_init(self, world, params, fluid, name, note, failure, wings, restart_time)
    class(output_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(output_params_t), intent(in) :: params
    type(fluid_t), intent(in) :: fluid
    character(*), intent(in) :: name
    character(*), intent(in) :: note !< on the units, stored with every field and surface unless it is empty
    type(failure_t), intent(inout) :: failure
    type(flapping_wings_t), intent(in), optional :: wings
    real(rp), intent(in), optional :: restart_time
    self%params = params
    self%note = note
    if (present(wings)) call self%wings%init(world, wings, name, failure, restart_time)
    if (present(wings) .and. params%wing_sides) call self%sides%init(world, fluid, wings)
    self%saves_wings = present(wings)
    associate (b => fluid%transform%block)
      if (params%needs_scratch()) call allocate_fields(self%scratch, b, 1, 'a field to be written')
    end associate
    if (params%slices .and. params%stack > 1) then
      allocate (self%stack)
      call self%stack%init(world, fluid%transform%block, params%slice, params%stack, failure, restart_time)
    end if
    if (.not. allocated(self%scratch)) return
    call self%index%open(world, name//'.xmf', failure, restart_time)
  end subroutine output_init

  !> Decides what has to be written for the state of `fluid`, and what its next pass must provide. Takes what the step
  !> that follows would change: Q, which stays in the scratch until `write`. Collective.
  subroutine output_request_fields(self, fluid, is_last, request, averages)
    class(output_t), target, intent(inout) :: self
    type(fluid_t), target, intent(inout) :: fluid
    logical, intent(in) :: is_last !< the end of the run: everything is due
    type(request_t), intent(out) :: request
    type(averages_t), intent(in), optional :: averages
    associate (p => self%params, t => fluid%rhs%state%time, dt => fluid%rhs%state%dt_old, &
               step => fluid%rhs%state%step)
      self%last = is_last
      self%fields_due = (is_due(t, dt, p%t_save) .or. is_last) .and. t >= p%t_save_first .and. &
                        (allocated(self%scratch) .or. self%saves_wings)
      self%slices_due = p%slices .and. t >= p%t_slice_first .and. &
                        (is_due(t, dt, p%t_slice) .or. mod(step, p%it_slice) == 0)
      self%integrals_due = is_due(t, dt, p%t_integral) .or. mod(step, p%it_integral) == 0 .or. is_last
      request%integrals = self%integrals_due
      request%fields = self%slices_due
      request%flow = self%fields_due .and. p%needs_flow()
      if (present(averages)) request%fields = request%fields .or. averages%wants(t)
      request%pressure = self%fields_due .and. (p%pressure .or. p%wing_sides)
    end associate
    if (self%fields_due .and. self%params%q_criterion) &
      call q_criterion(fluid%transform, fluid%rhs%state%u, self%scratch(:, :, :, 1))
  end subroutine output_request_fields

  !> Writes what `request_fields` found due, from the pass that has run since. Collective.
  subroutine output_write(self, fluid, failure, wings, coupler, averages)
    class(output_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(failure_t), intent(inout) :: failure
    type(flapping_wings_t), intent(in), optional :: wings
    type(coupler_t), intent(in), optional :: coupler !< of flexible wings
    type(averages_t), intent(in), optional :: averages
    character(:), allocatable :: label
    type(field_meta_t) :: meta
    character(8) :: saved(16 + MOST_AVERAGES) !< prefixes written so far
    integer :: c, i, n_saved, step
    if (.not. (self%fields_due .or. self%slices_due)) return
    meta = meta_of(fluid, fluid%sums_time)
    if (self%note /= '') meta%units = self%note
    associate (p => self%params, rhs => fluid%rhs)
      step = fluid%rhs%state%step - merge(0, 1, self%last)
      label = label_of(p, fluid%sums_time, step, p%t_save)
      if (self%fields_due) then
        n_saved = 0
        if (p%q_criterion) call save('Q', self%scratch(:, :, :, 1)) ! before the scratch is used for others
        do c = 1, 3
          if (p%velocity) call save_flow('u'//AXES(c:c), c)
        end do
        do c = 1, 3
          if (p%vorticity) call save_flow('vor'//AXES(c:c), 3 + c)
        end do
        if (p%vorticity_magnitude) call save_flow('vorabs', VORTICITY_MAGNITUDE)
        if (p%pressure) then
          call fluid%pressure_field(self%scratch)
          call save('p', self%scratch(:, :, :, 1))
        end if
        if (p%mask) then
          call mask_field(rhs%penalty, self%scratch(:, :, :, 1))
          call save('mask', self%scratch(:, :, :, 1))
        end if
        do c = 1, 3
          if (.not. p%solid_velocity) cycle
          call solid_velocity_field(rhs%penalty, c, self%scratch(:, :, :, 1))
          call save('us'//AXES(c:c), self%scratch(:, :, :, 1))
        end do
        if (present(averages)) call save_averages(averages)
        if (present(wings) .and. p%wing_sides) then
          call self%sides%sample(fluid, wings)
          call self%wings%write(wings, label, self%note, failure, coupler, self%sides)
        else if (present(wings)) then
          call self%wings%write(wings, label, self%note, failure, coupler)
        end if
        if (n_saved > 0) call self%index%add(fluid%sums_time, label, saved(1:n_saved), fluid%transform%block%n, &
                                             meta%domain_size, meta%origin, p%stride, precision_of(p), failure)
      end if
      if (self%slices_due .and. allocated(self%stack)) then
        call self%stack%add(fluid, meta, precision_of(p), failure)
      else if (self%slices_due) then
        label = label_of(p, fluid%sums_time, step, min(p%t_save, p%t_slice))
        do i = 1, size(p%slice)
          if (p%slice(i) < 0) cycle
          do c = 1, 3
            call write_slice(rhs%world, '.', 'u'//achar(iachar('0') + c), p%slice(i), label, fluid%transform%block, &
                             rhs%fields(:, :, :, c), meta, precision_of(p), failure)
          end do
        end do
      end if
    end associate

  contains

    subroutine save_averages(averages)
      type(averages_t), intent(in) :: averages
      integer :: i
      if (.not. averages%has(fluid%sums_time)) return
      do i = 1, averages%n
        call averages%mean(fluid, i, self%scratch(:, :, :, 1))
        if (.not. averages%params%one_only) then
          call save(trim(averages%name(i)), self%scratch(:, :, :, 1))
        else if (.not. failure%failed) then
          call write_field(fluid%rhs%world, '.', trim(averages%name(i)), '000', fluid%transform%block, &
                           self%scratch(:, :, :, 1), meta, precision_of(self%params), self%params%stride, failure)
        end if
      end do
    end subroutine save_averages

    subroutine save_flow(prefix, which)
      character(*), intent(in) :: prefix
      integer, intent(in) :: which
      call fluid%flow_field(which, self%scratch)
      call save(prefix, self%scratch(:, :, :, 1))
    end subroutine save_flow

    subroutine save(prefix, data)
      character(*), intent(in) :: prefix
      real(rp), intent(in) :: data(:, :, :)
      if (failure%failed) return
      call write_field(fluid%rhs%world, '.', prefix, label, fluid%transform%block, data, meta, &
                       precision_of(self%params), self%params%stride, failure)
      n_saved = n_saved + 1
      saved(n_saved) = prefix
    end subroutine save
  end subroutine output_write

  !> Writes what waits to be stacked, before a backup and at the end. Collective.
  subroutine output_flush(self, fluid, failure)
    class(output_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    type(failure_t), intent(inout) :: failure
    type(field_meta_t) :: meta
    if (.not. allocated(self%stack)) return
    meta = meta_of(fluid, fluid%sums_time)
    if (self%note /= '') meta%units = self%note
    call self%stack%flush(fluid, meta, precision_of(self%params), failure)
  end subroutine output_flush

  !> Writes the velocity that made the run fail, as failed-ux_*.h5 and so on. Collective.
  subroutine output_write_failed(self, fluid, failure)
    class(output_t), intent(in) :: self
    type(fluid_t), intent(inout) :: fluid
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: u(:, :, :, :)
    type(failure_t) :: writing
    integer :: c
    associate (b => fluid%transform%block, state => fluid%rhs%state)
      call allocate_fields(u, b, 3, 'the velocity to be written')
      call fluid%transform%backward(state%u, u)
      do c = 1, 3
        call write_field(fluid%rhs%world, '.', 'failed-u'//AXES(c:c), label_of(self%params, state%time, state%step, &
                                                                               self%params%t_save), b, &
                         u(:, :, :, c), meta_of(fluid, state%time), PRECISION_DOUBLE, 1, writing)
      end do
    end associate
    if (writing%failed) failure%reason = failure%reason//'; moreover: '//writing%reason
  end subroutine output_write_failed

  function meta_of(fluid, time) result(meta)
    type(fluid_t), intent(in) :: fluid
    real(rp), intent(in) :: time
    type(field_meta_t) :: meta
    meta%time = time
    meta%viscosity = fluid%rhs%params%nu
    meta%epsi = fluid%rhs%params%solids%c_eta
    meta%domain_size = fluid%rhs%params%grid%length
    meta%nxyz = fluid%rhs%params%grid%n
  end function meta_of

  !> Label of files that are written every `interval`.
  function label_of(p, time, step, interval) result(label)
    type(output_params_t), intent(in) :: p
    real(rp), intent(in) :: time, interval
    integer, intent(in) :: step
    character(:), allocatable :: label
    real(rp) :: shown
    shown = time
    ! A whole number of periods is 0 whatever its round-off.
    if (p%one_period) shown = max(0.0_rp, time - p%period*aint(time/p%period + 1.0e-9_rp))
    label = field_label(shown, int(step, i8), finest_naming(p%naming, interval))
  end function label_of

  pure integer function precision_of(p) result(precision)
    type(output_params_t), intent(in) :: p
    precision = merge(PRECISION_SINGLE, PRECISION_DOUBLE, p%single_precision)
  end function precision_of
end module flusi_output
