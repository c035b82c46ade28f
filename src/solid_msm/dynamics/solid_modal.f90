! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the natural modes of a wing about its unloaded shape or its shape under dead loads, and their exact derivatives.
!>
!>     K phi_i = lambda_i M phi_i,   lambda = omega^2,   phi_i M phi_j = 1 if i = j, else 0
!>
!> K is the tangent stiffness of the flat wing or, after `bend`, at the equilibrium u under the load, including the geometric
!> stiffness of the axial forces. M = diag(mass) has a mass for every direction of every point. A parameter p moves the equilibrium
!> by du/dp = -K^-1 (dg/dp - dF/dp). Then dK is the change of K at a fixed shape plus K'[du/dp] (solid_tangent_change). A clamp of
!> compliance C (root_twist, root_flap) turns by C times the moment of the forces on it. With R_k the rigid rotation about axis k,
!> K^-1 becomes F = K^-1 + R C R^T, and the iteration needs only F. The part of a mode that bends the wing is psi = lambda K^-1 M
!> phi.
!>
!> A block Lanczos iteration with A = M^(1/2) F M^(1/2) finds the modes; K is factorised once. The iteration ends when the residuals
!> are small, and not only the changes of lambda, because the derivatives need the shapes. Derivatives, with f_i = (dF^-1 - lambda_i
!> dM) phi_i (Fox & Kapoor 1968, doi:10.2514/3.5008; Nelson 1976, doi:10.2514/3.7211):
!>
!>     dlambda_i = phi_i f_i,    dphi_i = sum over j of c_ij phi_j + w,    c_ii = - phi_i dM phi_i/2,
!>     c_ij = - phi_j f_i/(lambda_j - lambda_i),   (1 - lambda_i F M) w = - F f_i without all modes that are known.
!>
!> The sum runs over all known modes. Nelson factorises a matrix for each mode; here conjugate gradients find w with the factors of
!> K. If modes i and j lie in one cluster (`same`), c_ij is left out, because only the space that they span has a derivative.
module solid_modal
  use base_constants, only: TWO_PI
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_lapack, only: multiply, multiply_transposed
  use solid_effects, only: clamp_compliance
  use solid_equilibrium, only: equilibrium_t
  use solid_extension, only: extension_axial
  use solid_lanczos, only: find_largest, symmetric_operator_t
  use solid_loads, only: load_t
  use solid_model, only: solid_model_t
  use solid_sensitivity, only: direction_sensitivity, force_sensitivity
  use solid_statics, only: solve_static, static_options_t, static_report_t
  use solid_stiffness, only: stiffness_t
  use solid_tangent, only: assemble_tangent
  use solid_tangent_change, only: add_tangent_change
  use solid_vectors, only: cross, IDENTITY
  implicit none
  private
  public :: changed_forces, flexibility, modal_t, mode_slopes_t, note_stiffness, solve_beside

  !> The modes of one wing; one per thread.
  type, extends(symmetric_operator_t) :: modal_t
    integer :: n_modes = 0
    real(rp), allocatable :: lambda(:)       !< (n_modes) [rad^2/s^2] lowest first
    real(rp), allocatable :: shapes(:, :, :) !< (3, n_all, n_modes) [kg^-1/2], of unit modal mass
    real(rp) :: residual = 0                 !< largest |F M phi lambda - phi|, with |phi| = 1 in the metric of M
    type(solid_model_t) :: model             !< its parameters may be set before `solve`
    type(solid_model_t), private :: probe    !< its stiffness is replaced by a direction of stiffness
    type(equilibrium_t) :: work              !< holds the factors of K after `solve`
    type(load_t), private :: load
    logical :: is_bent = .false.             !< the shape about which the wing vibrates is not the unloaded one
    real(rp), private :: gravity(3) = 0      !< [m/s^2] part of the load
    !> (3, n_all) [m] the shape about which the wing vibrates, its rounding error, and its change
    real(rp), allocatable, private :: u(:, :), low(:, :), du(:, :)
    real(rp), allocatable, private :: blocks(:, :, :), mass(:), x(:, :)
    real(rp), allocatable :: root_mass(:), turns(:, :) !< M^(1/2); R
    real(rp), allocatable :: bent(:, :), moment(:, :) !< psi, and the moment on the clamp
    real(rp), allocatable :: flat(:, :) !< (3 n_free, n_modes) the shapes at the movable points
    real(rp), private :: compliance(2) = 0   !< [rad/(N m)] about x and y
  contains
    procedure :: init => modal_init
    procedure :: free => modal_free
    procedure :: bend => modal_bend
    procedure :: solve => modal_solve
    procedure :: apply => flexible
    procedure :: frequencies => modal_frequencies
    procedure :: slopes_of_stiffness => modal_slopes_of_stiffness
    procedure :: slopes_of_mass => modal_slopes_of_mass
    procedure :: slopes_of_clamp => modal_slopes_of_clamp
  end type modal_t

  !> Slopes of the first n modes with respect to one parameter.
  type :: mode_slopes_t
    real(rp), allocatable :: force(:, :)     !< (n, n) phi_j f_i at (j, i): dlambda on the diagonal
    real(rp), allocatable :: shapes(:, :, :) !< (3, n_all, n) dphi
  end type mode_slopes_t

  real(rp), parameter :: TOLERANCE = 1.0e-12_rp !< of the residuals
  real(rp), parameter :: WORST = 1.0e-8_rp      !< residuals that rounding may leave

contains

  !> Allocates the work space for this model.
  subroutine modal_init(self, model)
    class(modal_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp) :: centre(3)
    integer :: i, k
    call self%free()
    self%model = model
    self%probe = model
    call self%work%init(model)
    call self%load%init(model)
    self%is_bent = .false.
    self%gravity = 0
    allocate (self%u(3, model%n_all), self%low(3, model%n_all), self%du(3, model%n_all), self%turns(3*model%n_free, 2), &
              source=0.0_rp)
    allocate (self%blocks(3, 3, size(model%pattern%rows)), self%mass(3*model%n_free), self%root_mass(3*model%n_free))
    centre = 0
    do i = 1, model%n_points
      if (model%free(i) == 0) centre = centre + model%points(:, i)
    end do
    centre = centre/max(1, count(model%free(:model%n_points) == 0))
    do k = 1, 2
      do i = 1, model%n_free
        self%turns(3*i - 2:3*i, k) = cross(IDENTITY(:, k), model%points(:, model%movable(i)) - centre)
      end do
    end do
  end subroutine modal_init

  !> Releases everything.
  subroutine modal_free(self)
    class(modal_t), intent(inout) :: self
    call self%work%free()
    if (allocated(self%u)) deallocate (self%u, self%low, self%du, self%turns, self%blocks, self%mass, self%root_mass)
    if (allocated(self%lambda)) deallocate (self%lambda, self%shapes, self%x, self%bent, self%moment, self%flat)
  end subroutine modal_free

  !> Finds the equilibrium under the dead load force(3, n_all) [N] and the weight of mass(1, :) [kg] in gravity(3) [m/s^2], with the
  !> parameters of `self%model`. Later calls of `solve` compute modes about this shape. The equilibrium is the end of the loading
  !> path from the flat wing, and does not depend on earlier calls. Fails if no equilibrium is found, or if the clamp is compliant:
  !> the clamp of a loaded wing must be stiff.
  subroutine modal_bend(self, mass, force, gravity, options, failure)
    class(modal_t), intent(inout) :: self
    real(rp), intent(in) :: mass(:, :), force(:, :), gravity(3)
    type(static_options_t), intent(in) :: options
    type(failure_t), intent(out) :: failure
    type(static_report_t) :: report
    integer :: i
    if (any(abs(clamp_compliance(self%model%params%effects)) > 0)) then
      call failure%raise('the clamp of a wing that vibrates about a loaded shape must be stiff: remove root_flap and root_twist')
      return
    end if
    self%is_bent = .true.
    self%gravity = gravity
    do i = 1, size(force, 2)
      self%load%force(:, i) = force(:, i) + mass(1, i)*gravity
    end do
    call solve_static(self%work, self%model, self%load, .false., options, self%u, report)
    if (.not. report%converged) call failure%raise('the loaded wing: '//report%reason)
    self%low = self%work%trial
  end subroutine modal_bend

  !> Finds the lowest n_modes modes for mass(3, n_all) [kg] with the parameters of `self%model`: `lambda`, `shapes`. If `bend` was
  !> called before, parameters and masses must be the same as in that call. Fails if the wing has fewer modes, if it is unstable, or
  !> if the iteration does not converge.
  subroutine modal_solve(self, mass, n_modes, failure)
    class(modal_t), intent(inout) :: self
    real(rp), intent(in) :: mass(:, :)
    integer, intent(in) :: n_modes
    type(failure_t), intent(out) :: failure
    real(rp), allocatable :: x(:, :)
    integer :: n
    logical :: is_spd
    associate (model => self%model)
      n = 3*model%n_free
      if (n_modes > n) then
        call failure%raise('the wing has fewer natural modes than requested: ask for fewer, or use a finer wing')
        return
      end if
      self%n_modes = n_modes
      self%compliance = clamp_compliance(model%params%effects)
      self%mass = reshape(mass(:, model%movable), [n])
      self%root_mass = sqrt(self%mass)
      self%work%stage = 1
      call extension_axial(model%springs, model%stiffness%extension, self%u, self%work%axial, step=self%low)
      call self%work%factorise(model, self%load, self%u, .false., 0.0_rp, is_spd)
    end associate
    if (.not. is_spd) then
      call failure%raise('the wing is unstable in the shape about which it vibrates: make it stiffer (E, D or joints of '// &
                         '[Wing]), or its load smaller')
      return
    end if
    call find_largest(self, self%root_mass, n_modes, TOLERANCE, x, self%residual)
    if (.not. self%residual < WORST) then
      call failure%raise('the natural modes did not converge: check that [Wing] and [Mass] are in SI units')
      return
    end if
    call keep_modes(self, x)
  end subroutine modal_solve

  !> Computes `lambda` and `shapes` from the eigenvectors.
  subroutine keep_modes(self, q)
    class(modal_t), intent(inout) :: self
    real(rp), intent(in) :: q(:, :)
    real(rp) :: y(size(q, 1)), z(size(q, 1), size(q, 2))
    integer :: i, k
    k = size(q, 2)
    if (allocated(self%lambda)) deallocate (self%lambda, self%shapes, self%x, self%bent, self%moment, self%flat)
    allocate (self%bent(size(y), k), self%flat(size(y), k), self%moment(2, k))
    allocate (self%lambda(k), self%shapes(3, self%model%n_all, k), source=0.0_rp)
    self%x = q
    z = flexible(self, q)
    do i = 1, k
      self%lambda(i) = 1/dot_product(q(:, i), z(:, i))
      y = self%lambda(i)*z(:, i)/self%root_mass
      self%flat(:, i) = y/sqrt(sum(self%mass*y**2))
      self%shapes(:, self%model%movable, i) = reshape(self%flat(:, i), [3, self%model%n_free])
      self%moment(:, i) = self%lambda(i)*matmul(self%mass*self%flat(:, i), self%turns)
      self%bent(:, i) = self%flat(:, i) - matmul(self%turns, self%compliance*self%moment(:, i))
    end do
  end subroutine keep_modes

  !> Computes M^(1/2) F M^(1/2) x, column by column.
  function flexible(self, x) result(z)
    class(modal_t), intent(in) :: self
    real(rp), intent(in) :: x(:, :)
    real(rp) :: z(size(x, 1), size(x, 2))
    z = spread(self%root_mass, 2, size(x, 2))*flexibility(self, spread(self%root_mass, 2, size(x, 2))*x)
  end function flexible

  !> Computes F b, column by column.
  function flexibility(self, b) result(z)
    class(modal_t), intent(in) :: self
    real(rp), intent(in) :: b(:, :)
    real(rp) :: z(size(b, 1), size(b, 2))
    integer :: i
    z = b
    call self%work%cholesky%solve(size(b, 2), z)
    if (.not. any(abs(self%compliance) > 0)) return
    do i = 1, size(b, 2)
      z(:, i) = z(:, i) + matmul(self%turns, self%compliance*matmul(b(:, i), self%turns))
    end do
  end function flexibility

  !> Returns the natural frequencies (n_modes) [Hz], lowest first; after `solve`.
  pure function modal_frequencies(self) result(f)
    class(modal_t), intent(in) :: self
    real(rp) :: f(self%n_modes)
    f = sqrt(self%lambda)/TWO_PI
  end function modal_frequencies

  !> Returns the slopes of the first size(same, 1) modes when all stiffness changes along `direction` (solid_stiffness_effects).
  subroutine modal_slopes_of_stiffness(self, direction, same, slopes)
    class(modal_t), intent(inout) :: self
    type(stiffness_t), intent(in) :: direction
    logical, intent(in) :: same(:, :) !< modes i and j belong to one cluster
    type(mode_slopes_t), intent(inout) :: slopes
    call note_stiffness(self, direction)
    call find_slopes(self, changed_forces(self, size(same, 1)), 0*self%mass, [0.0_rp, 0.0_rp], same, slopes)
  end subroutine modal_slopes_of_stiffness

  !> Makes later calls of `changed_forces` belong to a change of all stiffness along `direction` (solid_stiffness_effects).
  subroutine note_stiffness(self, direction)
    class(modal_t), intent(inout) :: self
    type(stiffness_t), intent(in) :: direction
    real(rp) :: axial(self%model%springs%n)
    if (self%is_bent) call direction_sensitivity(self%work, self%model, self%u, direction, self%du)
    self%probe%stiffness = direction
    self%probe%springs%tension = direction%tension
    self%probe%springs%slack = self%model%springs%slack
    self%probe%springs%width = self%model%springs%width
    call extension_axial(self%probe%springs, direction%extension, self%u, axial, step=self%low)
    call assemble_tangent(self%probe, self%u, axial, .false., self%blocks)
  end subroutine note_stiffness

  !> Returns the slopes when the masses, and with them the weight, change along direction(3, n_all) [kg per unit].
  subroutine modal_slopes_of_mass(self, direction, same, slopes)
    class(modal_t), intent(inout) :: self
    real(rp), intent(in) :: direction(:, :)
    logical, intent(in) :: same(:, :)
    type(mode_slopes_t), intent(inout) :: slopes
    self%blocks = 0
    if (self%is_bent) call force_sensitivity(self%work, self%model, spread(self%gravity, 2, size(direction, 2))* &
                                             spread(direction(1, :), 1, 3), self%du)
    call find_slopes(self, changed_forces(self, size(same, 1)), reshape(direction(:, self%model%movable), [size(self%mass)]), &
                     [0.0_rp, 0.0_rp], same, slopes)
  end subroutine modal_slopes_of_mass

  !> Returns f(:, n) [N], dK psi_i of the first n modes, where dK is `blocks` and, in a bent wing, K'[du].
  function changed_forces(self, n) result(flattened)
    class(modal_t), intent(inout) :: self
    integer, intent(in) :: n
    real(rp) :: flattened(size(self%mass), n), f(3, self%model%n_free)
    integer :: i
    if (self%is_bent) call add_tangent_change(self%model, self%probe, self%u, self%work%axial, self%du, self%blocks)
    do i = 1, n
      f = 0
      call self%model%pattern%multiply(self%blocks, 1.0_rp, reshape(self%bent(:, i), [3, self%model%n_free]), f)
      flattened(:, i) = reshape(f, [size(self%mass)])
    end do
  end function changed_forces

  !> Returns the slopes when the compliance of the clamp about axis k (1: x, root_twist; 2: y, root_flap) changes [per rad/(N m)].
  !> The wing must be unloaded.
  subroutine modal_slopes_of_clamp(self, k, same, slopes)
    class(modal_t), intent(inout) :: self
    integer, intent(in) :: k
    logical, intent(in) :: same(:, :)
    type(mode_slopes_t), intent(inout) :: slopes
    real(rp) :: dc(2)
    call require(.not. self%is_bent, 'modal_t: the clamp of a bent wing is stiff')
    dc = 0
    dc(k) = 1
    call find_slopes(self, spread(0*self%mass, 2, size(same, 1)), 0*self%mass, dc, same, slopes)
  end subroutine modal_slopes_of_clamp

  !> Computes the slopes. bent(:, i) = dK psi_i, dm is the change of the masses, and dc the change of the compliances. With the
  !> clamp, phi_j dF^-1 phi_i = psi_j dK psi_i - m_j dc m_i, m = lambda R^T M phi its moment, and F dF^-1 phi_i = K^-1 dK psi_i - R
  !> dc m_i.
  subroutine find_slopes(self, bent, dm, dc, same, slopes)
    class(modal_t), intent(in) :: self
    real(rp), intent(in) :: bent(:, :), dm(:), dc(:)
    logical, intent(in) :: same(:, :)
    type(mode_slopes_t), intent(inout) :: slopes
    real(rp), dimension(size(bent, 1), size(bent, 2)) :: g, inert
    real(rp), dimension(size(self%lambda), size(bent, 2)) :: c, by_mass
    integer :: n, i, j
    n = size(bent, 2)
    inert = spread(self%lambda(:n), 1, size(dm))*spread(dm, 2, n)*self%flat(:, :n)
    call multiply_transposed(self%bent, bent, c)
    call multiply_transposed(self%flat, inert, by_mass)
    do i = 1, n
      c(:, i) = c(:, i) - by_mass(:, i) - matmul(dc*self%moment(:, i), self%moment)
    end do
    g = bent
    call self%work%cholesky%solve(n, g)
    if (any(abs(dm) > 0)) g = g - flexibility(self, inert)
    do i = 1, n
      g(:, i) = g(:, i) - matmul(self%turns, dc*self%moment(:, i))
    end do
    slopes%force = c(:n, :)
    do i = 1, n
      do j = 1, size(self%lambda)
        if (j == i) then
          c(j, i) = -0.5_rp*sum(dm*self%flat(:, i)**2)
        else if (is_same(i, j)) then
          c(j, i) = 0
        else
          c(j, i) = -c(j, i)/(self%lambda(j) - self%lambda(i))
        end if
      end do
    end do
    g = -spread(self%root_mass, 2, n)*g
    call solve_beside(self, self%lambda(:n), g)
    if (.not. allocated(slopes%shapes)) allocate (slopes%shapes(3, self%model%n_all, n))
    slopes%shapes = 0
    g = g/spread(self%root_mass, 2, n)
    call multiply(1.0_rp, self%flat, c, g)
    do i = 1, n
      slopes%shapes(:, self%model%movable, i) = reshape(g(:, i), [3, self%model%n_free])
    end do

  contains

    pure logical function is_same(i, j)
      integer, intent(in) :: i, j
      is_same = .false.
      if (max(i, j) <= n) is_same = same(i, j)
    end function is_same

  end subroutine find_slopes

  !> Replaces b(:, i) by (1 - lambda_i A)^-1 b(:, i), A = M^(1/2) F M^(1/2), orthogonal to the known modes: conjugate gradients.
  subroutine solve_beside(self, lambda, b)
    class(modal_t), intent(in) :: self
    real(rp), intent(in) :: lambda(:)
    real(rp), intent(inout) :: b(:, :)
    real(rp), parameter :: SMALL = 1.0e-13_rp
    integer, parameter :: LIMIT = 200
    real(rp), dimension(size(b, 1), size(b, 2)) :: y, r, p
    real(rp), allocatable :: ap(:, :)
    real(rp) :: rr(size(b, 2)), first(size(b, 2)), old, step
    integer, allocatable :: open(:) ! columns that are not found yet
    integer :: i, k, iteration
    first = max(sum(b**2, 1), tiny(1.0_rp)) ! the right-hand side may be rounding error alone
    call remove_known(self, b)
    y = 0
    r = b
    p = r
    rr = sum(r**2, 1)
    do iteration = 1, LIMIT
      open = pack([(i, i=1, size(b, 2))], rr > SMALL**2*first)
      if (size(open) == 0) exit
      ap = p(:, open) - spread(lambda(open), 1, size(b, 1))*flexible(self, p(:, open))
      call remove_known(self, ap)
      do k = 1, size(open)
        i = open(k)
        old = rr(i)
        step = old/dot_product(p(:, i), ap(:, k))
        y(:, i) = y(:, i) + step*p(:, i)
        r(:, i) = r(:, i) - step*ap(:, k)
        rr(i) = sum(r(:, i)**2)
        p(:, i) = r(:, i) + rr(i)/old*p(:, i)
      end do
    end do
    b = y
  end subroutine solve_beside

  !> Removes the components along the known modes from `b`.
  subroutine remove_known(self, b)
    class(modal_t), intent(in) :: self
    real(rp), intent(inout) :: b(:, :)
    real(rp) :: components(size(self%x, 2), size(b, 2))
    call multiply_transposed(self%x, b, components)
    call multiply(-1.0_rp, self%x, components, b)
  end subroutine remove_known
end module solid_modal
