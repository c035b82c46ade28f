! SPDX-License-Identifier: GPL-3.0-or-later
!> Opens the files of a run with the properties that all of them share. Without a run it only gathers the names of the series.
module simulation_opening
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use io_series, only: series_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: opening_t

  !> Holds what all files of a run share, the names of the series, and the first failure.
  type :: opening_t
    type(world_t) :: world
    character(:), allocatable :: name      !< first part of the names of files that carry the name of the run
    character(:), allocatable :: note      !< text on the units, stored with every file unless it is empty
    real(rp), allocatable :: restart_time  !< files keep their records before this time; not allocated in a new run
    logical :: is_listing = .false.        !< nothing is opened: there is no run
    type(message_list_t) :: series         !< names of the series, in their order
    type(failure_t) :: failure
  contains
    procedure :: open => opening_open
    procedure :: list => opening_list
  end type opening_t

contains

  !> Opens `series` in the file `path` and lists its name. After a first failure it opens no further file, but the caller can still
  !> close all series. Collective.
  subroutine opening_open(self, series, path, columns)
    class(opening_t), intent(inout) :: self
    type(series_t), intent(inout) :: series
    character(*), intent(in) :: path
    character(*), intent(in) :: columns(:) !< names with units, the time first
    call self%list(path)
    if (.not. self%is_listing) call series%open(self%world, path, columns, self%failure, restart_time=self%restart_time, &
                                                note=self%note)
  end subroutine opening_open

  !> Lists the name of a file that belongs to the series, or a pattern if only a run knows the name.
  subroutine opening_list(self, path)
    class(opening_t), intent(inout) :: self
    character(*), intent(in) :: path
    call self%series%add(path)
  end subroutine opening_list
end module simulation_opening
