! SPDX-License-Identifier: GPL-3.0-or-later
!> Says how a simulation starts: from which file, from the beginning or from a backup.
module simulation_start
  implicit none
  private
  public :: simulation_start_t

  !> What a program decides before a simulation starts.
  type :: simulation_start_t
    character(:), allocatable :: ini          !< parameter file
    logical :: restart = .false.
    character(:), allocatable :: restart_file !< empty: the newest valid backup
    logical :: overwrite = .false.            !< results of an earlier run move aside
    logical :: accepts = .false.              !< a restart takes inputs that do not fit the checkpoint
  end type simulation_start_t
end module simulation_start
