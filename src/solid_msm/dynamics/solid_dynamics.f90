! SPDX-License-Identifier: GPL-3.0-or-later
!> Motion of a wing in time: variable-step BDF2, started by implicit Euler.
!>
!> With r = h/h_old, b_y = C1 y_n - C2 y_(n-1) and q = 1/(C3 h), C1 = (1+r)^2/(1+2r), C2 = r^2/(1+2r),
!> C3 = (1+r)/(1+2r), the rate of any y at the new time is q (y - b_y). Velocities are eliminated: the
!> unknown is the displacement. Stiffness-proportional damping is the rate of the elastic forces, so it
!> has an exact tangent. Newton's method uses the mixed-stress tangent of the statics; its symmetric
!> part is factorised, and the gyroscopic part is left to the iteration of Concus, Golub & Widlund
!> (1976), which converges for any symmetric positive definite plus skew matrix.
module solid_dynamics
  use base_errors, only: require
  use base_kinds, only: rp
  use base_text, only: number_text
  use solid_dynamic_state, only: copy_state, dynamic_state_t
  use solid_equilibrium, only: equilibrium_t
  use solid_extension, only: extension_axial
  use solid_inertia, only: inertia_t, add_inertia_forces, add_inertia_tangent, apply_gyroscopic, gyroscopic_turn
  use solid_krylov, only: krylov_t
  use solid_model, only: solid_model_t
  use solid_motion, only: frame_t, motion_t
  use solid_tangent, only: assemble_tangent
  implicit none
  private
  public :: copy_state, dynamic_state_t, dynamic_options_t, step_report_t, dynamics_t

  !> Choices of the algorithm.
  type :: dynamic_options_t
    real(rp) :: tolerance = 1.0e-8_rp !< of the residual, relative to the largest force in the balance
    integer :: iterations = 10
    integer :: halvings = 8           !< a failed step is retried with halved steps, this often
    !> A factorisation serves further iterations, which are not counted, if at the rate of the last one this many suffice,
    !> about what a factorisation costs; 0: none, a new tangent in every iteration.
    real(rp) :: worth_reuse = 7
    !> So many in a step, its second attempt included; then tangents are inverted by iterations with the last factors.
    !> More only if these fail, in a third attempt and where a step is halved: to begin with poor factors costs more.
    integer :: factorisations = 3
  end type dynamic_options_t

  integer, parameter :: HISTORY = 16

  !> What happened in a step.
  type :: step_report_t
    logical :: converged = .false.
    character(:), allocatable :: reason      !< why not
    integer :: iterations = 0                !< of Newton's method, all substeps
    integer :: factorisations = 0            !< of the Jacobian, all substeps
    integer :: substeps = 0                  !< accepted ones; 1 unless Newton's method failed
    real(rp) :: residual = 0                 !< relative, of the last substep
    real(rp) :: residuals(0:HISTORY) = 0     !< [N] of the iterations of the last substep
  end type step_report_t

  !> The stepper's work space; nothing is allocated after `init`.
  type :: dynamics_t
    private
    type(equilibrium_t) :: solver
    type(krylov_t) :: krylov
    type(dynamic_state_t) :: saved
    real(rp), dimension(:, :), allocatable :: bu, bv, bg, u, v, rate, r, x, old_x, old_r, turns, free_x
  contains
    procedure :: init => dynamics_init
    procedure :: free => dynamics_free
    procedure :: step => dynamics_step
  end type dynamics_t

contains

  !> Work space and symbolic analysis for this model.
  subroutine dynamics_init(self, model)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    integer :: n
    n = model%n_all
    call self%free()
    call self%solver%init(model)
    call self%krylov%init(model%n_free)
    call self%saved%init(model, 0.0_rp)
    allocate (self%bu(3, n), self%bv(3, n), self%bg(3, n), self%u(3, n), self%v(3, n), self%rate(3, n), &
              self%r(3, n), self%x(3, n), self%old_x(3, n), self%old_r(3, n), self%turns(3, model%n_free), &
              self%free_x(3, model%n_free), source=0.0_rp)
  end subroutine dynamics_init

  !> Releases everything.
  subroutine dynamics_free(self)
    class(dynamics_t), intent(inout) :: self
    call self%solver%free()
    call self%krylov%free()
    if (allocated(self%bu)) deallocate (self%bu, self%bv, self%bg, self%u, self%v, self%rate, self%r, &
                                        self%x, self%old_x, self%old_r, self%turns, self%free_x)
  end subroutine dynamics_free

  !> Advances `state` by dt > 0 [s] under the external forces force(3, n_all) [N], constant over the
  !> step, with the frame of `motion` at the new time. On failure the state is what it was.
  !>
  !> The same step, made again with another force or guess, uses the factors of the last time if it is told how many
  !> factorisations have gone `before` into it.
  subroutine dynamics_step(self, model, inertia, motion, force, dt, options, state, report, guess, before)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    class(motion_t), intent(in) :: motion
    real(rp), intent(in) :: force(:, :), dt
    type(dynamic_options_t), intent(in) :: options
    type(dynamic_state_t), intent(inout) :: state
    type(step_report_t), intent(out) :: report
    real(rp), intent(in), optional :: guess(:, :) !< (3, n_all) [m] of u at the end, instead of an extrapolated one
    integer, intent(in), optional :: before
    type(dynamic_options_t) :: now
    integer :: halvings, done
    real(rp) :: part
    logical :: converged, has_factors
    call require(dt > 0, 'dynamics_t%step: the time step must be positive')
    call copy_state(state, self%saved)
    now = options
    halvings = 0
    done = 0
    has_factors = .false.
    if (present(before)) then
      has_factors = before > 0
      now%factorisations = options%factorisations - before
    end if
    do
      part = dt/2**halvings
      if (present(guess) .and. halvings == 0) then
        call substep(self, model, inertia, motion%at(self%saved%time + part), force, part, now, state, report, &
                     has_factors, converged, guess)
      else
        call substep(self, model, inertia, motion%at(self%saved%time + (done + 1)*part), force, part, now, state, &
                     report, has_factors, converged)
      end if
      if (converged) then
        done = done + 1
        report%substeps = report%substeps + 1
        if (done == 2**halvings) exit
        now%worth_reuse = options%worth_reuse ! of the next piece
        has_factors = .false.
      else if (now%worth_reuse > 0) then
        now%worth_reuse = 0
      else if (now%factorisations < huge(1)) then ! iterations with older factors may be to blame
        now%factorisations = huge(1)
        has_factors = .false.
      else if (halvings < options%halvings) then
        now = options
        now%factorisations = huge(1)
        has_factors = .false.
        halvings = halvings + 1
        done = 2*done
      else
        call copy_state(self%saved, state)
        report%reason = 'Newton''s method did not converge with steps of '//number_text(part)//' s'
        return
      end if
    end do
    state%time = self%saved%time + dt
    report%converged = .true.
  end subroutine dynamics_step

  !> One attempt of a step h, or of a piece of it; `has_factors` tells whether an earlier one left some.
  subroutine substep(self, model, inertia, frame, force, h, options, state, report, has_factors, converged, guess)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: force(:, :), h
    type(dynamic_options_t), intent(in) :: options
    type(dynamic_state_t), intent(inout) :: state
    type(step_report_t), intent(inout) :: report
    logical, intent(inout) :: has_factors
    logical, intent(out) :: converged
    real(rp), intent(in), optional :: guess(:, :)
    real(rp), parameter :: LARGEST_RATIO = 2.4_rp ! variable-step BDF2 is stable below 1 + sqrt 2
    real(rp) :: r, c1, c2, q, scale, floor, noise, small, size_r, last_size, newton_sizes(2)
    integer :: iteration, n_newton
    logical :: is_scarce, was_iterated, is_warm

    r = 0
    if (state%old_step > 0) r = h/state%old_step
    if (r > LARGEST_RATIO) r = 0
    c1 = (1 + r)**2/(1 + 2*r)
    c2 = r**2/(1 + 2*r)
    q = (1 + 2*r)/((1 + r)*h)
    self%bu = c1*state%u - c2*state%old_u
    self%bv = c1*state%v - c2*state%old_v
    self%bg = c1*state%g - c2*state%old_g
    self%u = state%u + h*state%v
    if (r > 0) self%u = self%u + (0.5_rp*h*r)*(state%v - state%old_v)
    if (present(guess)) self%u = guess
    call extension_axial(model%springs, model%stiffness%extension, state%u, self%solver%axial)
    floor = 4*epsilon(h)*model%params%k_vein*sqrt(real(model%n_free, rp))
    noise = 8*epsilon(h)*hinge_forces(model)
    report%residuals = 0
    size_r = 0
    converged = .false.
    n_newton = 0
    newton_sizes = 0
    was_iterated = .false.
    is_warm = has_factors
    do iteration = 0, 4*options%iterations
      self%v = q*(self%u - self%bu)
      self%rate = q*(self%v - self%bv)
      call model%gradient(self%u, self%solver%g)
      self%r = self%solver%g - force + (q*inertia%rayleigh_stiffness)*(self%solver%g - self%bg)
      call model%zero_clamped(self%r)
      call model%zero_clamped(self%solver%g)
      scale = max(norm2(self%r), norm2(self%solver%g), norm2(force))
      call add_inertia_forces(inertia, model, frame, self%u, self%v, self%rate, self%r)
      last_size = size_r
      size_r = norm2(self%r)
      scale = max(scale, q*momentum_norm(inertia, self%bv))
      report%residuals(min(iteration, HISTORY)) = size_r
      if (.not. size_r <= huge(size_r)) exit
      small = max(options%tolerance*scale, floor*maxval(abs(self%u)) + noise)
      converged = size_r <= small
      if (converged .and. iteration > 0) exit
      converged = .false.
      if (was_iterated .or. needs_new_tangent(options, is_warm, iteration, size_r, last_size, small)) then
        is_scarce = has_factors .and. report%factorisations >= options%factorisations - 1 ! an indefinite one takes two
        if (n_newton == options%iterations) exit
        if (n_newton >= 3 .and. size_r > newton_sizes(1)) exit ! of the tangent before the last one
        n_newton = n_newton + 1
        newton_sizes = [newton_sizes(2), size_r]
        call assemble(self, model, inertia, frame, q, .false.)
        was_iterated = .false.
        if (is_scarce) call iterate(self, model, inertia, frame, q, was_iterated)
        if (.not. was_iterated) then
          call factorise(self, model, inertia, frame, q, report%factorisations, has_factors)
          if (.not. has_factors) exit
        end if
      end if
      if (.not. was_iterated) call solve(self, model, inertia, frame, q)
      call extension_axial(model%springs, model%stiffness%extension, self%u, self%solver%axial, self%x)
      self%u = self%u + self%x
      report%iterations = report%iterations + 1
    end do
    if (.not. converged) return
    if (scale > 0) report%residual = size_r/scale
    state%old_u = state%u
    state%old_v = state%v
    state%old_g = state%g
    state%u = self%u
    state%v = self%v
    state%g = self%solver%g
    state%a = self%rate
    state%old_step = h
    state%time = state%time + h
  end subroutine substep

  !> 2-norm of the forces [N] of all hinges turned by 1 rad: times the rounding of directions it is the smallest
  !> residual that a wing without motion can have.
  pure real(rp) function hinge_forces(model) result(norm)
    type(solid_model_t), intent(in) :: model
    integer :: h
    norm = 0
    do h = 1, size(model%plans)
      norm = norm + (model%stiffness%hinge(h)/ &
                     minval(model%plans(h)%lengths, mask=model%plans(h)%lengths > 0))**2
    end do
    norm = sqrt(norm)
  end function hinge_forces

  !> 2-norm of mass times velocity.
  pure real(rp) function momentum_norm(inertia, v) result(norm)
    type(inertia_t), intent(in) :: inertia
    real(rp), intent(in) :: v(:, :)
    integer :: i
    norm = 0
    do i = 1, size(v, 2)
      norm = norm + inertia%mass(i)**2*(v(1, i)**2 + v(2, i)**2 + v(3, i)**2)
    end do
    norm = sqrt(norm)
  end function momentum_norm

  !> Whether the factors at hand are no good for the next iteration. The first two after a factorisation at the
  !> extrapolated shape take back what its springs were stretched by, for which they are good enough; later ones
  !> should converge in fewer iterations than a factorisation costs. A step that is made again begins `is_warm`.
  pure logical function needs_new_tangent(options, is_warm, iteration, size_r, last_size, small) result(is_needed)
    type(dynamic_options_t), intent(in) :: options
    logical, intent(in) :: is_warm
    integer, intent(in) :: iteration
    real(rp), intent(in) :: size_r, last_size, small !< [N] residuals, now, before, and of the end
    integer, parameter :: STRETCHED = 3
    is_needed = .true.
    if (.not. options%worth_reuse > 0) return
    if (iteration == 0) is_needed = .not. is_warm
    if (iteration == 0) return
    if (iteration < STRETCHED) is_needed = size_r > last_size
    if (is_needed .and. size_r < last_size) &
      is_needed = log(size_r/small) > options%worth_reuse*log(last_size/size_r)
  end function needs_new_tangent

  !> The symmetric part of the Jacobian, or its elements' positive semidefinite parts.
  subroutine assemble(self, model, inertia, frame, q, semidefinite)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: q
    logical, intent(in) :: semidefinite
    type(frame_t) :: at_rest
    call assemble_tangent(model, self%u, self%solver%axial, semidefinite, self%solver%blocks)
    if (inertia%rayleigh_stiffness > 0) &
      self%solver%blocks = (1 + q*inertia%rayleigh_stiffness)*self%solver%blocks
    if (semidefinite) then
      call add_inertia_tangent(inertia, model, at_rest, q, self%solver%blocks)
    else
      call add_inertia_tangent(inertia, model, frame, q, self%solver%blocks)
    end if
  end subroutine assemble

  !> Factorises what was assembled, or a positive definite neighbour of it, and counts.
  subroutine factorise(self, model, inertia, frame, q, n_factorisations, is_spd)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: q
    integer, intent(inout) :: n_factorisations
    logical, intent(out) :: is_spd
    integer :: attempt
    do attempt = 1, 2
      if (attempt == 2) call assemble(self, model, inertia, frame, q, .true.)
      call model%pattern%pack(self%solver%blocks, self%solver%values)
      call self%solver%cholesky%factorise(self%solver%values, is_spd)
      n_factorisations = n_factorisations + 1
      if (is_spd) return
    end do
  end subroutine factorise

  !> x = -(S + N)^-1 r with the assembled S and the skew N, by the factors of an older S, if that succeeds.
  subroutine iterate(self, model, inertia, frame, q, is_solved)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: q
    logical, intent(out) :: is_solved
    real(rp), parameter :: ENOUGH = 1.0e-3_rp, USEFUL = 0.3_rp ! Newton's method mends the rest
    real(rp) :: left
    integer :: i
    do i = 1, model%n_free
      self%turns(:, i) = gyroscopic_turn(inertia, frame, q, model%movable(i))
      self%solver%right_hand_side(:, i) = -self%r(:, model%movable(i))
    end do
    call self%krylov%solve(model%pattern, self%solver%blocks, self%turns, self%solver%cholesky, &
                           self%solver%right_hand_side, ENOUGH, self%free_x, left)
    is_solved = left <= USEFUL
    if (.not. is_solved) return
    do i = 1, model%n_free
      self%x(:, model%movable(i)) = self%free_x(:, i)
    end do
  end subroutine iterate

  !> x = -(S + N)^-1 r with the factorised S and the skew N.
  subroutine solve(self, model, inertia, frame, q)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: q
    real(rp), parameter :: ENOUGH = 1.0e-8_rp ! of the squared energy norm: Newton's method mends the rest
    integer, parameter :: LIMIT = 60
    real(rp) :: rho, old_rho, first_rho, omega
    integer :: k
    call self%solver%newton_step(model, self%r)
    self%x = self%solver%du
    if (.not. maxval(abs(frame%omega)) + maxval(abs(frame%alpha)) > 0) return
    first_rho = -sum(self%r*self%x)
    old_rho = first_rho
    self%old_x = 0
    self%old_r = self%r
    omega = 1
    call apply_gyroscopic(inertia, model, frame, q, self%x, self%rate) ! r_1 = r_0 + N x_1, as x = -S^-1 r
    self%r = self%rate
    do k = 1, LIMIT
      call self%solver%newton_step(model, self%r)
      rho = -sum(self%r*self%solver%du)
      if (rho <= ENOUGH*first_rho) exit
      omega = 1/(1 + (rho/old_rho)/omega)
      old_rho = rho
      self%rate = self%old_x + omega*(self%solver%du + self%x - self%old_x)
      self%old_x = self%x
      self%x = self%rate
      call apply_gyroscopic(inertia, model, frame, q, self%solver%du, self%rate)
      self%v = (1 - omega)*self%old_r + omega*self%rate
      self%old_r = self%r
      self%r = self%v
    end do
  end subroutine solve
end module solid_dynamics
