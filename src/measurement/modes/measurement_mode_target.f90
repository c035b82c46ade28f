! SPDX-License-Identifier: GPL-3.0-or-later
!> Compares one measured mode with a computed one, or with a cluster of them.
!>
!> Observations, all in units of their sd: ln(f/f_m)/(sigma_f/f_m), and for a shape at n points n - 1 numbers. With s the measured
!> shape over its sd, phi_i the computed shapes over the same sd and v = sum of beta_i phi_i nearest to s (least squares), these are
!> the components normal to s of
!>
!>     v (s.s)/(s.v),
!>
!> which are 0 if both are parallel. Neither size nor sign of a mode matters, and to first order their errors are independent with
!> variance 1, whatever the size of the mode was. MAC = (s.v)^2/((s.s)(v.v)), the modal assurance criterion (Allemang & Brown 1982)
!> with the sd as weights, is 1/(1 + the squared length of these components over s.s).
!>
!> If its damping ratio was measured, this ratio less the measured one is a last observation, and a relaxation of the wing changes
!> the frequency (solid_decay).
!>
!> In a cluster, whose frequencies are nearer than GAP, single shapes change completely with small changes of the wing. Only the
!> space that they span is compared, and the frequency is that of v: lambda = sum beta_i^2 lambda_i/sum beta_i^2.
module measurement_mode_target
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use base_lapack, only: factorise, orthogonalise, solve_factorised
  use measurement_mode_damping, only: mode_damping_t
  use measurement_modes, only: measured_mode_t
  use measurement_material_point, only: find_material_point, material_point_t
  use solid_damping_effects, only: damping_effects_t
  use solid_model, only: solid_model_t
  implicit none
  private
  public :: mode_target_t

  !> Holds a measured mode, and the computed modes lo to hi with which it is paired.
  type :: mode_target_t
    integer :: n = 0                       !< observations
    integer :: state = 1                   !< medium and loads, as the simulation counts them
    integer :: number = 0
    integer :: lo = 0, hi = 0
    real(rp) :: mac = 0                    !< MAC of the pair; 1 without a shape
    real(rp) :: frequency = 0              !< [Hz] computed
    real(rp), allocatable :: seen(:)       !< (places) v in the units of the measurement, as long as this is along it
    type(mode_damping_t) :: damping
    real(rp), private :: log_frequency = 0, log_sigma = 1, lambda = 0
    integer, private :: n_shape = 0        !< observations of frequency and shape
    type(material_point_t), allocatable, private :: sites(:)
    real(rp), allocatable, private :: sigma(:), s(:), normal(:, :), phi(:, :), beta(:), gram(:, :), lambdas(:)
  contains
    procedure :: init => target_init
    procedure :: assurance => target_assurance
    procedure :: nearness => target_nearness
    procedure :: residuals => target_residuals
    procedure :: damp => target_damp
    procedure :: damping_tangent => target_damping_tangent
    procedure :: tangent => target_tangent
  end type mode_target_t

contains

  !> Takes a checked mode of the wing of `model`.
  subroutine target_init(self, mode, model)
    class(mode_target_t), intent(out) :: self
    type(measured_mode_t), intent(in) :: mode
    type(solid_model_t), intent(in) :: model
    real(rp), allocatable :: q(:, :), r(:, :), full(:, :)
    integer :: n, k
    n = size(mode%shape)
    self%n_shape = 1 + max(0, n - 1)
    call self%damping%init(mode)
    self%n = self%n_shape + merge(1, 0, self%damping%is_measured)
    self%number = mode%number
    self%log_frequency = log(mode%frequency)
    self%log_sigma = mode%frequency_sigma/mode%frequency
    allocate (self%sites(n), self%seen(n))
    self%seen = 0
    self%sigma = mode%sigma
    self%s = mode%shape/mode%sigma
    do k = 1, n
      self%sites(k) = find_material_point(model%points(:, :model%n_points), model%triangles, model%size, mode%place(:, k))
    end do
    if (n == 0) return
    allocate (full(n, n), source=0.0_rp)
    full(:, 1) = self%s
    k = maxloc(abs(self%s), 1) ! all unit vectors except number k complete s to a basis
    call fill_units(full, k)
    call orthogonalise(full, q, r)
    self%normal = q(:, 2:)
  end subroutine target_init

  !> Fills the columns from 2 on with all unit vectors but one.
  pure subroutine fill_units(full, left_out)
    real(rp), intent(inout) :: full(:, :)
    integer, intent(in) :: left_out
    integer :: i, column
    full(:, 2:) = 0
    column = 1
    do i = 1, size(full, 1)
      if (i == left_out) cycle
      column = column + 1
      full(i, column) = 1
    end do
  end subroutine fill_units

  !> Returns the displacements of shape(3, :) along z at the places, over the sd.
  pure function observe(self, shape) result(phi)
    class(mode_target_t), intent(in) :: self
    real(rp), intent(in) :: shape(:, :)
    real(rp) :: phi(size(self%s))
    integer :: k
    do k = 1, size(phi)
      phi(k) = dot_product(self%sites(k)%weight, shape(3, self%sites(k)%corner))/self%sigma(k)
    end do
  end function observe

  !> Returns the MAC of the mode with the space of shapes(3, :, :); negative if there are more shapes than the points can
  !> distinguish, or if they do not move the points.
  real(rp) function target_assurance(self, shapes) result(mac)
    class(mode_target_t), intent(in) :: self
    real(rp), intent(in) :: shapes(:, :, :)
    real(rp), allocatable :: phi(:, :), q(:, :), r(:, :)
    real(rp), parameter :: SEEN = 1.0e-9_rp ! of the metric size of the shape
    integer :: i
    mac = -1
    if (size(shapes, 3) >= size(self%s)) return
    allocate (phi(size(self%s), size(shapes, 3)))
    do i = 1, size(phi, 2)
      phi(:, i) = observe(self, shapes(:, :, i))
      if (maxval(abs(phi(:, i)*self%sigma)) < SEEN*maxval(abs(shapes(:, :, i)))) return
    end do
    call orthogonalise(phi, q, r)
    mac = sum(matmul(self%s, q)**2)/sum(self%s**2)
  end function target_assurance

  !> Returns exp(-(ln(f/f_m))^2/(2 spread^2)) for a computed frequency f [Hz].
  pure real(rp) function target_nearness(self, f, spread) result(nearness)
    class(mode_target_t), intent(in) :: self
    real(rp), intent(in) :: f, spread
    nearness = exp(-0.5_rp*((log(f) - self%log_frequency)/spread)**2)
  end function target_nearness

  !> Returns residuals(n), computed less measured, for the modes lo to hi with these lambdas [rad^2/s^2] and shapes.
  subroutine target_residuals(self, lambdas, shapes, residuals)
    class(mode_target_t), intent(inout) :: self
    real(rp), intent(in) :: lambdas(:), shapes(:, :, :)
    real(rp), intent(out) :: residuals(:)
    real(rp), parameter :: UNSEEN = 1.0e-12_rp
    real(rp) :: v(size(self%s)), trace
    logical :: ok
    integer :: i, m
    m = size(lambdas)
    self%lambdas = lambdas
    self%lambda = lambdas(1)
    if (size(self%s) == 0) self%beta = [1.0_rp]
    self%mac = 1
    if (size(self%s) > 0) then
      if (allocated(self%phi)) deallocate (self%phi)
      allocate (self%phi(size(self%s), m))
      do i = 1, m
        self%phi(:, i) = observe(self, shapes(:, :, i))
      end do
      self%gram = matmul(transpose(self%phi), self%phi)
      trace = sum(self%phi**2)
      do i = 1, m ! if the points do not distinguish all shapes, the smallest sum is taken
        self%gram(i, i) = self%gram(i, i) + UNSEEN*trace
      end do
      call factorise(self%gram, ok)
      self%beta = matmul(self%s, self%phi)
      call solve_factorised(self%gram, self%beta)
      self%lambda = sum(self%beta**2*lambdas)/sum(self%beta**2)
      v = matmul(self%phi, self%beta)
      v = v*sum(self%s**2)/dot_product(self%s, v)
      residuals(2:self%n_shape) = matmul(v, self%normal)
      self%seen = v*self%sigma
      self%mac = 1/(1 + sum(residuals(2:self%n_shape)**2)/sum(self%s**2))
    end if
    self%frequency = sqrt(self%lambda)/TWO_PI
    residuals(1) = (log(self%frequency) - self%log_frequency)/self%log_sigma
  end subroutine target_residuals

  !> Returns column(n), the derivative of the residuals, from the slopes of the modes lo to hi: force(:, :), for which a change of
  !> the masses counts with the lambda of each column, shapes(3, :, :), and the change rubbing(:, :) of the stiffness of joints
  !> between these modes. Call it after `damp`.
  subroutine target_tangent(self, force, shapes, is_mass, rubbing, column)
    class(mode_target_t), intent(in) :: self
    real(rp), intent(in) :: force(:, :), shapes(:, :, :), rubbing(:, :)
    logical, intent(in) :: is_mass
    real(rp), intent(out) :: column(:)
    real(rp) :: dphi(size(self%s), size(force, 1)), dbeta(size(force, 1)), dv(size(self%s)), v(size(self%s)), dlambda, f
    integer :: i, j
    column = 0
    if (size(self%s) == 0) then
      call put_slopes(self, self%damping%slopes(force(1, 1), rubbing, shapes, [0.0_rp]), column)
      return
    end if
    do i = 1, size(force, 1)
      dphi(:, i) = observe(self, shapes(:, :, i))
    end do
    v = matmul(self%phi, self%beta)
    dv = matmul(dphi, self%beta)
    dbeta = matmul(self%s - v, dphi) - matmul(dv, self%phi)
    call solve_factorised(self%gram, dbeta)
    dv = dv + matmul(self%phi, dbeta)
    associate (sv => dot_product(self%s, v), ss => sum(self%s**2))
      column(2:self%n_shape) = matmul(ss/sv*(dv - v*dot_product(self%s, dv)/sv), self%normal)
    end associate
    dlambda = 2*sum(self%beta*(self%lambdas - self%lambda)*dbeta)
    do i = 1, size(force, 1)
      do j = 1, size(force, 1)
        f = force(j, i)
        if (is_mass .and. j /= i) f = f*self%lambda/self%lambdas(i)
        dlambda = dlambda + self%beta(i)*self%beta(j)*f
      end do
    end do
    call put_slopes(self, self%damping%slopes(dlambda/sum(self%beta**2), rubbing, shapes, dbeta/norm2(self%beta)), column)
  end subroutine target_tangent

  !> Sets frequency and damping ratio of a column from their slopes.
  subroutine put_slopes(self, slopes, column)
    class(mode_target_t), intent(in) :: self
    real(rp), intent(in) :: slopes(2)
    real(rp), intent(inout) :: column(:)
    column(1) = slopes(1)/self%log_sigma
    if (self%damping%is_measured) column(self%n) = slopes(2)/self%damping%sigma
  end subroutine put_slopes

  !> Returns column(n), the derivative of the residuals with respect to damping effect `number`; see motion_simulation_t. Call it
  !> after `damp`.
  subroutine target_damping_tangent(self, number, time, column)
    class(mode_target_t), intent(in) :: self
    integer, intent(in) :: number
    real(rp), intent(in) :: time
    real(rp), intent(out) :: column(:)
    column = 0
    call put_slopes(self, self%damping%effect_slopes(number, time), column)
  end subroutine target_damping_tangent

  !> Gives the mode its damping, after `residuals`: sets the residuals of frequency and damping ratio. bent(3, n_all, :) are the
  !> forces of joints K_joints phi of the modes shapes(3, n_all, lo:hi); of size 0 without joints.
  subroutine target_damp(self, effects, bent, shapes, residuals)
    class(mode_target_t), intent(inout) :: self
    type(damping_effects_t), intent(in) :: effects
    real(rp), intent(in) :: bent(:, :, :), shapes(:, :, :)
    real(rp), intent(inout) :: residuals(:)
    call self%damping%find(effects, self%lambda, self%beta, bent, shapes)
    self%frequency = exp(self%damping%decay%log_rate)/TWO_PI
    residuals(1) = (log(self%frequency) - self%log_frequency)/self%log_sigma
    if (self%damping%is_measured) residuals(self%n) = (self%damping%decay%ratio - self%damping%measured)/self%damping%sigma
  end subroutine target_damp
end module measurement_mode_target
