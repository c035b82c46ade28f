! SPDX-License-Identifier: GPL-3.0-or-later
!> Solves the linear equations of Newton's method in a time step of a wing.
!>
!> The Jacobian is S + N + C (q + omega x). S is sparse and symmetric (mixed-stress tangent, inertia, damping), and N is skew
!> (gyroscopic). C >= 0 is the dense response of a reaction, if there is one, to velocities, which are q times the displacements,
!> and in space what the frame turns them by. Without a reaction S is factorised, and N is treated by the iteration of Concus,
!> Golub & Widlund (1976), which converges for any symmetric positive definite plus skew matrix. With a reaction, S + q D is
!> factorised, where the blocks D approximate C, and GMRES does the rest, also for later S with the same factors.
module solid_dynamic_solve
  use base_kinds, only: rp
  use solid_equilibrium, only: equilibrium_t
  use solid_inertia, only: inertia_t, add_inertia_tangent, apply_gyroscopic, gyroscopic_turn
  use solid_krylov, only: krylov_t
  use solid_model, only: solid_model_t
  use solid_motion, only: frame_t
  use solid_reaction, only: reaction_t
  use solid_residuals, only: residuals_t
  use solid_tangent, only: assemble_tangent
  implicit none
  private
  public :: dynamic_solver_t

  !> Work space; nothing is allocated after `init`. It holds the result x(3, n_all) [m] of the last solution, and counts, which
  !> the caller sets to 0 when it begins to count. The caller also sets the velocities before an assembly.
  type :: dynamic_solver_t
    type(equilibrium_t) :: equilibrium
    real(rp), allocatable :: x(:, :)
    real(rp), allocatable :: v(:, :)     !< (3, n_all) [m/s] velocities at which drag is linear
    real(rp), allocatable :: answer(:, :) !< (3, n_all) [N] minus the change of the load of the reaction by `x`
    integer :: n_factorisations = 0
    integer :: n_inner = 0               !< iterations of equations with a reaction
    logical :: is_slow = .false.         !< the last solution with a reaction took so long that new factors pay
    type(frame_t), private :: frame
    real(rp), private :: q = 0           !< [1/s]
    type(krylov_t), private :: krylov
    type(residuals_t), private :: residuals
    logical, private :: is_own = .false. !< the factors belong to the matrix that was assembled last
    real(rp), private, dimension(:, :), allocatable :: r, rate, mixed, old_x, old_r, turns, free_x
    real(rp), private, dimension(:, :, :), allocatable :: diagonal, kept, joint_blocks
  contains
    procedure :: init => solver_init
    procedure :: free => solver_free
    procedure :: start => solver_start
    procedure :: assemble => solver_assemble
    procedure :: factorise => solver_factorise
    procedure :: iterate => solver_iterate
    procedure :: solve_reaction => solver_solve_reaction
    procedure :: solve => solver_solve
  end type dynamic_solver_t

contains

  !> Allocates the work space and analyses the pattern of the matrices of this model.
  subroutine solver_init(self, model)
    class(dynamic_solver_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    integer :: n, m
    n = model%n_all
    m = model%n_free
    call self%free()
    call self%equilibrium%init(model)
    call self%krylov%init(m)
    call self%residuals%init(model)
    allocate (self%x(3, n), self%v(3, n), self%answer(3, n), self%r(3, n), self%rate(3, n), self%mixed(3, n), self%old_x(3, n), &
              self%old_r(3, n), self%turns(3, m), self%free_x(3, m), source=0.0_rp)
    allocate (self%diagonal(3, 3, n), self%kept(3, 3, m), source=0.0_rp)
    allocate (self%joint_blocks(3, 3, merge(size(model%pattern%rows), 0, any(model%plans%joint > 0))), source=0.0_rp)
  end subroutine solver_init

  !> Releases everything.
  subroutine solver_free(self)
    class(dynamic_solver_t), intent(inout) :: self
    call self%equilibrium%free()
    call self%krylov%free()
    call self%residuals%free()
    if (allocated(self%x)) deallocate (self%x, self%v, self%answer, self%r, self%rate, self%mixed, self%old_x, self%old_r, &
                                       self%turns, self%free_x, self%diagonal, self%kept, self%joint_blocks)
  end subroutine solver_free

  !> Begins the equations of a step or substep. They hold in the frame `frame`, and the rate of any quantity is q [1/s] times its
  !> change. Call it before the first `assemble` of a step.
  subroutine solver_start(self, model, inertia, frame, q)
    class(dynamic_solver_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: q
    integer :: i
    self%frame = frame
    self%q = q
    do i = 1, model%n_free
      self%turns(:, i) = gyroscopic_turn(inertia, frame, q, model%movable(i))
    end do
    call self%residuals%forget(frame%omega/q)
  end subroutine solver_start

  !> Assembles S at displacements u(3, n_all) [m]. With `semidefinite` every element contributes its positive semidefinite part
  !> only, and the motion of the frame is ignored.
  subroutine solver_assemble(self, model, inertia, u, semidefinite)
    class(dynamic_solver_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    real(rp), intent(in) :: u(:, :)
    logical, intent(in) :: semidefinite
    type(frame_t) :: at_rest
    call self%residuals%forget()
    self%is_own = .false.
    associate (blocks => self%equilibrium%blocks)
      call assemble_tangent(model, u, self%equilibrium%axial, semidefinite, blocks)
      if (max(inertia%rayleigh_stiffness, inertia%relaxation) > 0) blocks = inertia%elastic_factor(self%q)*blocks
      if (inertia%rubs()) then
        call inertia%joint_tangent(u, semidefinite, self%joint_blocks)
        blocks = blocks + (self%q*inertia%joint_friction)*self%joint_blocks
      end if
      if (semidefinite) then
        call add_inertia_tangent(inertia, model, at_rest, self%q, self%v, blocks)
      else
        call add_inertia_tangent(inertia, model, self%frame, self%q, self%v, blocks)
      end if
    end associate
  end subroutine solver_assemble

  !> Factorises the assembled S, with SHARE of the blocks of the reaction on its diagonal. If S is not positive definite, it
  !> assembles and factorises the semidefinite S at u(3, n_all) [m] instead. `is_spd` is false if that fails too. Adds each attempt
  !> to `n_factorisations`.
  subroutine solver_factorise(self, model, inertia, u, is_spd, reaction)
    class(dynamic_solver_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    real(rp), intent(in) :: u(:, :)
    logical, intent(out) :: is_spd
    class(reaction_t), intent(inout), optional :: reaction
    ! The blocks are C for the smoothest motion, and too much for others: with all of them the blowfly's wings take a fifth to a
    ! third more iterations.
    real(rp), parameter :: SHARE = 0.6_rp
    integer :: attempt, i, b
    if (present(reaction)) call reaction%block_diagonal(self%diagonal)
    do attempt = 1, 2
      if (attempt == 2) call self%assemble(model, inertia, u, .true.)
      if (present(reaction)) then
        do i = 1, model%n_free
          b = model%pattern%start(i + 1) - 1
          self%kept(:, :, i) = self%equilibrium%blocks(:, :, b)
          self%equilibrium%blocks(:, :, b) = self%kept(:, :, i) + SHARE*self%q*self%diagonal(:, :, model%movable(i))
        end do
      end if
      call model%pattern%pack(self%equilibrium%blocks, self%equilibrium%values)
      if (present(reaction)) then
        do i = 1, model%n_free
          self%equilibrium%blocks(:, :, model%pattern%start(i + 1) - 1) = self%kept(:, :, i)
        end do
      end if
      call self%equilibrium%cholesky%factorise(self%equilibrium%values, is_spd)
      self%n_factorisations = self%n_factorisations + 1
      self%is_own = is_spd
      self%is_slow = .false.
      if (is_spd) return
    end do
  end subroutine solver_factorise

  !> Solves (S + N) x = -r with the assembled S by iterations with the factors of an older S. r(3, n_all) is in N. If `is_solved`,
  !> the residual has fallen to 0.3 of r or below, and `x` is the solution; otherwise `x` keeps its value.
  subroutine solver_iterate(self, model, r, is_solved)
    class(dynamic_solver_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: r(:, :)
    logical, intent(out) :: is_solved
    real(rp), parameter :: ENOUGH = 1.0e-3_rp ! Newton's method corrects the rest
    real(rp) :: left
    call put_right_hand_side(self, model, r)
    call self%krylov%solve(model%pattern, self%equilibrium%blocks, self%turns, self%equilibrium%cholesky, &
                           self%equilibrium%right_hand_side, ENOUGH, self%free_x, left)
    call finish(self, model, left, is_solved)
  end subroutine solver_iterate

  !> Solves (S + N + C (q + omega x)) x = -r with the assembled S by iterations with the present factors, until the residual is
  !> `enough` times r(3, n_all) [N]. If `is_solved`, it has fallen to 0.3 of r or below, and `x` is the solution; otherwise `x`
  !> keeps its value. Adds the iterations to `n_inner`, and sets `is_slow` and `answer`.
  subroutine solver_solve_reaction(self, model, r, enough, reaction, is_solved)
    class(dynamic_solver_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: r(:, :), enough
    class(reaction_t), intent(inout) :: reaction
    logical, intent(out) :: is_solved
    integer, parameter :: MANY = 60, FEW = 20 ! few if new factors would help
    integer, parameter :: WORTH = 6           ! a factorisation costs as much as eight iterations
    real(rp) :: left
    integer :: n_iterations, i
    call put_right_hand_side(self, model, r)
    call self%residuals%solve(model, self%equilibrium, self%turns, reaction, self%q, enough, merge(MANY, FEW, self%is_own), &
                              self%free_x, left, n_iterations)
    self%n_inner = self%n_inner + n_iterations
    self%is_slow = n_iterations > WORTH .and. .not. self%is_own
    call finish(self, model, left, is_solved)
    do i = 1, model%n_free
      self%answer(:, model%movable(i)) = self%residuals%answer(:, i)
    end do
  end subroutine solver_solve_reaction

  !> Returns -r of the free points.
  subroutine put_right_hand_side(self, model, r)
    class(dynamic_solver_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: r(:, :)
    integer :: i
    do i = 1, model%n_free
      self%equilibrium%right_hand_side(:, i) = -r(:, model%movable(i))
    end do
  end subroutine put_right_hand_side

  !> Accepts the solution if the remaining share `left` of the residual is at most USEFUL.
  subroutine finish(self, model, left, is_solved)
    class(dynamic_solver_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: left
    logical, intent(out) :: is_solved
    real(rp), parameter :: USEFUL = 0.3_rp
    integer :: i
    is_solved = left <= USEFUL
    if (.not. is_solved) return
    do i = 1, model%n_free
      self%x(:, model%movable(i)) = self%free_x(:, i)
    end do
  end subroutine finish

  !> Solves (S + N) x = -r with the factorised S, for r(3, n_all) [N]; the result is `x` [m]. Concus, Golub & Widlund (1976).
  subroutine solver_solve(self, model, inertia, r)
    class(dynamic_solver_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    real(rp), intent(in) :: r(:, :)
    real(rp), parameter :: ENOUGH = 1.0e-8_rp ! of the squared energy norm: Newton's method corrects the rest
    integer, parameter :: LIMIT = 60
    real(rp) :: rho, old_rho, first_rho, omega
    integer :: k
    call self%equilibrium%newton_step(model, r)
    self%x = self%equilibrium%du
    if (.not. maxval(abs(self%frame%omega)) + maxval(abs(self%frame%alpha)) > 0) return
    first_rho = -sum(r*self%x)
    old_rho = first_rho
    self%old_x = 0
    self%old_r = r
    omega = 1
    call apply_gyroscopic(inertia, model, self%frame, self%q, self%x, self%rate) ! r_1 = r_0 + N x_1, as x = -S^-1 r
    self%r = self%rate
    do k = 1, LIMIT
      call self%equilibrium%newton_step(model, self%r)
      rho = -sum(self%r*self%equilibrium%du)
      if (rho <= ENOUGH*first_rho) exit
      omega = 1/(1 + (rho/old_rho)/omega)
      old_rho = rho
      self%rate = self%old_x + omega*(self%equilibrium%du + self%x - self%old_x)
      self%old_x = self%x
      self%x = self%rate
      call apply_gyroscopic(inertia, model, self%frame, self%q, self%equilibrium%du, self%rate)
      self%mixed = (1 - omega)*self%old_r + omega*self%rate
      self%old_r = self%r
      self%r = self%mixed
    end do
  end subroutine solver_solve
end module solid_dynamic_solve
