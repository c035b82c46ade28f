! SPDX-License-Identifier: GPL-3.0-or-later
!> Measures the time of the mask of two flapping wings relative to a fluid step in the same loop. Prints one JSON object on its
!> last line. It is called through bench/mask/run.
program bench_mask
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use bench_floor, only: floor_seconds
  use bench_json, only: number
  use fluid_initial_keys, only: FLOW_RING
  use fluid_params, only: fluid_params_t
  use fluid_requests, only: request_t
  use fluid_solid_keys, only: CHANNEL_NONE, MASK_NONE
  use fluid_solver, only: fluid_t
  use fsi_mask, only: mask_t
  use fsi_planform, only: elliptic_planform
  use fsi_planform_mesh, only: triangulate_planform
  use fsi_surface, only: surface_t
  use parallel_world, only: world_t
  use spectral_fftw, only: PLAN_MEASURE
  use spectral_grid, only: make_grid
  use spectral_sticks, only: DEALIAS_ELLIPSOID
  implicit none
  real(rp), parameter :: MEAN_CHORD = 3.004_rp/9.0_rp !< of a blowfly, in wing lengths
  type(world_t) :: world
  type(fluid_params_t) :: p
  type(fluid_t) :: fluid
  type(mask_t) :: mask
  type(surface_t) :: wings(2)
  type(request_t) :: nothing
  type(failure_t) :: failure
  real(rp), allocatable :: reference(:, :)
  integer, allocatable :: triangles(:, :)
  real(rp) :: dx, begun, drawn, stepped, sums(3), largest(2), total_mask
  integer :: arguments(5), i

  call read_arguments(arguments)
  call world%start()
  ! The box is that of the blowfly experiment: 4 R x 4 R x 2 R, the hinges are half a wing length away from the middle.
  p%grid = make_grid(arguments(1:3), [4.0_rp, 4.0_rp, 2.0_rp])
  p%resolution%planner = PLAN_MEASURE
  p%resolution%dealias = DEALIAS_ELLIPSOID
  p%nu = 1.0e-3_rp
  p%time%t_max = huge(1.0_rp)
  p%time%dt_fixed = 1.0e-5_rp
  p%initial%flow = FLOW_RING
  p%initial%omega1 = 12
  p%solids%size = 0.3125_rp
  p%solids%centre = [2.0_rp, 2.0_rp, 1.0_rp]
  p%solids%is_on = .true.
  p%solids%c_eta = 1.0e-3_rp
  p%solids%mask = MASK_NONE
  p%walls%channel = CHANNEL_NONE
  call triangulate_planform(elliptic_planform(0.0_rp, 1.0_rp, MEAN_CHORD, 0.3_rp), &
                            sqrt(2*MEAN_CHORD/arguments(4)), reference, triangles)
  do i = 1, 2
    call wings(i)%init(reference, triangles, i + 1)
  end do
  call fluid%init(world, p, .false., failure)
  call fluid%start(failure)
  dx = p%grid%max_spacing()
  call mask%init(p%grid, fluid%rhs%block, 2*dx, dx)
  call place_wings(0)
  call mask%draw(wings, fluid%rhs%penalty, failure)
  call fluid%step(nothing, failure)

  sums = 0
  largest = 0
  total_mask = 0
  do i = 1, arguments(5)
    call place_wings(i)
    call world%barrier()
    call cpu_time(begun)
    call mask%draw(wings, fluid%rhs%penalty, failure)
    call cpu_time(drawn)
    call fluid%step(nothing, failure)
    call cpu_time(stepped)
    total_mask = total_mask + drawn - begun
    largest = largest + [drawn - begun, stepped - drawn]
    sums = sums + [real(mask%n_cells, rp), real(mask%n_tests, rp), stepped - drawn]
  end do
  if (failure%failed) error stop 'bench_mask: the flow has failed'
  largest = largest/arguments(5)
  sums = sums/arguments(5)
  total_mask = total_mask/arguments(5)
  begun = floor_seconds(fluid%transform, 6, 3)
  call world%max_reals(largest)
  call world%sum_reals(sums)
  call report()
  call fluid%free()
  call world%stop()

contains

  !> Reads the arguments: nx, ny, nz, the approximate number of triangles of each wing, and the number of steps.
  subroutine read_arguments(numbers)
    integer, intent(out) :: numbers(5)
    character(32) :: text
    integer :: k, status
    do k = 1, 5
      call get_command_argument(k, text)
      read (text, *, iostat=status) numbers(k)
      if (status /= 0) error stop 'bench_mask: nx ny nz triangles steps are expected'
    end do
  end subroutine read_arguments

  !> Returns the angles of a stroke with feathering; they differ in every step, so that no line of the mask stays in place.
  subroutine place_wings(step)
    integer, intent(in) :: step
    real(rp) :: phi, alpha, side, span(3), chord(3), normal(3)
    integer :: k
    do k = 1, 2
      side = merge(1.0_rp, -1.0_rp, k == 1)
      phi = 1.2_rp*cos(0.7_rp*step)
      alpha = 0.8_rp*sin(0.7_rp*step)
      span = [sin(phi), side*cos(phi), 0.0_rp]
      chord = [cos(phi)*cos(alpha), -side*sin(phi)*cos(alpha), sin(alpha)]
      normal = [span(2)*chord(3) - span(3)*chord(2), span(3)*chord(1) - span(1)*chord(3), &
                span(1)*chord(2) - span(2)*chord(1)]
      call wings(k)%place_rigid(reference, reshape([span, chord, normal], [3, 3]), [2.0_rp, 2 + side/2, 1.0_rp], &
                                [0.0_rp, 0.0_rp, 0.0_rp], [0.0_rp, 0.0_rp, 5*side])
    end do
  end subroutine place_wings

  !> Prints the CPU times: those of the slowest rank, and their sum over the ranks for the cost of a band point.
  subroutine report()
    real(rp) :: all_mask(1), floor(1)
    all_mask = total_mask
    floor = begun
    call world%sum_reals(all_mask)
    call world%sum_reals(floor)
    if (.not. world%is_root) return
    write (output_unit, '(a,i0,a,3(i0,1x),a,i0,a)') 'two wings of ', size(triangles, 2), ' triangles on ', &
      p%grid%n, 'points, ', world%size, ' ranks'
    write (output_unit, '(a,3(i0,a),2(i0,a),16a)') '{"grid":[', p%grid%n(1), ',', p%grid%n(2), ',', p%grid%n(3), &
      '],"ranks":', world%size, ',"triangles":', 2*size(triangles, 2), ',"band_cells":', number(sums(1)), &
      ',"tests_per_cell":', number(sums(2)/sums(1)), ',"mask_ms":', number(1e3_rp*largest(1)), &
      ',"ns_per_band_cell":', number(1e9_rp*all_mask(1)/sums(1)), ',"step_ms":', number(1e3_rp*largest(2)), &
      ',"mask_percent_of_step":', number(100*largest(1)/largest(2)), ',"step_ratio_to_floor":', &
      number(sums(3)/floor(1)), '}'
  end subroutine report
end program bench_mask
