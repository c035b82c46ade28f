! SPDX-License-Identifier: GPL-3.0-or-later
!> Summarises several individuals by the mean and the standard deviation of every parameter, as in the protocol of Truong et al.
!> It prints them on the terminal and writes NAME_individuals.csv. Only rank 0 uses it.
module train_summary
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_text, only: number_text
  use base_text_file, only: write_text
  use train_settings, only: train_settings_t
  use training_outcome, only: trained_t
  use training_space, only: search_space_t
  implicit none
  private
  public :: summary_t

  character(*), parameter :: NL = new_line('a')

  !> An entry holds one parameter of one individual.
  type :: entry_t
    character(:), allocatable :: individual, name, unit
    real(rp) :: value = 0, lower = 0, upper = 0
    logical :: has_lower = .false., has_upper = .false.
    logical :: counts = .true. !< it counts in means: the data determine it, or no uncertainty was asked for
  end type entry_t

  type :: summary_t
    type(entry_t), allocatable, private :: entries(:)
    character(:), allocatable, private :: path, untrained
    integer, private :: n_individuals = 0, n_untrained = 0
  contains
    procedure :: add => summary_add
    procedure :: write => summary_write
  end type summary_t

contains

  !> Adds an individual. Without `has_outcome` it counts as not trained.
  subroutine summary_add(self, settings, space, trained, has_outcome)
    class(summary_t), intent(inout) :: self
    type(train_settings_t), intent(in) :: settings
    type(search_space_t), intent(in) :: space
    type(trained_t), intent(in) :: trained
    logical, intent(in) :: has_outcome
    type(entry_t) :: one
    integer :: i
    if (.not. allocated(self%entries)) then
      allocate (self%entries(0))
      self%untrained = ''
    end if
    self%path = settings%choices%name//'_individuals.csv'
    self%n_individuals = self%n_individuals + 1
    if (.not. has_outcome) then
      self%n_untrained = self%n_untrained + 1
      self%untrained = self%untrained//' '//settings%individual
      return
    end if
    do i = 1, size(trained%values)
      one = entry_t()
      one%individual = settings%individual
      one%name = trim(space%names(i))
      one%unit = trim(space%units(i))
      one%value = trained%values(i)
      if (trained%has_intervals) then
        associate (interval => trained%intervals(i))
          one%has_lower = interval%has_lower
          one%has_upper = interval%has_upper
          one%lower = interval%lower
          one%upper = interval%upper
          if (space%is_log(i)) one%lower = exp(one%lower)
          if (space%is_log(i)) one%upper = exp(one%upper)
        end associate
      end if
      one%counts = trained%determines(i)
      self%entries = [self%entries, one]
    end do
  end subroutine summary_add

  !> Prints the table and writes the file. Fails if the file cannot be written.
  subroutine summary_write(self, failure)
    class(summary_t), intent(in) :: self
    type(failure_t), intent(inout) :: failure
    character(:), allocatable :: text
    character(160) :: line
    real(rp), allocatable :: values(:)
    real(rp) :: mean, sd
    integer :: i
    if (.not. allocated(self%entries)) return
    write (line, '(a24,a10,3a14,a28)') 'parameter               ', 'unit      ', 'mean', 'sd', 'sd/mean', &
      'determined in'
    write (output_unit, '(a)') '', 'over individuals', trim(line)
    text = '% individual, parameter, unit, value (empty: not determined), '// &
           'lower, upper (90 % interval; empty: no end)'//NL
    do i = 1, size(self%entries)
      associate (e => self%entries(i))
        text = text//e%individual//','//e%name//','//e%unit//','//end_text(e%counts, e%value)//','// &
               end_text(e%has_lower, e%lower)//','//end_text(e%has_upper, e%upper)//NL
      end associate
    end do
    do i = 1, size(self%entries)
      if (.not. is_first(self, i)) cycle
      values = values_of(self, self%entries(i)%name)
      call moments(values, mean, sd)
      associate (e => self%entries(i))
        write (line, '(a24,a10)') e%name//repeat(' ', max(0, 24 - len(e%name))), e%unit//repeat(' ', 10)
        if (size(values) > 0) write (line(35:48), '(es14.5)') mean
        if (size(values) > 1) write (line(49:76), '(es14.5,f14.4)') sd, sd/abs(mean)
        write (line(77:), '(i12,a,i0)') size(values), ' of ', self%n_individuals
        write (output_unit, '(a)') trim(line)
        if (size(values) > 0) text = text//'mean,'//e%name//','//e%unit//','//number_text(mean)//',,'//NL
        if (size(values) > 1) text = text//'sd,'//e%name//','//e%unit//','//number_text(sd)//',,'//NL
      end associate
    end do
    if (self%n_untrained > 0) write (output_unit, '(a)') 'not trained:'//self%untrained
    flush (output_unit)
    call write_text(self%path, text(:len(text) - 1), failure)
  end subroutine summary_write

  !> Tells whether entry i is the first one of its parameter.
  pure logical function is_first(self, i)
    class(summary_t), intent(in) :: self
    integer, intent(in) :: i
    integer :: k
    is_first = .true.
    do k = 1, i - 1
      is_first = is_first .and. self%entries(k)%name /= self%entries(i)%name
    end do
  end function is_first

  !> Returns the values that count for the mean of a parameter.
  pure function values_of(self, name) result(values)
    class(summary_t), intent(in) :: self
    character(*), intent(in) :: name
    real(rp), allocatable :: values(:)
    integer :: i
    allocate (values(0))
    do i = 1, size(self%entries)
      if (self%entries(i)%name == name .and. self%entries(i)%counts) values = [values, self%entries(i)%value]
    end do
  end function values_of

  !> Returns the mean and the standard deviation of a sample (divisor n - 1).
  pure subroutine moments(values, mean, sd)
    real(rp), intent(in) :: values(:)
    real(rp), intent(out) :: mean, sd
    mean = sum(values)/max(1, size(values))
    sd = sqrt(sum((values - mean)**2)/max(1, size(values) - 1))
  end subroutine moments

  !> Returns the end of an interval as text, or an empty text if the interval is open there.
  function end_text(has_end, value) result(text)
    logical, intent(in) :: has_end
    real(rp), intent(in) :: value
    character(:), allocatable :: text
    text = ''
    if (has_end) text = number_text(value)
  end function end_text
end module train_summary
