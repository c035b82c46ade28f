! SPDX-License-Identifier: GPL-3.0-or-later
!> Solves for static equilibrium, defined as the end of the quasi-static loading path from the unloaded state.
!>
!> A loaded wing has many stable equilibria, so the path decides. It is followed in stages with a
!> mixed-stress Newton corrector: the axial forces N of the springs are independent iterates, used in
!> the geometric stiffness and updated by their linearised law, while the residual is the true one.
!> That keeps Newton's method quadratic without being thrown off by the stiff springs; near its end a
!> factorisation serves several steps. Stages begin with the parabola through the last three. A tangent that
!> is not positive definite marks a fold; there the wing falls to the next stable state (a snap). A path that does not
!> come to its end is followed once more with finer settings.
module solid_statics
  use base_kinds, only: rp
  use base_text, only: number_text
  use solid_descent, only: descend
  use solid_equilibrium, only: equilibrium_t
  use solid_extension, only: extension_axial
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_vectors, only: longest
  implicit none
  private
  public :: solve_static, static_options_t, static_report_t

  !> Choices of the algorithm.
  type :: static_options_t
    real(rp) :: tolerance = 1.0e-8_rp     !< of the load, for the residual
    real(rp) :: step_limit = 1.0_rp/40    !< of the wing's size: largest movement in one stage
    integer :: factorisation_limit = 900  !< of one path; a shape may take a warm, a cold and a repeated one
    !> a warm start that fails, snaps, or does not go straight to its end is repeated from the
    !> unloaded state
    logical :: redo_cold = .true.
  end type static_options_t

  !> What happened.
  type :: static_report_t
    logical :: converged = .false.        !< to the tolerance, and stable
    character(:), allocatable :: reason   !< why not
    real(rp) :: residual = 0              !< of the load
    real(rp) :: reciprocal_condition = 0  !< small near a snap, where sensitivities diverge
    integer :: factorisations = 0
    integer :: stages = 0                 !< accepted steps of the path
    integer :: snaps = 0
    logical :: was_redone_cold = .false.
    !> the cold path lost its way and was followed once more with finer settings
    logical :: was_repeated = .false.
    !> a start for warm solutions: converged without snaps or repetition, and no tangent that was not positive definite
    !> made the path shorten its steps below the first one. Behind a fold, or close to one, another path may lead to
    !> another shape
    logical :: is_start = .false.
  end type static_report_t

contains

  !> Finds the equilibrium of `model` under `load`. u(3, n_all) [m] is the start and the result: a
  !> cold start begins at zero whatever u is, a warm start at u, the solution for the same load with
  !> other parameters; only a shape reached without snaps is a start that leads where the cold path
  !> leads. Newton's method may leap over a fold to another stable shape; it stumbles when it does, so
  !> a warm start is trusted only if every tangent on its way is positive definite and every stage
  !> takes at most six factorisations. On success the last factorisation in `work` is that of the
  !> exact tangent, ready for sensitivities.
  !> A cold path that loses its way, since a descent does not converge or its end is unstable, is followed once more from
  !> the unloaded state with finer settings (`is_fine` of `follow_path`). One that needs more factorisations than allowed
  !> is not: it would need more still. Failure is a report with a reason; u is then the last equilibrium of the path.
  subroutine solve_static(work, model, load, is_warm, options, u, report)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    logical, intent(in) :: is_warm
    type(static_options_t), intent(in) :: options
    real(rp), intent(inout) :: u(:, :)
    type(static_report_t), intent(out) :: report
    integer :: begin
    logical :: is_lost, was_redone_cold
    begin = work%cholesky%n_factorisations
    if (size(model%triangles) > 0 .and. .not. model%stiffness%plate > 0) then
      report%reason = 'a membrane without bending stiffness D has no unique equilibrium'
      return
    end if
    if (.not. is_warm) u = 0
    call follow_path(work, model, load, is_warm, .false., options, u, report, is_lost)
    was_redone_cold = is_warm .and. options%redo_cold .and. .not. report%converged
    if (was_redone_cold) then
      u = 0
      call follow_path(work, model, load, .false., .false., options, u, report, is_lost)
    end if
    if (is_lost .and. (was_redone_cold .or. .not. is_warm)) then
      u = 0
      call follow_path(work, model, load, .false., .true., options, u, report, is_lost)
      report%was_repeated = .true.
      report%is_start = .false.
      if (allocated(report%reason)) report%reason = report%reason//' (second try, with finer settings)'
    end if
    report%was_redone_cold = was_redone_cold
    report%factorisations = work%cholesky%n_factorisations - begin
  end subroutine solve_static

  !> Follows the path from u to its end, as `report` tells; it `is_lost` if a descent does not converge, or its end is
  !> unstable.
  subroutine follow_path(work, model, load, is_warm, is_fine, options, u, report, is_lost)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    logical, intent(in) :: is_warm
    logical, intent(in) :: is_fine !< stages begin on the straight line, and a factorisation serves one step only
    type(static_options_t), intent(in) :: options
    real(rp), intent(inout) :: u(:, :)
    type(static_report_t), intent(out) :: report
    logical, intent(out) :: is_lost
    real(rp), parameter :: COLD_STEP = 0.05_rp, SHRINK = 0.35_rp, SMALLEST = 0.01_rp, &
                           PATH_TOLERANCE = 1.0e-3_rp
    integer, parameter :: STRAIGHT = 6 ! factorisations of a stage that Newton's method takes in its stride
    real(rp) :: t, dt, target, tolerance, moved, ahead(3), old_t, older_t, most_moved
    integer :: n_old ! points behind the last one that the extrapolation may use
    integer :: begin, n_used, rejections, rejections_unstable
    logical :: accepted, was_unstable, met_fold

    begin = work%cholesky%n_factorisations
    most_moved = options%step_limit*model%size
    call work%start(model, load, u)
    call work%law_axial(model, u)
    work%here_axial = work%axial
    work%old = u
    work%old_axial = work%axial
    old_t = 0
    older_t = 0
    n_old = 0
    rejections = 0
    rejections_unstable = 0
    met_fold = .false.
    is_lost = .false.
    t = 0
    dt = merge(1.0_rp, COLD_STEP, is_warm)
    do while (t < 1)
      target = min(1.0_rp, t + dt)
      if (1 - target < 0.25_rp*dt) target = 1
      work%stage = target
      tolerance = merge(max(options%tolerance, rounding(work, model, u)), PATH_TOLERANCE, target >= 1)
      ahead = 0
      if (n_old >= 1) ahead(1) = (target - t)/(t - old_t)
      if (n_old >= 2) ahead(2) = (target - t)*(target - old_t)/(t - older_t)
      if (n_old >= 2) ahead(2:3) = ahead(2)/[t - old_t, old_t - older_t]
      call correct(work, model, load, ahead, tolerance, most_moved, merge(12, 8, target >= 1), u, t > 0, is_fine, &
                   moved, accepted, was_unstable, n_used)
      if (is_warm .and. options%redo_cold) then
        if (was_unstable .or. accepted .and. n_used > STRAIGHT .or. dt < COLD_STEP) then
          report%reason = 'the warm start does not go straight to its end'
          exit
        end if
      end if
      if (accepted) then
        work%older = work%old
        work%older_axial = work%old_axial
        work%old = u
        work%old_axial = work%here_axial
        u = work%trial
        work%here_axial = work%axial
        older_t = old_t
        old_t = t
        t = target
        n_old = merge(1, n_old + 1, is_fine)
        rejections = 0
        rejections_unstable = 0
        report%stages = report%stages + 1
        dt = dt*min(2.5_rp, most_moved/max(moved, 0.1_rp*most_moved), &
                    merge(2.5_rp, merge(1.2_rp, 0.7_rp, n_used <= 6), n_used <= 4))
      else
        rejections = rejections + 1
        if (was_unstable) rejections_unstable = rejections_unstable + 1
        dt = SHRINK*dt
        met_fold = met_fold .or. was_unstable .and. (dt < COLD_STEP .or. is_warm)
        if (rejections_unstable >= 2 .or. rejections >= 4 .or. dt < SMALLEST) then
          target = min(1.0_rp, t + dt)
          work%stage = target
          tolerance = merge(max(options%tolerance, rounding(work, model, u)), PATH_TOLERANCE, target >= 1)
          call descend(work, model, load, tolerance, 300, u, accepted)
          report%snaps = report%snaps + 1
          is_lost = .not. accepted
          if (is_lost) then
            report%reason = 'the descent from a fold of the path did not converge at '// &
                            number_text(real(nint(100*target), rp))//' % of the load'
            exit
          end if
          report%stages = report%stages + 1
          work%here_axial = work%axial
          t = target
          dt = max(dt, 2*SMALLEST)
          n_old = 0
          rejections = 0
          rejections_unstable = 0
        end if
      end if
      if (work%cholesky%n_factorisations - begin > options%factorisation_limit) then
        report%reason = 'the path needs more than '//number_text(options%factorisation_limit)// &
                        ' factorisations'
        exit
      end if
    end do
    call conclude(work, model, load, options, u, report, is_lost)
    report%is_start = report%converged .and. report%snaps == 0 .and. .not. met_fold
  end subroutine follow_path

  !> Residual that the rounding of the displacements leaves, relative to the load.
  pure real(rp) function rounding(work, model, u)
    type(equilibrium_t), intent(in) :: work
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :)
    rounding = 2*epsilon(u)*maxval(abs(u))*model%params%k_vein*sqrt(3.0_rp*model%n_free)/work%force_scale
  end function rounding

  !> Newton iteration at the stage of `work`, from the path's last point u, extrapolated by `ahead`
  !> steps from the point before. If accepted, work%trial and work%axial are the new point.
  subroutine correct(work, model, load, ahead, tolerance, most_moved, limit, u, has_left, is_fine, moved, &
                     accepted, was_unstable, n_used)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: ahead(3), tolerance, most_moved
    integer, intent(in) :: limit
    real(rp), intent(in) :: u(:, :)
    logical, intent(in) :: has_left !< u is no longer the start of the path
    logical, intent(in) :: is_fine
    real(rp), intent(out) :: moved !< [m] largest movement from the last point
    logical, intent(out) :: accepted, was_unstable
    integer, intent(out) :: n_used !< factorisations, and one more if the last had to serve several steps
    real(rp), parameter :: SHIFT = 1.0e-13_rp ! of k_e
    real(rp), parameter :: WORTH_REUSE = 0.1_rp ! of the load and of the residual before
    real(rp) :: size_g, last_size
    integer :: iteration, begin, growths, n_more
    logical :: is_spd

    begin = work%cholesky%n_factorisations
    accepted = .false.
    was_unstable = .false.
    growths = 0
    n_more = 0
    moved = 0
    work%trial = u + (ahead(1) + ahead(2))*(u - work%old) - ahead(3)*(work%old - work%older)
    work%axial = work%here_axial + (ahead(1) + ahead(2))*(work%here_axial - work%old_axial) - &
                 ahead(3)*(work%old_axial - work%older_axial)
    if (has_left .or. work%is_growing .or. work%stage < 1) then
      call work%residual(model, load, work%trial, work%g)
    else
      work%g = work%start_residual
    end if
    size_g = norm2(work%g)
    do iteration = 1, limit
      call work%factorise(model, load, work%trial, .false., SHIFT*model%params%k_vein, is_spd)
      if (.not. is_spd) then
        if (was_unstable) exit
        was_unstable = .true.
        call work%factorise(model, load, work%trial, .true., SHIFT*model%params%k_vein, is_spd)
        if (.not. is_spd) exit
      end if
      call work%newton_step(model, work%g)
      if (longest(work%du) > 3*most_moved) exit
      call extension_axial(model%springs, model%stiffness%extension, work%trial, work%axial, work%du)
      work%trial = work%trial + work%du
      moved = longest(work%trial, u)
      if (moved > 4*most_moved) exit
      last_size = size_g
      call work%residual(model, load, work%trial, work%g)
      size_g = norm2(work%g)
      accepted = size_g <= tolerance*work%force_scale
      if (accepted) exit
      if (iteration > 1 .and. size_g > last_size) growths = growths + 1
      if (growths >= 2) exit
      if (is_fine .or. was_unstable .or. size_g > WORTH_REUSE*min(last_size, work%force_scale)) cycle
      call reuse_factors(work, model, load, tolerance, u, size_g, moved, accepted)
      if (.not. accepted) cycle
      n_more = 1
      exit
    end do
    n_used = work%cholesky%n_factorisations - begin + n_more
  end subroutine correct

  !> Further steps with the last factorisation while each reduces the residual well; one costs an eighth of a new
  !> factorisation. What the old factors get wrong lies in few directions: the steps are combined with those before
  !> as by Anderson (1965), doi:10.1145/321296.321305, with a memory of one. Sets what `correct` does.
  subroutine reuse_factors(work, model, load, tolerance, u, size_g, moved, accepted)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: tolerance
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(inout) :: size_g, moved
    logical, intent(out) :: accepted
    integer, parameter :: MOST = 8
    real(rp), parameter :: GOOD = 0.6_rp ! reduction
    real(rp) :: last_size, change, fraction
    integer :: step
    accepted = .false.
    work%last_du = work%du
    work%step = work%du
    do step = 1, MOST
      last_size = size_g
      work%kept = work%trial
      work%kept_g = work%g
      work%kept_axial = work%axial
      call work%newton_step(model, work%g)
      work%last_du = work%du - work%last_du
      change = sum(work%last_du**2)
      fraction = 0
      if (change > 0) fraction = sum(work%last_du*work%du)/change
      work%step = work%du - fraction*(work%step + work%last_du)
      work%last_du = work%du
      call extension_axial(model%springs, model%stiffness%extension, work%trial, work%axial, work%step)
      work%trial = work%trial + work%step
      call work%residual(model, load, work%trial, work%g)
      size_g = norm2(work%g)
      if (size_g > GOOD*last_size) then
        work%trial = work%kept
        work%g = work%kept_g
        work%axial = work%kept_axial
        size_g = last_size
        exit
      end if
      accepted = size_g <= tolerance*work%force_scale
      if (accepted) exit
    end do
    moved = longest(work%trial, u)
  end subroutine reuse_factors

  !> Tests the end of the path for stability with the exact tangent, whose factorisation stays, and
  !> spends up to three more steps on it, the first with the residual at u that `work` holds. Rounding u to its last
  !> bit alone changes the residual by k_e times that bit, up to 1e-8 of a small load; so what the first correction
  !> loses and all of the last two are kept apart from u.
  subroutine conclude(work, model, load, options, u, report, is_lost)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    type(static_options_t), intent(in) :: options
    real(rp), intent(inout) :: u(:, :)
    type(static_report_t), intent(inout) :: report
    logical, intent(inout) :: is_lost
    real(rp) :: size_g
    integer :: refinement
    logical :: is_spd
    if (allocated(report%reason)) return
    call work%law_axial(model, u)
    call work%factorise(model, load, u, .false., 0.0_rp, is_spd) ! no shift: sensitivities feel it
    is_lost = .not. is_spd
    if (is_lost) then
      report%reason = 'the path ends in an unstable equilibrium'
      return
    end if
    report%reciprocal_condition = work%cholesky%reciprocal_condition()
    call work%newton_step(model, work%g)
    work%trial = u
    u = u + work%du
    work%trial = (work%trial - u) + work%du ! what the sum lost
    do refinement = 0, 2
      call work%residual(model, load, u, work%g, low=work%trial)
      size_g = norm2(work%g)
      if (refinement == 2 .or. size_g <= 0.1_rp*options%tolerance*work%force_scale) exit
      call work%newton_step(model, work%g)
      work%trial = work%trial + work%du
    end do
    if (work%force_scale > 0) report%residual = size_g/work%force_scale
    report%converged = report%residual <= options%tolerance
    if (.not. report%converged) report%reason = 'the residual is limited by rounding at '// &
                                                number_text(report%residual)
  end subroutine conclude
end module solid_statics
