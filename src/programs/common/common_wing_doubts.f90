! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes remarks on the material of a wing: on values of a blowfly that replace missing values, and on values that are wrong by
!> orders of magnitude. It also prints the remarks on an input.
module common_wing_doubts
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_magnitude, only: magnitude_doubt, rounded
  use base_text, only: number_text
  use common_wing_keys, only: mass_choices_t
  use io_config, only: config_t
  use solid_wing, only: wing_t, MEMBRANE_UNIFORM, MEMBRANE_UNSTATED
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: notice_assumptions, notice_magnitudes, check_size, print_notices, size_hint

  character(*), parameter :: PAPER = 'Truong et al.'
  !> These are the ranges of insects, with a decade of room.
  real(rp), parameter :: YOUNG(2) = [1.0e7_rp, 1.0e11_rp]        !< cuticle of veins [Pa]
  real(rp), parameter :: PLATE(2) = [1.0e-13_rp, 1.0e-5_rp]      !< membrane of 0.3 to 30 um [N m]
  real(rp), parameter :: DENSITY(2) = [100.0_rp, 1.0e4_rp]       !< cuticle [kg/m^3]
  real(rp), parameter :: AREAL(2) = [1.0e-4_rp, 1.0e-1_rp]       !< membrane [kg/m^2]
  real(rp), parameter :: LONGEST = 0.2_rp                        !< wings longer than this are not those of insects [m]
  real(rp), parameter :: SHORTEST = 1.0e-4_rp                    !< length of the wings of the smallest wasps [m]
  real(rp), parameter :: IMPOSSIBLE = 10                         !< sizes above this multiple of LONGEST are mistakes

contains

  !> Prints remarks on an input. With `is_check` it prints them as comments before the values of --check, so that the whole
  !> output is an input with the same meaning.
  subroutine print_notices(notices, is_check)
    type(message_list_t), intent(in) :: notices
    logical, intent(in) :: is_check
    if (is_check) then
      call notices%print(output_unit, '; notice: ')
    else
      call notices%print(error_unit, 'notice: ')
    end if
  end subroutine print_notices

  !> Adds a notice for each number that is assumed because neither the input nor the wing file gives it. The notice says of what
  !> wing the number is.
  subroutine notice_assumptions(c, is_paper, choices, wing, needs_mass, notices)
    type(config_t), intent(in) :: c
    logical, intent(in) :: is_paper !< [Wing] preset = paper
    type(mass_choices_t), intent(in) :: choices
    type(wing_t), intent(in) :: wing
    logical, intent(in) :: needs_mass
    type(message_list_t), intent(inout) :: notices
    logical :: has_membrane
    has_membrane = size(wing%triangles, 2) > 0
    if (.not. is_paper) then
      if (size(wing%veins) > 0) call assume('Wing', 'E', '12.58 GPa, the mean of nine blowflies ('//PAPER//')')
      if (has_membrane) call assume('Wing', 'D', '2e-7 N m, a regularisation that was not measured on any wing')
    end if
    if (.not. needs_mass) return
    if (size(wing%veins) > 0 .and. .not. wing%mass%vein_density > 0) &
      call assume('Mass', 'vein_density', '1300 kg/m^3, of insect cuticle')
    if (.not. has_membrane) return
    if (wing%mass%law /= MEMBRANE_UNSTATED .and. .not. (choices%has_law .or. choices%has_areal_density)) return
    if (choices%law == MEMBRANE_UNIFORM) then
      call assume('Mass', 'areal_density', '3e-3 kg/m^2, about 2.5 um of cuticle, which was not measured on any wing')
    else if (choices%has_membrane_mass) then
      call assume('Mass', 'membrane_law', 'bilinear, so that the mass is spread as in a blowfly''s wing ('//PAPER//'); uniform '// &
                  'takes areal_density')
    else
      call assume('Mass', 'membrane_mass', '81.475 ug spread by the bilinear law of a blowfly''s wing ('//PAPER//'), because '// &
                  'the wing file does not state the mass of the membrane')
    end if

  contains

    subroutine assume(section, key, what)
      character(*), intent(in) :: section, key, what
      if (.not. c%is_given(section, key)) call c%complain(notices, section, key, 'is not given; the program assumes '//what)
    end subroutine assume
  end subroutine notice_assumptions

  !> Adds a notice for each number that no insect wing has, with the unit that the user may have meant. It does not check large
  !> wings.
  subroutine notice_magnitudes(c, law, s, notices)
    type(config_t), intent(in) :: c
    integer, intent(in) :: law !< [Mass] membrane_law
    type(wing_case_t), intent(in) :: s
    type(message_list_t), intent(inout) :: notices
    if (maxval(abs(s%wing%points)) > LONGEST) return
    if (size(s%wing%veins) > 0) then
      call doubt('Wing', 'E', s%requested%young, YOUNG, 'Pa', 'veins of insects')
      call doubt('Mass', 'vein_density', s%material%vein_density, DENSITY, 'kg/m^3', 'veins of insects')
    end if
    if (size(s%wing%triangles, 2) == 0) return
    call doubt('Wing', 'D', s%requested%plate, PLATE, 'N m', 'membranes of insects')
    if (.not. s%mass%area > 0) return
    if (law == MEMBRANE_UNIFORM) then
      call doubt('Mass', 'areal_density', s%mass%membrane/s%mass%area, AREAL, 'kg/m^2', 'membranes of insects')
    else
      call doubt('Mass', 'membrane_mass', s%material%membrane_mass, rounded(AREAL*s%mass%area, 1), 'kg', 'membranes of this size')
    end if

  contains

    subroutine doubt(section, key, value, range, unit, whose)
      character(*), intent(in) :: section, key, unit, whose
      real(rp), intent(in) :: value, range(2)
      character(:), allocatable :: text
      text = magnitude_doubt(value, range(1), range(2), unit, whose, index(unit, '/') == 0)
      if (text /= '') call c%complain(notices, section, key, text)
    end subroutine doubt
  end subroutine notice_magnitudes

  !> Checks the size that [Wing] gives, if the `wing` of the file is no larger than that of an insect. It adds a remark if no
  !> insect has this size, and a mistake if no wing can have it.
  subroutine check_size(c, given, wing, errors, notices)
    type(config_t), intent(in) :: c
    real(rp), intent(in) :: given(2) !< length and mean chord [m], 0: not given
    type(wing_t), intent(in) :: wing
    type(message_list_t), intent(inout) :: errors, notices
    if (maxval(abs(wing%points)) > LONGEST) return
    call check_one('length', given(1), [SHORTEST, LONGEST])
    call check_one('mean_chord', given(2), [SHORTEST, LONGEST]/4)

  contains

    !> Adds an error if a length is impossible for an insect wing, or a notice if it is only unlikely.
    subroutine check_one(key, size_given, range)
      character(*), intent(in) :: key
      real(rp), intent(in) :: size_given, range(2)
      character(:), allocatable :: text
      if (.not. size_given > 0) return
      text = magnitude_doubt(size_given, range(1), range(2), 'm', 'wings of insects', .true.)
      if (text == '') return
      if (size_given > IMPOSSIBLE*range(2)) then
        call c%complain(errors, 'Wing', key, text)
      else
        call c%complain(notices, 'Wing', key, text)
      end if
    end subroutine check_one
  end subroutine check_size

  !> Returns a question about the unit of the points, to put before a message, if the wing is too large for an insect; otherwise ''.
  function size_hint(wing) result(hint)
    type(wing_t), intent(in) :: wing
    character(:), allocatable :: hint
    real(rp) :: extent
    hint = ''
    extent = maxval(maxval(wing%points, 2) - minval(wing%points, 2))
    if (extent > IMPOSSIBLE*LONGEST) hint = 'the wing is '//number_text(rounded(extent, 3))// &
                                            ' m long: are its points in metres? If they are, '
  end function size_hint
end module common_wing_doubts
