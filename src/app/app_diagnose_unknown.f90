! SPDX-License-Identifier: GPL-3.0-or-later
!> What can be said of a cause that is not in the catalogue: where on the wing it is, and which entries come nearest to it
!> without being sufficient.
module app_diagnose_unknown
  use app_diagnose_settings, only: diagnose_settings_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnosis_decision, only: VERDICT_UNKNOWN
  use diagnosis_engine, only: diagnosis_t
  use diagnosis_region, only: find_region, find_related, region_t, related_t, REGION_LEVEL
  use diagnosis_wing_simulator, only: wing_simulator_t, FAMILY_NAMES
  use io_json, only: json_t
  implicit none
  private
  public :: unknown_t, candidate_name, describe_unknown, put_unknown, print_unknown

  !> Empty unless the verdict is an unknown cause.
  type :: unknown_t
    type(region_t) :: region
    real(rp), allocatable :: place(:, :)            !< (2, size(region%pattern)) [m]
    real(rp) :: cell = 0                            !< [m] half the distance of places
    type(related_t), allocatable :: related(:)
    character(:), allocatable :: names(:)           !< (size(related)) title and place
  end type unknown_t

contains

  !> Seeks both.
  function describe_unknown(s, simulator, d) result(unknown)
    type(diagnose_settings_t), intent(in) :: s
    type(wing_simulator_t), intent(in) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(unknown_t) :: unknown
    integer :: i
    allocate (unknown%related(0), unknown%place(2, 0))
    if (d%decision%verdict /= VERDICT_UNKNOWN) return
    unknown%cell = 0.5_rp*s%patterns%radius
    call find_region(d%design, d%z, simulator%pattern_place, s%patterns%radius, unknown%region)
    if (unknown%region%is_found) then
      associate (patterns => d%design%families(unknown%region%family)%patterns)
        unknown%place = simulator%pattern_place(:, patterns(unknown%region%pattern))
      end associate
    end if
    call find_related(d%design, d%calibration, d%statistics, d%z, unknown%related)
    allocate (character(200) :: unknown%names(size(unknown%related)))
    do i = 1, size(unknown%related)
      unknown%names(i) = candidate_name(s, d, unknown%related(i)%candidate)
    end do
  end function describe_unknown

  !> Title and place of a candidate.
  function candidate_name(s, d, c) result(text)
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, intent(in) :: c
    character(:), allocatable :: text
    associate (one => d%design%candidates(c))
      associate (effect => s%catalogue%effects(one%effect))
        text = effect%title
        if (effect%variants(one%variant)%label /= '') text = text//', '//effect%variants(one%variant)%label
      end associate
    end associate
  end function candidate_name

  !> Members `related` and `region` of the object that is open.
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
    call json%put('of', trim(FAMILY_NAMES(unknown%region%family)))
    call json%put('form', trim(merge('one_place', 'field    ', unknown%region%is_one_place)))
    call json%put('level', REGION_LEVEL)
    call json%put('cell_m', unknown%cell)
    call json%open_list('parts')
    do i = 1, unknown%region%n_parts
      call json%open_object('')
      call json%put('centre_m', centre(unknown, i))
      call json%put('radius_m', radius(unknown, i))
      call json%put('share', sum(unknown%region%share, mask=unknown%region%part == i))
      call json%open_list('places_m')
      do k = 1, size(unknown%region%pattern)
        if (unknown%region%part(k) == i) call json%put('', unknown%place(:, k))
      end do
      call json%close()
      call json%close()
    end do
    call json%close()
    call json%close()
  end subroutine put_unknown

  !> Mean (2) [m] of the places of part i, weighted with their shares.
  pure function centre(unknown, i)
    type(unknown_t), intent(in) :: unknown
    integer, intent(in) :: i
    real(rp) :: centre(2), weight(size(unknown%region%share))
    weight = merge(unknown%region%share, 0.0_rp, unknown%region%part == i)
    centre = matmul(unknown%place, weight)/sum(weight)
  end function centre

  !> [m] of the circle about the centre that holds the cells of all places of part i.
  pure real(rp) function radius(unknown, i)
    type(unknown_t), intent(in) :: unknown
    integer, intent(in) :: i
    real(rp) :: middle(2)
    integer :: k
    middle = centre(unknown, i)
    radius = unknown%cell
    do k = 1, size(unknown%region%pattern)
      if (unknown%region%part(k) == i) radius = max(radius, unknown%cell + norm2(unknown%place(:, k) - middle))
    end do
  end function radius

  !> Two lines at most: where, and what is related.
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
    write (unit, '(a)') '          related, not sufficient (share of the misfit): '//text(3:)
  end subroutine print_unknown

  !> The largest part in words.
  function region_text(unknown) result(text)
    type(unknown_t), intent(in) :: unknown
    character(:), allocatable :: text
    real(rp) :: middle(2)
    text = 'not on the wing: scans are bent, each in another way (the rig, or what the scan before has left)'
    if (FAMILY_NAMES(unknown%region%family) == 'scans') return
    text = 'no place stands out'
    if (unknown%region%n_parts == 0) return
    middle = centre(unknown, 1)
    text = 'around ('//millimetres(middle(1))//', '//millimetres(middle(2))//') mm, radius '// &
           millimetres(radius(unknown, 1))//' mm'
    if (unknown%region%is_one_place) then
      text = text//', probability '//number_text(nint(100*sum(unknown%region%share, mask=unknown%region%part == 1)))// &
             ' % if it is one place'
    else if (unknown%region%n_parts > 1) then
      text = text//', the first of '//number_text(unknown%region%n_parts)//' regions'
    end if
  end function region_text

  function millimetres(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    character(16) :: buffer
    write (buffer, '(f12.2)') 1.0e3_rp*x
    text = trim(adjustl(buffer))
  end function millimetres
end module app_diagnose_unknown
