! SPDX-License-Identifier: GPL-3.0-or-later
!> Joins the residuals of the records of all cases that were flown, one case after another: see diagnosis_wing_flight. Changes of
!> kinematics and flow that all cases share, and errors of the balance, act on all records. Errors of one case act on its records
!> alone.
module diagnosis_wing_flights
  use base_kinds, only: rp
  use diagnosis_flight_data, only: flight_cases_t
  use diagnosis_wing_flight, only: wing_flight_t
  use diagnosis_wing_parameters, only: wing_parameter_t
  use inference_simulator, only: labels_t
  use measurement_flight, only: measured_flight_t
  implicit none
  private
  public :: wing_flights_t

  type :: wing_flights_t
    integer :: n = 0                !< observations
    integer :: n_nuisances = 0
    integer :: n_patterns = 0       !< of unknown causes
    type(wing_flight_t), allocatable, private :: parts(:) !< (cases)
    !> Numbers of observations, nuisances and patterns before those of each case.
    integer, allocatable, private :: row(:), pattern(:)
    integer, allocatable :: nuisance(:)
  contains
    procedure :: init => flights_init
    procedure :: add => flights_add
    procedure :: use => flights_use
    procedure :: evaluate => flights_evaluate
    procedure :: nuisances => flights_nuisances
    procedure :: patterns => flights_patterns
    procedure :: append_labels => flights_append_labels
    procedure :: covariance => flights_covariance
  end type wing_flights_t

contains

  !> Takes the measured records `flights` in the order of their cases, the parameters of the model in the order of their
  !> coordinates, and the results of the simulated flights.
  subroutine flights_init(self, flights, parameters, data)
    class(wing_flights_t), intent(inout) :: self
    type(measured_flight_t), intent(in) :: flights(:)
    type(wing_parameter_t), intent(in) :: parameters(:)
    type(flight_cases_t), intent(in) :: data
    integer :: k, n
    n = size(data%cases)
    allocate (self%parts(n), self%row(n), self%nuisance(n), self%pattern(n))
    do k = 1, n
      associate (part => self%parts(k), case => data%cases(k))
        call part%init(flights(case%first:case%last), parameters, case)
        self%row(k) = self%n
        self%nuisance(k) = self%n_nuisances
        self%pattern(k) = self%n_patterns
        self%n = self%n + part%n
        self%n_nuisances = self%n_nuisances + part%n_nuisances
        self%n_patterns = self%n_patterns + part%n_patterns
      end associate
    end do
  end subroutine flights_init

  !> Keeps the approximations about fitted values that each case has as number i. Returns their common number for `use`.
  subroutine flights_add(self, data, i, number)
    class(wing_flights_t), intent(inout) :: self
    type(flight_cases_t), intent(in) :: data
    integer, intent(in) :: i
    integer, intent(out) :: number
    integer :: k
    number = 1
    do k = 1, size(self%parts)
      call self%parts(k)%add(data%cases(k)%again(i), data%cases(k)%facts, number)
    end do
  end subroutine flights_add

  !> Uses approximations that `add` numbered; 1 are those about the cases. Without records nothing happens.
  subroutine flights_use(self, number)
    class(wing_flights_t), intent(inout) :: self
    integer, intent(in) :: number
    integer :: k
    if (self%n == 0) return
    do k = 1, size(self%parts)
      call self%parts(k)%use(number)
    end do
  end subroutine flights_use

  !> Returns the residuals(n) at the coordinates q and their derivatives jacobian(n, size(columns)).
  subroutine flights_evaluate(self, q, columns, residuals, jacobian)
    class(wing_flights_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    integer, intent(in) :: columns(:)
    real(rp), intent(out) :: residuals(:), jacobian(:, :)
    integer :: k
    do k = 1, size(self%parts)
      associate (a => self%row(k) + 1, b => self%row(k) + self%parts(k)%n)
        call self%parts(k)%evaluate(q, columns, residuals(a:b), jacobian(a:b, :))
      end associate
    end do
  end subroutine flights_evaluate

  !> Returns nuisances(n, n_nuisances) at q. Those of case k begin behind number nuisance(k), and are 0 in the records of others.
  subroutine flights_nuisances(self, q, nuisances)
    class(wing_flights_t), intent(in) :: self
    real(rp), intent(in) :: q(:)
    real(rp), intent(inout) :: nuisances(:, :)
    integer :: k
    nuisances = 0
    do k = 1, size(self%parts)
      associate (a => self%row(k), i => self%nuisance(k), part => self%parts(k))
        call part%nuisances(q, nuisances(a + 1:a + part%n, i + 1:i + part%n_nuisances))
      end associate
    end do
  end subroutine flights_nuisances

  !> Returns patterns(n, n_patterns), the effects of unknown causes, each in one record.
  subroutine flights_patterns(self, patterns)
    class(wing_flights_t), intent(in) :: self
    real(rp), intent(inout) :: patterns(:, :)
    integer :: k
    patterns = 0
    do k = 1, size(self%parts)
      associate (a => self%row(k), i => self%pattern(k), part => self%parts(k))
        call part%patterns(patterns(a + 1:a + part%n, i + 1:i + part%n_patterns))
      end associate
    end do
  end subroutine flights_patterns

  !> Appends the labels of the observations.
  subroutine flights_append_labels(self, labels)
    class(wing_flights_t), intent(in) :: self
    type(labels_t), intent(inout) :: labels
    integer :: k
    do k = 1, size(self%parts)
      call self%parts(k)%append_labels(labels)
    end do
  end subroutine flights_append_labels

  !> Returns in c the covariance, in units of the sd, of the observations `rows`, which belong to one block.
  pure subroutine flights_covariance(self, rows, c)
    class(wing_flights_t), intent(in) :: self
    integer, intent(in) :: rows(:)
    real(rp), intent(out) :: c(:, :)
    integer :: k
    k = count(self%row < minval(rows))
    call self%parts(k)%covariance(rows - self%row(k), c)
  end subroutine flights_covariance
end module diagnosis_wing_flights
