! SPDX-License-Identifier: GPL-3.0-or-later
!> Locates an unknown cause, and finds the entries of the catalogue that are most similar to it.
!>
!> An unknown cause, for instance a change of stiffness or further forces, acts at a single position or as a smooth field over all
!> positions (inference_hypotheses). For a single position, the evidences of all positions give its posterior distribution, and the
!> region is the smallest set of positions that contains it with the probability REGION_LEVEL. A field has amplitudes with posterior
!> means m and sds s at its most likely strength. Its region is the smallest set of positions that holds the fraction REGION_LEVEL
!> of the sum of (m/s)^2, without those whose intervals of this probability contain 0. A position stands for the cell of the lattice
!> around it.
module inference_region
  use base_kinds, only: rp
  use inference_calibration, only: calibration_t, statistics_t
  use inference_design, only: design_t
  use inference_families, only: family_t
  use inference_distributions, only: log_add
  use inference_hypotheses, only: IMPOSSIBLE
  implicit none
  private
  public :: related_t, region_t, find_region, find_related

  real(rp), parameter, public :: REGION_LEVEL = 0.9_rp
  real(rp), parameter :: TWO_SIDED = 1.6448536269514722_rp !< [sd] a normal variable lies within this with probability REGION_LEVEL
  real(rp), parameter :: NEIGHBOURS = 1.2_rp               !< times the distance of lattice points
  real(rp), parameter :: RELATED_LEVEL = 0.05_rp
  integer, parameter :: MOST_RELATED = 3

  !> The region, in connected parts. It is empty if no region is more probable than others.
  type :: region_t
    logical :: is_found = .false.           !< there are families of unknown causes
    integer :: family = 0                   !< of the design
    logical :: is_one_site = .false.       !< more probable than a field
    integer :: n_parts = 0
    integer, allocatable :: pattern(:)      !< of the family's patterns, part by part, the largest fraction first
    integer, allocatable :: part(:)         !< the part to which it belongs
    real(rp), allocatable :: fraction(:)    !< probability of a position; for a field, fraction of the sum of (mean/sd)^2
  end type region_t

  !> An effect that would cause a part of the misfit.
  type :: related_t
    integer :: effect = 0, candidate = 0
    real(rp) :: explained = 0               !< fraction of |z|^2 in excess of that of noise
  end type related_t

contains

  !> Finds the region for z(k), in units of the noise. site(2, patterns) [m] are the positions of the simulator's patterns, and
  !> `distance` [m] is that between neighbours on their lattice.
  subroutine find_region(design, z, site, distance, region)
    type(design_t), intent(in) :: design
    real(rp), intent(in) :: z(:), site(:, :), distance
    type(region_t), intent(out) :: region
    real(rp), allocatable :: alone(:), best(:), mean(:), sd(:), weight(:)
    logical, allocatable :: is_in(:)
    real(rp) :: field, one, most
    integer :: f
    allocate (region%pattern(0), region%part(0), region%fraction(0))
    most = -huge(most)
    do f = 1, size(design%families)
      call find_evidences(design%families(f), z, field, one, alone)
      if (log_add(field, one) <= most) cycle
      most = log_add(field, one)
      region%is_found = .true.
      region%family = f
      region%is_one_site = one > field
      best = alone
    end do
    if (.not. region%is_found) return
    associate (family => design%families(region%family))
      if (region%is_one_site) then
        weight = exp(max(-700.0_rp, best - maxval(best)))
        weight = weight/sum(weight)
        is_in = highest_density_set(weight, weight >= 0)
      else
        call family%posterior(z, mean, sd)
        weight = (mean/max(sd, tiny(1.0_rp)))**2
        weight = weight/max(sum(weight), tiny(1.0_rp))
        is_in = highest_density_set(weight, abs(mean) > TWO_SIDED*sd)
      end if
      call find_connected_parts(site(:, family%patterns), NEIGHBOURS*distance, weight, is_in, region)
    end associate
  end subroutine find_region

  !> Returns the log evidences of a family: as a field, as a single position, and alone(patterns) for each position.
  subroutine find_evidences(family, z, field, one, alone)
    type(family_t), intent(in) :: family
    real(rp), intent(in) :: z(:)
    real(rp), intent(out) :: field, one
    real(rp), allocatable, intent(out) :: alone(:)
    integer :: i
    field = family%size_prior%log_evidence(matmul(z, family%basis))
    allocate (alone(size(family%patterns)), source=IMPOSSIBLE)
    one = IMPOSSIBLE
    do i = 1, size(family%alone, 2)
      associate (evidence => family%size_prior_alone%log_evidence([dot_product(z, family%alone(:, i))]))
        alone(family%shown(i)) = evidence
        one = log_add(one, evidence)
      end associate
    end do
    one = one - log(real(max(1, size(family%alone, 2)), rp))
  end subroutine find_evidences

  !> Returns the fewest of the allowed positions that hold REGION_LEVEL of weight(:), which adds up to 1; all if they hold less.
  pure function highest_density_set(weight, is_allowed) result(is_in)
    real(rp), intent(in) :: weight(:)
    logical, intent(in) :: is_allowed(:)
    logical :: is_in(size(weight))
    integer :: i
    is_in = .false.
    do
      if (all(is_in .or. .not. is_allowed) .or. sum(weight, mask=is_in) >= REGION_LEVEL) return
      i = maxloc(weight, 1, mask=is_allowed .and. .not. is_in)
      is_in(i) = .true.
    end do
  end function highest_density_set

  !> Sorts positions into connected parts: each position has a neighbour within `reach` in its part.
  subroutine find_connected_parts(site, reach, weight, is_in, region)
    real(rp), intent(in) :: site(:, :), reach, weight(:)
    logical, intent(in) :: is_in(:)
    type(region_t), intent(inout) :: region
    integer :: label(size(is_in)), i, j, n, k
    logical :: has_grown
    label = 0
    n = 0
    do i = 1, size(label)
      if (.not. is_in(i) .or. label(i) > 0) cycle
      n = n + 1
      label(i) = n
      has_grown = .true.
      do while (has_grown)
        has_grown = .false.
        do j = 1, size(label)
          if (.not. is_in(j) .or. label(j) > 0) cycle
          if (.not. any([(label(k) == n .and. norm2(site(:, j) - site(:, k)) <= reach, k=1, size(label))])) cycle
          label(j) = n
          has_grown = .true.
        end do
      end do
    end do
    region%n_parts = n
    do i = 1, n
      j = maxloc([(sum(weight, mask=label == k), k=1, n)], 1)
      region%pattern = [region%pattern, pack([(k, k=1, size(label))], label == j)]
      region%part = [region%part, spread(i, 1, count(label == j))]
      region%fraction = [region%fraction, pack(weight, label == j)]
      where (label == j) label = 0
    end do
  end subroutine find_connected_parts

  !> Finds the effects that explain a part of z(k) which is larger than chance, the largest part first; at most MOST_RELATED.
  subroutine find_related(design, calibration, statistics, z, related)
    type(design_t), intent(in) :: design
    type(calibration_t), intent(in) :: calibration
    type(statistics_t), intent(in) :: statistics
    real(rp), intent(in) :: z(:)
    type(related_t), allocatable, intent(out) :: related(:)
    type(related_t) :: one
    real(rp) :: beyond(size(statistics%best))
    integer :: e
    beyond = -1
    do e = 1, size(beyond)
      associate (c => statistics%best(e))
        if (c == 0) cycle
        if (calibration%log_p_effect(e, statistics%effect(e)) > log(RELATED_LEVEL)) cycle
        beyond(e) = statistics%squares(c) - design%candidates(c)%df
      end associate
    end do
    allocate (related(0))
    do while (size(related) < MOST_RELATED)
      e = maxloc(beyond, 1)
      if (e == 0) return
      if (.not. beyond(e) > 0) return
      one%effect = e
      one%candidate = statistics%best(e)
      one%explained = min(1.0_rp, beyond(e)/max(beyond(e), sum(z**2) - design%k))
      related = [related, one]
      beyond(e) = -1
    end do
  end subroutine find_related
end module inference_region
