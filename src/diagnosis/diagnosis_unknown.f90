! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes a cause that is not in the catalogue: where on the wing it acts, and which entries of the catalogue are most
!> similar to it without being sufficient.
module diagnosis_unknown
  use base_kinds, only: rp
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_wing_simulator, only: wing_simulator_t
  use inference_decision, only: VERDICT_UNKNOWN
  use inference_engine, only: diagnosis_t
  use inference_region, only: find_region, find_related, region_t, related_t
  implicit none
  private
  public :: unknown_t, candidate_name, describe_unknown

  !> Describes an unknown cause. Empty for any other verdict.
  type :: unknown_t
    type(region_t) :: region
    real(rp), allocatable :: site(:, :)            !< (2, size(region%pattern)) [m]
    real(rp) :: cell = 0                            !< [m] half the distance between neighbouring positions
    type(related_t), allocatable :: related(:)
    character(:), allocatable :: names(:)           !< (size(related)) title and position
    integer :: family = 0                           !< of the region: FAMILY_*
  contains
    procedure :: centre => unknown_centre
    procedure :: radius => unknown_radius
  end type unknown_t

contains

  !> Finds the region of the unknown cause and the related entries of the catalogue.
  function describe_unknown(s, simulator, d) result(unknown)
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(in) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(unknown_t) :: unknown
    integer :: i
    allocate (unknown%related(0), unknown%site(2, 0))
    if (d%decision%verdict /= VERDICT_UNKNOWN) return
    unknown%cell = 0.5_rp*s%patterns%radius
    call find_region(d%model%design, d%tests%z, simulator%pattern_site, s%patterns%radius, unknown%region)
    if (unknown%region%is_found) then
      unknown%family = simulator%family_kinds(unknown%region%family)
      associate (patterns => d%model%design%families(unknown%region%family)%patterns)
        unknown%site = simulator%pattern_site(:, patterns(unknown%region%pattern))
      end associate
    end if
    call find_related(d%model%design, d%model%calibration, d%tests%statistics, d%tests%z, unknown%related)
    allocate (character(200) :: unknown%names(size(unknown%related)))
    do i = 1, size(unknown%related)
      unknown%names(i) = candidate_name(s, d, unknown%related(i)%candidate)
    end do
  end function describe_unknown

  !> Returns the title and the position of a candidate.
  function candidate_name(s, d, c) result(text)
    class(diagnosis_case_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: c
    character(:), allocatable :: text
    associate (one => d%model%design%candidates(c))
      associate (effect => s%catalogue%effects(one%effect))
        text = effect%title
        if (effect%variants(one%variant)%label /= '') text = text//', '//effect%variants(one%variant)%label
      end associate
    end associate
  end function candidate_name

  !> Returns the mean (2) [m] of the positions of part i, weighted with their fractions.
  pure function unknown_centre(self, i) result(centre)
    class(unknown_t), intent(in) :: self
    integer, intent(in) :: i
    real(rp) :: centre(2), weight(size(self%region%fraction))
    weight = merge(self%region%fraction, 0.0_rp, self%region%part == i)
    centre = matmul(self%site, weight)/sum(weight)
  end function unknown_centre

  !> Returns the radius [m] of the circle about the centre that holds the cells of all positions of part i.
  pure real(rp) function unknown_radius(self, i) result(radius)
    class(unknown_t), intent(in) :: self
    integer, intent(in) :: i
    real(rp) :: middle(2)
    integer :: k
    middle = self%centre(i)
    radius = self%cell
    do k = 1, size(self%region%pattern)
      if (self%region%part(k) == i) radius = max(radius, self%cell + norm2(self%site(:, k) - middle))
    end do
  end function unknown_radius
end module diagnosis_unknown
