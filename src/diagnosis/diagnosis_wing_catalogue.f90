! SPDX-License-Identifier: GPL-3.0-or-later
!> The catalogue: what a simulation of a bending test may lack, one entry for each effect, with a sentence for people,
!> the parameters that it releases, the positions at which it is tried, and what data it needs to show.
module diagnosis_wing_catalogue
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnosis_simulator, only: effect_t, quantity_t, variant_t
  use diagnosis_wing_lattice, only: lattice
  use diagnosis_wing_quantities, only: wing_quantity_t, KIND_DAMAGE, KIND_INSTRUMENT, KIND_PARAMETER, KIND_SOFT, &
                                       KIND_ZERO
  use measurement_experiment, only: experiment_t
  use measurement_instrument, only: missing_for, CREEP, DRIFT, DRIFT_RATE, FORCE_GAIN, FORCE_OFFSET, FORCE_TILT_X, &
                                    FORCE_TILT_Y, HEIGHT_SCALE, LOAD_SHIFT_X, LOAD_SHIFT_Y, MAP_ROTATION, MAP_SCALE, &
                                    MAP_SHIFT_X, MAP_SHIFT_Y, PISTON, TILT_X, TILT_Y
  use solid_layout, only: hinge_in_vein
  use solid_params, only: parameter_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: catalogue_t, make_catalogue

  real(rp), parameter :: DECADE = 2.302585092994046_rp
  real(rp), parameter :: DAMAGE_RADIUS = 0.1_rp, DAMAGE_SPACING = 0.12_rp !< of the wing's size

  !> Parameters and effects of a diagnosis; the first n_baseline parameters are those of the baseline.
  type :: catalogue_t
    integer :: n_baseline = 0
    type(quantity_t), allocatable :: quantities(:)
    type(wing_quantity_t), allocatable :: kinds(:)
    type(effect_t), allocatable :: effects(:)
  contains
    procedure, private :: add_quantity => catalogue_add_quantity
    procedure, private :: add_parameter => catalogue_add_parameter
    procedure, private :: enter => catalogue_enter
  end type catalogue_t

contains

  !> The catalogue for an experiment without unknowns of its own on `wing`; the baseline seeks the parameters of these
  !> numbers, with `decades` as sd of their priors.
  subroutine make_catalogue(experiment, wing, numbers, decades, catalogue)
    type(experiment_t), intent(in) :: experiment
    type(wing_t), intent(in) :: wing
    integer, intent(in) :: numbers(:)
    real(rp), intent(in) :: decades
    type(catalogue_t), intent(out) :: catalogue
    integer :: i, n
    allocate (catalogue%quantities(0), catalogue%kinds(0), catalogue%effects(0))
    do i = 1, size(numbers)
      n = catalogue%add_parameter(experiment, numbers(i))
      catalogue%quantities(n)%prior_sd = decades*DECADE
      if (.not. catalogue%quantities(n)%is_log) catalogue%quantities(n)%prior_sd = decades
    end do
    do i = 1, size(experiment%measurement%zeros)
      n = catalogue%add_quantity(quantity_t('zero:'//trim(experiment%measurement%zeros(i)), 'm', .false., 0.0_rp, &
                                            0.0_rp, -experiment%model%size, experiment%model%size), &
                                 wing_quantity_t(kind=KIND_ZERO, number=i))
    end do
    catalogue%n_baseline = size(catalogue%quantities)
    call enter_structure(catalogue, experiment, numbers)
    call enter_scans(catalogue, experiment, wing)
    call enter_measurement(catalogue, experiment)
  end subroutine make_catalogue

  !> Entries that are parameters of the wing, where the baseline does not seek them already.
  subroutine enter_structure(c, e, numbers)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    character(:), allocatable :: levels
    levels = needs_levels(e)
    call enter_named(c, e, numbers, 'root_compliance', 'compliant root', [character(20) :: 'root_flap', 'root_twist'], &
                 .true., 'The clamp or the wing''s root gives way: the whole wing turns about it, in proportion to '// &
                     'the moment of the force.', '')
    call enter_named(c, e, numbers, 'root_stiffness', 'root of another stiffness', [character(20) :: 'root'], .true., &
                     'The veins bend more or less easily where the wing is clamped.', '')
    call enter_named(c, e, numbers, 'E_gradient', 'stiffness that changes along the span', &
                     [character(20) :: 'E_gradient'], .true., &
                     'The veins'' material is softer or stiffer toward the tip than at the root.', '')
    call enter_named(c, e, numbers, 'E_per_vein', 'a vein of another material', [character(20) :: 'E:*'], .false., &
                     'One vein is softer or stiffer than the others.', '')
    call enter_named(c, e, numbers, 'taper', 'other cross-sections of veins', [character(20) :: 'diameter_exponent'], &
                     .true., 'Thin veins are stiffer or softer against thick ones than solid circles would be: '// &
                     'hollow or flattened veins.', '')
    call enter_named(c, e, numbers, 'membrane_bending', 'stiffer or softer membrane', [character(20) :: 'D'], .true., &
                     'The membrane resists bending more or less than was assumed.', '')
    call enter_named(c, e, numbers, 'orthotropy', 'membrane that is stiffer in one direction', &
                     [character(20) :: 'orthotropy'], .true., &
                     'The membrane stretches less easily along the span than across it, or the other way round.', '')
    call enter_named(c, e, numbers, 'joint_hardening', 'joints that harden', &
                     [character(20) :: 'joint_hardening'], .true., &
                     'Joints of veins get stiffer, or give way, the more they are bent.', levels)
    call enter_named(c, e, numbers, 'one_joint_hardening', 'one joint that hardens', [character(20) :: 'hardening:*'], &
                     .false., 'One joint gets stiffer, or gives way, the more it is bent.', levels)
    call enter_named(c, e, numbers, 'cuticle', 'nonlinear cuticle', [character(20) :: 'cuticle'], .true., &
                     'The veins themselves get stiffer, or soften, the more they are bent.', levels)
  end subroutine enter_structure

  !> Enters the parameters that match one of `names` (NAME or NAME:*), released together or one after another; nothing
  !> if the wing has none of them or the baseline seeks them.
  subroutine enter_named(c, e, numbers, name, title, names, is_together, sentence, missing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    character(*), intent(in) :: name, title, names(:), sentence, missing
    logical, intent(in) :: is_together
    type(parameter_t) :: p
    type(variant_t), allocatable :: variants(:)
    integer, allocatable :: columns(:)
    integer :: i, k, n
    allocate (variants(0), columns(0))
    do i = 1, e%model%params%count()
      if (any(numbers == i)) cycle
      p = e%model%params%describe(i)
      do k = 1, size(names)
        n = len_trim(names(k))
        if (names(k) (n:n) == '*') then
          if (index(p%name, names(k) (:n - 1)) /= 1) cycle
        else if (p%name /= names(k)) then
          cycle
        end if
        n = c%add_parameter(e, i)
        columns = [columns, n]
        if (is_together) cycle
        call append(variants, p%name(index(p%name, ':') + 1:), n, [0.0_rp, 0.0_rp])
      end do
    end do
    if (size(columns) == 0) return
    if (is_together) then
      call append(variants, '', 0, [0.0_rp, 0.0_rp])
      variants(1)%columns = columns
    end if
    call c%enter(name, title, sentence, .false., missing, variants)
  end subroutine enter_named

  !> A soft place of a vein and damage of the membrane, each at many positions.
  subroutine enter_scans(c, e, wing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(wing_t), intent(in) :: wing
    type(variant_t), allocatable :: variants(:)
    type(wing_quantity_t) :: kind
    real(rp), allocatable :: way(:), places(:, :)
    integer :: v, k, n
    allocate (variants(0))
    do v = 1, size(wing%veins)
      associate (nodes => wing%veins(v)%nodes)
        way = [0.0_rp]
        do k = 2, size(nodes)
          way = [way, way(k - 1) + norm2(wing%points(:, nodes(k)) - wing%points(:, nodes(k - 1)))]
        end do
        do k = 2, size(nodes) - 1
          kind = wing_quantity_t(kind=KIND_SOFT, vein=v, share=way(k)/way(size(way)))
          kind%number = hinge_in_vein(wing, e%model%plans, v, kind%share)
          if (kind%number == 0) cycle
          if (any(c%kinds%kind == KIND_SOFT .and. c%kinds%number == kind%number)) cycle
          n = c%add_quantity(quantity_t('soft', '1', .true., 0.0_rp, 2.0_rp, -9.0_rp, 4.6_rp), kind)
          call append(variants, wing%veins(v)%name//' at '//percent(kind%share), n, wing%points(:2, nodes(k)))
        end do
      end associate
    end do
    if (size(variants) > 0) &
      call c%enter('soft_place', 'a joint that the model does not have', &
                  'One vein is softer (or stiffer) at one place than it looks: an unseen joint, a crack or a repair.', &
                   .false., '', variants)
    deallocate (variants)
    allocate (variants(0))
    call lattice(wing, e%model%size, DAMAGE_SPACING, places)
    do k = 1, size(places, 2)
      n = c%add_quantity(quantity_t('damage', '1', .true., 0.0_rp, 1.0_rp, -4.6_rp, 4.6_rp), &
                         wing_quantity_t(kind=KIND_DAMAGE, disc=[places(:, k), DAMAGE_RADIUS*e%model%size]))
      call append(variants, 'around ('//millimetres(places(1, k))//', '//millimetres(places(2, k))//') mm', n, &
                  places(:, k))
    end do
    if (size(variants) > 0) &
      call c%enter('damage', 'a damaged region', &
                   'Veins and membrane of one region are softer, as if torn, or stiffer than the rest.', .false., '', &
                   variants)
  end subroutine enter_scans

  !> Entries that are errors of the measurement.
  subroutine enter_measurement(c, e)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    call enter_instrument(c, e, 'force_gain', 'wrong gain of the force sensor', [FORCE_GAIN], .true., &
                          'All forces were larger or smaller than stated, by one factor.', '')
    call enter_instrument(c, e, 'force_offset', 'zero error of the force sensor', [FORCE_OFFSET], .true., &
                          'The same force was added to every force that is stated.', needs_levels(e))
    call enter_instrument(c, e, 'force_direction', 'forces that were not upright', &
                          [FORCE_TILT_X, FORCE_TILT_Y], .true., &
                          'All forces leaned to one side.', '')
    if (size(e%model%triangles) > 0) &
      call enter_instrument(c, e, 'load_position', 'forces beside the stated places', [LOAD_SHIFT_X, LOAD_SHIFT_Y], &
                            .true., 'All forces acted at a distance from the stated places, the same for all.', '')
    call enter_instrument(c, e, 'height_scale', 'wrong scale of the heights', [HEIGHT_SCALE], .true., &
                          'All heights were larger or smaller than stated, by one factor.', '')
    call enter_instrument(c, e, 'scan_plane', 'tilted or lifted scans', [TILT_X, TILT_Y, PISTON], .true., &
                          'All loaded scans were tilted or lifted against the unloaded one, in the same way.', '')
    call enter_instrument(c, e, 'registration', 'shifted or turned maps', [MAP_SHIFT_X, MAP_SHIFT_Y, MAP_ROTATION, &
                                                                           MAP_SCALE], .true., &
                          'The wing lay elsewhere, turned or magnified in the height maps than the file says.', '')
    call enter_instrument(c, e, 'drift', 'a wing that changed during the experiment', [DRIFT], .true., &
                          'The wing became stiffer (it dried) or softer from one measurement to the next.', '')
    call enter_instrument(c, e, 'drift_in_time', 'a wing that changed with time', [DRIFT_RATE], .true., &
                          'The wing became stiffer (it dried) or softer with time.', '')
    call enter_instrument(c, e, 'creep', 'creep under load', [CREEP], .false., &
                          'The wing went on bending while the force was held.', needs_holds(e))
  end subroutine enter_measurement

  !> Enters parameters of the instrument, released together.
  subroutine enter_instrument(c, e, name, title, numbers, is_measurement, sentence, missing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    character(*), intent(in) :: name, title, sentence, missing
    integer, intent(in) :: numbers(:)
    logical, intent(in) :: is_measurement
    type(variant_t), allocatable :: variants(:)
    character(:), allocatable :: lacking
    type(parameter_t) :: p
    type(quantity_t) :: quantity
    integer, allocatable :: columns(:)
    integer :: i
    lacking = missing
    allocate (columns(size(numbers)), variants(0))
    do i = 1, size(numbers)
      if (lacking == '') lacking = missing_for(numbers(i), e%measurement)
      p = e%instrument%describe(numbers(i))
      quantity%name = p%name
      quantity%unit = p%unit
      quantity%is_log = p%is_log
      quantity%null = merge(log(max(p%null, tiny(1.0_rp))), p%null, p%is_log)
      quantity%lower = merge(log(max(p%lower, tiny(1.0_rp))), p%lower, p%is_log)
      quantity%upper = merge(log(max(p%upper, tiny(1.0_rp))), p%upper, p%is_log)
      ! Beyond what is declared, which is a nuisance already.
      quantity%prior_sd = max(p%prior_sd, 0.05_rp*(quantity%upper - quantity%lower))
      columns(i) = c%add_quantity(quantity, wing_quantity_t(kind=KIND_INSTRUMENT, number=numbers(i)))
    end do
    call append(variants, '', 0, [0.0_rp, 0.0_rp])
    variants(1)%columns = columns
    call c%enter(name, title, sentence, is_measurement, lacking, variants)
  end subroutine enter_instrument

  !> What is missing for creep.
  function needs_holds(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    missing = ''
    associate (hold => e%measurement%loads%hold)
      if (any(hold < 0)) then
        missing = 'needs the hold of all loads'
      else if (maxval(hold) < 1.5_rp*minval(hold)) then
        missing = 'needs two times of holding that differ'
      end if
    end associate
  end function needs_holds

  !> What is missing where every place was loaded with one force only.
  function needs_levels(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    integer :: i, k
    missing = 'needs two forces at one place'
    associate (loads => e%measurement%loads)
      do i = 1, size(loads)
        do k = 1, i - 1
          if (norm2(loads(i)%point - loads(k)%point) < 0.02_rp*e%model%size .and. &
              abs(loads(i)%force - loads(k)%force) > 0.05_rp*loads(k)%force) missing = ''
        end do
      end do
    end associate
  end function needs_levels

  !> Adds a parameter and gives its number.
  integer function catalogue_add_quantity(self, quantity, kind) result(n)
    class(catalogue_t), intent(inout) :: self
    type(quantity_t), intent(in) :: quantity
    type(wing_quantity_t), intent(in) :: kind
    type(quantity_t), allocatable :: quantities(:)
    integer :: i
    n = size(self%kinds) + 1
    allocate (quantities(n))
    do i = 1, n - 1
      quantities(i) = self%quantities(i)
    end do
    quantities(n) = quantity
    call move_alloc(quantities, self%quantities)
    self%kinds = [self%kinds, kind]
    self%kinds(n)%null = quantity%null
  end function catalogue_add_quantity

  !> Adds a parameter of the wing, once; its null is where the wing has it.
  integer function catalogue_add_parameter(self, e, number) result(n)
    class(catalogue_t), intent(inout) :: self
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: number
    type(parameter_t) :: p
    type(quantity_t) :: quantity
    real(rp) :: value, lower, upper
    do n = 1, size(self%kinds)
      if (self%kinds(n)%kind == KIND_PARAMETER .and. self%kinds(n)%number == number) return
    end do
    p = e%model%params%describe(number)
    value = e%model%params%get(number)
    lower = p%lower
    upper = p%upper
    if (p%is_log) then
      value = log(value)
      lower = log(lower)
      upper = log(upper)
    end if
    quantity%name = p%name
    quantity%unit = p%unit
    quantity%is_log = p%is_log
    quantity%null = value
    quantity%prior_sd = merge(p%prior_sd, 1.0_rp, p%prior_sd > 0)
    quantity%lower = lower
    quantity%upper = upper
    n = self%add_quantity(quantity, wing_quantity_t(kind=KIND_PARAMETER, number=number))
  end function catalogue_add_parameter

  subroutine catalogue_enter(self, name, title, sentence, is_measurement, missing, variants)
    class(catalogue_t), intent(inout) :: self
    character(*), intent(in) :: name, title, sentence, missing
    logical, intent(in) :: is_measurement
    type(variant_t), intent(in) :: variants(:)
    type(effect_t), allocatable :: effects(:)
    integer :: i, n
    n = size(self%effects) + 1
    allocate (effects(n))
    do i = 1, n - 1
      effects(i) = self%effects(i)
    end do
    effects(n)%name = name
    effects(n)%title = title
    effects(n)%sentence = sentence
    effects(n)%is_measurement = is_measurement
    effects(n)%missing = missing
    allocate (effects(n)%variants(size(variants)))
    do i = 1, size(variants)
      effects(n)%variants(i) = variants(i)
    end do
    call move_alloc(effects, self%effects)
  end subroutine catalogue_enter

  !> Adds a variant with one parameter.
  subroutine append(variants, label, column, place)
    type(variant_t), allocatable, intent(inout) :: variants(:)
    character(*), intent(in) :: label
    integer, intent(in) :: column
    real(rp), intent(in) :: place(2)
    type(variant_t), allocatable :: longer(:)
    integer :: i
    allocate (longer(size(variants) + 1))
    do i = 1, size(variants)
      longer(i) = variants(i)
    end do
    longer(i)%label = label
    longer(i)%columns = [column]
    longer(i)%place = place
    call move_alloc(longer, variants)
  end subroutine append

  function percent(share) result(text)
    real(rp), intent(in) :: share
    character(:), allocatable :: text
    text = number_text(nint(100*share))//' % of its length'
  end function percent

  function millimetres(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    character(16) :: buffer
    write (buffer, '(f12.1)') 1000*x
    text = trim(adjustl(buffer))
  end function millimetres
end module diagnosis_wing_catalogue
