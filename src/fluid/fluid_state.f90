! SPDX-License-Identifier: GPL-3.0-or-later
!> What a restart needs of the fluid, and the tables of the exact viscous factor.
module fluid_state
  use base_kinds, only: rp
  use fluid_penalty, only: N_COLORS
  use spectral_sticks, only: sticks_t
  implicit none
  private
  public :: fluid_state_t, viscous_factor_t

  !> Velocity spectrum and multistep history at `time`.
  type :: fluid_state_t
    real(rp) :: time = 0
    real(rp) :: dt_old = 0  !< length of the step that led here
    integer :: step = 0     !< steps done
    complex(rp), allocatable :: u(:, :, :)       !< (nkz, sticks, 3) velocity
    complex(rp), allocatable :: history(:, :, :) !< (nkz, sticks, 3) E(dt_old) N(t - dt_old) for AB2
    real(rp) :: solid_momentum(3, 0:N_COLORS - 1) = 0 !< int chi u_s dV at t - dt_old, for the unsteady force
    real(rp) :: solid_moment(3, 0:N_COLORS - 1) = 0   !< int chi r x u_s dV at t - dt_old
  contains
    procedure :: init => state_init
  end type fluid_state_t

  !> exp(-nu k^2 dt) = on_stick(s)*along(kz), separable; recomputed only when dt changes.
  type :: viscous_factor_t
    real(rp) :: dt = -1
    real(rp), allocatable :: on_stick(:), along(:)
  contains
    procedure :: init => factor_init
    procedure :: update => factor_update
  end type viscous_factor_t

contains

  !> Allocates the spectra for these sticks, at rest.
  subroutine state_init(self, sticks)
    class(fluid_state_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    allocate (self%u(sticks%nkz, sticks%n, 3), self%history(sticks%nkz, sticks%n, 3))
    self%u = 0
    self%history = 0
  end subroutine state_init

  !> Allocates the tables.
  subroutine factor_init(self, sticks)
    class(viscous_factor_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    allocate (self%on_stick(sticks%n), self%along(sticks%nkz))
    self%dt = -1
  end subroutine factor_init

  !> Makes the tables valid for `dt`.
  subroutine factor_update(self, sticks, nu, dt)
    class(viscous_factor_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    real(rp), intent(in) :: nu, dt
    if (abs(dt - self%dt) <= 0) return
    self%dt = dt
    self%on_stick = exp(-nu*dt*(sticks%kx**2 + sticks%ky**2))
    self%along = exp(-nu*dt*sticks%kz**2)
  end subroutine factor_update
end module fluid_state
