! SPDX-License-Identifier: GPL-3.0-or-later
!> Describes the parameters that every wing has, and the causes of a misfit that are wrong values of these parameters. Module
!> solid_effects describes what a usual model leaves out.
!>
!> | name | what | unit | scale |
!> |---|---|---|---|
!> | `E` | Young's modulus of all veins | Pa | log |
!> | `E:<vein>` | factor on E of one vein | 1 | log |
!> | `joint:<name>` | stiffness of one joint | N m/rad | log |
!> | `D` | bending stiffness of the membrane | N m | log |
!> | `thickness` | thickness of a membrane with the bending stiffness D | m | log |
!> | `root` | factor on the hinges at the clamped root | 1 | log |
!> | `diameter_exponent` | p in I = pi dm^4/64 (d/dm)^p, dm the mean diameter, 4: circles | 1 | linear |
!> | `k_vein`, `k_membrane`, `k_cross` | extension stiffness of a spring | N/m | log |
module solid_usual_causes
  use base_cause, only: cause_parameter_t, cause_t, enlist, make_cause
  use base_kinds, only: rp
  use base_parameter, only: define => define_parameter
  use base_wording, only: word_factor, ASSUMED, SCALE_FACTOR, SCALE_HALF
  implicit none
  private
  public :: usual_parameter, list_usual_causes

  integer, parameter, public :: PARAM_YOUNG = 1, PARAM_PLATE = 2, PARAM_THICKNESS = 3, PARAM_ROOT = 4, &
                                PARAM_EXPONENT = 5, PARAM_K_VEIN = 6, PARAM_K_MEMBRANE = 7, PARAM_K_CROSS = 8
  integer, parameter, public :: N_COMMON = 8 !< parameters of every wing
  !> The parameters that each vein or each joint has. They follow the parameters of every wing.
  integer, parameter, public :: EACH_VEIN = N_COMMON + 1, EACH_JOINT = N_COMMON + 2, N_USUAL = N_COMMON + 2

  real(rp), parameter :: DECADE = 2.302585092994046_rp

contains

  !> Returns parameter i: unit, scale, bounds and words. The names of EACH_VEIN and EACH_JOINT end with a colon, behind which the
  !> name of the part belongs.
  pure function usual_parameter(i) result(p)
    integer, intent(in) :: i
    type(cause_parameter_t) :: p
    p%number = i
    p%scale = ''
    p%prior_scale = ''
    select case (i)
    case (PARAM_YOUNG)
      call define(p%value, 'E', 'Pa', .true., 1.0e8_rp, 1.0e11_rp)
      call word_factor(p%words, SCALE_FACTOR, 'The veins are stiffer: E is', 'The veins are softer: E is', 'higher', 'lower', &
                       ASSUMED, 'what was assumed')
    case (PARAM_PLATE)
      call define(p%value, 'D', 'N m', .true., 1.0e-9_rp, 1.0e-5_rp)
      call word_stiffness(p, 'The membrane resists bending more:', 'The membrane resists bending less:')
    case (PARAM_THICKNESS)
      call define(p%value, 'thickness', 'm', .true., 1.0e-6_rp, 3.0e-5_rp)
    case (PARAM_ROOT)
      call define(p%value, 'root', '1', .true., 1.0e-3_rp, 1.0e3_rp)
      call word_stiffness(p, 'The veins bend less easily at the clamp:', 'The veins bend more easily at the clamp:')
    case (PARAM_EXPONENT)
      call define(p%value, 'diameter_exponent', '1', .false., 1.0_rp, 6.0_rp)
      call word_factor(p%words, SCALE_HALF, 'Thin veins are stiff against thick ones: one of half the diameter is', &
                       'Thin veins are soft against thick ones: one of half the diameter is', 'stiffer', 'softer', &
                       'than if both were solid and round', 'as stiff as if both were solid and round', 4.0_rp)
    case (PARAM_K_VEIN)
      call define(p%value, 'k_vein', 'N/m', .true., 1.0e3_rp, 1.0e6_rp)
      call word_springs(p, 'along the veins')
    case (PARAM_K_MEMBRANE)
      call define(p%value, 'k_membrane', 'N/m', .true., 1.0e3_rp, 1.0e6_rp)
      call word_springs(p, 'of the membrane')
    case (PARAM_K_CROSS)
      call define(p%value, 'k_cross', 'N/m', .true., 1.0e1_rp, 1.0e6_rp)
      call word_springs(p, 'across the edges of the membrane')
    case (EACH_VEIN)
      call define(p%value, 'E:', '1', .true., 1.0e-2_rp, 1.0e2_rp)
      call word_factor(p%words, SCALE_FACTOR, 'Vein @ is of stiffer material: its E is', 'Vein @ is of softer material: its E is', &
                       'higher', 'lower', 'than in the other veins', 'that of the other veins', 1.0_rp)
    case default
      call define(p%value, 'joint:', 'N m/rad', .true., 1.0e-8_rp, 1.0e-2_rp)
      p%value%prior_sd = DECADE
      call word_stiffness(p, 'Joint @ is stiffer:', 'Joint @ is softer:')
    end select
  end function usual_parameter

  !> Sets the words for a factor on an assumed stiffness.
  pure subroutine word_stiffness(p, up, down)
    type(cause_parameter_t), intent(inout) :: p
    character(*), intent(in) :: up, down
    call word_factor(p%words, SCALE_FACTOR, up, down, 'stiffer', 'softer', ASSUMED, 'as stiff as was assumed')
  end subroutine word_stiffness

  !> Sets the words for springs that are stiffer or softer.
  pure subroutine word_springs(p, where)
    type(cause_parameter_t), intent(inout) :: p
    character(*), intent(in) :: where
    call word_stiffness(p, 'The springs '//where//' are stiffer:', 'The springs '//where//' are softer:')
  end subroutine word_springs

  !> Returns the causes that are wrong values of these parameters.
  pure function list_usual_causes() result(list)
    type(cause_t), allocatable :: list(:)
    call enter(list, 'root_stiffness', 20, [PARAM_ROOT], 'root of another stiffness', &
               'The veins bend more or less easily where the wing is clamped.', 'loads near the root')
    call enter(list, 'E_per_vein', 40, [EACH_VEIN], 'a vein of another material', &
               'One vein is softer or stiffer than the others.', 'loads that bend the vein')
    call enter(list, 'joint_stiffness', 45, [EACH_JOINT], 'a joint of another stiffness', &
               'One joint of veins is softer or stiffer than was stated or, if nothing was stated, than its vein.', &
               'loads that bend the joint')
    call enter(list, 'taper', 50, [PARAM_EXPONENT], 'other cross-sections of veins', &
               'Thin veins are stiffer or softer against thick ones than solid circles would be: hollow or flattened veins.', &
               'loads that bend thick and thin veins')
    call enter(list, 'membrane_bending', 60, [PARAM_PLATE], 'stiffer or softer membrane', &
               'The membrane resists bending more or less than was assumed.', 'loads on the membrane')
    call enter(list, 'elasticity', 70, [PARAM_PLATE, PARAM_K_VEIN, PARAM_K_MEMBRANE, PARAM_K_CROSS], &
               'stiffness of membrane and springs', &
               'Everything elastic that is not fitted, membrane and springs, is stiffer or softer than was assumed, '// &
               'as if all forces had another size.', 'loads that bend the membrane')
  end function list_usual_causes

  !> Enters one cause with its `place` in the catalogue and its parameters. A cause with EACH_VEIN or EACH_JOINT is tried for one
  !> vein or joint at a time.
  pure subroutine enter(list, name, place, numbers, title, sentence, data)
    type(cause_t), allocatable, intent(inout) :: list(:)
    character(*), intent(in) :: name, title, sentence, data
    integer, intent(in) :: place, numbers(:)
    type(cause_t) :: cause
    integer :: i
    cause = make_cause(name, title, sentence, data)
    cause%place = place
    cause%is_joint = all(numbers /= EACH_VEIN .and. numbers /= EACH_JOINT)
    do i = 1, size(numbers)
      call cause%add_told(usual_parameter(numbers(i)))
    end do
    call enlist(list, cause)
  end subroutine enter
end module solid_usual_causes
