! SPDX-License-Identifier: GPL-3.0-or-later
!> What a wing may do beyond the usual model: every effect has the law that its name promises, vanishes at its null to the
!> last bit, and its forces, tangent and derivatives belong together.
program test_solid_effects
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use sample_wings, only: make_beam, make_fly_wing
  use solid_effect_damage, only: damage_weight
  use solid_extension, only: extension_axial
  use solid_layout, only: hinge_in_vein
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, parameter_t, solid_params_t
  use solid_stiffness, only: stiffness_t
  use solid_stiffness_effects, only: bending_direction, damage_direction, hinge_direction, parameter_direction
  use solid_tangent, only: assemble_tangent
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  real(rp), parameter :: STENCIL(4) = [4/5.0_rp, -1/5.0_rp, 4/105.0_rp, -1/280.0_rp] ! 8th-order difference
  real(rp), parameter :: DISC(3) = [4.0e-3_rp, 0.0_rp, 1.5e-3_rp]
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: plain
  real(rp), allocatable :: u(:, :), along(:, :)

  call t%start(parallel=.false.)
  call make_plain()
  call test_null()
  call test_laws()
  call test_cubic_moment()
  call test_consistency()
  call test_directions(is_null=.true.)
  call test_directions(is_null=.false.)
  call test_scans()
  call test_soft_place()
  call t%finish()

contains

  subroutine make_plain()
    type(failure_t) :: failure
    integer :: i, j
    wing = make_fly_wing(24, 12)
    call plain%init(wing, default_params(wing), failure)
    call t%check('the model is built',.not. failure%failed)
    allocate (u(3, plain%n_all), along(3, plain%n_all))
    do i = 1, plain%n_all
      u(:, i) = [(4.0e-5_rp*sin(2.9_rp*i + 1.1_rp*j**2), j=1, 3)]
      along(:, i) = [(sin(1.7_rp*i + 0.3_rp*j), j=1, 3)]
    end do
    call plain%zero_clamped(u)
    call plain%zero_clamped(along)
  end subroutine make_plain

  !> A model with places for damage and softness, and effects at values of their own or at null.
  function model_with(is_null) result(model)
    logical, intent(in) :: is_null
    type(solid_model_t) :: model
    type(solid_params_t) :: params
    type(failure_t) :: failure
    params = default_params(wing)
    params%effects%disc = DISC
    params%effects%soft_vein = 'R4+5'
    params%effects%soft_share = 0.45_rp
    params%joint = 2.0e-6_rp
    params%joint(3) = -1
    if (.not. is_null) then
      call set(params, 'E_gradient', -0.8_rp)
      call set(params, 'damage', 0.3_rp)
      call set(params, 'soft', 0.2_rp)
      call set(params, 'orthotropy', 0.4_rp)
      call set(params, 'joint_hardening', 5.0_rp)
      call set(params, 'hardening:'//trim(params%joint_names(2)), -0.5_rp)
      call set(params, 'cuticle', 2.0e-6_rp)
    end if
    call model%init(wing, params, failure)
    call t%check('the model with effects is built',.not. failure%failed)

  end function model_with

  subroutine set(params, name, value)
    type(solid_params_t), intent(inout) :: params
    character(*), intent(in) :: name
    real(rp), intent(in) :: value
    call params%set(params%find(name), value)
  end subroutine set

  !> At null, effects with a place of their own change no bit of forces and tangent.
  subroutine test_null()
    type(solid_model_t) :: model, bare
    type(solid_params_t) :: params
    type(parameter_t) :: p
    type(failure_t) :: failure
    real(rp), dimension(3, plain%n_all) :: g, h
    real(rp), dimension(3, 3, size(plain%pattern%rows)) :: a, b
    real(rp) :: axial(plain%springs%n)
    integer :: i, n
    model = model_with(.true.)
    params = default_params(wing)
    params%joint = 2.0e-6_rp
    params%joint(3) = -1
    call bare%init(wing, params, failure)
    n = 0
    do i = params%count_usual() + 1, params%count()
      p = params%describe(i)
      n = n + merge(1, 0, p%is_effect .and. abs(params%get(i) - p%null) <= 0 .and. p%prior_sd > 0 .and. &
                    p%lower <= p%null .and. p%upper > p%null)
      call t%check('effect '//p%name//' is found by its name', params%find(p%name) == i)
    end do
    call t%check('all effects are at null unless set', n == params%effects%count() .and. n == 8 + 10)
    call model%gradient(u, g)
    call bare%gradient(u, h)
    call t%check('effects at null change no bit of the forces', all(transfer(g, [1]) == transfer(h, [1])))
    call extension_axial(bare%springs, bare%stiffness%extension, u, axial)
    call assemble_tangent(model, u, axial, .false., a)
    call assemble_tangent(bare, u, axial, .false., b)
    call t%check('  nor of the tangent', all(transfer(a, [1]) == transfer(b, [1])))
    call t%check('  nor of the energy', transfer(model%energy(u), 1) == transfer(bare%energy(u), 1))
  end subroutine test_null

  !> Stiffness of single elements against the formulas.
  subroutine test_laws()
    type(solid_model_t) :: model, bare
    real(rp), parameter :: ROUNDING = 1.0e-13_rp
    real(rp) :: worst(4), root, x, f, w
    integer :: h, s, e
    bare = model_with(.true.)
    model = model_with(.false.)
    worst = 0
    root = sum(wing%points(1, wing%root))/6
    do h = 1, size(model%plans)
      associate (plan => model%plans(h), place => wing%points(:, model%plans(h)%nodes(2)))
        x = (place(1) - root)/9.0e-3_rp ! the wing is 9 mm long
        f = 1
        if (plan%joint == 0 .or. plan%joint == 3) f = exp(-0.8_rp*(x - 0.5_rp))
        if (h == model%layout%soft_hinge) f = 0.2_rp*f
        w = weight(place(:2))
        worst(1) = max(worst(1), abs(model%stiffness%hinge(h)/(bare%stiffness%hinge(h)*f*(1 - 0.7_rp*w)) - 1))
        f = 5
        if (plan%joint == 2) f = 4.5_rp
        if (plan%joint == 0) f = 2.0e-6_rp/(0.5_rp*sum(plan%lengths))**2
        worst(2) = max(worst(2), abs(model%stiffness%cubic(h)/(model%stiffness%hinge(h)*f) - 1))
      end associate
    end do
    do s = 1, model%springs%n
      associate (a => wing%points(:, model%springs%nodes(1, s)), b => wing%points(:, model%springs%nodes(2, s)))
        f = 1
        if (model%springs%family(s) == 2) f = 1 + 0.4_rp*cos(2*atan2(b(2) - a(2), b(1) - a(1)))
        w = weight((a(:2) + b(:2))/2)
        worst(3) = max(worst(3), abs(model%stiffness%extension(s)/(bare%stiffness%extension(s)*f*(1 - 0.7_rp*w)) - 1))
      end associate
    end do
    do e = 1, model%plate%n
      associate (n => model%plate%nodes(:, e), p => wing%points)
        w = (weight(sum(p(:2, n([1, 2, 3])), 2)/3) + weight(sum(p(:2, n([1, 2, 4])), 2)/3))/2
        worst(4) = max(worst(4), abs((model%stiffness%plate + model%stiffness%edge(e))/ &
                                     (bare%stiffness%plate*(1 - 0.7_rp*w)) - 1))
      end associate
    end do
    call t%check_below('gradient, softness and damage of hinges', worst(1), ROUNDING)
    call t%check_below('hardening of joints and cuticle', worst(2), ROUNDING)
    call t%check_below('orthotropy and damage of springs', worst(3), ROUNDING)
    call t%check_below('damage of the membrane', worst(4), ROUNDING)
    call t%check('the damage has a rim', any(abs([(damage_weight(DISC, model%layout%hinge_place(:, h)), &
                                                   h=1, size(model%plans))] - 0.5_rp) < 0.499_rp))
    call t%check_close('the rim halves at the radius', damage_weight([1.0e-3_rp, 2.0e-3_rp, 5.0e-4_rp], &
                                                                     [1.3e-3_rp, 2.4e-3_rp]), 0.5_rp, rtol=1.0e-12_rp)
  end subroutine test_laws

  !> The weight of the damage, written another way.
  pure real(rp) function weight(place)
    real(rp), intent(in) :: place(2)
    real(rp) :: r
    r = sqrt(sum((place - DISC(:2))**2))/DISC(3)
    if (r <= 0.95_rp) then
      weight = 1
    else if (r >= 1.05_rp) then
      weight = 0
    else
      r = 10*(r - 0.95_rp)
      weight = 1 - r**2*(3 - 2*r)
    end if
  end function weight

  !> One hinge turned by Theta: the moment is k Theta (1 + h Theta^2).
  subroutine test_cubic_moment()
    real(rp), parameter :: ANGLE = 0.6_rp, L = 1.0e-3_rp, D = 1.0e-4_rp
    type(wing_t) :: beam
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(failure_t) :: failure
    real(rp), allocatable :: v(:, :), g(:, :)
    real(rp) :: k, kappa
    beam = make_beam(2, 2*L, D, [1.0_rp, 0.0_rp, 0.0_rp])
    beam%root = [1, 2] ! one hinge at the clamped point 2
    params = default_params(beam)
    params%effects%cuticle = 3.0e-6_rp
    call model%init(beam, params, failure)
    allocate (v(3, model%n_all), g(3, model%n_all), source=0.0_rp)
    v(:, 3) = L*[cos(ANGLE) - 1, 0.0_rp, sin(ANGLE)]
    call model%gradient(v, g)
    k = 2*params%young*3.141592653589793_rp*D**4/64/L ! EI over the half-length that bends
    kappa = ANGLE/(L/2)
    call t%check('there is one hinge', size(model%plans) == 1)
    call t%check_close('EI kappa (1 + c kappa^2)', L*(g(3, 3)*cos(ANGLE) - g(1, 3)*sin(ANGLE)), &
                       k*ANGLE*(1 + 3.0e-6_rp*kappa**2), rtol=1.0e-12_rp)
  end subroutine test_cubic_moment

  !> With all effects: forces are the derivative of the energy, the tangent that of the forces, and its semidefinite
  !> part is so, also where joints soften.
  subroutine test_consistency()
    type(solid_model_t) :: model
    real(rp), dimension(3, plain%n_all) :: g, gp, gm, fd
    real(rp) :: slope, axial(plain%springs%n), blocks(3, 3, size(plain%pattern%rows)), hv(3, plain%n_free), lowest, &
                x(3, plain%n_free)
    real(rp), parameter :: H = 1.0e-6_rp
    integer :: s, i, j
    model = model_with(.false.)
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
    call model%set_parameter(model%params%find('joint_hardening'), -1.0_rp)
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
    integer :: i, s
    model = model_with(is_null)
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
        call other%set_parameter(i, moved(value, s*step, p%is_log))
        call other%gradient(u, gp)
        call other%set_parameter(i, moved(value, -s*step, p%is_log))
        call other%gradient(u, gm)
        fd = fd + STENCIL(s)*(gp - gm)/step
      end do
      if (index(p%name, 'k_cross') == 1) cycle ! this wing has no cross-springs
      call t%check('the forces depend on '//p%name, maxval(abs(g)) > 0)
      call t%check_below('the forces'' derivative to '//p%name//trim(merge(' at null', '        ', is_null)), &
                         maxval(abs(g - fd))/(maxval(abs(g)) + 1.0e-6_rp*maxval(abs(gp))/step), 1.0e-8_rp)
    end do
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
    model = model_with(.false.)
    call damage_direction(plain, elsewhere, dk)
    call plain%gradient(u, g, dk)
    fd = 0
    other = plain
    do s = 1, 4
      other%params%effects%disc = elsewhere
      call other%set_parameter(other%params%find('damage'), exp(s*STEP))
      call other%gradient(u, gp)
      call other%set_parameter(other%params%find('damage'), exp(-s*STEP))
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

  !> The nearest point inside the vein; places of joints are refused.
  subroutine test_soft_place()
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(failure_t) :: failure
    integer :: h
    params = default_params(wing)
    params%effects%soft_vein = 'C' ! 24 equal segments along x, 9 mm
    params%effects%soft_share = 0.55_rp
    call model%init(wing, params, failure)
    h = model%layout%soft_hinge
    call t%check('there is a hinge', h > 0)
    if (h > 0) call t%check_below('at the nearest point', abs(model%layout%hinge_place(1, h) - 9.0e-3_rp*13/24), &
                                  0.5_rp*9.0e-3_rp/24)
    params%effects%soft_vein = 'no such vein'
    call model%init(wing, params, failure)
    call t%check('an unknown vein is refused', failure%failed)
    h = 0
    do while (h < size(plain%plans))
      h = h + 1
      if (plain%plans(h)%joint > 0 .and. plain%plans(h)%veins(1) == plain%plans(h)%veins(2)) exit
    end do
    associate (vein => plain%plans(h)%veins(1), point => plain%plans(h)%nodes(2))
      call t%check('no place where a joint is', hinge_in_vein(wing, plain%plans, vein, share_of(vein, point)) == 0)
    end associate
  end subroutine test_soft_place

  !> Place of a point along a vein, of its length.
  pure real(rp) function share_of(vein, point)
    integer, intent(in) :: vein, point
    real(rp) :: way, here
    integer :: k
    way = 0
    here = 0
    associate (nodes => wing%veins(vein)%nodes)
      do k = 2, size(nodes)
        way = way + norm2(wing%points(:, nodes(k)) - wing%points(:, nodes(k - 1)))
        if (nodes(k) == point) here = way
      end do
    end associate
    share_of = here/way
  end function share_of
end program test_solid_effects
