! SPDX-License-Identifier: GPL-3.0-or-later
!> An insect that flies freely, with wings in the mask and without thickness: it and the fluid have one momentum, its wings
!> have inertia, and what is held does not move.
program test_free_flight
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_free_flight, only: begin_flight, launch, prepare_flight, settle
  use fsi_thin_wings, only: thin_wings_t
  use support_momentum, only: flow_momentum
  use support_wings, only: make_wings, wings_text, write_lines, NL
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: FLIGHT = 'BodyMotion=free_flight'//NL//'mass=5.0'//NL//'gravity=-0.3'//NL// &
                             'J_body_yawpitchroll=0.9 0.9 0.8'//NL//'wing_mass=0.2'//NL//'v0=0.2 0.1 0.0'//NL// &
                             'FlappingMotion_left=from_file::beat.ini'//NL//'FlappingMotion_right=from_file::beat.ini'//NL
  type(testkit_t) :: test

  call test%start(parallel=.true.)
  call write_lines(test%world, 'wing.ini', '[Wing]'//NL//'type = curve'//NL//'length = 0.7'//NL//'mean_chord = 0.3'//NL// &
                   'outline = (/ 0.0 0.15'//NL//'0.7 0.15'//NL//'0.7 -0.15'//NL//'0.0 -0.15 /)')
  call write_lines(test%world, 'beat.ini', '[kinematics]'//NL//'type=fourier'//NL//'units=degree'//NL// &
                   'convention=flusi'//NL//'nfft_phi=1'//NL//'a0_phi=20'//NL//'ai_phi=0'//NL//'bi_phi=50'//NL// &
                   'nfft_alpha=1'//NL//'a0_alpha=0'//NL//'ai_alpha=45'//NL//'bi_alpha=0'//NL//'nfft_theta=0'//NL// &
                   'a0_theta=0')
  call exchange('penalized', 'with thick wings', '')
  call exchange('thin', 'with wings without thickness', '')
  ! The roots of its wings are inside the body, which has their share of the forces of the markers there.
  call exchange('thin', 'with wings without thickness and a body', 'BodyType=sphere'//NL//'L_body=0.8'//NL)
  call hold()
  call test%finish()

contains

  !> 30 steps with free mean flow: the momentum of insect and fluid changes by the weight alone.
  subroutine exchange(surface, words, body)
    character(*), intent(in) :: surface, words
    character(*), intent(in) :: body !< keys of [Insects]
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(thin_wings_t) :: thin
    type(request_t) :: nothing
    type(failure_t) :: failure
    real(rp) :: before(3), now(3), start(3), change
    integer :: i
    call make_wings(test%world, wings_text(surface)//FLIGHT//body//still_air(), fluid, wings)
    if (surface == 'thin') call thin%init(test%world, wings, fluid, failure)
    call prepare_flight(wings)
    call begin_flight(test%world, wings, fluid, failure)
    call test%check('an insect '//words//' may fly', .not. failure%failed)
    if (failure%failed) return
    change = 0
    before = total(fluid, wings)
    start = before
    do i = 1, 30
      call fluid%step(nothing, failure, wings)
      if (failure%failed) exit
      call launch(wings, fluid)
      if (surface == 'thin') call thin%advance_rigid(fluid, wings, failure)
      call settle(wings, fluid)
      now = total(fluid, wings)
      change = max(change, norm2(now - before - [0.0_rp, 0.0_rp, -1.5_rp*fluid%dt]))
      before = now
    end do
    call test%check('it makes 30 steps', .not. failure%failed)
    call test%check_below('insect and fluid exchange their momentum to round-off '//words, change, 1.0e-12_rp)
    call test%check('which is much', norm2(wings%flyer%state%momentum - start) > 0.05_rp)
    call fluid%free()
  end subroutine exchange

  function still_air() result(text)
    character(:), allocatable :: text
    text = '[MeanFlow]'//NL//'ux=0'//NL//'uy=0'//NL//'uz=0'//NL//'[Time]'//NL//'Tmax=1'//NL//'CFL=0.3'//NL
  end function still_air

  !> Momentum of the fluid in the box, and of the insect beyond that of the fluid in its mask. Collective.
  function total(fluid, wings) result(momentum)
    type(fluid_t), intent(in) :: fluid
    type(flapping_wings_t), intent(in) :: wings
    real(rp) :: momentum(3)
    momentum = flow_momentum(test%world, fluid) + wings%flyer%state%momentum
  end function total

  !> All degrees of freedom held: the insect moves on with v0, to round-off, as a prescribed one; released it does not.
  subroutine hold()
    type(fluid_t) :: fluid
    type(flapping_wings_t) :: wings
    type(request_t) :: nothing
    type(failure_t) :: failure
    real(rp) :: error
    call make_wings(test%world, wings_text()//FLIGHT//'release_time=0.05'//NL//still_air(), fluid, wings)
    call prepare_flight(wings)
    call begin_flight(test%world, wings, fluid, failure)
    error = 0
    do while (fluid%rhs%state%time < 0.1_rp .and. .not. failure%failed)
      call fluid%step(nothing, failure, wings)
      if (fluid%sums_time < 0.05_rp) error = max(error, norm2(wings%body%velocity - [0.2_rp, 0.1_rp, 0.0_rp]), &
        norm2(wings%body%centre - [1.25_rp, 1.25_rp, 0.75_rp] - [0.2_rp, 0.1_rp, 0.0_rp]*fluid%sums_time))
      call launch(wings, fluid)
      call settle(wings, fluid)
    end do
    call test%check_below('before its release an insect moves on with v0', error, 1.0e-14_rp)
    call test%check('then it flies', norm2(wings%body%velocity - [0.2_rp, 0.1_rp, 0.0_rp]) > 1.0e-3_rp)
    call fluid%free()
  end subroutine hold
end program test_free_flight
