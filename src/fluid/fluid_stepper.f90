! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the time step on one stick (fluid_rhs has the schemes) with its viscous factors and the arrays of the stages.
module fluid_stepper
  use base_kinds, only: rp
  use fluid_kernels, only: ab2_stick, add_weighted, weighted_sum
  use fluid_params, only: fluid_params_t, SCHEME_AB2, SCHEME_RK4
  use fluid_requests, only: PASS_AB2, PASS_HEUN_FIRST, PASS_HEUN_SECOND, PASS_RK_FIRST, PASS_RK_FOURTH, PASS_RK_SECOND, &
                            PASS_RK_THIRD
  use fluid_state, only: allocate_spectra, fluid_state_t, viscous_factor_t
  use spectral_sticks, only: sphere_radius, sticks_t
  implicit none
  private
  public :: stepper_t

  !> Scratch: contents undefined between steps.
  type :: stepper_t
    integer :: scheme = SCHEME_AB2
    real(rp) :: nu = 0
    type(viscous_factor_t) :: full, half            !< exp(-nu k^2 dt) and exp(-nu k^2 dt/2)
    complex(rp), allocatable :: stage_base(:, :, :) !< RK4 only: u(n)
    real(rp), private, allocatable :: ones(:)       !< (nkz)
  contains
    procedure :: init => stepper_init
    procedure :: choose => stepper_choose
    procedure :: advance => stepper_advance
    procedure :: memory_bytes => stepper_memory_bytes
  end type stepper_t

contains

  !> Allocates the tables and the base of the stages.
  subroutine stepper_init(self, params, sticks)
    class(stepper_t), intent(inout) :: self
    type(fluid_params_t), intent(in) :: params
    type(sticks_t), intent(in) :: sticks
    self%scheme = params%time%scheme
    self%nu = params%nu
    call self%full%init(sticks)
    call self%half%init(sticks)
    self%full%rate = params%vanishing_rate
    self%full%is_spherical = params%is_spherical
    self%full%radius = sphere_radius(params%grid)
    allocate (self%ones(sticks%nkz), source=1.0_rp)
    if (params%time%scheme == SCHEME_RK4) call allocate_spectra(self%stage_base, sticks, 'a stage of the time step')
  end subroutine stepper_init

  !> Makes the viscous factors of a step dt [T] that begins with pass `pass`.
  subroutine stepper_choose(self, sticks, pass, dt)
    class(stepper_t), intent(inout) :: self
    type(sticks_t), intent(in) :: sticks
    integer, intent(in) :: pass
    real(rp), intent(in) :: dt
    call self%full%update(sticks, self%nu, dt)
    if (pass == PASS_RK_FIRST) call self%half%update(sticks, self%nu, dt/2)
  end subroutine stepper_choose

  !> Updates component `c` on stick `s` by pass `pass` with the projected right-hand side `n`; `full` was chosen for `s`.
  subroutine stepper_advance(self, state, sticks, pass, dt, s, c, n)
    class(stepper_t), intent(inout) :: self
    type(fluid_state_t), intent(inout) :: state
    type(sticks_t), intent(in) :: sticks
    integer, intent(in) :: pass, s, c
    real(rp), intent(in) :: dt
    complex(rp), contiguous, intent(in) :: n(:)
    real(rp) :: b10, b11
    associate (nkz => sticks%nkz, e => self%full%on_stick(s), ez => self%full%along, &
               u => state%u(:, s, c), h => state%history(:, s, c))
      if (pass == PASS_AB2) then
        b10 = dt
        b11 = 0
        if (state%step > 0 .and. self%scheme == SCHEME_AB2) then
          b10 = dt/state%dt_old*(dt/2 + state%dt_old)
          b11 = -dt**2/(2*state%dt_old)
        end if
        call ab2_stick(nkz, e, ez, b10, b11, n, u, h)
      else if (pass == PASS_HEUN_FIRST) then
        call ab2_stick(nkz, e, ez, dt, 0.0_rp, n, u, h) ! h is E N
      else if (pass == PASS_HEUN_SECOND) then
        call add_weighted(nkz, dt/2, 1.0_rp, self%ones, n, u)
        call add_weighted(nkz, -dt/2, 1.0_rp, self%ones, h, u)
      else
        ! u is the stage velocity, stage_base is u(n), h gathers u(n+1).
        associate (g => self%half%on_stick(s), gz => self%half%along, base => self%stage_base(:, s, c))
          select case (pass)
          case (PASS_RK_FIRST)
            base = u
            call weighted_sum(nkz, e, ez, base, dt/6, e, ez, n, h)
            call weighted_sum(nkz, g, gz, base, dt/2, g, gz, n, u)
          case (PASS_RK_SECOND)
            call add_weighted(nkz, dt/3, g, gz, n, h)
            call weighted_sum(nkz, g, gz, base, dt/2, 1.0_rp, self%ones, n, u)
          case (PASS_RK_THIRD)
            call add_weighted(nkz, dt/3, g, gz, n, h)
            call weighted_sum(nkz, e, ez, base, dt, g, gz, n, u)
          case (PASS_RK_FOURTH)
            call weighted_sum(nkz, 1.0_rp, self%ones, h, dt/6, 1.0_rp, self%ones, n, u)
          end select
        end associate
      end if
      call sticks%truncate(s, u)
      call sticks%truncate(s, h)
    end associate
  end subroutine stepper_advance

  !> Returns the bytes of its large array.
  pure real(rp) function stepper_memory_bytes(self) result(bytes)
    class(stepper_t), intent(in) :: self
    bytes = 0
    if (allocated(self%stage_base)) bytes = 16*real(size(self%stage_base), rp)
  end function stepper_memory_bytes
end module fluid_stepper
