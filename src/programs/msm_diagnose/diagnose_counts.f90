! SPDX-License-Identifier: GPL-3.0-or-later
!> Counts the observations of a diagnosis by kinds of data: how many there are, what they contribute to chi^2 of the baseline and
!> of the extended model, and how well both predict what was left out.
module diagnose_counts
  use base_decimal, only: fixed
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_settings, only: diagnose_settings_t
  use inference_engine, only: diagnosis_t
  use inference_refit, only: nested_fit_t
  use inference_simulator, only: labels_t
  use inference_validation, only: validation_t
  use io_json, only: json_t
  implicit none
  private
  public :: counts_t, kinds_of, print_kinds

  integer, parameter, public :: DATA_BENDING = 1, DATA_MODES = 2, DATA_SERIES = 3, DATA_FLIGHT = 4, DATA_LANDMARKS = 5
  character(*), parameter, public :: DATA_NAMES(5) = [character(9) :: 'bending', 'modes', 'series', 'flight', 'landmarks']

  character(*), parameter :: DATA_WORDS(5) = [character(21) :: 'bending tests', 'natural modes', 'records of motion', &
                                                                  'forces over the beat', 'landmarks']

  type :: counts_t
    integer, allocatable :: kind(:)         !< (surfaces) of data, one of the above
    integer, allocatable, private :: n(:)   !< (surfaces) observations
    integer, allocatable, private :: fold(:) !< (surfaces) location
    real(rp), allocatable, private :: baseline(:), extended(:) !< (surfaces) contributions to chi^2; extended: if it was found
    type(validation_t), private :: left_out, extended_left_out !< predictions
  contains
    procedure :: init => counts_init
    procedure :: first => counts_first
    procedure :: put => counts_put
    procedure :: put_kind => counts_put_kind
    procedure, private :: put_numbers => counts_put_numbers
  end type counts_t

contains

  !> Takes the observations with these labels and the results of the diagnosis.
  subroutine counts_init(self, s, labels, d)
    class(counts_t), intent(out) :: self
    type(diagnose_settings_t), intent(in) :: s
    type(labels_t), intent(in) :: labels
    type(diagnosis_t), intent(in) :: d
    integer :: l
    self%kind = kinds_of(s)
    self%n = [(count(labels%surface == l), l=1, size(labels%fold))]
    self%fold = labels%fold
    self%baseline = squares_of(d%initial_baseline, size(self%fold))
    if (d%extended%is_found) self%extended = squares_of(d%extended, size(self%fold))
    self%left_out = d%prediction%baseline
    self%extended_left_out = d%prediction%extended
  end subroutine counts_init

  !> Returns the kind of data of each surface.
  pure function kinds_of(s) result(kind)
    type(diagnose_settings_t), intent(in) :: s
    integer, allocatable :: kind(:)
    integer :: i, l, n
    kind = [(DATA_BENDING, i=1, size(s%measurement%loads)), (DATA_MODES, i=1, s%measurement%count_modes())]
    n = 0
    do l = 1, s%measurement%count_series()
      n = n + size(s%measurement%series(l)%sigma)
    end do
    kind = [kind, (DATA_SERIES, i=1, n)]
    do l = 1, merge(s%measurement%count_flights(), 0, s%flights%is_ready)
      associate (f => s%measurement%flights(l))
        kind = [kind, (merge(DATA_FLIGHT, DATA_LANDMARKS, f%side == 0), i=1, size(f%component))]
      end associate
    end do
  end function kinds_of

  !> Prints on `unit` what each kind of data contributes to chi^2 of the baseline, if there are several.
  subroutine print_kinds(unit, s, d)
    integer, intent(in) :: unit
    type(diagnose_settings_t), intent(in) :: s
    type(diagnosis_t), intent(in) :: d
    integer, allocatable :: kind(:)
    real(rp), allocatable :: squares(:)
    character(:), allocatable :: text
    integer :: i
    kind = kinds_of(s)
    if (size(kind) == 0) return
    if (all(kind == kind(1))) return
    squares = squares_of(d%initial_baseline, size(kind))
    text = ''
    do i = 1, size(DATA_WORDS)
      if (any(kind == i)) text = text//', '//trim(DATA_WORDS(i))//' '//fixed(sum(squares, kind == i), 1)//' of '// &
                                 number_text(numbers_of(s, i))
    end do
    write (unit, '(a)') '          of which '//text(3:)
  end subroutine print_kinds

  !> Returns how many numbers of a kind were measured.
  pure integer function numbers_of(s, kind) result(n)
    type(diagnose_settings_t), intent(in) :: s
    integer, intent(in) :: kind
    select case (kind)
    case (DATA_BENDING)
      n = s%bins%n
    case (DATA_MODES)
      n = s%measurement%count_mode_observations()
    case (DATA_SERIES)
      n = s%measurement%count_series_observations()
    case default
      n = s%measurement%count_flight_observations(has_landmarks=kind == DATA_LANDMARKS)
    end select
  end function numbers_of

  !> Returns what each of n surfaces contributes to chi^2 of a fit.
  pure function squares_of(fit, n) result(squares)
    type(nested_fit_t), intent(in) :: fit
    integer, intent(in) :: n
    real(rp) :: squares(n)
    squares = 0
    if (allocated(fit%squares)) squares = fit%squares
  end function squares_of

  !> Returns the first surface of a kind of data, or 0.
  pure integer function counts_first(self, kind) result(first)
    class(counts_t), intent(in) :: self
    integer, intent(in) :: kind
    first = findloc(self%kind, kind, 1)
  end function counts_first

  !> Adds to the open object the name of a set and the counts of its surfaces first, .. first + n - 1.
  subroutine counts_put(self, json, name, first, n)
    class(counts_t), intent(in) :: self
    type(json_t), intent(inout) :: json
    character(*), intent(in) :: name
    integer, intent(in) :: first, n
    call json%put('name', name)
    call self%put_numbers(json, first, n)
  end subroutine counts_put

  !> Adds to the open object the counts of the surfaces first, .. first + n - 1.
  subroutine counts_put_numbers(self, json, first, n)
    class(counts_t), intent(in) :: self
    type(json_t), intent(inout) :: json
    integer, intent(in) :: first, n
    call json%put('observations', sum(self%n(first:first + n - 1)))
    call json%put('baseline_chi2', sum(self%baseline(first:first + n - 1)))
    if (allocated(self%extended)) call json%put('extended_chi2', sum(self%extended(first:first + n - 1)))
  end subroutine counts_put_numbers

  !> Adds to the open object the name and the counts of a kind of data, and `left_out` if its locations were left out in turn.
  subroutine counts_put_kind(self, json, kind)
    class(counts_t), intent(in) :: self
    type(json_t), intent(inout) :: json
    integer, intent(in) :: kind
    call json%put('kind', trim(DATA_NAMES(kind)))
    call self%put_numbers(json, self%first(kind), count(self%kind == kind))
    if (.not. allocated(self%left_out%fold)) return
    call json%open_object('left_out')
    call put_predictions('baseline', self%left_out)
    if (allocated(self%extended_left_out%fold)) call put_predictions('extended', self%extended_left_out)
    call json%close()

  contains

    !> Adds the sums over the locations of this kind that a fit predicted.
    subroutine put_predictions(name, v)
      character(*), intent(in) :: name
      type(validation_t), intent(in) :: v
      logical :: is_kind(size(v%fold))
      integer :: i
      is_kind = [(any(self%fold == v%fold(i) .and. self%kind == kind), i=1, size(v%fold))]
      call json%open_object(name)
      call json%put('locations', count(is_kind))
      call json%put('observations', sum(v%n, mask=is_kind))
      call json%put('chi2', sum(v%chi2, mask=is_kind))
      call json%put('log_density', sum(v%density, mask=is_kind))
      call json%close()
    end subroutine put_predictions

  end subroutine counts_put_kind
end module diagnose_counts
