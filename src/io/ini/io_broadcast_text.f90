! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads small text files from the disk once and gives them to every rank.
module io_broadcast_text
  use, intrinsic :: iso_fortran_env, only: int64
  use base_checksum, only: checksum_add, checksum_text
  use base_errors, only: message_list_t
  use base_files, only: file_exists, folder_of, join_path
  use base_kinds, only: i8
  use base_text, only: next_word, quoted
  use parallel_world, only: world_t
  implicit none
  private
  public :: read_text_file, read_broadcast_text, read_named_text, named_path, add_named_files, content_note

  integer(int64), parameter :: MAX_BYTES = 64*1024_int64**2

contains

  !> Reads a whole file into `text`, byte by byte. On success `problem` is not allocated; otherwise it is a message that names the
  !> file (missing, unreadable, a directory, too large).
  subroutine read_text_file(path, text, problem)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: text, problem
    character(256) :: reason
    integer(int64) :: n_bytes
    integer :: unit, status
    text = ''
    open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old', &
          iostat=status, iomsg=reason)
    if (status /= 0) then
      problem = path//': cannot be opened: '//trim(reason)
      return
    end if
    inquire (unit=unit, size=n_bytes)
    if (n_bytes < 0) then
      problem = path//': is not an ordinary file'
    else if (n_bytes > MAX_BYTES) then
      problem = path//': is larger than 64 MB, too large for a parameter file: check the name'
    else if (n_bytes > 0) then
      deallocate (text)
      allocate (character(n_bytes) :: text)
      read (unit, iostat=status, iomsg=reason) text
      if (status /= 0) problem = path//': cannot be read: '//trim(reason)
    end if
    close (unit)
  end subroutine read_text_file

  !> Reads the content of the file at `path`. With `world` the root rank reads it and all ranks get it; the call is then
  !> collective. If the file cannot be read, `problem` says why on all ranks, and `text` is empty.
  subroutine read_broadcast_text(path, text, problem, world)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: text, problem
    type(world_t), intent(in), optional :: world
    character(:), allocatable :: found
    logical :: reads
    reads = .true.
    if (present(world)) reads = world%is_root
    found = ''
    if (reads) then
      call read_text_file(path, text, problem)
      if (allocated(problem)) found = problem
    end if
    if (.not. allocated(text)) text = ''
    if (found /= '') text = ''
    if (present(world)) then
      call world%broadcast_text(found)
      call world%broadcast_text(text)
    end if
    if (allocated(problem)) deallocate (problem)
    if (found /= '') problem = found
  end subroutine read_broadcast_text

  !> Does `read_broadcast_text` for a file that the parameter file `ini` names. The file is searched in the current folder and then
  !> in the folder of `ini`; `path` is the name under which it was found.
  subroutine read_named_text(name, ini, path, text, problem, world)
    character(*), intent(in) :: name, ini
    character(:), allocatable, intent(out) :: path, text, problem
    type(world_t), intent(in), optional :: world
    path = named_path(name, ini, world)
    if (path == '') then
      text = ''
      problem = quoted(name)//' does not exist, neither here nor beside '//ini
    else
      call read_broadcast_text(path, text, problem, world)
    end if
  end subroutine read_named_text

  !> Returns the path of the file `name` that the parameter file `ini` names: in the current folder or in the folder of `ini`. It is
  !> empty if the file is in neither.
  function named_path(name, ini, world) result(path)
    character(*), intent(in) :: name, ini
    type(world_t), intent(in), optional :: world
    character(:), allocatable :: path
    logical :: reads
    reads = .true.
    if (present(world)) reads = world%is_root
    path = ''
    if (reads) then
      path = name
      if (.not. file_exists(path) .and. index(name, '/') /= 1) path = join_path(folder_of(ini), name)
      if (.not. file_exists(path)) path = ''
    end if
    if (present(world)) call world%broadcast_text(path)
  end function named_path

  !> Adds the paths of the existing files among those that `list` names. Names are separated by commas, may have a word and ::
  !> before them, and are searched as in named_path. Not collective.
  subroutine add_named_files(list, ini, paths)
    character(*), intent(in) :: list, ini
    type(message_list_t), intent(inout) :: paths
    character(:), allocatable :: name, path
    integer :: position, first, last
    logical :: found
    position = 1
    do
      call next_word(list, ',', position, first, last, found)
      if (.not. found) return
      name = trim(adjustl(list(first:last)))
      if (index(name, '::') > 0) name = name(index(name, '::') + 2:)
      if (name == '') cycle
      path = named_path(name, ini)
      if (path == '') cycle
      if (.not. file_exists(path//'/.')) call paths%add(path) ! no folder
    end do
  end subroutine add_named_files

  !> Returns ` {content CHECKSUM}` for the files that `list` names as for add_named_files; empty if none of them exists. Of files
  !> above 64 MB only the names count. Not collective.
  function content_note(list, ini) result(note)
    character(*), intent(in) :: list, ini
    character(:), allocatable :: note, content, problem
    type(message_list_t) :: paths
    character(16) :: digits
    integer(i8) :: total
    integer :: i
    note = ''
    call add_named_files(list, ini, paths)
    if (paths%count() == 0) return
    total = 0
    do i = 1, paths%count()
      call read_text_file(paths%text(i), content, problem)
      if (allocated(problem)) content = paths%text(i)
      total = checksum_add(ishftc(total, 7), checksum_text(content))
    end do
    write (digits, '(z16.16)') total
    note = ' {content '//digits//'}'
  end function content_note
end module io_broadcast_text
