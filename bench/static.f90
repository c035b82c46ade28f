program bench
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use sample_wings, only: make_fly_wing
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_wing, only: wing_t
  implicit none
  type(wing_t) :: wing
  type(solid_params_t) :: params
  type(solid_model_t) :: model
  type(failure_t) :: failure
  type(equilibrium_t) :: work
  type(load_t) :: load
  type(static_report_t) :: report
  type(static_options_t) :: options
  real(rp), allocatable :: u(:, :)
  real(rp) :: t0, t1, f
  integer :: i
  wing = make_fly_wing(60, 16)
  params = default_params(wing)
  call model%init(wing, params, failure)
  if (failure%failed) error stop 'init'
  call cpu_time(t0)
  call work%init(model)
  call cpu_time(t1)
  write (*, '(a,5i8,a,f8.1,a)') 'points, free, springs, hinges, nnz', size(wing%points, 2), model%n_free, &
    model%springs%n, size(model%hinges), size(model%pattern%rowind), ' analysis', 1e3*(t1 - t0), ' ms'
  allocate (u(3, model%n_all), source=0.0_rp)
  do i = 0, 5
    f = 0.1e-3_rp*2**i
    call load%init(model)
    call load%add_at(model, [6.0e-3_rp, 0.2e-3_rp], [0.0_rp, 0.0_rp, f], failure)
    if (failure%failed) error stop 'load'
    call cpu_time(t0)
    call solve_static(work, model, load, .false., options, u, report)
    call cpu_time(t1)
    write (*, '(es9.2,l2,a,es9.2,3i5,f9.4,f9.1,a,f8.2,a,es9.1)') f, report%converged, ' res', report%residual, &
      report%factorisations, report%stages, report%snaps, maxval(u(3, :))*1e3, 1e3*(t1 - t0), ' ms, per fac', &
      1e3*(t1 - t0)/report%factorisations, ' ms', report%reciprocal_condition
    if (allocated(report%reason)) write (*, '(a)') report%reason
  end do
  write (*, '(a,f12.0)') 'fill', work%cholesky%fill()
end program bench
