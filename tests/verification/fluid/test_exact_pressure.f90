! SPDX-License-Identifier: GPL-3.0-or-later
!> The static pressure against the exact one of the same band-limited velocity and the same force of solids,
!>
!>   -lap p = d_i d_j (u_i u_j) - div F,   mean of p = -mean of |u|^2/2,
!>
!> on a grid of twice the points: modes of u end below n/3, those of the products below 2 n/3, so that nothing aliases
!> there. Neither the total pressure nor the rotational form is in it. Inside the truncation p must be exact to
!> round-off; what lies outside is all that it may lack.
program test_exact_pressure
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_fields, only: mask_field
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use spectral_fftw, only: PLAN_ESTIMATE
  use spectral_grid, only: make_grid
  use spectral_pencil, only: pencil_t
  use spectral_sticks, only: DEALIAS_NONE
  use support_fluid, only: make_fluid, run_to_end, box_3d, NL
  use testkit, only: testkit_t
  implicit none
  !> p on the points of the fluid, the same on all ranks: of the fluid, exact, and exact without the modes outside the
  !> truncation.
  type :: pressures_t
    real(rp), allocatable :: ours(:, :, :), exact(:, :, :), truncated(:, :, :)
  end type pressures_t
  integer, parameter :: N = 32
  real(rp), parameter :: SIDE = 2.5_rp, ETA = 1.0e-2_rp
  character(*), parameter :: AT_REST = '[MeanFlow]'//NL//'ux=0'//NL//'uy=0'//NL//'uz=0'//NL
  character(*), parameter :: RING = '[InitialCondition]'//NL//'inicond=VortexRing'//NL//'omega1=12'//NL//AT_REST// &
                             '[ReynoldsNumber]'//NL//'nu=1.0e-2'//NL//'[Geometry]'//NL//'Size=0.3125'//NL
  type(testkit_t) :: test

  call test%start(parallel=.true.)
  call vortex_ring()
  call ring_in_a_sponge()
  call sphere()
  call saved_and_not_saved()
  call test%finish()

contains

  !> FLUSI's vortex ring at its end. The part of p outside the truncation is 1.1 % of it.
  subroutine vortex_ring()
    type(pressures_t) :: p
    call find_pressures(RING//'[Time]'//NL//'Tmax=0.5'//NL//'CFL=0.1'//NL, .false., p)
    call test%check_below('vortex ring: rms error of p over rms p', rms(p%ours - p%exact)/ &
                          rms(p%exact - sum(p%exact)/size(p%exact)), 1.2e-2_rp)
    call test%check_below('vortex ring: largest error of p, which spans 17', maxval(abs(p%ours - p%exact)), 0.5_rp)
    call check_truncated('vortex ring', p)
  end subroutine vortex_ring

  !> The sponge damps vorticity without a pressure; its three products are transformed beside that of the pressure.
  subroutine ring_in_a_sponge()
    type(pressures_t) :: p
    call find_pressures(RING//'[Time]'//NL//'Tmax=0.02'//NL//'CFL=0.1'//NL//'[Sponge]'//NL//'iVorticitySponge=yes'// &
                        NL//'iSpongeType=cavity'//NL//'eps_sponge=0.01'//NL//'sponge_thickness=6'//NL, .false., p)
    call check_truncated('vortex ring in a sponge', p)
  end subroutine ring_in_a_sponge

  !> A penalized flow: the force of the sphere is taken as the fluid feels it.
  subroutine sphere()
    type(pressures_t) :: p
    call find_pressures('[InitialCondition]'//NL//'inicond=MeanFlow'//NL//'[MeanFlow]'//NL//'ux=1'//NL//'uy=0.2'// &
                        NL//'uz=0'//NL//'[ReynoldsNumber]'//NL//'nu=1.0e-2'//NL//'[Geometry]'//NL//'Size=0.8'//NL// &
                        '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=sphere'//NL//'eps=0.01'//NL//'[Time]'// &
                        NL//'Tmax=0.1'//NL//'CFL=0.3'//NL, .true., p)
    call check_truncated('sphere', p)
  end subroutine sphere

  !> The pressure is a by-product: a flow of which it is saved is the same to the bit.
  subroutine saved_and_not_saved()
    type(fluid_t) :: fluid
    type(request_t) :: request
    type(failure_t) :: failure
    complex(rp), allocatable :: u(:, :, :)
    integer :: i, run
    do run = 1, 2
      request%pressure = run == 2
      call make_fluid(test%world, box_3d(N, SIDE)//RING//'[Time]'//NL//'Tmax=1'//NL//'CFL=0.1'//NL, fluid)
      do i = 1, 5
        call fluid%step(request, failure)
      end do
      if (run == 1) u = fluid%rhs%state%u
      if (run == 2) call test%check('a pass that keeps the pressure makes the same step to the bit', &
                                    all(abs(u - fluid%rhs%state%u) <= 0))
      call fluid%free()
    end do
  end subroutine saved_and_not_saved

  !> Round-off is some 1e-15: Pi and |u|^2/2 are of the size of p. A margin of two digits.
  subroutine check_truncated(name, p)
    character(*), intent(in) :: name
    type(pressures_t), intent(in) :: p
    call test%check(name//': there is a pressure', maxval(abs(p%exact)) > 0.1_rp)
    call test%check_below(name//': largest error of p inside the truncation over the largest p', &
                          maxval(abs(p%ours - p%truncated))/maxval(abs(p%exact)), 1.0e-13_rp)
  end subroutine check_truncated

  !> Runs the flow of these sections and takes its pressure in three ways.
  subroutine find_pressures(sections, has_solid, p)
    character(*), intent(in) :: sections
    logical, intent(in) :: has_solid
    type(pressures_t), intent(out) :: p
    type(fluid_t) :: fluid
    type(request_t) :: request
    type(failure_t) :: failure
    complex(rp), allocatable :: modes(:, :, :, :)
    real(rp), allocatable :: local(:, :, :, :)
    call make_fluid(test%world, box_3d(N, SIDE)//sections, fluid)
    call run_to_end(fluid)
    request%fields = .true.
    request%pressure = .true.
    call fluid%evaluate(request, failure)
    associate (b => fluid%transform%block)
      allocate (local(b%count(1), b%count(2), b%count(3), 1))
      call fluid%pressure_field(local)
      call gather(local(:, :, :, 1), b%start, 1, p%ours)
    end associate
    call gather_modes(fluid, has_solid, modes)
    call fluid%free()
    call solve_for_pressure(modes, p)
  end subroutine find_pressures

  !> modes(jx, jy, jz, :) of u and of the force of solids, the same on all ranks.
  subroutine gather_modes(fluid, has_solid, modes)
    type(fluid_t), intent(inout) :: fluid
    logical, intent(in) :: has_solid
    complex(rp), allocatable, intent(out) :: modes(:, :, :, :)
    complex(rp), allocatable :: force(:, :, :)
    real(rp), allocatable :: chi(:, :, :), physical(:, :, :, :), flat(:)
    integer :: s, i, c
    allocate (modes(0:N/2, -N/2:N/2, -N/2:N/2, 6))
    modes = 0
    associate (t => fluid%transform)
      allocate (force(t%sticks%nkz, t%sticks%n, 3))
      force = 0
      if (has_solid) then
        allocate (chi(t%block%count(1), t%block%count(2), t%block%count(3)))
        call mask_field(fluid%rhs%penalty, chi)
        physical = fluid%rhs%fields(:, :, :, 1:3)
        do c = 1, 3
          physical(:, :, :, c) = -chi/ETA*physical(:, :, :, c)
        end do
        call t%forward(physical, force)
      end if
      do s = 1, t%sticks%n
        do i = 1, t%sticks%nkz
          modes(t%sticks%jx(s), t%sticks%jy(s), t%sticks%jz(i), 1:3) = fluid%rhs%state%u(i, s, :)
          modes(t%sticks%jx(s), t%sticks%jy(s), t%sticks%jz(i), 4:6) = force(i, s, :)
        end do
      end do
    end associate
    flat = [reshape(real(modes), [size(modes)]), reshape(aimag(modes), [size(modes)])]
    call test%world%sum_reals(flat)
    modes = reshape(cmplx(flat(:size(modes)), flat(size(modes) + 1:), rp), shape(modes))
  end subroutine gather_modes

  !> Solves the Poisson equation of the header on 2 N points.
  subroutine solve_for_pressure(modes, p)
    complex(rp), intent(in) :: modes(0:, -N/2:, -N/2:, :)
    type(pressures_t), intent(inout) :: p
    real(rp), parameter :: CUTOFF = 2*(N/2 - 1)/3.0_rp
    type(pencil_t) :: t
    complex(rp), allocatable :: u(:, :, :), pairs(:, :, :), both(:, :, :)
    complex(rp) :: total
    real(rp), allocatable :: physical(:, :, :, :), product(:, :, :, :)
    real(rp) :: k(3)
    integer :: s, i, a, b, j(3)
    call t%init(test%world, make_grid([2*N, 2*N, 2*N], [SIDE, SIDE, SIDE]), DEALIAS_NONE, 0, PLAN_ESTIMATE, 3, 6)
    allocate (u(t%sticks%nkz, t%sticks%n, 3), pairs(t%sticks%nkz, t%sticks%n, 6), both(t%sticks%nkz, t%sticks%n, 2))
    allocate (physical(t%block%count(1), t%block%count(2), t%block%count(3), 3))
    allocate (product(t%block%count(1), t%block%count(2), t%block%count(3), 6))
    u = 0
    do s = 1, t%sticks%n
      do i = 1, t%sticks%nkz
        j = [t%sticks%jx(s), t%sticks%jy(s), t%sticks%jz(i)]
        if (all(abs(j) <= N/2)) u(i, s, :) = modes(j(1), j(2), j(3), 1:3)
      end do
    end do
    call t%backward(u, physical)
    do b = 1, 3
      do a = 1, b
        product(:, :, :, pair(a, b)) = physical(:, :, :, a)*physical(:, :, :, b)
      end do
    end do
    call t%forward(product, pairs)
    both = 0
    do s = 1, t%sticks%n
      do i = 1, t%sticks%nkz
        j = [t%sticks%jx(s), t%sticks%jy(s), t%sticks%jz(i)]
        k = [t%sticks%kx(s), t%sticks%ky(s), t%sticks%kz(i)]
        total = 0
        do b = 1, 3
          do a = 1, 3
            total = total - k(a)*k(b)*pairs(i, s, pair(a, b))
          end do
        end do
        if (all(abs(j) <= N/2)) total = total - (0, 1)*sum(k*modes(j(1), j(2), j(3), 4:6))
        if (all(j == 0)) then
          both(i, s, :) = -(pairs(i, s, pair(1, 1)) + pairs(i, s, pair(2, 2)) + pairs(i, s, pair(3, 3)))/2
        else
          both(i, s, 1) = total/sum(k**2)
          if (sum((j/CUTOFF)**2) < 1) both(i, s, 2) = both(i, s, 1)
        end if
      end do
    end do
    call t%backward(both, physical(:, :, :, 1:2))
    call gather(physical(:, :, :, 1), t%block%start, 2, p%exact)
    call gather(physical(:, :, :, 2), t%block%start, 2, p%truncated)
    call t%free()
  end subroutine solve_for_pressure

  !> Place of u_a u_b among six products.
  pure integer function pair(a, b)
    integer, intent(in) :: a, b
    pair = merge(a, a + b + 1, a == b)
  end function pair

  !> Every `stride`-th point of a field in each direction, on all ranks.
  subroutine gather(local, start, stride, whole)
    real(rp), intent(in) :: local(:, :, :)
    integer, intent(in) :: start(3), stride
    real(rp), allocatable, intent(out) :: whole(:, :, :)
    real(rp), allocatable :: flat(:)
    integer :: x, y, z, i(3)
    allocate (whole(N, N, N), source=0.0_rp)
    do z = 1, size(local, 3)
      do y = 1, size(local, 2)
        do x = 1, size(local, 1)
          i = [x, y, z] - 1 + start
          if (all(mod(i, stride) == 0)) whole(1 + i(1)/stride, 1 + i(2)/stride, 1 + i(3)/stride) = local(x, y, z)
        end do
      end do
    end do
    flat = reshape(whole, [size(whole)])
    call test%world%sum_reals(flat)
    whole = reshape(flat, shape(whole))
  end subroutine gather

  pure real(rp) function rms(field)
    real(rp), intent(in) :: field(:, :, :)
    rms = norm2(field)/sqrt(real(size(field), rp))
  end function rms
end program test_exact_pressure
