! SPDX-License-Identifier: GPL-3.0-or-later
!> The flow at t = 0, on the full spectrum.
!>
!> Conditions given by their vorticity become velocities by u = i k x omega/k^2 (k /= 0).
module fluid_initial
  use base_constants, only: PI
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use fluid_kernels, only: stick_fields, stick_divergence, biot_savart
  use fluid_params, only: fluid_params_t
  use fluid_spectrum, only: random_velocity
  use io_fields, only: read_field, field_meta_t
  use parallel_world, only: world_t
  use spectral_pencil, only: pencil_t
  implicit none
  private
  public :: initial_velocity

contains

  !> Fills fields(nx, ny_local, nz_local, 7) with velocity, vorticity and divergence at t = 0 on this
  !> rank's block. Fails if a file cannot be read. Uses a second, untruncated transform while it
  !> works. Collective.
  subroutine initial_velocity(world, params, fields, failure)
    type(world_t), intent(in) :: world
    type(fluid_params_t), intent(in) :: params
    real(rp), contiguous, intent(inout) :: fields(:, :, :, :)
    type(failure_t), intent(inout) :: failure
    type(pencil_t) :: full
    complex(rp), allocatable :: modes(:, :, :)
    integer :: s

    call full%init(world, params%grid, 'none', params%process_rows, 'estimate', 7, 3)
    allocate (modes(full%sticks%nkz, full%sticks%n, 7))
    modes = 0
    select case (params%inicond)
    case ('quiescent')
      continue
    case ('MeanFlow')
      if (full%sticks%zero > 0) modes(1, full%sticks%zero, 1:3) = params%mean_velocity
    case ('VortexRing')
      call vortex_ring(params, full, fields(:, :, :, 1:3))
      call full%forward(fields(:, :, :, 1:3), modes(:, :, 4:6))
      do s = 1, full%sticks%n
        call biot_savart(full%sticks%nkz, full%sticks%kx(s), full%sticks%ky(s), full%sticks%kz, modes(:, s, 4), &
                         modes(:, s, 5), modes(:, s, 6), modes(:, s, 1), modes(:, s, 2), modes(:, s, 3))
      end do
      if (full%sticks%zero > 0) modes(1, full%sticks%zero, 1:3) = params%mean_velocity
    case ('taylor_green', 'taylor_green_2d')
      call taylor_green(params, full, fields(:, :, :, 1:3))
      call full%forward(fields(:, :, :, 1:3), modes(:, :, 1:3))
    case ('turbulence_rogallo', 'random-given-spectrum')
      call random_velocity(world, params, full%sticks, modes(:, :, 1:3), failure)
    case ('infile')
      call from_files(world, params, full, fields(:, :, :, 1:3), failure)
      if (.not. failure%failed) call full%forward(fields(:, :, :, 1:3), modes(:, :, 1:3))
    case default
      call require(.false., 'initial_velocity: the registry allows an unknown condition')
    end select
    if (.not. failure%failed) then
      call complete(full, modes)
      call full%backward(modes, fields)
    end if
    call full%free()
  end subroutine initial_velocity

  !> Vorticity and divergence of the velocity in modes(:, :, 1:3).
  subroutine complete(full, modes)
    type(pencil_t), intent(in) :: full
    complex(rp), intent(inout) :: modes(:, :, :)
    complex(rp), allocatable :: u(:, :)
    integer :: s
    allocate (u(full%sticks%nkz, 3))
    do s = 1, full%sticks%n
      u = modes(:, s, 1:3)
      associate (t => full%sticks)
        call stick_fields(t%nkz, t%kx(s), t%ky(s), t%kz, u(:, 1), u(:, 2), u(:, 3), modes(:, s, 1), &
                          modes(:, s, 2), modes(:, s, 3), modes(:, s, 4), modes(:, s, 5), modes(:, s, 6))
        call stick_divergence(t%nkz, t%kx(s), t%ky(s), t%kz, u(:, 1), u(:, 2), u(:, 3), modes(:, s, 7))
      end associate
    end do
  end subroutine complete

  !> Vorticity of a ring in a plane x = const: core a = 0.82 r0, circulation omega1, centre (x0, y0, z0).
  subroutine vortex_ring(p, full, omega)
    type(fluid_params_t), intent(in) :: p
    type(pencil_t), intent(in) :: full
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
    type(pencil_t), intent(in) :: full
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

  !> Velocity from three field files of the same grid.
  subroutine from_files(world, p, full, u, failure)
    type(world_t), intent(in) :: world
    type(fluid_params_t), intent(in) :: p
    type(pencil_t), intent(in) :: full
    real(rp), contiguous, intent(inout) :: u(:, :, :, :)
    type(failure_t), intent(inout) :: failure
    type(field_meta_t) :: meta
    integer :: c
    do c = 1, 3
      call read_field(world, trim(p%file_u(c)), full%block, u(:, :, :, c), meta, failure)
      if (failure%failed) return
    end do
  end subroutine from_files
end module fluid_initial
