! SPDX-License-Identifier: GPL-3.0-or-later
!> Prints size, mass and stiffness of a wing before the program computes with it, and explains these numbers.
module common_wing_report
  use base_build, only: BUILD_COMMIT, BUILD_COMPILER, BUILD_VERSION
  use base_kinds, only: rp
  use base_named_kinds, only: word_of
  use base_parameter, only: parameter_t
  use base_text, only: number_text
  use solid_params, only: membrane_note
  use solid_wing, only: SIDE_UNSTATED, Z_SIDES
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: print_wing

contains

  !> Writes to `unit` the version, the method, and the size, mass and stiffness of the wing.
  subroutine print_wing(unit, method, s)
    integer, intent(in) :: unit
    character(*), intent(in) :: method !< what is computed, in a few words
    type(wing_case_t), intent(in) :: s
    real(rp), parameter :: UG = 1.0e9_rp, UM = 1.0e6_rp, MM = 1.0e3_rp
    character(:), allocatable :: note
    real(rp) :: tensor(3, 3)
    logical :: is_soft
    type(parameter_t) :: effect
    integer :: i
    write (unit, '(a)') 'flusi-msm '//BUILD_VERSION//' ('//BUILD_COMMIT//'), '//BUILD_COMPILER
    write (unit, '(a)') 'method    Truong et al. (masses and springs); '//method
    write (unit, '(a,6(i0,a),f0.3,a)') 'wing      '//s%path//': ', s%model%n_points, ' points, ', &
      size(s%wing%triangles, 2), ' triangles, ', size(s%wing%veins), ' veins, ', size(s%wing%joints), ' joints, ', &
      size(s%wing%root), ' root points, ', s%model%springs%n, ' springs, size ', MM*s%model%size, ' mm'
    if (s%wing%z_side /= SIDE_UNSTATED) write (unit, '(a)') '          +z points to the side: '//word_of(Z_SIDES, s%wing%z_side)
    if (s%has_mass) then
      associate (m => s%mass)
        write (unit, '(a,f0.2,a,f0.2,a,f0.2,a,3(f7.3,a))') 'mass      ', UG*m%total, ' ug: veins ', UG*m%veins, &
   ' ug, membrane ', UG*m%membrane, ' ug; centre of mass', MM*m%centre(1), '', MM*m%centre(2), '', MM*m%centre(3), ' mm'
        tensor = UG*MM**2*m%inertia_about([0.0_rp, 0.0_rp, 0.0_rp])
        write (unit, '(a,6(a,g0.5))') 'inertia   about the hinge', ': Jxx ', tensor(1, 1), ', Jyy ', tensor(2, 2), &
          ', Jzz ', tensor(3, 3), ', Jxy ', tensor(1, 2), ', Jxz ', tensor(1, 3), ', Jyz ', tensor(2, 3)
        write (unit, '(a)') '          ug mm^2, wing frame; off the diagonal minus the products of inertia'
        if (m%area > 0) write (unit, '(a,f0.3,a,f0.2,a,i0,a)') 'membrane  ', MM**2*m%area, ' mm^2; its mass means ', &
          UM*m%thickness, ' um at ', nint(s%material%vein_density), ' kg/m^3'
      end associate
    end if
    if (size(s%wing%triangles) > 0) then
      call membrane_note(s%model%params, note, is_soft)
      write (unit, '(a)') '          '//note
    end if
    associate (p => s%model%params)
      write (unit, '(a,es11.4,a,3(es10.3,a))') 'veins     E = ', p%young, ' Pa; springs of veins, membrane, cross ', &
        p%k_vein, ' ', p%k_membrane, ' ', p%k_cross, ' N/m; cross-springs '//trim(merge('yes', 'no ', p%cross_springs))
      if (p%slack < 1) write (unit, '(a,es9.2,a,es9.2,a)') 'membrane  a tension field: springs keep ', p%slack, &
        ' of their stiffness where they are more than ', p%slack_width, ' m too short'
      do i = 1, size(p%joint)
        write (unit, '(a,a,es11.4,a)') 'joint     '//p%joint_names(i), ' ', p%joint(i), ' N m/rad'// &
          trim(merge(' (as the vein)', '              ', s%requested%joint(i) < 0))
      end do
      do i = p%count_basic() + 1, p%count()
        effect = p%describe(i)
        if (abs(p%get(i) - effect%null) > 0) &
          write (unit, '(a)') 'effect    '//effect%name//' '//number_text(p%get(i))//' '//effect%unit
      end do
    end associate
  end subroutine print_wing
end module common_wing_report
