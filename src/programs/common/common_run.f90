! SPDX-License-Identifier: GPL-3.0-or-later
!> Guards a run and the files that it writes. Only one run at a time may write them, no run overwrites the results of another, and a
!> restart continues the same run only. `begin` locks the files; `check_new` or `judge` decides whether the run may start; `settle`
!> moves earlier files away just before the run writes its first file; `finish` unlocks. The names of all files begin with the same
!> text, the base: `runtime` for a flow, in the current folder.
module common_run
  use, intrinsic :: iso_fortran_env, only: error_unit
  use base_errors, only: failure_t, message_list_t
  use base_files, only: file_exists
  use base_listing, only: matches_name
  use base_outcome, only: outcome_t, OUTCOME_MISTAKE, OUTCOME_UNWRITABLE
  use base_process, only: date_and_clock
  use base_text, only: number_text
  use base_text_file, only: write_text
  use io_earlier_results, only: find_results, move_to_folder
  use io_config, only: config_t
  use io_identity, only: change_t, identity_t, list_changes
  use io_lock, only: lock_t, LOCK_HELD, LOCK_TAKEN
  use io_broadcast_text, only: read_text_file
  use parallel_failure, only: broadcast_failure
  use parallel_world, only: world_t
  implicit none
  private
  public :: run_t

  character(*), parameter :: NL = new_line('a')

  !> Guards the files of one run, as the head of this module describes.
  type :: run_t
    type(identity_t) :: identity            !< of the run, for its checkpoints; known after `settle`
    type(world_t), private :: world
    type(lock_t), private :: lock
    character(:), allocatable, private :: base, program
    type(message_list_t), private :: input_files
    character(:), allocatable, private :: ini
    logical, private :: moves = .false.     !< `settle` moves the files of an earlier run away
    type(message_list_t), private :: patterns
    type(message_list_t), private :: state_keys !< keys on which the state in a checkpoint depends
  contains
    procedure :: begin => run_begin
    procedure :: check_new => run_check_new
    procedure :: judge => run_judge
    procedure :: settle => run_settle
    procedure :: finish => run_finish
  end type run_t

contains

  !> Locks the files of a run of `program`, whose names begin with `base`. `config` holds the inputs from the file `ini`. Fails
  !> if another run writes there or if nobody can write there. Collective.
  subroutine run_begin(self, world, program, base, ini, config, outcome)
    class(run_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    character(*), intent(in) :: program, base, ini
    type(config_t), intent(in) :: config
    type(outcome_t), intent(inout) :: outcome
    type(failure_t) :: own, failure
    character(:), allocatable :: notice, inputs
    integer :: state
    if (outcome%failure%failed) return
    self%world = world
    self%program = program
    self%base = base
    self%ini = ini
    self%state_keys = config%state_keys()
    state = LOCK_HELD
    if (world%is_root) then
      call self%lock%acquire(base//'.lock', state, notice, own)
      inputs = config%inputs()
      call config%named_files(self%input_files)
      call self%identity%start(inputs)
    end if
    call world%broadcast_integer(state)
    call broadcast_failure(world, own, failure)
    call world%broadcast_text(inputs)
    call broadcast_identity(self, inputs)
    if (failure%failed) then
      call outcome%fail(merge(OUTCOME_MISTAKE, OUTCOME_UNWRITABLE, state == LOCK_TAKEN), failure%reason)
    else if (world%is_root) then
      if (notice /= '') write (error_unit, '(a)') 'notice: '//notice
      flush (error_unit)
    end if
  end subroutine run_begin

  !> Gives all ranks the name of the run that rank 0 has chosen.
  subroutine broadcast_identity(self, inputs)
    class(run_t), intent(inout) :: self
    character(*), intent(in) :: inputs
    character(:), allocatable :: id
    if (self%world%is_root) id = self%identity%id
    call self%world%broadcast_text(id)
    if (.not. self%world%is_root) call self%identity%start(inputs)
    self%identity%id = id
  end subroutine broadcast_identity

  !> Checks that a new run does not overwrite results of an earlier one, and fails if it would. With `overwrite` it passes:
  !> `settle` will then move away the files that match `patterns`, apart from those that this run reads. It changes no file.
  !> Collective.
  subroutine run_check_new(self, overwrite, patterns, outcome)
    class(run_t), intent(inout) :: self
    logical, intent(in) :: overwrite
    type(message_list_t), intent(in) :: patterns
    type(outcome_t), intent(inout) :: outcome
    character(:), allocatable :: what
    if (outcome%failure%failed) return
    what = ''
    if (self%world%is_root) what = earlier_run(self)
    call self%world%broadcast_text(what)
    self%moves = what /= '' .and. overwrite
    self%patterns = patterns
    if (what == '' .or. overwrite) return
    call outcome%fail(OUTCOME_MISTAKE, 'this folder has the results of '//what//'--overwrite moves its files into a folder '// &
                      'earlier_1 (or 2, ...) and starts from the beginning; you can also start in another folder')
  end subroutine run_check_new

  !> Returns what the files show about an earlier run and how the user can continue it; empty if there was none.
  function earlier_run(self) result(what)
    class(run_t), intent(in) :: self
    character(:), allocatable :: what
    logical :: has_backup, has_identity
    has_backup = has_file(backup_name(self, 0)) .or. has_file(backup_name(self, 1))
    has_identity = file_exists(self%base//'_identity.txt')
    what = ''
    if (has_identity) then
      what = 'run '//stored(self, 'id')//' ('//stored(self, 'input')//', begun '//stored(self, 'begun')//')'
    else if (has_backup) then
      what = 'an earlier run ('//self%base//'_backup*.h5)'
    end if
    if (has_backup) then
      what = what//': --restart continues it, '
    else if (has_identity) then
      what = what//', which left no backup: '
    end if
  end function earlier_run

  !> Tells whether there is a file of this name that is not a folder.
  logical function has_file(path)
    character(*), intent(in) :: path
    has_file = file_exists(path) .and. .not. file_exists(path//'/.')
  end function has_file

  !> Returns the name of the backup in a slot, 0 or 1.
  function backup_name(self, slot) result(name)
    class(run_t), intent(in) :: self
    integer, intent(in) :: slot
    character(:), allocatable :: name
    name = self%base//'_backup'//number_text(slot)//'.h5'
  end function backup_name

  !> Returns a value of BASE_identity.txt, which says to which run the files belong; empty if the value is missing.
  function stored(self, key) result(value)
    class(run_t), intent(in) :: self
    character(*), intent(in) :: key
    character(:), allocatable :: value, text, problem
    integer :: first
    value = ''
    if (.not. file_exists(self%base//'_identity.txt')) return
    call read_text_file(self%base//'_identity.txt', text, problem)
    if (allocated(problem)) return
    first = index(text, NL//key//' = ')
    if (first == 0) return
    value = text(first + len(key) + 4:)
    value = value(:index(value//NL, NL) - 1)
  end function stored

  !> Decides whether this run may continue from a checkpoint of the run `was`. Fails, unless the user `accepts` the differences, if
  !> the checkpoint depends on an input that differs, if the other files are of another run, or if there are `conflicts`. The
  !> declarations of keys say on which of them checkpoints depend. Adds a line to `remarks` for each other input that differs, and
  !> for each difference that is accepted. Collective.
  subroutine run_judge(self, was, conflicts, accepts, remarks, failure)
    class(run_t), intent(inout) :: self
    type(identity_t), intent(in) :: was
    type(message_list_t), intent(in) :: conflicts
    logical, intent(in) :: accepts
    type(message_list_t), intent(inout) :: remarks
    type(failure_t), intent(inout) :: failure
    type(change_t), allocatable :: changes(:)
    type(message_list_t) :: refused
    character(:), allocatable :: id, text
    integer :: i
    if (failure%failed) return
    id = ''
    if (self%world%is_root) id = stored(self, 'id')
    call self%world%broadcast_text(id)
    if (was%is_known()) then
      if (id /= '' .and. id /= was%id) call refused%add('the checkpoint belongs to run '//was%id// &
                                                        ', but the other files here belong to run '//id)
      call list_changes(was%inputs, self%identity%inputs, changes)
      do i = 1, size(changes)
        if (is_one_of(changes(i)%name, self%state_keys)) then
          call refused%add(changes(i)%text())
        else
          call remarks%add('changed   '//changes(i)%text())
        end if
      end do
      if (was%version /= self%identity%version) call remarks%add('changed   flusi-msm '//self%identity%version// &
                                                                 ', was '//was%version)
    else
      call remarks%add('notice: the checkpoint does not name its run, and its inputs cannot be compared with this input')
    end if
    do i = 1, conflicts%count()
      call refused%add(conflicts%text(i))
    end do
    if (id /= '') then
      self%identity%id = id
    else if (was%is_known()) then
      self%identity%id = was%id
    end if
    if (accepts) then
      do i = 1, refused%count()
        call remarks%add('accepted  '//refused%text(i))
      end do
    else if (refused%count() > 0) then
      text = 'the checkpoint does not fit these inputs:'
      do i = 1, refused%count()
        text = text//NL//'  '//refused%text(i)
      end do
      call failure%raise(text//NL//'  --accept-changes continues nevertheless')
    end if
  end subroutine run_judge

  !> Tells whether the name of a key matches one of the patterns.
  logical function is_one_of(name, patterns)
    character(*), intent(in) :: name
    type(message_list_t), intent(in) :: patterns
    integer :: i
    is_one_of = .false.
    do i = 1, patterns%count()
      is_one_of = is_one_of .or. matches_name(name, patterns%text(i))
    end do
  end function is_one_of

  !> Moves away the files of an earlier run, if `check_new` decided so, and writes BASE_identity.txt, which says to which run the
  !> files belong. Fails if a file cannot be moved or written. Collective.
  subroutine run_settle(self, outcome)
    class(run_t), intent(inout) :: self
    type(outcome_t), intent(inout) :: outcome
    type(failure_t) :: own, failure
    if (outcome%failure%failed) return
    if (self%world%is_root) then
      if (self%moves) call move_earlier(self, own)
      if (.not. own%failed .and. stored(self, 'id') /= self%identity%id) call write_identity(self, own)
    end if
    call broadcast_failure(self%world, own, failure)
    if (failure%failed) call outcome%fail(OUTCOME_UNWRITABLE, failure%reason)
  end subroutine run_settle

  !> Moves the files of an earlier run into a folder of their own. Fails if one of its backups has to stay.
  subroutine move_earlier(self, failure)
    class(run_t), intent(in) :: self
    type(failure_t), intent(inout) :: failure
    type(message_list_t) :: patterns, found
    character(:), allocatable :: folder
    integer :: i
    ! Backups go first. If the program is then interrupted, a restart finds no backup of the earlier run.
    call patterns%add(self%base//'_backup#.h5')
    do i = 1, self%patterns%count()
      call patterns%add(self%patterns%text(i))
    end do
    call patterns%add(self%base//'_identity.txt')
    call find_results(patterns, self%input_files, found)
    if (found%count() == 0) return
    call move_to_folder(found, self%base, folder, failure)
    if (failure%failed) return
    write (error_unit, '(a)') 'notice: '//number_text(found%count())//' files of an earlier run were moved to '//folder
    do i = 0, 1
      ! A backup that this run reads cannot be moved, but a restart would take it for a backup of this run.
      if (has_file(backup_name(self, i))) call failure%raise(backup_name(self, i)//': this file of an earlier run is an input '// &
                                                                'of this run: give it another name')
    end do
    flush (error_unit)
  end subroutine move_earlier

  !> Writes BASE_identity.txt, which says which run the files belong to.
  subroutine write_identity(self, failure)
    class(run_t), intent(in) :: self
    type(failure_t), intent(inout) :: failure
    call write_text(self%base//'_identity.txt', '% The run to which these files belong, by '//self%program//NL// &
                    'id = '//self%identity%id//NL//'input = '//self%ini//NL// &
                    'fingerprint = '//self%identity%fingerprint()//NL//'version = '//self%identity%version//NL// &
                    'begun = '//date_and_clock(), failure)
  end subroutine write_identity

  !> Unlocks the files. It is safe to call this after a failure of `begin`.
  subroutine run_finish(self)
    class(run_t), intent(inout) :: self
    call self%lock%release()
  end subroutine run_finish
end module common_run
