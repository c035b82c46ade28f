! SPDX-License-Identifier: GPL-3.0-or-later
!> What is said about ends of a polish: equal ones, higher minima, and others that fit as well; about intervals that are
!> from some of the loads only; and about an outcome: what does not fit, and what the data do not determine.
program test_start_agreement
  use base_kinds, only: i8, rp
  use cmaes_box, only: make_box
  use measurement_experiment, only: experiment_t
  use testkit, only: testkit_t
  use train_output, only: free_note, outcome_lines
  use train_settings, only: train_settings_t
  use training_agreement, only: agreement_lines, AGREEMENT_LENGTH
  use training_history, only: train_history_t
  use training_objective, only: candidate_costs_t
  use training_intervals, only: interval_sentence
  use training_outcome, only: trained_t
  use training_space, only: search_space_t
  implicit none
  character(7), parameter :: NAMES(2) = [character(7) :: 'E', 'joint:a']
  real(rp), parameter :: BEST(2) = [23.0_rp, -9.0_rp], SD(2) = [0.1_rp, 2.0_rp], CHI2 = 100.0_rp
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_alone()
  call test_equal()
  call test_others()
  call test_left_out()
  call test_outcome()
  call test_unfinished()
  call test_stages()
  call t%finish()

contains

  !> A candidate of the first stage that costs less than all of the second is the best point of the second one's space, in
  !> which the first unknown is fixed; candidates that cost more, or are not feasible, are not.
  subroutine test_stages()
    type(train_history_t) :: history
    type(search_space_t) :: space
    type(candidate_costs_t) :: costs
    real(rp) :: values(2, 3), cost, u(1)
    logical :: has_best
    space%box = make_box([1.0_rp, 0.0_rp], [100.0_rp, 10.0_rp], [.true., .false.])
    space%is_log = [.true., .false.]
    space%free = [2]
    space%fixed = [0.5_rp, 0.0_rp]
    call history%init(2)
    values = reshape([10.0_rp, 7.0_rp, 10.0_rp, 3.0_rp, 10.0_rp, 9.0_rp], [2, 3])
    costs%f = [2.0_rp, 1.0_rp, 0.1_rp]
    costs%violation = [0.0_rp, 0.0_rp, 0.5_rp]
    costs%has_failed = [.false., .false., .false.]
    has_best = .false.
    call history%improve(space, has_best, cost, u)
    call t%check('without candidates there is no best one',.not. has_best)
    call history%add_candidates([1_i8, 0_i8, 1_i8, 3_i8, 3_i8], costs, values)
    has_best = .true.
    cost = 0.5_rp
    u = 0.9_rp
    call history%improve(space, has_best, cost, u)
    call t%check_close('what costs more does not replace a point', u(1), 0.9_rp, atol=0.0_rp)
    cost = 1.5_rp
    call history%improve(space, has_best, cost, u)
    call t%check_close('the better candidate does', u(1), 0.3_rp, atol=1.0e-15_rp)
    call t%check_close('with its cost', cost, 1.0_rp, atol=0.0_rp)
    has_best = .false.
    u = 0.9_rp
    call history%improve(space, has_best, cost, u)
    call t%check('also where the second stage has no feasible one', has_best .and. abs(u(1) - 0.3_rp) < 1.0e-15_rp)
  end subroutine test_stages

  !> The first interval is from all loads, the second from the middle one, and its upper end is a jump.
  subroutine test_left_out()
    type(experiment_t) :: experiment
    type(search_space_t) :: space
    type(trained_t) :: trained
    character(:), allocatable :: first, second
    integer :: l
    allocate (experiment%measurement%loads(3), trained%intervals(2), trained%is_left_out(3, 2))
    do l = 1, 3
      experiment%measurement%loads(l)%name = 'load_'//achar(iachar('0') + l)
    end do
    allocate (space%names(2), space%units(2), space%is_log(2))
    space%names = NAMES
    space%units = [character(16) :: 'Pa', 'N m/rad']
    space%is_log = .true.
    trained%is_left_out = reshape([.false., .false., .false., .true., .false., .true.], [3, 2])
    trained%intervals%best = BEST
    trained%intervals%lower = BEST - SD
    trained%intervals%upper = BEST + SD
    trained%intervals%has_lower = .true.
    trained%intervals%has_upper = .true.
    trained%intervals%is_complete = .true.
    trained%intervals(2)%is_jump(2) = .true.
    first = interval_sentence(experiment, space, trained, 1)
    second = interval_sentence(experiment, space, trained, 2)
    call t%check('an interval from all loads says no more: '//first, index(first, 'load') + index(first, 'jump') == 0)
    call t%check('loads that are left out are named: '//second, index(second, '; found without load_1 load_3, where') > 0)
    call t%check('and so is an end at a jump', index(second, 'at the upper end shapes jump') > 0 .and. &
                 index(second, 'at the lower end') == 0)
  end subroutine test_left_out

  !> E has an interval, the joint only a lower end, or nothing at all; its value, 1.234E-4, must not be read as a result.
  subroutine test_outcome()
    real(rp), parameter :: JOINT = log(1.234e-4_rp)
    type(train_settings_t) :: settings
    type(search_space_t) :: space
    type(trained_t) :: trained
    character(:), allocatable :: text
    allocate (settings%experiment%comparisons(1), settings%experiment%measurement%loads(1), trained%intervals(2), &
              trained%is_left_out(1, 2))
    settings%experiment%comparisons%n = 50
    allocate (space%names(2), space%units(2), space%is_log(2))
    space%names = NAMES
    space%units = [character(16) :: 'Pa', 'N m/rad']
    space%is_log = .true.
    trained%values = exp([BEST(1), JOINT])
    trained%chi2 = CHI2
    trained%is_polished = .true.
    trained%posterior%sd = SD
    trained%is_left_out = .false.
    trained%has_intervals = .true.
    trained%intervals%best = [BEST(1), JOINT]
    trained%intervals%lower = [BEST(1) - SD(1), log(3.0e-6_rp)]
    trained%intervals%upper = [BEST(1) + SD(1), log(1.0e-2_rp)]
    trained%intervals%has_lower = .true.
    trained%intervals(1)%has_upper = .true.
    trained%intervals%is_complete = .true.
    text = outcome_lines(settings, space, trained, '')
    call t%check('what does not fit is said', index(text, 'warning: the fit does not agree with the declared errors') > 0)
    trained%fits = .true.
    text = outcome_lines(settings, space, trained, '')
    call t%check('and nothing of what fits', index(text, 'warning') == 0 .and. index(text, 'of 50 residuals') > 0)
    call t%check('a joint with one end has no value: '//text, index(text, '1.23') == 0 .and. &
                 index(text, 'joint:a: these data give a lower limit only: > 3.000E-06 N m/rad') > 0)
    text = free_note(space, trained)
    call t%check('the fragment names it as well: '//text, &
                 index(text, 'Not determined; other values fit as well as the values below: joint:a.') > 0)
    trained%intervals(2)%has_lower = .false.
    text = outcome_lines(settings, space, trained, '')
    call t%check('nor has one with none', index(text, '1.23') == 0 .and. &
                 index(text, 'joint:a: not determined by these data; every value from') > 0)
    trained%intervals(2)%has_lower = .true.
    trained%intervals(2)%has_upper = .true.
    text = outcome_lines(settings, space, trained, '')
    call t%check('one that is determined has a value', index(text, 'joint:a: 1.234') > 0 .and. &
                 free_note(space, trained) == '')
    ! Without intervals: the data take nothing of the decade that the joint's prior allows, and all of that of E.
    trained%has_intervals = .false.
    trained%prior_sd = [2.3_rp, 2.3_rp]
    text = outcome_lines(settings, space, trained, '')
    call t%check('nor has a joint whose predicted sd is that of its prior: '//text, index(text, '1.23') == 0 .and. &
                 index(text, 'joint:a: not determined by these data') > 0 .and. index(text, 'E: 9.74') > 0)
    call t%check('and the fragment names it', index(free_note(space, trained), 'joint:a.') > 0)
    trained%is_polished = .false.
    text = outcome_lines(settings, space, trained, '')
    call t%check('what was not asked is said', index(text, ', without an uncertainty') > 0 .and. free_note(space, trained) == '')
  end subroutine test_outcome

  !> Least squares that failed, and values at a bound of their box, 1.0E-6 to 1.0E-2: neither is a result.
  subroutine test_unfinished()
    real(rp), parameter :: JOINT = 1.0e-6_rp
    type(train_settings_t) :: settings
    type(search_space_t) :: space
    type(trained_t) :: trained
    character(:), allocatable :: text
    allocate (settings%experiment%comparisons(1))
    space%names = NAMES
    space%units = [character(16) :: 'Pa', 'N m/rad']
    space%is_log = [.true., .true.]
    trained%values = [8.0e9_rp, JOINT]
    trained%fits = .true.
    trained%reason = 'the model cannot be computed at the starting values'
    text = outcome_lines(settings, space, trained, '')
    call t%check('least squares that failed are told, and why: '//text, &
                 index(text, 'warning: least squares failed (the model cannot be computed at the starting values)') > 0)
    call t%check('what they were asked for is not said to be unasked', index(text, ', without an uncertainty') == 0 .and. &
                 index(text, 'E: not determined; the search ended at') > 0)
    call t%check('and nothing counts as determined',.not. (trained%determines(1) .or. trained%determines(2)))
    ! At a bound, with a posterior that looks as if it were known.
    trained%is_polished = .true.
    trained%posterior%sd = [1.0e-3_rp, 1.0e-3_rp]
    trained%prior_sd = [2.3_rp, 2.3_rp]
    trained%sides = [0, -1]
    text = outcome_lines(settings, space, trained, '')
    call t%check('a value at its lower bound is said to be there: '//text, &
                 index(text, 'joint:a: at the lower bound: 1.000000E-06 N m/rad;') > 0 .and. &
                 index(text, 'a smaller value may fit better') > 0)
    call t%check('and another is not', index(text, 'E: 8.000000E+09 Pa, predicted') > 0)
    call t%check('it is not determined', trained%determines(1) .and. .not. trained%determines(2) .and. &
                 index(free_note(space, trained), 'joint:a.') > 0)
    trained%is_polished = .false.
    deallocate (trained%reason)
    trained%sides = [1, 0]
    text = outcome_lines(settings, space, trained, '')
    call t%check('nor without a polish: '//text,.not. trained%determines(1) .and. trained%determines(2) .and. &
                 index(text, 'E: at the upper bound:') > 0 .and. index(text, 'a larger value may') > 0 .and. &
                 index(text, ', without an uncertainty') > 0)
  end subroutine test_unfinished

  subroutine test_alone()
    character(AGREEMENT_LENGTH), allocatable :: lines(:)
    lines = agreement_lines(NAMES, BEST, CHI2, SD, reshape([CHI2, BEST], [3, 1]))
    call t%check('about a single start nothing is said', size(lines) == 0)
  end subroutine test_alone

  !> Distances count in sd of each parameter: 0.4 and 0.45 of them are the same end.
  subroutine test_equal()
    character(AGREEMENT_LENGTH), allocatable :: lines(:)
    lines = agreement_lines(NAMES, BEST, CHI2, SD, &
                      reshape([CHI2, BEST, CHI2 + 50, 23.04_rp, -9.0_rp, CHI2, 23.0_rp, -9.9_rp], [3, 3]))
    call t%check('equal ends are counted, and nothing else is said', size(lines) == 1 .and. &
                 has(lines, 'polish    3 of 3 starts end at this point'))
  end subroutine test_equal

  !> The threshold of chi^2 is 2.7; 0.06 is 0.6 sd of the first parameter, 3 are 1.5 sd of the second.
  subroutine test_others()
    character(AGREEMENT_LENGTH), allocatable :: lines(:)
    lines = agreement_lines(NAMES, BEST, CHI2, SD, &
                      reshape([CHI2, BEST, CHI2 + 2.6_rp, 23.06_rp, -12.0_rp, CHI2 + 2.8_rp, 23.06_rp, -9.0_rp, &
                               CHI2, BEST], [3, 4]))
    call t%check('every other end has its line', size(lines) == 3)
    call t%check('one that fits as well is a warning with the parameter that differs most', &
                 has(lines, 'warning   another start ends in an equally good fit, 1.5 sd away in joint:a'))
    call t%check('one that does not is a higher minimum', &
                 has(lines, 'a higher minimum: chi^2 = 1.0280E+02 instead of 1.0000E+02; most different is E'))
    call t%check('the others agree', has(lines, '2 of 4 starts end at this point'))
  end subroutine test_others

  logical function has(lines, sentence)
    character(*), intent(in) :: lines(:), sentence
    integer :: i
    has = .false.
    do i = 1, size(lines)
      has = has .or. index(lines(i), sentence) > 0
    end do
  end function has
end program test_start_agreement
