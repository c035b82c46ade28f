! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves and loads the flexible wings' part of a checkpoint: their motion, their energy balance and the history of the coupling, in
!> double precision. Vectors have components along the frame of their wing, independently of the side of the wing in the file.
module fsi_restart
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use base_packing, only: count_packed, pack_value, unpack_value
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_wing_energy, only: wing_energy_t
  use fsi_wing_mirror, only: mirror_state, mirror_vectors
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use io_checkpoint_values, only: checkpoint_loader_t, checkpoint_saver_t
  use solid_dynamics, only: dynamic_state_t
  use solid_restart, only: load_motion, save_motion, points_fingerprint
  implicit none
  private
  public :: save_wings, load_wings, has_flexible_wings

contains

  !> Puts the states of the wings into an open checkpoint. Collective.
  subroutine save_wings(writer, wings, coupler)
    type(checkpoint_writer_t), intent(inout), target :: writer
    type(flapping_wings_t), intent(in) :: wings
    type(coupler_t), intent(in) :: coupler
    character(:), allocatable :: side
    type(dynamic_state_t) :: state
    type(wing_energy_t) :: balance
    type(checkpoint_saver_t) :: saver
    real(rp), allocatable :: force(:, :), applied(:, :), energy(:)
    integer :: i
    call writer%put_integer('wing_mesh', points_fingerprint(coupler%params%model))
    call writer%put_real('coupling_dt', coupler%history%old_dt)
    call writer%put_real('coupling_relaxation', coupler%history%relaxation)
    do i = 1, size(coupler%states)
      side = trim(wings%params%wings(i)%side)//'_'
      state = coupler%states(i)
      force = coupler%history%force(:, :, i)
      applied = coupler%history%applied(:, :, i)
      if (coupler%wings(i)%motion%is_mirrored) then
        call mirror_state(state)
        call mirror_vectors(force)
        call mirror_vectors(applied)
      end if
      call save_motion(writer, side, state)
      balance = coupler%energies(i)
      call pack_value(balance, energy)
      call saver%begin(writer, side)
      call saver%visit('load', force)
      call saver%visit('applied', applied)
      call saver%visit('energy', energy)
    end do
  end subroutine save_wings

  !> Restores the states and gives the deformation to `wings`. Fails if the checkpoint has no flexible wings or
  !> others. Collective.
  subroutine load_wings(reader, wings, coupler, failure)
    type(checkpoint_reader_t), intent(inout), target :: reader
    type(flapping_wings_t), intent(inout) :: wings
    type(coupler_t), intent(inout) :: coupler
    type(failure_t), intent(inout) :: failure
    integer(i8) :: mesh
    integer :: i
    if (.not. has_flexible_wings(reader)) then
      call failure%raise('the checkpoint has no flexible wings: set [Insects] wings = rigid, or give another checkpoint')
      return
    end if
    call reader%get_integer('wing_mesh', mesh, failure)
    if (.not. failure%failed .and. mesh /= points_fingerprint(coupler%params%model)) &
      call failure%raise('the checkpoint belongs to another wing: give the [Wing] file of the run that wrote it')
    call reader%get_real('coupling_dt', coupler%history%old_dt, failure)
    call reader%get_real('coupling_relaxation', coupler%history%relaxation, failure)
    do i = 1, size(coupler%states)
      call load_wing(reader, trim(wings%params%wings(i)%side)//'_', coupler, i, failure)
    end do
    if (.not. failure%failed) call coupler%deform(wings)
  end subroutine load_wings

  !> Restores wing i, whose entries have names that begin with `side`.
  subroutine load_wing(reader, side, coupler, i, failure)
    type(checkpoint_reader_t), intent(inout), target :: reader
    character(*), intent(in) :: side
    type(coupler_t), intent(inout) :: coupler
    integer, intent(in) :: i
    type(failure_t), intent(inout) :: failure
    type(checkpoint_loader_t) :: loader
    real(rp), allocatable :: energy(:)
    call load_motion(reader, side, coupler%states(i), failure)
    if (failure%failed) return
    allocate (energy(count_packed(coupler%energies(i))))
    call loader%begin(reader, side)
    call loader%visit('load', coupler%history%force(:, :, i))
    call loader%visit('applied', coupler%history%applied(:, :, i))
    call loader%visit('energy', energy)
    if (loader%failure%failed) then
      call failure%raise('the coupling of the wing does not fit: '//loader%failure%reason)
      return
    end if
    call unpack_value(energy, coupler%energies(i), failure)
    if (.not. coupler%wings(i)%motion%is_mirrored) return
    call mirror_state(coupler%states(i))
    call mirror_vectors(coupler%history%force(:, :, i))
    call mirror_vectors(coupler%history%applied(:, :, i))
  end subroutine load_wing

  !> Tells whether an open checkpoint holds flexible wings.
  logical function has_flexible_wings(reader)
    type(checkpoint_reader_t), intent(inout), target :: reader
    has_flexible_wings = reader%has('wing_mesh')
  end function has_flexible_wings
end module fsi_restart
