! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists the retained Fourier modes and the ranks that own them.
!>
!> A *stick* is a pair (kx, ky) with all its retained kz, stored contiguously. Only sticks inside the
!> truncation exist; kx >= 0 since fields are real. The truncation `ellipsoid` keeps the modes
!> j with (jx/Kx)^2 + (jy/Ky)^2 + (jz/Kz)^2 < 1 and K_i = 2/3 (n_i/2 - 1), which is FLUSI's; `box`
!> keeps |j_i| < K_i; `none` keeps all.
!>
!> Ranks form a grid of `rows` x `columns`, rank = column*rows + row. Physical space: x is whole, y is split over the rows, z over
!> the columns. Columns kx are distributed to rows in turn, so that each row has long and short columns, then the sticks of a row
!> are split in equal counts over the columns. A foreign library that shares kx and ky in blocks has the sticks of its blocks
!> (`make_block_sticks`); some ranks then have few or none.
module spectral_sticks
  use base_constants, only: TWO_PI
  use base_errors, only: require
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use parallel_block, only: rows_t, split_evenly
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: sticks_t, make_sticks, make_block_sticks, kept_columns, process_grid, sphere_radius, DEALIAS_ELLIPSOID, DEALIAS_BOX, &
            DEALIAS_NONE, TRUNCATIONS

  integer, parameter :: DEALIAS_ELLIPSOID = 1, DEALIAS_BOX = 2, DEALIAS_NONE = 3
  !> Names of the truncations in inputs, outputs and checkpoints.
  type(named_kind_t), parameter :: TRUNCATIONS(3) = [named_kind_t('ellipsoid', DEALIAS_ELLIPSOID), &
                                                     named_kind_t('box', DEALIAS_BOX), named_kind_t('none', DEALIAS_NONE)]

  type :: sticks_t
    integer :: dealias = DEALIAS_ELLIPSOID
    integer :: nz = 1              !< points in z
    integer :: kz_limit = 0        !< largest retained |jz|
    integer :: nkz = 1             !< stored kz per stick: 0 .. limit, -limit .. -1
    integer :: n = 0               !< sticks of this rank
    real(rp), allocatable :: kx(:), ky(:) !< (n) wavenumbers of this rank's sticks
    real(rp), allocatable :: kz(:)        !< (nkz) wavenumbers along a stick
    integer, allocatable :: jx(:), jy(:)  !< (n) mode numbers
    integer, allocatable :: jz(:)         !< (nkz) mode numbers
    integer, allocatable :: jz_max(:)     !< (n) largest |jz| inside the truncation on each stick
    real(rp), allocatable :: weight(:)    !< (n) number of modes that a stored mode represents: 1 or 2
    integer :: zero = 0            !< local number of the stick (0,0), 0 if another rank has it
    type(rows_t) :: rows           !< place of this rank's sticks in the global order, for files
    !> All sticks of this rank's row, in the order in which the columns own them; not with `make_block_sticks`:
    integer :: n_row_sticks = 0
    integer :: n_row_kx = 0                  !< kx columns dealt to this row
    integer :: n_jx = 0                      !< kx columns of all rows
    integer, allocatable :: plane_index(:)   !< (n_row_sticks) place in a plane (n_row_kx, ny)
    real(rp), allocatable :: row_kx(:), row_ky(:) !< (n_row_sticks) wavenumbers
    integer, allocatable :: part_start(:)    !< (0:columns) first stick of each column, 0-based
  contains
    procedure :: truncate => sticks_truncate
  end type sticks_t

contains

  !> Chooses rows x columns = ranks: slabs (one row, a single exchange) while every column has a plane, otherwise the fewest rows
  !> that leave no rank without work. `wanted` > 0 prescribes the rows. With `blocks` every rank also gets at least one of blocks(1)
  !> columns kx and one of blocks(2) columns ky.
  pure subroutine process_grid(ranks, n, wanted_rows, rows, columns, possible, blocks)
    integer, intent(in) :: ranks, n(3), wanted_rows
    integer, intent(out) :: rows, columns
    logical, intent(out) :: possible
    integer, intent(in), optional :: blocks(2)
    integer :: r, most_rows, most_columns
    most_rows = n(2)
    most_columns = n(3)
    if (present(blocks)) then
      most_rows = min(most_rows, blocks(1))
      most_columns = min(most_columns, blocks(2))
    end if
    possible = .false.
    rows = 1
    columns = ranks
    do r = 1, ranks
      if (mod(ranks, r) /= 0) cycle
      if (wanted_rows > 0 .and. r /= wanted_rows) cycle
      if (ranks/r > most_columns .or. r > most_rows) cycle
      rows = r
      columns = ranks/r
      possible = .true.
      return
    end do
  end subroutine process_grid

  !> Returns the stick table of rank (row, column) (0-based) for a grid and a truncation.
  function make_sticks(grid, dealias, rows, columns, row, column) result(s)
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: dealias !< DEALIAS_*
    integer, intent(in) :: rows, columns, row, column
    type(sticks_t) :: s
    integer :: jx_limit, ix, iy, part, start, count, i_row, global, jz_top
    integer, allocatable :: global_of_row(:), jx_of_row(:), jy_of_row(:), top_of_row(:)

    call set_axes(s, grid, dealias)
    jx_limit = s%n_jx - 1
    s%n_row_kx = (jx_limit - row)/rows + 1
    if (jx_limit < row) s%n_row_kx = 0
    count = s%n_row_kx*grid%n(2)
    allocate (global_of_row(count), jx_of_row(count), jy_of_row(count), top_of_row(count))
    allocate (s%plane_index(count))

    global = 0
    i_row = 0
    do iy = 0, grid%n(2) - 1
      do ix = 0, jx_limit
        jz_top = top_mode(ix, signed_mode(iy, grid%n(2)), grid%n, dealias, s%kz_limit)
        if (jz_top < 0) cycle
        if (mod(ix, rows) == row) then
          i_row = i_row + 1
          jx_of_row(i_row) = ix
          jy_of_row(i_row) = signed_mode(iy, grid%n(2))
          top_of_row(i_row) = jz_top
          global_of_row(i_row) = global
          s%plane_index(i_row) = 1 + ix/rows + s%n_row_kx*iy
        end if
        global = global + 1
      end do
    end do
    s%n_row_sticks = i_row
    s%plane_index = s%plane_index(1:i_row)
    s%row_kx = TWO_PI/grid%length(1)*jx_of_row(1:i_row)
    s%row_ky = TWO_PI/grid%length(2)*jy_of_row(1:i_row)

    allocate (s%part_start(0:columns))
    do part = 0, columns - 1
      call split_evenly(i_row, columns, part, start, count)
      s%part_start(part) = start
    end do
    s%part_start(columns) = i_row

    call split_evenly(i_row, columns, column, start, count)
    call take_sticks(s, grid, jx_of_row(start + 1:start + count), jy_of_row(start + 1:start + count), &
                     top_of_row(start + 1:start + count), global_of_row(start + 1:start + count), global)
  end function make_sticks

  !> Returns the stick table of a rank that owns the blocks first(i) .. first(i)+count(i)-1 of kx (i = 1) and of the FFT indices
  !> of ky (i = 2), all 0-based.
  function make_block_sticks(grid, dealias, first, count) result(s)
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: dealias
    integer, intent(in) :: first(2), count(2)
    type(sticks_t) :: s
    integer, allocatable, dimension(:) :: jx, jy, top, number
    integer :: ix, iy, jz_top, global, n
    n = product(count)
    allocate (jx(n), jy(n), top(n), number(n))
    call set_axes(s, grid, dealias)
    s%n_row_kx = s%n_jx
    global = 0
    n = 0
    do iy = 0, grid%n(2) - 1
      do ix = 0, s%n_jx - 1
        jz_top = top_mode(ix, signed_mode(iy, grid%n(2)), grid%n, dealias, s%kz_limit)
        if (jz_top < 0) cycle
        if (all([ix, iy] >= first .and. [ix, iy] < first + count)) then
          n = n + 1
          jx(n) = ix
          jy(n) = signed_mode(iy, grid%n(2))
          top(n) = jz_top
          number(n) = global
        end if
        global = global + 1
      end do
    end do
    call take_sticks(s, grid, jx(:n), jy(:n), top(:n), number(:n), global)
  end function make_block_sticks

  !> Sets the components that are the same on all ranks: the modes along z, and the number of columns kx.
  subroutine set_axes(s, grid, dealias)
    type(sticks_t), intent(inout) :: s
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: dealias
    integer :: i
    call require(any(dealias == TRUNCATIONS%kind), 'make_sticks: unknown truncation')
    s%dealias = dealias
    s%nz = grid%n(3)
    s%kz_limit = mode_limit(grid%n(3), dealias)
    s%nkz = merge(grid%n(3), 2*s%kz_limit + 1, dealias == DEALIAS_NONE)
    allocate (s%jz(s%nkz), s%kz(s%nkz))
    do i = 1, s%nkz
      s%jz(i) = merge(i - 1, i - 1 - s%nkz, i - 1 <= s%kz_limit .and. 2*(i - 1) < max(s%nkz, 2))
    end do
    s%kz = TWO_PI/grid%length(3)*s%jz
    s%n_jx = kept_columns(grid, dealias)
  end subroutine set_axes

  !> Sets this rank's sticks, with modes jx, jy, the largest kz `top`, and the ascending numbers `global` among n_global.
  subroutine take_sticks(s, grid, jx, jy, top, global, n_global)
    type(sticks_t), intent(inout) :: s
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: jx(:), jy(:), top(:), global(:), n_global
    integer :: i
    s%n = size(jx)
    s%jx = jx
    s%jy = jy
    s%jz_max = top
    s%kx = TWO_PI/grid%length(1)*s%jx
    s%ky = TWO_PI/grid%length(2)*s%jy
    allocate (s%weight(s%n))
    ! kx = 0 and kx = nx/2 are their own mirror images: both halves of these planes are stored.
    s%weight = merge(1.0_rp, 2.0_rp, s%jx == 0 .or. (2*s%jx == grid%n(1)))
    do i = 1, s%n
      if (s%jx(i) == 0 .and. s%jy(i) == 0) s%zero = i
    end do
    s%rows = runs_of(global, n_global)
  end subroutine take_sticks

  !> Returns the number of columns kx that the truncation keeps.
  pure integer function kept_columns(grid, dealias)
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: dealias
    kept_columns = mode_limit(grid%n(1), dealias) + 1
  end function kept_columns

  !> Zeroes the modes of local stick `s` that lie outside the truncation; `line` is (nkz).
  pure subroutine sticks_truncate(self, s, line)
    class(sticks_t), intent(in) :: self
    integer, intent(in) :: s
    complex(rp), intent(inout) :: line(self%nkz)
    line(self%jz_max(s) + 2:self%nkz - self%jz_max(s)) = 0
  end subroutine sticks_truncate

  !> Returns the largest mode number kept along an axis of n points.
  pure integer function mode_limit(n, dealias) result(limit)
    integer, intent(in) :: n
    integer, intent(in) :: dealias
    if (dealias == DEALIAS_NONE .or. n == 1) then
      limit = n/2
    else
      limit = ceiling(cutoff(n)) - 1 ! strictly below the cutoff
    end if
  end function mode_limit

  !> Returns K of the 2/3 rule for n points.
  pure real(rp) function cutoff(n) result(k)
    integer, intent(in) :: n
    k = real(2*(n/2 - 1), rp)/3
  end function cutoff

  !> Returns the largest radius [1/L] of a sphere of wavenumbers inside the ellipsoid; of a circle in a two-dimensional grid.
  pure real(rp) function sphere_radius(grid) result(radius)
    type(grid_t), intent(in) :: grid
    integer :: i
    radius = huge(radius)
    do i = merge(2, 1, grid%is_2d), 3
      radius = min(radius, cutoff(grid%n(i))*TWO_PI/grid%length(i))
    end do
  end function sphere_radius

  !> Returns the signed mode number of FFT index i (0-based) out of n; the Nyquist mode counts as negative.
  pure integer function signed_mode(i, n) result(j)
    integer, intent(in) :: i, n
    j = modulo(i + n/2, n) - n/2
  end function signed_mode

  !> Returns the largest |jz| kept on stick (jx, jy), -1 if the stick is outside. Integer comparisons would overflow for large
  !> grids, so the quadratic form is evaluated in reals.
  pure integer function top_mode(jx, jy, n, dealias, kz_limit) result(top)
    integer, intent(in) :: jx, jy, n(3), kz_limit
    integer, intent(in) :: dealias
    real(rp) :: r2
    integer :: jz
    top = -1
    if (abs(jy) > mode_limit(n(2), dealias)) return
    top = kz_limit
    if (dealias /= DEALIAS_ELLIPSOID) return
    r2 = square_ratio(jx, n(1)) + square_ratio(jy, n(2))
    ! Modes at least one mode number above the ellipsoid are outside.
    do jz = min(kz_limit, int(sqrt(max(0.0_rp, 1 - r2))*max(1.0_rp, cutoff(n(3)))) + 1), 0, -1
      ! Modes on the ellipsoid are outside, whatever the last bit of the sum.
      if (r2 + square_ratio(jz, n(3)) < 1 - 1.0e-12_rp) then
        top = jz
        return
      end if
    end do
    top = -1
  end function top_mode

  !> Returns (j/K)^2, and 0 for the direction without modes.
  pure real(rp) function square_ratio(j, n) result(ratio)
    integer, intent(in) :: j, n
    ratio = 0
    if (n > 1) ratio = (j/cutoff(n))**2
  end function square_ratio

  !> Describes increasing global numbers as regular runs.
  pure function runs_of(numbers, n_global) result(rows)
    integer, intent(in) :: numbers(:), n_global
    type(rows_t) :: rows
    integer, allocatable :: start(:), count(:), stride(:)
    integer :: i, n_runs
    allocate (start(size(numbers)), count(size(numbers)), stride(size(numbers)))
    n_runs = 0
    do i = 1, size(numbers)
      if (n_runs > 0) then
        if (count(n_runs) == 1) stride(n_runs) = numbers(i) - start(n_runs)
        if (numbers(i) == start(n_runs) + count(n_runs)*stride(n_runs)) then
          count(n_runs) = count(n_runs) + 1
          cycle
        end if
      end if
      n_runs = n_runs + 1
      start(n_runs) = numbers(i)
      count(n_runs) = 1
      stride(n_runs) = 1
    end do
    rows%n = n_global
    rows%n_local = size(numbers)
    rows%start = start(1:n_runs)
    rows%count = count(1:n_runs)
    rows%stride = stride(1:n_runs)
  end function runs_of
end module spectral_sticks
