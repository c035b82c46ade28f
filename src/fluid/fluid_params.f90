! SPDX-License-Identifier: GPL-3.0-or-later
!> Parameters of the fluid as given by the user; set once, then read-only.
module fluid_params
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use io_config, only: config_t
  use spectral_backends, only: HAS_P3DFFT
  use spectral_grid, only: grid_t, make_grid, is_fft_friendly
  implicit none
  private
  public :: fluid_params_t, read_fluid_params, SCHEME_AB2, SCHEME_RK4, SCHEME_RK2, SCHEME_EULER, SCHEME_NAMES

  integer, parameter :: SCHEME_AB2 = 1, SCHEME_RK4 = 2, SCHEME_RK2 = 3, SCHEME_EULER = 4
  character(*), parameter :: SCHEME_NAMES(4) = ['AB2  ', 'RK4  ', 'RK2  ', 'Euler']

  type :: fluid_params_t
    type(grid_t) :: grid
    integer :: process_rows = 0
    character(:), allocatable :: planner
    character(8) :: transform = 'builtin'  !< or 'p3dfft'
    character(:), allocatable :: dealias   !< 'ellipsoid', 'box', 'none'
    real(rp) :: nu = 0                     !< kinematic viscosity
    logical :: even_end = .false.          !< the run ends with two equal steps, not with a short one
    real(rp) :: vanishing_rate = 0         !< of spectral vanishing viscosity at the cut-off, AB2 only, 1/T
    integer :: scheme = SCHEME_AB2
    real(rp) :: t_max = 0, cfl = 0.1_rp, cfl_eta = 0.99_rp, dt_fixed = 0, dt_max = 0
    integer :: nt = 0                      !< largest number of steps
    logical :: intelligent_dt = .false.
    ! Initial condition
    character(:), allocatable :: inicond, spectrum_file
    character(1024) :: file_u(3) = '' !< names of the fields of inicond = infile
    real(rp) :: omega1 = 0
    integer :: seed = 0
    ! Solids
    logical :: penalized = .false.
    character(:), allocatable :: mask, channel
    character(:), allocatable :: obstacle !< a body at rest beside insects, or none
    logical :: moving = .false. !< a layer above draws the body in every step
    logical :: cavity = .false.
    integer :: cavity_size = 0
    real(rp) :: dt_fraction = 1 !< of the largest step of the explicit penalization that solids which react allow
    real(rp) :: c_eta = 1.0e-2_rp, thick_wall = 0, pos_wall = 0, us_fixed(3) = 0, omega = 0
    logical :: has_inflow = .false. !< channel = turek
    real(rp) :: inflow_velocity = 1, inflow_length = 0, inflow_start = 0
    real(rp) :: cylinder(2:3) = 0   !< centre of the one in that channel; `centre` may become that of an insect
    real(rp) :: centre(3) = 0, size = 0, alpha = 0, r1 = 1, r2 = 1
    logical :: compute_forces = .true., unsteady_corrections = .false., periodic_torque = .false.
    ! Sponge
    logical :: sponge = .false.
    character(:), allocatable :: sponge_type
    real(rp) :: c_sponge = 0
    integer :: sponge_thickness = 0
    ! Mean flow
    character(10) :: mean_flow(3) = 'free'
    real(rp) :: mean_velocity(3) = 0, m_fluid = 0, mean_frequency = 0, mean_tau = 0, mean_release = 0
    logical :: mean_conditioner = .false.
  contains
    procedure :: channel_height
  end type fluid_params_t

contains

  !> Takes the fluid's parameters from `config`; adds mistakes that concern several keys to `errors`, doubts to `notices`.
  subroutine read_fluid_params(config, params, errors, draws_solids, notices)
    type(config_t), intent(in) :: config
    type(fluid_params_t), intent(out) :: params
    type(message_list_t), intent(inout) :: errors
    logical, intent(in), optional :: draws_solids !< moving solids are in the mask; if not given they are
    type(message_list_t), intent(inout), optional :: notices
    call read_grid(config, params, errors)
    if (present(notices)) call notice_slow_sizes(config, params, notices)
    call read_time(config, params)
    call read_initial_condition(config, params, errors)
    call read_solids(config, params, errors)
    if (params%moving .and. present(draws_solids)) &
      params%penalized = draws_solids .or. params%channel /= 'no' .or. params%cavity .or. params%obstacle /= 'none'
    call read_sponge(config, params, errors, notices)
    call read_mean_flow(config, params, errors)
    if (params%has_inflow) call set_channel_flow(config, params, errors)
    call check_fixed_step(config, params, errors)
  end subroutine read_fluid_params

  subroutine read_grid(c, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    character(2), parameter :: KEYS(3) = ['nx', 'ny', 'nz']
    integer :: n(3), i
    do i = 1, 3
      n(i) = c%get_integer('Resolution', KEYS(i))
      if (i == 1 .and. n(i) == 1) cycle
      if (mod(n(i), 2) /= 0) call c%complain(errors, 'Resolution', KEYS(i), 'the number of points must be even')
      if (n(i) < 4) call c%complain(errors, 'Resolution', KEYS(i), 'needs at least 4 points, or nx = 1 for a two-dimensional flow')
    end do
    p%grid = make_grid(max(n, 1), [c%get_real('Geometry', 'xl'), c%get_real('Geometry', 'yl'), &
                                   c%get_real('Geometry', 'zl')])
    p%process_rows = c%get_integer('Resolution', 'process_rows')
    p%planner = c%get_word('Resolution', 'planner')
    p%transform = c%get_word('Parallel', 'transform')
    if (p%transform == 'p3dfft' .and. .not. HAS_P3DFFT) call c%complain(errors, 'Parallel', 'transform', &
      'this program was built without P3DFFT: set builtin, or build it again with P3DFFT_ROOT (docs/theory/transforms.md)')
    select case (c%get_word('Dealiasing', 'iDealias'))
    case ('1', 'ellipsoid')
      p%dealias = 'ellipsoid'
    case ('box')
      p%dealias = 'box'
    case default
      p%dealias = 'none'
    end select
  end subroutine read_grid

  !> Sizes that FFTW transforms, but not fast.
  subroutine notice_slow_sizes(c, p, notices)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: p
    type(message_list_t), intent(inout) :: notices
    character(2), parameter :: KEYS(3) = ['nx', 'ny', 'nz']
    integer :: i
    do i = 1, 3
      if (.not. is_fft_friendly(p%grid%n(i))) call c%complain(notices, 'Resolution', KEYS(i), &
        'is slower than need be: only the factors 2, 3, 5 and 7 transform fast; '//nearby_sizes(p%grid%n(i)))
    end do
  end subroutine notice_slow_sizes

  !> Names the next good sizes below and above n.
  function nearby_sizes(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text
    character(60) :: buffer
    integer :: below, above
    below = n
    do while (below > 4 .and. .not. (is_fft_friendly(below) .and. mod(below, 2) == 0))
      below = below - 1
    end do
    above = n
    do while (above < huge(1) - 1 .and. .not. (is_fft_friendly(above) .and. mod(above, 2) == 0))
      above = above + 1
    end do
    write (buffer, '(a,i0,a,i0)') 'nearest good sizes: ', below, ' and ', above
    text = trim(buffer)
  end function nearby_sizes

  subroutine read_time(c, p)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(inout) :: p
    p%t_max = c%get_real('Time', 'Tmax')
    p%nt = c%get_integer('Time', 'nt')
    p%cfl = c%get_real('Time', 'CFL')
    p%cfl_eta = c%get_real('Time', 'CFL_eta')
    p%dt_fixed = c%get_real('Time', 'dt_fixed')
    p%dt_max = c%get_real('Time', 'dt_max')
    p%intelligent_dt = c%get_switch('Time', 'intelligent_dt')
    p%scheme = findloc(SCHEME_NAMES == c%get_word('Time', 'iTimeMethodFluid'), .true., 1)
    if (p%scheme == 0) p%scheme = SCHEME_AB2 ! FLUSI's FSI_AB2_*
    p%nu = c%get_real('ReynoldsNumber', 'nu')
  end subroutine read_time

  subroutine read_initial_condition(c, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    character(7), parameter :: FILES(3) = ['file_ux', 'file_uy', 'file_uz']
    character(:), allocatable :: name
    integer :: i
    p%inicond = c%get_word('InitialCondition', 'inicond')
    p%omega1 = c%get_real('InitialCondition', 'omega1')
    p%seed = c%get_integer('InitialCondition', 'seed')
    call check_initial_numbers(c, p, errors)
    p%spectrum_file = c%get_text('InitialCondition', 'inicond_spectrum_file')
    do i = 1, 3
      name = c%get_text('InitialCondition', FILES(i))
      p%file_u(i) = name
      if (p%inicond == 'infile') call need_file(c, errors, FILES(i), name)
    end do
    if (p%inicond == 'random-given-spectrum') call need_file(c, errors, 'inicond_spectrum_file', p%spectrum_file)
    if (p%inicond == 'taylor_green_2d' .and. .not. p%grid%is_2d) &
      call c%complain(errors, 'InitialCondition', 'inicond', 'taylor_green_2d is a flow in the y-z plane: set nx = 1')
    if (p%inicond == 'taylor_green' .and. p%grid%is_2d) &
     call c%complain(errors, 'InitialCondition', 'inicond', 'taylor_green is three-dimensional; valid with nx = 1: '// &
                      'taylor_green_2d')
  end subroutine read_initial_condition

  !> A prescribed step must be stable for the explicit terms whose limit is known beforehand.
  subroutine check_fixed_step(c, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: p
    type(message_list_t), intent(inout) :: errors
    character(100) :: text
    real(rp) :: limit
    if (p%dt_fixed <= 0) return
    limit = huge(limit)
    if (p%penalized) limit = p%cfl_eta*p%c_eta
    if (p%sponge) limit = min(limit, p%c_sponge)
    if (p%dt_fixed <= limit) return
    write (text, '(a,es10.3)') 'unstable: penalization (CFL_eta*eps) and sponge (eps_sponge) allow at most', limit
    call c%complain(errors, 'Time', 'dt_fixed', trim(text))
  end subroutine check_fixed_step

  !> Numbers without which an initial condition is no flow.
  subroutine check_initial_numbers(c, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: p
    type(message_list_t), intent(inout) :: errors
    select case (p%inicond)
    case ('VortexRing')
      if (p%grid%is_2d) call c%complain(errors, 'InitialCondition', 'inicond', 'a vortex ring needs nx > 1')
      if (c%get_real('Geometry', 'Size') <= 0) &
        call c%complain(errors, 'Geometry', 'Size', 'the vortex ring needs a radius above 0')
    case ('turbulence_rogallo')
      if (p%omega1 <= 0) call c%complain(errors, 'InitialCondition', 'omega1', &
                                         'the random field needs a mean energy above 0')
    end select
  end subroutine check_initial_numbers

  subroutine need_file(c, errors, key, name)
    type(config_t), intent(in) :: c
    type(message_list_t), intent(inout) :: errors
    character(*), intent(in) :: key, name
    logical :: exists
    if (name == 'none' .or. name == '') then
      call c%complain(errors, 'InitialCondition', key, 'this initial condition needs a file name here')
      return
    end if
    inquire (file=name, exist=exists)
    if (.not. exists) call c%complain(errors, 'InitialCondition', key, 'there is no file "'//name//'"')
  end subroutine need_file

  subroutine read_solids(c, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    character(2), parameter :: CENTRES(3) = ['x0', 'y0', 'z0']
    integer :: i
    logical :: exists
    p%penalized = c%get_switch('Penalization', 'iPenalization')
    p%mask = c%get_word('Penalization', 'iMask')
    if (p%mask == 'insect') p%mask = 'Insect'
    if (p%mask == 'Sphere') p%mask = 'sphere'
    if (p%mask == 'Plate') p%mask = 'plate'
    if (p%mask == 'no') p%mask = 'none'
    p%moving = p%penalized .and. p%mask == 'Insect'
    p%obstacle = c%get_word('Penalization', 'obstacle')
    p%c_eta = c%get_real('Penalization', 'eps')
    p%cavity = any(c%get_word('Penalization', 'iCavity') == ['yes', '1  '])
    p%cavity_size = c%get_integer('Penalization', 'cavity_size')
    p%channel = c%get_word('Penalization', 'iChannel')
    if (p%channel == '0') p%channel = 'no'
    if (p%channel == '1') p%channel = 'xy'
    p%thick_wall = c%get_real('Penalization', 'thick_wall')
    p%pos_wall = c%get_real('Penalization', 'pos_wall')
    p%has_inflow = p%penalized .and. p%channel == 'turek'
    p%inflow_velocity = c%get_real('Penalization', 'inflow_velocity')
    p%inflow_length = c%get_real('Penalization', 'inflow_length')
    p%inflow_start = c%get_real('Penalization', 'inflow_start')
    p%compute_forces = c%get_switch('Penalization', 'compute_forces')
    p%unsteady_corrections = c%get_switch('Penalization', 'unst_corrections')
    p%periodic_torque = c%get_switch('Penalization', 'periodic')
    p%us_fixed = c%get_reals('Penalization', 'us_fixed')
    p%omega = c%get_real('Penalization', 'omega')
    p%size = c%get_real('Geometry', 'Size')
    p%alpha = c%get_real('Geometry', 'alpha')
    p%r1 = c%get_real('Geometry', 'r1')
    p%r2 = c%get_real('Geometry', 'r2')
    p%centre = p%grid%length/2
    if (p%grid%is_2d) p%centre(1) = 0 ! the plane itself: no lever arm across it
    do i = 1, 3
      if (i == 1 .and. p%grid%is_2d) cycle
      if (c%is_given('Geometry', CENTRES(i))) p%centre(i) = c%get_real('Geometry', CENTRES(i))
    end do
    p%cylinder = p%centre(2:3)
    if (.not. p%penalized) return
    ! The reader of iMask has already reported a wrong mask. With iMoving FLUSI redraws bodies at rest in every step; the result
    ! is the same mask, so that the key has no effect here.
    if (p%moving .and. c%is_given('Penalization', 'iMoving')) then
      if (.not. c%get_switch('Penalization', 'iMoving')) call c%complain(errors, 'Penalization', 'iMoving', &
        'would hold the wings of Insect where they are at t = 0; valid: 1, and FlappingMotion_left and _right none')
    end if
    call check_bodies(c, p, errors)
    if (p%mask == 'couette' .and. p%r2 <= p%r1) &
      call c%complain(errors, 'Geometry', 'r2', 'the outer radius must be larger than r1')
    if (index(p%mask, 'from_file::') == 1) then
      inquire (file=p%mask(12:), exist=exists)
      if (.not. exists) call c%complain(errors, 'Penalization', 'iMask', 'there is no file "'//p%mask(12:)//'"')
    end if
    if (p%cavity .and. p%cavity_size == 0) &
      call c%complain(errors, 'Penalization', 'cavity_size', 'the cavity walls need a thickness of at least one point')
  end subroutine read_solids

  subroutine check_bodies(c, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(in) :: p
    type(message_list_t), intent(inout) :: errors
    if (p%obstacle /= 'none' .and. .not. p%moving) call c%complain(errors, 'Penalization', 'obstacle', &
      'needs an insect (iMask = Insect) beside it; for a body without an insect set iMask = '//p%obstacle// &
      ' and leave obstacle out')
    if (p%obstacle /= 'none' .and. p%has_inflow) call c%complain(errors, 'Penalization', 'obstacle', &
      'is of no use with iChannel = turek, which has a cylinder of its own; valid: none')
    if ((any(p%mask == [character(10) :: 'sphere', 'cylinder', 'cylinder_x', 'plate']) .or. p%obstacle /= 'none') .and. &
        p%size <= 0) &
      call c%complain(errors, 'Geometry', 'Size', 'the body needs a size above 0')
  end subroutine check_bodies

  subroutine read_sponge(c, p, errors, notices)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    type(message_list_t), intent(inout), optional :: notices
    logical :: both(3), last(3)
    p%sponge = c%get_switch('Sponge', 'iVorticitySponge')
    p%sponge_type = c%get_word('Sponge', 'iSpongeType')
    p%c_sponge = c%get_real('Sponge', 'eps_sponge')
    p%sponge_thickness = c%get_integer('Sponge', 'sponge_thickness')
    if (.not. p%sponge) return
    if (p%c_sponge <= 0) call c%complain(errors, 'Sponge', 'eps_sponge', 'the sponge needs a damping time above 0')
    if (p%sponge_thickness <= 0) call c%complain(errors, 'Sponge', 'sponge_thickness', &
                                                 'the sponge needs a thickness of at least one point')
    call sponge_faces(p%sponge_type, both, last)
    if (p%grid%n(1) <= 4 .and. .not. any(both(2:)) .and. .not. any(last(2:))) &
      call c%complain(errors, 'Sponge', 'iSpongeType', 'this sponge lies at the ends of x, which has no extent here')
    if (.not. present(notices)) return
    if (any(both .and. 2*p%sponge_thickness >= p%grid%n .and. p%grid%n > 4) .or. &
        any(last .and. p%sponge_thickness >= p%grid%n .and. p%grid%n > 4)) &
      call c%complain(notices, 'Sponge', 'sponge_thickness', 'the sponge fills the box: all of the flow is damped')
  end subroutine read_sponge

  !> The directions in which a type of sponge covers both ends of the box, or the last one only.
  pure subroutine sponge_faces(kind, both, last)
    character(*), intent(in) :: kind
    logical, intent(out) :: both(3), last(3)
    last = [kind == 'outlet_x', .false., kind == 'top_cover']
    select case (kind)
    case ('cavity')
      both = .true.
    case ('cavity_open_z', 'xmin_xmax_ymin_ymax')
      both = [.true., .true., .false.]
    case ('xmin_xmax')
      both = [.true., .false., .false.]
    case ('xmin_xmax_zmin_zmax')
      both = [.true., .false., .true.]
    case ('2D_frame')
      both = [.false., .true., .true.]
    case default
      both = .false.
    end select
  end subroutine sponge_faces

  subroutine read_mean_flow(c, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    character(*), parameter :: AXES = 'xyz'
    integer :: i
    do i = 1, 3
      p%mean_flow(i) = c%get_word('MeanFlow', 'iMeanFlow_'//AXES(i:i))
      p%mean_velocity(i) = c%get_real('MeanFlow', 'u'//AXES(i:i))
      if (c%get_integer('MeanFlow', 'iMeanFlow') == 1) then
        if (any(p%mean_flow(i) == ['sinusoidal', 'dynamic   '])) &
          call c%complain(errors, 'MeanFlow', 'iMeanFlow', 'iMeanFlow = 1 contradicts iMeanFlow_'//AXES(i:i))
        p%mean_flow(i) = 'fixed'
      end if
    end do
    p%m_fluid = c%get_real('MeanFlow', 'm_fluid')
    p%mean_frequency = c%get_real('MeanFlow', 'umean_freq')
    p%mean_conditioner = c%get_switch('MeanFlow', 'iMeanFlowStartupConditioner')
    p%mean_tau = c%get_real('MeanFlow', 'tau_meanflow')
    p%mean_release = c%get_real('MeanFlow', 'T_release_meanflow')
  end subroutine read_mean_flow

  !> What a channel with inflow needs. It has all of the mean flow: along y what comes in, nothing through its walls.
  subroutine set_channel_flow(c, p, errors)
    type(config_t), intent(in) :: c
    type(fluid_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    character(*), parameter :: AXES = 'yz'
    integer :: i
    if (p%channel_height() <= 0) call c%complain(errors, 'Penalization', 'thick_wall', &
                                                 'the wall leaves no channel: it must be thinner than zl')
    if (p%inflow_length <= 0 .or. p%inflow_length >= p%grid%length(2)) &
      call c%complain(errors, 'Penalization', 'inflow_length', 'the inflow of turek needs a length between 0 and yl')
    if (all(p%mask /= [character(6) :: 'none', 'empty', 'Insect'])) &
      call c%complain(errors, 'Penalization', 'iMask', 'turek has its own cylinder; valid with it: none, empty, Insect')
    do i = 1, 2
      if (p%mean_flow(i + 1) /= 'free') &
        call c%complain(errors, 'MeanFlow', 'iMeanFlow_'//AXES(i:i), 'the inflow of turek prescribes the mean flow')
    end do
    p%mean_flow(2:3) = 'fixed'
    p%mean_velocity(2:3) = [p%inflow_velocity*p%channel_height()/p%grid%length(3), 0.0_rp]
  end subroutine set_channel_flow

  !> Distance of the walls of a channel with normal z, L.
  pure real(rp) function channel_height(self)
    class(fluid_params_t), intent(in) :: self
    channel_height = self%grid%length(3) - self%thick_wall
  end function channel_height
end module fluid_params
