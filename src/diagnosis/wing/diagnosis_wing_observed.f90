! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the wings of a diagnosis from coordinates, and averages over bins what is observed of them. The experiment has only those
!> parameters as unknowns that differ from their null.
module diagnosis_wing_observed
  use base_kinds, only: rp
  use diagnosis_wing_bins, only: bin_rows, bins_t
  use diagnosis_wing_parameters, only: is_fit_case_for, make_fit_case, wing_parameter_tangent, fit_case_coordinates, fit_case_t, &
                                       wing_parameter_t
  use measurement_experiment, only: experiment_t
  use measurement_observed_wing, only: observed_wing_t, wing_patterns_t
  use measurement_simulation, only: simulation_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: diagnosed_wing_t

  type, extends(observed_wing_t) :: diagnosed_wing_t
    type(experiment_t), pointer, private :: bare => null() !< without unknowns
    type(wing_t), pointer, private :: wing => null()
    type(wing_parameter_t), allocatable, private :: parameters(:)
    type(bins_t), private :: bins
    type(fit_case_t), pointer, private :: fit_case => null() !< of the last coordinates, which are q
    real(rp), allocatable, private :: q(:)
  contains
    procedure :: init => wing_init
    procedure :: free => wing_free
    procedure :: take => wing_take
    procedure :: tangent => wing_tangent
    procedure :: count_rows => wing_count_rows
    procedure :: average => wing_average
  end type diagnosed_wing_t

contains

  !> Takes the experiment `bare`, without unknowns, and the wing. Both must live as long as this.
  subroutine wing_init(self, bare, wing, parameters, bins, patterns)
    class(diagnosed_wing_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(bins_t), intent(in) :: bins
    type(wing_patterns_t), intent(in) :: patterns
    call self%take_experiment(bare)
    self%n_coordinates = size(parameters)
    self%bare => bare
    self%wing => wing
    self%parameters = parameters
    self%bins = bins
    self%patterns = patterns
  end subroutine wing_init

  !> Releases everything.
  subroutine wing_free(self)
    class(diagnosed_wing_t), intent(inout) :: self
    if (associated(self%fit_case)) deallocate (self%fit_case)
  end subroutine wing_free

  !> See `observed_wing_t`. Makes a new experiment if the set of parameters that differ from their null has changed.
  subroutine wing_take(self, q, coordinates, is_other)
    class(diagnosed_wing_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    real(rp), allocatable, intent(out) :: coordinates(:)
    logical, intent(out) :: is_other
    if (.not. associated(self%fit_case)) allocate (self%fit_case)
    is_other = .not. is_fit_case_for(self%fit_case, self%parameters, q)
    if (is_other) call make_fit_case(self%bare, self%wing, self%parameters, q, self%fit_case)
    self%experiment => self%fit_case%experiment
    coordinates = fit_case_coordinates(self%fit_case, q)
    self%q = q
  end subroutine wing_take

  !> See `observed_wing_t`.
  subroutine wing_tangent(self, simulation, i, l, column)
    class(diagnosed_wing_t), intent(in) :: self
    class(simulation_t), intent(inout) :: simulation
    integer, intent(in) :: i, l
    real(rp), intent(out) :: column(:)
    call wing_parameter_tangent(simulation, self%fit_case, self%parameters, self%q, i, l, column)
  end subroutine wing_tangent

  !> See `observed_wing_t`.
  pure integer function wing_count_rows(self, l) result(n)
    class(diagnosed_wing_t), intent(in) :: self
    integer, intent(in) :: l
    n = self%bins%count(l)
  end function wing_count_rows

  !> See `observed_wing_t`.
  pure subroutine wing_average(self, l, column, rows)
    class(diagnosed_wing_t), intent(in) :: self
    integer, intent(in) :: l
    real(rp), intent(in) :: column(:)
    real(rp), intent(out) :: rows(:)
    call bin_rows(self%bins, l, column, rows)
  end subroutine wing_average
end module diagnosis_wing_observed
