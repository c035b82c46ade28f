! SPDX-License-Identifier: GPL-3.0-or-later
!> The register of the ini keys of `flusi --static`. All units are SI.
module app_static_keys
  use base_kinds, only: rp
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_static_keys, write_static_reference

contains

  !> Fills `registry` with every key that `flusi --static` accepts.
  subroutine register_static_keys(registry)
    type(registry_t), intent(inout) :: registry
    call register_wing(registry)
    call register_mass(registry)
    call register_rest(registry)
  end subroutine register_static_keys

  !> Writes the reference of these keys, the second part of docs/parameters.md.
  subroutine write_static_reference(unit)
    integer, intent(in) :: unit
    type(registry_t) :: registry
    call register_static_keys(registry)
    write (unit, '(a)') '# Parameters of `flusi --static`', '', &
      'The shape of a wing under given loads. All numbers are in SI units.', ''
    call registry%write_markdown(unit)
  end subroutine write_static_reference

  subroutine register_wing(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Wing', 'the wing and what it is made of')
   call r%add_text('Wing', 'file', '', 'wing file (docs/wing-format.md); looked for here and then in the folder of '// &
                    'the input file', required=.true.)
    call r%add_word('Wing', 'preset', 'default', 'default|paper', 'paper: with cross-springs, as in Truong et al.')
    call r%add_real('Wing', 'E', 12.58e9_rp, 'Young''s modulus of all veins', unit='Pa', above=0.0_rp)
    call r%add_real('Wing', 'k_e', 1.0e5_rp, 'extension stiffness of every spring', unit='N/m', above=0.0_rp)
    call r%add_word('Wing', 'cross_springs', 'preset', 'preset|yes|no', &
                    'springs between the apexes of neighbouring triangles; their effect depends on the mesh')
    call r%add_real('Wing', 'D', 2.0e-7_rp, 'bending stiffness of the membrane: regularises, is not measured', &
                    unit='N m', above=0.0_rp)
    call r%add_real('Wing', 'joint_stiffness', -1.0_rp, 'of every joint; -1: as the vein without the joint', &
                    unit='N m/rad', min=-1.0_rp)
    call r%add_text('Wing', 'parameters', '', 'single parameters as pairs of name and value, separated by commas: '// &
                    'joint:NAME [N m/rad], E:VEIN (factor on E), root (factor), diameter_exponent, k_vein, '// &
                    'k_membrane, k_cross [N/m]')
  end subroutine register_wing

  subroutine register_mass(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Mass', 'what the wing weighs; reported only, it has no effect on the shape')
    call r%add_real('Mass', 'vein_density', 1300.0_rp, 'of the veins'' cuticle', unit='kg/m^3', above=0.0_rp)
    call r%add_word('Mass', 'membrane_law', 'bilinear', 'bilinear|uniform', &
                    'areal density of the membrane: 1.75 - 147 x + 101 y scaled to membrane_mass, or areal_density')
    call r%add_real('Mass', 'membrane_mass', 81.475e-9_rp, 'for bilinear', unit='kg', above=0.0_rp)
    call r%add_real('Mass', 'areal_density', 3.0e-3_rp, 'for uniform', unit='kg/m^2', above=0.0_rp)
  end subroutine register_mass

  subroutine register_rest(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Loads', 'every row is a load of its own; rows of forces come first')
    call r%add_matrix('Loads', 'forces', 3, 'rows of x y force: place on the unloaded membrane [m], force along z [N]')
    call r%add_matrix('Loads', 'point_forces', 4, 'rows of point fx fy fz: number of the point counted from 1, '// &
                      'force [N]')
    call r%add_section('Solver', 'path of the static solution')
    call r%add_real('Solver', 'tolerance', 1.0e-8_rp, 'of the residual, relative to the load', min=1.0e-12_rp, &
                    max=1.0e-3_rp)
    call r%add_real('Solver', 'step_limit', 0.025_rp, 'largest movement in one stage, relative to the wing''s size', &
                    above=0.0_rp, max=0.2_rp)
    call r%add_integer('Solver', 'factorisation_limit', 900, 'give up after so many for one load', min=1)
    call r%add_section('Saving', 'what is written')
    call r%add_text('Saving', 'name', 'static', 'first part of the names of all files, with a folder if wanted')
    call r%add_switch('Saving', 'shapes', .true., 'one HDF5 file and one XDMF index for every load')
  end subroutine register_rest
end module app_static_keys
