! SPDX-License-Identifier: GPL-3.0-or-later
!> One static shape of the benchmarks: cold, cold with half the step, and warm from a neighbour in the
!> space of the parameters; and the force that gives a wanted deflection.
module wing_shapes
  use base_kinds, only: rp
  use loaded_wing, only: load_at
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t
  use solid_statics, only: solve_static, static_options_t, static_report_t
  implicit none
  private
  public :: shape_t, find_force, measure_shape, deflection, median

  !> What was measured of one shape.
  type :: shape_t
    logical :: cold = .false., warm = .false. !< converged to 1e-8 of the load, and stable
    logical :: redone = .false.               !< the warm start was repeated cold
    logical :: repeated = .false.             !< the cold path was repeated with finer settings
    integer :: cold_factorisations = 0, warm_factorisations = 0, snaps = 0
    real(rp) :: cold_ms = 0, warm_ms = 0      !< CPU time
    real(rp) :: step_difference = 0           !< [m] largest difference when steps are half as long
    real(rp) :: warm_difference = 0           !< [m] largest difference of warm and cold
    real(rp) :: deflection = 0                !< [m] of the loaded point
  end type shape_t

contains

  !> The force [N] at a place under which that place moves by `target` [m] within 15 %, or the last
  !> one tried.
  subroutine find_force(model, work, site, target, force)
    type(solid_model_t), intent(in) :: model
    type(equilibrium_t), intent(inout) :: work
    integer, intent(in) :: site
    real(rp), intent(in) :: target
    real(rp), intent(out) :: force
    real(rp), parameter :: FIRST = 1.0e-5_rp, CHANGE = 8
    type(static_options_t) :: options
    type(static_report_t) :: report
    type(load_t) :: load
    real(rp) :: u(3, model%n_all), w, last_force, last_w, next
    integer :: attempt
    options%redo_cold = .false.
    options%tolerance = 1.0e-3_rp
    u = 0
    force = FIRST
    last_force = FIRST
    last_w = 0
    do attempt = 1, 8
      call load_at(model, site, force, load)
      call solve_static(work, model, load, attempt > 1, options, u, report)
      w = deflection(load, u)
      if (.not. report%converged .or. abs(w/target - 1) < 0.15_rp) exit
      next = target/w
      if (last_w > 0) next = next**(log(force/last_force)/log(w/last_w))
      next = force*min(CHANGE, max(1/CHANGE, next))
      last_force = force
      last_w = w
      force = next
    end do
  end subroutine find_force

  !> Solves for the shape under `force` [N] at a place in three ways and compares them; u(3, n_all) is
  !> the cold one.
  subroutine measure_shape(model, work, params, site, force, u, shape)
    type(solid_model_t), intent(inout) :: model
    type(equilibrium_t), intent(inout) :: work
    type(solid_params_t), intent(in) :: params
    integer, intent(in) :: site
    real(rp), intent(in) :: force
    real(rp), intent(out) :: u(:, :)
    type(shape_t), intent(out) :: shape
    type(solid_params_t) :: other
    type(load_t) :: load
    type(static_report_t) :: report
    type(static_options_t) :: options
    real(rp) :: v(3, model%n_all), t0, t1
    integer :: p
    logical :: is_warm
    u = 0
    v = 0
    call model%set_params(params)
    call load_at(model, site, force, load)
    call cpu_time(t0)
    call solve_static(work, model, load, .false., options, u, report)
    call cpu_time(t1)
    shape%cold_ms = 1000*(t1 - t0)
    shape%cold = report%converged
    shape%cold_factorisations = report%factorisations
    shape%snaps = report%snaps
    shape%repeated = report%was_repeated
    shape%deflection = deflection(load, u)

    options%step_limit = options%step_limit/2
    call solve_static(work, model, load, .false., options, v, report)
    shape%step_difference = maxval(abs(v - u))
    options = static_options_t()

    other = params
    other%young = params%young*exp(0.1_rp*normal(site, 0))
    do p = 1, size(params%joint)
      other%joint(p) = params%joint(p)*exp(0.1_rp*normal(site, p))
    end do
    call model%set_params(other)
    call solve_static(work, model, load, .false., options, v, report)
    call model%set_params(params)
    is_warm = report%is_start ! the path behind a snap may not be the cold one
    call cpu_time(t0)
    call solve_static(work, model, load, is_warm, options, v, report)
    call cpu_time(t1)
    shape%warm_ms = 1000*(t1 - t0)
    shape%warm = report%converged
    shape%warm_factorisations = report%factorisations
    shape%redone = report%was_redone_cold .or. .not. is_warm
    shape%warm_difference = maxval(abs(v - u))
  end subroutine measure_shape

  !> Movement [m] of the loaded place.
  pure real(rp) function deflection(load, u)
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: u(:, :)
    deflection = sum(load%force(3, :)*u(3, :))/sum(load%force(3, :))
  end function deflection

  !> A number from a fixed sample of the normal distribution, roughly.
  pure real(rp) function normal(i, j)
    integer, intent(in) :: i, j
    real(rp) :: x(12)
    integer :: k
    x = [(modulo(12.9898_rp*i + 78.233_rp*j + 37.719_rp*k + 0.618_rp*k**2*(i + 3*j), 1.0_rp), k=1, 12)]
    normal = sum(x) - 6
  end function normal

  !> The upper median.
  pure real(rp) function median(values)
    real(rp), intent(in) :: values(:)
    real(rp) :: sorted(size(values)), x
    integer :: i, j
    sorted = values
    do i = 2, size(sorted)
      x = sorted(i)
      j = i - 1
      do while (j >= 1)
        if (sorted(j) <= x) exit
        sorted(j + 1) = sorted(j)
        j = j - 1
      end do
      sorted(j + 1) = x
    end do
    median = sorted((size(sorted) + 1)/2)
  end function median
end module wing_shapes
