! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the residuals of the records of a vibrating wing in units of their sd (the covariance is the unit matrix), and exact
!> tangents of all parameters of the catalogue. The size and the time of every excitation are nuisances, and errors of the sensors
!> are unknown causes. Each trace is a surface and a fold by itself. Without records there are no observations here.
module diagnosis_wing_series
  use base_kinds, only: rp
  use diagnosis_moving_wing, only: moving_wing_t
  use diagnosis_wing_labels, only: append_surface
  use diagnosis_wing_parameters, only: wing_parameter_t, KIND_SHAKE
  use diagnosis_wing_rest, only: damping_at, shake_at, shake_of
  use inference_simulator, only: labels_t
  use measurement_experiment, only: experiment_t
  use measurement_motion_simulation, only: motion_simulation_t
  use measurement_series_sensors, only: put_late_errors, put_sensor_errors, N_SENSOR_ERRORS
  use measurement_series_simulation, only: series_simulation_t
  use solid_mass_effects, only: mass_parts_t
  use solid_model, only: solid_model_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: wing_series_t

  type, extends(moving_wing_t) :: wing_series_t
    type(series_simulation_t), pointer :: simulation => null() !< one for each simulator. It is never copied.
    integer :: n_sensor_errors = 0                             !< patterns of unknown causes
  contains
    procedure :: init => series_init
    procedure :: take_model => series_take_model
    procedure :: evaluate => series_evaluate
    procedure :: tangent => series_tangent
    procedure :: nuisances => series_nuisances
    procedure :: sensor_errors => series_sensor_errors
    procedure :: append_labels => series_append_labels
  end type wing_series_t

contains

  !> Takes the records of the measurement of `bare`, on a wing of these masses. Both must live as long as this.
  subroutine series_init(self, bare, wing, parameters, parts)
    class(wing_series_t), intent(inout) :: self
    type(experiment_t), intent(in), target :: bare
    type(wing_t), intent(in), target :: wing
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(mass_parts_t), intent(in) :: parts
    class(motion_simulation_t), pointer :: mechanics
    integer :: i
    allocate (self%simulation)
    mechanics => self%simulation
    call self%start(mechanics, bare, wing, parameters, parts)
    associate (series => bare%measurement%series)
      self%n_nuisances = 3*size(series)
      self%n_sensor_errors = N_SENSOR_ERRORS*sum([(size(series(i)%sigma), i=1, size(series))])
    end associate
  end subroutine series_init

  !> Gives the simulation this model of the wing at rest.
  subroutine series_take_model(self, model)
    class(wing_series_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    call self%simulation%init(self%rest%bare%measurement, model, self%parts)
  end subroutine series_take_model

  !> Computes residuals(n) at q, about which later tangents are taken. `ok` is false if the wing at rest is not stable.
  subroutine series_evaluate(self, q, residuals, ok)
    class(wing_series_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(out) :: residuals(:)
    logical, intent(out) :: ok
    type(solid_model_t), pointer :: model
    ok = self%is_at(q)
    if (ok) then
      call self%take_last(residuals)
      return
    end if
    call self%forget()
    residuals = 0
    call self%prepare(q, ok)
    if (.not. ok) return
    model => self%simulation%model()
    self%simulation%shake = shake_at(self%rest%parameters, q)
    call self%simulation%evaluate(self%rest%params(model, q), self%effects, damping_at(self%rest%parameters, q), residuals, ok)
    call self%keep(q, residuals, ok)
  end subroutine series_evaluate

  !> Returns column(n), the derivative of the residuals with respect to parameter i at q, after `evaluate` there.
  subroutine series_tangent(self, q, i, column)
    class(wing_series_t), intent(inout) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: i
    real(rp), intent(out) :: column(:)
    column = 0
    associate (one => self%rest%parameters(i))
      select case (one%kind)
      case (KIND_SHAKE)
        call self%simulation%shake_tangent(one%number, shake_of(self%rest%parameters, i, q), column)
      case default
        call self%mechanics_tangent(q, i, column)
      end select
    end associate
  end subroutine series_tangent

  !> Computes nuisances(n, n_nuisances), the effects on the residuals of errors of one sd of the sizes and times of the excitations,
  !> two for each record, and then what is of second order in those of the times; at the point of the last `evaluate`.
  subroutine series_nuisances(self, nuisances)
    class(wing_series_t), intent(inout) :: self
    real(rp), intent(inout) :: nuisances(:, :)
    integer :: n
    n = 2*size(self%simulation%series)
    call self%simulation%nuisances(nuisances(:, :n))
    call put_late_errors(self%simulation, nuisances(:, n + 1:))
  end subroutine series_nuisances

  !> Computes patterns(n, n_sensor_errors), the effects on the residuals of errors of the sensors, at the point of the last
  !> `evaluate`.
  subroutine series_sensor_errors(self, patterns)
    class(wing_series_t), intent(in) :: self
    real(rp), intent(inout) :: patterns(:, :)
    call put_sensor_errors(self%simulation, patterns)
  end subroutine series_sensor_errors

  !> Adds labels. Every trace is a surface with its own fold and block.
  subroutine series_append_labels(self, labels)
    class(wing_series_t), intent(in) :: self
    type(labels_t), intent(inout) :: labels
    integer :: i, j, n
    do i = 1, size(self%simulation%series)
      associate (s => self%simulation%series(i))
        do j = 1, size(s%sigma)
          n = count(s%is_known(:, j))
          if (n == 0) cycle
          call append_surface(labels, n, s%place(:, j))
          labels%stage(size(labels%stage) - n + 1:) = stages_of(pack(s%values(:, j), s%is_known(:, j)), s%sigma(j))
        end do
      end associate
    end do
  end subroutine series_append_labels

  !> Returns when each value of a trace joins the first fit of the baseline (inference_growing_fit): 0 for its first eight periods,
  !> k for those up to 2^k times as many. A period has two changes of sign about the mean, each by more than sigma, the sd of a
  !> value.
  pure function stages_of(values, sigma) result(stage)
    real(rp), intent(in) :: values(:), sigma
    integer :: stage(size(values))
    integer, parameter :: FIRST = 16 !< changes of sign
    real(rp) :: mean, side
    integer :: i, changes
    mean = sum(values)/size(values)
    changes = 0
    stage = 0
    side = values(1) - mean
    do i = 2, size(values)
      if (side*(values(i) - mean) < 0 .and. abs(values(i) - mean) > sigma) then
        changes = changes + 1
        side = values(i) - mean
      end if
      stage(i) = stage(i - 1)
      if (changes > FIRST*2**stage(i)) stage(i) = stage(i) + 1
    end do
  end function stages_of
end module diagnosis_wing_series
