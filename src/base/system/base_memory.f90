! SPDX-License-Identifier: GPL-3.0-or-later
!> Ends the program with a message when an array is too large for the memory. The other ranks wait for this one and cannot get a
!> message; the launcher ends them.
!>
!>     allocate (u(n, m), stat=status)
!>     call check_allocation(status, [n, m], 8, 'what u is')
module base_memory
  use, intrinsic :: iso_fortran_env, only: error_unit
  use base_kinds, only: rp
  use base_outcome, only: exit_code_of, OUTCOME_NO_MEMORY
  use base_process, only: exit_with, launched_rank
  implicit none
  private
  public :: check_allocation, REAL_BYTES, COMPLEX_BYTES

  integer, parameter :: REAL_BYTES = storage_size(1.0_rp)/8, COMPLEX_BYTES = 2*REAL_BYTES

contains

  !> Ends the program as OUTCOME_NO_MEMORY unless `status` of an allocation is 0. The array has `extents` elements of so many
  !> `bytes` and holds `what`. Not collective.
  subroutine check_allocation(status, extents, bytes, what)
    integer, intent(in) :: status, extents(:), bytes
    character(*), intent(in) :: what
    if (status == 0) return
    write (error_unit, '(a,i0,a,es9.3,3a)') 'flusi-msm: rank ', launched_rank(), ' cannot allocate ', &
      product(real(extents, rp))*bytes, ' bytes (', what, '): use more machines, fewer ranks on each, or a coarser grid; '// &
      'flusi INI --dry-run shows the memory of a rank; ulimit -v and the job may allow less memory than the machine has'
    flush (error_unit)
    call exit_with(exit_code_of(OUTCOME_NO_MEMORY))
  end subroutine check_allocation
end module base_memory
