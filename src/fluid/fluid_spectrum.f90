! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes a random solenoidal velocity with a given energy spectrum, the same on any number of ranks.
!>
!> Every mode of a shell (nearest integer of |k| over the smallest wavenumber of the box) gets the same
!> modulus, so that the shell holds exactly its energy; direction and phase are drawn by a
!> counter-based generator from the mode number alone.
module fluid_spectrum
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp, i8
  use base_random, only: random_uniforms
  use fluid_initial_keys, only: FLOW_ROGALLO
  use fluid_params, only: fluid_params_t
  use parallel_world, only: world_t
  use spectral_sticks, only: sticks_t
  use io_broadcast_text, only: read_text_file
  implicit none
  private
  public :: random_velocity

contains

  !> Fills u(nkz, sticks, 3). With turbulence_rogallo E(k) ~ k^4 exp(-2 (k/2)^2) in box wavenumbers,
  !> scaled to the mean energy omega1; with random-given-spectrum E(k) is interpolated from the columns
  !> k, E(k) of the spectrum file. Fails if that file cannot be used. Collective.
  subroutine random_velocity(world, p, sticks, u, failure)
    type(world_t), intent(in) :: world
    type(fluid_params_t), intent(in) :: p
    type(sticks_t), intent(in) :: sticks
    complex(rp), intent(inout) :: u(:, :, :)
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: modes_in_shell(:), energy(:), table(:, :)
    real(rp) :: k_min, k(3), drawn(3)
    complex(rp) :: direction(3)
    integer :: s, i, shell, n_shells, mode(3)

    k_min = TWO_PI/maxval(p%grid%length, mask=p%grid%n > 1)
    n_shells = ceiling(norm2(real(p%grid%n, rp)/2*TWO_PI/p%grid%length)/k_min) + 1
    allocate (modes_in_shell(n_shells), energy(n_shells))
    modes_in_shell = 0
    do s = 1, sticks%n
      do i = 1, sticks%nkz
        if (.not. is_used(sticks, s, i, p%grid%n)) cycle
        shell = shell_of(sticks, s, i, k_min)
        modes_in_shell(shell) = modes_in_shell(shell) + sticks%weight(s)
      end do
    end do
    call world%sum_reals(modes_in_shell)

    if (p%initial%flow == FLOW_ROGALLO) then
      energy = [(real(i, rp)**4*exp(-2*(i/2.0_rp)**2), i=1, n_shells)]
      where (modes_in_shell < 0.5_rp) energy = 0
      energy = energy*(p%initial%omega1/sum(energy))
    else
      call read_table(world, p%initial%spectrum_file, table, failure)
      if (failure%failed) return
      energy = [(interpolate(table, i*k_min)*k_min, i=1, n_shells)]
    end if

    u = 0
    do s = 1, sticks%n
      do i = 1, sticks%nkz
        if (.not. is_used(sticks, s, i, p%grid%n)) cycle
        mode = [sticks%jx(s), sticks%jy(s), sticks%jz(i)]
        k = [sticks%kx(s), sticks%ky(s), sticks%kz(i)]
        shell = shell_of(sticks, s, i, k_min)
        ! Of a mode and its mirror image only one is drawn; the other is its conjugate.
        if (is_mirror(mode)) then
          drawn = uniforms(p%initial%seed, -mode)
          direction = conjg(solenoidal_direction(-k, drawn, p%grid%is_2d))
        else
          drawn = uniforms(p%initial%seed, mode)
          direction = solenoidal_direction(k, drawn, p%grid%is_2d)
        end if
        u(i, s, :) = sqrt(2*energy(shell)/modes_in_shell(shell))*direction
      end do
    end do
  end subroutine random_velocity

  !> Draws three uniform numbers that depend on the seed and the mode number only.
  pure function uniforms(seed, mode) result(drawn)
    integer, intent(in) :: seed, mode(3)
    real(rp) :: drawn(3)
    integer(i8), parameter :: WIDTH = 2_i8**20 !< more modes than any direction has
    integer(i8) :: place
    place = (mode(1) + WIDTH/2) + WIDTH*((mode(2) + WIDTH/2) + WIDTH*(mode(3) + WIDTH/2))
    drawn(1:2) = random_uniforms(int(seed, i8), place, 0_i8)
    drawn(2:3) = random_uniforms(int(seed, i8), place, 1_i8)
  end function uniforms

  !> Tells whether a mode is neither the mean nor a Nyquist mode, which have no mirror image.
  pure logical function is_used(sticks, s, i, n) result(used)
    type(sticks_t), intent(in) :: sticks
    integer, intent(in) :: s, i, n(3)
    integer :: mode(3)
    mode = abs([sticks%jx(s), sticks%jy(s), sticks%jz(i)])
    used = any(mode > 0) .and. all(2*mode < max(n, 2))
  end function is_used

  !> Returns the number of the spherical shell of a wave vector.
  pure integer function shell_of(sticks, s, i, k_min) result(shell)
    type(sticks_t), intent(in) :: sticks
    integer, intent(in) :: s, i
    real(rp), intent(in) :: k_min
    shell = max(1, nint(norm2([sticks%kx(s), sticks%ky(s), sticks%kz(i)])/k_min))
  end function shell_of

  !> Tells whether a mode is the second one of the pair (k, -k).
  pure logical function is_mirror(mode) result(mirror)
    integer, intent(in) :: mode(3)
    integer :: i
    mirror = .false.
    do i = 1, 3
      if (mode(i) == 0) cycle
      mirror = mode(i) < 0
      return
    end do
  end function is_mirror

  !> Returns a complex vector of modulus 1 with k . a = 0, from three uniform numbers.
  pure function solenoidal_direction(k, drawn, is_2d) result(a)
    real(rp), intent(in) :: k(3), drawn(3)
    logical, intent(in) :: is_2d
    complex(rp) :: a(3)
    real(rp) :: e1(3), e2(3), mix
    if (is_2d) then
      ! In the plane there is one solenoidal direction only.
      a = [0.0_rp, -k(3), k(2)]/norm2(k)*exp(cmplx(0.0_rp, TWO_PI*drawn(1), rp))
      return
    end if
    e1 = 0
    e1(minloc(abs(k), 1)) = 1
    e1 = e1 - k*dot_product(k, e1)/dot_product(k, k)
    e1 = e1/norm2(e1)
    e2 = [k(2)*e1(3) - k(3)*e1(2), k(3)*e1(1) - k(1)*e1(3), k(1)*e1(2) - k(2)*e1(1)]/norm2(k)
    mix = TWO_PI*drawn(3)
    a = e1*cos(mix)*exp(cmplx(0.0_rp, TWO_PI*drawn(1), rp)) + e2*sin(mix)*exp(cmplx(0.0_rp, TWO_PI*drawn(2), rp))
  end function solenoidal_direction

  !> Reads two columns of numbers on root, for all; lines that begin with # or % are comments. Collective.
  subroutine read_table(world, path, table, failure)
    type(world_t), intent(in) :: world
    character(*), intent(in) :: path
    real(rp), allocatable, intent(out) :: table(:, :)
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: text, problem, line
    real(rp) :: row(2)
    integer :: first, last, status, n
    if (world%is_root) then
      call read_text_file(path, text, problem)
      if (.not. allocated(problem)) problem = ''
      if (problem /= '') text = ''
    end if
    call world%broadcast_text(problem)
    call world%broadcast_text(text)
    if (problem /= '') then
      call failure%raise(problem)
      return
    end if
    text = text//new_line('a')
    allocate (table(2, len(text)/2 + 1))
    n = 0
    first = 1
    do while (first <= len(text))
      last = first + index(text(first:), new_line('a')) - 2
      line = trim(adjustl(text(first:last)))
      first = last + 2
      if (line == '' .or. index('#%', line(1:min(1, len(line)))) > 0) cycle
      read (line, *, iostat=status) row
      if (status /= 0) row = -1
      if (any(row < 0)) then
        call failure%raise('spectrum file "'//path//'": "'//line//'" is not a pair k, E(k) >= 0')
        return
      end if
      n = n + 1
      table(:, n) = row
    end do
    table = table(:, 1:n)
    if (n < 2) then
      call failure%raise('spectrum file "'//path//'": at least two lines k, E(k) are needed')
    else if (any(table(1, 2:) <= table(1, :n - 1))) then
      call failure%raise('spectrum file "'//path//'": k must increase from line to line')
    end if
  end subroutine read_table

  !> Interpolates linearly; returns zero outside the table.
  pure real(rp) function interpolate(table, k) result(e)
    real(rp), intent(in) :: table(:, :), k
    integer :: i
    e = 0
    do i = 2, size(table, 2)
      if (k < table(1, i - 1) .or. k > table(1, i)) cycle
      e = table(2, i - 1) + (table(2, i) - table(2, i - 1))*(k - table(1, i - 1))/(table(1, i) - table(1, i - 1))
      return
    end do
  end function interpolate
end module fluid_spectrum
