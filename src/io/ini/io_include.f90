! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads parameter files that include others:
!>
!>     [include]
!>     file = trained.ini wing.ini
!>
!> A value in a file has priority over values in the files that it includes, wherever [include] stands. Two files that are included
!> by the same file must not give the same key. Files are searched in the current folder, then in the folder of the including file.
module io_include
  use base_errors, only: message_list_t
  use base_files, only: real_path
  use base_text, only: BLANKS, next_word, number_text
  use io_ini, only: ini_document_t
  use io_registry, only: registry_t
  use io_broadcast_text, only: read_named_text
  use parallel_world, only: world_t
  implicit none
  private
  public :: add_included, register_include, INCLUDE_SECTION

  !> Section and key of an entry.
  character(*), parameter :: INCLUDE_SECTION = 'include', INCLUDED_FILE = 'file'

  !> A file that was read, and the number of the file that included it (0: none).
  type :: source_t
    character(:), allocatable :: name, real_name
    integer :: parent = 0
    integer :: depth = 0
  end type source_t

contains

  !> Adds [include] to `registry`, so that its files may include others.
  subroutine register_include(registry)
    type(registry_t), intent(inout) :: registry
    call registry%add_section(INCLUDE_SECTION, 'parameters from other files')
    call registry%add_text(INCLUDE_SECTION, INCLUDED_FILE, '', &
                           'names of parameter files, separated by blanks; the program looks in the current folder, then in '// &
                           'the folder of this file; the keys of this file take precedence over theirs')
  end subroutine register_include

  !> Puts the sections and keys of all files that `document` includes, directly or not, behind its own. A file that is included
  !> twice is read once. Missing files and files that include themselves are added to `errors`, the real paths of the files that
  !> were read to `paths`. With `world` the root rank reads, and the call is collective.
  subroutine add_included(document, errors, paths, world)
    type(ini_document_t), intent(inout) :: document
    type(message_list_t), intent(inout) :: errors, paths
    type(world_t), intent(in), optional :: world
    type(source_t), allocatable :: sources(:)
    character(:), allocatable :: names
    integer :: e, position, first, last, parent
    logical :: found
    allocate (sources(1))
    sources(1)%name = document%name
    sources(1)%real_name = real_path(document%name)
    e = 0
    do while (e < document%n_entries) ! what is appended is processed later
      e = e + 1
      if (document%sections(document%entries(e)%section)%name /= INCLUDE_SECTION) cycle
      if (document%entries(e)%key /= INCLUDED_FILE) cycle
      parent = index_of(sources, document%entries(e)%file)
      names = document%entries(e)%value
      position = 1
      do
        call next_word(names, BLANKS, position, first, last, found)
        if (.not. found) exit
        call add_one(document, e, names(first:last), parent, sources, errors, world)
      end do
    end do
    do e = 2, size(sources)
      call paths%add(sources(e)%real_name)
    end do
  end subroutine add_included

  !> Adds the file `name`, which entry e of `document` includes.
  subroutine add_one(document, e, name, parent, sources, errors, world)
    type(ini_document_t), intent(inout) :: document
    integer, intent(in) :: e, parent
    character(*), intent(in) :: name
    type(source_t), allocatable, intent(inout) :: sources(:)
    type(message_list_t), intent(inout) :: errors
    type(world_t), intent(in), optional :: world
    type(ini_document_t) :: included
    type(source_t), allocatable :: more(:)
    character(:), allocatable :: place, path, text, problem, chain, real_name
    integer :: i, n
    associate (entry => document%entries(e))
      place = entry%file//':'//number_text(entry%line)//': ['//INCLUDE_SECTION//'] '//INCLUDED_FILE//': '
      call read_named_text(name, entry%file, path, text, problem, world)
    end associate
    if (allocated(problem)) then
      call errors%add(place//problem)
      return
    end if
    real_name = real_path(path)
    if (present(world)) call world%broadcast_text(real_name)
    i = parent
    chain = path
    do while (i > 0)
      chain = sources(i)%name//' includes '//chain
      if (sources(i)%real_name == real_name) then
        call errors%add(place//'a file must not include itself: '//chain)
        return
      end if
      i = sources(i)%parent
    end do
    do i = 1, size(sources)
      if (sources(i)%real_name == real_name) return
    end do
    n = size(sources)
    allocate (more(n + 1))
    more(:n) = sources
    more(n + 1)%name = path
    more(n + 1)%real_name = real_name
    more(n + 1)%parent = parent
    more(n + 1)%depth = sources(parent)%depth + 1
    call move_alloc(more, sources)
    call included%parse(text, path, errors)
    call document%append(included, sources(n + 1)%depth)
  end subroutine add_one

  !> Returns the index of the source called `name`.
  pure integer function index_of(sources, name) result(i)
    type(source_t), intent(in) :: sources(:)
    character(*), intent(in) :: name
    do i = size(sources), 2, -1
      if (sources(i)%name == name) return
    end do
    i = 1
  end function index_of
end module io_include
