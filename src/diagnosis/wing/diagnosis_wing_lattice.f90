! SPDX-License-Identifier: GPL-3.0-or-later
!> Places lattice points all over a wing, at which the diagnosis tries causes that may act anywhere.
module diagnosis_wing_lattice
  use base_kinds, only: rp
  use diagnosis_families, only: FAMILY_FORCE, FAMILY_SCANS, FAMILY_STIFFNESS, FAMILY_VEINS
  use diagnosis_wing_parameters, only: wing_parameter_t
  use measurement_experiment, only: experiment_t
  use measurement_material_point, only: find_material_point
  use measurement_observed_wing, only: wing_patterns_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: lattice, lay_out_patterns, make_patterns

  real(rp), parameter :: PATTERN_RADIUS = 0.16_rp !< of the wing's size

contains

  !> Finds the sites of unknown causes.
  subroutine make_patterns(experiment, wing, patterns)
    type(experiment_t), intent(in) :: experiment
    type(wing_t), intent(in) :: wing
    type(wing_patterns_t), intent(out) :: patterns
    patterns%radius = PATTERN_RADIUS*experiment%model%size
    call lattice(wing, experiment%model%size, PATTERN_RADIUS, patterns%site)
  end subroutine make_patterns

  !> Finds the families and the sites (2, :) [m] of all patterns: stiffness and forces at the sites of `patterns`, n_scan_errors
  !> errors of each scan at its load, and the fields of soft places at their hinges: the parameters with the numbers `field`.
  subroutine lay_out_patterns(experiment, parameters, patterns, n_scan_errors, field, family, sites)
    type(experiment_t), intent(in) :: experiment
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(wing_patterns_t), intent(in) :: patterns
    integer, intent(in) :: n_scan_errors, field(:)
    integer, allocatable, intent(out) :: family(:)
    real(rp), allocatable, intent(out) :: sites(:, :)
    integer :: l, n
    n = size(patterns%site, 2)
    family = [(FAMILY_STIFFNESS, l=1, n), (FAMILY_FORCE, l=1, n), (FAMILY_SCANS, l=1, n_scan_errors*size(experiment%loads)), &
              (FAMILY_VEINS, l=1, size(field))]
    sites = reshape([patterns%site, patterns%site, &
                     [(spread(experiment%measurement%loads(l)%point, 2, n_scan_errors), l=1, size(experiment%loads))], &
                     experiment%model%layout%hinge_site(:, parameters(field)%number)], [2, size(family)])
  end subroutine lay_out_patterns

  !> Finds points (2, n) [m] of a triangular lattice on the wing, or on its veins if it has no membrane. Their distance is a
  !> fraction of its size.
  subroutine lattice(wing, length, fraction, sites)
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: length, fraction
    real(rp), allocatable, intent(out) :: sites(:, :)
    real(rp) :: site(2), low(2), high(2), spacing
    integer :: i, j
    spacing = fraction*length
    low = minval(wing%points(:2, :), 2)
    high = maxval(wing%points(:2, :), 2)
    allocate (sites(2, 0))
    if (size(wing%triangles) == 0) then
      call along_veins(wing, spacing, sites)
      return
    end if
    do j = 0, int((high(2) - low(2))/(0.866_rp*spacing)) + 1
      do i = 0, int((high(1) - low(1))/spacing) + 1
        site = low + [(i + 0.5_rp*modulo(j, 2))*spacing, (j + 0.25_rp)*0.866_rp*spacing]
        associate (found => find_material_point(wing%points, wing%triangles, length, site))
          if (found%is_found) sites = reshape([sites, site], [2, size(sites, 2) + 1])
        end associate
      end do
    end do
  end subroutine lattice

  !> Finds points of a wing without membrane, no two of them closer than `spacing` [m].
  subroutine along_veins(wing, spacing, sites)
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: spacing
    real(rp), allocatable, intent(inout) :: sites(:, :)
    integer :: i
    do i = 1, size(wing%points, 2)
      if (any(wing%root == i)) cycle
      if (size(sites, 2) > 0) then
        if (minval(norm2(sites - spread(wing%points(:2, i), 2, size(sites, 2)), 1)) < spacing) cycle
      end if
      sites = reshape([sites, wing%points(:2, i)], [2, size(sites, 2) + 1])
    end do
  end subroutine along_veins
end module diagnosis_wing_lattice
