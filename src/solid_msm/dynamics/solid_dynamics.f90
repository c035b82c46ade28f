! SPDX-License-Identifier: GPL-3.0-or-later
!> Advances the motion of a wing in time by variable-step BDF2, started by implicit Euler.
!>
!> With r = h/h_old, b_y = C1 y_n - C2 y_(n-1) and q = 1/(C3 h), C1 = (1+r)^2/(1+2r), C2 = r^2/(1+2r), C3 = (1+r)/(1+2r), the rate
!> of any y at the new time is q (y - b_y). Velocities are eliminated, so that the displacement is the only unknown.
!> Stiffness-proportional damping is the rate of the elastic forces. The force of a viscoelastic wing is a rational function of the
!> elastic forces and their past. Both therefore have an exact tangent. Friction of joints is proportional to the rate of the forces
!> of joints alone. Newton's method uses the mixed-stress tangent of the statics; its linear equations are those of
!> solid_dynamic_solve. A load may respond to the velocity of the wing at once (solid_reaction).
module solid_dynamics
  use base_errors, only: require
  use base_kinds, only: rp
  use base_text, only: number_text
  use solid_dynamic_scale, only: linear_tolerance, momentum_norm, rounding_forces
  use solid_dynamic_solve, only: dynamic_solver_t
  use solid_dynamic_state, only: copy_state, dynamic_state_t, step_ratio
  use solid_extension, only: extension_axial
  use solid_inertia, only: inertia_t, add_inertia_forces
  use solid_model, only: solid_model_t
  use solid_motion, only: frame_t, motion_t
  use solid_reaction, only: reaction_t
  implicit none
  private
  public :: copy_state, dynamic_state_t, dynamic_options_t, step_report_t, dynamics_t

  integer, parameter :: HISTORY = 16

  !> Options of the algorithm.
  type :: dynamic_options_t
    real(rp) :: tolerance = 1.0e-8_rp !< of the residual, relative to the largest force in the balance
    integer :: iterations = 10
    integer :: halvings = 8           !< number of times that a failed step may be halved
    !> A factorisation serves further iterations if this many suffice at the present rate of convergence; they cost about as much as
    !> a factorisation, and are not counted. 0: a new tangent in every iteration.
    real(rp) :: worth_reuse = 7
    !> Without a reaction: the largest number of factorisations in a step, including its second attempt. After that the last
    !> factors are used in an iterative solution. More factorisations follow only if the iterations fail, in a third attempt, and in
    !> a halved step, where poor factors at the beginning cost more. With a reaction the first ones serve as long as they are good.
    integer :: factorisations = 3
  end type dynamic_options_t

  !> Report on a step.
  type :: step_report_t
    logical :: converged = .false.
    character(:), allocatable :: reason      !< why it has not converged
    integer :: iterations = 0                !< of Newton's method, all substeps
    integer :: factorisations = 0            !< of the Jacobian, all substeps
    integer :: inner = 0                     !< iterations of linear equations, all substeps, with a reaction only
    integer :: substeps = 0                  !< accepted substeps; 1 unless Newton's method failed
    real(rp) :: residual = 0                 !< relative, of the last substep
    real(rp) :: residuals(0:HISTORY) = 0     !< [N] of the iterations of the last substep
  end type step_report_t

  !> The stepper's work space; nothing is allocated after `init`.
  type :: dynamics_t
    private
    type(dynamic_solver_t) :: solver
    type(dynamic_state_t) :: saved
    logical :: has_factors = .false. !< the factors of the solver serve the present step
    integer :: n_before = 0          !< factorisations for this step, over all its attempts that were not in parts
    ! Data of the present substep
    type(frame_t) :: frame           !< at its end
    real(rp) :: q = 0                !< [1/s]
    real(rp), dimension(:, :), allocatable :: bu, bv, bg, bf, bj, u, v, rate, r, f, total
    real(rp), allocatable :: load(:, :) !< (3, n_all) [N] of the reaction
    logical :: is_predicted = .false., may_predict = .true. !< the load, by its tangent
  contains
    procedure :: init => dynamics_init
    procedure :: free => dynamics_free
    procedure :: step => dynamics_step
  end type dynamics_t

contains

  !> Allocates the work space and analyses the pattern of the matrices of this model. Call it before the first `step`.
  subroutine dynamics_init(self, model)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    integer :: n
    n = model%n_all
    call self%free()
    call self%solver%init(model)
    call self%saved%init(model, 0.0_rp)
    allocate (self%bu(3, n), self%bv(3, n), self%bg(3, n), self%bf(3, n), self%bj(3, n), self%total(3, n), self%u(3, n), &
              self%v(3, n), self%rate(3, n), self%r(3, n), self%f(3, n), self%load(3, n), source=0.0_rp)
  end subroutine dynamics_init

  !> Releases everything.
  subroutine dynamics_free(self)
    class(dynamics_t), intent(inout) :: self
    call self%solver%free()
    if (allocated(self%bu)) deallocate (self%bu, self%bv, self%bg, self%bf, self%bj, self%total, self%u, self%v, self%rate, &
                                        self%r, self%f, self%load)
  end subroutine dynamics_free

  !> Advances `state` by dt > 0 [s] under the external forces force(3, n_all) [N], which are constant over the step, with the frame
  !> of `motion` at the new time. `report` says whether Newton's method converged, and if not, why. On failure the state is
  !> unchanged. A dt that is not positive stops the program.
  !>
  !> With a `guess` the call repeats the last step under another force. It begins with the last factors, and its count of
  !> factorisations includes those of the earlier call. Allocates nothing.
  subroutine dynamics_step(self, model, inertia, motion, force, dt, options, state, report, guess, reaction)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    class(motion_t), intent(in) :: motion
    real(rp), intent(in) :: force(:, :), dt
    type(dynamic_options_t), intent(in) :: options
    type(dynamic_state_t), intent(inout) :: state
    type(step_report_t), intent(out) :: report
    real(rp), intent(in), optional :: guess(:, :) !< (3, n_all) [m] of u at the end, instead of an extrapolated one
    class(reaction_t), intent(inout), optional :: reaction !< adds its force, taken at the new time
    type(dynamic_options_t) :: now
    integer :: halvings, done ! substeps of length dt/2**halvings
    real(rp) :: part
    logical :: converged, can_try
    call require(dt > 0, 'dynamics_t%step: the time step must be positive')
    call copy_state(state, self%saved)
    self%solver%n_factorisations = 0
    self%solver%n_inner = 0
    now = options
    halvings = 0
    done = 0
    if (.not. present(guess)) self%n_before = 0
    self%has_factors = self%n_before > 0
    now%factorisations = options%factorisations - self%n_before
    do
      part = dt/2**halvings
      if (present(reaction)) call reaction%begin_part(motion%at(self%saved%time + done*part), state%u, state%v, 2**halvings, &
                                                      done, step_ratio(state, part))
      self%frame = motion%at(self%saved%time + (done + 1)*part)
      call begin_piece(self, model, inertia, part, state)
      if (present(guess) .and. halvings == 0) self%u = guess
      call solve_piece(self, model, inertia, force, now, report, converged, reaction)
      if (converged) then
        call end_piece(self, model, part, state)
        if (present(reaction)) call reaction%end_part()
        done = done + 1
        report%substeps = report%substeps + 1
        report%converged = done == 2**halvings
        if (report%converged) exit
        now%worth_reuse = options%worth_reuse ! for the next substep
        self%has_factors = .false.
      else
        call try_harder(self, options, now, halvings, done, can_try)
        if (.not. can_try) exit
      end if
    end do
    report%factorisations = self%solver%n_factorisations
    report%inner = self%solver%n_inner
    self%n_before = merge(0, self%n_before + report%factorisations, halvings > 0) ! factors of a part do not serve the whole step
    if (report%converged) then
      state%time = self%saved%time + dt
    else
      call copy_state(self%saved, state)
      report%reason = 'Newton''s method did not converge with steps of '//number_text(part)//' s'
    end if
  end subroutine dynamics_step

  !> Chooses the next attempt after a part of a step has failed, in this order: a new tangent in every iteration, new factors
  !> with every tangent, steps of half the length. `can_try` is false if no attempt is left.
  pure subroutine try_harder(self, options, now, halvings, done, can_try)
    type(dynamics_t), intent(inout) :: self
    type(dynamic_options_t), intent(in) :: options
    type(dynamic_options_t), intent(inout) :: now
    integer, intent(inout) :: halvings, done
    logical, intent(out) :: can_try
    can_try = .true.
    self%solver%is_slow = .true. ! the factors may be to blame
    if (now%worth_reuse > 0) then
      now%worth_reuse = 0
    else if (now%factorisations < huge(1)) then
      now%factorisations = huge(1)
      self%has_factors = .false.
    else if (halvings < options%halvings) then
      now = options
      now%factorisations = huge(1)
      self%has_factors = .false.
      halvings = halvings + 1
      done = 2*done
    else
      can_try = .false.
    end if
  end subroutine try_harder

  !> Prepares a part h [s] of a step: q, the terms of BDF2, initial displacements, and the axial forces of the state.
  subroutine begin_piece(self, model, inertia, h, state)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    real(rp), intent(in) :: h
    type(dynamic_state_t), intent(in) :: state
    real(rp) :: r, c1, c2
    self%is_predicted = .false.
    self%may_predict = .true.
    r = step_ratio(state, h)
    c1 = (1 + r)**2/(1 + 2*r)
    c2 = r**2/(1 + 2*r)
    self%q = (1 + 2*r)/((1 + r)*h)
    self%bu = c1*state%u - c2*state%old_u
    self%bv = c1*state%v - c2*state%old_v
    self%bg = c1*state%g - c2*state%old_g
    if (inertia%relaxation > 0) then ! the state has the sums of elastic and viscoelastic forces
      self%bf = self%bg
      call model%gradient(state%old_u, self%total)
      call model%gradient(state%u, self%bg)
      self%bg = c1*self%bg - c2*self%total
      call model%zero_clamped(self%bg)
    end if
    if (inertia%rubs()) then
      call inertia%joint_forces(state%u, self%bj)
      call inertia%joint_forces(state%old_u, self%f)
      self%bj = c1*self%bj - c2*self%f
    end if
    self%u = state%u + h*state%v
    if (r > 0) self%u = self%u + (0.5_rp*h*r)*(state%v - state%old_v)
    call extension_axial(model%springs, model%stiffness%extension, state%u, self%solver%equilibrium%axial)
  end subroutine begin_piece

  !> Does Newton's method for the present part of the step, from self%u. An iteration changes the load of a reaction by what its
  !> tangent says, which is exact but for the rounding of the tangent; the last iteration computes the load itself.
  subroutine solve_piece(self, model, inertia, force, options, report, converged, reaction)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    real(rp), intent(in) :: force(:, :)
    type(dynamic_options_t), intent(in) :: options
    type(step_report_t), intent(inout) :: report
    logical, intent(out) :: converged
    class(reaction_t), intent(inout), optional :: reaction
    real(rp) :: scale, rounding(2), small, size_r, last_size, newton_sizes(2)
    integer :: iteration, n_newton
    real(rp), parameter :: ROUGH = 0.5_rp, NEAR = 0.01_rp
    logical :: was_iterated, is_warm, is_solved, is_rough, is_second
    rounding = rounding_forces(model)
    report%residuals = 0
    call self%solver%start(model, inertia, self%frame, self%q)
    size_r = 0
    n_newton = 0
    newton_sizes = 0
    was_iterated = .false.
    is_warm = self%has_factors
    do iteration = 0, 4*options%iterations
      last_size = size_r
      if (present(reaction)) call find_load(self, model, reaction)
      call find_residual(self, model, inertia, force, size_r, scale, present(reaction))
      report%residuals(min(iteration, HISTORY)) = size_r
      converged = .false.
      if (.not. size_r <= huge(size_r)) exit
      small = max(options%tolerance*scale, rounding(1)*maxval(abs(self%u)) + rounding(2))
      converged = size_r <= small .and. iteration > 0
      if (converged .and. self%is_predicted) then
        call confirm_load(self, model, reaction, size_r)
        converged = size_r <= small
      end if
      if (converged) exit
      ! Far from the balance an older tangent leads astray. Near it the second one saves up to three iterations.
      is_rough = present(reaction) .and. iteration > 0 .and. size_r > ROUGH*scale
      is_second = present(reaction) .and. iteration == 1 .and. .not. is_warm .and. size_r < NEAR*scale .and. &
                  n_newton < options%iterations
      if (was_iterated .or. is_rough .or. is_second .or. &
          needs_new_tangent(options, is_warm, iteration, size_r, last_size, small)) then
        if (n_newton == options%iterations .or. (n_newton >= 3 .and. size_r > newton_sizes(1))) exit ! that before the last
        n_newton = n_newton + 1
        newton_sizes = [newton_sizes(2), size_r]
        call renew_tangent(self, model, inertia, options%factorisations, is_rough, was_iterated, reaction)
        if (.not. self%has_factors) exit
      end if
      if (present(reaction)) then
        call self%solver%solve_reaction(model, self%r, linear_tolerance(size_r, small), reaction, is_solved)
        if (.not. is_solved) exit
        call predict_load(self)
      else if (.not. was_iterated) then
        call self%solver%solve(model, inertia, self%r)
      end if
      call extension_axial(model%springs, model%stiffness%extension, self%u, self%solver%equilibrium%axial, self%solver%x)
      self%u = self%u + self%solver%x
      report%iterations = report%iterations + 1
    end do
    if (converged .and. scale > 0) report%residual = size_r/scale
  end subroutine solve_piece

  !> Computes the load of the reaction at displacements self%u, unless it is predicted.
  subroutine find_load(self, model, reaction)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    class(reaction_t), intent(inout) :: reaction
    if (self%is_predicted) return
    self%v = self%q*(self%u - self%bu)
    call reaction%force(self%frame, self%u, self%v, self%load)
    call model%zero_clamped(self%load)
  end subroutine find_load

  !> Predicts the load after an iteration by its tangent, unless a prediction has failed in this part of the step.
  subroutine predict_load(self)
    class(dynamics_t), intent(inout) :: self
    self%is_predicted = self%may_predict
    if (self%is_predicted) self%load = self%load - self%solver%answer
  end subroutine predict_load

  !> Replaces the predicted load, at which self%r is small, by the load itself; size_r [N] becomes that of the residual with it.
  subroutine confirm_load(self, model, reaction, size_r)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    class(reaction_t), intent(inout) :: reaction
    real(rp), intent(out) :: size_r
    self%is_predicted = .false.
    self%may_predict = .false.
    self%r = self%r + self%load
    call find_load(self, model, reaction)
    self%r = self%r - self%load
    size_r = norm2(self%r)
  end subroutine confirm_load

  !> Computes the residual self%r at self%u, with rates and forces there, its size [N], and that of the largest force.
  subroutine find_residual(self, model, inertia, force, size_r, scale, has_load)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    real(rp), intent(in) :: force(:, :)
    real(rp), intent(out) :: size_r, scale
    logical, intent(in) :: has_load
    associate (q => self%q, g => self%solver%equilibrium%g)
      self%v = q*(self%u - self%bu)
      self%solver%v = self%v
      self%rate = q*(self%v - self%bv)
      call model%gradient(self%u, g)
      self%total = g
      if (inertia%relaxation > 0) self%total = inertia%remembered(q, g, self%bg, self%bf)
      self%r = self%total - force + (q*inertia%rayleigh_stiffness)*(g - self%bg)
      if (inertia%rubs()) then
        call inertia%joint_forces(self%u, self%f)
        self%r = self%r + (q*inertia%joint_friction)*(self%f - self%bj)
      end if
      if (has_load) self%r = self%r - self%load
      call model%zero_clamped(self%r)
      call model%zero_clamped(g)
      scale = max(norm2(self%r), norm2(g), norm2(force))
      if (has_load) scale = max(scale, norm2(self%load))
      call add_inertia_forces(inertia, model, self%frame, self%u, self%v, self%rate, self%r)
      size_r = norm2(self%r)
      scale = max(scale, q*momentum_norm(inertia, self%bv))
    end associate
  end subroutine find_residual

  !> Assembles the tangent at self%u, and factorises it if the equations need that. If the allowed number `most` of factorisations
  !> gives none, the older factors are used, and solve the equations at once, if they can (`was_iterated`). With a reaction they are
  !> used unless the wing `is_rough`, solutions are slow, or there is no limit.
  subroutine renew_tangent(self, model, inertia, most, is_rough, was_iterated, reaction)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    type(inertia_t), intent(in) :: inertia
    integer, intent(in) :: most
    logical, intent(in) :: is_rough
    logical, intent(out) :: was_iterated
    class(reaction_t), intent(inout), optional :: reaction
    logical :: is_scarce
    was_iterated = .false.
    is_scarce = self%has_factors .and. self%solver%n_factorisations >= most - 1 ! an indefinite one takes two
    call self%solver%assemble(model, inertia, self%u, .false.)
    if (is_scarce .and. .not. present(reaction)) call self%solver%iterate(model, self%r, was_iterated)
    if (was_iterated) return
    if (present(reaction) .and. self%has_factors .and. most < huge(1) .and. .not. (is_rough .or. self%solver%is_slow)) return
    call self%solver%factorise(model, inertia, self%u, self%has_factors, reaction)
  end subroutine renew_tangent

  !> Advances the state by the solved part h [s] of the step.
  subroutine end_piece(self, model, h, state)
    class(dynamics_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: h
    type(dynamic_state_t), intent(inout) :: state
    state%old_u = state%u
    state%old_v = state%v
    state%old_g = state%g
    state%u = self%u
    state%v = self%v
    state%g = self%total
    call model%zero_clamped(state%g)
    state%a = self%rate
    state%old_step = h
    state%time = state%time + h
  end subroutine end_piece

  !> Tells whether the present factors are unsuitable for the next iteration. The first two iterations after a factorisation at
  !> the extrapolated shape undo the stretching of its springs, for which the factors are good enough. Later ones should converge
  !> in fewer iterations than a factorisation costs. A step that is repeated begins `is_warm`.
  pure logical function needs_new_tangent(options, is_warm, iteration, size_r, last_size, small) result(is_needed)
    type(dynamic_options_t), intent(in) :: options
    logical, intent(in) :: is_warm
    integer, intent(in) :: iteration
    real(rp), intent(in) :: size_r, last_size, small !< [N] residuals, now, before, and of the end
    integer, parameter :: STRETCHED = 3
    is_needed = .true.
    if (.not. options%worth_reuse > 0) return
    if (iteration < STRETCHED) is_needed = size_r > last_size
    if (iteration == 0) is_needed = .not. is_warm
    if (is_needed .and. size_r < last_size) is_needed = log(size_r/small) > options%worth_reuse*log(last_size/size_r)
  end function needs_new_tangent
end module solid_dynamics
