! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds how a simulation starts: from which parameter file, and from the beginning or from a backup.
module simulation_start
  implicit none
  private
  public :: simulation_start_t

  !> Holds what a program decides before a simulation starts.
  type :: simulation_start_t
    character(:), allocatable :: ini          !< parameter file
    logical :: restart = .false.
    character(:), allocatable :: restart_file !< empty: the newest valid backup
    logical :: overwrite = .false.            !< move the results of an earlier run to another folder
    logical :: accepts = .false.              !< a restart accepts inputs that do not fit the checkpoint
  end type simulation_start_t
end module simulation_start
