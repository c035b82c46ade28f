! SPDX-License-Identifier: GPL-3.0-or-later
!> Wings without thickness: what they lose the flow receives, and all ranks know when markers are too close, although
!> one rank alone owns the wing.
!>
!> usage: test_thin_wings [builtin|p3dfft]
program test_thin_wings
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_thin_wings, only: thin_wings_t
  use support_wings, only: make_wings, NL, wings_text, write_lines
  use test_pick, only: asked_transform
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: kit
  !> Of the largest speed: 1e-5 of long waves, and 1e-3 of the hundredth of the flow that is next to K.
  real(rp), parameter :: READING = 1.0e-4_rp

  call kit%start(parallel=.true.)
  call write_lines(kit%world, 'wing.ini', '[Wing]'//NL//'type=ellipse'//NL//'root=0.05'//NL//'length=0.75'//NL// &
                   'mean_chord=0.3'//NL//'front=0.3')
  call write_lines(kit%world, 'beat.ini', '[kinematics]'//NL//'type=fourier'//NL//'units=degree'//NL// &
                   'nfft_phi=1'//NL//'a0_phi=20.0'//NL//'ai_phi=55.0'//NL//'bi_phi=8.0'//NL// &
                   'nfft_alpha=1'//NL//'a0_alpha=-10.0'//NL//'ai_alpha=0.0'//NL//'bi_alpha=45.0'//NL// &
                   'nfft_theta=1'//NL//'a0_theta=6.0'//NL//'ai_theta=3.0'//NL//'bi_theta=-9.0')
  call check_momentum()
  call check_close_markers()
  call check_close_wings()
  call check_wings_of_different_size()
  call check_crossing_wings()
  call check_translation()
  call kit%finish()

contains

  function text() result(ini)
    character(:), allocatable :: ini
    ini = wings_text('thin')//'eta0=-50'//NL//'FlappingMotion_left=from_file::beat.ini'//NL// &
          'FlappingMotion_right=from_file::beat.ini'//NL//'[Time]'//NL//'Tmax=1'//NL//'dt_max=0.005'//NL// &
          '[MeanFlow]'//NL//'ux=0'//NL//'uy=0'//NL//'uz=0'//NL//'[Parallel]'//NL//'transform='//asked_transform()//NL
  end function text

  !> The mean flow is free, and nothing but the wings changes it: V d(mean)/dt is minus the force on them, in every step. The next
  !> step reads the slip; it needs a flow without modes outside the sphere, though the grid has fewer points in z.
  subroutine check_momentum()
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(thin_wings_t) :: thin
    type(request_t) :: nothing
    type(failure_t) :: failure
    real(rp) :: before(3), after(3), force(3), error, difference
    integer :: step
    call make_wings(kit%world, text(), fluid, wings)
    call thin%init(kit%world, wings, fluid, failure)
    error = 0
    difference = 0
    before = mean_flow(fluid)
    do step = 1, 5
      call fluid%step(nothing, failure, wings)
      if (step > 1) difference = max(difference, maxval(abs(fluid%rhs%reader%velocities - thin%flow))/thin%slip%speed)
      call thin%advance_rigid(fluid, wings, failure)
      call thin%sample_slip(fluid)
      after = mean_flow(fluid)
      force = wings%marker_loads(1)%force + wings%marker_loads(2)%force
      ! The mean of u x omega is 0 but for the round-off of a sum over the grid.
      error = max(error, maxval(abs((after - before)*fluid%transform%grid%volume()/fluid%dt + force))/norm2(force))
      before = after
    end do
    call kit%check('the steps succeed', .not. failure%failed)
    call kit%check_below('the flow receives the momentum that the wings lose', error, 1.0e-10_rp)
    call kit%check('the grid has unequal numbers of points', fluid%transform%grid%n(3) < fluid%transform%grid%n(1))
    call kit%check_below('the next step reads the flow at the markers', difference, READING)
    call fluid%free()
  end subroutine check_momentum

  function mean_flow(fluid) result(mean)
    type(fluid_t), intent(in) :: fluid
    real(rp) :: mean(3)
    mean = 0
    if (fluid%transform%sticks%zero > 0) mean = real(fluid%rhs%state%u(1, fluid%transform%sticks%zero, :))
    call kit%world%sum_reals(mean)
  end function mean_flow

  !> Markers half a grid spacing apart have no response that can be inverted. The check holds on all ranks or fails.
  subroutine check_close_markers()
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(thin_wings_t) :: thin
    type(failure_t) :: failure
    call make_wings(kit%world, text()//'[Insects]'//NL//'RightWing=no'//NL, fluid, wings)
    wings%params%thin%spacing = 0.5_rp*fluid%transform%grid%max_spacing()
    call thin%init(kit%world, wings, fluid, failure)
    call kit%check('all ranks know that markers are too close', failure%failed)
    call fluid%free()
  end subroutine check_close_markers

  !> Two plates that face each other two cells apart in a stream that starts at once answer each other within the step: what
  !> they leave of the slip is what one plate leaves, which knows nothing of its periodic images and of the window's error.
  subroutine check_close_wings()
    real(rp) :: left(2)
    integer :: iterations
    call write_lines(kit%world, 'facing.ini', '[kinematics]'//NL//'type=fourier'//NL//'units=degree'//NL// &
                     'nfft_phi=1'//NL//'a0_phi=180.0'//NL//'ai_phi=0.0'//NL//'bi_phi=0.0'//NL// &
                     'nfft_alpha=1'//NL//'a0_alpha=0.0'//NL//'ai_alpha=0.0'//NL//'bi_alpha=0.0'//NL// &
                     'nfft_theta=1'//NL//'a0_theta=0.0'//NL//'ai_theta=0.0'//NL//'bi_theta=0.0')
    call meet_stream('RightWing=no', left(1), iterations)
    call kit%check('one wing needs no iterations', iterations == 0)
    call meet_stream('RightWing=yes', left(2), iterations)
    call kit%check_below('two plates leave no more of the slip than one does', left(2), 1.5_rp*left(1))
    call kit%check('after a few iterations', iterations > 1 .and. iterations < 20)
  end subroutine check_close_wings

  !> A plate and one of half its length, which other ranks own, face each other two cells apart: the flow receives the momentum
  !> that both lose, each with its own force, and follows both.
  subroutine check_wings_of_different_size()
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(thin_wings_t) :: thin
    type(request_t) :: nothing
    type(failure_t) :: failure
    real(rp) :: before(3), after(3), force(3), error, left
    integer :: step
    call plates('facing', '0.0625', '-0.0625', 'iMeanFlow_x=free'//NL//'iMeanFlow_y=free'//NL//'iMeanFlow_z=free'//NL// &
                'ux=0.3'//NL//'uy=1'//NL//'uz=0.2', fluid, wings)
    wings%params%wings(2)%points = 0.5_rp*wings%params%wings(2)%points
    wings%params%thin%slip_interval = 1
    call thin%init(kit%world, wings, fluid, failure)
    associate (n => thin%wings%last - thin%wings%first + 1)
      call kit%check('the smaller wing has fewer markers', 2*n(2) < n(1) .and. n(2) > 3)
    end associate
    error = 0
    before = mean_flow(fluid)
    do step = 1, 3
      call fluid%step(nothing, failure, wings)
      call thin%advance_rigid(fluid, wings, failure)
      after = mean_flow(fluid)
      force = wings%marker_loads(1)%force + wings%marker_loads(2)%force
      error = max(error, maxval(abs((after - before)*fluid%transform%grid%volume()/fluid%dt + force))/norm2(force))
      before = after
      call thin%sample_slip(fluid)
      if (step == 1) left = thin%slip%after/thin%slip%before
    end do
    print '(a,4es10.2)', 'two sizes: momentum, slip, forces', error, left, norm2(wings%marker_loads(1)%force), &
      norm2(wings%marker_loads(2)%force)
    call kit%check('the steps with wings of different size succeed', .not. failure%failed)
    call kit%check_below('the flow receives the momentum that wings of different size lose', error, 1.0e-10_rp)
    call kit%check_below('and follows both', left, 0.05_rp)
    call fluid%free()
  end subroutine check_wings_of_different_size

  !> Two plates that turn apart want two velocities of the same flow if they are at one place, and half a grid spacing apart they
  !> need forces that are no flow's: all ranks know. Two spacings apart they are sound.
  subroutine check_crossing_wings()
    type(failure_t) :: failure
    call write_lines(kit%world, 'crossing.ini', '[kinematics]'//NL//'type=fourier'//NL//'units=degree'//NL// &
                     'nfft_phi=1'//NL//'a0_phi=180.0'//NL//'ai_phi=0.0'//NL//'bi_phi=0.001'//NL// &
                     'nfft_alpha=1'//NL//'a0_alpha=0.0'//NL//'ai_alpha=0.0'//NL//'bi_alpha=0.0'//NL// &
                     'nfft_theta=1'//NL//'a0_theta=0.0'//NL//'ai_theta=0.0'//NL//'bi_theta=0.0')
    call part('0.0001', '-0.0001', failure)
    call kit%check('wings that cross fail', failure%failed)
    if (failure%failed) call kit%check('the message says what to do', index(failure%reason, 'larger distance') > 0)
    call part('0.016', '-0.016', failure)
    call kit%check('wings half a grid spacing apart fail', failure%failed)
    call part('0.0625', '-0.0625', failure)
    call kit%check('wings two grid spacings apart are sound', .not. failure%failed)
  end subroutine check_crossing_wings

  !> Two plates two cells apart, moved by parts of a cell: their forces change by no more than the window's error of the velocities
  !> at the markers, 1e-6 of the stream, because responses, also of one wing to the other, depend on distances alone. After the
  !> start the forces answer slips of 0.04 of the stream.
  subroutine check_translation()
    real(rp) :: force(3, 2, 2)
    call forces_of_moved([0.0_rp, 0.0_rp, 0.0_rp], force(:, :, 1))
    call forces_of_moved([0.3_rp, 0.5_rp, 0.7_rp], force(:, :, 2))
    call kit%check_below('a shift by parts of a cell changes the forces on two wings by the error of the window', &
                         norm2(force(:, :, 2) - force(:, :, 1)), 1.0e-6_rp/0.04_rp*norm2(force(:, :, 1)))
  end subroutine check_translation

  !> Returns the forces on the plates in a stream after three steps, moved by `cells`.
  subroutine forces_of_moved(cells, force)
    real(rp), intent(in) :: cells(3)
    real(rp), intent(out) :: force(3, 2)
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(thin_wings_t) :: thin
    type(request_t) :: nothing
    type(failure_t) :: failure
    integer :: step
    call plates('facing', '0.0625', '-0.0625', 'ux=0.3'//NL//'uy=1'//NL//'uz=0.2', fluid, wings)
    wings%params%body%centre = wings%params%body%centre + cells*fluid%transform%grid%spacing
    fluid%rhs%params%time%dt_fixed = 3.0e-3_rp ! the CFL number knows the grid
    call thin%init(kit%world, wings, fluid, failure)
    do step = 1, 3
      call fluid%step(nothing, failure, wings)
      call thin%advance_rigid(fluid, wings, failure)
    end do
    call kit%check('the steps of plates that are moved succeed', .not. failure%failed)
    force(:, 1) = wings%marker_loads(1)%force
    force(:, 2) = wings%marker_loads(2)%force
    call fluid%free()
  end subroutine forces_of_moved

  !> Advances the plates of crossing.ini by a step; `failure` tells whether forces were found.
  subroutine part(left, right, failure)
    character(*), intent(in) :: left, right
    type(failure_t), intent(out) :: failure
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(thin_wings_t) :: thin
    type(request_t) :: nothing
    call plates('crossing', left, right, 'ux=0'//NL//'uy=0'//NL//'uz=0', fluid, wings)
    call thin%init(kit%world, wings, fluid, failure)
    call fluid%step(nothing, failure, wings)
    call kit%check('each wing alone is sound', .not. failure%failed)
    call thin%advance_rigid(fluid, wings, failure)
    call fluid%free()
  end subroutine part

  !> Plates whose hinges are `left` and `right` from the middle.
  subroutine plates(motion, left, right, stream, fluid, wings, further)
    character(*), intent(in) :: motion, left, right, stream
    type(fluid_t), intent(inout) :: fluid
    type(flapping_wings_t), intent(inout) :: wings
    character(*), intent(in), optional :: further
    character(:), allocatable :: ini, more
    more = ''
    if (present(further)) more = further
    ini = wings_text('thin')
    ini = ini(:index(ini, 'x_pivot_l=') - 1)//'x_pivot_l=0.0 '//left//' 0.0'//NL//'x_pivot_r=0.0 '//right//' 0.0'//NL
    call make_wings(kit%world, ini//'eta0=0'//NL//'FlappingMotion_left=from_file::'//motion//'.ini'//NL// &
                    'FlappingMotion_right=from_file::'//motion//'.ini'//NL//more//NL//'[Time]'//NL//'Tmax=1'//NL// &
                    'dt_max=0.005'//NL//'[MeanFlow]'//NL//stream//NL//'[Parallel]'//NL// &
                    'transform='//asked_transform()//NL, fluid, wings)
  end subroutine plates

  !> What is left of the slip of plates at rest after one step, relative.
  subroutine meet_stream(wings_there, left, iterations)
    character(*), intent(in) :: wings_there
    real(rp), intent(out) :: left
    integer, intent(out) :: iterations
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(thin_wings_t) :: thin
    type(request_t) :: nothing
    type(failure_t) :: failure
    call plates('facing', '0.0625', '-0.0625', 'ux=0.3'//NL//'uy=1'//NL//'uz=0.2', fluid, wings, wings_there)
    wings%params%thin%slip_interval = 1
    call thin%init(kit%world, wings, fluid, failure)
    call fluid%step(nothing, failure, wings)
    call thin%advance_rigid(fluid, wings, failure)
    call thin%sample_slip(fluid)
    left = thin%slip%after/thin%slip%before
    iterations = thin%slip%iterations
    call fluid%free()
  end subroutine meet_stream
end program test_thin_wings
