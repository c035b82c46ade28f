! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the measurement that discriminates best between the possible causes: the design that maximises the sum of squares by
!> which rival models must differ (Atkinson and Fedorov 1975, DOI 10.1093/biomet/62.1.57).
!>
!> The rivals of the first cause are all causes that may stand in its place: each candidate of another effect, at each of its sites,
!> even where the baseline imitates it, because another load may show it. The separation of the cause from a rival is the length of
!> the part of the cause, at the strength that was found, that baseline and rival together cannot imitate. It is the square root of
!> a sum of squares. A repeated load adds its part of the sum once more, and a load at a new site adds a new part. The value of a
!> load is the separation from the nearest rival after it. Tangents are those at the baseline.
module diagnosis_next_measurement
  use base_kinds, only: rp
  use base_sort, only: key_of_real, sorting_order
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_load_sites, only: new_load_t, normal_matrix, separation, common_columns, trial_t, whitened_tangents
  use diagnosis_wing_bins, only: noise_model_t
  use diagnosis_wing_simulator, only: wing_simulator_t
  use inference_engine, only: diagnosis_t
  implicit none
  private
  public :: next_measurement_t, rank_loads

  integer, parameter :: MOST_SITES = 10

  !> The ranking; empty without a cause and rivals.
  type :: next_measurement_t
    integer :: cause = 0                     !< the candidate
    integer, allocatable :: rivals(:)        !< candidates, the nearest first
    real(rp), allocatable :: now(:)          !< [sd] separation of the cause from each of these
    real(rp), allocatable :: after(:)        !< (loads) [sd] separation from the nearest rival if this load is repeated
    integer, allocatable :: order(:)         !< loads, the best first
    type(new_load_t), allocatable :: sites(:)  !< loads at new sites, the best first
  end type next_measurement_t

  type :: site_list_t
    integer, allocatable :: list(:)
  end type site_list_t

  !> The separation of a cause from its rivals by normal matrices.
  type :: discrimination_t
    integer, allocatable :: columns(:)       !< parameters of the baseline, those common to all loads, of the cause, of rivals
    integer :: n_common = 0, n_cause = 0
    type(site_list_t), allocatable :: sites(:) !< of each rival in `columns`, without those of the cause
    real(rp), allocatable :: strength(:)     !< of the cause
    real(rp), allocatable :: normal(:, :)    !< of the loads that have been applied
    real(rp), allocatable :: white(:, :)     !< (observations, columns) their whitened tangents
    real(rp), allocatable :: now(:)          !< separation from each rival
  contains
    procedure :: init => discrimination_init
    procedure :: block => discrimination_block
    procedure :: needed => discrimination_needed
    procedure :: separation => discrimination_separation
  end type discrimination_t

contains

  !> Ranks the loads of the measurement, and loads at new sites. Rank 0 calls it; the others serve.
  subroutine rank_loads(s, simulator, d, next)
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(next_measurement_t), intent(out) :: next
    type(discrimination_t) :: discrimination
    integer, allocatable :: order(:), rows(:)
    integer :: c, l
    logical :: ok
    allocate (next%rivals(0), next%now(0), next%after(0), next%order(0), next%sites(0))
    if (size(d%decision%causes) == 0) return
    next%cause = d%decision%causes(1)
    associate (candidates => d%model%design%candidates)
      next%rivals = pack([(c, c=1, size(candidates))], candidates%effect /= candidates(next%cause)%effect)
    end associate
    call discrimination%init(s, simulator, d, next, ok)
    if (.not. ok) next%rivals = [integer ::]
    if (size(next%rivals) == 0) return
    do l = 1, size(simulator%labels%fold)
      rows = pack([(c, c=1, simulator%n_observations)], simulator%labels%surface == l)
      associate (white => discrimination%white(rows, :))
        next%after = [next%after, discrimination%separation([(c, c=1, size(next%rivals))], matmul(transpose(white), white))]
      end associate
    end do
    next%order = sorting_order(key_of_real(-next%after))
    call rank_sites(s, simulator, d, discrimination, next)
    order = sorting_order(key_of_real(discrimination%now))
    next%rivals = next%rivals(order)
    next%now = discrimination%now(order)
  end subroutine rank_loads

  !> Ranks the sites of loads. There are hundreds of rivals with all their sites. The procedure first tries all loads against the
  !> nearest site of each effect, which gives an upper bound. It then tries the loads with the largest bounds against all rivals,
  !> until no other load can be better or 3 MOST_SITES have been tried.
  subroutine rank_sites(s, simulator, d, discrimination, next)
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(in) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(discrimination_t), intent(in) :: discrimination
    type(next_measurement_t), intent(inout) :: next
    type(trial_t) :: trial
    type(noise_model_t) :: noise
    type(new_load_t) :: one
    integer, allocatable :: few(:), numbers(:), order(:)
    real(rp), allocatable :: bounds(:)
    integer :: l, i, tried
    logical :: ok
    few = nearest_of_each(d%model%design%candidates(next%rivals)%effect, discrimination%now)
    allocate (numbers(0), bounds(0))
    noise = simulator%noise%with_independent(d%model%whitener%independent_fraction)
    call trial%begin(s, d%model%baseline%q)
    do l = 1, trial%n
      call trial%apply(noise, l, discrimination%columns(discrimination%needed(few)), one, ok)
      if (.not. ok) cycle
      numbers = [numbers, l]
      bounds = [bounds, discrimination%separation(few, one%normal)]
    end do
    order = sorting_order(key_of_real(-bounds))
    tried = 0
    do i = 1, size(order)
      if (tried >= MOST_SITES) then
        if (maxval(next%sites%after) >= bounds(order(i)) .or. tried >= 3*MOST_SITES) exit
      end if
      call trial%apply(noise, numbers(order(i)), discrimination%columns, one, ok)
      tried = tried + 1
      if (.not. ok) cycle
      one%after = discrimination%separation([(l, l=1, size(next%rivals))], one%normal)
      next%sites = [next%sites, one]
    end do
    call trial%end()
    order = sorting_order(key_of_real(-next%sites%after))
    next%sites = next%sites(order(:min(MOST_SITES, size(order))))
  end subroutine rank_sites

  !> Returns, for every effect, the rival with the least separation `now`(:).
  pure function nearest_of_each(effects, now) result(few)
    integer, intent(in) :: effects(:)
    real(rp), intent(in) :: now(:)
    integer, allocatable :: few(:)
    integer :: e
    few = [(minloc(now, 1, mask=effects == e), e=1, maxval(effects))]
    few = pack(few, few > 0)
  end function nearest_of_each

  !> Compares the cause with all rivals, with the loads that have been applied.
  subroutine discrimination_init(self, s, simulator, d, next, ok)
    class(discrimination_t), intent(inout) :: self
    class(diagnosis_case_t), intent(in) :: s
    type(wing_simulator_t), intent(inout) :: simulator
    type(diagnosis_t), intent(in) :: d
    type(next_measurement_t), intent(in) :: next
    logical, intent(out) :: ok
    integer, allocatable :: shared(:)
    real(rp), allocatable :: common_sd(:)
    integer :: r, i
    call common_columns(s, shared, common_sd)
    associate (candidates => d%model%design%candidates, cause => d%model%design%candidates(next%cause)%columns)
      self%columns = [d%model%baseline%active, shared, cause]
      self%n_common = size(d%model%baseline%active) + size(shared)
      self%n_cause = size(cause)
      allocate (self%sites(size(next%rivals)), self%now(size(next%rivals)))
      do r = 1, size(next%rivals)
        allocate (self%sites(r)%list(0))
        associate (parameters => candidates(next%rivals(r))%columns)
          do i = 1, size(parameters)
            if (any(cause == parameters(i))) cycle
            if (all(self%columns(self%n_common + 1:) /= parameters(i))) self%columns = [self%columns, parameters(i)]
            self%sites(r)%list = [self%sites(r)%list, &
                                  self%n_common + findloc(self%columns(self%n_common + 1:), parameters(i), 1)]
          end do
        end associate
      end do
      self%strength = -matmul(candidates(next%cause)%solve, matmul(d%tests%z, candidates(next%cause)%basis))
    end associate
    call whitened_tangents(simulator, d%model%whitener%independent_fraction, d%model%baseline%q, d%model%baseline%state, &
                           self%columns, self%white, ok)
    if (.not. ok) return
    self%normal = normal_matrix(simulator, self%columns, common_sd, self%white)
    do r = 1, size(next%rivals)
      self%now(r) = separation(self%normal(self%block(r), self%block(r)), self%strength)
    end do
  end subroutine discrimination_init

  !> Returns the indices in `columns` of the parameters that are fitted if rival r replaces the cause, then those of the cause.
  pure function discrimination_block(self, r) result(block)
    class(discrimination_t), intent(in) :: self
    integer, intent(in) :: r
    integer, allocatable :: block(:)
    integer :: i
    block = [[(i, i=1, self%n_common)], self%sites(r)%list, [(i, i=self%n_common + 1, self%n_common + self%n_cause)]]
  end function discrimination_block

  !> Returns the indices in `columns` that these rivals need.
  pure function discrimination_needed(self, rivals) result(needed)
    class(discrimination_t), intent(in) :: self
    integer, intent(in) :: rivals(:)
    integer, allocatable :: needed(:)
    logical :: is_needed(size(self%columns))
    integer :: r
    is_needed = .false.
    do r = 1, size(rivals)
      is_needed(self%block(rivals(r))) = .true.
    end do
    needed = pack([(r, r=1, size(is_needed))], is_needed)
  end function discrimination_needed

  !> Returns the least separation of these rivals with a further load, of which `normal` is the normal matrix of the columns that
  !> they need.
  real(rp) function discrimination_separation(self, rivals, normal) result(least)
    class(discrimination_t), intent(in) :: self
    integer, intent(in) :: rivals(:)
    real(rp), intent(in) :: normal(:, :)
    integer :: position(size(self%columns)), i, r
    position = 0
    position(self%needed(rivals)) = [(i, i=1, size(normal, 1))]
    least = huge(least)
    do i = 1, size(rivals)
      r = rivals(i)
      associate (block => self%block(r))
        least = min(least, separation(self%normal(block, block) + normal(position(block), position(block)), self%strength))
      end associate
    end do
  end function discrimination_separation
end module diagnosis_next_measurement
