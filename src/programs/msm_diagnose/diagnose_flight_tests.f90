! SPDX-License-Identifier: GPL-3.0-or-later
!> Says on which data causes of the structure were tested if flights of wings that bend and other data of the wing share them.
module diagnose_flight_tests
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t, word_of
  use diagnose_settings, only: diagnose_settings_t
  use base_text, only: number_text
  use diagnosis_flight_changes, only: FLOW_STRUCTURE, N_STRUCTURE
  use diagnosis_flight_comparison, only: approximation_of
  use diagnosis_flight_data, only: change_t
  use diagnosis_flight_response, only: flight_response_t
  use diagnosis_flight_structure, only: acts_in_flight, is_flown_first
  use diagnosis_wing_parameters, only: wing_parameter_t, KIND_BALANCE, KIND_FLIGHT, KIND_INSTRUMENT, KIND_SHAKE, KIND_ZERO
  use inference_decision, only: VERDICT_UNKNOWN
  use inference_engine, only: diagnosis_t
  use io_json, only: json_t
  implicit none
  private
  public :: print_flight_tests, put_flight_test

  integer, parameter :: NOT_SHARED = 0, FLOWN_FIRST = 1, FLOWN_IN_ROUND = 2, NOT_FLOWN = 3
  type(named_kind_t), parameter :: TESTS(3) = [named_kind_t('first', FLOWN_FIRST), named_kind_t('round', FLOWN_IN_ROUND), &
                                               named_kind_t('no', NOT_FLOWN)]
  !> Flights do not depend on these errors of other data; kinematics, flow and balance are none of the wing.
  integer, parameter :: OF_OTHERS(5) = [KIND_INSTRUMENT, KIND_ZERO, KIND_SHAKE, KIND_FLIGHT, KIND_BALANCE]

contains

  !> Prints on `unit`, for each cause of the verdict that the wing itself has, whether flights take part in its fit, or why not. If
  !> no cause explains the data, it says how flights can show causes of the structure.
  subroutine print_flight_tests(unit, s, d)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    character(:), allocatable :: reason
    integer :: i
    if (.not. is_shared(s)) return
    if (d%decision%verdict == VERDICT_UNKNOWN .and. s%flights%effects /= '') write (unit, '(a)') &
      'flights   do not show causes of the structure that [Flight] effects leaves out: name them there, or leave effects empty'
    do i = 1, size(d%decision%causes)
      associate (name => s%catalogue%effects(d%model%design%candidates(d%decision%causes(i))%effect)%name)
        select case (test_of(s, d, i, reason))
        case (FLOWN_FIRST)
          write (unit, '(a)') 'flights   take part in the fit of '//name//': they were flown for it before the decision'
        case (FLOWN_IN_ROUND)
          write (unit, '(a)') 'flights   take part in the fit of '//name//': they were flown with its value, which the other '// &
            'data had found'
        case (NOT_FLOWN)
          write (unit, '(a)') 'flights   take no part in the fit of '//name//': '//reason
        end select
      end associate
    end do
  end subroutine print_flight_tests

  !> Adds to the open object, that of cause i of the verdict, whether flights take part in its fit, if the wing itself has it.
  subroutine put_flight_test(json, s, d, i)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: i
    character(:), allocatable :: reason
    integer :: test
    if (.not. is_shared(s)) return
    test = test_of(s, d, i, reason)
    if (test == NOT_SHARED) return
    call json%put('flights', word_of(TESTS, test))
    if (test == NOT_FLOWN) call json%put('flights_reason', reason)
  end subroutine put_flight_test

  !> Tells whether there are flights of wings that bend, and other data of the wing.
  pure logical function is_shared(s)
    type(diagnose_settings_t), intent(in) :: s
    is_shared = s%flights%is_ready .and. s%flights%bend()
    if (is_shared) is_shared = .not. all(s%flights%cases%facts%is_alone)
  end function is_shared

  !> Returns whether and when flights were flown for cause i of the verdict. If they were not, `reason` says why.
  integer function test_of(s, d, i, reason) result(test)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: i
    character(:), allocatable, intent(out) :: reason
    type(change_t) :: change
    type(flight_response_t) :: response
    integer :: c, k
    test = NOT_SHARED
    reason = ''
    associate (columns => d%model%design%candidates(d%decision%causes(i))%columns)
      do c = 1, size(columns)
        associate (p => s%catalogue%parameters(columns(c)))
          if (any(p%kind == OF_OTHERS)) cycle
          if (test == NOT_SHARED) test = NOT_FLOWN
          do k = 1, size(s%flights%cases)
            change = s%flights%cases(k)%change_by(p)
            if (change%number == 0) cycle
            response = s%flights%cases(k)%response
            if (d%extended%is_found) response = approximation_of(d%extended, s%flights%cases(k))
            reason = trim(response%reason(change%number))
            if (.not. response%is_known(change%number)) cycle
            test = merge(FLOWN_FIRST, FLOWN_IN_ROUND, change%number <= FLOW_STRUCTURE + s%flights%cases(k)%facts%n_first)
          end do
          if (test == NOT_FLOWN .and. reason == '') reason = &
            why_not_flown(s, p, s%catalogue%effects(d%model%design%candidates(d%decision%causes(i))%effect)%name)
        end associate
      end do
    end associate
  end function test_of

  !> Returns why no flight changes parameter p of the wing, which belongs to `cause`.
  function why_not_flown(s, p, cause) result(reason)
    type(diagnose_settings_t), intent(in) :: s
    type(wing_parameter_t), intent(in) :: p
    character(*), intent(in) :: cause
    character(:), allocatable :: reason
    real(rp) :: own
    integer :: k, n
    reason = 'a flight has no such parameter'
    if (.not. acts_in_flight(p)) return
    do k = 1, size(s%flights%cases)
      if (.not. s%flights%cases(k)%facts%is_flexible) cycle
      call s%runner%judge_structure(k, p, own, reason)
      if (reason == '') exit
    end do
    if (reason /= '') return
    reason = 'no round was flown with it, as its gain is not clear'
    if (s%choices%flight%rounds == 0) reason = '[Flight] rounds = 0 allows no flight with it'
    n = 0
    if (allocated(s%flights%cases(1)%facts%structure)) n = size(s%flights%cases(1)%facts%structure)
    if (n == N_STRUCTURE) then
      reason = 'flights already change '//number_text(N_STRUCTURE)//' parameters of the structure, the most that are possible; '// &
               'name fewer in [Flight] effects'
    else if (is_flown_first(cause, cause)) then
      reason = reason//'; name it in [Flight] effects to fly it first'
    end if
  end function why_not_flown
end module diagnose_flight_tests
