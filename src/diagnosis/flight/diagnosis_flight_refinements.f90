! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists the numerical errors of a simulated flight, each of which one further flight makes smaller, by how much,
!> and their names for users. A program that simulates flights makes them: diagnosis_flight_runner.
module diagnosis_flight_refinements
  use base_kinds, only: rp
  use base_named_kinds, only: kind_of, named_kind_t, word_of
  use base_text, only: next_word
  implicit none
  private
  public :: refinement_name, refinement_names, read_refinements, thickness_error_over_change

  !> The grid (and with it the step, if it is prescribed), the step alone, the permeability of the solids, the thickness of the
  !> wings, the size of the box, the thickness of the sponge, the number of beats, and how the flow represents the wings.
  integer, parameter, public :: REFINE_GRID = 1, REFINE_STEP = 2, REFINE_PENALTY = 3, REFINE_THICKNESS = 4, REFINE_BOX = 5, &
                                REFINE_SPONGE = 6, REFINE_BEATS = 7, REFINE_SURFACE = 8, N_REFINEMENTS = 8, NOT_REFINED = 0

  real(rp), parameter, public :: FINER = 1.5_rp    !< points in a length, or steps in a time
  real(rp), parameter, public :: THINNER = 0.7_rp  !< of the thickness of the wings
  real(rp), parameter, public :: TIGHTER = 0.5_rp  !< of the permeability
  real(rp), parameter, public :: WIDER = 1.5_rp    !< of the box
  integer, parameter, public :: THICKER = 2        !< of the sponge

  !> What each refinement multiplies its error by, if the error has the order that the methods have: forces converge with the first
  !> order in the distance of points and in the thickness, and with the second in the step of the flow; the layer in a permeable
  !> solid is as thick as the root of the permeability (doi:10.1007/s002110050401); the flow of the images of a body falls with the
  !> square of their distance. No order is known of the sponge and of the beats: 0 says that the refined flight has no such error.
  !> For both representations of the wings, and for their thickness, `thickness_error_over_change` says more where the thickness of
  !> the wings of the experiment is known.
  real(rp), parameter :: LEFT(N_REFINEMENTS) = [1/FINER, 1/FINER**2, sqrt(TIGHTER), THINNER, 1/WIDER**2, 0.0_rp, 0.0_rp, 0.0_rp]

  !> The error of the case over the change that a refinement makes: e/(e - q e), where q e is what it leaves.
  real(rp), parameter, public :: USUAL_ERROR(N_REFINEMENTS) = 1/(1 - LEFT)

  integer, parameter :: EVERY = N_REFINEMENTS + 1, USUAL = N_REFINEMENTS + 2, NOTHING = N_REFINEMENTS + 3
  type(named_kind_t), parameter :: NAMES(N_REFINEMENTS + 3) = [ &
    named_kind_t('grid', REFINE_GRID), named_kind_t('step', REFINE_STEP), named_kind_t('penalization', REFINE_PENALTY), &
    named_kind_t('thickness', REFINE_THICKNESS), named_kind_t('box', REFINE_BOX), named_kind_t('sponge', REFINE_SPONGE), &
    named_kind_t('beats', REFINE_BEATS), named_kind_t('surface', REFINE_SURFACE), named_kind_t('all', EVERY), &
    named_kind_t('yes', USUAL), named_kind_t('no', NOTHING)]
  logical, parameter :: IS_USUAL(N_REFINEMENTS) = [.true., .false., .true., .true., .true., .true., .true., .false.]

contains

  !> Returns the error of the case over the change by a further flight if both are errors of the thickness of the wings, which acts
  !> on forces with the first order. The case has the thickness `of_case`, this flight `of_flight` and the experiment `of_wing`, all
  !> in one unit; wings without thickness have 0. `of_case` and `of_flight` must differ.
  pure real(rp) function thickness_error_over_change(of_case, of_flight, of_wing)
    real(rp), intent(in) :: of_case, of_flight, of_wing
    thickness_error_over_change = abs(of_wing - of_case)/abs(of_flight - of_case)
  end function thickness_error_over_change

  !> Returns the name of a refinement.
  pure function refinement_name(k) result(name)
    integer, intent(in) :: k
    character(:), allocatable :: name
    name = word_of(NAMES, k)
  end function refinement_name

  !> Returns the names of the refinements that are set in `list`, separated by commas.
  pure function refinement_names(list) result(text)
    logical, intent(in) :: list(N_REFINEMENTS)
    character(:), allocatable :: text
    integer :: k
    text = ''
    do k = 1, N_REFINEMENTS
      if (.not. list(k)) cycle
      if (text /= '') text = text//', '
      text = text//refinement_name(k)
    end do
  end function refinement_names

  !> Reads which refinements a user wants: names separated by commas or blanks, `all`, `yes` (all but the step, whose error is small
  !> beside that of the grid, and the other representation of the wings, which `usual_surface` adds) or `no`. `is_named(k)` tells
  !> that the user names refinement k itself. `unknown` is the first word that means nothing, or empty.
  pure subroutine read_refinements(words, usual_surface, wanted, is_named, unknown)
    character(*), intent(in) :: words
    logical, intent(in) :: usual_surface !< `yes` has the surface: the wings of the experiment have a thickness, those of the
    !< case none
    logical, intent(out) :: wanted(N_REFINEMENTS), is_named(N_REFINEMENTS)
    character(:), allocatable, intent(out) :: unknown
    integer :: position, first, last, k
    logical :: found
    wanted = .false.
    is_named = .false.
    unknown = ''
    position = 1
    do
      call next_word(words, ' ,', position, first, last, found)
      if (.not. found) return
      k = kind_of(NAMES, words(first:last))
      select case (k)
      case (EVERY)
        wanted = .true.
      case (USUAL)
        wanted = wanted .or. IS_USUAL
        wanted(REFINE_SURFACE) = wanted(REFINE_SURFACE) .or. usual_surface
      case (1:N_REFINEMENTS)
        wanted(k) = .true.
        is_named(k) = .true.
      case default
        if (k /= NOTHING .and. unknown == '') unknown = words(first:last)
      end select
    end do
  end subroutine read_refinements
end module diagnosis_flight_refinements
