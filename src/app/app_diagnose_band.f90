! SPDX-License-Identifier: GPL-3.0-or-later
!> What the mesh does to a diagnosis: the baseline is fitted on the wing of the file and on the same wing with a mesh of
!> half the size, and the difference between both fits, load by load, is an error of unknown sign and about this size.
!> Numerical error is no physics: with these directions in the covariance it is not named.
module app_diagnose_band
  use app_diagnose_settings, only: diagnose_settings_t
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use diagnosis_lapack, only: orthogonalise
  use diagnosis_refit, only: fit_baseline, nested_fit_t
  use diagnosis_whitener, only: whitener_t
  use diagnosis_wing_bins, only: bins_t, make_bins
  use diagnosis_wing_catalogue, only: catalogue_t, make_catalogue
  use diagnosis_wing_simulator, only: wing_simulator_t
  use diagnosis_wing_task, only: wing_patterns_t
  use measurement_experiment, only: experiment_t
  use parallel_world, only: world_t
  use solid_wing, only: wing_t
  use solid_wing_refine, only: refine_params, refine_wing
  implicit none
  private
  public :: mesh_band_t

  type :: mesh_band_t
    logical :: is_found = .false.
    integer :: n_points = 0               !< of the finer mesh
    real(rp) :: rms = 0                   !< [m] of the difference that remains after both fits
    real(rp) :: snr = 0                   !< that it would mimic
    type(wing_t), private :: wing
    type(experiment_t), private :: experiment
    type(catalogue_t), private :: catalogue
    type(wing_simulator_t), private :: simulator
  contains
    procedure :: init => band_init
    procedure :: find => band_find
    procedure :: serve => band_serve
    procedure :: free => band_free
  end type mesh_band_t

contains

  !> Makes the finer wing on all ranks. Collective. `failure` says why there is none.
  subroutine band_init(self, world, s, failure)
    class(mesh_band_t), intent(inout), target :: self
    type(world_t), intent(in) :: world
    type(diagnose_settings_t), intent(in) :: s
    type(failure_t), intent(out) :: failure
    type(wing_patterns_t) :: patterns
    type(bins_t) :: bins
    call refine_wing(s%setup%wing, self%wing)
    self%n_points = size(self%wing%points, 2)
 call self%experiment%init(s%measurement, self%wing, refine_params(s%setup%asked), [integer ::], s%experiment%options, &
                              failure, s%instrument)
    if (failure%failed) return
    call make_bins(self%experiment, s%bins%size, bins)
    if (bins%n /= s%bins%n) then
      call failure%raise('the finer mesh covers other heights')
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

  !> Rank 0: fits both and gives the band to the simulator of the wing. The others are in `serve`, and then in that of
  !> the simulator.
  subroutine band_find(self, s, simulator)
    class(mesh_band_t), intent(inout), target :: self
    type(diagnose_settings_t), intent(in) :: s
    type(wing_simulator_t), intent(inout), target :: simulator
    type(whitener_t), target :: whitener, whitener_fine
    type(nested_fit_t) :: coarse, fine
    type(failure_t) :: failure
   real(rp), allocatable :: spread(:), difference(:), band(:, :), jacobian(:, :), other(:, :), residuals(:), white(:, :)
    integer :: l, n
    n = simulator%n_observations
    allocate (difference(n), residuals(n), jacobian(n, simulator%n_baseline), other(n, 0))
    call fit_baseline(simulator, reshape(simulator%null_point(), [size(simulator%quantities), 1]), s%options%fit, &
                      whitener, coarse, spread, failure)
    self%is_found = .not. failure%failed
    if (self%is_found) call simulator%evaluate(coarse%q, coarse%active, residuals, jacobian, self%is_found)
    call simulator%dismiss()
    if (self%is_found) then
      deallocate (spread)
      call fit_baseline(self%simulator, reshape(self%simulator%null_point(), [size(self%simulator%quantities), 1]), &
                        s%options%fit, whitener_fine, fine, spread, failure)
      self%is_found = .not. failure%failed
    end if
    if (self%is_found) call self%simulator%evaluate(fine%q, [integer ::], difference, other, self%is_found)
    call self%simulator%dismiss()
    if (.not. self%is_found) return
    difference = difference - residuals
    self%rms = sqrt(sum(difference**2)/n)
    allocate (white(n, 1))
    white(:, 1) = difference
    call whitener%apply(white)
    call whitener%apply(jacobian)
    self%snr = length_beside(white(:, 1), jacobian)
    allocate (band(n, size(s%measurement%loads)), source=0.0_rp)
    do l = 1, size(band, 2)
      where (simulator%labels%surface == l) band(:, l) = difference
    end do
    call simulator%set_band(band)
  end subroutine band_find

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
    call simulator%serve()
    call self%simulator%serve()
  end subroutine band_serve

  !> Releases everything.
  subroutine band_free(self)
    class(mesh_band_t), intent(inout) :: self
    call self%simulator%free()
  end subroutine band_free
end module app_diagnose_band
