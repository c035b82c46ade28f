! SPDX-License-Identifier: GPL-3.0-or-later
!> Reports what to measure next, over all kinds of data: in words and as a table on the terminal, as the member `next` of
!> NAME.json, and as NAME_next_measurements.csv.
module diagnose_next
  use base_decimal, only: fixed
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_text_file, only: write_text
  use diagnose_counts, only: kinds_of, DATA_BENDING, DATA_MODES, DATA_NAMES, DATA_SERIES
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_motion_proposals, only: motion_proposal_t, PROPOSE_MODES
  use diagnosis_next_measurement, only: next_measurement_t, next_option_t, NEXT_LOAD, NEXT_MOTION, NEXT_REPEAT
  use inference_engine, only: diagnosis_t
  use io_json, only: json_t
  use measurement_modes, only: MEDIUM_NAMES, MEDIUM_VACUUM
  implicit none
  private
  public :: motion_words, print_next, put_motion, put_next, write_next

  real(rp), parameter :: NOTHING = 1.0_rp !< [sd] a measurement that separates less does not help

contains

  !> Prints on `unit` the best measurement in a sentence, and a line on the best one of each kind of data. Prints nothing without a
  !> cause and rivals.
  subroutine print_next(unit, s, d, next)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(next_measurement_t), intent(in) :: next
    character(12) :: number
    integer :: kind, i
    if (size(next%options) == 0) return
    write (unit, '(a)') 'next      '//next_sentence(s, d, next)
    do kind = 1, size(DATA_NAMES)
      do i = 1, size(next%options)
        if (kind_of(s, next%options(i)) /= kind) cycle
        write (number, '(f9.1,a)') next%options(i)%after, ' sd'
        write (unit, '(a)') '          '//DATA_NAMES(kind)//number//'   '//option_words(s, next%options(i))// &
          apart_words(s, d, next, next%options(i))
        exit
      end do
    end do
    if (next%no_motion /= '') write (unit, '(a)') '          new modes and series are not ranked: '//next%no_motion
  end subroutine print_next

  !> Returns in words the measurement that separates the cause from its nearest rival best. The text is empty without a cause and
  !> rivals.
  function next_sentence(s, d, next) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(next_measurement_t), intent(in) :: next
    character(:), allocatable :: text, cause, rival
    text = ''
    if (size(next%options) == 0) return
    cause = effect_name(s, d, next%cause)
    rival = effect_name(s, d, next%rivals(1))
    if (next%options(1)%after < NOTHING) then
      text = what_was_tried(s, next)//' would distinguish '//cause//' from '//rival
    else
      text = option_words(s, next%options(1))//': after it, at least '//fixed(next%options(1)%after, 1)//' sd separate '//cause// &
             ' from every rival; at present '//fixed(next%now(1), 1)//' sd separate it from '//rival
    end if
  end function next_sentence

  !> Returns the name of the effect of a candidate.
  pure function effect_name(s, d, candidate) result(name)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: candidate
    character(:), allocatable :: name
    name = s%catalogue%effects(d%model%design%candidates(candidate)%effect)%name
  end function effect_name

  !> Names the measurements that would not help: a further point load if there are loads, a repeat of every other kind of data, and
  !> new measurements of motion if they were tried.
  function what_was_tried(s, next) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(next_measurement_t), intent(in) :: next
    character(:), allocatable :: text, others
    others = ''
    if (s%measurement%count_modes() > 0) others = others//' or natural mode'
    if (s%measurement%count_series() > 0) others = others//' or record of motion'
    if (s%measurement%count_flights() > 0) others = others//' or record of a flight'
    text = 'no additional point load'
    if (others /= '') then
      others = 'no'//others(4:)//' measured once more'
      if (size(s%measurement%loads) == 0) text = others
      if (size(s%measurement%loads) > 0) text = text//' and '//others
    end if
    if (any(next%options%what == NEXT_MOTION)) text = text//' and no new mode or record of motion'
  end function what_was_tried

  !> Returns the kind of data of a measurement.
  pure integer function kind_of(s, option) result(kind)
    type(diagnose_settings_t), intent(in) :: s
    type(next_option_t), intent(in) :: option
    integer, allocatable :: of_surfaces(:)
    select case (option%what)
    case (NEXT_LOAD)
      kind = DATA_BENDING
    case (NEXT_MOTION)
      kind = merge(DATA_MODES, DATA_SERIES, option%motion%kind == PROPOSE_MODES)
    case default
      of_surfaces = kinds_of(s)
      kind = of_surfaces(option%surface)
    end select
  end function kind_of

  !> Returns a measurement in words.
  function option_words(s, option) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(next_option_t), intent(in) :: option
    character(:), allocatable :: text
    select case (option%what)
    case (NEXT_REPEAT)
      text = 'repeat '//s%measurement%surface_name(option%surface)
    case (NEXT_LOAD)
      text = 'push '//trim(merge('up  ', 'down', option%direction(3) > 0))//' at '//place_words(option%site)//' with '// &
             fixed(1.0e3_rp*option%force, 3)//' mN'
    case default
      text = motion_words(option%motion)
    end select
  end function option_words

  !> Returns a measurement of motion in words.
  function motion_words(motion) result(text)
    type(motion_proposal_t), intent(in) :: motion
    character(:), allocatable :: text
    if (motion%kind == PROPOSE_MODES) then
      text = 'natural modes 1 to '//number_text(size(motion%frequency))
      if (size(motion%frequency) == 1) text = 'natural mode 1'
    else
      text = 'release a force of '//fixed(1.0e3_rp*motion%force, 4)//' mN at '//place_words(motion%site)
    end if
    text = text//trim(merge(' in a vacuum', ' in air     ', motion%medium == MEDIUM_VACUUM))
  end function motion_words

  !> Returns a place [m] in words.
  function place_words(site) result(text)
    real(rp), intent(in) :: site(2)
    character(:), allocatable :: text
    text = '('//fixed(1.0e3_rp*site(1), 2)//', '//fixed(1.0e3_rp*site(2), 2)//') mm'
  end function place_words

  !> Tells which members of the set the measurement would tell from the first cause; empty if none.
  function apart_words(s, d, next, option) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(next_measurement_t), intent(in) :: next
    type(next_option_t), intent(in) :: option
    character(:), allocatable :: text
    text = ''
    if (any(option%tells_apart)) text = '; tells '//effect_name(s, d, next%cause)//' from '//apart_names(s, next, option, ', ')
  end function apart_words

  !> Returns the names of these members.
  function apart_names(s, next, option, separator) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(next_measurement_t), intent(in) :: next
    type(next_option_t), intent(in) :: option
    character(*), intent(in) :: separator
    character(:), allocatable :: text
    integer :: m
    text = ''
    do m = 1, size(next%members)
      if (.not. option%tells_apart(m)) cycle
      if (text /= '') text = text//separator
      text = text//s%catalogue%effects(next%members(m))%name
    end do
  end function apart_names

  !> Adds `next` to the open object: what to measure next in words, and all measurements of any kind, repeated or new, the one that
  !> separates the causes best first.
  subroutine put_next(json, s, d, next)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    type(next_measurement_t), intent(in) :: next
    integer :: i, m
    call json%open_object('next')
    call json%put('sentence', next_sentence(s, d, next))
    call json%put('motion_not_ranked', next%no_motion)
    call json%open_list('other_members')
    do m = 1, size(next%members)
      call json%put('', s%catalogue%effects(next%members(m))%name)
    end do
    call json%close()
    call json%put('from_members_now_sd', next%member_now)
    call json%open_list('measurements')
    do i = 1, size(next%options)
      associate (one => next%options(i))
        call json%open_object('')
        call json%put('kind', trim(DATA_NAMES(kind_of(s, one))))
        select case (one%what)
        case (NEXT_REPEAT)
          call json%put('repeat', s%measurement%surface_name(one%surface))
        case (NEXT_LOAD)
          call json%put('place_m', one%site)
          call json%put('force_n', one%force)
          call json%put('direction', one%direction)
        case default
          call put_motion(json, one%motion)
        end select
        call json%put('separation_sd', one%after)
        call json%put('separation_now_sd', next%now(1))
        call json%put('from_members_sd', one%from_members)
        call json%open_list('tells_apart')
        do m = 1, size(next%members)
          if (one%tells_apart(m)) call json%put('', s%catalogue%effects(next%members(m))%name)
        end do
        call json%close()
        call json%close()
      end associate
    end do
    call json%close()
    call json%close()
  end subroutine put_next

  !> Adds what describes a measurement of motion to the open object.
  subroutine put_motion(json, motion)
    type(json_t), intent(inout) :: json
    type(motion_proposal_t), intent(in) :: motion
    call json%put('medium', trim(MEDIUM_NAMES(motion%medium)))
    if (motion%kind == PROPOSE_MODES) then
      call json%put('frequencies_hz', motion%frequency)
    else
      call json%put('place_m', motion%site)
      call json%put('released_n', motion%force)
      call json%put('rate_hz', motion%rate)
      call json%put('samples', motion%samples)
    end if
  end subroutine put_motion

  !> Writes NAME_next_measurements.csv, a table of the next measurements.
  subroutine write_next(s, next, failure)
    type(diagnose_settings_t), intent(in) :: s
    type(next_measurement_t), intent(in) :: next
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: text
    character(160) :: place, lengths
    character, parameter :: NL = new_line('a')
    integer :: i
    text = 'rank,kind,measurement,x [m],y [m],force [N],separation now [sd],separation after it [sd],tells apart'//NL
    do i = 1, size(next%options)
      associate (one => next%options(i))
        place = ',,,' ! modes have no place and no force
        if (one%what == NEXT_REPEAT .and. one%surface <= size(s%measurement%loads)) then
          associate (load => s%measurement%loads(one%surface))
            write (place, '(3(",",es12.5))') load%point, load%force
          end associate
        else if (one%what == NEXT_LOAD) then
          write (place, '(3(",",es12.5))') one%site, one%force*sign(1.0_rp, one%direction(3))
        else if (one%what == NEXT_MOTION .and. one%motion%force > 0) then
          write (place, '(3(",",es12.5))') one%motion%site, one%motion%force
        end if
        write (lengths, '(2(",",es12.5))') next%now(1), one%after
        text = text//number_text(i)//','//trim(DATA_NAMES(kind_of(s, one)))//','//table_words(one)//trim(place)// &
               trim(lengths)//','//apart_names(s, next, one, ' ')//NL
      end associate
    end do
    call write_text(s%name//'_next_measurements.csv', text, failure)

  contains

    !> Returns a name of the measurement, whose place has its own columns.
    function table_words(one) result(words)
      type(next_option_t), intent(in) :: one
      character(:), allocatable :: words
      words = 'new load'
      if (one%what == NEXT_REPEAT) words = s%measurement%surface_name(one%surface)
      if (one%what == NEXT_MOTION) words = 'release in '//trim(MEDIUM_NAMES(one%motion%medium))
      if (one%what == NEXT_MOTION .and. one%motion%kind == PROPOSE_MODES) words = motion_words(one%motion)
    end function table_words
  end subroutine write_next
end module diagnose_next
