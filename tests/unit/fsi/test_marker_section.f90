! SPDX-License-Identifier: GPL-3.0-or-later
!> Markers of strips that a two-dimensional flow sees as sections. The arguments are wing files of strips, made of
!> cells of the same length with three points across.
program test_marker_section
  use base_files, only: name_of
  use base_kinds, only: rp
  use fsi_markers, only: markers_t
  use marker_sheets, only: bend, grid_sheet, least_distance, read_sheet, shake, sheet_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: BOUND = 8*epsilon(1.0_rp)
  type(testkit_t) :: kit
  type(markers_t) :: markers
  type(sheet_t) :: sheet
  real(rp), allocatable :: x(:, :)
  character(1000) :: path
  integer :: i

  call kit%start(parallel=.false.)
  do i = 1, command_argument_count()
    call get_command_argument(i, path)
    sheet = read_sheet(trim(path))
    call kit%check('the strip '//name_of(trim(path))//' is there', size(sheet%triangles) > 0)
    call check_strip(1/16.0_rp, 16)
    call check_strip(1/7.3_rp, 7)
    call check_strip(0.013_rp, 77)
    call test_three_rows()
  end do
  sheet = grid_sheet(1.0_rp, 1.0_rp, 1, 1)
  call check_strip(0.1_rp, 10)
  sheet = grid_sheet(1.0_rp, 1.0_rp, 37, 41)
  call check_strip(1/12.0_rp, 12)
  call test_skewed()
  call test_curved()
  call test_folded()
  call test_power()
  call kit%finish()

contains

  subroutine site(h)
    real(rp), intent(in) :: h
    call markers%init(sheet%points, sheet%triangles, h, .true.)
    if (allocated(x)) deallocate (x)
    allocate (x(3, markers%n))
    call markers%positions(sheet%points, x)
  end subroutine site

  !> A flat strip of length 1: n equal intervals, the ends included, in the middle of its width.
  subroutine check_strip(h, n)
    real(rp), intent(in) :: h
    integer, intent(in) :: n
    real(rp) :: wanted(3, n + 1), middle
    integer :: k
    logical :: there
    call site(h)
    middle = (minval(sheet%points(2, :)) + maxval(sheet%points(2, :)))/2
    wanted = reshape([(real(k, rp)/n, middle, 0.0_rp, k=0, n)], [3, n + 1])
    call kit%check('a strip has n + 1 stations', markers%n == n + 1)
    if (markers%n /= n + 1) return
    there = .true.
    do k = 0, n
      there = there .and. any(norm2(x - spread(wanted(:, k + 1), 2, n + 1), 1) <= 4*BOUND)
    end do
    call kit%check('at equal steps in the middle of its width', there)
    call kit%check('both ends are edges', count(markers%is_edge) == 2 .and. &
                   all(markers%is_edge .eqv. (x(1, :) < BOUND .or. x(1, :) > 1 - BOUND)))
    call kit%check('the weights have the sum 1', all(markers%weights >= 0) .and. &
                   all(abs(sum(markers%weights, 1) - 1) <= BOUND))
    call kit%check_close('the distance is told', markers%least, 1/(n*h), rtol=1.0e-12_rp)
    call kit%check_close('and the gap', markers%gap, 1/(2*n*h), atol=1/16.0_rp)
  end subroutine check_strip

  !> Between columns of three points a marker has six of them; on a column, whose middle counts twice, three.
  subroutine test_three_rows()
    real(rp) :: middle
    real(rp), allocatable :: u(:, :), at_markers(:, :)
    integer :: k
    call kit%check('six points at most', size(markers%nodes, 1) == 6)
    allocate (u(3, size(sheet%points, 2)), at_markers(3, markers%n))
    middle = (minval(sheet%points(2, :)) + maxval(sheet%points(2, :)))/2
    u = 0
    where (abs(sheet%points(2, :) - middle) < 1.0e-6_rp) u(3, :) = 1
    call markers%positions(u, at_markers)
    call kit%check_below('the middle row moves an end half as far', &
                         maxval(abs(at_markers(3, pack([(k, k=1, markers%n)], markers%is_edge)) - 0.5_rp)), BOUND)
    ! Between columns, of z = 1 in the middle row and 0 at the sides, a line across sees the same.
    call kit%check_below('and everything else', maxval(abs(at_markers(3, :) - 0.5_rp)), 4*BOUND)
    u = 0
    u(3, :) = sheet%points(2, :) - middle
    call markers%positions(u, at_markers)
    call kit%check_below('a twist moves nothing', maxval(abs(at_markers)), BOUND)
  end subroutine test_three_rows

  !> Points that stand in no rows and columns: linear motions are exact, and a mean is the integral over the line.
  subroutine test_skewed()
    integer, parameter :: N = 40000 !< steps of the integral: its error is 1/N times the jumps of the slope
    real(rp), allocatable :: u(:, :), at_markers(:, :)
    real(rp) :: mean, worst, along
    integer :: k, j
    sheet = grid_sheet(1.0_rp, 1.0_rp, 9, 5)
    do k = 1, size(sheet%points, 2)
      associate (p => sheet%points(:, k))
        if (p(1) > 0.01_rp .and. p(1) < 0.99_rp) p(1) = p(1) + 0.03_rp*sin(11.0_rp*k)
        if (p(2) > 0.01_rp .and. p(2) < 0.99_rp) p(2) = p(2) + 0.06_rp*sin(7.0_rp*k)
      end associate
    end do
    call check_strip(0.13_rp, 8)
    allocate (u(3, size(sheet%points, 2)), at_markers(3, markers%n))
    u = reshape([(sin(1.3_rp*k), k=1, size(u))], shape(u))
    call markers%positions(u, at_markers)
    worst = 0
    do k = 1, markers%n
      if (markers%is_edge(k)) cycle
      mean = 0
      do j = 1, N
        along = (j - 0.5_rp)/N
        mean = mean + interpolated([x(1, k), along], u(3, :))/N
      end do
      worst = max(worst, abs(mean - at_markers(3, k)))
    end do
    call kit%check_below('a marker moves as the line across does in the mean', worst, 1.0e-6_rp)
  end subroutine test_skewed

  !> The linear function of the triangle that holds p.
  real(rp) function interpolated(p, values)
    real(rp), intent(in) :: p(2), values(:)
    real(rp) :: b(2), c(2), d(2), v, w
    integer :: t
    interpolated = huge(1.0_rp)
    do t = 1, size(sheet%triangles, 2)
      associate (corners => sheet%triangles(:, t))
        b = sheet%points(:2, corners(2)) - sheet%points(:2, corners(1))
        c = sheet%points(:2, corners(3)) - sheet%points(:2, corners(1))
        d = p - sheet%points(:2, corners(1))
        v = (d(1)*c(2) - d(2)*c(1))/(b(1)*c(2) - b(2)*c(1))
        w = (b(1)*d(2) - b(2)*d(1))/(b(1)*c(2) - b(2)*c(1))
        if (min(v, w, 1 - v - w) < -1.0e-12_rp) cycle
        interpolated = (1 - v - w)*values(corners(1)) + v*values(corners(2)) + w*values(corners(3))
        return
      end associate
    end do
  end function interpolated

  !> A strip bent into most of a circle: steps along its length, not across the opening.
  subroutine test_curved()
    sheet = grid_sheet(5.5_rp, 1.0_rp, 110, 3)
    call bend(sheet, 1.0_rp)
    call site(0.25_rp)
    call kit%check('a curved strip has its stations along the arc', markers%n == 23)
    call kit%check_below('on the polygon', maxval(abs(hypot(x(1, :), 1 - x(3, :)) - 1)), 4.0e-4_rp)
    call kit%check_below('in the middle', maxval(abs(x(2, :) - 0.5_rp)), BOUND)
    call kit%check_close('at equal distances', least_distance(x), 2*sin(0.125_rp), rtol=1.0e-3_rp)
  end subroutine test_curved

  !> A strip with a fold of a right angle: a station on the fold; stations that round-off does not change.
  subroutine test_folded()
    real(rp), allocatable :: before(:, :)
    integer :: k
    sheet = grid_sheet(2.0_rp, 1.0_rp, 20, 2)
    do k = 1, size(sheet%points, 2)
      associate (p => sheet%points(:, k))
        if (p(1) > 0.8_rp) p = [0.8_rp, p(2), p(1) - 0.8_rp]
      end associate
    end do
    call site(0.1_rp)
    call kit%check('a fold has a station', any(norm2(x - spread([0.8_rp, 0.5_rp, 0.0_rp], 2, markers%n), 1) < BOUND))
    call kit%check('but is no edge', count(markers%is_edge) == 2)
    before = x
    call shake(sheet, 1.0e-15_rp)
    call site(0.1_rp)
    call kit%check('round-off has no say', size(x) == size(before))
    if (size(x) == size(before)) call kit%check_below('in where', maxval(abs(x - before)), 1.0e-12_rp)
    call site(1.2_rp)
    call kit%check('a fold too near to an end is left out', markers%n == 2 .and. markers%left_out == 1)
    call kit%check_close('as far from the next as on its line', markers%least, hypot(0.8_rp, 1.2_rp)/1.2_rp, rtol=1.0e-12_rp)
  end subroutine test_folded

  !> The transpose, and what a load of constant strength across a column of three points does to them.
  subroutine test_power()
    real(rp), allocatable :: f(:, :), u(:, :), at_markers(:, :), at_nodes(:, :)
    real(rp) :: rows(17, 3)
    integer :: k
    sheet = grid_sheet(1.0_rp, 1.0_rp, 16, 2)
    call site(1/8.0_rp)
    allocate (f(3, markers%n), at_markers(3, markers%n))
    allocate (u(3, size(sheet%points, 2)), at_nodes(3, size(sheet%points, 2)))
    f = reshape([(sin(1.7_rp*k), k=1, size(f))], shape(f))
    u = reshape([(cos(0.9_rp*k), k=1, size(u))], shape(u))
    call markers%positions(u, at_markers)
    at_nodes = 0
    call markers%spread(f, at_nodes)
    call kit%check_close('forces do the same power on markers and points', sum(u*at_nodes), sum(f*at_markers), &
                         atol=size(f)*epsilon(1.0_rp))
    f = spread([0.0_rp, 0.0_rp, 1.0_rp], 2, markers%n)
    at_nodes = 0
    call markers%spread(f, at_nodes)
    rows = reshape(at_nodes(3, :), [17, 3])
    call kit%check_below('a line load goes to the points of its column as 1 : 2 : 1', &
                         maxval(abs(rows(1::2, :) - spread([0.25_rp, 0.5_rp, 0.25_rp], 1, 9))), BOUND)
    call kit%check_below('and to no others', maxval(abs(rows(2::2, :))), 0.0_rp)
  end subroutine test_power
end program test_marker_section
