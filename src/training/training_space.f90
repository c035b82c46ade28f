! SPDX-License-Identifier: GPL-3.0-or-later
!> Maps the box of the search, whose sides are [0, 1], to coordinates of the experiment. No other module knows this map.
!> Unknowns may be fixed; the search then has fewer dimensions.
module training_space
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use cmaes_box, only: clip, cmaes_box_t, make_box
  use measurement_experiment, only: experiment_t
  use measurement_free_parameters, only: free_parameters_t
  implicit none
  private
  public :: search_space_t

  type :: search_space_t
    type(cmaes_box_t) :: box              !< of all unknowns, in their units
    logical, allocatable :: is_log(:)     !< the coordinate of the experiment is the logarithm
    integer, allocatable :: free(:)       !< unknowns that the search moves
    real(rp), allocatable :: fixed(:)     !< (unknowns) in [0, 1], values of the unknowns that are not free
    character(128), allocatable :: names(:)
    character(16), allocatable :: units(:)
  contains
    procedure :: init => space_init
    procedure :: fix => space_fix
    procedure :: values => space_values
    procedure :: coordinates => space_coordinates
    procedure :: point => space_point
    procedure :: whole => space_whole
  end type search_space_t

contains

  !> Makes all unknowns free: first the free parameters, then the offsets of observations.
  subroutine space_init(self, experiment, free_parameters)
    class(search_space_t), intent(out) :: self
    type(experiment_t), intent(in) :: experiment
    type(free_parameters_t), intent(in) :: free_parameters
    type(parameter_t) :: p
    real(rp) :: lower(experiment%count()), upper(experiment%count())
    logical :: on_log_scale(experiment%count())
    integer :: i, n
    n = experiment%count()
    allocate (self%is_log(n), self%names(n), self%units(n))
    allocate (self%fixed(n), source=0.5_rp)
    do i = 1, n
      p = experiment%describe(i)
      self%is_log(i) = p%is_log
      self%names(i) = p%name
      self%units(i) = p%unit
      lower(i) = p%lower
      upper(i) = p%upper
      on_log_scale(i) = .false.
      if (i > free_parameters%count()) cycle
      lower(i) = free_parameters%lower(i)
      upper(i) = free_parameters%upper(i)
      on_log_scale(i) = free_parameters%is_log(i)
    end do
    self%box = make_box(lower, upper, on_log_scale)
    self%free = [(i, i=1, n)]
  end subroutine space_init

  !> Fixes unknown i at its value in u, the coordinates of the free unknowns. Stores the values of all unknowns.
  subroutine space_fix(self, i, u)
    class(search_space_t), intent(inout) :: self
    integer, intent(in) :: i
    real(rp), intent(in) :: u(:)
    self%fixed(self%free) = u
    self%free = pack(self%free, self%free /= i)
  end subroutine space_fix

  !> Returns the values of all unknowns, in their units, at the point u of the free unknowns, clipped to the box.
  pure function space_values(self, u) result(values)
    class(search_space_t), intent(in) :: self
    real(rp), intent(in) :: u(:)
    real(rp) :: values(size(self%fixed))
    values = self%box%value(clip(self%whole(u)))
  end function space_values

  !> Returns the values of all unknowns in the box [0, 1] from those of the free unknowns.
  pure function space_whole(self, u) result(whole)
    class(search_space_t), intent(in) :: self
    real(rp), intent(in) :: u(:)
    real(rp) :: whole(size(self%fixed))
    whole = self%fixed
    whole(self%free) = u
  end function space_whole

  !> Returns the values of all unknowns at the point u as coordinates of the experiment.
  pure function space_coordinates(self, u) result(coordinates)
    class(search_space_t), intent(in) :: self
    real(rp), intent(in) :: u(:)
    real(rp) :: coordinates(size(self%fixed))
    coordinates = self%values(u)
    where (self%is_log) coordinates = log(merge(coordinates, 1.0_rp, self%is_log))
  end function space_coordinates

  !> Returns the point of the free unknowns that is nearest to these coordinates of the experiment.
  function space_point(self, coordinates) result(u)
    class(search_space_t), intent(in) :: self
    real(rp), intent(in) :: coordinates(:)
    real(rp) :: u(size(self%free)), whole(size(coordinates))
    whole = coordinates
    where (self%is_log) whole = exp(merge(coordinates, 0.0_rp, self%is_log))
    whole = max(self%box%lower, min(self%box%upper, whole))
    whole = clip(self%box%coordinate(whole))
    u = whole(self%free)
  end function space_point
end module training_space
