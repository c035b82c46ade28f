! SPDX-License-Identifier: GPL-3.0-or-later
!> Renames files, removes them and forces them to the disk, which Fortran cannot do.
!>
!> A file is replaced safely by writing it under a temporary name and calling `replace_file`: whoever
!> opens the final name finds either the old content or the new one, complete.
module base_files
  use base_errors, only: failure_t
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_long, c_ptr, c_null_char, c_associated
  implicit none
  private
  public :: file_exists, rename_file, remove_file, empty_file, replace_file
  public :: join_path, folder_of, name_of, stem_of, real_path, make_folder, link_file

  ! fopen and fileno instead of open: open takes a variable argument list, which no portable
  ! Fortran interface can describe.
  interface
    integer(c_int) function c_rename(from, to) bind(C, name='rename')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: from(*), to(*)
    end function c_rename

    ! The mode has type mode_t, an unsigned int.
    integer(c_int) function c_mkdir(path, mode) bind(C, name='mkdir')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function c_mkdir

    integer(c_int) function c_link(from, to) bind(C, name='link')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: from(*), to(*)
    end function c_link

    integer(c_int) function c_unlink(path) bind(C, name='unlink')
      import :: c_int, c_char
      character(kind=c_char), intent(in) :: path(*)
    end function c_unlink

    ! The length has type off_t, a long on every 64-bit system.
    integer(c_int) function c_truncate(path, length) bind(C, name='truncate')
      import :: c_int, c_long, c_char
      character(kind=c_char), intent(in) :: path(*)
      integer(c_long), value :: length
    end function c_truncate

    type(c_ptr) function c_fopen(path, mode) bind(C, name='fopen')
      import :: c_ptr, c_char
      character(kind=c_char), intent(in) :: path(*), mode(*)
    end function c_fopen

    integer(c_int) function c_fileno(stream) bind(C, name='fileno')
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
    end function c_fileno

    integer(c_int) function c_fsync(descriptor) bind(C, name='fsync')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_fsync

    type(c_ptr) function c_realpath(path, resolved) bind(C, name='realpath')
      import :: c_ptr, c_char
      character(kind=c_char), intent(in) :: path(*)
      character(kind=c_char), intent(out) :: resolved(*)
    end function c_realpath

    integer(c_int) function c_fclose(stream) bind(C, name='fclose')
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
    end function c_fclose
  end interface

contains

  !> Tells whether `path` names an existing file.
  logical function file_exists(path)
    character(*), intent(in) :: path
    inquire (file=path, exist=file_exists)
  end function file_exists

  !> Renames a file, replacing an existing `to`; atomic within one file system. Does nothing after a failure; fails if the file
  !> cannot get this name.
  subroutine rename_file(from, to, failure)
    character(*), intent(in) :: from, to
    type(failure_t), intent(inout) :: failure
    if (failure%failed) return
    if (c_rename(from//c_null_char, to//c_null_char) /= 0) call failure%raise(from//': cannot be renamed to '//to)
  end subroutine rename_file

  !> Removes a file, also after a failure. Fails if it cannot be removed, for instance because it is missing; without `failure`
  !> that does not matter.
  subroutine remove_file(path, failure)
    character(*), intent(in) :: path
    type(failure_t), intent(inout), optional :: failure
    logical :: is_removed
    is_removed = c_unlink(path//c_null_char) == 0
    if (present(failure) .and. .not. is_removed) call failure%raise(path//': cannot be removed')
  end subroutine remove_file

  !> Makes a folder. Does nothing after a failure; fails if there is something of this name, or it cannot be made.
  subroutine make_folder(path, failure)
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    integer(c_int), parameter :: ALL_RIGHTS = int(o'777', c_int) ! without the rights that the mask of the user removes
    if (failure%failed) return
    if (c_mkdir(path//c_null_char, ALL_RIGHTS) /= 0) call failure%raise( &
      path//': this folder cannot be made: is the disk full, or the folder above it read-only?')
  end subroutine make_folder

  !> Gives an existing file a second name; `is_linked` is false if something has that name already, or if the file system has no
  !> links. Of several processes, also on different machines, only one succeeds, even on a network file system without exclusive
  !> creation.
  subroutine link_file(from, to, is_linked)
    character(*), intent(in) :: from, to
    logical, intent(out) :: is_linked
    is_linked = c_link(from//c_null_char, to//c_null_char) == 0
  end subroutine link_file

  !> Makes an existing file empty, even if it is open elsewhere; its space is free at once. Fails if it cannot; without
  !> `failure` that does not matter.
  subroutine empty_file(path, failure)
    character(*), intent(in) :: path
    type(failure_t), intent(inout), optional :: failure
    logical :: is_empty
    is_empty = c_truncate(path//c_null_char, 0_c_long) == 0
    if (present(failure) .and. .not. is_empty) call failure%raise(path//': cannot be made empty')
  end subroutine empty_file

  !> Waits until the content of a file, or the entries of a folder, are on the disk. Does nothing after a failure.
  subroutine sync_path(path, failure)
    character(*), intent(in) :: path
    type(failure_t), intent(inout) :: failure
    type(c_ptr) :: stream
    logical :: is_on_disk, is_closed
    if (failure%failed) return
    stream = c_fopen(path//c_null_char, 'r'//c_null_char)
    is_on_disk = c_associated(stream)
    if (is_on_disk) then
      is_on_disk = c_fsync(c_fileno(stream)) == 0
      is_closed = c_fclose(stream) == 0
      is_on_disk = is_on_disk .and. is_closed
    end if
    if (.not. is_on_disk) call failure%raise(path//': cannot be flushed to the disk; is it full?')
  end subroutine sync_path

  !> Puts the complete file `temporary` in the place of `path`. With `durable`, the content is forced to the disk before the rename
  !> and the rename after it, so that either the old or the new file is complete after a power failure. Does nothing after an
  !> earlier failure; fails if it cannot do so.
  subroutine replace_file(temporary, path, durable, failure)
    character(*), intent(in) :: temporary, path
    logical, intent(in) :: durable
    type(failure_t), intent(inout) :: failure
    type(failure_t) :: unsynced
    if (durable) call sync_path(temporary, failure)
    call rename_file(temporary, path, failure)
    if (.not. durable .or. failure%failed) return
    call sync_path(folder_of(path), unsynced)
    if (unsynced%failed) call failure%raise(path//': its folder cannot be flushed to the disk; is it full?')
  end subroutine replace_file

  !> Returns `folder`/`name`; an empty folder is the current one.
  pure function join_path(folder, name) result(path)
    character(*), intent(in) :: folder, name
    character(:), allocatable :: path
    if (len_trim(folder) == 0) then
      path = name
    else if (folder(len_trim(folder):len_trim(folder)) == '/') then
      path = trim(folder)//name
    else
      path = trim(folder)//'/'//name
    end if
  end function join_path

  !> Returns the folder part of a path, '.' if it has none.
  pure function folder_of(path) result(folder)
    character(*), intent(in) :: path
    character(:), allocatable :: folder
    integer :: slash
    slash = index(path, '/', back=.true.)
    if (slash == 0) then
      folder = '.'
    else if (slash == 1) then
      folder = '/'
    else
      folder = path(:slash - 1)
    end if
  end function folder_of

  !> Returns the last part of a path.
  pure function name_of(path) result(name)
    character(*), intent(in) :: path
    character(:), allocatable :: name
    name = trim(path(index(path, '/', back=.true.) + 1:))
  end function name_of

  !> Returns the last part of a path up to `ending`, if that is in it.
  pure function stem_of(path, ending) result(stem)
    character(*), intent(in) :: path, ending
    character(:), allocatable :: stem
    stem = name_of(path)
    if (index(stem, ending, back=.true.) > 1) stem = stem(:index(stem, ending, back=.true.) - 1)
  end function stem_of

  !> Returns the canonical name of an existing file, which is absolute and has no links and dots. Returns `path` itself if there is
  !> no such file.
  function real_path(path) result(real_name)
    character(*), intent(in) :: path
    character(:), allocatable :: real_name
    integer, parameter :: PATH_MAX = 4096 ! of Linux; realpath writes no more
    character(PATH_MAX) :: resolved
    real_name = path
    if (.not. c_associated(c_realpath(path//c_null_char, resolved))) return
    real_name = resolved(:index(resolved, c_null_char) - 1)
  end function real_path
end module base_files
