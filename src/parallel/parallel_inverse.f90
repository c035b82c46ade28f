! SPDX-License-Identifier: GPL-3.0-or-later
!> Inverts a symmetric positive definite matrix that is too large for one rank. Each rank holds some of its rows.
!>
!> The sweep operator inverts the matrix in place, block by block of rows. With A divided into a pivot block I and the rest J it
!> computes
!>
!>     A_II <- -P,   A_IJ <- P A_IJ,   A_JI <- A_JI P,   A_JJ <- A_JJ - A_JI P A_IJ,   P = A_II^-1,
!>
!> and keeps A symmetric; after the sweeps of all blocks, A is minus its inverse (Goodnight 1979, DOI 10.2307/2683825). The rank of
!> a block sends P A_IJ to all, and every rank updates its own rows with one matrix product: 2 n^3 operations in all, evenly
!> distributed, and one broadcast for each block. A product with the inverse takes one broadcast and one reduction, where a product
!> with distributed triangular factors would take one of each for every block.
!>
!> One rank leads and asks for products, while the others serve:
!>
!>     if (world%is_root) then
!>       call inverse%multiply(v); ...; call inverse%release()
!>     else
!>       call inverse%serve()
!>     end if
module parallel_inverse
  use base_errors, only: require
  use base_kinds, only: rp
  use base_lapack, only: factorise, multiply, solve_factorised
  use parallel_world, only: world_t
  implicit none
  private
  public :: shared_inverse_t

  real(rp), parameter :: GOES_ON = 1.0_rp, ENDS = 0.0_rp !< command of the leader to the ranks that serve

  !> `init` allocates; `invert` copies its last block, if that is not full.
  type :: shared_inverse_t
    integer, allocatable :: own(:)         !< rows of the matrix that this rank holds, in ascending order
    !> (n, own) rows(:, k) is row own(k): of the matrix before `invert`, of minus its inverse afterwards.
    real(rp), allocatable :: rows(:, :)
    type(world_t), private :: world
    integer, private :: n = 0, width = 1   !< number of rows of the matrix, and of a block
    real(rp), allocatable, private :: pivot(:, :)   !< (width, width) P
    real(rp), allocatable, private :: panel(:, :)   !< (n, width) the transpose of P A_IJ
    real(rp), allocatable, private :: column(:, :)  !< (width, own) A_IJ of the own rows J
    real(rp), allocatable, private :: message(:)    !< (n + 1) word of the leader, and a vector
    real(rp), allocatable, private :: sums(:)       !< (n)
  contains
    procedure :: init => inverse_init
    procedure :: invert => inverse_invert
    procedure :: multiply => inverse_multiply
    procedure :: serve => inverse_serve
    procedure :: release => inverse_release
    procedure :: memory_bytes => inverse_memory_bytes
  end type shared_inverse_t

contains

  !> Makes room for a matrix of n rows, in blocks of `width` rows that the ranks of `world` hold in turn. The same on all ranks.
  subroutine inverse_init(self, world, n, width)
    class(shared_inverse_t), intent(out) :: self
    type(world_t), intent(in) :: world
    integer, intent(in) :: n, width
    integer :: i
    self%world = world
    self%n = n
    self%width = width
    self%own = pack([(i, i=1, n)], [(mod((i - 1)/width, world%size) == world%rank, i=1, n)])
    allocate (self%rows(n, size(self%own)), self%pivot(width, width), self%panel(n, width), &
              self%column(width, size(self%own)), self%message(n + 1), self%sums(n), source=0.0_rp)
  end subroutine inverse_init

  !> Replaces the matrix in `rows` by minus its inverse. `is_positive` is false, on all ranks, if the matrix is not positive
  !> definite; then `rows` are of no use. Collective.
  subroutine inverse_invert(self, is_positive)
    class(shared_inverse_t), intent(inout) :: self
    logical, intent(out) :: is_positive
    integer :: block, first, last, owner
    is_positive = .true.
    do block = 1, (self%n - 1)/self%width + 1
      first = (block - 1)*self%width + 1
      last = min(block*self%width, self%n)
      owner = mod(block - 1, self%world%size)
      if (owner == self%world%rank) call make_panel(self, first, last, is_positive)
      call send_panel(self, owner, last - first + 1, is_positive)
      if (.not. is_positive) return
      call sweep(self, first, last, owner == self%world%rank)
    end do
  end subroutine inverse_invert

  !> Computes P and the panel, which has P at the position of the pivot. On the rank that holds the pivot block of the rows first ..
  !> last.
  subroutine make_panel(self, first, last, is_positive)
    type(shared_inverse_t), intent(inout) :: self
    integer, intent(in) :: first, last
    logical, intent(out) :: is_positive
    real(rp) :: factor(last - first + 1, last - first + 1)
    integer :: at, c, b
    b = last - first + 1
    at = findloc(self%own, first, dim=1)
    factor = self%rows(first:last, at:at + b - 1)
    call factorise(factor, is_positive)
    if (.not. is_positive) return
    do c = 1, b
      self%pivot(:b, c) = 0
      self%pivot(c, c) = 1
      call solve_factorised(factor, self%pivot(:b, c))
    end do
    self%pivot(:b, :b) = 0.5_rp*(self%pivot(:b, :b) + transpose(self%pivot(:b, :b)))
    self%panel = 0
    call multiply(1.0_rp, self%rows(:, at:at + b - 1), self%pivot(:b, :b), self%panel(:, :b))
    self%panel(first:last, :b) = self%pivot(:b, :b)
  end subroutine make_panel

  !> Gives the panel of rank `owner`, b columns wide, to all ranks, and tells whether it exists.
  subroutine send_panel(self, owner, b, is_positive)
    type(shared_inverse_t), intent(inout), target :: self
    integer, intent(in) :: owner, b
    logical, intent(inout) :: is_positive
    real(rp), pointer, contiguous :: flat(:)
    self%message(1) = merge(GOES_ON, ENDS, is_positive)
    call self%world%broadcast_reals(self%message(:1), owner)
    is_positive = self%message(1) > 0.5_rp
    if (.not. is_positive) return
    flat(1:self%n*self%width) => self%panel
    call self%world%broadcast_reals(flat(:self%n*b), owner)
  end subroutine send_panel

  !> Updates the own rows with the panel of the pivot rows first .. last, which are on this rank if `is_own`.
  subroutine sweep(self, first, last, is_own)
    type(shared_inverse_t), intent(inout) :: self
    integer, intent(in) :: first, last
    logical, intent(in) :: is_own
    integer :: at, b, k
    b = last - first + 1
    self%column(:b, :) = self%rows(first:last, :)
    at = 0
    if (is_own) at = findloc(self%own, first, dim=1)
    if (is_own) self%column(:b, at:at + b - 1) = 0
    call multiply(-1.0_rp, self%panel(:, :b), self%column(:b, :), self%rows)
    do k = 1, size(self%own)
      self%rows(first:last, k) = matmul(self%panel(first:last, :b), self%column(:b, k))
    end do
    if (.not. is_own) return
    self%rows(:, at:at + b - 1) = self%panel(:, :b)
    self%rows(first:last, at:at + b - 1) = -self%panel(first:last, :b)
  end subroutine sweep

  !> Replaces v(n) by the inverse times v, on rank 0 of the world, while the others `serve`. One rank sums each component, in the
  !> order of the columns. Collective with `serve`.
  subroutine inverse_multiply(self, v)
    class(shared_inverse_t), intent(inout) :: self
    real(rp), intent(inout) :: v(:)
    call require(self%world%is_root, 'shared_inverse_t: only rank 0 asks for products')
    self%message(1) = GOES_ON
    self%message(2:) = v
    call self%world%broadcast_reals(self%message)
    call add_up(self)
    v = self%sums
  end subroutine inverse_multiply

  !> Takes part in the products that rank 0 asks for, until it ends the service. On the other ranks.
  subroutine inverse_serve(self)
    class(shared_inverse_t), intent(inout) :: self
    do
      call self%world%broadcast_reals(self%message)
      if (self%message(1) < 0.5_rp) return
      call add_up(self)
    end do
  end subroutine inverse_serve

  !> Ends `serve` on the other ranks. On rank 0.
  subroutine inverse_release(self)
    class(shared_inverse_t), intent(inout) :: self
    self%message = ENDS
    call self%world%broadcast_reals(self%message)
  end subroutine inverse_release

  !> Computes the product with the vector of the message, on all ranks.
  subroutine add_up(self)
    type(shared_inverse_t), intent(inout) :: self
    integer :: k
    self%sums = 0
    do k = 1, size(self%own)
      self%sums(self%own(k)) = -dot_product(self%rows(:, k), self%message(2:))
    end do
    call self%world%sum_reals(self%sums)
  end subroutine add_up

  !> Returns the bytes that this rank holds.
  pure real(rp) function inverse_memory_bytes(self) result(bytes)
    class(shared_inverse_t), intent(in) :: self
    bytes = 0
    if (allocated(self%rows)) bytes = 8*(real(size(self%rows), rp) + size(self%panel) + size(self%column))
  end function inverse_memory_bytes
end module parallel_inverse
