! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes one stage of a quasi-static loading path: extrapolated from the last points, corrected by a mixed-stress Newton method.
!>
!> The axial forces N of the springs are independent iterates. They enter the geometric stiffness and are updated by their
!> linearised law, while the residual is exact. Newton's method then converges quadratically in spite of the stiff springs; near its
!> end one factorisation serves several steps. Stages begin with the parabola through the last three points.
module solid_path_correction
  use base_kinds, only: rp
  use solid_equilibrium, only: equilibrium_t
  use solid_extension, only: extension_axial
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_vectors, only: longest
  implicit none
  private
  public :: correct, correction_t, path_t, way_t

  !> Options of a path.
  type :: way_t
    logical :: is_warm = .false. !< starts from the solution for other parameters, in one stage if possible
    logical :: is_fine = .false. !< stages begin on the straight line, and a factorisation serves one step only
  end type way_t

  !> Progress of a path.
  type :: path_t
    real(rp) :: t = 0, old_t = 0, older_t = 0 !< parts of the load at its last three points, the last one first
    real(rp) :: dt = 0                        !< of the next stage
    real(rp) :: most_moved = 0                !< [m] in one stage
    integer :: n_old = 0                      !< earlier points that the extrapolation may use
    integer :: rejections = 0, rejections_unstable = 0 !< in a row
    logical :: met_fold = .false.
  contains
    procedure :: ahead => path_ahead
  end type path_t

  !> Result of the correction of a stage.
  type :: correction_t
    real(rp) :: moved = 0 !< [m] largest movement from the last point
    logical :: accepted = .false., was_unstable = .false.
    integer :: n_used = 0 !< factorisations, and one more if the last one served several steps
  end type correction_t

contains

  !> Extrapolates the path to the part `target` of the load. Returns the factors of the last difference of points (two) and of the
  !> difference before it (one), for the parabola through the last three points or the line through the last two.
  pure function path_ahead(self, target) result(ahead)
    class(path_t), intent(in) :: self
    real(rp), intent(in) :: target
    real(rp) :: ahead(3)
    ahead = 0
    associate (t => self%t, old_t => self%old_t, older_t => self%older_t)
      if (self%n_old >= 1) ahead(1) = (target - t)/(t - old_t)
      if (self%n_old >= 2) ahead(2) = (target - t)*(target - old_t)/(t - older_t)
      if (self%n_old >= 2) ahead(2:3) = ahead(2)/[t - old_t, old_t - older_t]
    end associate
  end function path_ahead

  !> Sets the start of a stage: the path's last point u, extrapolated to the stage of `work`.
  subroutine extrapolate(work, model, load, path, u)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    type(path_t), intent(in) :: path
    real(rp), intent(in) :: u(:, :)
    real(rp) :: ahead(3)
    ahead = path%ahead(work%stage)
    work%trial = u + (ahead(1) + ahead(2))*(u - work%old) - ahead(3)*(work%old - work%older)
    work%axial = work%here_axial + (ahead(1) + ahead(2))*(work%here_axial - work%old_axial) - &
                 ahead(3)*(work%old_axial - work%older_axial)
    if (path%t > 0 .or. work%is_growing .or. work%stage < 1) then
      call work%residual(model, load, work%trial, work%g)
    else
      work%g = work%start_residual
    end if
  end subroutine extrapolate

  !> Iterates by Newton's method at the stage of `work`, from the last point u(3, n_all) [m] of the path, extrapolated. If the
  !> result is accepted, work%trial and work%axial are the new point.
  subroutine correct(work, model, load, way, path, tolerance, u, correction)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    type(way_t), intent(in) :: way
    type(path_t), intent(in) :: path
    real(rp), intent(in) :: tolerance !< of the residual, relative to the load
    real(rp), intent(in) :: u(:, :)
    type(correction_t), intent(out) :: correction
    real(rp), parameter :: SHIFT = 1.0e-13_rp ! of k_e
    real(rp), parameter :: WORTH_REUSE = 0.1_rp ! of the load and of the residual before
    real(rp) :: size_g, last_size
    integer :: iteration, begin, growths, n_more
    logical :: is_spd
    begin = work%cholesky%n_factorisations
    growths = 0
    n_more = 0
    call extrapolate(work, model, load, path, u)
    size_g = norm2(work%g)
    do iteration = 1, merge(12, 8, work%stage >= 1)
      call work%factorise(model, load, work%trial, .false., SHIFT*model%params%k_vein, is_spd)
      if (.not. is_spd) then
        if (correction%was_unstable) exit
        correction%was_unstable = .true.
        call work%factorise(model, load, work%trial, .true., SHIFT*model%params%k_vein, is_spd)
        if (.not. is_spd) exit
      end if
      call work%newton_step(model, work%g)
      if (longest(work%du) > 3*path%most_moved) exit
      call extension_axial(model%springs, model%stiffness%extension, work%trial, work%axial, work%du)
      work%trial = work%trial + work%du
      correction%moved = longest(work%trial, u)
      if (correction%moved > 4*path%most_moved) exit
      last_size = size_g
      call work%residual(model, load, work%trial, work%g)
      size_g = norm2(work%g)
      correction%accepted = size_g <= tolerance*work%force_scale
      if (correction%accepted) exit
      if (iteration > 1 .and. size_g > last_size) growths = growths + 1
      if (growths >= 2) exit
      if (way%is_fine .or. correction%was_unstable .or. size_g > WORTH_REUSE*min(last_size, work%force_scale)) cycle
      call reuse_factors(work, model, load, tolerance, u, size_g, correction)
      if (.not. correction%accepted) cycle
      n_more = 1
      exit
    end do
    correction%n_used = work%cholesky%n_factorisations - begin + n_more
  end subroutine correct

  !> Makes further steps with the last factorisation while each reduces the residual well; a step costs an eighth of a new
  !> factorisation. The error of the old factors lies in few directions. Each step is therefore combined with the previous one by
  !> Anderson's method (1965), doi:10.1145/321296.321305, with a memory of one.
  subroutine reuse_factors(work, model, load, tolerance, u, size_g, correction)
    type(equilibrium_t), intent(inout) :: work
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: tolerance
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(inout) :: size_g
    type(correction_t), intent(inout) :: correction
    integer, parameter :: MOST = 8
    real(rp), parameter :: GOOD = 0.6_rp ! reduction
    real(rp) :: last_size, change, fraction
    integer :: step
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
      correction%accepted = size_g <= tolerance*work%force_scale
      if (correction%accepted) exit
    end do
    correction%moved = longest(work%trial, u)
  end subroutine reuse_factors
end module solid_path_correction
