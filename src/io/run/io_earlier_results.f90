! SPDX-License-Identifier: GPL-3.0-or-later
!> Moves the results of an earlier run aside when a new run would overwrite them. It never removes them.
module io_earlier_results
  use base_errors, only: failure_t, message_list_t
  use base_files, only: file_exists, folder_of, join_path, make_folder, name_of, real_path, rename_file
  use base_listing, only: list_folder, matches_name
  use base_text, only: number_text
  implicit none
  private
  public :: find_results, move_to_folder, move_earlier_file

  character(*), parameter, public :: EARLIER_SUFFIX = '.earlier' !< what is added to the name of a file

contains

  !> Returns the paths of the files whose names match one of `patterns` (see matches_name), each with its folder before it, and
  !> which are not among `inputs`.
  subroutine find_results(patterns, inputs, found)
    type(message_list_t), intent(in) :: patterns, inputs
    type(message_list_t), intent(out) :: found
    type(message_list_t) :: names
    character(:), allocatable :: folder, path
    integer :: p, i, k
    logical :: is_input
    do p = 1, patterns%count()
      folder = folder_of(patterns%text(p))
      call list_folder(folder, names)
      do i = 1, names%count()
        if (.not. matches_name(names%text(i), name_of(patterns%text(p)))) cycle
        path = names%text(i)
        if (folder /= '.') path = join_path(folder, path)
        is_input = .false.
        do k = 1, inputs%count()
          is_input = is_input .or. real_path(path) == real_path(inputs%text(k))
        end do
        do k = 1, found%count() ! by another pattern
          is_input = is_input .or. path == found%text(k)
        end do
        if (.not. is_input) call found%add(path)
      end do
    end do
  end subroutine find_results

  !> Moves files into the first of `beside`'s folder/earlier_1, earlier_2, ... that does not exist; `folder` is then its name.
  subroutine move_to_folder(paths, beside, folder, failure)
    type(message_list_t), intent(in) :: paths
    character(*), intent(in) :: beside
    character(:), allocatable, intent(out) :: folder
    type(failure_t), intent(inout) :: failure
    integer, parameter :: MOST = 9999
    integer :: i
    logical :: ok
    ok = .false.
    do i = 1, MOST
      folder = 'earlier_'//number_text(i)
      if (folder_of(beside) /= '.') folder = join_path(folder_of(beside), folder)
      call make_folder(folder, ok)
      if (ok .or. .not. file_exists(folder//'/.')) exit
    end do
    if (.not. ok) then
      call failure%raise(folder//': this folder cannot be made: is the disk full, or the folder above it read-only?')
      return
    end if
    do i = 1, paths%count()
      call rename_file(paths%text(i), join_path(folder, name_of(paths%text(i))), ok)
      if (.not. ok) call failure%raise(paths%text(i)//': cannot be moved to '//folder)
    end do
  end subroutine move_to_folder

  !> Renames the file `path`, if there is one, to its name with EARLIER_SUFFIX and replaces a file of that name; `has_moved`
  !> tells.
  subroutine move_earlier_file(path, has_moved)
    character(*), intent(in) :: path
    logical, intent(out) :: has_moved
    has_moved = file_exists(path)
    if (has_moved) call rename_file(path, path//EARLIER_SUFFIX, has_moved)
  end subroutine move_earlier_file
end module io_earlier_results
