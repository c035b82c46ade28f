! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds how the modes of a wing in one medium change with a parameter, as far as the records of its motion there see it: their
!> forces, and the displacements of the traces, the excitation and a motion of the base. Rubbing joints and drag see whole shapes,
!> which cost equations for every parameter; what all others see costs products of vectors (solid_mode_views).
module measurement_series_slopes
  use base_kinds, only: rp
  use measurement_series_projections, only: no_matrix
  use solid_modal, only: modal_t, mode_slopes_t
  use solid_mode_views, only: mode_views_t
  use solid_ringing, only: ring_change_t
  use solid_stiffness, only: stiffness_t
  implicit none
  private
  public :: series_slopes_t

  type :: series_slopes_t
    logical :: is_ready = .false.                 !< `init` was called
    logical :: has_shapes = .false.               !< whole shapes are found
    integer :: n = 0                              !< number of modes in the motion
    real(rp), allocatable :: shapes(:, :, :)      !< (3, n_all, n) change of the shapes beside all n modes, if `has_shapes`
    type(ring_change_t) :: change                 !< of the reduced equations by the last parameter: stiffness and mass
    real(rp), allocatable, private :: view(:, :, :)
    real(rp), allocatable, private :: seen(:, :)  !< (views, n)
    type(mode_views_t), private :: views
    type(mode_slopes_t), private :: slopes
    logical, allocatable, private :: same(:, :)
  contains
    procedure :: init => slopes_init
    procedure :: by_stiffness => slopes_by_stiffness
    procedure :: by_mass => slopes_by_mass
    procedure :: by_clamp => slopes_by_clamp
    procedure :: take => slopes_take
  end type series_slopes_t

contains

  !> Takes view(3, n_all, views), what the records see of the first n modes of `modal`, after its `solve` (see record_views). This
  !> holds until the next `solve`.
  subroutine slopes_init(self, modal, n, view, has_shapes)
    class(series_slopes_t), intent(inout) :: self
    type(modal_t), intent(in) :: modal
    integer, intent(in) :: n
    real(rp), intent(in) :: view(:, :, :)
    logical, intent(in) :: has_shapes
    self%n = n
    self%has_shapes = has_shapes
    self%view = view
    if (allocated(self%seen)) deallocate (self%seen)
    allocate (self%seen(size(view, 3), n), source=0.0_rp)
    if (has_shapes) then
      if (allocated(self%same)) deallocate (self%same)
      allocate (self%same(n, n), source=.true.)
      if (allocated(self%slopes%shapes)) deallocate (self%slopes%shapes)
    else
      call self%views%init(modal, n, view)
    end if
    self%is_ready = .true.
  end subroutine slopes_init

  !> Finds the change if all stiffness changes along `direction` (solid_stiffness_effects).
  subroutine slopes_by_stiffness(self, modal, direction)
    class(series_slopes_t), intent(inout) :: self
    type(modal_t), intent(inout) :: modal
    type(stiffness_t), intent(in) :: direction
    if (self%has_shapes) then
      call modal%slopes_of_stiffness(direction, self%same, self%slopes)
    else
      call self%views%by_stiffness(modal, direction)
    end if
    call keep_stiffness(self)
  end subroutine slopes_by_stiffness

  !> Finds the change if the compliance of the clamp about axis k (1: x, 2: y) changes [per rad/(N m)].
  subroutine slopes_by_clamp(self, modal, k)
    class(series_slopes_t), intent(inout) :: self
    type(modal_t), intent(inout) :: modal
    integer, intent(in) :: k
    if (self%has_shapes) then
      call modal%slopes_of_clamp(k, self%same, self%slopes)
    else
      call self%views%by_clamp(modal, k)
    end if
    call keep_stiffness(self)
  end subroutine slopes_by_clamp

  !> Stores a change of stiffness.
  subroutine keep_stiffness(self)
    class(series_slopes_t), intent(inout) :: self
    self%change%mass = no_matrix()
    if (self%has_shapes) then
      self%change%stiffness = self%slopes%force
      call see(self)
    else
      self%change%stiffness = self%views%force
      self%seen = self%views%change
    end if
  end subroutine keep_stiffness

  !> Finds the change if the masses change along direction(3, n_all) [kg per unit].
  subroutine slopes_by_mass(self, modal, direction)
    class(series_slopes_t), intent(inout) :: self
    type(modal_t), intent(inout) :: modal
    real(rp), intent(in) :: direction(:, :)
    integer :: i
    self%change%stiffness = no_matrix()
    if (self%has_shapes) then
      call modal%slopes_of_mass(direction, self%same, self%slopes)
      self%change%mass = self%slopes%force
    else
      call self%views%by_mass(modal, direction)
      self%change%mass = self%views%force
      self%seen = self%views%change
    end if
    do i = 1, self%n
      self%change%mass(:, i) = -self%change%mass(:, i)/modal%lambda(i)
      if (self%has_shapes) self%slopes%shapes(:, :, i) = self%slopes%shapes(:, :, i) + &
                                                         0.5_rp*self%change%mass(i, i)*modal%shapes(:, :, i)
    end do
    if (self%has_shapes) call see(self)
  end subroutine slopes_by_mass

  !> Keeps the shapes and what the records see of them.
  subroutine see(self)
    class(series_slopes_t), intent(inout) :: self
    integer :: i, v
    self%shapes = self%slopes%shapes
    do i = 1, self%n
      do v = 1, size(self%view, 3)
        self%seen(v, i) = sum(self%view(:, :, v)*self%shapes(:, :, i))
      end do
    end do
  end subroutine see

  !> Sets the parts of `change` that a record with n traces sees by its views first to first + n + 1, of which the last ones are
  !> excitation and motion of the base. `n_dragged` is the number of points that meet with drag.
  subroutine slopes_take(self, first, n, n_dragged, change)
    class(series_slopes_t), intent(in) :: self
    integer, intent(in) :: first, n, n_dragged
    type(ring_change_t), intent(inout) :: change
    change%observation = self%seen(first:first + n - 1, :)
    change%forcing = self%seen(first + n, :)
    change%shaken = self%seen(first + n + 1, :)
    change%across = no_matrix()
    if (self%has_shapes) change%across = self%shapes(3, :n_dragged, :)
  end subroutine slopes_take
end module measurement_series_slopes
