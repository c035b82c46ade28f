! SPDX-License-Identifier: GPL-3.0-or-later
!> Sets the velocity at t = 0, on the full spectrum.
!>
!> Conditions given by their vorticity become velocities by u = i k x omega/k^2 (k /= 0).
module fluid_initial
  use base_constants, only: PI
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use fluid_bodies, only: check_box
  use fluid_initial_keys, only: FLOW_FILES, FLOW_MEAN, FLOW_QUIESCENT, FLOW_RING, FLOW_ROGALLO, FLOW_SPECTRUM, &
                                FLOW_TAYLOR_GREEN, FLOW_TAYLOR_GREEN_2D
  use fluid_kernels, only: biot_savart, project_stick
  use fluid_params, only: fluid_params_t
  use fluid_spectrum, only: random_velocity
  use io_fields, only: read_field, field_meta_t
  use parallel_block, only: allocate_fields
  use parallel_world, only: world_t
  use spectral_transform, only: transform_t
  implicit none
  private
  public :: initial_velocity, is_uniform, set_mean

contains

  !> Fills the full spectrum u (nkz, sticks, 3) of the velocity at t = 0 by the transform `full`. Fails if a file cannot be
  !> read. Collective.
  subroutine initial_velocity(full, params, u, time, failure)
    class(transform_t), intent(inout) :: full
    type(fluid_params_t), intent(in) :: params
    complex(rp), contiguous, target, intent(inout) :: u(:, :, :)
    real(rp), intent(out) :: time !< when the run starts: 0, or the time of the files
    type(failure_t), intent(inout) :: failure
    real(rp), allocatable :: field(:, :, :, :)
    integer :: c

    time = 0
    u = 0
    if (any(params%initial%flow == [FLOW_ROGALLO, FLOW_SPECTRUM])) then
      call random_velocity(full%world, params, full%sticks, u, failure)
      return
    end if
    ! One component at a time, to save memory.
    call allocate_fields(field, full%block, 1, 'a field of the initial condition')
    do c = 1, 3
      select case (params%initial%flow)
      case (FLOW_RING)
        call vortex_ring(params, full, c, field(:, :, :, 1))
      case (FLOW_TAYLOR_GREEN, FLOW_TAYLOR_GREEN_2D)
        call taylor_green(params, full, c, field(:, :, :, 1))
      case (FLOW_FILES)
        call from_file(full%world, params, full, c, field(:, :, :, 1), time, failure)
        if (failure%failed) return
      case default
        call require(.false., 'initial_velocity: the registry allows an unknown condition')
      end select
      call full%forward(field, u(:, :, c:c))
    end do
    deallocate (field)
    if (params%initial%flow == FLOW_RING) then
      call vorticity_to_velocity(full, u)
      call set_mean(full, params%mean%velocity, u)
    else
      ! In a box that is not a cube the classical field is not solenoidal, and fields from files of single precision are solenoidal
      ! to 1e-7 only.
      call project(full, u)
    end if
  end subroutine initial_velocity

  !> Tells whether the flow begins at rest or with its mean flow alone. Truncation does not change such a flow.
  pure logical function is_uniform(params)
    type(fluid_params_t), intent(in) :: params
    is_uniform = any(params%initial%flow == [FLOW_QUIESCENT, FLOW_MEAN])
  end function is_uniform

  !> Sets the mean of the velocity with the spectrum `u` of the transform `full` to `mean` [L/T].
  subroutine set_mean(full, mean, u)
    class(transform_t), intent(in) :: full
    real(rp), intent(in) :: mean(3)
    complex(rp), intent(inout) :: u(:, :, :)
    if (full%sticks%zero > 0) u(1, full%sticks%zero, 1:3) = mean
  end subroutine set_mean

  !> Replaces the vorticity in u by its velocity.
  subroutine vorticity_to_velocity(full, u)
    class(transform_t), intent(in) :: full
    complex(rp), intent(inout) :: u(:, :, :)
    complex(rp), allocatable :: omega(:, :)
    integer :: s
    allocate (omega(full%sticks%nkz, 3))
    do s = 1, full%sticks%n
      omega = u(:, s, :)
      associate (t => full%sticks)
        call biot_savart(t%nkz, t%kx(s), t%ky(s), t%kz, omega(:, 1), omega(:, 2), omega(:, 3), u(:, s, 1), &
                         u(:, s, 2), u(:, s, 3))
      end associate
    end do
  end subroutine vorticity_to_velocity

  !> Removes the gradient part of u.
  subroutine project(full, u)
    class(transform_t), intent(in) :: full
    complex(rp), intent(inout) :: u(:, :, :)
    complex(rp), allocatable :: potential(:)
    integer :: s
    allocate (potential(full%sticks%nkz))
    do s = 1, full%sticks%n
      associate (t => full%sticks)
        call project_stick(t%nkz, t%kx(s), t%ky(s), t%kz, u(:, s, 1), u(:, s, 2), u(:, s, 3), potential)
      end associate
    end do
  end subroutine project

  !> Returns component `c` of the vorticity of a ring in a plane x = const. Its core is a = 0.82 r0, its circulation omega1 and
  !> its centre (x0, y0, z0).
  subroutine vortex_ring(p, full, c, omega)
    type(fluid_params_t), intent(in) :: p
    class(transform_t), intent(in) :: full
    integer, intent(in) :: c
    real(rp), intent(inout) :: omega(:, :, :)
    real(rp), parameter :: CORE = 0.82_rp
    real(rp) :: q(3), r, a, w
    integer :: x, y, z
    a = CORE*p%solids%size
    do z = 1, full%block%count(3)
      do y = 1, full%block%count(2)
        do x = 1, full%block%count(1)
          q = ([x, y, z] - 1 + full%block%start)*p%grid%spacing - p%solids%centre
          r = hypot(q(2), q(3))
          w = p%initial%omega1/(PI*a**2)*exp(-(q(1)**2 + (r - p%solids%size)**2)/a**2)
          omega(x, y, z) = 0
          if (r > 0 .and. c > 1) omega(x, y, z) = merge(-w*q(3)/r, w*q(2)/r, c == 2)
        end do
      end do
    end do
  end subroutine vortex_ring

  !> Returns component `c` of Taylor-Green vortices scaled to the box: in 2-D (sin y cos z, -cos y sin z), in 3-D (sin x cos y cos
  !> z, -cos x sin y cos z, 0).
  subroutine taylor_green(p, full, c, u)
    type(fluid_params_t), intent(in) :: p
    class(transform_t), intent(in) :: full
    integer, intent(in) :: c
    real(rp), intent(inout) :: u(:, :, :)
    real(rp) :: q(3), all(3)
    integer :: x, y, z
    do z = 1, full%block%count(3)
      do y = 1, full%block%count(2)
        do x = 1, full%block%count(1)
          q = 2*PI*real([x, y, z] - 1 + full%block%start, rp)/p%grid%n
          if (p%grid%is_2d) then
            all = [0.0_rp, sin(q(2))*cos(q(3)), -cos(q(2))*sin(q(3))]
          else
            all = [sin(q(1))*cos(q(2))*cos(q(3)), -cos(q(1))*sin(q(2))*cos(q(3)), 0.0_rp]
          end if
          u(x, y, z) = all(c)
        end do
      end do
    end do
  end subroutine taylor_green

  !> Reads component `c` of the velocity from a field file of the same grid and box, and the time at which it was written.
  subroutine from_file(world, p, full, c, u, time, failure)
    type(world_t), intent(in) :: world
    type(fluid_params_t), intent(in) :: p
    class(transform_t), intent(in) :: full
    integer, intent(in) :: c
    real(rp), contiguous, intent(inout) :: u(:, :, :)
    real(rp), intent(inout) :: time
    type(failure_t), intent(inout) :: failure
    type(field_meta_t) :: meta
    call read_field(world, trim(p%initial%file_u(c)), full%block, u, meta, failure)
    if (failure%failed) return
    call check_box(trim(p%initial%file_u(c)), meta, p%grid, failure)
    time = meta%time
  end subroutine from_file
end module fluid_initial
