! SPDX-License-Identifier: GPL-3.0-or-later
!> The words of a verdict over a grid of probabilities: a cause is given as found only if names of this probability are right in
!> most cases, a set always leaves in what is not in the catalogue, and what is said adds up.
program test_diagnose_verdicts
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_settings, only: diagnose_settings_t
  use diagnose_summary, only: verdict_sentence, verdict_statement
  use inference_decision, only: is_sure_name, stated_probability, stated_rest, withdraw_name, ALIAS, AT_BOUND, LEAST_STATED, &
                                NO_POWER, VERDICT_ADEQUATE, VERDICT_NAMED, VERDICT_SET
  use inference_engine, only: diagnosis_t
  use inference_probability, only: calibrated_probability, provenance_of, MAP_OF_BENDING, MAP_OF_VIBRATION
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: OUTSIDE = 'something that is not in the catalogue ('
  type(testkit_t) :: t
  type(diagnose_settings_t) :: s
  type(diagnosis_t) :: d
  integer :: map

  call t%start(parallel=.false.)
  call make()
  do map = MAP_OF_BENDING, MAP_OF_VIBRATION
    d%decision%probability_map = map
    call test_names()
    call test_sets()
  end do
  d%decision%probability_map = MAP_OF_BENDING
  call test_words()
  call test_maps()
  call t%finish()

contains

  !> A catalogue of two entries; the first is the cause.
  subroutine make()
    integer :: e
    allocate (s%catalogue%effects(2), d%model%design%candidates(2))
    do e = 1, 2
      associate (effect => s%catalogue%effects(e))
        effect%name = 'cause_'//number_text(e)
        effect%title = 'cause '//number_text(e)
        effect%sentence = 'Cause '//number_text(e)//' is there'
        allocate (effect%variants(1))
        effect%variants(1)%label = ''
      end associate
      d%model%design%candidates(e)%effect = e
      d%model%design%candidates(e)%variant = 1
    end do
    d%decision%causes = [1]
    d%decision%set = [1]
    d%decision%wider = [integer ::]
  end subroutine make

  !> Probabilities by the odds from 0.5 to nearly 1: what may be a name is right as often as names must be.
  subroutine test_names()
    real(rp) :: p
    integer :: i
    logical :: holds, is_told
    holds = .true.
    is_told = .true.
    d%decision%verdict = VERDICT_NAMED
    do i = 1, 300
      p = 1 - 0.5_rp*10**(-0.03_rp*(i - 1))
      if (is_sure_name(map, p)) holds = holds .and. p >= 0.9_rp .and. calibrated_probability(map, VERDICT_NAMED, p) >= LEAST_STATED
      d%decision%probability = p
      d%decision%posterior = [p, 1 - p]
      if (is_sure_name(map, p)) is_told = is_told .and. told_percent() >= nint(100*LEAST_STATED)
    end do
    call t%check('a name is as sure as the decision asks, by the odds and in blind cases', holds)
    call t%check('and no name is told with less', is_told)
    call t%check('which names of odds of 0.89 are not',.not. is_sure_name(map, 0.89_rp))
    call t%check('and those of nearly 1 are', is_sure_name(map, 0.999999_rp))
  end subroutine test_names

  !> Sets of one and two causes with every share of the rest.
  subroutine test_sets()
    character(:), allocatable :: text
    real(rp) :: p, unknown, joint
    integer :: i, j, k, n
    logical :: leaves_unknown, is_conditional, adds_up, is_less, is_bounded
    real(rp) :: rest(4)
    leaves_unknown = .true.
    is_conditional = .true.
    adds_up = .true.
    is_less = .true.
    is_bounded = .true.
    do n = 1, 2
      d%decision%set = [(i, i=1, n)]
      d%decision%wider = [integer ::]
      do i = 0, 50
        do j = 0, 10
          do k = 0, 10 - j
            p = i/50.0_rp
            unknown = (1 - p)*j/10
            joint = (1 - p)*k/10
            call make_set(p, unknown, joint)
            text = verdict_sentence(s, d)
            leaves_unknown = leaves_unknown .and. index(text, OUTSIDE) > 0 .and. index(text, '(0 %)') == 0 .and. &
                             index(text, '100 %') == 0
            is_conditional = is_conditional .and. index(verdict_statement(s, d), '. if it is cause 1: ') > 0 .and. &
                             (index(text, 'consistent with') == 1 .or. index(text, 'these data cannot tell apart') == 1)
            rest = stated_rest(d%decision)
            adds_up = adds_up .and. (abs(sum(rest) + stated_probability(d%decision) - 1) < 1.0e-12_rp .or. .not. p < 1) .and. &
                      minval(rest) >= 0
            is_bounded = is_bounded .and. rest(4) <= d%decision%posterior_none
            call withdraw_name(d%decision, 'probability')
            is_less = is_less .and. stated_probability(d%decision) <= calibrated_probability(map, VERDICT_NAMED, p)
          end do
        end do
      end do
    end do
    call t%check('a set leaves in what is not in the catalogue, with its probability', leaves_unknown)
    call t%check('and says of its causes what they would be', is_conditional)
    call t%check('its probability and that of all else add up to 1', adds_up)
    call t%check('and no cause at all is not more probable than by the odds', is_bounded)
    call t%check('what is not sure enough for a name has no larger probability than such a name', is_less)
  end subroutine test_sets

  !> Makes the verdict a set with these odds; what is left is that of no cause.
  subroutine make_set(p, unknown, joint)
    real(rp), intent(in) :: p, unknown, joint
    d%decision%posterior = [p, 0.0_rp]
    d%decision%posterior_unknown = unknown
    d%decision%posterior_joint = joint
    d%decision%posterior_none = max(0.0_rp, 1 - p - unknown - joint)
    d%decision%has_further = .false.
    call withdraw_name(d%decision, merge(NO_POWER, 'alias         ', size(d%decision%set) == 1))
  end subroutine make_set

  !> Each kind of data has its own map, and says which. In bending tests too few names of odds of 0.95 were right.
  subroutine test_maps()
    real(rp) :: stated(2)
    integer :: k
    d%decision%verdict = VERDICT_ADEQUATE
    d%decision%probability = 0.75_rp
    do k = 1, 2
      d%decision%probability_map = k
      stated(k) = stated_probability(d%decision)
      call t%check_close('the probability of a verdict is by the map of its data', stated(k), &
                         calibrated_probability(k, VERDICT_ADEQUATE, 0.75_rp), 0.0_rp, 0.0_rp)
    end do
    call t%check('a name of odds of 0.95 is sure enough in one study and not in the other', &
                 is_sure_name(MAP_OF_VIBRATION, 0.95_rp) .and. .not. is_sure_name(MAP_OF_BENDING, 0.95_rp))
    call t%check('the two maps differ and name their studies', abs(stated(1) - stated(2)) > 0.01_rp .and. &
                 provenance_of(MAP_OF_BENDING) /= provenance_of(MAP_OF_VIBRATION))
  end subroutine test_maps

  !> Sentences that are written here.
  subroutine test_words()
    d%decision%set = [1]
    d%decision%wider = [integer ::]
    call make_set(0.5_rp, 0.2_rp, 0.3_rp)
    call t%check('one cause: '//verdict_sentence(s, d), verdict_sentence(s, d) == &
                 'consistent with cause 1; other causes are not excluded: something that is not in the catalogue (18 %), '// &
                 'several causes at once (27 %) (probability 55 %)')
    d%decision%wider = [2]
    call t%check('what it may be a part of: '//verdict_sentence(s, d), index(verdict_sentence(s, d), &
                 '%); cause 1 may be a part of a wider change, which explains the data as well: cause 2') > 0)
    d%decision%wider = [integer ::]
    call withdraw_name(d%decision, AT_BOUND)
    call t%check('and why it is no name', index(verdict_sentence(s, d), 'not excluded, because the fitted value reached its '// &
                                                'bound: something') > 0)
    d%decision%set = [1, 2]
    d%decision%wider = [integer ::]
    call make_set(1.0_rp, 0.0_rp, 0.0_rp)
    call withdraw_name(d%decision, ALIAS)
    call t%check('two causes: '//verdict_sentence(s, d), verdict_sentence(s, d) == &
                 'these data cannot tell apart: cause 1; cause 2; nor from something that is not in the catalogue (below 1 %) '// &
                 '(probability 98 %)')
    call t%check('verdicts of sets are sets', d%decision%verdict == VERDICT_SET)
  end subroutine test_words

  !> The probability in the sentence, in percent; 99 for "over 99".
  integer function told_percent() result(percent)
    character(:), allocatable :: text
    integer :: at
    text = verdict_sentence(s, d)
    at = index(text, '(probability ')
    text = text(at + len('(probability '):)
    if (text(:5) == 'over ') text = text(6:)
    read (text(:index(text, ' %') - 1), *) percent
  end function told_percent
end program test_diagnose_verdicts
