! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes how much natural modes of the wing, or a record of its motion after a release, would tell about the unknowns of a
!> diagnosis. For each of these measurements it gives the normal matrix of the tangents at the parameters of the baseline, in
!> units of assumed errors.
!>
!> Modes are the lowest ones, with their numbers, frequencies and damping ratios, in a vacuum and in air. A record is the
!> displacement along z of one place of the wing in air after a force there ends. This force bends the wing there by a hundredth
!> of its length: without drag its size does not matter.
!>
!> The mass of the air and the damping are unknowns, with the priors of a diagnosis of such data. Where no data show the damping
!> the lowest mode has a ratio of 0.02, or the motion ends within the record. The masses of the wing count as known.
module diagnosis_motion_proposals
  use base_kinds, only: rp
  use diagnosis_case, only: diagnosis_case_t
  use diagnosis_wing_catalogue, only: catalogue_t
  use diagnosis_wing_damping, only: add_damping
  use diagnosis_wing_inertia, only: add_air
  use diagnosis_wing_lattice, only: lattice
  use diagnosis_wing_modes, only: wing_modes_t
  use diagnosis_wing_parameters, only: wing_parameter_t, KIND_PARAMETER
  use diagnosis_wing_series, only: wing_series_t
  use inference_discrimination, only: marginal_normal
  use measurement_experiment, only: experiment_t
  use measurement_modes, only: measured_mode_t, MEDIUM_AIR, MEDIUM_VACUUM
  use measurement_series, only: measured_series_t
  use solid_effect, only: NEED_UNSTRESSED_REST
  use solid_effects, only: active_needs, needs_of
  use solid_mass_effects, only: mass_parts_t
  use solid_ringing, only: EXCITED_RELEASE
  use solid_wing, only: wing_t
  implicit none
  private
  public :: motion_proposal_t, motion_proposer_t

  integer, parameter, public :: PROPOSE_MODES = 1, PROPOSE_RELEASE = 2

  real(rp), parameter :: SPACING = 0.3_rp, NEAR_ROOT = 0.2_rp !< of places of releases; of the wing's size
  real(rp), parameter :: DEFLECTION = 0.01_rp                 !< by the released force, of the wing's size
  real(rp), parameter :: RATIO = 0.02_rp, LEAST_RATIO = 1.0e-4_rp !< of damping: assumed; smallest for an sd

  !> A measurement of motion.
  type :: motion_proposal_t
    integer :: kind = PROPOSE_MODES
    integer :: medium = MEDIUM_VACUUM
    real(rp) :: site(2) = 0                !< [m] of a release
    real(rp) :: force = 0                  !< [N] that is released
    real(rp) :: rate = 0                   !< [Hz] samples of the record
    integer :: samples = 0
    real(rp), allocatable :: frequency(:)  !< [Hz] expected ones of the modes
  end type motion_proposal_t

  !> A wing whose motion may be measured, at the parameters q.
  type :: motion_proposer_t
    type(motion_proposal_t), allocatable :: list(:)
    character(:), allocatable :: reason    !< why the list is empty
    type(wing_t), private :: wing
    type(experiment_t), private :: experiment
    type(mass_parts_t), private :: parts
    type(wing_parameter_t), allocatable, private :: parameters(:)
    real(rp), allocatable, private :: q(:)
    real(rp), private :: frequency_sd = 0, damping_sd = 0, motion_sd = 0, force_sd = 0
  contains
    procedure :: init => proposer_init
    procedure :: apply => proposer_apply
    procedure :: knows => proposer_knows
  end type motion_proposer_t

contains

  !> Makes the list of all measurements of motion for the wing at q. It is empty, with the reason, if nobody wants it, if the wing
  !> has no mass, or if it cannot vibrate about a flat shape. On rank 0 alone.
  subroutine proposer_init(self, s, q)
    class(motion_proposer_t), intent(inout), target :: self
    class(diagnosis_case_t), intent(in) :: s
    real(rp), intent(in) :: q(:)
    integer :: i
    allocate (self%list(0))
    self%reason = why_not(s)
    if (self%reason /= '') return
    self%wing = s%wing_case%wing
    self%experiment = s%experiment
    self%parts = s%parts
    self%parameters = s%catalogue%parameters
    self%q = q
    if (.not. all([(self%knows(i), i=1, s%catalogue%n_baseline)])) then
      self%reason = 'they need a wing that is flat and free of stress at rest, and the baseline fits its camber or pretension'
      return
    end if
    self%frequency_sd = s%proposals%frequency_sd
    self%damping_sd = s%proposals%damping_sd
    self%motion_sd = s%proposals%motion_sd
    self%force_sd = s%proposals%force_sd
    call add_modes(self, min(s%proposals%n_modes, s%experiment%model%n_free), MEDIUM_VACUUM)
    call add_modes(self, min(s%proposals%n_modes, s%experiment%model%n_free), MEDIUM_AIR)
    if (size(self%list) < 2) then
      self%reason = 'the wing at rest is not stable'
      deallocate (self%list)
      allocate (self%list(0))
      return
    end if
    call add_releases(self, s)
  end subroutine proposer_init

  !> Returns why the wing has no motion that could be measured; empty if it has.
  function why_not(s) result(reason)
    class(diagnosis_case_t), intent(in) :: s
    character(:), allocatable :: reason
    reason = ''
    if (s%proposals%n_modes == 0) then
      reason = '[Next] modes is 0'
    else if (.not. s%wing_case%has_mass) then
      reason = 'they need a valid mass of the wing: [Mass]'
    else if (.not. (s%states_mass .or. s%measurement%moves())) then
      reason = 'they need the mass of the wing: [Mass] membrane_mass or areal_density, or a wing file that states it'
    else if (any(active_needs(s%wing_case%requested%effects) == NEED_UNSTRESSED_REST)) then
      reason = 'they need a wing that is flat and free of stress at rest, and [Wing] has camber or pretension'
    end if
  end function why_not

  !> Tells whether the effect of parameter i on motion can be computed: it must not bend or stretch the wing at rest.
  logical function proposer_knows(self, i) result(knows)
    class(motion_proposer_t), intent(in) :: self
    integer, intent(in) :: i
    integer :: effect
    knows = .true.
    if (self%parameters(i)%kind /= KIND_PARAMETER) return
    effect = self%parameters(i)%number - self%experiment%model%params%count_basic()
    if (effect > 0) knows = all(needs_of(self%experiment%model%params%effects, effect) /= NEED_UNSTRESSED_REST)
  end function proposer_knows

  !> Adds the n lowest modes in a medium to the list, if the wing has them.
  subroutine add_modes(self, n, medium)
    class(motion_proposer_t), intent(inout), target :: self
    integer, intent(in) :: n, medium
    type(experiment_t), target :: planned
    type(motion_proposal_t) :: one
    type(wing_modes_t) :: modes
    type(wing_parameter_t), allocatable :: parameters(:)
    real(rp), allocatable :: q(:), residuals(:)
    integer :: i
    logical :: ok
    one%medium = medium
    allocate (one%frequency(n), source=1.0_rp)
    call plan_motion(self, planned)
    call plan_modes(self, one, .false., planned%measurement%modes)
    call add_unknowns(self, planned, parameters, q)
    call modes%init(planned, self%wing, parameters, self%parts)
    allocate (residuals(modes%n))
    call modes%evaluate(q, residuals, ok)
    if (ok) then
      one%frequency = [(modes%simulation%targets(i)%frequency, i=1, n)]
      self%list = [self%list, one]
    end if
    call modes%free()
  end subroutine add_modes

  !> Makes an experiment on the wing without modes and records.
  subroutine plan_motion(self, planned)
    class(motion_proposer_t), intent(in) :: self
    type(experiment_t), intent(out) :: planned
    planned = self%experiment
    if (allocated(planned%measurement%modes)) deallocate (planned%measurement%modes)
    if (allocated(planned%measurement%series)) deallocate (planned%measurement%series)
    allocate (planned%measurement%modes(0), planned%measurement%series(0))
  end subroutine plan_motion

  !> Makes the modes of a proposal, as they would be measured.
  subroutine plan_modes(self, proposal, has_damping, modes)
    class(motion_proposer_t), intent(in) :: self
    type(motion_proposal_t), intent(in) :: proposal
    logical, intent(in) :: has_damping
    type(measured_mode_t), allocatable, intent(out) :: modes(:)
    integer :: i
    allocate (modes(size(proposal%frequency)))
    do i = 1, size(modes)
      associate (mode => modes(i))
        mode%name = ''
        mode%medium = proposal%medium
        mode%number = i
        mode%frequency = proposal%frequency(i)
        mode%frequency_sigma = self%frequency_sd*mode%frequency
        if (has_damping) mode%damping = RATIO
        mode%damping_sigma = self%damping_sd*RATIO
        allocate (mode%place(2, 0), mode%shape(0), mode%sigma(0), mode%load_size(0), mode%load_direction(3, 0), &
                  mode%load_place(2, 0))
      end associate
    end do
  end subroutine plan_modes

  !> Adds a release at each site of a coarse lattice to the list.
  subroutine add_releases(self, s)
    class(motion_proposer_t), intent(inout) :: self
    class(diagnosis_case_t), intent(in) :: s
    type(motion_proposal_t) :: one
    real(rp), allocatable :: sites(:, :)
    integer :: i
    one%kind = PROPOSE_RELEASE
    one%medium = MEDIUM_AIR
    one%samples = s%proposals%n_samples
    one%rate = one%samples/s%proposals%n_periods*self%list(2)%frequency(1)
    allocate (one%frequency(0))
    call lattice(self%wing, s%experiment%model%size, SPACING, sites)
    do i = 1, size(sites, 2)
      if (norm2(sites(:, i) - s%experiment%root(:2)) < NEAR_ROOT*s%experiment%model%size) cycle
      one%site = sites(:, i)
      self%list = [self%list, one]
    end do
  end subroutine add_releases

  !> Makes the record of a release, with this sd [m] of its values.
  subroutine plan_record(self, proposal, sd, record)
    class(motion_proposer_t), intent(in) :: self
    type(motion_proposal_t), intent(in) :: proposal
    real(rp), intent(in) :: sd
    type(measured_series_t), intent(out) :: record
    record%name = ''
    record%medium = proposal%medium
    record%excitation = EXCITED_RELEASE
    record%point = proposal%site
    record%direction = [0.0_rp, 0.0_rp, 1.0_rp]
    record%size = proposal%force
    record%size_sigma = self%force_sd*proposal%force
    record%axis = record%direction
    record%rate = proposal%rate
    record%trigger_sigma = 1/proposal%rate
    record%place = reshape(proposal%site, [2, 1])
    allocate (record%values(proposal%samples, 1), source=0.0_rp)
    allocate (record%is_known(proposal%samples, 1), source=.true.)
    record%sigma = [sd]
    allocate (record%base(0))
  end subroutine plan_record

  !> Returns the parameters of the diagnosis, and behind them those that a baseline of this experiment fits and the diagnosis
  !> lacks: the ratio of the added mass and the damping. They have their null in q.
  subroutine add_unknowns(self, planned, parameters, q)
    class(motion_proposer_t), intent(in) :: self
    type(experiment_t), intent(in) :: planned
    type(wing_parameter_t), allocatable, intent(out) :: parameters(:)
    real(rp), allocatable, intent(out) :: q(:)
    type(catalogue_t) :: catalogue
    integer :: i
    allocate (catalogue%parameters(0), catalogue%effects(0))
    call add_air(catalogue, planned)
    call add_damping(catalogue, planned)
    parameters = self%parameters
    q = self%q
    do i = 1, size(catalogue%parameters)
      associate (one => catalogue%parameters(i))
        if (any(parameters%kind == one%kind .and. parameters%number == one%number)) cycle
        parameters = [parameters, one]
        q = [q, one%null]
      end associate
    end do
  end subroutine add_unknowns

  !> Computes normal(:, :, i), the normal matrix of the parameters `columns` by measurement i of the list, and finds the forces of
  !> releases. ok(i) is false if there is none, because the wing at rest is not stable. On rank 0 alone.
  subroutine proposer_apply(self, columns, normal, ok)
    class(motion_proposer_t), intent(inout), target :: self
    integer, intent(in) :: columns(:)
    real(rp), allocatable, intent(out) :: normal(:, :, :)
    logical, allocatable, intent(out) :: ok(:)
    type(motion_proposal_t), allocatable :: releases(:)
    real(rp), allocatable :: one(:, :)
    integer :: i
    allocate (normal(size(columns), size(columns), size(self%list)), source=0.0_rp)
    allocate (ok(size(self%list)), source=.false.)
    do i = 1, count(self%list%kind == PROPOSE_MODES)
      call apply_modes(self, self%list(i), columns, one, ok(i))
      if (ok(i)) normal(:, :, i) = one
    end do
    if (size(self%list) < i) return
    releases = self%list(i:)
    call apply_releases(self, releases, columns, normal(:, :, i:), ok(i:))
    self%list(i:) = releases
  end subroutine proposer_apply

  !> Computes the normal matrix by natural modes.
  subroutine apply_modes(self, proposal, columns, normal, ok)
    class(motion_proposer_t), intent(in), target :: self
    type(motion_proposal_t), intent(in) :: proposal
    integer, intent(in) :: columns(:)
    real(rp), allocatable, intent(out) :: normal(:, :)
    logical, intent(out) :: ok
    type(experiment_t), target :: planned
    type(wing_modes_t) :: modes
    type(wing_parameter_t), allocatable :: parameters(:)
    real(rp), allocatable :: q(:), residuals(:), tangents(:, :), errors(:, :)
    integer :: k
    call plan_motion(self, planned)
    call plan_modes(self, proposal, .true., planned%measurement%modes)
    call add_unknowns(self, planned, parameters, q)
    call modes%init(planned, self%wing, parameters, self%parts)
    allocate (residuals(modes%n), tangents(modes%n, size(columns)), errors(modes%n, size(q) - size(self%q)))
    call modes%evaluate(q, residuals, ok)
    if (ok) then
      do k = 1, size(proposal%frequency)
        associate (damping => modes%simulation%targets(k)%damping)
          damping%sigma = self%damping_sd*max(LEAST_RATIO, damping%decay%ratio)
        end associate
      end do
      call modes%tangents(q, columns, tangents)
      do k = 1, size(errors, 2)
        call modes%tangent(q, size(self%q) + k, errors(:, k))
        errors(:, k) = parameters(size(self%q) + k)%prior_sd*errors(:, k)
      end do
      call marginal_normal(tangents, errors, normal, ok)
    end if
    call modes%free()
  end subroutine apply_modes

  !> Computes normal(:, :, i), the normal matrices by the records of `releases`, and finds their forces. Errors of the force and of
  !> the time of a release, of this to second order, are unknown, as in a diagnosis of such records. All records are computed
  !> together, because they have the same modes.
  subroutine apply_releases(self, releases, columns, normal, ok)
    class(motion_proposer_t), intent(in), target :: self
    type(motion_proposal_t), intent(inout) :: releases(:)
    integer, intent(in) :: columns(:)
    real(rp), intent(inout) :: normal(:, :, :)
    logical, intent(out) :: ok(:)
    type(experiment_t), target :: planned
    type(wing_series_t) :: series
    type(wing_parameter_t), allocatable :: parameters(:)
    real(rp), allocatable :: q(:), tangents(:, :), errors(:, :), one(:, :)
    real(rp) :: length
    integer :: i, k, n, first, last
    logical :: is_stable
    ok = .false.
    length = DEFLECTION*self%experiment%model%size
    releases%force = 1
    call start_records(self, releases, self%motion_sd*length, planned, series, parameters, q, is_stable)
    if (is_stable) then
      do i = 1, size(releases)
        releases(i)%force = length/max(maxval(abs(series%simulation%computed(i))), tiny(1.0_rp))
      end do
      call series%free()
      call start_records(self, releases, self%motion_sd*length, planned, series, parameters, q, is_stable)
    end if
    if (is_stable) then
      n = size(q) - size(self%q)
      allocate (tangents(series%n, size(columns)), errors(series%n, n + series%n_nuisances))
      call series%tangents(q, columns, tangents)
      do k = 1, n
        call series%tangent(q, size(self%q) + k, errors(:, k))
        errors(:, k) = parameters(size(self%q) + k)%prior_sd*errors(:, k)
      end do
      call series%nuisances(errors(:, n + 1:))
      last = 0
      do i = 1, size(releases)
        first = last + 1
        last = last + releases(i)%samples
        call marginal_normal(tangents(first:last, :), errors(first:last, :), one, ok(i)) ! errors of other records are 0 here
        if (ok(i)) normal(:, :, i) = one
      end do
    end if
    call series%free()
  end subroutine apply_releases

  !> Simulates the records of these releases, with this sd [m] of their values. The experiment `planned` must live as long as
  !> `series`.
  subroutine start_records(self, releases, sd, planned, series, parameters, q, is_stable)
    class(motion_proposer_t), intent(in), target :: self
    type(motion_proposal_t), intent(in) :: releases(:)
    real(rp), intent(in) :: sd
    type(experiment_t), intent(inout), target :: planned
    type(wing_series_t), intent(inout) :: series
    type(wing_parameter_t), allocatable, intent(out) :: parameters(:)
    real(rp), allocatable, intent(out) :: q(:)
    logical, intent(out) :: is_stable
    real(rp), allocatable :: residuals(:)
    integer :: i
    call plan_motion(self, planned)
    deallocate (planned%measurement%series)
    allocate (planned%measurement%series(size(releases)))
    do i = 1, size(releases)
      call plan_record(self, releases(i), sd, planned%measurement%series(i))
    end do
    call add_unknowns(self, planned, parameters, q)
    call series%init(planned, self%wing, parameters, self%parts)
    allocate (residuals(series%n))
    call series%evaluate(q, residuals, is_stable)
  end subroutine start_records
end module diagnosis_motion_proposals
