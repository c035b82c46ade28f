! SPDX-License-Identifier: GPL-3.0-or-later
!> The flow at t = 0, on the full spectrum.
!>
!> Conditions given by their vorticity become velocities by u = i k x omega/k^2 (k /= 0).
module fluid_initial
  use base_constants, only: PI
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_memory, only: check_allocation, COMPLEX_BYTES
  use fluid_bodies, only: check_box
  use fluid_kernels, only: stick_fields, stick_divergence, biot_savart, project_stick
  use fluid_params, only: fluid_params_t
  use fluid_spectrum, only: random_velocity
  use io_fields, only: read_field, field_meta_t
  use parallel_world, only: world_t
  use spectral_backends, only: make_full_transform
  use spectral_transform, only: transform_t
  implicit none
  private
  public :: initial_velocity

contains

  !> Fills fields(nx, ny_local, nz_local, 7) with velocity, vorticity and divergence at t = 0 on this
  !> rank's block, as `main` has it. Fails if a file cannot be read. Uses a second, untruncated transform
  !> while it works. Collective.
  subroutine initial_velocity(main, params, fields, time, failure)
    class(transform_t), intent(in) :: main
    type(fluid_params_t), intent(in) :: params
    real(rp), contiguous, intent(inout) :: fields(:, :, :, :)
    real(rp), intent(out) :: time !< when the run starts: 0, or the time of the files
    type(failure_t), intent(inout) :: failure
    class(transform_t), allocatable :: full
    complex(rp), allocatable :: u(:, :, :)
    integer :: status

    time = 0
    call make_full_transform(main, full)
    allocate (u(full%sticks%nkz, full%sticks%n, 3), stat=status)
    call check_allocation(status, [full%sticks%nkz, full%sticks%n, 3], COMPLEX_BYTES, 'the initial condition')
    u = 0
    select case (params%inicond)
    case ('quiescent')
      continue
    case ('MeanFlow')
      call set_mean(full, params%mean_velocity, u)
    case ('VortexRing')
      call vortex_ring(params, full, fields(:, :, :, 1:3))
      call full%forward(fields(:, :, :, 1:3), u)
      call vorticity_to_velocity(full, u)
      call set_mean(full, params%mean_velocity, u)
    case ('taylor_green', 'taylor_green_2d')
      call taylor_green(params, full, fields(:, :, :, 1:3))
      call full%forward(fields(:, :, :, 1:3), u)
      call project(full, u) ! in a box that is no cube the classical field is not solenoidal
    case ('turbulence_rogallo', 'random-given-spectrum')
      call random_velocity(full%world, params, full%sticks, u, failure)
    case ('infile')
      call from_files(full%world, params, full, fields(:, :, :, 1:3), time, failure)
      if (.not. failure%failed) then
        call full%forward(fields(:, :, :, 1:3), u)
        call project(full, u) ! files of single precision are solenoidal to 1e-7 only
      end if
    case default
      call require(.false., 'initial_velocity: the registry allows an unknown condition')
    end select
    if (.not. failure%failed) call to_physical(full, u, fields)
    call full%free()
  end subroutine initial_velocity

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

  !> Takes the gradient part off u.
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

  !> Velocity, vorticity and divergence in physical space, one field at a time to save memory.
  subroutine to_physical(full, u, fields)
    class(transform_t), intent(inout) :: full
    complex(rp), intent(in) :: u(:, :, :)
    real(rp), contiguous, intent(inout) :: fields(:, :, :, :)
    complex(rp), allocatable :: one(:, :, :), stick(:, :)
    integer :: s, f, status
    allocate (one(full%sticks%nkz, full%sticks%n, 1), stick(full%sticks%nkz, 7), stat=status)
    call check_allocation(status, [full%sticks%nkz, full%sticks%n], COMPLEX_BYTES, 'a field of the initial condition')
    do f = 1, 7
      do s = 1, full%sticks%n
        associate (t => full%sticks)
          call stick_fields(t%nkz, t%kx(s), t%ky(s), t%kz, u(:, s, 1), u(:, s, 2), u(:, s, 3), stick(:, 1), &
                            stick(:, 2), stick(:, 3), stick(:, 4), stick(:, 5), stick(:, 6))
          call stick_divergence(t%nkz, t%kx(s), t%ky(s), t%kz, u(:, s, 1), u(:, s, 2), u(:, s, 3), stick(:, 7))
        end associate
        one(:, s, 1) = stick(:, f)
      end do
      call full%backward(one, fields(:, :, :, f:f))
    end do
  end subroutine to_physical

  !> Vorticity of a ring in a plane x = const: core a = 0.82 r0, circulation omega1, centre (x0, y0, z0).
  subroutine vortex_ring(p, full, omega)
    type(fluid_params_t), intent(in) :: p
    class(transform_t), intent(in) :: full
    real(rp), intent(inout) :: omega(:, :, :, :)
    real(rp), parameter :: CORE = 0.82_rp
    real(rp) :: q(3), r, a, w
    integer :: x, y, z
    a = CORE*p%size
    do z = 1, full%block%count(3)
      do y = 1, full%block%count(2)
        do x = 1, full%block%count(1)
          q = ([x, y, z] - 1 + full%block%start)*p%grid%spacing - p%centre
          r = hypot(q(2), q(3))
          w = p%omega1/(PI*a**2)*exp(-(q(1)**2 + (r - p%size)**2)/a**2)
          omega(x, y, z, :) = 0
          if (r > 0) omega(x, y, z, :) = [0.0_rp, -w*q(3)/r, w*q(2)/r]
        end do
      end do
    end do
  end subroutine vortex_ring

  !> Taylor-Green vortices scaled to the box: in 2-D (sin y cos z, -cos y sin z), in 3-D
  !> (sin x cos y cos z, -cos x sin y cos z, 0).
  subroutine taylor_green(p, full, u)
    type(fluid_params_t), intent(in) :: p
    class(transform_t), intent(in) :: full
    real(rp), intent(inout) :: u(:, :, :, :)
    real(rp) :: q(3)
    integer :: x, y, z
    do z = 1, full%block%count(3)
      do y = 1, full%block%count(2)
        do x = 1, full%block%count(1)
          q = 2*PI*real([x, y, z] - 1 + full%block%start, rp)/p%grid%n
          if (p%grid%is_2d) then
            u(x, y, z, :) = [0.0_rp, sin(q(2))*cos(q(3)), -cos(q(2))*sin(q(3))]
          else
            u(x, y, z, :) = [sin(q(1))*cos(q(2))*cos(q(3)), -cos(q(1))*sin(q(2))*cos(q(3)), 0.0_rp]
          end if
        end do
      end do
    end do
  end subroutine taylor_green

  !> Velocity from three field files of the same grid and box, and the time they were written at.
  subroutine from_files(world, p, full, u, time, failure)
    type(world_t), intent(in) :: world
    type(fluid_params_t), intent(in) :: p
    class(transform_t), intent(in) :: full
    real(rp), contiguous, intent(inout) :: u(:, :, :, :)
    real(rp), intent(out) :: time
    type(failure_t), intent(inout) :: failure
    type(field_meta_t) :: meta
    integer :: c
    time = 0
    do c = 1, 3
      call read_field(world, trim(p%file_u(c)), full%block, u(:, :, :, c), meta, failure)
      if (failure%failed) return
      call check_box(trim(p%file_u(c)), meta, p%grid, failure)
      if (failure%failed) return
      time = meta%time
    end do
  end subroutine from_files
end module fluid_initial
