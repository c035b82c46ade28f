! SPDX-License-Identifier: GPL-3.0-or-later
!> What the mesh does to a diagnosis: the baseline is fitted on the wing of the file and on the same wing with a mesh of
!> half the size, and the difference d between both fits is an error of unknown sign and about this size. Numerical error
!> is no physics: with these directions in the covariance it is not named. The error is (a + b_l) d in load l, with
!> a ~ N(0, 1) for all loads, as it is one mesh, and b_l ~ N(0, LOADS_DIFFER^2), as loads may converge at another order.
!>
!> Where the diagnosis itself is made on the finer mesh, the error of that mesh is wanted. Richardson's estimate of it from
!> a difference d between meshes of which one has half the size of the other is d/(2^p - 1), p the order of convergence.
!> Two meshes do not tell p; nets of springs converge slowly, and p = 1 is taken: the whole d, too much where p is larger.
!>
!> Both fits are rough: what they lack lies along the unknowns of the baseline, which are fitted anew in all that follows.
module app_diagnose_band
  use app_diagnose_settings, only: diagnose_settings_t
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_lapack, only: orthogonalise
  use diagnosis_refit, only: fit_nested, fit_roughly, nested_fit_t, roughly
  use diagnosis_whitener, only: whitener_t
  use diagnosis_wing_bins, only: bins_t, make_bins
  use diagnosis_wing_catalogue, only: catalogue_t, make_catalogue
  use diagnosis_wing_simulator, only: wing_simulator_t
  use diagnosis_wing_task, only: wing_patterns_t
  use measurement_experiment, only: experiment_t
  use parallel_world, only: world_t
  use solid_params, only: solid_params_t
  use solid_wing, only: wing_t
  use solid_wing_refine, only: refine_params, refine_wing
  implicit none
  private
  public :: mesh_band_t

  !> Half of what lies between the errors of first order and those of second, d/(2^p - 1) with p = 1 and 2.
  real(rp), parameter :: LOADS_DIFFER = 1.0_rp/3

  type :: mesh_band_t
    logical :: is_found = .false.
    integer :: n_points = 0               !< of the finer mesh
    real(rp) :: rms = 0                   !< [m] of the difference that remains after both fits
    real(rp) :: snr = 0                   !< that it would mimic
    real(rp), allocatable :: start(:)     !< (quantities) where the baseline of the diagnosis was fitted roughly
    type(wing_t), private :: wing
    type(experiment_t), private :: experiment
    type(catalogue_t), private :: catalogue
    type(wing_simulator_t), private :: simulator !< on the mesh that the diagnosis is not made on
    integer, allocatable, private :: parents(:, :)
    logical, private :: is_coarser = .false. !< that mesh is the coarser one
  contains
    procedure :: init => band_init
    procedure :: find => band_find
    procedure :: serve => band_serve
    procedure :: free => band_free
  end type mesh_band_t

contains

  !> Makes the other wing on all ranks. Collective. `failure` says why there is none.
  subroutine band_init(self, world, s, failure)
    class(mesh_band_t), intent(inout), target :: self
    type(world_t), intent(in) :: world
    type(diagnose_settings_t), intent(in) :: s
    type(failure_t), intent(out) :: failure
    type(wing_patterns_t) :: patterns
    type(bins_t) :: bins
    type(solid_params_t) :: params
    type(wing_t) :: fine
    self%is_coarser = s%fits_finer
    if (self%is_coarser) then
      self%wing = s%file_wing
      params = s%file_asked
      call refine_wing(s%file_wing, fine, self%parents)
    else
      call refine_wing(s%setup%wing, self%wing, self%parents)
      params = refine_params(s%setup%asked)
    end if
    self%n_points = size(self%parents, 2)
    call self%experiment%init(s%measurement, self%wing, params, [integer ::], s%experiment%options, failure, &
                              s%instrument)
    if (failure%failed) return
    call make_bins(self%experiment, s%bins%size, bins)
    if (bins%n /= s%bins%n) then
      call failure%raise('the other mesh covers other heights')
      return
    end if
    call make_catalogue(self%experiment, self%wing, s%sought%numbers, s%config%get_real('Diagnose', 'prior_decades'), &
                        self%catalogue)
    allocate (patterns%place(2, 0))
    call self%simulator%init(world, self%experiment, self%wing, self%catalogue%quantities, self%catalogue%kinds, &
                             self%catalogue%n_baseline, self%catalogue%effects, bins, patterns)
    self%simulator%noise = s%noise%model
    self%simulator%membrane_sd = s%membrane_sd
  end subroutine band_init

  !> Rank 0: fits both and gives the band to the simulator of the diagnosis. The others are in `serve`.
  subroutine band_find(self, s, simulator)
    class(mesh_band_t), intent(inout), target :: self
    type(diagnose_settings_t), intent(in) :: s
    type(wing_simulator_t), intent(inout), target :: simulator
    type(whitener_t), target :: whitener
    real(rp), allocatable :: coarse(:), fine(:), jacobian(:, :), band(:, :), white(:, :)
    integer :: l, n
    n = simulator%n_observations
    allocate (coarse(n), fine(n), jacobian(n, simulator%n_baseline), white(n, 1))
    if (self%is_coarser) then
      call fit_both(self, s, self%simulator, simulator, whitener, coarse, fine, jacobian)
    else
      call fit_both(self, s, simulator, self%simulator, whitener, coarse, fine, jacobian)
    end if
    if (.not. self%is_found) return
    self%rms = sqrt(sum((fine - coarse)**2)/n)
    white(:, 1) = fine - coarse
    call whitener%apply(white)
    call whitener%apply(jacobian)
    self%snr = length_beside(white(:, 1), jacobian)
    allocate (band(n, 0:size(s%measurement%loads)), source=0.0_rp)
    band(:, 0) = fine - coarse
    do l = 1, ubound(band, 2)
      where (simulator%labels%surface == l) band(:, l) = LOADS_DIFFER*band(:, 0)
    end do
    call simulator%set_band(band)
  end subroutine band_find

  !> Fits the coarser wing, then, from there and with the same weights, the finer one: residuals(n) of both, derivatives of
  !> the first, and where the diagnosis begins. Everyone who serves is dismissed in this order.
  subroutine fit_both(self, s, coarse, fine, whitener, r_coarse, r_fine, jacobian)
    class(mesh_band_t), intent(inout) :: self
    type(diagnose_settings_t), intent(in) :: s
    type(wing_simulator_t), intent(inout), target :: coarse, fine
    type(whitener_t), intent(inout), target :: whitener
    real(rp), intent(out) :: r_coarse(:), r_fine(:), jacobian(:, :)
    type(nested_fit_t) :: one, two
    type(failure_t) :: failure
    integer :: i
    real(rp) :: nothing(size(r_fine), 0), q(size(fine%quantities))
    call whitener%init(coarse, [(i, i=1, coarse%n_observations)], failure)
    if (.not. failure%failed) call fit_roughly(coarse, coarse%null_point(), s%options%fit, whitener, one, failure)
    self%is_found = .not. failure%failed
    if (self%is_found) call coarse%evaluate(one%q, one%active, r_coarse, jacobian, self%is_found)
    call coarse%dismiss()
    if (self%is_found) then
      call fine%begin_like(coarse, self%parents)
      q = fine%null_point()
      q(one%active) = one%q(one%active) ! further quantities are those of the catalogue, at their null
      call fit_nested(fine, whitener, one%active, q, roughly(s%options%fit), two)
      self%is_found = two%is_found
    end if
    if (self%is_found) call fine%evaluate(two%q, [integer ::], r_fine, nothing, self%is_found)
    call fine%dismiss()
    if (.not. self%is_found) return
    if (self%is_coarser) self%start = two%q
    if (.not. self%is_coarser) self%start = one%q
  end subroutine fit_both

  !> Length of a without what the columns of j can imitate.
  real(rp) function length_beside(a, j) result(length)
    real(rp), intent(in) :: a(:), j(:, :)
    real(rp), allocatable :: q(:, :), r(:, :)
    call orthogonalise(j, q, r)
    length = norm2(a - matmul(q, matmul(a, q)))
  end function length_beside

  !> The counterpart of `find` on the other ranks.
  subroutine band_serve(self, simulator)
    class(mesh_band_t), intent(inout) :: self
    type(wing_simulator_t), intent(inout) :: simulator
    if (self%is_coarser) then
      call self%simulator%serve()
      call simulator%serve()
    else
      call simulator%serve()
      call self%simulator%serve()
    end if
  end subroutine band_serve

  !> Releases everything.
  subroutine band_free(self)
    class(mesh_band_t), intent(inout) :: self
    call self%simulator%free()
  end subroutine band_free
end module app_diagnose_band
