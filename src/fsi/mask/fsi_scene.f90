! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the data of a run that the description of insects needs: the grid, the end of the run, and the units of files.
module fsi_scene
  use base_kinds, only: rp
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: scene_t

  type :: scene_t
    type(grid_t) :: grid
    real(rp) :: t_end = 0     !< end of the run, T
    real(rp) :: metre = 0     !< one metre in L; 0: unknown
    real(rp) :: file_unit = 1 !< one unit of length of the parameter file, L
  end type scene_t
end module fsi_scene
