! SPDX-License-Identifier: GPL-3.0-or-later
!> Words for the parameters of causes: a scale turns the value of each into a number that readers know, and words stand around it.
!>
!> Scales, for a value v, what it is when nothing happens r, and a constant c of the wording:
!>
!> | scale | what is displayed |
!> |---|---|
!> | FACTOR | v/r, as per cent more or less, or as "3.1 times" |
!> | EXPONENT | the factor exp(v) |
!> | LINEAR | the factor 1 + c v |
!> | CONTRAST | the factor (1 + v)/(1 - v) of the stiffness along over that across |
!> | HALF | the factor 2^(r - v) by which a vein of half the diameter is stiffer |
!> | PLAIN | c (v - r), with a unit |
!> | SHARE | v itself |
!>
!> Directions are those of the wing file: x points to the tip, z up. The word `up` of a wording stands where the displayed number is
!> larger than without the cause.
module diagnose_wordings
  use base_kinds, only: rp
  implicit none
  private
  public :: wording_t, find_wording, displayed

  integer, parameter, public :: SCALE_FACTOR = 1, SCALE_EXPONENT = 2, SCALE_LINEAR = 3, SCALE_CONTRAST = 4, SCALE_HALF = 5, &
                                SCALE_PLAIN = 6, SCALE_SHARE = 7
  real(rp), parameter :: DEGREES = 57.295779513082323_rp
  real(rp), parameter :: MINUTE = 60.0_rp !< [s]
  character(*), parameter :: ASSUMED = 'than was assumed'

  type :: wording_t
    integer :: scale = SCALE_PLAIN
    real(rp) :: reference = 0            !< value at which nothing happens
    logical :: is_natural = .false.      !< that value is the law's own, and not what was assumed
    real(rp) :: factor = 1               !< c
    character(:), allocatable :: unit    !< of the number, or empty
    character(:), allocatable :: up, down    !< words before the number
    character(:), allocatable :: more, less  !< behind it, and then `than`
    character(:), allocatable :: than
    character(:), allocatable :: times       !< behind ".. times", in their place
    logical :: is_known = .false.        !< the parameter has words of its own
  end type wording_t

contains

  !> The words of parameter `name` [unit] at `place`, of which `null` was assumed; `best` chooses prefixes of units.
  function find_wording(name, unit, place, null, best) result(w)
    character(*), intent(in) :: name, unit, place
    real(rp), intent(in) :: null, best
    type(wording_t) :: w
    w%is_known = .true.
    w%reference = null
    call word_structure(w, name, place, best)
    if (.not. allocated(w%up)) call word_shape(w, name)
    if (.not. allocated(w%up)) call word_forces(w, name)
    if (.not. allocated(w%up)) call word_maps(w, name)
    if (.not. allocated(w%up)) call word_course(w, name)
    if (.not. allocated(w%up)) call word_masses(w, name, place)
    if (.not. allocated(w%up)) then
      w%is_known = .false.
      call plain(w, unit, name//' is', name//' is', 'more', 'less', ASSUMED)
      if (unit == '1') w%unit = ''
    end if
    if (w%scale == SCALE_PLAIN) call choose_prefix(w, best)
  end function find_wording

  !> What is displayed of a value: a factor, a share, or an amount in the unit of the wording.
  pure elemental real(rp) function displayed(w, value) result(shown)
    type(wording_t), intent(in) :: w
    real(rp), intent(in) :: value
    real(rp), parameter :: LARGEST = 300.0_rp, ALMOST = 1.0e-12_rp
    select case (w%scale)
    case (SCALE_FACTOR)
      shown = value/w%reference
    case (SCALE_EXPONENT)
      shown = exp(min(LARGEST, max(-LARGEST, value)))
    case (SCALE_LINEAR)
      shown = 1 + w%factor*value
    case (SCALE_CONTRAST)
      shown = (1 + value)/max(ALMOST, 1 - value)
    case (SCALE_HALF)
      shown = 2.0_rp**(w%reference - value)
    case (SCALE_PLAIN)
      shown = w%factor*(value - w%reference)
    case default
      shown = value
    end select
  end function displayed

  !> Stiffness of veins, membrane and joints.
  subroutine word_structure(w, name, place, best)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name, place
    real(rp), intent(in) :: best
    character(:), allocatable :: what
    what = name(index(name, ':') + 1:)
    select case (name(:index(name//':', ':') - 1))
    case ('E_gradient')
      call factor(w, SCALE_EXPONENT, 'E rises toward the tip:', 'E falls toward the tip:', 'higher', 'lower', 'than at the root', &
                  'that at the root', 0.0_rp)
    case ('root')
      call factor(w, SCALE_FACTOR, 'The veins bend less easily at the clamp:', 'The veins bend more easily at the clamp:', &
                  'stiffer', 'softer', ASSUMED, 'as stiff as was assumed')
    case ('E')
      call factor(w, SCALE_FACTOR, 'Vein '//what//' is of stiffer material: its E is', 'Vein '//what// &
                  ' is of softer material: its E is', 'higher', 'lower', 'than in the other veins', &
                  'that of the other veins', 1.0_rp)
      if (what == name) call factor(w, SCALE_FACTOR, 'The veins are stiffer: E is', 'The veins are softer: E is', 'higher', &
                                    'lower', ASSUMED, 'what was assumed')
    case ('joint')
      call factor(w, SCALE_FACTOR, 'Joint '//what//' is stiffer:', 'Joint '//what//' is softer:', 'stiffer', 'softer', ASSUMED, &
                  'as stiff as was assumed')
    case ('diameter_exponent')
      call factor(w, SCALE_HALF, 'Thin veins are stiff against thick ones: one of half the diameter is', &
                  'Thin veins are soft against thick ones: one of half the diameter is', 'stiffer', 'softer', &
                  'than if both were solid and round', 'as stiff as if both were solid and round', 4.0_rp)
    case ('D')
      call factor(w, SCALE_FACTOR, 'The membrane resists bending more:', 'The membrane resists bending less:', 'stiffer', &
                  'softer', ASSUMED, 'as stiff as was assumed')
    case ('k_vein')
      call springs(w, 'along the veins')
    case ('k_membrane')
      call springs(w, 'of the membrane')
    case ('k_cross')
      call springs(w, 'across the edges of the membrane')
    case ('orthotropy')
      call factor(w, SCALE_CONTRAST, 'The membrane stretches less easily along the span:', &
                  'The membrane stretches more easily along the span:', 'stiffer', 'softer', 'along it than across it', &
                  'as stiff along it as across it', 0.0_rp)
    case ('soft')
      call factor(w, SCALE_FACTOR, 'Vein '//place//' bends less easily:', 'Vein '//place//' bends more easily:', &
                  'stiffer', 'softer', 'there than it looks', 'as stiff there as it looks', 1.0_rp)
    case ('damage')
      call factor(w, SCALE_FACTOR, 'Veins and membrane '//place//' are stiffer:', 'Veins and membrane '//place//' are softer:', &
                  'stiffer', 'softer', ASSUMED, 'as stiff as was assumed', 1.0_rp)
    case ('one_way')
      call factor(w, SCALE_FACTOR, 'Joint '//what//' bends less easily up (+z) than down:', &
                  'Joint '//what//' bends more easily up (+z) than down:', 'stiffer', 'softer', 'upward than downward', &
                  'as stiff upward as downward', 1.0_rp)
    case ('joint_hardening', 'hardening', 'cuticle')
      call word_bends(w, name, what, best)
    end select
  end subroutine word_structure

  subroutine springs(w, where)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: where
    call factor(w, SCALE_FACTOR, 'The springs '//where//' are stiffer:', 'The springs '//where//' are softer:', 'stiffer', &
                'softer', ASSUMED, 'as stiff as was assumed')
  end subroutine springs

  !> What gets stiffer the more it is bent, told at a bend at which that is some per cent.
  subroutine word_bends(w, name, what, best)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name, what
    real(rp), intent(in) :: best
    real(rp), parameter :: STRONG = 100.0_rp        ! [1/rad^2]
    real(rp), parameter :: WEAK = 5.0e-6_rp         ! [m^2]
    character(:), allocatable :: who, at, stiffens, yields
    if (name == 'cuticle') then
      at = merge(' 1 mm', '10 mm', abs(best) < WEAK)
      call factor(w, SCALE_LINEAR, 'Veins get stiffer the more they are bent: at a radius of '//trim(adjustl(at)), &
                  'Veins give way the more they are bent: at a radius of '//trim(adjustl(at)), 'stiffer', 'softer', &
                  'than when straight', 'as stiff as when straight', 0.0_rp)
      w%factor = merge(1.0e6_rp, 1.0e4_rp, abs(best) < WEAK)
      return
    end if
    who = 'All joints'
    stiffens = ' get stiffer'
    yields = ' give way'
    at = ' the more they are bent: at 10 degrees'
    if (name /= 'joint_hardening') then
      who = 'Joint '//what
      stiffens = ' gets stiffer'
      yields = ' gives way'
      at = ' the more it is bent: at 10 degrees'
    end if
    w%factor = (10/DEGREES)**2
    if (abs(best) > STRONG) then
      w%factor = (1/DEGREES)**2
      at = at(:len(at) - 10)//'1 degree'
    end if
    call factor(w, SCALE_LINEAR, who//stiffens//at, who//yields//at, 'stiffer', 'softer', 'than when straight', &
                'as stiff as when straight', 0.0_rp)
  end subroutine word_bends

  !> The clamp, and shape and stress of the unloaded wing.
  subroutine word_shape(w, name)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name
    character(*), parameter :: CURVED = 'The wing is curved when nothing pushes:'
    select case (name)
    case ('root_flap')
      call plain(w, '', 'The root gives way and lets the wing flap, by', 'The root lets the wing flap less than was assumed, by', &
                 '', '', 'for every uN m of moment about y', 0.0_rp)
      w%factor = 1.0e-6_rp*DEGREES
      w%unit = 'degrees'
    case ('root_twist')
      call plain(w, '', 'The root gives way and lets the wing twist, by', &
                 'The root lets the wing twist less than was assumed, by', '', '', 'for every uN m of moment about x', 0.0_rp)
      w%factor = 1.0e-6_rp*DEGREES
      w%unit = 'degrees'
    case ('pretension')
      call plain(w, 'N/m', 'The membrane is stretched when nothing pushes, by', &
                 'The membrane is stretched less than was assumed when nothing pushes, by', '', '', '', 0.0_rp)
    case ('camber_span')
      call plain(w, 'per m', CURVED, CURVED, 'along the span, with root and tip toward +z', &
                 'along the span, with root and tip toward -z', '', 0.0_rp)
    case ('camber_chord')
      call plain(w, 'per m', CURVED, CURVED, 'across the span, with both edges toward +z', &
                 'across the span, with both edges toward -z', '', 0.0_rp)
    case ('camber_twist')
      call plain(w, 'per m', 'The wing is twisted when nothing pushes:', 'The wing is twisted when nothing pushes:', &
                 'with its edge at +y toward +z at the tip', 'with its edge at +y toward -z at the tip', '', 0.0_rp)
    case ('torsion')
      call share(w, 'Veins resist being twisted: with', 'Veins resist being twisted less than was assumed: with', &
                 'of their stiffness against bending (solid round veins: 0.77)', 0.0_rp)
    end select
  end subroutine word_shape

  !> Forces, and what is read under them.
  subroutine word_forces(w, name)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name
    character(*), parameter :: UPRIGHT = 'Forces were not upright but turned:', BESIDE = 'Forces acted beside the stated places:'
    select case (name)
    case ('force_gain')
      call factor(w, SCALE_FACTOR, 'All forces were', 'All forces were', 'larger', 'smaller', 'than stated', &
                  'what is stated', 1.0_rp)
    case ('force_offset')
      call plain(w, 'N', 'Every force was', 'Every force was', 'larger', 'smaller', 'than stated', 0.0_rp)
    case ('force_tilt_x')
      call degrees_of(w, UPRIGHT, 'about x, those that point up toward -y', 'about x, those that point up toward +y')
    case ('force_tilt_y')
      call degrees_of(w, UPRIGHT, 'about y, those that point up toward +x', 'about y, those that point up toward -x')
    case ('load_shift_x')
      call plain(w, 'm', BESIDE, BESIDE, 'toward +x', 'toward -x', '', 0.0_rp)
    case ('load_shift_y')
      call plain(w, 'm', BESIDE, BESIDE, 'toward +y', 'toward -y', '', 0.0_rp)
    case ('nonlinearity')
      call share(w, 'The wing bends so far that twice the force is not twice the way: with', &
                 'The wing bends more in proportion to the force than was assumed: with', 'of what geometry alone makes')
    case ('gravity_x')
      call weight(w, 'x')
    case ('gravity_y')
      call weight(w, 'y')
    case ('gravity_z')
      call weight(w, 'z')
    end select
  end subroutine word_forces

  subroutine weight(w, axis)
    type(wording_t), intent(inout) :: w
    character, intent(in) :: axis
    character(*), parameter :: LEAD = 'The wing''s own weight bends it:'
    call plain(w, '', LEAD, LEAD, 'toward +'//axis, 'toward -'//axis, '', 0.0_rp)
    w%unit = 'm/s^2'
  end subroutine weight

  !> Height maps.
  subroutine word_maps(w, name)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name
    character(*), parameter :: TILTED = 'Loaded scans are tilted against the unloaded one:', &
                               ELSEWHERE = 'The wing lies elsewhere in the maps than the file says:', &
                               TURNED = 'The wing is turned in the maps:', &
                               MOVED = 'Loaded scans lie apart from the unloaded one:'
    select case (name)
    case ('height_scale')
      call factor(w, SCALE_FACTOR, 'The maps show all heights', 'The maps show all heights', 'larger', 'smaller', 'than they are', &
                  'as large as they are', 1.0_rp)
    case ('tilt_x')
      call degrees_of(w, TILTED, 'up toward +y', 'down toward +y')
    case ('tilt_y')
      call degrees_of(w, TILTED, 'down toward +x', 'up toward +x')
    case ('piston')
      call plain(w, 'm', MOVED, MOVED, 'up', 'down', '', 0.0_rp)
    case ('map_shift_x')
      call plain(w, 'm', ELSEWHERE, ELSEWHERE, 'toward +x', 'toward -x', '', 0.0_rp)
    case ('map_shift_y')
      call plain(w, 'm', ELSEWHERE, ELSEWHERE, 'toward +y', 'toward -y', '', 0.0_rp)
    case ('map_rotation')
      call degrees_of(w, TURNED, 'counter-clockwise', 'clockwise')
    case ('map_scale')
      call factor(w, SCALE_FACTOR, 'The maps show the wing', 'The maps show the wing', 'larger', 'smaller', 'than it is', &
                  'as large as it is', 1.0_rp)
    end select
  end subroutine word_maps

  !> What changes while it is measured.
  subroutine word_course(w, name)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name
    select case (name)
    case ('drift', 'drift_veins')
      call factor(w, SCALE_LINEAR, 'The wing became stiffer from one measurement to the next:', &
                  'The wing became softer from one measurement to the next:', 'stiffer', 'softer', 'each time', &
                  'as stiff each time', 0.0_rp)
    case ('drift_rate')
      call factor(w, SCALE_LINEAR, 'The wing became stiffer with time:', 'The wing became softer with time:', 'stiffer', &
                  'softer', 'in every minute', 'as stiff in every minute', 0.0_rp)
      w%factor = MINUTE
    case ('creep')
      call factor(w, SCALE_LINEAR, 'The wing goes on bending while a force is held:', &
                  'The wing bends back while a force is held:', 'more', 'less', 'in ten times the time', &
                  'as far in ten times the time', 0.0_rp)
    end select
  end subroutine word_course

  !> What motion alone shows.
  subroutine word_masses(w, name, place)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name, place
    select case (name)
    case ('vein_mass')
      call factor(w, SCALE_FACTOR, 'The veins weigh more:', 'The veins weigh less:', 'heavier', 'lighter', ASSUMED, &
                  'as heavy as was assumed', 1.0_rp)
    case ('membrane_mass')
      call factor(w, SCALE_FACTOR, 'The membrane weighs more:', 'The membrane weighs less:', 'heavier', 'lighter', ASSUMED, &
                  'as heavy as was assumed', 1.0_rp)
    case ('membrane_gradient')
      call factor(w, SCALE_EXPONENT, 'The membrane''s mass rises toward the tip:', 'The membrane''s mass falls toward the tip:', &
                  'more', 'less', 'there than at the root', 'that at the root', 0.0_rp)
    case ('point_mass')
      call plain(w, 'g', 'Something sits on the wing '//place//':', 'The wing is lighter '//place//':', '', '', '', 0.0_rp)
      w%factor = 1.0e3_rp
    end select
  end subroutine word_masses

  !> Words of a factor; without `reference` that is what was assumed.
  subroutine factor(w, scale, up, down, more, less, than, times, reference)
    type(wording_t), intent(inout) :: w
    integer, intent(in) :: scale
    character(*), intent(in) :: up, down, more, less, than, times
    real(rp), intent(in), optional :: reference
    call plain(w, '%', up, down, more, less, than, reference)
    w%scale = scale
    w%times = times
  end subroutine factor

  subroutine share(w, up, down, than, reference)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: up, down, than
    real(rp), intent(in), optional :: reference
    call plain(w, '', up, down, '', '', than, reference)
    w%scale = SCALE_SHARE
  end subroutine share

  subroutine degrees_of(w, lead, more, less)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: lead, more, less
    call plain(w, '', lead, lead, more, less, '', 0.0_rp)
    w%factor = DEGREES
    w%unit = 'degrees'
  end subroutine degrees_of

  subroutine plain(w, unit, up, down, more, less, than, reference)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: unit, up, down, more, less, than
    real(rp), intent(in), optional :: reference
    w%unit = trim(unit)
    w%up = up
    w%down = down
    w%more = more
    w%less = less
    w%than = than
    w%times = than
    w%is_natural = present(reference)
    if (present(reference)) w%reference = reference
  end subroutine plain

  !> A prefix that makes the number one from 1 to 1000, for units that take one.
  subroutine choose_prefix(w, best)
    type(wording_t), intent(inout) :: w
    real(rp), intent(in) :: best
    character, parameter :: PREFIXES(4) = ['m', 'u', 'n', 'p']
    real(rp) :: size
    integer :: k
    if (w%unit /= 'm' .and. w%unit /= 'N' .and. w%unit /= 'g' .and. w%unit /= 'N/m') return
    size = abs(displayed(w, best))
    if (.not. size > 0) return
    k = max(0, min(4, ceiling(-log10(size)/3 - 1.0e-9_rp)))
    if (k == 0) return
    w%factor = w%factor*1000.0_rp**k
    w%unit = PREFIXES(k)//w%unit
  end subroutine choose_prefix
end module diagnose_wordings
