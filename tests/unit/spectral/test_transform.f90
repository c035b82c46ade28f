! SPDX-License-Identifier: GPL-3.0-or-later
!> A transform against mathematics: single modes, round trips, the stick table, and the pipeline against its kernels on
!> whole fields, on slab and pencil process grids.
!>
!> usage: test_transform [builtin|p3dfft]
program test_transform
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_named_kinds, only: kind_of, word_of
  use spectral_backends, only: make_transform, transform_choices_t, TRANSFORMS
  use spectral_grid, only: grid_t, make_grid
  use spectral_sticks, only: kept_columns, process_grid, DEALIAS_BOX, DEALIAS_ELLIPSOID, DEALIAS_NONE, TRUNCATIONS
  use spectral_transform, only: transform_t
  use test_pick, only: asked_transform
  use test_transform_kernels, only: square_kernels_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  integer :: rows

  call test%start(parallel=.true.)
  do rows = 1, test%world%size
    if (mod(test%world%size, rows) /= 0) cycle
    call check_grid([12, 10, 14], DEALIAS_NONE, rows)
    call check_grid([24, 20, 18], DEALIAS_ELLIPSOID, rows)
    call check_grid([16, 16, 20], DEALIAS_BOX, rows)
    call check_grid([1, 16, 24], DEALIAS_ELLIPSOID, rows)
    call check_grid([22, 34, 26], DEALIAS_ELLIPSOID, rows) ! prime factors 11, 17, 13
    call check_grid([34, 22, 86], DEALIAS_NONE, rows)
  end do
  call test%finish()

contains

  subroutine check_grid(n, dealias, rows)
    integer, intent(in) :: n(3), rows
    integer, intent(in) :: dealias
    class(transform_t), allocatable :: t
    type(failure_t) :: failure
    type(grid_t) :: grid
    character(60) :: name
    integer :: grid_rows, columns
    logical :: possible

    write (name, '(3(i0,1x),a,a,i0)') n, word_of(TRUNCATIONS, dealias), ', rows ', rows
    grid = make_grid(n, [1.5_rp, 2.0_rp, 2.5_rp])
    if (asked_transform() == 'p3dfft') then
      call process_grid(test%world%size, n, rows, grid_rows, columns, possible, [kept_columns(grid, dealias), n(2)])
      if (.not. possible) return
    end if
    call make_transform(t, test%world, grid, transform_choices_t(kind_of(TRANSFORMS, asked_transform()), &
                                                                  dealias, rows), 5, 2, failure)
    call test%check(trim(name)//': there is such a transform', .not. failure%failed)
    call check_table(t, trim(name))
    call check_modes(t, trim(name))
    call check_pipelines(t, trim(name))
    call t%free()
  end subroutine check_grid

  !> Every retained mode is owned once, and the number of modes is that of a direct count.
  subroutine check_table(t, name)
    class(transform_t), intent(in) :: t
    character(*), intent(in) :: name
    real(rp) :: owned(2), k(3)
    integer :: i, jx, jy, jz, n(3), expected
    n = t%grid%n
    k = 2*(n/2 - 1)/3.0_rp
    where (n == 1) k = 1
    owned = 0
    do i = 1, t%sticks%n
      owned(1) = owned(1) + count(abs(t%sticks%jz) <= t%sticks%jz_max(i))
    end do
    owned(2) = sum(t%sticks%rows%count)
    call test%world%sum_reals(owned)
    expected = 0
    do jz = -n(3)/2, (n(3) - 1)/2
      do jy = -n(2)/2, (n(2) - 1)/2
        do jx = 0, n(1)/2
          select case (t%sticks%dealias)
          case (DEALIAS_NONE)
            expected = expected + 1
          case (DEALIAS_BOX)
            if (all(abs([jx, jy, jz]) < k)) expected = expected + 1
          case default
            if (sum(([jx, jy, jz]/k)**2) < 1) expected = expected + 1
          end select
        end do
      end do
    end do
    call test%check_close(name//': every retained mode has one owner', owned(1), real(expected, rp), atol=0.1_rp)
    call test%check_close(name//': file rows cover all sticks', owned(2), real(t%sticks%rows%n, rp), atol=0.1_rp)
  end subroutine check_table

  !> cos(k.x + phase) for a few retained modes: forward gives exp(i phase)/2 in that mode and nothing
  !> elsewhere; backward of forward gives the field.
  subroutine check_modes(t, name)
    class(transform_t), intent(inout) :: t
    character(*), intent(in) :: name
    complex(rp), allocatable :: spectral(:, :, :)
    real(rp), allocatable :: f(:, :, :, :), back(:, :, :, :)
    integer :: j(3, 2), x, y, z, i, m, iz
    real(rp) :: phase, worst(2)
    complex(rp) :: want
    allocate (spectral(t%sticks%nkz, t%sticks%n, 2))
    allocate (f(t%block%count(1), t%block%count(2), t%block%count(3), 2))
    j(:, 1) = [1, -2, 3]
    j(:, 2) = [3, 1, -1]
    if (t%grid%is_2d) j(1, :) = 0
    phase = 0.3_rp
    do m = 1, 2
      do z = 1, size(f, 3)
        do y = 1, size(f, 2)
          do x = 1, size(f, 1)
            f(x, y, z, m) = cos(TWO_PI*(j(1, m)*real(x - 1, rp)/t%grid%n(1) + &
                                        j(2, m)*real(y + t%block%start(2) - 1, rp)/t%grid%n(2) + &
                                        j(3, m)*real(z + t%block%start(3) - 1, rp)/t%grid%n(3)) + phase)
          end do
        end do
      end do
    end do
    back = f
    call t%forward(f, spectral)
    worst = 0
    do m = 1, 2
      do i = 1, t%sticks%n
        do iz = 1, t%sticks%nkz
          want = 0
          if (all([t%sticks%jx(i), t%sticks%jy(i), t%sticks%jz(iz)] == j(:, m))) want = exp(cmplx(0, phase, rp))/2
          if (all([t%sticks%jx(i), t%sticks%jy(i), t%sticks%jz(iz)] == -j(:, m))) want = exp(cmplx(0, -phase, rp))/2
          worst(1) = max(worst(1), abs(spectral(iz, i, m) - want))
        end do
      end do
    end do
    back = 0
    call t%backward(spectral, back)
    worst(2) = maxval(abs(back - f))
    ! Tolerance: a few units of round-off times log2 of the number of points.
    call test%check_below(name//': a cosine has its two modes and no other', worst(1), 1e-14_rp)
    call test%check_below(name//': backward undoes forward', worst(2), 1e-13_rp)
  end subroutine check_modes

  !> The pipeline does what its kernels do on whole fields, one after the other.
  subroutine check_pipelines(t, name)
    class(transform_t), intent(inout) :: t
    character(*), intent(in) :: name
    type(square_kernels_t) :: fused, staged
    real(rp) :: scale(1)
    call fused%init(t)
    call staged%init(t)
    call t%pipeline(fused)
    call run_on_fields(t, staged)
    scale(1) = maxval(abs(fused%result))
    call test%world%max_reals(scale)
    call test%check_below(name//': the pipeline does what its kernels do on whole fields', &
                          maxval(abs(fused%result - staged%result)), 1e-13_rp*scale(1))
    call test%check(name//': all products come before the first of their transforms', &
                    fused%in_order .and. staged%in_order)
    call test%check(name//': the product is not empty', scale(1) > 1e-3_rp)
  end subroutine check_pipelines

  !> Runs all kernels, each on all sticks or lines.
  subroutine run_on_fields(t, kernels)
    class(transform_t), intent(inout) :: t
    class(square_kernels_t), intent(inout) :: kernels
    complex(rp) :: spectra(t%sticks%nkz, t%sticks%n, kernels%n_in), products(t%sticks%nkz, t%sticks%n, kernels%n_out)
    real(rp), dimension(t%block%count(1), t%block%count(2), t%block%count(3), kernels%n_in) :: fields
    real(rp), dimension(t%block%count(1), t%block%count(2), t%block%count(3), kernels%n_out) :: squares
    integer :: z
    call kernels%spectral_in(1, t%sticks%n, spectra)
    call t%backward(spectra, fields)
    squares = 0
    do z = 1, size(fields, 3)
      call kernels%product(1, size(fields, 2), z, fields(:, :, z, :), squares(:, :, z, :))
    end do
    call t%forward(squares, products)
    call kernels%spectral_out(1, t%sticks%n, products)
  end subroutine run_on_fields
end program test_transform
