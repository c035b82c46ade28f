! SPDX-License-Identifier: GPL-3.0-or-later
!> The registry of causes: each has a name of its own, a title, a sentence and what it needs, and words for each of its parameters,
!> whose bounds hold the value at which nothing happens.
program test_causes
  use base_cause, only: append, cause_parameter_t, cause_t, find_parameter, LAST_PLACE
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use base_wording, only: wording_t
  use diagnosis_causes, only: find_words, list_causes
  use diagnosis_flight_catalogue, only: flight_causes
  use diagnosis_flight_changes, only: cause_of_change, change_parameter, change_scales_t, list_change_causes, FLOW_FREQUENCY, &
                                      FLOW_LEAD, FLOW_STROKE, FLOW_WIND, is_of_structure, N_CHANGES
  use measurement_balance_causes, only: balance_scales_t, list_balance_causes
  use measurement_instrument, only: instrument_t
  use measurement_instrument_causes, only: instrument_scales_t, list_instrument_causes, CREEP_TIME, N_INSTRUMENT
  use solid_effect, only: N_WING_NEEDS
  use solid_mass_effects, only: list_mass_causes
  use solid_structure_causes, only: list_structure_causes
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N_CAUSES = 19 + 4 + 4 + 1 + 12 + 17 + 7 !< structure, masses, damping, records, instrument, flight, balance
  character(*), parameter :: LETTERS = 'abcdefghijklmnopqrstuvwxyzE_'
  type(testkit_t) :: t
  type(cause_t), allocatable :: causes(:)
  integer :: i

  call t%start(parallel=.false.)
  causes = list_causes()
  call t%check('the list has all causes', size(causes) == N_CAUSES)
  do i = 1, size(causes)
    call check_texts(causes(i), causes(:i - 1))
    call check_parameters(causes(i), causes(:i - 1))
  end do
  call check_instrument()
  call check_changes()
  call check_needs()
  call t%finish()

contains

  !> A name and a place in the catalogue that no cause before it has, and all texts.
  subroutine check_texts(cause, before)
    type(cause_t), intent(in) :: cause, before(:)
    integer :: k
    logical :: is_new
    is_new = cause%name /= '' .and. verify(cause%name, LETTERS) == 0
    do k = 1, size(before)
      is_new = is_new .and. before(k)%name /= cause%name .and. before(k)%title /= cause%title .and. &
               (before(k)%place /= cause%place .or. cause%place == LAST_PLACE)
    end do
    call t%check(cause%name//' has name, title and place of its own', is_new)
    call t%check('  a title', len(cause%title) > 0 .and. scan(cause%title(len(cause%title):), '.:') == 0)
    call t%check('  a sentence', index(cause%sentence, '.', back=.true.) == len(cause%sentence) .and. len(cause%sentence) > 1)
    call t%check('  what it needs', len(cause%data) > 0)
  end subroutine check_texts

  !> Parameters with names that no other cause has, unless it is the same parameter, with words, and with a null between the bounds.
  subroutine check_parameters(cause, before)
    type(cause_t), intent(in) :: cause, before(:)
    logical :: is_own
    integer :: k, i, j
    call t%check('  parameters', size(cause%parameters) > 0 .and. any(cause%parameters%is_tried))
    do k = 1, size(cause%parameters)
      associate (one => cause%parameters(k))
        is_own = .true.
        do i = 1, size(before)
          do j = 1, size(before(i)%parameters)
            if (before(i)%parameters(j)%value%name == one%value%name) is_own = is_own .and. is_same(one, before(i)%parameters(j))
          end do
        end do
        do j = 1, k - 1
          is_own = is_own .and. cause%parameters(j)%value%name /= one%value%name
        end do
        call t%check('  '//one%value%name//' is a name of its own', is_own)
        call t%check('  with a unit and bounds', one%value%unit /= '' .and. one%value%lower < one%value%upper)
        if (one%value%is_effect) call t%check('  around its null, and a prior', one%value%lower <= one%value%null .and. &
                                              one%value%null <= one%value%upper .and. one%value%prior_sd > 0)
        if (one%is_tried) call check_words(one)
      end associate
    end do
  end subroutine check_parameters

  !> Tells whether two causes have the same parameter.
  logical function is_same(a, b)
    type(cause_parameter_t), intent(in) :: a, b
    is_same = a%number == b%number .and. a%number > 0 .and. .not. a%value%is_effect
  end function is_same

  !> Words for more and for less, in which the place is filled in.
  subroutine check_words(one)
    type(cause_parameter_t), intent(in) :: one
    type(wording_t) :: words
    character(:), allocatable :: name
    name = one%value%name
    if (name(len(name):) == ':') name = name//'part'
    call find_words(name, 'here', one%value%upper, words)
    call t%check('  and words', words%is_known)
    if (.not. words%is_known) return
    call t%check('  for more and for less', words%up /= '' .and. words%down /= '' .and. &
                 index(words%up//words%down, '@') == 0 .and. &
                 words%up//words%more /= words%down//words%less)
  end subroutine check_words

  !> Every parameter of the instrument belongs to a cause, is found by its name, and starts where it does nothing.
  subroutine check_instrument()
    type(instrument_t) :: instrument
    type(parameter_t) :: p
    integer :: i
    do i = 1, N_INSTRUMENT
      p = instrument%describe(i)
      call t%check('parameter '//p%name//' is found', instrument%find(p%name) == i)
      if (i /= CREEP_TIME) call t%check('  and starts at its null', abs(instrument%get(i) - p%null) <= 0 .and. p%is_effect)
    end do
    call t%check('all do nothing then', instrument%is_null() .and. instrument%find('no such error') == 0)
  end subroutine check_instrument

  !> Every change of a flight belongs to a cause and is 0 for the case as it is; a section feels no wind along x.
  subroutine check_changes()
    type(change_scales_t) :: scales
    type(parameter_t) :: p
    integer :: i
    do i = 1, N_CHANGES
      if (is_of_structure(i)) cycle ! causes of the wing
      p = change_parameter(i, scales)
      call t%check(p%name//' is 0 for the case', abs(p%null) <= 0 .and. index(flight_causes(), cause_of_change(i)) > 0)
    end do
    scales%prior_sd(FLOW_LEAD) = 4.0e-3_rp
    p = change_parameter(FLOW_LEAD, scales)
    call t%check('an error of the kinematics that is stated is the sd of the prior', abs(p%prior_sd/4.0e-3_rp - 1) < 1.0e-14_rp)
    p = change_parameter(FLOW_STROKE, scales)
    call t%check('the others keep theirs', abs(p%prior_sd/0.05_rp - 1) < 1.0e-14_rp)
    scales%is_section = .true.
    call t%check('a section does not try wind along x', has_wind_along_x(list_change_causes(change_scales_t())) .and. &
                 .not. has_wind_along_x(list_change_causes(scales)))
    call t%check('three are wind, the last is the frequency', cause_of_change(FLOW_WIND + 3) == 'wind' .and. &
                 cause_of_change(FLOW_FREQUENCY) == 'beat_frequency')
  end subroutine check_changes

  !> Tells whether a diagnosis tries wind along x, beside wind along y and z.
  logical function has_wind_along_x(list) result(has)
    type(cause_t), intent(in) :: list(:)
    integer :: cause, k
    call find_parameter(list, FLOW_WIND + 1, cause, k)
    associate (wind => list(cause)%parameters)
      call t%check('wind is along x, y and z', all(wind%number == FLOW_WIND + [1, 2, 3]) .and. all(wind(2:)%is_tried))
      has = wind(1)%is_tried
    end associate
  end function has_wind_along_x

  !> What one part of the catalogue needs is no need of another part: each judges the needs that it knows.
  subroutine check_needs()
    type(instrument_scales_t) :: of_instrument
    type(change_scales_t) :: of_changes
    type(balance_scales_t) :: of_balance
    type(cause_t), allocatable :: structure(:), masses(:)
    integer, allocatable :: wing(:), bending(:), changes(:), balance(:)
    integer :: i
    structure = list_structure_causes()
    masses = list_mass_causes(1.0_rp)
    call append(structure, masses)
    wing = needs_of(structure)
    bending = needs_of(list_instrument_causes(of_instrument))
    changes = needs_of(list_change_causes(of_changes))
    balance = needs_of(list_balance_causes(of_balance))
    call t%check('each has needs', all([size(wing), size(bending), size(changes), size(balance)] > 0))
    call t%check('an error of a bending test needs what a wing needs, by the same number, or what no wing needs', &
                 all([(any(wing == bending(i)) .or. bending(i) > N_WING_NEEDS, i=1, size(bending))]) .and. &
                 all(wing <= N_WING_NEEDS))
    call t%check('a change of the flight has needs of its own', &
                 .not. any([(any(changes == wing(i)), i=1, size(wing)), (any(changes == bending(i)), i=1, size(bending)), &
                            (any(changes == balance(i)), i=1, size(balance))]))
    call t%check('and so has an error of the balance', &
                 .not. any([(any(balance == wing(i)), i=1, size(wing)), (any(balance == bending(i)), i=1, size(bending))]))
  end subroutine check_needs

  !> Returns the needs of all causes in a list.
  pure function needs_of(list) result(needs)
    type(cause_t), intent(in) :: list(:)
    integer, allocatable :: needs(:)
    integer :: i
    allocate (needs(0))
    do i = 1, size(list)
      needs = [needs, list(i)%needs]
    end do
  end function needs_of
end program test_causes
