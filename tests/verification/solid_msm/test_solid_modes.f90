! SPDX-License-Identifier: GPL-3.0-or-later
!> Natural frequencies of cantilevers at rest and spinning.
program test_solid_modes
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use cantilever, only: make_cantilever
  use solid_equilibrium, only: equilibrium_t
  use solid_inertia, only: inertia_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_modes, only: natural_modes
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_beam_modes()
  call test_spinning_beam_modes()
  call t%finish()

contains

  subroutine test_beam_modes()
    real(rp), parameter :: EXACT(4) = [3.516015_rp, 22.034492_rp, 61.697214_rp, 120.901916_rp]
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(equilibrium_t) :: work
    type(load_t) :: load
    type(failure_t) :: failure
    real(rp), allocatable :: shapes(:, :, :)
    real(rp) :: f(8), mass
    integer :: i
    call make_cantilever(160, 1.0_rp, 1.0e6_rp, model, inertia)
    call work%init(model)
    call load%init(model)
    allocate (shapes(3, model%n_all, 8))
    call natural_modes(work, model, load, inertia%mass, 0*load%force, f, shapes, failure)
    call t%check('the modes of a cantilever are found',.not. failure%failed)
    do i = 1, 8 ! every frequency twice: in both planes
      call t%check_close('a natural frequency of the cantilever is beta^2', TWO_PI*f(i), &
                         EXACT(ceiling(0.5_rp*i)), rtol=1.0e-3_rp)
      mass = sum(inertia%mass*sum(shapes(:, :, i)**2, 1))
      call t%check_close('its shape has unit modal mass', mass, 1.0_rp, rtol=1.0e-8_rp)
    end do
    call work%free()
  end subroutine test_beam_modes

  !> Flapping of a spinning cantilever: Wright, Smith, Thresher & Wang (1982), doi:10.1115/1.3162139.
  subroutine test_spinning_beam_modes()
    real(rp), parameter :: SPEED(3) = [2.0_rp, 5.0_rp, 10.0_rp], EXACT(3) = [4.1373_rp, 6.4495_rp, 11.2023_rp]
    type(solid_model_t) :: model
    type(inertia_t) :: inertia
    type(equilibrium_t) :: work
    type(load_t) :: load
    type(static_report_t) :: report
    type(static_options_t) :: options
    type(failure_t) :: failure
    real(rp), allocatable :: shapes(:, :, :), u(:, :)
    real(rp) :: f(2)
    integer :: i
    call make_cantilever(80, 1.0_rp, 1.0e7_rp, model, inertia)
    call work%init(model)
    allocate (shapes(3, model%n_all, 2), u(3, model%n_all))
    do i = 1, size(SPEED)
      call load%init(model)
      load%force(1, :) = inertia%mass*SPEED(i)**2*model%points(1, :)
      call solve_static(work, model, load, .false., options, u, report)
      call t%check('the spinning beam is stretched', report%converged)
      call natural_modes(work, model, load, inertia%mass, u, f, shapes, failure)
      call t%check_close('a spinning beam stiffens', TWO_PI*f(1), EXACT(i), rtol=1.0e-3_rp)
    end do
    call work%free()
  end subroutine test_spinning_beam_modes
end program test_solid_modes
