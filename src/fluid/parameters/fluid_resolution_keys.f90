! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads grid, transforms and truncation of the spectrum from the keys of [Resolution], [Parallel] and [Dealiasing].
module fluid_resolution_keys
  use base_errors, only: message_list_t
  use base_named_kinds, only: named_kind_t
  use io_config, only: config_t
  use io_keys, only: keys_t
  use spectral_backends, only: HAS_P3DFFT, TRANSFORMS, TRANSFORM_BUILTIN, TRANSFORM_P3DFFT
  use spectral_fftw, only: PLANNERS, PLAN_AUTO
  use spectral_grid, only: is_fft_friendly
  use spectral_sticks, only: DEALIAS_ELLIPSOID, DEALIAS_NONE, TRUNCATIONS
  implicit none
  private
  public :: resolution_t, resolution_keys, dealiasing_keys, check_resolution, notice_slow_sizes

  character(2), parameter :: POINTS(3) = ['nx', 'ny', 'nz']

  !> Truncations, with the words of FLUSI.
  type(named_kind_t), parameter :: DEALIASINGS(5) = [named_kind_t('0', DEALIAS_NONE), named_kind_t('1', DEALIAS_ELLIPSOID), &
                                                     TRUNCATIONS]

  type :: resolution_t
    integer :: n(3) = 0                    !< points in x, y, z
    integer :: process_rows = 0
    integer :: planner = PLAN_AUTO
    integer :: transform = TRANSFORM_BUILTIN
    integer :: dealias = DEALIAS_ELLIPSOID
  end type resolution_t

contains

  !> Declares and reads the keys of [Resolution] and [Parallel].
  subroutine resolution_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(resolution_t), intent(inout) :: p
    call keys%section('Resolution', 'grid points and how they are shared among the ranks')
    call keys%integer('nx', p%n(1), 4, 'points in x, even; 1 means a two-dimensional flow in the y-z plane', min=1, max=32768, &
                      required=.true.)
    call keys%integer('ny', p%n(2), 4, 'points in y, even', min=4, max=32768, required=.true.)
    call keys%integer('nz', p%n(3), 4, 'points in z, even', min=4, max=32768, required=.true.)
    call keys%integer('process_rows', p%process_rows, 0, 'rows of the process grid (they share y); 0 chooses slabs if possible', &
                      min=0)
    call keys%kind('planner', p%planner, 'auto', PLANNERS, 'FFTW planning; estimate: results repeat to the '// &
                   'last bit; measure: faster; auto: measure for long runs')
    call keys%section('Parallel', 'how the ranks work together')
    call keys%kind('transform', p%transform, 'builtin', TRANSFORMS, 'Fourier transforms: builtin, or the library P3DFFT if the '// &
                   'program was built with it')
  end subroutine resolution_keys

  !> Declares and reads the keys of [Dealiasing].
  subroutine dealiasing_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(resolution_t), intent(inout) :: p
    call keys%section('Dealiasing', 'truncation of the spectrum')
    call keys%kind('iDealias', p%dealias, '1', DEALIASINGS, '1 = ellipsoid: 2/3 rule on an ellipsoid, as in FLUSI; box: 2/3 '// &
                   'rule in each direction; 0 = none')
  end subroutine dealiasing_keys

  !> Adds mistakes of the grid and the transforms to `errors`.
  subroutine check_resolution(c, p, errors)
    type(config_t), intent(in) :: c
    type(resolution_t), intent(in) :: p
    type(message_list_t), intent(inout) :: errors
    integer :: i
    do i = 1, 3
      if (i == 1 .and. p%n(i) == 1) cycle
      if (mod(p%n(i), 2) /= 0) call c%complain(errors, 'Resolution', POINTS(i), 'the number of points must be even')
      if (p%n(i) < 4) call c%complain(errors, 'Resolution', POINTS(i), &
                                      'needs at least 4 points, or nx = 1 for a two-dimensional flow')
    end do
    if (p%transform == TRANSFORM_P3DFFT .and. .not. HAS_P3DFFT) call c%complain(errors, 'Parallel', 'transform', &
      'this program was built without P3DFFT: set builtin, or build it again with P3DFFT_ROOT (docs/theory/transforms.md)')
  end subroutine check_resolution

  !> Adds a notice for each size of the grid that FFTW transforms, but not fast.
  subroutine notice_slow_sizes(c, p, notices)
    type(config_t), intent(in) :: c
    type(resolution_t), intent(in) :: p
    type(message_list_t), intent(inout) :: notices
    integer :: i
    do i = 1, 3
      if (.not. is_fft_friendly(p%n(i))) call c%complain(notices, 'Resolution', POINTS(i), &
        'is slow to transform: sizes with the factors 2, 3, 5 and 7 alone are fast; '//nearby_sizes(p%n(i)))
    end do
  end subroutine notice_slow_sizes

  !> Returns the next good sizes below and above n.
  function nearby_sizes(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text
    character(60) :: buffer
    integer :: below, above
    below = n
    do while (below > 4 .and. .not. (is_fft_friendly(below) .and. mod(below, 2) == 0))
      below = below - 1
    end do
    above = n
    do while (above < huge(1) - 1 .and. .not. (is_fft_friendly(above) .and. mod(above, 2) == 0))
      above = above + 1
    end do
    write (buffer, '(a,i0,a,i0)') 'nearest good sizes: ', below, ' and ', above
    text = trim(buffer)
  end function nearby_sizes
end module fluid_resolution_keys
