! SPDX-License-Identifier: GPL-3.0-or-later
!> The right-hand side of the Navier-Stokes equations and the time step, as kernels of a pipeline; `run_pass` of fluid_solver
!> says in which order.
!>
!>   du/dt = P[ u x omega - chi/C_eta (u - u_s) ] + F_sponge + nu lap u,   div u = 0,
!>
!> This is the rotational form; P is the exact projection in Fourier space. Viscosity is integrated exactly by E = exp(-nu k^2 dt),
!> with vanishing viscosity (fluid_state) times exp(-rate dt (k/K)^4); E is set to 0 outside the truncation, which removes aliasing
!> errors; around wings without thickness also outside its largest sphere. One pass costs six inverse and three forward
!> transforms (six forward ones with a sponge, and one more if it keeps the pressure). In z five inverse transforms suffice,
!> because the vorticity along z is made of the velocity.
!>
!> AB2 with variable step: u(n+1) = E [u(n) + b10 N(n) + b11 H], H = E(dt_old) N(n-1),
!> b10 = dt (dt/2 + dt_old)/dt_old, b11 = -dt^2/(2 dt_old); the first step, and all of Euler's scheme, have b10 = dt, b11 = 0.
!> RK4: classical, in the integrating-factor variable. RK2: Heun's, u* = E (u + dt N), u(n+1) = u* + dt/2 (N(u*) - E N).
module fluid_rhs
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_initial_flow, only: initial_flow_t
  use fluid_kernels, only: stick_fields, stick_curl, stick_divergence, line_product, project_stick, add_sponge
  use fluid_mean_flow, only: mean_acceleration, imposed_mean_flow
  use fluid_params, only: fluid_params_t
  use fluid_penalty, only: penalty_t
  use fluid_point_reader, only: point_reader_t
  use fluid_pressure, only: pressure_t
  use fluid_requests, only: request_t, PASS_EVALUATE, PASS_AB2, PASS_RK_FIRST, PASS_HEUN_FIRST, pass_begin, pass_end
  use fluid_sponge, only: sponge_t
  use fluid_state, only: allocate_spectra, fluid_state_t
  use fluid_stepper, only: stepper_t
  use fluid_sums, only: lever_t, sums_t
  use fluid_timestep, only: next_step_length, TOO_FAST
  use parallel_block, only: allocate_fields, block_t
  use parallel_world, only: world_t
  use spectral_sticks, only: sticks_t
  use spectral_transform, only: kernels_t, transform_t
  implicit none
  private
  public :: rhs_t

  !> Maxima and sums over the lines of a pass, one for each index along x.
  type :: along_x_t
    real(rp), allocatable :: max(:), sum(:, :) !< (nx) largest |u|^2, (nx, 7) sums of |u|^2 and of squares of components
    real(rp), allocatable :: divergence(:)     !< (nx) |div u|
  end type along_x_t

  !> Kernels with all data that they work on. All of it except `state` is scratch: its contents are undefined between steps.
  type, extends(kernels_t) :: rhs_t
    type(world_t) :: world
    type(fluid_params_t) :: params
    type(sticks_t) :: sticks
    type(block_t) :: block
    type(penalty_t) :: penalty
    type(sponge_t) :: sponge
    type(fluid_state_t) :: state
    ! This pass
    integer :: pass = PASS_EVALUATE
    type(request_t) :: request
    real(rp) :: intervals(4) = 0                 !< output intervals that intelligent_dt respects
    real(rp) :: solid_speed = 0                  !< largest |u_s| of solids that move
    real(rp) :: dt = 0                           !< the step, chosen when the products are known
    type(sums_t) :: sums
    type(failure_t) :: failure
    type(stepper_t) :: stepper
    type(point_reader_t) :: reader                   !< of the flow at points, where other layers ask for it
    type(pressure_t) :: pressure                     !< kept for outputs if these request it
    complex(rp), allocatable :: kept(:, :, :)        !< (nkz, sticks, 3) N of an evaluation that kept it
    real(rp), allocatable :: fields(:, :, :, :)      !< (nx, ny_local, nz_local, 6) u and omega if requested
    complex(rp), allocatable :: past(:, :, :)        !< (nkz, sticks, 3) u at the beginning of the pass, if requested
    type(initial_flow_t), allocatable :: initial     !< the untruncated initial flow, first pass only
    type(along_x_t), private :: along_x
    complex(rp), private, allocatable :: pressure_line(:) !< (nkz)
  contains
    procedure :: init => rhs_init
    procedure :: prepare => rhs_prepare
    procedure :: time_of => rhs_time_of
    procedure :: take_curl_multiply_and_penalise => rhs_take_curl_multiply_and_penalise
    procedure :: choose_step => rhs_choose_step
    procedure :: project_and_advance => rhs_project_and_advance
    procedure :: advance_kept => rhs_advance_kept
    procedure :: spectral_in => rhs_take_curl
    procedure :: product => rhs_multiply_and_penalise
    procedure :: spectral_out => rhs_project_and_advance_sticks
    procedure, private :: penalise_line, add_integrals, advance, set_step, stage_time
  end type rhs_t

contains

  !> Allocates state and tables. The caller sets penalty and sponge.
  subroutine rhs_init(self, world, params, sticks, block, keeps_fields, keeps_pressure, keeps_rhs)
    class(rhs_t), intent(inout) :: self
    type(world_t), intent(in) :: world
    type(fluid_params_t), intent(in) :: params
    type(sticks_t), intent(in) :: sticks
    type(block_t), intent(in) :: block
    !> Tells whether any pass will request fields, the pressure, or an evaluation that keeps its right-hand side.
    logical, intent(in) :: keeps_fields, keeps_pressure, keeps_rhs
    self%world = world
    self%params = params
    self%sticks = sticks
    self%block = block
    call self%state%init(sticks)
    call self%stepper%init(params, sticks)
    allocate (self%along_x%max(block%count(1)), self%along_x%sum(block%count(1), 7), self%pressure_line(sticks%nkz))
    allocate (self%along_x%divergence(block%count(1)), source=0.0_rp)
    if (keeps_pressure) call self%pressure%init(sticks)
    if (keeps_rhs) call allocate_spectra(self%kept, sticks, 'the change of the flow')
    if (keeps_fields) call allocate_fields(self%fields, block, 6, 'velocity and vorticity in space')
  end subroutine rhs_init

  !> Prepares the next pass. Call it before the pipeline runs.
  subroutine rhs_prepare(self, pass, request)
    class(rhs_t), intent(inout) :: self
    integer, intent(in) :: pass
    type(request_t), intent(in) :: request
    self%pass = pass
    self%request = request
    self%n_in = merge(7, 6, request%integrals)
    self%curl = 6
    if (allocated(self%initial) .and. pass_begin(pass) <= 0) self%n_in = 0
    if (request%flow .and. .not. (allocated(self%initial) .or. allocated(self%past))) &
      call allocate_spectra(self%past, self%sticks, 'the last flow') ! once in a run
    self%n_out = merge(6, 3, self%sponge%is_on)
    if (request%pressure) self%n_out = self%n_out + 1
    call self%reader%begin(self%n_in > 0 .and. pass_begin(pass) <= 0)
    call self%sums%clear()
    self%along_x%max = 0
    self%along_x%sum = 0
  end subroutine rhs_prepare

  !> Takes the curl of the velocity on sticks, transforms both to the points, and multiplies and penalises on lines there.
  !> Collective.
  subroutine rhs_take_curl_multiply_and_penalise(self, transform)
    class(rhs_t), intent(inout) :: self
    class(transform_t), intent(inout) :: transform
    call transform%to_points(self) ! by rhs_take_curl and rhs_multiply_and_penalise
    call self%reader%finish()
  end subroutine rhs_take_curl_multiply_and_penalise

  !> Transforms the products to modes, projects them there, and advances the state, stick by stick. Collective.
  subroutine rhs_project_and_advance(self, transform)
    class(rhs_t), intent(inout) :: self
    class(transform_t), intent(inout) :: transform
    call transform%to_modes(self) ! by rhs_project_and_advance_sticks
  end subroutine rhs_project_and_advance

  !> Fills `fields` with velocity, vorticity i k x u and, on request, the divergence; see kernels_t.
  subroutine rhs_take_curl(self, first, count, fields)
    class(rhs_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    integer :: i, s
    associate (t => self%sticks, u => self%state%u, f => fields)
      do i = 1, count
        s = first + i - 1
        call stick_fields(t%nkz, t%kx(s), t%ky(s), t%kz, u(:, s, 1), u(:, s, 2), u(:, s, 3), f(:, i, 1), f(:, i, 2), &
                          f(:, i, 3), f(:, i, 4), f(:, i, 5))
        if (self%fill_curl) call stick_curl(t%nkz, t%kx(s), t%ky(s), u(:, s, 1), u(:, s, 2), f(:, i, 6))
        if (self%n_in == 7) &
          call stick_divergence(t%nkz, t%kx(s), t%ky(s), t%kz, u(:, s, 1), u(:, s, 2), u(:, s, 3), f(:, i, 7))
      end do
    end associate
  end subroutine rhs_take_curl

  !> Computes u x omega, penalization, sponge and, last, |u|^2/2 on a batch of lines, and integrals and copies on request; see
  !> kernels_t.
  subroutine rhs_multiply_and_penalise(self, first, count, z, in, out)
    class(rhs_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    if (self%n_in > 0) call lines_product(self, first, count, z, in, out)
    if (self%n_in == 0) then
      call self%initial%bring(z)
      call lines_product(self, first, count, z, &
                         self%initial%fields(:, first:first + count - 1, z - self%initial%first, :), out)
    end if
  end subroutine rhs_multiply_and_penalise

  !> Computes what is needed in space on lines of plane `z`: u x omega, penalization, sponge, pressure and integrals.
  subroutine lines_product(self, first, count, z, in, out)
    type(rhs_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    integer :: i, y
    call self%reader%read_lines(first, count, z, in)
    do i = 1, count
      y = first + i - 1
      call line_product(size(in, 1), in(:, i, 1), in(:, i, 2), in(:, i, 3), in(:, i, 4), in(:, i, 5), in(:, i, 6), &
                        out(:, i, 1), out(:, i, 2), out(:, i, 3), self%along_x%max, self%along_x%sum(:, 1))
      if (self%params%solids%is_on) call self%penalise_line(y, z, in(:, i, 1:3), out(:, i, 1:3))
      if (self%sponge%is_on) call sponge_line(self, y, z, in(:, i, 4:6), out(:, i, 4:6))
      if (self%request%pressure) out(:, i, self%n_out) = 0.5_rp*(in(:, i, 1)**2 + in(:, i, 2)**2 + in(:, i, 3)**2)
      if (self%request%integrals) call self%add_integrals(y, z, in(:, i, :))
    end do
    if (self%request%fields) self%fields(:, first:first + count - 1, z, 1:6) = in(:, 1:count, 1:6)
  end subroutine lines_product

  !> Adds -chi/C_eta (u - u_s) to N on a line and gathers the forces.
  subroutine penalise_line(self, y, z, u, n)
    class(rhs_t), intent(inout) :: self
    integer, intent(in) :: y, z
    real(rp), intent(in) :: u(:, :)    !< (nx, 3)
    real(rp), intent(inout) :: n(:, :) !< (nx, 3)
    type(lever_t) :: lever
    real(rp) :: box(3)
    integer :: line
    line = y + self%block%count(2)*(z - 1)
    if (self%penalty%line_last(line) < self%penalty%line_first(line)) return
    box = self%params%grid%length
    lever%arm = ([0, y - 1, z - 1] + self%block%start)*self%params%grid%spacing - self%params%solids%centre
    lever%spacing = self%params%grid%spacing(1)
    ! Wings may reach beyond the box; the nearest image of a point is the one that belongs to them.
    if (self%params%solids%periodic_torque .or. self%params%solids%is_moving) then
      lever%arm(2:3) = lever%arm(2:3) - box(2:3)*anint(lever%arm(2:3)/box(2:3))
      lever%period = box(1)
    end if
    call self%sums%add_solid_line(self%penalty, line, self%params%solids%c_eta, lever, u, n)
  end subroutine penalise_line

  !> Adds the sponge on a line, outside the solids.
  subroutine sponge_line(self, y, z, omega, q)
    type(rhs_t), intent(in) :: self
    integer, intent(in) :: y, z
    real(rp), intent(in) :: omega(:, :)
    real(rp), intent(inout) :: q(:, :)
    integer :: line
    call self%sponge%damp(y, z, omega, q)
    if (.not. self%params%solids%is_on) return
    line = y + self%block%count(2)*(z - 1)
    q(self%penalty%x(self%penalty%line_first(line):self%penalty%line_last(line)), :) = 0
  end subroutine sponge_line

  !> Adds energies, enstrophies and the divergence on a line.
  subroutine add_integrals(self, y, z, in)
    class(rhs_t), intent(inout) :: self
    integer, intent(in) :: y, z
    real(rp), intent(in) :: in(:, :)
    real(rp) :: solid_fraction
    integer :: f, i, line
    do f = 1, 6
      self%along_x%sum(:, f + 1) = self%along_x%sum(:, f + 1) + in(:, f)**2
    end do
    if (size(in, 2) >= 7) then
      self%sums%divergence = max(self%sums%divergence, maxval(abs(in(:, 7))))
      self%along_x%divergence = abs(in(:, 7))
    end if
    if (self%params%solids%is_on) then
      line = y + self%block%count(2)*(z - 1)
      do i = self%penalty%line_first(line), self%penalty%line_last(line)
        associate (x => self%penalty%x(i), chi => self%penalty%chi(i))
          ! In the sums of the fluid every point has the weight (1 - chi)^2. Here the difference of this weight from 1 is
          ! subtracted.
          solid_fraction = 1 - (1 - chi)**2
          self%sums%energy_fluid = self%sums%energy_fluid - 0.5_rp*solid_fraction*in(x, 1:3)**2
          self%sums%enstrophy_fluid = self%sums%enstrophy_fluid - solid_fraction*in(x, 4:6)**2
          self%along_x%divergence(x) = self%along_x%divergence(x)*(1 - chi)
        end associate
      end do
    end if
    self%sums%divergence_fluid = max(self%sums%divergence_fluid, maxval(self%along_x%divergence))
  end subroutine add_integrals

  !> Finishes the integrals, checks the velocity, and fixes the step that this pass will take. The
  !> state is left alone if the velocity is not finite or too large. Collective.
  subroutine rhs_choose_step(self)
    class(rhs_t), intent(inout) :: self
    real(rp) :: total
    integer :: f
    character(80) :: text
    total = sum(self%along_x%sum(:, 1))
    self%sums%is_finite = abs(total) <= huge(total) ! false for NaN as well
    self%sums%kinetic_energy = 0.5_rp*total
    self%sums%u_max = sqrt(maxval(self%along_x%max))
    if (self%request%integrals) then
      do f = 1, 3
        self%sums%energy(f) = 0.5_rp*sum(self%along_x%sum(:, f + 1))
        self%sums%enstrophy(f) = sum(self%along_x%sum(:, f + 4))
      end do
      self%sums%energy_fluid = self%sums%energy_fluid + self%sums%energy
      self%sums%enstrophy_fluid = self%sums%enstrophy_fluid + self%sums%enstrophy
    end if
    if (self%sticks%zero > 0) self%sums%mean = real(self%state%u(1, self%sticks%zero, :))/ &
                                               self%params%grid%cell_volume()
    call self%sums%reduce(self%world, self%params%grid%cell_volume())
    if (.not. self%sums%is_finite) then
      call self%failure%raise('the flow has diverged: the velocity is not a number; '// &
                              'set a smaller [Time] CFL or dt_fixed, or a finer grid')
    else if (self%sums%u_max >= TOO_FAST) then
      write (text, '(a,es10.3)') 'the flow has diverged: max |u| =', self%sums%u_max
      call self%failure%raise(trim(text)//' L/T; set a smaller [Time] CFL or dt_fixed, or a finer grid')
    end if
    if (self%failure%failed) return
    if (any(self%pass == [PASS_AB2, PASS_RK_FIRST, PASS_HEUN_FIRST])) call self%set_step()
  end subroutine rhs_choose_step

  !> Chooses the length of the step that begins with this pass, and the viscous factors for it.
  subroutine set_step(self)
    class(rhs_t), intent(inout) :: self
    self%dt = next_step_length(self%params, max(self%sums%u_max, self%solid_speed), self%state%time, &
                               self%state%dt_old, self%intervals)
    call self%stepper%choose(self%sticks, self%pass, self%dt)
  end subroutine set_step

  !> Makes the AB2 step for which the last pass, an evaluation, kept the right-hand side. The state becomes the same to the last
  !> bit as with PASS_AB2, but without a transform.
  subroutine rhs_advance_kept(self)
    class(rhs_t), intent(inout) :: self
    integer :: s
    self%pass = PASS_AB2
    call self%set_step()
    do s = 1, self%sticks%n
      call self%advance(s, self%kept(:, s, :))
    end do
  end subroutine rhs_advance_kept

  !> Projects the right-hand side and advances the state by it; an evaluation keeps it on request. See kernels_t.
  subroutine rhs_project_and_advance_sticks(self, first, count, fields)
    class(rhs_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    integer :: i, s
    do i = 1, count
      s = first + i - 1
      call project(self, s, i, fields)
      if (self%request%flow .and. allocated(self%past)) self%past(:, s, :) = self%state%u(:, s, :)
      if (self%pass /= PASS_EVALUATE) then
        call self%advance(s, fields(:, i, 1:3))
      else if (self%request%rhs) then
        self%kept(:, s, :) = fields(:, i, 1:3)
      end if
    end do
  end subroutine rhs_project_and_advance_sticks

  !> Makes line i of the right-hand side, which belongs to stick `s`, free of divergence, keeps the pressure, and adds the sponge.
  subroutine project(self, s, i, fields)
    class(rhs_t), intent(inout) :: self
    integer, intent(in) :: s, i
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    call project_stick(self%sticks%nkz, self%sticks%kx(s), self%sticks%ky(s), self%sticks%kz, &
                       fields(:, i, 1), fields(:, i, 2), fields(:, i, 3), self%pressure_line)
    if (self%request%pressure) call self%pressure%keep(self%sticks, s, self%pressure_line, fields(:, i, self%n_out))
    if (self%sponge%is_on) call add_sponge(self%sticks%nkz, self%sticks%kx(s), self%sticks%ky(s), self%sticks%kz, &
                                           fields(:, i, 4), fields(:, i, 5), fields(:, i, 6), &
                                           fields(:, i, 1), fields(:, i, 2), fields(:, i, 3))
  end subroutine project

  !> Advances the state on stick `s` by the components of the projected right-hand side.
  subroutine advance(self, s, n)
    class(rhs_t), intent(inout) :: self
    integer, intent(in) :: s
    complex(rp), intent(inout) :: n(:, :) !< (nkz, 3)
    integer :: c
    call self%stepper%full%choose(s, self%sticks%jz)
    if (s == self%sticks%zero) n(1, :) = mean_acceleration(self%params, self%state%time, sum(self%sums%force, 2), n(1, :))
    do c = 1, 3
      call self%stepper%advance(self%state, self%sticks, self%pass, self%dt, s, c, n(:, c))
    end do
    if (s == self%sticks%zero) self%state%u(1, s, :) = imposed_mean_flow(self%params, self%stage_time(), &
                                                                         self%state%u(1, s, :))
  end subroutine advance

  !> Returns the time [T] at which pass `pass` evaluates the right-hand side. dt must be the length of its step.
  pure real(rp) function rhs_time_of(self, pass) result(time)
    class(rhs_t), intent(in) :: self
    integer, intent(in) :: pass
    time = self%state%time + pass_begin(pass)*self%dt
  end function rhs_time_of

  !> Returns the time of the state after this pass.
  pure real(rp) function stage_time(self) result(time)
    class(rhs_t), intent(in) :: self
    time = self%state%time + pass_end(self%pass)*self%dt
  end function stage_time
end module fluid_rhs
