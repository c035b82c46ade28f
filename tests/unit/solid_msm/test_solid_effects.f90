! SPDX-License-Identifier: GPL-3.0-or-later
!> What a wing may do beyond the usual model: every effect has the law that its name promises and vanishes at its null to
!> the last bit.
program test_solid_effects
  use base_cause, only: cause_t, find_wording
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use base_wording, only: wording_t
  use effect_wings, only: make_plain, model_of, DISC
  use named_params, only: set_each
  use sample_wings, only: make_beam
  use solid_arch, only: arch_energy
  use solid_edges, only: edges_t, make_edges
  use solid_effect, only: effect_t, STAGE_NONE
  use solid_effect_damage, only: damage_weight
  use solid_effects, only: list_effect_causes, list_effects, N_EFFECTS
  use solid_extension, only: extension_axial, tension_energy
  use solid_hinge, only: hinge_evaluate, hinge_t, HINGE_NODES
  use solid_junctions, only: hinge_plan_t
  use solid_layout, only: free_place_in_vein, hinge_in_vein, vein_places
  use solid_model, only: solid_model_t
  use solid_params, only: default_params, solid_params_t
  use solid_plate, only: plate_energy
  use solid_tangent, only: assemble_tangent
  use solid_twist, only: camber_evaluate, make_twists, twist_evaluate, twist_t, TWIST_NODES
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(wing_t) :: wing
  type(solid_model_t) :: plain
  real(rp), allocatable :: u(:, :), along(:, :)

  call t%start(parallel=.false.)
  call make_plain(wing, plain, u, along)
  call test_list()
  call test_null()
  call test_laws()
  call test_cubic_moment()
  call test_sides()
  call test_pretension()
  call test_camber()
  call test_torsion()
  call test_soft_place()
  call t%finish()

contains

  !> Every effect of the list has a law with its derivative, and a cause with the same parameters, texts and words.
  subroutine test_list()
    type(effect_t) :: list(N_EFFECTS)
    type(cause_t), allocatable :: causes(:)
    type(wording_t) :: words
    character(:), allocatable :: names
    integer :: e
    list = list_effects()
    causes = list_effect_causes()
    names = ' '
    do e = 1, size(list)
      associate (one => list(e), cause => causes(e))
        call t%check(cause%name//' has a law', (associated(one%apply) .and. one%stage /= STAGE_NONE) .neqv. &
                     (associated(one%modulus) .or. all(one%clamp_axis(:one%n) > 0)))
        call t%check('  and its derivative', (associated(one%apply) .eqv. associated(one%derive)) .and. &
                     (associated(one%modulus) .eqv. associated(one%modulus_slope)))
        call t%check('  and texts', min(len(cause%name), len(cause%title), len(cause%sentence), len(cause%definition), &
                                        len(cause%data), len(cause%confused)) > 0)
        call t%check('  and a cause of its own', index(names, ' '//cause%name//' ') == 0)
        names = names//cause%name//' '
        call t%check('  with its parameters', size(cause%parameters) == one%n .and. (cause%is_joint .neqv. one%is_per_joint) .and. &
                     all(cause%parameters%value%is_log .eqv. one%is_log))
        call check_words(cause, one%is_per_joint)
      end associate
    end do
    call find_wording(causes(1)%parameters, 'no such effect', 'here', 1.0_rp, words)
    call t%check('what is no effect has no words',.not. words%is_known)
  end subroutine test_list

  !> Words for each parameter of an effect, with its null.
  subroutine check_words(cause, is_per_joint)
    type(cause_t), intent(in) :: cause
    logical, intent(in) :: is_per_joint
    type(wording_t) :: words
    character(:), allocatable :: name
    integer :: k
    do k = 1, size(cause%parameters)
      associate (p => cause%parameters(k)%value)
        name = p%name
        if (is_per_joint) name = name//'knee'
        call find_wording(cause%parameters, name, 'here', p%upper, words)
        call t%check('  and words for '//name, words%is_known .and. index(words%up//words%down, '@') == 0)
        call t%check('  with its null', abs(words%reference - p%null) <= 0)
      end associate
    end do
  end subroutine check_words

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
    model = model_of(wing, is_null=.true., has_sides=.false.)
    params = default_params(wing)
    params%joint = 2.0e-6_rp
    params%joint(3) = -1
    call bare%init(wing, params, failure)
    n = 0
    do i = params%count_basic() + 1, params%count()
      p = params%describe(i)
      n = n + merge(1, 0, p%is_effect .and. abs(params%get(i) - p%null) <= 0 .and. p%prior_sd > 0 .and. &
                    p%lower <= p%null .and. p%upper > p%null)
      call t%check('effect '//p%name//' is found by its name', params%find(p%name) == i)
    end do
    call t%check('all effects are at null unless set', n == params%effects%count() .and. n == 14 + 20)
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
    bare = model_of(wing, is_null=.true., has_sides=.false.)
    model = model_of(wing, is_null=.false., has_sides=.false.)
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
        if (model%springs%family(s) /= 1) f = f*exp(0.6_rp*(((a(1) + b(1))/2 - root)/9.0e-3_rp - 0.5_rp))
        w = weight((a(:2) + b(:2))/2)
        worst(3) = max(worst(3), abs(model%stiffness%extension(s)/(bare%stiffness%extension(s)*f*(1 - 0.7_rp*w)) - 1))
      end associate
    end do
    do e = 1, model%plate%n
      associate (n => model%plate%nodes(:, e), p => wing%points)
        w = (weight(sum(p(:2, n([1, 2, 3])), 2)/3) + weight(sum(p(:2, n([1, 2, 4])), 2)/3))/2
        x = sum(p(1, n([1, 2, 3, 1, 2, 4])))/6 ! of both triangles
        f = exp(3*0.6_rp*((x - root)/9.0e-3_rp - 0.5_rp))
        worst(4) = max(worst(4), abs((model%stiffness%plate + model%stiffness%edge(e))/ &
                                     (bare%stiffness%plate*f*(1 - 0.7_rp*w)) - 1))
      end associate
    end do
    call t%check_below('gradient, softness and damage of hinges', worst(1), ROUNDING)
    call t%check_below('hardening of joints and cuticle', worst(2), ROUNDING)
    call t%check_below('orthotropy, thickness and damage of springs', worst(3), ROUNDING)
    call t%check_below('thickness and damage of the membrane', worst(4), ROUNDING)
    call t%check('the damage has a rim', any(abs([(damage_weight(DISC, model%layout%hinge_site(:, h)), &
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
    call params%set_named('cuticle', 3.0e-6_rp)
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

  !> A tension T holds a flat membrane still but for its outline, and a slope s over the whole membrane costs T s^2/2 per
  !> area.
  subroutine test_pretension()
    real(rp), parameter :: T0 = 0.3_rp, SLOPE = 1.0e-4_rp
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(failure_t) :: failure
    real(rp), dimension(3, plain%n_all) :: v, g
    logical :: is_inside(plain%n_all)
    type(edges_t) :: edges
    real(rp) :: area
    integer :: m
    params = default_params(wing)
    call params%set_named('pretension', T0)
    call model%init(wing, params, failure)
    v = 0
    call model%gradient(v, g)
    edges = make_edges(size(wing%points, 2), wing%triangles)
    is_inside = .true.
    do m = 1, edges%n
      if (edges%triangles(2, m) == 0) is_inside(edges%nodes(:, m)) = .false.
    end do
    call t%check_below('a stretched membrane lies still', &
                       maxval(norm2(g, 1), mask=is_inside)/maxval(abs(g)), 1.0e-12_rp)
    call t%check('  its outline draws', maxval(abs(g)) > 0)
    v(3, :model%n_points) = SLOPE*wing%points(2, :)
    area = 0
    do m = 1, size(wing%triangles, 2)
      associate (a => wing%points(:, wing%triangles(1, m)), b => wing%points(:, wing%triangles(2, m)), &
                 c => wing%points(:, wing%triangles(3, m)))
        area = area + 0.5_rp*abs((b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1)))
      end associate
    end do
    call t%check_close('and a slope stretches it further', tension_energy(model%springs, model%stiffness%tension, v), &
                       T0*SLOPE**2/2*area, rtol=1.0e-7_rp) ! SLOPE^2
  end subroutine test_pretension

  !> In the shape without stress the camber takes away twice the energy that the plate has there.
  subroutine test_camber()
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(failure_t) :: failure
    real(rp), parameter :: CURVATURES(3) = [1.5_rp, -40.0_rp, 7.0_rp] ! [1/m] xx, yy, xy
    real(rp) :: v(3, plain%n_all), bent
    params = default_params(wing)
    call set_each(params, 'camber_', CURVATURES)
    params%effects%has_sided_veins = .true.
    call model%init(wing, params, failure)
    v = 0
    associate (x => wing%points(1, :), y => wing%points(2, :), k => CURVATURES)
      v(3, :model%n_points) = 0.5_rp*(k(1)*x**2 + k(2)*y**2) + k(3)*x*y
    end associate
    bent = model%stiffness%plate*plate_energy(model%plate, v)
    call t%check('the shape is bent', bent > 0)
    call t%check_close('which costs nothing', arch_energy(model%plate, model%points, model%stiffness%arch, v), -2*bent, &
                       rtol=1.0e-12_rp)
  end subroutine test_camber

  !> Two segments whose membranes are turned by an angle about them: k sin^2/2; nothing where the vein bends or the
  !> membrane folds in the same way on both sides.
  subroutine test_torsion()
    real(rp), parameter :: ANGLE = 0.4_rp, K = 3.0_rp
    integer, parameter :: TRIANGLES(3, 4) = reshape([1, 2, 4, 2, 1, 5, 2, 3, 6, 3, 2, 7], [3, 4])
    type(twist_t), allocatable :: twists(:)
    type(hinge_plan_t) :: plan(1)
    real(rp) :: x(3, 7), u(3, TWIST_NODES), energy
    integer :: i
    x = reshape([-1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 1, 0, -1, -1, 0, 1, 1, 0, 1, -1, 0], [3, 7])
    plan(1)%nodes = [1, 2, 3]
    call make_twists(make_edges(7, TRIANGLES), plan, TRIANGLES, x, twists)
    u = 0
    do i = 4, 7
      if (twists(1)%x0(1, i) > 0) u(:, i) = [0.0_rp, (cos(ANGLE) - 1)*twists(1)%x0(2, i), sin(ANGLE)*twists(1)%x0(2, i)]
    end do
    call twist_evaluate(twists(1), K, u, energy)
    call t%check_close('a twisted vein', energy, K*sin(ANGLE)**2/2, rtol=1.0e-13_rp)
    u = 0
    do i = 3, 7
      if (twists(1)%x0(1, i) > 0) u(:, i) = [cos(ANGLE) - 1, 0.0_rp, sin(ANGLE)]
    end do
    call twist_evaluate(twists(1), K, u, energy)
    call t%check_below('a bent vein is not twisted', abs(energy), 1.0e-28_rp)
    u = 0
    u(3, 4:7) = ANGLE
    call twist_evaluate(twists(1), K, u, energy)
    call t%check_below('nor is one in a fold', abs(energy), 1.0e-28_rp)
    u = 0 ! the segment and its membrane bend up by ANGLE, as in a wing that is bent evenly
    do i = 3, 7
      if (twists(1)%x0(1, i) > 0) u(:, i) = [cos(ANGLE) - 1, 0.0_rp, sin(ANGLE)]
    end do
    call camber_evaluate(twists(1), K, u, energy)
    call t%check_close('a bow pushes by the change of slope along the mean normal', energy, -K*sin(ANGLE), &
                       rtol=1.0e-13_rp)
  end subroutine test_torsion

  !> A straight joint across two flat halves that bends by an angle of 0.8 up or down: one of both costs 1.4 as much.
  subroutine test_sides()
    type(hinge_t) :: hinge
    real(rp) :: u(3, HINGE_NODES), energy(2), g(3, HINGE_NODES)
    real(rp), parameter :: ANGLE = 0.8_rp, K = 2.0_rp
    integer :: side, i
    hinge%nodes = [(i, i=1, 7)]
    hinge%n_nodes = 7
    hinge%n_triangles = 4
    hinge%is_straight = .false.
    hinge%corners = reshape([1, 2, 4, 2, 1, 5, 2, 3, 6, 3, 2, 7], [3, 4])
    hinge%x0 = reshape([-1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 1, 0, -1, -1, 0, 1, 1, 0, 1, -1, 0], [3, 7])
    do side = 1, 2
      u = 0
      do i = 3, 7
        if (hinge%x0(1, i) > 0) u(:, i) = [cos(ANGLE) - 1, 0.0_rp, merge(1, -1, side == 1)*sin(ANGLE)]
      end do
      call hinge_evaluate(hinge, K, u, energy(side), g, lift=0.4_rp*K)
    end do
    call t%check_close('bending up costs 1.4 as much', energy(1), 1.4_rp*K*ANGLE**2/2, rtol=1.0e-13_rp)
    call t%check_close('  as bending down', energy(2), K*ANGLE**2/2, rtol=1.0e-13_rp)
  end subroutine test_sides

  !> The nearest point inside the vein; places of joints are refused.
  subroutine test_soft_place()
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(failure_t) :: failure
    integer :: h
    params = default_params(wing)
    params%effects%soft_vein = 'C' ! 24 equal segments along x, 9 mm
    params%effects%soft_fraction = 0.55_rp
    call model%init(wing, params, failure)
    h = model%layout%soft_hinge
    call t%check('there is a hinge', h > 0)
    if (h > 0) call t%check_below('at the nearest point', abs(model%layout%hinge_site(1, h) - 9.0e-3_rp*13/24), &
                                  0.5_rp*9.0e-3_rp/24)
    params%effects%soft_vein = 'no such vein'
    call model%init(wing, params, failure)
    call t%check('an unknown vein is refused', failure%failed)
    do h = 1, size(plain%plans)
      if (plain%plans(h)%joint > 0 .and. plain%plans(h)%veins(1) == plain%plans(h)%veins(2)) exit
    end do
    associate (vein => plain%plans(h)%veins(1), point => plain%plans(h)%nodes(2))
      call t%check('no place where a joint is', hinge_in_vein(wing, plain%plans, vein, fraction_of(vein, point)) == 0)
    end associate
    call test_places_of_finer_wing()
  end subroutine test_soft_place

  !> A place between two points, as a finer mesh has it, may be nearest to a point that has a joint. The next point serves then.
  subroutine test_places_of_finer_wing()
    real(rp) :: fraction, place
    integer :: v, k, lost(2)
    lost = 0
    do v = 1, size(wing%veins)
      associate (nodes => wing%veins(v)%nodes)
        do k = 2, size(nodes)
          fraction = (fraction_of(v, nodes(k - 1)) + fraction_of(v, nodes(k)))/2
          place = free_place_in_vein(wing, v, fraction)
          if (hinge_in_vein(wing, plain%plans, v, fraction) == 0) lost(1) = lost(1) + 1
          if (hinge_in_vein(wing, plain%plans, v, place) == 0 .or. abs(place - fraction) > 1.6_rp/(size(nodes) - 1)) &
            lost(2) = lost(2) + 1 ! segments are about equal
        end do
      end associate
    end do
    call t%check('some places are nearest to a joint, and have a hinge beside it', lost(1) > 0 .and. lost(2) == 0)
  end subroutine test_places_of_finer_wing

  !> Place of a point along a vein, of its length.
  pure real(rp) function fraction_of(vein, point)
    integer, intent(in) :: vein, point
    real(rp) :: places(size(wing%veins(vein)%nodes))
    places = vein_places(wing, vein)
    fraction_of = places(findloc(wing%veins(vein)%nodes, point, 1))
  end function fraction_of
end program test_solid_effects
