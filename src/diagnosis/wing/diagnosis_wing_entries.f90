! SPDX-License-Identifier: GPL-3.0-or-later
!> Builds the entries of the catalogue from parameters of the wing or of the instrument that are released together or one after
!> another.
module diagnosis_wing_entries
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use base_text, only: number_text
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_INSTRUMENT, KIND_PARAMETER
  use inference_simulator, only: effect_t, variant_t
  use measurement_experiment, only: experiment_t
  use measurement_instrument, only: missing_for
  use solid_effect, only: effect_text_t
  implicit none
  private
  public :: catalogue_t, append_variant, enter_named, enter_instrument, percent, millimetres

  !> Parameters and effects of a diagnosis; the first n_baseline parameters are those of the baseline.
  type :: catalogue_t
    integer :: n_baseline = 0
    type(wing_parameter_t), allocatable :: parameters(:) !< by their coordinates
    type(effect_t), allocatable :: effects(:)
  contains
    procedure :: add => catalogue_add
    procedure :: add_parameter => catalogue_add_parameter
    procedure :: enter => catalogue_enter
  end type catalogue_t

contains

  !> Enters the effect of this text, with the parameters that match one of `names` (NAME or NAME:*), released together if
  !> `is_joint`, else one after another. It is not testable if `missing` says what the data lack, if the wing has no such
  !> parameter, or if the baseline seeks it as one of the parameters `numbers`.
  subroutine enter_named(c, e, numbers, text, names, is_joint, missing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    type(effect_text_t), intent(in) :: text !< its cause, title and sentence
    character(*), intent(in) :: names(:), missing
    logical, intent(in) :: is_joint
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
        if (is_joint) cycle
        call append_variant(variants, p%name(index(p%name, ':') + 1:), n, [0.0_rp, 0.0_rp])
      end do
    end do
    if (size(columns) == 0) then
      call c%enter(text%cause, text%title, text%sentence, .false., lacks_parameters(e, numbers, names(1)), variants)
      return
    end if
    if (is_joint) then
      call append_variant(variants, '', 0, [0.0_rp, 0.0_rp])
      variants(1)%columns = columns
    end if
    call c%enter(text%cause, text%title, text%sentence, .false., missing, variants)
  end subroutine enter_named

  !> Returns why no parameter that matches `name` can be released.
  function lacks_parameters(e, numbers, name) result(missing)
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    character(*), intent(in) :: name
    character(:), allocatable :: missing
    type(parameter_t) :: p
    integer :: i, n
    n = index(name//'*', '*') - 1
    missing = 'the wing has no such part'
    do i = 1, size(numbers)
      p = e%model%params%describe(numbers(i))
      if (index(p%name//' ', trim(name(:n))) == 1) missing = 'it is a free parameter of the baseline'
    end do
  end function lacks_parameters

  !> Enters parameters of the instrument, released together. `missing` says what the data lack, if that is known.
  subroutine enter_instrument(c, e, name, title, numbers, is_measurement, sentence, missing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    character(*), intent(in) :: name, title, sentence, missing
    integer, intent(in) :: numbers(:)
    logical, intent(in) :: is_measurement
    type(variant_t), allocatable :: variants(:)
    character(:), allocatable :: lacking
    type(parameter_t) :: p
    integer, allocatable :: columns(:)
    integer :: i
    lacking = missing
    allocate (columns(size(numbers)), variants(0))
    do i = 1, size(numbers)
      if (lacking == '') lacking = missing_for(numbers(i), e%measurement)
      p = e%instrument%describe(numbers(i))
      p = p%as_coordinate(e%instrument%get(numbers(i))) ! null is where the input has it
      ! Beyond what is declared, which is a nuisance already.
      p%prior_sd = max(p%prior_sd, 0.05_rp*(p%upper - p%lower))
      columns(i) = c%add(wing_parameter(p, KIND_INSTRUMENT, numbers(i)))
    end do
    call append_variant(variants, '', 0, [0.0_rp, 0.0_rp])
    variants(1)%columns = columns
    call c%enter(name, title, sentence, is_measurement, lacking, variants)
  end subroutine enter_instrument

  !> Adds a parameter and returns its number.
  integer function catalogue_add(self, parameter) result(n)
    class(catalogue_t), intent(inout) :: self
    type(wing_parameter_t), intent(in) :: parameter
    type(wing_parameter_t), allocatable :: parameters(:)
    integer :: i
    n = size(self%parameters) + 1
    allocate (parameters(n))
    do i = 1, n - 1
      parameters(i) = self%parameters(i)
    end do
    parameters(n) = parameter
    call move_alloc(parameters, self%parameters)
  end function catalogue_add

  !> Adds a parameter of the wing, once, and returns its number. Its null is where the wing has it.
  integer function catalogue_add_parameter(self, e, number) result(n)
    class(catalogue_t), intent(inout) :: self
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: number
    type(parameter_t) :: p
    do n = 1, size(self%parameters)
      if (self%parameters(n)%kind == KIND_PARAMETER .and. self%parameters(n)%number == number) return
    end do
    p = e%model%params%describe(number)
    p = p%as_coordinate(e%model%params%get(number))
    if (.not. p%prior_sd > 0) p%prior_sd = 1
    n = self%add(wing_parameter(p, KIND_PARAMETER, number))
  end function catalogue_add_parameter

  !> Enters an effect with its texts and variants. An empty `missing` makes it testable.
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
  subroutine append_variant(variants, label, column, site)
    type(variant_t), allocatable, intent(inout) :: variants(:)
    character(*), intent(in) :: label
    integer, intent(in) :: column
    real(rp), intent(in) :: site(2)
    type(variant_t), allocatable :: longer(:)
    integer :: i
    allocate (longer(size(variants) + 1))
    do i = 1, size(variants)
      longer(i) = variants(i)
    end do
    longer(i)%label = label
    longer(i)%columns = [column]
    longer(i)%site = site
    call move_alloc(longer, variants)
  end subroutine append_variant

  !> Returns the fraction as words: '25 % of its length'.
  function percent(fraction) result(text)
    real(rp), intent(in) :: fraction
    character(:), allocatable :: text
    text = number_text(nint(100*fraction))//' % of its length'
  end function percent

  !> Returns a length [m] as text in millimetres, with one decimal.
  function millimetres(x) result(text)
    real(rp), intent(in) :: x
    character(:), allocatable :: text
    character(16) :: buffer
    write (buffer, '(f12.1)') 1000*x
    text = trim(adjustl(buffer))
  end function millimetres
end module diagnosis_wing_entries
