! SPDX-License-Identifier: GPL-3.0-or-later
!> The order in time of the couplings and of the energy balance, for a wing that weighs a third of the air that it
!> moves. Damping proportional to the stiffness keeps the motion smooth: BDF2 shows its order only on modes that the
!> steps resolve. The balance counts what a material that relaxes and joints with friction take.
program test_coupling_order
  use base_kinds, only: rp
  use fsi_coupler_params, only: COUPLING_EXTRAPOLATED, COUPLING_STRONG, COUPLING_WEAK
  use support_coupling, only: flight_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: LEVELS = 3
  real(rp), parameter :: T_END = 0.2_rp
  !> Halving the step takes what is of second order to a quarter; 3.4 is order 1.77, the steps being finite.
  real(rp), parameter :: SECOND = 3.4_rp
  type :: result_t
    real(rp), allocatable :: u(:, :), a(:, :)
    real(rp) :: imbalance = 0, work = 0
  end type result_t
  type(testkit_t) :: t
  type(result_t) :: weak(LEVELS), extrapolated(LEVELS), strong(LEVELS), viscous(LEVELS)
  real(rp) :: lag(LEVELS)
  integer :: k

  call t%start(parallel=.true.)
  do k = 1, LEVELS
    call fly(COUPLING_WEAK, k, weak(k))
    call fly(COUPLING_EXTRAPOLATED, k, extrapolated(k))
    call fly(COUPLING_STRONG, k, strong(k))
    if (k > 1) call fly(COUPLING_EXTRAPOLATED, k, viscous(k), is_viscous=.true.)
  end do
  call check_above('the strong coupling is of second order', distance(strong(1)%u, strong(2)%u)/ &
                   distance(strong(2)%u, strong(3)%u), SECOND)
  call check_above('so is the acceleration that the fluid is told', distance(strong(1)%a, strong(2)%a)/ &
                   distance(strong(2)%a, strong(3)%a), SECOND)
  ! At equal steps two couplings differ by the load alone.
  lag = [(distance(weak(k)%u, strong(k)%u), k=1, LEVELS)]
  call t%check_close('the lag of the weak load is of first order', lag(2)/lag(3), 2.0_rp, rtol=0.1_rp)
  lag = [(distance(extrapolated(k)%u, strong(k)%u), k=1, LEVELS)]
  call check_above('the error of the extrapolated load is of second order', lag(2)/lag(3), SECOND)
  call balance('weak', weak)
  call balance('extrapolated', extrapolated)
  call balance('strong', strong)
  call balance('viscoelastic, with friction in its joints', viscous)
  call t%check('which is another motion', distance(viscous(3)%u, extrapolated(3)%u) > 0.01_rp*norm2(extrapolated(3)%u))
  call t%finish()

contains

  !> A flight of the `level`-th step size, or one of a wing whose material relaxes and whose joints have friction.
  subroutine fly(coupling, level, result, is_viscous)
    integer, intent(in) :: coupling, level
    type(result_t), intent(out) :: result
    logical, intent(in), optional :: is_viscous
    type(flight_t) :: f
    f%dt = 0.02_rp/2**level
    f%mass = 60.0e-9_rp
    f%params%coupling = coupling
    f%params%tolerance = 1.0e-6_rp
    f%params%inertia%rayleigh_stiffness = 1.0e-4_rp
    if (present(is_viscous)) then
      f%params%inertia%relaxation = 0.5_rp
      f%params%inertia%relaxation_time = 5.0e-4_rp
      f%params%inertia%joint_friction = 5.0e-4_rp
    end if
    call f%start(t%world)
    call f%step(T_END)
    call t%check('the flight succeeds',.not. f%failure%failed)
    call t%check('joints rub if they have friction', f%params%inertia%rubs() .eqv. present(is_viscous))
    result%u = f%coupler%states(1)%u
    result%a = f%wings%deformation(1)%a
    associate (e => f%coupler%energies(1))
      result%imbalance = e%imbalance()
      result%work = abs(e%hinge_work) + abs(e%load_work) + abs(e%damped)
      call t%check('hinge, flow and dampers all take part', min(abs(e%hinge_work), abs(e%load_work), e%damped) > &
                   1.0e-2_rp*result%work)
    end associate
    call f%free()
  end subroutine fly

  !> The energy of the wing is what hinge and flow have done to it, but for the error of BDF2.
  subroutine balance(name, runs)
    character(*), intent(in) :: name
    type(result_t), intent(in) :: runs(LEVELS)
    call check_above(name//': the energy balance closes to second order', &
                     runs(2)%imbalance/runs(3)%imbalance, SECOND)
    call t%check_below(name//': to a thousandth of the work', abs(runs(3)%imbalance), 1.0e-3_rp*runs(3)%work)
  end subroutine balance

  !> `value` is above `limit`.
  subroutine check_above(sentence, value, limit)
    character(*), intent(in) :: sentence
    real(rp), intent(in) :: value, limit
    call t%check(sentence, value >= limit .and. value <= huge(value))
  end subroutine check_above

  pure real(rp) function distance(a, b)
    real(rp), intent(in) :: a(:, :), b(:, :)
    distance = norm2(a - b)
  end function distance
end program test_coupling_order
