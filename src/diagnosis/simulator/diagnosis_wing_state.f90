! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the state of a simulator of a wing: the shapes from which solutions begin, the errors about which the nuisances are linear,
!> and the flight about which forces over the beat are approximated.
module diagnosis_wing_state
  use base_errors, only: require
  use base_kinds, only: rp
  use least_squares_state, only: solver_state_t
  use measurement_bending_state, only: bending_state_t
  use measurement_experiment, only: experiment_t
  implicit none
  private
  public :: wing_state, wing_state_t

  type, extends(bending_state_t) :: wing_state_t
    real(rp), allocatable :: error_directions(:, :) !< (n, :) further directions of errors, of the mesh for instance
    real(rp), allocatable :: load_offset(:, :) !< (2, loads) [m] errors of positions about which the nuisances are linear
    integer :: flight = 1                    !< number of the approximation of flights, see wing_flight_t
    real(rp), allocatable :: linear(:)       !< (n) linear effect of these errors, by the tangents there
  contains
    procedure :: init => state_init
    procedure :: start_from_mesh => state_start_from_mesh
    procedure :: move_loads => state_move_loads
  end type wing_state_t

contains

  !> Makes the state at rest for n observations, n_bent of which belong to loads. It has shapes(3, n_all, n_loads).
  subroutine state_init(self, n, n_bent, n_all, n_loads)
    class(wing_state_t), intent(out) :: self
    integer, intent(in) :: n, n_bent, n_all, n_loads
    call self%init_shapes(n_all, n_loads)
    allocate (self%error_directions(n, 0), self%load_offset(2, n_loads), self%linear(n_bent), source=0.0_rp)
  end subroutine state_init

  !> Takes the shapes and the errors of `other`, a state of the same loads on a mesh of half or of twice the size. This mesh has
  !> n_points points. parents(2, points of the finer mesh) are the points of the coarser mesh between which each of them lies.
  subroutine state_start_from_mesh(self, other, n_points, parents)
    class(wing_state_t), intent(inout) :: self
    type(wing_state_t), intent(in) :: other
    integer, intent(in) :: n_points, parents(:, :)
    self%shapes = 0 ! ghost points do not move
    if (n_points == size(parents, 2)) then
      self%shapes(:, :n_points, :) = 0.5_rp*(other%shapes(:, parents(1, :), :) + other%shapes(:, parents(2, :), :))
    else
      self%shapes(:, :n_points, :) = other%shapes(:, :n_points, :)
    end if
    self%is_start = other%is_start
    self%load_offset = other%load_offset
    self%linear = other%linear
  end subroutine state_start_from_mesh

  !> Returns `state` as the state of a wing. Stops the program if it is another.
  function wing_state(state) result(own)
    class(solver_state_t), intent(in) :: state
    type(wing_state_t) :: own
    select type (state)
    type is (wing_state_t)
      own = state
    class default
      call require(.false., 'wing_state: the state must be one of a wing')
    end select
  end function wing_state

  !> Moves every load to the position where it acts with these errors of positions. Those of load l are errors(v + 1:v + 2),
  !> v = (l - 1) stride + 1.
  subroutine state_move_loads(self, experiment, errors, stride)
    class(wing_state_t), intent(inout) :: self
    type(experiment_t), intent(in) :: experiment
    real(rp), intent(in) :: errors(:)
    integer, intent(in) :: stride
    integer :: l
    do l = 1, size(self%load_offset, 2)
      self%load_offset(:, l) = offset_on_wing(experiment, l, errors((l - 1)*stride + 2:(l - 1)*stride + 3))
    end do
  end subroutine state_move_loads

  !> Returns the offset(2) [m] of load l from its declared position, for errors(2) of this position in units of their sd. Errors are
  !> limited to MOST sd, and reduced further where the position would not be on the wing.
  function offset_on_wing(experiment, l, errors) result(offset)
    type(experiment_t), intent(in) :: experiment
    integer, intent(in) :: l
    real(rp), intent(in) :: errors(2)
    real(rp), parameter :: MOST = 5.0_rp, LEAST = 0.01_rp
    real(rp) :: offset(2), e(2)
    associate (sd => experiment%measurement%accuracy%position)
      e = max(-MOST, min(MOST, errors))
      do while (.not. experiment%acts_on_wing(l, sd*e) .and. maxval(abs(e)) > LEAST)
        e = e/2
      end do
      offset = sd*merge(e, 0.0_rp, maxval(abs(e)) > LEAST)
    end associate
  end function offset_on_wing
end module diagnosis_wing_state
