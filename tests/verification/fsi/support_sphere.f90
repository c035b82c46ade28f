! SPDX-License-Identifier: GPL-3.0-or-later
!> A sphere in the mask that moves freely in the flow.
module support_sphere
  use base_constants, only: PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_bodies, only: mask_profile
  use fluid_moving_solids, only: moving_solids_t
  use fluid_penalty, only: COLOR_BODY, N_COLORS, penalty_t
  use fluid_solver, only: fluid_t
  use fluid_sums, only: sums_t
  use fsi_body_volume, only: displaced_moments
  use fsi_flyer, only: DAMPED, flyer_t, least_fraction
  use fsi_moments, only: second_of_inertia, whole_t
  use fsi_rotation, only: cross
  use parallel_block, only: block_t
  use parallel_world, only: world_t
  use spectral_grid, only: grid_t
  implicit none
  private
  public :: sphere_t

  type, extends(moving_solids_t) :: sphere_t
    type(flyer_t) :: flyer
    type(grid_t) :: grid
    type(block_t) :: block
    real(rp) :: radius = 0.5_rp
    real(rp) :: time = 0
  contains
    procedure :: init => sphere_init
    procedure :: whole => sphere_whole
    procedure :: move => sphere_move
    procedure :: place => sphere_place
    procedure :: feel => sphere_feel
    procedure :: refer => sphere_refer
    procedure :: momentum_rate => sphere_momentum_rate
    procedure :: max_speed => sphere_max_speed
  end type sphere_t

contains

  !> A sphere of diameter 1 and this density, under this weight and buoyancy together; the step of the fluid is limited as
  !> its density asks for. `flyer` has its place and velocities. Collective.
  subroutine sphere_init(self, world, fluid, density, weight)
    class(sphere_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(fluid_t), intent(inout) :: fluid
    real(rp), intent(in) :: density, weight
    type(failure_t) :: failure
    type(whole_t) :: own
    real(rp) :: inertia(3, 3)
    integer :: i
    self%grid = fluid%rhs%params%grid
    self%block = fluid%transform%block
    associate (flyer => self%flyer)
      flyer%params%is_free = .true.
      flyer%params%mass = density*PI/6
      flyer%params%gravity = -weight/flyer%params%mass
      flyer%body%mass = flyer%params%mass
      inertia = 0
      do i = 1, 3
        inertia(i, i) = flyer%params%mass/10
      end do
      flyer%body%second = second_of_inertia(inertia)
      call self%place(0.0_rp, fluid%rhs%penalty, failure)
      flyer%displaced = displaced_moments(world, self%grid, self%block, fluid%rhs%penalty, COLOR_BODY, &
                                          flyer%state%centre, reshape([1.0_rp, 0.0_rp, 0.0_rp, 0.0_rp, 1.0_rp, 0.0_rp, &
                                                                       0.0_rp, 0.0_rp, 1.0_rp], [3, 3]))
      call flyer%state%start(self%whole())
      call own%add_part(flyer%body)
      fluid%rhs%params%solids%dt_fraction = DAMPED*least_fraction(own, self%whole(), flyer%params%held)
    end associate
  end subroutine sphere_init

  pure type(whole_t) function sphere_whole(self) result(whole)
    class(sphere_t), intent(in) :: self
    call whole%add_part(self%flyer%body%minus(self%flyer%displaced))
  end function sphere_whole

  !> After a step of the fluid.
  subroutine sphere_move(self, fluid)
    class(sphere_t), intent(inout) :: self
    type(fluid_t), intent(in) :: fluid
    type(whole_t) :: whole
    whole = self%whole()
    call self%flyer%advance(fluid%sums_time, fluid%dt, whole, whole)
    call self%flyer%settle(fluid%sums_time, fluid%dt, whole, [0.0_rp, 0.0_rp, 0.0_rp], [0.0_rp, 0.0_rp, 0.0_rp])
  end subroutine sphere_move

  subroutine sphere_place(self, time, penalty, failure)
    class(sphere_t), intent(inout) :: self
    real(rp), intent(in) :: time
    type(penalty_t), intent(inout) :: penalty
    type(failure_t), intent(inout) :: failure
    real(rp) :: r(3), h, chi(self%block%count(1)), us(3, self%block%count(1))
    integer :: x, y, z, n, points(self%block%count(1)), color(self%block%count(1))
    self%time = time
    if (failure%failed) return
    h = 1.5_rp*self%grid%max_spacing()
    color = COLOR_BODY
    call penalty%erase_overlay()
    do z = 1, self%block%count(3)
      do y = 1, self%block%count(2)
        n = 0
        do x = 1, self%block%count(1)
          r = ([x - 1, y - 1, z - 1] + self%block%start)*self%grid%spacing - self%flyer%state%centre
          r = r - self%grid%length*anint(r/self%grid%length)
          if (norm2(r) >= self%radius + h) cycle
          n = n + 1
          points(n) = x
          chi(n) = mask_profile(norm2(r) - self%radius, h)
          us(:, n) = self%flyer%state%velocity + cross(self%flyer%state%omega, r)
        end do
        if (n > 0) call penalty%overlay_line(y + self%block%count(2)*(z - 1), n, points, chi, us, color)
      end do
    end do
  end subroutine sphere_place

  subroutine sphere_feel(self, sums)
    class(sphere_t), intent(inout) :: self
    type(sums_t), intent(in) :: sums
    call self%flyer%feel(self%time, sums%force(:, COLOR_BODY), sums%moment(:, COLOR_BODY), self%whole())
  end subroutine sphere_feel

  subroutine sphere_refer(self, centre)
    class(sphere_t), intent(in) :: self
    real(rp), intent(inout) :: centre(3)
    centre = self%flyer%state%centre
  end subroutine sphere_refer

  subroutine sphere_momentum_rate(self, centre, force, moment)
    class(sphere_t), intent(in) :: self
    real(rp), intent(in) :: centre(3)
    real(rp), intent(inout) :: force(3, 0:N_COLORS - 1), moment(3, 0:N_COLORS - 1)
    force(:, COLOR_BODY) = force(:, COLOR_BODY) + self%flyer%displaced%mass*self%flyer%state%acceleration
    moment(:, COLOR_BODY) = moment(:, COLOR_BODY) + self%flyer%displaced%mass* &
                            cross(self%flyer%state%centre - centre, self%flyer%state%acceleration)
  end subroutine sphere_momentum_rate

  real(rp) function sphere_max_speed(self) result(speed)
    class(sphere_t), intent(in) :: self
    speed = norm2(self%flyer%state%velocity) + self%radius*norm2(self%flyer%state%omega)
  end function sphere_max_speed
end module support_sphere
