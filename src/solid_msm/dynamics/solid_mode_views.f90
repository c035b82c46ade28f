! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds how some views of the natural modes change with a parameter: linear functions a(phi_i) of their shapes, such as the
!> displacement of a point. The shapes themselves are not needed.
!>
!> All n modes form one cluster, so that the change W of phi_i lies outside of their span (solid_modal). With b_i = -M^(1/2) F f_i
!> and S_i = 1 - lambda_i A beside the known modes,
!>
!>     a(w_i) = (M^(-1/2) a) S_i^-1 b_i = (S_i^-1 M^(-1/2) a) b_i.
!>
!> S_i is symmetric. `init` solves with it once for each view and mode. A parameter then costs products of vectors alone, where
!> solid_modal solves equations for each parameter (the adjoint method, Cea 1986, doi:10.1051/m2an/1986200303711).
module solid_mode_views
  use base_errors, only: require
  use base_kinds, only: rp
  use base_lapack, only: multiply_transposed
  use solid_modal, only: changed_forces, flexibility, modal_t, note_stiffness, solve_beside
  use solid_stiffness, only: stiffness_t
  implicit none
  private
  public :: mode_views_t

  !> Views of the first n modes of a flat wing.
  type :: mode_views_t
    logical :: is_ready = .false.               !< `init` was called
    integer :: n = 0                            !< number of modes
    real(rp), allocatable :: of_modes(:, :)     !< (views, known modes) a(phi)
    real(rp), allocatable :: force(:, :)        !< (n, n) phi_j f_i at (j, i), for the last parameter
    real(rp), allocatable :: change(:, :)       !< (views, n) a(W) for the last parameter
    real(rp), allocatable, private :: by_force(:, :, :)   !< (3 n_free, n, views) K^-1 M^(1/2) S^-1 M^(-1/2) a
    real(rp), allocatable, private :: by_inertia(:, :, :) !< the same with F instead of K^-1
    real(rp), allocatable, private :: by_turn(:, :, :)    !< (2, n, views) R^T M^(1/2) S^-1 M^(-1/2) a
  contains
    procedure :: init => views_init
    procedure :: by_stiffness => views_by_stiffness
    procedure :: by_mass => views_by_mass
    procedure :: by_clamp => views_by_clamp
  end type mode_views_t

contains

  !> Takes the functions view(3, n_all, views) of the first n modes of `modal`, after its `solve`. They hold until the next `solve`.
  !> The wing must be unloaded.
  subroutine views_init(self, modal, n, view)
    class(mode_views_t), intent(inout) :: self
    type(modal_t), intent(in) :: modal
    integer, intent(in) :: n
    real(rp), intent(in) :: view(:, :, :)
    real(rp), allocatable :: a(:, :), g(:, :), lambda(:)
    integer :: v, i, m
    call require(.not. modal%is_bent, 'mode_views_t: the wing must be unloaded')
    m = size(modal%root_mass)
    self%n = n
    a = reshape(view(:, modal%model%movable, :), [m, size(view, 3)])
    allocate (g(m, n*size(a, 2)), lambda(n*size(a, 2)))
    if (allocated(self%of_modes)) deallocate (self%of_modes, self%force, self%change, self%by_turn)
    allocate (self%of_modes(size(a, 2), size(modal%flat, 2)), self%force(n, n), self%change(size(a, 2), n), &
              self%by_turn(2, n, size(a, 2)))
    call multiply_transposed(a, modal%flat, self%of_modes)
    do v = 1, size(a, 2)
      do i = 1, n
        g(:, (v - 1)*n + i) = a(:, v)/modal%root_mass
        lambda((v - 1)*n + i) = modal%lambda(i)
      end do
    end do
    call solve_beside(modal, lambda, g)
    do i = 1, size(g, 2)
      g(:, i) = modal%root_mass*g(:, i)
    end do
    self%by_inertia = reshape(flexibility(modal, g), [m, n, size(a, 2)])
    self%by_turn = reshape(matmul(transpose(modal%turns), g), [2, n, size(a, 2)])
    call modal%work%cholesky%solve(size(g, 2), g)
    self%by_force = reshape(g, [m, n, size(a, 2)])
    self%is_ready = .true.
  end subroutine views_init

  !> Finds `force` and `change` if all stiffness changes along `direction` (solid_stiffness_effects).
  subroutine views_by_stiffness(self, modal, direction)
    class(mode_views_t), intent(inout) :: self
    type(modal_t), intent(inout) :: modal
    type(stiffness_t), intent(in) :: direction
    real(rp), allocatable :: bent(:, :)
    real(rp) :: c(size(modal%lambda), self%n)
    integer :: i, v
    call note_stiffness(modal, direction)
    bent = changed_forces(modal, self%n)
    call multiply_transposed(modal%bent, bent, c)
    call take_known(self, modal, c)
    do v = 1, size(self%change, 1)
      do i = 1, self%n
        self%change(v, i) = self%change(v, i) - dot_product(self%by_force(:, i, v), bent(:, i))
      end do
    end do
  end subroutine views_by_stiffness

  !> Finds `force` and `change` if the masses change along direction(3, n_all) [kg per unit].
  subroutine views_by_mass(self, modal, direction)
    class(mode_views_t), intent(inout) :: self
    type(modal_t), intent(in) :: modal
    real(rp), intent(in) :: direction(:, :)
    real(rp) :: dm(size(modal%root_mass)), inert(size(dm), self%n), c(size(modal%lambda), self%n)
    integer :: i, v
    dm = reshape(direction(:, modal%model%movable), [size(dm)])
    do i = 1, self%n
      inert(:, i) = modal%lambda(i)*dm*modal%flat(:, i)
    end do
    call multiply_transposed(modal%flat, inert, c)
    c = -c
    call take_known(self, modal, c)
    do v = 1, size(self%change, 1)
      do i = 1, self%n
        self%change(v, i) = self%change(v, i) + dot_product(self%by_inertia(:, i, v), inert(:, i))
      end do
    end do
  end subroutine views_by_mass

  !> Finds `force` and `change` if the compliance of the clamp about axis k (1: x, 2: y) changes [per rad/(N m)].
  subroutine views_by_clamp(self, modal, k)
    class(mode_views_t), intent(inout) :: self
    type(modal_t), intent(in) :: modal
    integer, intent(in) :: k
    real(rp) :: c(size(modal%lambda), self%n)
    integer :: i, j, v
    do i = 1, self%n
      do j = 1, size(c, 1)
        c(j, i) = -modal%moment(k, i)*modal%moment(k, j)
      end do
    end do
    call take_known(self, modal, c)
    do v = 1, size(self%change, 1)
      do i = 1, self%n
        self%change(v, i) = self%change(v, i) + self%by_turn(k, i, v)*modal%moment(k, i)
      end do
    end do
  end subroutine views_by_clamp

  !> Sets `force` from c(known modes, n) = phi_j f_i, and `change` to the part along the known modes outside of the cluster.
  subroutine take_known(self, modal, c)
    class(mode_views_t), intent(inout) :: self
    type(modal_t), intent(in) :: modal
    real(rp), intent(in) :: c(:, :)
    integer :: i, j
    self%force = c(:self%n, :)
    self%change = 0
    do i = 1, self%n
      do j = self%n + 1, size(c, 1)
        self%change(:, i) = self%change(:, i) - c(j, i)/(modal%lambda(j) - modal%lambda(i))*self%of_modes(:, j)
      end do
    end do
  end subroutine take_known
end module solid_mode_views
