! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds which case simulates which record: [Flight] file simulates all records but those that [Flight] records gives another case.
module diagnose_flight_cases
  use base_errors, only: message_list_t
  use base_files, only: real_path
  use base_text, only: next_word, number_text, quoted
  use common_diagnose_keys, only: flight_choices_t
  use common_wing_settings, only: find_beside
  use diagnosis_flight_data, only: flight_data_t, MOST_CASES
  use io_config, only: config_t
  use io_suggest, only: suggestion_t
  use measurement_data, only: measurement_t
  use measurement_flight, only: measured_flight_t
  use parallel_world, only: world_t
  implicit none
  private
  public :: group_records

  !> A record and the name of its case, as the input has it; empty: none.
  type :: assigned_t
    character(:), allocatable :: record, file
    logical :: is_named = .false. !< in [Flight] records
  end type assigned_t

contains

  !> Finds the cases of all records. Each of cases(:) gets its number, its records and, in its facts, the path of its file and the
  !> words for its records. The records of the measurement are then in the order of their cases, and the landmarks of each case are
  !> numbered on their own. Mistakes go to `errors`; there are no cases then. Collective.
  subroutine group_records(config, c, measurement, world, cases, errors)
    type(config_t), intent(in) :: config
    type(flight_choices_t), intent(in) :: c
    type(measurement_t), intent(inout) :: measurement
    type(world_t), intent(in) :: world
    type(flight_data_t), allocatable, intent(out) :: cases(:)
    type(message_list_t), intent(inout) :: errors
    type(assigned_t), allocatable :: assigned(:)
    integer, allocatable :: case_of(:), order(:)
    integer :: before, n, k, r
    before = errors%count()
    call list_records(measurement%flights, c%file, assigned)
    if (c%records /= '') call read_assignments(config, c%records, assigned, errors)
    do r = 1, size(assigned)
      if (assigned(r)%file /= '') cycle
      call config%complain(errors, 'Flight', 'file', 'is missing: the measurement holds records of a flight in /flight; '// &
                           'name the flusi case that simulates this experiment')
      exit
    end do
    if (errors%count() > before) then
      allocate (cases(0))
      return
    end if
    call find_cases(config, assigned, world, cases, case_of, errors)
    n = size(cases)
    if (c%file /= '' .and. all(assigned%is_named)) call config%complain(errors, 'Flight', 'file', &
      'simulates no record, because records gives a case to each of them: leave it out')
    if (n > MOST_CASES) call config%complain(errors, 'Flight', 'records', 'names '//number_text(n)//' cases; at most '// &
                                             number_text(MOST_CASES)//' are valid')
    if (errors%count() > before) then
      deallocate (cases)
      allocate (cases(0))
      return
    end if
    case_of = [(case_of(place_of(measurement%flights(r)%name)), r=1, size(measurement%flights))]
    order = [(pack([(r, r=1, size(case_of))], case_of == k), k=1, n)]
    call reorder(measurement%flights, order)
    do k = 1, n
      cases(k)%first = count(case_of < k) + 1
      cases(k)%last = count(case_of <= k)
      call renumber(measurement%flights(cases(k)%first:cases(k)%last))
      cases(k)%facts%label = ''
      if (n > 1) cases(k)%facts%label = words_for(measurement%flights(cases(k)%first:cases(k)%last))
    end do

  contains

    !> Returns the number of a record among all names.
    integer function place_of(name) result(i)
      character(*), intent(in) :: name
      do i = 1, size(assigned) - 1
        if (assigned(i)%record == name) return
      end do
    end function place_of

  end subroutine group_records

  !> Lists the names of all records, each with the case `file`.
  subroutine list_records(flights, file, assigned)
    type(measured_flight_t), intent(in) :: flights(:)
    character(*), intent(in) :: file
    type(assigned_t), allocatable, intent(out) :: assigned(:)
    logical :: is_first(size(flights))
    integer :: r, k, n
    is_first = [(all([(flights(k)%name /= flights(r)%name, k=1, r - 1)]), r=1, size(flights))]
    allocate (assigned(count(is_first)))
    n = 0
    do r = 1, size(flights)
      if (.not. is_first(r)) cycle
      n = n + 1
      assigned(n)%record = flights(r)%name
      assigned(n)%file = file
    end do
  end subroutine list_records

  !> Reads entries RECORD: FILE, which commas separate. Adds a mistake for each that is not valid.
  subroutine read_assignments(config, text, assigned, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: text
    type(assigned_t), intent(inout) :: assigned(:)
    type(message_list_t), intent(inout) :: errors
    type(suggestion_t) :: suggestion
    character(:), allocatable :: entry, name, valid
    integer :: position, first, last, colon, i, found_at
    logical :: found
    position = 1
    do
      call next_word(text, ',', position, first, last, found)
      if (.not. found) return
      entry = trim(adjustl(text(first:last)))
      if (entry == '') cycle
      colon = index(entry, ':')
      name = trim(entry(:max(colon - 1, 0)))
      if (name == '' .or. colon == len(entry)) then
        call config%complain(errors, 'Flight', 'records', 'has the entry '//quoted(entry)//'; valid: RECORD: FILE, with commas '// &
                             'between several')
        cycle
      end if
      call suggestion%start(name)
      valid = ''
      found_at = 0
      do i = 1, size(assigned)
        if (assigned(i)%record == name) found_at = i
        call suggestion%offer(assigned(i)%record)
        valid = valid//', '//assigned(i)%record
      end do
      if (found_at == 0) then
        call config%complain(errors, 'Flight', 'records', 'there is no record '//quoted(name)//' in /flight of the measurement'// &
                             suggestion%hint()//'; valid: '//valid(3:))
      else if (assigned(found_at)%is_named) then
        call config%complain(errors, 'Flight', 'records', 'names the record '//quoted(name)//' twice')
      else
        assigned(found_at)%file = trim(adjustl(entry(colon + 1:)))
        assigned(found_at)%is_named = .true.
      end if
    end do
  end subroutine read_assignments

  !> Finds the files of all records. Those of the same file are one case. case_of(i) is the number of the case of assigned(i). The
  !> case that [Flight] file names is the first one. Adds a mistake if that file is not there, and one for all files of `records`
  !> that are not there. Collective.
  subroutine find_cases(config, assigned, world, cases, case_of, errors)
    type(config_t), intent(in) :: config
    type(assigned_t), intent(in) :: assigned(:)
    type(world_t), intent(in) :: world
    type(flight_data_t), allocatable, intent(out) :: cases(:)
    integer, allocatable, intent(out) :: case_of(:)
    type(message_list_t), intent(inout) :: errors
    type(flight_data_t) :: found(size(assigned))
    character(:), allocatable :: path, problem, problems
    integer :: i, k, n, turn
    allocate (case_of(size(assigned)), source=0)
    n = 0
    do turn = 1, 2
      problems = ''
      do i = 1, size(assigned)
        if (assigned(i)%is_named .neqv. turn == 2) cycle
        if (allocated(problem)) deallocate (problem)
        call find_beside(config%file_name(), assigned(i)%file, path, problem, world)
        if (allocated(problem)) then
          if (index(problems, problem) > 0) cycle ! the same file again
          if (problems /= '') problems = problems//'; '
          if (turn == 2) problems = problems//'of the record '//assigned(i)%record//': '
          problems = problems//problem
          cycle
        end if
        path = real_path(path)
        call world%broadcast_text(path)
        do k = 1, n
          if (found(k)%facts%path == path) exit
        end do
        case_of(i) = k
        if (k <= n) cycle
        n = k
        found(k)%number = k
        found(k)%facts%path = path
      end do
      if (problems /= '') call config%complain(errors, 'Flight', trim(merge('file   ', 'records', turn == 1)), problems)
    end do
    allocate (cases(n))
    do k = 1, n
      cases(k) = found(k)
    end do
  end subroutine find_cases

  !> Puts records in another order.
  subroutine reorder(flights, order)
    type(measured_flight_t), allocatable, intent(inout) :: flights(:)
    integer, intent(in) :: order(:)
    type(measured_flight_t), allocatable :: sorted(:)
    integer :: r
    allocate (sorted(size(order)))
    do r = 1, size(order)
      sorted(r) = flights(order(r))
    end do
    call move_alloc(sorted, flights)
  end subroutine reorder

  !> Numbers the landmarks of these records from the first one.
  pure subroutine renumber(flights)
    type(measured_flight_t), intent(inout) :: flights(:)
    integer :: r, n
    n = 0
    do r = 1, size(flights)
      associate (f => flights(r))
        if (f%side == 0) cycle
        f%component = f%component - 3*(f%first - n)
        f%first = n
        n = n + f%count_landmarks()
      end associate
    end do
  end subroutine renumber

  !> Returns 'in the record a', or 'in the records a, b'.
  function words_for(flights) result(text)
    type(measured_flight_t), intent(in) :: flights(:)
    character(:), allocatable :: text
    integer :: r, k, n
    text = ''
    n = 0
    do r = 1, size(flights)
      if (any([(flights(k)%name == flights(r)%name, k=1, r - 1)])) cycle
      n = n + 1
      text = text//', '//flights(r)%name
    end do
    text = trim(merge('in the record ', 'in the records', n == 1))//' '//text(3:)
  end function words_for
end module diagnose_flight_cases
