! SPDX-License-Identifier: GPL-3.0-or-later
!> The registry of causes: each has a name of its own, a title, a sentence and what it needs, and words for each of its parameters,
!> whose bounds hold the value at which nothing happens.
program test_causes
  use base_cause, only: cause_parameter_t, cause_t, LAST_PLACE
  use base_parameter, only: parameter_t
  use base_wording, only: wording_t
  use diagnosis_causes, only: find_words, list_causes
  use diagnosis_flight_catalogue, only: flight_causes
  use diagnosis_flight_changes, only: cause_of_change, change_parameter, change_scales_t, FLOW_FREQUENCY, FLOW_WIND, N_CHANGES
  use measurement_instrument, only: instrument_t
  use measurement_instrument_causes, only: CREEP_TIME, N_INSTRUMENT
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N_CAUSES = 17 + 4 + 3 + 12 + 10 + 7 !< structure, masses, damping, instrument, flight, balance
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
      p = change_parameter(i, scales)
      call t%check(p%name//' is 0 for the case', abs(p%null) <= 0 .and. index(flight_causes(), cause_of_change(i)) > 0)
    end do
    call t%check('three are wind, the last is the frequency', cause_of_change(FLOW_WIND + 3) == 'wind' .and. &
                 cause_of_change(FLOW_FREQUENCY) == 'beat_frequency')
  end subroutine check_changes
end program test_causes
