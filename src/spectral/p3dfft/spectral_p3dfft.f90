! SPDX-License-Identifier: GPL-3.0-or-later
!> Transforms by the library P3DFFT (Pekurovsky 2012, SIAM J. Sci. Comput. 34, C192, DOI 10.1137/11082748X).
!>
!> P3DFFT transforms whole fields and distributes them in blocks: points as boxes of y and z, modes as boxes of kx and ky with all
!> kz of a pair in contiguous memory (its stride-1 arrays). The lines of its boxes are therefore sticks. Sticks outside the
!> truncation are dropped after a forward transform and are zero before a backward one. P3DFFT itself leaves out only the columns kx
!> that no rank keeps. The pipeline is the staged one. The time of P3DFFT's exchanges is not known: its clock of the column exchange
!> does not measure it.
!>
!> P3DFFT keeps its plans and buffers in its own variables, for one grid per process.
module spectral_p3dfft
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_memory, only: check_allocation, COMPLEX_BYTES
  use p3dfft, only: p3dfft_btran_c2r, p3dfft_clean, p3dfft_ftran_r2c, p3dfft_get_dims, p3dfft_setup, proc_dims
  use parallel_world, only: world_t
  use spectral_fftw, only: forget_wisdom, learn_wisdom, wisdom_text, PLAN_MEASURE
  use spectral_grid, only: grid_t
  use spectral_sticks, only: kept_columns, make_block_sticks, process_grid, DEALIAS_NONE
  use spectral_transform, only: transform_t
  implicit none
  private
  public :: p3dfft_t

  type, extends(transform_t) :: p3dfft_t
    complex(rp), allocatable, private :: modes(:, :, :) !< (nz, ky, kx) this rank's box of modes
    integer, allocatable, private :: stick_of(:, :)     !< (ky, kx) local stick of a line of modes, 0 if it has none
    integer, private :: n_kx = 1                        !< columns kx that P3DFFT keeps
    integer, private :: first(2) = 0, count(2) = 0      !< block of kx and ky, 0-based
    integer, private :: n_kz = 0                        !< the first extent of P3DFFT's modes, nz if they are stride-1
    logical, private :: owns_library = .false.          !< this transform frees the data of P3DFFT
    integer, private :: n_kx_after = 0                  !< of a full transform: columns to keep when it is freed
  contains
    procedure :: init => p3dfft_init
    procedure :: init_full => p3dfft_init_full
    procedure :: forward => p3dfft_forward
    procedure :: backward => p3dfft_backward
    procedure :: free => p3dfft_free
    procedure :: memory_bytes => p3dfft_memory_bytes
  end type p3dfft_t

contains

  !> Sets P3DFFT up for this grid and tests it with one wave. Fails if P3DFFT already serves another transform, or if the wave is
  !> not found at its mode in stride-1 arrays; after that, the transform can only be freed. Requires an existing process grid
  !> (`process_grid`, in blocks). Collective.
  subroutine p3dfft_init(self, world, grid, dealias, wanted_rows, effort, most, failure)
    class(p3dfft_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: dealias !< DEALIAS_* of spectral_sticks
    integer, intent(in) :: wanted_rows  !< rows of the process grid, 0 for the best
    integer, intent(in) :: effort       !< PLAN_MEASURE: all ranks agree on the plans that P3DFFT has measured
    integer, intent(in) :: most         !< fields of a pipeline, in and out
    type(failure_t), intent(inout) :: failure
    logical :: possible
    self%world = world
    self%grid = grid
    self%block%n = grid%n
    if (allocated(proc_dims)) then
      call failure%raise('P3DFFT keeps one grid per process, and another transform uses it: free that one first')
      self%sticks = make_block_sticks(grid, dealias, self%first, self%count)
      return
    end if
    self%n_kx = kept_columns(grid, dealias)
    call process_grid(world%size, grid%n, wanted_rows, self%rows, self%columns, possible, [self%n_kx, grid%n(2)])
    call require(possible, 'p3dfft_t: no process grid for this number of ranks')
    self%owns_library = .true.
    call set_up(self)
    if (effort == PLAN_MEASURE) call agree_on_plans(self)
    call check_wave(self, failure)
    call take_modes(self, dealias)
    call self%reserve(most)
  end subroutine p3dfft_init

  !> Makes a transform over the same points as `main`, which keeps all modes. Until it is freed `main` must not be used, because
  !> P3DFFT is set up for all modes. Collective.
  subroutine p3dfft_init_full(self, main)
    class(p3dfft_t), intent(inout) :: self
    class(p3dfft_t), intent(in) :: main
    self%world = main%world
    self%grid = main%grid
    self%block%n = main%block%n
    self%rows = main%rows
    self%columns = main%columns
    self%n_kx = kept_columns(self%grid, DEALIAS_NONE)
    self%n_kx_after = main%n_kx
    call p3dfft_clean()
    call set_up(self)
    call make_box(self)
    call take_modes(self, DEALIAS_NONE)
  end subroutine p3dfft_init_full

  !> Lets P3DFFT plan, and asks it for the shares of this rank. Collective.
  subroutine set_up(self)
    type(p3dfft_t), intent(inout) :: self
    integer :: first(3), last(3), extent(3)
    associate (n => self%grid%n)
      ! The library may overwrite its input: the modes are copies.
      call p3dfft_setup([self%rows, self%columns], n(1), n(2), n(3), self%world%comm%mpi_val, &
                        nxcut=2*self%n_kx - 1, overwrite=.true.)
    end associate
    call p3dfft_get_dims(first, last, extent, 1)
    self%block%start = first - 1
    self%block%count = extent
    call p3dfft_get_dims(first, last, extent, 2)
    self%first = [first(3), first(2)] - 1
    self%count = [extent(3), extent(2)]
    self%n_kz = extent(1)
  end subroutine set_up

  !> Allocates the spectra of this rank.
  subroutine make_box(self)
    type(p3dfft_t), intent(inout) :: self
    integer :: status
    ! FFTW requires fields that begin at an even number. nx is even, or it is 1 and this rank has all of the even ny.
    call require(any(mod(self%block%count, 2) == 0), 'p3dfft_t: every rank has an even number of points')
    allocate (self%modes(self%grid%n(3), self%count(2), self%count(1)), stat=status)
    call check_allocation(status, [self%grid%n(3), self%count], COMPLEX_BYTES, 'spectra of P3DFFT')
  end subroutine make_box

  !> Exchanges the plans that P3DFFT has measured, which differ between measurements. Ranks with the same shares must have the same
  !> plans, and the next run must find the plans of all shares in the wisdom of rank 0. The ranks at the corners of the process grid
  !> have all kinds of shares; all ranks take their plans. Collective.
  subroutine agree_on_plans(self)
    type(p3dfft_t), intent(inout) :: self
    character(:), allocatable :: own, learnt
    integer :: row, column
    own = wisdom_text()
    call forget_wisdom()
    do column = 0, self%columns - 1, max(1, self%columns - 1)
      do row = 0, self%rows - 1, max(1, self%rows - 1)
        learnt = own
        call self%world%broadcast_text(learnt, column*self%rows + row)
        call learn_wisdom(learnt)
      end do
    end do
    call p3dfft_clean()
    call set_up(self)
  end subroutine agree_on_plans

  !> Makes the table of sticks, and finds which line of the box each stick is.
  subroutine take_modes(self, dealias)
    type(p3dfft_t), intent(inout) :: self
    integer, intent(in) :: dealias
    integer :: s
    self%sticks = make_block_sticks(self%grid, dealias, self%first, self%count)
    allocate (self%stick_of(self%count(2), self%count(1)), source=0)
    associate (t => self%sticks)
      do s = 1, t%n
        self%stick_of(modulo(t%jy(s), self%grid%n(2)) - self%first(2) + 1, t%jx(s) - self%first(1) + 1) = s
      end do
    end associate
  end subroutine take_modes

  !> Transforms cos(2 pi (x/nx + y/ny - z/nz) + 0.3), without the x if no such kx is kept, and compares all modes.
  !> Collective.
  subroutine check_wave(self, failure)
    type(p3dfft_t), intent(inout) :: self
    type(failure_t), intent(inout) :: failure
    real(rp), parameter :: PHASE = 0.3_rp, TOLERANCE = 1.0e-10_rp
    real(rp), allocatable :: wave(:, :, :)
    real(rp) :: along(3), points
    integer :: jx, x, y, z, is_wrong
    associate (n => self%grid%n, b => self%block)
      is_wrong = merge(0, 1, self%n_kz == n(3))
      is_wrong = self%world%max_integer(is_wrong)
      if (is_wrong == 0) then
        call make_box(self)
        allocate (wave(b%count(1), b%count(2), b%count(3)))
        jx = min(1, self%n_kx - 1)
        along = TWO_PI*[jx, 1, -1]/n
        do z = 1, b%count(3)
          do y = 1, b%count(2)
            do x = 1, b%count(1)
              wave(x, y, z) = cos(dot_product(along, real([x, y, z] - 1 + b%start, rp)) + PHASE)
            end do
          end do
        end do
        call p3dfft_ftran_r2c(wave, self%modes, 'fft') ! f: Fourier, along x, y and z
        points = product(real(n, rp))
        call take_off(self, [jx, 1, -1], PHASE, points)
        if (jx == 0) call take_off(self, [0, -1, 1], -PHASE, points)
        is_wrong = merge(0, 1, all(abs(self%modes) < TOLERANCE*points))
        is_wrong = self%world%max_integer(is_wrong)
      end if
    end associate
    if (is_wrong > 0) call failure%raise('P3DFFT does not return waves in stride-1 arrays: build it with '// &
                                         '--enable-stride1, or set [Parallel] transform = builtin')
  end subroutine check_wave

  !> Subtracts half a wave from mode j, if this rank has it.
  subroutine take_off(self, j, phase, points)
    type(p3dfft_t), intent(inout) :: self
    integer, intent(in) :: j(3)
    real(rp), intent(in) :: phase, points
    integer :: line(2)
    line = [j(1), modulo(j(2), self%grid%n(2))] - self%first + 1
    if (any(line < 1 .or. line > self%count)) return
    associate (mode => self%modes(modulo(j(3), self%grid%n(3)) + 1, line(2), line(1)))
      mode = mode - points*exp(cmplx(0, phase, rp))/2
    end associate
  end subroutine take_off

  !> Transforms physical(nx, ny_local, nz_local, nf) to spectral(nkz, n, nf). Collective.
  subroutine p3dfft_forward(self, physical, spectral)
    class(p3dfft_t), intent(inout) :: self
    real(rp), contiguous, target, intent(in) :: physical(:, :, :, :)
    complex(rp), contiguous, target, intent(inout) :: spectral(:, :, :)
    integer :: f
    do f = 1, size(spectral, 3)
      call p3dfft_ftran_r2c(physical(:, :, :, f), self%modes, 'fft')
      call modes_to_sticks(self%grid%n(3), self%sticks%nkz, size(self%stick_of), self%stick_of, self%modes, &
                           1/product(real(self%grid%n, rp)), spectral(:, :, f))
    end do
  end subroutine p3dfft_forward

  !> Transforms spectral(nkz, n, nf) to physical(nx, ny_local, nz_local, nf). Collective.
  subroutine p3dfft_backward(self, spectral, physical)
    class(p3dfft_t), intent(inout) :: self
    complex(rp), contiguous, target, intent(in) :: spectral(:, :, :)
    real(rp), contiguous, target, intent(inout) :: physical(:, :, :, :)
    integer :: f
    do f = 1, size(spectral, 3)
      call sticks_to_modes(self%grid%n(3), self%sticks%nkz, size(self%stick_of), self%stick_of, spectral(:, :, f), &
                           self%modes)
      call p3dfft_btran_c2r(self%modes, physical(:, :, :, f), 'tff') ! t: Fourier back along z
    end do
  end subroutine p3dfft_backward

  !> Takes the retained kz of the lines that are sticks, multiplied by `scale`.
  pure subroutine modes_to_sticks(nz, nkz, n_lines, stick_of, modes, scale, sticks)
    integer, intent(in) :: nz, nkz, n_lines, stick_of(n_lines)
    complex(rp), intent(in) :: modes(nz, n_lines)
    real(rp), intent(in) :: scale
    complex(rp), intent(inout) :: sticks(nkz, *)
    integer :: line, n_low
    n_low = (nkz + 1)/2
    do line = 1, n_lines
      if (stick_of(line) == 0) cycle
      sticks(1:n_low, stick_of(line)) = scale*modes(1:n_low, line)
      sticks(n_low + 1:nkz, stick_of(line)) = scale*modes(nz - (nkz - n_low) + 1:nz, line)
    end do
  end subroutine modes_to_sticks

  !> Fills the box with the sticks, and with zeros outside the truncation.
  pure subroutine sticks_to_modes(nz, nkz, n_lines, stick_of, sticks, modes)
    integer, intent(in) :: nz, nkz, n_lines, stick_of(n_lines)
    complex(rp), intent(in) :: sticks(nkz, *)
    complex(rp), intent(inout) :: modes(nz, n_lines)
    integer :: line, n_low
    n_low = (nkz + 1)/2
    do line = 1, n_lines
      if (stick_of(line) == 0) then
        modes(:, line) = 0
      else
        modes(1:n_low, line) = sticks(1:n_low, stick_of(line))
        modes(n_low + 1:nz - (nkz - n_low), line) = 0
        modes(nz - (nkz - n_low) + 1:nz, line) = sticks(n_low + 1:nkz, stick_of(line))
      end if
    end do
  end subroutine sticks_to_modes

  !> Releases the buffers and the data of P3DFFT; a full transform returns P3DFFT to the transform from which it was made.
  !> Collective.
  subroutine p3dfft_free(self)
    class(p3dfft_t), intent(inout) :: self
    if (self%owns_library .or. self%n_kx_after > 0) call p3dfft_clean()
    if (self%n_kx_after > 0) then
      self%n_kx = self%n_kx_after
      call set_up(self)
    end if
    self%owns_library = .false.
    self%n_kx_after = 0
    if (allocated(self%modes)) deallocate (self%modes)
    if (allocated(self%stick_of)) deallocate (self%stick_of)
  end subroutine p3dfft_free

  !> Returns the bytes of this rank's buffers, of which P3DFFT itself has three, each for all modes of its lines along x.
  pure real(rp) function p3dfft_memory_bytes(self) result(bytes)
    class(p3dfft_t), intent(in) :: self
    bytes = self%staged_bytes()
    if (.not. allocated(self%modes)) return
    bytes = bytes + 16*real(size(self%modes), rp)
    if (self%owns_library) &
      bytes = bytes + 48*max(real(size(self%modes), rp), (self%grid%n(1)/2 + 1)*product(real(self%block%count(2:3), rp)))
  end function p3dfft_memory_bytes
end module spectral_p3dfft
