! SPDX-License-Identifier: GPL-3.0-or-later
!> Records what a search has done: a row for every generation and one for every candidate, in memory, in checkpoints and in
!> NAME_history.h5. Nothing in it depends on the clock or the number of ranks.
module training_history
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use io_attributes, only: put_attribute
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  use io_datasets, only: write_slab
  use io_hdf5, only: hdf5_file_t
  use training_objective, only: candidate_costs_t
  use training_space, only: search_space_t
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  implicit none
  private
  public :: train_history_t

  integer, parameter :: N_GENERATION = 12, N_CANDIDATE = 6
  character(*), parameter :: GENERATION_COLUMNS = 'stage run generation lambda evaluations best generation_best '// &
                             'generation_median sigma condition infeasible failed, then the mean'
  character(*), parameter :: CANDIDATE_COLUMNS = 'stage run generation class(1: feasible, 2: infeasible, 3: failed) cost '// &
                             'violation, then the values'

  type :: train_history_t
    integer :: n_unknowns = 0
    integer :: n_generations = 0, n_candidates = 0
    real(rp), allocatable, private :: generations(:, :) !< (N_GENERATION + unknowns, rows and room for more)
    real(rp), allocatable, private :: candidates(:, :)  !< (N_CANDIDATE + unknowns, rows and room for more)
  contains
    procedure :: init => history_init
    procedure :: add_generation => history_add_generation
    procedure :: add_candidates => history_add_candidates
    procedure :: best_candidates => history_best_candidates
    procedure :: improve => history_improve
    procedure :: save => history_save
    procedure :: load => history_load
    procedure :: write_tables => history_write_tables
  end type train_history_t

contains

  !> Makes an empty history of a search for n_unknowns unknowns.
  subroutine history_init(self, n_unknowns)
    class(train_history_t), intent(out) :: self
    integer, intent(in) :: n_unknowns
    self%n_unknowns = n_unknowns
    allocate (self%generations(N_GENERATION + n_unknowns, 64), self%candidates(N_CANDIDATE + n_unknowns, 1024))
  end subroutine history_init

  !> Adds a generation. `row` has the columns of GENERATION_COLUMNS up to condition except the best and the median of the
  !> generation, which this procedure computes; `mean` is in the units of the unknowns.
  subroutine history_add_generation(self, counts, best, sigma, condition, costs, mean)
    class(train_history_t), intent(inout) :: self
    integer(i8), intent(in) :: counts(5)  !< stage, run, generation, lambda, evaluations
    real(rp), intent(in) :: best          !< lowest cost so far; huge if no candidate was feasible
    real(rp), intent(in) :: sigma, condition
    type(candidate_costs_t), intent(in) :: costs
    real(rp), intent(in) :: mean(:)
    real(rp), allocatable :: feasible(:)
    real(rp) :: nothing, middle
    logical :: is_infeasible(size(costs%f))
    nothing = ieee_value(nothing, ieee_quiet_nan)
    is_infeasible = .not. costs%has_failed .and. costs%violation > 0
    feasible = pack(costs%f,.not. costs%has_failed .and. .not. is_infeasible)
    middle = nothing
    if (size(feasible) > 0) middle = median(feasible)
    call make_room(self%generations, self%n_generations + 1)
    self%n_generations = self%n_generations + 1
    self%generations(:, self%n_generations) = [real(counts, rp), merge(best, nothing, best < huge(best)), &
                                               merge(minval([feasible, huge(best)]), nothing, size(feasible) > 0), &
                                               middle, sigma, condition, real(count(is_infeasible), rp), &
                                               real(count(costs%has_failed), rp), mean]
  end subroutine history_add_generation

  !> Adds the candidates of a generation: values(unknowns, lambda) in the units of the unknowns.
  subroutine history_add_candidates(self, counts, costs, values)
    class(train_history_t), intent(inout) :: self
    integer(i8), intent(in) :: counts(5)
    type(candidate_costs_t), intent(in) :: costs
    real(rp), intent(in) :: values(:, :)
    integer :: k, class
    call make_room(self%candidates, self%n_candidates + size(costs%f))
    do k = 1, size(costs%f)
      class = merge(2, 1, costs%violation(k) > 0)
      if (costs%has_failed(k)) class = 3
      self%n_candidates = self%n_candidates + 1
      self%candidates(:, self%n_candidates) = [real(counts(:3), rp), real(class, rp), costs%f(k), costs%violation(k), &
                                               values(:, k)]
    end do
  end subroutine history_add_candidates

  !> Returns at most `most` feasible candidates, the best first. Each differs from every earlier one in some value by at least the
  !> fraction `apart` of it.
  subroutine history_best_candidates(self, most, apart, values)
    class(train_history_t), intent(in) :: self
    integer, intent(in) :: most
    real(rp), intent(in) :: apart
    real(rp), allocatable, intent(out) :: values(:, :) !< (unknowns, :)
    logical :: is_open(self%n_candidates)
    integer :: k, i
    allocate (values(self%n_unknowns, 0))
    is_open = abs(self%candidates(4, :self%n_candidates) - 1) < 0.5_rp
    do while (size(values, 2) < most .and. any(is_open))
      k = minloc(self%candidates(5, :self%n_candidates), 1, mask=is_open)
      associate (chosen => self%candidates(N_CANDIDATE + 1:, k))
        values = reshape([values, chosen], [self%n_unknowns, size(values, 2) + 1])
        do i = 1, self%n_candidates
          if (is_open(i)) is_open(i) = is_apart(self%candidates(N_CANDIDATE + 1:, i), chosen, apart)
        end do
      end associate
    end do
  end subroutine history_best_candidates

  !> Replaces the best point u of `space` by a feasible candidate of any stage that costs less. A second stage begins about the
  !> best candidate of the first without evaluating it again, and may find no better one.
  subroutine history_improve(self, space, has_best, cost, u)
    class(train_history_t), intent(in) :: self
    type(search_space_t), intent(in) :: space
    logical, intent(inout) :: has_best
    real(rp), intent(inout) :: cost
    real(rp), intent(inout) :: u(:)
    real(rp) :: coordinates(self%n_unknowns)
    logical :: is_feasible(self%n_candidates)
    integer :: k
    is_feasible = abs(self%candidates(4, :self%n_candidates) - 1) < 0.5_rp
    if (.not. any(is_feasible)) return
    k = minloc(self%candidates(5, :self%n_candidates), 1, mask=is_feasible)
    if (has_best .and. .not. self%candidates(5, k) < cost) return
    has_best = .true.
    cost = self%candidates(5, k)
    coordinates = self%candidates(N_CANDIDATE + 1:, k)
    where (space%is_log) coordinates = log(merge(coordinates, 1.0_rp, space%is_log))
    u = space%point(coordinates)
  end subroutine history_improve

  !> Tells whether two lists of numbers differ by more than the relative tolerance `apart`.
  pure logical function is_apart(a, b, apart)
    real(rp), intent(in) :: a(:), b(:), apart
    is_apart = any(abs(a - b) > apart*max(abs(a), abs(b)))
  end function is_apart

  !> Returns the median; of two middle values, the lower one.
  pure real(rp) function median(values)
    real(rp), intent(in) :: values(:)
    integer :: i
    median = values(1)
    do i = 1, size(values)
      if (count(values < values(i)) <= (size(values) - 1)/2 .and. &
          count(values <= values(i)) > (size(values) - 1)/2) median = values(i)
    end do
  end function median

  !> Makes room for n_rows columns in a table.
  subroutine make_room(table, n_rows)
    real(rp), allocatable, intent(inout) :: table(:, :)
    integer, intent(in) :: n_rows
    real(rp), allocatable :: larger(:, :)
    if (n_rows <= size(table, 2)) return
    allocate (larger(size(table, 1), max(n_rows, 2*size(table, 2))))
    larger(:, :size(table, 2)) = table
    call move_alloc(larger, table)
  end subroutine make_room

  !> Puts the history into an open checkpoint.
  subroutine history_save(self, writer)
    class(train_history_t), intent(in) :: self
    type(checkpoint_writer_t), intent(inout) :: writer
    call writer%put_reals('history_generations', [self%generations(:, :self%n_generations)])
    call writer%put_reals('history_candidates', [self%candidates(:, :self%n_candidates)])
  end subroutine history_save

  !> Restores an initialised history.
  subroutine history_load(self, reader, failure)
    class(train_history_t), intent(inout) :: self
    type(checkpoint_reader_t), intent(inout) :: reader
    type(failure_t), intent(inout) :: failure
    call load_table('history_generations', self%generations, self%n_generations)
    call load_table('history_candidates', self%candidates, self%n_candidates)

  contains

    !> Reads a table from the checkpoint.
    subroutine load_table(name, table, n_rows)
      character(*), intent(in) :: name
      real(rp), allocatable, intent(inout) :: table(:, :)
      integer, intent(inout) :: n_rows
      real(rp), allocatable :: numbers(:)
      if (failure%failed) return
      call reader%get_reals(name, numbers, failure)
      if (failure%failed) return
      n_rows = size(numbers)/size(table, 1)
      if (n_rows*size(table, 1) /= size(numbers)) then
        call failure%raise('in the checkpoint '//name//' has another size')
        return
      end if
      call make_room(table, n_rows)
      table(:, :n_rows) = reshape(numbers, [size(table, 1), n_rows])
    end subroutine load_table

  end subroutine history_load

  !> Writes both tables, with the names of their columns, into an open file of this process.
  subroutine history_write_tables(self, file, names, failure)
    class(train_history_t), intent(in) :: self
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: names !< of the unknowns, separated by blanks
    type(failure_t), intent(inout) :: failure
    if (self%n_generations == 0) return
    call write_table(file, 'generations', self%generations(:, :self%n_generations), failure)
    call put_attribute(file, 'generations', 'columns', GENERATION_COLUMNS, failure)
    call put_attribute(file, 'generations', 'unknowns', names, failure)
    call write_table(file, 'candidates', self%candidates(:, :self%n_candidates), failure)
    call put_attribute(file, 'candidates', 'columns', CANDIDATE_COLUMNS, failure)
    call put_attribute(file, 'candidates', 'unknowns', names, failure)
  end subroutine history_write_tables

  !> Writes a table.
  subroutine write_table(file, name, table, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name
    real(rp), intent(in) :: table(:, :)
    type(failure_t), intent(inout) :: failure
    call write_slab(file, name, int(shape(table), i8), [0_i8, 0_i8], int(shape(table), i8), [table], .false., failure)
  end subroutine write_table
end module training_history
