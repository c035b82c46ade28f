! SPDX-License-Identifier: GPL-3.0-or-later
!> Mathematical constants and the exit codes of the programs.
module base_constants
  use base_kinds, only: rp
  implicit none
  private
  public :: PI, TWO_PI, IMAG, EXIT_OK, EXIT_FAILURE, EXIT_USER, EXIT_NUMERICAL, EXIT_STOPPED, &
            EXIT_UNWRITABLE, EXIT_MEMORY

  real(rp), parameter :: PI = 3.14159265358979323846_rp
  real(rp), parameter :: TWO_PI = 2*PI
  complex(rp), parameter :: IMAG = (0.0_rp, 1.0_rp)

  integer, parameter :: EXIT_OK = 0        !< the run reached its end
  integer, parameter :: EXIT_FAILURE = 1   !< a defect of the program
  integer, parameter :: EXIT_USER = 2      !< a mistake in the input; nothing was written
  integer, parameter :: EXIT_NUMERICAL = 3 !< NaN or blow-up; the last good checkpoint is kept
  integer, parameter :: EXIT_STOPPED = 4   !< stopped early on request, with a checkpoint: submit again
  integer, parameter :: EXIT_UNWRITABLE = 5 !< files cannot be written: the disk is full, or the folder read-only or missing
  integer, parameter :: EXIT_MEMORY = 6    !< the machine has not enough memory
end module base_constants
