! SPDX-License-Identifier: GPL-3.0-or-later
!> Advances a flyer in the flow: a free body (fsi_free_body) under its weight, the forces of the flow and the inertia of the
!> fluid that it displaces.
!>
!> The penalization force F_p = int chi/C_eta (u - u_s) also acts on the fluid in the mask. The flow acts on the insect with F =
!> F_p + d/dt int chi u_s, and likewise for the moments. Here the last term is on the left side of the equations of motion, as
!> Uhlmann 2005 (DOI 10.1016/j.jcp.2005.03.017) and FLUSI do for a sphere:
!>
!>     d/dt (momentum of the insect - momentum of the displaced fluid, moving with it) = F_p + weight.
!>
!> The fluid loses the momentum that the left side gains. Both have the same weights in time, so that the sum is conserved to
!> round-off. FLUSI without its unsteady corrections omits the momentum of the displaced fluid. The insect then carries the fluid in
!> its mask, as if the fluid were a part of its mass (`carries_fluid`). The sum of momenta is conserved in both cases.
!>
!> If the body is as free as the fluid in it, the penalization force damps a slip s in the mask as ds/dt = -s/C_eta/(1 - m_f/m). The
!> explicit step must therefore be shorter by the smallest factor 1 - m_f/m of all motions (`least_fraction`). At the limit of AB2
!> its second root is -1, and the body would oscillate from step to step; at the share DAMPED of the limit the root is -0.74.
module fsi_flyer
  use base_kinds, only: rp
  use base_lapack, only: factorise, solve_lower, symmetric_eigen
  use fsi_body_motion, only: body_motion_t
  use fsi_free_body, only: free_body_t, inertia_matrix
  use fsi_moments, only: moments_t, whole_t
  use fsi_quaternion, only: matrix_of
  use fsi_rotation, only: cross
  implicit none
  private
  public :: flyer_params_t, flyer_t, least_fraction, DAMPED, SMALLEST_FRACTION

  real(rp), parameter :: DAMPED = 0.8_rp
  real(rp), parameter :: SMALLEST_FRACTION = 0.1_rp !< of 1 - m_f/m: a body lighter than that cannot be advanced

  type :: flyer_params_t
    logical :: is_free = .false.
    real(rp) :: mass = 0        !< of the insect, wings included, rho L^3
    real(rp) :: gravity = 0     !< along z, L/T^2
    real(rp) :: inertia(3) = 0  !< of the body about its x (roll), y (pitch) and z (yaw), rho L^5
    logical :: held(6) = .false. !< along x, y, z of space; about x, y, z of the body
    logical :: conditioner = .false. !< the forces of the flow begin smoothly
    real(rp) :: release = 0     !< everything is held until then, T
    logical :: carries_fluid = .false. !< the fluid in the mask moves with the insect as if it were part of it
  contains
    procedure :: held_at => params_held_at
    procedure :: growth_at => params_growth_at
  end type flyer_params_t

  type :: flyer_t
    type(flyer_params_t) :: params
    type(free_body_t) :: state
    type(moments_t) :: body             !< of the body without its wings, in its frame
    type(moments_t) :: displaced        !< of the fluid that it displaces
    type(body_motion_t) :: carried      !< as flexible wings assumed it at the ends of the last two steps
    real(rp) :: force(3) = 0            !< of the penalization, last felt, rho L^4/T^2
    real(rp) :: moment(3) = 0           !< about the body's centre
    real(rp) :: marker_force(3) = 0     !< on wings without thickness in the last step
    real(rp) :: marker_moment(3) = 0
    real(rp) :: fraction = 1            !< `least_fraction` over the beat
    logical :: is_restored = .false.    !< the state is that of a checkpoint
  contains
    procedure :: load => flyer_load
    procedure :: feel => flyer_feel
    procedure :: advance => flyer_advance
    procedure :: settle => flyer_settle
  end type flyer_t

contains

  !> Returns the degrees of freedom that are held at `time` [T].
  pure function params_held_at(self, time) result(held)
    class(flyer_params_t), intent(in) :: self
    real(rp), intent(in) :: time
    logical :: held(6)
    held = self%held .or. time < self%release
  end function params_held_at

  !> Returns the factor on the forces of the flow. With the conditioner it is 0 until t = 0.1 and grows by a cubic to 1 at 0.6.
  pure real(rp) function params_growth_at(self, time) result(growth)
    class(flyer_params_t), intent(in) :: self
    real(rp), intent(in) :: time
    real(rp), parameter :: BEGIN = 0.1_rp, LASTS = 0.5_rp
    real(rp) :: s
    growth = 1
    if (.not. self%conditioner) return
    s = max(0.0_rp, min(1.0_rp, (time - BEGIN)/LASTS))
    growth = s*s*(3 - 2*s)
  end function params_growth_at

  !> Returns the force [rho L^4/T^2] and the moment [rho L^5/T^2] about the body's centre, in space, that act at `time` [T], without
  !> the forces of markers.
  pure subroutine flyer_load(self, time, whole, force, moment)
    class(flyer_t), intent(in) :: self
    real(rp), intent(in) :: time
    type(whole_t), intent(in) :: whole
    real(rp), intent(out) :: force(3), moment(3)
    real(rp) :: weight(3)
    weight = [0.0_rp, 0.0_rp, self%params%gravity]
    force = self%params%growth_at(time)*self%force + self%params%mass*weight
    moment = self%params%growth_at(time)*self%moment + &
             cross(matmul(whole%heavy, matrix_of(self%state%attitude)), weight)
  end subroutine flyer_load

  !> Takes the forces of the penalization at `time` [T], and finds the accelerations. `moment` is about the body's centre.
  pure subroutine flyer_feel(self, time, force, moment, whole)
    class(flyer_t), intent(inout) :: self
    real(rp), intent(in) :: time, force(3), moment(3)
    type(whole_t), intent(in) :: whole
    real(rp) :: load(3, 2), growth
    self%force = force
    self%moment = moment
    growth = self%params%growth_at(time)
    call self%load(time, whole, load(:, 1), load(:, 2))
    call self%state%accelerate(whole, self%params%held_at(time), load(:, 1) + growth*self%marker_force, &
                               load(:, 2) + growth*self%marker_moment)
  end subroutine flyer_feel

  !> Advances the state to the end of a step dt [T] that began at `time`, from `before` at its beginning to `after`, as far as is
  !> possible without the forces of the markers. `carried` becomes the body that follows from the last forces of the markers.
  pure subroutine flyer_advance(self, time, dt, before, after)
    class(flyer_t), intent(inout) :: self
    real(rp), intent(in) :: time, dt
    type(whole_t), intent(in) :: before, after
    type(free_body_t) :: next
    real(rp) :: load(3, 2), growth
    call self%load(time, before, load(:, 1), load(:, 2))
    call self%state%advance(dt, load(:, 1), load(:, 2))
    growth = self%params%growth_at(time)
    next = self%state
    call next%push(dt*growth*self%marker_force, dt*growth*self%marker_moment)
    call next%settle(after, self%params%held_at(time))
    call self%load(time + dt, after, load(:, 1), load(:, 2))
    call next%accelerate(after, self%params%held_at(time + dt), load(:, 1) + growth*self%marker_force, &
                         load(:, 2) + growth*self%marker_moment)
    call self%carried%show(time + dt, next%body())
  end subroutine flyer_advance

  !> Completes that step with the forces that the markers had in it; `after` is the insect at the end of the step.
  pure subroutine flyer_settle(self, time, dt, after, marker_force, marker_moment)
    class(flyer_t), intent(inout) :: self
    real(rp), intent(in) :: time, dt
    type(whole_t), intent(in) :: after
    real(rp), intent(in) :: marker_force(3), marker_moment(3) !< about the body's centre at the end
    self%marker_force = marker_force
    self%marker_moment = marker_moment
    associate (growth => self%params%growth_at(time))
      call self%state%push(dt*growth*marker_force, dt*growth*marker_moment)
    end associate
    call self%state%settle(after, self%params%held_at(time))
  end subroutine flyer_settle

  !> Returns the least of (inertia without the displaced fluid)/(inertia) over all motions that are free: the smallest eigenvalue of
  !> the two tensors of inertia, 6 x 6. It is 1 without penalized solids, and below 0 if `own` is not a valid inertia.
  real(rp) function least_fraction(own, rest, held) result(fraction)
    type(whole_t), intent(in) :: own  !< the insect
    type(whole_t), intent(in) :: rest !< without the fluid that it displaces
    logical, intent(in) :: held(6)
    real(rp), parameter :: UNIT(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3])
    real(rp) :: a(6, 6), b(6, 6)
    real(rp), allocatable :: l(:, :), c(:, :), values(:)
    integer, allocatable :: free(:)
    integer :: i
    logical :: ok
    fraction = 1
    free = pack([(i, i=1, 6)], mask=.not. held)
    if (size(free) == 0) return
    call inertia_matrix(own, UNIT, a)
    call inertia_matrix(rest, UNIT, b)
    l = a(free, free)
    c = b(free, free)
    allocate (values(size(free)))
    call factorise(l, ok)
    if (.not. ok) then
      fraction = -1
      return
    end if
    call solve_lower(l, c)
    c = transpose(c)
    call solve_lower(l, c)
    call symmetric_eigen(c, values)
    fraction = min(1.0_rp, values(1))
  end function least_fraction
end module fsi_flyer
