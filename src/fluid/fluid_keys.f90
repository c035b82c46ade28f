! SPDX-License-Identifier: GPL-3.0-or-later
!> The ini keys of the fluid, registered once: type, unit, default, range, choices, help. Names and
!> meanings are FLUSI's wherever FLUSI has them.
module fluid_keys
  use base_kinds, only: rp
  use fluid_substitutes, only: FOR_CAVITIES, FOR_CHANNELS, FOR_FLOWS, FOR_MASKS, FOR_MEAN_FLOWS, FOR_SPONGES, FOR_STEPPERS, &
                               NO_FLOWS, NO_MASKS, NO_STEPPERS
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_fluid_keys

  character(*), parameter :: MEAN_FLOWS = 'free|fixed|sinusoidal|dynamic'
  character(*), parameter :: SPONGES = 'cavity|cavity_open_z|xmin_xmax|xmin_xmax_ymin_ymax|'// &
                             'xmin_xmax_zmin_zmax|outlet_x|top_cover|2D_frame'

contains

  !> Adds every key the fluid reads to `registry`.
  subroutine register_fluid_keys(registry)
    type(registry_t), intent(inout) :: registry
    call register_grid(registry)
    call register_time(registry)
    call register_initial_condition(registry)
    call register_solids(registry)
    call register_sponge_and_mean_flow(registry)
  end subroutine register_fluid_keys

  subroutine register_grid(r)
    type(registry_t), intent(inout) :: r
    real(rp), parameter :: BOX = 6.283185307179586_rp
    call r%add_section('Resolution', 'grid points and how they are shared among the ranks')
    call r%add_integer('Resolution', 'nx', 4, 'points in x, even; 1 means a two-dimensional flow in the y-z plane', &
                       min=1, max=32768, required=.true.)
    call r%add_integer('Resolution', 'ny', 4, 'points in y, even', min=4, max=32768, required=.true.)
    call r%add_integer('Resolution', 'nz', 4, 'points in z, even', min=4, max=32768, required=.true.)
    call r%add_integer('Resolution', 'process_rows', 0, &
                       'rows of the process grid (they share y); 0 chooses slabs if possible', min=0)
    call r%add_word('Resolution', 'planner', 'auto', 'auto|estimate|measure', &
                    'FFTW planning: estimate repeats to the last bit, measure is faster; auto measures for long runs')
    call r%add_section('Parallel', 'how the ranks work together')
    call r%add_word('Parallel', 'transform', 'builtin', 'builtin|p3dfft', &
                    'Fourier transforms: builtin, or the library P3DFFT if the program was built with it')
    call r%add_section('Geometry', 'the periodic box and the generic body')
    call r%add_real('Geometry', 'xl', BOX, 'length of the box in x', unit='L', above=0.0_rp)
    call r%add_real('Geometry', 'yl', BOX, 'length of the box in y', unit='L', above=0.0_rp)
    call r%add_real('Geometry', 'zl', BOX, 'length of the box in z', unit='L', above=0.0_rp)
    call r%add_length('Geometry', 'x0', 'xl/2', 'centre of body or vortex, x', unit='L')
    call r%add_length('Geometry', 'y0', 'yl/2', 'centre of body or vortex, y', unit='L')
    call r%add_length('Geometry', 'z0', 'zl/2', 'centre of body or vortex, z', unit='L')
call r%add_length('Geometry', 'Size', '0.0', 'diameter of sphere and cylinder, side of the plate, radius of the ring', &
                      unit='L', min=0.0_rp)
    call r%add_real('Geometry', 'alpha', 0.0_rp, 'turning of the plate about the z axis', unit='degree')
    call r%add_real('Geometry', 'r1', 1.0_rp, 'inner radius of the couette body', unit='L', above=0.0_rp)
    call r%add_real('Geometry', 'r2', 1.0681415_rp, 'outer radius of the couette body', unit='L', above=0.0_rp)
    call r%add_inert('Geometry', 'r3', 'used by a FLUSI body that does not exist here')
    call r%add_section('Dealiasing', 'truncation of the spectrum')
    call r%add_word('Dealiasing', 'iDealias', '1', '0|1|ellipsoid|box|none', &
                    '1 = ellipsoid: 2/3 rule on an ellipsoid as FLUSI; box: 2/3 rule per direction; 0 = none')
  end subroutine register_grid

  subroutine register_time(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Time', 'time stepping')
    call r%add_real('Time', 'Tmax', 1.0e9_rp, 'end of the run', unit='T', min=0.0_rp)
    call r%add_integer('Time', 'nt', 999999999, 'largest number of time steps', min=0)
    call r%add_word('Time', 'iTimeMethodFluid', 'AB2', &
                    'AB2|RK4|RK2|Euler|AB2_rigid_solid|FSI_AB2_staggered|FSI_AB2_semiimplicit|FSI_AB2_iteration', &
                    'all with the exact viscous factor; AB2: Adams-Bashforth; RK2 (Heun) and RK4: Runge-Kutta, at 2 '// &
                    'and 4 times its cost; Euler: first order; FSI_*: AB2, and a coupling of flexible wings; '// &
                    'AB2_rigid_solid: FLUSI''s name for AB2 with BodyMotion = free_flight', unbuilt=NO_STEPPERS, &
                    instead=FOR_STEPPERS)
    call r%add_real('Time', 'CFL', 0.1_rp, 'CFL number of the advective limit', above=0.0_rp)
    call r%add_real('Time', 'CFL_eta', 0.99_rp, 'largest dt/eps of the explicit penalization', above=0.0_rp)
    call r%add_real('Time', 'dt_fixed', 0.0_rp, 'prescribed step; 0: chosen by the CFL rule', unit='T', min=0.0_rp)
    call r%add_real('Time', 'dt_max', 0.0_rp, 'largest step; 0: no such limit', unit='T', min=0.0_rp)
    call r%add_switch('Time', 'intelligent_dt', .false., &
                      'hit output times exactly: the time left to the next one is spread over equal steps')
    call r%add_section('ReynoldsNumber', 'viscosity')
    call r%add_real('ReynoldsNumber', 'nu', 1.0e-2_rp, 'kinematic viscosity', unit='L^2/T', min=0.0_rp)
  end subroutine register_time

  subroutine register_initial_condition(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('InitialCondition', 'the flow at t = 0')
    call r%add_word('InitialCondition', 'inicond', 'none', &
                    'quiescent|MeanFlow|VortexRing|taylor_green_2d|taylor_green|turbulence_rogallo|'// &
                    'random-given-spectrum|infile|backup|backup::*', 'initial velocity', required=.true., &
                    unbuilt=NO_FLOWS, instead=FOR_FLOWS)
    call r%add_real('InitialCondition', 'omega1', 0.0_rp, &
                    'circulation of the vortex ring; mean kinetic energy of turbulence_rogallo')
    call r%add_integer('InitialCondition', 'seed', 0, 'seed of random fields; the field does not depend on the ranks', &
                       min=0)
    call r%add_inert('InitialCondition', 'nu_smoothing', 'belongs to an initial condition that does not exist here')
    call r%add_text('InitialCondition', 'file_ux', 'none', 'HDF5 field with u_x for infile')
    call r%add_text('InitialCondition', 'file_uy', 'none', 'HDF5 field with u_y for infile')
    call r%add_text('InitialCondition', 'file_uz', 'none', 'HDF5 field with u_z for infile')
    call r%add_inert('InitialCondition', 'file_p', 'pressure is not a prognostic variable')
    call r%add_text('InitialCondition', 'inicond_spectrum_file', 'none', &
                    'text file with columns k, E(k) for random-given-spectrum')
  end subroutine register_initial_condition

  subroutine register_solids(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Penalization', 'solid bodies by volume penalization')
    call r%add_switch('Penalization', 'iPenalization', .false., 'whether there are solids at all')
    call r%add_word('Penalization', 'iMask', 'none', 'none|empty|no|sphere|Sphere|cylinder|cylinder_x|plate|Plate|couette|'// &
                    'from_file::*|Insect|insect|Flexible_wing', 'body: sphere; cylinder along z (2-D: along x); '// &
                    'cylinder along x; square plate; Couette device; file; Insect: the wings of [Insects]; '// &
                    'Flexible_wing: these, with wings = flexible', &
                    unbuilt=NO_MASKS, instead=FOR_MASKS)
    call r%add_word('Penalization', 'obstacle', 'none', 'none|sphere|cylinder|cylinder_x', 'iMask = Insect: a body at rest '// &
                    'beside the insect, with [Geometry] Size at x0, y0, z0; cylinder along z (2-D: along x) or x')
    call r%add_switch('Penalization', 'iMoving', .false., &
                      'whether the body moves: the wings of Insect do; without effect on other bodies', computed='as iMask says')
    call r%add_real('Penalization', 'eps', 1.0e-2_rp, 'permeability C_eta', unit='T', above=0.0_rp)
    call r%add_word('Penalization', 'iCavity', 'no', 'no|yes|0|1', 'walls around the box, cavity_size points thick', &
                    unbuilt='freestream*', instead=FOR_CAVITIES)
    call r%add_integer('Penalization', 'cavity_size', 0, 'thickness of the cavity walls', unit='points', min=0)
    call r%add_word('Penalization', 'iChannel', 'no', 'no|xy|xz|xy_sliding|xz_sliding|turek|0|1', &
                    'one wall between pos_wall-thick_wall and pos_wall, normal z (xy) or y (xz); '// &
                    'sliding: it moves with the prescribed mean flow; turek: the wall xy, with a parabola of the '// &
                    'velocity that flows in along y, and a cylinder along x of [Geometry] Size at y0, z0; 0 = no, '// &
                    '1 = xy', unbuilt='inlet_x|cylinder', instead=FOR_CHANNELS)
    call r%add_length('Penalization', 'thick_wall', '0.2', 'thickness of the channel wall', unit='L', min=0.0_rp)
    call r%add_length('Penalization', 'pos_wall', '0.3', 'upper face of the channel wall', unit='L')
    call r%add_real('Penalization', 'inflow_velocity', 1.0_rp, 'turek: mean over the height of the channel', &
                    unit='L/T', above=0.0_rp)
    call r%add_length('Penalization', 'inflow_length', '0.0', 'turek: the inflow is imposed on this last part of y', &
                      unit='L', min=0.0_rp)
    call r%add_real('Penalization', 'inflow_start', 0.0_rp, &
                    'turek: time in which the inflow grows from rest; 0: it is there at once', unit='T', min=0.0_rp)
    call r%add_switch('Penalization', 'compute_forces', .true., 'write forces.t and its relatives')
call r%add_switch('Penalization', 'unst_corrections', .false., 'without effect on wings: their unsteady correction '// &
                      'is exact and always written; other bodies do not move. Free flight: if it is set to no, the insect '// &
                      'carries the fluid in its mask along, as in FLUSI')
    call r%add_switch('Penalization', 'periodic', .false., 'wrap lever arms of torques around the box')
    call r%add_reals('Penalization', 'us_fixed', [0.0_rp, 0.0_rp, 0.0_rp], 'velocity imposed inside the body', &
                     unit='L/T', length=3)
    call r%add_real('Penalization', 'omega', 1.25_rp, 'angular velocity of the inner cylinder of the couette body', &
                    unit='1/T')
  end subroutine register_solids

  subroutine register_sponge_and_mean_flow(r)
    type(registry_t), intent(inout) :: r
    character(*), parameter :: AXES = 'xyz'
    integer :: i
    call r%add_section('Sponge', 'vorticity sponge')
    call r%add_switch('Sponge', 'iVorticitySponge', .false., 'damp the vorticity in a frame of the box')
    call r%add_word('Sponge', 'iSpongeType', 'top_cover', SPONGES, 'which faces of the box', &
                    unbuilt='moving_insect*', instead=FOR_SPONGES)
  call r%add_real('Sponge', 'eps_sponge', 0.0_rp, 'damping time C_sp; has no default when the sponge is on', unit='T', &
                    min=0.0_rp)
    call r%add_integer('Sponge', 'sponge_thickness', 0, 'thickness of the sponge', unit='points', min=0)
    call r%add_section('MeanFlow', 'velocity of the mean (0,0,0) mode')
    do i = 1, 3
      call r%add_word('MeanFlow', 'iMeanFlow_'//AXES(i:i), 'free', MEAN_FLOWS, &
                      'free: follows the forces; fixed: prescribed; sinusoidal: u sin(2 pi f t); '// &
                      'dynamic: accelerated by the reaction of the solids', unbuilt='accelerate_to_unity', &
                      instead=FOR_MEAN_FLOWS)
      call r%add_real('MeanFlow', 'u'//AXES(i:i), 1.0_rp, 'mean velocity in '//AXES(i:i), unit='L/T')
    end do
    call r%add_integer('MeanFlow', 'iMeanFlow', 0, 'old FLUSI switch: 1 fixes all three components', min=0, max=1)
    call r%add_real('MeanFlow', 'm_fluid', 999.0e9_rp, 'mass of fluid that dynamic mean flow accelerates', unit='M', &
                    above=0.0_rp)
    call r%add_real('MeanFlow', 'umean_freq', 0.0_rp, 'frequency of sinusoidal mean flow', unit='1/T', min=0.0_rp)
    call r%add_switch('MeanFlow', 'iMeanFlowStartupConditioner', .false., 'ramp up the force of dynamic mean flow')
    call r%add_real('MeanFlow', 'tau_meanflow', 0.0_rp, 'duration of the ramp', unit='T', min=0.0_rp)
    call r%add_real('MeanFlow', 'T_release_meanflow', 0.0_rp, 'start of the ramp', unit='T', min=0.0_rp)
  end subroutine register_sponge_and_mean_flow
end module fluid_keys
