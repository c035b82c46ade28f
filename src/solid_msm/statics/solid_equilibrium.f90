! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes residual, potential and factorised tangent of the static problem at one stage of its loading path, and holds the
!> work arrays of the statics.
!>
!> At stage t of a path from the unloaded state the residual is dE/du - t F. For a warm start with the residual g0 it is dE/du - F
!> - (1 - t) g0, which transforms the old problem into the new one. For dead loads both are the same; for loads that follow the
!> wing only the first is a growing load.
module solid_equilibrium
  use base_kinds, only: rp
  use solid_cholesky, only: cholesky_t
  use solid_extension, only: extension_axial
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_tangent, only: assemble_tangent
  implicit none
  private
  public :: equilibrium_t

  !> One object per model and thread. `init` does the symbolic analysis; nothing is allocated afterwards.
  type :: equilibrium_t
    type(cholesky_t) :: cholesky
    real(rp), allocatable :: blocks(:, :, :), values(:), right_hand_side(:, :)
    real(rp), allocatable :: start_residual(:, :) !< (3, n_all) g0
    real(rp) :: stage = 0                         !< t
    logical :: is_growing = .false.               !< the load grows: the path began at the unloaded state
    real(rp) :: force_scale = 0                   !< [N] scale of residuals
    real(rp), dimension(:, :), allocatable :: g, du, trial, old, older, kept, kept_g, last_du, step !< (3, n_all) scratch
    real(rp), allocatable :: axial(:)             !< (springs) [N] independent axial forces of the iteration
    real(rp), allocatable :: kept_axial(:)       !< scratch
    real(rp), allocatable :: here_axial(:), old_axial(:), older_axial(:) !< of the last three points of a path
  contains
    procedure :: init => equilibrium_init
    procedure :: free => equilibrium_free
    procedure :: start => equilibrium_start
    procedure :: residual => equilibrium_residual
    procedure :: potential => equilibrium_potential
    procedure :: factorise => equilibrium_factorise
    procedure :: newton_step => equilibrium_newton_step
    procedure :: law_axial => equilibrium_law_axial
  end type equilibrium_t

contains

  !> Allocates everything, and analyses the pattern of the tangent of this model.
  subroutine equilibrium_init(self, model)
    class(equilibrium_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    integer :: n, n_springs
    n = model%n_all
    n_springs = model%springs%n
    call self%free()
    allocate (self%blocks(3, 3, size(model%pattern%rows)), self%values(size(model%pattern%rowind)), &
              self%right_hand_side(3, model%n_free), self%start_residual(3, n), self%g(3, n), &
              self%du(3, n), self%trial(3, n), self%old(3, n), self%older(3, n), self%kept(3, n), &
              self%kept_g(3, n), self%last_du(3, n), self%step(3, n), self%axial(n_springs), &
              self%here_axial(n_springs), self%old_axial(n_springs), &
              self%older_axial(n_springs), self%kept_axial(n_springs), source=0.0_rp)
    call self%cholesky%init(model%pattern%colptr, model%pattern%rowind)
  end subroutine equilibrium_init

  !> Releases the factorisation and the arrays.
  subroutine equilibrium_free(self)
    class(equilibrium_t), intent(inout) :: self
    call self%cholesky%free()
    if (.not. allocated(self%blocks)) return
    deallocate (self%blocks, self%values, self%right_hand_side, self%start_residual, self%g, self%du, &
                self%trial, self%old, self%older, self%kept, self%kept_g, self%last_du, self%step, self%axial, &
                self%here_axial, self%old_axial, self%older_axial, self%kept_axial)
  end subroutine equilibrium_free

  !> Begins a path at displacements u(3, n_all) [m].
  subroutine equilibrium_start(self, model, load, u)
    class(equilibrium_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: u(:, :)
    real(rp), parameter :: UNLOADED = 1.0e-6_rp ! scale of residuals without load
    self%is_growing = .not. any(abs(u) > 0)
    self%stage = 1
    call self%residual(model, load, u, self%start_residual)
    self%stage = 0
    self%g = 0
    call load%subtract_from(model, u, 1.0_rp, self%g)
    call model%zero_clamped(self%g)
    self%force_scale = norm2(self%g)
    if (.not. self%force_scale > 0) self%force_scale = &
      max(norm2(self%start_residual), UNLOADED*model%params%k_vein*model%size)
    self%g = 0
  end subroutine equilibrium_start

  !> Sets g(3, n_all) [N] to the residual at u plus the much smaller `low`, both (3, n_all) [m]; it is zero at clamped points.
  subroutine equilibrium_residual(self, model, load, u, g, low)
    class(equilibrium_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(inout) :: g(:, :)
    real(rp), intent(in), optional :: low(:, :)
    call model%gradient(u, g, low=low)
    call load%subtract_from(model, u, load_factor(self), g)
    if (self%stage < 1 .and. .not. self%is_growing) g = g - (1 - self%stage)*self%start_residual
    call model%zero_clamped(g)
  end subroutine equilibrium_residual

  !> Returns the factor on the load at the stage of the path.
  pure real(rp) function load_factor(self)
    class(equilibrium_t), intent(in) :: self
    load_factor = merge(self%stage, 1.0_rp, self%is_growing)
  end function load_factor

  !> Returns the potential [J] whose gradient the residual is.
  real(rp) function equilibrium_potential(self, model, load, u) result(potential)
    class(equilibrium_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: u(:, :)
    potential = model%energy(u) - load%work(model, u, load_factor(self))
    if (self%stage < 1 .and. .not. self%is_growing) potential = potential - (1 - self%stage)*sum(self%start_residual*u)
  end function equilibrium_potential

  !> Factorises the tangent at u(3, n_all) [m] with the independent axial forces `self%axial`, or its positive semidefinite part,
  !> plus `shift` [N/m] times the weights of the points. `is_spd` tells whether it is positive definite.
  subroutine equilibrium_factorise(self, model, load, u, semidefinite, shift, is_spd)
    class(equilibrium_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(load_t), intent(in) :: load
    real(rp), intent(in) :: u(:, :), shift
    logical, intent(in) :: semidefinite
    logical, intent(out) :: is_spd
    call assemble_tangent(model, u, self%axial, semidefinite, self%blocks)
    call load%subtract_tangent(model, u, load_factor(self), self%blocks)
    call model%pattern%add_diagonal(model%weights, shift, self%blocks)
    call model%pattern%pack(self%blocks, self%values)
    call self%cholesky%factorise(self%values, is_spd)
  end subroutine equilibrium_factorise

  !> Sets self%du(3, n_all) [m] to - K^-1 g, with the last factorisation K, for g(3, n_all) [N].
  subroutine equilibrium_newton_step(self, model, g)
    class(equilibrium_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: g(:, :)
    integer :: i
    do i = 1, model%n_free
      self%right_hand_side(:, i) = -g(:, model%movable(i))
    end do
    call self%cholesky%solve(1, self%right_hand_side)
    do i = 1, model%n_free
      self%du(:, model%movable(i)) = self%right_hand_side(:, i)
    end do
  end subroutine equilibrium_newton_step

  !> Sets the axial forces to those of the springs' law at u(3, n_all) [m].
  subroutine equilibrium_law_axial(self, model, u)
    class(equilibrium_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :)
    call extension_axial(model%springs, model%stiffness%extension, u, self%axial)
  end subroutine equilibrium_law_axial
end module solid_equilibrium
