! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes an unknown cause in words and in NAME.json.
module diagnose_unknown
  use base_kinds, only: rp
  use base_named_kinds, only: word_of
  use base_text, only: number_text
  use diagnose_settings, only: diagnose_settings_t
  use diagnosis_families, only: FAMILIES, FAMILY_FLIGHT, FAMILY_SCANS, FAMILY_SENSORS
  use diagnosis_unknown, only: unknown_t
  use inference_region, only: REGION_LEVEL
  use io_json, only: json_t
  implicit none
  private
  public :: put_unknown, print_unknown

contains

  !> Adds the members `related` and, if a region was found, `region` to the open object.
  subroutine put_unknown(json, s, unknown)
    type(json_t), intent(inout) :: json
    type(diagnose_settings_t), intent(in) :: s
    type(unknown_t), intent(in) :: unknown
    integer :: i, k
    call json%open_list('related')
    do i = 1, size(unknown%related)
      call json%open_object('')
      call json%put('effect', s%catalogue%effects(unknown%related(i)%effect)%name)
      call json%put('name', trim(unknown%names(i)))
      call json%put('explained', unknown%related(i)%explained)
      call json%close()
    end do
    call json%close()
    if (.not. unknown%region%is_found) return
    call json%open_object('region')
    call json%put('of', word_of(FAMILIES, unknown%family))
    call json%put('form', trim(merge('one_place', 'field    ', unknown%region%is_one_site)))
    call json%put('level', REGION_LEVEL)
    call json%put('cell_m', unknown%cell)
    call json%open_list('parts')
    do i = 1, merge(unknown%region%n_parts, 0, all(unknown%family /= [FAMILY_FLIGHT, FAMILY_SENSORS]))
      call json%open_object('')
      call json%put('centre_m', unknown%centre(i))
      call json%put('radius_m', unknown%radius(i))
      call json%put('share', sum(unknown%region%fraction, mask=unknown%region%part == i))
      call json%open_list('places_m')
      do k = 1, size(unknown%region%pattern)
        if (unknown%region%part(k) == i) call json%put('', unknown%site(:, k))
      end do
      call json%close()
      call json%close()
    end do
    call json%close()
    call json%close()
  end subroutine put_unknown

  !> Prints at most two lines: where the unknown cause acts, and which effects are related to it.
  subroutine print_unknown(unit, unknown)
    integer, intent(in) :: unit
    type(unknown_t), intent(in) :: unknown
    character(:), allocatable :: text
    integer :: i
    if (unknown%region%is_found) write (unit, '(a)') '          where: '//region_text(unknown)
    if (size(unknown%related) == 0) return
    text = ''
    do i = 1, size(unknown%related)
      text = text//'; '//trim(unknown%names(i))//' ('//number_text(nint(100*unknown%related(i)%explained))//' %)'
    end do
    write (unit, '(a)') '          related, but not sufficient (fraction of the misfit explained): '//text(3:)
  end subroutine print_unknown

  !> Describes in words the largest part of the region.
  function region_text(unknown) result(text)
    type(unknown_t), intent(in) :: unknown
    character(:), allocatable :: text
    real(rp) :: middle(2)
    text = 'not on the wing: each scan is bent in another way (by the rig, or by the scan before it)'
    if (unknown%family == FAMILY_SCANS) return
    text = 'not on the wing: errors of the sensors of the records of motion (gain, delay or filter)'
    if (unknown%family == FAMILY_SENSORS) return
    text = 'in the records over the beat'
    if (unknown%family == FAMILY_FLIGHT) return
    text = 'no place stands out'
    if (unknown%region%n_parts == 0) return
    middle = unknown%centre(1)
    text = 'around ('//millimetres(middle(1))//', '//millimetres(middle(2))//') mm, radius '// &
           millimetres(unknown%radius(1))//' mm'
    if (unknown%region%is_one_site) then
      text = text//', probability '//number_text(nint(100*sum(unknown%region%fraction, mask=unknown%region%part == 1)))// &
             ' % if it is one place'
    else if (unknown%region%n_parts > 1) then
      text = text//', the first of '//number_text(unknown%region%n_parts)//' regions'
    end if
  end function region_text

  !> Returns a length [m] in millimetres.
  function millimetres(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    character(16) :: buffer
    write (buffer, '(f12.2)') 1.0e3_rp*x
    text = trim(adjustl(buffer))
  end function millimetres
end module diagnose_unknown
