! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes a wing from the coordinates of a task, and selects what is observed of it. This type is that of a training: the unknowns of
!> one experiment are the coordinates, and observations are not averaged. Other types extend it.
module measurement_observed_wing
  use base_errors, only: require
  use base_kinds, only: rp
  use measurement_experiment, only: experiment_t
  use measurement_simulation, only: simulation_t
  implicit none
  private
  public :: observed_wing_t, wing_patterns_t

  !> Holds patterns that stand for unknown causes: log stiffness in discs, and forces proportional to the load around the same
  !> sites.
  type :: wing_patterns_t
    real(rp), allocatable :: site(:, :)      !< (2, n) [m]; not allocated: there are none
    real(rp) :: radius = 0                   !< [m]
  contains
    procedure :: count => patterns_count
    procedure :: tangent => patterns_tangent
  end type wing_patterns_t

  type :: observed_wing_t
    integer :: n_coordinates = 0
    type(experiment_t), pointer :: experiment => null() !< experiment of the last coordinates; null before the first
    type(wing_patterns_t) :: patterns
    logical, private :: is_taken = .false.
  contains
    procedure :: take_experiment => wing_take_experiment
    procedure :: take => wing_take
    procedure :: tangent => wing_tangent
    procedure :: count_rows => wing_count_rows
    procedure :: average => wing_average
    procedure :: free => wing_free
  end type observed_wing_t

contains

  !> Begins with this experiment, which must live as long as the wing.
  subroutine wing_take_experiment(self, experiment)
    class(observed_wing_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: experiment
    call self%free()
    self%experiment => experiment
    self%n_coordinates = experiment%count()
  end subroutine wing_take_experiment

  !> Makes the wing at q, a point of the experiment with these `coordinates`. `is_other` tells whether the experiment changed.
  subroutine wing_take(self, q, coordinates, is_other)
    class(observed_wing_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    real(rp), allocatable, intent(out) :: coordinates(:)
    logical, intent(out) :: is_other
    call require(size(q) == self%n_coordinates, 'observed_wing_t: coordinates of this wing')
    coordinates = q
    is_other = .not. self%is_taken
    self%is_taken = .true.
  end subroutine wing_take

  !> Returns column(n), the derivative of the residuals of load l with respect to coordinate i, after `simulation` has computed them
  !> for this wing.
  subroutine wing_tangent(self, simulation, i, l, column)
    class(observed_wing_t), intent(in) :: self
    class(simulation_t), intent(inout) :: simulation
    integer, intent(in) :: i, l
    real(rp), intent(out) :: column(:)
    call simulation%derivative(self%experiment, l, i, column)
  end subroutine wing_tangent

  !> Returns the number of observations of load l.
  pure integer function wing_count_rows(self, l) result(n)
    class(observed_wing_t), intent(in) :: self
    integer, intent(in) :: l
    n = self%experiment%count_residuals(l)
  end function wing_count_rows

  !> Reduces the residuals of load l, or their derivatives, to the observations rows(count_rows(l)). Types that average heights
  !> return averages.
  pure subroutine wing_average(self, l, column, rows)
    class(observed_wing_t), intent(in) :: self
    integer, intent(in) :: l
    real(rp), intent(in) :: column(:)
    real(rp), intent(out) :: rows(:)
    rows = column(:self%count_rows(l))
  end subroutine wing_average

  !> Releases everything.
  subroutine wing_free(self)
    class(observed_wing_t), intent(inout) :: self
    self%is_taken = .false.
  end subroutine wing_free

  !> Returns the number of patterns.
  pure integer function patterns_count(self) result(n)
    class(wing_patterns_t), intent(in) :: self
    n = 0
    if (allocated(self%site)) n = 2*size(self%site, 2)
  end function patterns_count

  !> Returns column(n), the derivative of the residuals of load l with respect to pattern i, after `simulation` has computed the
  !> residuals. The patterns of stiffness at all sites come first, then those of forces.
  subroutine patterns_tangent(self, experiment, simulation, i, l, column)
    class(wing_patterns_t), intent(in) :: self
    type(experiment_t), intent(in) :: experiment
    class(simulation_t), intent(inout) :: simulation
    integer, intent(in) :: i, l
    real(rp), intent(out) :: column(:)
    real(rp), allocatable :: force(:, :)
    associate (n => size(self%site, 2))
      if (i <= n) then
        call simulation%damage_tangent(experiment, l, [self%site(:, i), self%radius], column)
      else
        allocate (force(3, experiment%model%n_all))
        call spread_force(experiment, l, self%site(:, i - n), self%radius, force)
        call simulation%force_tangent(experiment, l, force, column)
      end if
    end associate
  end subroutine patterns_tangent

  !> Returns the declared force of load l, spread over the wing around a site.
  subroutine spread_force(experiment, l, site, radius, force)
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(in) :: site(2), radius
    real(rp), intent(out) :: force(:, :)
    real(rp) :: weights(experiment%model%n_points)
    integer :: i
    associate (load => experiment%measurement%loads(l))
      do i = 1, size(weights)
        weights(i) = exp(-0.5_rp*sum((experiment%model%points(:2, i) - site)**2)/(0.7_rp*radius)**2)
      end do
      weights = weights/sum(weights)
      force = 0
      do i = 1, size(weights)
        force(:, i) = weights(i)*load%force*load%direction
      end do
    end associate
  end subroutine spread_force
end module measurement_observed_wing
