! SPDX-License-Identifier: GPL-3.0-or-later
!> Solves for static equilibrium, defined as the end of the quasi-static loading path from the unloaded state.
!>
!> A loaded wing has many stable equilibria, so that the result depends on the path. The path is followed in stages, each corrected
!> by Newton's method (solid_path_correction). A tangent that is not positive definite marks a fold; there the wing moves to the
!> next stable state (a snap). A path that does not reach its end is followed once more with finer settings.
module solid_statics
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_visitor, only: visited_t, visitor_t
  use solid_descent, only: descend
  use solid_equilibrium, only: equilibrium_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_path_correction, only: correct, correction_t, path_t, way_t
  implicit none
  private
  public :: solve_static, static_options_t, static_report_t

  !> Options of the algorithm.
  type, extends(visited_t) :: static_options_t
    real(rp) :: tolerance = 1.0e-8_rp     !< of the load, for the residual
    real(rp) :: step_limit = 1.0_rp/40    !< of the wing's size: largest movement in one stage
    integer :: factorisation_limit = 900  !< of one path; a shape may need a warm, a cold and a repeated path
    !> a warm start that fails, snaps, or does not reach its end directly is repeated from the unloaded state
    logical :: redo_cold = .true.
  contains
    procedure :: visit => options_visit
  end type static_options_t

  !> Report on a solution.
  type :: static_report_t
    logical :: converged = .false.        !< to the tolerance, and stable
    character(:), allocatable :: reason   !< why not
    real(rp) :: residual = 0              !< of the load
    real(rp) :: reciprocal_condition = 0  !< small near a snap, where sensitivities diverge
    integer :: factorisations = 0
    integer :: stages = 0                 !< accepted steps of the path
    integer :: snaps = 0
    logical :: was_redone_cold = .false.
    !> the cold path failed and was followed again with finer settings
    logical :: was_repeated = .false.
    !> the shape may be the start of warm solutions: the path converged without snaps and repetition, and no indefinite tangent made
    !> its steps shorter than the first one. Beyond or near a fold, another path may lead to another shape
    logical :: is_start = .false.
  end type static_report_t

  real(rp), parameter :: COLD_STEP = 0.05_rp, SMALLEST = 0.01_rp !< of the load

contains

  !> Shows the options to the visitor that decide which shape is found for a load.
  subroutine options_visit(self, visitor)
    class(static_options_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('tolerance', self%tolerance)
    call visitor%visit('step_limit', self%step_limit)
    call visitor%visit('factorisation_limit', self%factorisation_limit)
    call visitor%leave_out('redo_cold')
  end subroutine options_visit

  !> Finds the equilibrium of `model` under `load`. u(3, n_all) [m] is the start and the result. A cold start begins at zero for
  !> any u. A warm start begins at u, the solution for the same load with other parameters. Only from a shape that was reached
  !> without snaps does a warm start lead to the shape of the cold path.
  !>
  !> Newton's method may jump across a fold to another stable shape; its convergence is then slow. A warm start is therefore
  !> trusted only if every tangent on its way is positive definite and every stage takes at most six factorisations.
  !>
  !> A cold path may fail: a descent does not converge, or its end is unstable. It is then followed again from the unloaded state
  !> with finer settings (`is_fine` of `way_t`). A path that needs more factorisations than allowed is not repeated, because it
  !> would need still more.
  !>
  !> On success the last factorisation in `work` is that of the exact tangent, ready for sensitivities. On failure the report has
  !> a reason, and u is the last equilibrium of the path.
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
    call follow_path(work, model, load, way_t(is_warm=is_warm), options, u, report, is_lost)
    was_redone_cold = is_warm .and. options%redo_cold .and. .not. report%converged
    if (was_redone_cold) then
      u = 0
      call follow_path(work, model, load, way_t(), options, u, report, is_lost)
    end if
    if (is_lost .and. (was_redone_cold .or. .not. is_warm)) then
      u = 0
      call follow_path(work, model, load, way_t(is_fine=.true.), options, u, report, is_lost)
      report%was_repeated = .true.
      report%is_start = .false.
      if (allocated(report%reason)) report%reason = report%reason//' (second try, with finer settings)'
    end if
    report%was_redone_cold = was_redone_cold
    report%factorisations = work%cholesky%n_factorisations - begin
  end subroutine solve_static

  !> Follows the path from u to its end, and reports in `report`; `is_lost` if a descent does not converge, or if its end is
  !> unstable.
  subroutine follow_path(work, model, load, way, options, u, report, is_lost)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    type(way_t), intent(in) :: way
    type(static_options_t), intent(in) :: options
    real(rp), intent(inout) :: u(:, :)
    type(static_report_t), intent(out) :: report
    logical, intent(out) :: is_lost
    integer, parameter :: STRAIGHT = 6 ! factorisations of a stage with normal convergence of Newton's method
    type(path_t) :: path
    type(correction_t) :: correction
    integer :: begin
    begin = work%cholesky%n_factorisations
    call work%start(model, load, u)
    call work%law_axial(model, u)
    work%here_axial = work%axial
    work%old = u
    work%old_axial = work%axial
    is_lost = .false.
    path%dt = merge(1.0_rp, COLD_STEP, way%is_warm)
    path%most_moved = options%step_limit*model%size
    do while (path%t < 1)
      work%stage = min(1.0_rp, path%t + path%dt)
      if (1 - work%stage < 0.25_rp*path%dt) work%stage = 1
      call correct(work, model, load, way, path, stage_tolerance(work, model, options, u), u, correction)
      if (way%is_warm .and. options%redo_cold) then
        if (correction%was_unstable .or. correction%accepted .and. correction%n_used > STRAIGHT &
            .or. path%dt < COLD_STEP) then
          report%reason = 'the solution that begins at an earlier shape met an instability'
          exit
        end if
      end if
      if (correction%accepted) then
        call advance(work, way, correction, u, path)
        report%stages = report%stages + 1
      else
        call shorten(way, correction, path)
        if (path%rejections_unstable >= 2 .or. path%rejections >= 4 .or. path%dt < SMALLEST) then
          call fall(work, model, load, options, u, path, is_lost)
          report%snaps = report%snaps + 1
          if (is_lost) then
            report%reason = 'the wing snaps through at '//number_text(real(nint(100*work%stage), rp))// &
                            ' % of the load, and no stable equilibrium is found beyond that'
            exit
          end if
          report%stages = report%stages + 1
        end if
      end if
      if (work%cholesky%n_factorisations - begin > options%factorisation_limit) then
        report%reason = 'no equilibrium is found with '//number_text(options%factorisation_limit)// &
                        ' factorisations of the stiffness matrix'
        exit
      end if
    end do
    call conclude(work, model, load, options, u, report, is_lost)
    report%is_start = report%converged .and. report%snaps == 0 .and. .not. path%met_fold
  end subroutine follow_path

  !> Makes the corrected point the last one of the path, u. The faster the convergence, the longer is the next stage.
  subroutine advance(work, way, correction, u, path)
    type(equilibrium_t), intent(inout) :: work
    type(way_t), intent(in) :: way
    type(correction_t), intent(in) :: correction
    real(rp), intent(inout) :: u(:, :)
    type(path_t), intent(inout) :: path
    work%older = work%old
    work%older_axial = work%old_axial
    work%old = u
    work%old_axial = work%here_axial
    u = work%trial
    work%here_axial = work%axial
    path%older_t = path%old_t
    path%old_t = path%t
    path%t = work%stage
    path%n_old = merge(1, path%n_old + 1, way%is_fine)
    path%rejections = 0
    path%rejections_unstable = 0
    path%dt = path%dt*min(2.5_rp, path%most_moved/max(correction%moved, 0.1_rp*path%most_moved), &
                          merge(2.5_rp, merge(1.2_rp, 0.7_rp, correction%n_used <= 6), correction%n_used <= 4))
  end subroutine advance

  !> Prepares a failed stage to be tried again with a smaller part of the load.
  pure subroutine shorten(way, correction, path)
    type(way_t), intent(in) :: way
    type(correction_t), intent(in) :: correction
    type(path_t), intent(inout) :: path
    real(rp), parameter :: SHRINK = 0.35_rp
    path%rejections = path%rejections + 1
    if (correction%was_unstable) path%rejections_unstable = path%rejections_unstable + 1
    path%dt = SHRINK*path%dt
    path%met_fold = path%met_fold .or. correction%was_unstable .and. (path%dt < COLD_STEP .or. way%is_warm)
  end subroutine shorten

  !> Moves the wing from a fold to the next stable state, u, from which the path begins anew; `is_lost` if it finds none.
  subroutine fall(work, model, load, options, u, path, is_lost)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    type(static_options_t), intent(in) :: options
    real(rp), intent(inout) :: u(:, :)
    type(path_t), intent(inout) :: path
    logical, intent(out) :: is_lost
    integer, parameter :: LIMIT = 300 ! factorisations
    logical :: converged
    work%stage = min(1.0_rp, path%t + path%dt)
    call descend(work, model, load, stage_tolerance(work, model, options, u), LIMIT, u, converged)
    is_lost = .not. converged
    if (is_lost) return
    work%here_axial = work%axial
    path%t = work%stage
    path%dt = max(path%dt, 2*SMALLEST)
    path%n_old = 0
    path%rejections = 0
    path%rejections_unstable = 0
  end subroutine fall

  !> Returns the residual, relative to the load, to which the stage of `work` is solved.
  pure real(rp) function stage_tolerance(work, model, options, u) result(tolerance)
    type(equilibrium_t), intent(in) :: work
    type(solid_model_t), intent(in) :: model
    type(static_options_t), intent(in) :: options
    real(rp), intent(in) :: u(:, :)
    real(rp), parameter :: PATH_TOLERANCE = 1.0e-3_rp
    tolerance = merge(max(options%tolerance, rounding(work, model, u)), PATH_TOLERANCE, work%stage >= 1)
  end function stage_tolerance

  !> Returns the residual, relative to the load, that is caused by the rounding of the displacements.
  pure real(rp) function rounding(work, model, u)
    type(equilibrium_t), intent(in) :: work
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :)
    rounding = 2*epsilon(u)*maxval(abs(u))*model%params%k_vein*sqrt(3.0_rp*model%n_free)/work%force_scale
  end function rounding

  !> Tests the end of the path for stability with the exact tangent, whose factorisation is kept, and makes up to three more steps
  !> with it; the first step uses the residual at u that `work` holds. The rounding of u to its last bit alone changes the residual
  !> by k_e times that bit, up to 1e-8 of a small load. The rounding of the first correction and all of the last two are therefore
  !> kept separate from u.
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
    call work%factorise(model, load, u, .false., 0.0_rp, is_spd) ! no shift, because it would enter the sensitivities
    is_lost = .not. is_spd
    if (is_lost) then
      report%reason = 'the equilibrium that is found under the full load is unstable'
      return
    end if
    report%reciprocal_condition = work%cholesky%reciprocal_condition()
    call work%newton_step(model, work%g)
    work%trial = u
    u = u + work%du
    work%trial = (work%trial - u) + work%du ! rounding error of the sum
    do refinement = 0, 2
      call work%residual(model, load, u, work%g, low=work%trial)
      size_g = norm2(work%g)
      if (refinement == 2 .or. size_g <= 0.1_rp*options%tolerance*work%force_scale) exit
      call work%newton_step(model, work%g)
      work%trial = work%trial + work%du
    end do
    if (work%force_scale > 0) report%residual = size_g/work%force_scale
    report%converged = report%residual <= options%tolerance
    if (.not. report%converged) report%reason = 'rounding errors keep the relative residual at '// &
                                                number_text(report%residual)//', above the tolerance'
  end subroutine conclude
end module solid_statics
