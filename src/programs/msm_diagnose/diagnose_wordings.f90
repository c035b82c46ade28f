! SPDX-License-Identifier: GPL-3.0-or-later
!> Provides the words for the parameters of causes. Those of effects of the wing are in the modules solid_effect_*. Here are those
!> of parameters that every wing has, of the measurement and of masses. solid_wording defines the scales.
module diagnose_wordings
  use base_kinds, only: rp
  use diagnose_flight_wordings, only: word_flight
  use solid_effects, only: effect_wording
  use solid_wording, only: displayed, factor => word_factor, plain => word_plain, fraction => word_fraction, wording_t, DEGREES, &
                           SCALE_EXPONENT, SCALE_FACTOR, SCALE_HALF, SCALE_LINEAR, SCALE_PLAIN
  implicit none
  private
  public :: find_wording

  real(rp), parameter :: MINUTE = 60.0_rp !< [s]
  character(*), parameter :: ASSUMED = 'than was assumed'

contains

  !> Returns the words of parameter `name` [unit] at `site`. `null` is its assumed value; `best`, its fitted value, determines the
  !> prefix of the unit.
  function find_wording(name, unit, site, null, best) result(w)
    character(*), intent(in) :: name, unit, site
    real(rp), intent(in) :: null, best
    type(wording_t) :: w
    call effect_wording(name, site, best, w)
    if (.not. w%is_known) w%reference = null
    w%is_known = .true.
    if (.not. allocated(w%up)) call word_structure(w, name)
    if (.not. allocated(w%up)) call word_forces(w, name)
    if (.not. allocated(w%up)) call word_maps(w, name)
    if (.not. allocated(w%up)) call word_course(w, name)
    if (.not. allocated(w%up)) call word_masses(w, name, site)
    if (.not. allocated(w%up)) call word_flight(w, name, unit)
    if (.not. allocated(w%up)) then
      w%is_known = .false.
      call plain(w, unit, name//' is', name//' is', 'more', 'less', ASSUMED)
      if (unit == '1') w%unit = ''
    end if
    if (w%scale == SCALE_PLAIN) call choose_prefix(w, best)
  end function find_wording

  !> Gives the words for the stiffness of veins, membrane and joints.
  subroutine word_structure(w, name)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name
    character(:), allocatable :: what
    what = name(index(name, ':') + 1:)
    select case (name(:index(name//':', ':') - 1))
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
    end select
  end subroutine word_structure

  !> Gives the words for springs that are stiffer or softer.
  subroutine springs(w, where)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: where
    call factor(w, SCALE_FACTOR, 'The springs '//where//' are stiffer:', 'The springs '//where//' are softer:', 'stiffer', &
                'softer', ASSUMED, 'as stiff as was assumed')
  end subroutine springs

  !> Gives the words for forces, and for what is read under them.
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
      call fraction(w, 'The wing bends so far that twice the force does not bend it twice as far: with', &
                    'The wing bends more in proportion to the force than was assumed: with', 'of what geometry alone makes')
    case ('gravity_x')
      call weight(w, 'x')
    case ('gravity_y')
      call weight(w, 'y')
    case ('gravity_z')
      call weight(w, 'z')
    end select
  end subroutine word_forces

  !> Gives the words for the weight of the wing along an axis.
  subroutine weight(w, axis)
    type(wording_t), intent(inout) :: w
    character, intent(in) :: axis
    character(*), parameter :: LEAD = 'The wing''s own weight bends it:'
    call plain(w, '', LEAD, LEAD, 'toward +'//axis, 'toward -'//axis, '', 0.0_rp)
    w%unit = 'm/s^2'
  end subroutine weight

  !> Gives the words for errors of height maps.
  subroutine word_maps(w, name)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name
    character(*), parameter :: TILTED = 'Loaded scans are tilted against the unloaded one:', &
                               DISPLACED = 'The wing lies elsewhere in the maps than the file says:', &
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
      call plain(w, 'm', DISPLACED, DISPLACED, 'toward +x', 'toward -x', '', 0.0_rp)
    case ('map_shift_y')
      call plain(w, 'm', DISPLACED, DISPLACED, 'toward +y', 'toward -y', '', 0.0_rp)
    case ('map_rotation')
      call degrees_of(w, TURNED, 'counter-clockwise', 'clockwise')
    case ('map_scale')
      call factor(w, SCALE_FACTOR, 'The maps show the wing', 'The maps show the wing', 'larger', 'smaller', 'than it is', &
                  'as large as it is', 1.0_rp)
    end select
  end subroutine word_maps

  !> Gives the words for what changes during the measurement.
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

  !> Gives the words for what only motion shows.
  subroutine word_masses(w, name, site)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: name, site
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
      call plain(w, 'g', 'Something sits on the wing '//site//':', 'The wing is lighter '//site//':', '', '', '', 0.0_rp)
      w%factor = 1.0e3_rp
    end select
  end subroutine word_masses

  !> Gives the words for an angle, which is shown in degrees.
  subroutine degrees_of(w, lead, more, less)
    type(wording_t), intent(inout) :: w
    character(*), intent(in) :: lead, more, less
    call plain(w, '', lead, lead, more, less, '', 0.0_rp)
    w%factor = DEGREES
    w%unit = 'degrees'
  end subroutine degrees_of

  !> Chooses a prefix that brings the number between 1 and 1000, if the unit takes one.
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
