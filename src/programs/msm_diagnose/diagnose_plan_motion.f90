! SPDX-License-Identifier: GPL-3.0-or-later
!> Reports, for `msm_diagnose --plan`, what natural modes and records of motion would add to the loads, and which measurement would
!> tell apart effects that the loads cannot.
module diagnose_plan_motion
  use base_kinds, only: rp
  use diagnose_next, only: motion_words, put_motion
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_detectability, only: detectability_t, most_detectable, MOTION_AIR, MOTION_RELEASE, MOTION_VACUUM, N_MOTIONS
  use diagnosis_wing_parameters, only: wing_parameter_t
  use io_json, only: json_t
  implicit none
  private
  public :: in_words_of, print_motion, print_twins, put_twins, put_with_motion, strength_words

  character(*), parameter :: NO_UNIT = '1' !< of a number without a unit
  character(*), parameter :: NAMES(N_MOTIONS) = [character(12) :: 'modes_vacuum', 'modes_air', 'release']

contains

  !> Returns a strength, a change of the coordinate of a parameter, with its unit or as a factor.
  function strength_words(parameter, strength) result(text)
    type(wing_parameter_t), intent(in) :: parameter
    real(rp), intent(in) :: strength
    character(:), allocatable :: text
    character(40) :: value
    if (parameter%is_log) write (value, '(a,f0.4)') 'a factor of ', in_words_of(.true., strength)
    if (.not. parameter%is_log) write (value, '(es10.3)') strength
    text = trim(adjustl(value))
    if (parameter%unit /= NO_UNIT .and. .not. parameter%is_log) text = text//' '//parameter%unit
  end function strength_words

  !> Converts a change of a coordinate into the number that users see. It is a factor if the coordinate is a logarithm.
  pure real(rp) function in_words_of(is_log, change) result(value)
    logical, intent(in) :: is_log
    real(rp), intent(in) :: change
    value = change
    if (is_log) value = exp(min(50.0_rp, change))
  end function in_words_of

  !> Prints for each effect the smallest strength that would show with motion too.
  subroutine print_motion(unit, s, found)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(detectability_t), intent(in) :: found
    character(24) :: values(N_MOTIONS)
    character(:), allocatable :: place
    real(rp) :: least
    integer :: e, m, best(2)
    if (found%no_motion /= '') then
      write (unit, '(a)') '', 'Natural modes and records of motion were not tried: '//found%no_motion//'.'
      return
    end if
    write (unit, '(a)') '', 'effect                with modes in vacuum    with modes in air       with a release          which'
    do e = 1, size(s%catalogue%effects)
      if (.not. any(found%with_motion(:, e) > 0)) cycle
      call most_detectable(s, found%design, e, found%snr(e), best, least)
      associate (q => s%catalogue%parameters(found%design%candidates(best(1))%columns(best(2))))
        values = '-'
        do m = 1, N_MOTIONS
          if (found%with_motion(m, e) > 0) values(m) = strength_words(q, found%with_motion(m, e))
        end do
      end associate
      place = ''
      if (found%with_motion(MOTION_RELEASE, e) > 0) place = motion_words(found%releases(e))
      write (unit, '(a22,3a24,a)') s%catalogue%effects(e)%name//repeat(' ', 22), values, place
    end do
  end subroutine print_motion

  !> Prints the effects that the data cannot tell apart, and how far each measurement would separate them.
  subroutine print_twins(unit, s, found)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(detectability_t), intent(in) :: found
    character(12) :: motion(N_MOTIONS)
    character(22) :: rival
    integer :: i
    if (size(found%twins) == 0) return
    write (unit, '(a)') '', 'At these strengths the data cannot tell apart these effects. Separations are in sd; 2.4 is enough:', &
      'effect                from                       now  one more load  modes in vacuum  modes in air   release'
    do i = 1, size(found%twins)
      associate (one => found%twins(i))
        rival = 'the baseline'
        if (one%rival > 0) rival = s%catalogue%effects(one%rival)%name
        motion = '           -'
        if (found%no_motion == '') write (motion, '(f12.1)') one%with_motion
        write (unit, '(2a22,f8.1,f15.1,a17,a14,a10)') s%catalogue%effects(one%effect)%name//repeat(' ', 22), rival, one%now, &
          one%with_load, motion(MOTION_VACUUM), motion(MOTION_AIR), motion(MOTION_RELEASE)(3:)
      end associate
    end do
  end subroutine print_twins

  !> Adds what motion would make of the smallest strength of effect e to the open object.
  subroutine put_with_motion(json, found, e, is_log)
    type(json_t), intent(inout) :: json
    type(detectability_t), intent(in) :: found
    integer, intent(in) :: e
    logical, intent(in) :: is_log
    integer :: m
    if (.not. any(found%with_motion(:, e) > 0)) return
    call json%open_object('with_motion')
    do m = 1, N_MOTIONS
      if (found%with_motion(m, e) > 0) call json%put(trim(NAMES(m)), in_words_of(is_log, found%with_motion(m, e)))
    end do
    if (found%with_motion(MOTION_RELEASE, e) > 0) then
      call json%open_object('best_release')
      call put_motion(json, found%releases(e))
      call json%close()
    end if
    call json%close()
  end subroutine put_with_motion

  !> Adds the list `not_told_apart` to the open object: effects, and how far each measurement would separate them.
  subroutine put_twins(json, s, found)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(detectability_t), intent(in) :: found
    integer :: i, m
    call json%put('motion_not_tried', found%no_motion)
    call json%open_list('not_told_apart')
    do i = 1, size(found%twins)
      associate (one => found%twins(i))
        call json%open_object('')
        call json%put('effect', s%catalogue%effects(one%effect)%name)
        if (one%rival > 0) call json%put('from', s%catalogue%effects(one%rival)%name)
        call json%put('separation_now_sd', one%now)
        call json%put('one_more_load_sd', one%with_load)
        do m = 1, merge(N_MOTIONS, 0, found%no_motion == '')
          call json%put(trim(NAMES(m))//'_sd', one%with_motion(m))
        end do
        call json%close()
      end associate
    end do
    call json%close()
  end subroutine put_twins
end module diagnose_plan_motion
