! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads time stepping and viscosity from the keys of [Time] and [ReynoldsNumber].
module fluid_time_keys
  use base_kinds, only: rp
  use base_named_kinds, only: kind_of, named_kind_t
  use fluid_substitutes, only: FOR_STEPPERS, NO_STEPPERS
  use io_keys, only: keys_t
  implicit none
  private
  public :: stepping_t, time_keys, viscosity_keys, SCHEME_AB2, SCHEME_RK4, SCHEME_RK2, SCHEME_EULER, SCHEMES, ALSO_NOTHING, &
            ALSO_RIGID_SOLID, ALSO_COUPLING, ALSO_ITERATION

  integer, parameter :: SCHEME_AB2 = 1, SCHEME_RK4 = 2, SCHEME_RK2 = 3, SCHEME_EULER = 4
  !> Time steppers. The last four are words of FLUSI that name solids and couplings, too.
  type(named_kind_t), parameter :: SCHEMES(8) = [ &
    named_kind_t('AB2', SCHEME_AB2), named_kind_t('RK4', SCHEME_RK4), named_kind_t('RK2', SCHEME_RK2), &
    named_kind_t('Euler', SCHEME_EULER), named_kind_t('AB2_rigid_solid', SCHEME_AB2), &
    named_kind_t('FSI_AB2_staggered', SCHEME_AB2), named_kind_t('FSI_AB2_semiimplicit', SCHEME_AB2), &
    named_kind_t('FSI_AB2_iteration', SCHEME_AB2)]

  !> What words of FLUSI name beside the time stepper: a free body, a coupling of flexible wings, or one with iterations.
  integer, parameter :: ALSO_NOTHING = 0, ALSO_RIGID_SOLID = 1, ALSO_COUPLING = 2, ALSO_ITERATION = 3
  type(named_kind_t), parameter :: ALSO(3) = [named_kind_t('AB2_rigid_solid', ALSO_RIGID_SOLID), &
                                              named_kind_t('FSI_AB2_iteration', ALSO_ITERATION), &
                                              named_kind_t('FSI_*', ALSO_COUPLING)]

  !> The steps and the end of a run.
  type :: stepping_t
    integer :: scheme = SCHEME_AB2
    integer :: also = ALSO_NOTHING         !< what the word for it names, too
    character(:), allocatable :: word      !< the word for it that the user gives
    real(rp) :: t_max = 0, cfl = 0.1_rp, cfl_eta = 0.99_rp, dt_fixed = 0, dt_max = 0
    integer :: nt = 0                      !< largest number of steps
    logical :: has_nt = .false.            !< the user gives it
    logical :: intelligent_dt = .false.
    logical :: even_end = .false.          !< the run ends with two equal steps, not with a short one
  end type stepping_t

contains

  !> Declares and reads the keys of [Time].
  subroutine time_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(stepping_t), intent(inout) :: p
    call keys%section('Time', 'time stepping')
    call keys%real('Tmax', p%t_max, 1.0e9_rp, 'end of the run', unit='T', min=0.0_rp)
    call keys%integer('nt', p%nt, 999999999, 'largest number of time steps', min=0, given=p%has_nt)
    call keys%kind('iTimeMethodFluid', p%scheme, 'AB2', SCHEMES, &
                   'all schemes integrate the viscous term exactly; AB2: Adams-Bashforth; RK2 (Heun) and RK4: Runge-Kutta, at '// &
                   '2 and 4 times the cost of AB2; Euler: first order; FSI_*: AB2 with a coupling of flexible wings; '// &
                   'AB2_rigid_solid: FLUSI''s name for AB2 with BodyMotion = free_flight', unbuilt=NO_STEPPERS, &
                   instead=FOR_STEPPERS, word=p%word)
    if (allocated(p%word)) p%also = kind_of(ALSO, p%word)
    call keys%real('CFL', p%cfl, 0.1_rp, 'CFL number of the advective limit', above=0.0_rp)
    call keys%real('CFL_eta', p%cfl_eta, 0.99_rp, 'largest dt/eps of the explicit penalization', above=0.0_rp)
    call keys%real('dt_fixed', p%dt_fixed, 0.0_rp, 'prescribed time step; 0: the CFL rule chooses it', unit='T', min=0.0_rp)
    call keys%real('dt_max', p%dt_max, 0.0_rp, 'largest time step; 0: no limit', unit='T', min=0.0_rp)
    call keys%switch('intelligent_dt', p%intelligent_dt, .false., 'reach output times exactly: the time until the next output '// &
                     'is divided into equal steps')
  end subroutine time_keys

  !> Declares and reads the key of [ReynoldsNumber]: the kinematic viscosity [L^2/T], and whether the user gives it.
  subroutine viscosity_keys(keys, nu, has_nu)
    type(keys_t), intent(inout) :: keys
    real(rp), intent(inout) :: nu
    logical, intent(inout) :: has_nu
    call keys%section('ReynoldsNumber', 'viscosity')
    call keys%real('nu', nu, 1.0e-2_rp, 'kinematic viscosity', unit='L^2/T', min=0.0_rp, given=has_nu)
  end subroutine viscosity_keys
end module fluid_time_keys
