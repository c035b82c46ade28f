! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads what the user wants a run to write: [Saving], [DryRun] and [SaveSlices], and [Averaging] (fluid_average_keys).
module simulation_output_params
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use common_solver_keys, only: backup_keys, limit_keys
  use fluid_params, only: fluid_params_t
  use io_config, only: config_t
  use io_fields, only: PRECISION_DOUBLE, PRECISION_SINGLE
  use io_keys, only: keys_t, reading
  use io_stop, only: job_limits_t
  use fsi_kinematics_keys, only: SIDES
  use fluid_average_keys, only: average_keys, average_params_t
  implicit none
  private
  public :: output_params_t, landmarks_key, output_keys, read_output, wanted_output

  type(named_kind_t), parameter :: PRECISIONS(2) = [named_kind_t('single', PRECISION_SINGLE), &
                                                    named_kind_t('double', PRECISION_DOUBLE)]

  !> States which fields are saved, and when.
  type :: field_params_t
    real(rp) :: interval = 0, first = 0 !< T
    logical :: velocity = .false., pressure = .false., vorticity = .false., vorticity_magnitude = .false., &
               mask = .false., solid_velocity = .false., wing_sides = .false., q_criterion = .false.
    logical :: single_precision = .true.
    integer :: stride = 1
    character(:), allocatable :: naming
    logical :: one_period = .false.
    real(rp) :: period = 1              !< T
  end type field_params_t

  !> States which planes of the velocity are saved.
  type :: slice_params_t
    logical :: is_on = .false.
    integer :: plane(4) = -2            !< x indices, from 0; negative: none
    integer :: every = 0                !< steps
    integer :: stack = 1                !< slices in a file
    real(rp) :: interval = 0, first = 0 !< T
  end type slice_params_t

  !> Points (x, y) of a wing in rows, in units of the file.
  type :: marked_points_t
    real(rp), allocatable :: rows(:, :)
  end type marked_points_t

  !> States what to write, how often, and when to stop.
  type :: output_params_t
    type(field_params_t) :: fields
    type(slice_params_t) :: slices
    type(average_params_t) :: averages
    real(rp) :: t_integral = 0        !< T
    integer :: it_integral = 0
    logical :: spectra = .false.
    type(marked_points_t) :: landmarks(2) !< of the wings of SIDES, whose path is saved
    logical :: backup = .true.
    logical :: mask_only = .false.    !< the run has no flow
    type(job_limits_t) :: limits      !< of backups, and when to stop
    real(rp) :: progress_seconds = 30
  contains
    procedure :: needs_fields => output_needs_fields
    procedure :: needs_flow => output_needs_flow
    procedure :: held_fields => output_held_fields
    procedure :: needs_scratch => output_needs_scratch
  end type output_params_t

contains

  !> Declares and reads all keys of the output.
  subroutine output_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(output_params_t), intent(inout) :: p
    call saving_keys(keys, p)
    call slice_keys(keys, p)
    call average_keys(keys, p%averages)
  end subroutine output_keys

  !> Visits the keys of [Saving].
  subroutine saving_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(output_params_t), intent(inout) :: p
    integer :: precision, i
    precision = PRECISION_SINGLE
    call keys%section('Saving', 'fields, time series, backups, and when to stop')
    call keys%real('tsave', p%fields%interval, 9.0e9_rp, 'interval of fields', unit='T', above=0.0_rp)
    call keys%real('tsave_first', p%fields%first, 0.0_rp, 'no fields before this time', unit='T')
    call keys%real('tintegral', p%t_integral, 0.01_rp, 'interval of forces and other integrals', unit='T', above=0.0_rp)
    call keys%integer('itdrag', p%it_integral, 99999, 'steps between integrals, in addition to tintegral', min=1)
    call keys%switch('iSaveVelocity', p%fields%velocity, .false., 'save ux uy uz')
    call keys%switch('iSavePress', p%fields%pressure, .false., 'save p')
    call keys%switch('iSaveVorticity', p%fields%vorticity, .false., 'save vorx vory vorz')
    call keys%switch('iSaveMagVorticity', p%fields%vorticity_magnitude, .false., 'save vorabs')
    call keys%switch('iSaveMask', p%fields%mask, .false., 'save mask')
    call keys%switch('iSaveSolidVelocity', p%fields%solid_velocity, .false., 'save usx usy usz')
    call keys%switch('iSaveWingSides', p%fields%wing_sides, .false., 'save pressure and traction on both sides of the wings '// &
                     'with their surfaces')
    call keys%switch('iSaveQ', p%fields%q_criterion, .false., 'save Q, the Q criterion -1/2 A_ij A_ji of the velocity gradient A')
    call keys%switch('iSaveSpectrae', p%spectra, .false., 'save energy spectra with the integrals: spectrum_tot.t, _x.t, '// &
                     '_y.t, _z.t have the mean of u^2/2 in each shell of wavenumbers of spectrum_k.t')
    do i = 1, 2
      call keys%matrix(landmarks_key(i), p%landmarks(i)%rows, 2, 'rows of x y [L]: points of the '//trim(SIDES(i))// &
                       ' wing, flat and before wing_stretch, in its frame. Their path in space is saved with the integrals: '// &
                       'landmarks_'//trim(SIDES(i))//'.t')
    end do
    call keys%kind('field_precision', precision, 'single', PRECISIONS, 'precision of the saved fields')
    call keys%integer('striding', p%fields%stride, 1, 'save every n-th point in each direction, n being this value', min=1)
    call keys%word('naming', p%fields%naming, 'time', 'time|step', 'number in the file names: 1000 t, or the time step')
    call keys%switch('save_only_one_period', p%fields%one_period, .false., 'overwrite the fields of the previous period: '// &
                     'times in file names are taken modulo tsave_period')
    call keys%real('tsave_period', p%fields%period, 1.0_rp, 'period of save_only_one_period', unit='T', above=0.0_rp)
    call keys%inert('backup_type', 'there is one kind of backup: one file, double precision')
    call backup_keys(keys, p%backup, p%limits)
    call limit_keys(keys, p%limits, p%progress_seconds)
    p%fields%single_precision = precision == PRECISION_SINGLE
  end subroutine saving_keys

  !> Returns the name of the key of the landmarks on wing `i` of SIDES.
  pure function landmarks_key(i) result(name)
    integer, intent(in) :: i
    character(:), allocatable :: name
    name = 'landmarks_'//trim(SIDES(i))
  end function landmarks_key

  !> Visits the keys of [SaveSlices] and of the dry run of the mask.
  subroutine slice_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(output_params_t), intent(inout) :: p
    integer :: i
    call keys%inert_section('DryRun', 'drawing the mask without a flow')
    call keys%switch('dry_run_without_fluid', p%mask_only, .false., 'no flow: save mask, velocity of the solids and surfaces '// &
                     'of the wings every tsave until Tmax')
    call keys%section('SaveSlices', 'y-z planes of the velocity, saved more often than fields')
    call keys%switch('use_slicing', p%slices%is_on, .false., 'save slices')
    call keys%older_name('save_slices')
    do i = 1, 4
      call keys%integer(slice_name(i), p%slices%plane(i), -2, 'x index of the plane, from 0; negative: no such slice', min=-2)
    end do
    call keys%integer('itslice', p%slices%every, 99999, 'steps between two slices', min=1)
    call keys%real('tslice', p%slices%interval, 9.0e9_rp, 'time between two slices', unit='T', above=0.0_rp)
    call keys%real('tslice_first', p%slices%first, 0.0_rp, 'no slices before this time', unit='T')
    call keys%integer('ncache_slices', p%slices%stack, 1, 'number of slices in one file, whose x is the time; slice_times.t '// &
                      'has their times; 1: one file for every slice', min=1)
    call keys%older_name('nslice_cache')
  end subroutine slice_keys

  !> Returns the output that the user asks for, even if the run has nothing to write for it.
  function wanted_output(c) result(p)
    type(config_t), intent(in), target :: c
    type(output_params_t) :: p
    type(keys_t) :: keys
    keys = reading(c)
    call output_keys(keys, p)
  end function wanted_output

  !> Returns in `p` what the run with this `fluid` writes. Adds mistakes to `errors`.
  subroutine read_output(c, fluid, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: fluid
    type(output_params_t), intent(out) :: p
    type(message_list_t), intent(inout) :: errors
    character(*), parameter :: SECTION = 'SaveSlices'
    integer :: i
    p = wanted_output(c)
    p%fields%mask = p%fields%mask .and. fluid%solids%is_on
    p%fields%solid_velocity = p%fields%solid_velocity .and. fluid%solids%is_on
    p%fields%wing_sides = p%fields%wing_sides .and. fluid%solids%is_moving
    do i = 1, 4
      if (p%slices%is_on .and. p%slices%plane(i) >= fluid%grid%n(1)) &
        call c%complain(errors, SECTION, slice_name(i), 'there is no such plane: indices run from 0 to nx-1')
    end do
    if (p%slices%is_on .and. all(p%slices%plane < 0)) &
      call c%complain(errors, SECTION, 'use_slicing', 'no slice is chosen: set slice1 to the x index of a plane')
    if (any(mod(fluid%grid%n, p%fields%stride) /= 0 .and. fluid%grid%n > 1)) &
      call c%complain(errors, 'Saving', 'striding', 'must divide nx, ny and nz')
    if (p%mask_only) call leave_mask_only(c, fluid, p, errors)
  end subroutine read_output

  !> Returns the name of the key of plane `i`.
  pure function slice_name(i) result(name)
    integer, intent(in) :: i
    character(6) :: name
    write (name, '(a,i1)') 'slice', i
  end function slice_name

  !> Removes all output that needs a flow. Adds a mistake if nothing remains.
  subroutine leave_mask_only(c, fluid, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: fluid
    type(output_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    p%fields%velocity = .false.
    p%fields%pressure = .false.
    p%fields%vorticity = .false.
    p%fields%vorticity_magnitude = .false.
    p%fields%wing_sides = .false.
    p%slices%is_on = .false.
    p%averages%is_on = .false.
    p%backup = .false.
    if (.not. (p%fields%mask .or. p%fields%solid_velocity .or. fluid%solids%is_moving)) call c%complain(errors, 'DryRun', &
      'dry_run_without_fluid', 'there is nothing to draw; valid with [Penalization] iPenalization = 1 and [Saving] '// &
      'iSaveMask = 1')
    if (p%fields%interval > fluid%time%t_max .and. fluid%time%t_max > 0) p%fields%interval = fluid%time%t_max
  end subroutine leave_mask_only

  !> Tells whether any output needs the velocity or vorticity in physical space.
  pure logical function output_needs_fields(self) result(needs)
    class(output_params_t), intent(in) :: self
    needs = self%slices%is_on .or. self%averages%is_on
  end function output_needs_fields

  !> Tells whether any output needs the velocity or vorticity one field after another.
  pure logical function output_needs_flow(self) result(needs)
    class(output_params_t), intent(in) :: self
    needs = self%fields%velocity .or. self%fields%vorticity .or. self%fields%vorticity_magnitude .or. self%fields%wing_sides
  end function output_needs_flow

  !> Returns how many fields of nx points the output keeps for sums of means over time and for stacked slices.
  pure real(rp) function output_held_fields(self, nx) result(n)
    class(output_params_t), intent(in) :: self
    integer, intent(in) :: nx
    n = self%averages%n_fields()
    if (self%slices%is_on .and. self%slices%stack > 1) n = n + 3*count(self%slices%plane >= 0)*real(self%slices%stack, rp)/nx
  end function output_held_fields

  !> Tells whether any output needs room to compute a field.
  pure logical function output_needs_scratch(self) result(needs)
    class(output_params_t), intent(in) :: self
    needs = self%needs_fields() .or. self%needs_flow() .or. self%fields%pressure .or. self%fields%mask .or. &
            self%fields%solid_velocity .or. self%fields%q_criterion
  end function output_needs_scratch
end module simulation_output_params
