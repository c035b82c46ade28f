! SPDX-License-Identifier: GPL-3.0-or-later
!> Factorises sparse matrices by Cholesky's method with one symbolic analysis. The statics use it as the test of stability.
!>
!> The library is CHOLMOD (Debian: libsuitesparse-dev): Chen, Davis, Hager & Rajamanickam 2008,
!> doi:10.1145/1391989.1391995. Its supernodal factorisation with AMD is faster here than MUMPS
!> (docs/results/statics-results.md). The algorithms only test whether a matrix is positive definite, and do not need the inertia
!> that MUMPS returns.
module solid_cholesky
  use base_errors, only: require
  use base_kinds, only: rp
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_null_ptr, c_associated
  implicit none
  private
  public :: cholesky_t

  integer, parameter, public :: CHOLESKY_AUTO = 0, CHOLESKY_SUPERNODAL = 1

  !> A factorisation A = L L^T. Not to be copied after `init`; `free` it.
  type :: cholesky_t
    private
    type(c_ptr) :: handle = c_null_ptr
    integer(c_int), pointer :: colptr(:) => null(), rowind(:) => null()
    integer :: n = 0
    integer, public :: n_factorisations = 0 !< attempts since `init`, failed ones included
  contains
    procedure :: init => cholesky_init
    procedure :: free => cholesky_free
    procedure :: factorise => cholesky_factorise
    procedure :: solve => cholesky_solve
    procedure :: reciprocal_condition => cholesky_reciprocal_condition
  end type cholesky_t

  interface
    integer(c_int) function solid_cholmod_analyse(handle, n, colptr, rowind, mode) bind(c)
      import :: c_ptr, c_int
      type(c_ptr), intent(inout) :: handle
      integer(c_int), value :: n, mode
      integer(c_int), intent(in) :: colptr(*), rowind(*)
    end function solid_cholmod_analyse
    integer(c_int) function solid_cholmod_factorise(handle, values) bind(c)
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: handle
      real(c_double), intent(in) :: values(*)
    end function solid_cholmod_factorise
    integer(c_int) function solid_cholmod_solve(handle, columns, b) bind(c)
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: handle
      integer(c_int), value :: columns
      real(c_double), intent(inout) :: b(*)
    end function solid_cholmod_solve
    real(c_double) function solid_cholmod_rcond(handle) bind(c)
      import :: c_ptr, c_double
      type(c_ptr), value :: handle
    end function solid_cholmod_rcond
    subroutine solid_cholmod_free(handle) bind(c)
      import :: c_ptr
      type(c_ptr), intent(inout) :: handle
    end subroutine solid_cholmod_free
  end interface

contains

  !> Orders and analyses a symmetric pattern, which its upper triangle gives: columns colptr(n+1) and rows rowind, both 0-based,
  !> rows ascending, with the diagonal.
  subroutine cholesky_init(self, colptr, rowind, mode)
    class(cholesky_t), intent(inout) :: self
    integer, intent(in) :: colptr(:), rowind(:)
    integer, intent(in), optional :: mode !< CHOLESKY_AUTO unless given
    integer :: chosen
    call self%free()
    chosen = CHOLESKY_AUTO
    if (present(mode)) chosen = mode
    self%n = size(colptr) - 1
    allocate (self%colptr(size(colptr)), self%rowind(size(rowind)))
    self%colptr = colptr
    self%rowind = rowind
    call require(solid_cholmod_analyse(self%handle, self%n, self%colptr, self%rowind, chosen) == 0, &
                 'cholesky_t: the analysis of the sparse pattern failed')
  end subroutine cholesky_init

  !> Releases the factor.
  subroutine cholesky_free(self)
    class(cholesky_t), intent(inout) :: self
    if (c_associated(self%handle)) call solid_cholmod_free(self%handle)
    if (associated(self%colptr)) deallocate (self%colptr)
    if (associated(self%rowind)) deallocate (self%rowind)
    self%handle = c_null_ptr
    self%n_factorisations = 0
  end subroutine cholesky_free

  !> Factorises the matrix with these values, in the order of the pattern. `is_spd` tells whether it is positive definite; only
  !> then may `solve` follow.
  subroutine cholesky_factorise(self, values, is_spd)
    class(cholesky_t), intent(inout) :: self
    real(rp), intent(in), contiguous :: values(:)
    logical, intent(out) :: is_spd
    integer :: status
    call require(c_associated(self%handle), 'cholesky_t%factorise before init')
    status = solid_cholmod_factorise(self%handle, values)
    call require(status >= 0, 'cholesky_t: a factorisation failed (out of memory?)')
    self%n_factorisations = self%n_factorisations + 1
    is_spd = status == 0
  end subroutine cholesky_factorise

  !> Replaces b(3, n/3, columns), or any array of the same length, by A^-1 b.
  subroutine cholesky_solve(self, columns, b)
    class(cholesky_t), intent(in) :: self
    integer, intent(in) :: columns
    real(rp), intent(inout) :: b(*)
    call require(solid_cholmod_solve(self%handle, columns, b) == 0, 'cholesky_t: the solution failed')
  end subroutine cholesky_solve

  !> Returns a cheap estimate of the reciprocal condition number of the last factorised matrix.
  real(rp) function cholesky_reciprocal_condition(self) result(rcond)
    class(cholesky_t), intent(in) :: self
    rcond = solid_cholmod_rcond(self%handle)
  end function cholesky_reciprocal_condition
end module solid_cholesky
