! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds what a restart needs of the fluid, and the tables of the exact viscous factor.
module fluid_state
  use base_kinds, only: rp
  use base_memory, only: check_allocation, COMPLEX_BYTES
  use base_visitor, only: visited_t, visitor_t
  use fluid_penalty, only: N_COLORS
  use spectral_sticks, only: sticks_t
  implicit none
  private
  public :: fluid_state_t, viscous_factor_t, allocate_spectra

  !> Velocity spectrum and multistep history at `time`.
  type, extends(visited_t) :: fluid_state_t
    real(rp) :: time = 0
    real(rp) :: dt_old = 0  !< length of the step that led here
    integer :: step = 0     !< steps done
    complex(rp), allocatable :: u(:, :, :)       !< (nkz, sticks, 3) velocity
    complex(rp), allocatable :: history(:, :, :) !< (nkz, sticks, 3) E(dt_old) N(t - dt_old) for AB2
    real(rp) :: solid_momentum(3, 0:N_COLORS - 1) = 0 !< int chi u_s dV at t - dt_old, for the unsteady force
    real(rp) :: solid_moment(3, 0:N_COLORS - 1) = 0   !< int chi r x u_s dV at t - dt_old
  contains
    procedure :: init => state_init
    procedure :: visit => state_visit
  end type fluid_state_t

  !> The viscous factor of every mode, on_stick(s)*along(kz): exp(-nu k^2 dt), and with spectral vanishing viscosity (Maday, Kaber
  !> & Tadmor 1993, DOI 10.1137/0730016) times exp(-rate dt (k/K)^4). The first factor is separable. Of the second, `choose`
  !> multiplies `along` by the mixed part exp(-2 rate dt (kx^2 + ky^2) kz^2/K^4) of its stick. A spherical factor is 0 where k >= K.
  !> Tables are recomputed only when dt changes.
  type :: viscous_factor_t
    real(rp) :: dt = -1
    real(rp) :: rate = 0   !< of the vanishing viscosity at k = K, 1/T
    real(rp) :: radius = 1 !< K, 1/L
    logical :: is_spherical = .false.
    real(rp), allocatable :: on_stick(:), along(:)
    real(rp), allocatable, private :: separable(:), mixed(:) !< (nkz) part of `along`, (sticks) exponent of kz_1
    integer, allocatable, private :: inside(:)               !< (sticks) modes kz >= 0 inside the sphere, or all
  contains
    procedure :: init => factor_init
    procedure :: update => factor_update
    procedure :: choose => factor_choose
  end type viscous_factor_t

contains

  !> Allocates the spectra for these sticks, at rest.
  subroutine state_init(self, sticks)
    class(fluid_state_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    call allocate_spectra(self%u, sticks, 'the flow')
    call allocate_spectra(self%history, sticks, 'the last change of the flow')
    self%u = 0
    self%history = 0
  end subroutine state_init

  !> Shows to the visitor what all ranks have. The spectra are distributed: fluid_restart writes and reads them.
  subroutine state_visit(self, visitor)
    class(fluid_state_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('step', self%step)
    call visitor%visit('time', self%time)
    call visitor%visit('dt_old', self%dt_old)
    call visitor%visit('solid_momentum', self%solid_momentum)
    call visitor%visit('solid_moment', self%solid_moment)
    call visitor%leave_out('u history')
  end subroutine state_visit

  !> Makes room for the spectra of three fields, which hold `what`, on the sticks of this rank. Ends the program if there is none.
  subroutine allocate_spectra(spectra, sticks, what)
    complex(rp), allocatable, intent(out) :: spectra(:, :, :)
    type(sticks_t), intent(in) :: sticks
    character(*), intent(in) :: what
    integer :: status
    allocate (spectra(sticks%nkz, sticks%n, 3), stat=status)
    call check_allocation(status, [sticks%nkz, sticks%n, 3], COMPLEX_BYTES, what)
  end subroutine allocate_spectra

  !> Allocates the tables.
  subroutine factor_init(self, sticks)
    class(viscous_factor_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    allocate (self%on_stick(sticks%n), self%along(sticks%nkz))
    self%dt = -1
  end subroutine factor_init

  !> Makes the tables valid for the step `dt` [T].
  subroutine factor_update(self, sticks, nu, dt)
    class(viscous_factor_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    real(rp), intent(in) :: nu, dt
    real(rp) :: vanishing
    integer :: s, top
    if (abs(dt - self%dt) <= 0) return
    self%dt = dt
    self%on_stick = exp(-nu*dt*(sticks%kx**2 + sticks%ky**2))
    self%along = exp(-nu*dt*sticks%kz**2)
    if (.not. (self%rate > 0 .or. self%is_spherical)) return
    vanishing = self%rate*dt/self%radius**4
    self%on_stick = self%on_stick*exp(-vanishing*(sticks%kx**2 + sticks%ky**2)**2)
    self%separable = self%along*exp(-vanishing*sticks%kz**4)
    self%mixed = -2*vanishing*(sticks%kx**2 + sticks%ky**2)*sticks%kz(min(2, sticks%nkz))**2
    if (allocated(self%inside)) return
    top = sticks%kz_limit + 1
    allocate (self%inside(sticks%n), source=top)
    do s = 1, merge(sticks%n, 0, self%is_spherical)
      self%inside(s) = count((sticks%kx(s)**2 + sticks%ky(s)**2)/self%radius**2 + sticks%kz(:top)**2/self%radius**2 < 1)
    end do
  end subroutine factor_update

  !> Makes `along` valid for stick `s`; `jz` are the mode numbers along it. With kz = j kz_1 the mixed part is q^(j^2),
  !> found by q^((j+1)^2) = q^(j^2) q^(2j+1) without an exponential for every mode.
  pure subroutine factor_choose(self, s, jz)
    class(viscous_factor_t), intent(inout) :: self
    integer, intent(in) :: s, jz(:)
    real(rp) :: q, power, ratio
    integer :: i, n
    if (.not. (self%rate > 0 .or. self%is_spherical)) return
    q = exp(self%mixed(s))
    power = 1
    ratio = q
    n = size(jz)
    self%along = 0
    if (self%inside(s) > 0) self%along(1) = self%separable(1)
    do i = 2, self%inside(s)
      if (jz(i) < 0) exit
      power = power*ratio
      ratio = ratio*q*q
      self%along(i) = self%separable(i)*power
      self%along(n + 2 - i) = self%along(i) ! that of -jz
    end do
  end subroutine factor_choose
end module fluid_state
