! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes all terms of the equation of motion except the elastic forces: inertia in the moving frame, damping, weight; and
!> energy and momentum.
module solid_inertia
  use base_kinds, only: rp
  use solid_model, only: solid_model_t
  use solid_motion, only: frame_t, inertial_velocity
  use solid_point_areas, only: point_areas
  use solid_stiffness_effects, only: keep_joints
  use solid_tangent, only: assemble_tangent
  use solid_vectors, only: cross, outer, IDENTITY
  implicit none
  private
  public :: inertia_t, momenta_t, add_inertia_forces, add_inertia_tangent, apply_gyroscopic, gyroscopic_turn, &
            measure_motion

  !> Masses and damping. The damping acts on the motion within the wing frame.
  type :: inertia_t
    real(rp), allocatable :: mass(:)        !< (n_all) [kg], 0 at ghost points
    real(rp), allocatable :: nodal(:)       !< (n_all) [kg/s] damping of every point
    real(rp), allocatable :: area(:)        !< (n_all) [m^2] of the membrane
    real(rp) :: rayleigh_mass = 0           !< [1/s] times the mass
    real(rp) :: rayleigh_stiffness = 0      !< [s] times the rate of the elastic forces
    real(rp) :: relaxation = 0              !< g: for a sudden force the stiffness is 1 + g times larger,
    real(rp) :: relaxation_time = 1         !< [s] and the increase relaxes with this time
    real(rp) :: joint_friction = 0          !< [s] times the rate of the elastic moments of joints
    real(rp) :: drag = 0                    !< [kg/m^3] times the area and the square of the velocity, against it
    type(solid_model_t), allocatable, private :: joints !< the joints alone, if they have friction
  contains
    procedure :: init => inertia_init
    procedure :: hold_joints => inertia_hold_joints
    procedure :: loss => inertia_loss
    procedure :: elastic_factor => inertia_elastic_factor
    procedure :: remembered => inertia_remembered
    procedure :: rubs => inertia_rubs
    procedure :: joint_forces => inertia_joint_forces
    procedure :: joint_tangent => inertia_joint_tangent
  end type inertia_t

  !> Sums over all points, in an inertial frame with components along the wing frame.
  type :: momenta_t
    real(rp) :: mass = 0                    !< [kg]
    real(rp) :: centre(3) = 0               !< [m] centre of mass, from the frame's origin
    real(rp) :: kinetic = 0                 !< [J]
    real(rp) :: relative_kinetic = 0        !< [J] of the motion within the wing frame
    real(rp) :: elastic = 0                 !< [J]
    real(rp) :: linear(3) = 0               !< [kg m/s]
    real(rp) :: angular(3) = 0              !< [kg m^2/s] about the frame's origin
  end type momenta_t

contains

  !> Takes the masses(n_points) [kg] of the points of the wing. Ghost points have none. Damping keeps its values.
  subroutine inertia_init(self, model, masses)
    class(inertia_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: masses(:)
    if (allocated(self%mass)) deallocate (self%mass, self%nodal, self%area)
    allocate (self%mass(model%n_all), self%nodal(model%n_all), self%area(model%n_all), source=0.0_rp)
    self%mass(:size(masses)) = masses
    self%area(:model%n_points) = point_areas(model%points(:, :model%n_points), model%triangles)
    call self%hold_joints(model)
  end subroutine inertia_init

  !> Takes over a changed `joint_friction`. The joints of `model` have the friction.
  subroutine inertia_hold_joints(self, model)
    class(inertia_t), intent(inout) :: self
    type(solid_model_t), intent(in) :: model
    if (allocated(self%joints)) deallocate (self%joints)
    if (self%joint_friction > 0 .and. any(model%plans%joint > 0)) call keep_joints(model, self%joints)
  end subroutine inertia_hold_joints

  !> Tells whether joints have friction.
  pure logical function inertia_rubs(self) result(rubs)
    class(inertia_t), intent(in) :: self
    rubs = allocated(self%joints)
  end function inertia_rubs

  !> Returns the forces f(3, n_all) [N] of the joints alone at displacements u(3, n_all), if there is friction in them; 0 at
  !> clamped points.
  subroutine inertia_joint_forces(self, u, f)
    class(inertia_t), intent(in) :: self
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(inout) :: f(:, :)
    call self%joints%gradient(u, f)
    call self%joints%zero_clamped(f)
  end subroutine inertia_joint_forces

  !> Sets `blocks` to the derivatives of these forces with respect to u, or to the sum of the positive semidefinite parts of the
  !> elements.
  subroutine inertia_joint_tangent(self, u, semidefinite, blocks)
    class(inertia_t), intent(in) :: self
    real(rp), intent(in) :: u(:, :)
    logical, intent(in) :: semidefinite
    real(rp), intent(out) :: blocks(:, :, :)
    call assemble_tangent(self%joints, u, self%joints%springs%tension, semidefinite, blocks)
  end subroutine inertia_joint_tangent

  !> Returns the power [W] that damping by mass, by points and by drag takes from point p at the velocity v [m/s] within the frame.
  pure real(rp) function inertia_loss(self, p, v) result(power)
    class(inertia_t), intent(in) :: self
    integer, intent(in) :: p
    real(rp), intent(in) :: v(3)
    power = (self%rayleigh_mass*self%mass(p) + self%nodal(p) + self%drag*self%area(p)*norm2(v))*dot_product(v, v)
  end function inertia_loss

  !> Returns the derivative of the elastic, viscous and viscoelastic forces together with respect to the elastic force alone, if
  !> the rate of a quantity is rate_of [1/s] times its change.
  pure real(rp) function inertia_elastic_factor(self, rate_of) result(factor)
    class(inertia_t), intent(in) :: self
    real(rp), intent(in) :: rate_of
    factor = 1 + rate_of*self%rayleigh_stiffness
    if (self%relaxation > 0) factor = factor + self%relaxation*rate_of/(rate_of + 1/self%relaxation_time)
  end function inertia_elastic_factor

  !> Returns the elastic and viscoelastic force f [N] for the elastic force g [N]: f = g + relaxation z with z' = g' - z/tau. The
  !> rates of both forces are rate_of (g - bg) and rate_of (f - bf), with rate_of in 1/s.
  pure elemental real(rp) function inertia_remembered(self, rate_of, g, bg, bf) result(f)
    class(inertia_t), intent(in) :: self
    real(rp), intent(in) :: rate_of, g, bg, bf
    f = g + rate_of*(self%relaxation*(g - bg) + bf - bg)/(rate_of + 1/self%relaxation_time)
  end function inertia_remembered

  !> Adds to r(3, n_all) [N] mass times acceleration, the forces of damping, and minus the weight, for displacements u [m],
  !> velocities v [m/s] and their rate [m/s^2] within the frame, all (3, n_all). Clamped points stay unchanged.
  pure subroutine add_inertia_forces(self, model, frame, u, v, rate, r)
    type(inertia_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :), rate(:, :)
    real(rp), intent(inout) :: r(:, :)
    real(rp) :: x(3), a(3)
    integer :: i, p
    do i = 1, model%n_free
      p = model%movable(i)
      x = model%points(:, p) + u(:, p)
      a = rate(:, p) + frame%acceleration - frame%gravity + 2*cross(frame%omega, v(:, p)) &
          + cross(frame%alpha, x) + cross(frame%omega, cross(frame%omega, x)) + self%rayleigh_mass*v(:, p)
      r(:, p) = r(:, p) + self%mass(p)*a + (self%nodal(p) + self%drag*self%area(p)*norm2(v(:, p)))*v(:, p)
    end do
  end subroutine add_inertia_forces

  !> Adds the symmetric part of the derivative of these forces with respect to u to the diagonal blocks blocks(3, 3, :) [N/m],
  !> where dv/du = rate_of and d(rate)/du = rate_of^2, rate_of in 1/s, at velocities v(3, n_all) [m/s].
  pure subroutine add_inertia_tangent(self, model, frame, rate_of, v, blocks)
    type(inertia_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: rate_of, v(:, :)
    real(rp), intent(inout) :: blocks(:, :, :)
    real(rp) :: centrifugal(3, 3), speed
    integer :: i, p, b
    centrifugal = outer(frame%omega, frame%omega) - dot_product(frame%omega, frame%omega)*IDENTITY
    do i = 1, model%n_free
      p = model%movable(i)
      b = model%pattern%start(i + 1) - 1
      blocks(:, :, b) = blocks(:, :, b) + self%mass(p)*centrifugal + &
                        (rate_of*(self%mass(p)*(rate_of + self%rayleigh_mass) + self%nodal(p)))*IDENTITY
      speed = norm2(v(:, p))
      if (self%drag*speed > 0) &
        blocks(:, :, b) = blocks(:, :, b) + (rate_of*self%drag*self%area(p))*(speed*IDENTITY + outer(v(:, p), v(:, p))/speed)
    end do
  end subroutine add_inertia_tangent

  !> Sets y(3, n_all) to the skew part of that derivative (Coriolis force, angular acceleration) times x(3, n_all), at the points
  !> that can move.
  pure subroutine apply_gyroscopic(self, model, frame, rate_of, x, y)
    type(inertia_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: rate_of, x(:, :)
    real(rp), intent(inout) :: y(:, :)
    integer :: i, p
    do i = 1, model%n_free
      p = model%movable(i)
      y(:, p) = cross(gyroscopic_turn(self, frame, rate_of, p), x(:, p))
    end do
  end subroutine apply_gyroscopic

  !> Returns the vector t [kg/s^2] of point p for which the skew part of that derivative takes x to the cross product t x x.
  pure function gyroscopic_turn(self, frame, rate_of, p) result(turn)
    type(inertia_t), intent(in) :: self
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: rate_of
    integer, intent(in) :: p
    real(rp) :: turn(3)
    turn = self%mass(p)*(2*rate_of*frame%omega + frame%alpha)
  end function gyroscopic_turn

  !> Returns mass, centre of mass, energies and momenta at displacements u(3, n_all) [m] and velocities v(3, n_all) [m/s] within
  !> the frame; see `momenta_t` for units.
  function measure_motion(self, model, frame, u, v) result(m)
    type(inertia_t), intent(in) :: self
    type(solid_model_t), intent(in) :: model
    type(frame_t), intent(in) :: frame
    real(rp), intent(in) :: u(:, :), v(:, :)
    type(momenta_t) :: m
    real(rp) :: x(3), w(3)
    integer :: i
    do i = 1, model%n_points
      x = model%points(:, i) + u(:, i)
      w = inertial_velocity(frame, x, v(:, i))
      m%mass = m%mass + self%mass(i)
      m%centre = m%centre + self%mass(i)*x
      m%kinetic = m%kinetic + 0.5_rp*self%mass(i)*dot_product(w, w)
      m%relative_kinetic = m%relative_kinetic + 0.5_rp*self%mass(i)*dot_product(v(:, i), v(:, i))
      m%linear = m%linear + self%mass(i)*w
      m%angular = m%angular + self%mass(i)*cross(x, w)
    end do
    if (m%mass > 0) m%centre = m%centre/m%mass
    m%elastic = model%energy(u)
  end function measure_motion
end module solid_inertia
