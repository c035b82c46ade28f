! SPDX-License-Identifier: GPL-3.0-or-later
!> Decides when fields and slices are due, and writes them.
module simulation_output
  use base_errors, only: failure_t
  use base_kinds, only: rp, i8
  use fluid_fields, only: mask_field, solid_velocity_field
  use fluid_flow_fields, only: VORTICITY_MAGNITUDE
  use fluid_q_criterion, only: q_criterion
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fluid_timestep, only: is_due
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_wing_sides, only: wing_sides_t
  use io_fields, only: field_form_t, field_meta_t, write_field, write_slice, field_label, finest_naming, PRECISION_SINGLE, &
                       PRECISION_DOUBLE
  use io_xdmf, only: xdmf_index_t
  use parallel_block, only: allocate_fields
  use fluid_averages, only: averages_t, MOST_AVERAGES
  use simulation_flight_output, only: flight_output_t
  use simulation_opening, only: opening_t
  use simulation_output_params, only: output_params_t
  use simulation_slices, only: slices_t
  implicit none
  private
  public :: output_t

  !> Holds which output is due in the present step, and scratch memory for fields.
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

  !> Describes how the fields of a step are written, and lists those that have been written.
  type :: saving_t
    type(field_meta_t) :: meta
    type(field_form_t) :: form
    integer :: n = 0
    character(8) :: prefixes(16 + MOST_AVERAGES) = ''
  end type saving_t

  character(*), parameter :: AXES = 'xyz'

contains

  !> Opens the indices of fields and wings, and makes room for what the output needs. Collective.
  subroutine output_init(self, opening, params, fluid, wings)
    class(output_t), intent(inout) :: self
    type(opening_t), intent(inout) :: opening
    type(output_params_t), intent(in) :: params
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(in), optional :: wings
    self%params = params
    self%note = opening%note
    self%saves_wings = present(wings)
    if (present(wings)) call self%wings%init(opening, wings)
    if (present(wings) .and. params%fields%wing_sides) call self%sides%init(fluid, wings)
    if (params%needs_scratch()) call allocate_fields(self%scratch, fluid%transform%block, 1, 'a field to be written')
    if (params%slices%is_on .and. params%slices%stack > 1) then
      allocate (self%stack)
      call self%stack%init(opening, fluid%transform%block, params%slices%plane, params%slices%stack)
    end if
    if (.not. allocated(self%scratch)) return
    call self%index%open(opening%world, opening%name//'.xmf', opening%failure, opening%restart_time)
  end subroutine output_init

  !> Decides what to write for the present state of `fluid`, and sets in `request` what the next pass must provide. If Q is due it
  !> computes Q now, because the next step changes it, and keeps it in the scratch until `write`. Collective.
  subroutine output_request_fields(self, fluid, is_last, request, averages)
    class(output_t), target, intent(inout) :: self
    type(fluid_t), target, intent(inout) :: fluid
    logical, intent(in) :: is_last !< the run ends, so that all output is due
    type(request_t), intent(out) :: request
    type(averages_t), intent(in), optional :: averages
    associate (p => self%params, t => fluid%rhs%state%time, dt => fluid%rhs%state%dt_old, &
               step => fluid%rhs%state%step)
      self%last = is_last
      self%fields_due = (is_due(t, dt, p%fields%interval) .or. is_last) .and. t >= p%fields%first .and. &
                        (allocated(self%scratch) .or. self%saves_wings)
      self%slices_due = p%slices%is_on .and. t >= p%slices%first .and. &
                        (is_due(t, dt, p%slices%interval) .or. mod(step, p%slices%every) == 0)
      self%integrals_due = is_due(t, dt, p%t_integral) .or. mod(step, p%it_integral) == 0 .or. is_last
      request%integrals = self%integrals_due
      request%fields = self%slices_due
      request%flow = self%fields_due .and. p%needs_flow()
      if (present(averages)) request%fields = request%fields .or. averages%wants(t)
      request%pressure = self%fields_due .and. (p%fields%pressure .or. p%fields%wing_sides)
    end associate
    if (self%fields_due .and. self%params%fields%q_criterion) &
      call q_criterion(fluid%transform, fluid%rhs%state%u, self%scratch(:, :, :, 1))
  end subroutine output_request_fields

  !> Writes the output that `request_fields` found due, from the pass that has run since then. Collective.
  subroutine output_write(self, fluid, failure, wings, coupler, averages)
    class(output_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(failure_t), intent(inout) :: failure
    type(flapping_wings_t), intent(in), optional :: wings
    type(coupler_t), intent(in), optional :: coupler !< of flexible wings
    type(averages_t), intent(in), optional :: averages
    type(saving_t) :: saving
    integer :: step
    if (.not. (self%fields_due .or. self%slices_due)) return
    call begin_saving(self, fluid, saving)
    associate (p => self%params, form => saving%form)
      step = fluid%rhs%state%step - merge(0, 1, self%last)
      saving%form%label = label_of(p, fluid%sums_time, step, p%fields%interval)
      if (self%fields_due) then
        call save_fields(self, fluid, saving, failure)
        if (present(averages)) call save_averages(self, fluid, averages, saving, failure)
        if (present(wings) .and. p%fields%wing_sides) then
          call self%sides%sample(fluid, wings)
          call self%wings%write(wings, form%label, self%note, failure, coupler, self%sides)
        else if (present(wings)) then
          call self%wings%write(wings, form%label, self%note, failure, coupler)
        end if
        if (saving%n > 0) call self%index%add(saving%prefixes(:saving%n), saving%meta, saving%form, failure)
      end if
      if (.not. self%slices_due) return
      saving%form%label = label_of(p, fluid%sums_time, step, min(p%fields%interval, p%slices%interval))
      call save_slices(self, fluid, saving, failure)
    end associate
  end subroutine output_write

  !> Sets what all files of the present step share, apart from the label.
  subroutine begin_saving(self, fluid, saving)
    class(output_t), intent(in) :: self
    type(fluid_t), intent(in) :: fluid
    type(saving_t), intent(out) :: saving
    saving%meta = meta_of(fluid, fluid%sums_time)
    if (self%note /= '') saving%meta%units = self%note
    saving%form%directory = '.'
    saving%form%precision = precision_of(self%params)
    saving%form%stride = self%params%fields%stride
  end subroutine begin_saving

  !> Saves all fields of this time that the user wants.
  subroutine save_fields(self, fluid, saving, failure)
    class(output_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(saving_t), intent(inout) :: saving
    type(failure_t), intent(inout) :: failure
    integer :: c
    associate (p => self%params, penalty => fluid%rhs%penalty)
      if (p%fields%q_criterion) call save('Q') ! before the scratch is used for other fields
      do c = 1, 3
        if (p%fields%velocity) call save_flow('u'//AXES(c:c), c)
      end do
      do c = 1, 3
        if (p%fields%vorticity) call save_flow('vor'//AXES(c:c), 3 + c)
      end do
      if (p%fields%vorticity_magnitude) call save_flow('vorabs', VORTICITY_MAGNITUDE)
      if (p%fields%pressure) then
        call fluid%pressure_field(self%scratch)
        call save('p')
      end if
      if (p%fields%mask) then
        call mask_field(penalty, self%scratch(:, :, :, 1))
        call save('mask')
      end if
      do c = 1, 3
        if (.not. p%fields%solid_velocity) cycle
        call solid_velocity_field(penalty, c, self%scratch(:, :, :, 1))
        call save('us'//AXES(c:c))
      end do
    end associate

  contains

    subroutine save_flow(prefix, which)
      character(*), intent(in) :: prefix
      integer, intent(in) :: which
      call fluid%flow_field(which, self%scratch)
      call save(prefix)
    end subroutine save_flow

    subroutine save(prefix)
      character(*), intent(in) :: prefix
      call save_scratch(self, fluid, prefix, saving, failure)
    end subroutine save
  end subroutine save_fields

  !> Writes the scratch as a file and keeps its name for the index.
  subroutine save_scratch(self, fluid, prefix, saving, failure)
    class(output_t), intent(in) :: self
    type(fluid_t), intent(in) :: fluid
    character(*), intent(in) :: prefix
    type(saving_t), intent(inout) :: saving
    type(failure_t), intent(inout) :: failure
    if (failure%failed) return
    call write_field(fluid%rhs%world, prefix, fluid%transform%block, self%scratch(:, :, :, 1), saving%meta, saving%form, failure)
    saving%n = saving%n + 1
    saving%prefixes(saving%n) = prefix
  end subroutine save_scratch

  !> Saves the means over time, either in files of their own or in files that keep the newest means alone.
  subroutine save_averages(self, fluid, averages, saving, failure)
    class(output_t), intent(inout) :: self
    type(fluid_t), intent(inout) :: fluid
    type(averages_t), intent(in) :: averages
    type(saving_t), intent(inout) :: saving
    type(failure_t), intent(inout) :: failure
    type(field_form_t) :: newest
    integer :: i
    if (.not. averages%has(fluid%sums_time)) return
    newest = saving%form
    newest%label = '000'
    do i = 1, averages%n
      call averages%mean(fluid, i, self%scratch(:, :, :, 1))
      if (.not. averages%params%one_only) then
        call save_scratch(self, fluid, trim(averages%name(i)), saving, failure)
      else if (.not. failure%failed) then
        call write_field(fluid%rhs%world, trim(averages%name(i)), fluid%transform%block, self%scratch(:, :, :, 1), &
                         saving%meta, newest, failure)
      end if
    end do
  end subroutine save_averages

  !> Writes the planes of the velocity, or adds them to the stack.
  subroutine save_slices(self, fluid, saving, failure)
    class(output_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    type(saving_t), intent(in) :: saving
    type(failure_t), intent(inout) :: failure
    integer :: c, i
    if (allocated(self%stack)) then
      call self%stack%add(fluid, saving%meta, saving%form%precision, failure)
      return
    end if
    associate (place => self%params%slices%plane, rhs => fluid%rhs)
      do i = 1, size(place)
        if (place(i) < 0) cycle
        do c = 1, 3
          call write_slice(rhs%world, 'u'//achar(iachar('0') + c), place(i), fluid%transform%block, &
                           rhs%fields(:, :, :, c), saving%meta, saving%form, failure)
        end do
      end do
    end associate
  end subroutine save_slices

  !> Writes the slices that wait in the stack. A run calls it before a backup and at the end. Collective.
  subroutine output_flush(self, fluid, failure)
    class(output_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    type(failure_t), intent(inout) :: failure
    type(saving_t) :: saving
    if (.not. allocated(self%stack)) return
    call begin_saving(self, fluid, saving)
    call self%stack%flush(fluid, saving%meta, saving%form%precision, failure)
  end subroutine output_flush

  !> Writes the velocity that made the run fail, as failed-ux_*.h5 and so on. Collective.
  subroutine output_write_failed(self, fluid, failure)
    class(output_t), intent(in) :: self
    type(fluid_t), intent(inout) :: fluid
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: u(:, :, :, :)
    type(field_form_t) :: form
    type(failure_t) :: writing
    integer :: c
    associate (b => fluid%transform%block, state => fluid%rhs%state)
      call allocate_fields(u, b, 3, 'the velocity to be written')
      call fluid%transform%backward(state%u, u)
      form%directory = '.'
      form%label = label_of(self%params, state%time, state%step, self%params%fields%interval)
      do c = 1, 3
        call write_field(fluid%rhs%world, 'failed-u'//AXES(c:c), b, u(:, :, :, c), meta_of(fluid, state%time), form, writing)
      end do
    end associate
    if (writing%failed) failure%reason = failure%reason//'; moreover: '//writing%reason
  end subroutine output_write_failed

  !> Returns the data on the run that every field file contains: time, viscosity, permeability and grid.
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

  !> Returns the label of files that are written every `interval` [T].
  function label_of(p, time, step, interval) result(label)
    type(output_params_t), intent(in) :: p
    real(rp), intent(in) :: time, interval
    integer, intent(in) :: step
    character(:), allocatable :: label
    real(rp) :: shown
    shown = time
    ! A whole number of periods gives 0 in spite of round-off.
    if (p%fields%one_period) shown = max(0.0_rp, time - p%fields%period*aint(time/p%fields%period + 1.0e-9_rp))
    label = field_label(shown, int(step, i8), finest_naming(p%fields%naming, interval))
  end function label_of

  !> Returns the precision in which fields are saved.
  pure integer function precision_of(p) result(precision)
    type(output_params_t), intent(in) :: p
    precision = merge(PRECISION_SINGLE, PRECISION_DOUBLE, p%fields%single_precision)
  end function precision_of
end module simulation_output
