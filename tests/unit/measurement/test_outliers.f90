! SPDX-License-Identifier: GPL-3.0-or-later
!> Heights that stand out: errors of Student's t are found among normal ones, and nothing that a surface may have is taken for
!> one: slopes, ridges, steps, dimples, the edge of what was seen.
program test_outliers
  use base_kinds, only: i8, rp
  use base_random, only: fill_gaussians
  use measurement_data, only: measurement_t
  use measurement_outliers, only: leave_out_outliers, outliers_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: NX = 60, NY = 40, N_LOADS = 4, EVERY = 50
  real(rp), parameter :: SPACING = 1.0e-4_rp, SIGMA = 1.0e-5_rp !< [m]
  type(testkit_t) :: t
  type(measurement_t) :: m
  type(outliers_t) :: out
  logical :: is_hit(NX, NY, N_LOADS)

  call t%start(parallel=.false.)
  call test_normal()
  call test_specks()
  call test_shapes()
  call t%finish()

contains

  !> Two heights in 1e9 of normal errors would be left out: none of these 9600, whatever is declared.
  subroutine test_normal()
    call lay_out(SIGMA, 1.0_rp)
    call leave_out_outliers(m, out)
    call t%check('normal errors have none', out%n == 0)
    call t%check('of all heights', out%n_tested == N_LOADS*NX*NY)
    call t%check('a share below 0.001 can be said', out%fraction(1) < 1.0e-12_rp .and. out%fraction(2) < 1.0e-3_rp)
    call lay_out(SIGMA/3, 1.0_rp)
    call leave_out_outliers(m, out)
    call t%check('nor where the declared errors are a third of them', out%n == 0)
  end subroutine test_normal

  !> Every fiftieth height is 40 sd aside, up or down, and some beside them 16 sd.
  subroutine test_specks()
    real(rp) :: fraction
    integer :: n, n_right, l, k
    call lay_out(SIGMA, 1.0_rp)
    call add_specks(40*SIGMA)
    n = count(is_hit)
    call leave_out_outliers(m, out)
    n_right = n
    do l = 1, N_LOADS
      do k = 1, m%loads(l)%count()
        if (is_hit(m%loads(l)%node(1, k), m%loads(l)%node(2, k), l)) n_right = n_right - 1
      end do
    end do
    call t%check('specks are found', n_right >= nint(0.97_rp*n))
    call t%check('and nothing else', out%n == n_right)
    fraction = real(n, rp)/(N_LOADS*NX*NY)
    call t%check('their share lies in its interval', out%fraction(1) < fraction .and. fraction < out%fraction(2))
    call t%check_close('which is as wide as that of a binomial share', out%fraction(2) - out%fraction(1), &
                       2*1.645_rp*sqrt(fraction*(1 - fraction)/out%n_tested), rtol=0.02_rp)
    call t%check('what stays belongs together', all([(size(m%loads(l)%node, 2) == m%loads(l)%count() .and. &
                                                      size(m%loads(l)%sigma) == m%loads(l)%count(), l=1, N_LOADS)]))
    n = out%n
    call leave_out_outliers(m, out)
    call t%check('nothing is left to leave out', out%n == 0 .and. n > 0)
  end subroutine test_specks

  !> A sharp surface without errors that is declared to be exact.
  subroutine test_shapes()
    integer :: l
    call lay_out(1.0e-9_rp, 0.0_rp)
    do l = 1, N_LOADS
      call shape_of(l)
    end do
    call leave_out_outliers(m, out)
    call t%check('ridges, steps, dimples and holes stay', out%n == 0)
  end subroutine test_shapes

  !> Smooth shapes with normal errors of SIGMA times `errors`, of which `declared` is known.
  subroutine lay_out(declared, errors)
    real(rp), intent(in) :: declared, errors
    real(rp) :: noise(NX*NY)
    integer :: i, j, l, k
    m%x = [(SPACING*i, i=1, NX)]
    m%y = [(SPACING*j, j=1, NY)]
    m%has_unloaded = spread(spread(.true., 1, NX), 2, NY)
    m%unloaded = spread(spread(0.0_rp, 1, NX), 2, NY)
    m%unloaded_sigma = spread(spread(0.0_rp, 1, NX), 2, NY)
    if (allocated(m%loads)) deallocate (m%loads)
    allocate (m%loads(N_LOADS))
    do l = 1, N_LOADS
      call fill_gaussians(501_i8, int(l, i8), 0_i8, noise)
      associate (load => m%loads(l))
        allocate (load%node(2, NX*NY), load%height(NX*NY), load%sigma(NX*NY))
        load%has_surface = .true.
        k = 0
        do j = 1, NY
          do i = 1, NX
            k = k + 1
            load%node(:, k) = [i, j]
            load%height(k) = 0.05_rp*m%x(i)**2/m%x(NX) + 0.02_rp*m%y(j) + SIGMA*errors*noise(k)
            load%sigma(k) = declared
          end do
        end do
      end associate
    end do
  end subroutine lay_out

  !> Every fiftieth, and here and there the next one too, but less, which the first one hides.
  subroutine add_specks(height)
    real(rp), intent(in) :: height
    integer :: l, k, sign
    is_hit = .false.
    do l = 1, N_LOADS
      do k = 1 + 7*l, NX*NY - 1, EVERY
        sign = merge(1, -1, modulo(k, 3) > 0)
        call hit(l, k, sign*height)
        if (modulo(k, 11) == 0) call hit(l, k + 1, 0.4_rp*sign*height)
      end do
    end do
  end subroutine add_specks

  subroutine hit(l, k, height)
    integer, intent(in) :: l, k
    real(rp), intent(in) :: height
    associate (load => m%loads(l))
      is_hit(load%node(1, k), load%node(2, k), l) = .true.
      load%height(k) = load%height(k) + height
    end associate
  end subroutine hit

  !> 1: a ridge along x and one aslant; 2: a step; 3: a deep dimple, two spacings wide; 4: every height beyond a
  !> slanted edge is missing.
  subroutine shape_of(l)
    integer, intent(in) :: l
    logical, allocatable :: stays(:)
    integer, allocatable :: rest(:)
    integer :: k
    associate (load => m%loads(l))
      do k = 1, load%count()
        associate (i => load%node(1, k), j => load%node(2, k))
          if (l == 1) load%height(k) = load%height(k) - 1.0e-2_rp*SPACING*(abs(j - 20) + abs(i - j))
          if (l == 2 .and. i > 30) load%height(k) = load%height(k) + 1.0e-4_rp
          if (l == 3) load%height(k) = load%height(k) + 2.0e-4_rp*exp(-0.5_rp*((i - 30)**2 + (j - 20)**2)/2.0_rp**2)
        end associate
      end do
      if (l < 4) return
      stays = load%node(1, :) + 2*load%node(2, :) < 80
      rest = pack([(k, k=1, size(stays))], stays)
      load%node = load%node(:, rest)
      load%height = load%height(rest)
      load%sigma = load%sigma(rest)
    end associate
  end subroutine shape_of
end program test_outliers
