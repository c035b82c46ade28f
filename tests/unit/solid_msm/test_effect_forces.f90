! SPDX-License-Identifier: GPL-3.0-or-later
!> With effects the forces of a wing are the derivatives of its energy, the tangent those of the forces, and the
!> derivatives of the forces with respect to every effect are exact, in the model or not.
program test_effect_forces
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use effect_wings, only: make_plain, model_of, STENCIL
  use model_variation, only: set_parameter
  use solid_extension, only: extension_axial
  use solid_model, only: solid_model_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: bending_direction, damage_direction, hinge_direction, parameter_direction
  use solid_tangent, only: assemble_tangent
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: plain
  real(rp), allocatable :: u(:, :), along(:, :)

  call t%start(parallel=.false.)
  call make_plain(wing, plain, u, along)
  call test_consistency()
  call test_directions(is_null=.true.)
  call test_directions(is_null=.false.)
  call test_scans()
  call t%finish()

contains

  !> With all effects: forces are the derivative of the energy, the tangent that of the forces, and its semidefinite
  !> part is so, also where joints soften.
  subroutine test_consistency()
    type(solid_model_t) :: model
    real(rp), dimension(3, plain%n_all) :: g, gp, gm, fd
    real(rp) :: slope, axial(plain%springs%n), hv(3, plain%n_free), lowest, &
                x(3, plain%n_free)
    real(rp), parameter :: H = 1.0e-7_rp ! no joint passes from up to down within a few of them
    real(rp), allocatable :: blocks(:, :, :)
    integer :: s, i, j
    model = model_of(wing, is_null=.false., has_sides=.true., has_sided_veins=.true.)
    allocate (blocks(3, 3, size(model%pattern%rows)))
    call model%gradient(u, g)
    slope = 0
    fd = 0
    do s = 1, 4
      call model%gradient(u + s*H*along, gp)
      call model%gradient(u - s*H*along, gm)
      fd = fd + STENCIL(s)*(gp - gm)/H
      slope = slope + STENCIL(s)*(model%energy(u + s*H*along) - model%energy(u - s*H*along))/H
    end do
    call t%check_close('forces are the derivative of the energy', sum(g*along), slope, rtol=1.0e-9_rp)
    call extension_axial(model%springs, model%stiffness%extension, u, axial)
    call assemble_tangent(model, u, axial, .false., blocks)
    hv = 0
    call model%pattern%multiply(blocks, 1.0_rp, along(:, model%movable), hv)
    call t%check_below('the tangent is the derivative of the forces', &
                       maxval(abs(hv - fd(:, model%movable)))/maxval(abs(hv)), 1.0e-9_rp)
    call set_parameter(model, model%params%find('joint_hardening'), -1.0_rp)
    call assemble_tangent(model, 40*u, axial, .true., blocks)
    lowest = 0
    do s = 1, 50
      x = reshape([((sin(0.7_rp*s*i + 0.1_rp*s**2*j), j=1, 3), i=1, model%n_free)], [3, model%n_free])
      hv = 0
      call model%pattern%multiply(blocks, 1.0_rp, x, hv)
      lowest = min(lowest, sum(x*hv)/maxval(abs(blocks)))
    end do
    call t%check('the semidefinite part is so', lowest > -1.0e-12_rp)
  end subroutine test_consistency

  !> Directions are the differences of the forces; steps of 1/1000 make an error of the eighth order, and what is
  !> left is the rounding of the forces over the step.
  subroutine test_directions(is_null)
    logical, intent(in) :: is_null
    type(solid_model_t) :: model, other
    type(parameter_t) :: p
    type(stiffness_t) :: dk
    real(rp), dimension(3, plain%n_all) :: g, gp, gm, fd
    real(rp) :: step, value
    integer :: i, s, n_up
    model = model_of(wing, is_null, has_sides=.true., has_sided_veins=.true.)
    n_up = 0
    do i = 1, model%params%count()
      p = model%params%describe(i)
      if (.not. acts_on_stiffness(p%name)) cycle
      call parameter_direction(model, i, dk)
      call model%gradient(u, g, dk)
      value = model%params%get(i)
      step = 1.0e-3_rp*max(1.0_rp, merge(1.0_rp, p%prior_sd, p%is_log .or. .not. p%is_effect))
      if (p%name == 'cuticle') step = 1.0e-8_rp
      if (p%name == 'diameter_exponent') step = 1.0e-3_rp
      fd = 0
      other = model
      do s = 1, 4
        call set_parameter(other, i, moved(value, s*step, p%is_log))
        call other%gradient(u, gp)
        call set_parameter(other, i, moved(value, -s*step, p%is_log))
        call other%gradient(u, gm)
        fd = fd + STENCIL(s)*(gp - gm)/step
      end do
      if (index(p%name, 'k_cross') == 1) cycle ! this wing has no cross-springs
      if (index(p%name, 'one_way:') == 1) then ! half of the joints bend down
        if (.not. maxval(abs(g)) > 0) cycle
        n_up = n_up + 1
      end if
      call t%check('the forces depend on '//p%name, maxval(abs(g)) > 0)
      call t%check_below('the forces'' derivative to '//p%name//trim(merge(' at null', '        ', is_null)), &
                         maxval(abs(g - fd))/(maxval(abs(g)) + 1.0e-6_rp*maxval(abs(gp))/step), 1.0e-8_rp)
    end do
    call t%check('some joints bend up', n_up > 0 .and. n_up < 10)
  end subroutine test_directions

  pure logical function acts_on_stiffness(name)
    character(*), intent(in) :: name
    acts_on_stiffness = index(name, 'root_') /= 1
  end function acts_on_stiffness

  pure real(rp) function moved(value, step, is_log)
    real(rp), intent(in) :: value, step
    logical, intent(in) :: is_log
    moved = value + step
    if (is_log) moved = value*exp(step)
  end function moved

  !> Effects that the model does not have: any single hinge, damage anywhere, all bending stiffness.
  subroutine test_scans()
    real(rp), parameter :: elsewhere(3) = [6.0e-3_rp, -1.0e-3_rp, 0.8e-3_rp], STEP = 1.0e-3_rp
    type(solid_model_t) :: model, other
    type(stiffness_t) :: dk, changed
    real(rp), dimension(3, plain%n_all) :: g, gp, gm, fd
    integer :: s, h
    model = model_of(wing, is_null=.false., has_sides=.false.)
    call damage_direction(plain, elsewhere, dk)
    call plain%gradient(u, g, dk)
    fd = 0
    other = plain
    do s = 1, 4
      other%params%effects%disc = elsewhere
      call set_parameter(other, other%params%find('damage'), exp(s*STEP))
      call other%gradient(u, gp)
      call set_parameter(other, other%params%find('damage'), exp(-s*STEP))
      call other%gradient(u, gm)
      fd = fd + STENCIL(s)*(gp - gm)/STEP
    end do
    call t%check_below('damage anywhere', maxval(abs(g - fd))/maxval(abs(g)), 1.0e-9_rp)
    h = size(model%plans)/2
    call hinge_direction(model, h, dk)
    changed = model%stiffness
    changed%hinge(h) = 0
    changed%cubic(h) = 0
    call model%gradient(u, g, dk)
    call model%gradient(u, gp)
    call model%gradient(u, gm, changed)
    call t%check_below('a hinge''s direction is its own force', maxval(abs(gp - gm - g))/maxval(abs(gp)), 1.0e-13_rp)
    call t%check('  which is something', maxval(abs(g)) > 0)
    call bending_direction(model, dk)
    call model%gradient(u, g, dk)
    other = model
    other%params%bending_factor = 3
    call other%set_params(other%params)
    call other%gradient(u, gp)
    call model%gradient(u, gm)
    call t%check_below('all bending stiffness', maxval(abs(gp - gm - 2*g))/maxval(abs(g)), 1.0e-9_rp)
  end subroutine test_scans
end program test_effect_forces
