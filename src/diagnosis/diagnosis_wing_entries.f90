! SPDX-License-Identifier: GPL-3.0-or-later
!> Entries of the catalogue of a wing and a measurement, and how they are made: parameters that are released together or
!> one after another, of the wing or of the instrument.
module diagnosis_wing_entries
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnosis_wing_quantities, only: wing_quantity_t, KIND_INSTRUMENT, KIND_PARAMETER
  use inference_simulator, only: effect_t, quantity_t, variant_t
  use measurement_experiment, only: experiment_t
  use measurement_instrument, only: missing_for
  use solid_params, only: parameter_t
  implicit none
  private
  public :: catalogue_t, append_variant, enter_named, enter_instrument, percent, millimetres

  !> Parameters and effects of a diagnosis; the first n_baseline parameters are those of the baseline.
  type :: catalogue_t
    integer :: n_baseline = 0
    type(quantity_t), allocatable :: quantities(:)
    type(wing_quantity_t), allocatable :: kinds(:)
    type(effect_t), allocatable :: effects(:)
  contains
    procedure :: add_quantity => catalogue_add_quantity
    procedure :: add_parameter => catalogue_add_parameter
    procedure :: enter => catalogue_enter
  end type catalogue_t

contains

  !> Enters the parameters that match one of `names` (NAME or NAME:*), released together or one after another; as not
  !> testable if the wing has none of them or the baseline seeks them.
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
        call append_variant(variants, p%name(index(p%name, ':') + 1:), n, [0.0_rp, 0.0_rp])
      end do
    end do
    if (size(columns) == 0) then
      call c%enter(name, title, sentence, .false., lacks_parameters(e, numbers, names(1)), variants)
      return
    end if
    if (is_together) then
      call append_variant(variants, '', 0, [0.0_rp, 0.0_rp])
      variants(1)%columns = columns
    end if
    call c%enter(name, title, sentence, .false., missing, variants)
  end subroutine enter_named

  !> Why no parameter that matches `name` can be released.
  function lacks_parameters(e, numbers, name) result(missing)
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    character(*), intent(in) :: name
    character(:), allocatable :: missing
    type(parameter_t) :: p
    integer :: i, n
    n = index(name//'*', '*') - 1
    missing = 'the wing has nothing of the kind'
    do i = 1, size(numbers)
      p = e%model%params%describe(numbers(i))
      if (index(p%name//' ', trim(name(:n))) == 1) missing = 'the baseline seeks it'
    end do
  end function lacks_parameters

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
    real(rp) :: value
    integer :: i
    lacking = missing
    allocate (columns(size(numbers)), variants(0))
    do i = 1, size(numbers)
      if (lacking == '') lacking = missing_for(numbers(i), e%measurement)
      p = e%instrument%describe(numbers(i))
      quantity%name = p%name
      quantity%unit = p%unit
      quantity%is_log = p%is_log
      value = e%instrument%get(numbers(i)) ! where the input has it
      quantity%null = merge(log(max(value, tiny(1.0_rp))), value, p%is_log)
      quantity%lower = merge(log(max(p%lower, tiny(1.0_rp))), p%lower, p%is_log)
      quantity%upper = merge(log(max(p%upper, tiny(1.0_rp))), p%upper, p%is_log)
      ! Beyond what is declared, which is a nuisance already.
      quantity%prior_sd = max(p%prior_sd, 0.05_rp*(quantity%upper - quantity%lower))
      columns(i) = c%add_quantity(quantity, wing_quantity_t(kind=KIND_INSTRUMENT, number=numbers(i)))
    end do
    call append_variant(variants, '', 0, [0.0_rp, 0.0_rp])
    variants(1)%columns = columns
    call c%enter(name, title, sentence, is_measurement, lacking, variants)
  end subroutine enter_instrument

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
    quantity%strong = p%strong
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
  subroutine append_variant(variants, label, column, place)
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
  end subroutine append_variant

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
end module diagnosis_wing_entries
