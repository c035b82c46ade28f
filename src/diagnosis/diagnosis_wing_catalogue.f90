! SPDX-License-Identifier: GPL-3.0-or-later
!> The catalogue: what a simulation of a bending test may lack, one entry for each effect, with a sentence for people, the
!> parameters that it releases, the positions at which it is tried, and what data it needs to show.
module diagnosis_wing_catalogue
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnosis_simulator, only: effect_t, quantity_t, variant_t
  use diagnosis_wing_quantities, only: wing_quantity_t, KIND_CREEP, KIND_DAMAGE, KIND_DRIFT, KIND_GAIN, KIND_LEAN_X, &
                                       KIND_LEAN_Y, KIND_OFFSET, KIND_PARAMETER, KIND_SCALE, KIND_SOFT, KIND_ZERO
  use diagnosis_wing_task, only: wing_patterns_t
  use measurement_experiment, only: experiment_t
  use measurement_place, only: find_place
  use solid_layout, only: hinge_in_vein
  use solid_params, only: parameter_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: catalogue_t, make_catalogue, make_patterns

  real(rp), parameter :: DECADE = 2.302585092994046_rp
  real(rp), parameter :: DAMAGE_RADIUS = 0.1_rp, DAMAGE_SPACING = 0.12_rp, PATTERN_RADIUS = 0.16_rp !< of the wing's size

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
                                 wing_quantity_t(kind=KIND_ZERO, number=i, is_log=.false.))
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
    call enter_named(c, e, numbers, 'joint_hardening', 'joints that harden', [character(20) :: 'joint_hardening'], .true., &
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
        if (names(k)(n:n) == '*') then
          if (index(p%name, names(k)(:n - 1)) /= 1) cycle
        else if (p%name /= names(k)) then
          cycle
        end if
        n = c%add_parameter(e, i)
        columns = [columns, n]
        if (is_together) cycle
        variants = [variants, variant_t(p%name(index(p%name, ':') + 1:), [n])]
      end do
    end do
    if (size(columns) == 0) return
    if (is_together) variants = [variant_t('', columns)]
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
          variants = [variants, variant_t(wing%veins(v)%name//' at '//percent(kind%share), [n], &
                                          wing%points(:2, nodes(k)))]
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
      variants = [variants, variant_t('around ('//millimetres(places(1, k))//', '//millimetres(places(2, k))//') mm', &
                                      [n], places(:, k))]
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
    character(:), allocatable :: order, hold
    integer :: n, m
    order = ''
    hold = ''
    associate (loads => e%measurement%loads)
      if (any(loads%order <= 0) .or. size(loads) < 3) order = 'the order of the measurements'
      if (any(loads%hold < 0)) then
        hold = 'times of holding'
      else if (maxval(loads%hold) < 1.5_rp*minval(loads%hold)) then
        hold = 'two times of holding that differ'
      end if
    end associate
    n = c%add_quantity(quantity_t('force_gain', '1', .true., 0.0_rp, 0.3_rp, -1.0_rp, 1.0_rp), &
                       wing_quantity_t(kind=KIND_GAIN))
    call c%enter('force_gain', 'wrong gain of the force sensor', &
                 'All forces were larger or smaller than stated, by one factor.', .true., '', [variant_t('', [n])])
    n = c%add_quantity(quantity_t('force_offset', 'N', .false., 0.0_rp, 0.3_rp*maxval(e%measurement%loads%force), &
                                  -maxval(e%measurement%loads%force), maxval(e%measurement%loads%force)), &
                       wing_quantity_t(kind=KIND_OFFSET, is_log=.false.))
    call c%enter('force_offset', 'zero error of the force sensor', &
                 'The same force was added to every force that is stated.', .true., needs_levels(e), [variant_t('', [n])])
    n = c%add_quantity(quantity_t('height_scale', '1', .true., 0.0_rp, 0.3_rp, -1.0_rp, 1.0_rp), &
                       wing_quantity_t(kind=KIND_SCALE))
    call c%enter('height_scale', 'wrong scale of the heights', &
                 'All heights were larger or smaller than stated, by one factor.', .true., '', [variant_t('', [n])])
    n = c%add_quantity(quantity_t('drift', '1', .true., 0.0_rp, 0.3_rp, -2.0_rp, 2.0_rp), &
                       wing_quantity_t(kind=KIND_DRIFT))
    call c%enter('drift', 'a wing that changed during the experiment', &
                 'The wing became stiffer (it dried) or softer from one measurement to the next.', .true., order, &
                 [variant_t('', [n])])
    n = c%add_quantity(quantity_t('creep', '1', .true., 0.0_rp, 0.3_rp, -2.0_rp, 2.0_rp), &
                       wing_quantity_t(kind=KIND_CREEP))
    call c%enter('creep', 'creep under load', &
                 'The wing went on bending while the force was held.', .false., hold, [variant_t('', [n])])
    n = c%add_quantity(quantity_t('force_lean_x', 'rad', .false., 0.0_rp, 0.1_rp, -0.5_rp, 0.5_rp), &
                       wing_quantity_t(kind=KIND_LEAN_X, is_log=.false.))
    m = c%add_quantity(quantity_t('force_lean_y', 'rad', .false., 0.0_rp, 0.1_rp, -0.5_rp, 0.5_rp), &
                       wing_quantity_t(kind=KIND_LEAN_Y, is_log=.false.))
    call c%enter('force_direction', 'forces that were not upright', &
                 'All forces leaned to one side.', .true., '', [variant_t('', [n, m])])
  end subroutine enter_measurement

  !> What is missing where every place was loaded with one force only.
  function needs_levels(e) result(missing)
    type(experiment_t), intent(in) :: e
    character(:), allocatable :: missing
    integer :: i, k
    missing = 'two forces at one place'
    associate (loads => e%measurement%loads)
      do i = 1, size(loads)
        do k = 1, i - 1
          if (norm2(loads(i)%point - loads(k)%point) < 0.02_rp*e%model%size .and. &
              abs(loads(i)%force - loads(k)%force) > 0.05_rp*loads(k)%force) missing = ''
        end do
      end do
    end associate
  end function needs_levels

  !> Places of unknown causes.
  subroutine make_patterns(experiment, wing, patterns)
    type(experiment_t), intent(in) :: experiment
    type(wing_t), intent(in) :: wing
    type(wing_patterns_t), intent(out) :: patterns
    patterns%radius = PATTERN_RADIUS*experiment%model%size
    call lattice(wing, experiment%model%size, PATTERN_RADIUS, patterns%place)
  end subroutine make_patterns

  !> Points (2, n) [m] of a triangular lattice on the wing, their distance a share of its size.
  subroutine lattice(wing, length, share, places)
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: length, share
    real(rp), allocatable, intent(out) :: places(:, :)
    real(rp) :: place(2), low(2), high(2), spacing
    integer :: i, j
    spacing = share*length
    low = minval(wing%points(:2, :), 2)
    high = maxval(wing%points(:2, :), 2)
    allocate (places(2, 0))
    do j = 0, int((high(2) - low(2))/(0.866_rp*spacing)) + 1
      do i = 0, int((high(1) - low(1))/spacing) + 1
        place = low + [(i + 0.5_rp*modulo(j, 2))*spacing, (j + 0.25_rp)*0.866_rp*spacing]
        associate (found => find_place(wing%points, wing%triangles, length, place))
          if (found%is_found) places = reshape([places, place], [2, size(places, 2) + 1])
        end associate
      end do
    end do
  end subroutine lattice

  integer function catalogue_add_quantity(self, quantity, kind) result(n)
    class(catalogue_t), intent(inout) :: self
    type(quantity_t), intent(in) :: quantity
    type(wing_quantity_t), intent(in) :: kind
    self%quantities = [self%quantities, quantity]
    self%kinds = [self%kinds, kind]
    n = size(self%quantities)
    self%kinds(n)%null = quantity%null
  end function catalogue_add_quantity

  !> Adds a parameter of the wing, once; its null is where the wing has it.
  integer function catalogue_add_parameter(self, e, number) result(n)
    class(catalogue_t), intent(inout) :: self
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: number
    type(parameter_t) :: p
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
    n = self%add_quantity(quantity_t(p%name, p%unit, p%is_log, value, merge(p%prior_sd, 1.0_rp, p%prior_sd > 0), lower, &
                                     upper), &
                          wing_quantity_t(kind=KIND_PARAMETER, number=number, is_log=p%is_log))
  end function catalogue_add_parameter

  subroutine catalogue_enter(self, name, title, sentence, is_measurement, missing, variants)
    class(catalogue_t), intent(inout) :: self
    character(*), intent(in) :: name, title, sentence, missing
    logical, intent(in) :: is_measurement
    type(variant_t), intent(in) :: variants(:)
    type(effect_t) :: effect
    effect%name = name
    effect%title = title
    effect%sentence = sentence
    effect%is_measurement = is_measurement
    effect%missing = missing
    effect%variants = variants
    self%effects = [self%effects, effect]
  end subroutine catalogue_enter

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
