! SPDX-License-Identifier: GPL-3.0-or-later
!> Every element's gradient and Hessian are the derivatives of its energy, and rigid motions cost
!> nothing and produce no force.
program test_solid_elements
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use derivative_checks, only: derivative_errors, STENCIL
  use model_variation, only: set_parameter
  use sample_wings, only: make_fly_wing, make_beam
  use solid_extension, only: extension_axial
  use solid_hinge, only: hinge_t, hinge_evaluate, turning_law, HINGE_NODES
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params
  use solid_pattern, only: pattern_t
  use solid_stiffness, only: stiffness_t
  use solid_tangent, only: assemble_tangent
  use solid_vectors, only: cross
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call test_turning_law()
  call test_hinges()
  call test_hinge_directions()
  call test_model(slack=1.0_rp)
  call test_model(slack=0.05_rp)
  call test_slack_branches()
  call test_rigid_motion()
  call test_bad_wings()
  call t%finish()

contains

  subroutine test_turning_law()
    real(rp) :: law(0:2), below(0:2), above(0:2), angle
    integer :: i
    real(rp) :: worst
    worst = 0
    do i = 1, 60
      angle = 0.05_rp*i
      law = turning_law(sin(angle/2)**2)
      worst = max(worst, abs(law(0) - angle**2)/angle**2)
    end do
    call t%check_below('the turning law gives the squared angle up to 3 rad', worst, 1.0e-13_rp)
    below = turning_law(0.01_rp*(1 - 1.0e-13_rp))
    above = turning_law(0.01_rp*(1 + 1.0e-13_rp))
    call t%check_below('series and closed form agree where they meet', maxval(abs(below - above)/above), &
                       1.0e-11_rp)
  end subroutine test_turning_law

  !> A hinge with two triangles on each side and rest angle theta0 in a strongly deformed state.
  subroutine make_hinge(theta0, n_triangles, hinge, u)
    real(rp), intent(in) :: theta0
    integer, intent(in) :: n_triangles
    type(hinge_t), intent(out) :: hinge
    real(rp), intent(out) :: u(3, HINGE_NODES)
    integer :: i, j
    hinge%normal0 = [0.0_rp, 0.0_rp, 1.0_rp]
    hinge%x0(:, 1) = [-1.1_rp, 0.0_rp, 0.0_rp]
    hinge%x0(:, 3) = 0.8_rp*[cos(theta0), sin(theta0), 0.0_rp]
    hinge%x0(:, 4) = [-0.4_rp, 0.9_rp, 0.0_rp]
    hinge%x0(:, 5) = [-0.5_rp, -0.7_rp, 0.0_rp]
    hinge%x0(:, 6) = [cos(theta0 + 0.9_rp), sin(theta0 + 0.9_rp), 0.0_rp]
    hinge%x0(:, 7) = [cos(theta0 - 0.8_rp), sin(theta0 - 0.8_rp), 0.0_rp]
    hinge%corners = reshape([1, 2, 4, 2, 1, 5, 2, 3, 6, 3, 2, 7], [3, 4])
    hinge%is_straight = .not. abs(theta0) > 0
    hinge%cos0 = cos(theta0)
    hinge%sin0 = sin(theta0)
    hinge%n_triangles = n_triangles
    hinge%n_nodes = merge(7, 3, n_triangles > 0)
    u = 0
    do i = 1, hinge%n_nodes
      u(:, i) = [(0.25_rp*sin(3.7_rp*i + 1.3_rp*j**2), j=1, 3)]
    end do
  end subroutine make_hinge

  subroutine test_hinges()
    real(rp), parameter :: ANGLES(4) = [0.0_rp, 0.6_rp, -1.6_rp, 2.2_rp], H = 2.0e-3_rp, K = 2.5_rp
    type(hinge_t) :: hinge
    real(rp), dimension(3, HINGE_NODES) :: u, v, g, gp, gm, fd
    real(rp) :: hess(21, 21), fd_hess(21, 21), psd(21, 21), energy, ep, em, e2, x(21), g2(3, HINGE_NODES)
    character(60) :: label
    integer :: a, n, i, c, s
    do a = 1, size(ANGLES)
      do n = 0, 4, 4
        if (a == 1 .and. n == 4) cycle
        call make_hinge(ANGLES(a), n, hinge, u)
        call hinge_evaluate(hinge, K, u, energy, g, hess)
        fd = 0
        fd_hess = 0
        do i = 1, hinge%n_nodes
          do c = 1, 3
            do s = 1, 4
              v = u
              v(c, i) = u(c, i) + s*H
              call hinge_evaluate(hinge, K, v, ep, gp)
              v(c, i) = u(c, i) - s*H
              call hinge_evaluate(hinge, K, v, em, gm)
              fd(c, i) = fd(c, i) + STENCIL(s)*(ep - em)/H
              fd_hess(:, 3*i - 3 + c) = fd_hess(:, 3*i - 3 + c) + STENCIL(s)*reshape(gp - gm, [21])/H
            end do
          end do
        end do
        write (label, '(a,f5.1,a,i0,a)') ' (rest angle', ANGLES(a), ', ', n, ' triangles)'
        call t%check_below('a hinge''s gradient is the derivative of its energy'//trim(label), &
                           maxval(abs(g - fd))/maxval(abs(g)), 1.0e-10_rp)
        call t%check_below('a hinge''s Hessian is the derivative of its gradient'//trim(label), &
                           maxval(abs(hess - fd_hess))/maxval(abs(hess)), 1.0e-9_rp)
        call t%check_below('a hinge''s Hessian is symmetric'//trim(label), &
                           maxval(abs(hess - transpose(hess)))/maxval(abs(hess)), 1.0e-14_rp)
        call hinge_evaluate(hinge, K, u, energy, h=psd, semidefinite=.true.)
        ep = huge(ep)
        do s = 1, 200
          x = [(sin(1.0_rp*s*i + 0.1_rp*s**2), i=1, 21)]
          ep = min(ep, dot_product(x, matmul(psd, x)))
        end do
        call t%check('the semidefinite part is so'//trim(label), ep > -1.0e-12_rp*maxval(abs(psd)))
        v = rotate(hinge%x0 + u) - hinge%x0
        if (n == 0 .and. a > 1) cycle ! a fixed normal does not turn with the structure
        call hinge_evaluate(hinge, K, v, e2, g2)
        call t%check_below('a rotated hinge has the same energy'//trim(label), abs(e2 - energy)/energy, &
                           1.0e-13_rp)
        call t%check_below('its forces turn with it'//trim(label), &
                           maxval(abs(g2 - turned(g)))/maxval(abs(g)), 1.0e-12_rp)
        v = cross_sum(hinge%x0 + u, g)
        call t%check_below('a hinge exerts no net force'//trim(label), &
                           maxval(abs(sum(g, 2)))/maxval(abs(g)), 1.0e-13_rp)
        call t%check_below('a hinge exerts no net moment'//trim(label), maxval(abs(v))/maxval(abs(g)), &
                           1.0e-13_rp)
      end do
    end do
  end subroutine test_hinges

  !> Swinging the next segment by phi costs k phi^2/2 in the plane and out of it, whatever the rest angle.
  subroutine test_hinge_directions()
    real(rp), parameter :: PHI = 0.7_rp, K = 3.0_rp, ANGLES(3) = [0.0_rp, 0.8_rp, 1.5707963267948966_rp]
    type(hinge_t) :: hinge
    real(rp) :: u(3, HINGE_NODES), energy, f(3), axis(3)
    integer :: a
    do a = 1, size(ANGLES)
      call make_hinge(ANGLES(a), merge(2, 0, a > 1), hinge, u) ! the membrane at a-b stays where it is
      u = 0
      f = hinge%x0(:, 3)
      axis = [0.0_rp, 0.0_rp, 1.0_rp]
      u(:, 3) = cos(PHI)*f + sin(PHI)*cross(axis, f) - f
      call hinge_evaluate(hinge, K, u, energy)
      call t%check_close('bending in the plane costs k phi^2/2', energy, 0.5_rp*K*PHI**2, rtol=1.0e-13_rp)
      axis = [f(2), -f(1), 0.0_rp]/norm2(f)
      u(:, 3) = cos(PHI)*f + sin(PHI)*cross(axis, f) - f
      call hinge_evaluate(hinge, K, u, energy)
      call t%check_close('swinging out of the plane costs k phi^2/2', energy, 0.5_rp*K*PHI**2, &
                         rtol=1.0e-13_rp)
    end do
  end subroutine test_hinge_directions

  subroutine test_model(slack)
    real(rp), intent(in) :: slack
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(parameter_t) :: p
    type(solid_model_t) :: model, other
    type(stiffness_t) :: dk
    type(failure_t) :: failure
    real(rp), allocatable, dimension(:, :) :: u, direction, g, gp, gm, fd
    real(rp), allocatable :: blocks(:, :, :), axial(:)
    real(rp) :: scale, value, worst
    integer :: i, j, s
    wing = make_fly_wing(24, 12)
    params = default_params(wing)
    params%cross_springs = .true.
    params%slack = slack
    params%slack_width = 2.0e-4_rp
    params%vein_factor(2) = 1.7_rp
    params%diameter_exponent = 3.5_rp
    params%root_factor = 0.6_rp
    call model%init(wing, params, failure)
    call t%check('the model of a wing is built',.not. failure%failed)
    if (failure%failed) return
    allocate (u(3, model%n_all), direction(3, model%n_all), g(3, model%n_all), gp(3, model%n_all), &
              gm(3, model%n_all), axial(model%springs%n), blocks(3, 3, size(model%pattern%rows)))
    do i = 1, model%n_all
      u(:, i) = [(4.0e-5_rp*sin(2.9_rp*i + 1.1_rp*j**2), j=1, 3)]
      direction(:, i) = [(sin(1.7_rp*i + 0.3_rp*j), j=1, 3)]
    end do
    call model%zero_clamped(u)
    call model%zero_clamped(direction)
    ! at the ends of the slack springs' branches, over which differences reach, the tangent has a kink
    if (slack < 1) call check_derivatives(model, u, direction, 3.0e-8_rp, 1.0e-8_rp, 1.0e-6_rp)
    if (slack >= 1) call check_derivatives(model, u, direction, 1.0e-6_rp, 1.0e-9_rp, 1.0e-9_rp)
    call extension_axial(model%springs, model%stiffness%extension, u, axial)
    call t%check_below('the tangent of the stiffnesses is positive semidefinite without compression', &
                       -quadratic_minimum(model, u, axial, blocks), 1.0e-12_rp)
    if (slack < 1) return

    worst = 0
    do i = 1, model%params%count()
      p = model%params%describe(i)
      call t%check('parameter '//p%name//' is found by its name', model%params%find(p%name) == i)
      if (i > model%params%count_basic()) cycle
      call model%stiffness_derivative(i, .false., dk)
      call model%gradient(u, g, dk)
      fd = 0*u
      value = model%params%get(i)
      other = model
      do s = 1, 4
        call set_parameter(other, i, value*(1 + s*1.0e-3_rp))
        call other%gradient(u, gp)
        call set_parameter(other, i, value*(1 - s*1.0e-3_rp))
        call other%gradient(u, gm)
        fd = fd + STENCIL(s)*(gp - gm)/(1.0e-3_rp*value)
      end do
      call other%gradient(u, gp)
      scale = maxval(abs(g)) + 1.0e-9_rp*maxval(abs(gp))/value
      call t%check_below('the forces'' derivative to '//p%name, maxval(abs(g - fd))/scale, 1.0e-9_rp)
      call t%check('the forces depend on '//p%name, maxval(abs(g)) > 0)
      call model%stiffness_derivative(i, .true., dk)
      call model%gradient(u, gm, dk)
      worst = max(worst, maxval(abs(gm - value*g))/maxval(abs(gm)))
    end do
    call t%check_below('derivatives per log unit are those times the value', worst, 1.0e-13_rp)
  end subroutine test_model

  !> Derivatives of the energy along `direction` and of the gradient against differences of eighth order.
  subroutine check_derivatives(model, u, direction, h, tolerance, tolerance_tangent)
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :), direction(:, :), h, tolerance, tolerance_tangent
    real(rp) :: error, tangent_error
    call derivative_errors(model, u, direction, h, error, tangent_error)
    call t%check_below('the wing''s gradient is the derivative of its energy', error, tolerance)
    call t%check_below('the assembled tangent is the derivative of the gradient', tangent_error, tolerance_tangent)
  end subroutine check_derivatives

  !> The three branches of the slack spring, each far from its ends: all springs of the membrane are stretched,
  !> compressed by less than the width of the change, or by more, everything in one plane.
  subroutine test_slack_branches()
    real(rp), parameter :: STRAINS(3) = [0.02_rp, -0.02_rp, -0.02_rp]
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(failure_t) :: failure
    real(rp), allocatable :: u(:, :), direction(:, :)
    real(rp) :: shortest
    integer :: branch, i, j
    wing = make_fly_wing(24, 12)
    params = default_params(wing)
    params%cross_springs = .true.
    params%slack = 0.05_rp
    call model%init(wing, params, failure)
    shortest = minval(model%springs%l0)
    allocate (direction(3, model%n_all))
    do i = 1, model%n_all
      direction(:, i) = [(shortest*sin(1.7_rp*i + 0.3_rp*j), j=1, 3)]
    end do
    do branch = 1, 3
      params%slack_width = merge(2*0.02_rp*maxval(model%springs%l0), 0.5_rp*0.02_rp*shortest, branch == 2)
      call model%init(wing, params, failure)
      call t%check('a wing with slack springs is built',.not. failure%failed)
      call model%zero_clamped(direction)
      ! the points at the root are strained too: no spring may come near the end of its branch
      u = STRAINS(branch)*model%points + 1.0e-3_rp*direction
      call check_derivatives(model, u, direction, 2.0e-4_rp, 1.0e-9_rp, 1.0e-9_rp)
    end do
  end subroutine test_slack_branches

  real(rp) function quadratic_minimum(model, u, axial, blocks) result(lowest)
    type(solid_model_t), intent(in) :: model
    real(rp), intent(in) :: u(:, :), axial(:)
    real(rp), intent(inout) :: blocks(:, :, :)
    real(rp) :: x(3, model%n_free), y(3, model%n_free)
    integer :: s, i, j
    call assemble_tangent(model, u, axial, .true., blocks)
    lowest = 0
    do s = 1, 50
      x = reshape([((sin(0.7_rp*s*i + 0.1_rp*s**2*j), j=1, 3), i=1, model%n_free)], [3, model%n_free])
      y = 0
      call model%pattern%multiply(blocks, 1.0_rp, x, y)
      lowest = min(lowest, sum(x*y)/maxval(abs(blocks)))
    end do
  end function quadratic_minimum

  subroutine test_rigid_motion()
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(solid_model_t) :: model
    type(failure_t) :: failure
    real(rp), allocatable, dimension(:, :) :: u, v, g, gv
    real(rp) :: energy, moment(3), shift(3)
    integer :: i, j
    wing = make_fly_wing(24, 12)
    params = default_params(wing)
    params%cross_springs = .true.
    call model%init(wing, params, failure)
    allocate (u(3, model%n_all), g(3, model%n_all), gv(3, model%n_all))
    do i = 1, model%n_all
      u(:, i) = [(2.0e-5_rp*sin(2.9_rp*i + 1.1_rp*j**2), j=1, 3)]
    end do
    shift = [1.0e-3_rp, -2.0e-3_rp, 4.0e-4_rp]
    energy = model%energy(u)
    call model%gradient(u, g)
    v = rotate(model%points + u) - model%points + spread(shift, 2, model%n_all)
    call model%gradient(v, gv)
    call t%check_close('the energy of a wing is invariant under rigid motion', model%energy(v), energy, &
                       rtol=1.0e-11_rp)
    call t%check_below('its forces turn with it', maxval(abs(gv - turned(g)))/maxval(abs(g)), 1.0e-11_rp)
    call t%check_below('a wing exerts no net force', maxval(abs(sum(g, 2)))/maxval(abs(g)), 1.0e-12_rp)
    v = cross_sum(model%points + u, g)
    moment = v(:, 1)
    call t%check_below('a wing exerts no net moment', maxval(abs(moment))/(maxval(abs(g))*model%size), &
                       1.0e-12_rp)
    u = 0
    v = rotate(model%points) - model%points + spread(shift, 2, model%n_all)
    call model%gradient(v, gv)
    call t%check_below('a rigid motion costs no energy', model%energy(v), &
                       1.0e-24_rp*model%stiffness%extension(1))
    call t%check_below('a rigid motion produces no force', maxval(abs(gv)), &
                       1.0e-14_rp*model%size*model%stiffness%extension(1))
  end subroutine test_rigid_motion

  subroutine test_bad_wings()
    type(wing_t) :: wing
    type(solid_model_t) :: model
    type(failure_t) :: failure
    wing = make_fly_wing(24, 12)
    wing%points(3, 100) = 1.0e-5_rp
    call model%init(wing, default_params(wing), failure)
    call t%check('a membrane that is not flat is refused', failure%failed)
    wing = make_fly_wing(24, 12)
    wing%joints(4)%nodes(3) = 1
    call model%init(wing, default_params(wing), failure)
    call t%check('a joint beside the veins is refused by name', failure%failed .and. index(failure%reason, &
                                                                                           'J4') > 0)
    wing = make_beam(4, 1.0_rp, 0.1_rp, [1.0_rp, 0.0_rp, 0.0_rp])
    wing%root = [integer ::]
    call model%init(wing, default_params(wing), failure)
    call t%check('a wing without a root is refused', failure%failed)
    wing = make_beam(4, 1.0_rp, 0.1_rp, [1.0_rp, 0.0_rp, 0.0_rp])
    wing%points(3, 3) = 0.1_rp
    call model%init(wing, default_params(wing), failure)
    call t%check('a vein bent out of its plane is refused', failure%failed)
  end subroutine test_bad_wings

  !> A finite rotation about a skew axis.
  pure function turned(x) result(y)
    real(rp), intent(in) :: x(:, :)
    real(rp) :: y(3, size(x, 2))
    real(rp), parameter :: ANGLE = 1.1_rp
    real(rp) :: axis(3)
    integer :: i
    axis = [0.3_rp, -0.5_rp, 0.7_rp]
    axis = axis/norm2(axis)
    do i = 1, size(x, 2)
      y(:, i) = cos(ANGLE)*x(:, i) + sin(ANGLE)*cross(axis, x(:, i)) &
                + (1 - cos(ANGLE))*dot_product(axis, x(:, i))*axis
    end do
  end function turned

  pure function rotate(x) result(y)
    real(rp), intent(in) :: x(:, :)
    real(rp) :: y(3, size(x, 2))
    y = turned(x)
  end function rotate

  !> The sum of x x f in every column.
  pure function cross_sum(x, f) result(m)
    real(rp), intent(in) :: x(:, :), f(:, :)
    real(rp) :: m(3, size(x, 2)), total(3)
    integer :: i
    total = 0
    do i = 1, size(x, 2)
      total = total + cross(x(:, i), f(:, i))
    end do
    m = spread(total, 2, size(x, 2))
  end function cross_sum
end program test_solid_elements
