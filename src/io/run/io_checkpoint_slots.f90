! SPDX-License-Identifier: GPL-3.0-or-later
!> Keeps two alternating checkpoints, `<base>0.h5` and `<base>1.h5`, and uses the newer valid one.
!>
!> Each holds a generation number that increases, also over restarts. A checkpoint replaces the older or the invalid file, but the
!> first checkpoint of a restarted run never replaces the file from which the run was restarted. Thus one complete generation is on
!> the disk at any instant.
module io_checkpoint_slots
  use base_errors, only: failure_t, require
  use base_files, only: join_path, name_of
  use base_kinds, only: i8
  use io_checkpoint, only: checkpoint_writer_t, checkpoint_reader_t
  use io_identity, only: identity_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: checkpoint_slots_t

  type :: checkpoint_slots_t
    private
    type(world_t) :: world
    character(:), allocatable :: directory, base
    integer(i8) :: generation(0:1) = 0 !< 0: missing or invalid
    integer :: source = -1             !< slot from which the run was restarted, until the other one is newer
    integer :: writing = -1            !< slot between begin and commit
    type(failure_t) :: verdict(0:1)    !< why a slot is invalid
    type(identity_t) :: identity       !< of the run, for its checkpoints
  contains
    procedure :: scan => slots_scan
    procedure :: newest_valid => slots_newest_valid
    procedure :: must_find => slots_must_find
    procedure :: came_from => slots_came_from
    procedure :: identify => slots_identify
    procedure :: begin => slots_begin
    procedure :: commit => slots_commit
    procedure :: newest_generation => slots_newest_generation
    procedure :: reason => slots_reason
  end type checkpoint_slots_t

contains

  !> Reads both files and verifies their content. Collective.
  subroutine slots_scan(self, world, directory, base)
    class(checkpoint_slots_t), intent(out) :: self
    type(world_t), intent(in) :: world
    character(*), intent(in) :: directory, base
    type(checkpoint_reader_t) :: reader
    integer :: slot

    self%world = world
    self%directory = directory
    self%base = base
    do slot = 0, 1
      associate (verdict => self%verdict(slot))
        call reader%open(world, join_path(directory, slot_name(self, slot)), verdict)
        if (verdict%failed) cycle
        call reader%get_integer('generation', self%generation(slot), verdict)
        call reader%close(verdict)
        if (verdict%failed) self%generation(slot) = 0
      end associate
    end do
  end subroutine slots_scan

  !> Returns the name of the newest valid checkpoint, without folder. `found` is false if there is none.
  subroutine slots_newest_valid(self, name, found)
    class(checkpoint_slots_t), intent(in) :: self
    character(:), allocatable, intent(out) :: name
    logical, intent(out) :: found
    found = maxval(self%generation) > 0
    name = slot_name(self, merge(1, 0, self%generation(1) > self%generation(0)))
  end subroutine slots_newest_valid

  !> Returns the name of the newest valid file; fails with the reasons if there is none.
  subroutine slots_must_find(self, name, failure)
    class(checkpoint_slots_t), intent(in) :: self
    character(:), allocatable, intent(out) :: name
    type(failure_t), intent(inout) :: failure
    logical :: found
    call self%newest_valid(name, found)
    if (.not. found) call failure%raise('there is no valid backup to restart from: '//self%reason(0)//'; '//self%reason(1))
  end subroutine slots_must_find

  !> Records that the run was restarted from the file `path`, of any age. If it is one of the two files, the next checkpoint
  !> replaces the other one.
  subroutine slots_came_from(self, path)
    class(checkpoint_slots_t), intent(inout) :: self
    character(*), intent(in) :: path
    integer :: slot
    self%source = -1
    do slot = 0, 1
      if (name_of(path) == slot_name(self, slot)) self%source = slot
    end do
  end subroutine slots_came_from

  !> Sets the identity of the run, which later checkpoints contain.
  subroutine slots_identify(self, identity)
    class(checkpoint_slots_t), intent(inout) :: self
    type(identity_t), intent(in) :: identity
    self%identity = identity
  end subroutine slots_identify

  !> Begins the next checkpoint in its slot, with its generation number. Collective.
  subroutine slots_begin(self, writer, failure)
    class(checkpoint_slots_t), intent(inout) :: self
    type(checkpoint_writer_t), intent(inout) :: writer
    type(failure_t), intent(inout) :: failure
    self%writing = next_slot(self)
    call writer%begin(self%world, self%directory, slot_name(self, self%writing), failure)
    call writer%put_integer('generation', maxval(self%generation) + 1)
    call self%identity%save(writer)
  end subroutine slots_begin

  !> Commits the checkpoint that `begin` began. After a failure the earlier ones are untouched and the next attempt uses the same
  !> slot. Collective.
  subroutine slots_commit(self, writer, failure)
    class(checkpoint_slots_t), intent(inout) :: self
    type(checkpoint_writer_t), intent(inout) :: writer
    type(failure_t), intent(inout) :: failure
    call require(self%writing >= 0, 'io_checkpoint_slots: commit without begin')
    call writer%commit(failure)
    if (.not. failure%failed) then
      self%generation(self%writing) = maxval(self%generation) + 1
      self%source = -1
    end if
    self%writing = -1
  end subroutine slots_commit

  !> Returns the generation number of the newest valid checkpoint, 0 if there is none.
  pure integer(i8) function slots_newest_generation(self) result(generation)
    class(checkpoint_slots_t), intent(in) :: self
    generation = maxval(self%generation)
  end function slots_newest_generation

  !> Returns why `scan` refused slot 0 or 1; empty if it was valid.
  function slots_reason(self, slot) result(reason)
    class(checkpoint_slots_t), intent(in) :: self
    integer, intent(in) :: slot
    character(:), allocatable :: reason
    reason = ''
    if (self%verdict(slot)%failed) reason = self%verdict(slot)%reason
  end function slots_reason

  !> Returns the slot of the next backup: not the slot of the backup from which the run started, otherwise the older one.
  pure integer function next_slot(self)
    class(checkpoint_slots_t), intent(in) :: self
    if (self%source >= 0) then
      next_slot = 1 - self%source
    else
      next_slot = merge(1, 0, self%generation(1) < self%generation(0))
    end if
  end function next_slot

  !> Returns the file name of a slot.
  pure function slot_name(self, slot) result(name)
    class(checkpoint_slots_t), intent(in) :: self
    integer, intent(in) :: slot
    character(:), allocatable :: name
    name = self%base//achar(iachar('0') + slot)//'.h5'
  end function slot_name
end module io_checkpoint_slots
