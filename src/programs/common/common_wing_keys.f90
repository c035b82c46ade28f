! SPDX-License-Identifier: GPL-3.0-or-later
!> The ini keys that `flusi --static` and `flusi --solid` share: the wing, its stiffness, its mass. SI units.
module common_wing_keys
  use base_kinds, only: rp
  use common_wing_effects, only: register_effect_keys
  use io_registry, only: registry_t
  use solid_wing, only: z_side_choices
  implicit none
  private
  public :: register_wing_keys, register_damping_keys

  !> Help of every key that lists forces.
  character(*), parameter, public :: PLACE_HELP = 'PLACE: tip, vein:NAME:first, vein:NAME:last, vein:NAME:K '// &
                                     '(its K-th point), joint:NAME, point:K (from 1) or at:X:Y (on the membrane, m)'

contains

  !> Adds [Wing] and [Mass] to `registry`. Without `required` a run may do without a wing file.
  subroutine register_wing_keys(registry, required)
    type(registry_t), intent(inout) :: registry
    logical, intent(in) :: required
    call register_wing(registry, required)
    call register_mass(registry)
  end subroutine register_wing_keys

  subroutine register_wing(r, required)
    type(registry_t), intent(inout) :: r
    logical, intent(in) :: required
    call r%add_section('Wing', 'the wing and what it is made of')
   call r%add_text('Wing', 'file', '', 'wing file (docs/formats/wing-format.md); looked for here and then in the folder of '// &
                    'the input file', required=required)
call r%add_real('Wing', 'length', 0.0_rp, 'the wing is made so large, with all its lengths and diameters, that its '// &
                    'largest x is this; 0: as in its file', unit='m', min=0.0_rp)
  call r%add_real('Wing', 'mean_chord', 0.0_rp, 'then its y are stretched so that its area over its extent along x '// &
                    'is this; 0: not stretched', unit='m', min=0.0_rp)
    call r%add_word('Wing', 'preset', 'default', 'default|paper', 'paper: with cross-springs, as in Truong et al.')
    call r%add_real('Wing', 'E', 12.58e9_rp, 'Young''s modulus of all veins', unit='Pa', above=0.0_rp)
    call r%add_real('Wing', 'k_e', 1.0e5_rp, 'extension stiffness of every spring', unit='N/m', above=0.0_rp)
    call r%add_word('Wing', 'cross_springs', 'preset', 'preset|yes|no', &
                    'springs between the apexes of neighbouring triangles; their effect depends on the mesh')
    call r%add_real('Wing', 'D', 2.0e-7_rp, 'bending stiffness of the membrane: regularises, is not measured', &
                    unit='N m', above=0.0_rp)
call r%add_real('Wing', 'slack', 1.0_rp, 'another membrane, a tension field: the fraction of their stiffness that its '// &
                    'springs keep where they are shorter than at rest; 1: all of it', above=0.0_rp, max=1.0_rp)
    call r%add_real('Wing', 'slack_width', 1.0e-7_rp, 'how much shorter a spring is when it has lost the rest', &
                    unit='m', above=0.0_rp)
    call r%add_real('Wing', 'joint_stiffness', -1.0_rp, 'of every joint; -1: as the vein without the joint', &
                    unit='N m/rad', min=-1.0_rp)
    call r%add_text('Wing', 'parameters', '', 'single parameters as pairs of name and value, separated by commas: '// &
                    'joint:NAME [N m/rad], E:VEIN (factor on E), root (factor), diameter_exponent, k_vein, '// &
                    'k_membrane, k_cross [N/m], and the effects of docs/theory/effects.md')
    call r%add_word('Wing', 'z_side', 'file', 'file|'//z_side_choices('|'), &
                    'which side of which wing +z points to, for effects that tell up from down; file: as the '// &
                    'wing file says (docs/formats/wing-format.md), or else left ventral')
    call r%add_text('Wing', 'fingerprint', '', 'identifies the wing for which these values were found; msm_train and '// &
                    'msm_diagnose write it; another wing is an error')
    call r%add_reals('Wing', 'found_size', [0.0_rp, 0.0_rp], 'length and mean chord of the wing that was trained; '// &
                     'msm_train and msm_diagnose write them; a program warns if the wing has another size', unit='m', length=2)
    call r%add_switch('Wing', 'allow_other_wing', .false., 'accept values that were found for another wing')
    call register_effect_keys(r)
  end subroutine register_wing

  subroutine register_mass(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Mass', 'what the wing weighs')
    call r%add_real('Mass', 'vein_density', 1300.0_rp, 'of the veins'' cuticle', unit='kg/m^3', above=0.0_rp)
    call r%add_word('Mass', 'membrane_law', 'bilinear', 'bilinear|uniform', &
                    'areal density of the membrane: 1.75 - 147 x + 101 y scaled to membrane_mass, or areal_density; '// &
                    'the law of the wing file counts if neither this nor areal_density is given')
    call r%add_real('Mass', 'membrane_mass', 81.475e-9_rp, 'for bilinear', unit='kg', above=0.0_rp)
    call r%add_real('Mass', 'areal_density', 3.0e-3_rp, 'for uniform', unit='kg/m^2', above=0.0_rp)
    call r%add_real('Mass', 'vein_factor', 1.0_rp, 'factor on the mass of all veins', above=0.0_rp)
    call r%add_real('Mass', 'membrane_factor', 1.0_rp, 'factor on the mass of the membrane, whatever its law', above=0.0_rp)
    call r%add_real('Mass', 'membrane_gradient', 0.0_rp, 'g: the membrane weighs exp(g (x/R - 1/2)) times that, x from the '// &
                    'root, R the extent along x', min=-5.0_rp, max=5.0_rp)
    call r%add_reals('Mass', 'point_mass', [0.0_rp, 0.0_rp, 0.0_rp], 'x y mass of something that sits on the wing: dust, '// &
                     'glue, a marker', unit='m, m, kg')
  end subroutine register_mass

  !> Adds [Damping] to `registry`.
  subroutine register_damping_keys(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Damping', 'of the motion within the wing frame')
    call r%add_real('Damping', 'rayleigh_mass', 0.0_rp, 'damping force per mass and velocity', unit='1/s', min=0.0_rp)
    call r%add_real('Damping', 'rayleigh_stiffness', 0.0_rp, 'damping force per rate of the elastic force', unit='s', &
                    min=0.0_rp)
    call r%add_real('Damping', 'relaxation', 0.0_rp, 'g of a viscoelastic wing: a sudden force meets 1 + g times the stiffness', &
                    min=0.0_rp)
    call r%add_real('Damping', 'relaxation_time', 1.0e-3_rp, 'in which that relaxes', unit='s', above=0.0_rp)
    call r%add_real('Damping', 'nodal', 0.0_rp, 'damping force per velocity, the same at every point', unit='kg/s', &
                    min=0.0_rp)
  end subroutine register_damping_keys
end module common_wing_keys
