! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the places of effects that may be anywhere, from the best places of their scans, and makes them candidates.
!>
!> The evidence pays for a place as for any finer place of a scan: see inference_weights.
module inference_places
  use base_kinds, only: rp
  use inference_design, only: design_t
  use inference_record, only: model_t, tests_t
  use inference_search_place, only: place_search_t, place_t
  use inference_simulator, only: simulator_t
  implicit none
  private
  public :: find_places, place_found

  integer, parameter :: N_STARTS = 12        !< most places of the scan at which a search begins
  !> Least log evidence of an effect that is worth a search, as a fraction of the largest one: tangents at the baseline may miss a
  !> part of a strong effect.
  real(rp), parameter :: SHARE = 0.5_rp
  real(rp), parameter :: WORTH = 0.3_rp      !< decrease of the sum of squares that is worth a move, in units of the noise

contains

  !> Searches a place of every effect that may be anywhere and whose scan comes near the best effect, and releases its variant
  !> there. The baseline of the model then has this place. `has_place` tells whether one was found.
  subroutine find_places(simulator, tests, model, has_place)
    class(simulator_t), intent(inout), target :: simulator
    type(tests_t), intent(in) :: tests
    type(model_t), intent(inout), target :: model
    logical, intent(out) :: has_place
    type(place_search_t) :: search
    type(place_t) :: found
    real(rp), allocatable :: starts(:, :), strengths(:)
    real(rp) :: least
    integer :: e
    has_place = .false.
    least = max(0.0_rp, SHARE*maxval(tests%hypotheses%effect))
    do e = 1, size(simulator%effects)
      if (simulator%effects(e)%anywhere == 0 .or. tests%hypotheses%effect(e) < least) cycle
      call choose_starts(simulator, tests, model%design, e, starts, strengths)
      if (size(strengths) == 0) cycle
      search%simulator => simulator
      search%whitener => model%whitener
      search%prior = model%design%prior
      search%weight = model%design%weight
      search%effect = e
      search%strength = simulator%effects(e)%variants(simulator%effects(e)%anywhere)%columns(1)
      search%worth = WORTH*tests%scale
      call search%run(starts, strengths, model%baseline%q, model%baseline%state, found)
      if (.not. found%is_valid) cycle
      call simulator%settle_place(e, found%at, found%q(search%strength))
      call simulator%take_places(model%baseline%q)
      has_place = .true.
    end do
  end subroutine find_places

  !> Returns the places starts(coordinates, :) of the scan of effect e that have the largest evidence, and the strengths(:) there,
  !> by the tangents.
  subroutine choose_starts(simulator, tests, design, e, starts, strengths)
    class(simulator_t), intent(in) :: simulator
    type(tests_t), intent(in) :: tests
    type(design_t), intent(in) :: design
    integer, intent(in) :: e
    real(rp), allocatable, intent(out) :: starts(:, :), strengths(:)
    real(rp) :: evidence(size(design%candidates)), estimate(1)
    integer :: c, i
    evidence = -huge(1.0_rp)
    do c = 1, size(evidence)
      associate (one => design%candidates(c))
        if (one%effect /= e .or. one%df == 0 .or. one%is_finer) cycle
        evidence(c) = one%size_prior%log_evidence(matmul(tests%z, one%basis))
      end associate
    end do
    allocate (starts(size(simulator%effects(e)%place_columns), 0), strengths(0))
    do i = 1, N_STARTS
      c = maxloc(evidence, 1)
      if (.not. evidence(c) > -huge(1.0_rp)) exit
      evidence(c) = -huge(1.0_rp)
      associate (one => design%candidates(c), variant => simulator%effects(e)%variants(design%candidates(c)%variant))
        estimate = simulator%parameters(one%columns)%null - matmul(one%solve, matmul(tests%z*sqrt(tests%scale), one%basis))
        starts = reshape([starts, variant%place], [size(starts, 1), i])
        strengths = [strengths, estimate]
      end associate
    end do
  end subroutine choose_starts

  !> Returns the candidate of effect e at the place that was found; 0: there is none.
  pure integer function place_found(simulator, design, e) result(c)
    class(simulator_t), intent(in) :: simulator
    type(design_t), intent(in) :: design
    integer, intent(in) :: e
    c = 0
    if (allocated(simulator%effects(e)%place)) &
      c = findloc(design%candidates%effect == e .and. design%candidates%variant == simulator%effects(e)%anywhere, .true., 1)
  end function place_found
end module inference_places
