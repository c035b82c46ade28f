! SPDX-License-Identifier: GPL-3.0-or-later
!> Defines the record of a cause: what a simulation or a measurement may get wrong. It has the cause's name, its texts for people,
!> what it needs, and its parameters with units, ranges, priors and words. The module that knows a cause makes its record in one
!> function and lists it in one line. The catalogue of the diagnosis, reports and the documents use these records.
module base_cause
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use base_wording, only: wording_t
  implicit none
  private
  public :: cause_t, cause_parameter_t, make_cause, enlist, append, find_parameter, find_wording, parameter_of

  integer, parameter, public :: LAST_PLACE = huge(1) !< in the catalogue: behind all that have a place

  type :: cause_parameter_t
    type(parameter_t) :: value                 !< name, unit, scale, bounds, null, prior. NAME: is one for each of several parts
    integer :: number = 0                      !< by which its module knows it
    logical :: is_tried = .true.               !< a diagnosis releases it for this cause
    character(:), allocatable :: scale         !< what the bounds are multiples of, for documents; empty: of its unit
    character(:), allocatable :: prior_scale   !< the same of the prior sd
    type(wording_t) :: words                   !< @ is the part or the place
    type(wording_t) :: beyond                  !< for values of at least `far`
    real(rp) :: far = huge(1.0_rp)
  end type cause_parameter_t

  type :: cause_t
    character(:), allocatable :: name           !< in catalogues and files
    character(:), allocatable :: title, sentence
    character(:), allocatable :: data            !< that it needs to show, for documents
    character(:), allocatable :: definition      !< of an effect, with its equation, for documents
    character(:), allocatable :: confused        !< what an effect may be confused with, for documents
    logical :: is_measurement = .false.          !< an error of the measurement, not of the simulation
    logical :: is_joint = .true.                 !< its parameters are released together, else one after another
    integer :: place = LAST_PLACE                !< in the catalogue; equal places are in the order of the list
    integer, allocatable :: needs(:)             !< constants NEED_* of its layer; the first missing one is reported
    type(cause_parameter_t), allocatable :: parameters(:)
  contains
    procedure :: add => cause_add
    procedure :: add_told => cause_add_told
    procedure :: tried => cause_tried
  end type cause_t

contains

  !> Returns a cause that needs nothing and has no parameters. Its definition and what it may be confused with are empty.
  pure function make_cause(name, title, sentence, data) result(cause)
    character(*), intent(in) :: name, title, sentence, data
    type(cause_t) :: cause
    cause%name = name
    cause%title = title
    cause%sentence = sentence
    cause%data = data
    cause%definition = ''
    cause%confused = ''
    allocate (cause%needs(0), cause%parameters(0))
  end function make_cause

  !> Adds a parameter, which has no words yet. `scale` says what its bounds are multiples of, and `prior_scale` the same of its
  !> prior; without it that is `scale`.
  pure subroutine cause_add(self, number, value, scale, prior_scale)
    class(cause_t), intent(inout) :: self
    integer, intent(in) :: number
    type(parameter_t), intent(in) :: value
    character(*), intent(in), optional :: scale, prior_scale
    type(cause_parameter_t) :: one
    one%number = number
    one%value = value
    one%scale = ''
    if (present(scale)) one%scale = scale
    one%prior_scale = one%scale
    if (present(prior_scale)) one%prior_scale = prior_scale
    call self%add_told(one)
  end subroutine cause_add

  !> Adds a parameter with its words.
  pure subroutine cause_add_told(self, one)
    class(cause_t), intent(inout) :: self
    type(cause_parameter_t), intent(in) :: one
    type(cause_parameter_t), allocatable :: longer(:)
    integer :: i
    allocate (longer(size(self%parameters) + 1))
    do i = 1, size(self%parameters)
      longer(i) = self%parameters(i)
    end do
    longer(size(longer)) = one
    call move_alloc(longer, self%parameters)
  end subroutine cause_add_told

  !> Returns the numbers of the parameters that a diagnosis releases.
  pure function cause_tried(self) result(numbers)
    class(cause_t), intent(in) :: self
    integer, allocatable :: numbers(:)
    numbers = pack(self%parameters%number, self%parameters%is_tried)
  end function cause_tried

  !> Appends a cause to a list; a list that is not allocated is empty.
  pure subroutine enlist(list, cause)
    type(cause_t), allocatable, intent(inout) :: list(:)
    type(cause_t), intent(in) :: cause
    type(cause_t), allocatable :: longer(:)
    integer :: i, n
    n = 0
    if (allocated(list)) n = size(list)
    allocate (longer(n + 1))
    do i = 1, n
      call move(list(i), longer(i))
    end do
    longer(n + 1) = cause
    call move_alloc(longer, list)
  end subroutine enlist

  !> Appends the causes `more`, which are gone then, to a list; a list that is not allocated is empty.
  pure subroutine append(list, more)
    type(cause_t), allocatable, intent(inout) :: list(:), more(:)
    type(cause_t), allocatable :: longer(:)
    integer :: i, n
    n = 0
    if (allocated(list)) n = size(list)
    allocate (longer(n + size(more)))
    do i = 1, n
      call move(list(i), longer(i))
    end do
    do i = 1, size(more)
      call move(more(i), longer(n + i))
    end do
    call move_alloc(longer, list)
    deallocate (more)
  end subroutine append

  !> Moves a cause without a copy of its texts and parameters.
  pure subroutine move(from, to)
    type(cause_t), intent(inout) :: from, to
    call move_alloc(from%name, to%name)
    call move_alloc(from%title, to%title)
    call move_alloc(from%sentence, to%sentence)
    call move_alloc(from%data, to%data)
    call move_alloc(from%definition, to%definition)
    call move_alloc(from%confused, to%confused)
    call move_alloc(from%needs, to%needs)
    call move_alloc(from%parameters, to%parameters)
    to%is_measurement = from%is_measurement
    to%is_joint = from%is_joint
    to%place = from%place
  end subroutine move

  !> Finds the first parameter with this number: its cause and its number k there, 0 and 0 if there is none.
  pure subroutine find_parameter(list, number, cause, k)
    type(cause_t), intent(in) :: list(:)
    integer, intent(in) :: number
    integer, intent(out) :: cause, k
    do cause = 1, size(list)
      do k = 1, size(list(cause)%parameters)
        if (list(cause)%parameters(k)%number == number) return
      end do
    end do
    cause = 0
    k = 0
  end subroutine find_parameter

  !> Returns the value of the first parameter with this number. It has no name if there is none.
  pure function parameter_of(list, number) result(p)
    type(cause_t), intent(in) :: list(:)
    integer, intent(in) :: number
    type(parameter_t) :: p
    integer :: cause, k
    call find_parameter(list, number, cause, k)
    if (cause > 0) p = list(cause)%parameters(k)%value
  end function parameter_of

  !> Returns the words for parameter `name` at `site` with a value of about `best`. `words%is_known` is false if no parameter has
  !> this name.
  pure subroutine find_wording(parameters, name, site, best, words)
    type(cause_parameter_t), intent(in) :: parameters(:)
    character(*), intent(in) :: name, site
    real(rp), intent(in) :: best
    type(wording_t), intent(out) :: words
    character(:), allocatable :: where
    integer :: k, n
    do k = 1, size(parameters)
      associate (one => parameters(k))
        n = len(one%value%name)
        where = site
        if (one%value%name(n:) == ':' .and. index(name, one%value%name) == 1) then
          where = name(n + 1:)
        else if (name /= one%value%name) then
          cycle
        end if
        words = one%words
        if (abs(best) >= one%far) words = one%beyond
        words%is_known = allocated(words%up)
        if (.not. words%is_known) return
        words%up = put(words%up, where)
        words%down = put(words%down, where)
        return
      end associate
    end do
  end subroutine find_wording

  !> Returns `text` with `where` in place of @.
  pure function put(text, where) result(filled)
    character(*), intent(in) :: text, where
    character(:), allocatable :: filled
    integer :: at
    filled = text
    at = index(text, '@')
    if (at > 0) filled = text(:at - 1)//where//text(at + 1:)
  end function put
end module base_cause
