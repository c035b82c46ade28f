! SPDX-License-Identifier: GPL-3.0-or-later
!> Gradient and tangent of every family of elements of a wing by itself: in the sum of all, an error of a soft family
!> disappears beside the stiff ones. Within a family all stiffnesses are one, so that the same holds for its members.
program test_solid_families
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use derivative_checks, only: derivative_errors
  use sample_wings, only: make_fly_wing
  use solid_extension, only: SPRING_VEIN, SPRING_MEMBRANE, SPRING_CROSS
  use solid_model, only: solid_model_t
  use solid_params, only: solid_params_t, default_params
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  type(solid_model_t) :: whole

  call t%start(parallel=.false.)
  call make_model(whole)
  call test_springs('springs along veins', SPRING_VEIN)
  call test_springs('springs of the membrane', SPRING_MEMBRANE)
  call test_springs('cross-springs', SPRING_CROSS)
  call test_plate()
  call test_hinges('hinges inside veins and where they meet',.not. whole%plans%is_root .and. whole%plans%joint == 0)
  call test_hinges('hinges of joints', whole%plans%joint > 0)
  call test_hinges('hinges at the root', whole%plans%is_root)
  call test_sum()
  call t%finish()

contains

  subroutine make_model(model)
    type(solid_model_t), intent(out) :: model
    type(wing_t) :: wing
    type(solid_params_t) :: params
    type(failure_t) :: failure
    wing = make_fly_wing(24, 12)
    params = default_params(wing)
    params%cross_springs = .true.
    call model%init(wing, params, failure)
    call t%check('the model of a wing is built',.not. failure%failed)
  end subroutine make_model

  !> The model with no stiffness at all.
  function without_stiffness() result(model)
    type(solid_model_t) :: model
    model = whole
    model%stiffness%extension = 0
    model%stiffness%hinge = 0
    model%stiffness%plate = 0
  end function without_stiffness

  subroutine test_springs(name, family)
    character(*), intent(in) :: name
    integer, intent(in) :: family
    type(solid_model_t) :: model
    model = without_stiffness()
    where (model%springs%family == family) model%stiffness%extension = 1
    call check_family(name, model)
  end subroutine test_springs

  subroutine test_plate()
    type(solid_model_t) :: model
    model = without_stiffness()
    model%stiffness%plate = 1
    call check_family('bending of the membrane', model)
  end subroutine test_plate

  subroutine test_hinges(name, is_member)
    character(*), intent(in) :: name
    logical, intent(in) :: is_member(:)
    type(solid_model_t) :: model
    model = without_stiffness()
    where (is_member) model%stiffness%hinge = 1
    call check_family(name, model)
  end subroutine test_hinges

  !> Two states, two directions. The differences are exact to (4 h/l)^8 = 2e-14, l the shortest edge, and to the
  !> rounding of energies, 1e-16 l/h of their derivatives.
  subroutine check_family(name, model)
    character(*), intent(in) :: name
    type(solid_model_t), intent(in) :: model
    real(rp), parameter :: BENT(2) = [4.0e-5_rp, 1.0e-5_rp], H = 1.0e-6_rp
    real(rp), dimension(3, model%n_all) :: u, direction
    real(rp) :: errors(2), worst(2)
    integer :: i, j, c
    worst = 0
    do c = 1, 2
      do i = 1, model%n_all
        u(:, i) = [(BENT(c)*sin(2.9_rp*i + 1.1_rp*j**2), j=1, 3)]
        direction(:, i) = [(sin((1.2_rp + 0.5_rp*c)*i + 0.3_rp*j), j=1, 3)]
      end do
      call model%zero_clamped(u)
      call model%zero_clamped(direction)
      call derivative_errors(model, u, direction, H, errors(1), errors(2))
      worst = max(worst, errors)
    end do
    call t%check_below('the gradient is the derivative of the energy: '//name, worst(1), 1.0e-9_rp)
    call t%check_below('the tangent is the derivative of the gradient: '//name, worst(2), 1.0e-9_rp)
  end subroutine check_family

  !> The families are all that the wing consists of: with their own stiffnesses their forces add up to the wing's.
  subroutine test_sum()
    type(solid_model_t) :: model
    real(rp), dimension(3, whole%n_all) :: u, g, part, total
    integer :: i, j, family
    do i = 1, whole%n_all
      u(:, i) = [(1.0e-5_rp*sin(2.9_rp*i + 1.1_rp*j**2), j=1, 3)]
    end do
    call whole%gradient(u, g)
    total = 0
    do family = 1, 5
      model = without_stiffness()
      select case (family)
      case (1:3)
        where (model%springs%family == family) model%stiffness%extension = whole%stiffness%extension
      case (4)
        model%stiffness%plate = whole%stiffness%plate
      case (5)
        model%stiffness%hinge = whole%stiffness%hinge
      end select
      call model%gradient(u, part)
      total = total + part
    end do
    call t%check_below('the forces of the families add up to those of the wing', &
                       maxval(abs(total - g))/maxval(abs(g)), 1.0e-13_rp)
  end subroutine test_sum
end program test_solid_families
