! SPDX-License-Identifier: GPL-3.0-or-later
!> A wing for tests of the diagnosis that shares nothing with the one of the solver: a beam that bends and twists, with
!> closed sums for its deflection.
!>
!> w = F [ sum over s of c(s) (x - s)+ (a - s)+ ds + y b sum over s < min(x, a) of t(s) ds ] at (x, y) under the force
!> F at (a, b): c and t are the compliances of bending and torsion along the span of length 1. Everything that can be
!> wrong with it has a parameter; some cannot be told apart by construction.
module diagnosis_beam
  use base_kinds, only: i8, rp
  use base_parameter, only: parameter_t
  use base_random, only: fill_gaussians
  use inference_simulator, only: effect_t, labels_t, simulator_t, variant_t
  use least_squares_state, only: solver_state_t
  implicit none
  private
  public :: beam_t, make_beam

  integer, parameter, public :: N_BASE = 5, P_MEMBRANE = 6
  integer, parameter, public :: P_ROOT = 7, P_GRADIENT = 8, P_GAIN = 9, P_SCALE = 10, P_DRIFT = 11, P_ONE_WAY = 12, &
                                P_HARD = 13, P_OFFSET = 14, P_SPAN = 15, P_TORSION = 16, P_BOTH = 17, P_SOFT = 18
  integer, parameter :: N_SOFT = 12
  integer, parameter, public :: N_ALL = P_SOFT + N_SOFT - 1
  integer, parameter, public :: E_ROOT = 1, E_GRADIENT = 2, E_GAIN = 3, E_SCALE = 4, E_DRIFT = 5, E_ONE_WAY = 6, &
                                E_HARD = 7, E_OFFSET = 8, E_SPAN = 9, E_TORSION = 10, E_SOFT = 11, E_MEMBRANE = 12
  integer, parameter :: STATIONS = 60, N_BUMPS = 10
  real(rp), parameter :: JOINTS(4) = [0.15_rp, 0.35_rp, 0.55_rp, 0.75_rp]

  type, extends(simulator_t) :: beam_t
    real(rp), allocatable :: data(:)
    real(rp) :: sigma = 0.002_rp         !< that is declared
    real(rp) :: tilt_sd = 0.002_rp
    real(rp), allocatable :: hidden(:)   !< (STATIONS) log compliance of bending that the model does not know
    real(rp), allocatable :: hidden_twist(:) !< the same of torsion
    real(rp), allocatable :: load(:, :)  !< (4, surfaces) a, b, F, order
    real(rp) :: gain_sd = 0              !< of all forces, if there is a nuisance more for it
    real(rp) :: turns = 0                !< strong P_SPAN also looks like P_ROOT and P_TORSION, with its third power
  contains
    procedure :: evaluate => beam_evaluate
    procedure :: covariance => beam_covariance
    procedure :: directions => beam_directions
    procedure :: shape => beam_shape
    procedure :: observe => beam_observe
  end type beam_t

contains

  !> Eight places, three levels (0.5, 1, -1), 28 points each.
  subroutine make_beam(beam)
    type(beam_t), intent(out) :: beam
    real(rp), parameter :: LEVELS(3) = [0.5_rp, 1.0_rp, -1.0_rp]
    integer :: l, n
    n = 8*3
    beam%n_observations = n*28
    beam%n_baseline = N_BASE
    beam%n_nuisances = 3*n
    beam%nuisance_kind = [(1, l=1, 3*n)]
    beam%nuisance_names = ['tilts of scans']
    beam%n_patterns = 4*N_BUMPS
    allocate (beam%load(4, n), beam%labels%fold(n), beam%labels%level(n), beam%labels%order(n), beam%labels%hold(n), &
              beam%labels%moment(n), beam%labels%replicate(n), beam%hidden(STATIONS), &
              beam%hidden_twist(STATIONS))
    beam%hidden = 0
    beam%hidden_twist = 0
    call place_loads(beam, LEVELS)
    call place_points(beam)
    call describe_parameters(beam)
    call describe_effects(beam)
  end subroutine make_beam

  !> Loads at eight places, each at these levels.
  subroutine place_loads(beam, levels)
    type(beam_t), intent(inout) :: beam
    real(rp), intent(in) :: levels(:)
    integer :: l, v, s
    s = 0
    do l = 1, 8
      do v = 1, size(levels)
        s = s + 1
        beam%load(:, s) = [0.25_rp + 0.09_rp*l, 0.15_rp*(modulo(3*l, 5) - 2)/2.0_rp, levels(v), &
                           real(1 + modulo(7*(s - 1), 8*size(levels)), rp)]
        beam%load(3, s) = beam%load(3, s)/beam%load(1, s)**2
        beam%labels%fold(s) = l
        beam%labels%level(s) = beam%load(3, s)
        beam%labels%moment(s) = beam%load(3, s)*beam%load(1, s)
        beam%labels%order(s) = beam%load(4, s)
        beam%labels%replicate(s) = s
      end do
    end do
    beam%labels%hold = -1
  end subroutine place_loads

  !> 28 points on each surface.
  subroutine place_points(beam)
    type(beam_t), intent(inout) :: beam
    integer :: i, j, k, n, s
    n = size(beam%labels%fold)
    allocate (beam%labels%surface(28*n), beam%labels%block(28*n), beam%labels%site(2, 28*n))
    k = 0
    do s = 1, n
      do j = 1, 4
        do i = 1, 7
          k = k + 1
          beam%labels%surface(k) = s
          beam%labels%block(k) = s
          beam%labels%site(:, k) = [0.1_rp + 0.14_rp*(i - 1) + 0.01_rp*j, 0.2_rp*(j - 2.5_rp)/1.5_rp]
        end do
      end do
    end do
  end subroutine place_points

  !> Names, units, bounds and priors of all parameters.
  subroutine describe_parameters(beam)
    type(beam_t), intent(inout) :: beam
    integer :: i
    allocate (beam%parameters(N_ALL))
    do i = 1, N_ALL
      beam%parameters(i)%name = 'p'
      beam%parameters(i)%unit = '1'
      beam%parameters(i)%prior_sd = 0.5_rp
      beam%parameters(i)%lower = -8
      beam%parameters(i)%upper = 8
    end do
    beam%parameters(:N_BASE)%prior_sd = 2.3_rp
    beam%parameters(:N_BASE)%is_log = .true.
    beam%parameters(2:5)%null = log(0.05_rp)
  end subroutine describe_parameters

  !> Which parameters each effect has, and the patterns.
  subroutine describe_effects(beam)
    type(beam_t), intent(inout) :: beam
    integer :: i
    allocate (beam%effects(12))
    call enter(beam%effects(E_ROOT), 'root', [P_ROOT])
    call enter(beam%effects(E_GRADIENT), 'gradient', [P_GRADIENT])
    call enter(beam%effects(E_GAIN), 'gain', [P_GAIN])
    call enter(beam%effects(E_SCALE), 'scale', [P_SCALE])
    call enter(beam%effects(E_DRIFT), 'drift', [P_DRIFT])
    call enter(beam%effects(E_ONE_WAY), 'one_way', [P_ONE_WAY])
    call enter(beam%effects(E_HARD), 'hardening', [P_HARD])
    call enter(beam%effects(E_OFFSET), 'offset', [P_OFFSET])
    call enter(beam%effects(E_SPAN), 'span', [P_SPAN])
    call enter(beam%effects(E_TORSION), 'torsion', [P_TORSION, P_BOTH])
    call enter(beam%effects(E_MEMBRANE), 'membrane', [P_MEMBRANE])
    beam%effects(E_SOFT)%name = 'soft'
    beam%effects(E_SOFT)%missing = ''
    allocate (beam%effects(E_SOFT)%variants(N_SOFT))
    do i = 1, N_SOFT
      beam%effects(E_SOFT)%variants(i) = variant_t('', [P_SOFT + i - 1], [soft_place(i), 0.0_rp])
    end do
    allocate (beam%family(4*N_BUMPS), source=1)
    allocate (beam%pattern_site(2, 4*N_BUMPS), source=0.0_rp)
    beam%family(2*N_BUMPS + 1:) = 2
    beam%pattern_site(1, :) = [(bump_place(i), i=1, 4*N_BUMPS)]
  end subroutine describe_effects

  subroutine enter(effect, name, columns)
    type(effect_t), intent(inout) :: effect
    character(*), intent(in) :: name
    integer, intent(in) :: columns(:)
    effect%name = name
    effect%missing = ''
    allocate (effect%variants(1))
    effect%variants(1)%label = ''
    effect%variants(1)%columns = columns
  end subroutine enter

  pure real(rp) function soft_place(i)
    integer, intent(in) :: i
    soft_place = 0.08_rp*i - 0.03_rp
  end function soft_place

  pure real(rp) function bump_place(i)
    integer, intent(in) :: i
    bump_place = (modulo(i - 1, N_BUMPS) + 0.5_rp)/N_BUMPS
  end function bump_place

  !> Deflections w(n) of all points; bump > 0 adds amplitude 1 times the pattern.
  pure subroutine beam_shape(self, q, w)
    class(beam_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: w(:)
    real(rp) :: x, y, a, b, f, s, ds, factor, m
    real(rp) :: bend(STATIONS), twist(STATIONS)
    integer :: k, i, l
    ds = 1.0_rp/STATIONS
    do i = 1, STATIONS
      s = (i - 0.5_rp)*ds
      bend(i) = exp(-q(1) - q(P_GRADIENT)*(s - 0.5_rp) + self%hidden(i))*(0.3_rp + s)*ds
      twist(i) = exp(-q(6) - q(P_BOTH)*(s - 0.5_rp) + self%hidden_twist(i))*3*ds
    end do
    do k = 1, size(w)
      l = self%labels%surface(k)
      x = self%labels%site(1, k)
      y = self%labels%site(2, k)
      a = self%load(1, l)
      b = self%load(2, l)
      f = self%load(3, l)*exp(q(P_GAIN)) + q(P_OFFSET)
      factor = exp(q(P_DRIFT)*(self%load(4, l) - 12)/12)
      w(k) = 0
      do i = 1, STATIONS
        s = (i - 0.5_rp)*ds
        if (s < min(x, a)) w(k) = w(k) + bend(i)*(x - s)*(a - s) + y*b*twist(i)
      end do
      do i = 1, 4
        s = JOINTS(i)
        if (s >= min(x, a)) cycle
        m = self%load(3, l)*(a - s)
        w(k) = w(k) + exp(q(1 + i))*(x - s)*(a - s)*(1 - q(P_HARD)*m**2)* &
               merge(exp(q(P_ONE_WAY)), 1.0_rp, i == 2 .and. f < 0)
      end do
      do i = 1, N_SOFT
        s = soft_place(i)
        if (s < min(x, a)) w(k) = w(k) + 0.05_rp*(exp(q(P_SOFT + i - 1)) - 1)*(x - s)*(a - s)
      end do
      w(k) = w(k) + 0.05_rp*(exp(q(P_ROOT)) - 1)*x*a
      w(k) = w(k)*f*factor*exp(q(P_SCALE))
      w(k) = w(k) + q(P_SPAN)*0.05_rp*f**3*x**2*a**2 + q(P_TORSION)*0.1_rp*f*x*b + &
             self%turns*q(P_SPAN)**3*(0.05_rp*a + 0.1_rp*b)*f*x
    end do
  end subroutine beam_shape

  !> Data: the shape at q with the hidden compliance, and white errors, tilt and piston of this seed.
  subroutine beam_observe(self, q, sigma, seed)
    class(beam_t), intent(inout) :: self
    real(rp), intent(in) :: q(:), sigma
    integer, intent(in) :: seed
    real(rp) :: noise(self%n_observations), tilt(3*size(self%load, 2)), gain(1)
    integer :: k, l
    if (.not. allocated(self%data)) allocate (self%data(self%n_observations))
    call self%shape(q, self%data)
    call fill_gaussians(int(seed, i8), 1_i8, 0_i8, noise)
    call fill_gaussians(int(seed, i8), 2_i8, 0_i8, tilt)
    call fill_gaussians(int(seed, i8), 3_i8, 0_i8, gain)
    self%data = self%data*(1 + self%gain_sd*gain(1))
    do k = 1, size(noise)
      l = self%labels%surface(k)
      self%data(k) = self%data(k) + sigma*noise(k) + &
                     self%tilt_sd*(tilt(3*l - 2) + tilt(3*l - 1)*self%labels%site(1, k) &
                                   + tilt(3*l)*self%labels%site(2, k))
    end do
    self%labels%observed = self%data
    self%hidden = 0
    self%hidden_twist = 0
  end subroutine beam_observe

  !> Deflections of all surfaces, wanted or not.
  subroutine beam_evaluate(self, q, columns, from, residuals, jacobian, is_valid, to, is_wanted)
    class(beam_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    class(solver_state_t), intent(in) :: from
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    logical, intent(out) :: is_valid
    class(solver_state_t), allocatable, intent(out), optional :: to
    logical, intent(in), optional :: is_wanted(:)
    real(rp), parameter :: STEP = 1.0e-4_rp
    real(rp) :: moved(size(q)), above(size(residuals)), below(size(residuals))
    integer :: i
    is_valid = .true.
    if (present(is_wanted)) is_valid = size(is_wanted) == size(self%load, 2)
    if (present(to)) allocate (to, source=from)
    call self%shape(q, residuals)
    residuals = residuals - self%data
    do i = 1, size(columns)
      moved = q
      moved(columns(i)) = q(columns(i)) + STEP
      call self%shape(moved, above)
      moved(columns(i)) = q(columns(i)) - STEP
      call self%shape(moved, below)
      jacobian(:, i) = (above - below)/(2*STEP)
    end do
  end subroutine beam_evaluate

  subroutine beam_covariance(self, rows, independent_fraction, c)
    class(beam_t), intent(in) :: self
    integer, intent(in) :: rows(:)
    real(rp), intent(in) :: independent_fraction !< all errors are independent
    real(rp), intent(out) :: c(:, :)
    integer :: i
    c = 0
    associate (unused => independent_fraction)
    end associate
    do i = 1, size(rows)
      c(i, i) = self%sigma**2
    end do
  end subroutine beam_covariance

  !> Tilt and piston of every surface; bumps of log bending and torsional compliance, and of forces in proportion to the
  !> load along and beside the axis.
  subroutine beam_directions(self, q, from, nuisances, patterns, is_valid)
    class(beam_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    class(solver_state_t), intent(in) :: from !< which this beam does not need
    real(rp), intent(out) :: nuisances(:, :), patterns(:, :)
    logical, intent(out) :: is_valid
    real(rp) :: ds, s, x, y, a, b, f, green
    integer :: k, l, i, p
    is_valid = .true.
    associate (unused => from)
    end associate
    nuisances = 0
    patterns = 0
    if (self%n_nuisances > 3*size(self%load, 2)) then
      call self%shape(q, nuisances(:, self%n_nuisances))
      nuisances(:, self%n_nuisances) = self%gain_sd*nuisances(:, self%n_nuisances)
    end if
    ds = 1.0_rp/STATIONS
    do k = 1, self%n_observations
      l = self%labels%surface(k)
      x = self%labels%site(1, k)
      y = self%labels%site(2, k)
      a = self%load(1, l)
      b = self%load(2, l)
      f = self%load(3, l)
      nuisances(k, 3*l - 2:3*l) = self%tilt_sd*[1.0_rp, x, y]
      if (size(patterns, 2) == 0) cycle
      do i = 1, STATIONS
        s = (i - 0.5_rp)*ds
        do p = 1, N_BUMPS
          green = exp(-0.5_rp*((s - bump_place(p))*N_BUMPS)**2)
          if (s < min(x, a)) then
            patterns(k, p) = patterns(k, p) + green*f*exp(-q(1))*(0.3_rp + s)*ds*(x - s)*(a - s)
            patterns(k, N_BUMPS + p) = patterns(k, N_BUMPS + p) + green*f*exp(-q(6))*3*ds*y*b
          end if
          if (s < min(x, bump_place(p))) then
            patterns(k, 2*N_BUMPS + p) = patterns(k, 2*N_BUMPS + p) + f*exp(-q(1))*(0.3_rp + s)*ds*(x - s)* &
                                         (bump_place(p) - s)
            patterns(k, 3*N_BUMPS + p) = patterns(k, 3*N_BUMPS + p) + f*exp(-q(6))*3*ds*y*0.2_rp
          end if
        end do
      end do
    end do
  end subroutine beam_directions
end module diagnosis_beam
