! SPDX-License-Identifier: GPL-3.0-or-later
!> The transform of P3DFFT next to the builtin one: the same modes and the same points to round-off on any process
!> grid, wherever the sticks are; and its one grid per process.
program test_p3dfft
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_named_kinds, only: word_of
  use spectral_backends, only: HAS_P3DFFT, make_full_transform, make_transform, transform_choices_t, TRANSFORM_BUILTIN, &
                               TRANSFORM_P3DFFT
  use spectral_fftw, only: PLAN_MEASURE
  use spectral_grid, only: grid_t, make_grid
  use spectral_sticks, only: kept_columns, process_grid, DEALIAS_BOX, DEALIAS_ELLIPSOID, DEALIAS_NONE, TRUNCATIONS
  use spectral_transform, only: transform_t
  use test_transform_kernels, only: square_kernels_t
  use testkit, only: testkit_t
  implicit none
  !> The same sums of up to 8640 numbers in another order.
  real(rp), parameter :: ROUND_OFF = 1.0e-12_rp
  type(testkit_t) :: test
  integer :: rows

  if (.not. HAS_P3DFFT) call test%skip('this program was built without P3DFFT (P3DFFT_ROOT tells CMake where it is)')
  call test%start(parallel=.true.)
  do rows = 1, test%world%size
    if (mod(test%world%size, rows) /= 0) cycle
    call compare([24, 20, 18], DEALIAS_ELLIPSOID, rows)
    call compare([10, 14, 22], DEALIAS_BOX, rows)
    call compare([12, 10, 14], DEALIAS_NONE, rows)
    call compare([16, 6, 30], DEALIAS_ELLIPSOID, rows)
    call compare([1, 18, 20], DEALIAS_ELLIPSOID, rows)
    call compare([1, 6, 10], DEALIAS_NONE, rows)
  end do
  call check_one_grid()
  call test%finish()

contains

  subroutine compare(n, dealias, rows)
    integer, intent(in) :: n(3), rows
    integer, intent(in) :: dealias
    class(transform_t), allocatable :: builtin, foreign, full_builtin, full_foreign
    type(failure_t) :: failure
    type(grid_t) :: grid
    character(60) :: name
    integer :: grid_rows, columns
    logical :: possible
    grid = make_grid(n, [1.0_rp, 1.5_rp, 2.0_rp])
    call process_grid(test%world%size, n, rows, grid_rows, columns, possible, [kept_columns(grid, dealias), n(2)])
    if (.not. possible) return
    write (name, '(3(i0,1x),a,a,i0)') n, word_of(TRUNCATIONS, dealias), ', rows ', rows
    call make_transform(builtin, test%world, grid, transform_choices_t(TRANSFORM_BUILTIN, dealias, rows), 5, 2, failure)
    call make_transform(foreign, test%world, grid, transform_choices_t(TRANSFORM_P3DFFT, dealias, rows, PLAN_MEASURE), 5, 2, &
                        failure)
    call test%check(trim(name)//': P3DFFT can be used', .not. failure%failed)
    if (failure%failed) then
      call builtin%free()
      call foreign%free()
      return
    end if
    call compare_modes(trim(name), builtin, foreign)
    call compare_points(trim(name), builtin, foreign)
    call make_full_transform(builtin, full_builtin)
    call make_full_transform(foreign, full_foreign)
    call test%check(trim(name)//': the full transforms keep all modes', &
                    full_foreign%sticks%rows%n == (n(1)/2 + 1)*n(2) .and. full_foreign%sticks%nkz == n(3))
    call compare_points(trim(name)//', all modes', full_builtin, full_foreign)
    call full_builtin%free()
    call full_foreign%free()
    call compare_points(trim(name)//' after the full one', builtin, foreign)
    call builtin%free()
    call foreign%free()
  end subroutine compare

  !> Both pipelines of both transforms make the same of the same.
  subroutine compare_modes(name, builtin, foreign)
    character(*), intent(in) :: name
    class(transform_t), intent(inout) :: builtin, foreign
    type(square_kernels_t) :: one, two
    complex(rp), allocatable :: a(:, :, :, :), b(:, :, :, :)
    call one%init(builtin)
    call two%init(foreign)
    call builtin%pipeline(one)
    call foreign%pipeline(two)
    a = all_modes(builtin, one%result)
    b = all_modes(foreign, two%result)
    call test%check_below(name//': the same modes', maxval(abs(a - b)), ROUND_OFF*maxval(abs(a)))
  end subroutine compare_modes

  !> Forward of a rough field, where no mode is special, and backward of what that gives.
  subroutine compare_points(name, builtin, foreign)
    character(*), intent(in) :: name
    class(transform_t), intent(inout) :: builtin, foreign
    complex(rp), allocatable :: a(:, :, :, :), b(:, :, :, :), of_builtin(:, :, :), of_foreign(:, :, :)
    real(rp), allocatable :: x(:, :, :, :), y(:, :, :, :)
    allocate (of_builtin(builtin%sticks%nkz, builtin%sticks%n, 2))
    allocate (of_foreign(foreign%sticks%nkz, foreign%sticks%n, 2))
    x = rough_field(builtin)
    y = rough_field(foreign)
    call builtin%forward(x, of_builtin)
    call foreign%forward(y, of_foreign)
    a = all_modes(builtin, of_builtin)
    b = all_modes(foreign, of_foreign)
    call test%check_below(name//': the same modes of a field', maxval(abs(a - b)), ROUND_OFF*maxval(abs(a)))
    call test%check(name//': the field is left as it was', all(abs(y - rough_field(foreign)) <= 0))
    call builtin%backward(of_builtin, x)
    call foreign%backward(of_foreign, y)
    a = all_points(builtin, x)
    b = all_points(foreign, y)
    call test%check_below(name//': the same field of its modes', maxval(abs(a - b)), ROUND_OFF*maxval(abs(a)))
  end subroutine compare_points

  !> Two fields that jump from point to point, the same on any shares.
  function rough_field(t) result(field)
    class(transform_t), intent(in) :: t
    real(rp), allocatable :: field(:, :, :, :)
    integer :: x, y, z, f
    associate (c => t%block%count, s => t%block%start)
      allocate (field(c(1), c(2), c(3), 2))
      do f = 1, 2
        do z = 1, c(3)
          do y = 1, c(2)
            do x = 1, c(1)
              field(x, y, z, f) = modulo(7919*(x + 31*(y + s(2)) + 1009*(z + s(3))) + 13*f, 1000)/1000.0_rp
            end do
          end do
        end do
      end do
    end associate
  end function rough_field

  !> The modes (kx, ky, kz, fields) of all ranks, 0 outside the table of sticks. Collective.
  function all_modes(t, spectral) result(whole)
    class(transform_t), intent(in) :: t
    complex(rp), intent(in) :: spectral(:, :, :)
    complex(rp), allocatable :: whole(:, :, :, :)
    integer :: s
    associate (n => t%grid%n, k => t%sticks)
      allocate (whole(n(1)/2 + 1, n(2), n(3), size(spectral, 3)))
      whole = 0
      do s = 1, k%n
        whole(k%jx(s) + 1, modulo(k%jy(s), n(2)) + 1, modulo(k%jz, n(3)) + 1, :) = spectral(:, s, :)
      end do
    end associate
    call add_ranks(2*size(whole), whole)
  end function all_modes

  !> The points (nx, ny, nz, fields) of all ranks, as complex numbers. Collective.
  function all_points(t, physical) result(whole)
    class(transform_t), intent(in) :: t
    real(rp), intent(in) :: physical(:, :, :, :)
    complex(rp), allocatable :: whole(:, :, :, :)
    associate (n => t%grid%n, first => t%block%start + 1, last => t%block%start + t%block%count)
      allocate (whole(n(1), n(2), n(3), size(physical, 4)))
      whole = 0
      whole(:, first(2):last(2), first(3):last(3), :) = physical
    end associate
    call add_ranks(2*size(whole), whole)
  end function all_points

  subroutine add_ranks(n, whole)
    integer, intent(in) :: n
    complex(rp), contiguous, target, intent(inout) :: whole(:, :, :, :)
    real(rp) :: parts(n)
    parts = transfer(whole, parts)
    call test%world%sum_reals(parts)
    whole = reshape(transfer(parts, whole, n/2), shape(whole))
  end subroutine add_ranks

  !> A second grid is refused as long as the first is in use, which goes on as before.
  subroutine check_one_grid()
    class(transform_t), allocatable :: first, second, third
    type(failure_t) :: none, refused
    real(rp), allocatable :: x(:, :, :, :), back(:, :, :, :)
    complex(rp), allocatable :: modes(:, :, :)
    type(transform_choices_t) :: choices
    choices = transform_choices_t(TRANSFORM_P3DFFT, DEALIAS_NONE)
    associate (box => [1.0_rp, 1.0_rp, 1.0_rp])
      call make_transform(first, test%world, make_grid([8, 8, 8], box), choices, 1, 1, none)
      call make_transform(second, test%world, make_grid([8, 8, 12], box), choices, 1, 1, refused)
      call test%check('a second grid is refused', refused%failed .and. .not. none%failed)
      call second%free()
      if (none%failed .or. .not. refused%failed) return
      call test%check('and the reason is said', index(refused%reason, 'one grid per process') > 0)
      x = rough_field(first)
      allocate (modes(first%sticks%nkz, first%sticks%n, 2))
      call first%forward(x, modes)
      back = x
      call first%backward(modes, back)
      call test%check_below('the first goes on', maxval(abs(back - x)), ROUND_OFF)
      call first%free()
      call make_transform(third, test%world, make_grid([8, 8, 12], box), choices, 1, 1, none)
      call test%check('when it is freed, there is room for another', .not. none%failed)
      call third%free()
    end associate
  end subroutine check_one_grid
end program test_p3dfft
