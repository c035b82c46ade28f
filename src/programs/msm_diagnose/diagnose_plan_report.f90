! SPDX-License-Identifier: GPL-3.0-or-later
!> Implements `msm_diagnose --plan`: reports what the loads of a measurement, or of a plan without heights, could show. It prints
!> a table on the terminal and writes NAME_plan.json for other programs.
module diagnose_plan_report
  use base_build, only: BUILD_COMMIT, BUILD_VERSION
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text_file, only: write_text
  use diagnose_plan_motion, only: in_words_of, print_motion, print_twins, put_twins, put_with_motion, strength_words
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_detectability, only: detectability_t, most_detectable, find_detectability, best_load_t
  use diagnosis_wing_simulator, only: wing_simulator_t
  use inference_calibration_store, only: calibration_store_t
  use inference_decision, only: LEVEL
  use inference_design, only: design_t
  use io_json, only: json_t
  implicit none
  private
  public :: print_plan

  integer, parameter :: SCHEMA_VERSION = 1

contains

  !> Prints the smallest strength of every effect that the loads would show with a probability of 90 %, and writes NAME_plan.json.
  !> It uses the derivatives at the wing with the values in [Wing]. `store` keeps the random draws for another run. Rank 0 calls
  !> it while the other ranks serve.
  subroutine print_plan(unit, s, simulator, failure, store)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(failure_t), intent(out) :: failure
    class(calibration_store_t), intent(inout), optional :: store
    type(detectability_t) :: found
    integer :: e
    call find_detectability(s, simulator, found, failure, store)
    if (failure%failed) return
    write (unit, '(a)') &
      'effect                parameter          found with 90 % from  at                          '// &
      'seen beside baseline'
    do e = 1, size(s%catalogue%effects)
      if (s%catalogue%effects(e)%is_testable()) then
        call print_detectable(unit, s, found%design, e, found%snr(e))
      else
        write (unit, '(a)') s%catalogue%effects(e)%name//repeat(' ', max(1, 22 - len(s%catalogue%effects(e)%name)))// &
          'not testable with these data: '//s%catalogue%effects(e)%missing
      end if
    end do
    if (found%has_loads) call print_best_loads(unit, s, found%best_loads)
    call print_motion(unit, s, found)
    call print_twins(unit, s, found)
    write (unit, '(a)') '', 'These strengths assume that the declared errors are right and that the data have no other errors.'
    if (s%measurement%is_plan .and. any(s%measurement%loads%has_surface) .and. s%noise%model%length > 0) write (unit, '(a)') &
      'Errors of heights count in full as independent errors and in full as correlated errors, because their fractions are not '// &
      'known before the measurement.'
    if (s%finds_discretisation) write (unit, '(a)') &
      'A diagnosis with `refine = yes` also counts the error of the mesh, and needs stronger effects.'
    flush (unit)
    call write_plan(s, found, failure)
  end subroutine print_plan

  !> Prints for each effect the load at a new site that would lower its smallest strength most.
  subroutine print_best_loads(unit, s, best_loads)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(best_load_t), intent(in) :: best_loads(:) !< (effects)
    character(40) :: value
    integer :: e
    write (unit, '(a)') '', &
      'effect                with one more load at x, y [m]      force [N]   found with 90 % from'
    do e = 1, size(best_loads)
      if (.not. best_loads(e)%is_found) cycle
      associate (effect => s%catalogue%effects(e), one => best_loads(e), q => s%catalogue%parameters(best_loads(e)%parameter))
        value = strength_words(q, one%strength)
        write (unit, '(a22,2es15.4,es16.3,3x,a)') effect%name//repeat(' ', 22), one%site, one%force, trim(adjustl(value))
      end associate
    end do
  end subroutine print_best_loads

  !> Prints the variant of effect e that is easiest to detect, and its smallest detectable strength.
  subroutine print_detectable(unit, s, design, e, snr)
    integer, intent(in) :: unit, e
    type(diagnose_settings_t), intent(in) :: s
    type(design_t), intent(in) :: design
    real(rp), intent(in) :: snr
    real(rp) :: strength, least
    character(40) :: value
    integer :: best(2)
    call most_detectable(s, design, e, snr, best, least)
    associate (effect => s%catalogue%effects(e))
      if (best(1) == 0) then
        write (unit, '(a)') effect%name//repeat(' ', max(1, 22 - len(effect%name)))//'absorbed by the baseline'
        return
      end if
      associate (one => design%candidates(best(1)))
        associate (q => s%catalogue%parameters(one%columns(best(2))))
          strength = least*q%prior_sd
          value = strength_words(q, strength)
          write (unit, '(a22,a19,a22,a28,f6.3)') effect%name//repeat(' ', 22), q%name//repeat(' ', 19), &
            adjustl(value), effect%variants(one%variant)%label//repeat(' ', 28), one%retained
        end associate
      end associate
    end associate
  end subroutine print_detectable

  !> Writes NAME_plan.json (docs/formats/diagnosis.schema.json).
  subroutine write_plan(s, found, failure)
    type(diagnose_settings_t), intent(in) :: s
    type(detectability_t), intent(in) :: found
    type(failure_t), intent(inout) :: failure
    type(json_t) :: json
    integer :: e
    call json%open_object('')
    call json%put('schema', 'flusi-msm diagnosis plan')
    call json%put('schema_version', SCHEMA_VERSION)
    call json%put('program', 'msm_diagnose '//BUILD_VERSION//' ('//BUILD_COMMIT//')')
    call json%put('wing', s%wing_case%path)
    call json%put('measurement', s%measurement_path)
    call json%put('level', LEVEL)
    call json%put('power', 0.9_rp)
    call json%open_list('effects')
    do e = 1, size(s%catalogue%effects)
      call put_plan(json, s, found, e)
    end do
    call json%close()
    call put_twins(json, s, found)
    call json%close()
    call write_text(s%name//'_plan.json', json%text, failure)
  end subroutine write_plan

  !> Writes how well a planned measurement could show effect `e`.
  subroutine put_plan(json, s, found, e)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(detectability_t), intent(in) :: found
    integer, intent(in) :: e
    real(rp) :: least
    integer :: best(2)
    call json%open_object('')
    best = 0
    associate (effect => s%catalogue%effects(e), best_load => found%best_loads(e))
      if (effect%is_testable()) call most_detectable(s, found%design, e, found%snr(e), best, least)
      call json%put('name', effect%name)
      call json%put('title', effect%title)
      if (.not. effect%is_testable()) then
        call json%put('status', 'not_testable')
      else if (best(1) == 0) then
        call json%put('status', 'absorbed')
      else
        call json%put('status', 'tested')
      end if
      call json%put('missing', effect%missing)
      if (best(1) > 0) then
        associate (one => found%design%candidates(best(1)))
          associate (q => s%catalogue%parameters(one%columns(best(2))))
            call json%put('parameter', q%name)
            call json%put('unit', q%unit)
            call json%put('is_factor', q%is_log)
            call json%put('variant', effect%variants(one%variant)%label)
            call json%put('retained', one%retained)
            call json%put('detectable', in_words_of(q%is_log, least*q%prior_sd))
            if (best_load%is_found) then
              call json%open_object('best_new_load')
              call json%put('place_m', best_load%site)
              call json%put('force_n', best_load%force)
              call json%put('detectable', in_words_of(q%is_log, best_load%strength))
              call json%close()
            end if
            call put_with_motion(json, found, e, q%is_log)
          end associate
        end associate
      end if
    end associate
    call json%close()
  end subroutine put_plan
end module diagnose_plan_report
