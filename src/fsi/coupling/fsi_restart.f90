! SPDX-License-Identifier: GPL-3.0-or-later
!> Saves and loads the flexible wings' part of a checkpoint: their motion, their energy balance and the history of the coupling,
!> in double precision. Vectors have components along the frame of their wing, whichever side its file was made from.
module fsi_restart
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use fsi_coupler, only: coupler_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_wing_energy, only: wing_energy_t
  use fsi_wing_mirror, only: mirror_state, mirror_vectors
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use solid_dynamics, only: dynamic_state_t
  use solid_restart, only: load_motion, save_motion, points_fingerprint
  implicit none
  private
  public :: save_wings, load_wings, has_flexible_wings

contains

  !> Puts the states of the wings into an open checkpoint. Collective.
  subroutine save_wings(writer, wings, coupler)
    type(checkpoint_writer_t), intent(inout) :: writer
    type(flapping_wings_t), intent(in) :: wings
    type(coupler_t), intent(in) :: coupler
    character(:), allocatable :: side
    type(dynamic_state_t) :: state
    real(rp), allocatable :: force(:, :), applied(:, :)
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
      call writer%put_reals(side//'load', [force])
      call writer%put_reals(side//'applied', [applied])
      call writer%put_reals(side//'energy', energy_to_reals(coupler%energies(i)))
    end do
  end subroutine save_wings

  !> Restores the states and gives the deformation to `wings`. Fails if the checkpoint has no flexible wings or
  !> others. Collective.
  subroutine load_wings(reader, wings, coupler, failure)
    type(checkpoint_reader_t), intent(inout) :: reader
    type(flapping_wings_t), intent(inout) :: wings
    type(coupler_t), intent(inout) :: coupler
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: side
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
      side = trim(wings%params%wings(i)%side)//'_'
      call load_motion(reader, side, coupler%states(i), failure)
      call get_loads('load', coupler%history%force(:, :, i))
      call get_loads('applied', coupler%history%applied(:, :, i))
      if (coupler%wings(i)%motion%is_mirrored) then
        call mirror_state(coupler%states(i))
        call mirror_vectors(coupler%history%force(:, :, i))
        call mirror_vectors(coupler%history%applied(:, :, i))
      end if
      call get_energy(coupler%energies(i))
    end do
    if (.not. failure%failed) call coupler%deform(wings)

  contains

    subroutine get_loads(name, loads)
      character(*), intent(in) :: name
      real(rp), intent(inout) :: loads(:, :)
      real(rp), allocatable :: flat(:)
      if (failure%failed) return
      call reader%get_reals(side//name, flat, failure)
      if (failure%failed) return
      if (size(flat) /= size(loads)) then
        call failure%raise('the checkpoint has another number of points: give the [Wing] file of the run that wrote it')
      else
        loads(:, :) = reshape(flat, shape(loads))
      end if
    end subroutine get_loads

    subroutine get_energy(energy)
      type(wing_energy_t), intent(out) :: energy
      real(rp), allocatable :: flat(:)
      if (failure%failed) return
      call reader%get_reals(side//'energy', flat, failure)
      if (failure%failed) return
      if (size(flat) /= size(energy_to_reals(energy))) then
        call failure%raise('the checkpoint is not complete, as its energy balance has another length: give another one')
      else
        energy = wing_energy_t(flat(1), flat(2), flat(3), flat(4), flat(5), flat(6), flat(7), flat(8), flat(9), &
                               flat(10), flat(11))
      end if
    end subroutine get_energy
  end subroutine load_wings

  !> All components in their order.
  pure function energy_to_reals(e) result(reals)
    type(wing_energy_t), intent(in) :: e
    real(rp) :: reals(11)
    reals = [e%start, e%kinetic, e%elastic, e%hinge_work, e%load_work, e%weight_work, e%damped, e%hinge_power, &
             e%load_power, e%weight_power, e%damping_power]
  end function energy_to_reals

  !> Whether an open checkpoint holds flexible wings.
  logical function has_flexible_wings(reader)
    type(checkpoint_reader_t), intent(inout) :: reader
    has_flexible_wings = reader%has('wing_mesh')
  end function has_flexible_wings
end module fsi_restart
