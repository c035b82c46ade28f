! SPDX-License-Identifier: GPL-3.0-or-later
!> Builds the entries of the catalogue from parameters of the wing or of the instrument that are released together or one after
!> another.
module diagnosis_wing_entries
  use base_cause, only: cause_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use base_text, only: number_text
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_INSTRUMENT, KIND_PARAMETER
  use inference_simulator, only: effect_t, variant_t
  use measurement_experiment, only: experiment_t
  use measurement_instrument, only: missing_for
  use solid_usual_causes, only: PARAM_PLATE, PARAM_THICKNESS
  implicit none
  private
  public :: catalogue_t, append_variant, enter_structural, enter_instrument, percent, millimetres

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

  !> Enters a cause with those of its parameters that the wing has, released together or one after another. A parameter whose name
  !> ends with a colon is one for each part. The cause is not testable if `missing` says what the data lack, if the wing has no such
  !> parameter, or if the baseline fits it as one of the parameters `numbers`. `thickness` is D by another name.
  subroutine enter_structural(c, e, numbers, cause, missing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    type(cause_t), intent(in) :: cause
    character(*), intent(in) :: missing
    type(parameter_t) :: p
    type(variant_t), allocatable :: variants(:)
    integer, allocatable :: columns(:)
    integer :: i, k, n
    allocate (variants(0), columns(0))
    do i = 1, e%model%params%count()
      if (any(numbers == i) .or. i == PARAM_PLATE .and. any(numbers == PARAM_THICKNESS)) cycle
      p = e%model%params%describe(i)
      do k = 1, size(cause%parameters)
        if (.not. has_name(p%name, cause%parameters(k)%value%name)) cycle
        n = c%add_parameter(e, i)
        columns = [columns, n]
        if (cause%is_joint) cycle
        call append_variant(variants, p%name(index(p%name, ':') + 1:), n, [0.0_rp, 0.0_rp])
      end do
    end do
    if (size(columns) == 0) then
      call c%enter(cause, lacks_parameters(e, numbers, cause%parameters(1)%value%name), variants)
      return
    end if
    if (cause%is_joint) then
      call append_variant(variants, '', 0, [0.0_rp, 0.0_rp])
      variants(1)%columns = columns
    end if
    call c%enter(cause, missing, variants)
  end subroutine enter_structural

  !> Tells whether `parameter` has this name or, if the name ends with a colon, is one of the parameters of parts.
  pure logical function has_name(parameter, name)
    character(*), intent(in) :: parameter, name
    has_name = parameter == name
    if (name(len(name):) == ':') has_name = index(parameter, name) == 1
  end function has_name

  !> Returns why no parameter that matches `name` can be released.
  function lacks_parameters(e, numbers, name) result(missing)
    type(experiment_t), intent(in) :: e
    integer, intent(in) :: numbers(:)
    character(*), intent(in) :: name
    character(:), allocatable :: missing
    type(parameter_t) :: p
    integer :: i
    missing = 'the wing has no such part'
    do i = 1, size(numbers)
      p = e%model%params%describe(merge(PARAM_PLATE, numbers(i), numbers(i) == PARAM_THICKNESS))
      if (index(p%name, name) == 1) missing = 'it is a free parameter of the baseline'
    end do
  end function lacks_parameters

  !> Enters a cause of the instrument, whose parameters are released together. `missing` says what the data lack, if that is known.
  subroutine enter_instrument(c, e, cause, missing)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(cause_t), intent(in) :: cause
    character(*), intent(in) :: missing
    type(variant_t), allocatable :: variants(:)
    character(:), allocatable :: lacking
    type(parameter_t) :: p
    integer, allocatable :: columns(:), numbers(:)
    integer :: i
    lacking = missing
    numbers = cause%tried()
    allocate (columns(size(numbers)), variants(0))
    do i = 1, size(numbers)
      if (lacking == '') lacking = missing_for(numbers(i), e%measurement)
      p = e%instrument%describe(numbers(i))
      p = p%as_coordinate(e%instrument%get(numbers(i))) ! its null is its value in the input
      ! The prior covers values beyond the declared error, which is a nuisance already.
      p%prior_sd = max(p%prior_sd, 0.05_rp*(p%upper - p%lower))
      columns(i) = c%add(wing_parameter(p, KIND_INSTRUMENT, numbers(i)))
    end do
    call append_variant(variants, '', 0, [0.0_rp, 0.0_rp])
    variants(1)%columns = columns
    call c%enter(cause, lacking, variants)
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

  !> Adds a parameter of the wing, once, and returns its number. Its null is the value that the wing has.
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

  !> Enters a cause with its variants. An empty `missing` makes it testable.
  subroutine catalogue_enter(self, cause, missing, variants)
    class(catalogue_t), intent(inout) :: self
    type(cause_t), intent(in) :: cause
    character(*), intent(in) :: missing
    type(variant_t), intent(in) :: variants(:)
    type(effect_t), allocatable :: effects(:)
    integer :: i, n
    n = size(self%effects) + 1
    allocate (effects(n))
    do i = 1, n - 1
      effects(i) = self%effects(i)
    end do
    effects(n)%name = cause%name
    effects(n)%title = cause%title
    effects(n)%sentence = cause%sentence
    effects(n)%is_measurement = cause%is_measurement
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
